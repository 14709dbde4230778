"""What each client command does to the robot: one row each, by its name in the protocol's table.

`HANDLERS` are the commands that do something, `IGNORED` the others. A handler gets the robot and the command's value.
Numbers arrive in the units of the wire (mm, mm/s, deg, deg/s) and leave in SI. ``docs/simulator-commands.md`` shows
the same rows to people.
"""

import math
from typing import Any, Callable, Dict, NamedTuple, Optional

from ...p2os import BAUD_RATES, GripperCommand, two_bytes
from ..hardware import Hardware
from ..hardware.accessories import GYRO_OF_CLIENT
from ..hardware.gripper import ParallelGripper
from . import reports
from .commanded_robot import CommandedRobot
from .reports import GRIPPER_UNIT

LETTERS = {family: frozenset(letters) for family, letters in dict(
    PSOS="S", P2OS="P", AmigOS="G", AROS="A", ARCOS="C", AmigoSH="C", uARCS="CU", MARCOS="CM",
).items()}
"""Firmware families, and the letters that stand for them.

S is PSOS, P P2OS, G AmigOS, A AROS, C ARCOS and its kin, U uARCS, M MARCOS.

Source: protocol sheet 3.
"""
ALL, NOT_PSOS, LATER, ARCOS = "SPGAC", "PGAC", "AC", "C"
ALL_NUMBERS, AT_LEAST_0, AT_LEAST_1 = range(-0xFFFF, 0x10000), range(0x10000), range(1, 0x10000)


def is_one_of(family: str, letters: str) -> bool:
    """Whether a firmware family is among those that the letters stand for."""
    return not LETTERS[family].isdisjoint(letters)


class Handler(NamedTuple):
    """A row of the table."""

    value: Optional[type]
    """The type that the value must have; None: the value is ignored."""
    act: Callable[[CommandedRobot, Any], None]
    """What the command does, given the robot and the value."""
    families: str = ALL
    """Letters of the firmware families that know the command."""
    does: str = ""
    """What it does, for people."""
    legal: range = ALL_NUMBERS
    """The numbers that change something; the robot obeys any other number by doing nothing."""

    def known_to(self, family: str) -> bool:
        """Whether firmware of this family obeys it; to the others it is an unknown number."""
        return is_one_of(family, self.families)


# -- motion

def enable(robot: CommandedRobot, on: int) -> None:
    """Obey ENABLE."""
    if on:
        robot.hardware.motors.enable()
    else:
        robot.hardware.motors.disable()


def motion(act: Callable[[Hardware, float], None]) -> Callable[[CommandedRobot, float], None]:
    """The action of a motion command, made of what it does to the drives.

    While the motors are off the robot forgets the command. With the motors on, what VEL2 told the wheels ends.
    """
    def obey(robot: CommandedRobot, value: float) -> None:
        if robot.hardware.motors.enabled:
            robot.hardware.drives.cancel_wheels()
            act(robot.hardware, value)
    return obey


def turn_by(hardware: Hardware, angle: float) -> None:
    """Turn by an angle (rad) from the present heading."""
    hardware.drives.angular.set_distance(angle)


def head(hardware: Hardware, deg: float) -> None:
    """Obey HEAD."""
    turn_by(hardware, math.remainder(math.radians(deg) - hardware.odometry.pose[2], 2.0 * math.pi))


def turn_goal(robot: CommandedRobot, deg: int) -> None:
    """Obey DCHEAD. The goal counts that the robot had before this command."""
    hardware = robot.hardware
    motion(turn_by)(robot, hardware.heading_goal - hardware.odometry.pose[2] + math.radians(deg))


def wheels(robot: CommandedRobot, value: int) -> None:
    """Obey VEL2. Like a motion command, but it does not end what an earlier VEL2 told the wheels."""
    if robot.hardware.motors.enabled:
        left, right = (units * robot.model.vel2_mm_s_per_unit / 1000.0 for units in two_bytes(value))
        robot.hardware.drives.turn_wheels(left, right)


def stop(robot: CommandedRobot, _: Any) -> None:
    """Obey STOP."""
    robot.hardware.drives.cancel_wheels()
    robot.hardware.drives.set_speeds(0.0, 0.0)


def emergency_stop(robot: CommandedRobot, _: Any) -> None:
    """Obey E_STOP and QSTOP."""
    robot.hardware.drives.cancel_wheels()
    robot.hardware.drives.emergency_stop()


# -- sonar, inputs, outputs

