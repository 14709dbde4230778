"""Odometry of a robot whose calibration says that its wheels turn and bend otherwise than the robot counts.

The robot adds up its pose with a heading that is a little wrong. So each of its steps is turned to the corrected
heading before it is added. This keeps the rounding errors of the steps as small as without a correction: the angle
between both headings changes slowly, so they cancel each other.

Source of the factors: a user's models file (docs/calibration.md).
"""

import math
from typing import NamedTuple, Optional, Tuple

from ..robots import RobotModel
from .odometry import Odometry


class Correction(NamedTuple):
    """What a robot turns, beside what it counts.

    Attributes:
        turn_factor: turn (rad) for each radian that the robot counts.
        curve: turn (rad, counter-clockwise) besides, for each metre ahead.
    """

    turn_factor: float = 1.0
    curve: float = 0.0


class CorrectedOdometry(Odometry):
    """Odometry with a correction of its heading. The counts and their sums stay as the robot counts them.

    Args:
        mm_per_count, units_per_turn: as of Odometry.
        correction: how the robot errs.
    """

    def __init__(self, mm_per_count: float, units_per_turn: int, correction: Correction) -> None:
        self._correction = correction
        self._corrected = (0.0, 0.0, 0.0)
        super().__init__(mm_per_count, units_per_turn)

    def fits(self, mm_per_count: float, units_per_turn: int, correction: Tuple[float, float] = (1.0, 0.0)) -> bool:
        """Return whether this odometry uses these units and this correction."""
        return super().fits(mm_per_count, units_per_turn) and self._correction == correction

    def update(self, x_raw: int, y_raw: int, heading_raw: int, seconds: float = math.inf) -> bool:
        """Take the raw position and heading of the next SIP, as Odometry does, and correct the step to them."""
        before = self.x_counts, self.y_counts, self.heading_units, self.travel
        possible = super().update(x_raw, y_raw, heading_raw, seconds)
        forward, left, units, ahead = (
            now - then for now, then in zip((self.x_counts, self.y_counts, self.heading_units, self.travel), before))
        turn = units * self._rad_per_unit
        turned = turn * self._correction.turn_factor + ahead * self._correction.curve
        x, y, heading = self._corrected
        # from the middle of the step by the robot's heading to the middle by the corrected one
        rotation = (heading + turned / 2) - (self._raw[2] * self._rad_per_unit - turn / 2)
        cosine, sine, metres = math.cos(rotation), math.sin(rotation), self._mm_per_count / 1000
        self._corrected = (x + (cosine * forward - sine * left) * metres,
                           y + (sine * forward + cosine * left) * metres, math.remainder(heading + turned, 2 * math.pi))
        return possible

    def reset(self) -> None:
        """Set the present pose to zero: x 0, y 0, heading 0."""
        super().reset()
        self._corrected = (0.0, 0.0, 0.0)

    @property
    def pose(self) -> Tuple[float, float, float]:
        """Corrected pose in the odometry frame: x, y (m), heading (rad, counter-clockwise, -pi <= heading <= pi)."""
        return self._corrected


def odometry_of(model: RobotModel, before: Optional[Odometry] = None) -> Odometry:
    """Return the odometry of a model: the one that was there ``before`` if it fits, else a new one."""
    units = model.dist_mm_per_unit, model.angle_units_per_rev
    correction = Correction(model.turn_factor, model.curve_rad_per_m)
    if before is not None and before.fits(*units, correction):
        return before
    return Odometry(*units) if correction == Correction() else CorrectedOdometry(*units, correction)
