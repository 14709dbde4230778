"""What is kept of the messages of a bag: for each kind of thing a class whose ``add(time, message)`` takes them.

Each keeps what is worth keeping. When that is more than `ROWS`, it becomes coarser.
"""

import heapq
import math
from array import array
from typing import Any, Callable, Dict, List, Optional, Sequence, Tuple

import numpy as np

from ..message_values import NO_ECHO, NOT_HEARD, GripStatus, heading_of
from .recorded_run import (ERROR, WARNING, CanPath, Echoes, GripperEvent, Map, RecordedDecision, Report, Series, Span,
                           Track, Velocities)

ROWS = 1 << 16
"""Rows that one thing keeps at most."""
TEXTS = 1000
"""Faults, cans, and gaps of a topic, kept at most."""
FARTHEST = 1e9  # m: what is beyond, or no number, is damage
CHANGE_OF_PLACE = (0.01, 0.01, math.radians(1.0))  # m, m, rad: less is the same place
CHANGE_OF_CAN = (0.002, 0.002, 0.002)  # m: x, y, height
CHANGE_OF_SPEED = (0.002, math.radians(0.2))  # m/s, rad/s
SILENCE = 3.0
"""Median periods without a message that are a gap, ..."""
SHORTEST_GAP = 0.5
"""... if they are so many seconds."""
FEWEST = 10
"""Messages from which on a topic has a period."""
ROS_LOG = ((8, ERROR), (4, WARNING))  # least rosgraph_msgs/Log.level of each


class Thinned:
    """Rows of numbers over time, without those that hardly differ from the one before.

    Kept are the rows that differ from the row kept before by more than a tolerance, and the row before each of them.
    """

    def __init__(self, *tolerances: float) -> None:
        self._tolerances = tolerances
        self._width = 1 + len(tolerances)
        self._rows = array("d")
        self._kept: Tuple[float, ...] = ()
        self._passed: Tuple[float, ...] = ()

    def add(self, time: float, *values: float) -> None:
        """Take a row."""
        for value, kept, most in zip(values, self._kept, self._tolerances):
            if not -most <= value - kept <= most:
                break
        else:
            if self._kept:
                self._passed = (time, *values)
                return
        self._rows.extend(self._passed)
        self._rows.extend((time, *values))
        self._kept, self._passed = values, ()
        if len(self._rows) > ROWS * self._width:
            self._rows = _every_second(self._rows, self._width)
            self._tolerances = tuple(2 * most for most in self._tolerances)

    def columns(self) -> np.ndarray:
        """The columns (time, values ...) of all rows kept and of the last, in order of time."""
        rows = np.concatenate((np.array(self._rows), np.array(self._passed))).reshape(-1, self._width)
        return rows[np.argsort(rows[:, 0], kind="stable")].T


def _every_second(rows: array, width: int) -> array:
    return array("d", np.array(rows).reshape(-1, width)[::2].reshape(-1).tobytes())


class Sampled:
    """Rows of numbers: all of them, or of so many one when they are more than `ROWS`."""

    def __init__(self, width: int) -> None:
        self.rows = array("d")
        self._width = width
        self._share, self._passed = 1, 0    # one of so many is kept; passed over since the last one

    def add(self, *row: float) -> None:
        """Take a row."""
        self._passed += 1
        if self._passed >= self._share:
            self._passed = 0
            self.rows.extend(row)
            if len(self.rows) > ROWS * self._width:
                self.rows = _every_second(self.rows, self._width)
                self._share *= 2


class VelocityCollector:
    """Velocities of geometry_msgs/Twist: what a robot was told, or measured."""

    def __init__(self) -> None:
        self._speeds = Thinned(*CHANGE_OF_SPEED)

    def add(self, time: float, message: Any) -> None:
        """Take in a message that came at a time (s)."""
        if not is_plausible(message.linear.x, message.angular.z):
            raise ValueError("no velocity")
        self._speeds.add(time, message.linear.x, message.angular.z)

    @property
    def velocities(self) -> Velocities:
        """The velocities that were taken in."""
        return Velocities(*self._speeds.columns())


class OdometryCollector(VelocityCollector):
    """Where a robot was and how fast, of nav_msgs/Odometry."""

    def __init__(self) -> None:
        super().__init__()
        self._places = Thinned(*CHANGE_OF_PLACE)
        self._heading = 0.0

    def add(self, time: float, message: Any) -> None:
        """Take in a message that came at a time (s)."""
        place, heading = message.pose.pose.position, heading_in(message.pose.pose.orientation)
        if not is_plausible(place.x, place.y, heading):
            raise ValueError("no place")
        # without jumps at half a turn
        self._heading = heading + math.tau * round((self._heading - heading) / math.tau)
        self._places.add(time, place.x, place.y, self._heading)
        speed = message.twist.twist
        if is_plausible(speed.linear.x, speed.angular.z):
            self._speeds.add(time, speed.linear.x, speed.angular.z)

    @property
    def track(self) -> Optional[Track]:
        """The poses that were taken in; None if there were none."""
        columns = self._places.columns()
        return Track(*columns) if columns.size else None


