"""Collectors: each takes the messages of a topic one after the other, by ``add(time, message)``, and keeps what counts.

However long a bag is, no collector keeps more than some number of rows, texts or spans. What is longer becomes coarser.
"""

import heapq
import math
from array import array
from contextlib import suppress
from typing import Any, Callable, Dict, Iterable, List, Optional, Sequence, Tuple

import numpy as np

from ..message_values import NO_ECHO, NOT_HEARD, GripStatus, heading_of
from .recorded_run import ERROR, WARNING, GripperEvent, Map, Report, Span

ROWS = 1 << 16
"""Rows that one collector keeps at most."""
TEXTS = 1000
"""Cans that are kept at most. Of the gaps of a topic they may be twice as many, of faults ten times."""
SPANS = 10000
"""Spans of one kind that are always kept. When there are twice as many, so many of them stay, the longest."""
FARTHEST = 1e9  # m: a place that is farther away, or not a number, is damage
CHANGE_OF_PLACE = (0.01, 0.01, math.radians(1.0))  # m, m, rad: a robot that moved less is in the same place
CHANGE_OF_CAN = (0.002, 0.002, 0.002)  # m: x, y, height
CHANGE_OF_SPEED = (0.002, math.radians(0.2))  # m/s, rad/s
SILENCE = 3.0
"""A silence is a gap when it is longer than so many median periods of its topic, ..."""
SHORTEST_GAP = 0.5
"""... and longer than so many seconds."""
FEWEST = 10
"""A topic of which fewer periods are known has no gaps."""
ROS_LOG = ((8, ERROR), (4, WARNING))  # the least rosgraph_msgs/Log.level that is one


class Thinned:
    """Rows of numbers over time, without those that hardly differ from the row kept before.

    A row is kept when one of its numbers differs from the row kept before by more than its tolerance. Then the row
    before it is kept too.

    Args:
        row_of: gives the numbers of a message.
        tolerances: one for each number.
    """

    def __init__(self, row_of: Callable[[Any], Iterable[Any]], *tolerances: float) -> None:
        self._row_of = row_of
        self._tolerances = tolerances
        self._width = 1 + len(tolerances)
        self._rows = array("d")
        self._kept: Tuple[float, ...] = ()
        self._passed: Tuple[float, ...] = ()

    def add(self, time: float, message: Any) -> None:
        """Take in a message that came at a time (s)."""
        values = tuple(map(float, self._row_of(message)))
        if self._kept and all(-most <= value - kept <= most
                              for value, kept, most in zip(values, self._kept, self._tolerances)):
            self._passed = (time, *values)
            return
        self._rows.extend((*self._passed, time, *values))
        self._kept, self._passed = values, ()
        if len(self._rows) > ROWS * self._width:
            self._rows = _every_second(self._rows, self._width)
            self._tolerances = tuple(2 * most for most in self._tolerances)

    def columns(self) -> np.ndarray:
        """The columns (time, values ...) of all rows kept and of the last, in order of time."""
        rows = np.concatenate((self._rows, self._passed)).reshape(-1, self._width)
        return rows[np.argsort(rows[:, 0], kind="stable")].T


def _every_second(rows: array, width: int) -> array:
    return array("d", np.array(rows).reshape(-1, width)[::2].tobytes())


class Sampled:
    """Rows of numbers: all of them, or one of so many when they are more than `ROWS`.

    Attributes:
        rows: their numbers, one row after the other.
    """

    def __init__(self, width: int) -> None:
        self.rows = array("d")
        self._width = width
        self._share = 1     # one of so many is kept
        self._count = 0

    def keep(self, *row: float) -> None:
        """Take a row."""
        self._count += 1
        if self._count % self._share == 0:
            self.rows.extend(row)
        if len(self.rows) > ROWS * self._width:
            self.rows = _every_second(self.rows, self._width)
            self._share *= 2


def speed_of(twist: Any) -> Tuple[float, float]:
    """The speeds of a Twist, forward (m/s) and to the left (rad/s). Raises ValueError when no robot can be so fast."""
    if not is_plausible(twist.linear.x, twist.angular.z):
        raise ValueError("no velocity")
    return twist.linear.x, twist.angular.z


