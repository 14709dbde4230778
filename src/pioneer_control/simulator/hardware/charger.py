"""What feeds the battery: a charger that somebody plugs in, or a dock of the world.

A robot asks a dock for power, and gets it while it stands in the dock.

A dock is the pose (m, rad; map frame) that a robot has while it charges there. The station itself is drawn as walls or
boxes, or not at all.
"""

import math
from typing import Sequence

from ..world.geometry import Pose
from .robot_numbers import BatteryNumbers


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
