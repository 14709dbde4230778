"""Straight walls that a robot heard beside its way: where they face, and whether they are square to each other.

A wall that is heard from two places tells its direction by how the range changes. So one stretch of path tells it to
about a degree, whatever part of the wall was heard. In most buildings most walls are square to each other: then each of
them tells the robot's heading, also walls that it never heard before.
"""

import math
from typing import Any, List, NamedTuple, Optional, Tuple

import numpy as np

from ..robots import HALF_CONE
from .frames import wrapped_angles
from .sonar_grid import SonarBeams
from .tuned import WallNumbers

Array = Any     # of numpy

_TRIED = np.radians(np.arange(0.0, 360.0, 3.0))
"""Directions (rad) that are tried first."""
_ROUNDS = 4
"""How often a direction is fitted; then the readings that fit change no more."""
_MOST_TURN = 0.05
"""How far (rad) a round may turn it."""
_FINEST = 0.01
"""A reading deviates from a wall by as much (m) at least."""
_RIGHT_ANGLE = math.pi / 2.0


class WallDirection(NamedTuple):
    """Where a wall faces.

    Attributes:
        heading: direction (rad) of the shortest way to the wall, in the frame of the beams.
        deviation: standard deviation of it (rad).
    """

    heading: float
    deviation: float


class SquareWalls(NamedTuple):
    """Walls that are square to each other.

    Attributes:
        which: mask of these walls.
        off: how far (rad) each of these is turned from where they are on average.
        weights: inverse of the standard deviation of each (1/rad).
    """

    which: Array
    off: Array
    weights: Array


def wall_directions(beams: SonarBeams, numbers: WallNumbers) -> List[WallDirection]:
    """Return where the straight walls face that some beams heard, first the wall that most of them heard."""
    beams = beams.chosen(beams.range < numbers.reach)
    walls: List[WallDirection] = []
    for _ in range(int(numbers.most)):
        found = _best(beams, numbers)
        if found is None:
            break
        heading, fits = found
        along = _along(beams, heading)[fits]
        if np.ptp(along) >= numbers.span and abs(_bend(beams.chosen(fits), heading)) < numbers.bend:
            off = max(float(_to_wall(beams, heading)[fits].std()), _FINEST)
            walls.append(WallDirection(heading, off / (float(along.std()) * math.sqrt(len(along)))))
        beams = beams.chosen(~fits)
    return walls


def square_walls(headings: Array, deviations: Array, numbers: WallNumbers) -> Optional[SquareWalls]:
    """Return the walls that are square to each other, or None where these are too few, or too few of all walls.

    Args:
        headings: where the walls face (rad), all in one frame.
        deviations: standard deviations (rad) of these.
        numbers: how it is judged.
    """
    if len(headings) < numbers.least_walls:
        return None
    weights = 1.0 / (deviations ** 2 + numbers.slack ** 2)
    agree = np.abs(_off_square(headings[:, None] - headings)) < numbers.square
    votes = agree @ weights
    best = int(votes.argmax())
    if votes[best] < numbers.share * weights.sum():
        return None
    off = _off_square(headings - headings[best])
    off = _off_square(off - np.average(off[agree[best]], weights=weights[agree[best]]))
    which = np.abs(off) < numbers.square
    if which.sum() < numbers.least_walls:
        return None
    return SquareWalls(which, off[which], np.sqrt(weights[which]))


def _off_square(angles: Array) -> Array:
    """Return how far angles (rad) are from a multiple of a right angle."""
    return np.remainder(angles + _RIGHT_ANGLE / 2.0, _RIGHT_ANGLE) - _RIGHT_ANGLE / 2.0


def _best(beams: SonarBeams, numbers: WallNumbers) -> Optional[Tuple[float, Array]]:
    """Return where the wall faces that most of the beams heard, and a mask of these beams; None if too few heard it."""
    if len(beams.x) < numbers.least:
        return None
    heading, distance = _guess(beams, numbers)
    for number in range(_ROUNDS):
        near = numbers.band if number < _ROUNDS / 2 else 0.75 * numbers.band
        off = _to_wall(beams, heading) - distance
        fits = _hears(beams, heading) & (np.abs(off) < near)
        if fits.sum() < numbers.least:
            return None
        along = _along(beams, heading)[fits]
        along -= along.mean()
        turn = -float((along * off[fits]).sum()) / max(float((along ** 2).sum()), 1e-3)
        heading += min(max(turn, -_MOST_TURN), _MOST_TURN)
        distance = float(_to_wall(beams, heading)[fits].mean())
    return heading, fits


def _guess(beams: SonarBeams, numbers: WallNumbers) -> Tuple[float, float]:
    """Return of the directions that are tried the one on which most beams agree, and how far (m) the wall is from the
    origin.
    """
    distances = np.stack([_to_wall(beams, heading) for heading in _TRIED])
    hears = np.stack([_hears(beams, heading) for heading in _TRIED])
    best, distance = most_agree(distances, hears, numbers.band)
    return float(_TRIED[best]), distance


def most_agree(distances: Array, counts: Array, band: float) -> Tuple[int, float]:
    """Return the direction on which most readings or places agree, as its row, and how far (m) the wall is that way.

    Args:
        distances: a row for each direction: how far (m) the wall is by each of them, if it faces there.
        counts: mask of those that count.
        band: they agree when they are so near to each other (m).
    """
    first = float(distances.min())
    bins = np.floor((distances - first) / band).astype(int)
    width = int(bins.max()) + 2
    row, _ = np.nonzero(counts)
    votes = np.bincount(row * width + bins[counts], minlength=len(distances) * width).reshape(len(distances), width)
    votes = votes[:, :-1] + votes[:, 1:]        # a wall may lie on the border of two
    best, number = np.unravel_index(int(votes.argmax()), votes.shape)
    return int(best), first + (float(number) + 1.0) * band


def _bend(beams: SonarBeams, heading: float) -> float:
    """Return how bent a wall is by the beams that heard it. 0: straight. 1: all heard one point, as a post or an edge.

    With 2 cm of noise in the ranges, 93 % of the walls of a classroom are bent by less than 0.3, and 25 % of its posts.
    """
    along = _along(beams, heading)
    along -= along.mean()
    terms = np.stack((np.ones(len(along)), along, along ** 2 / (2.0 * beams.range)), axis=1)
    return float(np.linalg.lstsq(terms, _to_wall(beams, heading), rcond=None)[0][2])


def _hears(beams: SonarBeams, heading: float) -> Array:
    """Return a mask of the beams whose cone has a direction in it: a wall that faces there answers from there."""
    return np.abs(wrapped_angles(beams.heading - heading)) < HALF_CONE


def _to_wall(beams: SonarBeams, heading: float) -> Array:
    """Return how far (m) from the origin a wall is by each beam, if it faces there."""
    return beams.range + beams.x * math.cos(heading) + beams.y * math.sin(heading)


def _along(beams: SonarBeams, heading: float) -> Array:
    """Return where along the wall (m) each beam heard it."""
    return beams.y * math.cos(heading) - beams.x * math.sin(heading)
