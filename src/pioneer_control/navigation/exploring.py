"""Where a robot goes that makes a map by itself: to the ends of the map, until all that can be reached is known.

An end of the map is where floor that it can reach meets unknown floor on which it would have room. Unknown cells beside
a wall are no end: no robot fits there.

A corner that is heard from afar is drawn as an arc, as wide as the cone of the sonar; it may close a corridor. So when
no end is left, the robot doubts the walls that it was never near to, and looks at each of them once from near. From
there sound goes through an arc where nothing is, and the end of the map behind it opens.
"""

import math
from dataclasses import replace
from typing import Any, Generator, List, NamedTuple, Optional, Sequence, Tuple

import numpy as np
from scipy.ndimage import binary_dilation, distance_transform_edt, label, uniform_filter
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import cKDTree

from ..floor_poses import Pose, distance_between, wrapped
from ..maps import FREE, OCCUPIED, UNKNOWN, GridMap
from .planning import EIGHT_STEPS, net_of
from .tuned import ExploringNumbers
from .values import Point

Array = Any     # of numpy

_ALL_ROUND = np.ones((3, 3), dtype=bool)
_LOOKS = 3
"""Goals in which a robot turns round once, before all others: it has to know its own surroundings."""
_WAY_SPARED = 1.0
"""The way (m) to the place from which an end of the map is seen is at most so much shorter than that to the end."""
_STANDPOINTS = 6
"""Places before an end of the map that are looked at to find one from which it can be seen."""


Choosing = Generator[None, None, "NextGoal"]
"""A choice in steps, one for each packet: all at once take too long in a large hall. It returns the goal."""


class NextGoal(NamedTuple):
    """Where to go next.

    Attributes:
        pose: the goal; None: nothing is left.
        reason: why, for people.
        with_heading: whether its heading counts.
        end: the end of the map (m) that the robot is to see from there; None if it goes for another reason.
        length: of the way there (m).
        doubts: whether `end` is no end, but a wall that the robot doubts.
    """

    pose: Optional[Pose]
    reason: str
    with_heading: bool = False
    end: Optional[Point] = None
    length: float = 0.0
    doubts: bool = False


class Doubt(NamedTuple):
    """Which walls are doubted: all that the robot was never near to, but for those that it went to look at.

    Attributes:
        path: x, y (m, map frame) where it has been, array (n, 2).
        looked: x, y (m) of the walls that it went to look at, whether it came there or not.
    """

    path: Array
    looked: Sequence[Point]


class _Attempt:
    """A goal on the way, and how it goes."""

    def __init__(self, goal: NextGoal, pose: Pose, time: float):
        self.goal = goal
        self.start = pose
        self.began = time
        self.moved, self.moved_at = pose, time      # where it last was elsewhere, and when (s)


