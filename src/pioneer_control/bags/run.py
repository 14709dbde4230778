"""From the messages of a bag to a `recorded_run.Run`, in bounded memory however long the bag is: `read_run`.

The table `TOPICS` says what is read, and which of the `collectors` takes it. A topic is known by the last part of its
name and the last part of its type, so bags with ``p2os_driver/SonarArray`` or ``p2os_msgs/SonarArray`` read as ours do.
Robots are told apart by their namespaces.
"""

from collections import defaultdict
from typing import Any, Callable, Counter, DefaultDict, Dict, List, NamedTuple, Optional, Sequence, Tuple, Union

import numpy as np

from .collectors import (CHANGE_OF_SPEED, CanCollector, DecisionCollector, EchoCollector, LastCollector,
                         OdometryCollector, ReportCollector, SilenceCollector, SpanCollector, Thinned, doing, grip_of,
                         gripper_events, map_of, pressed, speed_of, stalled, told_of)
from .reader import BagReader, BagConnection, decode, message_class, plural, read_bag
from .records import BagError
from .recorded_run import CanPath, Echoes, Run, Series, Track, Velocities

CHANGE_OF_VOLTAGE = 0.05  # V
SWITCHED = 0.5  # of a value that is 0 or 1


class Topic(NamedTuple):
    """What is read of a robot: a topic by its last name."""

    type: str
    """last name"""
    collector: Callable[[], Any]
    """makes what its messages are added to: ``add(time, message)``"""
    periodic: bool = False
    """whether silence is a gap"""
    shared: bool = False
    """whether a robot that has none uses that of another namespace: several robots share a world, or a recording"""


TOPICS: Dict[str, Topic] = {
    "pose": Topic("Odometry", OdometryCollector, True),
    "odom": Topic("Odometry", OdometryCollector, True),      # where there is no pose
    "ground_truth": Topic("Odometry", OdometryCollector, True),
    "sonar": Topic("SonarArray", EchoCollector, True),
    "gripper_state": Topic("GripperState", lambda: Thinned(grip_of, SWITCHED, SWITCHED), True),
    "cmd_vel": Topic("Twist", lambda: Thinned(speed_of, *CHANGE_OF_SPEED)),
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
    "map": Topic("OccupancyGrid", lambda: LastCollector(map_of), shared=True),
    "world": Topic("String", lambda: LastCollector(lambda message: message.data), shared=True),
    "recording": Topic("String", lambda: LastCollector(lambda message: message.data), shared=True),
}
ODOMETRY = ("pose", "odom")     # the first of them that a robot has counts

Adder = Callable[[float, Any], Any]


