"""The values that all parts of navigation exchange.

Lengths are in metres, angles in radians, counter-clockwise positive, times in seconds.
"""

from typing import NamedTuple, Sequence, Tuple

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


class Sensing(NamedTuple):
    """What the robot senses in one standard packet (SIP).

    `odometry` is the pose by the wheels at `time` (s); it never jumps. `firings` are those since the last packet,
    oldest first. `origin` is where the wheels tell a pose of 0, in the frame of `odometry`: see `steady_odometry`.
    """

    time: float
    odometry: Pose
    firings: Tuple[Firing, ...]
    origin: Pose = Pose(0.0, 0.0, 0.0)


class Scan(NamedTuple):
    """What a laser measures in one turn.

    `odometry` is the pose by the wheels at `time` (s), `mount` that of the laser on the robot. Ray number i looks to
    `first_angle` + i * `angle_step` (rad; 0 is straight ahead of the laser) and measures `ranges[i]` (m), infinite or
    NaN where it sees nothing.
    """

    time: float
    odometry: Pose
    mount: Pose
    first_angle: float
    angle_step: float
    ranges: Sequence[float]


class Twist(NamedTuple):
    """The velocity that a robot is told: forward (m/s) and counter-clockwise (rad/s)."""

    linear: float
    angular: float


STOP = Twist(0.0, 0.0)
"""The velocity of a robot that stands."""
