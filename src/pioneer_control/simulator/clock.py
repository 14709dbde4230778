"""Simulated time: one clock for robots, lines and faults. They read it; the simulation sets it."""

NEVER_US = 1 << 62
"""Later than any simulated time (us)."""


class Clock:
    """The time of one simulation.

    Attributes:
        now_us: simulated microseconds since the start.
    """

    def __init__(self) -> None:
        self.now_us = 0
        self._fraction_us = 0.0

    @property
    def seconds(self) -> float:
        """Simulated seconds since the start."""
        return self.now_us * 1e-6

    def after(self, seconds: float) -> int:
        """The time (us) in `seconds` from now. A fraction of a microsecond is kept, and added in the next call."""
        exact_us = seconds * 1e6 + self._fraction_us
        whole_us = round(exact_us)
        self._fraction_us = exact_us - whole_us
        return self.now_us + whole_us
