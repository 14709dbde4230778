"""The effect of each client command on the robot, in two tables by the command's name in the protocol.

`HANDLERS` has the commands that do something. `IGNORED` has all other commands. A handler gets the robot and the value
of the command. It converts the value from the units of the protocol (mm, mm/s, deg, deg/s) to SI units.
``docs/simulator-commands.md`` shows the same rows.
"""

import math
from typing import Any, Callable, Dict, NamedTuple, Optional

from ...p2os import BAUD_RATES, GripperCommand, two_bytes
from ..hardware import Hardware
from ..hardware.accessories import GYRO_OF_CLIENT
from ..hardware.arm import PioneerArm
from ..hardware.gripper import ParallelGripper
from . import reports
from .commanded_robot import CommandedRobot
from .reports import GRIPPER_UNIT

LETTERS = {family: frozenset(letters) for family, letters in dict(
    PSOS="S", P2OS="P", AmigOS="G", AROS="A", ARCOS="C", AmigoSH="C", uARCS="CU", MARCOS="CM",
).items()}
"""The letters of each firmware family. Strings of these letters name sets of families in `HANDLERS`.

S is PSOS, P is P2OS, G is AmigOS, A is AROS, U is uARCS, M is MARCOS. C is ARCOS, AmigoSH, uARCS or MARCOS.

Source: protocol sheet 3.
"""
ALL, NOT_PSOS, LATER, ARCOS = "SPGAC", "PGAC", "AC", "C"
MOST_NOTES = 20     # of one SAY
ALL_NUMBERS, AT_LEAST_0, AT_LEAST_1 = range(-0xFFFF, 0x10000), range(0x10000), range(1, 0x10000)


def is_one_of(family: str, letters: str) -> bool:
    """Return whether a firmware family, such as "ARCOS", has one of the `letters` of `LETTERS`."""
    return not LETTERS[family].isdisjoint(letters)


class Handler(NamedTuple):
    """A row of `HANDLERS`: what the simulated robot does when it receives a command."""

    value: Optional[type]
    """Required type of the command's value. None if the command ignores its value."""
    act: Callable[[CommandedRobot, Any], None]
    """Function that executes the command. It gets the robot and the value."""
    families: str = ALL
    """Letters of the firmware families that know the command; see `LETTERS`."""
    does: str = ""
    """Description of the command's effect, for the documentation."""
    legal: range = ALL_NUMBERS
    """Numbers that have an effect. The robot accepts a command with any other number, but does nothing."""

    def known_to(self, family: str) -> bool:
        """Return whether firmware of this family knows the command. To other families its number is unknown."""
        return is_one_of(family, self.families)


# -- motion

def enable(robot: CommandedRobot, on: int) -> None:
    """Execute command ENABLE: switch the motors on if `on` is not 0, else off."""
    if on:
        robot.hardware.motors.enable()
    else:
        robot.hardware.motors.disable()


def motion(act: Callable[[Hardware, float], None]) -> Callable[[CommandedRobot, float], None]:
    """Return the handler function of a motion command.

    The returned function does nothing while the motors are off. If the motors are on, it ends the effect of an earlier
    VEL2 command and then calls `act`.

    Args:
        act: function that sets the drives. It gets the hardware and the value of the command.
    """
    def obey(robot: CommandedRobot, value: float) -> None:
        if robot.hardware.motors.enabled:
            robot.hardware.drives.cancel_wheels()
            act(robot.hardware, value)
    return obey


def head(hardware: Hardware, deg: float) -> None:
    """Execute command HEAD: start to turn to the heading `deg` (degrees, odometry frame), the shortest way."""
    hardware.drives.angular.set_distance(
        math.remainder(math.radians(deg) - hardware.odometry.pose[2], 2.0 * math.pi))


def turn_goal(hardware: Hardware, deg: float) -> None:
    """Execute command DCHEAD: start to turn by `deg` degrees from the heading to which the robot turns now."""
    hardware.drives.angular.set_distance((hardware.drives.angular.remaining or 0.0) + math.radians(deg))


