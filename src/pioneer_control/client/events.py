"""What a listener is told: the states of the robot, and one small value for each other thing that happens on the link.
"""

from typing import Any, NamedTuple, Optional, Tuple, Union

from ..errors import PioneerError
from .identity import RobotIdentity
from .state import RobotState
from .tuning import Change


class Ready(NamedTuple):
    """The handshake is done: states follow. Motors are off."""

    identity: RobotIdentity


class LinkDown(NamedTuple):
    """There is no link: the port did not open, nothing answered, or the link worked and is gone.

    The message of ``error`` says what to do.
    """

    error: PioneerError
    retry_in: float
    """s until the next attempt; negative when there will be none."""


class CommandTimedOut(NamedTuple):
    """No new velocity came within the command time-out: the robot was told to stop."""

    age: float
    """s since the last velocity command."""


class MotionCleared(NamedTuple):
    """The robot took the motors away (STOP button, stall, MOTORS button): set points are zero now and stay so until a
    new command.
    """

    reason: str


class Unmoved(NamedTuple):
    """The robot was told to drive, its motors are on, and no wheel is stalled. Yet it stands: perhaps it does not hear.

    This is told once, and again only after the robot has moved.
    """

    age: float
    """s for which it has stood."""


class MotorsAnswered(NamedTuple):
    """A request for the motors has its answer."""

    on: bool
    """what was asked for"""
    changed: bool
    """whether the motors were in the other state before"""
    error: Optional[PioneerError]
    """why the robot did not do it; None when it did"""


class StatesMissed(NamedTuple):
    """The listeners were too slow: the oldest states and packets that waited for them were dropped.

    Other events are never dropped.
    """

    number: int
    """since the last time that this was told"""


class BaudFound(NamedTuple):
    """The robot answered at another line speed than the one given."""

    baud: int


class LineSpeed(NamedTuple):
    """The line speed of a connection, where host_baud asked for another than the robot's own."""

    baud: int
    problem: str
    """Why it is still the robot's own; empty when it is the one asked for."""


class Tuned(NamedTuple):
    """Settings were sent, after connecting or by tune(), and the robot has answered; or set_limits() changed limits."""

    changes: Tuple[Change, ...]
    """one per value sent; its ``problem`` says if the robot did not take it"""
    identity: RobotIdentity
    """with the new CONFIGpac, and the limits that follow from it"""


class PacketReceived(NamedTuple):
    """A packet other than the standard SIP (IOpac, ENCODERpac, ...) as decoded by p2os."""

    packet: Any
    time: float
    """Monotonic time (s) of its last byte."""
    sent_time: float
    """Monotonic time (s) of its first byte: ``time`` without what the line took to carry the packet."""


Event = Union[
    RobotState, Ready, LinkDown, CommandTimedOut, MotionCleared, Unmoved, MotorsAnswered, StatesMissed, BaudFound,
    LineSpeed, Tuned, PacketReceived]
