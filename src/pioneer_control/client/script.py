"""Scripts: what is done on a line step by step, as generators. No clock in here either: they are given one.

A script yields the time (monotonic, s) until which it waits, and is sent a packet that came, or None when that time has come.
"""

from typing import Any, Callable, Generator

Clock = Callable[[], float]
Script = Generator[float, Any, Any]


def pause(seconds: float, clock: Clock) -> Script:
    """Let time pass, whatever comes meanwhile."""
    deadline = clock() + seconds
    while clock() < deadline:
        yield deadline
