"""Points and poses of the floor: one seen from another, the arc that a robot drives, outlines where they stand.

Metres and radians; headings are not wrapped. Everything here rounds the same on every computer, as all must whose
result reaches the wire. So sine, cosine and length are made of + - * / and sqrt alone, which IEEE 754 defines to the
last bit; what :mod:`math` and numpy take from the C library may differ in that bit from one Debian to the next. They
are right to 1e-13 for angles up to a million radians either way.
"""

import math
from typing import Callable, List, Sequence, Tuple

Point = Tuple[float, float]
Pose = Tuple[float, float, float]
"""x, y, heading (counter-clockwise from x)."""
Wall = Tuple[float, float, float, float]
"""x and y of one end and of the other, as `World` takes it."""

_QUARTERS_PER_RADIAN = 2.0 / math.pi
_QUARTER_HIGH = float.fromhex("0x1.921fb544p+0")  # of a quarter turn (rad) the first 33 bits: its multiples are exact
_QUARTER_LOW = float.fromhex("0x1.0b4611a626331p-34")  # and the rest


def unit(angle: float) -> Tuple[float, float]:
    """Cosine and sine of an angle (rad): the unit vector in its direction."""
    quarters = math.floor(angle * _QUARTERS_PER_RADIAN + 0.5)
    x = (angle - quarters * _QUARTER_HIGH) - quarters * _QUARTER_LOW
    z = x * x
    sine = x + x * z * (-1 / 6 + z * (1 / 120 + z * (-1 / 5040
                                                     + z * (1 / 362880 + z * (-1 / 39916800 + z * (1 / 6227020800))))))
    cosine = 1.0 + z * (-0.5
                        + z * (1 / 24
                               + z * (-1 / 720
                                      + z * (1 / 40320 + z * (-1 / 3628800 + z * (1 / 479001600 - z / 87178291200))))))
    quarters &= 3
    if quarters == 0:
        return cosine, sine
    if quarters == 1:
        return -sine, cosine
    if quarters == 2:
        return -cosine, -sine
    return sine, -cosine


class Heading:
    """The unit vector of an angle that stays the same for long, as that of what stands or goes straight on: worked out
    only when it changes. (A cache of the library takes half as long again.)
    """

    def __init__(self) -> None:
        self._angle = math.nan
        self._unit = 1.0, 0.0

    def unit(self, angle: float) -> Tuple[float, float]:
        """Cosine and sine of the angle (rad) that it is now."""
        if angle != self._angle:
            self._angle, self._unit = angle, unit(angle)
        return self._unit


def hypot(x: float, y: float) -> float:
    """Length of a vector that is neither tiny nor huge."""
    return math.sqrt(x * x + y * y)


def compose(frame: Pose, pose: Pose) -> Pose:
    """The pose that `pose`, as seen from `frame`, has in the frame that `frame` is given in."""
    cosine, sine = unit(frame[2])
    x, y, heading = pose
    return frame[0] + x * cosine - y * sine, frame[1] + x * sine + y * cosine, frame[2] + heading


def relative(frame: Pose, pose: Pose) -> Pose:
    """`pose` as seen from `frame`, both given in the same frame; the heading is not wrapped."""
    cosine, sine = unit(frame[2])
    x, y = pose[0] - frame[0], pose[1] - frame[1]
    return x * cosine + y * sine, y * cosine - x * sine, pose[2] - frame[2]


def along_arc(pose: Pose, distance: float, turn: float, direction: Callable[[float], Point] = unit) -> Pose:
    """The pose after driving `distance` while turning by `turn`, both evenly: exact, straight lines included.

    Args:
        direction: works out the unit vector of an angle (rad).
    """
    x, y, heading = pose
    if not distance:
        return x, y, heading + turn
    half = turn / 2.0
    z = half * half
    # of the arc, its chord
    share = 1.0 - z / 6.0 * (1.0 - z / 20.0 * (1.0 - z / 42.0)) if z < 0.01 else unit(half)[1] / half
    cosine, sine = direction(heading + half)
    return x + distance * share * cosine, y + distance * share * sine, heading + turn


def placed(polygon: Sequence[Point], pose: Pose) -> List[Point]:
    """A polygon of the body's frame, where it lies in the map frame when the body stands at `pose`."""
    cosine, sine = unit(pose[2])
    return [(pose[0] + x * cosine - y * sine, pose[1] + x * sine + y * cosine) for x, y in polygon]


def turned(point: Point, angle: float) -> Point:
    """A point after a turn about the origin."""
    x, y = point
    cosine, sine = unit(angle)
    return x * cosine - y * sine, x * sine + y * cosine


def closed(corners: Sequence[Point]) -> List[Wall]:
    """Walls from corner to corner and back to the first; none between corners that are the same."""
    corners = list(corners)
    return [first + second for first, second in zip(corners, corners[1:] + corners[:1]) if first != second]


def box_walls(centre: Point, size: Point, angle: float) -> List[Wall]:
    """The four walls of a box.

    Args:
        centre: its middle.
        size: its sides along x and y before it is turned.
        angle: by which it is turned (rad).
    """
    (x, y), (length, width) = centre, size
    sides = [(ahead * length / 2.0, aside * width / 2.0) for ahead, aside in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    corners = [turned(side, angle) for side in sides]
    return closed([(x + ahead, y + aside) for ahead, aside in corners])