class ValueCollector:
    """A field of a message over time."""

    def __init__(self, field: str, tolerance: float) -> None:
        self._field = field
        self._values = Thinned(tolerance)

    def add(self, time: float, message: Any) -> None:
        """Take in a message that came at a time (s)."""
        self._values.add(time, float(getattr(message, self._field)))

    @property
    def series(self) -> Series:
        """The values over time."""
        return Series(*self._values.columns())

    @property
    def changes(self) -> Series:
        """Only the first, those that differ from the one before, and the last."""
        time, value = self._values.columns()
        chosen = np.ones(len(time), dtype=bool)
        chosen[1:-1] = value[1:-1] != value[:-2]
        return Series(time[chosen], value[chosen])


class EchoCollector:
    """What the sonar heard, of SonarArray: a driver repeats each reading until its transducer's next turn."""

    def __init__(self) -> None:
        self._readings = Sampled(3)
        self._ranges: Sequence[float] = ()

    def add(self, time: float, message: Any) -> None:
        """Take in a message that came at a time (s)."""
        before, self._ranges = self._ranges, message.ranges
        if before == self._ranges:
            return
        for number, reading in enumerate(self._ranges):
            if NOT_HEARD < reading < NO_ECHO and not (number < len(before) and before[number] == reading):
                self._readings.add(time, number, reading)

    @property
    def echoes(self) -> Echoes:
        """All echoes."""
        return Echoes(*np.array(self._readings.rows).reshape(-1, 3).T)


class GripperCollector:
    """What the paddles did, of GripperState."""

    def __init__(self) -> None:
        self._states = Thinned(0.5, 0.5)

    def add(self, time: float, message: Any) -> None:
        """Take in a message that came at a time (s)."""
        grip = message.grip
        pressed, seen = grip.left_contact or grip.right_contact, grip.inner_beam or grip.outer_beam
        self._states.add(time, grip.state, pressed and seen)    # paddles that close on nothing press on each other

    @property
    def events(self) -> Tuple[GripperEvent, ...]:
        """What the paddles did, in order of time."""
        return gripper_events([(time, int(state), bool(feels)) for time, state, feels in self._states.columns().T])


def gripper_events(states: Sequence[Tuple[float, int, bool]]) -> Tuple[GripperEvent, ...]:
    """What the paddles did.

    Args:
        states: (time in s, GripState.state, whether a paddle presses on something that is in a beam), in order of time.
    """
    events: List[GripperEvent] = []
    held, closed = False, None
    for time, state, feels in states:
        was_closed, closed = closed, state == GripStatus.CLOSED
        if held and not feels:
            held = False
            events.append(GripperEvent(time, "put down"))
        elif not held and feels and closed:
            held = True
            if was_closed is not None:  # else it was held before the recording began
                events.append(GripperEvent(time, "picked up"))
        elif closed and was_closed is False and not held:
            events.append(GripperEvent(time, "closed on nothing"))
    return tuple(events)


class CanCollector:
    """Where each can was, of a simulated world's PoseArray: those of the first message."""

    def __init__(self) -> None:
        self.last: Any = None
        self._cans: List[Thinned] = []

    def add(self, time: float, message: Any) -> None:
        """Take in a message that came at a time (s)."""
        if self.last is None:
            self._cans = [Thinned(*CHANGE_OF_CAN) for _ in message.poses[:TEXTS]]
        self.last = message
        for can, pose in zip(self._cans, message.poses):
            can.add(time, pose.position.x, pose.position.y, pose.position.z)

    @property
    def paths(self) -> Tuple[CanPath, ...]:
        """The path of each can."""
        return tuple(CanPath(*can.columns()) for can in self._cans)


class LastCollector:
    """The last message."""

    last: Any = None

    def add(self, time: float, message: Any) -> None:
        """Take in a message that came at a time (s)."""
        self.last = message


class MapCollector(LastCollector):
    """The last OccupancyGrid, as a Map."""

    def add(self, time: float, message: Any) -> None:
        """Take in a message that came at a time (s)."""
        info = message.info
        corner = (info.origin.position.x, info.origin.position.y, heading_in(info.origin.orientation))
        self.last = Map(np.array(message.data, dtype=np.int8).reshape(info.height, info.width), info.resolution, corner)


class SpanCollector:
    """Spans of time in which words of a message are not empty: they last until the words change."""

    def __init__(self, words: Callable[[Any], str]) -> None:
        self._words = words
        self._spans: List[Span] = []
        self._what = ""

    def add(self, time: float, message: Any) -> None:
        """Take in a message that came at a time (s)."""
        what = self._words(message)
        if self._what:
            self._spans[-1] = self._spans[-1]._replace(end=time)
        if what and what != self._what:
            self._spans.append(Span(time, time, what))
        self._what = what
        if len(self._spans) > 2 * TEXTS:    # the longest of them
            self._spans = sorted(heapq.nlargest(TEXTS, self._spans, key=lambda span: span.end - span.begin))
            self._what = ""

    @property
    def spans(self) -> Tuple[Span, ...]:
        """The spans, in order of time."""
        return tuple(self._spans)


