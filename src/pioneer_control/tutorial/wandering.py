"""One wander, from its first sonar message to its last. This file does not use ROS.

The time of a wander is the time in the stamps, not the arrival time of messages. So the same messages give the same
decisions, no matter whether they come from a bag or from the robot, and how late they come.
"""

import math
from enum import Enum
from typing import Optional

from .pick import holds
from .sights import JUMP_BACK, Sight
from .snapshot import Heard
from .wander import Going, Memory, Move, wander

#: ns; time runs when a stamp is later than an earlier stamp by at least this. While simulated time is paused, stamps
#: still differ a little, because each stamp is ROS time minus the age of the packet.
MOVES_ON = 50_000_000
SAME = 1e-4  #: s; stamps that differ by less count as equal, because a stamp written as text may have lost digits


WanderEnd = Enum("WanderEnd", {"TIME_UP": "the time is up", "AT_CAN": "something stands between the paddles"})
"""Why a wander ended. The value is a text for people."""


class Wandering:
    """One wander: makes a decision for each `Sight`, until it ends.

    Attributes:
        seed: the seed with which the wander began.
        speed: the speed of the wander [m/s].
        memory: the state between two decisions.
        end: why the wander ended. None while it goes on.
        newest: the newest stamp [ns], not exact: it changes only in steps of MOVES_ON or more. While it does not
            change, time stands still.
    """

    def __init__(
            self, seed: int, speed: float, duration: float, *, stop_at_can: bool = True, leaving: bool = False,
            begin_at: float = -math.inf, end_at: float = math.inf):
        """Begin a wander.

        `begin_at` and `end_at` are only for repeating a recorded wander. Reports of the gripper have no stamps, so a
        repeated wander cannot see when a gripper beam ended the recorded one. `end_at` gives this time instead.

        Args:
            seed: the seed for random choices.
            speed: the speed while driving [m/s].
            duration: the length of the wander [s], from the stamp of the first sonar message.
            stop_at_can: an object that breaks the outer gripper beam ends the wander.
            leaving: the robot has just put an object down, and first backs away from it.
            begin_at: the stamp [s] of the first sonar message that the recorded wander decided on.
            end_at: the stamp [s] of the last sonar message that it decided on. Then no gripper beam ends the wander.
        """
        self.seed, self.speed = seed, speed
        self._begin = Memory(seed, speed, going=Going.LEAVING if leaving else Going.LOOKING)
        self.memory = self._begin
        self.end: Optional[WanderEnd] = None
        self.newest = 0
        self._duration, self._begin_at, self._end_at = duration, begin_at, end_at
        self._stop_at_can = stop_at_can and end_at == math.inf
        self._first: Optional[float] = None  #: s, the stamp of the first sonar message

    @property
    def waits(self) -> bool:
        """Whether the wander still waits for the stamp `begin_at`."""
        return self._first is None and self._begin_at > -math.inf

    def decide(self, sight: Sight, heard: Heard) -> Optional[Move]:
        """Decide how to move. When time jumps back, the wander begins again.

        Args:
            sight: the sensor data to decide on.
            heard: the newest data from the robot. The gripper state and the shape of the robot come from here.

        Returns:
            The decision. None before `begin_at`, and when the wander has ended.

        Raises:
            NoAnswerError: the shape of the robot is not known yet.
        """
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
        """Return why the wander ends at `time` [s]. None if it goes on. `until` is when its duration is over [s]."""
        if time >= until:
            return WanderEnd.TIME_UP
        left = self.memory.going not in (Going.LEAVING, Going.BACKING)
        between_paddles = self._stop_at_can and left and heard.grip and heard.grip.outer and not holds(heard.grip)
        return WanderEnd.AT_CAN if between_paddles or time > self._end_at + SAME else None
