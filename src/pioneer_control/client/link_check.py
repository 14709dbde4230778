"""Does the robot hear us? It acknowledges no command. So a question is sent with a velocity now and then, and the
answers are counted.

The question is ENCODER 1. It is short, has no effect, and is answered once. (Early P2OS answers it for ever: then it is
told to stop.) It is only sent with a velocity, in one write. Alone it could revive the set point of a robot whose stop
was lost. So a standing robot is asked nothing.

Source: protocol sheet 2.4, 3.2.
"""

import math
from collections import deque
from typing import Callable, Deque, Sequence

from ..p2os import Encoder, encode_command, encode_packet

# s between two questions at least: 5 a second with velocities at 10 Hz, or repeated every 0.2 s.
EVERY = 0.15
CYCLES = 1.5                # of SIPs between two questions at least: two in one may get one answer
SHARE = 0.03                # of the line's capacity that answers may take
ANSWERED_WITHIN = 1.5       # s; one cycle of SIPs is usual
TRIES = 10                  # questions to a robot that has not answered any, until they become seldom
SELDOM = 5.0                # s between two questions from then on: perhaps only the line was bad
TOO_MANY = 10               # answers more than questions: this robot answers for ever, as early P2OS does
QUESTION = encode_command("ENCODER", 1)
SILENCE = encode_command("ENCODER", 0)
ANSWER = encode_packet(Encoder(0, 0))


class LinkCheck:
    """Questions to one connected robot. ``now`` is monotonic time in s.

    Args:
        cycle: time (s) between two SIPs.
        transfer_time: how long (s) so many bytes are under way.
    """

    def __init__(self, cycle: float, transfer_time: Callable[[int], float]) -> None:
        self.asks = True
        """Whether questions are asked at all."""
        self._every = max(EVERY, CYCLES * cycle, transfer_time(len(ANSWER)) / SHARE)
        self._open: Deque[float] = deque()      # when the questions were asked that have no answer yet
        self._last_asked = -math.inf
        self._answered = self._unanswered = 0
        self._surplus = 0                       # of answers
        self._goes_on = False                   # it answers for ever

    @property
    def questions(self) -> int:
        """How many were answered or are overdue. 0 until the robot has answered one: perhaps it never does."""
        return self._answered + self.unanswered

    @property
    def unanswered(self) -> int:
        """How many were not answered in time. Either the question was lost, or the answer."""
        return self._unanswered if self._answered else 0

    @property
    def due(self) -> float:
        """When tick() has something to do."""
        return self._open[0] + ANSWERED_WITHIN if self._open else math.inf

    def question(self, now: float) -> Sequence[bytes]:
        """The packets that are sent with a velocity that is written now."""
        asks_often = self._answered or len(self._open) + self._unanswered < TRIES
        if not self.asks or now < self._last_asked + (self._every if asks_often else SELDOM):
            return ()
        self._last_asked = now
        if self._surplus >= TOO_MANY:
            self._goes_on, self._surplus = True, 0
            return (SILENCE,)
        if self._goes_on:
            return ()
        self._surplus -= 1
        self._open.append(now)
        return (QUESTION,)

    def saw_answer(self) -> bool:
        """Take an answer. It counts for the newest open question: so a lost answer stays lost.

        Returns:
            Whether a question was open.
        """
        if self.asks:
            self._surplus += 1
        expected = self.asks and bool(self._open)
        if expected:
            self._open.pop()
            self._answered += 1
        return expected

    def tick(self, now: float) -> None:
        """Count questions that are overdue."""
        while now >= self.due:
            self._open.popleft()
            self._unanswered += 1
