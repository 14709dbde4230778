"""A pose by odometry that never jumps, made of one that may: somebody resets it (`reset_odometry` of the driver)."""

import math
from typing import Optional

from ..floor_poses import Pose, compose, relative

FASTEST = 2.0, 5.0
"""No robot is faster than this: m/s and rad/s."""
SPARE = 0.15, 0.3
"""Way (m) and turn (rad) that a message may tell besides: stamps of two that were held up are near each other, and
while a clock stands they are the same."""


class SteadyOdometry:
    """Makes steady poses of those that the wheels of one robot tell.

    Attributes:
        origin: where the wheels tell a pose of 0, among steady poses.
    """

    def __init__(self) -> None:
        self.origin = Pose(0.0, 0.0, 0.0)
        self._step = Pose(0.0, 0.0, 0.0)        # the last one
        self._told: Optional[Pose] = None
        self._time = 0.0

    def of(self, told: Pose, time: float) -> Pose:
        """Return the steady pose of one that the wheels tell at a time (s).

        After a jump, the robot is where it is if it has moved as in the packet before.
        """
        before, passed = self._told, max(0.0, time - self._time)
        self._told, self._time = told, time
        if before is not None:
            step = relative(before, told)
            if _jumps(step, passed):
                here = compose(compose(self.origin, before), self._step)
                self.origin = compose(here, relative(told, Pose(0.0, 0.0, 0.0)))
            else:
                self._step = step
        return compose(self.origin, told)


def _jumps(step: Pose, passed: float) -> bool:
    """Return whether a step (m, rad) is more than a robot can drive in a time (s)."""
    way, turn = (fastest * passed + spare for fastest, spare in zip(FASTEST, SPARE))
    return math.hypot(step.x, step.y) > way or abs(step.heading) > turn
