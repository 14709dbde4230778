"""What moves the arm by itself: its server's timers (arm sheet 14, 18)."""

import math
from typing import List, Optional

from .joints import Joint
from .status import ArmStatus

WARNING_TIME = 30.0
"""How long (s) before a timer moves the arm the user is told."""
GRIPPER_NEAR_HOME = 10
"""A gripper no farther from its home than this (ticks) counts as open for the arm's timer, as we understand it."""


class ArmTimers:
    """When the arm moves by itself, for want of commands. Times are monotonic (s).

    Args:
        autopark: time (s) without a command after which it parks.
        grippark: time (s) after which a closed gripper opens.
        gripper: the gripper. None without one that can be used.
        now: the present time.

    Attributes:
        parks_at, opens_at: when it parks, and when its gripper opens. Infinity when that does not come.
    """

    def __init__(self, autopark: float, grippark: float, gripper: Optional[Joint], now: float) -> None:
        self._autopark, self._grippark = autopark, grippark
        self._gripper = gripper
        self._told_park = self._told_open = False
        self.parks_at = self.opens_at = math.inf
        self._commanded = now

    @property
    def due(self) -> float:
        """When there is something to tell."""
        return min(math.inf if told else at - WARNING_TIME for told, at in (
            (self._told_park, self.parks_at), (self._told_open, self.opens_at)))

    def commanded(self, now: float) -> None:
        """Take that the arm got a command: its time without one begins anew."""
        self._commanded, self._told_park = now, False
        if self.parks_at < math.inf:
            self.parks_at = now + self._autopark

    def saw(self, status: ArmStatus, now: float) -> None:
        """Take a status."""
        self.parks_at = self._commanded + self._autopark if status.powered else math.inf
        gripper = self._gripper
        closed = status.powered and gripper is not None and (
            abs(status.ticks[gripper.number - 1] - gripper.home) > GRIPPER_NEAR_HOME)
        if not closed:
            self.opens_at, self._told_open = math.inf, False
        elif self.opens_at == math.inf:
            self.opens_at = now + self._grippark

    def warnings(self, now: float) -> List[str]:
        """Return what is to be told now, each once."""
        told = []
        if not self._told_park and now >= self.parks_at - WARNING_TIME:
            self._told_park = True
            told.append("keep clear: the arm parks by itself in %.0f s, unless it gets a command"
                        % max(0.0, self.parks_at - now))
        if not self._told_open and now >= self.opens_at - WARNING_TIME:
            self._told_open = True
            told.append("the arm's gripper opens by itself in about %.0f s and drops what it holds, because it was"
                        " closed for long; open it before, or take what it holds" % max(0.0, self.opens_at - now))
        return told
