"""The bodies of robots that stand in a world, found by place, because they are obstacles to each other.

Lengths are in metres, coordinates in the map frame.
"""

import collections
import math
from typing import Dict, List, Optional, Protocol, Sequence, Tuple

from .geometry import Block
from .materials import Material
from .poses import Point, Pose

Cell = Tuple[int, int]
Candidate = Tuple[float, float, float, float, float, float]
"""A wall or a post that sonar may detect, as six numbers (m).

A wall: least distance, x and y of its start, x and y of its unit vector, length. A post: least distance, x and y of
its middle, radius, 0, -1. The least distance is a lower bound of the distance from the sonar.
"""


class Obstacle(Protocol):
    """A robot's body, as an obstacle to other robots.

    Attributes:
        pose: where the body stands (m, rad; map frame).
        reach: largest distance (m) from the middle of the body to any of its points.
        box: rectangle with which the body pushes cans (m, base_link).
        material: what light finds at it.
    """

    pose: Pose
    reach: float
    box: Block
    material: Material

    @property
    def outline(self) -> Sequence[Point]:
        """The corners of the body at its present pose (m, map frame)."""

    @property
    def candidates(self) -> Sequence[Candidate]:
        """The edges of the body that sonar can detect, at its present pose."""


Grid = Dict[Cell, List[Obstacle]]
NOBODY: List[Obstacle] = []
"""An empty list, returned where no body is near. It must stay empty."""


class Crowd:
    """The bodies that have entered a world, listed by place, so that each search reads only one list.

    The floor is divided into squares. A grid lists each body under the square that it stands on and under the eight
    squares around it. There are several grids. The first grid has the smallest squares; the squares of the other grids
    are two, three or more times as wide. Two bodies that touch stand in the same smallest square or in neighbouring
    smallest squares.

    Attributes:
        reach: largest distance (m) from the middle of any body to any of its points.
    """

    def __init__(self) -> None:
        self.reach = 0.0
        self._side = 1.0    # side (m) of the smallest squares
        self._squares: Dict[Obstacle, Cell] = {}    # each body's smallest square, kept up only while there is a grid
        self._grids: Dict[int, Grid] = {}           # by the width of their squares, in smallest squares

    def enter(self, body: Obstacle) -> None:
        """Add a body, so that it is an obstacle to all others."""
        if body.reach > self.reach:
            self.reach, self._side = body.reach, 2.0 * body.reach
            self._grids.clear()     # they are made again when they are needed
        square = self._squares[body] = self._square(body)
        for width, grid in self._grids.items():
            _list(body, grid, _around(square, width))

    def moved(self, body: Obstacle) -> None:
        """List a body under its new pose, after it moved. Ignore a body that has not entered."""
        if not self._grids or body not in self._squares:
            return
        before, square = self._squares[body], self._square(body)
        if square == before:
            return
        self._squares[body] = square
        for width, grid in self._grids.items():
            old, new = _around(before, width), _around(square, width)
            if old != new:
                for cell in old:
                    grid[cell].remove(body)
                    if not grid[cell]:
                        del grid[cell]
                _list(body, grid, new)

    def near(self, x: float, y: float, reach: float, asker: Optional[Obstacle] = None) -> List[Obstacle]:
        """Return all bodies that have a point within `reach` (m) of (x, y) (m, map frame), and some farther bodies.

        `asker` is a body that asks for others. It may be in the list, but not when no other body has entered.
        """
        if self._squares.keys() <= {asker}:     # nobody else has entered
            return NOBODY
        width = math.ceil((reach + self.reach) / self._side)
        grid = self._grids.get(width) or self._add_grid(width)
        return grid.get((math.floor(x / self._side) // width, math.floor(y / self._side) // width), NOBODY)

    def _square(self, body: Obstacle) -> Cell:
        x, y, _ = body.pose
        return math.floor(x / self._side), math.floor(y / self._side)

    def _add_grid(self, width: int) -> Grid:
        if not self._grids:     # until now nobody kept the squares up
            self._squares = {body: self._square(body) for body in self._squares}
        grid = self._grids[width] = collections.defaultdict(list)
        for body, square in self._squares.items():
            _list(body, grid, _around(square, width))
        return grid


def _list(body: Obstacle, grid: Grid, cells: Sequence[Cell]) -> None:
    for cell in cells:
        grid[cell].append(body)


def _around(square: Cell, width: int) -> List[Cell]:
    """Return the grid square that contains a smallest square, and the eight grid squares around it.

    `width` is the width of the grid's squares, in smallest squares.
    """
    column, row = square[0] // width, square[1] // width
    return [(column + right, row + up) for right in (-1, 0, 1) for up in (-1, 0, 1)]
