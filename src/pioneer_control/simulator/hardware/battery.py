"""The battery: it falls with time, faster while the robot drives, and rises while something feeds it.

That is a charger that somebody plugs in, or a dock of the world, while a robot that asks for power stands in it. A dock
is the pose (m, rad; map frame) that a robot has while it charges there. The station itself is drawn as walls or boxes,
or not at all.
"""

import math
from typing import Sequence

from ...p2os import ChargeState
from ..world.poses import Pose
from .robot_numbers import BatteryNumbers

US_PER_MINUTE = 6e7


class BatteryPack:
    """A battery of the 12 V or the 24 V class.

    Args:
        numbers: voltages of the 12 V class and how fast they fall and rise.
        nominal: 12 or 24.

    Attributes:
        scale: by how much its voltage is more than that of a 12 V battery.
        charging: a charger feeds it.
    """

    def __init__(self, numbers: BatteryNumbers, nominal: int):
        self._numbers = numbers
        self.scale = nominal / 12.0
        self._level = numbers.full
        self._pretended = 0.0
        self.charging = False

    @property
    def voltage_12v(self) -> float:
        """Voltage (V) on the scale of a 12 V battery."""
        return self._pretended / self.scale if self._pretended else self._level

    @property
    def voltage(self) -> float:
        """Real voltage (V). Setting it drains or fills the battery to there, as a fault or a fresh battery would."""
        return self.voltage_12v * self.scale

    @voltage.setter
    def voltage(self, voltage: float) -> None:
        self._level = max(0.0, voltage / self.scale)

    @property
    def charge(self) -> float:
        """Share of the way from the shutdown voltage to full, 0 to 1."""
        span = self._numbers.full - self._numbers.shutdown
        return max(0.0, min(1.0, (self.voltage_12v - self._numbers.shutdown) / span))

    @property
    def charge_state(self) -> int:
        """What the charger does, one of `ChargeState`."""
        if not self.charging:
            return int(ChargeState.NOT_CHARGING)
        if self._level < self._numbers.overcharge:
            return int(ChargeState.BULK)
        return int(ChargeState.OVERCHARGE if self._level < self._numbers.full else ChargeState.FLOAT)

    @property
    def is_low(self) -> bool:
        """Whether the alarm sounds."""
        return self.voltage_12v < self._numbers.alarm

    @property
    def is_empty(self) -> bool:
        """Whether the robot can no longer drive."""
        return self.voltage_12v < self._numbers.shutdown

    def pretend(self, voltage: float) -> None:
        """Report this real voltage (V) whatever the battery has; 0 ends the pretence."""
        self._pretended = voltage

    def step(self, duration_us: int, driving: bool) -> None:
        """Use the battery for some microseconds, or charge it."""
        if self.charging:
            rise = self._numbers.charging_rise_per_min / US_PER_MINUTE * duration_us
            self._level = max(self._level, min(self._numbers.full, self._level + rise))
        else:
            fall_per_min = self._numbers.driving_fall_per_min if driving else self._numbers.standing_fall_per_min
            self._level = max(0.0, self._level - fall_per_min / US_PER_MINUTE * duration_us)


class Charger:
    """The charger of one robot.

    Attributes:
        docks: of the world.
        plugged_in: somebody has plugged a charger in.
        asks_dock: the robot takes power where it stands in a dock.
        stops_in_dock: it stops in a dock that feeds it.
    """

    def __init__(self, numbers: BatteryNumbers, docks: Sequence[Pose]):
        self.docks = docks
        self._numbers = numbers
        self.plugged_in = False
        self.reset()

    def reset(self) -> None:
        """Ask no dock for power, as at power-on."""
        self.asks_dock = self.stops_in_dock = False

    def ask_dock(self, asks: bool) -> None:
        """Take power in a dock from now on, or no longer."""
        self.asks_dock = asks

    def plug(self, in_: bool) -> None:
        """Plug a charger in, or pull it out."""
        self.plugged_in = in_

    def feeds(self, pose: Pose) -> bool:
        """Whether the battery of a robot at `pose` is charged."""
        if self.plugged_in or not self.asks_dock:
            return self.plugged_in
        distance, angle = self._numbers.dock_distance, math.radians(self._numbers.dock_angle_deg)
        return any(stands_in(dock, pose, distance, angle) for dock in self.docks)


def stands_in(dock: Pose, pose: Pose, distance: float, angle: float) -> bool:
    """Whether a robot at `pose` stands in a dock.

    Args:
        distance: how far (m) the robot's middle may be from the dock's.
        angle: how far (rad) its heading may be from the dock's, either way; headings need not be wrapped.
    """
    away_x, away_y = pose[0] - dock[0], pose[1] - dock[1]
    near = away_x * away_x + away_y * away_y <= distance * distance
    # remainder is exact: no library rounds it
    return near and abs(math.remainder(pose[2] - dock[2], 2.0 * math.pi)) <= angle
