"""The values that all parts of navigation exchange.

Lengths are in metres, angles in radians, counter-clockwise positive, times in seconds.
"""

from typing import NamedTuple, Optional, Sequence, Tuple

import numpy as np

from ..floor_poses import Pose


Point = Tuple[float, float]
"""x and y (m) of a place."""


class Firing(NamedTuple):
    """What one transducer heard in one firing.

    `range` (m) is infinite without an echo. `time` (s) is when the transducer fired: a packet has firings of the last
    0.1 s.
    """

    number: int
    range: float
    time: float


class LaserSweep(NamedTuple):
    """What a laser measures in one turn, as it tells it.

    Attributes:
        time: when the first ray was fired (s).
        duration: from the first ray to the last one (s); 0 if the laser does not tell the order of its rays.
        mount: pose of the laser on the robot.
        first_angle, angle_step: ray number i looks to `first_angle` + i * `angle_step` (rad; 0 is straight ahead of the
            laser).
        ranges: of each ray (m): infinite where no echo came back, NaN where the laser could not measure.
    """

    time: float
    duration: float
    mount: Pose
    first_angle: float
    angle_step: float
    ranges: Sequence[float]


LEAST_SEEN = 0.1
"""A scan of which a smaller share of rays measured something is blind: the laser is covered or dazzled, or all is too
far away for it."""


def is_blind(ranges: Sequence[float]) -> bool:
    """Return whether so few ranges are finite that they do not tell where the robot is."""
    return bool(np.isfinite(ranges).mean() < LEAST_SEEN)


class Scan(NamedTuple):
    """What a laser measures in one turn, and how the robot moved meanwhile, by the wheels.

    `time` (s) is the middle between the first ray and the last, `odometry` the pose then, and `motion` what the robot
    moved from the first ray to the last (m, rad; robot's frame). All else is as in `LaserSweep`.
    """

    time: float
    odometry: Pose
    mount: Pose
    first_angle: float
    angle_step: float
    ranges: Sequence[float]
    motion: Pose = Pose(0.0, 0.0, 0.0)

    @property
    def is_blind(self) -> bool:
        """Whether it does not tell where the robot is: next to nothing was in sight."""
        return is_blind(self.ranges)


class Sensing(NamedTuple):
    """What the robot senses in one standard packet (SIP).

    `odometry` is the pose by the wheels at `time` (s); it never jumps. `firings` are those since the last packet,
    oldest first. `origin` is where the wheels tell a pose of 0, in the frame of `odometry`: see `steady_odometry`.
    `scan` is the newest one of a laser since the last packet, if there is any.
    """

    time: float
    odometry: Pose
    firings: Tuple[Firing, ...]
    origin: Pose = Pose(0.0, 0.0, 0.0)
    scan: Optional[Scan] = None


class Twist(NamedTuple):
    """The velocity that a robot is told: forward (m/s) and counter-clockwise (rad/s)."""

    linear: float
    angular: float


STOP = Twist(0.0, 0.0)
"""The velocity of a robot that stands."""
