"""Where a robot goes that makes a map by itself: to the ends of the map, until all that can be reached is known.

An end of the map is where floor that it can reach meets unknown floor on which it would have room. Unknown cells beside
a wall are no end: no robot fits there.
"""

import math
from typing import Any, List, NamedTuple, Optional, Sequence, Tuple

import numpy as np
from scipy.ndimage import binary_dilation, distance_transform_edt, label
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra

from ..floor_poses import Pose, wrapped
from ..maps import FREE, OCCUPIED, UNKNOWN, GridMap
from .tuned import ExploringNumbers

Array = Any     # of numpy

_ALL_ROUND = np.ones((3, 3), dtype=bool)


_LOOKS = 3
"""Goals in which a robot turns round once, before all others: it has to know its own surroundings."""


class NextGoal(NamedTuple):
    """Where to go next, and why, for people. `pose` is None: nothing is left. `with_heading`: its heading counts."""

    pose: Optional[Pose]
    reason: str
    with_heading: bool = False


class Explorer:
    """Explores: gives goal after goal, and home as the last.

    Args:
        home: where it ends (map frame).
        radius: distance (m) from walls that the middle of the robot needs.
        numbers: what was tuned.
    """

    def __init__(self, home: Pose, radius: float, numbers: ExploringNumbers = ExploringNumbers()) -> None:
        self._home, self._radius, self._numbers = home, radius, numbers
        self._given_up: List[Tuple[float, float]] = []
        self._looks = 0
        self.homeward = False
        """Whether the present goal is home."""

    def next(self, grid_map: GridMap, pose: Pose) -> NextGoal:
        """Return where to go now. Ask again when it is there, or when it failed, or when the map has grown."""
        if self._looks < _LOOKS:
            self._looks += 1
            turned = wrapped(pose.heading + 2.0 * math.pi / _LOOKS)
            return NextGoal(Pose(pose.x, pose.y, turned), "to look round", True)
        goal = next_goal(grid_map, pose, self._radius, self._given_up, self._numbers)
        self.homeward = goal.pose is None
        return NextGoal(self._home, goal.reason + ": home", True) if self.homeward else goal

    def give_up(self, goal: Pose) -> None:
        """Do not try this goal again: the robot could not get there, or learnt nothing there."""
        self._given_up.append((goal.x, goal.y))


def next_goal(grid_map: GridMap, pose: Pose, radius: float, given_up: Sequence[Tuple[float, float]] = (),
              numbers: ExploringNumbers = ExploringNumbers()) -> NextGoal:
    """Choose the end of the map that is worth its way most.

    Args:
        grid_map: the map as it is now.
        pose: where the robot is (map frame).
        radius: distance (m) from walls that its middle needs.
        given_up: x, y (m) of goals that failed.
        numbers: what was tuned.

    Returns:
        A pose on known floor before the end of the map, looking at it; or no pose, and why.
    """
    cells, here = _with_room_to_stand(grid_map, pose, radius + numbers.off_floor)
    grid = GridMap(cells, grid_map.resolution, here)
    to_wall = distance_transform_edt(np.pad(cells != OCCUPIED, 1, constant_values=True))[1:-1, 1:-1] * grid.resolution \
        if (cells == OCCUPIED).any() else np.full(cells.shape, np.inf)
    room = to_wall > radius
    way, reached = _ways(room & (cells == FREE), grid, pose, numbers.off_floor)
    if not reached.any():
        return NextGoal(None, "no known floor with room for the robot is near it")
    open_unknown = room & (cells == UNKNOWN)
    ends, count = label(open_unknown & binary_dilation(reached, _ALL_ROUND), _ALL_ROUND)
    best, best_cost, skipped = None, math.inf, 0
    reached_rows, reached_columns = np.nonzero(reached)
    reached_x, reached_y = grid.middle(reached_rows, reached_columns)
    unknown_x, unknown_y = grid.middle(*np.nonzero(open_unknown))
    for number in range(1, count + 1):
        rows, columns = np.nonzero(ends == number)
        x, y = grid.middle(rows, columns)
        if max(np.ptp(x), np.ptp(y)) + grid.resolution < numbers.least_width:
            continue
        middle = int(np.hypot(x - x.mean(), y - y.mean()).argmin())
        nearest = int(np.hypot(reached_x - x[middle], reached_y - y[middle]).argmin())
        goal_x, goal_y = float(reached_x[nearest]), float(reached_y[nearest])
        if any(math.hypot(goal_x - tried[0], goal_y - tried[1]) < numbers.given_up for tried in given_up):
            skipped += 1
            continue
        gain = float((np.hypot(unknown_x - goal_x, unknown_y - goal_y) < numbers.view).sum()) * grid.resolution ** 2
        length = float(way[reached_rows[nearest], reached_columns[nearest]])
        turn = abs(wrapped(math.atan2(goal_y - pose.y, goal_x - pose.x) - pose.heading)) if length > radius else 0.0
        cost = length + numbers.turn * turn - numbers.gain * min(gain, numbers.most_gain)
        if cost < best_cost:
            looks = math.atan2(y[middle] - goal_y, x[middle] - goal_x)
            best_cost, best = cost, NextGoal(
                Pose(goal_x, goal_y, looks),
                "to an end of the map, %.1f m away: %.1f m^2 are unknown there" % (length, gain))
    if best is not None:
        return best
    if skipped:
        return NextGoal(None, "all that can be reached is known, but for %d places that were given up" % skipped)
    return NextGoal(None, "all that can be reached is known")


