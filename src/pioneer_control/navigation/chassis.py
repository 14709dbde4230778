"""The robot as navigation knows it: its outline, where its sonar looks, and its speeds.

Two things follow from these: how far it can go along each of its moves before it touches a place (`Moves.ways`), and
along which moves some transducer looks (`Moves.covered`). All is in the robot's frame (m, rad).
"""

import functools
import math
from typing import Any, FrozenSet, Iterable, List, NamedTuple, Tuple

import numpy as np
from scipy.spatial import ConvexHull

from ..floor_poses import Pose
from ..robots import HALF_CONE, Transducer
from .frames import into, turned
from .values import Point

Array = Any     # of numpy

LOOKS = (0.2, 0.35, 0.5, 0.65, 0.8, 1.0, 1.2)
"""How far ahead along a move (m) a transducer may look: what it heard there is remembered when the robot comes."""
GAP = 0.05
"""Width (m) of a gap between two cones that is allowed."""
FAR = 1.4
"""Longest way (m) that `Moves.ways` tells."""

_CELL, _STEP, _TURN_STEP = 0.025, 0.04, 0.05
_BENDS = (0.2, 0.45, 0.8, 1.2, 1.8, 2.6, 3.6)
_BENDS_BACK = (0.5, 1.2, 2.5)


class Chassis(NamedTuple):
    """A robot as navigation knows it.

    Attributes:
        transducers: those that are fitted.
        outline: corners (x, y) of its outline (m), counter-clockwise.
        max_linear: greatest speed (m/s) to drive at.
        max_angular: greatest turn rate (rad/s).
    """

    transducers: Tuple[Transducer, ...]
    outline: Tuple[Point, ...]
    max_linear: float
    max_angular: float

    @property
    def half_width(self) -> float:
        """The greatest distance (m) of the outline from the x axis."""
        return max(abs(y) for _, y in self.outline)

    @property
    def reach(self) -> float:
        """The greatest distance (m) of the outline from the centre of rotation."""
        return max(math.hypot(*corner) for corner in self.outline)


class Manoeuvre(NamedTuple):
    """A way to move: an arc, or a turn on the spot.

    `direction` is 1 forward, -1 backward, 0 for a turn on the spot. `bend` is the heading's change a metre of an arc
    (rad/m, to the left positive as it goes), or 1 and -1 for a turn to the left and to the right.
    """

    direction: int
    bend: float


def all_moves() -> List[Manoeuvre]:
    """Return the moves among which the robot chooses."""
    both = [0.0] + [side * bend for bend in _BENDS for side in (1.0, -1.0)]
    back = [0.0] + [side * bend for bend in _BENDS_BACK for side in (1.0, -1.0)]
    arcs = [Manoeuvre(1, bend) for bend in both] + [Manoeuvre(-1, bend) for bend in back]
    return arcs + [Manoeuvre(0, 1.0), Manoeuvre(0, -1.0)]


class Moves:
    """The moves of one chassis, and how far each goes before it touches a place.

    Attributes:
        each: the moves.
        direction, bend: their fields, as arrays.
    """

    def __init__(self, chassis: Chassis, margin: float):
        """Make the tables; `margin` (m) is the distance that the outline keeps from a place."""
        self._chassis = chassis
        self.each = all_moves()
        self.direction = np.array([move.direction for move in self.each])
        self.bend = np.array([move.bend for move in self.each])
        self._half = math.ceil((chassis.reach + FAR) / _CELL)
        self._free = np.where(self.direction == 0, 2.0 * math.pi, FAR)
        self._ways = _ways(chassis.outline, margin, self._half)

    def ways(self, x: Array, y: Array) -> Array:
        """Return how far the robot can go along each move until it touches one of some points: m, rad for a turn.

        A point nearer than the margin ends a move only if the move brings it nearer. Without points: `FAR`, or a whole
        turn.
        """
        column = np.floor(x / _CELL).astype(int) + self._half
        row = np.floor(y / _CELL).astype(int) + self._half
        inside = (row >= 0) & (row < 2 * self._half) & (column >= 0) & (column < 2 * self._half)
        cells = row[inside] * 2 * self._half + column[inside]
        return np.minimum(self._free, self._ways[cells].min(axis=0, initial=np.inf))

    def covered(self, live: Iterable[int]) -> Array:
        """Return for each move whether transducers with these numbers look where it leads (bool).

        They look along an arc if each point of the outline that leads lies in one of their cones after at least one of
        `LOOKS`. A turn on the spot always counts: it sweeps floor that sonar has passed over.
        """
        return _covered(self._chassis, frozenset(live))


