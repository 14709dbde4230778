"""Remembers obstacles that the sonars measured a moment ago.

The robot needs this memory because there are gaps between the cones of the sonars, and because a sonar measures nothing
nearer than 0.10 m.

An echo at the shortest range may come from anything nearer, so we place it at the outline of the robot.

We place an echo on the axis of its cone. If it filled the whole arc of the cone, open corridors would seem closed.
"""

import math
from enum import Enum
from typing import Dict, List, NamedTuple, Tuple

from .clearance import Point
from .snapshot import Snapshot

NEAREST = 0.10  #: m, the shortest range of a sonar; if a sonar gives no reading, we assume an obstacle at this range
NEAR = 1.0  #: m, only echoes with a shorter range are remembered
SILENT = 4.9  #: m, a longer range says that no echo came back: a slanting wall may have lost it, so it refutes nothing
FORGOTTEN_BEYOND = 1.2  #: m, an echo that is farther from the robot is forgotten
CELL = 0.08  #: m, the side of a grid cell; of all echoes in one cell only the newest is kept


class Refuting(NamedTuple):
    """The limits for refuting a remembered echo: for deciding that the obstacle is not there any more.

    A sonar measures the nearest obstacle in its cone. When a remembered echo lies in the cone, but the measured range
    is longer, the echo is refuted.
    """

    tangent: float  #: tangent of the greatest angle between the axis and the echo; the edge of the cone is at 0.22
    farther: float  #: m, the measured range must be longer than the distance to the echo by this much
    nearest: float  #: m, an echo that is nearer to the sonar than this is not refuted


Beam = Tuple[float, float, float, float, float]
"""One sonar: its position x, y [m, robot's frame], cosine and sine of its direction, and its measured range [m]."""

STEADY = Refuting(math.tan(math.radians(10)), 0.05, 0.0)
#: Stricter limits while the robot turns: a range may be 0.33 s old, and the sonar now points in another direction. It
#: looks past the tip of a wedge of smooth walls, which returns few echoes, and those only from near by.
TURNING = Refuting(math.tan(math.radians(6)), 0.15, 0.3)


Motion = Enum("Motion", ["STANDS", "DRIVES", "TURNS"])
"""What a robot does from one snapshot to the next."""

REMEMBERED = {Motion.DRIVES: 12.0, Motion.TURNS: 35.0, Motion.STANDS: 60.0}
"""The time [s] after which an echo is forgotten while the robot does this.

A slow turn all round takes 31 s. A robot that stands looks at the same places all the time, so it learns nothing new;
but somebody may have carried it away from what it remembers.
"""


class Echo(NamedTuple):
    """A remembered echo: the position of an obstacle, x and y [m] in the odom frame, and its age.

    It ages at a rate that depends on the motion: at `age` 1 it is forgotten (see REMEMBERED).
    """

    x: float
    y: float
    age: float = 0.0


def remember(echoes: Tuple[Echo, ...], snapshot: Snapshot, motion: Motion,
             passed: float) -> Tuple[Tuple[Echo, ...], List[Point]]:
    """Update the remembered echoes with the sonar ranges of a snapshot.

    Args:
        echoes: the echoes that were remembered before.
        snapshot: the new data.
        motion: what the robot has done since the snapshot before.
        passed: the time since then [s].

    Returns:
        The echoes to remember now, and all known obstacle points (x, y) [m] in the robot's frame, old and new.
    """
    pose = snapshot.pose
    cosine, sine = math.cos(pose.heading), math.sin(pose.heading)
    refuting = TURNING if motion is Motion.TURNS else STEADY
    kept: Dict[Tuple[int, int], Echo] = {}
    around: List[Point] = []
    beams = [
        (each.x, each.y, *axis, snapshot.ranges[each.number])
        for each, axis in zip(snapshot.robot.transducers, snapshot.robot.axes)]
    far = [beam for beam in beams if 0.3 < beam[4] < SILENT]
    aged = passed / REMEMBERED[motion]
    for echo in echoes:
        echo = echo._replace(age=echo.age + aged)
        dx, dy = echo.x - pose.x, echo.y - pose.y
        x, y = cosine * dx + sine * dy, cosine * dy - sine * dx
        if (echo.age < 1.0 and x * x + y * y < FORGOTTEN_BEYOND ** 2
                and not _refuted(x, y, far, refuting)):
            kept[round(echo.x / CELL), round(echo.y / CELL)] = echo
            around.append((x, y))
    for (bx, by, ahead, aside, heard), covered in zip(beams, snapshot.robot.covered):
        distance = heard if heard > NEAREST else min(NEAREST, covered) if heard else NEAREST
        x, y = bx + distance * ahead, by + distance * aside
        around.append((x, y))
        if 0 < heard < NEAR:
            echo = Echo(pose.x + cosine * x - sine * y, pose.y + sine * x + cosine * y)
            kept[round(echo.x / CELL), round(echo.y / CELL)] = echo
    return tuple(kept.values()), around


def _refuted(x: float, y: float, beams: List[Beam], refuting: Refuting) -> bool:
    """Return whether one of the beams shows that there is no obstacle at the point (x, y) [m, robot's frame]."""
    for bx, by, ahead, aside, heard in beams:
        along = (x - bx) * ahead + (y - by) * aside
        off_axis = abs((y - by) * ahead - (x - bx) * aside)
        if refuting.nearest < along < heard - refuting.farther and off_axis < along * refuting.tangent:
            return True
    return False
