"""Who else stands near: the bodies of one world, found by place, as obstacles to each other.

Metres, map frame. A body belongs to the crowd from `enter` to `leave`, and says with `moved` when it has.
"""

import math
from typing import Any, Dict, List, Tuple

Cell = Tuple[int, int]
NOBODY: List = []
"""Never added to."""


class _Grid:
    """Bodies listed by the square of floor they stand on, and by the eight round it: a question looks into one list
    only.
    """

    def __init__(self, side: float):
        self.side = side
        self._cells: Dict[Cell, List] = {}
        self._where: Dict[int, Cell] = {}

    def put(self, body) -> None:
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

    def drop(self, body) -> None:
        """List it nowhere."""
        for around in _around(self._where.pop(id(body))):
            bodies = self._cells[around]
            bodies.remove(body)
            if not bodies:
                del self._cells[around]

    def near(self, x: float, y: float) -> List:
        """All that stand within a side of a point, and some that stand farther."""
        return self._cells.get((math.floor(x / self.side), math.floor(y / self.side)), NOBODY)


class Crowd:
    """The bodies that stand in a world.

    All grids have squares whose side is a multiple of one: a body that stays in a square of that side stays in one of
        each.
    """

    def __init__(self):
        self.reach = 0.0
        """No body reaches farther (m) from its middle."""
        self._bodies: Dict[int, Any] = {}
        self._squares: Dict[int, Cell] = {}
        self._start_grids()

    def __len__(self) -> int:
        return len(self._bodies)

    def enter(self, body) -> None:
        """From now on this body is in everybody's way."""
        self._bodies[id(body)] = body
        if body.reach > self.reach:
            self.reach = body.reach
            self._start_grids()
        self._squares = dict.fromkeys(self._bodies, (math.inf, math.inf))   # nowhere yet
        self.moved(body)

    def leave(self, body) -> None:
        """From now on it no longer is."""
        del self._bodies[id(body)], self._squares[id(body)]
        for grid in self._grids.values():
            grid.drop(body)

    def moved(self, body) -> None:
        """The body stands elsewhere now; nothing to one that has not entered."""
        before = self._squares.get(id(body))
        if before is not None:
            x, y, _ = body.pose
            square = math.floor(x / self._side), math.floor(y / self._side)
            if square != before:
                self._squares[id(body)] = square
                for grid in self._grids.values():
                    grid.put(body)

    def beside(self, x: float, y: float) -> List:
        """The bodies that could touch another body whose middle is at (x, y), that one included if it has entered, and
        some that could not.
        """
        return self._smallest.near(x, y) if self._bodies else NOBODY

    def near(self, x: float, y: float, reach: float) -> List:
        """The bodies that have a point within `reach` of (x, y), and some that have none."""
        if not self._bodies:
            return NOBODY
        sides = math.ceil((reach + self.reach) / self._side)
        return (self._grids.get(sides) or self._add_grid(sides)).near(x, y)

    def _start_grids(self) -> None:
        self._side = 2.0 * self.reach
        """Of the smallest squares (m): two bodies that touch stand in the same or in neighbours."""
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