class Explorer:
    """Explores: gives goal after goal, and home as the last.

    Args:
        home: where it ends (map frame).
        radius: distance (m) from walls that the middle of the robot keeps.
        numbers: what was tuned.
        narrow: the same when nothing else is left; None: as before.
    """

    def __init__(self, home: Pose, radius: float, numbers: ExploringNumbers = ExploringNumbers(),
                 narrow: Optional[float] = None) -> None:
        self._home, self._radius, self._numbers = home, radius, numbers
        self._narrow = radius if narrow is None else narrow
        self._given_up: List[Point] = []
        self._jam: Optional[Pose] = None        # where it did not get away, map frame
        self._not_from_jam: List[Point] = []    # the ends of the map that it did not get to from there
        self._tried: List[Point] = []
        self._looked: List[Point] = []
        self._looks = 0
        self._tries_again = True
        self._attempt: Optional[_Attempt] = None
        self._choosing: Optional[Choosing] = None
        self.homeward = False
        """Whether the present goal is home."""

    def next(self, grid_map: GridMap, pose: Pose, time: float, path: Optional[Array] = None) -> Optional[NextGoal]:
        """Return where to go now; None: it is not chosen yet, ask once more in the next packet. The map and the place
        at the begin of a choice count. Ask again when the robot is there, when it failed, or when it `is_over`.

        Args:
            grid_map: the map.
            pose: where the robot is (map frame).
            time: the time (s).
            path: x, y (m, map frame) where it has been, array (n, 2); None: no wall is doubted.
        """
        if self._choosing is None:
            doubts = path is not None and len(self._looked) < self._numbers.most_doubts
            self._choosing = self._choose(grid_map, pose, Doubt(path, self._looked) if doubts else None)
        try:
            next(self._choosing)
        except StopIteration as chosen:
            goal: NextGoal = chosen.value
            self._choosing, self._attempt = None, _Attempt(goal, pose, time)
            if goal.end is not None:
                (self._looked if goal.doubts else self._tried).append(goal.end)
            return goal
        return None

    def is_over(self, pose: Pose, time: float, grid_map: Optional[GridMap] = None) -> bool:
        """Return whether it is not worth while to drive on to the present goal: the end of the map is known meanwhile,
        or the robot does not get on. On its way home, time ends it, or that the robot got away from where it was
        jammed: then it is homeward no more.

        Args:
            pose: where the robot is (map frame).
            time: the time (s).
            grid_map: the map, when there is a newer one.
        """
        attempt, numbers = self._attempt, self._numbers
        if attempt is None or attempt.goal.end is None:
            if self.homeward and self._got_away(pose):
                self.homeward = False   # there is more to explore
                return True
            return attempt is not None and self.homeward and time - attempt.began > numbers.homeward
        if distance_between(pose, attempt.moved) > numbers.moved:
            attempt.moved, attempt.moved_at = pose, time
        return (time - attempt.moved_at > numbers.stuck
                or time - attempt.began > numbers.patience + numbers.patience_per_metre * attempt.goal.length
                or grid_map is not None and not attempt.goal.with_heading
                and self._is_known(grid_map, attempt.goal.end))

    def refused(self) -> None:
        """The present goal is one that the robot cannot go to."""
        if self._attempt is not None and self._attempt.goal.end is not None:
            if not self._attempt.goal.doubts:
                self._given_up.append(self._attempt.goal.end)
            self._attempt = None

    def held_up(self, time: float) -> None:
        """The robot must not move at this time (s): the time limits of the present goal begin anew."""
        if self._attempt is not None:
            self._attempt.began = self._attempt.moved_at = time

    def _give_up(self, end: Point, start: Pose, pose: Pose) -> None:
        """Give up an end of the map. Where the robot did not get away from its place, that is not the end's fault: then
        it is given up until the robot is elsewhere.
        """
        away = self._numbers.away
        if distance_between(pose, start) > away or math.hypot(end[0] - pose.x, end[1] - pose.y) < away:
            self._given_up.append(end)
        else:
            self._jam = pose
            self._not_from_jam.append(end)

    def _got_away(self, pose: Pose) -> bool:
        """Return whether the robot got away from where it was jammed. Then the ends that it did not get to from there
        are tried again.
        """
        if self._jam is None or distance_between(pose, self._jam) < self._numbers.away:
            return False
        self._jam, self._not_from_jam = None, []
        return True

    def _choose(self, grid_map: GridMap, pose: Pose, doubt: Optional[Doubt]) -> Choosing:
        self._got_away(pose)
        if self._looks < _LOOKS:
            self._looks += 1
            turned = wrapped(pose.heading + 2.0 * math.pi / _LOOKS)
            return NextGoal(Pose(pose.x, pose.y, turned), "to look round", True)
        attempt = self._attempt
        if (attempt is not None and attempt.goal.end is not None and not attempt.goal.doubts
                and not self._is_known(grid_map, attempt.goal.end)):
            x, y = end = attempt.goal.end
            if not attempt.goal.with_heading and math.hypot(x - pose.x, y - pose.y) < self._numbers.sees:
                looks = math.atan2(y - pose.y, x - pose.x)
                return NextGoal(Pose(pose.x, pose.y, looks), "to look at the end of the map", True, end)
            self._give_up(end, attempt.start, pose)
        goal = yield from next_goal(grid_map, pose, self._radius, self._left_alone(), self._numbers, doubt)
        if goal.pose is None and self._tries_again:
            # The map is better now, and it comes from elsewhere: what was given up gets one more chance. The walls of
            # the map may make a doorway narrower than it is.
            self._tries_again, self._given_up, self._tried, self._radius = False, [], [], self._narrow
            yield
            goal = yield from next_goal(grid_map, pose, self._radius, (), self._numbers, doubt)
        self.homeward = goal.pose is None
        return NextGoal(self._home, goal.reason + ": home", True) if self.homeward else goal

    def _is_known(self, grid_map: GridMap, end: Point) -> bool:
        """Return whether most cells round an end of the map are known now."""
        offs = np.arange(-3, 4) * grid_map.resolution
        x, y = np.meshgrid(end[0] + offs, end[1] + offs)
        return bool((grid_map.at(x, y) == UNKNOWN).mean() < self._numbers.still_unknown)

    def _left_alone(self) -> List[Point]:
        """Return the ends of the map that are left alone: those given up, and those tried too often."""
        near = self._numbers.given_up / 2.0
        return self._given_up + self._not_from_jam + [end for end in self._tried if sum(
            math.hypot(end[0] - other[0], end[1] - other[1]) < near for other in self._tried) > self._numbers.tries]