class OdometryCollector:
    """Where a robot was and how fast, of nav_msgs/Odometry.

    Attributes:
        places: rows of time (s), x, y (m), and heading (rad), which does not jump at half a turn.
        speeds: rows of time (s), forward (m/s), and to the left (rad/s).
    """

    def __init__(self) -> None:
        self.places = Thinned(self._place_of, *CHANGE_OF_PLACE)
        self.speeds = Thinned(speed_of, *CHANGE_OF_SPEED)
        self._heading = 0.0

    def _place_of(self, pose: Any) -> Tuple[float, float, float]:
        place, heading = pose.position, heading_in(pose.orientation)
        if not is_plausible(place.x, place.y, heading):
            raise ValueError("no place")
        self._heading = heading + math.tau * round((self._heading - heading) / math.tau)
        return place.x, place.y, self._heading

    def add(self, time: float, message: Any) -> None:
        """Take in a message that came at a time (s)."""
        self.places.add(time, message.pose.pose)
        with suppress(ValueError):  # of a robot that does not measure its speed
            self.speeds.add(time, message.twist.twist)


class EchoCollector(Sampled):
    """What the sonar heard, of SonarArray: rows of time (s), number of the transducer, and range (m).

    A driver repeats each reading until its transducer's next turn. Only the first is kept.
    """

    def __init__(self) -> None:
        super().__init__(3)
        self._ranges: Sequence[float] = ()

    def add(self, time: float, message: Any) -> None:
        """Take in a message that came at a time (s)."""
        before, self._ranges = self._ranges, message.ranges
        for number, reading in enumerate(self._ranges):
            if NOT_HEARD < reading < NO_ECHO and reading not in before[number:number + 1]:
                self.keep(time, number, reading)


def grip_of(message: Any) -> Tuple[int, bool]:
    """Of a GripperState: GripState.state, and whether a paddle presses on something that is in a beam.

    Paddles that close on nothing press on each other.
    """
    grip = message.grip
    return grip.state, (grip.left_contact or grip.right_contact) and (grip.inner_beam or grip.outer_beam)


def gripper_events(states: Iterable[Sequence[float]]) -> Tuple[GripperEvent, ...]:
    """What the paddles did.

    Args:
        states: time (s) and what `grip_of` gives, in order of time.
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
    """Where the cans of a simulated world were, of its PoseArray. The cans are those of the first message.

    Attributes:
        last: the rows (time in s; x, y, height in m) of each can; None before the first message.
    """

    last: Optional[List[Thinned]] = None

    def add(self, time: float, message: Any) -> None:
        """Take in a message that came at a time (s)."""
        if self.last is None:
            self.last = [Thinned(lambda place: (place.x, place.y, place.z), *CHANGE_OF_CAN)
                         for _ in message.poses[:TEXTS]]
        for can, pose in zip(self.last, message.poses):
            can.add(time, pose.position)


class LastCollector:
    """The last message.

    Args:
        kept: gives what is kept of a message.

    Attributes:
        last: what is kept of the last message; None before the first.
    """

    def __init__(self, kept: Callable[[Any], Any]) -> None:
        self._kept = kept
        self.last: Any = None

    def add(self, time: float, message: Any) -> None:
        """Take in a message that came at a time (s)."""
        self.last = self._kept(message)


def map_of(message: Any) -> Map:
    """An OccupancyGrid as a Map."""
    info = message.info
    return Map(np.array(message.data, dtype=np.int8).reshape(info.height, info.width), info.resolution,
               (info.origin.position.x, info.origin.position.y, heading_in(info.origin.orientation)))


def told_of(info: Any) -> Dict[str, Any]:
    """What a RobotInfo tells of a robot, by the fields of a Run."""
    outline = [(point.x, point.y) for point in info.footprint.points if is_plausible(point.x, point.y)]
    looks = {number: (pose.x, pose.y, pose.theta) for number, pose in zip(info.sonar_numbers, info.sonar_poses)
             if is_plausible(pose.x, pose.y, pose.theta)}
    return dict(model=info.subtype, footprint=np.array(outline).reshape(-1, 2), transducers=looks)


def _longest(spans: List[Span], most: int) -> List[Span]:
    """The spans; where they are more than twice as many as `most`, the longest of them, in order of time."""
    if len(spans) <= 2 * most:
        return spans
    return sorted(heapq.nlargest(most, spans, key=lambda span: span.end - span.begin))


class SpanCollector:
    """Spans of time in which messages say something. Each lasts until the words change.

    Args:
        words: gives the words of a message; empty where it says nothing.

    Attributes:
        spans: in order of time.
    """

    def __init__(self, words: Callable[[Any], str]) -> None:
        self._words = words
        self.spans: List[Span] = []
        self._what = ""

    def add(self, time: float, message: Any) -> None:
        """Take in a message that came at a time (s)."""
        what = self._words(message)
        if self._what:
            self.spans[-1] = self.spans[-1]._replace(end=time)
        if what and what != self._what:
            self.spans.append(Span(time, time, what))
        self._what = what
        if len(self.spans) > 2 * SPANS:
            self.spans = _longest(self.spans, SPANS)
            self._what = ""


def stalled(message: Any) -> str:
    """Which wheels a Stall says are stalled; empty where none is."""
    return {(True, True): "both wheels", (True, False): "left wheel",
            (False, True): "right wheel"}.get((message.left, message.right), "")


def pressed(message: Any) -> str:
    """Which segments of the bumpers are pressed, numbered from 1; empty where none is."""
    parts = {name: [str(number) for number, segment in enumerate(getattr(message, name), 1) if segment]
             for name in ("front", "rear")}
    return "; ".join("%s %s" % (name, ", ".join(segments)) for name, segments in parts.items() if segments)


def doing(message: Any) -> str:
    """What a Decision is about: the first word of its reason, "driving", "turning", ..."""
    return message.reason.replace(":", " ").partition(" ")[0] or "no reason"


class DecisionCollector(SpanCollector):
    """Spans of what a program decided: a decision holds until the next one of its wander."""

    _wander = 0

    def add(self, time: float, message: Any) -> None:
        """Take in a message that came at a time (s)."""
        if message.wander != self._wander:
            self._what = ""     # the last decision of the wander before ends with that wander
        self._wander = message.wander
        super().add(time, message)


class ReportCollector:
    """Warnings and errors: of /diagnostics where a task's level becomes one, of /rosout where a node says a new one."""

    def __init__(self) -> None:
        self._told: List[Tuple[str, Report]] = []    # with the node
        self._more = 0
        self._newest: Dict[str, Any] = {}   # level of each task of /diagnostics, words of each node of /rosout

    def add_diagnostics(self, time: float, message: Any) -> None:
        """Take in a DiagnosticArray."""
        for status in message.status:
            level = status.level if isinstance(status.level, int) else status.level[0]  # a byte in Python 3
            node, _, task = status.name.rpartition(": ")
            self._add(node, Report(time, level, task, status.message), status.name, level)

    def add_log(self, time: float, message: Any) -> None:
        """Take in a Log of /rosout."""
        level = next((level for least, level in ROS_LOG if message.level >= least), 0)
        if level:
            report = Report(time, level, message.name, message.msg)
            self._add(message.name.strip("/"), report, message.name, message.msg)

    def _add(self, node: str, report: Report, source: str, newest: Any) -> None:
        """Keep a warning or an error of a node, unless its source said the same last time."""
        if report.level in (WARNING, ERROR) and newest != self._newest.get(source):
            if len(self._told) < 10 * TEXTS:
                self._told.append((node, report))
            else:
                self._more += 1
        self._newest[source] = newest

    def of(self, robot: str, robots: Sequence[str]) -> Tuple[Report, ...]:
        """Reports of a robot's nodes, and of nodes that belong to no robot."""
        mine = [report for node, report in self._told if _owner(node, robots) in (robot, "")]
        if self._more:
            mine.append(Report(mine[-1].time if mine else 0.0, WARNING, "",
                               "and %s more warnings and errors" % self._more))
        return tuple(mine)


