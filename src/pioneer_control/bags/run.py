"""From the messages of a bag to a `recorded_run.Run`, in bounded memory however long the bag is: `read_run`.

What is read is the table `TOPICS`; `collectors` keep what is kept of it. A topic counts by the last part of its name
and the last part of its type, so bags with ``p2os_driver/SonarArray`` or ``p2os_msgs/SonarArray`` read as ours do.
Robots are told apart by their namespace.
"""

from typing import Any, Callable, Dict, List, NamedTuple, Optional, Sequence, Tuple, Union

import numpy as np

from .collectors import (CanCollector, DecisionCollector, EchoCollector, GripperCollector, LastCollector, MapCollector,
                         OdometryCollector, ReportCollector, SilenceCollector, SpanCollector, ValueCollector,
                         VelocityCollector, is_plausible, pressed, stalled)
from .reader import BagReader, BagConnection, decode, message_class, plural, read_bag
from .records import BagError
from .recorded_run import Run

CHANGE_OF_VOLTAGE = 0.05  # V


class Topic(NamedTuple):
    """What is read of a robot: a topic by its last name."""

    type: str
    """last name"""
    collector: Callable[[], Any]
    """makes what its messages are added to: ``add(time, message)``"""
    periodic: bool = False
    """whether silence is a gap"""
    shared: bool = False
    """whether one of another namespace counts where the robot has none: a world, or a recording, of several robots"""


TOPICS: Dict[str, Topic] = {
    "pose": Topic("Odometry", OdometryCollector, True),
    "odom": Topic("Odometry", OdometryCollector, True),      # where there is no pose
    "ground_truth": Topic("Odometry", OdometryCollector, True),
    "sonar": Topic("SonarArray", EchoCollector, True),
    "gripper_state": Topic("GripperState", GripperCollector, True),
    "cmd_vel": Topic("Twist", VelocityCollector),
    "battery_state": Topic("BatteryState", lambda: ValueCollector("voltage", CHANGE_OF_VOLTAGE), True),
    # where there is no battery_state
    "battery": Topic("BatteryState", lambda: ValueCollector("voltage", CHANGE_OF_VOLTAGE), True),
    "motor_state": Topic("MotorState", lambda: ValueCollector("state", 0.5), True),
    "e_stop": Topic("Bool", lambda: ValueCollector("data", 0.5)),
    "stall": Topic("Stall", lambda: SpanCollector(stalled), True),
    "bumpers": Topic("Bumpers", lambda: SpanCollector(pressed), True),
    "decision": Topic("Decision", DecisionCollector),
    "robot_info": Topic("RobotInfo", LastCollector),
    "cans": Topic("PoseArray", CanCollector, shared=True),
    "map": Topic("OccupancyGrid", MapCollector, shared=True),
    "world": Topic("String", LastCollector, shared=True),
    "recording": Topic("String", LastCollector, shared=True),
}
ODOMETRY = ("pose", "odom")     # the first that is there
KEPT = tuple(sorted({"/" + topic.type for topic in TOPICS.values()
                     if topic.collector in (LastCollector, CanCollector)}))
"""Types of messages that are kept whole."""

Adder = Callable[[float, Any], Any]


class CollectedRobot:
    """What is kept of one robot."""

    def __init__(self) -> None:
        self._collectors = {name: topic.collector() for name, topic in TOPICS.items()}
        self.silences: Dict[str, SilenceCollector] = {}    # by topic

    def __getitem__(self, name: str) -> Any:
        return self._collectors[name]

    @property
    def odometry(self) -> Optional[OdometryCollector]:
        """That of the first topic that has one; None: there is none yet."""
        return next((self[name] for name in ODOMETRY if self[name].track is not None), None)


