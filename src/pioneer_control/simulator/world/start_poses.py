"""Finds start poses for many robots: first the starts of the world, then places that are spread over the free floor."""

import math
import random
from typing import List, Sequence

import numpy as np

from ...errors import ParameterError
from ...robots import RobotModel
from .geometry import Array
from .grids import flood
from .poses import Point, Pose, hypot, unit
from .world import World

RESOLUTION = 0.05
"""Side (m) of a cell of the grid that is searched for free places."""
MARGIN = 0.1
"""Width (m) of the free floor that is kept around every robot. With it a robot can turn on the spot."""
FAR = 2.5
"""Distance (m) from a wall, a post or a can beyond which a place is not better for being still farther away."""
DIRECTIONS = 16
"""Number of headings among which the heading of a robot is chosen."""
LOOK_AHEAD = 3.0
"""Length (m) of the free way ahead beyond which a heading is not better for a longer one."""


def standing_places(world: World, model: RobotModel, count: int) -> List[Pose]:
    """Return start poses (m, rad; map frame) for `count` robots.

    The starts of the world come first. If they are too few, the other robots are spread over the free floor that can
    be reached from a start, and head to where their way is free. If the floor is too full for that, they stand in rows,
    as near to the first start as they can.

    Raises:
        ParameterError: the world has no room for `count` robots. The message says for how many it has room.
    """
    starts = world.starts[:count]
    if len(starts) == count:
        return starts
    floor = _Floor(world, model, count)
    places = floor.spread(count)
    if len(places) < count:
        places = max(floor.in_rows(count), places, key=len)     # of two equally long lists, the rows
    if len(places) < count:
        raise ParameterError("the world %r has room for %s robots of the model %s, not for %s"
                             % (world.name, len(places), model.subtype, count))
    return starts + [(x, y, floor.heading((x, y), places)) for x, y in places[len(starts):]]


def random_places(world: World, model: RobotModel, count: int, seed: int) -> List[Pose]:
    """Return random start poses (m, rad; map frame) for `count` robots, on floor that can be reached from a start.

    Each robot can turn where it stands. The same seed gives the same poses.

    Raises:
        ParameterError: no room is left. The message says for how many robots there was room.
    """
    floor, rng = _Floor(world, model, count), random.Random("starts %s" % seed)
    places = floor.at_random(count, rng)
    if len(places) < count:
        raise ParameterError("the world %r has room for %s robots of the model %s at random places, not for %s"
                             % (world.name, len(places), model.subtype, count))
    return [(x, y, rng.uniform(-math.pi, math.pi)) for x, y in places]


