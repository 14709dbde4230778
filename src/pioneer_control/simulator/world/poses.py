"""Poses: one seen from another, the arc that a robot drives, outlines where they stand.

Metres and radians; headings are not wrapped.
"""

from typing import Callable, List, Sequence

from .geometry import Point, Pose
from .trigonometry import sin, unit


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
    share = 1.0 - z / 6.0 * (1.0 - z / 20.0 * (1.0 - z / 42.0)) if z < 0.01 else sin(half) / half
    cosine, sine = direction(heading + half)
    return x + distance * share * cosine, y + distance * share * sine, heading + turn


def placed(polygon: Sequence[Point], pose: Pose) -> List[Point]:
    """A polygon of the body's frame, where it lies in the map frame when the body stands at `pose`."""
    cosine, sine = unit(pose[2])
    return [(pose[0] + x * cosine - y * sine, pose[1] + x * sine + y * cosine) for x, y in polygon]
