"""The handshake: find a robot on a port in an unknown state, and get the robot's name (protocol 2.2, 13).

Before a session the command numbers 0, 1, 2 mean SYNC0, SYNC1, SYNC2. In a session they mean PULSE, OPEN, CLOSE. Two
mistakes are possible:

* A program may have crashed and left the robot open. Such a robot takes SYNC0 for PULSE, a sign of life, and drives on
  at its old speed. An open robot sends SIPs, so the client listens first.
* A robot that waits for a handshake takes every packet for a step of it. It takes CLOSE for SYNC2. The vendor's
  simulator then opens a session, or gives up.

So the client sends CLOSE to a robot that it hears, until the robot is silent. What it sends to a silent robot depends
on the line. On TCP nothing is lost: the client sends SYNC0 at once. On a serial line all packets of an open robot may
have been lost: the client sends CLOSE several times, because the robot does not acknowledge it, and then SYNC0.

::

    listen 0.26 s ──silence──────────────> [serial: CLOSE six times] SYNC0 ─echo─> SYNC1 ─echo─> SYNC2 ─> its name
         │                                            │ a SIP: it was open after all ──┐
         └─SIPs, or noise──> CLOSE until silent <─────┴────────────────────────────────┘
                                   └─ noise goes on ── 2 tries: next line speed

On TCP an open robot may hear the client, while the client does not hear the robot. SYNC0 is a sign of life to such a
robot, and it drives on. So when all tries have failed, the client sends CLOSE right before it closes the connection.

When no answer comes at all, the client tries again. A robot that answers too late gets more time at each further try.
A robot that has sent its name but was never opened is silent, too. On a serial line CLOSE ends this state. On TCP a
SYNC1 after an unanswered SYNC0 ends it: such a robot takes SYNC1 for OPEN. A slow robot takes it for the next step of
the handshake.

Some robots take CLOSE for SYNC2 when they are closed. One CLOSE closes such a robot, and the next CLOSE opens it. An
even number of CLOSEs leaves the robot as it was. An odd number closes the robot if it was open. So a silent robot gets
an even number of CLOSEs, and a robot that is heard gets an odd number.

HOSTBAUD may have raised the line speed of a robot that was left open. At CLOSE this robot falls back to its own speed.
Then the client tries the other speeds once more.

A robot that was connected before is most likely still at the same line speed. The client tries this speed four times,
and again after each other speed. It tries each other speed once.

The longest time from the first byte until the robot is ready, with firmware that does not know CONFIG (0.9 s less with
other firmware):

=============================================  =================  ====================
the robot                                      at a known speed   at any of the five
=============================================  =================  ====================
waits                                          1.4 s              4.4 s
was left open, and streams                     1.7 s              3.9 s
was left open at a speed that was raised       3.0 s              7.0 s
is not there                                   0.8 s              3.8 s (TCP: 2.1 s)
=============================================  =================  ====================

For a speed that was raised, "known" means that the client was given both the robot's own speed, and the raised speed as
host_baud.
"""

from typing import Any, Generator, List, Optional, Tuple

from .. import p2os
from ..errors import NoAnswerError
from .link import Link, Named, Outcome, Procedure, SteppedPhase
from .odometry import Odometry

RATES = (9600, 38400, 19200, 115200, 57600)     # in the order of their likelihood

LISTEN = 0.26           # s: more than two usual SIP cycles, and more than one of the longest that can be set (255 ms)
# CLOSEs to a silent robot on a serial line, where half of all packets may get lost. The number is even. Six CLOSEs and
# three SYNCs are fewer than the ten packets after which the vendor's simulator hangs up.
CLOSES = 6
CLOSES_IF_HEARD = 7     # CLOSEs to a robot that is heard; an odd number
DRAIN = 0.1             # s for the bytes that were under way when CLOSE was sent, and for CLOSE itself
QUIET = 0.2             # s of silence after that: the robot waits for a SYNC now
CLOSE_TRIES = 10
SYNC_TIMEOUT = 0.25     # s for the echo of each SYNC
LONGEST_SYNC_TIMEOUT = 1.0  # s for the echo of a robot that answers too late: it gets twice as long at each further try
SYNC_TRIES = 2          # per line speed
SYNC_TRIES_AGAIN = 4    # at the speed at which the robot was found before
TCP_TRIES = 6
TCP_TRY_WITH_SYNC1 = 2  # the try (counted from 0) in which SYNC1 follows an unanswered SYNC0; seven packets in all

