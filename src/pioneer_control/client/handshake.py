"""From a port in an unknown state to a robot that has said its name (protocol 2.2).

Before a session the numbers 0, 1, 2 mean SYNC0, SYNC1, SYNC2; in one they mean PULSE, OPEN, CLOSE. A robot that a crashed program left open takes a
SYNC0 for a sign of life and drives on at its old speed. So first of all: listen. And since packets get lost, close also whom nothing is heard of:
a robot that waits passes over CLOSE. Each time that is said several times in a row, because nothing acknowledges it.

::

    listen 0.26 s ──silence────────────────────────> CLOSE, SYNC0 ─echo─> SYNC1 ─echo─> SYNC2 ─> name, type, subtype
         │                                                   │ no answer: CLOSE (for one that was synced but never opened), try again
         └─SIPs, or noise──> CLOSE until it falls silent ────┤
                                   └─ noise goes on ─────────┴─ 2 tries: next line speed

A robot that was left open at a speed which HOSTBAUD had raised falls back to its own at CLOSE: then the others are tried once more.

At the latest it takes from the first byte until the robot is ready, with firmware that does not know CONFIG (0.9 s less with any other):

=============================================  =================  ====================
the robot                                      at a known speed   at any of the five
=============================================  =================  ====================
waits                                          1.4 s              5.6 s
was left open, and streams                     1.7 s              3.9 s
was left open at a speed that was raised       3.3 s              8.2 s
is not there                                   1.1 s              5.3 s (TCP: 3.3 s)
=============================================  =================  ====================

For a raised one known means that the own speed was given, and the raised one as host_baud.
"""

from typing import Any, Generator, Optional, Tuple

from .. import p2os
from ..errors import NoAnswerError
from .line import Line
from .script import Clock, pause

RATES = (9600, 38400, 19200, 115200, 57600)     # in the order of their likelihood

LISTEN = 0.26           # s: two SIP cycles and some, and one of the longest that can be set (255 ms)
CLOSES = 6              # in a row: half of all packets may get lost. With three SYNCs fewer than the ten after which the vendor's simulator hangs up
DRAIN = 0.1             # s for what was under way when CLOSE was sent, and for CLOSE itself
QUIET = 0.2             # s of silence after that: the robot waits for a SYNC now
CLOSE_TRIES = 10
SYNC_TIMEOUT = 0.25     # s for the echo of each SYNC
SYNC_TRIES = 2          # per line speed
TCP_TRIES = 6

SYNC = [p2os.encode_frame(number) for number in (p2os.SYNC0, p2os.SYNC1, p2os.SYNC2)]
CLOSE = p2os.encode_command("CLOSE")


class Handshake:
    """One attempt. The session keeps ``packets`` and ``noise`` up to date before it resumes the script.

    Args:
        line: to send on.
        url: for the error messages.
        rates: line speeds to try, the present one first; empty on TCP.
        clock: tells monotonic time (s).
        again: whether there was a connection before.
    """

    def __init__(self, line: Line, url: str, rates: Tuple[int, ...], clock: Clock, again: bool = False) -> None:
        self.packets = 0
        """Packets heard so far."""
        self.noise = 0
        """Bytes so far that belonged to no packet."""
        self._line = line
        self._url = url
        self._rates = rates
        self._clock = clock
        self._again = again

    def script(self) -> Generator[float, Any, p2os.SyncReply]:
        """Find the robot. Raises NoAnswerError that says what was tried."""
        noise, packets = self.noise, self.packets
        rates, fell_back = list(self._rates) or [None], False
        while rates:
            rate, heard_before = rates.pop(0), self.packets
            if rate is not None and rate != self._line.baud:
                self._line.set_baud(rate)
            for attempt in range(SYNC_TRIES if self._rates else TCP_TRIES):
                silent = (attempt == 0 and (yield from self._is_silent(LISTEN))) or (yield from self._silenced())
                spoke = self.packets > heard_before
                reply = (yield from self._synced(may_be_open=self._again or attempt > 0)) if silent else None
                if reply is not None:
                    return reply
                if self._rates and not silent:      # noise that no CLOSE ends: not the line speed of this robot
                    break
            if spoke and not fell_back:     # it obeyed CLOSE, and waits at its own speed now: HOSTBAUD had raised this one
                rates, fell_back = [each for each in self._rates if each != rate], True
        raise NoAnswerError(self._what_to_do(self.noise - noise, self.packets - packets))

    def _silenced(self) -> Generator[float, Any, bool]:
        """Close the robot until it is silent; False when what is heard is no robot, or does not obey."""
        for _ in range(CLOSE_TRIES):
            self._close()
            yield from pause(DRAIN, self._clock)
            noise, packets = self.noise, self.packets
            if (yield from self._is_silent(QUIET)):
                return True
            if self.packets == packets and self.noise > noise:
                return False
        return False

    def _close(self) -> None:
        for _ in range(CLOSES):
            self._line.command(self._clock(), CLOSE)

    def _is_silent(self, seconds: float) -> Generator[float, Any, bool]:
        """Whether nothing at all is heard for so long; returns as soon as a packet is."""
        noise, packets, deadline = self.noise, self.packets, self._clock() + seconds
        while self._clock() < deadline and self.packets == packets:
            yield deadline
        return self.packets == packets and self.noise == noise

    def _synced(self, may_be_open: bool) -> Generator[float, Any, Optional[p2os.SyncReply]]:
        """The three SYNCs, each after the echo of the one before; None when the robot does not play along.

        Who was silent just now may be open, with set points that a SYNC0 would revive: its packets were lost, or it is a robot of ours whose cable is
        put back at this very moment. Then one more CLOSE goes right before the SYNC0.
        """
        self._close()
        for number, packet in enumerate(SYNC):
            self._line.command(self._clock(), *((CLOSE,) if number == p2os.SYNC0 and may_be_open else ()), packet)
            answer = yield from self._answer(number)
            if answer is None:
                return None
        return answer

    def _answer(self, number: int) -> Generator[float, Any, Any]:
        """The robot's answer to one SYNC. Late echoes of earlier ones are passed over; a SIP means that it was open after all."""
        deadline = self._clock() + SYNC_TIMEOUT
        while self._clock() < deadline:
            packet = yield deadline
            if isinstance(packet, p2os.SyncReply) and number == p2os.SYNC2:
                return packet
            if isinstance(packet, p2os.SyncEcho) and packet.number == number != p2os.SYNC2:
                return packet
            # A CLOSE before SYNC0 may be "wrong" to it.
            if isinstance(packet, p2os.Sip) or isinstance(packet, p2os.Reset) and number != p2os.SYNC0:
                return None
        return None

    def _what_to_do(self, noise: int, packets: int) -> str:
        tried = "at %s baud" % ", ".join(map(str, self._rates)) if self._rates else "over TCP"
        heard = " (%d bytes came that make no packet: is this the robot's port?)" % noise if noise else ""
        if packets:
            heard = " (%d packets came: from a robot that does not obey CLOSE, or one that another program drives)" % packets
        return (
            "%s: nothing answers as a robot, tried %s%s. Is it switched on, its controller running, the cable in its serial port, and no other "
            "program connected? Without a robot: launch with sim:=true" % (self._url, tried, heard)
        )
