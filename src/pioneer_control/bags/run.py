"""Read a bag of one robot into a :class:`Run`: plain arrays, SI units, one clock (the recorder's) for every topic.

A topic counts by the last part of its name and the last part of its type, so bags with ``p2os_driver/SonarArray`` or
``p2os_msgs/SonarArray`` read as ours do. Only odometry is required; whatever else is missing is empty or ``None``.
"""

import os
import struct
from typing import Dict, List, NamedTuple, Optional, Sequence, Tuple

import numpy as np

from pioneer_control.bags.reader import BagError
from pioneer_control.message_values import NO_ECHO, NOT_HEARD, GripStatus, heading_of

# What is read: the topic's last name and its type's last name.
ROLES = {
    "pose": "Odometry",
    "sonar": "SonarArray",
    "gripper_state": "GripperState",
    "robot_info": "RobotInfo",
    "ground_truth": "Odometry",
    "cans": "PoseArray",
    "map": "OccupancyGrid",
    "world": "String",
}

Pose = Tuple[float, float, float]  # x, y (m), heading (rad, counter-clockwise)


class Track(NamedTuple):
    """Where a robot was: arrays of one length; s, m, m, and rad without jumps at half a turn."""

    time: np.ndarray
    x: np.ndarray
    y: np.ndarray
    heading: np.ndarray

    @property
    def length(self) -> float:
        """The way driven, in m."""
        return float(np.hypot(np.diff(self.x), np.diff(self.y)).sum())

    def pose(self, index: int) -> Pose:
        """The pose at an index: 0 is the first, -1 the last."""
        return float(self.x[index]), float(self.y[index]), float(self.heading[index])

    def at(self, times: np.ndarray) -> "Track":
        """The track at other times, in between by straight lines, held still before its first and after its last."""
        times = np.asarray(times, dtype=float)
        return Track(times, *(np.interp(times, self.time, values) for values in (self.x, self.y, self.heading)))

    def seen_from(self, origin: Pose) -> "Track":
        """The track in the frame in which its own frame lies at ``origin``."""
        x, y = placed(origin, self.x, self.y)
        return Track(self.time, x, y, self.heading + origin[2])


class Sonar(NamedTuple):
    """Sonar messages: time (m,), ranges (m, n) in m with the sonar's number as column, NaN where there is none."""

    time: np.ndarray
    ranges: np.ndarray


class GripperEvent(NamedTuple):
    """Something the paddles did: time in s, and "picked up", "put down" or "closed on nothing"."""

    time: float
    what: str


class Map(NamedTuple):
    """An occupancy grid: cells (rows, columns) bottom-up, 0 free to 100 occupied, -1 unknown; m; pose of cell (0, 0)'s corner."""

    cells: np.ndarray
    resolution: float
    origin: Pose


class Run(NamedTuple):
    """What one robot did, in the frame of its odometry unless said otherwise."""

    path: str
    robot: str  # namespace without slashes at its ends; empty for a robot at the root
    model: str  # subtype, empty when no robot_info was recorded
    world: str  # name of the simulated world, empty when none was recorded
    footprint: np.ndarray  # (k, 2) outline in base_link, m; k = 0 when unknown
    transducers: Dict[int, Pose]  # by sonar number, in base_link
    odometry: Track
    truth: Optional[Track]  # in the frame of the map
    sonar: Sonar
    gripper: Tuple[GripperEvent, ...]
    cans: Tuple[np.ndarray, ...]  # each (n, 3): x, y, height lifted (m), in the frame of the map; as they came
    map: Optional[Map]

    @property
    def duration(self) -> float:
        """Seconds from the first pose to the last."""
        return float(self.odometry.time[-1] - self.odometry.time[0])

    @property
    def odometry_origin(self) -> Pose:
        """Where the odometry's frame lies in the map: so that both tracks begin together. Zero without ground truth."""
        if self.truth is None:
            return (0.0, 0.0, 0.0)
        # Both are taken when both are there: one may begin before the other.
        start = np.array([max(self.truth.time[0], self.odometry.time[0])])
        return chained(self.truth.at(start).pose(0), inverted(self.odometry.at(start).pose(0)))

    def echoes(self) -> np.ndarray:
        """Points (n, 2) in the odometry's frame that returned a ping; m.

        A reading counts when it is new (a driver repeats each until its transducer's next turn), and is neither "no
        echo" nor 0.0, "not heard".
        """
        ranges = self.sonar.ranges
        fresh = np.ones(ranges.shape, dtype=bool)
        fresh[1:] = ranges[1:] != ranges[:-1]
        with np.errstate(invalid="ignore"):
            row, number = np.nonzero(fresh & (ranges > NOT_HEARD) & (ranges < NO_ECHO))
        fitted = np.isin(number, list(self.transducers))
        row, number = row[fitted], number[fitted]
        if not row.size:
            return np.empty((0, 2))
        looks = np.array([self.transducers[n] for n in number])
        reach = ranges[row, number]
        robot = self.odometry.at(self.sonar.time[row])
        hit = looks[:, 0] + reach * np.cos(looks[:, 2]), looks[:, 1] + reach * np.sin(looks[:, 2])
        return np.column_stack(placed((robot.x, robot.y, robot.heading), *hit))


