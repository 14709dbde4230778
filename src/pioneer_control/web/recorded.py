"""Turns a bag into a recording for the page: columns of frames for each robot, and the texts with their times.

The page gets the whole run at once, and moves in it by itself. docs/page-protocol.md has the form.
"""

import functools
import json
import math
import zlib
from typing import Any, Callable, Counter, Dict, List, NamedTuple, Optional, Sequence, Tuple

from ..bags.reader import BagConnection, decode, message_class, plural, read_bag
from ..bags.records import BagError
from .backend import STATUS_EVERY
from .columns import TimedFrame, columns
from .frames import WHOLE, FrameFlags
from .from_messages import (OF_ANYBODY, TOPICS, RobotPicture, WorldPicture, diagnosed, helm_text, namespace_of,
                            shared_name)
from .navigation_picture import NavigationPicture

GAP = 0.6
"""Time (s) without a pose after which the picture says that the link is lost."""
MOST_MARKS = 5000
MOST_ROBOTS = 200
INPUTS = {"teleop/cmd_vel": "person"}
CLOUD_EVERY = 2.0       # s between two clouds of a robot
CELLS_A_SECOND = 10000  # of a map that is being made
LIMIT = (0.2, 0.7)      # of a recorded helm; nobody drives a recording

Message = Tuple[float, Dict[str, Any]]
"""The time since the start (s), and a text of the page's protocol."""


class Recording(NamedTuple):
    """A run for the page: the value of ``recording``, and the binary messages with the columns of each robot."""

    value: Dict[str, Any]
    columns: List[bytes]

    def packed(self) -> bytes:
        """Return the value as compressed JSON (RFC 1950)."""
        return zlib.compress(json.dumps(self.value, separators=(",", ":"), allow_nan=False).encode(), 9)

    @property
    def parts(self) -> List[bytes]:
        """The binary messages of the page's protocol."""
        return [WHOLE + self.packed(), *self.columns]


class RecordedRobot:
    """Collects frames and texts of one robot. A frame is made of a pose and of all that came until the next pose: the
    messages of one packet of the robot follow its pose.
    """

    def __init__(self, number: int, namespace: str) -> None:
        self.picture = RobotPicture(number, namespace)
        self.picture.navigation = NavigationPicture(number, cloud=CLOUD_EVERY)
        self.frames: List[TimedFrame] = []
        self.messages: List[Message] = []
        self.marks: List[Dict[str, Any]] = []
        self._told: Dict[str, Tuple[float, Any]] = {}       # the newest text of each kind, and its time
        self._waiting: Optional[float] = None               # time of a pose whose frame is not made yet

    def take(self, name: str, message: Any, now: float) -> None:
        """Take a message of the robot."""
        if name == "pose":
            self.finish()
            before = self.picture.pose_at
            if now - before > GAP and math.isfinite(before):
                self._lose(before + GAP)
            self._waiting = now
        self.picture.take(name, message, now)
        if name == "robot_info":
            self._tell("entry", now, self.picture.entry(""))
        self.tell(now)

    def tell(self, now: float) -> None:
        """Keep the texts that have changed, and what has happened."""
        self._tell("status", now, self.picture.status(now), STATUS_EVERY)
        if self.picture.helm is not None:
            self._tell("helm", now, helm_text(self.picture.number, self.picture.helm, LIMIT, INPUTS))
        self.messages += [(now, {kind: value}) for kind, value in self.picture.navigation.changes(now)]
        for happening in self.picture.happened:
            self.marks.append({"at": round(now, 2), "robot": self.picture.number, "kind": happening.kind,
                               "text": happening.text})
            if happening.kind != "decision":
                self.messages.append((now, {"said": {"robot": self.picture.number, "level": happening.level,
                                                     "text": happening.text}}))
        self.picture.happened.clear()

    def finish(self) -> None:
        """Make the frame of the newest pose, if it is not made yet."""
        if self._waiting is not None:
            frame = self.picture.frame(0, self._waiting)
            self.frames.append((max(0.0, self._waiting), frame))
            self._waiting = None

    def _lose(self, at: float) -> None:
        time, frame = self.frames[-1]
        self.frames.append((at, frame._replace(linear=0.0, angular=0.0, flags=frame.flags & ~FrameFlags.LINK)))

    def _tell(self, kind: str, now: float, value: Any, every: float = 0.0) -> None:
        at, before = self._told.get(kind, (-math.inf, None))
        if value != before and now - at >= every:
            self._told[kind] = (now, value)
            if kind != "entry":
                self.messages.append((now, {kind: value}))