class RunCollector:
    """Takes every message of a bag that is wanted: of one robot, or of all as long as none is chosen.

    Args:
        robot: namespace of the robot; None: all.

    Attributes:
        robot: the same.
        robots: collectors by namespace, and by names of `TOPICS`.
        silences: of the periodic topics, by namespace and topic.
        reports: of all robots.
        undecoded: how many messages could not be read, by topic.
    """

    def __init__(self, robot: Optional[str]) -> None:
        self.robot = robot
        self.robots: DefaultDict[str, Dict[str, Any]] = defaultdict(
            lambda: {name: topic.collector() for name, topic in TOPICS.items()})
        self.silences: DefaultDict[Tuple[str, str], SilenceCollector] = defaultdict(SilenceCollector)
        self.reports = ReportCollector()
        self.undecoded: Counter[str] = Counter()
        # By the id of a connection: what takes its messages, and one message that is filled again and again, which
        # takes half the time of making a new one.
        self._known: Dict[int, Tuple[List[Adder], Any]] = {}

    def adders(self, connection: BagConnection) -> List[Adder]:
        """What takes the messages of a connection; empty where they are not read."""
        namespace, name = _place(connection)
        key = connection.topic.strip("/"), connection.type.split("/")[-1]
        of_all = {("diagnostics", "DiagnosticArray"): self.reports.add_diagnostics,
                  ("rosout", "Log"): self.reports.add_log}
        adders: List[Adder] = [of_all[key]] if key in of_all else []
        if name and (self.robot in (None, namespace) or TOPICS[name].shared):
            adders.append(self.robots[namespace][name].add)
            if TOPICS[name].periodic:
                adders.append(self.silences[namespace, connection.topic].add)
        return adders

    def add(self, connection: BagConnection, data: bytes, time: float) -> None:
        """Take a message that came at a time (s)."""
        try:
            if id(connection) not in self._known:   # the reader keeps the connection, so its id stays its own
                self._known[id(connection)] = self.adders(connection), message_class(connection)()
            adders, filled = self._known[id(connection)]
            message = decode(connection, data, filled)
            for add in adders:
                add(time, message)
        except Exception:   # not such a message, numbers that cannot be, or a definition of the bag's own
            self.undecoded[connection.topic] += 1

    def nearest(self, robot: str, name: str) -> Any:
        """What was last said on a shared topic: the robot's own, else of the innermost namespace around it, else any.

        None where nothing was said.
        """
        around = {place for place in self.robots if not place or (robot + "/").startswith(place + "/")}
        places = sorted(self.robots, key=lambda place: (place not in around, -len(place)))
        found = (self.robots[place][name].last for place in places)
        return next((last for last in found if last is not None), None)


def read_run(paths: Union[str, Sequence[str]], robot: Optional[str] = None,
             progress: Callable[[int, int], Any] = lambda done, total: None) -> Run:
    """Read the run of a robot.

    Args:
        paths: a bag, or the parts of one recording.
        robot: its namespace; None: the only one there is.
        progress: called with the bytes done and all bytes.

    Raises:
        BagError: the bag cannot be read, or has no such robot.
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
    """The namespace of a topic (no slashes at its ends), and its name in `TOPICS`; empty where it is not there."""
    namespace, _, name = connection.topic.strip("/").rpartition("/")
    is_ours = name in TOPICS and TOPICS[name].type == connection.type.split("/")[-1]
    return namespace, name if is_ours else ""


def _robots(reader: BagReader) -> List[str]:
    """Namespaces of the robots with odometry."""
    return sorted({namespace for namespace, name in map(_place, reader.connections) if name in ODOMETRY})


def _choose(path: str, wanted: Optional[str], reader: BagReader) -> str:
    """The namespace of the robot to read.

    Raises:
        BagError: there is no robot, or not the wanted one, or there are several and nobody said which.
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
    """What was collected of a robot."""
    robot = collector.robots[name]
    odometry = next((robot[topic] for topic in ODOMETRY if robot[topic].places.columns().size), None)
    if odometry is None or reader.end is None:
        raise BagError(("%s has no message of the odometry of %s. %s" % (path, name or "/", reader.damage)).strip())
    gaps = [gap for (namespace, topic), silence in sorted(collector.silences.items()) if namespace == name
            for gap in silence.gaps(topic, reader.end / 1e9)]
    undecoded = ["%s on %s could not be understood." % (plural(count, "message"), topic)
                 for topic, count in sorted(collector.undecoded.items())]
    battery, truth = Series(*robot["battery_state"].columns()), Track(*robot["ground_truth"].places.columns())
    return Run(
        path=path,
        robot=name,
        **(robot["robot_info"].last or {}),
        world=collector.nearest(name, "world") or "",
        odometry=Track(*odometry.places.columns()),
        truth=truth if len(truth.time) else None,
        sonar=Echoes(*np.array(robot["sonar"].rows).reshape(-1, 3).T),
        gripper=gripper_events(robot["gripper_state"].columns().T.tolist()),
        cans=tuple(CanPath(*can.columns()) for can in collector.nearest(name, "cans") or ()),
        map=collector.nearest(name, "map"),
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