def _with_room_to_stand(grid_map: GridMap, pose: Pose, margin: float) -> Tuple[Array, Tuple[float, float]]:
    """Return the cells with unknown ones round them, and their origin. The robot stands inside, on a free cell."""
    step = grid_map.resolution
    low_x, low_y, high_x, high_y = grid_map.bounds
    before = [max(1, math.ceil((low - at + margin) / step)) for low, at in ((low_y, pose.y), (low_x, pose.x))]
    after = [max(1, math.ceil((at + margin - high) / step)) for high, at in ((high_y, pose.y), (high_x, pose.x))]
    cells = np.pad(grid_map.cells, tuple(zip(before, after)), constant_values=UNKNOWN)
    origin = grid_map.origin[0] - before[1] * step, grid_map.origin[1] - before[0] * step
    rows, columns = np.indices(cells.shape)
    x, y = GridMap(cells, step, origin).middle(rows, columns)
    under = (np.hypot(x - pose.x, y - pose.y) < margin / 2.0) & (cells == UNKNOWN)
    cells[under] = FREE
    return cells, origin


def _ways(floor: Array, grid: GridMap, pose: Pose, off_floor: float) -> Tuple[Array, Array]:
    """Return the length (m) of the way to each cell of the floor, and which cells can be reached."""
    rows, columns = np.nonzero(floor)
    if not len(rows):
        return np.zeros(floor.shape), floor
    number = np.full(floor.shape, -1)
    number[rows, columns] = np.arange(len(rows))
    x, y = grid.middle(rows, columns)
    away = np.hypot(x - pose.x, y - pose.y)
    if away.min() > off_floor:
        return np.zeros(floor.shape), np.zeros_like(floor)
    first, second, length = [], [], []
    for up, right in ((0, 1), (1, 0), (1, 1), (1, -1)):
        here = number[:floor.shape[0] - up, max(0, -right):floor.shape[1] - max(0, right)].ravel()
        there = number[up:, max(0, right):floor.shape[1] + min(0, right)].ravel()
        both = (here >= 0) & (there >= 0)
        first.append(here[both])
        second.append(there[both])
        length.append(np.full(both.sum(), math.hypot(up, right) * grid.resolution))
    graph = coo_matrix((np.concatenate(length), (np.concatenate(first), np.concatenate(second))),
                       shape=(len(rows), len(rows))).tocsr()
    lengths = dijkstra(graph, directed=False, indices=int(away.argmin()))
    way = np.full(floor.shape, np.inf)
    way[rows, columns] = lengths
    return way, np.isfinite(way)
