"""One connection to one robot, sans-I/O: bytes and time go in, bytes and events come out.

The owner of a session calls receive() with what was read and tick() at ``wake_at`` at the latest. After each call of
any kind it sends data_to_send() and hands events() to the listeners. Nothing in here knows a clock, a thread or a port.
What happens when is in `phases`.
"""

import math
from typing import List, NamedTuple, Optional, Tuple

from .. import p2os
from ..errors import PioneerError
from .drive import STOP
from .events import Event
from .handshake import Connecting
from .line import Action, Line, SetBaud
from .link import Failed, HostBaud, Left, Link, Outcome, Phase
from .odometry import Odometry
from .phases import TRANSITIONS, Connected, Finished
from .settings import Settings


class Counts(NamedTuple):
    """What one session has counted: see robot.LinkCounts."""

    sips: int = 0
    bad_checksums: int = 0
    discarded_bytes: int = 0
    unreadable: int = 0
    unknown_sonar: int = 0
    questions: int = 0
    unanswered: int = 0


class Session:
    """One connection, from its first byte to its last. ``now`` is monotonic time in s everywhere.

    Args:
        url: for error messages.
        rates: line speeds to try, the port's present one first; empty on TCP.
        settings: what the user wants.
        now: when it begins.
        odometry: of the connection before, to be continued if this is the same kind of robot.
        host_baud: what the connections before found out about the other line speed; None for the first one.

    Attributes:
        phase: what is true now; one of the classes of `phases`.
    """

    def __init__(self, url: str, rates: Tuple[int, ...], settings: Settings, now: float,
                 odometry: Optional[Odometry] = None,
                 host_baud: Optional[HostBaud] = None) -> None:
        self.line = Line(rates[0] if rates else None, STOP)
        self._link = Link(url, settings, self.line, now, host_baud or HostBaud(settings.host_baud))
        self._last_byte = now
        self.phase: Phase = Connecting(self._link, rates, odometry)
        self.tick(now)

    @property
    def connected(self) -> Optional[Connected]:
        """The phase in which the robot obeys; None in any other."""
        return self.phase if isinstance(self.phase, Connected) else None

    @property
    def finished(self) -> bool:
        """Whether the connection is over."""
        return isinstance(self.phase, Finished)

    @property
    def error(self) -> Optional[PioneerError]:
        """Why the connection is over; None when it was closed, or is not over."""
        return self.phase.error if isinstance(self.phase, Finished) else None

    @property
    def wake_at(self) -> float:
        """When tick() is to be called at the latest; infinity once finished. After a tick always in the future."""
        if isinstance(self.phase, Finished):
            return math.inf
        due = min(self.phase.due, self.line.due)
        return min(due, self._last_byte + p2os.PARTIAL_TIMEOUT) if self._link.decoder.waiting else due

    def receive(self, data: bytes, now: float) -> None:
        """Take bytes as they came, in any pieces."""
        self._link.now = self._last_byte = now
        self._read(self._link.decoder.feed(data))

    def tick(self, now: float) -> None:
        """Let time pass."""
        link = self._link
        link.now = now
        if link.decoder.waiting and now >= self._last_byte + p2os.PARTIAL_TIMEOUT:
            self._read(link.decoder.drop_partial())
        self._follow(self.phase.tick(now))
        self.line.tick(now)

    def use(self, settings: Settings, now: float) -> None:
        """The user wants something else from now on."""
        self._link.settings = settings
        self.phase.use(settings, now)

    def close(self, now: float) -> None:
        """Stop, motors off, CLOSE. A robot that was only listened to is told nothing."""
        self._link.now = now
        self._follow(Left())

    def fail(self, error: PioneerError) -> None:
        """The connection is over, for this reason. A robot that may still hear us is told to stop."""
        self._follow(Failed(error))

    def data_to_send(self) -> List[Action]:
        """What is to be done on the line, in order; each only once."""
        actions, self.line.to_send = self.line.to_send, []
        for action in actions:
            if isinstance(action, SetBaud):
                self._link.decoder.drop_partial()   # what came at the old speed
        return actions

    def events(self) -> List[Event]:
        """What the listeners are to be told, in order; each only once."""
        events = self._link.events[:]
        self._link.events.clear()
        return events

    @property
    def counts(self) -> Counts:
        """What the line brought."""
        link, counts = self._link, self._link.decoder.counts
        return Counts(link.sips, counts.bad_checksums + counts.bad_counts, counts.discarded_bytes, link.unreadable,
                      *link.connected_counts())

    def _read(self, frames: List[p2os.Frame]) -> None:
        link, byte_time = self._link, self.line.byte_time
        for frame in frames:
            packet = p2os.decode_packet(frame, link.grip_state_first)
            if isinstance(packet, p2os.Sip):
                link.sips += 1
                link.last_sip = link.now
            self._follow(self.phase.take(packet, link.now - frame.length * byte_time))

    def _follow(self, outcome: Optional[Outcome]) -> None:
        """Go on to the phase that the table names after this outcome. That phase begins at once."""
        while outcome is not None:
            following = TRANSITIONS.get((type(self.phase), type(outcome)))
            if following is None:
                return
            self.phase = following(self._link, self.phase, outcome)
            outcome = self.phase.tick(self._link.now)