def placed(pose, x, y) -> Tuple[np.ndarray, np.ndarray]:
    """Points given in the frame of a pose, in the frame the pose is given in. All may be arrays."""
    cosine, sine = np.cos(pose[2]), np.sin(pose[2])
    return pose[0] + cosine * x - sine * y, pose[1] + sine * x + cosine * y


def chained(first: Pose, then: Pose) -> Pose:
    """The pose ``then``, given in the frame of ``first``, in the frame ``first`` is given in."""
    x, y = placed(first, then[0], then[1])
    return float(x), float(y), first[2] + then[2]


def inverted(pose: Pose) -> Pose:
    """The pose of the outer frame seen from this one."""
    x, y = placed((0.0, 0.0, -pose[2]), -pose[0], -pose[1])
    return float(x), float(y), -pose[2]


def gripper_events(states: Sequence[Tuple[float, int, bool]]) -> Tuple[GripperEvent, ...]:
    """What happened, from (time, GripState.state, whether a paddle presses on something) in order of time."""
    events: List[GripperEvent] = []
    held, closed = False, None
    for time, state, pressed in states:
        was_closed, closed = closed, state == GripStatus.CLOSED
        if held and not pressed:
            held = False
            events.append(GripperEvent(time, "put down"))
        elif not held and pressed and closed:
            held = True
            if was_closed is not None:  # else it was held before the recording began
                events.append(GripperEvent(time, "picked up"))
        elif closed and was_closed is False and not held:
            events.append(GripperEvent(time, "closed on nothing"))
    return tuple(events)


def read_run(path: str, robot: Optional[str] = None) -> Run:
    """Read the run of a robot, by its namespace; ``None`` takes the only one in the bag. Raises :class:`BagError`."""
    import genpy  # here, so that a Run of arrays needs no ROS
    import rosbag

    if not os.path.exists(path):
        raise BagError(f"{path}: no such file")
    try:
        with rosbag.Bag(path) as bag:
            return _read(path, bag, robot)
    except rosbag.ROSBagUnindexedException:
        raise BagError(
            f"{path} has no index: its recorder is still running or was killed. When it has ended: rosbag reindex {path}"
        ) from None
    except (rosbag.ROSBagException, genpy.MessageException, struct.error, EOFError) as error:
        raise BagError(f"{path} is not a bag, or is damaged: {error}") from None
    except OSError as error:  # also what bz2 raises for damaged data
        raise BagError(f"{path} cannot be read: {error.strerror or error}") from None


def _read(path: str, bag, robot: Optional[str]) -> Run:
    """The run in an open bag."""
    known = bag.get_type_and_topic_info().topics
    types = {topic: info.msg_type for topic, info in known.items() if info.message_count}
    robot = _choose(path, types, robot)
    role_of = {topic: role for role, topic in _topics_of(robot, types).items()}
    collected = {role: [] for role in ROLES}
    for topic, message, stamp in bag.read_messages(topics=list(role_of)):
        collected[role_of[topic]].append((stamp.to_sec(), message))
    return _assemble(path, robot, collected)


