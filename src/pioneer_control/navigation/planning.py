"""Plans the way to a goal on a grid map: which floor a robot may use, what the way from each place costs, and the way.

The floor is divided into squares of about 0.1 m (the map's cells, or several of them). A metre costs more near a wall,
so a way keeps its distance where there is room, and goes through a narrow gap only if it must. The cost to go is found
once from the goal for all squares (Dijkstra), so one plan serves the robot wherever it is.

Obstacles that are on no map make a square costly, but do not close it: when they block the only way, the robot goes
there and waits, and sees whether they have gone.
"""

import math
from dataclasses import dataclass
from typing import Any, List, NamedTuple, Optional, Tuple

import numpy as np
from scipy import ndimage
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import connected_components, dijkstra

from ..maps.grid_map import FREE, OCCUPIED, GridMap
from .tuned import PlanningNumbers

Array = Any     # of numpy
Point = Tuple[float, float]

_STEPS = [(rows, columns) for rows in range(-2, 3) for columns in range(-2, 3) if math.gcd(rows, columns) == 1]
"""The sixteen steps from a square to others: to its neighbours, and as the knight of chess."""


_AIM_STEPS = 5


class _Net(NamedTuple):
    """The squares as a graph: the square at each end of each step, the step's length (m), and where rows begin."""

    start: Array
    end: Array
    length: Array
    row_starts: Array


