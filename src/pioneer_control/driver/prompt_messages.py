"""What whoever steers waits for, as messages that write themselves in one go: where the robot is, and what its sonar heard.

genpy visits each field, and takes longer for one Odometry than all else that lies between the wire and it. These have what rospy asks of a message
that is published, and nothing that could be read and be wrong. rospy has written one when publish() returns: there is one of each, filled anew.
"""

import struct
from functools import lru_cache
from typing import BinaryIO, Dict, NamedTuple, Sequence

from nav_msgs.msg import Odometry
from std_msgs.msg import Header
from tf2_msgs.msg import TFMessage

from ..client import RobotState
from ..message_values import quaternion_of
from ..msg import SonarArray
from .conversions import diagonal
from .parameters import DriverParameters
from .ranges import ranges_by_number


class Covariance(NamedTuple):
    """As they are written: row-major 6 x 6, of x, y, z, roll, pitch, yaw."""

    pose: bytes
    twist: bytes


def covariances(parameters: DriverParameters) -> Dict[bool, Covariance]:
    """What goes into odometry while the robot moves (True) and while it stands (False)."""
    return {
        True: Covariance(_matrix(parameters.pose_covariance_moving), _matrix(parameters.twist_covariance_moving)),
        False: Covariance(_matrix(parameters.pose_covariance_still), _matrix(parameters.twist_covariance_still)),
    }


class PoseMessage:
    """A nav_msgs/Odometry: pose in the odometry frame, twist in base_link, with the covariances for a robot that moves or stands."""

    _type, _md5sum, _has_header = Odometry._type, Odometry._md5sum, True

    def __init__(self, odom_frame: str, base_link_frame: str, covariance: Dict[bool, Covariance]) -> None:
        self.header = Header(frame_id=odom_frame)
        self._frames = _string(odom_frame) + _string(base_link_frame)
        self._covariance = covariance
        self._struct = struct.Struct("<3I%ds7d288s6d288s" % len(self._frames))

    def of(self, motion: RobotState, stamp) -> "PoseMessage":
        """Say this from now on."""
        self._motion, self.header.stamp = motion, stamp
        return self

    def serialize(self, buffer: BinaryIO) -> None:
        """Write it. rospy has counted it in the header before."""
        stamp, motion = self.header.stamp, self._motion
        _, _, z, w = quaternion_of(motion.heading)
        pose, twist = self._covariance[motion.moving]
        buffer.write(self._struct.pack(
            self.header.seq, stamp.secs, stamp.nsecs, self._frames,
            motion.x, motion.y, 0.0, 0.0, 0.0, z, w, pose,
            motion.linear, 0.0, 0.0, 0.0, 0.0, motion.angular, twist))


class TransformMessage:
    """A tf2_msgs/TFMessage with one transform, odometry frame -> base_link, that says what the PoseMessage says."""

    _type, _md5sum = TFMessage._type, TFMessage._md5sum

    def __init__(self, odom_frame: str, base_link_frame: str) -> None:
        self._frames = _string(odom_frame) + _string(base_link_frame)
        self._struct = struct.Struct("<4I%ds7d" % len(self._frames))

    def of(self, motion: RobotState, stamp) -> "TransformMessage":
        """Say this from now on."""
        self._motion, self._stamp = motion, stamp
        return self

    def serialize(self, buffer: BinaryIO) -> None:
        """Write it."""
        motion, stamp = self._motion, self._stamp
        _, _, z, w = quaternion_of(motion.heading)
        buffer.write(self._struct.pack(1, 0, stamp.secs, stamp.nsecs, self._frames, motion.x, motion.y, 0.0, 0.0, 0.0, z, w))


class SonarMessage:
    """A SonarArray."""

    _type, _md5sum, _has_header = SonarArray._type, SonarArray._md5sum, True

    def __init__(self, base_link_frame: str) -> None:
        self.header = Header(frame_id=base_link_frame)
        self._frame = _string(base_link_frame)
        self._struct = lru_cache(maxsize=4)(lambda count: struct.Struct("<3I%dsiI%dd" % (len(self._frame), count)))

    def of(self, state: RobotState, stamp) -> "SonarMessage":
        """Say this from now on."""
        self._state, self.header.stamp = state, stamp
        return self

    def serialize(self, buffer: BinaryIO) -> None:
        """Write it. rospy has counted it in the header before."""
        stamp, ranges = self.header.stamp, ranges_by_number(self._state)
        count = len(ranges)
        buffer.write(self._struct(count).pack(self.header.seq, stamp.secs, stamp.nsecs, self._frame, count, count, *ranges))


def _matrix(variances: Sequence[float]) -> bytes:
    return struct.pack("<36d", *diagonal(variances))


def _string(text: str) -> bytes:
    """As ROS writes a string."""
    data = text.encode()
    return struct.pack("<I", len(data)) + data
