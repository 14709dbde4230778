"""The steps of a pick, and how to see from the gripper reports that a step has ended. Pure functions, without ROS."""

from enum import Enum
from typing import Callable, NamedTuple, Optional

from ..message_values import GripCommand, GripStatus, LiftCommand, LiftStatus
from .snapshot import Grip, Lift

DOWN, UP = 0.1, 0.9  # position of the lift (0.0 to 1.0): a resting lift is down at <= DOWN, and up at >= UP


class Outcome(Enum):
    """How a step of the gripper ended. The value is a text for people."""

    DONE = "done"
    ALREADY_THERE = "already there"
    GRIPPED = "gripped an object"
    TIMED_OUT = "timed out"
    NO_GRIPPER = "no gripper fitted"

    @property
    def succeeded(self) -> bool:
        """Whether the gripper reached the position of the step."""
        return self not in (Outcome.TIMED_OUT, Outcome.NO_GRIPPER)


class Step(NamedTuple):
    """One movement of the gripper.

    It has a name, a command to the paddles (`grip`) and a command to the lift. The function `there` returns whether the
    reported state of paddles and lift shows that the movement has reached its end.
    """

    name: str
    grip: GripCommand
    lift: LiftCommand
    there: Callable[[Grip, Lift], bool]


def holds(grip: Optional[Grip]) -> bool:
    """Return whether the gripper holds an object. False when `grip` is None.

    An object is held when the paddles are closed, both paddle contacts are pressed, and the object breaks a light beam.
    One of these signs is not enough. The contacts are also pressed when the robot only pushes an object, and the beams
    also read as broken when no gripper is connected.
    """
    return (
        grip is not None and grip.state == GripStatus.CLOSED and grip.left and grip.right
        and (grip.inner or grip.outer))


LOWER = Step(
    "lower", GripCommand.STOP, LiftCommand.DOWN,
    lambda grip, lift: lift.state == LiftStatus.IDLE and lift.position <= DOWN)
OPEN = Step("open", GripCommand.OPEN, LiftCommand.STOP, lambda grip, lift: grip.state == GripStatus.OPEN)
CLOSE = Step("close", GripCommand.CLOSE, LiftCommand.STOP, lambda grip, lift: grip.state == GripStatus.CLOSED)
RAISE = Step(
    "raise", GripCommand.STOP, LiftCommand.UP,
    lambda grip, lift: lift.state == LiftStatus.IDLE and lift.position >= UP)
PICK = (LOWER, OPEN, CLOSE, RAISE)


def judge(step: Step, grip: Optional[Grip], lift: Optional[Lift], commanded: bool) -> Optional[Outcome]:
    """Return how a step of the gripper has ended. None when it has not ended yet.

    Args:
        step: the step.
        grip, lift: the newest reports of paddles and lift. None when there are no reports: no gripper is fitted.
        commanded: whether the command of the step was sent. If not, the result is ALREADY_THERE or NO_GRIPPER when no
            command is needed, and None when one is needed.
    """
    if grip is None or lift is None:
        return None if commanded else Outcome.NO_GRIPPER
    if not step.there(grip, lift):
        return None
    if not commanded:
        return Outcome.ALREADY_THERE
    return Outcome.GRIPPED if step is CLOSE and holds(grip) else Outcome.DONE
