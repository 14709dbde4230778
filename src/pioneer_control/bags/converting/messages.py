"""What becomes of each message of an old bag: the new name of its type, and standard messages. No files in here.

Drivers repeat readings in their arrays of sonar ranges. Here the arrays are read as what each transducer heard, and
when.
"""

import math
from contextlib import suppress
from types import MappingProxyType
from typing import (Any, Collection, Counter, Dict, Iterable, Iterator, List, Mapping, NamedTuple, Optional, Sequence,
                    Set, Tuple)

import genpy
import numpy as np
from nav_msgs.msg import Odometry
from sensor_msgs.msg import BatteryState, LaserScan, PointCloud2, Range
from std_msgs.msg import Header
from tf2_msgs.msg import TFMessage

from ... import msg, standard_messages
from ...message_values import NO_ECHO, NOT_HEARD
from ...robots import RobotModel, Transducer
from ..reader import BagConnection, Message, decode
from ..records import BagError
from ..writer import serialized

OLD_PACKAGES = ("p2os_driver", "p2os_msgs")
MESSAGES = ("AIO", "BatteryState", "DIO", "GripState", "GripperState", "LiftState", "MotorState", "PTZState",
            "SonarArray")
"""What p2os has too, with the same fields."""
KINDS = {("%s/%s" % (package, name), getattr(msg, name)._md5sum): name
         for name in MESSAGES for package in (*OLD_PACKAGES, "pioneer_control")}
"""The name of each of them by its type in all packages that have it, and its md5."""
BASE_LINK = "base_link"
"""The frame that is meant where p2os left it empty."""
STATIC_FRAMES = "/tf_static"
ROUND = 0.32
"""s in which each transducer of an array has its turn. A reading that stays the same for so long was heard again."""
BEAMS = 360
"""Directions of a scan, a degree apart: as seen from the robot's middle, near and far echoes of one transducer lie in
different directions.
"""


def kind_of(connection: BagConnection) -> str:
    """What the messages of a connection are to a converter; empty where it does nothing with them.

    Returns:
        One of `MESSAGES`, of p2os or of this package; ``RobotInfo``; or ``pose``: odometry under p2os's name.
    """
    if connection.md5sum == msg.RobotInfo._md5sum:
        return "RobotInfo"
    is_pose = connection.md5sum == Odometry._md5sum and connection.topic.rpartition("/")[2] == "pose"
    return "pose" if is_pose else KINDS.get((connection.type, connection.md5sum), "")


class Conversion(NamedTuple):
    """What one word of the command line asks for."""

    meaning: str
    kind: str = ""
    """of the messages that something is made of"""
    made: Optional[type] = None
    topic: str = ""
    """last name of the new topic, in the namespace of the old one: /alice/sonar -> /alice/sonar_ranges"""
    by_default: bool = True


CONVERSIONS: Dict[str, Conversion] = {
    "types": Conversion("p2os_driver/X and p2os_msgs/X are called pioneer_control/X; no byte of a message changes"),
    "info": Conversion("what robot it is, as --model says, where the bag does not tell", "SonarArray", msg.RobotInfo,
                       "robot_info"),
    "ranges": Conversion("a sensor_msgs/Range of each new reading, and the transducers' frames", "SonarArray", Range,
                         "sonar_ranges"),
    "points": Conversion("where the echoes were, sensor_msgs/PointCloud2", "SonarArray", PointCloud2, "sonar_points"),
    "battery": Conversion("voltage as sensor_msgs/BatteryState", "BatteryState", BatteryState, "battery"),
    "scan": Conversion("the echoes as sensor_msgs/LaserScan", "SonarArray", LaserScan, "sonar_scan", by_default=False),
    "odom": Conversion("`pose` under the name that most programs look for", "pose", Odometry, "odom",
                       by_default=False),
}
DEFAULT = tuple(word for word, conversion in CONVERSIONS.items() if conversion.by_default)


class Options(NamedTuple):
    """What is wanted."""

    what: Sequence[str] = DEFAULT
    """names of CONVERSIONS"""
    model: Optional[RobotModel] = None
    """of the robots of which no robot_info tells where their sonar looks"""
    gripper: bool = False
    """whether these have a gripper"""
    replace: bool = False
    """leave out what was converted, instead of keeping it beside what is made of it"""
    renamed: Mapping[str, str] = MappingProxyType({})
    """frames, old name -> new name, in every message"""


