"""Plans the way to a goal on a grid map: which floor a robot may use, what the way from each place costs, and the way.

The floor is divided into squares of about 0.1 m (the map's cells, or several of them). A metre costs more near a wall,
so a way keeps its distance where there is room, and goes through a narrow gap only if it must. The cost to go is found
once from the goal for all squares (Dijkstra), so one plan serves the robot wherever it is.

A plan past obstacles differs from the map's only behind them, as seen from the goal, and only what is not much farther
from the goal than the robot is needed. So only the squares between are searched again.

Obstacles that are on no map make a square costly, but do not close it: when they block the only way, the robot goes
there and waits, and sees whether they have gone.
"""

import functools
import math
from dataclasses import dataclass
from typing import Any, List, NamedTuple, Tuple

import numpy as np
from scipy import ndimage
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import connected_components, dijkstra

from ..maps.grid_map import FORBIDDEN, FREE, OCCUPIED, UNKNOWN, GridMap
from .tuned import PlanningNumbers
from .values import Point

Array = Any     # of numpy

EIGHT_STEPS = [(rows, columns) for rows in range(-1, 2) for columns in range(-1, 2) if rows or columns]
"""The steps from a square to its neighbours."""
_STEPS = [(rows, columns) for rows in range(-2, 3) for columns in range(-2, 3) if math.gcd(rows, columns) == 1]
"""The sixteen steps from a square to others: to its neighbours, and as the knight of chess."""

_AIM_STEPS = 5
_BEYOND = 4.0
"""A new plan has all squares up to this much farther from the goal than the robot is, as costs."""


_REFUSED = {OCCUPIED: "in a wall", UNKNOWN: "where the map is unknown", FORBIDDEN: "on a forbidden line"}


class Net(NamedTuple):
    """The squares as a graph: the square at each end of each step, the step's length (m), and where rows begin."""

    start: Array
    end: Array
    length: Array
    row_starts: Array

    def weights(self, costs: Array, step: Any) -> Array:
        """Return what some steps cost; `costs`: of a metre in each square."""
        return self.length[step] * (costs[self.start[step]] + costs[self.end[step]]) * 0.5

    def steps_from(self, squares: Array) -> Tuple[Array, Array]:
        """Return the steps from some squares, those of one after those of another, and where those of each begin."""
        count = self.row_starts[squares + 1] - self.row_starts[squares]
        begin = np.append(0, np.cumsum(count))
        return begin, np.arange(begin[-1]) + np.repeat(self.row_starts[squares] - begin[:-1], count)

    def matrix(self, weights: Array) -> Any:
        """Return the graph as scipy has it, with a weight for each step."""
        count = len(self.row_starts) - 1
        return csr_matrix((weights, self.end, self.row_starts), shape=(count, count))


class Slowness(NamedTuple):
    """How much slower than elsewhere the robot is beside what is on no map.

    Attributes:
        near: within this distance (m) of its sides it is slowest.
        far: from this distance (m) on it is not slow.
        cost: what a metre costs more where it is slowest; between, in proportion.
    """

    near: float
    far: float
    cost: float


NOT_SLOW = Slowness(0.0, 0.0, 0.0)