def wheels(robot: CommandedRobot, value: int) -> None:
    """Execute command VEL2: set the speeds of the left wheels (high byte of `value`) and the right wheels (low byte).

    It does nothing while the motors are off. Unlike other motion commands, it does not end an earlier VEL2 first.
    """
    if robot.hardware.motors.enabled:
        left, right = (units * robot.model.vel2_mm_s_per_unit / 1000.0 for units in two_bytes(value))
        robot.hardware.drives.turn_wheels(left, right)


def stop(robot: CommandedRobot, _: Any) -> None:
    """Execute command STOP: slow down to speed zero with the normal decelerations."""
    robot.hardware.drives.cancel_wheels()
    robot.hardware.drives.set_speeds(0.0, 0.0)


def emergency_stop(robot: CommandedRobot, _: Any) -> None:
    """Execute commands E_STOP and QSTOP: stop with the highest deceleration."""
    robot.hardware.drives.cancel_wheels()
    robot.hardware.drives.emergency_stop()


# -- sonar, inputs, outputs

def sonar(robot: CommandedRobot, value: int) -> None:
    """Execute command SONAR: switch sonar arrays on or off.

    Bit 0 of `value` is 1 for on. Bits 1 to 4 select arrays 1 to 4 on firmware of AROS and later. If none of these bits
    is set, the command acts on all arrays.
    """
    arrays = [array for array in range(4) if value >> array + 1 & 1]
    single = is_one_of(robot.model.firmware_family, LATER) and value > 0
    robot.hardware.sonar.switch(bool(value & 1), robot.clock.now_us, arrays if single and arrays else None)


def sonar_cycle(robot: CommandedRobot, milliseconds: int) -> None:
    """Execute command SONARCYCLE: set the time between two firings of each sonar array (milliseconds)."""
    robot.hardware.sonar.cycle_us = milliseconds * 1000


def digital_out(robot: CommandedRobot, value: int) -> None:
    """Execute command DIGOUT: set the digital outputs that the high byte selects to the states in the low byte."""
    mask, states = (byte & 0xFF for byte in two_bytes(value))
    ports = robot.hardware.ports
    ports.digital_out = (ports.digital_out & ~mask | states & mask) & 0xFF


def analog_select(robot: CommandedRobot, port: int) -> None:
    """Execute command ADSEL: select the analog input that the SIP contains. Ignore ports that do not exist."""
    if port in (range(8) if is_one_of(robot.model.firmware_family, ARCOS) else range(1, 6)):
        robot.hardware.ports.analog_port = port


# -- requests

def request(kind: str, what: str, families: str) -> Handler:
    """Return the row of a command that requests packets.

    Args:
        kind: kind of packet, a key of `reports.PACKETS`.
        what: name of the packet in the documentation.
        families: letters of the firmware families that know the command.
    """
    return Handler(int, lambda robot, how: robot.request(kind, how), families,
                   "0: send no %s. 1: one with the next SIP. More: one with every SIP." % what)


def gyro(robot: CommandedRobot, how: int) -> None:
    """Execute command GYRO.

    For a gyro that the client reads, `how` above 0 sends GYROpac with every SIP, and 0 ends this. For a gyro that the
    robot reads, `how` (0 to 2) is the new mode of the gyro.
    """
    if robot.hardware.gyro.kind == GYRO_OF_CLIENT:
        robot.request("gyro", 2 if how > 0 else 0)
        robot.hardware.gyro.take_readings()
    elif 0 <= how <= 2:
        robot.hardware.gyro.mode = how


def compass(robot: CommandedRobot, how: int) -> None:
    """Execute command TCM2: switch the compass off if `how` is 0, else on, and set whether TCM2pac is sent.

    If `how` is 2 or 6, one TCM2pac is sent. If it is 3, TCM2pac is sent with every SIP. Without a compass, do nothing.
    """
    if robot.hardware.compass.numbers.fitted and 0 <= how <= 7:
        robot.hardware.compass.on = how != 0
        robot.request("compass", {2: 1, 3: 2, 6: 1}.get(how, 0))