class RunCollector:
    """Takes every message of a bag that is wanted: of one robot, or of all as long as none is chosen."""

    def __init__(self, robot: Optional[str]) -> None:
        self.robot = robot
        self.robots: Dict[str, CollectedRobot] = {}
        self.reports = ReportCollector()
        self.undecoded: Dict[str, int] = {}     # by topic
        self._of_all = {("diagnostics", "DiagnosticArray"): self.reports.add_diagnostics,
                        ("rosout", "Log"): self.reports.add_log}
        self._adders: Dict[Tuple[str, str], List[Adder]] = {}     # by topic and type
        # By connection: what takes its messages, and one message that is filled again and again, in half the time of a
        # new one; None for those that are kept.
        self._known: Dict[int, Tuple[List[Adder], Any]] = {}

    def wants(self, connection: BagConnection) -> bool:
        """Whether a connection's messages are read."""
        return bool(self._adders_of(connection))

    def _adders_of(self, connection: BagConnection) -> List[Adder]:
        """What takes its messages."""
        key = connection.topic.strip("/"), connection.type.split("/")[-1]
        if key not in self._adders:
            namespace, name = _split(connection.topic)
            adders: List[Adder] = [self._of_all[key]] if key in self._of_all else []
            if _fits(connection) and (self.robot in (None, namespace) or TOPICS[name].shared):
                robot = self.robots.setdefault(namespace, CollectedRobot())
                adders.append(robot[name].add)
                if TOPICS[name].periodic:
                    adders.append(robot.silences.setdefault(connection.topic, SilenceCollector()).add)
            self._adders[key] = adders
        return self._adders[key]

    def add(self, connection: BagConnection, data: bytes, time: float) -> None:
        """Take a message (s)."""
        try:
            known = self._known.get(id(connection))
            if known is None:   # the reader keeps the connection, so its id stays its own
                filled = None if connection.type.endswith(KEPT) else message_class(connection)()
                known = self._known[id(connection)] = self._adders_of(connection), filled
            adders, filled = known
            message = decode(connection, data, filled)
            for add in adders:
                add(time, message)
        except Exception:   # no message, numbers that are none, or a definition of the bag's own with other fields
            self.undecoded[connection.topic] = self.undecoded.get(connection.topic, 0) + 1

    def nearest(self, robot: str, name: str) -> Any:
        """What was kept of a shared topic: the robot's own, else of the innermost namespace around it, else any."""
        def distance(place: str) -> Tuple[bool, int]:
            is_around = place == "" or (robot + "/").startswith(place + "/")
            return not is_around, -len(place)

        found = [self.robots[place][name] for place in sorted(self.robots, key=distance)]
        return next((collector for collector in found if collector.last is not None), self.robots[robot][name])


def read_run(paths: Union[str, Sequence[str]], robot: Optional[str] = None,
             progress: Callable[[int, int], Any] = lambda done, total: None) -> Run:
    """Read the run of a robot.

    Args:
        paths: a bag, or the parts of one recording.
        robot: its namespace; None: the only one there is.
        progress: called with the bytes done and all bytes.

    Raises:
        BagError: it cannot be read, or has no such robot.
    """
    paths = [paths] if isinstance(paths, str) else list(paths)
    collector = RunCollector(None if robot is None else robot.strip("/"))
    reader = read_bag(paths, collector.wants, progress)
    if reader.indexed:  # it has said before it is read what is in it
        _choose(paths, _robots(reader.connections), collector.robot, reader)
    for _, connection, data, time in reader:
        collector.add(connection, data, time / 1e9)
    robots = _robots(reader.connections)
    name = _choose(paths, robots, collector.robot, reader)
    try:
        return _run(paths[0], name, robots, collector, reader)
    except BagError:
        raise
    except (AttributeError, TypeError, ValueError) as error:    # only here the fields of messages kept whole are read
        raise BagError("%s has messages under names of ours whose fields are others: %s" % (paths[0], error)) from None


def _split(topic: str) -> Tuple[str, str]:
    """A topic's namespace (no slashes at its ends) and last name."""
    namespace, _, name = topic.strip("/").rpartition("/")
    return namespace, name


