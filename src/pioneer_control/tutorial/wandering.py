"""One wander, from its first sonar message to its last. It is pure: its time is the time of the stamps.

So the same messages lead to the same decisions, from a bag as from the robot, however late each of them came.
"""

import math
from enum import Enum
from typing import Optional

from .pick import holds
from .sights import JUMP_BACK, Sight
from .snapshot import Heard
from .wander import Going, Memory, Move, wander

#: ns; time has moved on when a stamp is later by so much. While time stands, stamps still differ a little: each is as
#: old as its packet.
MOVES_ON = 50_000_000
SAME = 1e-4  #: s; stamps that differ by less are the same: a number in a text may have lost digits


WanderEnd = Enum("WanderEnd", {"TIME_UP": "the time is up", "AT_CAN": "something stands between the paddles"})
"""Why a wander ended."""


class Wandering:
    """Decides on each `Sight` in turn, until `end` says why it is over."""

    def __init__(
            self, seed: int, speed: float, duration: float, *, stop_at_can: bool = True, leaving: bool = False,
            begin_at: float = -math.inf, end_at: float = math.inf):
        """Begin a wander.

        The beams of the gripper have no stamps, so a re-run cannot know when one ended a wander. It is told instead.

        Args:
            seed: of what chance decides.
            speed: m/s.
            duration: s, from the first message on.
            stop_at_can: what stands between the paddles ends the wander.
            leaving: something was put down before, and is left first.
            begin_at: for a re-run, the stamp [s] of the first message that was decided on.
            end_at: for a re-run, the stamp [s] of the last one. Then no beam ends the wander.
        """
        self.seed, self.speed = seed, speed
        self._begin = Memory(seed, speed, going=Going.LEAVING if leaving else Going.LOOKING)
        self.memory = self._begin
        self.end: Optional[WanderEnd] = None
        self.newest = 0  #: stamp [ns], give or take MOVES_ON; as long as it does not change, time stands still
        self._duration, self._begin_at, self._end_at = duration, begin_at, end_at
        self._stop_at_can = stop_at_can and end_at == math.inf
        self._first: Optional[float] = None  #: s

    @property
    def waits(self) -> bool:
        """Has `begin_at` not come yet?"""
        return self._first is None and self._begin_at > -math.inf

    def decide(self, sight: Sight, heard: Heard) -> Optional[Move]:
        """What to do now; None before the begin and from the end on. When time jumps back, the wander begins again."""
        jumped = sight.stamp < self.newest - JUMP_BACK
        if jumped or sight.stamp >= self.newest + MOVES_ON:
            self.newest = sight.stamp
        if self._first is None and sight.time < self._begin_at - SAME:
            return None
        if self._first is None or jumped:
            self._first, self.memory = sight.time, self._begin
        self.end = self._ended(sight.time, self._first + self._duration, heard)
        if self.end is not None:
            return None
        heard = heard._replace(pose=sight.pose, ranges=sight.ranges, stalled=sight.stalled)
        move, self.memory = wander(heard.snapshot(sight.time, sight.pose_age), self.memory)
        return move

    def _ended(self, time: float, until: float, heard: Heard) -> Optional[WanderEnd]:
        if time >= until:
            return WanderEnd.TIME_UP
        left = self.memory.going not in (Going.LEAVING, Going.BACKING)
        between_paddles = self._stop_at_can and left and heard.grip and heard.grip.outer and not holds(heard.grip)
        return WanderEnd.AT_CAN if between_paddles or time > self._end_at + SAME else None