# -- the line, and auxiliary serial ports

def host_baud(robot: CommandedRobot, code: int) -> None:
    """Execute command HOSTBAUD: set the baud rate of the robot's serial line. `code` is an index of `BAUD_RATES`."""
    robot.baud = BAUD_RATES[code]


def aux_write(port: int) -> Handler:
    """Return the row of the command that sends bytes to the device at auxiliary serial port 1, 2 or 3."""
    return Handler(
        bytes, lambda robot, data: robot.hardware.aux[port - 1].write(data), ARCOS if port == 3 else NOT_PSOS,
        "Send bytes to the device at AUX%d. There is none, unless a program connects one:"
        " `robot.hardware.aux[%d].device`."
        % (port, port - 1))


def aux_read(port: int) -> Handler:
    """Return the row of the command that requests bytes from the device at auxiliary serial port 1, 2 or 3."""
    return Handler(
        int, lambda robot, count: robot.hardware.aux[port - 1].want(count), ARCOS if port == 3 else NOT_PSOS,
        "Request so many bytes (197 at most) from the device at AUX%d. They come in one packet behind the SIP, as soon"
        " as all have arrived. 0: empty the buffer." % port)


# -- docking, sounds, gripper

def dock(robot: CommandedRobot, how: int) -> None:
    """Execute command DOCK: take power in docks if `how` is 1 or 2, and stop when a dock starts charging if it is 2."""
    robot.hardware.charger.asks_dock = how in (1, 2)
    robot.hardware.charger.stops_in_dock = how == 2


def gripper(robot: CommandedRobot, number: int) -> None:
    """Execute command GRIPPER: call the action of `GRIPPER_ACTIONS` with this number. Ignore it without a gripper."""
    fitted = robot.hardware.gripper
    if fitted is not None and number in GRIPPER_ACTIONS:
        GRIPPER_ACTIONS[number](fitted)


def gripper_value(robot: CommandedRobot, units: int) -> None:
    """Execute command GRIPPERVAL: set the value for the GRIPPER command before it.

    After GRIPPER PRESSURE, `units` is the grasp time. After GRIPPER CARRY, it is the time for which the lift moves,
    negative for down. One unit is `GRIPPER_UNIT` seconds. After any other command, GRIPPERVAL is ignored.
    """
    fitted = robot.hardware.gripper
    before = robot.open_session.previous if robot.open_session else None
    if fitted is None or before is None or before.name != "GRIPPER":
        return
    if before.value == GripperCommand.PRESSURE and 1 <= units <= 100:
        fitted.grasp_time = units * GRIPPER_UNIT
    elif before.value == GripperCommand.CARRY and 1 <= abs(units) <= 255:
        fitted.lift.move_for(units * GRIPPER_UNIT)


GRIPPER_ACTIONS: Dict[int, Callable[[ParallelGripper], None]] = {
    GripperCommand.OPEN: ParallelGripper.open,
    GripperCommand.CLOSE: ParallelGripper.close,
    GripperCommand.STOP: ParallelGripper.stop,
    GripperCommand.LIFT_UP: lambda fitted: fitted.lift.move_to(fitted.shape.lift_height),
    GripperCommand.LIFT_DOWN: lambda fitted: fitted.lift.move_to(0.0),
    GripperCommand.LIFT_STOP: lambda fitted: fitted.lift.stop(),
    GripperCommand.STORE: ParallelGripper.store,
    GripperCommand.DEPLOY: ParallelGripper.deploy,
    GripperCommand.HALT: ParallelGripper.halt,
}

# -- the arm

ALL_JOINTS = range(6)


