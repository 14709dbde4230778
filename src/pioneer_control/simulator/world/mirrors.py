"""The range that sonar measures among walls that are mirrors to it: sound that meets them at a slant bounces away.

A point of a wall returns an echo when sound meets it at an angle to the wall's normal up to a largest one. All other
points of the wall in a cone are a mirror: they return no echo, and nothing behind them is detected. An end or a corner
of walls scatters a little sound: it returns an echo from every side, but only over a short distance. A post returns an
echo from every side. No sound comes back over two walls.

The sides of other robots are walls, too. Lengths are in metres, all coordinates in the map frame unless they are said
to be relative to the sensor. As in `echoes`, only ``+ - * / sqrt`` and comparisons are used.
"""

import itertools
import math
from typing import Dict, Iterable, List, NamedTuple, Optional, Tuple

import numpy as np

from .crowd import Candidate, Obstacle
from .echoes import Ear, Surroundings, disc_echo, unpacked
from .geometry import Array, Solids
from .poses import Point, hypot

SCATTERED = 1.0
"""Distance (m) up to which an end or a corner of walls is heard, if sound meets its walls at a slant."""
STRAIGHT = 0.97
"""Cosine of the largest angle between two walls at whose joint no sound is scattered: a straight or a bent wall."""
BEFORE = 0.002
"""Distance (m) before an end or a corner at which mirrors are searched that hide it. Its own walls do not hide it."""
CRACK = 1e-6
"""Width (m, or rad at the sensor) of a crack that lets no sound through.

Rounding may leave a crack between the shadows of two mirrors that meet.
"""

Part = Tuple[float, float]
"""A part of a wall: the positions of its two ends (m) along the wall."""
Bound = Tuple[float, float]
"""A condition on a position t along a wall, as two numbers a, b: a + b t >= 0."""
Cone = Tuple[Point, Point]
"""The unit vectors along the right edge and the left edge of a cone that is narrower than half a turn."""


class SeenLine(NamedTuple):
    """The line of a wall, as a sensor sees it: the foot of the perpendicular (m, relative to the sensor), and the unit
    vector along the wall. Positions along the wall count from the foot.
    """

    foot: Point
    along: Point

    def point(self, position: float) -> Point:
        """Return the point (m, relative to the sensor) at a position along the wall."""
        return self.foot[0] + position * self.along[0], self.foot[1] + position * self.along[1]

    def left_of(self, direction: Point) -> Bound:
        """Return the condition on positions to the left of a direction from the sensor."""
        return _cross(direction, self.foot), _cross(direction, self.along)

    def right_of(self, direction: Point) -> Bound:
        """Return the condition on positions to the right of a direction from the sensor."""
        return _cross(self.foot, direction), _cross(self.along, direction)


class Mirror(NamedTuple):
    """The part of a wall that returns no echo: its right end and its left end (m, relative to the sensor)."""

    right: Point
    left: Point

    def hidden(self, part: Part, line: SeenLine) -> Part:
        """Return what this mirror hides of a part of a wall. Nothing is hidden if the result ends before it begins."""
        (x, y), (left_x, left_y) = self.right, self.left
        along = left_x - x, left_y - y
        behind = _cross((line.foot[0] - x, line.foot[1] - y), along), _cross(line.along, along)
        return _within(part, line.left_of(self.right), line.right_of(self.left), behind)

    def hides(self, cone: Cone, middle: Point) -> bool:
        """Return whether a disc in a `cone` is behind this mirror. `middle` is that of the disc, relative to the
        sensor.
        """
        right, left = self.cone
        nearest = right if _cross(right, middle) < 0.0 else left if _cross(middle, left) < 0.0 else middle
        length = hypot(*nearest)
        ahead = (nearest[0] * middle[0] + nearest[1] * middle[1]) / length
        along = self.left[0] - self.right[0], self.left[1] - self.right[1]
        return _cross(self.right, self.left) * length < ahead * _cross(nearest, along)

    @property
    def cone(self) -> Cone:
        """The cone that this mirror fills."""
        (right_x, right_y), (left_x, left_y) = self
        to_right, to_left = hypot(right_x, right_y), hypot(left_x, left_y)
        return (right_x / to_right, right_y / to_right), (left_x / to_left, left_y / to_left)


