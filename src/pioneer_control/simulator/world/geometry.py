"""Exact plane geometry: tests and distances between outlines or points and walls or posts.

Lengths are in metres, angles in radians, all coordinates in the map frame. Arrays are used only with ``+ - * / sqrt``,
comparisons, ``min`` and ``max``. IEEE 754 rounds these the same everywhere, so the same world and pose give the same
bytes with every version of numpy.
"""

import math
from typing import Any, Iterator, List, NamedTuple, Optional, Sequence, Tuple, Union

import numpy as np

from .poses import Point, hypot

Array = Union["np.ndarray[Any, Any]"]
"""A numpy array. Its shape is documented where it is used."""
TOUCH = 1e-5
"""Depth (m) up to which two overlapping shapes count as touching, not as overlapping."""


class Solids:
    """Walls and posts in arrays for fast computation. Sonar detects them, and they stop a body.

    Args:
        walls: (n, 4) array, one segment ``x1 y1 x2 y2`` (m) per row, none of length zero.
        posts: (m, 3) array, one disc ``x y radius`` (m) per row.
        materials: the `Material` of each wall, then of each post, as an array of integers. None: all are plain.

    Attributes:
        walls, posts, materials: as the arguments.
        frames: (5, n) array: x and y of the start, x and y of the unit vector, and length of each wall (m).
    """

    def __init__(self, walls: Array, posts: Array, materials: Optional[Array] = None):
        self.walls, self.posts = walls, posts
        self.materials: Array = np.zeros(len(self), dtype=int) if materials is None else materials
        along_x, along_y = walls[:, 2] - walls[:, 0], walls[:, 3] - walls[:, 1]
        length = np.sqrt(along_x * along_x + along_y * along_y)
        self.frames = np.array([walls[:, 0], walls[:, 1], along_x / length, along_y / length, length])

    def __len__(self) -> int:
        return len(self.walls) + len(self.posts)

    def some(self, walls: Any, posts: Any) -> "Solids":
        """Return only the walls and posts that the two numpy indices select."""
        of_walls, of_posts = self.materials[:len(self.walls)], self.materials[len(self.walls):]
        return Solids(self.walls[walls], self.posts[posts], np.concatenate((of_walls[walls], of_posts[posts])))

    def each(self) -> Iterator["Solids"]:
        """Yield every wall, then every post, each as a `Solids` of its own."""
        yield from (self.some(slice(i, i + 1), slice(0)) for i in range(len(self.walls)))
        yield from (self.some(slice(0), slice(i, i + 1)) for i in range(len(self.posts)))

    def corners(self) -> Array:
        """Return points (k, 2) that have the same bounds as all walls and posts (m, map frame)."""
        middles, radii = self.posts[:, :2], self.posts[:, 2:]
        return np.concatenate((self.walls[:, :2], self.walls[:, 2:], middles - radii, middles + radii))

    def within(self, x: float, y: float, reach: float) -> "Solids":
        """Return the walls and posts that have a point within `reach` (m) of (x, y) (m, map frame)."""
        walls, posts = self.distances(np.array(x), np.array(y))
        return self.some(walls <= reach, posts <= reach)

    def distances(self, x: Array, y: Array) -> Tuple[Array, Array]:
        """Return the distances (m) from each point to every wall and to the rim of every post.

        Args:
            x: x of the points (m, map frame), an array of any shape.
            y: y of the points, an array of the same shape, or of one that broadcasts with it.

        Returns:
            Distances to the walls (..., n) and to the posts (..., m). The distance to a post is negative inside it.
        """
        start_x, start_y, ux, uy, length = self.frames
        to_x, to_y = start_x - x[..., None], start_y - y[..., None]
        low, aside = to_x * ux + to_y * uy, to_x * uy - to_y * ux
        beyond = np.maximum(np.maximum(low, -low - length), 0.0)
        post_x, post_y, radius = self.posts.T
        to_x, to_y = post_x - x[..., None], post_y - y[..., None]
        return np.sqrt(aside * aside + beyond * beyond), np.sqrt(to_x * to_x + to_y * to_y) - radius

    def clearances(self, column_x: Array, row_y: Array, limit: float) -> Array:
        """Return the distance (m) to the nearest wall or post from every point of a grid. See `World.clearances`."""
        grid = np.full((len(row_y), len(column_x)), limit)
        for solid in self.each():
            corners = solid.corners()
            (low_x, low_y), (high_x, high_y) = corners.min(axis=0), corners.max(axis=0)
            columns = slice(*np.searchsorted(column_x, (low_x - limit, high_x + limit)))
            rows = slice(*np.searchsorted(row_y, (low_y - limit, high_y + limit)))
            for distances in solid.distances(column_x[None, columns], row_y[rows, None]):
                nearest = np.minimum.reduce(distances, axis=2, initial=math.inf)
                grid[rows, columns] = np.minimum(grid[rows, columns], nearest)
        clearances: Array = np.maximum(grid, 0.0)
        return clearances

    def overlap(self, outline: Sequence[Point], x: float, y: float, radius: float) -> bool:
        """Return whether any wall or post has a point inside a polygon.

        Uses plain loops, because few solids are near a body, and arrays are faster only for many solids. A circle that
        contains the polygon saves work on walls outside the circle.

        Args:
            outline: corners of the polygon in order (m, map frame), clockwise or counter-clockwise, convex or not.
            x: x of the middle of the circle.
            y: y of the middle of the circle.
            radius: radius of the circle (m).
        """
        for start_x, start_y, ux, uy, length in self.frames.T.tolist():
            to_x, to_y = start_x - x, start_y - y
            near = abs(to_x * uy - to_y * ux) <= radius and -length - radius <= to_x * ux + to_y * uy <= radius
            if near and _crosses(outline, start_x, start_y, ux, uy, length):
                return True
        return any(_meets_disc(outline, *post) for post in self.posts.tolist())


