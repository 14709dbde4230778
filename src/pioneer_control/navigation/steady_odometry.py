"""A pose by odometry that never jumps, made of one that may: somebody resets it (`reset_odometry` of the driver)."""

import math
from typing import Optional

from ..floor_poses import Pose, compose, relative

FASTEST = 2.0, 5.0
"""No robot is faster than this: m/s and rad/s."""
SPARE = 0.15, 0.3
"""Way (m) and turn (rad) that a packet may tell besides: two packets that were held up have stamps near each other."""


class SteadyOdometry:
    """Makes steady poses of those that the wheels of one robot tell.

    Attributes:
        jumped: whether the last pose was one to which no robot could have driven.
    """

    def __init__(self) -> None:
        self.jumped = False
        self._frame = Pose(0.0, 0.0, 0.0)       # the origin of what the wheels tell, among steady poses
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
            self.jumped = _jumps(step, passed)
            if self.jumped:
                self._frame = compose(compose(compose(self._frame, before), self._step),
                                      relative(told, Pose(0.0, 0.0, 0.0)))
            else:
                self._step = step
        return compose(self._frame, told)


def _jumps(step: Pose, passed: float) -> bool:
    """Return whether a step (m, rad) is more than a robot can drive in a time (s)."""
    way, turn = (fastest * passed + spare for fastest, spare in zip(FASTEST, SPARE))
    return math.hypot(step.x, step.y) > way or abs(step.heading) > turn
