"""Arrays of sonar ranges, as a driver repeats them, read as what each transducer heard and when; and a scan of it."""

import math
from typing import Any, Dict, Iterable, List, NamedTuple, Sequence, Tuple

import numpy as np
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Header

from ...message_values import NO_ECHO, NOT_HEARD
from ...robots import Transducer
from ...standard_messages import MIN_RANGE

ROUND = 0.32
"""s in which each transducer of an array has its turn. A reading that stays the same for so long was heard again."""
BEAMS = 360
"""Directions of a scan, a degree apart: as seen from the robot's middle, near and far echoes of one transducer lie in
different directions.
"""


class Reading(NamedTuple):
    """What a transducer heard last: its range (m), and its age (s); 0 where it was just heard."""

    transducer: Transducer
    range: float
    age: float


class SonarHistory:
    """Tells new readings from repeated ones."""

    def __init__(self) -> None:
        self._last: Dict[int, Tuple[float, float]] = {}     # by number: range, and when it was heard
        self._time = -math.inf

    def readings(self, ranges: Sequence[float], transducers: Iterable[Transducer], time: float) -> List[Reading]:
        """The newest reading of each transducer that was heard, in an array that came at a time (s)."""
        if time < self._time:   # time began anew
            self._last.clear()
        self._time = time
        found = []
        for transducer in transducers:
            heard = ranges[transducer.number] if transducer.number < len(ranges) else NOT_HEARD
            if heard > NOT_HEARD:   # and is not NaN
                before, since = self._last.get(transducer.number, (None, time))
                since = since if heard == before and time - since < ROUND else time
                self._last[transducer.number] = heard, since
                found.append(Reading(transducer, heard, time - since))
            else:
                self._last.pop(transducer.number, None)
        return found


def sonar_scan(
    points: Iterable[Tuple[float, float]],
    silent: Iterable[Transducer],
    transducers: Iterable[Transducer],
    stamp: Any,
    base_link_frame: str,
) -> LaserScan:
    """A scan all round base_link (REP 117).

    Args:
        points: echoes (x, y); m.
        silent: transducers that hear nothing: infinity in their direction. Where no transducer looks there is NaN.
        transducers: of the robot.
        stamp: of the message.
        base_link_frame: of the message.
    """
    step = 2 * math.pi / BEAMS
    ranges = np.full(BEAMS, math.nan)
    for each in silent:
        ranges[_beam(each.x + NO_ECHO * math.cos(each.heading), each.y + NO_ECHO * math.sin(each.heading))] = math.inf
    for x, y in points:
        ranges[_beam(x, y)] = np.fmin(ranges[_beam(x, y)], math.hypot(x, y))    # the nearest echo; fmin passes over NaN
    return LaserScan(
        header=Header(stamp=stamp, frame_id=base_link_frame),
        angle_min=-math.pi,
        angle_max=math.pi - step,
        angle_increment=step,
        range_min=MIN_RANGE,
        range_max=NO_ECHO + max((math.hypot(each.x, each.y) for each in transducers), default=0.0),
        ranges=ranges.tolist(),
    )


def _beam(x: float, y: float) -> int:
    """The beam that goes through a point (m), or next to it."""
    return round((math.atan2(y, x) + math.pi) / (2 * math.pi) * BEAMS) % BEAMS