def _fits(connection: BagConnection) -> bool:
    """Whether a topic is of a kind we read, by its last name and its type's last name."""
    topic = TOPICS.get(_split(connection.topic)[1])
    return topic is not None and topic.type == connection.type.split("/")[-1]


def _robots(connections: Sequence[BagConnection]) -> List[str]:
    """Namespaces of the robots with odometry."""
    return sorted({_split(entry.topic)[0] for entry in connections
                   if _split(entry.topic)[1] in ODOMETRY and _fits(entry)})


def _choose(paths: Sequence[str], robots: Sequence[str], wanted: Optional[str], reader: BagReader) -> str:
    """The namespace to read, of those there are.

    Raises:
        BagError: there is none, not the wanted one, or none is wanted and there are several.
    """
    names = ", ".join(name or "/" for name in robots)
    if not robots:
        topics = {"%s (%s)" % (entry.topic, entry.type) for entry in reader.connections}
        there = ", ".join(sorted(topics)) or "nothing: the bag is empty"
        raise BagError(("%s has no odometry of a robot (a topic `pose` or `odom`, nav_msgs/Odometry). It has: %s. %s"
                        % (paths[0], there, reader.damage)).strip())
    if wanted is not None and wanted not in robots:
        raise BagError("%s has no robot %r; it has: %s. Choose one with --robot" % (paths[0], wanted, names))
    if wanted is None and len(robots) > 1:
        raise BagError("%s has %s robots: %s. Choose one with --robot" % (paths[0], len(robots), names))
    return robots[0] if wanted is None else wanted


def _run(path: str, name: str, robots: Sequence[str], collector: RunCollector, reader: BagReader) -> Run:
    """What was collected of a robot."""
    robot = collector.robots[name]
    odometry, track = robot.odometry, robot.odometry.track if robot.odometry else None
    if odometry is None or track is None or reader.end is None:
        raise BagError(("%s has no message of the odometry of %s. %s" % (path, name or "/", reader.damage)).strip())
    info = robot["robot_info"].last
    world, recording = (collector.nearest(name, topic).last for topic in ("world", "recording"))
    gaps = [gap for topic, silence in sorted(robot.silences.items()) for gap in silence.gaps(topic, reader.end / 1e9)]
    undecoded = ["%s on %s could not be understood." % (plural(count, "message"), topic)
                 for topic, count in sorted(collector.undecoded.items())]
    battery = robot["battery_state"].series
    outline = [(p.x, p.y) for p in info.footprint.points if is_plausible(p.x, p.y)] if info else []
    return Run(
        path=path,
        robot=name,
        model=info.subtype if info else "",
        world=world.data if world else "",
        footprint=np.array(outline).reshape(-1, 2),
        transducers={number: (pose.x, pose.y, pose.theta) for number, pose in zip(info.sonar_numbers, info.sonar_poses)
                     if is_plausible(pose.x, pose.y, pose.theta)} if info else {},
        odometry=track,
        truth=robot["ground_truth"].track,
        sonar=robot["sonar"].echoes,
        gripper=robot["gripper_state"].events,
        cans=collector.nearest(name, "cans").paths,
        map=collector.nearest(name, "map").last,
        commanded=robot["cmd_vel"].velocities,
        measured=odometry.velocities,
        battery=battery if len(battery.time) else robot["battery"].series,
        motors=robot["motor_state"].changes,
        e_stop=robot["e_stop"].changes,
        stalls=robot["stall"].spans,
        bumps=robot["bumpers"].spans,
        faults=collector.reports.of(name, robots),
        gaps=tuple(sorted(gaps, key=lambda gap: gap.begin)),
        decisions=robot["decision"].decisions,
        notes=recording.data if recording else "",
        damage=" ".join([reader.damage] * bool(reader.damage) + undecoded),
    )
