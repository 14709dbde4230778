"""Sonar to ROS: what was heard by number, as ranges and as points. Pure functions; the frames of the transducers are in `standard_messages`."""

from typing import Iterable, List

from sensor_msgs.msg import PointCloud2, Range

from .. import standard_messages
from ..client import RobotState
from ..message_values import NO_ECHO, NOT_HEARD
from ..robots import Transducer

SONAR_LIFETIME = 2.0
"""Age (s) at which a reading expires; a full round of an array takes 0.32 s."""


def ranges_by_number(state: RobotState) -> List[float]:
    """Ranges (m) by sonar number; NO_ECHO where nothing is in sight, NOT_HEARD where the last reading has expired."""
    return [NOT_HEARD if _expired(reading, state) else min(reading.range, NO_ECHO) for reading in state.sonar]


def sonar_ranges(state: RobotState, stamp, frame_prefix: str, no_echo: float) -> List[Range]:
    """One message for each transducer that this packet brought; ``no_echo`` (m) where nothing is in sight: infinity (REP 117), or NO_ECHO."""
    return [
        standard_messages.sonar_range(number, reading.range, stamp, frame_prefix, no_echo)
        for number, reading in enumerate(state.sonar)
        if reading is not None and reading.time == state.time
    ]


def sonar_points(state: RobotState, stamp, base_link_frame: str, transducers: Iterable[Transducer]) -> PointCloud2:
    """The newest echo of each transducer, in base_link as it now stands; none where nothing is in sight or heard."""
    heard = ((transducer, state.sonar[transducer.number]) for transducer in transducers)
    return standard_messages.sonar_points(
        [standard_messages.echo_place(transducer, reading.range, state.time - reading.time, state.linear, state.angular)
         for transducer, reading in heard if not _expired(reading, state) and reading.range < NO_ECHO],
        stamp, base_link_frame)


def _expired(reading, state: RobotState) -> bool:
    return reading is None or state.time - reading.time > SONAR_LIFETIME
