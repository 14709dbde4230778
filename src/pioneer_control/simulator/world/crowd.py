"""The bodies that stand in a world, found by place: obstacles to each other. Metres, map frame."""

import math
from typing import Dict, List, Protocol, Sequence, Tuple

from .geometry import Block, Point, Pose

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

    def is_close(self, pose: Pose, reach: float) -> bool:
        """Whether something within `reach` of the middle of `pose` could touch it."""


NOBODY: List[Obstacle] = []
"""Never added to."""
NOWHERE = 1 << 60, 1 << 60


class _Grid:
    """Bodies listed by the square of floor they stand on, and by the eight round it: a question looks into one list."""

    def __init__(self, side: float):
        self.side = side
        self._cells: Dict[Cell, List[Obstacle]] = {}
        self._where: Dict[int, Cell] = {}

    def put(self, body: Obstacle) -> None:
        """List a body where it stands now."""
        x, y, _ = body.pose
        cell = math.floor(x / self.side), math.floor(y / self.side)
        before = self._where.get(id(body))
        if cell == before:
            return
        if before is not None:
            self.drop(body)
        self._where[id(body)] = cell
        for around in _around(cell):
            self._cells.setdefault(around, []).append(body)

    def drop(self, body: Obstacle) -> None:
        """List a body nowhere."""
        for around in _around(self._where.pop(id(body))):
            bodies = self._cells[around]
            bodies.remove(body)
            if not bodies:
                del self._cells[around]

    def near(self, x: float, y: float) -> List[Obstacle]:
        """All that stand within a side of a point, and some that stand farther."""
        return self._cells.get((math.floor(x / self.side), math.floor(y / self.side)), NOBODY)


class Crowd:
    """The bodies that stand in a world, from `enter` to `leave`.

    The squares of all grids have sides that are multiples of one. So a body that stays in a square of that side stays
    in one square of each grid.

    Attributes:
        reach: no body reaches farther (m) from its middle.
    """

    def __init__(self) -> None:
        self.reach = 0.0
        self._bodies: Dict[int, Obstacle] = {}
        self._squares: Dict[int, Cell] = {}
        self._start_grids()

    def __len__(self) -> int:
        return len(self._bodies)

    def enter(self, body: Obstacle) -> None:
        """Let a body be in the way of all others."""
        self._bodies[id(body)] = body
        if body.reach > self.reach:
            self.reach = body.reach
            self._start_grids()
        self._squares = dict.fromkeys(self._bodies, NOWHERE)
        self.moved(body)

    def leave(self, body: Obstacle) -> None:
        """Let a body be in nobody's way."""
        del self._bodies[id(body)], self._squares[id(body)]
        for grid in self._grids.values():
            grid.drop(body)

    def moved(self, body: Obstacle) -> None:
        """Note that a body stands elsewhere now. Bodies that have not entered do not count."""
        before = self._squares.get(id(body))
        if before is not None:
            x, y, _ = body.pose
            square = math.floor(x / self._side), math.floor(y / self._side)
            if square != before:
                self._squares[id(body)] = square
                for grid in self._grids.values():
                    grid.put(body)

    def beside(self, x: float, y: float) -> List[Obstacle]:
        """The bodies that could touch another body whose middle is at (x, y), and some that could not.

        The other body is among them if it has entered.
        """
        return self._smallest.near(x, y) if self._bodies else NOBODY

    def near(self, x: float, y: float, reach: float) -> List[Obstacle]:
        """The bodies that have a point within `reach` of (x, y), and some that have none."""
        if not self._bodies:
            return NOBODY
        sides = math.ceil((reach + self.reach) / self._side)
        return (self._grids.get(sides) or self._add_grid(sides)).near(x, y)

    def _start_grids(self) -> None:
        """Begin with the smallest grid alone: two bodies that touch stand in one of its squares, or in neighbours."""
        self._side = 2.0 * self.reach
        self._grids: Dict[int, _Grid] = {}
        self._smallest = self._add_grid(1)

    def _add_grid(self, sides: int) -> _Grid:
        grid = self._grids[sides] = _Grid(self._side * sides)
        for body in self._bodies.values():
            grid.put(body)
        return grid


def _around(cell: Cell) -> List[Cell]:
    column, row = cell
    return [(column + right, row + up) for right in (-1, 0, 1) for up in (-1, 0, 1)]