SYNC = [p2os.encode_frame(number) for number in (p2os.SYNC0, p2os.SYNC1, p2os.SYNC2)]
CLOSE = p2os.encode_command("CLOSE")

UNHEARD = 3.0           # s that a robot may drive on without a link: until its watchdog stops it, and its ramp

BEFORE_A_SESSION = (p2os.SyncEcho, p2os.SyncReply, p2os.Reset)
"""Packets that a robot sends while it is not open."""


class Connecting(SteppedPhase):
    """The first phase of a connection: listen, close a robot that was left open, and synchronise.

    Args:
        link: its port is open, and nothing was sent yet.
        odometry: of the previous connection, which worked at the first of the line speeds; None for the first
            connection.

    Attributes:
        rates: line speeds to try, the present one first; empty on TCP.
    """

    def __init__(self, link: Link, rates: Tuple[int, ...], odometry: Optional[Odometry]) -> None:
        super().__init__(link, odometry)
        self.rates = rates
        self._own_rate = rates[0] if rates and odometry is not None else None
        self._packets = self._noise = 0     # packets heard so far, and bytes that belonged to none
        self._said_its_name = False         # SIPs from then on belong to a new session
        self._heard_open = False            # a packet came that only an open robot sends, or noise
        self._answers_late = False          # an echo came for which nobody waited any more

    def take(self, packet: Any, sent_time: float) -> Optional[Outcome]:
        if isinstance(packet, p2os.Sip) and self.odometry is not None and not self._said_its_name:
            # The robot was left open, and went on counting.
            self.odometry.update(packet.x_counts, packet.y_counts, packet.heading_units, UNHEARD)
        self._said_its_name |= isinstance(packet, p2os.SyncReply)
        self._packets += 1
        self._heard_open |= not isinstance(packet, BEFORE_A_SESSION)
        return super().take(packet, sent_time)

    def _resume(self, packet: Any) -> Optional[Outcome]:
        noise, self._noise = self._noise, self._link.decoder.counts.discarded_bytes
        self._heard_open |= self._noise > noise
        return super()._resume(packet)

    def _steps(self) -> Procedure:
        """Find the robot, and return its name (Named). Raises NoAnswerError that says what was tried."""
        line, attempts, fell_back, listens = self._link.line, self._attempts(), False, True
        while attempts:
            (rate, tries), heard_before = attempts.pop(0), self._packets
            if rate is not None and rate != line.baud:
                line.set_baud(rate)
            silent = not listens or (yield from self._is_silent(LISTEN)) or (yield from self._silenced())
            # With a known speed a fast reconnect is more important: CLOSE is sent before SYNC0 anyway.
            listens = self._own_rate is None
            reply = (yield from self._tried(tries)) if silent else None
            if reply is not None:
                return Named(reply)
            if self._packets > heard_before and rate != self._own_rate and not fell_back:
                # The robot obeyed CLOSE, and waits at its own speed now: HOSTBAUD had raised this one.
                attempts, fell_back = [each for each in self._attempts() if each[0] != rate], True
        raise NoAnswerError(self._what_to_do())

    def _attempts(self) -> List[Tuple[Optional[int], int]]:
        """Return the line speeds in the order of the tries, each with its number of tries. On TCP the speed is None.

        The line speed of a previous connection is tried again after each other speed.
        """
        if not self.rates:
            return [(None, TCP_TRIES)]
        if self._own_rate is None:
            return [(rate, SYNC_TRIES) for rate in self.rates]
        own = (self._own_rate, SYNC_TRIES_AGAIN)
        return [own, *(each for other in self.rates[1:] for each in ((other, 1), own))]

    def _tried(self, tries: int) -> Generator[float, Any, Optional[p2os.SyncReply]]:
        """Synchronise with a silent robot. Returns the reply with its name; None when no try has success.

        A robot that answers as an open robot is closed at once. An open robot gets twice as many tries, and a robot
        that answers late does, too.
        """
        self._answers_late, timeout = False, SYNC_TIMEOUT
        for attempt in range(2 * tries):
            if self._answers_late:
                timeout = min(2 * timeout, LONGEST_SYNC_TIMEOUT)
            reply = yield from self._synced(attempt, timeout)
            heard_open = self._heard_open
            if reply is not None or heard_open and not (yield from self._silenced()):
                return reply
            if attempt + 1 >= tries and not heard_open and not self._answers_late:
                break
        return None

    def _is_silent(self, seconds: float) -> Generator[float, Any, bool]:
        """Listen for ``seconds``. Returns False as soon as a packet of an open robot or noise comes; else True."""
        self._heard_open = False
        deadline = self._link.now + seconds
        while self._link.now < deadline and not self._heard_open:
            yield deadline
        return not self._heard_open

    def _silenced(self) -> Generator[float, Any, bool]:
        """Send CLOSE until the robot is silent. Returns False when it does not obey, or when only noise comes."""
        link = self._link
        for _ in range(CLOSE_TRIES):
            for _ in range(CLOSES_IF_HEARD):
                link.line.command(link.now, CLOSE)
            yield from link.pause(DRAIN)
            noise, packets = self._noise, self._packets
            silent = yield from self._is_silent(QUIET)
            # Noise alone: this is not the line speed of this robot.
            if silent or self.rates and self._packets == packets and self._noise > noise:
                return silent
        return False

    def _synced(self, attempt: int, timeout: float) -> Generator[float, Any, Optional[p2os.SyncReply]]:
        """Send SYNC0, SYNC1, SYNC2, each after the echo of the one before. Returns the reply with the robot's name.

        Returns None when an answer does not come within ``timeout`` s. ``attempt`` counts the tries from 0. On a serial
        line the client sends CLOSEs first. The last CLOSE and SYNC0 go out in one write, because somebody may plug in
        the cable of an open robot at this very moment.
        """
        self._heard_open = False
        link, answer = self._link, None
        if self.rates:
            for _ in range(CLOSES - 1):
                link.line.command(link.now, CLOSE)
        else:
            # for a robot that hears us and is not heard: SYNC0 may have revived its old speed.
            self.last_words = CLOSE * CLOSES
        also_sync1 = not self.rates and attempt == TCP_TRY_WITH_SYNC1
        for number, packet in enumerate(SYNC):
            link.line.command(link.now, *((CLOSE,) if self.rates and number == p2os.SYNC0 else ()), packet)
            answer = yield from self._answer(number, timeout)
            if answer is None and not (also_sync1 and number == p2os.SYNC0 and not self._heard_open):
                return None
        return answer

    def _answer(self, number: int, timeout: float) -> Generator[float, Any, Any]:
        """Wait for the robot's answer to SYNC ``number``. Returns None when no answer comes within ``timeout`` s.

        Late echoes of earlier SYNCs are ignored. A SIP means that the robot is open, and the answer is None. But SIPs
        are ignored when the robot has sent its name too early, before the expected echo. Such a robot took the CLOSEs
        for SYNC2 and CLOSE in turn, and sent SIPs in between.
        """
        deadline = self._link.now + timeout
        took_closes_for_sync2 = False
        while self._link.now < deadline:
            packet = yield deadline
            if isinstance(packet, p2os.SyncReply):
                if number == p2os.SYNC2:
                    return packet
                took_closes_for_sync2 = True
            elif isinstance(packet, p2os.SyncEcho):
                if packet.number == number != p2os.SYNC2:
                    return packet
                self._answers_late = True
            # A robot sends Reset when the number of a SYNC is wrong. After SYNC0 the CLOSEs before it may be the cause.
            elif (isinstance(packet, p2os.Sip) and not took_closes_for_sync2 or
                  isinstance(packet, p2os.Reset) and number != p2os.SYNC0):
                return None
        return None

    def _what_to_do(self) -> str:
        tried = "at %s baud" % ", ".join(map(str, self.rates)) if self.rates else "over TCP"
        heard = " (%d bytes came that make no packet: is this the robot's port?)" % self._noise if self._noise else ""
        if self._packets:
            heard = (" (%d packets came: from a robot that does not obey CLOSE, or one that another program drives)"
                     % self._packets)
        return (
            "%s: nothing answers as a robot, tried %s%s. Is it switched on, its controller running, the cable in its "
            "serial port, and no other program connected? Without a robot: python3 -m pioneer_control.simulator "
            "simulates one; in ROS, pioneer.launch with sim:=true" % (self._link.url, tried, heard)
        )
