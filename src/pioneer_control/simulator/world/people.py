"""People who walk about in a world: obstacles to robots, and heard by sonar. A person is an upright disc, the legs.

A person looks: in front of a robot that is in the way, the person waits, and after a while goes somewhere else. A
blind person walks on until the robot is touched. People do not push robots, and pass each other freely.

Lengths are in metres, speeds in m/s, times in simulated seconds, coordinates in the map frame.
"""

import math
import random
from typing import List, Optional, Sequence, Set, Tuple

import numpy as np

from ...errors import WorldError
from .crowd import Candidate, Obstacle
from .geometry import Array, Block, outlines_meet
from .grids import flood
from .materials import Material
from .poses import Point, Pose, hypot, unit
from .world import Walk, World

RADIUS = 0.25
"""Radius (m) of a person."""
LOOKS_AHEAD = 0.4
"""Distance (m) ahead at which a person who looks sees a robot in the way, and waits."""
PATIENCE = 3.0
"""Time (s) that a person waits at a robot. Then the person goes somewhere else."""
APART = 0.02
"""Distance (m) that a person and a robot must be apart before the person can touch the robot again."""
TO_WALLS = 0.1
"""Least distance (m) that a person who walks to random places keeps from walls and posts."""
TO_STARTS = 1.5
"""Least distance (m) between the start of a robot and the place where such a person first stands, if there is room."""
RESOLUTION = 0.1
"""Side (m) of a cell of the grid on which people find their ways."""
CORNERS = 16
"""Corners of the outline that stands for the disc in collisions."""

_ROUND = [unit(2.0 * math.pi * number / CORNERS) for number in range(CORNERS)]


class Footways:
    """The floor on which people walk to random places: all that can be reached from a start, as a grid.

    Args:
        world: the world.

    Raises:
        WorldError: there is no such floor.
    """

    def __init__(self, world: World):
        low_x, low_y, high_x, high_y = world.bounds
        self._x = np.arange(low_x, high_x + RESOLUTION, RESOLUTION)
        self._y = np.arange(low_y, high_y + RESOLUTION, RESOLUTION)
        room = world.clearances(self._x, self._y, limit=RADIUS + TO_WALLS) >= RADIUS + TO_WALLS
        starts = np.zeros_like(room)
        for x, y, _ in world.starts:
            starts |= (abs(self._x - x) < 0.3) & (abs(self._y - y) < 0.3)[:, None]
        free = flood(starts, room)
        if not free.any():
            raise WorldError("world %s: nobody can walk from a start" % world.name)
        self._width = len(self._x) + 2
        self._free = np.pad(free, 1).ravel()    # a border of occupied cells stops every search
        self._cells = np.flatnonzero(self._free).tolist()
        self._starts = [(x, y) for x, y, _ in world.starts]

    def any_place(self, rng: random.Random) -> Point:
        """Return a random place."""
        return self._point(self._cells[int(rng.random() * len(self._cells))])

    def first_place(self, rng: random.Random) -> Point:
        """Return a random place, away from the starts of robots if there is room."""
        places = [self.any_place(rng) for _ in range(30)]
        return max(places, key=lambda place: min(
            TO_STARTS, *(hypot(place[0] - x, place[1] - y) for x, y in self._starts)))

    def way(self, begin: Point, end: Point) -> List[Point]:
        """Return a short way between two places on this floor, as its corners after `begin`."""
        cell, steps = self._cell(begin), self._steps_to(self._cell(end))
        line = [cell]
        while steps[cell] > 0:
            cell = min((cell + side for side in (1, -1, self._width, -self._width) if steps[cell + side] >= 0),
                       key=lambda each: int(steps[each]))
            line.append(cell)
        way, at = [], 0
        while at < len(line) - 1:
            ahead = next(each for each in range(len(line) - 1, at, -1)
                         if each == at + 1 or self._in_sight(self._point(line[at]), self._point(line[each])))
            way.append(self._point(line[ahead]))
            at = ahead
        return way or [end]

    def _steps_to(self, cell: int) -> Array:
        """Return the number of steps over free cells from every cell to one of them. -1 where there is no way."""
        steps = np.full(len(self._free), -1)
        front, count = np.array([cell]), 0
        while len(front):
            steps[front] = count
            count += 1
            beside = (front[:, None] + np.array([1, -1, self._width, -self._width])).ravel()
            front = np.unique(beside[self._free[beside] & (steps[beside] < 0)])
        return steps

    def _in_sight(self, begin: Point, end: Point) -> bool:
        """Return whether the straight way between two places is free."""
        count = max(2, math.ceil(hypot(end[0] - begin[0], end[1] - begin[1]) / (0.5 * RESOLUTION)))
        share = np.arange(count + 1) / count
        column = np.floor((begin[0] + share * (end[0] - begin[0]) - self._x[0]) / RESOLUTION + 0.5).astype(int) + 1
        row = np.floor((begin[1] + share * (end[1] - begin[1]) - self._y[0]) / RESOLUTION + 0.5).astype(int) + 1
        return bool(self._free[row * self._width + column].all())

    def _cell(self, place: Point) -> int:
        column = math.floor((place[0] - float(self._x[0])) / RESOLUTION + 0.5) + 1
        return (math.floor((place[1] - float(self._y[0])) / RESOLUTION + 0.5) + 1) * self._width + column

    def _point(self, cell: int) -> Point:
        row, column = divmod(cell, self._width)
        return float(self._x[column - 1]), float(self._y[row - 1])


