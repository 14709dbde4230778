"""Many points at once from one frame into another, and many angles (m, rad). `floor_poses` does it for one pose.

A point is relative to a frame when its x is ahead of the frame's origin (along its heading), and its y to the left.
"""

import math
from typing import Any, Tuple

import numpy as np

from ..floor_poses import Pose

Array = Any     # of numpy


def out_of(frame: Pose, x: Array, y: Array) -> Tuple[Array, Array]:
    """Transform points that are relative to `frame` into the frame that `frame` is given in."""
    cosine, sine = math.cos(frame.heading), math.sin(frame.heading)
    return frame.x + x * cosine - y * sine, frame.y + x * sine + y * cosine


def into(frame: Pose, x: Array, y: Array) -> Tuple[Array, Array]:
    """Transform points of the frame that `frame` is given in, so that they are relative to `frame`."""
    cosine, sine = math.cos(frame.heading), math.sin(frame.heading)
    x, y = x - frame.x, y - frame.y
    return x * cosine + y * sine, y * cosine - x * sine


def turned(x: Array, y: Array, angles: Array) -> Tuple[Array, Array]:
    """Turn points about the origin, each by an angle of its own (rad)."""
    cosine, sine = np.cos(angles), np.sin(angles)
    return x * cosine - y * sine, x * sine + y * cosine


def wrapped_angles(angles: Array) -> Array:
    """Return angles (rad) from -pi on, below pi. `floor_poses.wrapped` does it for one."""
    return np.remainder(angles + math.pi, 2.0 * math.pi) - math.pi