class MirrorEar(Ear):
    """An `Ear` in a world whose walls return no echo to sound that meets them at a slant.

    Args:
        world: as for `Ear`, like `half_width` and `maximum`.
        slant: tangent of the largest angle between sound and a wall's normal at which the wall returns an echo.
    """

    def __init__(self, world: Surroundings, half_width: float, maximum: float, slant: float):
        super().__init__(world, half_width, maximum)
        self._slant = slant
        self._solids = Solids(world.solids.walls, np.vstack((world.solids.posts, _ends(world.solids))))

    def echo(
        self, x: float, y: float, heading: float, right: Point, left: Point, listener: Optional[Obstacle] = None,
    ) -> float:
        """Return the distance (m) to the nearest point that returns an echo and that no mirror hides. See `Ear.echo`.
        """
        bodies = [body.candidates for body in self._world.crowd.near(x, y, self._maximum, listener)
                  if body is not listener]
        corners = [(0.0, x1, y1, 0.0, 0.0, -1.0) for body in bodies for _, x1, y1, _, _, length in body if length > 0.0]
        fixed = unpacked(self._candidates(x, y, heading))
        return echo_among_mirrors(
            itertools.chain(*bodies, corners, fixed), x, y, (right, left), self._maximum, self._slant)


def ear_of(world: Surroundings, half_width: float, maximum: float, slant: float = math.inf) -> Ear:
    """Return the `Ear` of a world. If `slant` is infinite, all walls return echoes. For the arguments see `MirrorEar`.
    """
    return Ear(world, half_width, maximum) if slant == math.inf else MirrorEar(world, half_width, maximum, slant)


def echo_among_mirrors(
    candidates: Iterable[Candidate], x: float, y: float, cone: Cone, maximum: float, slant: float,
) -> float:
    """Return the distance (m) from a sensor at (x, y) to the nearest point that returns an echo.

    Args:
        candidates: walls, posts, and ends of walls, which are posts with radius 0, sorted by least distance.
        x: x of the sensor (m, map frame).
        y: y of the sensor (m, map frame).
        cone: the cone of the sensor, at most a quarter turn wide.
        maximum: longest range (m).
        slant: tangent of the largest angle between sound and a wall's normal at which the wall returns an echo.

    Returns:
        The distance, at most `maximum`; 0 inside a post.
    """
    right, left = cone
    mirrors: List[Mirror] = []
    audible: List[Tuple[float, Part, SeenLine]] = []
    discs: List[Tuple[Point, float]] = []
    ends: List[Point] = []
    for least, at_x, at_y, ux, uy, length in candidates:
        if least >= maximum:
            break
        at_x -= x
        at_y -= y
        if length < 0.0:
            if ux > 0.0:
                discs.append(((at_x, at_y), ux))
            elif at_x * at_x + at_y * at_y < SCATTERED * SCATTERED:
                ends.append((at_x, at_y))
            continue
        low = at_x * ux + at_y * uy
        line = SeenLine((at_x - low * ux, at_y - low * uy), (ux, uy))
        begin, end = _within((low, low + length), line.left_of(right), line.right_of(left))
        if begin > end:
            continue
        aside = hypot(*line.foot)
        farthest = slant * aside    # position of the last point that returns an echo
        if begin < -farthest:
            mirrors += _mirror(line, (begin, min(end, -farthest)))
        if end > farthest:
            mirrors += _mirror(line, (max(begin, farthest), end))
        if begin <= farthest and end >= -farthest:
            part = max(begin, -farthest), min(end, farthest)
            audible.append((_distance(aside, part), part, line))
    nearest = maximum
    for distance, part, line in sorted(audible, key=lambda each: each[0]):
        if distance >= nearest:
            break
        for seen in _seen(part, line, mirrors):
            nearest = min(nearest, _distance(hypot(*line.foot), seen))
    for middle, radius in discs:
        distance = disc_echo(*middle, radius, right, left)
        if distance == 0.0:
            return 0.0
        if distance < nearest:
            for free in _free_cones(cone, middle, mirrors):
                nearest = min(nearest, disc_echo(*middle, radius, *free))
    for tip in ends:
        distance = hypot(*tip)
        if BEFORE < distance < nearest:
            before = tip[0] * (1.0 - BEFORE / distance), tip[1] * (1.0 - BEFORE / distance)
            free_cones = _free_cones(cone, before, mirrors)
            if any(_cross(first, tip) >= 0.0 <= _cross(tip, last) for first, last in free_cones):
                nearest = distance
    return nearest