class Outlet:
    """A connection of the new bag.

    Args:
        source: the connection that its messages come from.
        topic: of the new bag.
        type_: class of its messages; None: that of the source.
        made: whether its messages are made of the source's; else they are the source's, as they were.
        latched: whether it latches; else it does as the source does.

    Attributes:
        source, topic, made: the same.
        header: all fields of the connection.
        count: messages so far.
    """

    def __init__(self, source: BagConnection, topic: str, type_: Any = None, made: bool = True,
                 latched: bool = False) -> None:
        self.source, self.topic, self.made, self.count = source, topic, made, 0
        self.header = dict(source.header, **{"latching": "1"} if latched else {},
                           **{"topic": topic} if "topic" in source.header else {})
        if type_ is not None:
            self.header.update(type=type_._type, md5sum=type_._md5sum, message_definition=type_._full_text)


Written = Tuple[Outlet, bytes]


def namespace_of(topic: str) -> str:
    """The robot a topic belongs to: /alice/sonar -> /alice."""
    return topic.rpartition("/")[0]


def transducers_of(info: msg.RobotInfo) -> Tuple[Transducer, ...]:
    """Where the sonar of a robot looks, by its robot_info."""
    return tuple(Transducer(number, pose.x, pose.y, pose.theta)
                 for number, pose in zip(info.sonar_numbers, info.sonar_poses))


class Reading(NamedTuple):
    """What a transducer heard last: its range (m), and its age (s); 0 where it was just heard."""

    transducer: Transducer
    range: float
    age: float


class SonarHistory:
    """Tells new readings from repeated ones."""

    def __init__(self) -> None:
        self._last: Dict[int, Tuple[float, float]] = {}     # by number: range, and when it was heard

    def readings(self, ranges: Sequence[float], transducers: Iterable[Transducer], time: float) -> List[Reading]:
        """Return the newest reading of each transducer that was heard.

        Args:
            ranges: the array of ranges (m).
            transducers: the transducers of the robot.
            time: the time (s) at which the array came. It may jump back: then all readings are new.
        """
        found = []
        for transducer in transducers:
            heard = ranges[transducer.number] if transducer.number < len(ranges) else NOT_HEARD
            if heard > NOT_HEARD:   # and is not NaN
                before, since = self._last.get(transducer.number, (None, time))
                since = since if heard == before and 0 <= time - since < ROUND else time
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
        range_min=standard_messages.MIN_RANGE,
        range_max=NO_ECHO + max((math.hypot(each.x, each.y) for each in transducers), default=0.0),
        ranges=ranges.tolist(),
    )


def _beam(x: float, y: float) -> int:
    """The beam that goes through a point (m), or next to it."""
    return round((math.atan2(y, x) + math.pi) / (2 * math.pi) * BEAMS) % BEAMS