class BagCollector:
    """Passes each message of a bag to the robot or the world that it is about.

    Attributes:
        robots: by namespace.
        messages: the texts about no robot, or all.
        undecoded: the number of messages that could not be understood, by topic.
        begin: the time of the first message (s); None before it.
    """

    def __init__(self) -> None:
        self.robots: Dict[str, RecordedRobot] = {}
        self.messages: List[Message] = []
        self.undecoded: Counter[str] = Counter()
        self.begin: Optional[float] = None
        self._world = WorldPicture(CELLS_A_SECOND)
        self._known: Dict[int, Tuple[Optional[Callable[[Any, float], None]], Any]] = {}

    def add(self, connection: BagConnection, data: bytes, time: float) -> None:
        """Take a message that was recorded at a time (s)."""
        self.begin = time if self.begin is None else self.begin
        try:
            if id(connection) not in self._known:   # the reader keeps the connection, so its id stays its own
                taker = self.taker(connection)
                self._known[id(connection)] = taker, message_class(connection) if taker else None
            take, kind = self._known[id(connection)]
            if take is not None:
                take(decode(connection, data, kind()), round(time - self.begin, 3))
        except Exception:   # damaged data, impossible numbers, or another definition of the message type
            self.undecoded[connection.topic] += 1

    def taker(self, connection: BagConnection) -> Optional[Callable[[Any, float], None]]:
        """Return the function that takes the messages of a connection; None when the page shows nothing of it."""
        topic, kind = connection.topic.strip("/"), connection.type.split("/")[-1]
        namespace, _, name = topic.rpartition("/")
        if (topic, kind) == ("diagnostics", "DiagnosticArray"):
            return self._take_diagnostics
        if (topic, kind) == ("rosout", "Log"):
            return self._take_log
        shared = shared_name(topic, kind)
        if shared:
            return functools.partial(self._take_shared, shared)
        for each in OF_ANYBODY:
            if ("/" + topic).endswith("/" + each) and kind == TOPICS[each].type:
                return functools.partial(self._take_of_anybody, topic[:-len(each)].strip("/"), each)
        is_known = namespace in self.robots or len(self.robots) < MOST_ROBOTS
        if name in TOPICS and TOPICS[name].type == kind and is_known:
            robot = self.robots.setdefault(namespace, RecordedRobot(len(self.robots) + 1, namespace))
            return lambda message, now: self._take_of(robot, name, message, now)
        return None

    def finish(self) -> None:
        """Make the frames that wait for more messages."""
        for robot in self.robots.values():
            robot.finish()

    def _take_of(self, robot: RecordedRobot, name: str, message: Any, now: float) -> None:
        robot.take(name, message, now)
        if name in ("ground_truth", "navigation"):
            self._tell_shared(now)

    def _take_of_anybody(self, namespace: str, name: str, message: Any, now: float) -> None:
        robot = self._robot_in(namespace)
        if robot is not None:
            robot.take(name, message, now)
            self._tell_shared(now)

    def _take_shared(self, name: str, message: Any, now: float) -> None:
        self._world.take(name, message, now)
        self._tell_shared(now)

    def _tell_shared(self, now: float) -> None:
        pictures = [robot.picture for robot in self.robots.values()]
        self.messages += [(now, {kind: value}) for kind, value in self._world.changes(pictures)]

    def _take_diagnostics(self, message: Any, now: float) -> None:
        for each in diagnosed(message):
            robot = self._robot_in(each.namespace)
            if robot is not None:
                robot.picture.take_diagnostics(each.task, each.level, each.text)
                robot.tell(now)

    def _take_log(self, message: Any, now: float) -> None:
        robot = self._robot_in(namespace_of(message.name))
        if robot is not None:
            robot.picture.take_log(message.level, message.msg)
            robot.tell(now)

    def _robot_in(self, namespace: str) -> Optional[RecordedRobot]:
        """Return the robot of a namespace; if there is none, the only robot; None if there are several."""
        only = next(iter(self.robots.values())) if len(self.robots) == 1 else None
        return self.robots.get(namespace, only)


def read_recording(paths: Sequence[str], name: str,
                   progress: Callable[[int, int], Any] = lambda done, total: None) -> Recording:
    """Read a bag, or the parts of one recording in their order, as a recording for the page.

    Args:
        paths: the files.
        name: what the page calls it.
        progress: called with the number of bytes read so far and of all bytes.

    Raises:
        BagError: a file cannot be read, or has no pose of a robot.
    """
    reader, collector = read_bag(list(paths), progress=progress), BagCollector()
    for _, connection, data, time in reader:
        collector.add(connection, data, time / 1e9)
    collector.finish()
    robots = [robot for robot in collector.robots.values() if robot.frames]
    if not robots:
        raise BagError(("%s has no pose of a robot (a topic `pose`, nav_msgs/Odometry). %s" % (
            paths[0], reader.damage)).strip())
    return _recording(collector, robots, name, reader.damage)


def _recording(collector: BagCollector, robots: List[RecordedRobot], name: str, damage: str) -> Recording:
    """Put together what was collected. ``damage``: what could not be read, in sentences."""
    missing = [damage] * bool(damage) + ["%s on %s could not be understood." % (plural(count, "message"), topic)
                                         for topic, count in sorted(collector.undecoded.items())]
    begin = min(robot.frames[0][0] for robot in robots)     # the page begins with a picture
    first: List[Message] = [(begin, {"robots": [robot.picture.entry(name) for robot in robots]})]
    first += [(begin, {"said": {"robot": None, "level": "warn", "text": text}}) for text in missing]
    messages = collector.messages + [each for robot in robots for each in robot.messages]
    marks: List[Dict[str, Any]] = [{"at": begin, "robot": robots[0].picture.number, "kind": "fault", "text": text}
                                   for text in missing]
    marks += [mark for robot in robots for mark in robot.marks]
    value = {
        "name": name,
        "start": round((collector.begin or 0.0) + begin, 3),
        "duration": round(max(robot.frames[-1][0] for robot in robots) - begin, 3),
        "messages": [[round(max(0.0, at - begin), 3), text] for at, text in
                     first + sorted(messages, key=lambda message: message[0])],
        "marks": [dict(mark, at=round(max(0.0, mark["at"] - begin), 2))
                  for mark in sorted(marks, key=lambda mark: float(mark["at"]))[:MOST_MARKS]],
        "columns": [{"robot": robot.picture.number, "rows": len(robot.frames),
                     "sonar": max(len(frame.sonar) for _, frame in robot.frames)} for robot in robots]}
    return Recording(value, [columns(robot.picture.number, [(at - begin, frame) for at, frame in robot.frames])
                             for robot in robots])
