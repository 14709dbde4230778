"""A cloud of poses (particles) that says where the robot may be: it moves with the robot, and readings weigh it."""

import math
from typing import Any, NamedTuple, Tuple

import numpy as np

from ..floor_poses import Pose
from .frames import turned, wrapped_angles
from .tuned import LocalisationNumbers

Array = Any     # of numpy

MAIN_POSITION, MAIN_HEADING = 0.5, 0.5
"""Poses that differ less (m, rad) from the middle of the likeliest place are of this place."""
PLACES = 24
"""So many poses of the cloud are asked how likely their places are."""
ON_THE_SPOT = 0.003
"""A robot turns on the spot that moves by less (m) in a packet."""
WIDE = 5.0
"""A cloud is wide that spreads more than so many times as far as its poses scatter when they are drawn anew."""


class Spread(NamedTuple):
    """The middle of the likeliest place of a cloud, and the covariance (3, 3) of the whole cloud about it."""

    pose: Pose
    covariance: Array

    @property
    def position(self) -> float:
        """Standard deviation of the position (m), in the direction in which it is greatest."""
        middle, half = self._axes
        return math.sqrt(middle + half)

    @property
    def across(self) -> float:
        """Standard deviation of the position (m), in the direction in which it is least."""
        middle, half = self._axes
        return math.sqrt(max(0.0, middle - half))

    @property
    def direction(self) -> float:
        """The direction (rad, map frame) in which the standard deviation of the position is greatest."""
        (xx, xy), (_, yy) = self.covariance[:2, :2].tolist()
        return math.atan2(2.0 * xy, xx - yy) / 2.0

    @property
    def _axes(self) -> Tuple[float, float]:
        """The mean of the greatest and the least variance of the position (m^2), and half their difference."""
        (xx, xy), (_, yy) = self.covariance[:2, :2].tolist()
        return (xx + yy) / 2.0, math.hypot((xx - yy) / 2.0, xy)

    @property
    def heading(self) -> float:
        """Standard deviation of the heading (rad)."""
        return math.sqrt(float(self.covariance[2, 2]))


class PoseCloud:
    """The cloud.

    Args:
        tuned: the numbers of localisation.
        luck: random generator.

    Attributes:
        poses: array (poses, 3) of x, y (m) and heading (rad, not wrapped), map frame.
    """

    def __init__(self, tuned: LocalisationNumbers, luck: Any):
        self._tuned, self._luck = tuned, luck
        self.put(np.zeros((1, 3)), np.zeros(1), 0.0, 0.0, 1)

    def put(self, middles: Array, logs: Array, position: float, heading: float, count: int) -> None:
        """Begin anew with `count` poses about some middles (poses, 3), in shares by their log-weights.

        `position` and `heading` are the standard deviations about each middle (m, rad).
        """
        chosen = _chosen(np.exp(logs - np.max(logs)), count, self._luck)
        self.poses = middles[chosen] + self._luck.normal(size=(count, 3)) * (position, position, heading)
        self._logs, self._wide, self._turns_only = np.zeros(count), True, False

    def move(self, step: Pose) -> None:
        """Move all poses by a motion that the wheels measured, each with another error of the wheels."""
        way, turn = math.hypot(step.x, step.y), abs(step.heading)
        if not way and not turn:
            return
        self._turns_only = way < ON_THE_SPOT
        tuned, count = self._tuned, len(self.poses)
        scatter = self._luck.normal(size=(3, count))
        error = tuned.noise_way * math.sqrt(way)
        ahead, aside = step.x + scatter[0] * error, step.y + scatter[1] * error * 0.3
        # the step was measured from the heading at its beginning
        self.poses[:, :2] += np.transpose(turned(ahead, aside, self.poses[:, 2]))
        turn_error = math.sqrt(tuned.noise_turn_of_way ** 2 * way + tuned.noise_turn ** 2 * turn)
        self.poses[:, 2] += step.heading + scatter[2] * turn_error

    def weigh(self, logs: Array, count: int, roughen: bool = False) -> None:
        """Weigh each pose by a log-likelihood. When few poses have most of the weight, draw `count` poses anew.

        `roughen`: those of a wide cloud scatter about the ones that they come from, while the robot turns on the spot.
        Else the few that fit are soon all that is left of it: they do not scatter as on a way.
        """
        self._logs += logs
        self._logs -= self._logs.max()
        weights = np.exp(self._logs)
        if weights.sum() ** 2 < 0.5 * len(weights) * np.square(weights).sum() or count != len(weights):
            self.poses = self.poses[_chosen(weights, count, self._luck)]
            if roughen and self._wide and self._turns_only:
                self.poses += self._luck.normal(0.0, self._tuned.roughening, (count, 3))
            self._logs = np.zeros(count)

    def spread(self) -> Spread:
        """Return where the robot most likely is, and how far the cloud spreads."""
        weights = np.exp(self._logs)
        weights /= weights.sum()
        middle = self.poses[weights.argmax()]
        off, near = self._about(middle, weights)
        if near.sum() < 0.5:    # the likeliest pose need not be of the likeliest place
            middle = self._likeliest(weights)
            off, near = self._about(middle, weights)
        shift = near @ off / near.sum()     # from there to the middle of the poses about it
        mean = weights @ off
        covariance = (off * weights[:, None]).T @ off - mean[:, None] * shift + shift[:, None] * (shift - mean)
        x, y, heading = (middle + shift).tolist()
        spread = Spread(Pose(x, y, math.remainder(heading, 2.0 * math.pi)), covariance)
        self._wide = spread.position > WIDE * self._tuned.roughening
        return spread

    def _about(self, middle: Array, weights: Array) -> Tuple[Array, Array]:
        """Return how far each pose is from a pose, and the weights of those that are of its place; 0 of the others."""
        off = self.poses - middle
        off[:, 2] = wrapped_angles(off[:, 2])
        inside = np.abs(off) < (MAIN_POSITION, MAIN_POSITION, MAIN_HEADING)
        return off, weights * (inside[:, 0] & inside[:, 1] & inside[:, 2])

    def _likeliest(self, weights: Array) -> Array:
        """Return a pose of the likeliest place: of some poses, the one that has most of the weight about it."""
        some = self.poses[::max(1, len(self.poses) // PLACES)]
        return max(some, key=lambda pose: float(self._about(pose, weights)[1].sum()))


def _chosen(weights: Array, count: int, luck: Any) -> Array:
    """Return `count` indices, each in proportion to its weight (systematic resampling)."""
    sums = np.cumsum(weights)
    return np.minimum(np.searchsorted(sums, (luck.random() + np.arange(count)) / count * sums[-1]), len(weights) - 1)
