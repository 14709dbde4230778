"""Where a stretch of path lies on a map: all poses near a guess are tried, and the likely ones averaged.

For each reading, the range that is expected at a pose is the distance of the nearest wall in the cone. A reading fits
when it is about that. Readings near which the map has no wall say nothing.
"""

import math
from typing import Any, NamedTuple, Optional, Tuple

import numpy as np

from ..floor_poses import Pose, wrapped
from .sonar_grid import SonarBeams
from .tuned import MatchNumbers

Array = Any     # of numpy


_FAR = 1e3
"""A distance (m) that stands for "nothing there"; points that fill up lie farther."""
_FEW = 16
"""Poses whose scores are computed at once."""


class Match(NamedTuple):
    """Where a stretch lies.

    `pose` is that of its begin, `covariance` (3 x 3; m, m, rad) how sure that is. `fit` is the share of readings that
    fit, of those that say something; `said` how many these are. `hits` (n, 2) are the points (m) of the map's walls
    that were heard.
    """

    pose: Pose
    covariance: Array
    fit: float
    said: int
    hits: Array


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
    coarse = _tried(guess, middle, reach, numbers.step, turn, numbers.turn_step)
    weights, best = _weights(_scores(points, beams, coarse, numbers), numbers.trust)
    wide = _spread(coarse, weights)[1]
    fine = _tried(Pose(*coarse[best]), middle, numbers.step * 0.75, numbers.step / 4.0, numbers.turn_step,
                  numbers.turn_step / 3.0)
    weights, _ = _weights(_scores(points, beams, fine, numbers), numbers.trust)
    mean, narrow = _spread(fine, weights)
    pose = Pose(float(mean[0]), float(mean[1]), wrapped(float(mean[2])))
    distance = _distances(points, beams, np.array([pose]), numbers)[0]
    nearest = distance.argmin(axis=1)
    index = np.arange(len(nearest))
    fits = np.abs(distance[index, nearest] - beams.range) < 2.0 * numbers.blur
    return Match(pose, wide + narrow, float(fits.mean()), len(fits), points[index, nearest][fits].astype(float))


def _near(walls: Array, beams: SonarBeams, reach: float, turn: float, numbers: MatchNumbers) -> Tuple[Array, Array]:
    """Return the points of walls that each beam may hear, array (beams, points, 2), of those beams that may hear any,
    and the indices of these beams. Points far away fill up.
    """
    way_x, way_y = walls[:, 0] - beams.x[:, None], walls[:, 1] - beams.y[:, None]
    distance = np.hypot(way_x, way_y)
    off = np.abs(np.remainder(np.arctan2(way_y, way_x) - beams.heading[:, None] + np.pi, 2.0 * np.pi) - np.pi)
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


def _tried(guess: Pose, middle: Array, reach: float, step: float, turn: float, turn_step: float) -> Array:
    """Return poses round a guess, as an array (n, 3). They are turned round `middle`, a point in the guess's frame."""
    shifts = np.arange(-round(reach / step), round(reach / step) + 1) * step
    turns = np.arange(-round(turn / turn_step), round(turn / turn_step) + 1) * turn_step
    x, y, turned = (each.ravel() for each in np.meshgrid(shifts, shifts, turns, indexing="ij"))
    heading = guess.heading + turned
    at = (math.cos(guess.heading) * middle[0] - math.sin(guess.heading) * middle[1],
          math.sin(guess.heading) * middle[0] + math.cos(guess.heading) * middle[1])
    return np.stack((guess.x + x + at[0] - np.cos(heading) * middle[0] + np.sin(heading) * middle[1],
                     guess.y + y + at[1] - np.sin(heading) * middle[0] - np.cos(heading) * middle[1], heading), axis=1)


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
    """Return the log-likelihood of the readings for each pose."""
    # Few poses at a time: what is in the cache of the processor is worked on three times as fast.
    return np.concatenate([_scores_of_few(points, beams, poses[first:first + _FEW], numbers)
                           for first in range(0, len(poses), _FEW)])


def _scores_of_few(points: Array, beams: SonarBeams, poses: Array, numbers: MatchNumbers) -> Array:
    expected = _distances(points, beams, poses, numbers).min(axis=2)
    fit = np.exp(-0.5 * np.minimum(np.abs(expected - beams.range) / numbers.blur, 9.0) ** 2)
    # Where no wall is known, a reading must not draw the stretch to where one is.
    fit[expected > _FAR] = numbers.neutral
    return np.log(numbers.miss + fit).sum(axis=1)


def _weights(scores: Array, trust: float) -> Any:
    """Return the probability of each pose, and the index of the best."""
    best = int(scores.argmax())
    weights = np.exp(trust * (scores - scores[best]).astype(float))
    return weights / weights.sum(), best


def _spread(poses: Array, weights: Array) -> Any:
    """Return mean and covariance of weighted poses."""
    mean = (weights[:, None] * poses).sum(axis=0)
    off = poses - mean
    return mean, np.einsum("n,ni,nj->ij", weights, off, off)
