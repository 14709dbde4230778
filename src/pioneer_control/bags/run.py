"""Read a `recorded_run.Run` from a bag with `read_run`, in bounded memory however long the bag is.

The table `TOPICS` lists the topics that are read, and the collector of each topic. Only the end of a topic's name and
the last part of its type must match. So bags with ``p2os_driver/SonarArray`` or ``p2os_msgs/SonarArray`` can be
read too. The namespace of a topic is the name of its robot.
"""

from collections import defaultdict
from typing import Any, Callable, Counter, DefaultDict, Dict, List, NamedTuple, Optional, Sequence, Tuple, Union

import numpy as np

from .collectors import (CanCollector, CommandCollector, DecisionCollector, EchoCollector, LastCollector,
                         OdometryCollector, ReportCollector, SilenceCollector, SpanCollector, Thinned, doing, grip_of,
                         gripper_events, looks_of, pressed, stalled, told_of)
from .navigation_collectors import MapCollector, NavigationCollector
from .reader import BagReader, BagConnection, decode, message_class, plural, read_bag
from .records import BagError
from .recorded_run import CanPath, Echoes, Run, Series, Track, Velocities

CHANGE_OF_VOLTAGE = 0.05  # V: a smaller change is not kept
SWITCHED = 0.5  # tolerance for a value that is a whole number, such as 0 or 1: each change is kept


class Topic(NamedTuple):
    """How a topic of a robot is read. The key in `TOPICS` is the end of the topic's name."""

    type: str
    """the last part of the message type, for example Odometry"""
    collector: Callable[[], Any]
    """makes an object with a method ``add(time, message)``"""
    periodic: bool = False
    """whether a long time without messages is reported as a gap"""
    shared: bool = False
    """whether a robot without this topic uses the topic of another namespace (several robots share one world)"""
    of: str = ""
    """the topic whose collector takes the messages; empty: this one has its own"""
    take: str = "add"
    """the method of the collector that takes a message"""


TOPICS: Dict[str, Topic] = {
    "pose": Topic("Odometry", OdometryCollector, True),
    "odom": Topic("Odometry", OdometryCollector, True),      # where there is no pose
    "ground_truth": Topic("Odometry", OdometryCollector, True),
    "sonar": Topic("SonarArray", EchoCollector, True),
    "gripper_state": Topic("GripperState", lambda: Thinned(grip_of, SWITCHED, SWITCHED), True),
    "cmd_vel": Topic("Twist", CommandCollector),
    "teleop/cmd_vel": Topic("Twist", CommandCollector, of="cmd_vel", take="add_of_person"),
    "helm": Topic("Helm", CommandCollector, of="cmd_vel", take="add_helm"),
    "ptz_state": Topic("PTZState", lambda: Thinned(lambda message: [message.pan, message.zoom], SWITCHED, SWITCHED)),
    "battery_state": Topic("BatteryState", lambda: Thinned(lambda message: [message.voltage], CHANGE_OF_VOLTAGE), True),
    # where there is no battery_state
    "battery": Topic("BatteryState", lambda: Thinned(lambda message: [message.voltage], CHANGE_OF_VOLTAGE), True),
    "motor_state": Topic("MotorState", lambda: Thinned(lambda message: [message.state], SWITCHED), True),
    "e_stop": Topic("Bool", lambda: Thinned(lambda message: [message.data], SWITCHED)),
    "stall": Topic("Stall", lambda: SpanCollector(stalled), True),
    "bumpers": Topic("Bumpers", lambda: SpanCollector(pressed), True),
    "decision": Topic("Decision", lambda: DecisionCollector(doing)),
    "robot_info": Topic("RobotInfo", lambda: LastCollector(told_of)),
    "cans": Topic("PoseArray", CanCollector, shared=True),
    "map": Topic("OccupancyGrid", MapCollector, shared=True),
    "truth/map": Topic("OccupancyGrid", MapCollector, shared=True),     # which navigation does not see
    "navigation": Topic("Navigation", NavigationCollector, True),
    "plan": Topic("Path", NavigationCollector, of="navigation", take="add_plan"),
    "particlecloud": Topic("PoseArray", NavigationCollector, of="navigation", take="add_cloud"),
    "world": Topic("String", lambda: LastCollector(lambda message: message.data), shared=True),
    "recording": Topic("String", lambda: LastCollector(lambda message: message.data), shared=True),
}
ODOMETRY = ("pose", "odom")     # the topics with odometry: the first one that has messages is used

