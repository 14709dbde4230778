"""Joins the sonar, pose and stall messages of one moment. They have the same stamp, but come on three connections.

The result depends on the messages and their order on each topic, but not on which topic was faster. So a replayed bag
gives the same result as the robot.
"""

from collections import deque
from typing import Any, Deque, Iterator, NamedTuple, Optional, Tuple

from ..floor_poses import Pose

#: ns; when a stamp is earlier than the stamp before it by more than this, time has jumped back: a bag starts again.
JUMP_BACK = 1_000_000_000
#: ns; for this time after a stall message we expect a stall message for each sonar message
STALL_EXPECTED = 10_000_000_000
KEPT = 6000  #: how many messages of one topic may wait (ten minutes); then the oldest are dropped


class Sight(NamedTuple):
    """The sensor data of one moment: sonar ranges, the pose of the robot, and whether a wheel is stalled."""

    stamp: int  #: ns, the stamp of the sonar message
    pose_age: float  #: s, how much older the pose is than the ranges; 0 when both have the same stamp
    pose: Pose
    ranges: Tuple[float, ...]  #: m, by transducer number
    stalled: bool = False

    @property
    def time(self) -> float:
        """The stamp of the sonar message [s]."""
        return self.stamp * 1e-9


class _Stamped(NamedTuple):
    """A received message that waits for messages of the other topics with the same stamp."""

    stamp: int  #: ns
    jumps: int  #: how often the stamps of its topic have jumped back, up to this message
    value: Any

    def is_after(self, other: "_Stamped") -> bool:
        """Return whether this message was measured after `other`, a message of another topic.

        When a bag starts again, the stamps of one topic jump back earlier than the stamps of the other topic. So when
        two stamps differ by JUMP_BACK or more, the message with more jumps is the later one. With equal jumps it is the
        message with the greater stamp.
        """
        same_time = abs(self.stamp - other.stamp) < JUMP_BACK
        return self.stamp > other.stamp if same_time else (self.jumps, self.stamp) > (other.jumps, other.stamp)


class _Topic:
    """The messages of one topic.

    Attributes:
        waiting: messages that are not used yet, oldest first.
        newest: the last message that was received. None before the first.
        taken: the last message that `take_until` removed from `waiting`. None before the first.
    """

    def __init__(self) -> None:
        self.waiting: Deque[_Stamped] = deque(maxlen=KEPT)
        self.newest: Optional[_Stamped] = None
        self.taken: Optional[_Stamped] = None

    def add(self, stamp: int, value: Any) -> None:
        """Add a received message with its stamp [ns]."""
        last = self.newest or _Stamped(stamp, 0, None)
        self.newest = _Stamped(stamp, last.jumps + (stamp < last.stamp - JUMP_BACK), value)
        self.waiting.append(self.newest)

    def take_until(self, other: _Stamped) -> bool:
        """Remove waiting messages up to the stamp of `other`, a message of another topic. `taken` is the last of them.

        Returns:
            False when a message with the same stamp as `other` may still come. Then call again after the next message.
        """
        while self.waiting and not self.waiting[0].is_after(other):
            self.taken = self.waiting.popleft()
            if self.taken.stamp == other.stamp:
                return True
        return bool(self.waiting)


class Sights:
    """Makes one `Sight` from each sonar message, in order.

    A sonar message waits until a pose with the same stamp or a later stamp has come. When no pose has the same stamp,
    the last earlier pose is used. Sonar messages before the first pose are dropped.

    If the robot publishes stall messages, it publishes one with each packet. Then a sonar message also waits for the
    stall message.

    Some old bags have messages without stamps. Then the stamp of a pose is its arrival time, and the stamp of a sonar
    message is the stamp of the newest pose.
    """

    def __init__(self) -> None:
        self._sonar, self._poses, self._stalls = _Topic(), _Topic(), _Topic()
        self._posed: Deque[Tuple[_Stamped, Sight]] = deque()  #: sights with a pose that wait for their stall message

    def add_pose(self, stamp: int, pose: Pose, now: int) -> Iterator[Sight]:
        """Add a message of the topic ``pose``.

        Args:
            stamp: the stamp of the message [ns], or 0 when it has none.
            pose: the pose in the message.
            now: the arrival time [ns].

        Yields:
            The `Sight` objects whose messages have all arrived.
        """
        self._poses.add(stamp or now, pose)
        return self._complete()

    def add_sonar(self, stamp: int, ranges: Tuple[float, ...]) -> Iterator[Sight]:
        """Add a message of the topic ``sonar`` and yield the `Sight` objects whose messages have all arrived.

        Args:
            stamp: the stamp of the message [ns], or 0 when it has none.
            ranges: the sonar ranges by transducer number [m].
        """
        newest = self._poses.newest
        stamp = stamp or (newest.stamp if newest else 0)
        if stamp:
            self._sonar.add(stamp, ranges)
        return self._complete()

    def add_stall(self, stamp: int, stalled: bool) -> Iterator[Sight]:
        """Add a message of the topic ``stall`` and yield the `Sight` objects whose messages have all arrived.

        Args:
            stamp: the stamp of the message [ns]. With stamp 0 the message is ignored.
            stalled: whether a wheel is stalled.
        """
        if stamp:
            self._stalls.add(stamp, stalled)
        return self._complete()

    def _complete(self) -> Iterator[Sight]:
        """Yield the `Sight` objects whose messages have all arrived, in the order of the sonar messages."""
        while self._sonar.waiting and self._poses.take_until(self._sonar.waiting[0]):
            sonar, pose = self._sonar.waiting.popleft(), self._poses.taken
            if pose is not None and pose.stamp < sonar.stamp + JUMP_BACK:
                self._posed.append((sonar, Sight(
                    sonar.stamp, max(0, sonar.stamp - pose.stamp) * 1e-9, pose.value, sonar.value)))
        while self._posed and (self._stalls.take_until(self._posed[0][0]) or not self._expects_stalls()):
            sonar, sight = self._posed.popleft()
            stall = self._stalls.taken
            stalled = stall is not None and abs(stall.stamp - sonar.stamp) < JUMP_BACK and stall.value
            yield sight._replace(stalled=stalled)

    def _expects_stalls(self) -> bool:
        """Return whether a stall message is expected for the newest sonar message; see STALL_EXPECTED."""
        stall, sonar = self._stalls.newest, self._sonar.newest
        return stall is not None and sonar is not None and sonar.stamp < stall.stamp + STALL_EXPECTED
