"""Convert the messages of an old bag: give their types new names, and make standard messages. Reads and writes no file.

A driver repeats the reading of a transducer in its arrays of sonar ranges until there is a new one. `SonarHistory`
tells new readings from repeated ones.
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
"""The message types that p2os has too, with the same fields."""
KINDS = {("%s/%s" % (package, name), getattr(msg, name)._md5sum): name
         for name in MESSAGES for package in (*OLD_PACKAGES, "pioneer_control")}
"""The name in `MESSAGES` of each type in each package, by the full name of the type and its MD5 sum."""
BASE_LINK = "base_link"
"""The frame of messages in which p2os left the frame empty."""
STATIC_FRAMES = "/tf_static"
ROUND = 0.32
"""The time (s) in which each transducer measures once.

A reading that stays the same for this time was measured again."""
BEAMS = 360
"""The number of beams of a scan: one for each degree.

It is more than the number of transducers, because a transducer is not in the middle of the robot. Seen from the middle,
its near and far echoes lie in different directions."""


def kind_of(connection: BagConnection) -> str:
    """Return the kind of the messages of a connection. Empty if the converter does not read them.

    The kind is a name in `MESSAGES` for a type of p2os or of this package, or ``RobotInfo``, or ``pose`` for odometry
    on a topic with p2os's name.
    """
    if connection.md5sum == msg.RobotInfo._md5sum:
        return "RobotInfo"
    is_pose = connection.md5sum == Odometry._md5sum and connection.topic.rpartition("/")[2] == "pose"
    return "pose" if is_pose else KINDS.get((connection.type, connection.md5sum), "")


class Conversion(NamedTuple):
    """The conversion that a word of the command line asks for."""

    meaning: str
    """what is made, in words, for --help"""
    kind: str = ""
    """the kind of the old messages, see `kind_of`"""
    made: Optional[type] = None
    """the class of the new messages. None: no new messages are made"""
    topic: str = ""
    """the last name of the new topic, in the namespace of the old topic: /alice/sonar -> /alice/sonar_ranges"""
    by_default: bool = True
    """whether it is made if the command line has no word"""


CONVERSIONS: Dict[str, Conversion] = {
    "types": Conversion("types p2os_driver/X and p2os_msgs/X become pioneer_control/X; no byte of a message changes"),
    "info": Conversion("a RobotInfo of the model that --model names, for robots without one", "SonarArray",
                       msg.RobotInfo, "robot_info"),
    "ranges": Conversion("a sensor_msgs/Range for each new reading, and the frames of the transducers", "SonarArray",
                         Range, "sonar_ranges"),
    "points": Conversion("the places of the echoes as sensor_msgs/PointCloud2", "SonarArray", PointCloud2,
                         "sonar_points"),
    "battery": Conversion("the voltage as sensor_msgs/BatteryState", "BatteryState", BatteryState, "battery"),
    "scan": Conversion("the echoes as sensor_msgs/LaserScan", "SonarArray", LaserScan, "sonar_scan", by_default=False),
    "odom": Conversion("the messages of `pose` again as `odom`, which most programs expect", "pose", Odometry, "odom",
                       by_default=False),
}
DEFAULT = tuple(word for word, conversion in CONVERSIONS.items() if conversion.by_default)


class Options(NamedTuple):
    """The options of a conversion."""

    what: Sequence[str] = DEFAULT
    """the wanted conversions: keys of `CONVERSIONS`"""
    model: Optional[RobotModel] = None
    """the model of all robots that have no robot_info in the bag"""
    gripper: bool = False
    """whether these robots have a gripper"""
    replace: bool = False
    """whether to leave out the old topics that were converted. If not, they stay beside the new topics"""
    renamed: Mapping[str, str] = MappingProxyType({})
    """the frames to rename in every message: {old name: new name}"""


class Outlet:
    """A connection of the new bag.

    Args:
        source: the connection of the old bag from which its messages come.
        topic: the topic in the new bag.
        type_: the class of its messages. None: the class of the messages of the source.
        made: True if its messages are made from the messages of the source. False if they are these messages.
        latched: True if the connection latches. False: it latches if the source does.

    Attributes:
        source, topic, made: the arguments.
        header: all fields of the connection.
        count: the number of its messages so far.
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
    """Return the namespace of the robot to which a topic belongs: /alice/sonar -> /alice."""
    return topic.rpartition("/")[0]


def transducers_of(info: msg.RobotInfo) -> Tuple[Transducer, ...]:
    """Return the transducers that a RobotInfo message describes."""
    return tuple(Transducer(number, pose.x, pose.y, pose.theta)
                 for number, pose in zip(info.sonar_numbers, info.sonar_poses))


class Reading(NamedTuple):
    """The last reading of a transducer: its range (m) and its age (s). The age is 0 when the reading is new."""

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
    """Return a scan in all directions around base_link.

    A beam has the range (m) of the nearest echo in its direction. It has infinity (REP 117) if a transducer looks there
    and has no echo, and NaN if no transducer looks there.

    Args:
        points: the echoes (x, y) in base_link (m).
        silent: the transducers that have no echo.
        transducers: all transducers of the robot.
        stamp: the stamp of the message.
        base_link_frame: the frame of the message.
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
    """Return the number of the beam that is nearest to a point (m)."""
    return round((math.atan2(y, x) + math.pi) / (2 * math.pi) * BEAMS) % BEAMS


class Converter:
    """Converts the messages of a bag. Call it with each message of the old bag, in order of time.

    Args:
        options: the options of the conversion.
        topics: the topics of the old bag. They are not made again.
        transducers: the transducers by the robot's namespace, for robots with a robot_info in the old bag.
        static_frames: the child frames in /tf_static of the old bag. Their transforms are not made again.

    Attributes:
        dropped: the number of messages that were left out, by topic.
        already_there: the topics that are not made because the old bag has them.
        not_fitted: the number of readings from transducers that the robot does not have.
        damaged: the number of messages from which nothing was made because they are damaged, by topic.
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
        """Yield what the new bag gets at the time of a message: for each new message its connection and its bytes."""
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
        """Return the connections of the new bag for one connection of the old bag.

        Returns:
            The outlets by the word of the command line that asks for them. Two outlets have other keys: ``kept`` gets
            the old messages themselves, unless they are replaced, and ``frames`` gets the transforms of transducers.
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
        """Yield the new messages for an old message. Remember the transducers and the velocity that it reports."""
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
        """Return the bytes of a message. They are the old bytes unless frames are renamed."""
        if self._options.renamed and "frame_id" in message.connection.definition:
            with suppress(BagError):
                return serialized(self._decoded(message))
        return message.data

    def _decoded(self, message: Message) -> Any:
        """Decode a message and rename its frames. Raises BagError if it is damaged."""
        made = decode(message.connection, message.data)
        self._rename_frames(made)
        return made

    def _rename_frames(self, part: Any) -> None:
        """Rename the frames in a message and in all messages in it."""
        for field in part.__slots__:
            value = getattr(part, field)
            if field in ("frame_id", "child_frame_id") and isinstance(value, str):
                setattr(part, field, self._options.renamed.get(value.lstrip("/"), value))
            for inner in value if isinstance(value, list) else [value]:
                if isinstance(inner, genpy.Message):
                    self._rename_frames(inner)

    def _sonar(self, outlets: Dict[str, Outlet], history: SonarHistory, robot: str, ranges: Sequence[float],
               stamp: genpy.Time, base_link: str) -> Iterator[Tuple[str, Any]]:
        """Yield the new messages for an array of ranges (m), each with the key of its outlet."""
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