def sonar(robot: CommandedRobot, value: int) -> None:
    """Obey SONAR."""
    arrays = [array for array in range(4) if value >> array + 1 & 1]
    single = is_one_of(robot.model.firmware_family, LATER) and value > 0
    robot.hardware.sonar.switch(bool(value & 1), robot.clock.now_us, arrays if single and arrays else None)


def sonar_cycle(robot: CommandedRobot, milliseconds: int) -> None:
    """Obey SONARCYCLE."""
    robot.hardware.sonar.cycle_us = milliseconds * 1000


def digital_out(robot: CommandedRobot, value: int) -> None:
    """Obey DIGOUT."""
    mask, states = (byte & 0xFF for byte in two_bytes(value))
    ports = robot.hardware.ports
    ports.digital_out = (ports.digital_out & ~mask | states & mask) & 0xFF


def analog_select(robot: CommandedRobot, port: int) -> None:
    """Obey ADSEL."""
    if port in (range(8) if is_one_of(robot.model.firmware_family, ARCOS) else range(1, 6)):
        robot.hardware.ports.analog_port = port


# -- requests

def request(kind: str, what: str, families: str) -> Handler:
    """The row of a command that asks for packets of a kind."""
    return Handler(int, lambda robot, how: robot.request(kind, how), families,
                   "0 no %s, 1 one with the next SIP, more: one with every SIP." % what)


def gyro(robot: CommandedRobot, how: int) -> None:
    """Obey GYRO."""
    if robot.hardware.gyro.kind == GYRO_OF_CLIENT:
        robot.request("gyro", 2 if how > 0 else 0)
        robot.hardware.gyro.take_readings()
    elif 0 <= how <= 2:
        robot.hardware.gyro.mode = how


def compass(robot: CommandedRobot, how: int) -> None:
    """Obey TCM2."""
    if robot.hardware.compass.numbers.fitted and 0 <= how <= 7:
        robot.hardware.compass.on = how != 0
        robot.request("compass", {2: 1, 3: 2, 6: 1}.get(how, 0))


# -- the line, and auxiliary serial ports

def host_baud(robot: CommandedRobot, code: int) -> None:
    """Obey HOSTBAUD."""
    robot.baud = BAUD_RATES[code]


def aux_write(port: int) -> Handler:
    """The row of a command that passes bytes on to what is connected to an auxiliary port."""
    return Handler(
        bytes, lambda robot, data: robot.hardware.aux[port - 1].write(data), ARCOS if port == 3 else NOT_PSOS,
        "Bytes to the device at AUX%d (none, unless a program connects one: `robot.hardware.aux[%d].device`)."
        % (port, port - 1))


def aux_read(port: int) -> Handler:
    """The row of a command that asks for bytes of what is connected to an auxiliary port."""
    return Handler(
        int, lambda robot, count: robot.hardware.aux[port - 1].want(count), ARCOS if port == 3 else NOT_PSOS,
        "So many bytes (197 at most) of the device at AUX%d in one packet behind the SIP, once they are there; 0"
        " flushes." % port)


# -- docking, sounds, gripper

def dock(robot: CommandedRobot, how: int) -> None:
    """Obey DOCK."""
    robot.hardware.charger.asks_dock = how in (1, 2)
    robot.hardware.charger.stops_in_dock = how == 2


def gripper(robot: CommandedRobot, number: int) -> None:
    """Obey GRIPPER."""
    fitted = robot.hardware.gripper
    if fitted is not None and number in GRIPPER_ACTIONS:
        GRIPPER_ACTIONS[number](fitted)


def gripper_value(robot: CommandedRobot, units: int) -> None:
    """Obey GRIPPERVAL."""
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

# -- safety and tuning


def bump_stall(robot: CommandedRobot, which: int) -> None:
    """Obey BUMPSTALL."""
    robot.hardware.bumpers.front_stalls = bool(which & 1)
    robot.hardware.bumpers.rear_stalls = bool(which & 2)


def rev_count(robot: CommandedRobot, count: int) -> None:
    """Obey REVCOUNT."""
    robot.hardware.wheels.rev_count = count


def ticks_per_mm(robot: CommandedRobot, ticks: int) -> None:
    """Obey TICKSMM."""
    robot.hardware.wheels.ticks_per_mm = ticks


def setting(
    name: str, families: str, legal: range = range(0x8000),
    does: str = "Shown in CONFIGpac, until the session ends; it drives no differently.",
) -> Handler:
    """The row of a command that keeps a number under its name in CONFIGpac."""
    return Handler(int, lambda robot, number: robot.settings.update({name: number}), families, does, legal)


