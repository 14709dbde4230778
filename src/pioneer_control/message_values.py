"""What the numbers in our messages mean, and conversions between a heading and a quaternion.

The driver, which publishes the messages, and all programs that subscribe to them use this file. It does not need ROS.

The status of the gripper and the commands to it use the same message type, but different numbers: grip.state 3 is
"moving" in a status, and "stop" in a command. So there are two enums for the paddles (grip) and two for the lift.
"""

import math
from enum import IntEnum
from typing import Tuple

NO_ECHO = 5.0
"""The range (m) in a SonarArray that means "no echo". The driver publishes no greater range."""
NOT_HEARD = 0.0
"""The range (m) in a SonarArray that means "no recent reading from this transducer".

A program that does not know this value takes it for an obstacle, which is the safe mistake.
"""


class GripStatus(IntEnum):
    """The values of grip.state in messages on gripper_state: what the paddles do."""

    BETWEEN = 0
    OPEN = 1
    CLOSED = 2
    MOVING = 3
    ERROR = 4


class LiftStatus(IntEnum):
    """The values of lift.state in messages on gripper_state: what the lift does."""

    IDLE = 1
    MOVING = 2
    STALLED = 3


class GripCommand(IntEnum):
    """The values of grip.state in messages on gripper_control: commands to the paddles. 0 is no command."""

    OPEN = 1
    CLOSE = 2
    STOP = 3
    STORE = 7       # close and raise
    DEPLOY = 8      # open and lower
    HALT = 15       # stop both
    PRESSURE = 16   # set how long the paddles go on closing when they touch an object: grip.dir (1..100) times 20 ms


class LiftCommand(IntEnum):
    """The values of lift.state in messages on gripper_control: commands to the lift. 0 is no command."""

    UP = 4
    DOWN = 5
    STOP = 6
    CARRY = 17      # move for lift.dir times 20 ms: 1..255 is up, -1..-255 is down


def quaternion_of(heading: float) -> Tuple[float, float, float, float]:
    """Return the quaternion (x, y, z, w) of a heading (rad): a rotation about the vertical axis."""
    return 0.0, 0.0, math.sin(heading / 2.0), math.cos(heading / 2.0)


def heading_of(x: float, y: float, z: float, w: float) -> float:
    """Return the heading (rad, -pi to pi) of a quaternion: its rotation about the vertical axis."""
    return math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
