"""Learns how the wheels err: how much farther the robot turns and drives than odometry says, while it is sure where.

Tyres have other sizes than the calibration says. A turn of 360 degrees can so be wrong by 18 degrees, always to the
same side. Odometry that is corrected for this keeps the readings of the last metres together.
"""

import math
from typing import Any, Optional

import numpy as np

from ..floor_poses import Pose, compose, relative, wrapped

Array = Any     # of numpy

SEGMENT_TURN, SEGMENT_WAY = 1.5, 2.0
"""After such a turn (rad) or way (m), a segment ends: its odometry is compared with the poses at its ends."""
HEADING_ERROR, WAY_ERROR = 0.05, 0.06
"""Standard deviations of what two poses say about a turn (rad) and a way (m)."""
TURN_PRIOR, CURVE_PRIOR, WAY_PRIOR = 0.05, 0.02, 0.03
"""How wrong wheels are: shares of a turn and of a way, and rad per metre straight ahead (standard deviations)."""


class WheelCalibration:
    """Corrects odometry, and learns the correction.

    Attributes:
        odometry: the corrected odometry. It begins at 0, 0, 0.
    """

    def __init__(self) -> None:
        self.odometry = Pose(0.0, 0.0, 0.0)
        self._factors = np.array([1.0, 0.0])        # of a turn; turn (rad) per metre ahead
        self._variance = np.diag([TURN_PRIOR ** 2, CURVE_PRIOR ** 2])
        self._way_factor, self._way_variance = 1.0, WAY_PRIOR ** 2
        self._start: Optional[Pose] = None      # of the segment, by the map
        self._track = Pose(0.0, 0.0, 0.0)       # since then, by the corrected odometry
        self._turn = self._ahead = self._way = 0.0      # since then, by the wheels

    @property
    def factors(self) -> Array:
        """An array of three: its turn (rad) for each radian of odometry and for each metre ahead, its way (m) for each
        metre.
        """
        return np.append(self._factors, self._way_factor)

    def corrected(self, step: Pose) -> Pose:
        """Add a motion that the wheels measured (m, rad; frame of the robot before it). Return it corrected."""
        turn = float(self._factors @ (step.heading, step.x))
        better = Pose(step.x * self._way_factor, step.y * self._way_factor, turn)
        self.odometry = compose(self.odometry, better)
        self._track = compose(self._track, better)
        self._turn += step.heading
        self._ahead += step.x
        self._way += math.hypot(step.x, step.y)
        return better

    def learn(self, pose: Optional[Pose]) -> None:
        """Take the pose on the map (m, rad), None if it is not sure. After a segment, learn from it and its begin."""
        if pose is None or self._start is None:
            self._begin(pose)
        elif abs(self._turn) > SEGMENT_TURN or self._way > SEGMENT_WAY:
            way = relative(self._start, pose)
            measured = np.array([self._turn, self._ahead])
            error = wrapped(way.heading - float(self._factors @ measured))
            gain = self._variance @ measured / (measured @ self._variance @ measured + HEADING_ERROR ** 2)
            if abs(error) < 0.3 and self._way < 3.0 * SEGMENT_WAY and abs(self._turn) < 3.0 * SEGMENT_TURN:
                self._factors = self._factors + gain * error
                self._variance = self._variance - np.outer(gain, measured @ self._variance)
                self._learn_way(math.hypot(way.x, way.y), math.hypot(self._track.x, self._track.y))
            self._begin(pose)

    def _learn_way(self, true: float, tracked: float) -> None:
        """Take how far two poses are apart (m), and how far by the corrected odometry."""
        measured = tracked / self._way_factor
        gain = self._way_variance * measured / (measured ** 2 * self._way_variance + WAY_ERROR ** 2)
        if abs(true - tracked) < 0.3:
            self._way_factor += gain * (true - tracked)
            self._way_variance -= gain * measured * self._way_variance

    def _begin(self, pose: Optional[Pose]) -> None:
        self._start, self._track = pose, Pose(0.0, 0.0, 0.0)
        self._turn = self._ahead = self._way = 0.0
