"""How far a body can go before it comes too near to something: the geometry under the wander.

Points are (x, y) [m] in the robot's frame: x forward, y left.
"""

import itertools
import math
from typing import Any, Iterable, List, Tuple

import numpy as np

Point = Tuple[float, float]
Array = Any     # of numpy

#: A turn is tried in steps of this [rad].
TURN_STEP = 0.04
#: Two directions are parallel when they differ by less than this.
PARALLEL = 1e-9


class Outline:
    """The convex hull of a body, asked how far it may move.

    Each edge has a normal that points outwards, and an offset: a point lies outside an edge when its way along the
    normal is more than the offset. Near a corner that measure is shorter than the true distance, so the answers err to
    the safe side.
    """

    def __init__(self, footprint: Iterable[Point]):
        """Take the corners of the footprint (x, y) [m], in any order."""
        edges = np.array(hull_edges(footprint))
        corners = edges[:, 0]
        x, y = (edges[:, 1] - corners).T    # along each edge
        self._normals = np.column_stack((y, -x)) / np.hypot(x, y)[:, np.newaxis]
        self._offsets = (self._normals * corners).sum(axis=1)
        self.reach = float(np.hypot(*corners.T).max())
        self.half_width = float(abs(corners[:, 1]).max())
        self.front, self.rear = float(corners[:, 0].max()), -float(corners[:, 0].min())

    def distance(self, x: Array, y: Array) -> Array:
        """From the outline to points [m]; negative inside, never more than the true distance."""
        return self._outside(x, y).max(axis=0)

    def _outside(self, x: Array, y: Array) -> Array:
        """How far points are outside each edge [m]: a row for each edge."""
        return np.outer(self._normals[:, 0], x) + np.outer(self._normals[:, 1], y) - self._offsets[:, np.newaxis]

    def straight(self, points: Iterable[Point], margin: float, limit: float, direction: int = 1) -> float:
        """How far the body can go straight ahead (`direction` 1) or back (-1) before it touches [m], at most `limit`.

        A point that the body would pass at less than `margin` counts as touched, unless it is beside the body already.
        """
        x, y = _columns(points)
        outside, towards = self._outside(x, y), direction * self._normals[:, :1]
        leading, trailing = towards[:, 0] > PARALLEL, towards[:, 0] < -PARALLEL
        reached = (outside[leading] / towards[leading]).max(axis=0)
        passed = ((outside[trailing] - margin) / towards[trailing]).min(axis=0)
        in_the_way = (abs(y) < self.half_width + margin) & (reached < passed)
        in_the_way &= (outside[~leading & ~trailing] < margin).all(axis=0)
        way = np.where(reached >= 0, reached, np.where(outside.max(axis=0) < 0, 0.0, limit))
        return float(way[in_the_way].min(initial=limit))

    def circle_straight(self, points: Iterable[Point], margin: float, limit: float) -> float:
        """How far the body can go straight ahead and still turn on the spot all the way [m], at most `limit`.

        Its turning circle, wider by `margin`, goes until it touches. A point that is within the margin already counts
        only if the circle itself would touch it.
        """
        x, y = _columns(points)
        radius = np.where(np.hypot(x, y) > self.reach + margin, self.reach + margin, self.reach)
        ahead = (abs(y) < radius) & (x > 0)
        return float(max(0.0, (x[ahead] - np.sqrt(radius[ahead] ** 2 - y[ahead] ** 2)).min(initial=limit)))

    def turn(self, points: Iterable[Point], side: int, margin: float, limit: float) -> float:
        """How far the body can turn on the spot to the left (`side` 1) or right (-1) [rad], at most `limit`.

        A point that is nearer than `margin` already stops the turn only if the turn brings it nearer still.
        """
        x, y = _columns((x, y) for x, y in points if math.hypot(x, y) < self.reach + margin)
        angle, before = 0.0, self.distance(x, y)
        while x.size and angle < limit:
            cosine, sine = math.cos(angle + TURN_STEP), -side * math.sin(angle + TURN_STEP)
            after = self.distance(cosine * x - sine * y, sine * x + cosine * y)
            if ((after < margin) & (after < before)).any():
                return angle
            angle, before = angle + TURN_STEP, after
        return limit


def _columns(points: Iterable[Point]) -> Tuple[Array, Array]:
    """All x and all y of points."""
    x, y = np.array(list(points), dtype=float).reshape(-1, 2).T
    return x, y


def hull_edges(points: Iterable[Point]) -> List[Tuple[Point, Point]]:
    """The edges of the smallest convex polygon around points, each from corner to corner, counter-clockwise.

    No point stands on the right of such an edge.
    """
    corners = sorted(set((float(x), float(y)) for x, y in points))
    return [(a, b) for a, b in itertools.permutations(corners, 2)
            if all(_area(a, b, other) >= -PARALLEL for other in corners)]


def _area(a: Point, b: Point, c: Point) -> float:
    """Twice the signed area of a triangle [m^2]: positive when a, b, c turn to the left."""
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