def _split(topic: str) -> Tuple[str, str]:
    """A topic's namespace (no slashes at its ends) and last name."""
    namespace, _, name = topic.strip("/").rpartition("/")
    return namespace, name


def _fits(topic: str, type_name: str) -> bool:
    """Whether a topic is of a kind we read, by its last name and its type's last name."""
    return ROLES.get(_split(topic)[1]) == type_name.split("/")[-1]


def _choose(path: str, types: Dict[str, str], robot: Optional[str]) -> str:
    """The namespace to read."""
    robots = sorted({_split(topic)[0] for topic in types if _split(topic)[1] == "pose" and _fits(topic, types[topic])})
    names = ", ".join(name or "/" for name in robots)
    if robot is not None:
        if robot.strip("/") not in robots:
            raise BagError(f"{path} has no robot {robot!r}; it has: {names or 'none'}")
        return robot.strip("/")
    if not robots:
        there = ", ".join(sorted(types)) or "nothing: the bag is empty"
        raise BagError(f"{path} has no odometry of a robot (a topic `pose`, nav_msgs/Odometry). It has: {there}")
    if len(robots) > 1:
        raise BagError(f"{path} has {len(robots)} robots: {names}. Choose one with --robot")
    return robots[0]


def _topics_of(robot: str, types: Dict[str, str]) -> Dict[str, str]:
    """Role to topic, for one robot. A map may also be everybody's."""
    found = {}
    for role in ROLES:
        own = f"/{robot}/{role}" if robot else f"/{role}"
        for topic in [own, own.lstrip("/")] + (["/map"] if role == "map" else []):
            if topic in types and _fits(topic, types[topic]):
                found.setdefault(role, topic)
    return found


def _assemble(path: str, robot: str, collected: Dict[str, list]) -> Run:
    """A Run of the messages collected by role, each (seconds, message)."""
    info = collected["robot_info"][-1][1] if collected["robot_info"] else None
    grips = [
        (time, message.grip.state, message.grip.left_contact or message.grip.right_contact)
        for time, message in collected["gripper_state"]
    ]
    return Run(
        path=path,
        robot=robot,
        model=info.subtype if info else "",
        world=collected["world"][-1][1].data if collected["world"] else "",
        footprint=np.array([(p.x, p.y) for p in info.footprint.points] if info else []).reshape(-1, 2),
        transducers={n: (p.x, p.y, p.theta) for n, p in zip(info.sonar_numbers, info.sonar_poses)} if info else {},
        odometry=_track(collected["pose"]),
        truth=_track(collected["ground_truth"]) if collected["ground_truth"] else None,
        sonar=_sonar(collected["sonar"]),
        gripper=gripper_events(grips),
        cans=tuple(
            np.array([(p.position.x, p.position.y, p.position.z) for p in message.poses]).reshape(-1, 3)
            for _, message in collected["cans"]
        ),
        map=_map(collected["map"][-1][1]) if collected["map"] else None,
    )


def _track(messages: list) -> Track:
    """A Track of Odometry messages."""
    rows = [(time, m.pose.pose.position.x, m.pose.pose.position.y, _heading(m.pose.pose.orientation)) for time, m in messages]
    time, x, y, heading = np.array(rows, dtype=float).T
    return Track(time, x, y, np.unwrap(heading))


def _heading(q) -> float:
    """Heading of a quaternion message, in rad."""
    return heading_of(q.x, q.y, q.z, q.w)


def _sonar(messages: list) -> Sonar:
    """Sonar of SonarArray messages, which may differ in length."""
    width = max((len(message.ranges) for _, message in messages), default=0)
    ranges = np.full((len(messages), width), np.nan)
    for row, (_, message) in zip(ranges, messages):
        row[: len(message.ranges)] = message.ranges
    return Sonar(np.array([time for time, _ in messages], dtype=float), ranges)


def _map(message) -> Map:
    """Map of an OccupancyGrid message."""
    info = message.info
    corner = (info.origin.position.x, info.origin.position.y, _heading(info.origin.orientation))
    return Map(np.array(message.data, dtype=np.int8).reshape(info.height, info.width), info.resolution, corner)