def stalled(message: Any) -> str:
    """Which wheels are stalled."""
    return {(True, True): "both wheels", (True, False): "left wheel",
            (False, True): "right wheel"}.get((message.left, message.right), "")


def pressed(message: Any) -> str:
    """Which segments of the bumpers are pressed, numbered from 1."""
    parts = {name: [str(number) for number, segment in enumerate(getattr(message, name), 1) if segment]
             for name in ("front", "rear")}
    return "; ".join("%s %s" % (name, ", ".join(segments)) for name, segments in parts.items() if segments)


class DecisionCollector:
    """What a program decided: where its reason changes, and the first and the last of each wander."""

    def __init__(self) -> None:
        self._kept: List[RecordedDecision] = []
        self._last: Optional[RecordedDecision] = None

    def add(self, time: float, message: Any) -> None:
        """Take in a message that came at a time (s)."""
        last = self._last
        self._last = RecordedDecision(time, message.header.stamp.to_sec(), message.wander, message.reason)
        if last is not None and last.wander != message.wander and self._kept[-1] is not last:
            self._kept.append(last)
        if last is None or (last.wander, last.reason) != (message.wander, message.reason):
            self._kept.append(self._last)
        if len(self._kept) > 10 * TEXTS:
            self._kept = self._kept[::2]

    @property
    def decisions(self) -> Tuple[RecordedDecision, ...]:
        """The decisions that are kept, in order of time."""
        last = [self._last] if self._last is not None and self._kept[-1] is not self._last else []
        return tuple(self._kept + last)


class ReportCollector:
    """What went wrong: of /diagnostics, where a level gets worse or turns to another one, and of /rosout."""

    def __init__(self) -> None:
        self._told: List[Tuple[str, Report]] = []    # with the node
        self._more = 0
        self._levels: Dict[str, int] = {}
        self._words: Dict[str, str] = {}

    def add_diagnostics(self, time: float, message: Any) -> None:
        """Take in a DiagnosticArray."""
        for status in message.status:
            level = status.level if isinstance(status.level, int) else status.level[0]  # a byte in Python 3
            if level in (WARNING, ERROR) and level != self._levels.get(status.name):
                node, _, task = status.name.rpartition(": ")
                self._add(node, Report(time, level, task, status.message))
            self._levels[status.name] = level

    def add_log(self, time: float, message: Any) -> None:
        """Take in a Log of /rosout."""
        level = next((level for least, level in ROS_LOG if message.level >= least), 0)
        if level and self._words.get(message.name) != message.msg:
            self._words[message.name] = message.msg
            self._add(message.name.strip("/"), Report(time, level, message.name, message.msg))

    def _add(self, node: str, report: Report) -> None:
        if len(self._told) < 10 * TEXTS:
            self._told.append((node, report))
        else:
            self._more += 1

    def of(self, robot: str, robots: Sequence[str]) -> Tuple[Report, ...]:
        """Reports of a robot's nodes, and of nodes that belong to no robot."""
        mine = [report for node, report in self._told if _owner(node, robots) in (robot, None)]
        if self._more:
            mine.append(Report(mine[-1].time if mine else 0.0, WARNING, "",
                               "and %s more warnings and errors" % self._more))
        return tuple(mine)


def _owner(node: str, robots: Sequence[str]) -> Optional[str]:
    """The innermost robot in whose namespace a node is; None: no robot. A robot without a name has no nodes."""
    around = sorted((robot for robot in robots if robot and node.startswith(robot + "/")), key=len)
    return around[-1] if around else None


class SilenceCollector:
    """How regularly a topic comes, and where it does not."""

    def __init__(self) -> None:
        self._last: Optional[float] = None
        self._periods = Sampled(1)
        self._silences: List[Tuple[float, float, float]] = []   # the longest: length, begin, end

    def add(self, time: float, _: Any = None) -> None:
        """Take in the time (s) of a message."""
        last, self._last = self._last, time
        if last is None:
            return
        self._periods.add(time - last)
        if time - last > SHORTEST_GAP:
            self._keep(last, time)

    def _keep(self, begin: float, end: float) -> None:
        keep = heapq.heappush if len(self._silences) < TEXTS else heapq.heappushpop
        keep(self._silences, (end - begin, begin, end))

    def gaps(self, topic: str, end: float) -> List[Span]:
        """Gaps of this topic until the recording's end (s)."""
        if self._last is None or len(self._periods.rows) < FEWEST:
            return []
        self._keep(self._last, end)
        most = max(SHORTEST_GAP, SILENCE * float(np.median(np.array(self._periods.rows))))
        return sorted(Span(begin, end, topic) for length, begin, end in self._silences if length > most)


def is_plausible(*values: float) -> bool:
    """Whether these can be m or rad, or that each second."""
    return all(-FARTHEST < value < FARTHEST for value in values)


def heading_in(orientation: Any) -> float:
    """Heading of a quaternion message, in rad."""
    return heading_of(orientation.x, orientation.y, orientation.z, orientation.w)
