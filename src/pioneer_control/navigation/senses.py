"""Joins poses, sonar messages and scans of a robot, live or from a bag, into what it sensed in each packet.

A laser measures more often than anybody needs: each packet takes the newest scan of before it.

The topic ``sonar`` repeats all ranges in each message, and does not say which of them are new. `FiringWatch` finds out.
"""

import bisect
from collections import deque
from typing import Deque, Dict, Iterable, List, Optional, Sequence, Tuple

from ..floor_poses import Pose, between, relative
from ..robots import ARRAY_SIZE
from .firings import CYCLE, timed
from .steady_odometry import SteadyOdometry
from .values import LaserSweep, Scan, Sensing

MOST_WAITING = 50
"""Most sonar messages that wait for a pose, and most poses that are kept: of about 5 s."""
JUMP = 5.0
"""Time (s) between two messages that is a gap: what was heard before says nothing about what is new."""
SHORTEST = 0.01
"""Shortest time (s) between two sonar messages: no robot sends so often. If their stamps are nearer, time stands."""
MOST_SCANS = 8
"""Most scans that wait for a packet: those of 0.2 s, if they are `BETWEEN_SCANS` apart."""
BETWEEN_SCANS = 0.025
"""Shortest time (s) between two scans that are kept."""
OLD_SCAN = 1.5
"""A scan that is older than its packet by more (s) is left out. At 9600 baud a scan takes 0.8 s."""
OUT_OF_ORDER = 0.25
"""How much (s) the stamps of one topic may go back without a jump of time."""


