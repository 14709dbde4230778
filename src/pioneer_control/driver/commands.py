"""Checks messages to the motors and the gripper, and converts them to commands of the protocol.

Pure functions. When a message must be refused, they raise UsageError with the reason.
"""

from typing import List, Optional, Tuple

from ..errors import UsageError
from ..message_values import GripCommand, LiftCommand, LiftStatus
from ..msg import GripperState, MotorState
from ..p2os import GRIPPER_VALUES, GripperCommand

LEAVE_ALONE = 0
LEGAL_GRIP = "legal: 1 open, 2 close, 3 stop, 7 store, 8 deploy, 15 halt, 16 pressure, 0 leave alone"
LEGAL_LIFT = "legal: 4 up, 5 down, 6 stop, 17 carry, 0 leave alone"
STOPS = ({LEAVE_ALONE, GripCommand.STOP, GripCommand.HALT}, {LEAVE_ALONE, LiftCommand.STOP})
"""Two sets: the values of grip.state, and those of lift.state, that mean stop or no command. They start no movement."""
MOVES_BOTH = (GripCommand.STORE, GripCommand.DEPLOY, GripCommand.HALT)


GripperOrder = Tuple[GripperCommand, Optional[int]]
"""One gripper command of the protocol and its value (units of 20 ms). The value is None if the command has no value."""


def gripper_stops(message: GripperState) -> bool:
    """Return whether a gripper_control message starts no movement: it only stops the gripper, or does nothing."""
    return message.grip.state in STOPS[0] and message.lift.state in STOPS[1]


def motors_wanted(message: MotorState) -> bool:
    """Return whether a cmd_motor_state message switches the motors on. Raises UsageError when state is not 0 or 1."""
    if message.state not in (0, 1):
        raise UsageError("cmd_motor_state refused: state is %d (legal: 1 on, 0 off)" % message.state)
    return message.state == 1


def gripper_orders(message: GripperState) -> List[GripperOrder]:
    """Return the gripper commands in a gripper_control message, first for the paddles, then for the lift.

    The state 0 means no command for this part. The messages of p2os have no field for the value that the commands
    PRESSURE and CARRY need. So the value is in the field ``dir``, which no other command uses. For CARRY the sign of
    ``dir`` is the direction.

    Raises:
        UsageError: a number in the message is not a command. Then no part of the message is obeyed. It is the same when
            lift.state is a number of a status: the message is a gripper_state on the wrong topic.
    """
    grip, lift = message.grip.state, message.lift.state
    for is_wrong, why in (
            (lift in list(LiftStatus),
             "lift.state %d is a status as gripper_state reports it, not a command (%s)" % (lift, LEGAL_LIFT)),
            (grip not in (LEAVE_ALONE, *GripCommand), "grip.state is %d (%s)" % (grip, LEGAL_GRIP)),
            (lift not in (LEAVE_ALONE, *LiftCommand), "lift.state is %d (%s)" % (lift, LEGAL_LIFT)),
            (grip in MOVES_BOTH and lift != LEAVE_ALONE,
             "grip.state %d moves the lift too, so lift.state must be 0, not %d" % (grip, lift))):
        if is_wrong:
            raise UsageError("gripper_control refused: " + why)
    return [_order(part, GripperCommand(number), value)
            for part, number, value in (("grip", grip, message.grip.dir), ("lift", lift, message.lift.dir))
            if number != LEAVE_ALONE]


def _order(part: str, command: GripperCommand, value: int) -> GripperOrder:
    """Return a command for a part ("grip" or "lift") with its value. Raises UsageError when the value is not legal."""
    if command not in GRIPPER_VALUES:
        return command, None
    low, high = GRIPPER_VALUES[command]
    if not low <= value <= high or not value:
        raise UsageError("gripper_control refused: %s.state %d needs %s.dir in %d..%d (units of 20 ms), not 0; it is %d"
                         % (part, command, part, low, high, value))
    return command, value
