"""Where a robot has looked from one place: `Looks`.

A robot that turns to and fro on the spot hears the same again and again. That tells as little as standing does.
"""

import math
from typing import Any, Optional

import numpy as np

from ..floor_poses import Pose

Array = Any     # of numpy

_DIRECTIONS = 36
_WIDE = 2.0 * math.pi / _DIRECTIONS     # rad


class Looks:
    """The directions in which a robot has looked from where it is.

    Args:
        place: so far (m) from there it looks from another place.
    """

    def __init__(self, place: float) -> None:
        self._place = place
        self._from: Optional[Pose] = None
        self._looked = np.zeros(_DIRECTIONS)

    def forget(self) -> None:
        """All that it looks at counts anew."""
        self._from = None

    def new_part(self, pose: Pose, turn: float) -> float:
        """Return how much of a turn looked where the robot had not looked from this place (rad, not negative).

        Args:
            pose: where the turn ended, by the wheels (m, rad).
            turn: the turn (rad, to either side); a small part of a circle.
        """
        if self._from is None or math.hypot(pose.x - self._from.x, pose.y - self._from.y) > self._place:
            self._from, self._looked = pose, np.zeros(_DIRECTIONS)
        direction = int(pose.heading // _WIDE) % _DIRECTIONS
        part = min(abs(turn), _WIDE - float(self._looked[direction]))
        self._looked[direction] += part
        return part
