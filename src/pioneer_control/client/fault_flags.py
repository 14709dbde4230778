"""The table of fault flags: how each bit of FAULTFLAGS, with which a robot reports its faults, shows in diagnostics."""

from enum import IntEnum
from typing import Dict, Tuple

from ..p2os import FaultFlags


Level = IntEnum("Level", {"OK": 0, "WARN": 1, "ERROR": 2, "STALE": 3})
"""The levels of diagnostic_msgs/DiagnosticStatus."""


FAULTS: Dict[FaultFlags, Tuple[str, Level, str]] = {
    FaultFlags.HIGH_TEMPERATURE: ("Temperature", Level.ERROR, "the robot says it is too hot: let it cool down"),
    FaultFlags.POWER_BOARD_ERROR: (
        "Battery", Level.ERROR, "the power board reports an error: switch the robot off and on; have it looked at"),
    FaultFlags.UNDERVOLTAGE: ("Battery", Level.WARN, "the robot itself reports a low voltage: charge it"),
    FaultFlags.GYRO_FAULT: ("Motors", Level.WARN, "the gyro fails: headings come from the wheels alone"),
    FaultFlags.BATTERY_OVER_TEMPERATURE: (
        "Battery", Level.ERROR, "the battery is too hot: stop driving and charging, let it cool down"),
    FaultFlags.BATTERY_BALANCE_NEEDED: (
        "Battery", Level.WARN, "the cells have drifted apart: leave the robot on its charger for a full charge"),
    FaultFlags.ENCODER_DEGRADATION: ("Motors", Level.WARN, "a wheel encoder is getting worse: clean or replace it"),
    FaultFlags.ENCODER_FAILURE: ("Motors", Level.ERROR, "a wheel encoder fails: do not trust the pose; replace it"),
    FaultFlags.DRIVE_FAULT: ("Motors", Level.ERROR, "a motor amplifier reports a fault: switch the robot off and on"),
    FaultFlags.E_STOP_MISMATCH: (
        "Motors", Level.ERROR, "the channels of the emergency stop disagree: check the STOP buttons and their wires"),
    FaultFlags.E_STOP_SAFETY_FAULT: (
        "Motors", Level.ERROR, "the emergency stop's circuit reports a fault: do not drive; have it looked at"),
    FaultFlags.SPEED_ZONE_FAULT: (
        "Motors", Level.WARN, "the safety system saw too high a speed in its zone: drive slower"),
    FaultFlags.UNKNOWN_SAFETY_FAULT: (
        "Motors", Level.ERROR, "the safety system reports a fault it does not name: switch the robot off and on"),
    FaultFlags.REVERSE_SPEED_EXCEEDED: ("Motors", Level.WARN, "too fast backwards for the safety system: drive slower"),
    FaultFlags.JOYSTICK_WITH_SAFETY_OFF: (
        "Motors", Level.WARN, "the joystick drives the robot with its safety system off"),
}
"""For each bit: the diagnostics task that reports it, its level, and the text. LASER_POWER is not here: it is no fault.
"""
