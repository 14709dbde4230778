"""The bodies that stand in a world, found by place: obstacles to each other. Metres, map frame."""

import collections
import math
from typing import Dict, List, Protocol, Sequence, Tuple

from .geometry import Block
from .poses import Point, Pose

Cell = Tuple[int, int]
Candidate = Tuple[float, float, float, float, float, float]
"""A wall or a post, as sonar hears it: no nearer than the first number, then x and y of its start or middle.

Behind that come the wall's unit vector and length, or the post's radius, 0 and -1.
"""


class Obstacle(Protocol):
    """A body, as others meet it.

    Attributes:
        pose: where it stands.
        reach: no point of it is farther (m) from its middle.
        box: the rectangle that it is to a can (base_link).
    """

    pose: Pose
    reach: float
    box: Block

    @property
    def outline(self) -> Sequence[Point]:
        """Its corners where it stands now."""

    @property
    def candidates(self) -> Sequence[Candidate]:
        """What sonar can hear of it."""


Grid = Dict[Cell, List[Obstacle]]
NOBODY: List[Obstacle] = []
"""One empty list for all questions; nobody adds to it."""


class Crowd:
    """The bodies that have entered a world, listed by place: a question looks into one list.

    A grid lists each body in the square of floor that it stands on and in the eight round it. There are several
    grids: the squares of one are the smallest, those of the others two, three or more of the smallest squares wide. Two
    bodies that touch stand in the same of the smallest squares, or in neighbouring ones.

    Attributes:
        reach: no body reaches farther (m) from its middle.
    """

    def __init__(self) -> None:
        self.reach = 0.0
        self._side = 1.0    # of the smallest squares
        self._squares: Dict[Obstacle, Cell] = {}    # the smallest square that each body stands on
        self._grids: Dict[int, Grid] = {}           # by the width of their squares
        self._smallest: Grid = {}

    def enter(self, body: Obstacle) -> None:
        """Let a body be in the way of all others."""
        if body.reach > self.reach:
            self.reach, self._side = body.reach, 2.0 * body.reach
            self._squares = {each: self._square(each) for each in self._squares}
            self._grids.clear()     # others are made anew when somebody asks
            self._smallest = self._add_grid(1)
        square = self._squares[body] = self._square(body)
        for width, grid in self._grids.items():
            _list(body, grid, _around(square, width))

    def moved(self, body: Obstacle) -> None:
        """Note that a body stands elsewhere now. Bodies that have not entered do not count."""
        before = self._squares.get(body)
        if before is None:
            return
        square = self._square(body)
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

    def beside(self, x: float, y: float) -> List[Obstacle]:
        """The bodies that could touch another body whose middle is at (x, y), and some that could not.

        The other body is among them if it has entered.
        """
        return self._smallest.get((math.floor(x / self._side), math.floor(y / self._side)), NOBODY)

    def near(self, x: float, y: float, reach: float) -> List[Obstacle]:
        """The bodies that have a point within `reach` of (x, y), and some that have none."""
        if not self._squares:
            return NOBODY
        width = math.ceil((reach + self.reach) / self._side)
        grid = self._grids.get(width) or self._add_grid(width)
        return grid.get((math.floor(x / self._side) // width, math.floor(y / self._side) // width), NOBODY)

    def _square(self, body: Obstacle) -> Cell:
        x, y, _ = body.pose
        return math.floor(x / self._side), math.floor(y / self._side)

    def _add_grid(self, width: int) -> Grid:
        grid = self._grids[width] = collections.defaultdict(list)
        for body, square in self._squares.items():
            _list(body, grid, _around(square, width))
        return grid


def _list(body: Obstacle, grid: Grid, cells: Sequence[Cell]) -> None:
    for cell in cells:
        grid[cell].append(body)


def _around(square: Cell, width: int) -> List[Cell]:
    """The square of a grid that one of the smallest squares lies in, and the eight round it."""
    column, row = square[0] // width, square[1] // width
    return [(column + right, row + up) for right in (-1, 0, 1) for up in (-1, 0, 1)]
