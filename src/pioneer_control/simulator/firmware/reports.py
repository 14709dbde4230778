"""The packets that the robot sends, made from the state of its hardware. Their units and lengths depend on the robot's
model and firmware family.
"""

import dataclasses
import itertools
import math
from typing import Any, Callable, Dict, List, Mapping, Tuple

from ... import p2os
from ...p2os import DigitalIn, FaultFlags, Flags, GripperSwitches, GripState
from ...wire_fields import made
from ..hardware import Hardware, RobotNumbers
from ..hardware.accessories import JoystickState
from ..world.poses import unit

GRIPPER_UNIT = 0.02
"""Duration (s) of one unit of the gripper's times in packets.

Source: protocol sheet 6.1.
"""
MOST_READINGS = 50
"""Largest number of sonar readings in one SIP. It keeps the byte count of the SIP below 200."""

SIP_ENDS = {
    "PSOS": "digital_out", "P2OS": "digital_out", "AmigOS": "digital_out", "AROS": "digital_out",
    "AmigoSH": "charge_state",
}
"""Last field of the SIP, by firmware family (protocol section 4). All other families send the full SIP of ARCOS."""
CONFIG_ENDS = {
    "PSOS": "translation_ki", "P2OS": "translation_ki", "AmigOS": "translation_ki", "AROS": "has_gyro",
    "AmigoSH": "firmware_version",
}
"""Last field of CONFIGpac, by firmware family (protocol 5.1). All other families send the full CONFIGpac of ARCOS."""

CONFIG_FIELDS = tuple(field.name for field in dataclasses.fields(p2os.Config))

# Bits for `_bits`, in the order of its truth values. Plain numbers are many times faster than members of an IntFlag.
GRIP_STATE = tuple(map(int, (
    GripState.OPEN, GripState.CLOSED, GripState.MOVING, GripState.ERROR,
    GripState.LIFT_UP, GripState.LIFT_DOWN, GripState.LIFT_MOVING, GripState.LIFT_ERROR,
)))
DIGITAL_IN = tuple(map(int, (
    DigitalIn.PADDLES_NOT_OPEN, DigitalIn.LIFT_BETWEEN, DigitalIn.OUTER_BEAM_BROKEN, DigitalIn.INNER_BEAM_BROKEN,
    DigitalIn.LEFT_CONTACT_FREE, DigitalIn.RIGHT_CONTACT_FREE,
)))
FLAGS = tuple(map(int, (
    Flags.MOTORS_ENABLED, Flags.SONAR_1, Flags.SONAR_2, Flags.SONAR_3, Flags.SONAR_4, Flags.STOP_BUTTON, Flags.E_STALL,
    Flags.CHARGER_POWER, Flags.JOYSTICK_BUTTON,
)))
JOINT_BITS = tuple(1 << joint for joint in range(6))
MOVING_SWITCHES = int(GripperSwitches.PADDLES_MOVING), int(GripperSwitches.LIFT_MOVING)
UNDERVOLTAGE = int(FaultFlags.UNDERVOLTAGE)
OLDER_ANALOG = frozenset(["PSOS", "P2OS", "AmigOS", "AROS"])
"""Families of firmware whose IOpac has analog ports 1 to 5, with 2047 for 5 V.

The IOpac of other families has ports 0 to 7 and the battery, with 1023 for 5 V (protocol 5.5).
"""
BATTERY_DIVIDER = 4.0
"""Ratio of the battery voltage (12 V class) to the voltage at the last analog input. Our choice: no manual gives it."""
PLAYLIST_ID = 0xD0
SOUNDS: List[Tuple[str, int, int]] = [("~greetings", 0, 0), ("hello", 0, 8000), ("goodbye", 8000, 6400)]
"""Stored sounds of an AmigoBot: name, first byte, and length in bytes. A ~ before the name marks a group."""
FLOATING = 0xFF
"""Value of the digital inputs when nothing is connected."""
UNCONNECTED = int(DigitalIn.INPUT_6 | DigitalIn.INPUT_7)
"""Bits of the digital inputs that a gripper does not use."""


