"""Collectors keep the data of recorded messages that a `recorded_run.Run` needs.

The reader of a bag calls ``add(time, message)`` for each message of a topic. A collector has a limit of rows, texts or
spans, so its memory stays small however long the bag is. A longer bag gives coarser data.
"""

import heapq
import math
from array import array
from contextlib import suppress
from itertools import groupby
from typing import Any, Callable, Dict, Iterable, List, Optional, Sequence, Tuple

import numpy as np

from ..message_values import NO_ECHO, NOT_HEARD, GripStatus, heading_of
from ..vcc4 import field_of_view
from .recorded_run import ERROR, WARNING, GripperEvent, Look, Map, Report, Span

ROWS = 1 << 16
"""The largest number of rows that a `Thinned`, and of echoes that an `EchoCollector` keeps.

A `SilenceCollector` keeps the first so many periods."""
TEXTS = 1000
"""The largest number of cans that are kept. The limit for the gaps of one topic is twice this number.

The limit for warnings and errors is ten times this number."""
SPANS = 10000
"""A collector with more than twice this number of spans keeps only this number: the longest spans."""
LOOKED = 1.0  # s: a camera that looks somewhere for a shorter time is on its way
LOOKS = 12  # the largest number of looks of a camera that are kept
FARTHEST = 1e9  # m: a coordinate that is larger, or not a number, comes from damaged data
CHANGE_OF_PLACE = (0.01, 0.01, math.radians(1.0))  # m, m, rad: a robot that moved less is in the same place
CHANGE_OF_CAN = (0.002, 0.002, 0.002)  # m: x, y, height
CHANGE_OF_SPEED = (0.002, math.radians(0.2))  # m/s, rad/s
SILENCE = 3.0
"""How many median periods of its topic a silence must exceed to be a gap. It must also exceed `SHORTEST_GAP`."""
SHORTEST_GAP = 0.5
"""The time (s) that a silence must exceed to be a gap. It must also exceed `SILENCE` median periods."""
FEWEST = 10
"""A topic with fewer known periods than this has no gaps."""
ROS_LOG = ((8, ERROR), (4, WARNING))  # the lowest rosgraph_msgs/Log.level of an error, and of a warning


class Thinned:
    """Rows of numbers over time. A row that hardly differs from the last kept row is left out.

    A row is kept when one of its numbers differs from the last kept row by more than the tolerance of this number. Then
    the row just before it is kept too. When there are more than `ROWS` rows, every second row is dropped, and the
    tolerances double.

    Args:
        row_of: a function that returns the numbers of a message.
        tolerances: the tolerance of each number, in the unit of this number.
    """

    def __init__(self, row_of: Callable[[Any], Iterable[Any]], *tolerances: float) -> None:
        self._row_of = row_of
        self._tolerances = tolerances
        self._width = 1 + len(tolerances)
        self._rows = array("d")
        self._kept: Tuple[float, ...] = ()
        self._passed: Tuple[float, ...] = ()

    def add(self, time: float, message: Any) -> None:
        """Add a message that was recorded at `time` (s)."""
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
        """The columns (time in s, then each value) of the kept rows and of the last row, in order of time."""
        rows = np.concatenate((self._rows, self._passed)).reshape(-1, self._width)
        return rows[np.argsort(rows[:, 0], kind="stable")].T


def _every_second(rows: array, width: int) -> array:
    return array("d", np.array(rows).reshape(-1, width)[::2].tobytes())


def speed_of(twist: Any) -> Tuple[float, float]:
    """The speeds of a Twist: forward (m/s) and to the left (rad/s).

    Raises:
        ValueError: a speed is not a number, or impossibly large.
    """
    if not is_plausible(twist.linear.x, twist.angular.z):
        raise ValueError("no velocity")
    return twist.linear.x, twist.angular.z


