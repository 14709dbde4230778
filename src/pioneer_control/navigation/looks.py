"""Where a robot has looked from one place: `Looks`.

A robot that turns to and fro on the spot hears the same again and again. That tells as little as standing does. But its
wheels measure turns badly: after some circles it has to look again, or it no longer knows where it looks.
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
        most_turn: after so much turning (rad) all counts anew.
    """

    def __init__(self, place: float, most_turn: float) -> None:
        self._place, self._most_turn = place, most_turn
        self._from: Optional[Pose] = None
        self._looked, self._turned = np.zeros(_DIRECTIONS), 0.0

    def forget(self) -> None:
        """All that it looks at counts anew."""
        self._from = None

    def new_part(self, pose: Pose, turn: float) -> float:
        """Return how much of a turn looked where the robot had not looked from this place (rad, not negative).

        Args:
            pose: where the turn ended, by the wheels (m, rad).
            turn: the turn (rad, to either side); a small part of a circle.
        """
        self._turned += abs(turn)
        if (self._from is None or self._turned > self._most_turn
                or math.hypot(pose.x - self._from.x, pose.y - self._from.y) > self._place):
            self._from, self._looked, self._turned = pose, np.zeros(_DIRECTIONS), 0.0
        direction = int(pose.heading // _WIDE) % _DIRECTIONS
        part = min(abs(turn), _WIDE - float(self._looked[direction]))
        self._looked[direction] += part
        return part
