"""Sonar to ROS: what was heard as an array, as ranges and as points, and the frames of the transducers. Pure functions."""

import math
import struct
from typing import Iterable, List, Optional, Tuple

from geometry_msgs.msg import Quaternion, TransformStamped, Vector3
from sensor_msgs.msg import PointCloud2, PointField, Range
from std_msgs.msg import Header
from tf2_msgs.msg import TFMessage

from ..client import RobotState
from ..message_values import NO_ECHO, NOT_HEARD, quaternion_of
from ..msg import SonarArray
from ..robots import Transducer

SONAR_LIFETIME = 2.0
"""Age (s) at which a reading expires; a full round of an array takes 0.32 s."""
MIN_RANGE = 0.1
"""Range (m) below which a transducer hears only its own pulse: what is nearer reads as this."""
FIELD_OF_VIEW = math.radians(25)
HEIGHT = 0.17
"""Height (m) of the transducers above the floor on a Pioneer 3: the table of models has none."""

POINT = struct.Struct("<fff")
FIELDS = [PointField(axis, 4 * place, PointField.FLOAT32, 1) for place, axis in enumerate("xyz")]


def sonar_array(state: RobotState, stamp, base_link_frame: str, message: Optional[SonarArray] = None) -> SonarArray:
    """Ranges (m) by sonar number; NO_ECHO where nothing is in sight, NOT_HEARD where the last reading has expired. Fills ``message``, else a new one."""
    message = message or SonarArray()
    message.header.stamp, message.header.frame_id = stamp, base_link_frame
    message.ranges = [NOT_HEARD if _expired(reading, state) else min(reading.range, NO_ECHO) for reading in state.sonar]
    message.ranges_count = len(message.ranges)
    return message


def sonar_ranges(state: RobotState, stamp, frame_prefix: str, no_echo: float) -> List[Range]:
    """One message for each transducer that this packet brought; ``no_echo`` (m) where nothing is in sight: infinity (REP 117), or NO_ECHO."""
    return [
        Range(
            header=Header(stamp=stamp, frame_id=frame_of(number, frame_prefix)),
            radiation_type=Range.ULTRASOUND,
            field_of_view=FIELD_OF_VIEW,
            min_range=MIN_RANGE,
            max_range=NO_ECHO,
            range=max(MIN_RANGE, reading.range) if reading.range < NO_ECHO else no_echo,
        )
        for number, reading in enumerate(state.sonar)
        if reading is not None and reading.time == state.time
    ]


def sonar_points(state: RobotState, stamp, base_link_frame: str, transducers: Iterable[Transducer]) -> PointCloud2:
    """The newest echo of each transducer, in base_link as it stands now; none where nothing is in sight or heard."""
    data = bytearray()
    for transducer in transducers:
        reading = state.sonar[transducer.number]
        if not _expired(reading, state) and reading.range < NO_ECHO:
            data += POINT.pack(*_place(transducer, reading, state), HEIGHT)
    return PointCloud2(
        header=Header(stamp=stamp, frame_id=base_link_frame),
        height=1,
        width=len(data) // POINT.size,
        fields=FIELDS,
        point_step=POINT.size,
        row_step=len(data),
        data=bytes(data),
        is_dense=True,
    )


def sonar_frames(transducers: Iterable[Transducer], stamp, base_link_frame: str, frame_prefix: str) -> TFMessage:
    """Where each transducer sits and looks. All in one message: /tf_static keeps only the last one of a node."""
    transforms = TFMessage()
    for transducer in transducers:
        message = TransformStamped(Header(stamp=stamp, frame_id=base_link_frame), frame_of(transducer.number, frame_prefix), None)
        message.transform.translation = Vector3(transducer.x, transducer.y, HEIGHT)
        message.transform.rotation = Quaternion(*quaternion_of(transducer.heading))
        transforms.transforms.append(message)
    return transforms


def frame_of(number: int, frame_prefix: str) -> str:
    """The frame of a transducer, x along its axis."""
    return "%ssonar_%d" % (frame_prefix, number)


def _expired(reading, state: RobotState) -> bool:
    return reading is None or state.time - reading.time > SONAR_LIFETIME


def _place(transducer: Transducer, reading, state: RobotState) -> Tuple[float, float]:
    """Where (m) an echo is in base_link, after the robot has gone on at its present speed since it was heard."""
    age = state.time - reading.time
    turn, way = state.angular * age, state.linear * age
    x = transducer.x + reading.range * math.cos(transducer.heading) - way * math.cos(turn / 2)
    y = transducer.y + reading.range * math.sin(transducer.heading) - way * math.sin(turn / 2)
    cosine, sine = math.cos(turn), math.sin(turn)
    return cosine * x + sine * y, cosine * y - sine * x
