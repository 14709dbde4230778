"""What becomes of each message of an old bag: the new name of its type, and standard messages. No files in here."""

import functools
import io
from types import MappingProxyType
from typing import (Any, Callable, Collection, Counter, Dict, Iterable, Iterator, List, Mapping, NamedTuple, Optional,
                    Sequence, Set, Tuple)

import genpy
from nav_msgs.msg import Odometry
from sensor_msgs.msg import BatteryState, LaserScan, PointCloud2, Range
from tf2_msgs.msg import TFMessage

from ... import msg, standard_messages
from ...message_values import NO_ECHO
from ...robots import RobotModel, Transducer
from ..reader import BagConnection, Message, decode
from ..records import BagError
from .sonar import SonarHistory, sonar_scan

OLD_PACKAGES = ("p2os_driver", "p2os_msgs")
MESSAGES = ("AIO", "BatteryState", "DIO", "GripState", "GripperState", "LiftState", "MotorState", "PTZState",
            "SonarArray")
"""What p2os has too, with the same fields."""
BASE_LINK = "base_link"
"""What a frame means that p2os left empty."""
STATIC_FRAMES = "/tf_static"


def is_frozen(connection: BagConnection, *names: str) -> bool:
    """Whether its messages are of one of these types, which both p2os and this package have."""
    package, _, name = connection.type.partition("/")
    of_ours = name in names and package in (*OLD_PACKAGES, "pioneer_control")
    return of_ours and connection.md5sum == getattr(msg, name)._md5sum


def is_old(connection: BagConnection) -> bool:
    """Whether its messages are of p2os."""
    return is_frozen(connection, *MESSAGES) and connection.type.partition("/")[0] in OLD_PACKAGES


def is_sonar(connection: BagConnection) -> bool:
    """Whether its messages are arrays of sonar ranges."""
    return is_frozen(connection, "SonarArray")


def is_battery(connection: BagConnection) -> bool:
    """Whether its messages are the battery's voltage."""
    return is_frozen(connection, "BatteryState")


def is_pose(connection: BagConnection) -> bool:
    """Whether its messages are the odometry of a robot, under p2os's name."""
    return connection.md5sum == Odometry._md5sum and connection.topic.rpartition("/")[2] == "pose"


class Conversion(NamedTuple):
    """What one word of the command line asks for."""

    meaning: str
    fits: Callable[[BagConnection], bool]
    made: Optional[type] = None
    topic: str = ""
    """of what is made, beside the one it is made of: /alice/sonar -> /alice/sonar_ranges"""
    by_default: bool = True


CONVERSIONS: Dict[str, Conversion] = {
    "types": Conversion("p2os_driver/X and p2os_msgs/X are called pioneer_control/X; no byte of a message changes",
                        is_old),
    "info": Conversion("what robot it is, as --model says, where the bag does not tell", is_sonar, msg.RobotInfo,
                       "robot_info"),
    "ranges": Conversion("a sensor_msgs/Range of each new reading, and the transducers' frames", is_sonar, Range,
                         "sonar_ranges"),
    "points": Conversion("where the echoes were, sensor_msgs/PointCloud2", is_sonar, PointCloud2, "sonar_points"),
    "battery": Conversion("voltage as sensor_msgs/BatteryState", is_battery, BatteryState, "battery"),
    "scan": Conversion("the echoes as sensor_msgs/LaserScan", is_sonar, LaserScan, "sonar_scan", by_default=False),
    "odom": Conversion("`pose` under the name that most programs look for", is_pose, Odometry, "odom",
                       by_default=False),
}
DEFAULT = tuple(word for word, conversion in CONVERSIONS.items() if conversion.by_default)


class Options(NamedTuple):
    """What is wanted."""

    what: Sequence[str] = DEFAULT
    """names of CONVERSIONS"""
    model: Optional[RobotModel] = None
    """of a robot of which no robot_info tells where its sonar looks"""
    gripper: bool = False
    """whether that one has a gripper"""
    replace: bool = False
    """leave out what was converted, instead of keeping it beside"""
    renamed: Mapping[str, str] = MappingProxyType({})
    """frames, old name -> new name, in every message"""


