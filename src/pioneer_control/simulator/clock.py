"""Simulated time: one clock for robots, lines and faults, which read it. Only the simulation sets it."""

NEVER_US = 1 << 62
"""A time that is later than any simulated time (microseconds)."""


class Clock:
    """The clock of one simulation.

    Attributes:
        now_us: simulated microseconds since the start.
    """

    def __init__(self) -> None:
        self.now_us = 0
        self._fraction_us = 0.0

    @property
    def seconds(self) -> float:
        """The simulated time (s) since the start."""
        return self.now_us * 1e-6

    def after(self, seconds: float) -> int:
        """Return the time (microseconds) that is `seconds` after now. The clock itself does not change.

        A fraction of a microsecond is kept, and added in the next call.
        """
        exact_us = seconds * 1e6 + self._fraction_us
        whole_us = round(exact_us)
        self._fraction_us = exact_us - whole_us
        return self.now_us + whole_us
