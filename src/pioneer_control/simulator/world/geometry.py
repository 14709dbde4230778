"""Exact plane geometry of the simulated robot: outlines and points against walls and posts.

Lengths are metres, angles radians, all coordinates in the map frame. Arrays see only ``+ - * / sqrt``, comparisons,
``min`` and ``max``, which IEEE 754 rounds the same everywhere: the same world and pose give the same bytes with every
numpy.
"""

import math
from typing import Any, Iterator, List, NamedTuple, Optional, Sequence, Tuple, Union

import numpy as np

from .trigonometry import hypot

Array = Union["np.ndarray[Any, Any]"]
"""An array of numpy; its shape is said where it is used."""
Point = Tuple[float, float]
Pose = Tuple[float, float, float]
"""x, y, heading (counter-clockwise from x)."""
TOUCH = 1e-5
"""Overlaps smaller than this (m) are contacts, not overlaps."""


class Solids:
    """Walls and posts, laid out for fast questions: all that sonar sees and a body bumps into.

    Args:
        walls: (n, 4) array, one segment ``x1 y1 x2 y2`` a row, none of length zero.
        posts: (m, 3) array, one disc ``x y radius`` a row.
        frames: start, unit vector and length of each wall, in rows, where they are known; worked out if None.
    """

    def __init__(self, walls: Array, posts: Array, frames: Optional[Array] = None):
        self.walls = walls
        self.posts = posts
        self.frames = _frames(walls) if frames is None else frames

    def __len__(self) -> int:
        return len(self.walls) + len(self.posts)

    def some(self, walls: Any, posts: Any) -> "Solids":
        """The walls and posts that two indices of arrays choose."""
        return Solids(self.walls[walls], self.posts[posts], self.frames[:, walls])

    def each(self) -> Iterator["Solids"]:
        """Every wall and every post alone."""
        yield from (self.some(slice(i, i + 1), slice(0)) for i in range(len(self.walls)))
        yield from (self.some(slice(0), slice(i, i + 1)) for i in range(len(self.posts)))

    def bounds(self) -> Tuple[float, float, float, float]:
        """Least x and y and greatest x and y of any of them, of which there is at least one."""
        x, y, radius = self.posts.T
        xs = np.concatenate((self.walls[:, 0], self.walls[:, 2], x - radius, x + radius))
        ys = np.concatenate((self.walls[:, 1], self.walls[:, 3], y - radius, y + radius))
        return float(xs.min()), float(ys.min()), float(xs.max()), float(ys.max())

    def within(self, x: float, y: float, reach: float) -> "Solids":
        """The walls and posts that come within `reach` of a point."""
        walls, posts = self.distances(np.array(x), np.array(y))
        return self.some(walls <= reach, posts <= reach)

    def distances(self, x: Array, y: Array) -> Tuple[Array, Array]:
        """From points to every wall (..., n) and to the rim of every post (..., m; negative inside a post)."""
        start_x, start_y, ux, uy, length = self.frames
        to_x, to_y = start_x - x[..., None], start_y - y[..., None]
        low, aside = to_x * ux + to_y * uy, to_x * uy - to_y * ux
        beyond = np.maximum(np.maximum(low, -low - length), 0.0)
        post_x, post_y, radius = self.posts.T
        to_x, to_y = post_x - x[..., None], post_y - y[..., None]
        return np.sqrt(aside * aside + beyond * beyond), np.sqrt(to_x * to_x + to_y * to_y) - radius

    def nearest(self, x: float, y: float) -> float:
        """Distance from a point to the nearest solid: infinite where there is none, 0 inside a post.

        Plain loops, for few solids.
        """
        walls = (_from_origin(x1 - x, y1 - y, x2 - x, y2 - y) for x1, y1, x2, y2 in self.walls.tolist())
        posts = (hypot(px - x, py - y) - radius for px, py, radius in self.posts.tolist())
        return max(min(min(walls, default=math.inf), min(posts, default=math.inf)), 0.0)

    def overlap(self, outline: Sequence[Point], x: float, y: float, radius: float) -> bool:
        """Whether any wall or post has a point inside a polygon.

        Plain loops: where a body is, there are few solids, and arrays only pay for many.

        Args:
            outline: corners in order, either way round, convex or not.
            x: middle of a circle round the polygon, as `y` and its `radius`; saves work on solids outside it.
        """
        for start_x, start_y, ux, uy, length in self.frames.T.tolist():
            to_x, to_y = start_x - x, start_y - y
            low = to_x * ux + to_y * uy
            if abs(to_x * uy - to_y * ux) <= radius and -length - radius <= low <= radius:
                in_frame = [((px - start_x) * ux + (py - start_y) * uy, (py - start_y) * ux - (px - start_x) * uy)
                            for px, py in outline]
                if _crosses_axis(in_frame, length):
                    return True
        return any(_meets_disc(outline, *post) for post in self.posts.tolist())