def aux_baud(port: int) -> Handler:
    """The row of a command that keeps the speed of an auxiliary port."""
    return setting("aux%d_baud" % port, ARCOS if port == 3 else NOT_PSOS, range(len(BAUD_RATES)),
                   "Shown in CONFIGpac, until the session ends; the devices hear at any speed.")


_ROTATE = motion(lambda hardware, deg_s: hardware.drives.angular.set_speed(math.radians(deg_s)))
_ROTATES = "Rotate at this speed (deg/s), within SETRV, with the ramps of SETRA."
_EMERGENCY_STOP = "Stop as fast as the drives can, until the next motion command."
_TURNING_LIMIT = Handler(
    int, lambda robot, deg_s: robot.hardware.drives.angular.limits.set_limit_towards(math.radians(deg_s)), ARCOS,
    "Speed limit (deg/s) of later turns counter-clockwise, or when negative clockwise. Sources give it two numbers,"
    " both are obeyed.")

HANDLERS: Dict[str, Handler] = {
    "PULSE": Handler(None, lambda robot, _: None, ALL,
                     "Feeds the watchdog, as every packet does; a robot that it stopped takes up its old set points."),
    "OPEN": Handler(None, lambda robot, _: None, ALL,
                    "Begins a session after SYNC0, SYNC1, SYNC2: motors off, sonar on, pose 0, a SIP every 100 ms."
                    " Inside a session: nothing."),
    "CLOSE": Handler(None, lambda robot, _: robot.close_session(), ALL,
                     "Ends the session: motors and sonar off, no more packets, parameters as at power-on; the next"
                     " client is welcome at once."),
    "RESET": Handler(None, lambda robot, _: robot.restart(), ARCOS,
                     "Ends the session as a fresh start of the controller, and says so with 0xFF."),
    "HOSTBAUD": Handler(int, host_baud, NOT_PSOS,
                        "Another speed of the line (a pseudo-terminal garbles what comes at the old one), until the"
                        " session ends.", range(len(BAUD_RATES))),
    "ENABLE": Handler(int, enable, ALL,
                      "Motor power on, unless the STOP button or an empty battery forbids it, or off."),
    "VEL": Handler(int, motion(lambda hardware, mm_s: hardware.drives.linear.set_speed(mm_s / 1000.0)), ALL,
                   "Translate at this speed (mm/s), within SETV, with the ramps of SETA; forgotten while the motors are"
                   " off, as all motion commands."),
    "RVEL": Handler(int, _ROTATE, ALL, _ROTATES),
    "ROTATE": Handler(int, _ROTATE, NOT_PSOS, _ROTATES),
    "VEL2": Handler(int, wheels, ALL,
                    "Left wheel in the high byte, right in the low one, in the model's VEL2 unit. ARCOS makes"
                    " translation and rotation of it, with their limits; before, each wheel has its own speed, and only"
                    " SETA counts."),
    "MOVE": Handler(int, motion(lambda hardware, mm: hardware.drives.linear.set_distance(mm / 1000.0)), NOT_PSOS,
                    "Translate this far (mm; negative: backward) at SETV, with the ramps of SETA, and stop there."),
    "HEAD": Handler(int, motion(head), ALL, "Turn to this heading (deg) of the robot's own frame, the shortest way."),
    "DHEAD": Handler(int, motion(lambda hardware, deg: turn_by(hardware, math.radians(deg))), ALL,
                     "Turn by this angle (deg) from the present heading."),
    "DCHEAD": Handler(int, turn_goal, NOT_PSOS, "Turn by this angle (deg) from the heading it is turning to."),
    "STOP": Handler(None, stop, NOT_PSOS, "Ramp down; the motors stay on."),
    "E_STOP": Handler(None, emergency_stop, NOT_PSOS, _EMERGENCY_STOP),
    "QSTOP": Handler(None, emergency_stop, "M", _EMERGENCY_STOP),
    "SETO": Handler(None, lambda robot, _: robot.hardware.reset_odometry(), ALL,
                    "The robot's own pose becomes 0, 0, 0."),
    "SETV": Handler(int, lambda robot, mm_s: robot.hardware.drives.linear.limits.set_limit(mm_s / 1000.0), ALL,
                    "Speed limit (mm/s) of later commands."),
    "SETRV": Handler(int, lambda robot, deg_s: robot.hardware.drives.angular.limits.set_limit(math.radians(deg_s)), ALL,
                     "Speed limit (deg/s) of later commands."),
    "SETRVDIR_ARCOS": _TURNING_LIMIT,
    "SETRVDIR": _TURNING_LIMIT,
    "SETA": Handler(int, lambda robot, mm_s2: robot.hardware.drives.linear.limits.set_rate(mm_s2 / 1000.0), NOT_PSOS,
                    "Acceleration, or when negative deceleration (mm/s^2)."),
    "SETRA": Handler(int, lambda robot, deg_s2: robot.hardware.drives.angular.limits.set_rate(math.radians(deg_s2)),
                     NOT_PSOS,
                     "Acceleration, or when negative deceleration (deg/s^2)."),
    "SONAR": Handler(int, sonar, ALL,
                     "Bit 0: on or off; bits 1 to 4: which of arrays 1 to 4, as FLAGS numbers them (AROS and later; our"
                     " reading), none set: all."),
    "POLLING": Handler(bytes, lambda robot, numbers: robot.hardware.sonar.set_sequence(
                           [number - 1 for number in numbers if 1 <= number <= 32], robot.clock.now_us), ALL,
                       "A new firing sequence of the arrays that it names (numbers count from 1, repeats allowed, 16"
                       " for an array); empty: sonar off, sequences kept."),
    "SONARCYCLE": Handler(int, sonar_cycle, LATER, "Time of a firing, 2 to 120 ms, in every array.",
                          range(2, 121)),
    "DIGOUT": Handler(int, digital_out, ALL,
                      "Mask of the outputs to change in the high byte, their new states in the low one."),
    "ADSEL": Handler(int, analog_select, NOT_PSOS, "The analog port that the SIP shows: 1 to 5, on ARCOS 0 to 7."),
    "CONFIG": Handler(None, lambda robot, _: robot.send(
        reports.config(robot.hardware, robot.name, robot.numbers, robot.settings)), NOT_PSOS,
                      "Send CONFIGpac, at once."),
    "ENCODER": request("encoder", "ENCODERpac", NOT_PSOS),
    "GRIPREQUEST": request("gripper", "GRIPPERpac", NOT_PSOS),
    "IOREQUEST": request("io", "IOpac", NOT_PSOS),
    "BATTERYINFO": request("battery", "battery information", ARCOS),
    "JOYREQUEST": request("joystick", "JOYSTICKpac (before the SIP)", LATER),
    "JOYDRIVE": Handler(int, lambda robot, on: robot.hardware.allow_joystick(bool(on)), NOT_PSOS,
                        "Whether a joystick that is plugged in (`robot.hardware.joystick`) drives while its first"
                        " button is pressed."),
    "GYRO": Handler(int, gyro, LATER,
                    "Gyro read by the client (HasGyro 1): 1 sends GYROpac before every SIP, 0 ends that. Gyro in the"
                    " robot (2): the heading is made of 0 the encoders, 1 both, 2 the gyro alone. Without a gyro:"
                    " nothing."),
    "GYROCALCW": setting("gyro_cw", ARCOS),
    "GYROCALCCW": setting("gyro_ccw", ARCOS),
    "TCM2": Handler(int, compass, NOT_PSOS,
                    "Where a compass is fitted: 0 off, 1 shown in the SIP, 2 one TCM2pac, 3 one with every SIP, 6 one"
                    " and then as 1, 7 as after power-on. 4 and 5 calibrate, which changes nothing here."),
    "PLAYLIST": Handler(int, lambda robot, number: robot.send(*reports.playlist(
                            robot.model.firmware_family, number, robot.settings["sounds_on"])), "GPA",
                        "Send PLAYLIST: AmigOS its sounds, all for 0; the others 25 zero bytes."),
    "SOUNDTOG": Handler(int, lambda robot, on: robot.settings.update(sounds_on=int(on != 0)), "GAC",
                        "Shown in PLAYLIST; nobody hears anything."),
    "GRIPPER": Handler(int, gripper, NOT_PSOS,
                       "One of the sub-commands 1 to 8 and 15 at once; 16 and 17 wait for their GRIPPERVAL. Without a"
                       " gripper: nothing."),
    "GRIPPERVAL": Handler(int, gripper_value, NOT_PSOS,
                          "Right behind GRIPPER 16: the grasp time, 1 to 100; behind 17: how far the lift goes, -255 to"
                          " 255; anywhere else nothing."),
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
                    "0 off; 1, 2: takes power where it stands in a dock of the world; 2 also stops then."),
    "CHARGE": Handler(int, lambda robot, on: robot.hardware.charger.ask_dock(bool(on)), LATER,
                      "1: takes power where it stands in a dock of the world, 0: no longer."),
    "BUMPSTALL": Handler(int, bump_stall, NOT_PSOS,
                         "Which bumpers stop the wheels at once: bit 0 the front ones, bit 1 the rear ones; at first"
                         " both."),
    "E_STALL": Handler(int, lambda robot, on: robot.hardware.motors.set_stop_button_stalls(bool(on)), NOT_PSOS,
                       "Whether the STOP button takes the power from the motors: at first it does, before AROS it does"
                       " not."),
    "BATTEST": Handler(int, lambda robot, decivolts: robot.hardware.battery.pretend(decivolts / 10.0), ARCOS,
                       "Pretend a battery voltage (0.1 V), 0 for the real one.", AT_LEAST_0),
    "ROTKP": setting("rotation_kp", NOT_PSOS),
    "ROTKV": setting("rotation_kv", NOT_PSOS),
    "ROTKI": setting("rotation_ki", NOT_PSOS),
    "TRANSKP": setting("translation_kp", NOT_PSOS),
    "TRANSKV": setting("translation_kv", NOT_PSOS),
    "TRANSKI": setting("translation_ki", NOT_PSOS),
    "REVCOUNT": Handler(int, rev_count, NOT_PSOS,
                        "Encoder count of a turn: a greater one makes wider turns of the same angle told.", AT_LEAST_1),
    "TICKSMM": Handler(int, ticks_per_mm, ARCOS,
                       "Encoder ticks of a mm: more make longer metres of the same distance told.", AT_LEAST_1),
    "DRIFTFACTOR": setting("drift_factor", ARCOS, range(-0x7FFF, 0x8000)),
    "ARM_INFO": Handler(None, lambda robot, _: robot.send(reports.NO_ARM_INFO), NOT_PSOS, "Send ARMINFOpac: no arm."),
    "ARM_STATUS": request("arm", "ARMpac (no arm)", NOT_PSOS),
}

