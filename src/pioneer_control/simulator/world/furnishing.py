"""Puts obstacles on a floor so that nothing is cut off: a robot still gets everywhere where it got before.

Lengths are in metres, coordinates in the map frame.
"""

from typing import List, Sequence, Tuple

import numpy as np

from .geometry import Array, is_inside
from .grids import flood
from .poses import Point, box_corners, hypot, placed
from .world import Furniture, World

PASSAGE = 0.3
"""Half the width (m) of the ways that stay open: at every obstacle a robot 0.5 m wide gets past, with some room."""
PASSAGE_OF_PEOPLE = 0.4
"""The same for people: who is shut in with a robot cannot give way to it."""
RESOLUTION = 0.1
"""Side (m) of a cell of the grid on which ways are searched."""
CHAIR_LEG = 0.02
"""Radius (m) of a chair's leg."""


def box(centre: Point, size: Point, angle: float) -> Furniture:
    """Return a box as an obstacle. For the arguments see `poses.box_corners`."""
    return Furniture(corners=tuple(box_corners(centre, size, angle)))


def post(centre: Point, radius: float) -> Furniture:
    """Return a post as an obstacle."""
    return Furniture(posts=((*centre, radius),))


def chair(centre: Point, side: float, angle: float) -> Furniture:
    """Return the four legs of a chair, in a square with the given side (m)."""
    half = side / 2.0
    legs = placed(((-half, -half), (half, -half), (half, half), (-half, half)), (*centre, angle))
    return Furniture(posts=tuple((x, y, CHAIR_LEG) for x, y in legs))


class Furnishing:
    """Puts obstacles on the floor of a world, one after the other.

    Args:
        world: the world. It is not changed.
        kept: places ``(x, y, distance)`` that every obstacle must keep away from: doors, and where robots start.
        passages: half the widths (m) of the ways that stay open, where they are open.

    Attributes:
        obstacles: what was put there so far.
    """

    def __init__(self, world: World, kept: Sequence[Tuple[float, float, float]] = (),
                 passages: Sequence[float] = (PASSAGE,)):
        self._world, self._kept, self._passages = world, kept, passages
        low_x, low_y, high_x, high_y = world.bounds
        self._x = np.arange(low_x + RESOLUTION / 2.0, high_x, RESOLUTION)
        self._y = np.arange(low_y + RESOLUTION / 2.0, high_y, RESOLUTION)
        self._seeds = np.zeros((len(self._y), len(self._x)), dtype=bool)
        for x, y, _ in world.starts:
            self._seeds[abs(self._y - y).argmin(), abs(self._x - x).argmin()] = True
        self._reached = [flood(self._seeds, world.clearances(self._x, self._y, limit=passage) >= passage)
                         for passage in passages]
        self.obstacles: List[Furniture] = []

    def reached(self) -> Array:
        """Return the points (n, 2) that the middle of a robot can reach from a start, on a grid, by the first of the
        passages.
        """
        rows, columns = np.nonzero(self._reached[0])
        return np.column_stack((self._x[columns], self._y[rows]))

    def put(self, obstacle: Furniture) -> bool:
        """Put an obstacle on the floor, unless it overlaps anything, is in a kept place, or would cut off any floor.

        Returns:
            Whether it stands there now.
        """
        solids = obstacle.solids
        if self._overlaps(obstacle) or any(
                np.concatenate(solids.distances(np.array(x), np.array(y))).min() < distance
                for x, y, distance in self._kept):
            return False
        left = [reached & ~self._covered(obstacle, passage) for reached, passage in zip(self._reached, self._passages)]
        if any((flood(self._seeds & each, each) != each).any() for each in left):
            return False
        self._reached = left
        self.obstacles.append(obstacle)
        return True

    def _covered(self, obstacle: Furniture, passage: float) -> Array:
        """Return the cells of the grid that are nearer to an obstacle than half a passage, or in it."""
        clearance = obstacle.solids.clearances(self._x, self._y, limit=passage)
        inside = np.full(clearance.shape, bool(obstacle.corners))
        for x1, y1, x2, y2 in obstacle.walls:    # counter-clockwise
            inside &= (x2 - x1) * (self._y[:, None] - y1) - (y2 - y1) * (self._x - x1) > 0.0
        covered: Array = inside | (clearance < passage)
        return covered

    def _overlaps(self, obstacle: Furniture) -> bool:
        """Return whether an obstacle overlaps a wall, a post or another obstacle."""
        outlines = [obstacle.corners] if obstacle.corners else [
            ((x - r, y - r), (x + r, y - r), (x + r, y + r), (x - r, y + r)) for x, y, r in obstacle.posts]
        for outline in outlines:
            xs, ys = zip(*outline)
            x, y = (min(xs) + max(xs)) / 2.0, (min(ys) + max(ys)) / 2.0
            radius = hypot(max(xs) - min(xs), max(ys) - min(ys)) / 2.0
            if self._world.touches(outline) or any(
                    other.solids.overlap(outline, x, y, radius)
                    or other.corners and is_inside(*outline[0], other.corners) for other in self.obstacles):
                return True
        return any(is_inside(*outline[0], other) for outline in outlines for other in self._world.boxes)
