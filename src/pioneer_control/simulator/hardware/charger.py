"""What feeds the battery: a charger that somebody plugs in, or a dock of the world that the robot stands in and asks
for power.

A dock is the pose (m, rad; map frame) that a robot has while it charges there. The station itself is drawn as walls or
boxes, or not at all.
"""

import math
from typing import Optional, Sequence

from ..world.geometry import Pose
from .robot_numbers import BatteryNumbers


class Charger:
    """The charger of one robot.

    Attributes:
        docks: of the world.
        plugged_in: somebody has plugged a charger in.
        asks_dock: the robot takes power where it stands in a dock.
        stops_in_dock: and stops there.
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
        numbers = self._numbers
        return dock_at(pose, self.docks, numbers.dock_distance, math.radians(numbers.dock_angle_deg)) is not None


def dock_at(pose: Pose, docks: Sequence[Pose], distance: float, angle: float) -> Optional[Pose]:
    """The dock that a robot at `pose` stands in, None when it stands in none.

    Args:
        docks: as `World.docks`.
        distance: how far (m) the robot's middle may be from the dock's.
        angle: how far (rad) its heading may be from the dock's, either way; headings need not be wrapped.
    """
    x, y, heading = pose
    for dock in docks:
        away_x, away_y = x - dock[0], y - dock[1]
        near = away_x * away_x + away_y * away_y <= distance * distance
        # remainder is exact: no library rounds it
        if near and abs(math.remainder(heading - dock[2], 2.0 * math.pi)) <= angle:
            return dock
    return None