class DrivableFloor:
    """The floor that a robot may use, on one map.

    Attributes:
        clearance: distance (m) from the middle of each cell of the map to the nearest cell that is not free.
        side: side (m) of a square.
    """

    def __init__(self, grid_map: GridMap, half_width: float, tuned: PlanningNumbers, through_unknown: bool = False,
                 slowness: Slowness = NOT_SLOW):
        """Find the squares that the robot may use.

        Args:
            grid_map: the map.
            half_width: half the width (m) of the robot.
            tuned: the numbers of planning.
            through_unknown: unknown cells count as free, for a robot that explores.
            slowness: of the robot beside what is on no map.
        """
        self._map, self._tuned, self._half_width, self._slowness = grid_map, tuned, half_width, slowness
        self._least = half_width + tuned.squeeze
        self._wanted = half_width + tuned.keep
        passable = (grid_map.cells == FREE) | (through_unknown & (grid_map.cells == UNKNOWN))
        framed = ndimage.distance_transform_edt(np.pad(passable, 1)) * grid_map.resolution
        self.clearance: Array = framed[1:-1, 1:-1]
        self._pooled = max(1, round(tuned.side / grid_map.resolution))
        self.side = grid_map.resolution * self._pooled
        self._usable = _most_of_squares(self.clearance, self._pooled) >= self._least
        self._number = np.where(self._usable, np.cumsum(self._usable).reshape(self._usable.shape) - 1, -1)
        self._squares = np.flatnonzero(self._usable)
        self._net = net_of(self._number, self.side)
        self._near_walls = self._cost_of(self.clearance)
        rows, columns = np.indices(self._usable.shape)
        self._base = self._cost_of(_between(self.clearance, (rows + 0.5) * self._pooled - 0.5,
                                            (columns + 0.5) * self._pooled - 0.5))
        _, (self._near_row, self._near_column) = ndimage.distance_transform_edt(
            ~self._usable, return_indices=True) if self._usable.any() else (None, (rows, columns))
        self._nearest_number = self._number[self._near_row, self._near_column]
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
            left, bottom, right, top = self._map.bounds
            return ("the goal (%.6g, %.6g) lies outside of the map, which has x from %.2f to %.2f and y from %.2f to"
                    " %.2f" % (x, y, left, right, bottom, top))
        if self.clearance[row, column] <= 0.0:
            return "%s lies %s" % (name, _REFUSED[int(self._map.cells[row, column])])
        if self.clearance[row, column] < self._least:
            return ("%s lies %.2f m from the nearest wall, forbidden line or unknown floor: the robot needs %.2f m"
                    % (name, self.clearance[row, column], self._least))
        if not self._usable.any() or self._part(start) != self._part(goal):
            return "%s cannot be reached: no way %.2f m wide leads there from (%.2f, %.2f)%s" % (
                name, 2.0 * self._least, start[0], start[1],
                " that crosses no forbidden line" if (self._map.cells == FORBIDDEN).any() else "")
        return ""

    def to(self, goal: Point) -> "RoutePlan":
        """Return the plan to a goal (m, map frame) that is not refused, by the map alone."""
        return self._whole(goal, self._base[self._usable])

    def past(self, plan: "RoutePlan", obstacles: Array, start: Point) -> "RoutePlan":
        """Return the plan of a robot among obstacles that are on no map.

        Args:
            plan: the plan to the same goal by the map alone.
            obstacles: array (number, 2) of x and y (m, map frame) of what is there and on no map.
            start: where the robot is. Much farther from the goal than it is, the new plan is no more than a guess.
        """
        extra, known, node = self._extra(obstacles), plan.to_go, self.node(start)
        first = float(known[extra > 0.0].min(initial=np.inf))   # what is nearer to the goal costs the same as before
        most = known[node] + _BEYOND
        if first > most:
            return plan
        costs, fixed = plan.costs + extra, (known < first) | (known == 0.0)
        squares = np.flatnonzero(~fixed & (known < most))
        if 2 * len(squares) < len(known):
            to_go, following = self._searched(squares, costs, plan, fixed, most)
            if to_go[node] < most - _BEYOND / 2.0:
                return self._plan(plan.goal, costs, to_go, following)
        return self._whole(plan.goal, costs)

    def _whole(self, goal: Point, costs: Array) -> "RoutePlan":
        return self._plan(goal, costs, *dijkstra(self._graph(costs), indices=self.node(goal), return_predecessors=True))

    def _plan(self, goal: Point, costs: Array, to_go: Array, following: Array) -> "RoutePlan":
        values = np.full(self._usable.shape, np.inf)
        values[self._usable] = to_go
        values = values[self._near_row, self._near_column]
        most = float(values[np.isfinite(values)].max(initial=0.0))
        values = np.where(np.isfinite(values), values, most + 10.0) + self._off_the_floor
        onward = np.where(following >= 0, following, np.arange(len(following)))
        aims = onward
        for _ in range(_AIM_STEPS - 1):
            aims = onward[aims]
        return RoutePlan(goal, values, costs, to_go, following, aims, self)

    def shortest(self, start: Point, goal: Point) -> float:
        """Return the length (m) of the shortest way between two places, infinite when there is none."""
        lengths = dijkstra(self._graph(np.ones(int(self._usable.sum()))), indices=self.node(goal))
        return float(lengths[self.node(start)])

    def straight(self, start: Point, goal: Point) -> bool:
        """Return whether the robot may drive straight from one place to another (m, map frame)."""
        count = max(2, math.ceil(math.hypot(goal[0] - start[0], goal[1] - start[1]) / self._map.resolution))
        row, column = self._map.cell(np.linspace(start[0], goal[0], count), np.linspace(start[1], goal[1], count))
        rows, columns = self.clearance.shape
        inside = (row >= 0) & (row < rows) & (column >= 0) & (column < columns)
        return bool(inside.all() and (self.clearance[row, column] >= self._least).all())

    def room(self, x: float, y: float) -> float:
        """Return the distance (m) from a point of the map (m) to the nearest cell that is not free."""
        row, column = self._map.cell(x, y)
        return float(self.clearance[int(row), int(column)])

    def cost_of_a_metre(self, x: Array, y: Array) -> Array:
        """Return the cost of a metre at points (m, map frame), as the map alone has it."""
        row, column = self._map.cell(x, y)
        rows, columns = self._near_walls.shape
        row, column = np.minimum(np.maximum(row, 0), rows - 1), np.minimum(np.maximum(column, 0), columns - 1)
        return self._near_walls[row, column]

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
        square = self._squares[aims[self.nodes(x, y)]]
        columns = self._usable.shape[1]
        return self.middle(square // columns, square % columns)

    def places(self, nodes: List[int]) -> List[Point]:
        """Return the middles (m, map frame) of squares that may be used, by their numbers in the graph."""
        row, column = np.divmod(self._squares[nodes], self._usable.shape[1])
        x, y = self.middle(row, column)
        return list(zip(x.tolist(), y.tolist()))

    def nodes(self, x: Array, y: Array) -> Array:
        """Return the numbers of the squares nearest to points (m, map frame) that may be used."""
        row, column = self.fraction(x, y)
        rows, columns = self._usable.shape
        row = np.minimum(np.maximum(np.rint(row).astype(int), 0), rows - 1)
        column = np.minimum(np.maximum(np.rint(column).astype(int), 0), columns - 1)
        return self._nearest_number[row, column]

    def node(self, place: Point) -> int:
        """Return the number of the square nearest to a place (m, map frame) that may be used."""
        row, column = self.fraction(*place)
        rows, columns = self._usable.shape
        row, column = min(max(round(row), 0), rows - 1), min(max(round(column), 0), columns - 1)
        return int(self._nearest_number[row, column])

    @functools.cached_property
    def _parts(self) -> Array:
        """For each square that may be used, the number of the part of the floor that it belongs to."""
        return connected_components(self._graph(np.ones(int(self._usable.sum()))), directed=False)[1]

    def _part(self, place: Point) -> int:
        return int(self._parts[self.node(place)])

    def _cost_of(self, room: Array) -> Array:
        """Return the cost of a metre where the nearest wall is `room` (m) away: 1 in the open."""
        tuned = self._tuned
        near = np.clip((self._wanted + tuned.berth - room) / tuned.berth, 0.0, None)
        return 1.0 + tuned.near_cost * near ** 2 + np.where(room < self._wanted, tuned.squeeze_cost, 0.0)

    def _extra(self, obstacles: Array) -> Array:
        """Return what obstacles that are on no map add to the cost of a metre in each square that may be used.

        Beside them the robot may be slow, so a metre takes longer than elsewhere.
        """
        rows, columns = self._usable.shape
        row, column = (np.rint(each).astype(int) for each in self.fraction(obstacles[:, 0], obstacles[:, 1]))
        inside = (row >= 0) & (row < rows) & (column >= 0) & (column < columns)
        extra = np.zeros(self._usable.shape)
        if inside.any():
            row, column = row[inside], column[inside]
            tuned, slowness = self._tuned, self._slowness
            reach = math.ceil(max(self._wanted + tuned.berth, self._half_width + slowness.far) / self.side)
            low_row, low_column = max(0, row.min() - reach), max(0, column.min() - reach)
            free = np.ones((min(rows, row.max() + reach + 1) - low_row,
                            min(columns, column.max() + reach + 1) - low_column), dtype=bool)
            free[row - low_row, column - low_column] = False
            room = ndimage.distance_transform_edt(free) * self.side
            slow = np.interp(room - self._half_width, slowness[:2], (slowness.cost, 0.0))
            extra[low_row:low_row + free.shape[0], low_column:low_column + free.shape[1]] = np.where(
                room < self._least, tuned.obstacle_cost, self._cost_of(room) - 1.0 + slow)
        return extra[self._usable]

    def _graph(self, costs: Array) -> Any:
        """Return the graph of the squares that may be used, with the cost of a metre in each."""
        net = self._net
        return net.matrix(net.weights(costs, slice(None)))

    def _searched(self, squares: Array, costs: Array, plan: "RoutePlan", fixed: Array, most: float) -> Tuple[
            Array, Array]:
        """Return the cost to go from each square and the next one on its way, searched anew for some squares.

        Args:
            squares: their numbers.
            costs: the cost of a metre in each square that may be used.
            plan: the plan by the map alone.
            fixed: which squares have the cost to go of `plan`.
            most: what costs more to go is not searched, but guessed.
        """
        rim = np.zeros(len(costs), dtype=bool)      # the fixed squares to which steps lead from `squares`
        rim[self._net.end[self._net.steps_from(squares)[1]]] = True
        rim &= fixed
        known = np.flatnonzero(rim)
        rim[squares] = True
        squares = np.flatnonzero(rim)
        begin, step = self._net.steps_from(squares)
        place, count = np.full(len(costs), -1), len(squares)
        place[squares] = np.arange(count)
        end = place[self._net.end[step]]
        weights = np.where(end < 0, np.inf, self._net.weights(costs, step))
        # One more place, from which a step to each known square costs what there is to go from it.
        graph = csr_matrix((np.append(weights, plan.to_go[known]), np.append(np.maximum(end, 0), place[known]),
                            np.append(begin, begin[-1] + len(known))), shape=(count + 1, count + 1))
        found, following = dijkstra(graph, indices=count, limit=most, return_predecessors=True)
        new = np.isfinite(found[:count]) & ~fixed[squares]
        to_go, onward = np.where(fixed, plan.to_go, np.maximum(plan.to_go, most)), plan.following.copy()
        to_go[squares[new]], onward[squares[new]] = found[:count][new], squares[following[:count][new]]
        return to_go, onward


@dataclass(frozen=True)
class RoutePlan:
    """The way to a goal from everywhere.

    Attributes:
        goal: x and y (m, map frame).
        values: the cost to go from the middle of each square; in metres of open floor.
        costs: the cost of a metre in each square that may be used.
        to_go: the cost to go from each such square.
        following: for each such square, the next one on its way to the goal; -1 or less: none.
        aims: for each such square, one farther on its way, at which the robot aims.
        floor: the floor it was made for.
    """

    goal: Point
    values: Array
    costs: Array
    to_go: Array
    following: Array
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
        each = self.costs[self.floor.nodes(x[1:], y[1:])]
        return float((each * np.hypot(np.diff(x), np.diff(y))).sum())

    def points_from(self, place: Point) -> List[Point]:
        """Return the way from a place to the goal as points (m, map frame), about a square apart. Ends at the goal."""
        nodes = [self.floor.node(place)]
        following = self.following.item
        while following(nodes[-1]) >= 0:
            nodes.append(following(nodes[-1]))
        return [place, *self.floor.places(nodes[1:-1]), self.goal]


def length_of(points: List[Point]) -> float:
    """Return the length (m) of a way."""
    return float(np.hypot(*np.diff(np.array(points), axis=0).T).sum())


def _between(grid: Array, row: Array, column: Array) -> Array:
    """Return the values of a grid at rows and columns between its own, in proportion; at its border, beyond it."""
    rows, columns = grid.shape
    row = np.minimum(np.maximum(row, 0), rows - 1.001)
    column = np.minimum(np.maximum(column, 0), columns - 1.001)
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


def net_of(number: Array, side: float, steps: List[Tuple[int, int]] = _STEPS) -> Net:
    """Return the graph of squares with a number from 0 on, row by row; -1 marks the others."""
    row, column = (each.astype(np.int32) for each in np.nonzero(number >= 0))
    rows, columns = number.shape
    framed = np.full((rows + 4, columns + 4), -1, dtype=np.int32)
    framed[2:-2, 2:-2] = number
    up, right = np.array(steps, dtype=np.int32).T
    width = np.int32(columns + 4)
    ends = framed.ravel()[((row + 2) * width + column + 2)[:, None] + up * width + right]
    there = ends >= 0
    count = there.sum(axis=1)
    row_starts = np.concatenate(([0], np.cumsum(count))).astype(np.int32)
    start = np.repeat(np.arange(len(row), dtype=np.int32), count)
    length = np.broadcast_to((side * np.hypot(up, right)).astype(np.float32), there.shape)[there]
    return Net(start, ends[there], length, row_starts)