Adder = Callable[[float, Any], Any]


class RunCollector:
    """Passes each message of a bag to the collectors of its topic, for one robot or for all robots.

    Args:
        robot: namespace of the robot, without slashes at its ends. None: collect for all robots.

    Attributes:
        robot: the argument `robot`.
        robots: the collectors, by namespace and then by name in `TOPICS`.
        silences: the collectors of gaps in periodic topics, by namespace and topic.
        reports: the warnings and errors of all robots.
        undecoded: the number of messages that could not be read, by topic.
    """

    def __init__(self, robot: Optional[str]) -> None:
        self.robot = robot
        self.robots: DefaultDict[str, Dict[str, Any]] = defaultdict(
            lambda: {name: topic.collector() for name, topic in TOPICS.items() if not topic.of})
        self.silences: DefaultDict[Tuple[str, str], SilenceCollector] = defaultdict(SilenceCollector)
        self.reports = ReportCollector()
        self.undecoded: Counter[str] = Counter()
        # By the id of a connection: the functions that take its messages, and one message object. The object is filled
        # again for each message, which takes half the time of making a new object.
        self._known: Dict[int, Tuple[List[Adder], Any]] = {}

    def adders(self, connection: BagConnection) -> List[Adder]:
        """Return the functions to call with each message of a connection. Empty if its messages are not wanted."""
        namespace, name = _place(connection)
        key = connection.topic.strip("/"), connection.type.split("/")[-1]
        of_all = {("diagnostics", "DiagnosticArray"): self.reports.add_diagnostics,
                  ("rosout", "Log"): self.reports.add_log}
        adders: List[Adder] = [of_all[key]] if key in of_all else []
        if name and (self.robot in (None, namespace) or TOPICS[name].shared):
            topic = TOPICS[name]
            adders.append(getattr(self.robots[namespace][topic.of or name], topic.take))
            if topic.periodic:
                adders.append(self.silences[namespace, connection.topic].add)
        return adders

    def add(self, connection: BagConnection, data: bytes, time: float) -> None:
        """Decode a message and pass it to its collectors. A message that cannot be read is counted in `undecoded`.

        Args:
            connection: the connection of the message.
            data: the serialized message.
            time: the time when it was recorded (s).
        """
        try:
            if id(connection) not in self._known:   # the reader keeps the connection, so its id stays its own
                self._known[id(connection)] = self.adders(connection), message_class(connection)()
            adders, filled = self._known[id(connection)]
            message = decode(connection, data, filled)
            for add in adders:
                add(time, message)
        except Exception:   # damaged data, impossible numbers, or another definition of the message type
            self.undecoded[connection.topic] += 1

    def nearest(self, robot: str, name: str) -> Any:
        """Return the last value of a shared topic for a robot. None if no namespace has a value.

        The value of the robot's own namespace comes first, then that of the longest namespace that contains the robot,
        then that of any other namespace.

        Args:
            robot: namespace of the robot.
            name: name of the topic in `TOPICS`.
        """
        around = {place for place in self.robots if not place or (robot + "/").startswith(place + "/")}
        places = sorted(self.robots, key=lambda place: (place not in around, -len(place)))
        found = (self.robots[place][name].last for place in places)
        return next((last for last in found if last is not None), None)


def read_run(paths: Union[str, Sequence[str]], robot: Optional[str] = None,
             progress: Callable[[int, int], Any] = lambda done, total: None) -> Run:
    """Read the run of a robot.

    Args:
        paths: a bag, or the parts of one recording in their order.
        robot: namespace of the robot. None: the only robot in the bag.
        progress: a function that is called with the number of bytes read so far and of all bytes.

    Raises:
        BagError: the bag cannot be read, has no such robot, or has several robots and `robot` is None.
    """
    paths = [paths] if isinstance(paths, str) else list(paths)
    collector = RunCollector(None if robot is None else robot.strip("/"))
    reader = read_bag(paths, lambda connection: bool(collector.adders(connection)), progress)
    if reader.indexed:  # all its connections are known before the messages are read
        _choose(paths[0], collector.robot, reader)
    for _, connection, data, time in reader:
        collector.add(connection, data, time / 1e9)
    return _run(paths[0], _choose(paths[0], collector.robot, reader), collector, reader)


