"""What a user is warned of, and how often. Pure: time (monotonic, s) is an argument.

Warnings are a dict of texts by kind. An empty text says that there is nothing to warn of.
"""

import math
import re
from typing import Dict, NamedTuple, Optional

from ..client import RobotIdentity, RobotState

PERIOD = 10.0
"""The same warning is not repeated within so many seconds."""
LOW_BATTERY_12_V = 11.5
"""Alarm level (V) of a 12 V robot that does not report an own level (CONFIGpac LowBattery)."""
EMPTY_BATTERY_12_V = 11.0
"""Level (V) at which a 12 V robot switches itself off, if it does not report an own level (CONFIGpac ShutdownVolts)."""
SAME_COMMANDER = 5.0
"""Seconds. Velocities that come with a longer pause between them are two drives, not one slow commander."""
NUMBER = re.compile("[0-9]+")


class BatteryLevels(NamedTuple):
    """Voltages (V, real) below which a battery is low, and empty: there the robot switches itself off."""

    low: float
    empty: float


def battery_levels(identity: RobotIdentity) -> BatteryLevels:
    """The levels that the robot reports, or the usual levels of robots with such a battery."""
    config, volts_of_class = identity.config, identity.model.battery_class / 12
    low_dv, shutdown_dv = (None, None) if config is None else (config.low_battery_dv, config.shutdown_dv)

    def level(reported_dv: Optional[int], usual_12_v: float) -> float:
        volts = reported_dv / 10 if reported_dv else usual_12_v * volts_of_class
        # Some 24 V robots report a level as if they had 12 V.
        return volts * volts_of_class if volts < 8 * volts_of_class else volts

    low = level(low_dv, LOW_BATTERY_12_V)
    return BatteryLevels(low, min(low, level(shutdown_dv, EMPTY_BATTERY_12_V)))


def low_battery(voltage: float, levels: BatteryLevels) -> str:
    """What to say of a low battery (V)."""
    return "battery low: %.1f V, the alarm level is %.1f V" % (voltage, levels.low)


def stalled_wheels(state: RobotState) -> str:
    """What to say of stalled wheels; empty when no wheel is stalled, or when the STOP button holds the wheels."""
    stalled = [name for name, stall in (("left", state.left_stall), ("right", state.right_stall)) if stall]
    text = "the %s wheel%s stalled: something holds the robot" % (
        " and the ".join(stalled), "s are" if len(stalled) > 1 else " is")
    return text if stalled and not state.stop_button else ""


def stop_button_pressed(how_to_enable: str) -> str:
    """What to say of a pressed STOP button."""
    return "the STOP button is pressed: motors are off; release it, then %s" % how_to_enable


def unmoved(age: float) -> str:
    """What to say of a robot that has stood for ``age`` s with its motors on, told to drive."""
    return ("told to drive, the robot has not moved for %.0f s: does it hear? check the wire to it; "
            "then what holds its wheels" % age)


class Throttle:
    """Lets a kind of warning pass once per PERIOD."""

    def __init__(self) -> None:
        self._last: Dict[str, float] = {}

    def passes(self, kind: str, now: float) -> bool:
        """Whether a warning of this kind may be given now. If it may, it counts as given.

        Kinds that differ only in numbers are one kind.
        """
        kind = NUMBER.sub("", kind)
        passes = now - self._last.get(kind, -math.inf) >= PERIOD
        if passes:
            self._last[kind] = now
        return passes


class Watch:
    """Looks at states and velocities and says what its user should know.

    Args:
        cmd_vel_timeout: s after which a velocity is too old.
        how_to_enable: the command that switches motors on, as the user would type it.
    """

    def __init__(self, cmd_vel_timeout: float, how_to_enable: str) -> None:
        self.cmd_vel_timeout = cmd_vel_timeout
        self._how_to_enable = how_to_enable
        self._battery = BatteryLevels(LOW_BATTERY_12_V, EMPTY_BATTERY_12_V)
        self._last_command: Optional[float] = None
        self._was_moving = False
        self._gaps = 0  # in a row that were too long

    def identified(self, identity: RobotIdentity) -> None:
        """Take the levels of the robot's battery."""
        self._battery = battery_levels(identity)

    def state(self, state: RobotState) -> Dict[str, str]:
        """Warnings about a state."""
        is_low = state.battery_voltage < self._battery.low
        return {
            "battery": low_battery(state.battery_voltage, self._battery) + "; charge it" if is_low else "",
            "stall": stalled_wheels(state),
            "stop button": stop_button_pressed(self._how_to_enable) if state.stop_button else "",
        }

    def velocity(self, now: float, moving: bool, state: Optional[RobotState]) -> Dict[str, str]:
        """Warnings about a velocity command that arrives now (monotonic, s). It is ``moving`` unless it is zero.

        ``state`` is the robot's newest one; None if there is none.
        """
        motors_off = moving and state is not None and not state.motors_enabled
        gap = now - self._last_command if self._last_command is not None else 0.0
        self._gaps = self._gaps + 1 if self._was_moving and self.cmd_vel_timeout < gap < SAME_COMMANDER else 0
        self._last_command, self._was_moving = now, moving
        return {
            "motors off": ("a velocity arrived, but the motors are off; to switch them on: %s" % self._how_to_enable
                           if motors_off else ""),
            "slow": ("velocities come every %.1f s, but are too old after %.1f s (cmd_vel_timeout): the robot stops in "
                     "between; publish at 10 Hz" % (gap, self.cmd_vel_timeout)
                     if self._gaps > 1 else ""),    # one alone may be the pause between two drives
        }
