"""What a robot may have driven while nobody heard of it.

A robot whose line is silent drives on as it was told, until its watchdog stops it. When it is connected anew, odometry
goes on from the last pose that was heard: it never tells this way.
"""

import math
from typing import Optional

from ..floor_poses import Pose
from .values import STOP, Twist

LONGEST_SILENCE = 0.5
"""After a longer time (s) without a packet, the robot may have driven on unseen."""
WATCHDOG = 2.5
"""A robot that is told nothing stands after this time (s): its watchdog (2 s, p2os-protocol.md), and its brakes."""
SHORTEST_UNSEEN = 0.1
"""A shorter unseen way (m) or turn (rad) is none."""


class UnseenMotion:
    """Of one robot.

    Attributes:
        told: the velocity that the robot was told last, by whoever navigates.
    """

    def __init__(self) -> None:
        self.told = STOP
        self._velocity, self._time = STOP, -math.inf

    def after(self, time: float, step: Pose) -> Optional[Pose]:
        """Return the motion (m, rad) that the robot may have made unseen before a packet, at most. None: it made none.

        Args:
            time: of the packet (s).
            step: what odometry tells of the motion since the packet before.
        """
        silence, self._time = time - self._time, time
        if 0.0 < silence <= LONGEST_SILENCE:
            self._velocity = Twist(step.x / silence, step.heading / silence)
        if not LONGEST_SILENCE < silence < math.inf:
            return None
        drove = min(silence, WATCHDOG)
        ahead = max(self._velocity.linear, self.told.linear, key=abs) * drove - step.x
        turn = max(self._velocity.angular, self.told.angular, key=abs) * drove - step.heading
        return Pose(ahead, 0.0, turn) if max(abs(ahead), abs(turn)) > SHORTEST_UNSEEN else None
