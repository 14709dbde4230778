"""Poses: one seen from another, the arc that a robot drives; outlines where they stand, and as walls.

Metres and radians; headings are not wrapped. Walls are rows ``(x1, y1, x2, y2)``, as `World` takes them.
"""

from typing import Callable, List, Sequence, Tuple

from .geometry import Point, Pose
from .trigonometry import unit

Wall = Tuple[float, float, float, float]


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
