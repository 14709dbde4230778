"""What a user is warned of, and how often. Pure: time (monotonic, s) is an argument."""

from typing import Dict, List, NamedTuple, Optional

from ..client import RobotIdentity, RobotState

PERIOD = 10.0
"""The same warning is not repeated within so many seconds."""
LOW_BATTERY_12_V = 11.5
"""Alarm level (V) of a 12 V robot that does not report its own (CONFIGpac LowBattery)."""
SAME_COMMANDER = 5.0
"""Velocities that come further apart (s) than this are two drives, not one slow commander."""


class Notice(NamedTuple):
    """One warning: the kind it is throttled by, and what the user reads."""

    kind: str
    text: str


class Throttle:
    """Lets a kind of warning pass once per PERIOD."""

    def __init__(self, period: float = PERIOD) -> None:
        self._period = period
        self._last: Dict[str, float] = {}

    def passes(self, kind: str, now: float) -> bool:
        """Whether a warning of this kind may be given now; if so it counts as given."""
        last = self._last.get(kind)
        if last is not None and now - last < self._period:
            return False
        self._last[kind] = now
        return True


class Watch:
    """Looks at states and velocities and says what its user should know.

    Args:
        cmd_vel_timeout: s after which a velocity is too old.
        how_to_enable: the command that switches motors on, as the user would type it.
    """

    def __init__(self, cmd_vel_timeout: float, how_to_enable: str) -> None:
        self._timeout = cmd_vel_timeout
        self._how_to_enable = how_to_enable
        self._low_battery = LOW_BATTERY_12_V
        self._last_command: Optional[float] = None
        self._was_moving = False
        self._gaps = 0  # in a row that were too long

    def identified(self, identity: RobotIdentity) -> None:
        """Take the battery's alarm level: the robot's own, else the usual one of its class."""
        volts_of_class = identity.model.battery_class / 12
        reported = identity.config.low_battery_dv if identity.config is not None else None
        level = reported / 10 if reported else LOW_BATTERY_12_V * volts_of_class
        # Some 24 V robots report the level as if they had 12 V.
        self._low_battery = level * volts_of_class if level < 8 * volts_of_class else level

    def state(self, state: RobotState) -> List[Notice]:
        """What is to be said about a state."""
        notices = []
        if state.battery_voltage < self._low_battery:
            levels = state.battery_voltage, self._low_battery
            notices.append(Notice("battery", "battery low: %.1f V, the alarm level is %.1f V; charge it" % levels))
        stalled = [name for name, stall in (("left", state.left_stall), ("right", state.right_stall)) if stall]
        if stalled and not state.stop_button:
            plural = "s are" if len(stalled) > 1 else " is"
            notices.append(Notice("stall", "the %s wheel%s stalled: something holds the robot" % (" and the ".join(stalled), plural)))
        if state.stop_button:
            notices.append(Notice("stop button", "the STOP button is pressed: motors are off; release it, then %s" % self._how_to_enable))
        return notices

    def velocity(self, now: float, moving: bool, state: Optional[RobotState]) -> List[Notice]:
        """What is to be said about a velocity command that arrived, `moving` unless it is zero."""
        notices = []
        if moving and state is not None and not state.motors_enabled:
            notices.append(Notice("motors off", "a velocity arrived, but the motors are off; to switch them on: %s" % self._how_to_enable))
        gap = now - self._last_command if self._last_command is not None else 0.0
        self._gaps = self._gaps + 1 if self._was_moving and self._timeout < gap < SAME_COMMANDER else 0
        if self._gaps > 1:  # one alone may be the pause between two drives
            notices.append(Notice(
                "slow",
                "velocities come every %.1f s, but are too old after %.1f s (cmd_vel_timeout): the robot stops in between; publish at 10 Hz"
                % (gap, self._timeout),
            ))
        self._last_command, self._was_moving = now, moving
        return notices
