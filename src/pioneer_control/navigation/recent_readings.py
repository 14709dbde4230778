"""Readings with the place of their sensor: those of a packet, of a scan, and of the last metres."""

import math
from typing import Any, List, Sequence, Tuple

import numpy as np

from ..floor_poses import Pose, between, compose, relative
from ..robots import Transducer
from .frames import into, out_of
from .laser_rays import rays_of
from .measurement import Beams
from .values import Firing, Scan, Sensing

Array = Any     # of numpy

PACKETS_KEPT = 4
"""Firings of a packet lie between it and some packets before: the odometry of so many packets is kept."""


class RecentReadings:
    """Keeps the newest readings, and places them relative to the robot.

    Args:
        most: number of readings to keep.

    Attributes:
        heard: number of readings that were ever added.
    """

    def __init__(self, most: int):
        self._rows = np.empty((2 * most, 5))    # x, y, heading of the sensor (odometry frame), range number, sensor
        self._most, self._end = most, 0
        self.heard = self._heard_at_mark = 0

    def __len__(self) -> int:
        return min(self._end, self._most)

    def forget(self) -> None:
        """Forget all readings."""
        self._end = 0

    def keep(self, newest: int) -> None:
        """Forget all but some of the newest readings."""
        kept = self._rows[max(0, self._end - newest):self._end].copy()
        self._rows[:len(kept)], self._end = kept, len(kept)

    def mark(self) -> None:
        """Mark the newest reading, see `keep_marked`."""
        self._heard_at_mark = self.heard

    def keep_marked(self, most: int) -> None:
        """Forget all but those that came after the mark, and of these all but some of the newest."""
        self.keep(min(most, self.heard - self._heard_at_mark))

    def add(self, odometry: Pose, beams: Beams) -> None:
        """Keep readings that are given relative to the robot when its pose by the wheels (m, rad) was `odometry`."""
        count = len(beams.x)
        if self._end + count > len(self._rows):
            self._rows[:self._most] = self._rows[self._end - self._most:self._end].copy()
            self._end = self._most
        x, y = out_of(odometry, beams.x, beams.y)
        self._rows[self._end:self._end + count] = np.stack((
            x, y, odometry.heading + beams.heading, beams.measured, beams.sensor), axis=1)
        self._end += count
        self.heard += count

    def seen_from(self, odometry: Pose) -> Beams:
        """Return all kept readings, oldest first, relative to the robot at a pose by the wheels (m, rad)."""
        rows = self._rows[max(0, self._end - self._most):self._end]
        return Beams(*into(odometry, rows[:, 0], rows[:, 1]), rows[:, 2] - odometry.heading,
                     rows[:, 3].astype(np.int32), rows[:, 4].astype(np.int32))


class FiringPoses:
    """Tells where a transducer was when it fired: between two packets, odometry is interpolated.

    Args:
        transducers: the transducers of the robot.

    Attributes:
        span: diagonal (m) of the square in which the transducers are while the robot turns on the spot.
    """

    def __init__(self, transducers: Sequence[Transducer]):
        self.span = math.sqrt(8.0) * max((math.hypot(each.x, each.y) for each in transducers), default=0.0)
        self._mounts = {each.number: Pose(each.x, each.y, each.heading) for each in transducers}
        self._past: List[Tuple[float, Pose]] = []
        self._firings: List[Firing] = []

    def add(self, sensing: Sensing) -> None:
        """Take one packet. Unknown transducers are left out."""
        self._past = self._past[1 - PACKETS_KEPT:] + [(sensing.time, sensing.odometry)]
        self._firings += [each for each in sensing.firings if each.number in self._mounts]

    def forget(self) -> None:
        """Forget the readings that were added since the last call of `beams`."""
        self._firings = []

    def beams(self, number_of: Any) -> Beams:
        """Return the readings added since the last call, relative to the robot at its newest odometry.

        Args:
            number_of: function that makes numbers of ranges (m).
        """
        firings, self._firings = self._firings, []
        _, odometry = self._past[-1]
        robot = {time: relative(odometry, self._at(time)) for time in {each.time for each in firings}}
        placed = [compose(robot[each.time], self._mounts[each.number]) for each in firings]
        x, y, heading = np.array(placed, dtype=float).reshape(-1, 3).T
        return Beams(x, y, heading, number_of([each.range for each in firings]),
                     np.array([each.number for each in firings], dtype=int))

    def _at(self, time: float) -> Pose:
        """Return the odometry at a time (s), as far back as it is kept."""
        late, after = self._past[-1]
        for early, before in reversed(self._past[:-1]):
            if time >= early:
                share = min(1.0, (time - early) / (late - early)) if late > early else 1.0
                return between(before, after, share)
            late, after = early, before
        return after


def scan_beams(scan: Scan, odometry: Pose, number_of: Any, most: int) -> Beams:
    """Return some rays of a scan that measured something, relative to the robot at a later odometry.

    Args:
        scan: the scan.
        odometry: the pose by the wheels (m, rad) of now.
        number_of: function that makes numbers of ranges (m).
        most: most rays; they are spread over the scan.
    """
    rays = rays_of(scan, relative(odometry, scan.odometry), most)
    return Beams(rays.x, rays.y, rays.heading, number_of(rays.range), rays.number)
