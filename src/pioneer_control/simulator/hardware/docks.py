"""Charging stations: when a robot stands in one.

A dock of a world is the pose (m, rad; map frame) that a robot has while it charges there. The station itself is drawn as walls or boxes,
or not at all.
"""

import math
from typing import Optional, Sequence

from ..world.geometry import Pose


def dock_at(pose: Pose, docks: Sequence[Pose], distance: float, angle: float) -> Optional[Pose]:
    """The dock that a robot at `pose` stands in, None when it stands in none.

    :param docks: as `World.docks`.
    :param distance: how far (m) the robot's middle may be from the dock's.
    :param angle: how far (rad) its heading may be from the dock's, either way; headings need not be wrapped.
    """
    x, y, heading = pose
    for dock in docks:
        away_x, away_y = x - dock[0], y - dock[1]
        near = away_x * away_x + away_y * away_y <= distance * distance
        if near and abs(math.remainder(heading - dock[2], 2.0 * math.pi)) <= angle:  # remainder is exact: no library rounds it
            return dock
    return None
