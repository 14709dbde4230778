"""A time that never goes back, made of stamps that may: a clock that somebody sets, simulated time that begins anew."""

from typing import Optional

LATE = 0.25
"""How much older (s) than the newest a stamp may be: messages of two topics come in any order."""
AHEAD = 2.0
"""How much more time (s) may pass by the stamps than by the clock that nobody sets."""


class SteadyTime:
    """Makes steady times of the stamps of one robot.

    Attributes:
        jump: how far (s) the last stamp jumped; 0 if it did not.
        offset: what to add to a stamp of now for its steady time (s).
    """

    def __init__(self) -> None:
        self.jump = self.offset = 0.0
        self._newest: Optional[float] = None
        self._came = 0.0

    def of(self, stamp: float, now: float) -> float:
        """Return the steady time (s) of a stamp (s) that has come now: the time (s) of a clock that nobody sets.

        After a jump, time goes on as that clock says.
        """
        self.jump = 0.0
        if self._newest is not None:
            step, passed = stamp - self._newest, now - self._came
            if not -LATE <= step <= passed + AHEAD:
                self.jump = step - passed
                self.offset -= self.jump
            elif step <= 0.0:
                return stamp + self.offset
        self._newest, self._came = stamp, now
        return stamp + self.offset
