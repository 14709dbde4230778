"""One wander from its first sonar message to its last: pure, its time is that of the stamps.

So the same messages lead to the same decisions, from a bag as from the robot, however late each of them came.
"""

import math
from enum import Enum
from typing import Optional

from pioneer_control.tutorial.pick import holds
from pioneer_control.tutorial.sights import JUMP_BACK, Sight
from pioneer_control.tutorial.snapshot import Command, Heard
from pioneer_control.tutorial.wander import Memory, wander

MOVES_ON = 50_000_000  #: ns at least, when time does: while it stands, stamps still differ by how old each packet was
SAME = 1e-4  #: s; stamps that differ by less are one: a number in a text may have lost digits


class WanderEnd(Enum):
    """Why a wander ended."""

    TIME_UP = "the time is up"
    AT_CAN = "something stands between the paddles"


class Wandering:
    """Decides on each `Sight` in turn, until `end` says why it is over.

    The beams of the gripper have no stamps. So for a re-run `begin_at` and `end_at` [s] tell the stamps of the first and the last message that were
    decided on; then no beam ends the wander.
    """

    def __init__(
            self, seed: int, speed: float, duration: float, *, stop_at_can: bool = True, begin_at: float = -math.inf, end_at: float = math.inf):
        """`speed` in m/s, `duration` in s from the first message on."""
        self.seed, self.speed = seed, speed
        self.memory = Memory(seed=seed, speed=speed)
        self.end: Optional[WanderEnd] = None
        self.newest = 0  #: stamp [ns], give or take MOVES_ON; as long as it stays, time stands still
        self._duration, self._begin_at, self._end_at = duration, begin_at, end_at
        self._stop_at_can = stop_at_can and end_at == math.inf
        self._first: Optional[float] = None  #: s

    @property
    def waits(self) -> bool:
        """Has `begin_at` not come yet?"""
        return self._first is None and self._begin_at > -math.inf

    def decide(self, sight: Sight, heard: Heard) -> Optional[Command]:
        """The command for now; None before the begin and from the end on. A jump back in time begins afresh."""
        jumped = sight.stamp < self.newest - JUMP_BACK
        if jumped or sight.stamp >= self.newest + MOVES_ON:
            self.newest = sight.stamp
        if self._first is None and sight.time < self._begin_at - SAME:
            return None
        if self._first is None or jumped:
            self._first, self.memory = sight.time, Memory(seed=self.seed, speed=self.speed)
        self.end = self._ended(sight.time, heard)
        if self.end is not None:
            return None
        here = heard._replace(pose=sight.pose, ranges=sight.ranges)
        command, self.memory = wander(here.snapshot(sight.time, sight.pose_age), self.memory)
        return command

    def _ended(self, time: float, heard: Heard) -> Optional[WanderEnd]:
        if time >= self._first + self._duration:
            return WanderEnd.TIME_UP
        between_paddles = self._stop_at_can and heard.grip and heard.grip.outer and not holds(heard.grip)
        return WanderEnd.AT_CAN if between_paddles or time > self._end_at + SAME else None
