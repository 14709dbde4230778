"""The floor of an arena that the middle of a robot can get to from the start, as a grid of points."""

import heapq
import math
from typing import Any, List, Tuple

import numpy as np

from ...errors import WorldError
from ..world import World
from ..world.geometry import Array
from ..world.grids import flood
from ..world.world import MarkedPlace

STEP = 0.1
"""Distance (m) between two points of the grid."""
ROOM = 0.25
"""Least distance (m) of the middle of a robot from any wall or post: half the width of a Pioneer, and a little more."""
STEPS = [(up, right, STEP * math.sqrt(up * up + right * right))
         for up in (-1, 0, 1) for right in (-1, 0, 1) if up or right]


class Floor:
    """The floor of an arena.

    Args:
        arena: the arena. Its first start counts.

    Attributes:
        x: x of the columns of the grid (m).
        y: y of the rows of the grid (m).
        reachable: boolean array (rows, columns): whether the middle of a robot can get to a point.
    """

    def __init__(self, arena: World):
        low_x, low_y, high_x, high_y = arena.bounds
        start_x, start_y, _ = arena.starts[0]
        self.x = np.arange(low_x, high_x + STEP, STEP)
        self.y = np.arange(low_y, high_y + STEP, STEP)
        passable = arena.clearances(self.x, self.y, limit=2.0 * ROOM) >= ROOM
        start = np.zeros_like(passable)
        start[self.cell(start_x, start_y)] = True
        self.reachable = flood(start, passable)
        if not self.reachable.any():
            raise WorldError("arena %s: a robot cannot move away from the start" % arena.name)

    def cell(self, x: float, y: float) -> Tuple[int, int]:
        """Return row and column of the grid point next to the point (x, y) (m), which may lie outside the grid."""
        row, column = round((y - float(self.y[0])) / STEP), round((x - float(self.x[0])) / STEP)
        return min(max(row, 0), len(self.y) - 1), min(max(column, 0), len(self.x) - 1)

    def near(self, x: float, y: float, reach: float) -> "np.ndarray[Any, Any]":
        """Return a boolean array (rows, columns): whether a point is not farther than `reach` (m) from (x, y) (m)."""
        near: "np.ndarray[Any, Any]" = np.square(self.x - x) + np.square(self.y - y)[:, None] <= reach * reach
        return near

    def near_reachable(self, reach: float) -> Array:
        """Return a boolean array (rows, columns): whether a point is not farther than `reach` (m) from a reachable one.
        """
        found = np.zeros_like(self.reachable)
        for row, column in zip(*np.nonzero(self.reachable)):
            found |= self.near(float(self.x[column]), float(self.y[row]), reach)
        return found

    def ways_to(self, place: MarkedPlace) -> Array:
        """Return the lengths (m) of the ways from all points to a place, as an array (rows, columns).

        A way leads over reachable points, in steps along x, along y or both. The length is infinite where there is no
        way.
        """
        ways = np.full(self.reachable.shape, math.inf)
        front: List[Tuple[float, int, int]] = [
            (0.0, row, column) for row, column in zip(*(each.tolist() for each in np.nonzero(self.reachable)))
            if place.contains(float(self.x[column]), float(self.y[row]))]
        for _, row, column in front:
            ways[row, column] = 0.0
        while front:
            way, row, column = heapq.heappop(front)
            for up, right, step in STEPS:
                other = row + up, column + right
                if way + step < ways[other] and self.reachable[other]:
                    ways[other] = way + step
                    heapq.heappush(front, (way + step, *other))
        return ways
