"""What the sonars saw a moment ago: cones leave gaps between them, and nothing is measured below 0.10 m.

An echo is taken to lie on the axis of its cone. Spread over the whole arc it would close corridors that are open.
"""

import math
from typing import Dict, List, NamedTuple, Tuple

from .clearance import Point
from .snapshot import Snapshot

NEAREST = 0.10  #: a sonar measures nothing nearer [m]; where nothing was heard, we take an obstacle to stand there
NEAR = 1.0  #: echoes up to here are remembered [m]
REMEMBERED = 12.0  #: an echo is remembered for so long [s]
FORGOTTEN_BEYOND = 1.2  #: or until the robot is so far away from it [m]
CELL = 0.08  #: of two echoes in one square of this side only the newer one is kept [m]


class Refuting(NamedTuple):
    """When a sonar refutes an echo: the echo is in its cone, and yet what it hears is farther away.

    A sonar hears the nearest thing in its cone.
    """

    tangent: float  #: how far the echo may be from the axis, in metres aside per metre along; the cone ends at 0.22
    farther: float  #: how much farther away the sonar must hear something [m]


Beam = Tuple[float, float, float, float, float]
"""A sonar: x, y [m], cosine and sine of where it looks, and what it hears [m]."""

STEADY = Refuting(math.tan(math.radians(10)), 0.05)
#: While the robot turns: a range may be a third of a second old, and the sonar looks elsewhere now.
TURNING = Refuting(math.tan(math.radians(6)), 0.15)


class Echo(NamedTuple):
    """Something was here: x, y [m] in the frame of odometry, at time [s]."""

    x: float
    y: float
    time: float


def remember(echoes: Tuple[Echo, ...], snapshot: Snapshot, turning: bool) -> Tuple[Tuple[Echo, ...], List[Point]]:
    """What to remember after a snapshot.

    Returns:
        The echoes to remember, and all points (x, y) [m] that are known around the robot, in the robot's frame.
    """
    pose = snapshot.pose
    cosine, sine = math.cos(pose.heading), math.sin(pose.heading)
    refuting = TURNING if turning else STEADY
    kept: Dict[Tuple[int, int], Echo] = {}
    around: List[Point] = []
    beams = [
        (each.x, each.y, *axis, snapshot.ranges[each.number])
        for each, axis in zip(snapshot.robot.transducers, snapshot.robot.axes)]
    far = [beam for beam in beams if beam[4] > 0.3]
    for echo in echoes:
        dx, dy = echo.x - pose.x, echo.y - pose.y
        x, y = cosine * dx + sine * dy, cosine * dy - sine * dx
        if (snapshot.time - echo.time < REMEMBERED and x * x + y * y < FORGOTTEN_BEYOND ** 2
                and not _refuted(x, y, far, refuting)):
            kept[round(echo.x / CELL), round(echo.y / CELL)] = echo
            around.append((x, y))
    for bx, by, ahead, aside, heard in beams:
        distance = max(heard, NEAREST)
        x, y = bx + distance * ahead, by + distance * aside
        around.append((x, y))
        if 0 < heard < NEAR:
            echo = Echo(pose.x + cosine * x - sine * y, pose.y + sine * x + cosine * y, snapshot.time)
            kept[round(echo.x / CELL), round(echo.y / CELL)] = echo
    return tuple(kept.values()), around


def _refuted(x: float, y: float, beams: List[Beam], refuting: Refuting) -> bool:
    """Does a sonar look at a point and hear nothing there?"""
    for bx, by, ahead, aside, heard in beams:
        along = (x - bx) * ahead + (y - by) * aside
        off_axis = abs((y - by) * ahead - (x - bx) * aside)
        if 0 < along < heard - refuting.farther and off_axis < along * refuting.tangent:
            return True
    return False
