"""What the gripper's reports mean, and the steps of a pick: pure, without ROS."""

from enum import Enum
from typing import Callable, NamedTuple, Optional

from ..message_values import GripCommand, GripStatus, LiftCommand, LiftStatus
from .snapshot import Grip, Lift

DOWN, UP = 0.1, 0.9  # of the lift's position, 0.0 to 1.0: at rest beyond these, it is there


class Outcome(Enum):
    """How a step of the gripper ended; the value is what to tell people."""

    DONE = "done"
    ALREADY_THERE = "already there"
    GRIPPED = "gripped an object"
    TIMED_OUT = "timed out"
    NO_GRIPPER = "no gripper fitted"

    @property
    def succeeded(self) -> bool:
        """Is the gripper where the step should bring it?"""
        return self not in (Outcome.TIMED_OUT, Outcome.NO_GRIPPER)


class Step(NamedTuple):
    """One movement of the gripper: its name, the two commands it takes, and how its end shows."""

    name: str
    grip: GripCommand
    lift: LiftCommand
    there: Callable[[Grip, Lift], bool]


def holds(grip: Optional[Grip]) -> bool:
    """Is an object held? The paddles have closed, both feel it, and it is in a beam.

    All three are needed: contacts alone show while something is only pushed, beams alone when nothing is connected.
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
    """How a step has ended as far as the gripper reports; None while it goes on.

    Args:
        step: the step that is judged.
        grip, lift: the newest reports; None without a gripper.
        commanded: False before the step's command was given. What the gripper reports then was so before.
    """
    if grip is None or lift is None:
        return None if commanded else Outcome.NO_GRIPPER
    if not step.there(grip, lift):
        return None
    if not commanded:
        return Outcome.ALREADY_THERE
    return Outcome.GRIPPED if step is CLOSE and holds(grip) else Outcome.DONE
