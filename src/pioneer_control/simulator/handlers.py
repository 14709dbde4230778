"""What each client command does to the robot: one row each, by its name in the protocol's table.

A handler gets the firmware and the command's value. Numbers arrive in the units of the wire (mm, mm/s, deg, deg/s) and
leave in SI.
"""

import math
from typing import Callable, Dict, NamedTuple, Optional

from ..p2os import BAUD_RATES, GripperCommand, two_bytes

GRIPPER_UNIT = 0.02
"""Seconds in one unit of the gripper's times on the wire (protocol 6.1)."""


class Handler(NamedTuple):
    """A row: the type that the value must have (None: whatever comes is ignored), and what to do with it."""

    value: Optional[type]
    act: Callable


# -- session

def pulse(robot, _):
    """Nothing but being heard."""


def open_again(robot, _):
    """An OPEN inside a session changes nothing."""


def close(robot, _):
    """Motors and sonar off, parameters revert, back to waiting."""
    robot.close_session()


def reset(robot, _):
    """Like CLOSE, as a fresh start of the controller."""
    robot.restart()


def host_baud(robot, code):
    """Another speed of the line, until the session ends."""
    if 0 <= code < len(BAUD_RATES):
        robot.change_baud(BAUD_RATES[code])


# -- motion; with the motors off nothing of it is remembered either

def enable(robot, on):
    """Motor power on, if the STOP button allows, or off."""
    if on:
        robot.hardware.enable_motors()
    else:
        robot.hardware.disable_motors()


def velocity(robot, mm_s):
    """Translate at this speed (mm/s)."""
    if robot.can_drive():
        robot.leave_wheel_mode()
        robot.hardware.linear.set_speed(mm_s / 1000.0)


def rotation(robot, deg_s):
    """Rotate at this speed (deg/s)."""
    if robot.can_drive():
        robot.leave_wheel_mode()
        robot.hardware.angular.set_speed(math.radians(deg_s))


def wheels(robot, value):
    """Left wheel in the high byte, right in the low one, in the model's VEL2 unit; both translation and rotation."""
    if robot.can_drive():
        hardware = robot.hardware
        left, right = (units * hardware.model.vel2_mm_s_per_unit for units in two_bytes(value))
        hardware.linear.set_speed((left + right) / 2000.0)
        hardware.angular.set_speed((right - left) / 2.0 * hardware.model.diff_rad_per_mm)
        robot.wheel_mode = True


def move(robot, mm):
    """Translate this far (mm)."""
    if robot.can_drive():
        robot.leave_wheel_mode()
        robot.hardware.linear.set_distance(mm / 1000.0)


def head(robot, deg):
    """Turn to this heading (deg) of the robot's own frame, the shortest way."""
    _turn_by(robot, math.radians(deg) - robot.hardware.odometry[2], shortest=True)


def turn(robot, deg):
    """Turn by this angle (deg) from the present heading."""
    _turn_by(robot, math.radians(deg), shortest=False)


def turn_goal(robot, deg):
    """Turn by this angle (deg) from the heading it is turning to."""
    hardware = robot.hardware
    _turn_by(robot, hardware.heading_goal - hardware.odometry[2] + math.radians(deg), shortest=False)


def _turn_by(robot, angle, shortest):
    if robot.can_drive():
        robot.leave_wheel_mode()
        robot.hardware.angular.set_distance(math.remainder(angle, 2.0 * math.pi) if shortest else angle)


def stop(robot, _):
    """Ramp down; the motors stay on."""
    robot.wheel_mode = False
    robot.hardware.linear.set_speed(0.0)
    robot.hardware.angular.set_speed(0.0)


def emergency_stop(robot, _):
    """Stop as fast as the drives can, until the next motion command."""
    robot.wheel_mode = False
    robot.hardware.linear.emergency_stop()
    robot.hardware.angular.emergency_stop()


def set_origin(robot, _):
    """The robot's own pose becomes 0, 0, 0."""
    robot.hardware.reset_odometry()


def set_linear_limit(robot, mm_s):
    """Speed limit (mm/s) of later commands."""
    robot.hardware.linear.limits.set_limit(mm_s / 1000.0)


def set_angular_limit(robot, deg_s):
    """Speed limit (deg/s) of later commands."""
    robot.hardware.angular.limits.set_limit(math.radians(deg_s))


def set_linear_rate(robot, mm_s2):
    """Acceleration, or when negative deceleration (mm/s^2)."""
    robot.hardware.linear.limits.set_rate(mm_s2 / 1000.0)


def set_angular_rate(robot, deg_s2):
    """Acceleration, or when negative deceleration (deg/s^2)."""
    robot.hardware.angular.limits.set_rate(math.radians(deg_s2))


# -- sonar, inputs, outputs

def sonar(robot, on):
    """All arrays on or off."""
    robot.hardware.sonar.switch(bool(on & 1), robot.time_us)


def polling(robot, numbers):
    """A new firing sequence; numbers on the wire count from 1."""
    robot.hardware.sonar.set_sequence([number - 1 for number in numbers if 1 <= number <= 32], robot.time_us)


def sonar_cycle(robot, milliseconds):
    """Time of a firing (ms)."""
    if 2 <= milliseconds <= 120:
        robot.hardware.sonar.cycle_us = milliseconds * 1000


def digital_out(robot, value):
    """Mask of the outputs to change in the high byte, their new states in the low one."""
    mask, states = (byte & 0xFF for byte in two_bytes(value))
    robot.hardware.digital_out = (robot.hardware.digital_out & ~mask | states & mask) & 0xFF