def with_driven_floor(grid_map: GridMap, path: Array, radius: float) -> GridMap:
    """Return a map that is free wherever a robot has driven.

    Args:
        grid_map: the map.
        path: x, y (m, map frame) of the robot's middle, array (n, 2).
        radius: how far (m) from there it is free.
    """
    step = grid_map.resolution
    reach = math.floor(radius / step)
    up, right = np.mgrid[-reach:reach + 1, -reach:reach + 1]
    disc = np.argwhere(np.hypot(up, right) * step <= radius)
    rows, columns = grid_map.cells.shape
    row, column = grid_map.cell(path[:, 0], path[:, 1])
    near = (row >= -reach) & (row < rows + reach) & (column >= -reach) & (column < columns + reach)
    driven = np.zeros((rows + 4 * reach, columns + 4 * reach), dtype=bool)
    driven[row[near] + 2 * reach, column[near] + 2 * reach] = True
    free = np.zeros((rows, columns), dtype=bool)
    for first_row, first_column in disc + reach:
        free |= driven[first_row:first_row + rows, first_column:first_column + columns]
    cells = grid_map.cells.copy()
    cells[free] = FREE
    return GridMap(cells, step, grid_map.origin)


class _ExploredFloor(NamedTuple):
    """What a robot that explores knows of the floor.

    `grid` has unknown cells round it. `to_wall` is the distance (m) of its cells from walls; `open_unknown` and
    `reached` say which cells have room for the robot and are unknown, or can be reached; `edge` says which of the
    unknown ones lie beside those; `way` is the length (m) of the way to those that can be reached.
    """

    grid: GridMap
    to_wall: Array
    open_unknown: Array
    edge: Array
    reached: Array
    way: Array


def next_goal(grid_map: GridMap, pose: Pose, radius: float, given_up: Sequence[Point] = (),
              numbers: ExploringNumbers = ExploringNumbers(), doubt: Optional[Doubt] = None) -> Choosing:
    """Choose the end of the map that is worth its way most; when there is none, a wall that is doubted.

    Args:
        grid_map: the map as it is now.
        pose: where the robot is (map frame).
        radius: distance (m) from walls that its middle needs.
        given_up: x, y (m) of ends of the map that are left alone.
        numbers: what was tuned.
        doubt: which walls are doubted; None: none.

    Returns:
        In steps: a pose on known floor before the end of the map, looking at it; or no pose, and why.
    """
    floor = yield from _floor(grid_map, pose, radius, numbers)
    if not floor.reached.any():
        return NextGoal(None, "no known floor with room for the robot is near it")
    yield
    ends, alone = _ends(floor, given_up, numbers)
    if len(ends):
        return _best(floor, ends, pose, radius, numbers)
    if doubt is not None:
        yield
        doubted = _doubted(floor, doubt.path, radius, numbers)
        walls, _ = _ends(doubted, doubt.looked, replace(numbers, least_width=numbers.doubted_width))
        if len(walls):
            return _best(doubted, walls, pose, radius, numbers)._replace(
                reason="to look from near at a wall that was heard from afar", with_heading=True, doubts=True)
    return NextGoal(None, "all that can be reached is known" + (
        ", but for %d places that were given up" % len(given_up) if alone else ""))


def _best(floor: _ExploredFloor, ends: Array, pose: Pose, radius: float, numbers: ExploringNumbers) -> NextGoal:
    """Choose among some ends of the map the one that is most worth its way. Return the goal from which it is seen."""
    step = floor.grid.resolution
    width = 2 * round(numbers.view / step) + 1
    gains = uniform_filter(floor.open_unknown.astype(np.float32), width, mode="constant") * (width * step) ** 2
    seen_from = _Standpoints(floor, radius + numbers.comfort)
    gain = numbers.gain * np.minimum(gains[tuple(ends.T)], numbers.most_gain)
    least = _way_beside(floor.way, ends) - _WAY_SPARED - gain
    best, best_cost = NextGoal(None, ""), math.inf
    for number in np.argsort(least, kind="stable"):
        if least[number] > best_cost:
            break
        row, column = ends[number]
        x, y = (float(each) for each in floor.grid.middle(row, column))
        goal_row, goal_column = seen_from.best(row, column)
        goal_x, goal_y = (float(each) for each in floor.grid.middle(goal_row, goal_column))
        length = float(floor.way[goal_row, goal_column])
        turn = abs(wrapped(math.atan2(goal_y - pose.y, goal_x - pose.x) - pose.heading)) if length > radius else 0.0
        cost = length + numbers.turn * turn - float(gain[number])
        if cost < best_cost:
            best_cost, best = cost, NextGoal(
                Pose(goal_x, goal_y, math.atan2(y - goal_y, x - goal_x)),
                "to an end of the map, %.1f m away: %.1f m^2 are unknown there" % (length, gains[row, column]), False,
                (x, y), length)
    return best