class Survey(NamedTuple):
    """What has to be known of a bag before its first message is converted."""

    connections: Sequence[BagConnection]
    transducers: Mapping[str, Sequence[Transducer]]
    """by the robot's namespace, where a robot_info tells"""
    static_frames: Collection[str] = ()
    """in /tf_static"""
    compression: str = "none"


class Outlet:
    """A connection of the new bag.

    Attributes:
        topic: where its messages go.
        header: all fields of the connection.
        source: the connection they come from.
        made: whether they are made of its messages; else they are these, as they were.
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
Make = Callable[[Message], Iterable[Written]]


def namespace_of(topic: str) -> str:
    """The robot a topic belongs to: /alice/sonar -> /alice."""
    return topic.rpartition("/")[0]


def transducers_of(info: msg.RobotInfo) -> Tuple[Transducer, ...]:
    """Where the sonar of a robot looks, by its robot_info."""
    return tuple(Transducer(number, pose.x, pose.y, pose.theta)
                 for number, pose in zip(info.sonar_numbers, info.sonar_poses))


def serialized(message: genpy.Message) -> bytes:
    """A message as it goes over the line."""
    buffer = io.BytesIO()
    message.serialize(buffer)
    return buffer.getvalue()


class Converter:
    """Turns the messages of a bag, one after the other, into those of the new one.

    Args:
        options: what is wanted.
        known: of the old bag. A topic that is there already is not made, nor are transducers that its /tf_static has.

    Attributes:
        outlets: of the new bag, in order of their first message.
        dropped: messages left out, by topic.
        already_there: topics not made.
        not_fitted: readings of transducers that the robot does not have.
        damaged: messages of which nothing could be made, by topic.
    """

    def __init__(self, options: Options, known: Survey) -> None:
        self.outlets: List[Outlet] = []
        self.dropped: Counter[str] = Counter()
        self.already_there: Set[str] = set()
        self.not_fitted = 0
        self.damaged: Counter[str] = Counter()
        self._options, self._known = options, known
        self._renamed = options.renamed
        self._topics = {connection.topic for connection in known.connections}
        self._transducers, self._static_frames = dict(known.transducers), set(known.static_frames)
        self._speeds: Dict[str, Tuple[float, float]] = {}               # m/s and rad/s, by namespace
        # by the id of a connection, which is held so that it stays its own
        self._makers: Dict[int, Tuple[BagConnection, List[Make]]] = {}

    def __call__(self, message: Message) -> Iterator[Written]:
        """What is to be written at the time of a message."""
        connection = message.connection
        if id(connection) not in self._makers:
            self._makers[id(connection)] = connection, self._makers_of(connection)
        try:
            for make in self._makers[id(connection)][1]:
                for outlet, data in make(message):
                    if not outlet.count:
                        self.outlets.append(outlet)
                    outlet.count += 1
                    yield outlet, data
        except BagError:
            self.damaged[message.topic] += 1

    def _makers_of(self, connection: BagConnection) -> List[Make]:
        """What is done with each message of a connection, in this order."""
        outlets = {}
        space, slash, _ = connection.topic.rpartition("/")
        told = space in self._known.transducers     # what robot it is
        for word in self._options.what:
            conversion = CONVERSIONS[word]
            if word == "info" and (told or self._options.model is None):
                continue
            if conversion.made and conversion.fits(connection):
                topic = space + slash + conversion.topic
                if topic in self._topics:
                    self.already_there.add(topic)
                else:
                    outlets[word] = Outlet(connection, topic, conversion.made, latched=word == "info")
        makers: List[Make] = []
        if self._options.replace and set(outlets) - {"info"}:
            makers.append(self._drop)
        else:
            renamed = None
            if "types" in self._options.what and is_old(connection):
                renamed = getattr(msg, connection.type.partition("/")[2])
            makers.append(functools.partial(self._keep, Outlet(connection, connection.topic, renamed, made=False)))
        if connection.md5sum == msg.RobotInfo._md5sum:
            makers.append(self._note_transducers)
        if is_pose(connection) and {"points", "scan"} & set(self._options.what):
            makers.append(self._note_speed)
        if "odom" in outlets:
            makers.append(functools.partial(self._keep, outlets["odom"]))
        if "battery" in outlets:
            makers.append(functools.partial(self._battery, outlets["battery"]))
        if is_sonar(connection) and outlets:
            outlets["frames"] = Outlet(connection, STATIC_FRAMES, TFMessage, latched=True)
            makers.append(functools.partial(self._sonar, outlets, SonarHistory()))
        return makers

    # What is kept.

    def _keep(self, outlet: Outlet, message: Message) -> Iterable[Written]:
        if self._renamed and "frame_id" in message.connection.definition:
            try:
                return [(outlet, serialized(self._decoded(message)))]
            except BagError:
                pass
        return [(outlet, message.data)]

    def _drop(self, message: Message) -> Iterable[Written]:
        self.dropped[message.topic] += 1
        return ()

    def _decoded(self, message: Message) -> Any:
        """A message, its frames renamed."""
        made = decode(message.connection, message.data)
        if self._renamed:
            self._rename_frames(made)
        return made

    def _rename_frames(self, part: Any) -> None:
        """In a message and all messages in it."""
        for field in part.__slots__:
            value = getattr(part, field)
            if field in ("frame_id", "child_frame_id") and isinstance(value, str):
                setattr(part, field, self._renamed.get(value.lstrip("/"), value))
            for inner in value if isinstance(value, list) else [value]:
                if isinstance(inner, genpy.Message):
                    self._rename_frames(inner)

    # What is noted on the way.

    def _note_transducers(self, message: Message) -> Iterable[Written]:
        self._transducers[namespace_of(message.topic)] = transducers_of(decode(message.connection, message.data))
        return ()

    def _note_speed(self, message: Message) -> Iterable[Written]:
        twist = decode(message.connection, message.data).twist.twist
        self._speeds[namespace_of(message.topic)] = twist.linear.x, twist.angular.z
        return ()

    # What is made.

    def _head(self, message: Message) -> Tuple[Any, genpy.Time, str]:
        """A message, its stamp (where it has none, the bag's time), and the robot's base_link."""
        old = self._decoded(message)
        stamp = old.header.stamp if old.header.stamp.to_nsec() else genpy.Time(0, message.time)
        return old, stamp, old.header.frame_id.lstrip("/") or self._renamed.get(BASE_LINK, BASE_LINK)

    @staticmethod
    def _written(outlet: Outlet, made: Any, old: Any) -> Written:
        made.header.seq = old.header.seq
        return outlet, serialized(made)

    def _battery(self, outlet: Outlet, message: Message) -> Iterable[Written]:
        old, stamp, base_link = self._head(message)
        return [self._written(outlet, standard_messages.battery(old.voltage, stamp, base_link), old)]

    def _sonar(self, outlets: Dict[str, Outlet], history: SonarHistory, message: Message) -> Iterator[Written]:
        robot, model = namespace_of(message.topic), self._options.model
        old, stamp, base_link = self._head(message)
        if "info" in outlets and not outlets["info"].count and model is not None:
            info = standard_messages.robot_info(model, self._options.gripper, stamp, base_link)
            yield outlets["info"], serialized(info)
        transducers = self._transducers.get(robot, model.sonar if model else ())
        readings = history.readings(old.ranges, transducers, stamp.to_sec())
        fitted = {transducer.number for transducer in transducers}
        self.not_fitted += sum(heard > 0 and number not in fitted for number, heard in enumerate(old.ranges))
        if "ranges" in outlets:
            prefix = base_link[:base_link.rfind("/") + 1]
            unknown = [each for each in transducers
                       if standard_messages.frame_of(each.number, prefix) not in self._static_frames]
            if unknown:
                self._static_frames |= {standard_messages.frame_of(each.number, prefix) for each in unknown}
                frames = standard_messages.sonar_frames(transducers, stamp, base_link, prefix)
                yield outlets["frames"], serialized(frames)
            for reading in readings:
                if reading.age == 0:
                    made = standard_messages.sonar_range(reading.transducer.number, reading.range, stamp, prefix)
                    yield self._written(outlets["ranges"], made, old)
        speed = self._speeds.get(robot, (0.0, 0.0))
        echoes = [standard_messages.echo_place(*reading, *speed) for reading in readings if reading.range < NO_ECHO]
        if "points" in outlets:
            yield self._written(outlets["points"], standard_messages.sonar_points(echoes, stamp, base_link), old)
        if "scan" in outlets:
            silent = [reading.transducer for reading in readings if reading.range >= NO_ECHO]
            yield self._written(outlets["scan"], sonar_scan(echoes, silent, transducers, stamp, base_link), old)