class Converter:
    """Turns the messages of a bag, one after the other, into those of the new one.

    Args:
        options: what is wanted.
        topics: of the old bag. Those are not made again.
        transducers: by the robot's namespace, where a robot_info of the old bag tells.
        static_frames: child frames in /tf_static of the old bag. Frames of transducers among them are not made again.

    Attributes:
        dropped: how many messages were left out, by topic.
        already_there: topics that are not made because the bag has them.
        not_fitted: how many readings came from transducers that the robot does not have.
        damaged: how many messages were so damaged that nothing could be made of them, by topic.
    """

    def __init__(self, options: Options, topics: Collection[str], transducers: Mapping[str, Sequence[Transducer]],
                 static_frames: Iterable[str]) -> None:
        self.dropped: Counter[str] = Counter()
        self.already_there: Set[str] = set()
        self.not_fitted = 0
        self.damaged: Counter[str] = Counter()
        self._options, self._topics, self._first_transducers = options, topics, transducers
        self._transducers, self._static_frames = dict(transducers), set(static_frames)
        self._speeds: Dict[str, Tuple[float, float]] = {}               # m/s and rad/s, by namespace
        # kind and outlets by the id of a connection; the outlets hold the connection, so its id stays its own
        self._sources: Dict[int, Tuple[str, Dict[str, Outlet], SonarHistory]] = {}

    def __call__(self, message: Message) -> Iterator[Written]:
        """What is to be written at the time of a message."""
        connection = message.connection
        if id(connection) not in self._sources:
            self._sources[id(connection)] = kind_of(connection), self._outlets_of(connection), SonarHistory()
        try:
            for outlet, data in self._written(message, *self._sources[id(connection)]):
                outlet.count += 1
                yield outlet, data
        except BagError:
            self.damaged[message.topic] += 1

    def _outlets_of(self, connection: BagConnection) -> Dict[str, Outlet]:
        """What the new bag has of a connection.

        Returns:
            Outlets by word of the command line. Two have names of their own: ``kept`` takes the messages as they were,
            where nothing replaces them, and ``frames`` the places of the transducers.
        """
        outlets = {}
        space, slash, _ = connection.topic.rpartition("/")
        is_unknown = self._options.model is not None and space not in self._first_transducers
        for word in self._options.what:
            conversion = CONVERSIONS[word]
            if conversion.made and conversion.kind == kind_of(connection) and (is_unknown or word != "info"):
                topic = space + slash + conversion.topic
                if topic in self._topics:
                    self.already_there.add(topic)
                else:
                    outlets[word] = Outlet(connection, topic, conversion.made, latched=word == "info")
        if not self._options.replace or not set(outlets) - {"info"}:
            package, _, name = connection.type.partition("/")
            is_old = package in OLD_PACKAGES and kind_of(connection) == name
            type_ = getattr(msg, name) if is_old and "types" in self._options.what else None
            outlets["kept"] = Outlet(connection, connection.topic, type_, made=False)
        outlets["frames"] = Outlet(connection, STATIC_FRAMES, TFMessage, latched=True)
        return outlets

    def _written(self, message: Message, kind: str, outlets: Dict[str, Outlet],
                 history: SonarHistory) -> Iterator[Written]:
        """What becomes of a message, and what it says of its robot for later ones."""
        if "kept" in outlets:
            yield outlets["kept"], self._kept(message)
        else:
            self.dropped[message.topic] += 1
        robot = namespace_of(message.topic)
        if kind == "RobotInfo":
            self._transducers[robot] = transducers_of(self._decoded(message))
        elif kind == "pose" and {"points", "scan"} & set(self._options.what):
            twist = self._decoded(message).twist.twist
            self._speeds[robot] = twist.linear.x, twist.angular.z
        if "odom" in outlets:
            yield outlets["odom"], self._kept(message)
        if outlets.keys() & {"battery", "info", "ranges", "points", "scan"}:
            old = self._decoded(message)
            stamp = old.header.stamp if old.header.stamp.to_nsec() else genpy.Time(0, message.time)
            base_link = old.header.frame_id.lstrip("/") or self._options.renamed.get(BASE_LINK, BASE_LINK)
            made = ([("battery", standard_messages.battery(old.voltage, stamp, base_link))] if "battery" in outlets
                    else self._sonar(outlets, history, robot, old.ranges, stamp, base_link))
            for word, each in made:
                if word not in ("info", "frames"):
                    each.header.seq = old.header.seq
                yield outlets[word], serialized(each)

    def _kept(self, message: Message) -> bytes:
        """The bytes of a message, which change only where frames get new names."""
        if self._options.renamed and "frame_id" in message.connection.definition:
            with suppress(BagError):
                return serialized(self._decoded(message))
        return message.data

    def _decoded(self, message: Message) -> Any:
        """A message whose frames have their new names."""
        made = decode(message.connection, message.data)
        self._rename_frames(made)
        return made

    def _rename_frames(self, part: Any) -> None:
        """Give frames their new names, in a message and in all messages in it."""
        for field in part.__slots__:
            value = getattr(part, field)
            if field in ("frame_id", "child_frame_id") and isinstance(value, str):
                setattr(part, field, self._options.renamed.get(value.lstrip("/"), value))
            for inner in value if isinstance(value, list) else [value]:
                if isinstance(inner, genpy.Message):
                    self._rename_frames(inner)

    def _sonar(self, outlets: Dict[str, Outlet], history: SonarHistory, robot: str, ranges: Sequence[float],
               stamp: genpy.Time, base_link: str) -> Iterator[Tuple[str, Any]]:
        """What is made of an array of ranges (m), by the names of the outlets."""
        model = self._options.model
        if "info" in outlets and not outlets["info"].count and model is not None:
            yield "info", standard_messages.robot_info(model, self._options.gripper, stamp, base_link)
        transducers = self._transducers.get(robot, model.sonar if model else ())
        readings = history.readings(ranges, transducers, stamp.to_sec())
        fitted = {transducer.number for transducer in transducers}
        self.not_fitted += sum(heard > 0 and number not in fitted for number, heard in enumerate(ranges))
        if "ranges" in outlets:
            prefix = base_link[:base_link.rfind("/") + 1]
            frames = {standard_messages.frame_of(number, prefix) for number in fitted}
            if not frames <= self._static_frames:
                self._static_frames |= frames
                yield "frames", standard_messages.sonar_frames(transducers, stamp, base_link, prefix)
            for reading in readings:
                if reading.age == 0:
                    yield "ranges", standard_messages.sonar_range(reading.transducer.number, reading.range, stamp,
                                                                  prefix)
        speed = self._speeds.get(robot, (0.0, 0.0))
        echoes = [standard_messages.echo_place(*reading, *speed) for reading in readings if reading.range < NO_ECHO]
        if "points" in outlets:
            yield "points", standard_messages.sonar_points(echoes, stamp, base_link)
        if "scan" in outlets:
            silent = [reading.transducer for reading in readings if reading.range >= NO_ECHO]
            yield "scan", sonar_scan(echoes, silent, transducers, stamp, base_link)
