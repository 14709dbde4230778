"""Units and axes of ROS and of p2os for where a camera looks, and the frustum of its view. Pure functions.

A camera's counts grow to the right and upwards. In ROS (REP 103) pan grows to the left, and tilt, a turn about the axis
to the left, grows downwards. The messages of p2os have whole degrees with the signs of the camera (camera sheet 8, 9).
"""

import math
from typing import List, NamedTuple, Tuple

from ..vcc4 import COUNT_DEG, count_of, degrees_of

COUNT_RAD = math.radians(COUNT_DEG)
ASPECT = 3.0 / 4.0
"""Height of the picture for its width: an analogue one."""
DRAWN = 1.0
"""Length (m) of the frustum that is drawn."""
ABOVE_FOOT = 0.07
"""Height (m) of the axes of a camera above its foot: by eye."""

Point3 = Tuple[float, float, float]


class Place3(NamedTuple):
    """Where the foot of a camera is (m, base_link)."""

    x: float
    y: float
    z: float


def joints(pan: int, tilt: int) -> Tuple[float, float]:
    """Return the angles (rad) of the joints from counts: pan to the left, tilt downwards."""
    return -pan * COUNT_RAD, -tilt * COUNT_RAD


def counts_of_joints(pan: float, tilt: float) -> Tuple[int, int]:
    """Return the counts of joint angles (rad, finite)."""
    return count_of(math.degrees(-pan)), count_of(math.degrees(-tilt))


def whole_degrees(count: int) -> int:
    """Return the nearest whole degree of a count, for messages of p2os."""
    return round(degrees_of(count))


def frustum(width: float) -> List[Point3]:
    """Return the corners of a view (m; x ahead, y left, z up): where it begins, then four at `DRAWN` m ahead.

    These are upper left, upper right, lower right and lower left in the picture. ``width``: field of view (rad).
    """
    side = DRAWN * math.tan(width / 2.0)
    up = ASPECT * side
    return [(0.0, 0.0, 0.0), (DRAWN, side, up), (DRAWN, -side, up), (DRAWN, -side, -up), (DRAWN, side, -up)]


def orientation(pan: float, tilt: float) -> Tuple[float, float, float, float]:
    """Return the quaternion (x, y, z, w) of a camera whose joints have these angles (rad): pan first, then tilt."""
    (sin_pan, cos_pan), (sin_tilt, cos_tilt) = ((math.sin(angle / 2.0), math.cos(angle / 2.0)) for angle in (pan, tilt))
    return -sin_pan * sin_tilt, cos_pan * sin_tilt, sin_pan * cos_tilt, cos_pan * cos_tilt
