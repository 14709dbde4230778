"""Events for listeners: each RobotState, and one small class for each other thing that happens on the link."""

from typing import Any, NamedTuple, Optional, Tuple, Union

from ..errors import PioneerError
from .identity import RobotIdentity
from .state import RobotState
from .tuning import Change


class Ready(NamedTuple):
    """The robot is connected. Its motors are off. From now on states arrive."""

    identity: RobotIdentity


class LinkDown(NamedTuple):
    """There is no link: the port did not open, nothing answered, or the link worked and is gone.

    The message of ``error`` says what to do.
    """

    error: PioneerError
    retry_in: float
    """Time (s) until the next attempt to connect; negative when there is no further attempt."""


class CommandTimedOut(NamedTuple):
    """The client stopped the robot, because no new velocity came within the command time-out."""

    age: float
    """Time (s) since the last velocity command."""


class MotionCleared(NamedTuple):
    """The robot switched its motors off by itself (STOP button, stall, MOTORS button).

    The client has set the velocity to zero. It stays zero until a new command.
    """

    reason: str


class Unmoved(NamedTuple):
    """The robot stands although a velocity is commanded, its motors are on, and no wheel is stalled.

    Perhaps the commands do not reach it. The event comes once, and again only after the robot has moved.
    """

    age: float
    """Time (s) for which the robot has stood."""


class MotorsAnswered(NamedTuple):
    """A request to switch the motors on or off has succeeded or failed."""

    on: bool
    """True for a request to switch them on, False for a request to switch them off."""
    changed: bool
    """Whether the motors were in the other state when the request was made."""
    error: Optional[PioneerError]
    """Why the request failed; None when it succeeded."""


class StatesMissed(NamedTuple):
    """States and packets were dropped, the oldest first, because the listeners were too slow.

    Other events are never dropped.
    """

    number: int
    """How many were dropped since the last StatesMissed."""


class BaudFound(NamedTuple):
    """The robot answered at another line speed (``baud``) than the given one."""

    baud: int


class LineSpeed(NamedTuple):
    """The line speed of this connection. It is reported when host_baud asks for another speed than the robot's own."""

    baud: int
    problem: str
    """Why the line is still at the robot's own speed; empty when it is at the speed that host_baud asks for."""


class Tuned(NamedTuple):
    """The result of settings that were sent after connecting or by tune(). It also comes when the limits change."""

    changes: Tuple[Change, ...]
    """One for each value that was sent. Its ``problem`` says why the robot did not take the value."""
    identity: RobotIdentity
    """The identity with the newest CONFIGpac, and with the present limits."""


class PacketReceived(NamedTuple):
    """A packet other than the standard SIP (IOpac, ENCODERpac, ...), as p2os decodes it."""

    packet: Any
    time: float
    """Monotonic time (s) of its last byte."""
    sent_time: float
    """Monotonic time (s) of its first byte: ``time`` minus the time that the line took to carry the packet."""


Event = Union[
    RobotState, Ready, LinkDown, CommandTimedOut, MotionCleared, Unmoved, MotorsAnswered, StatesMissed, BaudFound,
    LineSpeed, Tuned, PacketReceived]
