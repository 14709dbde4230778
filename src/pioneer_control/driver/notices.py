"""The warnings for the user, and how often they are given. Pure functions: time (monotonic, s) is an argument.

Warnings are a dictionary from the kind of a warning to its text. An empty text means that there is no such warning now.
"""

import math
import re
from typing import Dict, Optional, Tuple

from ..client import RobotIdentity, RobotState
from ..client.alarms import (EMPTY_BATTERY_12_V, LOW_BATTERY_12_V, BatteryLevels, battery_levels, low_battery,
                             stalled_wheels, stop_button_pressed)

PERIOD = 10.0
"""The shortest time (s) between two warnings of the same kind that say the same."""
NEWS_PERIOD = 2.0
"""The shortest time (s) between two warnings of the same kind: who makes one mistake after another is told of each."""
SAME_COMMANDER = 5.0
"""Seconds. After a longer pause between two velocities, we assume a new drive, not a publisher that is too slow."""
NUMBER = re.compile("[0-9]+")


class Throttle:
    """Limits how often warnings of the same kind are given: one text once in PERIOD, another in NEWS_PERIOD (s)."""

    def __init__(self) -> None:
        self._last: Dict[str, Tuple[float, str]] = {}

    def passes(self, kind: str, now: float, text: str = "") -> bool:
        """Return whether to give a warning of this kind now (monotonic, s). If true, the warning counts as given.

        Two kinds, or two texts, that differ only in their numbers count as the same.
        """
        kind, text = NUMBER.sub("", kind), NUMBER.sub("", text)
        given_at, given = self._last.get(kind, (-math.inf, ""))
        passes = now - given_at >= (PERIOD if text == given else NEWS_PERIOD)
        if passes:
            self._last[kind] = now, text
        return passes


class Watch:
    """Checks states of the robot and velocity commands, and makes warnings for the user.

    Args:
        cmd_vel_timeout: the time (s) after which a velocity is too old.
        how_to_enable: the shell command that switches the motors on, for the texts.
    """

    def __init__(self, cmd_vel_timeout: float, how_to_enable: str) -> None:
        self.cmd_vel_timeout = cmd_vel_timeout
        self._how_to_enable = how_to_enable
        self._battery = BatteryLevels(LOW_BATTERY_12_V, EMPTY_BATTERY_12_V)
        self._last_command: Optional[float] = None
        self._was_moving = False
        self._gaps = 0  # how many pauses in a row were too long

    def identified(self, identity: RobotIdentity) -> None:
        """Take the identity of the newly connected robot, and use its battery levels from now on."""
        self._battery = battery_levels(identity)

    def state(self, state: RobotState) -> Dict[str, str]:
        """Return the warnings about a state of the robot, by kind."""
        is_low = state.battery_voltage < self._battery.low
        return {
            "battery": low_battery(state.battery_voltage, self._battery) + "; charge it" if is_low else "",
            "stall": stalled_wheels(state),
            "stop button": stop_button_pressed(self._how_to_enable) if state.stop_button else "",
        }

    def velocity(self, now: float, moving: bool, state: Optional[RobotState]) -> Dict[str, str]:
        """Return the warnings about a velocity command, by kind.

        Args:
            now: the time of its arrival (monotonic, s).
            moving: the velocity is not zero.
            state: the newest state of the robot. None if there is none.
        """
        gap = now - self._last_command if self._last_command is not None else 0.0
        self._gaps = self._gaps + 1 if self._was_moving and self.cmd_vel_timeout < gap < SAME_COMMANDER else 0
        self._last_command, self._was_moving = now, moving
        return {
            **self.motors_off(moving, state),
            "slow": ("velocities come every %.1f s, but are too old after %.1f s (cmd_vel_timeout): the robot stops in "
                     "between; publish at 10 Hz" % (gap, self.cmd_vel_timeout)
                     if self._gaps > 1 else ""),    # a single long pause may be the pause between two drives
        }

    def motors_off(self, moving: bool, state: Optional[RobotState]) -> Dict[str, str]:
        """Return the warning about a velocity, zero or ``moving``, that finds the motors off."""
        motors_off = moving and state is not None and not state.motors_enabled
        return {"motors off": "a velocity arrived, but the motors are off; to switch them on: %s" % self._how_to_enable
                if motors_off else ""}
