"""What is kept of the messages of a bag: for each kind of thing a small class that takes its messages one by one, ``add(time, message)``, and keeps
what is worth keeping. When that is more than `ROWS`, it becomes coarser.
"""

import heapq
import math
from array import array
from typing import Any, Callable, Dict, List, Optional, Sequence, Tuple

import numpy as np

from ..message_values import NO_ECHO, NOT_HEARD, heading_of
from .run import ERROR, WARNING, Decision, Gap, Happening, Map, Series, Sonar, Span, Track, Velocities, gripper_events

ROWS = 1 << 16
"""Rows that one thing keeps at most."""
TEXTS = 1000
"""Faults, and gaps of a topic, kept at most."""
FARTHEST = 1e9  # m: what is beyond, or no number, is damage
CHANGE_OF_PLACE = (0.01, 0.01, math.radians(1.0))  # m, m, rad: less is the same place
CHANGE_OF_SPEED = (0.002, math.radians(0.2))  # m/s, rad/s
SILENCE = 3.0
"""Median periods without a message that are a gap, ..."""
SHORTEST_GAP = 0.5
"""... if they are so many seconds."""
FEWEST = 10
"""Messages from which on a topic has a period."""
ROS_LOG = ((8, ERROR), (4, WARNING))  # rosgraph_msgs/Log.level from which on it is which


class Thinned:
    """Rows of numbers over time: those that differ from the row kept before by more than tolerances, and the row before each of them."""

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


class Odometry:
    """Where a robot was and how fast, of nav_msgs/Odometry."""

    def __init__(self) -> None:
        self._places = Thinned(*CHANGE_OF_PLACE)
        self._speeds = Thinned(*CHANGE_OF_SPEED)
        self._heading = 0.0

    def add(self, time: float, message: Any) -> None:
        place, speed = message.pose.pose.position, message.twist.twist
        heading = _heading(message.pose.pose.orientation)
        if not are_places(place.x, place.y, heading):
            raise ValueError("no place")
        self._heading = heading + math.tau * round((self._heading - heading) / math.tau)    # without jumps at half a turn
        self._places.add(time, place.x, place.y, self._heading)
        if are_places(speed.linear.x, speed.angular.z):
            self._speeds.add(time, speed.linear.x, speed.angular.z)

    @property
    def track(self) -> Optional[Track]:
        columns = self._places.columns()
        return Track(*columns) if columns.size else None

    @property
    def velocities(self) -> Velocities:
        return Velocities(*self._speeds.columns())


class Commands:
    """What a robot was told to do, of geometry_msgs/Twist."""

    def __init__(self) -> None:
        self._speeds = Thinned(*CHANGE_OF_SPEED)

    def add(self, time: float, message: Any) -> None:
        if not are_places(message.linear.x, message.angular.z):
            raise ValueError("no velocity")
        self._speeds.add(time, message.linear.x, message.angular.z)

    @property
    def velocities(self) -> Velocities:
        return Velocities(*self._speeds.columns())


class Values:
    """A field of a message over time."""

    def __init__(self, field: str, tolerance: float) -> None:
        self._field = field
        self._values = Thinned(tolerance)

    def add(self, time: float, message: Any) -> None:
        self._values.add(time, float(getattr(message, self._field)))

    @property
    def series(self) -> Series:
        return Series(*self._values.columns())

    @property
    def changes(self) -> Series:
        """Only the first, those that differ from the one before, and the last."""
        time, value = self._values.columns()
        chosen = np.ones(len(time), dtype=bool)
        chosen[1:-1] = value[1:-1] != value[:-2]
        return Series(time[chosen], value[chosen])


class Echoes:
    """What the sonar heard, of SonarArray: a driver repeats each reading until its transducer's next turn."""

    def __init__(self) -> None:
        self._rows = array("d")
        self._ranges: Sequence[float] = ()
        self._share = 1     # of so many new readings one is kept
        self._passed = 0

    def add(self, time: float, message: Any) -> None:
        before, self._ranges = self._ranges, message.ranges
        if before == self._ranges:
            return
        for number, reading in enumerate(self._ranges):
            if NOT_HEARD < reading < NO_ECHO and not (number < len(before) and before[number] == reading):
                self._passed += 1
                if self._passed >= self._share:
                    self._passed = 0
                    self._rows.extend((time, number, reading))
        if len(self._rows) > 3 * ROWS:
            self._rows = _every_second(self._rows, 3)
            self._share *= 2

    @property
    def sonar(self) -> Sonar:
        return Sonar(*np.array(self._rows).reshape(-1, 3).T)


class Gripper:
    """What the paddles did, of GripperState."""

    def __init__(self) -> None:
        self._states = Thinned(0.5, 0.5)

    def add(self, time: float, message: Any) -> None:
        grip = message.grip
        pressed, seen = grip.left_contact or grip.right_contact, grip.inner_beam or grip.outer_beam
        self._states.add(time, grip.state, pressed and seen)    # paddles that close on nothing press on each other

    @property
    def events(self):
        return gripper_events([(time, int(state), bool(feels)) for time, state, feels in self._states.columns().T])


class Ends:
    """The first message and the last."""

    def __init__(self) -> None:
        self.first: Any = None
        self.last: Any = None

    def add(self, time: float, message: Any) -> None:
        self.first = self.first or message
        self.last = message

    @property
    def both(self) -> List[Any]:
        return [] if self.last is None else [self.first] if self.last is self.first else [self.first, self.last]


