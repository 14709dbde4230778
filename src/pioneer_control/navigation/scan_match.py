"""Where a stretch of path lies on a map: poses near a guess are tried, and from the best one Newton's method goes on.

For each reading, the range that is expected at a pose is the distance of the nearest wall in the cone. A reading fits
when it is about that. Readings near which the map has no wall say nothing.

How sure a pose is, each reading tells by itself: its log-likelihood near the pose is fitted by a parabola. Readings of
a corridor's walls are curved across the corridor and flat along it, so they say nothing about the way along.
"""

import functools
import math
from typing import Any, NamedTuple, Optional, Tuple

import numpy as np

from ..floor_poses import Pose, wrapped
from .frames import wrapped_angles
from .sonar_grid import SonarBeams
from .tuned import MatchNumbers

Array = Any     # of numpy


_FAR = 1e3
"""A distance (m) that stands for "nothing there"; points that fill up lie farther."""
_FEW = 16
"""Poses whose scores are computed at once."""
_ROUNDS = 3
"""Steps of Newton's method."""
_HOLD = np.diag((100.0, 100.0, 400.0))
"""What holds the pose where no reading does: a deviation of 0.1 m, 0.1 m and 0.05 rad in each step."""
_FLAT = 1e-3
"""Where the readings curve less than this share of the most, they say nothing."""
_MOST_ALONE = 0.05
"""How far (m, rad) some of the readings alone may have the pose from where all have it."""


class Match(NamedTuple):
    """Where a stretch lies.

    Attributes:
        pose: of its begin (map frame).
        fit: share of the readings that fit, of those that say something.
        said: how many say something.
        hits: points (m) of the map's walls that were heard, one for each reading that fits, array (n, 2).
        curves: parabolas of these readings' log-likelihoods round `pose`, array (n, 10). See `_parabolas`.
        middle: point (m, map frame) round which the parabolas are turned.
    """

    pose: Pose
    fit: float
    said: int
    hits: Array
    curves: Array
    middle: Array

    def alone(self, which: Array) -> Tuple[Pose, Array]:
        """Return what some of the readings alone say about the pose.

        Args:
            which: mask or indices of these readings, of those that fit.

        Returns:
            Where they have the begin of the stretch, near `pose` (map frame), and the inverse (3 x 3) of the covariance
            (x, y (m), heading (rad)) of that. It is singular when they say nothing about a direction.
        """
        slope, bend = _slope_and_bend(self.curves[which].sum(axis=0))
        # The parabolas are turned round the middle, the pose round the begin.
        way_x, way_y = self.pose.x - self.middle[0], self.pose.y - self.middle[1]
        of_middle = np.array(((1.0, 0.0, way_y), (0.0, 1.0, -way_x), (0.0, 0.0, 1.0)))
        slope, bend = of_middle.T @ slope, of_middle.T @ bend @ of_middle
        values, vectors = np.linalg.eigh(bend)
        said = values > _FLAT * max(values[-1], 1.0)
        step = vectors[:, said] @ (vectors[:, said].T @ slope / values[said])
        x, y, heading = np.array(self.pose) + np.clip(step, -_MOST_ALONE, _MOST_ALONE)
        return Pose(float(x), float(y), wrapped(float(heading))), bend


def wall_points(odds: Array, row: int, column: int, resolution: float, least: float) -> Array:
    """Return points on the walls of a part of a map, finer than its cells: array (n, 2) of x, y (m).

    A wall that is several cells thick has its points where the odds are greatest.

    Args:
        odds: log-odds of the cells.
        row, column: the first of these, on the lattice of `sonar_grid`.
        resolution: side of a cell (m).
        least: log-odds from which a cell is a wall.
    """
    padded = np.pad(odds, 1)
    middle = padded[1:-1, 1:-1]
    west, east, south, north = padded[1:-1, :-2], padded[1:-1, 2:], padded[:-2, 1:-1], padded[2:, 1:-1]
    crest_x, crest_y = (middle >= west) & (middle > east), (middle >= south) & (middle > north)
    rows, columns = np.nonzero((middle > least) & (crest_x | crest_y))
    weights = np.maximum(padded, 0.0)
    shift_x, shift_y, total = np.zeros(len(rows)), np.zeros(len(rows)), np.zeros(len(rows))
    for up in (-1, 0, 1):
        for right in (-1, 0, 1):
            weight = weights[rows + 1 + up, columns + 1 + right]
            shift_x, shift_y, total = shift_x + right * weight, shift_y + up * weight, total + weight
    x = (column + columns + 0.5 + np.where(crest_x[rows, columns], shift_x / total, 0.0)) * resolution
    y = (row + rows + 0.5 + np.where(crest_y[rows, columns], shift_y / total, 0.0)) * resolution
    return np.stack((x, y), axis=1)


