"""Procedures: what is done on a line step by step, as generators. No clock in here either: they are given one.

A procedure yields the time (monotonic, s) until which it waits, and is sent a packet that came, or None when that time
has come.
"""

from typing import Any, Callable, Generator

Clock = Callable[[], float]
Procedure = Generator[float, Any, Any]


def pause(seconds: float, clock: Clock) -> Procedure:
    """Let time pass, whatever comes meanwhile."""
    deadline = clock() + seconds
    while clock() < deadline:
        yield deadline