def joined(parts: Sequence[Solids]) -> Solids:
    """Return all walls and posts of several `Solids` in one."""
    counts = [len(part.walls) for part in parts]
    materials = [part.materials[:count] for part, count in zip(parts, counts)]
    materials += [part.materials[count:] for part, count in zip(parts, counts)]
    return Solids(np.vstack([part.walls for part in parts]), np.vstack([part.posts for part in parts]),
                  np.concatenate(materials))


class Block(NamedTuple):
    """A rectangle of the robot that pushes cans, given by its bounds (m, base_link)."""

    low_x: float
    high_x: float
    low_y: float
    high_y: float

    @property
    def reach(self) -> float:
        """The distance (m) from the robot's middle to the farthest corner of the block."""
        return hypot(max(-self.low_x, self.high_x), max(-self.low_y, self.high_y))

    def push(self, x: float, y: float, radius: float) -> Optional[Point]:
        """Return where this block pushes the middle of a disc that overlaps it. None when the disc does not overlap it.

        All lengths and coordinates are in metres in base_link; x and y are the middle of the disc.
        """
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


def edges(outline: Sequence[Point]) -> Iterator[Tuple[float, float, float, float, float]]:
    """Yield each edge of a polygon as x and y of its start, x and y of its unit vector, and its length."""
    for (x1, y1), (x2, y2) in zip(outline, [*outline[1:], outline[0]]):
        along_x, along_y = x2 - x1, y2 - y1
        length = hypot(along_x, along_y)
        yield x1, y1, along_x / length, along_y / length, length


def outlines_meet(first: Sequence[Point], second: Sequence[Point]) -> bool:
    """Return whether two polygons share a point. This includes the case that one polygon is inside the other."""
    return (any(_crosses(first, *edge) for edge in edges(second))
            or any(_crosses(second, *edge) for edge in edges(first)))


def is_inside(x: float, y: float, outline: Sequence[Point]) -> bool:
    """Return whether the point (x, y) is inside a polygon."""
    return _crosses_axis([(corner_x - x, corner_y - y) for corner_x, corner_y in outline], 0.0)


def _crosses(outline: Sequence[Point], start_x: float, start_y: float, ux: float, uy: float, length: float) -> bool:
    """Return whether any point of a segment (start, unit vector, length) is inside a polygon."""
    return _crosses_axis([((x - start_x) * ux + (y - start_y) * uy, (y - start_y) * ux - (x - start_x) * uy)
                          for x, y in outline], length)


def _crosses_axis(outline: List[Point], length: float) -> bool:
    """Return whether any point of the x axis from 0 to `length` is inside a polygon."""
    inside = False
    for (x1, y1), (x2, y2) in zip(outline, outline[1:] + outline[:1]):
        if (y1 > 0.0) != (y2 > 0.0):
            at = x1 + (x2 - x1) * (y1 / (y1 - y2))
            if 0.0 <= at <= length:
                return True
            inside ^= at > length
    return inside


def _meets_disc(outline: Sequence[Point], x: float, y: float, radius: float) -> bool:
    """Return whether a polygon and a disc with its middle at (x, y) share a point."""
    centred = [(px - x, py - y) for px, py in outline]
    edges = zip(centred, centred[1:] + centred[:1])
    return any(_from_origin(*first, *second) <= radius for first, second in edges) or _crosses_axis(centred, 0.0)


def _from_origin(x1: float, y1: float, x2: float, y2: float) -> float:
    """Return the distance from the origin to the segment from (x1, y1) to (x2, y2)."""
    along_x, along_y = x2 - x1, y2 - y1
    squared = along_x * along_x + along_y * along_y
    share = min(max(-(x1 * along_x + y1 * along_y) / squared, 0.0), 1.0) if squared > 0.0 else 0.0
    return hypot(x1 + share * along_x, y1 + share * along_y)