class FiringWatch:
    """Finds out which transducers fired since the last message, and in which order.

    A range that has changed is new. Between the last firing that is known and the farthest new one in the sequence of
    the array, all have fired, also those whose range stayed the same.

    Args:
        numbers: the fitted transducers.
    """

    def __init__(self, numbers: Iterable[int]) -> None:
        self._arrays: Dict[int, List[int]] = {}
        for number in sorted(numbers):
            self._arrays.setdefault(number // ARRAY_SIZE, []).append(number)
        self._last: Dict[int, int] = {}     # by array: the place in its sequence of the last firing
        self._before: Sequence[float] = ()
        self._time: Optional[float] = None

    def new(self, time: float, ranges: Sequence[float]) -> List[Tuple[int, float]]:
        """Return number and range (m) of each firing since the last message, oldest first within its array.

        Args:
            time: of the message (s).
            ranges: ranges (m) by number; 0 for a transducer that has not been heard yet.
        """
        since = time - self._time if self._time is not None else 0.0
        if not 0.0 < since < JUMP:
            self._last.clear()
            self._before = ()
        fired: List[Tuple[int, float]] = []
        for array, sequence in self._arrays.items():
            heard = [number for number in sequence if number < len(ranges) and ranges[number] > 0.0]
            changed = [number for number in heard if number >= len(self._before)
                       or ranges[number] != self._before[number]]
            fired += [(number, ranges[number]) for number in self._order(array, sequence, changed, since)
                      if number in heard]
        self._before, self._time = tuple(ranges), time
        return fired

    def _order(self, array: int, sequence: List[int], changed: List[int], since: float) -> List[int]:
        """Return the transducers of an array that have fired in the last `since` seconds, oldest first."""
        last, size = self._last.get(array), len(sequence)
        if last is None:
            if changed:
                self._last[array] = sequence.index(changed[-1])
            return changed
        most = min(size, round(since / CYCLE) + 1)
        ahead = [(sequence.index(number) - last - 1) % size + 1 for number in changed]
        within = [steps for steps in ahead if steps <= most]
        steps = max(within) if within else (0 if changed else min(size, round(since / CYCLE)))
        self._last[array] = (last + steps) % size
        if not within and changed:      # a sequence of the user's own: only what has changed is new
            return changed
        return [sequence[(last + step) % size] for step in range(1, steps + 1)]


class Senses:
    """Makes one `Sensing` of each sonar message, with the pose at the same time.

    Messages of two topics may come in any order. So a sonar message waits until a pose of its time or later has come.
    One that is newer than the last by less than `SHORTEST`, or a little older, is left out: time stands then. When
    somebody resets the odometry, the poses do not jump.

    Args:
        numbers: the fitted transducers.

    Attributes:
        scan_age: how much older (s) than the last packet its newest scan was; None before the first scan, or packet.
    """

    def __init__(self, numbers: Iterable[int]) -> None:
        self._watch = FiringWatch(numbers)
        self._steady = SteadyOdometry()
        self._poses: Deque[Tuple[float, Pose, Pose]] = deque(maxlen=MOST_WAITING)   # time (s), pose, origin
        self._waiting: Deque[Tuple[float, Sequence[float]]] = deque(maxlen=MOST_WAITING)
        self._sweeps: Deque[LaserSweep] = deque(maxlen=MOST_SCANS)      # by time
        self._told: Optional[float] = None      # time of what was sensed last
        self.scan_age: Optional[float] = None

    def hear_pose(self, time: float, pose: Pose) -> List[Sensing]:
        """Take a pose by odometry of a time (s). Return what was sensed, oldest first; usually one or none."""
        if self._poses and time < self._poses[-1][0]:       # time has jumped back
            self._poses.clear()
        self._poses.append((time, self._steady.of(pose, time), self._steady.origin))
        return self._joined()

    def hear_sonar(self, time: float, ranges: Sequence[float]) -> List[Sensing]:
        """Take the ranges (m) of a time (s), by transducer number. Return what was sensed, oldest first."""
        if self._waiting and time < self._waiting[-1][0]:
            self._waiting.clear()
        self._waiting.append((time, ranges))
        return self._joined()

    def wants_sweep(self, time: float) -> bool:
        """Return whether a scan of a time (s) is of use: only some of them are."""
        return not self._sweeps or not 0.0 <= time - self._sweeps[-1].time < BETWEEN_SCANS

    def hear_sweep(self, sweep: LaserSweep) -> None:
        """Take what a laser measured, if it is of use. The next packet gets the newest one of before it."""
        if self.wants_sweep(sweep.time):
            if self._sweeps and sweep.time < self._sweeps[-1].time:     # time has jumped back
                self._sweeps.clear()
            self._sweeps.append(sweep)

    def _joined(self) -> List[Sensing]:
        sensed = []
        while self._waiting and self._poses and self._poses[-1][0] >= self._waiting[0][0]:
            time, ranges = self._waiting.popleft()
            if self._told is not None and -OUT_OF_ORDER < time - self._told < SHORTEST:
                continue
            self._told = time
            pose, origin = self._pose_at(time)
            sensed.append(Sensing(time, pose, timed(self._watch.new(time, ranges), time), origin, self._scan(time)))
        return sensed

    def _scan(self, time: float) -> Optional[Scan]:
        """Return the newest scan of before a packet (s), with where the robot was then, and forget all older ones."""
        newest: Optional[LaserSweep] = None
        if self._sweeps:
            self.scan_age = time - self._sweeps[-1].time
        while self._sweeps and self._sweeps[0].time + self._sweeps[0].duration <= time:
            newest = self._sweeps.popleft()
        if newest is None or time - newest.time > OLD_SCAN or newest.time < self._poses[0][0]:
            return None
        (first, _), (middle, _), (last, _) = (
            self._pose_at(newest.time + share * newest.duration) for share in (0.0, 0.5, 1.0))
        return Scan(newest.time + newest.duration / 2.0, middle, newest.mount, newest.first_angle, newest.angle_step,
                    newest.ranges, relative(first, last))

    def _pose_at(self, time: float) -> Tuple[Pose, Pose]:
        """Return the pose of a time (s), between the two poses around it, and its origin. A pose has come since."""
        times = [each for each, _, _ in self._poses]
        after = bisect.bisect_left(times, time)
        later_time, later, origin = self._poses[after]
        if after == 0 or later_time == time:
            return later, origin
        earlier_time, earlier, _ = self._poses[after - 1]
        return between(earlier, later, (time - earlier_time) / (later_time - earlier_time)), origin