def arm(act: Callable[[PioneerArm, int], None], does: str, legal: range = AT_LEAST_0) -> Handler:
    """Return the row of a command to the arm.

    Args:
        act: function that obeys the command. It gets the arm and the value.
        does: description of the command's effect on a robot with an arm, for the documentation.
        legal: legal numbers. Other numbers are ignored.
    """
    def obey(robot: CommandedRobot, value: int) -> None:
        fitted = robot.hardware.arm
        if fitted is not None:
            act(fitted, value)
    return Handler(int, obey, NOT_PSOS, does, legal)


def arm_alone(act: Callable[[PioneerArm], None], does: str) -> Handler:
    """Return the row of a command to the arm that has no value; see `arm`."""
    return arm(lambda fitted, _: act(fitted), does)._replace(value=None)


def joints_of(number: int) -> range:
    """Return the indices of the joints that a number of ARM_HOME and ARM_STOP means: all if it is above 6.

    Source: arm sheet 14.
    """
    return range(number - 1, number) if number <= len(ALL_JOINTS) else ALL_JOINTS


def arm_pair(act: Callable[[PioneerArm, int, int], None], does: str) -> Handler:
    """Return the row of a command whose high byte is a joint, and whose low byte is for `act`; see `arm`."""
    def obey(fitted: PioneerArm, value: int) -> None:
        joint, number = (byte & 0xFF for byte in two_bytes(value))
        if joint - 1 in ALL_JOINTS:
            act(fitted, joint - 1, number)
    return arm(obey, does)


def arm_info(robot: CommandedRobot, _: Any) -> None:
    """Execute command ARM_INFO: send ARMINFOpac, at once if there is no arm, else with the next SIP."""
    if robot.hardware.arm is None:
        robot.send(reports.NO_ARM_INFO)
    else:
        robot.request("arm_info", 1)


# -- safety and tuning


def bump_stall(robot: CommandedRobot, which: int) -> None:
    """Execute command BUMPSTALL: bit 0 of `which` lets the front bumper stall the wheels, bit 1 the rear bumper."""
    robot.hardware.bumpers.front_stalls = bool(which & 1)
    robot.hardware.bumpers.rear_stalls = bool(which & 2)


def rev_count(robot: CommandedRobot, count: int) -> None:
    """Execute command REVCOUNT: set the firmware's calibration of a full turn (encoder ticks)."""
    robot.hardware.wheels.rev_count = count


def ticks_per_mm(robot: CommandedRobot, ticks: int) -> None:
    """Execute command TICKSMM: set the firmware's calibration of distances (encoder ticks per mm)."""
    robot.hardware.wheels.ticks_per_mm = ticks


def setting(
    name: str, families: str, legal: range = range(0x8000),
    does: str = "Shown in CONFIGpac until the session ends. It does not change how the robot drives.",
) -> Handler:
    """Return the row of a command that only stores a number, which CONFIGpac shows. It does not change the motion.

    Args:
        name: name of the number in `CommandedRobot.settings` and in CONFIGpac.
        families: letters of the firmware families that know the command.
        legal: legal numbers. Other numbers are ignored.
        does: description of the command's effect, for the documentation.
    """
    return Handler(int, lambda robot, number: robot.settings.update({name: number}), families, does, legal)


def aux_baud(port: int) -> Handler:
    """Return the row of the command that stores the baud rate of auxiliary serial port 1, 2 or 3 for CONFIGpac only."""
    return setting("aux%d_baud" % port, ARCOS if port == 3 else NOT_PSOS, range(len(BAUD_RATES)),
                   "Shown in CONFIGpac until the session ends. The devices receive at any baud rate.")


_ROTATE = motion(lambda hardware, deg_s: hardware.drives.angular.set_speed(math.radians(deg_s)))
_ROTATES = "Rotate at this speed (deg/s), within SETRV, with the ramps of SETRA."
_EMERGENCY_STOP = "Stop as fast as the drives can, until the next motion command."
_TURNING_LIMIT = Handler(
    int, lambda robot, deg_s: robot.hardware.drives.angular.limits.set_limit_towards(math.radians(deg_s)), ARCOS,
    "Speed limit (deg/s) of later turns: a positive value counter-clockwise, a negative value clockwise. The sources"
    " give this command two different numbers; the robot obeys both.")

