"""Incoming messages: what is obeyed, what is refused, and why. Pure functions; a refusal is a UsageError with the reason."""

import math
from typing import List

from geometry_msgs.msg import Twist

from ..errors import UsageError
from ..message_values import GripCommand, LiftCommand, LiftStatus
from ..msg import GripperState, MotorState
from ..p2os import GripperCommand

LEAVE_ALONE = 0
LEGAL_GRIP = "legal: 1 open, 2 close, 3 stop, 0 leave alone"
LEGAL_LIFT = "legal: 4 up, 5 down, 6 stop, 0 leave alone"


def sender(message) -> str:
    """The name of the node that published a message; empty if it did not come over a topic."""
    return (getattr(message, "_connection_header", None) or {}).get("callerid", "")


def is_replayed(message) -> bool:
    """Whether a message was published by `rosbag play`, which names its node play_<time> (in whatever namespace) if nobody renames it."""
    return sender(message).rpartition("/")[2].startswith("play_")


def check_twist(twist: Twist) -> None:
    """Refuse a velocity in which any number is not finite, whether it is used or not: its sender is in trouble."""
    for part in ("linear", "angular"):
        for axis in "xyz":
            value = getattr(getattr(twist, part), axis)
            if not math.isfinite(value):
                raise UsageError("cmd_vel refused: %s.%s is %s, and a velocity must be finite" % (part, axis, value))


def motors_wanted(message: MotorState) -> bool:
    """Whether motors shall be on. Refuses states other than 0 and 1."""
    if message.state not in (0, 1):
        raise UsageError("cmd_motor_state refused: state is %d (legal: 1 on, 0 off)" % message.state)
    return message.state == 1


def gripper_commands(message: GripperState) -> List[GripperCommand]:
    """The sub-commands in a gripper_control message, paddles first; 0 leaves that part alone.

    Refuses the whole message when a number means nothing, or when its lift.state is that of a status: then it is a gripper_state, and
    would move the paddles.
    """
    grip, lift = message.grip.state, message.lift.state
    if lift in list(LiftStatus):
        raise UsageError("gripper_control refused: lift.state %d is a status as gripper_state reports it, not a command (%s)" % (lift, LEGAL_LIFT))
    if grip not in (LEAVE_ALONE, *GripCommand):
        raise UsageError("gripper_control refused: grip.state is %d (%s)" % (grip, LEGAL_GRIP))
    if lift not in (LEAVE_ALONE, *LiftCommand):
        raise UsageError("gripper_control refused: lift.state is %d (%s)" % (lift, LEGAL_LIFT))
    return [GripperCommand(number) for number in (grip, lift) if number != LEAVE_ALONE]
