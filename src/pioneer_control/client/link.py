"""What the phases of a connection have in common: the link that they share, the form of a phase, and how a phase ends.
"""

import math
from dataclasses import dataclass, field
from typing import Any, Callable, Generator, List, NamedTuple, Optional, Sequence, Union, cast

from .. import p2os
from ..errors import LinkLostError, PioneerError
from ..robots import RobotModel
from .events import Event
from .line import Line
from .odometry import Odometry
from .settings import Settings

Procedure = Generator[float, Any, Any]
"""What a phase does step by step. It yields the time (monotonic, s) until which it waits, and is sent a packet that
came, or None when that time has come.
"""


class Named(NamedTuple):
    """The robot has said who it is."""

    reply: p2os.SyncReply


class Recognised(NamedTuple):
    """The model of the robot is known."""

    model: RobotModel


class Learned(NamedTuple):
    """The robot is open, its motors are off, and this is what it said."""

    config: Optional[p2os.Config]
    """None from firmware that does not know CONFIG"""
    sip: p2os.Sip
    time: float
    """monotonic time (s) at which this SIP was whole"""
    sent_time: float
    """monotonic time (s) at which the robot began to send it"""


class Left(NamedTuple):
    """The user closes the connection."""


class Gone(NamedTuple):
    """The robot was stopped and closed."""


class Failed(NamedTuple):
    """The connection is over, for this reason."""

    error: PioneerError


Outcome = Union[Named, Recognised, Learned, Left, Gone, Failed]


@dataclass
class HostBaud:
    """What is known of the other line speed. One object serves all connections of a client: so what does not work is
    not tried again.
    """

    wanted: Optional[int]
    """the other speed (baud); None: the robot's own will do"""
    breaks: int = 0
    """times in a row that the change was begun, and the link broke over it"""


@dataclass
class Link:
    """What all phases of one connection share."""

    url: str
    """for error messages"""
    settings: Settings
    line: Line
    now: float
    """monotonic time (s)"""
    host_baud: HostBaud
    decoder: p2os.FrameDecoder = field(default_factory=p2os.FrameDecoder)
    grip_state_first: bool = True
    """which kind of firmware it is (p2os.decode_packet)"""
    last_sip: float = -math.inf
    """when the last SIP came (monotonic, s)"""
    sips: int = 0
    unreadable: int = 0
    """whole packets that nobody understands or can believe"""
    events: List[Event] = field(default_factory=list)
    """what the listeners are to be told"""
    connected_counts: Callable[[], Sequence[int]] = tuple
    """gives what was counted while the robot obeyed, the last fields of session.Counts; nothing before that"""

    def lost(self, how: str) -> LinkLostError:
        """An error that says how the link was lost."""
        return LinkLostError("%s: %s" % (self.url, how))

    def pause(self, seconds: float) -> Procedure:
        """Let time pass, whatever comes meanwhile."""
        deadline = self.now + seconds
        while self.now < deadline:
            yield deadline


class Phase:
    """A phase of a connection. This one takes everything and does nothing.

    Attributes:
        last_words: what a robot in this phase has to hear when the connection ends at once.
        odometry: of this connection, or of the one before until this robot has its own.
    """

    last_words = b""

    def __init__(self, link: Link, odometry: Optional[Odometry]) -> None:
        self._link = link
        self.odometry = odometry

    @property
    def due(self) -> float:
        """When tick() has something to do at the latest (monotonic, s)."""
        return math.inf

    def take(self, packet: Any, sent_time: float) -> Optional[Outcome]:
        """Take a packet that is whole now; the robot began to send it at ``sent_time``."""

    def tick(self, now: float) -> Optional[Outcome]:
        """Let time pass."""

    def use(self, settings: Settings, now: float) -> None:
        """The user wants something else from now on. Most phases have nothing to do for that."""


class SteppedPhase(Phase):
    """A phase that follows a procedure: step by step until it returns its outcome."""

    due = -math.inf     # it begins at once

    def __init__(self, link: Link, odometry: Optional[Odometry]) -> None:
        super().__init__(link, odometry)
        self._procedure = self._steps()

    def take(self, packet: Any, sent_time: float) -> Optional[Outcome]:
        return self._resume(packet)

    def tick(self, now: float) -> Optional[Outcome]:
        return self._resume(None) if now >= self.due else None

    def _steps(self) -> Procedure:
        raise NotImplementedError

    def _resume(self, packet: Any) -> Optional[Outcome]:
        try:
            self.due = self._procedure.send(packet)
        except StopIteration as end:
            return cast(Outcome, end.value)
        except PioneerError as error:
            return Failed(error)
        return None
