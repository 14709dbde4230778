"""One connection to one robot, sans-I/O: bytes and time go in, bytes and events come out.

The owner of a session calls receive() with the bytes that it has read, and tick() at ``wake_at`` at the latest. After
each call of any method it sends data_to_send(), and gives events() to the listeners. A session uses no clock, no thread
and no port. The steps of a connection are in `phases`.
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
from .lockstep import LOCKSTEP_TRANSITIONS
from .odometry import Odometry
from .phases import TRANSITIONS, Connected, Finished
from .settings import Settings


class Counts(NamedTuple):
    """The counters of one session. robot.LinkCounts explains each of them."""

    sips: int = 0
    bad_checksums: int = 0
    discarded_bytes: int = 0
    unreadable: int = 0
    unknown_sonar: int = 0
    questions: int = 0
    unanswered: int = 0


class Session:
    """One connection, from its first byte to its last. ``now`` is monotonic time in s everywhere.

    In lockstep a connected session has a time of its own: time() converts.

    Args:
        url: the port, for error messages.
        rates: line speeds to try, the present speed of the port first; empty on TCP.
        settings: the user's settings.
        now: time at which the session begins.
        odometry: odometry of the previous connection, to be continued if this robot uses the same units; None for the
            first connection.
        host_baud: the wanted line speed, and what previous connections found out about it; None for the first
            connection.
        lockstep: whether a simulated robot waits for the program at each SIP: see the file lockstep.

    Attributes:
        phase: the present phase; an object of one of the classes of `phases`.
    """

    def __init__(self, url: str, rates: Tuple[int, ...], settings: Settings, now: float,
                 odometry: Optional[Odometry] = None,
                 host_baud: Optional[HostBaud] = None, lockstep: bool = False) -> None:
        self.line = Line(rates[0] if rates else None, STOP)
        self._link = Link(url, settings, self.line, now, host_baud or HostBaud(settings.host_baud))
        self._last_byte = now
        self._transitions = LOCKSTEP_TRANSITIONS if lockstep else TRANSITIONS
        self.phase: Phase = Connecting(self._link, rates, odometry)
        self.tick(now)

    @property
    def connected(self) -> Optional[Connected]:
        """The present phase if the robot is connected and obeys; else None."""
        return self.phase if isinstance(self.phase, Connected) else None

    @property
    def finished(self) -> bool:
        """Whether the connection is over."""
        return isinstance(self.phase, Finished)

    @property
    def error(self) -> Optional[PioneerError]:
        """Why the connection ended; None when the user closed it, and while it is not over."""
        return self.phase.error if isinstance(self.phase, Finished) else None

    @property
    def wake_at(self) -> float:
        """Time (s, of this session) by which tick() must be called; infinity once finished.

        After a tick it is in the future.
        """
        if isinstance(self.phase, Finished):
            return math.inf
        due = min(self.phase.due, self.line.due)
        return min(due, self._last_byte + p2os.PARTIAL_TIMEOUT) if self._link.decoder.waiting else due

    def time(self, now: float) -> float:
        """Return the time (s) of this session at the monotonic time ``now``: the same, unless it is in lockstep."""
        return self._link.now if self._link.has_own_time else now

    def receive(self, data: bytes, now: float) -> None:
        """Take bytes from the robot, in pieces of any size."""
        self._link.now = self._last_byte = self.time(now)
        self._read(self._link.decoder.feed(data))

    def tick(self, now: float) -> None:
        """Do what is due at ``now``."""
        link = self._link
        link.now = self.time(now)
        if link.decoder.waiting and link.now >= self._last_byte + p2os.PARTIAL_TIMEOUT:
            self._read(link.decoder.drop_partial())
        self._follow(self.phase.tick(link.now))
        self.line.tick(link.now)

    def use(self, settings: Settings, now: float) -> None:
        """Use these settings from now on."""
        self._link.settings = settings
        self.phase.use(settings, self.time(now))

    def close(self, now: float) -> None:
        """Begin to close: stop the robot, switch its motors off, send CLOSE.

        A robot to which nothing was sent yet gets nothing.
        """
        self._link.now = self.time(now)
        self._follow(Left())

    def fail(self, error: PioneerError) -> None:
        """End the connection at once with this error. The robot gets ``last_words`` of the present phase.

        For a connected robot these are a stop, motors off, and CLOSE.
        """
        self._follow(Failed(error))

    def data_to_send(self) -> List[Action]:
        """Return the new actions for the line (bytes to write, changes of speed), in order. Each action comes once."""
        actions, self.line.to_send = self.line.to_send, []
        for action in actions:
            if isinstance(action, SetBaud):
                self._link.decoder.drop_partial()   # its bytes came at the old speed
        return actions

    def events(self) -> List[Event]:
        """Return the new events for the listeners, in order. Each event comes once."""
        events = self._link.events[:]
        self._link.events.clear()
        return events

    @property
    def counts(self) -> Counts:
        """The counters of this session up to now."""
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
            outcome = self.phase.take(packet, link.now - frame.length * byte_time)
            if outcome is not None:
                self._follow(outcome)

    def _follow(self, outcome: Optional[Outcome]) -> None:
        """Go on to the phase that the table has for this outcome. The new phase begins at once."""
        while outcome is not None:
            following = self._transitions.get((type(self.phase), type(outcome)))
            if following is None:
                return
            self.phase = following(self._link, self.phase, outcome)
            outcome = self.phase.tick(self._link.now)
