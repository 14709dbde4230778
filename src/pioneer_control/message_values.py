"""What the values in messages mean: names for the numbers of the frozen messages, headings as quaternions.

For the driver that sends them and every program that hears them. No ROS in here.

Status and commands of the gripper travel in the same message with different numbers: grip.state 3 is "moving" in a
status, and "stop" in a command. So there are two enums for each part.
"""

import math
from enum import IntEnum
from typing import Tuple

NO_ECHO = 5.0
"""Range (m) in a SonarArray that says: nothing in sight. Nothing greater is published."""
NOT_HEARD = 0.0
"""Range (m) that says: this transducer has not been heard lately. It reads as an obstacle, which is the safe side."""


class GripStatus(IntEnum):
    """grip.state of gripper_state."""

    BETWEEN = 0
    OPEN = 1
    CLOSED = 2
    MOVING = 3
    ERROR = 4


class LiftStatus(IntEnum):
    """lift.state of gripper_state."""

    IDLE = 1
    MOVING = 2
    STALLED = 3


class GripCommand(IntEnum):
    """grip.state of gripper_control; 0 leaves the paddles alone."""

    OPEN = 1
    CLOSE = 2
    STOP = 3
    STORE = 7       # close and raise
    DEPLOY = 8      # open and lower
    HALT = 15       # stop both
    PRESSURE = 16   # how long paddles that hold something go on closing: grip.dir times 20 ms, 1..100


class LiftCommand(IntEnum):
    """lift.state of gripper_control; 0 leaves the lift alone."""

    UP = 4
    DOWN = 5
    STOP = 6
    CARRY = 17      # move for a while: lift.dir times 20 ms, 1..255 up, -1..-255 down


def quaternion_of(heading: float) -> Tuple[float, float, float, float]:
    """A heading (rad) as a rotation about the vertical axis: x, y, z, w."""
    return 0.0, 0.0, math.sin(heading / 2.0), math.cos(heading / 2.0)


def heading_of(x: float, y: float, z: float, w: float) -> float:
    """The heading (rad, -pi to pi) in a quaternion."""
    return math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
