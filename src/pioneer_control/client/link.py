"""What the phases of a connection share: the Link, the base classes of a phase, and the outcomes that end a phase."""

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
"""A generator with the steps of a phase. It yields the time (monotonic, s) until which it waits. It receives a packet,
or None when this time has come.
"""


class Named(NamedTuple):
    """Outcome of Connecting: the robot has sent its name."""

    reply: p2os.SyncReply


class Recognised(NamedTuple):
    """Outcome of Synced: the model of the robot is known."""

    model: RobotModel


class Learned(NamedTuple):
    """Outcome of Opening: the robot is open, its motors are off, and it has sent these packets."""

    config: Optional[p2os.Config]
    """CONFIGpac; None from firmware that does not know CONFIG."""
    sip: p2os.Sip
    time: float
    """Monotonic time (s) of the last byte of ``sip``."""
    sent_time: float
    """Monotonic time (s) at which the robot began to send ``sip``."""


class Left(NamedTuple):
    """Outcome of any phase: the user closes the connection."""


class Gone(NamedTuple):
    """Outcome of Closing: the robot was stopped and closed."""


class Failed(NamedTuple):
    """Outcome of any phase: the connection has failed with this error."""

    error: PioneerError


Outcome = Union[Named, Recognised, Learned, Left, Gone, Failed]


@dataclass
class HostBaud:
    """The wanted line speed (setting host_baud), and whether it works.

    All connections of a client share one object. So a line speed that does not work is not tried again.
    """

    wanted: Optional[int]
    """The line speed (baud) to change to; None to stay at the robot's own speed."""
    breaks: int = 0
    """How often in a row the link broke during the change of speed."""


@dataclass
class Link:
    """What all phases of one connection share."""

    url: str
    """The port, for error messages."""
    settings: Settings
    line: Line
    now: float
    """Time (s) of the present call of the session: monotonic, or its own."""
    host_baud: HostBaud
    decoder: p2os.FrameDecoder = field(default_factory=p2os.FrameDecoder)
    grip_state_first: bool = True
    """The kind of firmware, as p2os.decode_packet takes it."""
    last_sip: float = -math.inf
    """Monotonic time (s) at which the last SIP came."""
    sips: int = 0
    unreadable: int = 0
    """Number of whole packets that are unknown, malformed or impossible."""
    events: List[Event] = field(default_factory=list)
    """Events for the listeners. The session takes them out."""
    has_own_time: bool = False
    """Whether only the phase sets ``now``: see the file lockstep."""
    connected_counts: Callable[[], Sequence[int]] = tuple
    """Returns the last three fields of session.Counts, which Connected counts; nothing before that phase."""

    def lost(self, how: str) -> LinkLostError:
        """Return a LinkLostError. Its message has the URL, and says ``how`` the link was lost."""
        return LinkLostError("%s: %s" % (self.url, how))

    def pause(self, seconds: float) -> Procedure:
        """Wait for ``seconds``, and ignore packets that come meanwhile."""
        deadline = self.now + seconds
        while self.now < deadline:
            yield deadline


class Phase:
    """Base class of the phases of a connection. Its own methods do nothing.

    Attributes:
        last_words: bytes that the robot must get when the connection ends at once in this phase.
        odometry: odometry of this connection, or of the previous one until this connection has its own; None without
            either.
    """

    last_words = b""

    def __init__(self, link: Link, odometry: Optional[Odometry]) -> None:
        self._link = link
        self.odometry = odometry

    @property
    def due(self) -> float:
        """Time (monotonic, s) by which tick() must be called; infinity when nothing is due."""
        return math.inf

    def take(self, packet: Any, sent_time: float) -> Optional[Outcome]:
        """Take a packet that has just arrived. Returns an outcome if this ends the phase.

        ``sent_time`` is when the robot began to send the packet (monotonic, s).
        """

    def tick(self, now: float) -> Optional[Outcome]:
        """Do what is due at ``now`` (monotonic, s). Returns an outcome if this ends the phase."""

    def use(self, settings: Settings, now: float) -> None:
        """Use these settings from ``now`` (monotonic, s) on. Most phases have nothing to do."""


class SteppedPhase(Phase):
    """A phase that runs a procedure step by step. The procedure returns the outcome of the phase."""

    due = -math.inf     # the procedure begins at once

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