class _Floor:
    """The floor of a world as a grid of points. The first start is one of the points.

    A place has room for a robot if the robot can turn there and keeps `MARGIN` from everything.

    Args:
        world: the world. All its starts are taken.
        model: model of the robots.
        count: number of robots. On a floor without walls, the grid has room for so many.
    """

    def __init__(self, world: World, model: RobotModel, count: int):
        self._starts = [(x, y) for x, y, _ in world.starts]
        self._first_heading = world.starts[0][2]
        outline = model.outline(model.can_carry_gripper)
        self._radius = max(hypot(x, y) for x, y in outline) + MARGIN
        narrowest = max(abs(y) for _, y in outline) + MARGIN    # half the width of a way that a robot can drive
        self._pitch = math.ceil(2.0 * self._radius / RESOLUTION)    # least distance between two robots, in cells
        x0, y0 = self._starts[0]
        low_x, low_y, high_x, high_y = world.bounds
        beyond = (math.isqrt(count) + 2) * self._pitch      # cells to add on each side: enough for all on open floor
        self._columns, self._rows = [
            np.arange(math.floor((low - at) / RESOLUTION) - beyond, math.ceil((high - at) / RESOLUTION) + beyond + 1)
            for low, high, at in ((low_x, high_x, x0), (low_y, high_y, y0))
        ]
        self._x, self._y = x0 + self._columns * RESOLUTION, y0 + self._rows * RESOLUTION
        clearance = world.clearances(self._x, self._y, limit=FAR)
        passable = clearance >= narrowest       # a robot can push cans out of its way
        near_start = np.any([(np.abs(self._x - x) <= narrowest) & (np.abs(self._y - y) <= narrowest)[:, None]
                             for x, y in self._starts], axis=0)
        self._room = np.where(flood(near_start & passable, passable), clearance, 0.0)
        for can in world.cans:
            _limit(self._room, self._x, self._y, (can.x, can.y), FAR + can.radius, 1.0, -can.radius)
        self._free = self._room >= self._radius

    def spread(self, count: int) -> List[Point]:
        """Return the places (m, map frame) of the starts and of more robots, `count` or as many as there is room for.

        Every robot gets a circle of floor of its own. The next robot always stands in the middle of the largest circle
        that is still free.
        """
        columns, rows = self._columns % 2 == 0, self._rows % 2 == 0     # every second point is exact enough
        x, y, places = self._x[columns], self._y[rows], list(self._starts)
        room = self._room[np.ix_(rows, columns)]
        room[room >= FAR] = math.inf
        largest = math.inf
        for place in places:
            _limit(room, x, y, place, largest, 0.5)
        while len(places) < count:
            row, column = np.unravel_index(int(np.argmax(room)), room.shape)
            largest = float(room[row, column])
            if largest < self._radius:
                break
            places.append((float(x[column]), float(y[row])))
            _limit(room, x, y, places[-1], 2.0 * largest, 0.5)
        return places

    def at_random(self, count: int, rng: random.Random) -> List[Point]:
        """Return random places (m, map frame) for robots, `count` or as many as there is room for.

        Where there are no walls, the places are on the grid around the starts.
        """
        room = self._free.copy()
        places: List[Point] = []
        while len(places) < count and room.any():
            rows, columns = np.nonzero(room)
            chosen = int(rng.random() * len(rows))
            x, y = float(self._x[columns[chosen]]), float(self._y[rows[chosen]])
            places.append((x, y))
            to_x, to_y = self._x - x, (self._y - y)[:, None]
            room &= to_x * to_x + to_y * to_y >= 4.0 * self._radius * self._radius
        return places

    def in_rows(self, count: int) -> List[Point]:
        """Return the places (m, map frame) of the starts and of more robots, `count` or as many as there is room for.

        The robots stand in rows and columns, as near to each other as they may. Those near the first start come first.
        """
        columns, rows = self._columns % self._pitch == 0, self._rows % self._pitch == 0
        free = self._free[np.ix_(rows, columns)]
        places = [(float(x), float(y)) for row, y in zip(free, self._y[rows]) for x in self._x[columns][row]]
        apart = [place for place in places
                 if all(_distance(place, other) >= 2.0 * self._radius for other in self._starts)]
        return [*self._starts, *sorted(apart, key=lambda place: (_distance(place, self._starts[0]), place))][:count]

    def heading(self, place: Point, robots: Sequence[Point]) -> float:
        """Return the heading (rad) in which a robot at `place` has the longest free way.

        Of equally long ways, the first counter-clockwise from the heading of the first start is taken. `robots` are the
        places (m, map frame) of all robots.
        """
        others = np.array([other for other in robots
                           if other != place and _distance(place, other) < LOOK_AHEAD + 2.0 * self._radius])
        headings = [self._first_heading + 2.0 * math.pi * number / DIRECTIONS for number in range(DIRECTIONS)]
        ways = [self._free_way(place, unit(heading), others.reshape(-1, 2)) for heading in headings]
        return headings[ways.index(max(ways))]

    def _free_way(self, place: Point, direction: Point, others: Array) -> int:
        """Return how many cells a robot at `place` can drive in a direction (a unit vector), up to `LOOK_AHEAD`.

        `others` are the places of the other robots that are near, as an array (n, 2).
        """
        ahead = np.arange(math.ceil(LOOK_AHEAD / RESOLUTION)) * RESOLUTION
        x, y = place[0] + ahead * direction[0], place[1] + ahead * direction[1]
        column = np.floor((x - self._x[0]) / RESOLUTION + 0.5).astype(int)
        row = np.floor((y - self._y[0]) / RESOLUTION + 0.5).astype(int)
        inside = (column >= 0) & (column < len(self._x)) & (row >= 0) & (row < len(self._y))
        blocked = inside.copy()     # beyond the grid there is open floor
        blocked[inside] = ~self._free[row[inside], column[inside]]
        to_x, to_y = others[:, 0] - x[:, None], others[:, 1] - y[:, None]
        blocked |= np.any(to_x * to_x + to_y * to_y < 4.0 * self._radius * self._radius, axis=1)
        return int(np.argmax(blocked)) if blocked.any() else len(ahead)


def _limit(
    room: Array, column_x: Array, row_y: Array, place: Point, reach: float, share: float, less: float = 0.0,
) -> None:
    """Limit the values of a grid to `share` of the distance from `place`, and add `less` to that limit.

    Args:
        room: the grid (rows, columns), which is changed.
        column_x: x of the columns (m), in increasing order.
        row_y: y of the rows (m), in increasing order.
        place: the place (m).
        reach: distance from the place (m) beyond which no value is changed.
        share: factor of the distance.
        less: length (m) that is added to the limit.
    """
    x, y = place
    columns = slice(*np.searchsorted(column_x, (x - reach, x + reach)))
    rows = slice(*np.searchsorted(row_y, (y - reach, y + reach)))
    to_x, to_y = column_x[None, columns] - x, row_y[rows, None] - y
    limit = share * np.sqrt(to_x * to_x + to_y * to_y) + less
    room[rows, columns] = np.minimum(room[rows, columns], limit)


def _distance(first: Point, second: Point) -> float:
    return hypot(first[0] - second[0], first[1] - second[1])
