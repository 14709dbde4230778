"""How much later than usual the robot reacts, because a computer, or the way to the robot, has too much to do."""

import math
from collections import deque
from typing import Deque, Tuple

USUAL = 0.15
"""Longest time (s) from a packet until the next one is answered that is not late: packets come every 0.1 s."""
EXPECTED = 3.0
"""Time (s) for which, after a late answer, others are expected to be as late."""
COMPARED = 10.0
"""Time (s) of messages that are compared: the quickest of them says how far the clocks are apart."""


class Lately:
    """The greatest number of the last seconds.

    Args:
        kept: for so long (s) a number counts.
    """

    def __init__(self, kept: float) -> None:
        self._kept = kept
        self._numbers: Deque[Tuple[float, float]] = deque()     # each later one is smaller

    def most(self, number: float, now: float) -> float:
        """Take the number of now (s), and return the greatest."""
        while self._numbers and (self._numbers[-1][1] <= number or self._numbers[-1][0] > now):
            self._numbers.pop()
        self._numbers.append((now, number))
        while self._numbers[0][0] < now - self._kept:
            self._numbers.popleft()
        return self._numbers[0][1]


class Delay:
    """How long messages of one sender need, by stamps of a clock that may be wrong by any time that stays the same.

    Attributes:
        least: how long (s) the quickest of the last seconds needed, if both clocks are right.
    """

    def __init__(self) -> None:
        self._quickest, self.least = Lately(COMPARED), 0.0

    def of(self, stamp: float, now: float) -> float:
        """Return how much longer (s) a message needed than the quickest of the last seconds.

        Args:
            stamp: of the message (s).
            now: the time (s) at which it is heard.
        """
        self.least = -self._quickest.most(stamp - now, now)
        return now - stamp - self.least


class Lateness:
    """Of the answers to one robot: its packets come late, or some do not come at all.

    Attributes:
        late: how much later than usual (s) it reacts: the worst of the last answers.
    """

    def __init__(self) -> None:
        self._before, self.late = math.inf, 0.0
        self._worst = Lately(EXPECTED)

    def note(self, time: float, now: float) -> None:
        """Note when a packet is answered.

        Until a packet is answered the robot goes on as it was told at the packet before. The answer is taken to need
        as long to the robot as the packet needed here.

        Args:
            time: of the packet (s).
            now: the time (s) at which it is answered.
        """
        late, self._before = max(0.0, now + (now - time) - self._before - USUAL), time
        self.late = self._worst.most(late, now)