class Grid:
    """The last OccupancyGrid."""

    def __init__(self) -> None:
        self.last: Optional[Map] = None

    def add(self, time: float, message: Any) -> None:
        info = message.info
        corner = (info.origin.position.x, info.origin.position.y, _heading(info.origin.orientation))
        self.last = Map(np.array(message.data, dtype=np.int8).reshape(info.height, info.width), info.resolution, corner)


class Spans:
    """While words of a message are not empty: they last until they change."""

    def __init__(self, words: Callable[[Any], str]) -> None:
        self._words = words
        self._spans: List[Span] = []
        self._what = ""

    def add(self, time: float, message: Any) -> None:
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
        return tuple(self._spans)


def stalled(message: Any) -> str:
    """Which wheels are stalled."""
    return {(True, True): "both wheels", (True, False): "left wheel", (False, True): "right wheel"}.get((message.left, message.right), "")


def pressed(message: Any) -> str:
    """Which segments of the bumpers are pressed, numbered from 1."""
    parts = []
    for name in ("front", "rear"):
        segments = [str(number) for number, segment in enumerate(getattr(message, name), 1) if segment]
        if segments:
            parts.append("%s %s" % (name, ", ".join(segments)))
    return "; ".join(parts)


class Decisions:
    """What a program decided: where its reason changes, and the first and the last of each wander."""

    def __init__(self) -> None:
        self._kept: List[Decision] = []
        self._last: Optional[Decision] = None

    def add(self, time: float, message: Any) -> None:
        last = self._last
        self._last = Decision(time, message.header.stamp.to_sec(), message.wander, message.seed, message.speed,
                              message.linear, message.angular, message.reason)
        if last is not None and last.wander != message.wander and self._kept[-1] is not last:
            self._kept.append(last)
        if last is None or (last.wander, last.reason) != (message.wander, message.reason):
            self._kept.append(self._last)
        if len(self._kept) > 10 * TEXTS:
            self._kept = self._kept[::2]

    @property
    def decisions(self) -> Tuple[Decision, ...]:
        last = [self._last] if self._last is not None and self._kept[-1] is not self._last else []
        return tuple(self._kept + last)


class Faults:
    """What went wrong, of /diagnostics, where a level gets worse or turns to another one, and of /rosout: with the node that said so."""

    def __init__(self) -> None:
        self._told: List[Tuple[str, Happening]] = []    # with the node
        self._more = 0
        self._levels: Dict[str, int] = {}
        self._words: Dict[str, str] = {}

    def add_diagnostics(self, time: float, message: Any) -> None:
        for status in message.status:
            level = status.level if isinstance(status.level, int) else status.level[0]  # a byte in Python 3
            if level in (WARNING, ERROR) and level != self._levels.get(status.name):
                node, _, task = status.name.rpartition(": ")
                self._add(node, Happening(time, level, task, status.message))
            self._levels[status.name] = level

    def add_log(self, time: float, message: Any) -> None:
        level = next((level for least, level in ROS_LOG if message.level >= least), 0)
        if level and self._words.get(message.name) != message.msg:
            self._words[message.name] = message.msg
            self._add(message.name.strip("/"), Happening(time, level, message.name, message.msg))

    def _add(self, node: str, happening: Happening) -> None:
        if len(self._told) < 10 * TEXTS:
            self._told.append((node, happening))
        else:
            self._more += 1

    def of(self, robot: str, robots: Sequence[str]) -> Tuple[Happening, ...]:
        """Those of a robot, and those of nodes that belong to none."""
        mine = [happening for node, happening in self._told if _owner(node, robots) in (robot, None)]
        if self._more:
            mine.append(Happening(mine[-1].time if mine else 0.0, WARNING, "", "and %s more warnings and errors" % self._more))
        return tuple(mine)


def _owner(node: str, robots: Sequence[str]) -> Optional[str]:
    """The robot in whose namespace a node is: the innermost; None if there is none. The root is nobody's when others have names."""
    inside = [robot for robot in robots if robot and node.startswith(robot + "/")]
    return max(inside, key=len, default=None)


class Rhythm:
    """How regularly a topic comes."""

    def __init__(self) -> None:
        self._last: Optional[float] = None
        self._periods = array("d")      # every so many-th
        self._every, self._passed = 1, 0
        self._silences: List[Tuple[float, float, float]] = []   # the longest: length, begin, end

    def add(self, time: float, _: Any = None) -> None:
        last, self._last = self._last, time
        if last is None:
            return
        self._passed += 1
        if self._passed >= self._every:
            self._passed = 0
            self._periods.append(time - last)
            if len(self._periods) > ROWS:
                self._periods = _every_second(self._periods, 1)
                self._every *= 2
        if time - last > SHORTEST_GAP:
            self._keep(last, time)

    def _keep(self, begin: float, end: float) -> None:
        keep = heapq.heappush if len(self._silences) < TEXTS else heapq.heappushpop
        keep(self._silences, (end - begin, begin, end))

    def gaps(self, topic: str, end: float) -> List[Gap]:
        """Its gaps until the recording's end."""
        if len(self._periods) < FEWEST:
            return []
        self._keep(self._last, end)
        most = max(SHORTEST_GAP, SILENCE * float(np.median(np.array(self._periods))))
        return [Gap(topic, begin, end) for length, begin, end in sorted(self._silences, key=lambda silence: silence[1]) if length > most]


def are_places(*values: float) -> bool:
    """Whether these can be m or rad, or that each second."""
    return all(-FARTHEST < value < FARTHEST for value in values)


def _heading(q: Any) -> float:
    """Heading of a quaternion message, in rad."""
    return heading_of(q.x, q.y, q.z, q.w)
