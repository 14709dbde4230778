"""How simulated time follows real time: at a speed, and not while it is paused. This file reads no clock."""

from typing import Optional

from ...errors import ParameterError

LONGEST_LAG = 0.25
"""Longest simulated time (s) for which the simulation catches up after a delay of this process.

If the delay is longer, the rest of it is left out of the simulated time.
"""
SPEEDS = (0.01, 100.0)
"""Legal real-time factors."""


class Pace:
    """The simulated time that is due at a real time.

    Args:
        speed: simulated seconds per real second.
        now_us: simulated time at the start (microseconds).

    Raises:
        ParameterError: the speed is not legal.
    """

    def __init__(self, speed: float, now_us: int):
        self.speed = speed
        self.late_answers: Optional[int] = None
        """How often a program in lockstep has answered too late. None without lockstep."""
        self._paused = False
        self._due_us = float(now_us)
        self._looked: Optional[float] = None

    @property
    def speed(self) -> float:
        """The simulated seconds per real second. It may be changed at any time.

        Raises:
            ParameterError: the new speed is not legal.
        """
        return self._speed

    @speed.setter
    def speed(self, speed: float) -> None:
        if not SPEEDS[0] <= speed <= SPEEDS[1]:
            raise ParameterError("speed %r is not legal: give a number from %g to %g" % (speed, *SPEEDS))
        self._speed = speed

    @property
    def paused(self) -> bool:
        """Whether simulated time stands still. It may be changed at any time."""
        return self._paused

    @paused.setter
    def paused(self, paused: bool) -> None:
        if self._paused and not paused:
            self._looked = None     # the time of the pause is left out
        self._paused = paused

    def client_sent(self, data: bytes, is_open: bool, now: float) -> None:
        """Take bytes from the client at the real time `now` (s). `is_open` is whether a session is open after them.

        Only a pace in lockstep uses them.
        """

    def client_got(self, data: bytes, now: float) -> None:
        """Take bytes that have reached the client at the real time `now` (s). Only a pace in lockstep uses them."""

    def session_ended(self) -> None:
        """Take note that the client has ended its session. Only a pace in lockstep uses it."""

    def due_us(self, now: float, news_us: int = 0) -> int:
        """Return the simulated time (microseconds) that is due at the real time `now` (s). Call this regularly.

        `news_us` is a simulated time (microseconds) before which no client can receive bytes. Only a pace in lockstep
        uses it.
        """
        if not self._paused and self._looked is not None:
            self._due_us += min((now - self._looked) * self.speed, LONGEST_LAG) * 1e6
        self._looked = now
        return int(self._due_us)

    def rest(self, until_us: int) -> Optional[float]:
        """Return the real time (s) from the last look until the simulated time `until_us` is due. None while paused."""
        return None if self._paused else max(0.0, (until_us - self._due_us) * 1e-6 / self.speed)