def _owner(node: str, robots: Sequence[str]) -> str:
    """The innermost robot in whose namespace a node is; empty where there is none. One without a name has no nodes."""
    around = (robot for robot in robots if robot and node.startswith(robot + "/"))
    return max(around, key=len, default="")


class SilenceCollector:
    """How regularly the messages of a topic come, and when they do not."""

    def __init__(self) -> None:
        self._last: Optional[float] = None
        self._periods = Sampled(1)
        self._silences: List[Span] = []     # the longest

    def add(self, time: float, _: Any = None) -> None:
        """Take in the time (s) of a message."""
        if self._last is not None:
            self._periods.keep(time - self._last)
            if time - self._last > SHORTEST_GAP:
                self._silences = _longest([*self._silences, Span(self._last, time, "")], TEXTS)
        self._last = time

    def gaps(self, topic: str, end: float) -> List[Span]:
        """The gaps in this topic until the recording's end (s)."""
        if self._last is None or len(self._periods.rows) < FEWEST:
            return []
        most = max(SHORTEST_GAP, SILENCE * float(np.median(np.array(self._periods.rows))))
        return [Span(begin, until, topic) for begin, until, _ in [*self._silences, Span(self._last, end, "")]
                if until - begin > most]


def is_plausible(*values: float) -> bool:
    """Whether these can be places (m), angles (rad), or speeds (m/s, rad/s) of a robot."""
    return all(-FARTHEST < value < FARTHEST for value in values)


def heading_in(orientation: Any) -> float:
    """Heading of a quaternion message, in rad."""
    return heading_of(orientation.x, orientation.y, orientation.z, orientation.w)
