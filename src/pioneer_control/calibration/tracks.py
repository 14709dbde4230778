"""What odometry measured in a run, and where the robot ends when it is corrected.

Lengths in m, angles in rad; x ahead of the robot as the run begins, y to its left, counter-clockwise positive.
"""

import math
from typing import Any, List, NamedTuple, Optional

import numpy as np

from ..errors import CalibrationError
from ..floor_poses import Pose, relative

Array = Any     # of numpy

LONGEST_STEP, LONGEST_TURN = 1.0, math.pi / 2.0
"""No robot drives or turns farther (m, rad) from one pose to the next: odometry was reset, or poses got lost."""


class Factors(NamedTuple):
    """How far a robot moves for what its odometry says.

    Attributes:
        distance: way (m) for each metre of odometry.
        turn: turn (rad) for each radian of odometry.
        curve: turn (rad, counter-clockwise) besides, for each metre ahead that the robot really drives.
    """

    distance: float = 1.0
    turn: float = 1.0
    curve: float = 0.0


class OdometryTrack:
    """The steps of one run by odometry: from pose to pose, as an arc.

    Args:
        ahead: way (m) of each step, backward negative.
        turned: turn (rad) of each step.
        gyro: sum of the turn (rad) by the gyro; None without a gyro.
    """

    def __init__(self, ahead: List[float], turned: List[float], gyro: Optional[float] = None) -> None:
        self.ahead, self.turned = np.array(ahead, dtype=float), np.array(turned, dtype=float)
        self.gyro = gyro

    def scaled(self, distance: float, turn: float) -> "OdometryTrack":
        """Return this track with its ways and its turns multiplied by these factors."""
        return OdometryTrack(self.ahead * distance, self.turned * turn, self.gyro)

    @property
    def way(self) -> float:
        """The sum of its ways (m), forward and backward."""
        return float(abs(self.ahead).sum())

    @property
    def turn(self) -> float:
        """Its whole turn (rad), not wrapped."""
        return float(self.turned.sum())

    def end(self, factors: Factors = Factors()) -> Pose:
        """Return where the robot ends by corrected odometry. The heading is not wrapped."""
        return Pose(*(float(column[-1]) for column in self.path(factors)))

    def path(self, factors: Factors = Factors()) -> Array:
        """Return x, y and heading after each step by corrected odometry, as three rows that begin with 0, 0, 0."""
        ways = self.ahead * factors.distance
        turns = self.turned * factors.turn + ways * factors.curve
        headings = np.cumsum(turns)
        middle = headings - turns / 2.0
        steps = np.vstack((np.cumsum(ways * np.cos(middle)), np.cumsum(ways * np.sin(middle)), headings))
        return np.hstack((np.zeros((3, 1)), steps))

    def noise(self, per_metre: float, rad_per_metre: float, factors: Factors) -> Array:
        """Return the covariance (3 x 3) of the end: how far the robot is off by chance, while its wheels roll.

        Args:
            per_metre: standard deviation (m) of the way of one wheel after 1 m; it grows with the root of the way.
            rad_per_metre: turn (rad) when each right wheel rolls 1 m forward and each left wheel 1 m back.
            factors: the correction.
        """
        path = self.path(factors)
        x, y = path[:2, -1:] - (path[:2, :-1] + path[:2, 1:]) / 2.0     # from the middle of each step to the end
        heading = (path[2, :-1] + path[2, 1:]) / 2.0
        half_difference = self.turned / rad_per_metre
        rolled = abs(self.ahead - half_difference) + abs(self.ahead + half_difference)      # by both wheels
        variance = per_metre ** 2 * rolled / 4.0        # of the way of the robot's middle
        along = np.vstack((np.cos(heading), np.sin(heading), np.zeros_like(heading)))
        about = np.vstack((-y, x, np.ones_like(heading))) * rad_per_metre
        return (along * variance) @ along.T + (about * variance) @ about.T


class TrackRecorder:
    """Makes a track from poses of odometry, one after the other, and from turn rates of a gyro.

    Raises CalibrationError when a pose jumps, or something is not finite.
    """

    def __init__(self) -> None:
        self._ahead: List[float] = []
        self._turned: List[float] = []
        self._last: Optional[Pose] = None
        self._rate_time: Optional[float] = None
        self._gyro: Optional[float] = None

    def pose(self, pose: Pose) -> None:
        """Take the next pose (odometry frame)."""
        if not all(map(math.isfinite, pose)):
            raise CalibrationError("odometry says %s, and that is no pose. Drive this run again" % (tuple(pose),))
        if self._last is not None and pose != self._last:
            step = relative(self._last, pose)
            way = math.hypot(step.x, step.y)
            if way > LONGEST_STEP or abs(step.heading) > LONGEST_TURN:
                raise CalibrationError(
                    "odometry jumped by %.2f m and %.0f degrees from one pose to the next: it was reset, or its"
                    " messages got lost. Drive this run again" % (way, math.degrees(step.heading)))
            half = step.heading / 2.0
            self._ahead.append(step.x * math.cos(half) + step.y * math.sin(half))
            self._turned.append(step.heading)
        self._last = pose

    def rate(self, time: float, rate: float) -> None:
        """Take a turn rate (rad/s) of the gyro, the mean since the rate before, and its stamp (s)."""
        if not math.isfinite(rate):
            raise CalibrationError("the gyro says %r, and that is no turn rate. Drive this run again" % rate)
        if self._rate_time is None:
            self._gyro = 0.0
        elif time > self._rate_time:
            assert self._gyro is not None
            self._gyro += rate * (time - self._rate_time)
        self._rate_time = time

    @property
    def track(self) -> OdometryTrack:
        """What was measured so far."""
        return OdometryTrack(self._ahead, self._turned, self._gyro)
