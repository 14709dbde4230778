"""Poses on the floor, and their transforms between frames.

The simulator has transforms of its own, which give the same bits on every computer (`simulator.world.poses`).
"""

import math
from typing import NamedTuple


class Pose(NamedTuple):
    """x, y (m) and heading (rad, counter-clockwise from the x axis) of a robot in some frame."""

    x: float
    y: float
    heading: float


def wrapped(angle: float) -> float:
    """Return an angle (rad) between -pi and pi."""
    return math.remainder(angle, 2.0 * math.pi)


def compose(frame: Pose, pose: Pose) -> Pose:
    """Transform `pose`, which is relative to `frame`, into the frame of `frame`. The heading is wrapped."""
    cosine, sine = math.cos(frame.heading), math.sin(frame.heading)
    return Pose(frame.x + pose.x * cosine - pose.y * sine, frame.y + pose.x * sine + pose.y * cosine,
                wrapped(frame.heading + pose.heading))


def relative(frame: Pose, pose: Pose) -> Pose:
    """Return `pose` relative to `frame`. Both are poses in the same frame. The heading is wrapped."""
    cosine, sine = math.cos(frame.heading), math.sin(frame.heading)
    x, y = pose.x - frame.x, pose.y - frame.y
    return Pose(x * cosine + y * sine, y * cosine - x * sine, wrapped(pose.heading - frame.heading))


def distance_between(one: Pose, other: Pose) -> float:
    """Return the distance (m) of two poses."""
    return math.hypot(one.x - other.x, one.y - other.y)


def between(before: Pose, after: Pose, share: float) -> Pose:
    """Return the pose at a share (0 to 1) of a motion between two poses in the same frame. It turns the shorter way."""
    return Pose(before.x + (after.x - before.x) * share, before.y + (after.y - before.y) * share,
                wrapped(before.heading + wrapped(after.heading - before.heading) * share))
