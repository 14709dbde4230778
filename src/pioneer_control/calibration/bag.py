"""The runs in a bag, for a robot that was driven by hand or by a program while `rosbag record` ran."""

from typing import List, NamedTuple, Tuple

from ..bags.reader import BagReader, read_bag
from ..bags.converting.messages import kind_of, namespace_of
from ..errors import UsageError
from ..floor_poses import Pose
from ..message_values import heading_of
from .pieces import RecordedRun, PoseOrRate, pieces

IMU = "sensor_msgs/Imu"


class RecordedRuns(NamedTuple):
    """The runs in a bag.

    Attributes:
        subtype: the model that the robot says it is; empty if the bag does not tell.
        pieces: the runs.
        damage: what of the bag cannot be read; empty: nothing.
    """

    subtype: str
    pieces: List[RecordedRun]
    damage: str


def runs_of_bag(path: str, robot: str) -> RecordedRuns:
    """Return the runs of a robot in a bag.

    Args:
        path: the bag.
        robot: the namespace of the robot. If the bag has only one robot, any.

    Raises:
        BagError: the file cannot be read, or is no bag.
        UsageError: it has no poses, or those of several other robots.
    """
    reader = read_bag(path, lambda connection: kind_of(connection) in ("pose", "RobotInfo") or connection.type == IMU)
    spaces = sorted({namespace_of(each.topic) for each in reader.connections if kind_of(each) == "pose"})
    wanted = [space for space in spaces if space.strip("/") == robot.strip("/")] or spaces
    if not wanted:
        raise UsageError("%s has no poses of a robot: record its topic pose" % path)
    if len(wanted) != 1:
        raise UsageError("%s has the poses of %d robots (%s): name one, as in calibrate ROBOT --bag" % (
            path, len(spaces), ", ".join(space.lstrip("/") or "/" for space in spaces)))
    subtype, recorded = _read(reader, wanted[0])
    return RecordedRuns(subtype, list(pieces(recorded)), reader.damage)


def _read(reader: BagReader, space: str) -> Tuple[str, List[PoseOrRate]]:
    """Return the model in a bag, and poses and turn rates in the order in which they came.

    Not in that of their stamps: with simulated time these may go back a little, and two poses that change places are a
    step back and one ahead.
    """
    subtype, recorded = "", []
    for connection, message, _ in reader.decoded():
        if namespace_of(connection.topic) != space:
            continue
        if kind_of(connection) == "RobotInfo":
            subtype = message.subtype
        elif connection.topic == space + "/imu":
            recorded.append(PoseOrRate(message.header.stamp.to_sec(), None, message.angular_velocity.z))
        elif kind_of(connection) == "pose":
            place, turn = message.pose.pose.position, message.pose.pose.orientation
            recorded.append(PoseOrRate(message.header.stamp.to_sec(),
                                       Pose(place.x, place.y, heading_of(turn.x, turn.y, turn.z, turn.w))))
    return subtype, recorded
