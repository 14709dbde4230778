"""Lockstep: simulated time waits for the program. This file reads no clock.

Simulated time stands after each SIP that reaches the client, until the client sends the **mark**: a PULSE. Then time
goes on, as fast as the computer can, until the next SIP reaches the client. So real time has no effect on the program.

::

             OPEN              mark          mark          mark              CLOSE
    stands ... | ... stands ... | SIP stands  | SIP stands  | SIP ... stands  | stands
                                  0.1 s         0.2 s         0.3 s

No time passes before the first OPEN, so each run begins in the same state. No time passes after CLOSE, so each run
ends in a state that can be looked at. When the client does not answer in time, time passes at its usual pace until it
does: for programs that hang, and for clients that know no lockstep.
"""

import math
from typing import Optional

from ...errors import ParameterError
from ...p2os import FrameDecoder, Sip, decode_command, decode_packet
from .pace import Pace

LIMITS = (0.05, 3600.0)
"""Legal real times (s) to wait for an answer."""


class Lockstep(Pace):
    """The pace of a simulation whose only robot waits for its client.

    Args:
        limit: longest real time (s) to wait for an answer.
        speed: simulated seconds per real second, while a client does not answer in time.
        now_us: simulated time at the start (microseconds).

    Raises:
        ParameterError: the limit or the speed is not legal.
    """

    late_answers: int

    def __init__(self, limit: float, speed: float, now_us: int):
        if not LIMITS[0] <= limit <= LIMITS[1]:
            raise ParameterError("lockstep %r is not legal: give a number of seconds from %g to %g" % (limit, *LIMITS))
        super().__init__(speed, now_us)
        self.late_answers = 0
        self.limit = limit
        self._is_open = False       # whether the client has a session
        self._answered = False      # whether the client has answered the newest SIP, so that time goes on
        self._wait_until = math.inf     # real time (s) until which time stands, or goes on to the next SIP
        self._from_client, self._to_client = FrameDecoder(), FrameDecoder()

    def client_sent(self, data: bytes, is_open: bool, now: float) -> None:
        frames = self._from_client.feed(data)
        if is_open and any(decode_command(frame).name == "PULSE" for frame in frames):
            self._wait(True, now)
        elif not (self._is_open and is_open):       # the handshake goes on
            self._wait(False, now)
        self._is_open = is_open

    def client_got(self, data: bytes, now: float) -> None:
        sips = [frame for frame in self._to_client.feed(data) if isinstance(decode_packet(frame), Sip)]
        if sips and self._answered:
            self._wait(False, now)

    def session_ended(self) -> None:
        self._is_open = self._answered = False
        self._wait_until = math.inf

    def due_us(self, now: float, news_us: int = 0) -> int:
        if self._wait_until > -math.inf:
            # What came until the last look is read by now: a computer that was busy makes no answer late.
            if self._looked is not None and self._looked >= self._wait_until:
                self.late_answers += self._is_open and not self._answered
                self._wait_until = -math.inf
            elif self._answered and not self.paused:
                self._due_us = max(self._due_us, float(news_us))
            self._looked = now      # the time of the wait is left out
        return super().due_us(now)

    def rest(self, until_us: int) -> Optional[float]:
        if self.paused or self._wait_until == -math.inf:
            return super().rest(until_us)
        if self._answered or self._looked is None:
            return 0.0
        return None if self._wait_until == math.inf else max(0.0, self._wait_until - self._looked)

    def _wait(self, answered: bool, now: float) -> None:
        self._answered, self._wait_until = answered, now + self.limit