def _frames(walls: Array) -> Array:
    """Start, unit vector and length of walls, in rows."""
    along_x, along_y = walls[:, 2] - walls[:, 0], walls[:, 3] - walls[:, 1]
    length = np.sqrt(along_x * along_x + along_y * along_y)
    return np.array([walls[:, 0], walls[:, 1], along_x / length, along_y / length, length])


class Finder:
    """Finds the few solids round a point among many: they are listed by squares of floor, once.

    Each is listed by points so dense that none of its own is farther than a quarter of a square's side from the next
    of them.
    """

    def __init__(self, solids: Solids):
        self._solids = solids
        lengths = solids.frames[4]
        self._side = max(2.0, float(lengths.max(initial=0.0)) * len(lengths) / 1e6)  # a few million points at most
        owners, x, y = [np.concatenate(parts) for parts in zip(self._points_of_walls(), self._points_of_posts())]
        columns, rows = np.floor(x / self._side).astype(np.int64), np.floor(y / self._side).astype(np.int64)
        self._low = (int(columns.min(initial=0)), int(rows.min(initial=0)))
        self._high = (int(columns.max(initial=0)), int(rows.max(initial=0)))
        squares = self._number(columns, rows)
        order = np.argsort(squares, kind="stable")
        self._squares, self._owners = squares[order], owners[order]

    def within(self, x: float, y: float, reach: float) -> Solids:
        """The solids that come within `reach` of a point."""
        wide = reach + self._side / 4.0
        (low_column, high_column), (low_row, high_row) = [
            (max(low, math.floor((at - wide) / self._side)), min(high, math.floor((at + wide) / self._side)))
            for at, low, high in zip((x, y), self._low, self._high)
        ]
        rows = np.arange(low_row, high_row + 1)
        begins: Array = np.searchsorted(self._squares, self._number(low_column, rows))
        ends: Array = np.searchsorted(self._squares, self._number(high_column, rows), side="right")
        owners = [self._owners[begin:end] for begin, end in zip(begins.tolist(), ends.tolist())]
        found = np.unique(np.concatenate(owners)) if owners and low_column <= high_column else np.empty(0, dtype=int)
        walls = len(self._solids.walls)
        return self._solids.some(found[found < walls], found[found >= walls] - walls).within(x, y, reach)

    def _number(self, column: Any, row: Any) -> Any:
        """Numbers of squares, row by row, from their columns and rows: numbers or arrays of them."""
        return (row - self._low[1]) * (self._high[0] - self._low[0] + 1) + column - self._low[0]

    def _points_of_walls(self) -> Tuple[Array, Array, Array]:
        """Number of the solid, x and y of every point."""
        steps = np.ceil(self._solids.frames[4] / (self._side / 2.0)).astype(int)
        owners = np.repeat(np.arange(len(steps)), steps + 1)
        first = np.cumsum(steps + 1) - (steps + 1)
        share = (np.arange(len(owners)) - first[owners]) / steps[owners]
        x1, y1, x2, y2 = self._solids.walls[owners].T
        return owners, x1 + (x2 - x1) * share, y1 + (y2 - y1) * share

    def _points_of_posts(self) -> Tuple[Array, Array, Array]:
        """The same: of a small post its middle, of a large one a lattice over it."""
        points = []
        for owner, (x, y, radius) in enumerate(self._solids.posts.tolist(), len(self._solids.walls)):
            reach = math.ceil(radius / (0.35 * self._side)) if radius > self._side / 4.0 else 0
            steps = [radius * step / reach for step in range(-reach, reach + 1)] if reach else [0.0]
            points += [(owner, x + right, y + up) for right in steps for up in steps]
        columns = np.array(points).reshape(-1, 3).T
        return columns[0].astype(int), columns[1], columns[2]


