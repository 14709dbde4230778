"""The laser of a robot in a bag: where it sits, as tf told then."""

from typing import NamedTuple, Optional

import rospy
import tf2_ros

from ...bags.command_line import Progress
from ...bags.reader import BagConnection, read_bag
from ...errors import UsageError
from ...floor_poses import Pose
from .messages import mount_of

SCAN = "sensor_msgs/LaserScan"
TF = ("tf2_msgs/TFMessage", "tf/tfMessage")


class BagLaser(NamedTuple):
    """A laser: the frame of its scans, where it is on the robot (m, rad), and whether it is upside down there."""

    frame: str
    mount: Pose
    upside_down: bool


def laser_of(path: str, robot: str, base_frame: str) -> Optional[BagLaser]:
    """Return the laser of a robot in a bag: that of its first scan. None: there are no scans.

    Args:
        path: the bag.
        robot: the namespace of the robot.
        base_frame: the frame of the robot itself.

    Raises:
        UsageError: no transform in the bag says where the laser is, or it does not look along the floor.
    """
    scans = read_bag(path, lambda connection: connection.topic == robot + "/scan" and connection.type == SCAN)
    first = next((message for _, message, _ in scans.decoded()), None)
    if first is None:
        return None
    frame = first.header.frame_id.lstrip("/")
    return BagLaser(frame, *mount_of(transform_in(path, base_frame, frame)))


def transform_in(path: str, parent: str, child: str) -> object:
    """Return the first geometry_msgs/Transform from one frame to another that a bag tells, over any frames between.

    Raises:
        UsageError: it tells none.
    """
    frames = tf2_ros.BufferCore(rospy.Duration(1.0))
    with Progress("looking for the laser") as progress:
        for _, message, _ in read_bag(path, is_tf, progress).decoded():
            for each in message.transforms:
                frames.set_transform_static(each, "bag")        # it takes off the / that old names begin with
            if frames.can_transform_core(parent, child, rospy.Time(0))[0]:
                return frames.lookup_transform_core(parent, child, rospy.Time(0)).transform
    raise UsageError("nobody says in /tf or /tf_static where its frame %r is in %r" % (child, parent))


def is_tf(connection: BagConnection) -> bool:
    """Return whether a connection carries transforms."""
    return connection.topic in ("/tf", "/tf_static") and connection.type in TF
