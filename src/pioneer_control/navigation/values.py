"""The values that all parts of navigation exchange.

Lengths are in metres, angles in radians, counter-clockwise positive, times in seconds.
"""

from typing import NamedTuple, Tuple

from ..floor_poses import Pose


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

    `odometry` is the pose by the wheels at `time` (s). `firings` are those since the last packet, oldest first.
    """

    time: float
    odometry: Pose
    firings: Tuple[Firing, ...]


class Twist(NamedTuple):
    """The velocity that a robot is told: forward (m/s) and counter-clockwise (rad/s)."""

    linear: float
    angular: float
