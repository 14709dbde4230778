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


def box_walls(x: float, y: float, length: float, width: float, angle: float) -> List[Wall]:
    """The four walls of a box: its middle, its sides along x and y before it is turned by `angle`."""
    corners = [turned((ahead * length / 2.0, aside * width / 2.0), angle) for ahead, aside in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    return closed([(x + ahead, y + aside) for ahead, aside in corners])