HANDLERS: Dict[str, Handler] = {
    "PULSE": Handler(None, lambda robot, _: None, ALL,
                     "Restarts the time of the watchdog, as every packet does. If the watchdog had stopped the robot,"
                     " it drives on with its old set points."),
    "OPEN": Handler(None, lambda robot, _: None, ALL,
                    "After SYNC0, SYNC1, SYNC2: begin a session, with motors off, sonar on, pose 0, and a SIP every"
                    " 100 ms. Inside a session: nothing."),
    "CLOSE": Handler(None, lambda robot, _: robot.close_session(), ALL,
                     "End the session: motors and sonar off, no more packets, parameters as at power-on. The next"
                     " client can connect at once."),
    "RESET": Handler(None, lambda robot, _: robot.restart(), ARCOS,
                     "End the session, restart the controller, and send packet 0xFF."),
    "HOSTBAUD": Handler(int, host_baud, NOT_PSOS,
                        "Set the baud rate of the line until the session ends. A pseudo-terminal then garbles bytes"
                        " that have the old baud rate.", range(len(BAUD_RATES))),
    "ENABLE": Handler(int, enable, ALL,
                      "1: switch the motors on, unless the STOP button or an empty battery prevents it. 0: switch them"
                      " off."),
    "VEL": Handler(int, motion(lambda hardware, mm_s: hardware.drives.linear.set_speed(mm_s / 1000.0)), ALL,
                   "Translate at this speed (mm/s), within SETV, with the ramps of SETA. Ignored while the motors are"
                   " off, as all motion commands are."),
    "RVEL": Handler(int, _ROTATE, ALL, _ROTATES),
    "ROTATE": Handler(int, _ROTATE, NOT_PSOS, _ROTATES),
    "VEL2": Handler(int, wheels, ALL,
                    "Speeds of the left wheels (high byte) and the right wheels (low byte), in the VEL2 unit of the"
                    " model. ARCOS converts them to translation and rotation, with their limits. Older firmware"
                    " controls each wheel, with the ramps of SETA and no other limit than the highest speed."),
    "MOVE": Handler(int, motion(lambda hardware, mm: hardware.drives.linear.set_distance(mm / 1000.0)), NOT_PSOS,
                    "Translate this far (mm; negative: backward) at SETV, with the ramps of SETA, and stop there."),
    "HEAD": Handler(int, motion(head), ALL, "Turn to this heading (deg) in the odometry frame, the shortest way."),
    "DHEAD": Handler(int, motion(lambda hardware, deg: hardware.drives.angular.set_distance(math.radians(deg))), ALL,
                     "Turn by this angle (deg) from the present heading."),
    "DCHEAD": Handler(int, motion(turn_goal), NOT_PSOS,
                      "Turn by this angle (deg) from the heading to which the robot turns now."),
    "STOP": Handler(None, stop, NOT_PSOS, "Slow down to a stop. The motors stay on."),
    "E_STOP": Handler(None, emergency_stop, NOT_PSOS, _EMERGENCY_STOP),
    "QSTOP": Handler(None, emergency_stop, "M", _EMERGENCY_STOP),
    "SETO": Handler(None, lambda robot, _: robot.hardware.reset_odometry(), ALL,
                    "Set the pose of the odometry to 0, 0, 0."),
    "SETV": Handler(int, lambda robot, mm_s: robot.hardware.drives.linear.limits.set_limit(mm_s / 1000.0), ALL,
                    "Speed limit (mm/s) of later commands."),
    "SETRV": Handler(int, lambda robot, deg_s: robot.hardware.drives.angular.limits.set_limit(math.radians(deg_s)), ALL,
                     "Speed limit (deg/s) of later commands."),
    "SETRVDIR_ARCOS": _TURNING_LIMIT,
    "SETRVDIR": _TURNING_LIMIT,
    "SETA": Handler(int, lambda robot, mm_s2: robot.hardware.drives.linear.limits.set_rate(mm_s2 / 1000.0), NOT_PSOS,
                    "A positive value sets the acceleration, a negative value the deceleration (mm/s^2)."),
    "SETRA": Handler(int, lambda robot, deg_s2: robot.hardware.drives.angular.limits.set_rate(math.radians(deg_s2)),
                     NOT_PSOS,
                     "A positive value sets the acceleration, a negative value the deceleration (deg/s^2)."),
    "SONAR": Handler(int, sonar, ALL,
                     "Bit 0: on or off. Bits 1 to 4 select arrays 1 to 4, with the numbers of FLAGS (AROS and later,"
                     " as we read the manuals). If none is set: all arrays."),
    "POLLING": Handler(bytes, lambda robot, numbers: robot.hardware.sonar.set_sequence(
                           [number - 1 for number in numbers if 1 <= number <= 32], robot.clock.now_us), ALL,
                       "Set the firing sequence of the arrays whose transducers it names. Transducers are numbered"
                       " from 1 and may be repeated, at most 16 for each array. Empty: switch the sonar off, and keep"
                       " the sequences."),
    "SONARCYCLE": Handler(int, sonar_cycle, LATER, "Set the time between two firings of each array, 2 to 120 ms.",
                          range(2, 121)),
    "DIGOUT": Handler(int, digital_out, ALL,
                      "High byte: mask of the outputs to change. Low byte: their new states."),
    "ADSEL": Handler(int, analog_select, NOT_PSOS, "Select the analog port in the SIP: 1 to 5, on ARCOS 0 to 7."),
    "CONFIG": Handler(None, lambda robot, _: robot.send(
        reports.config(robot.hardware, robot.name, robot.numbers, robot.settings)), NOT_PSOS,
                      "Send CONFIGpac, at once."),
    "ENCODER": request("encoder", "ENCODERpac", NOT_PSOS),
    "GRIPREQUEST": request("gripper", "GRIPPERpac", NOT_PSOS),
    "IOREQUEST": request("io", "IOpac", NOT_PSOS),
    "BATTERYINFO": request("battery", "battery information", ARCOS),
    "JOYREQUEST": request("joystick", "JOYSTICKpac (before the SIP)", LATER),
    "JOYDRIVE": Handler(int, lambda robot, on: robot.hardware.allow_joystick(bool(on)), NOT_PSOS,
                        "1: a plugged-in joystick (`robot.hardware.joystick`) drives the robot while its first button"
                        " is pressed. 0: it does not."),
    "GYRO": Handler(int, gyro, LATER,
                    "Gyro read by the client (HasGyro 1): 1 sends GYROpac before every SIP, 0 ends this. Gyro read by"
                    " the robot (HasGyro 2): source of the heading, 0 encoders, 1 both, 2 only the gyro. Without a"
                    " gyro: nothing."),
    "GYROCALCW": setting("gyro_cw", ARCOS),
    "GYROCALCCW": setting("gyro_ccw", ARCOS),
    "TCM2": Handler(int, compass, NOT_PSOS,
                    "With a compass: 0 off, 1 heading in the SIP, 2 also one TCM2pac, 3 one with every SIP, 6 as 2, 7"
                    " as after power-on. 4 and 5 calibrate the compass, which has no effect here. Without a compass:"
                    " nothing."),
    "PLAYLIST": Handler(int, lambda robot, number: robot.send(*reports.playlist(
                            robot.model.firmware_family, number, robot.settings["sounds_on"])), "GPA",
                        "Send PLAYLIST: on AmigOS the sound with this number (0: all sounds), on other firmware 25"
                        " zero bytes."),
    "SAY": Handler(bytes, lambda robot, notes: robot.hardware.ports.speaker.play(notes[:MOST_NOTES * 2]), "SPAC",
                   "Play up to 20 notes, pairs of length (20 ms) and tone. They are not heard, but kept:"
                   " `robot.hardware.ports.speaker.played`."),
    "SOUNDTOG": Handler(int, lambda robot, on: robot.settings.update(sounds_on=int(on != 0)), "GAC",
                        "Shown in PLAYLIST. The simulated robot makes no sounds."),
    "GRIPPER": Handler(int, gripper, NOT_PSOS,
                       "Sub-commands 1 to 8 and 15 act at once; 16 and 17 act with the GRIPPERVAL that follows."
                       " Without a gripper: nothing."),
    "GRIPPERVAL": Handler(int, gripper_value, NOT_PSOS,
                          "Directly after GRIPPER 16: the grasp time, 1 to 100. Directly after GRIPPER 17: the time"
                          " for which the lift moves, -255 to 255, negative for down. Elsewhere: nothing. The unit is"
                          " 20 ms."),
    "TTY2": aux_write(1),
    "TTY3": aux_write(2),
    "TTY4": aux_write(3),
    "GETAUX": aux_read(1),
    "GETAUX2": aux_read(2),
    "GETAUX3": aux_read(3),
    "AUX1BAUD": aux_baud(1),
    "AUX2BAUD": aux_baud(2),
    "AUX3BAUD": aux_baud(3),
    "DOCK": Handler(int, dock, "PG",
                    "1 or 2: charge when the robot stands in a dock of the world. 2: also stop when a dock starts to"
                    " charge. 0: do not charge in docks."),
    "CHARGE": Handler(int, lambda robot, on: dock(robot, int(on != 0)), LATER,
                      "1: charge when the robot stands in a dock of the world. 0: do not charge in docks."),
    "BUMPSTALL": Handler(int, bump_stall, NOT_PSOS,
                         "Bumpers that stall the wheels at once: bit 0 the front bumper, bit 1 the rear bumper. At"
                         " power-on both."),
    "E_STALL": Handler(int, lambda robot, on: robot.hardware.motors.set_stop_button_stalls(bool(on)), NOT_PSOS,
                       "1: the STOP button switches the motors off. 0: it does not. At power-on 1, on firmware before"
                       " AROS 0."),
    "BATTEST": Handler(int, lambda robot, decivolts: robot.hardware.battery.pretend(decivolts / 10.0), ARCOS,
                       "Report this battery voltage (0.1 V) instead of the real one. 0: report the real voltage.",
                       AT_LEAST_0),
    "ROTKP": setting("rotation_kp", NOT_PSOS),
    "ROTKV": setting("rotation_kv", NOT_PSOS),
    "ROTKI": setting("rotation_ki", NOT_PSOS),
    "TRANSKP": setting("translation_kp", NOT_PSOS),
    "TRANSKV": setting("translation_kv", NOT_PSOS),
    "TRANSKI": setting("translation_ki", NOT_PSOS),
    "REVCOUNT": Handler(int, rev_count, NOT_PSOS,
                        "Encoder ticks of a full turn. With a greater number, the robot turns farther for the same"
                        " angle.", AT_LEAST_1),
    "TICKSMM": Handler(int, ticks_per_mm, ARCOS,
                       "Encoder ticks per mm. With a greater number, the robot drives farther for the same distance.",
                       AT_LEAST_1),
    "DRIFTFACTOR": setting("drift_factor", ARCOS, range(-0x7FFF, 0x8000)),
    "ARM_INFO": Handler(None, arm_info, NOT_PSOS,
                        "Send ARMINFOpac: `No arm` at once, or that of the arm behind the next SIP."),
    "ARM_STATUS": request("arm", "ARMpac (all zero without an arm)", NOT_PSOS),
    "ARM_INIT": arm_alone(PioneerArm.init,
                          "Where an arm is fitted: servo power off, speeds as at power-on, and the arm's controller is"
                          " found again. It takes 0.7 s, in which the arm obeys no command. Without an arm: nothing, as"
                          " all commands to it."),
    "ARM_CHECK": arm_alone(PioneerArm.check, "For 0.2 s the arm obeys nothing but ARM_STOP."),
    "ARM_POWER": arm(lambda fitted, on: fitted.power(on != 0),
                     "1: servo power on, unless the arm's controller does not answer. 0: off; an arm that is not at"
                     " home falls down."),
    "ARM_HOME": arm(lambda fitted, number: fitted.go_home(joints_of(number)),
                    "Move a joint (1 to 6) home, or all joints (any larger number), these at a safe speed. Needs servo"
                    " power.", AT_LEAST_1),
    "ARM_PARK": arm_alone(PioneerArm.go_park, "Move all joints home, then switch the servo power off."),
    "ARM_POS": arm_pair(PioneerArm.move,
                        "Move a joint (high byte) to this tick (low byte), clipped to its range. Needs servo power."),
    "ARM_SPEED": arm_pair(PioneerArm.set_speed,
                          "Time of one tick (ms, low byte, clipped to 1 to 127) of a joint (high byte). It is no less"
                          " than 2 ms times the number of joints that move."),
    "ARM_STOP": arm(lambda fitted, number: fitted.stop(joints_of(number)),
                    "Stop a joint (1 to 6), or all joints (any larger number), with servo power on.", AT_LEAST_1),
    "ARM_AUTOPARK": arm(PioneerArm.set_autopark,
                        "Park after so many seconds without a command to the arm other than 70 and 71. 0: never. At"
                        " power-on `arm.autopark_s`."),
    "ARM_GRIPPARK": arm(PioneerArm.set_grippark,
                        "Open an arm's gripper that was closed for so many seconds. 0: never. At power-on"
                        " `arm.grippark_s`."),
}

