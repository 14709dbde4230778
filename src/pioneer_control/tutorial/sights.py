"""Joins what the robot reports of one moment. Sonar, pose and stall have the same stamp, but three connections.

What comes out depends on the messages and their order on each topic, never on which topic was faster.
So it is the same from a bag as from the robot.
"""

from collections import deque
from typing import Any, Deque, Iterator, NamedTuple, Optional, Tuple

from .snapshot import Pose

#: ns; when a stamp is so much earlier than the one before it, another time begins: somebody plays a bag again.
JUMP_BACK = 1_000_000_000
SPEAKS = 10_000_000_000  #: ns; a robot that told of stalls so shortly before is going to tell of them again
KEPT = 6000  #: messages of a topic that wait for the others, at most: ten minutes; then the oldest are dropped


class Sight(NamedTuple):
    """What the sonars saw, and from where."""

    stamp: int  #: of the sonar message [ns]
    pose_age: float  #: s, by how much the pose is older: 0 where the pose has the same stamp
    pose: Pose
    ranges: Tuple[float, ...]  #: [m], by number
    stalled: bool = False

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
        """Was it measured after a message of another topic? Perhaps only one of the two topics has jumped back yet."""
        same_time = abs(self.stamp - other.stamp) < JUMP_BACK
        return self.stamp > other.stamp if same_time else (self.jumps, self.stamp) > (other.jumps, other.stamp)


class _Topic:
    """The messages of one topic that wait, oldest first; the newest that came; the last that was taken."""

    def __init__(self) -> None:
        self.waiting: Deque[_Stamped] = deque(maxlen=KEPT)
        self.newest: Optional[_Stamped] = None
        self.taken: Optional[_Stamped] = None

    def add(self, stamp: int, value: Any) -> None:
        last = self.newest or _Stamped(stamp, 0, None)
        self.newest = _Stamped(stamp, last.jumps + (stamp < last.stamp - JUMP_BACK), value)
        self.waiting.append(self.newest)

    def take_until(self, other: _Stamped) -> bool:
        """Take the messages up to the stamp of another topic's message.

        Returns:
            False while a message of the same stamp may still come.
        """
        while self.waiting and not self.waiting[0].is_after(other):
            self.taken = self.waiting.popleft()
            if self.taken.stamp == other.stamp:
                return True
        return bool(self.waiting)


class Sights:
    """Makes a `Sight` of every sonar message, in their order, as soon as its pose or a later pose has come.

    Where no pose has the same stamp, the last pose before it serves. Sonar messages that come before the first pose are
    dropped. A robot that has told of stalls does so with each packet, so a sonar message waits for its stall too.
    Some old bags have messages without stamps. Then a pose counts as of the time when it came, and a sonar message as
    of the stamp of the newest pose.
    """

    def __init__(self) -> None:
        self._sonar, self._poses, self._stalls = _Topic(), _Topic(), _Topic()
        self._posed: Deque[Tuple[_Stamped, Sight]] = deque()  #: these have their pose, and wait for their stall

    def hear_pose(self, stamp: int, pose: Pose, now: int) -> Iterator[Sight]:
        """Take a message on ``pose``: its stamp [ns] or 0 for none, and the time of its arrival [ns].

        Yields:
            What this message completes.
        """
        self._poses.add(stamp or now, pose)
        return self._seen()

    def hear_sonar(self, stamp: int, ranges: Tuple[float, ...]) -> Iterator[Sight]:
        """Take a message on ``sonar``: its stamp [ns] or 0 for none, and its ranges [m]. Yields what it completes."""
        newest = self._poses.newest
        stamp = stamp or (newest.stamp if newest else 0)
        if stamp:
            self._sonar.add(stamp, ranges)
        return self._seen()

    def hear_stall(self, stamp: int, stalled: bool) -> Iterator[Sight]:
        """Take a message on ``stall``: its stamp [ns], and whether a wheel is stalled. Yields what it completes."""
        if stamp:
            self._stalls.add(stamp, stalled)
        return self._seen()

    def _seen(self) -> Iterator[Sight]:
        while self._sonar.waiting and self._poses.take_until(self._sonar.waiting[0]):
            sonar, pose = self._sonar.waiting.popleft(), self._poses.taken
            if pose is not None and pose.stamp < sonar.stamp + JUMP_BACK:
                self._posed.append((sonar, Sight(
                    sonar.stamp, max(0, sonar.stamp - pose.stamp) * 1e-9, pose.value, sonar.value)))
        while self._posed and (self._stalls.take_until(self._posed[0][0]) or not self._tells_of_stalls()):
            sonar, sight = self._posed.popleft()
            stall = self._stalls.taken
            stalled = stall is not None and abs(stall.stamp - sonar.stamp) < JUMP_BACK and stall.value
            yield sight._replace(stalled=stalled)

    def _tells_of_stalls(self) -> bool:
        stall, sonar = self._stalls.newest, self._sonar.newest
        return stall is not None and sonar is not None and sonar.stamp < stall.stamp + SPEAKS