def _place(connection: BagConnection) -> Tuple[str, str]:
    """Return the namespace of a topic (without slashes at its ends), and the name of the topic in `TOPICS`.

    The name is empty if `TOPICS` has no such topic, or the topic has another message type.
    """
    parts, kind = connection.topic.strip("/").split("/"), connection.type.split("/")[-1]
    for length in (2, 1):
        name = "/".join(parts[-length:])
        if name in TOPICS and TOPICS[name].type == kind:
            return "/".join(parts[:-length]), name
    return "/".join(parts[:-1]), ""


def _robots(reader: BagReader) -> List[str]:
    """Return the namespaces of all robots with an odometry topic in a bag, sorted."""
    return sorted({namespace for namespace, name in map(_place, reader.connections) if name in ODOMETRY})


def _choose(path: str, wanted: Optional[str], reader: BagReader) -> str:
    """Return the namespace of the robot to read.

    Args:
        path: path of the bag, for the error message.
        wanted: namespace of the wanted robot. None: the only robot in the bag.
        reader: the reader of the bag.

    Raises:
        BagError: the bag has no robot, does not have the wanted robot, or has several robots and `wanted` is None.
    """
    robots = _robots(reader)
    names = ", ".join(name or "/" for name in robots)
    if not robots:
        topics = sorted({"%s (%s)" % (entry.topic, entry.type) for entry in reader.connections})
        raise BagError(("%s has no odometry of a robot (a topic `pose` or `odom`, nav_msgs/Odometry). It has: %s. %s"
                        % (path, ", ".join(topics) or "nothing: the bag is empty", reader.damage)).strip())
    if wanted is not None and wanted not in robots:
        raise BagError("%s has no robot %r; it has: %s. Choose one with --robot" % (path, wanted, names))
    if wanted is None and len(robots) > 1:
        raise BagError("%s has %s robots: %s. Choose one with --robot" % (path, len(robots), names))
    return robots[0] if wanted is None else wanted


def _run(path: str, name: str, collector: RunCollector, reader: BagReader) -> Run:
    """Make the Run of a robot from the collected data, after all messages are read.

    Args:
        path: path of the bag, or of its first part.
        name: namespace of the robot.
        collector: the collected data.
        reader: the reader of the bag.

    Raises:
        BagError: the bag has no odometry message of the robot.
    """
    robot = collector.robots[name]
    odometry = next((robot[topic] for topic in ODOMETRY if robot[topic].places.columns().size), None)
    if odometry is None or reader.end is None:
        raise BagError(("%s has no message of the odometry of %s. %s" % (path, name or "/", reader.damage)).strip())
    gaps = [gap for (namespace, topic), silence in sorted(collector.silences.items()) if namespace == name
            for gap in silence.gaps(topic, reader.end / 1e9)]
    undecoded = ["%s on %s could not be understood." % (plural(count, "message"), topic)
                 for topic, count in sorted(collector.undecoded.items())]
    battery, truth = Series(*robot["battery_state"].columns()), Track(*robot["ground_truth"].places.columns())
    used, world = collector.nearest(name, "map"), collector.nearest(name, "truth/map")
    return Run(
        path=path,
        robot=name,
        **(robot["robot_info"].last or {}),
        world=collector.nearest(name, "world") or "",
        odometry=Track(*odometry.places.columns()),
        truth=truth if len(truth.time) else None,
        sonar=Echoes(*np.array(robot["sonar"].rows).reshape(-1, 3).T),
        gripper=gripper_events(robot["gripper_state"].columns().T.tolist()),
        looks=looks_of(robot["ptz_state"].columns().T.tolist()),
        cans=tuple(CanPath(*can.columns()) for can in collector.nearest(name, "cans") or ()),
        map=used or world,
        map_made=robot["map"].made,
        own_frame=bool(used and world and not used.covers_the_same(world)),
        navigation=robot["navigation"].navigated(),
        commanded=Velocities(*robot["cmd_vel"].columns()),
        measured=Velocities(*odometry.speeds.columns()),
        battery=battery if len(battery.time) else Series(*robot["battery"].columns()),
        motors=Series(*robot["motor_state"].columns()),
        e_stop=Series(*robot["e_stop"].columns()),
        stalls=tuple(robot["stall"].spans),
        bumps=tuple(robot["bumpers"].spans),
        faults=collector.reports.of(name, _robots(reader)),
        gaps=tuple(sorted(gaps, key=lambda gap: gap.begin)),
        doings=tuple(robot["decision"].spans),
        notes=collector.nearest(name, "recording") or "",
        damage=" ".join([reader.damage] * bool(reader.damage) + undecoded),
    )