@functools.lru_cache(maxsize=16)
def _ways(outline: Tuple[Point, ...], margin: float, half: int) -> Array:
    """Return the table of ways: one row for each cell around the robot, one column for each move."""
    middles = (np.arange(-half, half) + 0.5) * _CELL
    y, x = (each.ravel().astype(np.float32) for each in np.meshgrid(middles, middles, indexing="ij"))
    moves = all_moves()
    table = np.empty((len(moves), len(x)), dtype=np.float32)
    symmetrical = {(round(px, 6), round(py, 6)) for px, py in outline} == {
        (round(px, 6), round(-py, 6)) for px, py in outline}
    for number, move in enumerate(moves):
        mirrored = Manoeuvre(move.direction, -move.bend)
        if symmetrical and move.bend < 0.0:
            table[number] = table[moves.index(mirrored)].reshape(2 * half, 2 * half)[::-1].ravel()
        else:
            table[number] = _way(outline, margin, move, x, y)
    return np.ascontiguousarray(table.T)


def _way(outline: Tuple[Point, ...], margin: float, move: Manoeuvre, x: Array, y: Array) -> Array:
    step, most = (_TURN_STEP, 2.0 * math.pi) if move.direction == 0 else (_STEP, FAR)
    reach = max(math.hypot(*corner) for corner in outline) + margin
    way = np.full(len(x), np.inf, dtype=np.float32)
    left = np.arange(len(x))
    if move.direction == 0:
        left = left[np.hypot(x, y) < reach]
    before = distance_outside(outline, x[left], y[left])
    for number in range(1, round(most / step) + 1):
        now = distance_outside(outline, *into(after(move, number * step), x[left], y[left]))
        touched = (now < margin) & (now < before - 1e-5)
        # Where between the two steps the margin is met, in proportion; at once if it was within it before.
        share = np.clip((before - margin) / np.maximum(before - now, 1e-5), 0.0, 1.0)
        way[left[touched]] = ((number - 1 + share) * step)[touched]
        left, before = left[~touched], now[~touched]
    return way


def after(move: Manoeuvre, way: float) -> Pose:
    """Return the pose of the robot (robot's frame) after a move of this length (m; rad for a turn on the spot)."""
    if move.direction == 0:
        return Pose(0.0, 0.0, move.bend * way)
    heading, along = move.bend * way, move.direction * way
    if abs(heading) < 1e-9:
        return Pose(along, 0.0, 0.0)
    return Pose(along * math.sin(heading) / heading, along * (1.0 - math.cos(heading)) / heading, heading)


def distance_outside(outline: Tuple[Point, ...], x: Array, y: Array) -> Array:
    """Return the distance (m) of points from the convex hull of an outline, negative inside.

    Near a corner it may be too small. What lies between the paddles of a gripper and the body is inside.
    """
    most = None
    corners = _hull(outline)
    for (x1, y1), (x2, y2) in zip(corners, corners[1:] + corners[:1]):
        length = math.hypot(x2 - x1, y2 - y1)
        out_x, out_y = (y2 - y1) / length, (x1 - x2) / length
        distance = x * np.float32(out_x) + y * np.float32(out_y) - np.float32(out_x * x1 + out_y * y1)
        most = distance if most is None else np.maximum(most, distance)
    return most


@functools.lru_cache(maxsize=16)
def _hull(outline: Tuple[Point, ...]) -> Tuple[Point, ...]:
    """Return the corners of the convex hull, counter-clockwise."""
    corners: List[int] = ConvexHull(outline).vertices.tolist()
    return tuple(outline[corner] for corner in corners)


@functools.lru_cache(maxsize=256)
def _covered(chassis: Chassis, live: FrozenSet[int]) -> Array:
    looking = [each for each in chassis.transducers if each.number in live]
    return np.array([move.direction == 0 or _looked_at(chassis.outline, looking, move) for move in all_moves()])


def _looked_at(outline: Tuple[Point, ...], looking: List[Transducer], move: Manoeuvre) -> bool:
    """Return whether cones cover where the leading part of the outline comes, at some distance."""
    ahead = [after(move, way) for way in LOOKS if way * abs(move.bend) < 1.3]     # an arc that has not turned away
    x, y, heading = np.array(ahead).T[:, :, np.newaxis]
    point_x, point_y = np.array(leading(outline, move)).T
    way_x, way_y = turned(point_x, point_y, heading)
    looked_at = np.zeros(len(point_x), dtype=bool)
    for each in looking:
        looked_at |= _in_cone(each, x + way_x, y + way_y).any(axis=0)
    return bool(looked_at.all())


def leading(outline: Tuple[Point, ...], move: Manoeuvre) -> List[Point]:
    """Return points along the edges of an outline that look where the move goes, at most 2 cm apart."""
    points = []
    for (x1, y1), (x2, y2) in zip(outline, outline[1:] + outline[:1]):
        length = math.hypot(x2 - x1, y2 - y1)
        if (y2 - y1) / length * move.direction > math.cos(math.radians(45.0)):
            count = max(1, math.ceil(length / 0.02))
            points += [(x1 + (x2 - x1) * k / count, y1 + (y2 - y1) * k / count) for k in range(count + 1)]
    return points


def _in_cone(transducer: Transducer, x: Array, y: Array) -> Array:
    along, aside = into(Pose(transducer.x, transducer.y, transducer.heading), x, y)
    return (along > 0.0) & (np.abs(aside) - GAP / 2.0 <= along * math.tan(HALF_CONE))