def _way_beside(way: Array, ends: Array) -> Array:
    """Return the least length (m) of the way to the cells beside each end of the map, array (n)."""
    rows, columns = way.shape
    beside = [way[np.clip(ends[:, 0] + up, 0, rows - 1), np.clip(ends[:, 1] + right, 0, columns - 1)]
              for up, right in EIGHT_STEPS]
    return np.min(beside, axis=0)


def _floor(grid_map: GridMap, pose: Pose, radius: float,
           numbers: ExploringNumbers) -> Generator[None, None, _ExploredFloor]:
    """Find what is known of the floor. In two steps: the room beside walls, then the ways."""
    cells, here = _with_room_to_stand(grid_map, pose, radius + numbers.off_floor)
    grid = GridMap(cells, grid_map.resolution, here)
    to_wall = distance_transform_edt(np.pad(cells != OCCUPIED, 1, constant_values=True))[1:-1, 1:-1] * grid.resolution \
        if (cells == OCCUPIED).any() else np.full(cells.shape, np.inf)
    room = to_wall > radius
    yield
    way, reached = _ways(room & (cells == FREE), grid, pose, numbers.off_floor)
    open_unknown = room & (cells == UNKNOWN)
    edge = open_unknown & binary_dilation(reached, _ALL_ROUND)
    return _ExploredFloor(grid, to_wall, open_unknown, edge, reached, way)


def _doubted(floor: _ExploredFloor, path: Array, radius: float, numbers: ExploringNumbers) -> _ExploredFloor:
    """Return the floor as it were if the walls that the robot was never near to were unknown.

    Its edge is those of these walls that keep the robot off. Where it cannot go, the way is that to the nearest floor
    where it can.
    """
    grid = floor.grid
    rows, columns = np.nonzero(grid.cells == OCCUPIED)
    away, _ = cKDTree(path).query(np.stack(grid.middle(rows, columns), axis=1), distance_upper_bound=numbers.near)
    far = np.zeros_like(floor.reached)
    far[rows, columns] = np.isinf(away)
    off, nearest = distance_transform_edt(~floor.reached, return_indices=True)
    return floor._replace(grid=GridMap(np.where(far, UNKNOWN, grid.cells), grid.resolution, grid.origin),
                          edge=far & (off * grid.resolution < radius + 2.0 * grid.resolution),
                          way=floor.way[tuple(nearest)])


def _ends(floor: _ExploredFloor, given_up: Sequence[Point], numbers: ExploringNumbers) -> Tuple[Array, bool]:
    """Return the ends of the map in pieces, as rows and columns of their middle cells, array (n, 2); and whether some
    were left alone.
    """
    numbered, count = label(floor.edge, _ALL_ROUND)
    rows, columns = np.nonzero(floor.edge)
    part = numbered[rows, columns] - 1
    low, high = np.full((2, count), 10 ** 9), np.full((2, count), -10 ** 9)
    for axis, values in enumerate((rows, columns)):
        np.minimum.at(low[axis], part, values)
        np.maximum.at(high[axis], part, values)
    wide = ((high - low + 1).max(axis=0) * floor.grid.resolution >= numbers.least_width)[part]
    x, y = floor.grid.middle(rows, columns)
    alone = np.zeros(len(rows), dtype=bool)
    for end in given_up:
        alone |= np.hypot(x - end[0], y - end[1]) < numbers.given_up
    kept = np.nonzero(wide & ~alone)[0]
    # Pieces lie on a lattice that is fixed to the floor: they stay the same when the map grows.
    key = np.stack((part[kept], np.floor(x[kept] / numbers.piece), np.floor(y[kept] / numbers.piece)))
    _, piece = np.unique(key, axis=1, return_inverse=True)
    middles = []
    for number in range(piece.max(initial=-1) + 1):
        cells = kept[piece.ravel() == number]
        middles.append(cells[int(np.hypot(x[cells] - x[cells].mean(), y[cells] - y[cells].mean()).argmin())])
    return np.stack((rows[middles], columns[middles]), axis=1) if middles else np.zeros((0, 2), int), \
        bool((wide & alone).any())