def analog_select(robot, port):
    """The analog port that the SIP shows."""
    if 0 <= port <= 7:
        robot.hardware.analog_port = port


# -- requests

def config(robot, _):
    """Send CONFIGpac."""
    robot.send_config()


def request(kind):
    """A handler that asks for packets of a kind: 0 stops them, 1 sends one, more sends them with every SIP."""
    return Handler(int, lambda robot, how: robot.request(kind, how))


# -- gripper

def gripper(robot, number):
    """One of the gripper's sub-commands; a robot without gripper ignores it."""
    fitted = robot.hardware.gripper
    if fitted is not None and number in GRIPPER_ACTIONS:
        GRIPPER_ACTIONS[number](fitted)


def gripper_value(robot, units):
    """Only right behind the sub-command that it belongs to."""
    fitted = robot.hardware.gripper
    before = robot.previous
    if fitted is None or before is None or before.name != "GRIPPER":
        return
    if before.value == GripperCommand.PRESSURE and 1 <= units <= 100:
        fitted.grasp_time = units * GRIPPER_UNIT
    elif before.value == GripperCommand.CARRY and 1 <= abs(units) <= 255:
        fitted.lift_by(units * GRIPPER_UNIT)


def _up(fitted):
    fitted.lift_to(fitted.shape.lift_height)


def _down(fitted):
    fitted.lift_to(0.0)


def _together(*actions):
    def act(fitted):
        for action in actions:
            action(fitted)
    return act


# -- safety and tuning

def bump_stall(robot, which):
    """Which bumpers stall the wheels: bit 0 the front one, bit 1 the rear one."""
    robot.hardware.bump_stall_front = bool(which & 1)
    robot.hardware.bump_stall_rear = bool(which & 2)


def setting(name, lowest=0):
    """A handler that keeps a number under its name in CONFIGpac, unless it is too low to mean anything."""
    def keep(robot, number):
        if number >= lowest:
            robot.hardware.settings[name] = number
    return Handler(int, keep)


def e_stall(robot, on):
    """Whether the STOP button takes the power from the motors."""
    robot.hardware.set_stop_button_stalls(bool(on))


def battery_test(robot, decivolts):
    """Pretend a battery voltage (0.1 V), 0 for the real one."""
    if decivolts >= 0:
        robot.hardware.battery.pretend(decivolts / 10.0)


GRIPPER_ACTIONS = {
    GripperCommand.OPEN: lambda fitted: fitted.open(),
    GripperCommand.CLOSE: lambda fitted: fitted.close(),
    GripperCommand.STOP: lambda fitted: fitted.stop(),
    GripperCommand.LIFT_UP: _up,
    GripperCommand.LIFT_DOWN: _down,
    GripperCommand.LIFT_STOP: lambda fitted: fitted.lift_stop(),
    GripperCommand.STORE: _together(lambda fitted: fitted.close(), _up),
    GripperCommand.DEPLOY: _together(lambda fitted: fitted.open(), _down),
    GripperCommand.HALT: _together(lambda fitted: fitted.stop(), lambda fitted: fitted.lift_stop()),
}

HANDLERS: Dict[str, Handler] = {
    "PULSE": Handler(None, pulse),
    "OPEN": Handler(None, open_again),
    "CLOSE": Handler(None, close),
    "RESET": Handler(None, reset),
    "HOSTBAUD": Handler(int, host_baud),
    "ENABLE": Handler(int, enable),
    "VEL": Handler(int, velocity),
    "RVEL": Handler(int, rotation),
    "ROTATE": Handler(int, rotation),
    "VEL2": Handler(int, wheels),
    "MOVE": Handler(int, move),
    "HEAD": Handler(int, head),
    "DHEAD": Handler(int, turn),
    "DCHEAD": Handler(int, turn_goal),
    "STOP": Handler(None, stop),
    "E_STOP": Handler(None, emergency_stop),
    "QSTOP": Handler(None, emergency_stop),
    "SETO": Handler(None, set_origin),
    "SETV": Handler(int, set_linear_limit),
    "SETRV": Handler(int, set_angular_limit),
    "SETA": Handler(int, set_linear_rate),
    "SETRA": Handler(int, set_angular_rate),
    "SONAR": Handler(int, sonar),
    "POLLING": Handler(bytes, polling),
    "SONARCYCLE": Handler(int, sonar_cycle),
    "DIGOUT": Handler(int, digital_out),
    "ADSEL": Handler(int, analog_select),
    "CONFIG": Handler(None, config),
    "ENCODER": request("encoder"),
    "GRIPREQUEST": request("gripper"),
    "IOREQUEST": request("io"),
    "BATTERYINFO": request("battery"),
    "GRIPPER": Handler(int, gripper),
    "GRIPPERVAL": Handler(int, gripper_value),
    "BUMPSTALL": Handler(int, bump_stall),
    "E_STALL": Handler(int, e_stall),
    "BATTEST": Handler(int, battery_test),
    "ROTKP": setting("rotation_kp"),
    "ROTKV": setting("rotation_kv"),
    "ROTKI": setting("rotation_ki"),
    "TRANSKP": setting("translation_kp"),
    "TRANSKV": setting("translation_kv"),
    "TRANSKI": setting("translation_ki"),
    "REVCOUNT": setting("rev_count", lowest=1),
    "TICKSMM": setting("ticks_per_mm", lowest=1),
    "DRIFTFACTOR": setting("drift_factor", lowest=-0x7FFF),
}