def _ends(solids: Solids) -> Array:
    """Return the ends and corners of walls as an array (n, 3) of posts with radius 0. Straight joints are left out."""
    start_x, start_y, ux, uy, length = solids.frames
    around: Dict[Tuple[float, float], List[Point]] = {}
    for x, y, along_x, along_y, far in zip(*(each.tolist() for each in (start_x, start_y, ux, uy, length))):
        around.setdefault((round(x, 6), round(y, 6)), []).append((along_x, along_y))
        end = round(x + far * along_x, 6), round(y + far * along_y, 6)
        around.setdefault(end, []).append((-along_x, -along_y))
    ends = [(x, y, 0.0) for (x, y), ways in around.items()
            if not (len(ways) == 2 and ways[0][0] * ways[1][0] + ways[0][1] * ways[1][1] < -STRAIGHT)]
    return np.array(ends).reshape(-1, 3)


def _mirror(line: SeenLine, part: Part) -> List[Mirror]:
    """Return the mirror that a part of a wall is, as a list. It is empty if the sensor sees the part from its end."""
    first, second = line.point(part[0]), line.point(part[1])
    width = _cross(first, second)
    return [Mirror(first, second)] if width > 0.0 else [Mirror(second, first)] if width < 0.0 else []


def _seen(part: Part, line: SeenLine, mirrors: List[Mirror]) -> List[Part]:
    """Return the parts of a part of a wall that no mirror hides."""
    parts = [part]
    for mirror in mirrors:
        begin, end = mirror.hidden(part, line)
        if begin <= end:
            parts = [piece for low, high in parts for piece in ((low, min(high, begin)), (max(low, end), high))
                     if piece[1] - piece[0] > CRACK]
    return parts


def _free_cones(cone: Cone, middle: Point, mirrors: List[Mirror]) -> List[Cone]:
    """Return the parts of a cone in which no mirror hides a disc. `middle` is that of the disc, relative to the sensor.
    """
    cones = [cone]
    for mirror in mirrors:
        if mirror.hides(cone, middle):
            begin, end = mirror.cone
            cones = [(first, last) for right, left in cones
                     for first, last in ((right, _first(left, begin)), (_last(right, end), left))
                     if _cross(first, last) > CRACK]
    return cones


def _within(part: Part, *bounds: Bound) -> Part:
    """Return the part of a wall's part that fulfils all conditions. It ends before it begins if there is none."""
    low, high = part
    for base, slope in bounds:
        if slope > 0.0:
            low = max(low, -base / slope)
        elif slope < 0.0:
            high = min(high, -base / slope)
        elif base < 0.0:
            return math.inf, -math.inf
    return low, high


def _distance(aside: float, part: Part) -> float:
    """Return the distance (m) to the nearest point of a part of a wall whose line is `aside` (m) away."""
    return hypot(aside, max(part[0], -part[1], 0.0))


def _first(direction: Point, other: Point) -> Point:
    """Return the direction that is farther to the right."""
    return direction if _cross(direction, other) > 0.0 else other


def _last(direction: Point, other: Point) -> Point:
    """Return the direction that is farther to the left."""
    return other if _cross(direction, other) > 0.0 else direction


def _cross(first: Point, second: Point) -> float:
    """Return the cross product of two vectors. It is positive when the second is to the left of the first."""
    return first[0] * second[1] - first[1] * second[0]
