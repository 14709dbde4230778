"""Sonar and battery as messages that other packages know, and RobotInfo. Pure functions.

The driver sends them live, and the programs of `bags` make them of old bags. ``stamp`` is a rospy.Time.

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
from .robots import RobotModel, Transducer

MIN_RANGE = 0.1
"""Range (m) below which a transducer hears only its own pulse: what is nearer reads as this."""
FIELD_OF_VIEW = math.radians(25)
HEIGHT = 0.17
"""Height (m) of the transducers above the floor on a Pioneer 3: the table of models has none."""

POINT = struct.Struct("<fff")
FIELDS = [PointField(axis, 4 * place, PointField.FLOAT32, 1) for place, axis in enumerate("xyz")]


def sonar_range(number: int, distance: float, stamp: Any, frame_prefix: str, no_echo: float = math.inf) -> Range:
    """What one transducer heard (m); ``no_echo`` (m) where nothing is in sight: infinity (REP 117), or NO_ECHO."""
    return Range(
        header=Header(stamp=stamp, frame_id=frame_of(number, frame_prefix)),
        radiation_type=Range.ULTRASOUND,
        field_of_view=FIELD_OF_VIEW,
        min_range=MIN_RANGE,
        max_range=NO_ECHO,
        range=max(MIN_RANGE, distance) if distance < NO_ECHO else no_echo,
    )


def sonar_points(points: Iterable[Tuple[float, float]], stamp: Any, base_link_frame: str) -> PointCloud2:
    """Places of echoes (m, base_link; see `echo_place`) as a cloud at the height of the transducers."""
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
    """Where (m) an echo is in base_link now.

    Args:
        transducer: it heard the echo.
        distance: of the echo then (m).
        age: s since then.
        linear, angular: speed of the robot (m/s, rad/s), at which it went on meanwhile.
    """
    turn, way = angular * age, linear * age
    x = transducer.x + distance * math.cos(transducer.heading) - way * math.cos(turn / 2)
    y = transducer.y + distance * math.sin(transducer.heading) - way * math.sin(turn / 2)
    cosine, sine = math.cos(turn), math.sin(turn)
    return cosine * x + sine * y, cosine * y - sine * x


def sonar_frames(transducers: Iterable[Transducer], stamp: Any, base_link_frame: str, frame_prefix: str) -> TFMessage:
    """Where each transducer sits and looks. All in one message: /tf_static keeps only the last one of a node."""
    header = Header(stamp=stamp, frame_id=base_link_frame)
    return TFMessage([
        TransformStamped(header, frame_of(transducer.number, frame_prefix), Transform(
            Vector3(transducer.x, transducer.y, HEIGHT), Quaternion(*quaternion_of(transducer.heading))))
        for transducer in transducers])


def frame_of(number: int, frame_prefix: str) -> str:
    """The frame of a transducer, x along its axis."""
    return "%ssonar_%d" % (frame_prefix, number)


def battery(
    voltage: float, stamp: Any, base_link_frame: str, percentage: float = math.nan,
    status: int = BatteryState.POWER_SUPPLY_STATUS_UNKNOWN,
) -> BatteryState:
    """Voltage (V), and if known charge (0 to 1) and status of the charger. What no Pioneer measures is NaN."""
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
    """What a model is: limits, poses of its transducers and outline (m, rad, base_link).

    The fields that only a connected robot can fill stay empty.
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
