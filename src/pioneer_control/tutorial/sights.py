"""Sonar messages and poses find each other again: a robot sends both of one moment with one stamp, but on two connections.

What comes out depends on the messages and their order on each topic, never on which topic was faster: the same from a bag as from the robot.
"""

from collections import deque
from typing import Any, Deque, Iterator, NamedTuple, Optional, Tuple

from pioneer_control.tutorial.snapshot import Pose

JUMP_BACK = 1_000_000_000  #: ns; a stamp so much before the one before it begins another time: a bag was begun again
KEPT = 6000  #: messages of a topic that wait for the other, at most: ten minutes; then the oldest are dropped


class Sight(NamedTuple):
    """What the sonars saw, and from where."""

    stamp: int  #: of the sonar message [ns]
    pose_age: float  #: s, by how much the pose is older: 0 where that of the same stamp has come
    pose: Pose
    ranges: Tuple[float, ...]  #: [m], by number

    @property
    def time(self) -> float:
        """The stamp [s]."""
        return self.stamp * 1e-9


class _Stamped(NamedTuple):
    """A message that waits."""

    stamp: int  #: ns
    jumps: int  #: how often the stamps of its topic have jumped back before
    value: Any

    def is_after(self, other: "_Stamped") -> bool:
        """Was it measured after a message of the other topic? One topic may have jumped back already, and the other not yet."""
        if abs(self.stamp - other.stamp) < JUMP_BACK:
            return self.stamp > other.stamp
        return (self.jumps, self.stamp) > (other.jumps, other.stamp)


class _Topic:
    """The messages of one topic that wait, oldest first, and the newest that came."""

    def __init__(self) -> None:
        self.waiting: Deque[_Stamped] = deque(maxlen=KEPT)
        self.newest: Optional[_Stamped] = None

    def add(self, stamp: int, value: Any) -> None:
        last = self.newest or _Stamped(stamp, 0, None)
        self.newest = _Stamped(stamp, last.jumps + (stamp < last.stamp - JUMP_BACK), value)
        self.waiting.append(self.newest)


class Sights:
    """Makes a `Sight` of every sonar message, in their order, as soon as its pose has come, or a later one: then the last before it serves.

    Messages without stamps (of some old bags): a pose has the time of its arrival, a sonar message the stamp of the newest pose.
    Sonar messages from before the first pose are dropped.
    """

    def __init__(self) -> None:
        self._sonar, self._poses = _Topic(), _Topic()
        self._pose: Optional[_Stamped] = None  #: the last one that was taken

    def hear_pose(self, stamp: int, pose: Pose, now: int) -> Iterator[Sight]:
        """A message on ``pose``, its stamp [ns] or 0 for none, and the time of its arrival [ns]. Yields what is seen by it."""
        self._poses.add(stamp or now, pose)
        return self._seen()

    def hear_sonar(self, stamp: int, ranges: Tuple[float, ...]) -> Iterator[Sight]:
        """A message on ``sonar``, its stamp [ns] or 0 for none. Yields what is seen by it."""
        newest = self._poses.newest
        if stamp or newest:
            self._sonar.add(stamp or newest.stamp, ranges)
        return self._seen()

    def _seen(self) -> Iterator[Sight]:
        while self._sonar.waiting and self._take_poses_until(self._sonar.waiting[0]):
            sonar, pose = self._sonar.waiting.popleft(), self._pose
            if pose is not None and pose.stamp < sonar.stamp + JUMP_BACK:
                yield Sight(sonar.stamp, max(0, sonar.stamp - pose.stamp) * 1e-9, pose.value, sonar.value)

    def _take_poses_until(self, sonar: _Stamped) -> bool:
        """Up to the pose of a sonar message. False while that may still come."""
        poses = self._poses.waiting
        while poses:
            if poses[0].is_after(sonar):
                return True
            self._pose = poses.popleft()
            if self._pose.stamp == sonar.stamp:
                return True
        return False