class CommandCollector:
    """Keeps the velocities that were commanded: those of a person, and those of programs that were not locked out.

    Without messages of the topic ``helm`` all of them count.
    """

    def __init__(self) -> None:
        self._speeds = Thinned(speed_of, *CHANGE_OF_SPEED)
        self._locked_out = False

    def add(self, time: float, message: Any) -> None:
        """Add a Twist of a program that was recorded at `time` (s)."""
        if not self._locked_out:
            self._speeds.add(time, message)

    def add_of_person(self, time: float, message: Any) -> None:
        """Add a Twist of a person that was recorded at `time` (s)."""
        self._speeds.add(time, message)

    def add_helm(self, time: float, message: Any) -> None:
        """Add a Helm: who may command from `time` (s) on."""
        self._locked_out = bool(message.programs_locked_out)

    def columns(self) -> np.ndarray:
        """The columns of the kept rows: time (s), speed forward (m/s) and speed to the left (rad/s)."""
        return self._speeds.columns()


class OdometryCollector:
    """Keeps the poses and speeds in the nav_msgs/Odometry messages of one topic.

    Attributes:
        places: rows of time (s), x, y (m) and heading (rad). The heading does not jump from pi to -pi.
        speeds: rows of time (s), speed forward (m/s) and speed to the left (rad/s).
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
        """Add a message that was recorded at `time` (s)."""
        self.places.add(time, message.pose.pose)
        with suppress(ValueError):  # an implausible speed, of a robot that does not measure it
            self.speeds.add(time, message.twist.twist)


class EchoCollector:
    """Keeps the echoes in SonarArray messages.

    A driver repeats the reading of a transducer until there is a new one. Only the first of equal readings is kept. Of
    more than `ROWS` echoes only every second, then every fourth, ... is kept.

    Attributes:
        rows: time (s), number of the transducer, and range (m) of each kept echo, one after the other in a flat array.
    """

    def __init__(self) -> None:
        self.rows = array("d")
        self._share, self._count = 1, 0     # of all echoes so far (`_count`), each `_share`-th is kept
        self._ranges: Sequence[float] = ()

    def add(self, time: float, message: Any) -> None:
        """Add a message that was recorded at `time` (s)."""
        before, self._ranges = self._ranges, message.ranges
        for number, reading in enumerate(self._ranges):
            if NOT_HEARD < reading < NO_ECHO and reading not in before[number:number + 1]:
                self._count += 1
                if self._count % self._share == 0:
                    self.rows.extend((time, number, reading))
        if len(self.rows) > 3 * ROWS:
            self.rows = _every_second(self.rows, 3)
            self._share *= 2


def grip_of(message: Any) -> Tuple[int, bool]:
    """Return GripState.state of a GripperState message, and whether the gripper holds something.

    The gripper holds something when a paddle reports contact and a beam is broken. Contact alone is not enough,
    because paddles that close on nothing press on each other.
    """
    grip = message.grip
    return grip.state, (grip.left_contact or grip.right_contact) and (grip.inner_beam or grip.outer_beam)


def gripper_events(states: Iterable[Sequence[float]]) -> Tuple[GripperEvent, ...]:
    """Return what the paddles did: picked something up, put it down, or closed on nothing.

    Args:
        states: rows of time (s) and the two values that `grip_of` returns, in order of time.
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
            if was_closed is not None:  # None: the gripper held it before the recording began
                events.append(GripperEvent(time, "picked up"))
        elif closed and was_closed is False and not held:
            events.append(GripperEvent(time, "closed on nothing"))
    return tuple(events)


def looks_of(states: Sequence[Sequence[float]]) -> Tuple[Look, ...]:
    """Return where a camera looked: each direction and zoom that lasted for `LOOKED` s, of more than `LOOKS` the
    longest.

    Args:
        states: rows of time (s), pan (degrees, to the right) and zoom (steps), in order of time.
    """
    looks: List[Look] = []
    for (pan, zoom), rows in groupby(states, lambda row: tuple(row[1:])):
        times = [row[0] for row in rows]
        if times[-1] - times[0] >= LOOKED:
            looks.append(Look(times[0], times[-1], math.radians(-pan), field_of_view(zoom)))
    return tuple(sorted(heapq.nlargest(LOOKS, looks, key=lambda look: look.end - look.begin)))


