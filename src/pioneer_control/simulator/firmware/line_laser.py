"""A laser whose scans come over the robot's own line, as the vendor's simulator offers it (laser sheet 3.3).

A scan is sent right after a SIP. Its last ray was fired at the moment of that SIP, its first one up to one turn of an
LMS200's mirror before. Values go from right to left, also where the robot's laser hangs upside down: so the vendor's
client takes them.
"""

import functools
import math
from typing import Iterator, Tuple

import numpy as np

from ...lms2xx import TURN_S
from ...p2os import LaserReading, SimulatedLaser, SimulatedLaserExtended, wrapped
from ...robots import LaserPlace, RobotModel
from ..hardware import Hardware, LaserNumbers
from ..lms200 import Optics
from ..lms200.ray_plans import RayPlan
from ..world import World
from ..world.poses import Pose, along_arc, compose
from .laser_orders import OFF, PLAIN_SCANS, FieldOfView, LaserOrders

MOST_TOGETHER = 32
"""Most values in one packet."""
NO_ECHO_MM = 32767
"""What stands for no echo, and for a value that is dazzled or farther away: more than clients take for a distance."""
REFLECTANCE = 32
"""Reflectance of a reflector, as the vendor's simulator sends it."""
WAS_MOVED = 1
"""Flag of `SimulatedLaserExtended`: a person has moved the robot since the last scan."""


class LineLaser:
    """The laser of one robot, without its orders.

    Args:
        world: the world in which the robot stands.
        hardware: the robot.
        numbers: how the laser measures.
        seed: seed of its errors.
    """

    def __init__(self, world: World, hardware: Hardware, numbers: LaserNumbers, seed: int):
        place = laser_place(hardware.model)
        self._mirror = place.x, place.y, 0.0
        self._hardware = hardware
        self._optics = Optics(world, numbers, "line %s" % seed, hardware.body)
        self._carried = hardware.body.carried

    def packets(self, orders: LaserOrders) -> Iterator[object]:
        """Yield the packets of one scan, which is measured now. There are none while the client wants no scans."""
        if orders.scans == OFF:
            return
        was_moved, self._carried = self._hardware.body.carried != self._carried, self._hardware.body.carried
        plan = plan_of(orders.view)
        measured = self._optics.measure(plan, -plan.after[-1], self._pose_at)
        seen = np.isfinite(measured.distances) & ~measured.dazzled
        ranges = np.where(seen, np.minimum(np.rint(measured.distances * 1000.0), NO_ECHO_MM), NO_ECHO_MM)
        values = ranges.astype(int).tolist()
        marks = np.where(measured.reflectors, REFLECTANCE, 0).tolist()
        for first in range(0, len(values), MOST_TOGETHER):
            some = slice(first, first + MOST_TOGETHER)
            if orders.scans == PLAIN_SCANS:
                yield SimulatedLaser(*self._odometry_pose, len(values), first, tuple(values[some]))
            else:
                yield SimulatedLaserExtended(
                    len(values), first, tuple(LaserReading(*each, 0) for each in zip(values[some], marks[some])), 0,
                    WAS_MOVED if was_moved and not first else 0)

    @property
    def _odometry_pose(self) -> Tuple[int, int, int]:
        """The pose as packets have it: mm, mm, degrees, wrapped to 16 bits and to half a turn."""
        x, y, heading = self._hardware.odometry.pose
        return (wrapped(round(x * 1000.0), 1 << 16), wrapped(round(y * 1000.0), 1 << 16),
                wrapped(round(math.degrees(heading)), 360))

    def _pose_at(self, seconds: float) -> Pose:
        """Return the pose of the laser (m, rad; map frame) some seconds from now; negative: ago."""
        linear, angular = self._hardware.drives.linear.speed, self._hardware.drives.angular.speed
        return compose(along_arc(self._hardware.body.pose, linear * seconds, angular * seconds), self._mirror)


@functools.lru_cache(maxsize=64)
def plan_of(view: FieldOfView) -> RayPlan:
    """Return the rays of a field of view. They are fired as a mirror turns that takes as long as an LMS200's."""
    degrees = [index * view.step_hundredths / 100.0 for index in range(view.values)]
    return RayPlan(tuple(math.radians(view.first_deg + each) for each in degrees),
                   tuple(each / 360.0 * TURN_S for each in degrees), 1)


def laser_place(model: RobotModel) -> LaserPlace:
    """Return where the laser of a model sits: in the middle of the robot, if the table of models does not say it."""
    return model.laser or LaserPlace(0.0, 0.0)
