"""From a port in an unknown state to a robot that has said its name (protocol 2.2, 13).

Before a session the numbers 0, 1, 2 mean SYNC0, SYNC1, SYNC2; in one they mean PULSE, OPEN, CLOSE. Two mistakes are
possible:

* A robot that a crashed program left open takes SYNC0 for a sign of life, and drives on at its old speed. It streams,
  so listen first.
* To a robot that waits, every packet is a step of the handshake. CLOSE is SYNC2 to it. The vendor's simulator then
  opens, or gives up.

So a robot that is heard gets CLOSE until it is silent. What a silent robot gets depends on the line. On TCP nothing is
lost: it gets SYNC0, and nothing before it. On a serial line all packets of an open robot may have been lost: it gets
CLOSE several times, because nothing acknowledges it, then SYNC0.

::

    listen 0.26 s ──silence──────────────> [serial: CLOSE six times] SYNC0 ─echo─> SYNC1 ─echo─> SYNC2 ─> its name
         │                                            │ a SIP: it was open after all ──┐
         └─SIPs, or noise──> CLOSE until silent <─────┴────────────────────────────────┘
                                   └─ noise goes on ── 2 tries: next line speed

On TCP an open robot may hear SYNC0 and not be heard: SYNC0 is a sign of life to it, and it drives on. So CLOSE follows
when all tries were in vain, right before the client hangs up.

When no answer comes at all, the client tries again. A robot that answers too late gets more time at each further try.
A robot that said its name but was never opened is silent, too. On a serial line CLOSE ends that. On TCP a SYNC1 after
an unanswered SYNC0 ends it: to that robot it is OPEN, and to a slow robot it is the next step.

A robot to which CLOSE is SYNC2 is closed by one CLOSE and opened by the next. An even number of them leaves the robot
as it was. An odd number closes it if it was open. So a silent robot gets an even number, and a robot that is heard gets
an odd number.

At CLOSE a robot that was left open at a speed which HOSTBAUD had raised falls back to its own speed. Then the other
speeds are tried once more.

A robot that was connected before is most likely at the line speed that it had. This speed is tried four times, and
again after each other speed. Each other speed is tried once.

At the latest it takes from the first byte until the robot is ready, with firmware that does not know CONFIG (0.9 s less
with any other):

=============================================  =================  ====================
the robot                                      at a known speed   at any of the five
=============================================  =================  ====================
waits                                          1.4 s              4.4 s
was left open, and streams                     1.7 s              3.9 s
was left open at a speed that was raised       3.0 s              7.0 s
is not there                                   0.8 s              3.8 s (TCP: 2.1 s)
=============================================  =================  ====================

"Known" means of a raised speed: the robot's own speed was given, and the raised speed as host_baud.
"""

from typing import Any, Generator, List, Optional, Tuple

from .. import p2os
from ..errors import NoAnswerError
from .link import Link, Named, Outcome, Procedure, SteppedPhase
from .odometry import Odometry

RATES = (9600, 38400, 19200, 115200, 57600)     # in the order of their likelihood

LISTEN = 0.26           # s: two SIP cycles and some, and one of the longest that can be set (255 ms)
# To a silent robot on a serial line, where half of all packets may get lost. The number is even. Together with three
# SYNCs these are fewer than the ten packets after which the vendor's simulator hangs up.
CLOSES = 6
CLOSES_IF_HEARD = 7     # odd
DRAIN = 0.1             # s for what was under way when CLOSE was sent, and for CLOSE itself
QUIET = 0.2             # s of silence after that: the robot waits for a SYNC now
CLOSE_TRIES = 10
SYNC_TIMEOUT = 0.25     # s for the echo of each SYNC
LONGEST_SYNC_TIMEOUT = 1.0  # s for the echo of a robot that answers too late: it gets twice as long at each further try
SYNC_TRIES = 2          # per line speed
SYNC_TRIES_AGAIN = 4    # at the speed at which the robot was found before
TCP_TRIES = 6
TCP_TRY_WITH_SYNC1 = 2  # counted from 0; seven packets in all

SYNC = [p2os.encode_frame(number) for number in (p2os.SYNC0, p2os.SYNC1, p2os.SYNC2)]
CLOSE = p2os.encode_command("CLOSE")