_NO_SUPPLY = "there are no supplies to switch"
_OTHER_ROBOT = "only robots that are not Pioneers know it, and what they have beyond a Pioneer is not simulated"

IGNORED: Dict[str, str] = {
    "IMUREQUEST": "no inertial unit is fitted, and no source describes its packet",
    "SOUND": "the simulated robot makes no sounds",
    "TIMER": _NO_SUPPLY,
    "PTUPOS": "no servo is fitted",
    "MOVINGBLINK": "there are no lights",
    "LCDWRITE": "there is no display, and the meaning of the control bytes is not known for sure",
    "CALCOMP": "the compass needs no calibration",
    "POWER_PC": _NO_SUPPLY, "POWER_LRF": _NO_SUPPLY, "POWER_5V": _NO_SUPPLY, "POWER_12V": _NO_SUPPLY,
    "MAINTENANCE": "it would make the robot ignore all commands until somebody opens it, which is of no use for a"
                   " simulated robot",
    "LATVEL": _OTHER_ROBOT, "LATACCEL": _OTHER_ROBOT, "RECENTERWHEELS": _OTHER_ROBOT,
    "ROTVEL_CLOSEDLOOP_ENABLE": _OTHER_ROBOT,
    "ACCELINFO": _OTHER_ROBOT, "TORQUEINFO": _OTHER_ROBOT, "HEADINGINFO": _OTHER_ROBOT,
    "SAFETY_STATE_INFO": _OTHER_ROBOT,
    "WHEELINFO_REQUEST": _OTHER_ROBOT, "POWER_DEVICE": _OTHER_ROBOT, "POWER_AUX_PC": _OTHER_ROBOT,
    "POWER_TOUCHSCREEN": _OTHER_ROBOT,
    "POWER_PTZ": _OTHER_ROBOT, "POWER_AUDIO": _OTHER_ROBOT, "POWER_LRF2": _OTHER_ROBOT,
}
"""Commands that have no effect on a simulated robot with any firmware, with the reason. They only feed the watchdog."""
