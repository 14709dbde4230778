"""Accelerations that a program borrows: they count only while the program repeats its wish.

A program that navigates needs stronger brakes than the robot has at power-on. When the program ends, or is killed, the
robot must not keep what nobody else expects. So silence means: put back. No ROS; time is an argument.
"""

import threading
from dataclasses import replace
from typing import Any, Callable, Dict, FrozenSet, Optional

from ..client.tuning import Tuning
from ..errors import RefusedError, UsageError
from ..parameters import Rate

LIFETIME = 2.0
"""Time (s) after which borrowed accelerations are put back, unless the wish is repeated."""
NAMES = {
    "linear_acceleration": "max_linear_acceleration", "linear_deceleration": "max_linear_deceleration",
    "angular_acceleration": "max_angular_acceleration", "angular_deceleration": "max_angular_deceleration",
}
"""The fields of a wish, and the names that the settings of the robot have for them."""
LEGAL = {
    "linear_acceleration": Rate(0.01, 10.0), "linear_deceleration": Rate(0.3, 10.0),
    "angular_acceleration": Rate(0.1, 20.0), "angular_deceleration": Rate(1.7, 20.0),
}
"""What each field may be (m/s^2, rad/s^2). Nobody borrows weaker brakes than a robot has at power-on."""


class BorrowedAccelerations:
    """Puts the wish of one program over the user's own settings, and takes it away again.

    Threads may call the methods at the same time.

    Args:
        own: the user's settings.
        tune: a function that gives settings to the robot.
    """

    def __init__(self, own: Tuning, tune: Callable[[Tuning], None]) -> None:
        self._own, self._tune = own, tune
        self._lock = threading.Lock()
        self._wish: Optional[Tuning] = None
        self._wished: FrozenSet[str] = frozenset()
        self._borrower, self._until = "", 0.0

    def changes(self, name: str) -> bool:
        """Return whether the newest change of a setting was somebody's wish, or its end, and not the user's own."""
        return name in self._wished

    def change_own(self, own: Tuning) -> None:
        """Use new settings of the user. A wish stays over them."""
        with self._lock:
            wanted = own if self._wish is None else self._over(own)
            self._tune(wanted)
            self._own, self._wished = own, frozenset()

    def borrow(self, wish: object, borrower: str, now: float) -> bool:
        """Give the robot the accelerations of a wish, for the next `LIFETIME` seconds.

        Args:
            wish: an object with the attributes `NAMES` (m/s^2, rad/s^2); 0 leaves one as it is.
            borrower: the node that asks.
            now: monotonic time (s).

        Returns:
            Whether this node did not borrow before.

        Raises:
            UsageError: a value is not legal.
            RefusedError: another node has borrowed them.
        """
        for name, kind in LEGAL.items():
            try:
                kind.accept(getattr(wish, name))
            except ValueError:
                raise UsageError("accelerations refused: %s is %s; legal: %s"
                                 % (name, getattr(wish, name), kind.legal)) from None
        tuning = Tuning(**{ours: getattr(wish, name) or None for name, ours in NAMES.items()})
        with self._lock:
            if self._wish is not None and self._borrower != borrower and now < self._until:
                raise RefusedError("accelerations refused: %s has borrowed them" % self._borrower)
            is_new = self._wish is None or self._borrower != borrower
            if tuning != self._wish:
                before, self._wish = self._wish, tuning
                self._wished = frozenset(tuning.values)
                try:
                    self._tune(self._over(self._own))
                except Exception:
                    self._wish = before
                    raise
            self._borrower, self._until = borrower, now + LIFETIME
        return is_new

    def tick(self, now: float) -> str:
        """Put back what was borrowed when its time is over. Return the borrower then, else an empty text."""
        if self._wish is None or now < self._until:     # the usual case, without the lock
            return ""
        with self._lock:
            if self._wish is None or now < self._until:
                return ""
            self._wish = None
            self._tune(self._own)
            return self._borrower

    def _over(self, own: Tuning) -> Tuning:
        assert self._wish is not None
        wished: Dict[str, Any] = self._wish.values      # Any: fields have different types
        return replace(own, **wished)
