"""Exact plane geometry of the simulated robot: cones, outlines and points against walls and posts.

Lengths are metres, angles radians, all coordinates in the map frame. Arrays see only ``+ - * / sqrt``, comparisons, ``min`` and
``max``, which IEEE 754 rounds the same everywhere, and angles go through `exact` one by one: the same world and pose give the
same bytes with every numpy.
"""

import math
from typing import Dict, Iterator, List, Sequence, Tuple

import numpy as np

from .exact import hypot, unit

Point = Tuple[float, float]

_TINY = 1e-140  # in place of a denominator that is not positive: the quotient becomes huge, not infinite or undefined
_NUDGE = 1e-13  # m: a sensor exactly on a wall's line counts as this far beside it, so that it sees the wall's end


class Solids:
    """Walls and posts, laid out for fast questions: all that sonar sees and a body bumps into.

    :param walls: (n, 4) array, one segment ``x1 y1 x2 y2`` a row, none of length zero.
    :param posts: (m, 3) array, one disc ``x y radius`` a row.
    """

    def __init__(self, walls: np.ndarray, posts: np.ndarray):
        self.walls = walls
        self.posts = posts
        along_x, along_y = walls[:, 2] - walls[:, 0], walls[:, 3] - walls[:, 1]
        length = np.sqrt(along_x * along_x + along_y * along_y)
        ux, uy = along_x / length, along_y / length
        self._walls = np.array([walls[:, 0], walls[:, 1], ux, uy, length])  # start, unit vector and length of each, in rows
        self._tiles: Dict[int, Tuple[np.ndarray, ...]] = {}

    def __len__(self) -> int:
        return len(self.walls) + len(self.posts)

    def each(self) -> Iterator["Solids"]:
        """Every one of them alone."""
        yield from (Solids(self.walls[i : i + 1], self.posts[:0]) for i in range(len(self.walls)))
        yield from (Solids(self.walls[:0], self.posts[i : i + 1]) for i in range(len(self.posts)))

    def bounds(self) -> Tuple[float, float, float, float]:
        """Least x and y and greatest x and y of any of them, of which there is at least one."""
        x, y, radius = self.posts.T
        xs = np.concatenate((self.walls[:, 0], self.walls[:, 2], x - radius, x + radius))
        ys = np.concatenate((self.walls[:, 1], self.walls[:, 3], y - radius, y + radius))
        return float(xs.min()), float(ys.min()), float(xs.max()), float(ys.max())

    def within(self, x: float, y: float, reach: float) -> "Solids":
        """Those that come within `reach` of a point."""
        walls, posts = self.distances(np.array(x), np.array(y))
        return Solids(self.walls[walls <= reach], self.posts[posts <= reach])

    def distances(self, x: np.ndarray, y: np.ndarray) -> Tuple[np.ndarray, np.ndarray]:
        """From points to every wall (..., n) and to the rim of every post (..., m; negative inside a post)."""
        start_x, start_y, ux, uy, length = self._walls
        to_x, to_y = start_x - x[..., None], start_y - y[..., None]
        low, aside = to_x * ux + to_y * uy, to_x * uy - to_y * ux
        beyond = np.maximum(np.maximum(low, -low - length), 0.0)
        post_x, post_y, radius = self.posts.T
        to_x, to_y = post_x - x[..., None], post_y - y[..., None]
        return np.sqrt(aside * aside + beyond * beyond), np.sqrt(to_x * to_x + to_y * to_y) - radius

    def nearest(self, x: float, y: float) -> float:
        """Distance from a point to the nearest solid: infinite where there is none, 0 inside a post. Plain loops, for few solids."""
        walls = (_from_origin(x1 - x, y1 - y, x2 - x, y2 - y) for x1, y1, x2, y2 in self.walls.tolist())
        posts = (hypot(px - x, py - y) - radius for px, py, radius in self.posts.tolist())
        return max(min(min(walls, default=math.inf), min(posts, default=math.inf)), 0.0)

    def echoes(self, x: Sequence[float], y: Sequence[float], heading: Sequence[float], half_width: float) -> np.ndarray:
        """Distance from each sensor to the nearest point of any solid in its cone; infinite where the cone is empty.

        :param x: (s,) positions of the sensors, as `y`.
        :param heading: (s,) directions of the cones' axes.
        :param half_width: angle between a cone's axis and its edge, above 0 and at most pi / 4.
        """
        right, left = [angle - half_width for angle in heading], [angle + half_width for angle in heading]
        edges = list(zip(*map(unit, right + left)))
        nearest = self._wall_echoes(x, y, *edges) if len(self.walls) else np.full(len(right), math.inf)
        if len(self.posts):
            nearest = np.minimum(nearest, self._post_echoes(x, y, *edges))
        return nearest

    def _wall_echoes(self, x, y, edge_x, edge_y) -> np.ndarray:
        """Clip each wall to each cone; the nearest point of the rest is the foot of the perpendicular, or an end.

        Along a wall `t` counts from the perpendicular's foot, so that a point's squared distance is aside² + t². An edge of the
        cone cuts the wall's line at t = aside * (its part along the wall) / (its part towards the wall). An edge that leads away
        from the wall cuts it at one or the other infinity, as far as the cone goes; if both lead away nothing is seen.
        """
        count = len(x)
        pairs, twice = count * len(self.walls), 2 * count * len(self.walls)
        owner, start_x, start_y, ux, uy, length = self._tiled(count)
        vector_x = np.array([*x, *x, *edge_x])[owner]  # of all pairs of a sensor and a wall: position, again, right edge, left edge
        vector_y = np.array([*y, *y, *edge_y])[owner]
        vector_x[:twice] = start_x - vector_x[:twice]
        vector_y[:twice] = start_y - vector_y[:twice]
        along = vector_x * ux + vector_y * uy
        across = vector_x * uy - vector_y * ux
        low, aside = along[:pairs], across[:pairs]
        beside = across[:twice] + _NUDGE
        towards = across[twice:] * beside
        cuts = beside * beside * along[twice:] / np.maximum(towards, _TINY)
        high = np.minimum(low + length, np.maximum(cuts[:pairs], cuts[pairs:]))
        low = np.maximum(low, np.minimum(cuts[:pairs], cuts[pairs:]))
        t = np.minimum(np.maximum(low, 0.0), high)
        squared = aside * aside + t * t
        squared[(low > high) | (np.maximum(towards[:pairs], towards[pairs:]) <= 0.0)] = math.inf
        return np.sqrt(np.minimum.reduce(squared.reshape(count, -1), axis=1))

    def _tiled(self, count: int) -> Tuple[np.ndarray, ...]:
        """The walls again and again for `count` sensors, as `_wall_echoes` needs them: numpy is quickest on long plain rows."""
        if count not in self._tiles:
            start_x, start_y, ux, uy, length = self._walls
            columns = ((start_x, 2 * count), (start_y, 2 * count), (ux, 4 * count), (uy, 4 * count), (length, count))
            owner = np.repeat(np.arange(4 * count), len(self.walls))
            self._tiles[count] = (owner, *(np.tile(*column) for column in columns))
        return self._tiles[count]

    def _post_echoes(self, x, y, edge_x, edge_y) -> List[float]:
        """Nearest post in each cone. Plain loops: few posts reach into a cone, and the others are told by two products."""
        posts, count = self.posts.tolist(), len(x)
        right, left = zip(edge_x[:count], edge_y[:count]), zip(edge_x[count:], edge_y[count:])
        echoes = []
        for sensor_x, sensor_y, (right_x, right_y), (left_x, left_y) in zip(x, y, right, left):
            nearest = math.inf
            for post_x, post_y, radius in posts:
                to_x, to_y = post_x - sensor_x, post_y - sensor_y
                if right_y * to_x - right_x * to_y <= radius and left_x * to_y - left_y * to_x <= radius:
                    nearest = min(nearest, _disc_echo(to_x, to_y, radius, ((right_x, right_y), (left_x, left_y))))
            echoes.append(nearest)
        return echoes

    def overlap(self, outline: Sequence[Point], x: float, y: float, radius: float) -> bool:
        """Whether any wall or post has a point inside a polygon.

        Plain loops: where a body is, there are few solids, and arrays only pay for many.

        :param outline: corners in order, either way round, convex or not.
        :param x: middle of a circle round the polygon, as `y` and its `radius`; saves work on solids outside it.
        """
        for start_x, start_y, ux, uy, length in self._walls.T.tolist():
            to_x, to_y = start_x - x, start_y - y
            low = to_x * ux + to_y * uy
            if abs(to_x * uy - to_y * ux) <= radius and -length - radius <= low <= radius:
                in_frame = [((px - start_x) * ux + (py - start_y) * uy, (py - start_y) * ux - (px - start_x) * uy) for px, py in outline]
                if _crosses_axis(in_frame, length):
                    return True
        return any(_meets_disc(outline, *post) for post in self.posts.tolist())