def sip(hardware: Hardware) -> p2os.Sip:
    """Return the standard SIP. It contains the sonar readings since the last SIP, which are then dropped."""
    model = hardware.model
    x, y = counts(hardware)
    left, right = hardware.drives.wheel_speeds
    front_bumpers, rear_bumpers = hardware.bumpers.bits()
    stalled = hardware.motors.e_stalled
    per_metre = 1000.0 / model.range_mm_per_unit
    values = dict(
        type_id=p2os.MOVING if hardware.drives.moving else p2os.STOPPED,
        x_counts=x & 0x7FFF,
        y_counts=y & 0x7FFF,
        heading_units=heading_units(hardware, hardware.odometry.pose[2]),
        left_velocity_units=round(left * 1000.0 / model.vel_mm_s_per_unit),
        right_velocity_units=round(right * 1000.0 / model.vel_mm_s_per_unit),
        battery_dv=min(255, round(hardware.battery.voltage_12v * 10.0)),
        left_stall_bits=(hardware.stall.left or stalled) | rear_bumpers << 1,
        right_stall_bits=(hardware.stall.right or stalled) | front_bumpers << 1,
        control_units=heading_units(hardware, hardware.heading_goal),
        flags=_flags(hardware),
        compass=_compass(hardware),
        sonar=tuple(p2os.SonarReading(number, round(distance * per_metre))
                    for number, distance in hardware.sonar.take_readings(MOST_READINGS)),
        grip_state=grip_state(hardware),
        analog_port=hardware.ports.analog_port,
        analog=round(hardware.ports.volts(hardware.ports.analog_port) * 255.0 / 5.0),
        digital_in=digital_in(hardware),
        digital_out=hardware.ports.digital_out,
    )
    end = SIP_ENDS.get(model.firmware_family)
    if end != "digital_out":
        values.update(battery_x10_dv=min(0xFFFF, round(hardware.battery.voltage * 10.0)),
                      charge_state=hardware.battery.charge_state)
        if end != "charge_state":
            values.update(rotation_velocity_ddeg_s=round(math.degrees(hardware.drives.angular.speed) * 10.0),
                          fault_flags=UNDERVOLTAGE if hardware.battery.is_low else 0)
    packet: p2os.Sip = made(p2os.Sip, values)
    return packet


def counts(hardware: Hardware) -> Tuple[int, int]:
    """Return the odometry x and y in the units of the SIP, before they wrap to 15 bits."""
    x, y, _ = hardware.odometry.pose
    per_metre = 1000.0 / hardware.model.dist_mm_per_unit
    return round(x * per_metre), round(y * per_metre)


