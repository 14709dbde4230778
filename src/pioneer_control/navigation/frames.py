"""Many points at once from one frame into another (m, rad). `floor_poses` does it for one pose."""

import math
from typing import Any, Tuple

from ..floor_poses import Pose

Array = Any     # of numpy


def out_of(frame: Pose, x: Array, y: Array) -> Tuple[Array, Array]:
    """Transform points that are relative to `frame` into the frame that `frame` is given in."""
    cosine, sine = math.cos(frame.heading), math.sin(frame.heading)
    return frame.x + x * cosine - y * sine, frame.y + x * sine + y * cosine


def into(frame: Pose, x: Array, y: Array) -> Tuple[Array, Array]:
    """Transform points of the frame that `frame` is given in, so that they are relative to `frame`."""
    cosine, sine = math.cos(frame.heading), math.sin(frame.heading)
    return (x - frame.x) * cosine + (y - frame.y) * sine, (y - frame.y) * cosine - (x - frame.x) * sine
