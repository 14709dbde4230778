"""The range that sonar measures: the distance to the nearest point of anything solid in a cone.

Lengths are in metres, all coordinates in the map frame. A cone is given by the unit vectors along its right edge and
its left edge, which are less than half a turn apart. Ranges are computed with ``+ - * / sqrt`` and comparisons only,
so that they are the same on every computer.
"""

import functools
import math
import struct
from typing import Any, Callable, Dict, Iterable, Iterator, Optional, Protocol

import numpy as np

from ...errors import UsageError
from .crowd import Candidate, Crowd, Obstacle
from .geometry import Array, Solids
from .poses import Point, unit

SQUARE = 1.0
"""Side (m) of a square of floor. The walls and posts that sonar can detect are computed once for each square."""
MOST_SQUARES = 4096
"""Squares of floor for which the walls and posts that sonar can detect are kept in memory."""
SECTORS = 32
"""Number of equal sectors of directions into which an `Earshot` sorts walls and posts."""
SECTORS_PER_RADIAN = SECTORS / (2.0 * math.pi)

_NUDGE = 1e-13  # m: a sensor exactly on a wall's line counts as this far beside it, so that the wall's end is detected
_SPARE = 1e-6  # m: added so that rounding does not drop a solid at the border of a sector

# Candidates kept as bytes need a fifth of the memory. With many robots, access to memory takes most of the time.
unpacked: Callable[[bytes], Iterator[Any]] = struct.Struct("6d").iter_unpack
"""Function that returns each `Candidate` of packed candidates."""


class Surroundings(Protocol):
    """What an `Ear` needs of a `World`: its bodies, and its walls and posts."""

    crowd: Crowd
    solids: Solids


class Ear:
    """Computes the ranges of sonar transducers with equal cones in one world.

    Args:
        world: the world whose walls, posts and robots the sonar detects.
        half_width: angle (rad) between the axis of a cone and its edge, above 0 and at most pi / 4.
        maximum: longest range (m).

    Raises:
        UsageError: `half_width` is not above 0, or is more than pi / 4.
    """

    def __init__(self, world: Surroundings, half_width: float, maximum: float):
        if not 0.0 < half_width <= math.pi / 4.0:
            raise UsageError("half_width %r rad: a sonar cone's must be above 0 and at most pi / 4" % half_width)
        self._world, self._maximum = world, maximum
        self._solids = world.solids
        borders = [2.0 * math.pi / SECTORS * key for key in range(SECTORS)]
        self._rights = np.array([unit(border - half_width) for border in borders])
        self._lefts = np.array([unit(border + 2.0 * math.pi / SECTORS + half_width) for border in borders])
        self._earshot = functools.lru_cache(MOST_SQUARES)(self._listen)
        nothing = Solids(np.empty((0, 4)), np.empty((0, 3)))
        # one for all squares where no wall or post can be detected
        self._silence = Earshot(nothing, 0.0, 0.0, 0.0, self._rights, self._lefts)

    def echo(
        self, x: float, y: float, heading: float, right: Point, left: Point, listener: Optional[Obstacle] = None,
    ) -> float:
        """Return the distance (m) from a transducer to the nearest wall, post or other robot in its cone.

        The distance is exact, not sampled by rays. Nothing can hide the nearest point, so no test for hidden points
        is needed. Cans are too low to be detected.

        Args:
            x: x of the transducer (m, map frame).
            y: y of the transducer (m, map frame).
            heading: direction of the cone's axis (rad, map frame).
            right: unit vector along the right edge of the cone.
            left: unit vector along the left edge of the cone.
            listener: body that carries the transducer. The transducer does not detect it.

        Returns:
            The distance, at most the maximum range; 0 inside a post.
        """
        earshot = self._earshot(math.floor(x / SQUARE), math.floor(y / SQUARE))
        candidates = earshot[math.floor(heading * SECTORS_PER_RADIAN) % SECTORS]
        nearest = self._maximum
        if candidates:
            nearest = echo(unpacked(candidates), x, y, right, left, nearest)
        others = self._world.crowd.near(x, y, nearest, listener)
        if others:
            room = nearest + self._world.crowd.reach
            right_x, right_y = right
            left_x, left_y = left
            for body in others:
                to_x, to_y, _ = body.pose
                to_x -= x
                to_y -= y
                reach = body.reach
                if right_y * to_x - right_x * to_y > reach or left_x * to_y - left_y * to_x > reach:
                    continue    # the body is beside the cone: the usual case
                if (to_x * to_x + to_y * to_y < room * room and body is not listener
                        and disc_echo(to_x, to_y, reach, right, left) < nearest):
                    nearest = echo(body.candidates, x, y, right, left, nearest)
        return nearest

    def _candidates(self, x: float, y: float, heading: float) -> bytes:
        """Return the walls and posts that a transducer at (x, y) may detect, packed and sorted by least distance."""
        return self._earshot(math.floor(x / SQUARE), math.floor(y / SQUARE))[
            math.floor(heading * SECTORS_PER_RADIAN) % SECTORS]

    def _listen(self, column: int, row: int) -> "Earshot":
        """Compute the `Earshot` of the square of floor in this column and row. The results are cached."""
        x, y, spread = (column + 0.5) * SQUARE, (row + 0.5) * SQUARE, SQUARE * 0.7072
        solids = self._solids.within(x, y, self._maximum + spread)
        return Earshot(solids, x, y, spread, self._rights, self._lefts) if len(solids) else self._silence


