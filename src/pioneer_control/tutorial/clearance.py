"""Geometry for the wander: how far the robot can move before it touches an obstacle or comes too near to it.

Points are (x, y) [m] in the robot's frame: x forward, y left.
"""

import itertools
import math
from typing import Any, Iterable, List, Tuple

import numpy as np

Point = Tuple[float, float]
Array = Any     # of numpy

#: `Outline.turn` tries a turn in steps of this size [rad].
TURN_STEP = 0.04
#: Numbers with a smaller absolute value count as 0 (rounding errors).
PARALLEL = 1e-9


class Outline:
    """The convex hull of the robot, with methods that compute how far the robot can move.

    Each edge has a normal, which points outwards, and an offset. A point lies outside an edge when its coordinate along
    the normal is greater than the offset, and the difference is its distance from the edge. Near a corner this distance
    is shorter than the true distance, so the robot stops too early rather than too late.

    Attributes:
        reach: the distance of the farthest corner from the origin, the centre of rotation [m].
        half_width: the greatest distance of a corner from the x axis [m].
        front, rear: how far the hull extends ahead of the origin and behind it [m].
    """

    def __init__(self, footprint: Iterable[Point]):
        """Make the hull of the footprint: corners (x, y) [m] in the robot's frame, in any order."""
        edges = np.array(hull_edges(footprint))
        corners = edges[:, 0]
        x, y = (edges[:, 1] - corners).T    # along each edge
        self._normals = np.column_stack((y, -x)) / np.hypot(x, y)[:, np.newaxis]
        self._offsets = (self._normals * corners).sum(axis=1)
        self.reach = float(np.hypot(*corners.T).max())
        self.half_width = float(abs(corners[:, 1]).max())
        self.front, self.rear = float(corners[:, 0].max()), -float(corners[:, 0].min())

    def distance(self, x: Array, y: Array) -> Array:
        """Return the distance from the outline to each point (x, y) [m], negative for points inside the outline.

        Near a corner it can be less than the true distance, but never more.
        """
        return self._outside(x, y).max(axis=0)

    def _outside(self, x: Array, y: Array) -> Array:
        """Return how far each point (x, y) lies outside each edge [m]: one row for each edge, negative inside."""
        return np.outer(self._normals[:, 0], x) + np.outer(self._normals[:, 1], y) - self._offsets[:, np.newaxis]

    def way_out(self, x: float, y: float, cosine: float, sine: float) -> float:
        """Return the distance [m] from a point (x, y) inside the outline to the outline, along a direction."""
        towards = self._normals @ (cosine, sine)
        inside = self._offsets - self._normals @ (x, y)
        return max(0.0, float((inside[towards > PARALLEL] / towards[towards > PARALLEL]).min()))

    def straight(self, points: Iterable[Point], margin: float, limit: float, direction: int = 1) -> float:
        """Return how far the robot can drive straight before it touches a point [m], at most `limit`.

        A point that the robot would pass at a distance of less than `margin` counts as touched, unless the point is
        beside the robot already.

        Args:
            points: obstacles (x, y) [m] in the robot's frame.
            margin: the distance to keep on both sides [m].
            limit: the greatest result [m].
            direction: 1 to drive forward, -1 to drive back.
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
        """Return how far the robot can drive forward and still make a full turn on the spot there [m], at most `limit`.

        A turn on the spot needs a circle with the radius `reach`, wider by `margin`. The result is how far this circle
        can move forward before it touches a point. A point that is inside the margin at the start counts only if the
        circle without the margin would touch it.

        Args:
            points: obstacles (x, y) [m] in the robot's frame.
            margin: the distance to keep around the circle [m].
            limit: the greatest result [m].
        """
        x, y = _columns(points)
        radius = np.where(np.hypot(x, y) > self.reach + margin, self.reach + margin, self.reach)
        ahead = (abs(y) < radius) & (x > 0)
        return float(max(0.0, (x[ahead] - np.sqrt(radius[ahead] ** 2 - y[ahead] ** 2)).min(initial=limit)))

    def turn(self, points: Iterable[Point], side: int, margin: float, limit: float) -> float:
        """Return how far the robot can turn on the spot [rad], at most `limit`.

        The turn ends before a point comes nearer to the outline than `margin`. A point that is nearer at the start ends
        the turn only if the turn brings it even nearer.

        Args:
            points: obstacles (x, y) [m] in the robot's frame.
            side: 1 to turn left, -1 to turn right.
            margin: the distance to keep from points [m].
            limit: the greatest result [rad].
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
    """Return the x coordinates and the y coordinates of points, as two arrays."""
    x, y = np.array(list(points), dtype=float).reshape(-1, 2).T
    return x, y


def hull_edges(points: Iterable[Point]) -> List[Tuple[Point, Point]]:
    """Return the edges of the convex hull of points: the smallest convex polygon that contains all of them.

    Each edge is a pair of corners (from, to). Along the edge in this direction, the polygon lies on the left.
    """
    corners = sorted(set((float(x), float(y)) for x, y in points))
    return [(a, b) for a, b in itertools.permutations(corners, 2)
            if all(_area(a, b, other) >= -PARALLEL for other in corners)]


def _area(a: Point, b: Point, c: Point) -> float:
    """Return twice the area of the triangle a, b, c [m^2]. It is positive when the path a, b, c turns left."""
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
