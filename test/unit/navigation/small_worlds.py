"""Small worlds made by hand, and what a robot senses in them, for tests of localisation."""

import math

import numpy as np

from pioneer_control.floor_poses import Pose, compose, relative
from pioneer_control.maps import FREE, OCCUPIED, UNKNOWN, GridMap
from pioneer_control.navigation.expected_ranges import Beam
from pioneer_control.navigation.values import Firing, Scan, Sensing
from pioneer_control.robots import find_model
from pioneer_control.simulator.world import World
from pioneer_control.simulator.world.poses import unit

RAY = Beam(0.0, 8.0, 180, 1, 0.04)
"""A sensor that looks along one line."""
HALF_CONE = math.radians(12.5)
TRANSDUCERS = find_model("p3dx-sh").sonar


def rectangle(x, y, width, depth):
    """Return the four walls of a rectangle."""
    corners = [(x, y), (x + width, y), (x + width, y + depth), (x, y + depth)]
    return [one + other for one, other in zip(corners, corners[1:] + corners[:1])]


# a room like no other: 6 x 4 m, with a niche, a pillar and a slanting wall
ROOM = World("room", walls=rectangle(0, 0, 6, 4) + rectangle(2.2, 3.0, 0.6, 1.0) + rectangle(4.5, 0.0, 0.4, 1.2)
             + [(0.0, 1.2, 1.0, 0.0)], posts=[(1.2, 2.7, 0.1)], starts=[(3.0, 1.8, 0.0)])


def map_of(world):
    """Return the map of a world."""
    cells, origin = world.occupancy(0.05)
    return GridMap(cells, 0.05, origin)


def square_map(side_cells, resolution=0.05):
    """Return a map of a free square room with walls of one cell. Its corner is at 0, 0."""
    cells = np.full((side_cells, side_cells), FREE, dtype=np.int8)
    cells[[0, -1], :] = cells[:, [0, -1]] = OCCUPIED
    return GridMap(cells, resolution, (0.0, 0.0))


class SensingRobot:
    """A robot that moves as it is told, and whose odometry is exact but for what `odometry_error` multiplies turns by.

    Attributes:
        pose: its true pose.
        deaf: no transducer hears anything.
    """

    def __init__(self, world, pose, odometry_error=1.0, seed=1):
        self.pose, self.odometry, self.time, self.deaf = pose, Pose(0.0, 0.0, 0.0), 0.0, False
        self._ear, self._error = world.ear(HALF_CONE, 5.0, math.inf), odometry_error
        self._next, self._luck = 0, np.random.default_rng(seed)

    def step(self, way=0.04, turn=0.0):
        """Move for 0.1 s, and return what is sensed then."""
        motion = Pose(way * math.cos(turn / 2), way * math.sin(turn / 2), turn)
        self.pose = compose(self.pose, motion)
        self.odometry = compose(self.odometry, motion._replace(heading=turn * self._error))
        self.time += 0.1
        return Sensing(self.time, self.odometry, tuple(self._fired() for _ in range(5)))

    def _fired(self):
        transducer = TRANSDUCERS[self._next % len(TRANSDUCERS)]
        self._next += 5
        at = compose(self.pose, Pose(*transducer[1:]))
        heard = self._ear.echo(at.x, at.y, at.heading, unit(at.heading - HALF_CONE), unit(at.heading + HALF_CONE))
        heard = heard + self._luck.normal(0.0, 0.02) if heard < 5.0 and not self.deaf else math.inf
        return Firing(transducer.number, heard, self.time)

    def scan(self, mount=Pose(0.1, 0.0, 0.0)):
        """Return a scan of the true world: 181 rays over half a turn."""
        at = compose(self.pose, mount)
        ear = self._narrow
        ranges = []
        for degrees in range(-90, 91):
            to = at.heading + math.radians(degrees)
            heard = ear.echo(at.x, at.y, to, unit(to - 0.002), unit(to + 0.002))
            ranges.append(heard + self._luck.normal(0.0, 0.01) if heard < 8.0 else math.inf)
        return Scan(self.time, self.odometry, mount, -math.pi / 2, math.radians(1), ranges)

    def with_laser(self, world):
        """Return this robot, able to scan."""
        self._narrow = world.ear(0.002, 8.0, math.inf)
        return self


def off(where, robot):
    """Return how far (m) and how much (rad) the pose of a `Where` is off the robot's true one."""
    error = relative(where.pose, robot.pose)
    return math.hypot(error.x, error.y), abs(error.heading)


def unknown_map():
    """Return a map of which nothing is known."""
    return GridMap(np.full((40, 40), UNKNOWN, dtype=np.int8), 0.05, (0.0, 0.0))