def match(walls: Array, beams: SonarBeams, guess: Pose, reach: float, turn: float,
          numbers: MatchNumbers) -> Optional[Match]:
    """Search for the pose of a stretch. None when no reading says anything.

    Args:
        walls: points (n, 2) on walls of the map (m).
        beams: readings of the stretch, all with echoes, relative to its begin.
        guess: pose of its begin.
        reach: how far from the guess poses are tried (m).
        turn: how far they are turned (rad).
        numbers: how it is judged.
    """
    points, which = _near(walls, beams.moved(*guess), reach, turn, numbers)
    beams = SonarBeams(*(each[which].astype(np.float32) for each in beams))
    if not len(beams.x):
        return None
    middle = np.array((beams.x.mean(), beams.y.mean()))
    # Newton's method finds by itself what is this near.
    pose = guess if reach <= 2.0 * numbers.step else _searched(points, beams, guess, middle, reach, turn, numbers)
    for _ in range(_ROUNDS):
        curves = _parabolas(points, beams, pose, middle, numbers)
        slope, bend = _slope_and_bend(curves.sum(axis=0))
        step = np.linalg.solve(bend + _HOLD, slope)
        limit = numbers.near, numbers.near, numbers.near_turn
        step = np.clip(step, np.negative(limit), limit)
        pose = Pose(*_moved(pose, middle, step[None])[0])
    curves[:, 1:4] -= _bends(curves) @ step     # the slopes at the pose
    distance = _distances(points, beams, np.array([pose]), numbers)[0]
    nearest = distance.argmin(axis=1)
    index = np.arange(len(nearest))
    fits = np.abs(distance[index, nearest] + numbers.nearer - beams.range) < 2.0 * numbers.blur
    return Match(Pose(float(pose.x), float(pose.y), wrapped(float(pose.heading))), float(fits.mean()), len(fits),
                 points[index, nearest][fits].astype(float), curves[fits], _moved_point(pose, middle))


def _searched(points: Array, beams: SonarBeams, guess: Pose, middle: Array, reach: float, turn: float,
              numbers: MatchNumbers) -> Pose:
    """Return the best of the poses round a guess; one far away must be better than one near."""
    shifts = np.arange(-round(reach / numbers.step), round(reach / numbers.step) + 1) * numbers.step
    turns = np.arange(-round(turn / numbers.turn_step), round(turn / numbers.turn_step) + 1) * numbers.turn_step
    steps = _all_of(shifts, shifts, turns)
    tried = _moved(guess, middle, steps)
    scores = _scores(points, beams, tried, numbers).sum(axis=1)
    scores -= numbers.edge * ((steps / (reach, reach, turn)) ** 2).sum(axis=1)
    return Pose(*tried[scores.argmax()])


def _parabolas(points: Array, beams: SonarBeams, pose: Pose, middle: Array, numbers: MatchNumbers) -> Array:
    """Return the parabola that fits the log-likelihood of each reading near a pose, array (readings, 10).

    It is of the steps x, y (m) of the middle and of the turn t (rad); its numbers are those of 1, x, y, t, x^2/2,
    y^2/2, t^2/2, xy, xt, yt.
    """
    steps, projection = _near_steps(numbers.near, numbers.near_turn)
    return (projection @ _scores(points, beams, _moved(pose, middle, steps), numbers)).T


@functools.lru_cache(maxsize=None)
def _near_steps(reach: float, turn: float) -> Tuple[Array, Array]:
    """Return steps (n, 3) round a pose, and the matrix (10, n) that fits a parabola to values there."""
    shares = np.linspace(-1.0, 1.0, 5)
    steps = _all_of(reach * shares, reach * shares, turn * shares)
    x, y, t = steps.T
    terms = (np.ones(len(steps)), x, y, t, x * x / 2.0, y * y / 2.0, t * t / 2.0, x * y, x * t, y * t)
    return steps, np.linalg.pinv(np.stack(terms, axis=1))


def _bends(curves: Array) -> Array:
    """Return how much parabolas curve downwards, array (n, 3, 3)."""
    _, _, _, _, xx, yy, tt, xy, xt, yt = -curves.T
    return np.stack((xx, xy, xt, xy, yy, yt, xt, yt, tt), axis=1).reshape(-1, 3, 3)