class CanCollector:
    """Keeps the positions of the cans of a simulated world, from its PoseArray messages (map frame).

    The first message says how many cans there are. At most `TEXTS` cans are kept.

    Attributes:
        last: for each can its rows of time (s), x, y and height (m). None before the first message.
    """

    last: Optional[List[Thinned]] = None

    def add(self, time: float, message: Any) -> None:
        """Add a message that was recorded at `time` (s)."""
        if self.last is None:
            self.last = [Thinned(lambda place: (place.x, place.y, place.z), *CHANGE_OF_CAN)
                         for _ in message.poses[:TEXTS]]
        for can, pose in zip(self.last, message.poses):
            can.add(time, pose.position)


class LastCollector:
    """Keeps data of the last message only.

    Args:
        kept: a function that returns the data to keep of a message.

    Attributes:
        last: the data of the last message. None before the first message.
    """

    def __init__(self, kept: Callable[[Any], Any]) -> None:
        self._kept = kept
        self.last: Any = None

    def add(self, time: float, message: Any) -> None:
        """Add a message that was recorded at `time` (s)."""
        self.last = self._kept(message)


def map_of(message: Any) -> Map:
    """Convert an OccupancyGrid message to a `Map`."""
    info = message.info
    return Map(np.array(message.data, dtype=np.int8).reshape(info.height, info.width), info.resolution,
               (info.origin.position.x, info.origin.position.y, heading_in(info.origin.orientation)))


def told_of(info: Any) -> Dict[str, Any]:
    """Return the fields of a `recorded_run.Run` that a RobotInfo message gives: model, footprint and transducers.

    Points and poses that are not plausible are left out.
    """
    outline = [(point.x, point.y) for point in info.footprint.points if is_plausible(point.x, point.y)]
    looks = {number: (pose.x, pose.y, pose.theta) for number, pose in zip(info.sonar_numbers, info.sonar_poses)
             if is_plausible(pose.x, pose.y, pose.theta)}
    return dict(model=info.subtype, footprint=np.array(outline).reshape(-1, 2), transducers=looks)


def _longest(spans: List[Span], most: int) -> List[Span]:
    """Return all spans if there are at most 2 * `most`; if there are more, the `most` longest in order of time."""
    if len(spans) <= 2 * most:
        return spans
    return sorted(heapq.nlargest(most, spans, key=lambda span: span.end - span.begin))


class SpanCollector:
    """Keeps the spans of time in which the messages of a topic have the same text.

    A span ends at the first message with another text. An empty text makes no span.

    Args:
        words: a function that returns the text of a message, for example "left wheel". Empty for nothing to keep.

    Attributes:
        spans: the spans in order of time.
    """

    def __init__(self, words: Callable[[Any], str]) -> None:
        self._words = words
        self.spans: List[Span] = []
        self._what = ""

    def add(self, time: float, message: Any) -> None:
        """Add a message that was recorded at `time` (s)."""
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
    """Return which wheels are stalled in a Stall message: "left wheel", "both wheels", ...; empty if no wheel is."""
    return {(True, True): "both wheels", (True, False): "left wheel",
            (False, True): "right wheel"}.get((message.left, message.right), "")


def pressed(message: Any) -> str:
    """Return which bumper segments are pressed in a Bumpers message, for example "front 2, 3; rear 1".

    The first segment is number 1. Returns an empty text if no segment is pressed.
    """
    parts = {name: [str(number) for number, segment in enumerate(getattr(message, name), 1) if segment]
             for name in ("front", "rear")}
    return "; ".join("%s %s" % (name, ", ".join(segments)) for name, segments in parts.items() if segments)


def doing(message: Any) -> str:
    """Return the first word of the reason in a Decision message: "driving", "turning", ..."""
    return message.reason.replace(":", " ").partition(" ")[0] or "no reason"


class DecisionCollector(SpanCollector):
    """Keeps the spans of time in which the Decision messages of a wandering program have the same text.

    The last span of a wander ends with the last decision of this wander. The next wander begins a new span.
    """

    _wander = 0

    def add(self, time: float, message: Any) -> None:
        """Add a message that was recorded at `time` (s)."""
        if message.wander != self._wander:
            self._what = ""     # the last span of the previous wander is not extended
        self._wander = message.wander
        super().add(time, message)


