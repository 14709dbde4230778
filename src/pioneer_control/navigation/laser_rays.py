"""The rays of a scan: where each began, where it looked, and how far it went. The robot may have moved meanwhile."""

from typing import Any, NamedTuple, Optional

import numpy as np

from ..floor_poses import Pose
from .frames import out_of, turned
from .values import Scan

Array = Any     # of numpy


class LaserRays(NamedTuple):
    """Rays that measured something, as arrays of one length, in their order.

    Attributes:
        x, y: where each began (m).
        heading: where it looked (rad).
        range: how far it went (m).
        number: its number in the scan.
    """

    x: Array
    y: Array
    heading: Array
    range: Array
    number: Array


def rays_of(scan: Scan, frame: Pose, most: Optional[int] = None) -> LaserRays:
    """Return the rays of a scan, each from where the laser was when it was fired: the robot has moved evenly meanwhile.

    Args:
        scan: the scan.
        frame: the pose of the robot at the time of the scan (m, rad), in any frame. The rays are in this frame.
        most: most rays, spread over the scan; None: all.
    """
    count = len(scan.ranges)
    number = np.arange(count) if most is None or most >= count else np.linspace(0, count - 1, most).astype(int)
    ranges = np.asarray(scan.ranges, dtype=float)[number]
    measured = np.isfinite(ranges)
    number, ranges = number[measured], ranges[measured]
    later = number / max(1, count - 1) - 0.5        # than the middle, in shares of the scan
    turn = later * scan.motion.heading
    x, y = turned(scan.mount.x, scan.mount.y, turn)
    x, y = out_of(frame, x + later * scan.motion.x, y + later * scan.motion.y)
    return LaserRays(x, y, frame.heading + turn + scan.mount.heading + scan.first_angle + number * scan.angle_step,
                     ranges, number)