def _slope_and_bend(curve: Array) -> Tuple[Array, Array]:
    """Return the slope (3) of a parabola and how much it curves downwards (3 x 3), in no direction less than 0."""
    values, vectors = np.linalg.eigh(_bends(curve[None])[0])
    return curve[1:4], vectors @ np.diag(np.maximum(values, 0.0)) @ vectors.T


def _all_of(x: Array, y: Array, turn: Array) -> Array:
    """Return all steps of some shifts and turns, array (n, 3)."""
    return np.stack([each.ravel() for each in np.meshgrid(x, y, turn, indexing="ij")], axis=1)


def _moved(pose: Pose, middle: Array, steps: Array) -> Array:
    """Return a pose after each of some steps, array (n, 3): `middle`, a point in the pose's frame, is shifted (map
    frame), and all is turned round it.
    """
    heading = pose.heading + steps[:, 2]
    at = _moved_point(pose, middle)
    return np.stack((at[0] + steps[:, 0] - np.cos(heading) * middle[0] + np.sin(heading) * middle[1],
                     at[1] + steps[:, 1] - np.sin(heading) * middle[0] - np.cos(heading) * middle[1], heading), axis=1)


def _moved_point(pose: Pose, point: Array) -> Array:
    """Return where a point of a pose's frame is on the map."""
    cosine, sine = math.cos(pose.heading), math.sin(pose.heading)
    return np.array((pose.x + cosine * point[0] - sine * point[1], pose.y + sine * point[0] + cosine * point[1]))


def _near(walls: Array, beams: SonarBeams, reach: float, turn: float, numbers: MatchNumbers) -> Tuple[Array, Array]:
    """Return the points of walls that each beam may hear, array (beams, points, 2), of those beams that may hear any,
    and the indices of these beams. Points far away fill up.
    """
    way_x, way_y = walls[:, 0] - beams.x[:, None], walls[:, 1] - beams.y[:, None]
    distance = np.hypot(way_x, way_y)
    off = np.abs(wrapped_angles(np.arctan2(way_y, way_x) - beams.heading[:, None]))
    slack = reach + 3.0 * numbers.blur
    near = ((np.abs(distance - beams.range[:, None]) < slack)
            & (off < numbers.half_cone + turn + np.arcsin(np.minimum(reach / np.maximum(distance, 1e-3), 1.0))))
    cost = np.where(near, np.abs(distance - beams.range[:, None]), np.inf)
    count = min(int(numbers.points), cost.shape[1])
    which = np.nonzero(near.any(axis=1))[0]
    chosen = np.argsort(cost[which], axis=1, kind="stable")[:, :count]
    points = walls[chosen].astype(np.float32)
    points[~np.isfinite(np.take_along_axis(cost[which], chosen, axis=1))] = 1e4
    return points, which


def _distances(points: Array, beams: SonarBeams, poses: Array, numbers: MatchNumbers) -> Array:
    """Return the distance of the points of walls from the transducers, array (poses, beams, points). Outside of the
    cone it is great.
    """
    x, y, heading = (poses[:, axis, None].astype(np.float32) for axis in range(3))
    cosine, sine = np.cos(heading), np.sin(heading)
    way_x = points[:, :, 0] - (x + beams.x * cosine - beams.y * sine)[:, :, None]
    way_y = points[:, :, 1] - (y + beams.x * sine + beams.y * cosine)[:, :, None]
    direction = heading + beams.heading
    ahead = way_x * np.cos(direction)[:, :, None] + way_y * np.sin(direction)[:, :, None]
    distance = np.sqrt(way_x * way_x + way_y * way_y)
    distance[ahead < math.cos(numbers.half_cone) * distance] = 1e4
    return distance


def _scores(points: Array, beams: SonarBeams, poses: Array, numbers: MatchNumbers) -> Array:
    """Return the log-likelihood of each reading at each pose, array (poses, beams)."""
    # Few poses at a time: what is in the cache of the processor is worked on three times as fast.
    return np.concatenate([_scores_of_few(points, beams, poses[first:first + _FEW], numbers)
                           for first in range(0, len(poses), _FEW)])


def _scores_of_few(points: Array, beams: SonarBeams, poses: Array, numbers: MatchNumbers) -> Array:
    expected = _distances(points, beams, poses, numbers).min(axis=2) + np.float32(numbers.nearer)
    fit = np.exp(-0.5 * np.minimum(np.abs(expected - beams.range) / numbers.blur, 9.0) ** 2)
    # Where no wall is known, a reading must not draw the stretch to where one is.
    fit[expected > _FAR] = numbers.neutral
    return numbers.trust * np.log(numbers.miss + fit)