class ReportCollector:
    """Keeps the warnings and errors on /diagnostics and /rosout.

    On /diagnostics a task is kept when its level changes to warning or error. On /rosout a warning or an error is kept
    when its text differs from the last one of its node. After 10 * `TEXTS` reports, the others are only counted.
    """

    def __init__(self) -> None:
        self._told: List[Tuple[str, Report]] = []    # with the node
        self._more = 0
        self._newest: Dict[str, Any] = {}   # the last level of each task, and the last text of each node on /rosout

    def add_diagnostics(self, time: float, message: Any) -> None:
        """Add the warnings and errors of a DiagnosticArray message that was recorded at `time` (s)."""
        for status in message.status:
            level = status.level if isinstance(status.level, int) else status.level[0]  # a byte in Python 3
            node, _, task = status.name.rpartition(": ")
            self._add(node, Report(time, level, task, status.message), status.name, level)

    def add_log(self, time: float, message: Any) -> None:
        """Add a Log message of /rosout that was recorded at `time` (s), if it is a warning or an error."""
        level = next((level for least, level in ROS_LOG if message.level >= least), 0)
        if level:
            report = Report(time, level, message.name, message.msg)
            self._add(message.name.strip("/"), report, message.name, message.msg)

    def _add(self, node: str, report: Report, source: str, newest: Any) -> None:
        """Keep a warning or an error of a node, unless it repeats the last one of its source.

        Args:
            node: name of the node, without slashes at its ends.
            report: the report. If its level is neither warning nor error, it is not kept.
            source: name of the diagnostics task, or of the node on /rosout.
            newest: the level of the task, or the text of the log message. The same value as last time is a repetition.
        """
        if report.level in (WARNING, ERROR) and newest != self._newest.get(source):
            if len(self._told) < 10 * TEXTS:
                self._told.append((node, report))
            else:
                self._more += 1
        self._newest[source] = newest

    def of(self, robot: str, robots: Sequence[str]) -> Tuple[Report, ...]:
        """Return the reports of the nodes of one robot, and of nodes that belong to no robot.

        Args:
            robot: namespace of the robot, without slashes at its ends.
            robots: namespaces of all robots in the bag.
        """
        mine = [report for node, report in self._told if _owner(node, robots) in (robot, "")]
        if self._more:
            mine.append(Report(mine[-1].time if mine else 0.0, WARNING, "",
                               "and %s more warnings and errors" % self._more))
        return tuple(mine)


def _owner(node: str, robots: Sequence[str]) -> str:
    """Return the robot with the longest namespace that contains a node; empty if no namespace contains it.

    A robot in the root namespace owns no nodes.
    """
    around = (robot for robot in robots if robot and node.startswith(robot + "/"))
    return max(around, key=len, default="")


class SilenceCollector:
    """Keeps the usual period of the messages of a topic, and the longest times without a message."""

    def __init__(self) -> None:
        self._last: Optional[float] = None
        self._periods = array("d")
        self._silences: List[Span] = []     # the longest

    def add(self, time: float, _: Any = None) -> None:
        """Add a message that was recorded at `time` (s)."""
        if self._last is not None:
            if len(self._periods) < ROWS:
                self._periods.append(time - self._last)
            if time - self._last > SHORTEST_GAP:
                self._silences = _longest([*self._silences, Span(self._last, time, "")], TEXTS)
        self._last = time

    def gaps(self, topic: str, end: float) -> List[Span]:
        """Return the spans without a message that are too long for this topic, see `SILENCE` and `SHORTEST_GAP`.

        Args:
            topic: name of the topic. Each span gets it as its text.
            end: time of the end of the recording (s).
        """
        if self._last is None or len(self._periods) < FEWEST:
            return []
        most = max(SHORTEST_GAP, SILENCE * float(np.median(self._periods)))
        return [Span(begin, until, topic) for begin, until, _ in [*self._silences, Span(self._last, end, "")]
                if until - begin > most]


def is_plausible(*values: float) -> bool:
    """Whether all values (m, rad, m/s or rad/s) are numbers that a robot can have: not NaN and not enormous."""
    return all(-FARTHEST < value < FARTHEST for value in values)


def heading_in(orientation: Any) -> float:
    """Return the heading (rad, counter-clockwise) in a Quaternion message."""
    return heading_of(orientation.x, orientation.y, orientation.z, orientation.w)
