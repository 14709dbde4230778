"""Points and poses on the floor: transforms between frames, the arc that a robot drives, and placed outlines.

Lengths are in metres, angles in radians; headings are not wrapped. All functions give the same result on every
computer to the last bit, because the results reach the bytes that the simulated robot sends. Therefore sine, cosine
and length are computed with + - * / and sqrt only, which IEEE 754 defines to the last bit. The functions of :mod:`math`
and numpy come from the C library, and their last bit may differ between versions of Debian. Sine and cosine have an
error of at most 1e-13 for angles from minus one million to one million radians.
"""

import math
from typing import Any, Callable, List, Sequence, Tuple

import numpy as np

Point = Tuple[float, float]
Pose = Tuple[float, float, float]
"""x (m), y (m) and heading (rad, counter-clockwise from the x axis)."""
Wall = Tuple[float, float, float, float]
"""A straight wall: x and y of one end, then x and y of the other end (m)."""

_QUARTERS_PER_RADIAN = 2.0 / math.pi
_QUARTER_HIGH = float.fromhex("0x1.921fb544p+0")  # first 33 bits of a quarter turn (rad): its multiples are exact
_QUARTER_LOW = float.fromhex("0x1.0b4611a626331p-34")  # the remaining bits


def _series(angle: Any, quarters: Any) -> Tuple[Any, Any]:
    """Return cosine and sine of what is left of an angle (rad) without its whole quarter turns: numbers, or arrays."""
    x = (angle - quarters * _QUARTER_HIGH) - quarters * _QUARTER_LOW
    z = x * x
    sine = x + x * z * (-1 / 6 + z * (1 / 120 + z * (-1 / 5040
                                                     + z * (1 / 362880 + z * (-1 / 39916800 + z * (1 / 6227020800))))))
    cosine = 1.0 + z * (-0.5
                        + z * (1 / 24
                               + z * (-1 / 720
                                      + z * (1 / 40320 + z * (-1 / 3628800 + z * (1 / 479001600 - z / 87178291200))))))
    return cosine, sine


def unit(angle: float) -> Tuple[float, float]:
    """Return cosine and sine of an angle (rad), which is the unit vector in its direction."""
    quarters = math.floor(angle * _QUARTERS_PER_RADIAN + 0.5)
    cosine, sine = _series(angle, quarters)
    quarters &= 3
    if quarters == 0:
        return cosine, sine
    if quarters == 1:
        return -sine, cosine
    if quarters == 2:
        return -cosine, -sine
    return sine, -cosine


def units(angles: Any) -> Tuple[Any, Any]:
    """Return cosines and sines of an array of angles (rad), as two arrays: those of `unit`, to the last bit."""
    quarters = np.floor(angles * _QUARTERS_PER_RADIAN + 0.5)
    cosine, sine = _series(angles, quarters)
    quarters = quarters.astype(int) & 3
    is_odd, is_turned_x, is_turned_y = quarters & 1 == 1, (quarters == 1) | (quarters == 2), quarters >= 2
    across, along = np.where(is_odd, sine, cosine), np.where(is_odd, cosine, sine)
    return np.where(is_turned_x, -across, across), np.where(is_turned_y, -along, along)


class Heading:
    """Keeps the unit vector of an angle, and computes it again only when the angle changes.

    This saves time for a robot that stands still or drives straight. `functools.lru_cache` would take one and a half
    times as long.
    """

    def __init__(self) -> None:
        self._angle = math.nan
        self._unit = 1.0, 0.0

    def unit(self, angle: float) -> Tuple[float, float]:
        """Return cosine and sine of `angle` (rad)."""
        if angle != self._angle:
            self._angle, self._unit = angle, unit(angle)
        return self._unit


def hypot(x: float, y: float) -> float:
    """Return the length of the vector (x, y). Very small or very large values underflow or overflow."""
    return math.sqrt(x * x + y * y)


def compose(frame: Pose, pose: Pose) -> Pose:
    """Transform `pose`, which is relative to `frame`, into the parent frame of `frame`. The heading is not wrapped."""
    cosine, sine = unit(frame[2])
    x, y, heading = pose
    return frame[0] + x * cosine - y * sine, frame[1] + x * sine + y * cosine, frame[2] + heading


def relative(frame: Pose, pose: Pose) -> Pose:
    """Return `pose` relative to `frame`. Both arguments are poses in the same frame. The heading is not wrapped."""
    cosine, sine = unit(frame[2])
    x, y = pose[0] - frame[0], pose[1] - frame[1]
    return x * cosine + y * sine, y * cosine - x * sine, pose[2] - frame[2]


def along_arc(pose: Pose, distance: float, turn: float, direction: Callable[[float], Point] = unit) -> Pose:
    """Return the pose at the end of an arc from `pose`. The result is exact, also for a straight line.

    Args:
        pose: pose at the start of the arc (m, rad).
        distance: length of the arc (m), negative for backward.
        turn: angle of the arc (rad, counter-clockwise positive).
        direction: function that returns the unit vector of an angle (rad).
    """
    x, y, heading = pose
    if not distance:
        return x, y, heading + turn
    half = turn / 2.0
    z = half * half
    # ratio of chord to arc
    share = 1.0 - z / 6.0 * (1.0 - z / 20.0 * (1.0 - z / 42.0)) if z < 0.01 else unit(half)[1] / half
    cosine, sine = direction(heading + half)
    return x + distance * share * cosine, y + distance * share * sine, heading + turn


def placed(points: Sequence[Point], pose: Pose) -> List[Point]:
    """Transform points from the frame of a body to the map frame, for a body at `pose` (map frame)."""
    cosine, sine = unit(pose[2])
    return [(pose[0] + x * cosine - y * sine, pose[1] + x * sine + y * cosine) for x, y in points]


def closed(corners: Sequence[Point]) -> List[Wall]:
    """Return walls from each corner to the next, and from the last corner to the first.

    There is no wall between two equal corners.
    """
    corners = list(corners)
    return [first + second for first, second in zip(corners, corners[1:] + corners[:1]) if first != second]


def box_corners(centre: Point, size: Point, angle: float) -> List[Point]:
    """Return the four corners of a box.

    Args:
        centre: middle of the box (m).
        size: sides of the box (m) along x and y before rotation.
        angle: rotation of the box (rad, counter-clockwise positive).
    """
    ahead, aside = size[0] / 2.0, size[1] / 2.0
    return placed(((-ahead, -aside), (ahead, -aside), (ahead, aside), (-ahead, aside)), (*centre, angle))


def box_walls(centre: Point, size: Point, angle: float) -> List[Wall]:
    """Return the four walls of a box. For the arguments see `box_corners`."""
    return closed(box_corners(centre, size, angle))
