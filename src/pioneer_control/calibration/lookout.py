"""What the sonar sees in the way of a leg: the robot stands for it. Pure.

It remembers echoes as the wander does, since a sonar is blind between its cones and to what is very near.
"""

import math
from typing import Optional, Tuple

from ..tutorial.echoes import Echo, Motion, remember
from ..tutorial.snapshot import Snapshot
from .plan import AheadLeg, Leg

MARGIN = 0.04
"""Way (m) that is kept beside the robot."""
FREE = 0.55
"""Way (m) ahead that must be free: to stand from full speed, and a little."""
FREE_TURN = 0.6
"""Turn (rad) that must be free."""
TOO_OLD = 0.5
"""Age (s) above which what the robot told does not count."""
CLEAR_FOR = 1.0
"""Time (s) for which the way must be free before the robot goes on."""


class Lookout:
    """Says whether the way of a leg is free."""

    def __init__(self) -> None:
        self._echoes: Tuple[Echo, ...] = ()
        self._time: Optional[float] = None
        self._blocked_at = -math.inf

    def why_not(self, snapshot: Snapshot, leg: Optional[Leg]) -> str:
        """Take what the robot sees, and return why it must stand; nothing if its way is free.

        ``snapshot.time`` must not go back.
        """
        reason = self._look(snapshot, leg)
        if reason:
            self._blocked_at = snapshot.time
        elif snapshot.time - self._blocked_at < CLEAR_FOR:
            return "the way was not free just now"
        return reason

    def _look(self, snapshot: Snapshot, leg: Optional[Leg]) -> str:
        passed = 0.0 if self._time is None else snapshot.time - self._time
        self._time = snapshot.time
        around = not isinstance(leg, AheadLeg)
        self._echoes, points = remember(
            self._echoes, snapshot, Motion.TURNS if around else Motion.DRIVES, max(0.0, passed))
        if snapshot.stalled:
            return "a wheel is stalled: something holds the robot"
        if snapshot.age > TOO_OLD:
            return "the robot has told nothing for %.1f s" % snapshot.age
        outline = snapshot.robot.outline
        if leg is None:
            return ""
        if isinstance(leg, AheadLeg):
            free = outline.straight(points, MARGIN, FREE)
            return "" if free >= FREE else "the sonar sees something %.2f m ahead" % free
        side = 1 if leg.turn > 0 else -1
        free = outline.turn(points, side, MARGIN, FREE_TURN)
        return "" if free >= FREE_TURN else "the sonar sees something that a turn would touch"