class _Standpoints:
    """The places from which ends of the map can be seen: such with ample room, if there are any near."""

    def __init__(self, floor: _ExploredFloor, ample: float) -> None:
        self._cells, self._reached = floor.grid.cells, floor.reached
        self._ample = floor.reached & (floor.to_wall > ample)
        self._most = 0.6 / floor.grid.resolution
        self._beside = ample / floor.grid.resolution + 2.0

    def best(self, row: int, column: int) -> Tuple[int, int]:
        """Return the cell from which an end of the map, a cell, is seen best."""
        near = _nearest(self._ample, row, column, self._most)[:_STANDPOINTS]
        for here in near[self._see(near, row, column)]:
            return int(here[0]), int(here[1])
        # An end of the map touches what can be reached; a wall is as far from it as the robot keeps.
        beside = _nearest(self._reached, row, column, self._beside)[0]
        return int(beside[0]), int(beside[1])

    def _see(self, places: Array, row: int, column: int) -> Array:
        """Return whether there is no wall between a cell and each of some others, array (n, 2) of row and column."""
        share = np.linspace(0.0, 1.0, 25)[:, None]
        rows, columns = (np.round(places[:, axis] + share * (there - places[:, axis])).astype(int)
                         for axis, there in enumerate((row, column)))
        return ~(self._cells[rows, columns] == OCCUPIED).any(axis=0)


def _nearest(which: Array, row: int, column: int, most: float) -> Array:
    """Return the cells of a mask that are at most so many cells away from one, array (n, 2), the nearest first."""
    reach = math.floor(most)
    low_row, low_column = max(0, row - reach), max(0, column - reach)
    found = np.argwhere(which[low_row:row + reach + 1, low_column:column + reach + 1]) + (low_row, low_column)
    away = np.hypot(*(found - (row, column)).T)
    order = np.argsort(away, kind="stable")
    return found[order[:int((away <= most).sum())]]


def _with_room_to_stand(grid_map: GridMap, pose: Pose, margin: float) -> Tuple[Array, Tuple[float, float]]:
    """Return the cells with unknown ones round them, and their origin. The robot stands inside, on a free cell."""
    step = grid_map.resolution
    low_x, low_y, high_x, high_y = grid_map.bounds
    before = [max(1, math.ceil((low - at + margin) / step)) for low, at in ((low_y, pose.y), (low_x, pose.x))]
    after = [max(1, math.ceil((at + margin - high) / step)) for high, at in ((high_y, pose.y), (high_x, pose.x))]
    cells = np.pad(grid_map.cells, tuple(zip(before, after)), constant_values=UNKNOWN)
    origin = grid_map.origin[0] - before[1] * step, grid_map.origin[1] - before[0] * step
    x, y = GridMap(cells, step, origin).middle(*map(np.arange, cells.shape))
    near = np.hypot(x - pose.x, (y - pose.y)[:, None]) < margin / 2.0
    cells[near & (cells == UNKNOWN)] = FREE
    return cells, origin


def _ways(floor: Array, grid: GridMap, pose: Pose, off_floor: float) -> Tuple[Array, Array]:
    """Return the length (m) of the way to each cell of the floor, and which cells can be reached."""
    rows, columns = np.nonzero(floor)
    if not len(rows):
        return np.zeros(floor.shape), floor
    x, y = grid.middle(rows, columns)
    away = np.hypot(x - pose.x, y - pose.y)
    start = int(away.argmin())
    if away[start] > off_floor:
        return np.zeros(floor.shape), np.zeros_like(floor)
    parts, _ = label(floor, _ALL_ROUND)
    reached = parts == parts[rows[start], columns[start]]
    # Lengths need not be as fine as the map: squares of two cells take a fifth of the time.
    even = np.pad(reached, tuple((0, size % 2) for size in reached.shape))
    square = even[::2, ::2] | even[1::2, ::2] | even[::2, 1::2] | even[1::2, 1::2]
    number = np.where(square, np.cumsum(square).reshape(square.shape) - 1, -1)
    net = net_of(number, 2.0 * grid.resolution, EIGHT_STEPS)
    lengths = np.full(square.shape, np.inf)
    lengths[square] = dijkstra(net.matrix(net.length), indices=int(number[rows[start] // 2, columns[start] // 2]))
    way = lengths.repeat(2, axis=0).repeat(2, axis=1)[:floor.shape[0], :floor.shape[1]]
    return np.where(reached, way, np.inf), reached
