"""Where on the map something stood that is on no map, after the robot has gone on from there.

Wheels err, so the place of an old echo is wrong after a minute. Echoes are therefore soon forgotten. But a robot with
two ways, and a thing in each, then forgets the first one on its way to the second, turns round, and goes to and fro. So
what stood still is remembered on the map, for planning.
"""

from typing import Any

import numpy as np

from ..floor_poses import Pose
from .tuned import ObstacleNumbers

Array = Any     # of numpy


class StandingObstacles:
    """Places where something stood still.

    Args:
        tuned: the numbers of obstacles.

    Attributes:
        places: array (number, 2) of x and y (m, map frame).
    """

    def __init__(self, tuned: ObstacleNumbers):
        self._tuned = tuned
        self.forget()

    def forget(self) -> None:
        """Forget all."""
        self.places, self._time = np.zeros((0, 2)), np.zeros(0)

    def keep(self, which: Array) -> None:
        """Forget all but some places: those that are true in an array of bools."""
        self.places, self._time = self.places[which], self._time[which]

    def remember(self, places: Array, pose: Pose, now: float) -> None:
        """Remember what stands still, but nothing near the robot: it hears what is still there.

        Args:
            places: array (number, 2) of x and y (m, map frame) of what stands still now.
            pose: where the robot is (map frame).
            now: the time (s).
        """
        self._time = np.append(np.full(len(places), now), self._time)
        self.places = np.vstack((places, self.places))
        # Of several places in a cell the first one is the newest.
        self.keep(np.unique(np.floor(self.places / self._tuned.cell), axis=0, return_index=True)[1])
        self.keep((now - self._time < self._tuned.kept_standing)
                  & (np.hypot(*(self.places - pose[:2]).T) > self._tuned.away))
