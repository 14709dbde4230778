"""How far a body can go before it comes too near to something: the geometry under the wander.

Points are (x, y) [m] in the robot's frame: x forward, y left.
"""

import math
from typing import Iterable, List, Sequence, Tuple

Point = Tuple[float, float]

#: A turn is tried in steps of this [rad].
TURN_STEP = 0.04


class Outline:
    """The convex hull of a body, asked how far it may move.

    `edges` are (nx, ny, d): a point lies outside when nx x + ny y > d for one of them. Near a corner that measure is
    shorter than the true distance, so the answers err to the safe side.
    """

    def __init__(self, footprint: Iterable[Point]):
        """Take the corners of the footprint (x, y) [m], in any order."""
        hull = convex_hull(footprint)
        self.edges = tuple(_edge(a, b) for a, b in zip(hull, hull[1:] + hull[:1]))
        self.reach = max(math.hypot(x, y) for x, y in hull)
        self.half_width = max(abs(y) for _, y in hull)
        self.front = max(x for x, _ in hull)
        self.rear = -min(x for x, _ in hull)

    def distance(self, x: float, y: float) -> float:
        """From the outline to a point [m]; negative inside, never more than the true distance."""
        return max([nx * x + ny * y - d for nx, ny, d in self.edges])

    def straight(self, points: Iterable[Point], margin: float, limit: float, direction: int = 1) -> float:
        """How far the body can go straight ahead (`direction` 1) or back (-1) before it touches [m], at most `limit`.

        A point that the body would pass at less than `margin` counts as touched, unless it is beside the body already.
        """
        free, width = limit, self.half_width + margin
        for x, y in points:
            if abs(y) < width:
                free = min(free, self._contact(x, y, margin, limit, direction))
        return free

    def _contact(self, x: float, y: float, margin: float, limit: float, direction: int) -> float:
        """The way until the body reaches one point, straight on; `limit` when it passes or has passed it."""
        reached, passed = -math.inf, math.inf
        for nx, ny, d in self.edges:
            towards = nx * direction
            outside = nx * x + ny * y - d
            if towards > 1e-9:
                reached = max(reached, outside / towards)
            elif towards < -1e-9:
                passed = min(passed, (outside - margin) / towards)
            elif outside >= margin:
                return limit
        if reached >= passed:
            return limit
        if reached >= 0:
            return reached
        return 0.0 if self.distance(x, y) < 0 else limit

    def circle_straight(self, points: Iterable[Point], margin: float, limit: float) -> float:
        """How far the body can go straight ahead and still turn on the spot all the way [m], at most `limit`.

        Its turning circle, wider by `margin`, goes until it touches. A point that is within the margin already counts
        only if the circle itself would touch it.
        """
        free = limit
        for x, y in points:
            radius = self.reach + margin if x * x + y * y > (self.reach + margin) ** 2 else self.reach
            if abs(y) < radius and x > 0:
                free = min(free, max(0.0, x - math.sqrt(radius * radius - y * y)))
        return free

    def turn(self, points: Iterable[Point], side: int, margin: float, limit: float) -> float:
        """How far the body can turn on the spot to the left (`side` 1) or right (-1) [rad], at most `limit`.

        A point that is nearer than `margin` already stops the turn only if the turn brings it nearer still.
        """
        near = [(x, y, self.distance(x, y)) for x, y in points if x * x + y * y < (self.reach + margin) ** 2]
        angle = 0.0
        while near and angle < limit:
            cosine, sine = math.cos(angle + TURN_STEP), -side * math.sin(angle + TURN_STEP)
            for index, (x, y, before) in enumerate(near):
                after = self.distance(cosine * x - sine * y, sine * x + cosine * y)
                if after < margin and after < before:
                    return angle
                near[index] = (x, y, after)
            angle += TURN_STEP
        return limit


def convex_hull(points: Iterable[Point]) -> List[Point]:
    """Corners of the smallest convex polygon around points, counter-clockwise (Andrew's monotone chain)."""
    ordered = sorted(set((float(x), float(y)) for x, y in points))
    return _half_hull(ordered) + _half_hull(ordered[::-1])


def _half_hull(ordered: Sequence[Point]) -> List[Point]:
    chain: List[Point] = []
    for point in ordered:
        while len(chain) > 1 and _area(chain[-2], chain[-1], point) <= 0:
            chain.pop()
        chain.append(point)
    return chain[:-1]


def _area(a: Point, b: Point, c: Point) -> float:
    """Twice the signed area of a triangle [m^2]: positive when a, b, c turn to the left."""
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def _edge(a: Point, b: Point) -> Tuple[float, float, float]:
    length = math.hypot(b[0] - a[0], b[1] - a[1])
    nx, ny = (b[1] - a[1]) / length, (a[0] - b[0]) / length
    return nx, ny, nx * a[0] + ny * a[1]
