"""Write the times of a run in seconds, minutes or hours. Its length chooses the unit."""

from typing import List, NamedTuple, Sequence

import numpy as np

# s: the steps between two times on an axis
STEPS = (0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 30, 60, 120, 300, 600, 900, 1800, 3600, 7200, 4 * 3600, 8 * 3600, 24 * 3600)


class Timeline(NamedTuple):
    """The times (s) of the first and the last message of a run."""

    begin: float
    end: float

    @property
    def span(self) -> float:
        """The length of the run (s), at least 0.1 s."""
        return max(self.end - self.begin, 0.1)

    @property
    def unit(self) -> str:
        """The unit of the written times."""
        return "s" if self.span < 200 else "min:s" if self.span < 7200 else "h:min:s"

    def write(self, time: float) -> str:
        """Return a time in words, counted from the begin: ``7.5 s``, ``68 s``, ``12:05``, ``1:12:05``.

        `time` is in s, as `begin`.
        """
        return self.number(time) + (" s" if self.unit == "s" else "")

    def number(self, time: float) -> str:
        """Return the same as `write`, without the unit."""
        seconds = time - self.begin
        if self.unit == "s":
            return "%g" % (round(seconds, 1) + 0.0) if self.span < 10 else str(round(seconds))
        minutes, second = divmod(int(round(seconds)), 60)
        if self.unit == "min:s":
            return "%s:%02d" % (minutes, second)
        return "%s:%02d:%02d" % (minutes // 60, minutes % 60, second)

    def ticks(self, most: int) -> np.ndarray:
        """Return times (s) at round steps from the begin of the run, with at most `most` steps."""
        step = next((step for step in STEPS if self.span <= most * step),
                    STEPS[-1] * np.ceil(self.span / STEPS[-1] / most))
        return self.begin + np.arange(0.0, self.span + step / 1000, step)


def how_long(seconds: float) -> str:
    """Return a length of time in words: ``7.5 s``, ``78 s``, ``12 min 5 s``, ``3 h 12 min``."""
    if seconds < 200:
        return "%g s" % round(seconds, 1) if seconds < 10 else "%.0f s" % seconds
    minutes, second = divmod(int(round(seconds)), 60)
    return "%s min %s s" % (minutes, second) if minutes < 120 else "%s h %s min" % (minutes // 60, minutes % 60)


def spread(places: Sequence[float], apart: float, low: float, high: float) -> List[float]:
    """Move places as little as needed, so that they lie apart.

    Args:
        places: the places in rising order.
        apart: the smallest distance between two of them. If there is too little room, it is smaller.
        low: the lower end of the room.
        high: the upper end of the room.
    """
    steps = min(apart, (high - low) / max(len(places) - 1, 1)) * np.arange(len(places))
    # first each place moves up until it is a step above the one before, then down until the rest has room above it
    spread_out = np.maximum.accumulate(np.maximum(places, low) - steps) + steps
    return np.minimum(spread_out, high - steps[::-1]).tolist()