def _disc_echo(x: float, y: float, radius: float, edges: Tuple[Point, Point]) -> float:
    """Nearest point of a disc in a cone at the origin, whose right and left edges are given as unit vectors.

    It is on the way to the disc's middle if that is in the cone, else where an edge that the middle is beyond enters the disc.
    """
    distance = hypot(x, y)
    if distance <= radius:
        return 0.0
    (right_x, right_y), (left_x, left_y) = edges
    beyond = (right_y * x - right_x * y, left_x * y - left_y * x)
    if max(beyond) <= 0.0:
        return distance - radius
    nearest = math.inf
    for (edge_x, edge_y), outside in zip(edges, beyond):
        ahead = edge_x * x + edge_y * y
        if 0.0 < outside <= radius and ahead > 0.0:
            nearest = min(nearest, ahead - math.sqrt(radius * radius - outside * outside))
    return nearest


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


def outline_echo(outline: Sequence[Point], right: Point, left: Point) -> float:
    """Nearest point of a polygon's edges in a cone at the origin, whose edges are given as unit vectors; infinite if there is none."""
    return min(_segment_echo(*first, *second, right, left) for first, second in zip(outline, [*outline[1:], outline[0]]))


def _segment_echo(x1: float, y1: float, x2: float, y2: float, right: Point, left: Point) -> float:
    """The same for one segment; see `Solids._wall_echoes`."""
    along_x, along_y = x2 - x1, y2 - y1
    length = hypot(along_x, along_y)
    ux, uy = along_x / length, along_y / length
    low, aside = x1 * ux + y1 * uy, x1 * uy - y1 * ux
    beside = aside + _NUDGE
    cuts = []
    facing = False
    for edge_x, edge_y in (right, left):
        towards = (edge_x * uy - edge_y * ux) * beside
        facing |= towards > 0.0
        cuts.append(beside * beside * (edge_x * ux + edge_y * uy) / max(towards, _TINY))
    high = min(low + length, max(cuts))
    low = max(low, min(cuts))
    if low > high or not facing:
        return math.inf
    t = min(max(low, 0.0), high)
    return math.sqrt(aside * aside + t * t)


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
