"""From the messages of a bag to a :class:`~pioneer_control.bags.run.Run`, in bounded memory however long the bag is.

What is read is the table `TOPICS`, and what is kept of it is in `keepers`. A topic counts by the last part of its name and the last part of its type,
so bags with ``p2os_driver/SonarArray`` or ``p2os_msgs/SonarArray`` read as ours do. Robots are told apart by their namespace.
"""

from typing import Any, Callable, Dict, List, NamedTuple, Optional, Sequence, Tuple

import numpy as np

from .keepers import Commands, Decisions, Echoes, Ends, Faults, Grid, Gripper, Odometry, Rhythm, Spans, Values, are_places, pressed, stalled
from .reader import BagError, BagReader, Connection, decode, message_class, plural, read_bag
from .run import Run

CHANGE_OF_VOLTAGE = 0.05  # V


class Topic(NamedTuple):
    """What is read of a robot: a topic by its last name."""

    type: str
    """last name"""
    keeper: Callable[[], Any]
    """makes what its messages are added to: ``add(time, message)``"""
    periodic: bool = False
    """whether silence is a gap"""
    shared: bool = False
    """whether one of another namespace counts where the robot has none: a world, or a recording, of several robots"""


TOPICS: Dict[str, Topic] = {
    "pose": Topic("Odometry", Odometry, True),
    "odom": Topic("Odometry", Odometry, True),      # where there is no pose
    "ground_truth": Topic("Odometry", Odometry, True),
    "sonar": Topic("SonarArray", Echoes, True),
    "gripper_state": Topic("GripperState", Gripper, True),
    "cmd_vel": Topic("Twist", Commands),
    "battery_state": Topic("BatteryState", lambda: Values("voltage", CHANGE_OF_VOLTAGE), True),
    "battery": Topic("BatteryState", lambda: Values("voltage", CHANGE_OF_VOLTAGE), True),   # sensor_msgs; where there is no battery_state
    "motor_state": Topic("MotorState", lambda: Values("state", 0.5), True),
    "e_stop": Topic("Bool", lambda: Values("data", 0.5)),
    "stall": Topic("Stall", lambda: Spans(stalled), True),
    "bumpers": Topic("Bumpers", lambda: Spans(pressed), True),
    "decision": Topic("Decision", Decisions),
    "robot_info": Topic("RobotInfo", Ends),
    "cans": Topic("PoseArray", Ends, shared=True),
    "map": Topic("OccupancyGrid", Grid, shared=True),
    "world": Topic("String", Ends, shared=True),
    "recording": Topic("String", Ends, shared=True),
}
ODOMETRY = ("pose", "odom")     # the first that is there
KEPT = tuple(sorted({"/" + topic.type for topic in TOPICS.values() if topic.keeper is Ends}))   # messages that are kept whole


class Robot:
    """What is kept of one robot."""

    def __init__(self) -> None:
        self.keepers = {name: topic.keeper() for name, topic in TOPICS.items()}
        self.rhythms: Dict[str, Rhythm] = {}    # by topic

    def __getitem__(self, name: str) -> Any:
        return self.keepers[name]

    @property
    def odometry(self) -> Optional[Odometry]:
        """None as long as there is none."""
        return next((self[name] for name in ODOMETRY if self[name].track is not None), None)


class Gatherer:
    """Takes every message of a bag that is wanted: of one robot, or of all as long as none is chosen."""

    def __init__(self, robot: Optional[str]) -> None:
        self.robot = robot
        self.robots: Dict[str, Robot] = {}
        self.faults = Faults()
        self.undecoded: Dict[str, int] = {}     # by topic
        self._of_all = {("diagnostics", "DiagnosticArray"): self.faults.add_diagnostics, ("rosout", "Log"): self.faults.add_log}
        self._adders: Dict[Tuple[str, str], List[Callable[[float, Any], Any]]] = {}     # by topic and type
        # By connection: what takes its messages, and one that is filled again and again, in half the time of a new one; None for those that are kept.
        self._taken: Dict[int, Tuple[List[Callable[[float, Any], Any]], Any]] = {}

    def wants(self, connection: Connection) -> bool:
        """Whether a connection's messages are read."""
        return bool(self._adders_of(connection))

    def _adders_of(self, connection: Connection) -> List[Callable[[float, Any], Any]]:
        """What takes its messages."""
        key = connection.topic.strip("/"), connection.type.split("/")[-1]
        if key not in self._adders:
            namespace, name = _split(connection.topic)
            adders = [self._of_all[key]] if key in self._of_all else []
            if _fits(connection) and (self.robot in (None, namespace) or TOPICS[name].shared):
                robot = self.robots.setdefault(namespace, Robot())
                adders.append(robot[name].add)
                if TOPICS[name].periodic:
                    adders.append(robot.rhythms.setdefault(connection.topic, Rhythm()).add)
            self._adders[key] = adders
        return self._adders[key]

    def add(self, connection: Connection, data: bytes, time: float) -> None:
        """Take a message (s)."""
        try:
            taken = self._taken.get(id(connection))
            if taken is None:   # the reader keeps it, so its id stays its own
                fresh = connection.type.endswith(KEPT)
                taken = self._taken[id(connection)] = self._adders_of(connection), None if fresh else message_class(connection)()
            adders, filled = taken
            message = decode(connection, data, filled)
            for add in adders:
                add(time, message)
        except Exception:   # bytes of the file that are no message, numbers that are none, or a definition of a bag's own with other fields
            self.undecoded[connection.topic] = self.undecoded.get(connection.topic, 0) + 1

    def nearest(self, robot: str, name: str) -> Any:
        """What was kept of a shared topic: the robot's own, else that of a namespace around it, from within, else any."""
        around = sorted(self.robots, key=lambda place: (not ("%s/" % robot).startswith("%s/" % place * bool(place)), -len(place)))
        return next((self.robots[place][name] for place in around if self.robots[place][name].last is not None), self.robots[robot][name])