class Block(NamedTuple):
    """A rectangle of the robot that pushes cans: bounds in base_link (m)."""

    low_x: float
    high_x: float
    low_y: float
    high_y: float

    @property
    def reach(self) -> float:
        """How far (m) its farthest corner is from the robot's middle."""
        return hypot(max(-self.low_x, self.high_x), max(-self.low_y, self.high_y))

    def push(self, x: float, y: float, radius: float) -> Optional[Point]:
        """The new place (base_link) of a disc that overlaps this block; None when it does not overlap."""
        near_x = max(self.low_x, min(self.high_x, x))
        near_y = max(self.low_y, min(self.high_y, y))
        away_x, away_y = x - near_x, y - near_y
        distance = math.sqrt(away_x * away_x + away_y * away_y)
        if distance > radius - TOUCH:
            return None
        if distance > 0.0:
            scale = radius / distance
            return near_x + away_x * scale, near_y + away_y * scale
        ways_out = (
            (self.high_x - x, (self.high_x + radius, y)),
            (self.high_y - y, (x, self.high_y + radius)),
            (y - self.low_y, (x, self.low_y - radius)),
            (x - self.low_x, (self.low_x - radius, y)),
        )
        return min(ways_out, key=lambda way: way[0])[1]


def outlines_meet(first: Sequence[Point], second: Sequence[Point]) -> bool:
    """Whether two polygons share a point, also when one is wholly inside the other."""
    return _edge_inside(first, second) or _edge_inside(second, first)


def _edge_inside(outline: Sequence[Point], other: Sequence[Point]) -> bool:
    """Whether an edge of the other polygon has a point inside the first."""
    for (x1, y1), (x2, y2) in zip(other, [*other[1:], other[0]]):
        along_x, along_y = x2 - x1, y2 - y1
        length = hypot(along_x, along_y)
        ux, uy = along_x / length, along_y / length
        if _crosses_axis([((x - x1) * ux + (y - y1) * uy, (y - y1) * ux - (x - x1) * uy) for x, y in outline], length):
            return True
    return False


def _crosses_axis(outline: List[Point], length: float) -> bool:
    """Whether a polygon has a point of the x axis from 0 to `length` inside."""
    inside = False
    for (x1, y1), (x2, y2) in zip(outline, outline[1:] + outline[:1]):
        if (y1 > 0.0) != (y2 > 0.0):
            at = x1 + (x2 - x1) * (y1 / (y1 - y2))
            if 0.0 <= at <= length:
                return True
            inside ^= at > length
    return inside


def _meets_disc(outline: Sequence[Point], x: float, y: float, radius: float) -> bool:
    """Whether a polygon and a disc share a point."""
    centred = [(px - x, py - y) for px, py in outline]
    edges = zip(centred, centred[1:] + centred[:1])
    return any(_from_origin(*first, *second) <= radius for first, second in edges) or _crosses_axis(centred, 0.0)


def _from_origin(x1: float, y1: float, x2: float, y2: float) -> float:
    """Distance from the origin to a segment."""
    along_x, along_y = x2 - x1, y2 - y1
    squared = along_x * along_x + along_y * along_y
    share = min(max(-(x1 * along_x + y1 * along_y) / squared, 0.0), 1.0) if squared > 0.0 else 0.0
    return hypot(x1 + share * along_x, y1 + share * along_y)
