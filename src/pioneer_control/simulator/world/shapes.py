"""Outlines as walls: rows ``(x1, y1, x2, y2)``, as `World` takes them."""

from typing import List, Sequence, Tuple

from .geometry import Point
from .trigonometry import unit

Wall = Tuple[float, float, float, float]


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