def gather(paths: Sequence[str], robot: Optional[str] = None, progress: Optional[Callable[[int, int], Any]] = None) -> Run:
    """See `pioneer_control.bags.run.read_run`."""
    gatherer = Gatherer(None if robot is None else robot.strip("/"))
    reader = read_bag(paths, gatherer.wants, progress)
    if reader.indexed:  # it has said before it is read what is in it
        _choose(paths, _robots(reader.connections), gatherer.robot, reader)
    for _, connection, data, time in reader:
        gatherer.add(connection, data, time / 1e9)
    robots = _robots(reader.connections)
    name = _choose(paths, robots, gatherer.robot, reader)
    try:
        return _run(paths[0], name, robots, gatherer, reader)
    except BagError:
        raise
    except (AttributeError, TypeError, ValueError) as error:    # of what was kept as it was: only now its fields are looked at
        raise BagError("%s has messages under names of ours whose fields are others: %s" % (paths[0], error)) from None


def _split(topic: str) -> Tuple[str, str]:
    """A topic's namespace (no slashes at its ends) and last name."""
    namespace, _, name = topic.strip("/").rpartition("/")
    return namespace, name


def _fits(connection: Connection) -> bool:
    """Whether a topic is of a kind we read, by its last name and its type's last name."""
    topic = TOPICS.get(_split(connection.topic)[1])
    return topic is not None and topic.type == connection.type.split("/")[-1]


def _robots(connections: Sequence[Connection]) -> List[str]:
    """Namespaces of the robots with odometry."""
    return sorted({_split(entry.topic)[0] for entry in connections if _split(entry.topic)[1] in ODOMETRY and _fits(entry)})


def _choose(paths: Sequence[str], robots: Sequence[str], wanted: Optional[str], reader: BagReader) -> str:
    """The namespace to read, of those there are."""
    names = ", ".join(name or "/" for name in robots)
    if wanted is not None and wanted in robots:
        return wanted
    if wanted is not None and robots:
        raise BagError("%s has no robot %r; it has: %s. Choose one with --robot" % (paths[0], wanted, names))
    if not robots:
        there = ", ".join(sorted({"%s (%s)" % (entry.topic, entry.type) for entry in reader.connections})) or "nothing: the bag is empty"
        raise BagError(("%s has no odometry of a robot (a topic `pose` or `odom`, nav_msgs/Odometry). It has: %s. %s" % (paths[0], there, reader.damage)).strip())
    if len(robots) > 1:
        raise BagError("%s has %s robots: %s. Choose one with --robot" % (paths[0], len(robots), names))
    return robots[0]


def _run(path: str, name: str, robots: Sequence[str], gatherer: Gatherer, reader: BagReader) -> Run:
    """What was gathered of a robot."""
    robot = gatherer.robots[name]
    if robot.odometry is None:
        raise BagError(("%s has no message of the odometry of %s. %s" % (path, name or "/", reader.damage)).strip())
    info, world, recording = robot["robot_info"].last, gatherer.nearest(name, "world").last, gatherer.nearest(name, "recording").last
    gaps = [gap for topic, rhythm in sorted(robot.rhythms.items()) for gap in rhythm.gaps(topic, reader.end / 1e9)]
    undecoded = ["%s on %s could not be understood." % (plural(count, "message"), topic) for topic, count in sorted(gatherer.undecoded.items())]
    return Run(
        path=path,
        robot=name,
        model=info.subtype if info else "",
        world=world.data if world else "",
        footprint=np.array([(p.x, p.y) for p in info.footprint.points if are_places(p.x, p.y)] if info else []).reshape(-1, 2),
        transducers={n: (p.x, p.y, p.theta) for n, p in zip(info.sonar_numbers, info.sonar_poses) if are_places(p.x, p.y, p.theta)} if info else {},
        odometry=robot.odometry.track,
        truth=robot["ground_truth"].track,
        sonar=robot["sonar"].sonar,
        gripper=robot["gripper_state"].events,
        cans=tuple(
            np.array([(p.position.x, p.position.y, p.position.z) for p in message.poses]).reshape(-1, 3) for message in gatherer.nearest(name, "cans").both),
        map=gatherer.nearest(name, "map").last,
        commanded=robot["cmd_vel"].velocities,
        measured=robot.odometry.velocities,
        battery=robot["battery_state"].series if len(robot["battery_state"].series.time) else robot["battery"].series,
        motors=robot["motor_state"].changes,
        e_stop=robot["e_stop"].changes,
        stalls=robot["stall"].spans,
        bumps=robot["bumpers"].spans,
        faults=gatherer.faults.of(name, robots),
        gaps=tuple(sorted(gaps, key=lambda gap: gap.begin)),
        decisions=robot["decision"].decisions,
        notes=recording.data if recording else "",
        damage=" ".join([reader.damage] * bool(reader.damage) + undecoded),
    )