class DrivableFloor:
    """The floor that a robot may use, on one map.

    Attributes:
        clearance: distance (m) from the middle of each cell of the map to the nearest cell that is not free.
        side: side (m) of a square.
    """

    def __init__(self, grid_map: GridMap, half_width: float, tuned: PlanningNumbers, through_unknown: bool = False):
        """Find the squares that the robot may use.

        Args:
            grid_map: the map.
            half_width: half the width (m) of the robot.
            tuned: the numbers of planning.
            through_unknown: unknown cells count as free, for a robot that explores.
        """
        self._map, self._tuned = grid_map, tuned
        self._least = half_width + tuned.squeeze
        self._wanted = half_width + tuned.keep
        blocked = (grid_map.cells == OCCUPIED) if through_unknown else (grid_map.cells != FREE)
        framed = ndimage.distance_transform_edt(np.pad(~blocked, 1)) * grid_map.resolution
        self.clearance: Array = framed[1:-1, 1:-1]
        self._pooled = max(1, round(tuned.side / grid_map.resolution))
        self.side = grid_map.resolution * self._pooled
        self._usable = _most_of_squares(self.clearance, self._pooled) >= self._least
        self._number = np.where(self._usable, np.cumsum(self._usable).reshape(self._usable.shape) - 1, -1)
        self._squares = np.flatnonzero(self._usable)
        self._net = _net(self._number, self.side)
        self._near_walls = self._cost_of(self.clearance)
        rows, columns = np.indices(self._usable.shape)
        self._base = self._cost_of(_between(self.clearance, (rows + 0.5) * self._pooled - 0.5,
                                            (columns + 0.5) * self._pooled - 0.5))
        self._parts = connected_components(self._graph(np.ones(int(self._usable.sum()))))[1]
        _, (self._near_row, self._near_column) = ndimage.distance_transform_edt(
            ~self._usable, return_indices=True) if self._usable.any() else (None, (rows, columns))
        off = np.hypot(rows - self._near_row, columns - self._near_column) * self.side
        self._off_the_floor = off * tuned.off_the_floor

    def refusal(self, start: Point, goal: Point) -> str:
        """Return why the robot cannot go from a place to a goal (m, map frame), for people. Empty when it can."""
        x, y = goal
        if not (math.isfinite(x) and math.isfinite(y)):
            return "the goal (%g, %g) is not finite: give two numbers in metres" % goal
        name = "the goal (%.2f, %.2f)" % goal
        row, column = (int(each) for each in self._map.cell(x, y))
        rows, columns = self._map.cells.shape
        if not (0 <= row < rows and 0 <= column < columns):
            return "%s lies outside of the map, which has x from %.2f to %.2f and y from %.2f to %.2f" % (
                name, self._map.bounds[0], self._map.bounds[2], self._map.bounds[1], self._map.bounds[3])
        if self._map.cells[row, column] == OCCUPIED:
            return "%s lies in a wall" % name
        if self.clearance[row, column] <= 0.0:
            return "%s lies where the map is unknown" % name
        if self.clearance[row, column] < self._least:
            return "%s lies %.2f m from what the map has there: the robot needs %.2f m" % (
                name, self.clearance[row, column], self._least)
        if not self._usable.any() or self._part(start) != self._part(goal):
            return "%s cannot be reached: no way %.2f m wide leads there from (%.2f, %.2f)" % (
                name, 2.0 * self._least, start[0], start[1])
        return ""

    def to(self, goal: Point, obstacles: Optional[Array] = None) -> "RoutePlan":
        """Return the plan to a goal (m, map frame) that is not refused.

        Args:
            goal: x and y.
            obstacles: array (number, 2) of x and y of what is there and on no map.
        """
        cost = self._base
        if obstacles is not None and len(obstacles):
            cost = cost + self._extra(obstacles)
        costs = cost[self._usable]
        node = self._nearest(goal)
        to_go, previous = dijkstra(self._graph(costs), indices=node, return_predecessors=True)
        values = np.full(self._usable.shape, np.inf)
        values[self._usable] = to_go
        values = values[self._near_row, self._near_column]
        most = float(values[np.isfinite(values)].max(initial=0.0))
        values = np.where(np.isfinite(values), values, most + 10.0) + self._off_the_floor
        following = np.where(previous >= 0, previous, np.arange(len(previous)))
        aims = following
        for _ in range(_AIM_STEPS - 1):
            aims = following[aims]
        return RoutePlan(goal, values, cost, previous, aims, self)

    def shortest(self, start: Point, goal: Point) -> float:
        """Return the length (m) of the shortest way between two places, infinite when there is none."""
        lengths = dijkstra(self._graph(np.ones(int(self._usable.sum()))), indices=self._nearest(goal))
        return float(lengths[self._nearest(start)])

    def straight(self, start: Point, goal: Point) -> bool:
        """Return whether the robot may drive straight from one place to another (m, map frame)."""
        count = max(2, math.ceil(math.hypot(goal[0] - start[0], goal[1] - start[1]) / self._map.resolution))
        row, column = self._map.cell(np.linspace(start[0], goal[0], count), np.linspace(start[1], goal[1], count))
        rows, columns = self.clearance.shape
        inside = (row >= 0) & (row < rows) & (column >= 0) & (column < columns)
        return bool(inside.all() and (self.clearance[row, column] >= self._least).all())

    def cost_of_a_metre(self, x: Array, y: Array) -> Array:
        """Return the cost of a metre at points (m, map frame), as the map alone has it."""
        row, column = self._map.cell(x, y)
        rows, columns = self._near_walls.shape
        return self._near_walls[np.clip(row, 0, rows - 1), np.clip(column, 0, columns - 1)]

    def middle(self, row: Array, column: Array) -> Tuple[Array, Array]:
        """Return x and y (m, map frame) of the middle of squares."""
        x, y = self._map.origin
        return x + (np.asarray(column) + 0.5) * self.side, y + (np.asarray(row) + 0.5) * self.side

    def fraction(self, x: Array, y: Array) -> Tuple[Array, Array]:
        """Return row and column of points (m, map frame) as numbers that are whole in the middles of squares."""
        left, bottom = self._map.origin
        return (y - bottom) / self.side - 0.5, (x - left) / self.side - 0.5

    def aim_at(self, aims: Array, x: Array, y: Array) -> Tuple[Array, Array]:
        """Return x and y (m, map frame) of the squares that `aims` has for the squares of points."""
        row, column = self.fraction(x, y)
        rows, columns = self._usable.shape
        row = np.clip(np.rint(row).astype(int), 0, rows - 1)
        column = np.clip(np.rint(column).astype(int), 0, columns - 1)
        square = self._squares[aims[self._number[self._near_row[row, column], self._near_column[row, column]]]]
        return self.middle(square // columns, square % columns)

    def place(self, node: int) -> Point:
        """Return the middle (m, map frame) of a square that may be used, by its number in the graph."""
        row, column = divmod(int(self._squares[node]), self._usable.shape[1])
        x, y = self.middle(row, column)
        return float(x), float(y)

    def node(self, place: Point) -> int:
        """Return the number of the square nearest to a place (m, map frame) that may be used."""
        return self._nearest(place)

    def _nearest(self, place: Point) -> int:
        row, column = self.fraction(*place)
        rows, columns = self._usable.shape
        row, column = min(max(round(row), 0), rows - 1), min(max(round(column), 0), columns - 1)
        return int(self._number[self._near_row[row, column], self._near_column[row, column]])

    def _part(self, place: Point) -> int:
        return int(self._parts[self._nearest(place)])

    def _cost_of(self, room: Array) -> Array:
        """Return the cost of a metre where the nearest wall is `room` (m) away: 1 in the open."""
        tuned = self._tuned
        near = np.clip((self._wanted + tuned.berth - room) / tuned.berth, 0.0, None)
        return 1.0 + tuned.near_cost * near ** 2 + np.where(room < self._wanted, tuned.squeeze_cost, 0.0)

    def _extra(self, obstacles: Array) -> Array:
        """Return what obstacles that are on no map add to the cost of a metre in each square."""
        rows, columns = self._usable.shape
        row, column = (np.round(each).astype(int) for each in self.fraction(obstacles[:, 0], obstacles[:, 1]))
        inside = (row >= 0) & (row < rows) & (column >= 0) & (column < columns)
        if not inside.any():
            return np.zeros(self._usable.shape)
        free = np.ones(self._usable.shape, dtype=bool)
        free[row[inside], column[inside]] = False
        room = ndimage.distance_transform_edt(free) * self.side
        return np.where(room < self._least, self._tuned.obstacle_cost, self._cost_of(room) - 1.0)

    def _graph(self, costs: Array) -> Any:
        net = self._net
        weights = net.length * (costs[net.start] + costs[net.end]) * 0.5
        count = len(net.row_starts) - 1
        return csr_matrix((weights, net.end, net.row_starts), shape=(count, count))


@dataclass(frozen=True)
class RoutePlan:
    """The way to a goal from everywhere.

    Attributes:
        goal: x and y (m, map frame).
        values: the cost to go from the middle of each square; in metres of open floor.
        costs: the cost of a metre in each square.
        previous: for each square that may be used, the next one on its way to the goal; -1 or less: none.
        aims: for each such square, one farther on its way, at which the robot aims.
        floor: the floor it was made for.
    """

    goal: Point
    values: Array
    costs: Array
    previous: Array
    aims: Array
    floor: DrivableFloor

    def cost(self, x: Array, y: Array) -> Array:
        """Return the cost to go from points (m, map frame), between the middles of squares in proportion."""
        return _between(self.values, *self.floor.fraction(x, y))

    def heading(self, x: Array, y: Array) -> Array:
        """Return the direction (rad, map frame) from points (m, map frame) to where their way is some squares on."""
        aim_x, aim_y = self.floor.aim_at(self.aims, x, y)
        return np.arctan2(aim_y - y, aim_x - x)

    def cost_of_way(self, points: List[Point]) -> float:
        """Return the cost of a way (m, map frame), also of one of another plan."""
        x, y = np.array(points).T
        row, column = self.floor.fraction(x[1:], y[1:])
        rows, columns = self.costs.shape
        each = self.costs[np.clip(np.rint(row).astype(int), 0, rows - 1),
                          np.clip(np.rint(column).astype(int), 0, columns - 1)]
        return float((each * np.hypot(np.diff(x), np.diff(y))).sum())

    def points_from(self, place: Point) -> List[Point]:
        """Return the way from a place to the goal as points (m, map frame), about a square apart. Ends at the goal."""
        node = self.floor.node(place)
        points = [place]
        while self.previous[node] >= 0:
            node = int(self.previous[node])
            points.append(self.floor.place(node))
        return points[:-1] + [self.goal] if len(points) > 1 else [place, self.goal]


def length_of(points: List[Point]) -> float:
    """Return the length (m) of a way."""
    return sum(math.hypot(b[0] - a[0], b[1] - a[1]) for a, b in zip(points, points[1:]))


def _between(grid: Array, row: Array, column: Array) -> Array:
    """Return the values of a grid at rows and columns between its own, in proportion; at its border, beyond it."""
    rows, columns = grid.shape
    row, column = np.clip(row, 0, rows - 1.001), np.clip(column, 0, columns - 1.001)
    up, right = row.astype(int), column.astype(int)
    above, beside = row - up, column - right
    up_next, right_next = np.minimum(up + 1, rows - 1), np.minimum(right + 1, columns - 1)
    return ((grid[up, right] * (1 - beside) + grid[up, right_next] * beside) * (1 - above)
            + (grid[up_next, right] * (1 - beside) + grid[up_next, right_next] * beside) * above)


def _most_of_squares(clearance: Array, pooled: int) -> Array:
    """Return the greatest clearance in each square of `pooled` x `pooled` cells.

    So no gap is lost that the cells have. None is won either: both sides of a wall that a robot may use are farther
    apart than two squares.
    """
    rows, columns = (-(-size // pooled) for size in clearance.shape)
    padded = np.zeros((rows * pooled, columns * pooled))
    padded[:clearance.shape[0], :clearance.shape[1]] = clearance
    return padded.reshape(rows, pooled, columns, pooled).max(axis=(1, 3))


def _net(number: Array, side: float) -> _Net:
    """Return the graph of squares with a number from 0 on; -1 marks the others."""
    starts, ends, lengths = [], [], []
    rows, columns = number.shape
    for up, right in _STEPS:
        here = number[max(0, -up):rows - max(0, up), max(0, -right):columns - max(0, right)]
        there = number[max(0, up):rows - max(0, -up), max(0, right):columns - max(0, -right)]
        both = (here >= 0) & (there >= 0)
        starts.append(here[both])
        ends.append(there[both])
        lengths.append(np.full(int(both.sum()), side * math.hypot(up, right)))
    start = np.concatenate(starts)
    order = np.argsort(start, kind="stable")
    count = int((number >= 0).sum())
    row_starts = np.concatenate(([0], np.cumsum(np.bincount(start, minlength=count)))).astype(np.int32)
    return _Net(start[order], np.concatenate(ends)[order].astype(np.int32), np.concatenate(lengths)[order], row_starts)
