"""Checks whether packets reach the robot: sends questions now and then, and counts the answers.

The robot acknowledges no command. So a question is sent together with some velocities. The question is ENCODER 1. It is
short, has no effect, and is answered once. (Early P2OS answers it for ever: then the client stops the answers by
ENCODER 0.) The question and a velocity are sent in one write. A question alone could revive the set point of a robot
whose stop was lost. So a robot that is to stand gets no questions.

Source: protocol sheet 2.4, 3.2.
"""

import math
from collections import deque
from typing import Callable, Deque, Sequence

from ..p2os import Encoder, encode_command, encode_packet

# s between two questions at least: 5 a second with velocities at 10 Hz, or repeated every 0.2 s.
EVERY = 0.15
CYCLES = 1.5                # SIP cycles between two questions at least: two questions in a cycle may get one answer
SHARE = 0.03                # of the line's capacity that answers may take
ANSWERED_WITHIN = 1.5       # s; one cycle of SIPs is usual
TRIES = 10                  # questions to a robot that has not answered any, until questions become seldom
SELDOM = 5.0                # s between two questions from then on: perhaps only the line was bad
TOO_MANY = 10               # more answers than questions: a robot that answers for ever, as early P2OS does
QUESTION = encode_command("ENCODER", 1)
SILENCE = encode_command("ENCODER", 0)
ANSWER = encode_packet(Encoder(0, 0))


class LinkCheck:
    """Makes questions for one connected robot, and counts its answers. ``now`` is monotonic time in s.

    Args:
        cycle: time (s) between two SIPs.
        transfer_time: returns the time (s) that the line takes to carry so many bytes.
    """

    def __init__(self, cycle: float, transfer_time: Callable[[int], float]) -> None:
        self.asks = True
        """Whether questions are asked at all."""
        self._every = max(EVERY, CYCLES * cycle, transfer_time(len(ANSWER)) / SHARE)
        self._open: Deque[float] = deque()      # when the questions were asked that have no answer yet
        self._last_asked = -math.inf
        self._answered = self._unanswered = 0
        self._surplus = 0                       # answers minus questions
        self._goes_on = False                   # whether this robot answers for ever

    @property
    def questions(self) -> int:
        """Number of questions that are answered or overdue. 0 until the first answer: some robots never answer."""
        return self._answered + self.unanswered

    @property
    def unanswered(self) -> int:
        """Number of questions that are overdue: the question or its answer was lost. 0 until the first answer."""
        return self._unanswered if self._answered else 0

    @property
    def due(self) -> float:
        """Time (monotonic, s) by which tick() must be called; infinity when nothing is due."""
        return self._open[0] + ANSWERED_WITHIN if self._open else math.inf

    def question(self, now: float) -> Sequence[bytes]:
        """Return the packets to send with a velocity at ``now``: a question, a command to stop answers, or nothing."""
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
        """Count an answer. Returns whether a question was open.

        The answer counts for the newest open question. So a question whose answer was lost becomes overdue.
        """
        if self.asks:
            self._surplus += 1
        expected = self.asks and bool(self._open)
        if expected:
            self._open.pop()
            self._answered += 1
        return expected

    def tick(self, now: float) -> None:
        """Count questions that are overdue at ``now``."""
        while now >= self.due:
            self._open.popleft()
            self._unanswered += 1
