"""Finds poses anywhere on the map that explain the last readings: for an unknown start, and after a robot was carried.

Random poses are compared with a few readings at first, the better ones with more, and the best are moved a little and
compared with all. The work is cut into steps, so that no packet waits for it.
"""

from typing import Any, Iterator, List, NamedTuple, Optional, Union

import numpy as np

from .frames import wrapped_angles
from .laser_field import LaserField
from .measurement import Beams, RangeModel
from .tuned import LocalisationNumbers

Array = Any     # of numpy

FIRST_READINGS, SECOND_READINGS, THIRD_READINGS = 12, 60, 150
KEPT_FIRST, KEPT_SECOND, KEPT_THIRD = 400, 60, 12
SAME_PLACE, SAME_HEADING = 0.4, 0.35
"""Poses that differ by less (m, rad) are one place."""


class Found(NamedTuple):
    """The result of a search: poses in different places, the best first.

    `poses` is an array (places, 3), relative to the map, of the robot when the search began. `scores` are their mean
    log-likelihoods of a spot that was heard, see `RangeModel.spot_shares`.
    """

    poses: Array
    scores: Array


class PoseSearch:
    """Searches, one step at each call of `step`.

    Args:
        model: compares poses with readings.
        places: array (places, 2) of x and y (m) where the robot can stand.
        area: their area (m^2).
        tuned: the numbers of localisation.
        luck: random generator.
    """

    def __init__(self, model: Union[RangeModel, LaserField], places: Array, area: float, tuned: LocalisationNumbers,
                 luck: Any):
        self._model, self._places, self._tuned, self._luck = model, places, tuned, luck
        self._count = max(tuned.least_poses, int(area * tuned.poses_per_square_metre))
        self._steps: Optional[Iterator[Optional[Found]]] = None

    @property
    def runs(self) -> bool:
        """Whether a search has begun and has not ended."""
        return self._steps is not None

    def begin(self, beams: Beams) -> None:
        """Begin a search for poses that explain these readings. A search that runs is given up."""
        self._steps = self._search(beams) if len(self._places) else None

    def give_up(self) -> None:
        """End the search that runs, without a result."""
        self._steps = None

    def step(self) -> Optional[Found]:
        """Do a part of the search that runs. Return the result when it is complete."""
        found = next(self._steps) if self._steps is not None else None
        if found is not None:
            self._steps = None
        return found

    def _search(self, beams: Beams) -> Iterator[Optional[Found]]:
        first, second, third = (spread_out(beams, count) for count in (FIRST_READINGS, SECOND_READINGS, THIRD_READINGS))
        best, scores = np.empty((0, 3)), np.empty(0)
        for begin in range(0, self._count, self._tuned.poses_per_step):
            poses = self.random_poses(min(self._tuned.poses_per_step, self._count - begin))
            new = self._scores(poses, first, coarse=True)
            best, scores = np.vstack((best, poses)), np.concatenate((scores, new))
            best, scores = _best(best, scores, KEPT_FIRST)
            yield None
        best, scores = _best(best, self._scores(best, second, coarse=True), KEPT_SECOND)
        best, scores = self._moved(best, 16, 0.10, second, True)
        yield None
        best, scores = self._moved(best, 16, 0.05, second, False)
        best, scores = different_places(best, scores, KEPT_THIRD)
        yield None
        for spread in (0.04, 0.02):
            best, scores = self._moved(best, 12, spread, third, False)
        scores = self._scores(best, beams, coarse=False)
        best, scores = different_places(best, scores, KEPT_THIRD)
        yield Found(best, scores)

    def random_poses(self, count: int) -> Array:
        """Return random poses where the robot can stand: array (count, 3). They are all 0 if it can stand nowhere."""
        poses = np.zeros((count, 3))
        if not len(self._places):
            return poses
        poses[:, :2] = self._places[self._luck.integers(0, len(self._places), count)]
        poses[:, :2] += self._luck.uniform(-0.025, 0.025, (count, 2))
        poses[:, 2] = self._luck.uniform(-np.pi, np.pi, count)
        return poses

    def scored(self, poses: Array, beams: Beams) -> Found:
        """Return some poses with their scores for other readings, the best first."""
        scores = self._scores(poses, beams, coarse=False)
        order = np.argsort(-scores)
        return Found(poses[order], scores[order])

    def improved(self, poses: Array, beams: Beams) -> Found:
        """Return the best of some poses near which the robot may be, a little moved, compared like a found pose."""
        third = spread_out(beams, THIRD_READINGS)
        best, _ = _best(poses, self._scores(poses, third, coarse=False), 3)
        for spread in (0.04, 0.02):
            best, _ = self._moved(best, 8, spread, third, False)
        best, scores = _best(best, self._scores(best, beams, coarse=False), 1)
        return Found(best, scores)

    def _moved(self, poses: Array, copies: int, spread: float, beams: Beams, coarse: bool) -> Any:
        """Return the best of some moved copies of each pose, and their scores. `spread` is in m, and in rad."""
        moved = np.repeat(poses[:, None, :], copies, axis=1)
        moved[:, 1:] += self._luck.normal(0.0, spread, (len(poses), copies - 1, 3))
        scores = self._scores(moved.reshape(-1, 3), beams, coarse).reshape(len(poses), copies)
        chosen = np.arange(len(poses)), scores.argmax(axis=1)
        return moved[chosen], scores[chosen]

    def _scores(self, poses: Array, beams: Beams, coarse: bool) -> Array:
        """Return the mean log-likelihood of the spots that were heard, for each pose."""
        shares = self._model.spot_shares(beams)
        return self._model.log_likelihoods(poses, beams, coarse) @ (shares / shares.sum()).astype(np.float32)


def spread_out(beams: Beams, count: int) -> Beams:
    """Return some of the readings, spread over all."""
    total = len(beams.x)
    return beams if total <= count else beams.some(np.linspace(0, total - 1, count).astype(int))


def different_places(poses: Array, scores: Array, most: int) -> Any:
    """Return the best pose of each place, the best first, and their scores. At most `most` of them."""
    kept: List[int] = []
    for number in np.argsort(-scores):
        if all(not same_place(poses[number], poses[other]) for other in kept):
            kept.append(number)
        if len(kept) == most:
            break
    return poses[kept], scores[kept]


def same_place(one: Array, other: Array) -> bool:
    """Return whether two poses (x, y, heading) are of one place."""
    turn = wrapped_angles(one[2] - other[2])
    return bool(np.hypot(one[0] - other[0], one[1] - other[1]) < SAME_PLACE and abs(turn) < SAME_HEADING)


def _best(poses: Array, scores: Array, count: int) -> Any:
    if len(scores) <= count:
        return poses, scores
    kept = np.argpartition(-scores, count)[:count]
    return poses[kept], scores[kept]