class Earshot(Dict[int, bytes]):
    """The walls and posts that sonar can detect from a small square of floor, by sector, for cones of one width.

    A key is the number of the sector that contains the axis of a cone. The value holds all walls and posts that such
    a cone can contain, and some that it cannot contain, as packed bytes: one `Candidate` for each, sorted by least
    distance. A value is computed at the first access.

    Args:
        solids: all walls and posts within the sonar's maximum of any point of the square, and maybe more.
        x: x of the middle of the square (m, map frame).
        y: y of the middle of the square (m, map frame).
        spread: distance (m) from the middle of the square to its corners.
        rights: array (sectors, 2): unit vector along the rightmost edge of all cones of each sector.
        lefts: array (sectors, 2): unit vector along the leftmost edge of all cones of each sector.
    """

    def __init__(self, solids: Solids, x: float, y: float, spread: float, rights: Array, lefts: Array):
        super().__init__()
        walls, posts = solids.distances(np.array(x), np.array(y))
        least = np.concatenate((walls, posts)) - (spread + _SPARE)
        order = np.argsort(least, kind="stable")
        posts = np.vstack((solids.posts.T, np.zeros(len(solids.posts)), np.full(len(solids.posts), -1.0)))
        self._candidates = np.vstack((least, np.hstack((solids.frames, posts)))).T[order]
        self._audible = audible(solids, x, y, spread + _SPARE, rights, lefts)[:, order]

    def __missing__(self, sector: int) -> bytes:
        self[sector] = self._candidates[self._audible[sector]].tobytes()
        return self[sector]


def audible(solids: Solids, x: float, y: float, spread: float, rights: Array, lefts: Array) -> Array:
    """Return an array (sectors, solids) that is False where no cone of a sector can contain a point of a solid.

    True means that a cone may contain a point of the solid. For the arguments see `Earshot`; there may be any number of
    sectors.
    """
    ends_x = np.concatenate((solids.walls[:, 0::2].T, np.tile(solids.posts[:, 0], (2, 1))), axis=1) - x
    ends_y = np.concatenate((solids.walls[:, 1::2].T, np.tile(solids.posts[:, 1], (2, 1))), axis=1) - y
    room = np.concatenate((np.zeros(len(solids.walls)), solids.posts[:, 2])) + spread
    found = np.ones((len(rights), len(solids)), dtype=bool)
    for edges, side in ((rights, 1.0), (lefts, -1.0)):
        edge_x, edge_y = edges.T[:, :, None]
        inside = side * (edge_x * ends_y[0] - edge_y * ends_x[0]), side * (edge_x * ends_y[1] - edge_y * ends_x[1])
        found &= np.maximum(*inside) >= -room
    return found


def echo(
    candidates: Iterable[Candidate], x: float, y: float, right: Point, left: Point, maximum: float,
) -> float:
    """Return the distance (m) from a sensor at (x, y) to the nearest candidate in its cone.

    Args:
        candidates: walls and posts, sorted by least distance.
        x: x of the sensor (m, map frame).
        y: y of the sensor (m, map frame).
        right: unit vector along the right edge of the cone.
        left: unit vector along the left edge of the cone.
        maximum: longest range (m).

    Returns:
        The distance, at most `maximum`; 0 inside a post.
    """
    right_x, right_y = right
    left_x, left_y = left
    nearest = maximum
    for least, at_x, at_y, ux, uy, length in candidates:
        if least >= nearest:
            break
        at_x -= x
        at_y -= y
        if length < 0.0:
            nearest = min(nearest, disc_echo(at_x, at_y, ux, right, left))
            continue
        aside = at_x * uy - at_y * ux
        if aside >= nearest or -aside >= nearest:
            continue
        # Along a wall `t` counts from the foot of the perpendicular, which is `aside` away. An edge of the cone that
        # leads towards the wall's line cuts it at one t. An edge that leads away cuts it at an infinite t.
        beside = aside + _NUDGE
        along, across = right_x * ux + right_y * uy, right_x * uy - right_y * ux
        facing = across * beside > 0.0
        cut = beside * along / across if facing else math.copysign(math.inf, along)
        along, across = left_x * ux + left_y * uy, left_x * uy - left_y * ux
        if across * beside > 0.0:
            other_cut = beside * along / across
        elif facing:
            other_cut = math.copysign(math.inf, along)
        else:
            continue
        if cut > other_cut:
            cut, other_cut = other_cut, cut
        low = at_x * ux + at_y * uy
        high = low + length
        if cut > low:
            low = cut
        if other_cut < high:
            high = other_cut
        if low > high:
            continue
        t = low if low > 0.0 else -high if high < 0.0 else 0.0
        squared = aside * aside + t * t
        if squared < nearest * nearest:
            nearest = math.sqrt(squared)
    return nearest


def disc_echo(x: float, y: float, radius: float, right: Point, left: Point) -> float:
    """Return the distance (m) from the origin to the nearest point of a disc that lies in a cone at the origin.

    If the middle of the disc is in the cone, the nearest point lies on the line to the middle. If not, the nearest
    point is where an edge of the cone enters the disc.

    Args:
        x: x of the middle of the disc (m).
        y: y of the middle of the disc (m).
        radius: radius of the disc (m).
        right: unit vector along the right edge of the cone.
        left: unit vector along the left edge of the cone.

    Returns:
        The distance; 0 when the origin is inside the disc, infinity when no point of the disc is in the cone.
    """
    distance = math.sqrt(x * x + y * y)
    if distance <= radius:
        return 0.0
    right_x, right_y = right
    left_x, left_y = left
    beyond_right, beyond_left = right_y * x - right_x * y, left_x * y - left_y * x
    if beyond_right <= 0.0 and beyond_left <= 0.0:
        return distance - radius
    nearest = math.inf
    for (edge_x, edge_y), outside in ((right, beyond_right), (left, beyond_left)):
        ahead = edge_x * x + edge_y * y
        if 0.0 < outside <= radius and ahead > 0.0:
            nearest = min(nearest, ahead - math.sqrt(radius * radius - outside * outside))
    return nearest