_NO_ARM = "no arm is fitted"
_NO_SUPPLY = "no supplies that could be switched"
_OTHER_ROBOT = "the robots that know it are simulated only as far as they are Pioneers"

IGNORED: Dict[str, str] = {
    "IMUREQUEST": "no inertial unit is fitted, and no source describes its packet",
    "SAY": "nobody hears anything",
    "SOUND": "nobody hears anything",
    "TIMER": _NO_SUPPLY,
    "PTUPOS": "no servo is fitted",
    "MOVINGBLINK": "no lights",
    "LCDWRITE": "no display; the meaning of its control bytes is not known for sure",
    "CALCOMP": "the compass needs no calibration",
    "POWER_PC": _NO_SUPPLY, "POWER_LRF": _NO_SUPPLY, "POWER_5V": _NO_SUPPLY, "POWER_12V": _NO_SUPPLY,
    "MAINTENANCE": "a robot in maintenance hears nothing until somebody opens it: nobody can want that of a simulated"
                   " one",
    "ARM_INIT": _NO_ARM, "ARM_CHECK": _NO_ARM, "ARM_POWER": _NO_ARM, "ARM_HOME": _NO_ARM, "ARM_PARK": _NO_ARM,
    "ARM_POS": _NO_ARM,
    "ARM_SPEED": _NO_ARM, "ARM_STOP": _NO_ARM, "ARM_AUTOPARK": _NO_ARM, "ARM_GRIPPARK": _NO_ARM,
    "LATVEL": _OTHER_ROBOT, "LATACCEL": _OTHER_ROBOT, "RECENTERWHEELS": _OTHER_ROBOT,
    "ROTVEL_CLOSEDLOOP_ENABLE": _OTHER_ROBOT,
    "ACCELINFO": _OTHER_ROBOT, "TORQUEINFO": _OTHER_ROBOT, "HEADINGINFO": _OTHER_ROBOT,
    "SAFETY_STATE_INFO": _OTHER_ROBOT,
    "WHEELINFO_REQUEST": _OTHER_ROBOT, "POWER_DEVICE": _OTHER_ROBOT, "POWER_AUX_PC": _OTHER_ROBOT,
    "POWER_TOUCHSCREEN": _OTHER_ROBOT,
    "POWER_PTZ": _OTHER_ROBOT, "POWER_AUDIO": _OTHER_ROBOT, "POWER_LRF2": _OTHER_ROBOT,
}
"""Commands of the protocol that change nothing here whatever the firmware, and why: they only keep the session alive.
"""