UNHEARD = 3.0           # s that a robot may have gone on for without a link: until its watchdog stops it, and a ramp

BEFORE_A_SESSION = (p2os.SyncEcho, p2os.SyncReply, p2os.Reset)
"""What a robot sends that is not open."""


class Connecting(SteppedPhase):
    """Nobody knows yet whether there is a robot: listen, close one that was left open, sync.

    Args:
        link: the port is open, and nothing was sent.
        odometry: of the connection before, in which the robot was found at the first of the line speeds.

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
        """Find the robot. Raises NoAnswerError that says what was tried."""
        line, attempts, fell_back, listens = self._link.line, self._attempts(), False, True
        while attempts:
            (rate, tries), heard_before = attempts.pop(0), self._packets
            if rate is not None and rate != line.baud:
                line.set_baud(rate)
            silent = not listens or (yield from self._is_silent(LISTEN)) or (yield from self._silenced())
            listens = self._own_rate is None    # else time counts more: CLOSE goes ahead of SYNC0 anyway
            reply = (yield from self._tried(tries)) if silent else None
            if reply is not None:
                return Named(reply)
            if self._packets > heard_before and rate != self._own_rate and not fell_back:
                # The robot obeyed CLOSE, and waits at its own speed now: HOSTBAUD had raised this one.
                attempts, fell_back = [each for each in self._attempts() if each[0] != rate], True
        raise NoAnswerError(self._what_to_do())

    def _attempts(self) -> List[Tuple[Optional[int], int]]:
        """The line speeds in the order in which they are tried, and how often the robot is synchronised at each.

        The speed of a robot that was there before is also tried after each other speed.
        """
        if not self.rates:
            return [(None, TCP_TRIES)]
        if self._own_rate is None:
            return [(rate, SYNC_TRIES) for rate in self.rates]
        own = (self._own_rate, SYNC_TRIES_AGAIN)
        return [own, *(each for other in self.rates[1:] for each in ((other, 1), own))]

    def _tried(self, tries: int) -> Generator[float, Any, Optional[p2os.SyncReply]]:
        """Synchronise with a silent robot. Returns its name; None when it never says one.

        A robot that answers as an open robot is closed at once. It gets as many tries again; so does a slow robot.
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
        """Whether neither an open robot nor noise is heard for so long. Returns as soon as one of them is heard."""
        self._heard_open = False
        deadline = self._link.now + seconds
        while self._link.now < deadline and not self._heard_open:
            yield deadline
        return not self._heard_open

    def _silenced(self) -> Generator[float, Any, bool]:
        """Close the robot until it is silent. Returns False when it does not obey, or when noise is all that comes."""
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
        """Send the three SYNCs, each after the echo of the one before. Returns None when the robot does not play along.

        On a serial line CLOSEs go ahead, the last of them in one write with SYNC0: somebody may put back the cable of
        an open robot at this very moment.
        """
        self._heard_open = False
        link, answer = self._link, None
        if self.rates:
            for _ in range(CLOSES - 1):
                link.line.command(link.now, CLOSE)
        else:
            self.last_words = CLOSE * CLOSES    # if it hears us and is not heard: SYNC0 may have revived its old speed
        also_sync1 = not self.rates and attempt == TCP_TRY_WITH_SYNC1
        for number, packet in enumerate(SYNC):
            link.line.command(link.now, *((CLOSE,) if self.rates and number == p2os.SYNC0 else ()), packet)
            answer = yield from self._answer(number, timeout)
            if answer is None and not (also_sync1 and number == p2os.SYNC0 and not self._heard_open):
                return None
        return answer

    def _answer(self, number: int, timeout: float) -> Generator[float, Any, Any]:
        """The robot's answer to one SYNC; None when none comes in time.

        Late echoes of earlier SYNCs are passed over. A SIP means that the robot was open after all. But when the robot
        has said its name before the echo of SYNC0, a SIP means nothing: this robot took the CLOSEs for SYNC2 and CLOSE
        in turn, and sent SIPs in between.
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
            # By Reset a robot says that the count of SYNCs is wrong. After SYNC0 it may mean the CLOSEs ahead of that.
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
