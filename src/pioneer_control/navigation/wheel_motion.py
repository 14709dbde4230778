"""How the robot really moved, from its odometry: with the errors of its wheels taken out.

Wheels differ from the robot's own calibration in three ways that last: size, distance apart, and left from right.
Mapping estimates them (`pose_graph`).
"""

from typing import Any, NamedTuple

import numpy as np

from .frames import turned

Array = Any     # of numpy


class WheelBias(NamedTuple):
    """The lasting errors of the wheels. All are 0 when the odometry is right.

    `distance`: the robot drives farther than it measures by this share. `turning`: it turns farther than it measures
    by this share. `veer` (rad/m): it turns this much for each metre while it measures a straight line.
    """

    distance: float = 0.0
    turning: float = 0.0
    veer: float = 0.0


def path(steps: Array, errors: WheelBias) -> Array:
    """Return the poses along a path.

    Args:
        steps: array (n, 3) of the motion between two packets, by odometry: forward and left (m) in the frame of the
            packet before, and turn (rad).
        errors: what to take out.

    Returns:
        Array (n + 1, 3) of x, y (m) and heading (rad, not wrapped). The first is 0, 0, 0.
    """
    forward, left = steps[:, 0] * (1.0 + errors.distance), steps[:, 1] * (1.0 + errors.distance)
    turn = steps[:, 2] * (1.0 + errors.turning) + errors.veer * steps[:, 0]
    poses = np.zeros((len(steps) + 1, 3))
    poses[1:, 2] = np.cumsum(turn)
    # A step is told in the frame of the packet before, as if the robot had turned as odometry says while it drove. It
    # really turned by more or less, evenly on the way: so the step as a whole is turned by half of the difference.
    heading = poses[:-1, 2] + (turn - steps[:, 2]) / 2.0
    poses[1:, :2] = np.cumsum(turned(forward, left, heading), axis=1).T
    return poses
