"""A stretch of the robot's path: a metre or so, with what was heard on it. It is small enough to be taken as rigid.

Mapping moves whole stretches when it finds that they lie wrong (`mapping`, `pose_graph`).
"""

import math
from typing import Any, Dict, List, Sequence, Tuple

import numpy as np

from ..floor_poses import Pose, relative
from ..robots import Transducer
from .sonar_grid import SonarBeams
from .values import Firing, Sensing
from .wheel_motion import WheelBias, path

Array = Any     # of numpy

STEADY = 1.5
"""Turning faster than this (rad/s), firings are not used: their time is known to half a cycle only."""
MOST_TURN = 1.2
"""Greatest turn rate (rad/s) while a map is made: less than `STEADY`, so that firings are used."""
MOVED = 0.01, 0.02
"""A transducer counts again when the robot has moved this far (m) or has turned this far (rad): standing teaches
nothing new."""


class Ears:
    """The transducers of a robot, and what each has said already.

    Args:
        transducers: those that are fitted.
    """

    def __init__(self, transducers: Sequence[Transducer]) -> None:
        self.mounts: Dict[int, Transducer] = {each.number: each for each in transducers}
        self._said: Dict[int, Tuple[float, float]] = {}

    def new(self, firing: Firing, way: float, turned: float) -> bool:
        """Return whether a firing says something new. It then counts as said.

        Args:
            firing: the firing.
            way: sum of all ways (m) of the robot.
            turned: sum of all turns (rad), whatever their side.
        """
        said = self._said.get(firing.number)
        is_new = firing.number in self.mounts and (
            said is None or way - said[0] > MOVED[0] or turned - said[1] > MOVED[1])
        if is_new:
            self._said[firing.number] = way, turned
        return is_new


class Stretch:
    """The motion on a stretch of path, and the firings that are used.

    Args:
        time: when it begins (s).
        ears: the transducers; several stretches share them.

    Attributes:
        way: length (m) of the path in it.
        turned: sum (rad) of the turns in it, whatever their side.
    """

    def __init__(self, time: float, ears: Ears) -> None:
        self.way = self.turned = 0.0
        self._ears = ears
        self._times = [time]
        self._steps: List[Tuple[float, float, float]] = []
        self._heard: List[Tuple[float, int, float]] = []
        self._steps_until = np.zeros((0, 3))

    def add(self, before: Pose, sensing: Sensing, way: float, turned: float) -> None:
        """Go on with one packet.

        Args:
            before: odometry of the packet before.
            sensing: the packet.
            way, turned: sums of ways (m) and turns (rad) of the robot until `before`, see `Ears.new`.
        """
        step = relative(before, sensing.odometry)
        seconds = max(sensing.time - self._times[-1], 1e-3)
        self._steps.append((step.x, step.y, step.heading))
        self._times.append(sensing.time)
        moved = math.hypot(step.x, step.y)
        self.way += moved
        self.turned += abs(step.heading)
        if abs(step.heading) <= STEADY * seconds:
            self._heard += [(each.time, each.number, each.range) for each in sensing.firings
                            if self._ears.new(each, way + moved, turned + abs(step.heading))]

    @property
    def heard_count(self) -> int:
        """How many firings it has."""
        return len(self._heard)

    @property
    def steps(self) -> Array:
        """The motion between its packets by odometry, see `wheel_motion.path`: array (n, 3)."""
        if len(self._steps_until) < len(self._steps):
            self._steps_until = np.array(self._steps)
        return self._steps_until

    def path(self, bias: WheelBias) -> Array:
        """Return the poses at its packets, relative to its begin: array (n, 3) of x, y (m), heading (rad)."""
        return path(self.steps, bias)

    def end(self, bias: WheelBias) -> Pose:
        """Return the pose at its end, relative to its begin."""
        return Pose(*self.path(bias)[-1])

    def beams(self, bias: WheelBias, first: int = 0) -> SonarBeams:
        """Return its firings from number `first` on, relative to its begin."""
        heard = self._heard[first:]
        poses = self.path(bias)
        times = np.array([each[0] for each in heard])
        x, y, heading = (np.interp(times, self._times, poses[:, axis]) for axis in range(3))
        mounts = [self._ears.mounts[each[1]] for each in heard]
        cosine, sine = np.cos(heading), np.sin(heading)
        ahead, left = np.array([each.x for each in mounts]), np.array([each.y for each in mounts])
        return SonarBeams(x + ahead * cosine - left * sine, y + ahead * sine + left * cosine,
                          heading + np.array([each.heading for each in mounts]), np.array([each[2] for each in heard]))
