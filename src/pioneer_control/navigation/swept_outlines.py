"""The floor that a robot covers until it stands, for each of the ways that it may go: `SweptOutlines`."""

import math
from typing import Any, Sequence, Tuple

import numpy as np
from scipy.spatial import ConvexHull

from .chassis import Manoeuvre, after
from .frames import out_of
from .values import Point

Array = Any     # of numpy

_PARTS = (0.0, 0.25, 0.5, 0.75, 1.0)    # of a way: its floor is the hull of the outlines there, a cm too small at most


class SweptOutlines:
    """Tells how far places are from the floor of each way.

    Args:
        outline: the robot's outline (m, robot's frame).
        ways: the moves, each with its length (m; 0: the robot stays where it is).
    """

    def __init__(self, outline: Tuple[Point, ...], ways: Sequence[Tuple[Manoeuvre, float]]):
        sides = [_sides(outline, *way) for way in ways]
        most = max(len(each) for each in sides)
        # Hulls have different numbers of sides: the last side is repeated.
        self._sides = np.array([np.pad(each, ((0, most - len(each)), (0, 0)), mode="edge") for each in sides])

    def nearest(self, x: Array, y: Array) -> Array:
        """Return for each way the distance (m) from its floor to the nearest of some places, infinite without one.

        It is negative inside. Near a corner it may be too small.

        Args:
            x, y: the places (m, robot's frame).
        """
        out_x, out_y, offset = np.moveaxis(self._sides, 2, 0)[..., np.newaxis]
        return (out_x * x + out_y * y + offset).max(axis=1).min(axis=1, initial=math.inf)


def _sides(outline: Tuple[Point, ...], move: Manoeuvre, way: float) -> Array:
    """Return the sides of the floor of a way: array (number, 3); x and y of what points out, and an offset (m)."""
    x, y = np.array(outline).T
    corners = np.hstack([out_of(after(move, part * way), x, y) for part in _PARTS])
    return ConvexHull(corners.T).equations
