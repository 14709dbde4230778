"""Pure functions that make messages: sonar and battery as standard ROS messages, and RobotInfo.

The driver publishes these messages, and the programs in `bags` make them from old bags. ``stamp`` is a rospy.Time, the
time of the measurement.

Source: REP 103 for units and axes, REP 117 for ranges.
"""

import math
import struct
from typing import Any, Iterable, Tuple

from geometry_msgs.msg import Point32, Polygon, Pose2D, Quaternion, Transform, TransformStamped, Vector3
from sensor_msgs.msg import BatteryState, PointCloud2, PointField, Range
from std_msgs.msg import Header
from tf2_msgs.msg import TFMessage

from .message_values import NO_ECHO, quaternion_of
from .msg import RobotInfo
from .robots import SONAR_HEIGHT, RobotModel, Transducer

MIN_RANGE = 0.1
"""The shortest range (m) that a transducer can measure. For a nearer obstacle we publish this range."""
FIELD_OF_VIEW = math.radians(25)
HEIGHT = SONAR_HEIGHT
"""The height (m) of the transducers above the floor. We use that of a Pioneer 3 for all models."""

POINT = struct.Struct("<fff")
FIELDS = [PointField(axis, 4 * place, PointField.FLOAT32, 1) for place, axis in enumerate("xyz")]


def sonar_range(number: int, distance: float, stamp: Any, frame_prefix: str, no_echo: float = math.inf) -> Range:
    """Return the reading of one sonar transducer as a sensor_msgs/Range message.

    Args:
        number: the number of the transducer; it chooses the frame (see `frame_of`).
        distance: the measured range (m). NO_ECHO or more means that there was no echo.
        stamp: the time of the measurement.
        frame_prefix: the prefix of the names of the sonar frames.
        no_echo: the range (m) to publish when there was no echo. Infinity is as REP 117 says.
    """
    return Range(
        header=Header(stamp=stamp, frame_id=frame_of(number, frame_prefix)),
        radiation_type=Range.ULTRASOUND,
        field_of_view=FIELD_OF_VIEW,
        min_range=MIN_RANGE,
        max_range=NO_ECHO,
        range=max(MIN_RANGE, distance) if distance < NO_ECHO else no_echo,
    )


def sonar_points(points: Iterable[Tuple[float, float]], stamp: Any, base_link_frame: str) -> PointCloud2:
    """Return a point cloud of echoes. ``points`` are (x, y) in base_link (m); z is the height of the transducers."""
    data = b"".join(POINT.pack(*point, HEIGHT) for point in points)
    return PointCloud2(
        header=Header(stamp=stamp, frame_id=base_link_frame),
        height=1,
        width=len(data) // POINT.size,
        fields=FIELDS,
        point_step=POINT.size,
        row_step=len(data),
        data=data,
        is_dense=True,
    )


def echo_place(
    transducer: Transducer, distance: float, age: float, linear: float, angular: float,
) -> Tuple[float, float]:
    """Return where an echo is now: (x, y) in base_link (m). The robot has moved since the measurement.

    Args:
        transducer: the transducer that measured the echo.
        distance: the range at the time of the measurement (m).
        age: the time since the measurement (s).
        linear, angular: the velocity of the robot since the measurement (m/s, rad/s), taken as constant.
    """
    turn, way = angular * age, linear * age
    x = transducer.x + distance * math.cos(transducer.heading) - way * math.cos(turn / 2)
    y = transducer.y + distance * math.sin(transducer.heading) - way * math.sin(turn / 2)
    cosine, sine = math.cos(turn), math.sin(turn)
    return cosine * x + sine * y, cosine * y - sine * x


def sonar_frames(transducers: Iterable[Transducer], stamp: Any, base_link_frame: str, frame_prefix: str) -> TFMessage:
    """Return the transforms from base_link to the frames of all transducers, for /tf_static.

    They are in one message, because /tf_static is latched: it keeps only the last message of each node.
    """
    header = Header(stamp=stamp, frame_id=base_link_frame)
    return TFMessage([
        TransformStamped(header, frame_of(transducer.number, frame_prefix), Transform(
            Vector3(transducer.x, transducer.y, HEIGHT), Quaternion(*quaternion_of(transducer.heading))))
        for transducer in transducers])


def frame_of(number: int, frame_prefix: str) -> str:
    """Return the name of the frame of a transducer. Its x axis points along the axis of the sonar cone."""
    return "%ssonar_%d" % (frame_prefix, number)


def battery(
    voltage: float, stamp: Any, base_link_frame: str, percentage: float = math.nan,
    status: int = BatteryState.POWER_SUPPLY_STATUS_UNKNOWN,
) -> BatteryState:
    """Return a sensor_msgs/BatteryState message.

    Values that no Pioneer measures (temperature, current, capacity) are NaN.

    Args:
        voltage: the voltage of the battery (V).
        stamp: the time of the measurement.
        base_link_frame: the frame of the message.
        percentage: the state of charge (0 to 1); NaN when it is not known.
        status: whether the charger charges: a POWER_SUPPLY_STATUS_ constant of BatteryState.
    """
    return BatteryState(
        header=Header(stamp=stamp, frame_id=base_link_frame),
        voltage=voltage,
        temperature=math.nan,
        current=math.nan,
        charge=math.nan,
        capacity=math.nan,
        design_capacity=math.nan,
        percentage=percentage,
        power_supply_status=status,
        present=True,
    )


def robot_info(model: RobotModel, has_gripper: bool, stamp: Any, base_link_frame: str) -> RobotInfo:
    """Return a RobotInfo message: speed limits, poses of the transducers and outline of a model (m, rad, base_link).

    The fields that only a connected robot can fill (name, type, firmware) stay empty.
    """
    return RobotInfo(
        header=Header(stamp=stamp, frame_id=base_link_frame),
        subtype=model.subtype,
        max_linear=model.max_linear,
        max_angular=model.max_angular,
        has_gripper=has_gripper,
        sonar_numbers=[transducer.number for transducer in model.sonar],
        sonar_poses=[Pose2D(transducer.x, transducer.y, transducer.heading) for transducer in model.sonar],
        footprint=Polygon([Point32(x, y, 0.0) for x, y in model.outline(has_gripper)]),
    )
