"""The battery and its charger. The voltage falls with time, faster while the robot drives, and rises while it charges.

The robot charges while a user has plugged in a charger, or while it stands in a dock of the world and has asked for
power. A dock is the pose (m, rad; map frame) of a robot while it charges there. The charging station itself is not
simulated; a world may have walls or boxes in its place.
"""

import math
from typing import Sequence

from ...p2os import ChargeState
from ..world.poses import Pose
from .robot_numbers import BatteryNumbers

US_PER_MINUTE = 6e7


class BatteryPack:
    """A battery of the 12 V class or the 24 V class.

    Args:
        numbers: voltages of a 12 V battery, and how fast they fall and rise.
        nominal: nominal voltage, 12 or 24.

    Attributes:
        scale: ratio of the real voltage to the voltage of a 12 V battery, 1 or 2.
        charging: whether a charger or a dock charges the battery.
    """

    def __init__(self, numbers: BatteryNumbers, nominal: int):
        self._numbers = numbers
        self.scale = nominal / 12.0
        self._level = numbers.full
        self._pretended = 0.0
        self.charging = False

    @property
    def voltage_12v(self) -> float:
        """The voltage (V) scaled to a 12 V battery. A 24 V battery has half its real voltage here."""
        return self._pretended / self.scale if self._pretended else self._level

    @property
    def voltage(self) -> float:
        """The real voltage (V). Setting it drains or charges the battery to this voltage at once."""
        return self.voltage_12v * self.scale

    @voltage.setter
    def voltage(self, voltage: float) -> None:
        self._level = max(0.0, voltage / self.scale)

    @property
    def charge(self) -> float:
        """The state of charge: 0 at the shutdown voltage or below, 1 at the full voltage or above."""
        span = self._numbers.full - self._numbers.shutdown
        return max(0.0, min(1.0, (self.voltage_12v - self._numbers.shutdown) / span))

    @property
    def charge_state(self) -> int:
        """The state of the charger, as the value of a `ChargeState`."""
        if not self.charging:
            return int(ChargeState.NOT_CHARGING)
        if self._level < self._numbers.overcharge:
            return int(ChargeState.BULK)
        return int(ChargeState.OVERCHARGE if self._level < self._numbers.full else ChargeState.FLOAT)

    @property
    def is_low(self) -> bool:
        """Whether the voltage is below the alarm voltage."""
        return self.voltage_12v < self._numbers.alarm

    @property
    def is_empty(self) -> bool:
        """Whether the voltage is below the shutdown voltage, so that the motors get no power."""
        return self.voltage_12v < self._numbers.shutdown

    def pretend(self, voltage: float) -> None:
        """Report `voltage` (real voltage in V) instead of the battery's own. 0 ends this."""
        self._pretended = voltage

    def step(self, duration_us: int, driving: bool) -> None:
        """Discharge or charge the battery for `duration_us` microseconds. It discharges faster while `driving`."""
        if self.charging:
            rise = self._numbers.charging_rise_per_min / US_PER_MINUTE * duration_us
            self._level = max(self._level, min(self._numbers.full, self._level + rise))
        else:
            fall_per_min = self._numbers.driving_fall_per_min if driving else self._numbers.standing_fall_per_min
            self._level = max(0.0, self._level - fall_per_min / US_PER_MINUTE * duration_us)


class Charger:
    """Decides whether one robot is charged: by a charger that a user has plugged in, or by a dock of the world.

    Attributes:
        docks: poses of the world's docks (m, rad; map frame).
        plugged_in: whether a user has plugged in a charger.
        asks_dock: whether the robot takes power when it stands in a dock.
        stops_in_dock: whether the robot stops when a dock starts to charge it.
    """

    def __init__(self, numbers: BatteryNumbers, docks: Sequence[Pose]):
        self.docks = docks
        self._numbers = numbers
        self.plugged_in = False
        self.reset()

    def reset(self) -> None:
        """Make the robot take no power in docks, and not stop in docks, as at power-on."""
        self.asks_dock = self.stops_in_dock = False

    def plug(self, in_: bool) -> None:
        """Plug in the charger if `in_`, or else unplug it."""
        self.plugged_in = in_

    def feeds(self, pose: Pose) -> bool:
        """Return whether the battery of a robot at `pose` (m, rad; map frame) is charged."""
        if self.plugged_in or not self.asks_dock:
            return self.plugged_in
        distance, angle = self._numbers.dock_distance, math.radians(self._numbers.dock_angle_deg)
        return any(stands_in(dock, pose, distance, angle) for dock in self.docks)


def stands_in(dock: Pose, pose: Pose, distance: float, angle: float) -> bool:
    """Return whether a robot at `pose` stands in a dock.

    Args:
        dock: pose of the dock (m, rad; map frame).
        pose: pose of the robot (m, rad; map frame). Headings need not be wrapped.
        distance: largest distance (m) between the middles of robot and dock.
        angle: largest difference (rad) between the headings of robot and dock.
    """
    away_x, away_y = pose[0] - dock[0], pose[1] - dock[1]
    near = away_x * away_x + away_y * away_y <= distance * distance
    # math.remainder is exact, so its result is the same on every computer
    return near and abs(math.remainder(pose[2] - dock[2], 2.0 * math.pi)) <= angle