def heading_units(hardware: Hardware, heading: float) -> int:
    """Convert an angle (rad) to units of THPOS, wrapped to at most half a turn in both directions."""
    turn = hardware.model.angle_units_per_rev
    return (round(heading / hardware.model.angle_rad_per_unit) + turn // 2) % turn - turn // 2


def _flags(hardware: Hardware) -> int:
    arrays, motors = hardware.sonar.firing, hardware.motors
    return _bits(FLAGS, (
        motors.enabled, 0 in arrays, 1 in arrays, 2 in arrays, 3 in arrays, motors.stop_button, motors.e_stalled,
        hardware.battery.charging, hardware.joystick is not None and hardware.joystick.button_1))


def grip_state(hardware: Hardware) -> int:
    """Return GRIP_STATE of the SIP; 0 without a gripper.

    While paddles or lift move, both their moving bit and the bit of the end position to which they move are set.
    """
    gripper = hardware.gripper
    if gripper is None:
        return 0
    outward, inward = gripper.paddle_motion > 0, gripper.paddle_motion < 0
    lift = gripper.lift
    rising, sinking = lift.goal > lift.height, lift.goal < lift.height
    return _bits(GRIP_STATE, (
        outward or gripper.is_open and not inward,
        inward or gripper.is_closed and not outward,
        outward or inward,
        gripper.paddles_jammed,
        rising or lift.is_up and not sinking,
        sinking or lift.is_down and not rising,
        rising or sinking,
        lift.jammed,
    ))


def digital_in(hardware: Hardware) -> int:
    """Return DIGIN of the SIP. If a gripper is fitted, it shows the gripper's switches, beams and contacts."""
    gripper = hardware.gripper
    if gripper is None:
        return FLOATING
    inner, outer = gripper.beams_broken(hardware.body.pose)
    left, right = gripper.contacts
    between = not gripper.lift.is_up and not gripper.lift.is_down
    return UNCONNECTED | _bits(DIGITAL_IN, (not gripper.is_open, between, outer, inner, not left, not right))


def _bits(bits: Tuple[int, ...], states: Tuple[bool, ...]) -> int:
    """Return the sum of all numbers in `bits` whose entry in `states` is true."""
    return sum(itertools.compress(bits, states))


def gripper(hardware: Hardware) -> p2os.Gripper:
    """Return GRIPPERpac. A fitted gripper has type 1, on the user I/O port. The model decides the layout of its state.
    """
    fitted = hardware.gripper
    if fitted is None:
        return p2os.Gripper(has_gripper=0, state=0, grasp_time_units=0)
    moving = _bits(MOVING_SWITCHES, (fitted.paddle_motion != 0, fitted.lift.motion != 0))
    switches = digital_in(hardware) & ~UNCONNECTED | moving
    state = grip_state(hardware) if hardware.model.grip_state_first else switches
    return p2os.Gripper(has_gripper=1, state=state, grasp_time_units=min(255, round(fitted.grasp_time / GRIPPER_UNIT)))


def encoder(hardware: Hardware) -> p2os.Encoder:
    """Return ENCODERpac: encoder ticks of left and right wheels since power-on, wrapped to signed 32-bit numbers."""
    return p2os.Encoder(*((ticks + 2 ** 31) % 2 ** 32 - 2 ** 31 for ticks in hardware.wheels.ticks))


def io(hardware: Hardware) -> p2os.IO:
    """Return IOpac: user inputs, bumpers, infrared sensors, digital outputs and analog inputs.

    The digital inputs are electrical levels: 1 while a sensor is idle.
    """
    front, rear = hardware.bumpers.bits()
    inputs = (digital_in(hardware), ~front & 0xFF, ~rear & 0xFF, 0xFF)
    if hardware.model.firmware_family in OLDER_ANALOG:
        analog = [round(hardware.ports.volts(port) / 5.0 * 2047.0) for port in range(1, 6)]
    else:
        analog = [round(hardware.ports.volts(port) / 5.0 * 1023.0) for port in range(8)]
        analog.append(min(1023, round(hardware.battery.voltage_12v / BATTERY_DIVIDER / 5.0 * 1023.0)))
    return p2os.IO(digital_in=inputs, digital_out=(hardware.ports.digital_out,), analog=tuple(analog))


def _compass(hardware: Hardware) -> int:
    """Return COMPASS of the SIP: the heading from 1 to 180, in units of 2 degrees clockwise from north.

    It is 0 without a compass, or while the compass is switched off.
    """
    shown = hardware.compass.numbers.fitted and hardware.compass.on
    return (round(hardware.compass.degrees(hardware.body.pose[2]) / 2.0) or 180) if shown else 0


def gyro(hardware: Hardware) -> p2os.Gyro:
    """Return GYROpac. It contains the gyro readings since the last GYROpac, which are then dropped."""
    return p2os.Gyro(tuple(p2os.GyroReading(*reading) for reading in hardware.gyro.take_readings()))


def joystick(hardware: Hardware) -> p2os.Joystick:
    """Return JOYSTICKpac. If no joystick is plugged in, all axes are in the middle."""
    stick = hardware.joystick or JoystickState()
    return p2os.Joystick(int(stick.button_1), int(stick.button_2),
                         *(max(0, min(1023, axis)) for axis in (stick.x, stick.y, stick.throttle)))


def tcm2(hardware: Hardware) -> p2os.TCM2:
    """Return TCM2pac of the compass module, for a level robot in an undisturbed magnetic field."""
    degrees = hardware.compass.degrees(hardware.body.pose[2])
    north, east = unit(math.radians(degrees))
    field = hardware.compass.numbers
    return p2os.TCM2(
        heading_ddeg=round(degrees * 10.0) % 3600, pitch_ddeg=0, roll_ddeg=0,
        magnetic_x_hundredths=round(field.horizontal_field * north * 100.0),
        magnetic_y_hundredths=round(-field.horizontal_field * east * 100.0),
        magnetic_z_hundredths=round(field.vertical_field * 100.0),
        temperature_dc=round(field.temperature_c * 10.0), error_bits=0, calibration_h=9, calibration_v=9,
        calibration_m_hundredths=1200,
    )


def playlist(family: str, number: int, sounds_on: int) -> List[object]:
    """Return the packets that answer command PLAYLIST.

    Args:
        family: firmware family. Only AmigOS has stored sounds; other families answer with one packet of zeros.
        number: number of the requested sound (from 1), or 0 for all sounds. For 0, the first packet has the number of
            sounds in place of its own number.
        sounds_on: whether sounds are switched on, 0 or 1.
    """
    if family != "AmigOS":
        return [p2os.UnknownPacket(PLAYLIST_ID, bytes(25))]
    return [p2os.Playlist(len(SOUNDS) if number == 0 and sound == 1 else sound, sounds_on, *stored)
            for sound, stored in enumerate(SOUNDS, 1) if number in (0, sound)]


NO_ARM = p2os.Arm(status_bits=0, motion_bits=0, positions=(0,) * 6)
"""The arm packet of a robot without an arm."""
NO_ARM_INFO = p2os.ArmInfo("No arm", ())


def arm(hardware: Hardware) -> p2os.Arm:
    """Return ARMpac, in the layout of the arm's numbers (arm sheet 13). It is all zero without an arm."""
    fitted = hardware.arm
    if fitted is None:
        return NO_ARM
    motion = _bits(JOINT_BITS, tuple(fitted.moving))
    if fitted.numbers.layout == "M":
        first, second = _bits(JOINT_BITS, (fitted.powered, fitted.linked)), motion
    else:
        first, second = motion, _bits(JOINT_BITS, (fitted.linked, fitted.linked, fitted.powered, fitted.homing))
    return p2os.Arm(first, second, tuple(servo.position for servo in fitted.servos))


def arm_info(hardware: Hardware) -> p2os.ArmInfo:
    """Return ARMINFOpac."""
    fitted = hardware.arm
    if fitted is None:
        return NO_ARM_INFO
    return p2os.ArmInfo(fitted.numbers.version, tuple(
        p2os.ArmJoint(servo.speed_ms, servo.home, servo.minimum, servo.centre, servo.maximum, servo.ticks_per_90)
        for servo in fitted.servos))


def battery_info(hardware: Hardware) -> p2os.BatteryInfo:
    """Return the packet that answers command BATTERYINFO: one battery and its charge (percent)."""
    percent = round(hardware.battery.charge * 100.0)
    return p2os.BatteryInfo((p2os.Battery(0, 0, 0, percent, percent),))


def config(hardware: Hardware, name: str, numbers: RobotNumbers, settings: Dict[str, int]) -> p2os.Config:
    """Return CONFIGpac, with only the fields that the robot's firmware family sends.

    Args:
        hardware: devices of the robot.
        name: name of the robot.
        numbers: parameters of the simulated robot.
        settings: numbers that a client has set, by their names in CONFIGpac; see `CommandedRobot.settings`.
    """
    model, drive = hardware.model, numbers.drive
    linear, angular = hardware.drives.linear.limits, hardware.drives.angular.limits
    values: Dict[str, Any] = dict(
        type="Pioneer", subtype=model.subtype, serial=numbers.session.serial, four_motors=0,
        rotation_velocity_top_deg_s=_degrees(angular.top), translation_velocity_top_mm_s=_millimetres(linear.top),
        rotation_acceleration_top_deg_s2=_degrees(angular.rate_top),
        translation_acceleration_top_mm_s2=_millimetres(linear.rate_top),
        pwm_max=500, name=name, sip_cycle_ms=numbers.session.sip_cycle_ms,
        host_baud=p2os.BAUD_RATES.index(numbers.session.host_baud),
        has_gripper=int(hardware.gripper is not None),
        front_sonar=int(model.with_arrays(front=False, rear=True) != model),
        rear_sonar=int(model.with_arrays(front=True, rear=False) != model),
        low_battery_dv=round(numbers.battery.alarm * 10.0), watchdog_ms=numbers.session.watchdog_ms,
        alternative_sips=0, stall_value=200, stall_count=round(drive.stall_recovery * 1000.0),
        joystick_velocity_mm_s=numbers.joystick.linear_mm_s, joystick_rotation_deg_s=numbers.joystick.angular_deg_s,
        rotation_velocity_max_deg_s=_degrees(angular.limit), translation_velocity_max_mm_s=_millimetres(linear.limit),
        rotation_acceleration_deg_s2=_degrees(angular.rise), rotation_deceleration_deg_s2=_degrees(angular.fall),
        translation_acceleration_mm_s2=_millimetres(linear.rise),
        translation_deceleration_mm_s2=_millimetres(linear.fall),
        front_bumpers=model.front_bumpers, rear_bumpers=model.rear_bumpers, charger=charger(hardware),
        sonar_cycle_ms=hardware.sonar.cycle_us // 1000, autobaud=numbers.session.autobaud, has_gyro=hardware.gyro.kind,
        shutdown_dv=round(numbers.battery.shutdown * 10.0), firmware_version=numbers.session.firmware_version,
        kinematics_delay_ms=0, lateral_velocity_top_mm_s=0, lateral_acceleration_top_mm_s2=0,
        lateral_velocity_max_mm_s=0, lateral_acceleration_mm_s2=0, lateral_deceleration_mm_s2=0, charge_threshold=0,
        rev_count=hardware.wheels.rev_count, ticks_per_mm=hardware.wheels.ticks_per_mm, **settings,
    )
    end = CONFIG_ENDS.get(model.firmware_family, "charge_threshold")
    return p2os.Config(**{field: values[field] for field in CONFIG_FIELDS[:CONFIG_FIELDS.index(end) + 1]})


PACKETS: Mapping[str, Callable[[Hardware], object]] = {
    "gyro": gyro, "joystick": joystick, "sip": sip, "encoder": encoder, "gripper": gripper, "io": io,
    "battery": battery_info, "compass": tcm2, "arm": arm,
    "arm_info": arm_info,
}
"""Functions that make the SIP and the packets that a client can request, in the order in which they are sent."""


def charger(hardware: Hardware) -> int:
    """Return field Charger of CONFIGpac: 0 if the world has no docks, 2 for a PowerBot, 1 for all other models."""
    fitting = 2 if hardware.model.subtype.lower().startswith("powerbot") else 1
    return fitting if hardware.charger.docks else 0


def _millimetres(metres: float) -> int:
    return round(metres * 1000.0)


def _degrees(radians: float) -> int:
    return round(math.degrees(radians))