class Walker:
    """A person who walks, as an obstacle to robots.

    Args:
        world: the world in which the person walks.
        walk: how the person walks.
        footways: the floor for random ways. None if the walk has a path.

    Attributes:
        pose: where the person stands (m; map frame). The heading is always 0.
        reach: radius of the person (m).
        box: square with which the person stops cans (m).
        material: what light finds at the person.
    """

    def __init__(self, world: World, walk: Walk, footways: Optional[Footways]):
        self._world, self._walk, self._footways = world, walk, footways
        self._random = random.Random("person %s" % walk.seed)
        begin = footways.first_place(self._random) if footways else walk.path[0]
        self.pose: Pose = (*begin, 0.0)
        self.reach = RADIUS
        self.material = Material.PERSON
        self.box = Block(-RADIUS, RADIUS, -RADIUS, RADIUS)
        self._path = list(walk.path)    # in the direction in which it is walked now
        self._way: List[Point] = list(walk.path[1:])
        self._rest = self._waited = 0.0
        self._touching: Set[Obstacle] = set()

    @property
    def outline(self) -> List[Point]:
        """The corners that stand for the person in collisions (m, map frame)."""
        return _round(self.pose[:2], RADIUS)

    @property
    def candidates(self) -> Sequence[Candidate]:
        """What sonar detects of the person: a post."""
        return [(0.0, self.pose[0], self.pose[1], RADIUS, 0.0, -1.0)]

    def step(self, dt: float) -> List[Obstacle]:
        """Walk for `dt` seconds. Return the bodies of robots that the person has touched now and not before."""
        if self._rest > 0.0:
            self._rest -= dt
            return []
        if not self._way:
            self._turn()
        place, way = self._next(dt * self._walk.speed)
        met = self._robots_at(place, RADIUS)
        touched = [body for body in met if self._walk.blind and body not in self._touching]
        self._touching.update(touched)
        self._touching.intersection_update(self._robots_at(self.pose[:2], RADIUS + APART) + met)
        if met or not self._walk.blind and self._sees_robot(place):
            self._waited += dt
            if self._waited > PATIENCE:
                self._waited = 0.0
                self._turn()
            return touched
        self._waited = 0.0
        self.pose = (*place, 0.0)
        self._way = way
        if not way:
            self._rest = self._walk.pause
        self._world.crowd.moved(self)
        return touched

    def _next(self, distance: float) -> Tuple[Point, List[Point]]:
        """Return the place at a distance (m) along the way, and the rest of the way from there."""
        (x, y), way = self.pose[:2], self._way
        while way:
            to_x, to_y = way[0][0] - x, way[0][1] - y
            length = hypot(to_x, to_y)
            if length > distance:
                return (x + to_x * distance / length, y + to_y * distance / length), way
            (x, y), way, distance = way[0], way[1:], distance - length
        return (x, y), []

    def _turn(self) -> None:
        """Choose where to go next: back along the path, or to a random place."""
        if self._footways:
            self._way = self._footways.way(self.pose[:2], self._footways.any_place(self._random))
        else:
            walked = len(self._path) - len(self._way)
            self._path, self._way = self._path[::-1], self._path[:walked][::-1]
            if self._way and self._way[0] == self.pose[:2]:
                del self._way[0]

    def _sees_robot(self, place: Point) -> bool:
        """Return whether a robot is in the way to the next `place`, a little farther on."""
        x, y, _ = self.pose
        length = hypot(place[0] - x, place[1] - y)
        share = LOOKS_AHEAD / length if length > 0.0 else 0.0
        return bool(self._robots_at((x + share * (place[0] - x), y + share * (place[1] - y)), RADIUS))

    def _robots_at(self, place: Point, radius: float) -> List[Obstacle]:
        """Return the bodies of robots that overlap a disc."""
        return [body for body in self._world.crowd.near(*place, radius, self)
                if not isinstance(body, Walker) and _near(body, place, radius)
                and outlines_meet(_round(place, radius), body.outline)]


def people_of(world: World) -> List[Walker]:
    """Return the people who walk in a world.

    Raises:
        WorldError: the path of a person leads too near to a wall or a post, or there is no floor for random ways.
    """
    footways = None if all(walk.path for walk in world.walks) else Footways(world)
    for number, walk in enumerate(world.walks, 1):
        for place in _along(walk.path):
            if world.clearance(*place) < RADIUS:
                raise WorldError("world %s: walker %d would touch a wall or a post at x %.2f, y %.2f: a person needs"
                                 " %g m on each side" % (world.name, number, *place, RADIUS))
    return [Walker(world, walk, None if walk.path else footways) for walk in world.walks]


def _along(path: Sequence[Point]) -> List[Point]:
    """Return points along a path, not farther than a tenth of a metre from each other."""
    points = list(path[:1])
    for (x1, y1), (x2, y2) in zip(path, path[1:]):
        count = math.ceil(hypot(x2 - x1, y2 - y1) / 0.1)
        points += [(x1 + (x2 - x1) * each / count, y1 + (y2 - y1) * each / count) for each in range(1, count + 1)]
    return points


def _near(body: Obstacle, place: Point, radius: float) -> bool:
    return hypot(body.pose[0] - place[0], body.pose[1] - place[1]) < body.reach + radius


def _round(place: Point, radius: float) -> List[Point]:
    """Return the corners of a polygon in a disc."""
    return [(place[0] + radius * x, place[1] + radius * y) for x, y in _ROUND]
