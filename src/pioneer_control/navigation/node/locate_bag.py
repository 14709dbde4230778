"""Where a robot was, or its map, from a bag: ``rosrun pioneer_control locate_bag IN.bag OUT.bag --map lab.yaml``.

The bag may come from this package or from p2os: sonar and pose are enough; scans of a laser are used where tf says
where it sits. The new bag has all of the old one but its
navigation, amcl_pose, particlecloud, map and tf of odom on a map, which are made anew as if navigation had run, and
what else navigation told or was told then: plan, places, footprint, goals, its diagnostics and its log. Without a map
one is made, and ``--save-map`` saves it; an older map of that name is kept. The same bag gives the same poses and the
same map.
"""

import contextlib
import os
import sys
from pathlib import Path
from typing import Any, Callable, Dict, List, NamedTuple, Optional, Sequence, Tuple

import genpy
from nav_msgs.msg import OccupancyGrid
from tf2_msgs.msg import TFMessage

from ... import msg, standard_messages
from ...bags.command_line import Progress, parser_of
from ...bags.converting.messages import kind_of, namespace_of
from ...bags.reader import BagConnection, BagReader, decode, read_bag
from ...bags.records import BagError
from ...bags.writer import BagWriter, serialized
from ...errors import PioneerError, UsageError
from ...floor_poses import Pose
from ...maps.ros_map import check_map_file
from ...message_values import heading_of
from ...robots import RobotModel, find_model
from ...whole_file import writing
from ..chassis import Chassis
from .bag_laser import SCAN, BagLaser, laser_of
from .map_files import load_floor_map
from .map_saver import write_map
from ..navigator import Readiness
from ..pilot import Pilot, PilotStep
from ..senses import Senses
from ..values import Sensing
from .parameters import NavigationParameters
from .messages import (body_of, cloud_message, header_of, map_message, odom_on_map, pose2d, pose_with_covariance,
                       sweep_of)

FRAME = "map"
CLOUD_EVERY = 1.0
"""Time (s) between two clouds in the new bag."""
MOST_IN_CLOUD = 200
"""Most poses in one of them."""
MAP_EVERY = 10.0
"""Time (s) between two states of a map that is made."""
MADE = ("navigation", "amcl_pose", "particlecloud", "map")
"""The topics that are made. Those of the old bag are left out."""
TOLD_THEN = ("plan", "places", "footprint", "map_metadata", "initialpose", "move_base_simple/goal")
"""Topics of navigation that are left out too: they tell of goals and of a map that the new bag does not have."""
ACTION = "move_base/"
"""How the topics of its action begin. They are left out, too."""
LISTS = {"diagnostic_msgs/DiagnosticArray": "status", "tf2_msgs/TFMessage": "transforms",
         "tf/tfMessage": "transforms"}
"""The types of messages that are lists of what several nodes tell, and the field that has it."""
LOG = "rosgraph_msgs/Log"
TASK = ": Navigation"
"""How the name of the diagnostics of navigation ends."""
OPTIONS: Dict[str, Dict[str, Any]] = {
    "bag": dict(metavar="IN.bag"),
    "output": dict(metavar="OUT.bag", help="must not exist yet"),
    "--map": dict(default="", metavar="FILE", help="map_server's .yaml, ARIA's .map, or the name of a world; without "
                                                   "it a map is made"),
    "--save-map": dict(default="", metavar="FILE", help="without --map: the .yaml file for the map that is made"),
    "--start": dict(nargs=3, type=float, metavar=("X", "Y", "HEADING"),
                    help="where the robot was at first (m, m, rad); without it, it is found out"),
    "--robot": dict(default="", metavar="NAME", help="namespace of the robot, if the bag has several"),
    "--model": dict(default="", help="model of a robot that has no robot_info in the bag: p3dx-sh for example; the new "
                                     "bag gets one"),
    "--no-laser": dict(action="store_true", help="go by sonar alone, also where the bag has scans"),
    "--seed": dict(type=int, default=0, help="of what chance decides"),
}


class Located(NamedTuple):
    """What became of one bag: how many sonar messages, how many of them with a sure pose, how many with one by the
    laser, and what was damaged.
    """

    heard: int
    sure: int
    by_laser: int
    damage: str


class BagRobot(NamedTuple):
    """A robot in a bag: its namespace, its shape, its model if the bag does not tell it, its frame of odometry and its
    own.
    """

    namespace: str
    chassis: Chassis
    model: Optional[RobotModel]
    odom_frame: str
    base_frame: str


def frames_of(path: str, robot: str) -> Tuple[str, str]:
    """Return the frame of a robot's odometry in a bag, and its own: those of its first pose. p2os may have left them
    empty.
    """
    poses = read_bag(path, lambda connection: connection.topic == robot + "/pose" and kind_of(connection) == "pose")
    first = next((message for _, message, _ in poses.decoded()), None)
    told = ("", "") if first is None else (first.header.frame_id.lstrip("/"), first.child_frame_id.lstrip("/"))
    return told[0] or "odom", told[1] or "base_link"


def robot_of(path: str, wanted: str, model: str) -> BagRobot:
    """Return the robot in a bag.

    Raises:
        UsageError: there is no such robot, there are several, or nobody says where its transducers look.
    """
    infos: Dict[str, Any] = {}
    with Progress("looking") as progress:
        reader = read_bag(path, lambda connection: kind_of(connection) == "RobotInfo", progress)
        for connection, message, _ in reader.decoded():
            infos.setdefault(namespace_of(connection.topic), message)
    names = sorted({namespace_of(each.topic) for each in reader.connections if kind_of(each) == "SonarArray"})
    told = ", ".join(name.lstrip("/") or "/" for name in names) or "none"
    if wanted:
        names = [name for name in names if name.strip("/") == wanted.strip("/")]
    if len(names) != 1:
        raise UsageError("%s has %s robots with sonar%s (%s): name one with --robot" % (
            path, len(names), " named %r" % wanted if wanted else "", told))
    info, frames = infos.get(names[0]), frames_of(path, names[0])
    speeds = NavigationParameters.max_linear, NavigationParameters.max_angular
    if model or info is None:
        if not model:
            raise UsageError("%s does not say where the transducers look (it has no robot_info): name its model,"
                             " --model p3dx-sh for example" % path)
        found = find_model(model)
        return BagRobot(names[0], Chassis(found.sonar, found.outline(False), *speeds),
                        found if info is None else None, *frames)
    return BagRobot(names[0], Chassis(*body_of(info), *speeds), None, *frames)


class Locator:
    """Makes the messages of navigation from those of a robot.

    Args:
        pilot: the navigation.
        robot: the robot. If it has a model, the new bag is to tell it.
        laser: its laser. None: it has none, or its scans are not to be used.

    Attributes:
        heard, sure, by_laser: as those of `Located`.
        unused: how many scans were of no use.
        why_unused: why, of the first of them.
    """

    def __init__(self, pilot: Pilot, robot: BagRobot, laser: Optional[BagLaser]):
        self._pilot, self._senses = pilot, Senses([each.number for each in robot.chassis.transducers])
        self._model, self._odom_frame = robot.model, robot.odom_frame
        self._laser = laser
        self._next_cloud = self._next_map = 0.0
        self.heard = self.sure = self.by_laser = self.unused = 0
        self.why_unused = ""
        self.hears: Dict[str, Callable[[Any], List[Sensing]]] = {
            "SonarArray": self._hear_sonar, "pose": self._hear_pose, SCAN: self._hear_scan}

    def take(self, kind: str, message: Any) -> List[Tuple[str, Any]]:
        """Take a message of a kind of `hears`. Return what navigation says then: name of a topic (of the robot, or one
        that begins with /), and message.
        """
        made: List[Tuple[str, Any]] = []
        for sensing in self.hears[kind](message):
            made += self._told(self._pilot.sense(sensing, Readiness()))
        return made

    def _hear_sonar(self, message: Any) -> List[Sensing]:
        return self._senses.hear_sonar(message.header.stamp.to_sec(), message.ranges)

    def _hear_pose(self, message: Any) -> List[Sensing]:
        place, turn = message.pose.pose.position, message.pose.pose.orientation
        return self._senses.hear_pose(message.header.stamp.to_sec(), Pose(
            place.x, place.y, heading_of(turn.x, turn.y, turn.z, turn.w)))

    def _hear_scan(self, message: Any) -> List[Sensing]:
        """Take a scan. One of another frame, or whose numbers do not fit together, is left out, and counted."""
        laser = self._laser
        if laser is not None:
            try:
                if message.header.frame_id.lstrip("/") != laser.frame:
                    raise UsageError("its frame is %r, and that of the first scan was %r" % (
                        message.header.frame_id, laser.frame))
                self._senses.hear_sweep(sweep_of(message, laser.mount, laser.upside_down, 0.0))
            except UsageError as error:
                self.unused += 1
                self.why_unused = self.why_unused or str(error)
        return []

    def _told(self, step: PilotStep) -> List[Tuple[str, Any]]:
        where = step.where
        assert where is not None
        stamp = genpy.Time.from_sec(step.time)
        self.heard += 1
        self.sure += where.sure
        self.by_laser += where.by_laser
        made: List[Tuple[str, Any]] = [
            ("navigation", msg.Navigation(header_of(FRAME, stamp), step.state.value, step.reason, where.sure,
                                          where.reason, pose2d(where.pose), [], 0.0, 0.0)),
            ("amcl_pose", pose_with_covariance(where.pose, where.covariance, FRAME, stamp)),
            ("/tf", TFMessage([odom_on_map(where.pose, step.odometry, FRAME, self._odom_frame, stamp)]))]
        if self.heard == 1 and self._model is not None:
            made.append(("robot_info", standard_messages.robot_info(self._model, False, stamp, "base_link")))
        if not 0.0 <= self._next_cloud - step.time <= CLOUD_EVERY:
            self._next_cloud = step.time + CLOUD_EVERY
            made.append(("particlecloud", cloud_message(self._pilot.particles, MOST_IN_CLOUD, FRAME, stamp)))
        if self.heard == 1 or self._pilot.makes_map and not 0.0 <= self._next_map - step.time <= MAP_EVERY:
            self._next_map = step.time + MAP_EVERY
            made.append(("map", map_message(self._pilot.grid, FRAME, stamp)))
        return made


class OldBag:
    """What the new bag keeps of the old one.

    Args:
        reader: the reader of the old bag.
        robot: namespace of the robot.
        odom_frame: its frame of odometry.
    """

    def __init__(self, reader: BagReader, robot: str, odom_frame: str):
        self._left_out, self._odom_frame = {"%s/%s" % (robot, name) for name in MADE + TOLD_THEN}, odom_frame
        self._action = "%s/%s" % (robot, ACTION)
        self._tasks_of = (robot.strip("/") + "/").lstrip("/")
        self._map, self._truth, navigation = robot + "/map", robot + "/truth/map", robot + "/navigation"
        topics = {each.topic for each in reader.connections}
        self._map_is_true = (robot + "/ground_truth" in topics and navigation not in topics
                             and self._truth not in topics)
        self._nodes = {each.caller for each in reader.connections if each.topic == navigation} | {navigation}

    def topic(self, topic: str) -> str:
        """Return what a topic is called in the new bag; empty: it is left out.

        The map of a simulator is that of its world. Navigation has another one, so it gets the name for that case.
        """
        if topic == self._map and self._map_is_true:
            return self._truth
        return "" if topic in self._left_out or topic.startswith(self._action) else topic

    def data(self, connection: BagConnection, data: bytes) -> bytes:
        """Return the data of a message without what navigation told on a topic of all nodes: its diagnostics, its log,
        and where odometry is on a map, whoever told that. Empty: nothing is left.
        """
        if connection.type != LOG and connection.type not in LISTS:
            return data
        try:
            message = decode(connection, data)
        except BagError:
            return data
        if connection.type == LOG:
            return b"" if message.name in self._nodes else data
        told = getattr(message, LISTS[connection.type])
        kept = [each for each in told if not self._is_of_then(each)]
        if len(kept) == len(told):
            return data
        setattr(message, LISTS[connection.type], kept)
        return serialized(message) if kept else b""

    def _is_of_then(self, told: Any) -> bool:
        """Return whether a transform, or the status of a task, tells where the robot was then."""
        if hasattr(told, "child_frame_id"):
            return told.child_frame_id.lstrip("/") == self._odom_frame
        return told.name.endswith(TASK) and told.name.startswith(self._tasks_of)


def locate(source: str, target: str, robot: BagRobot, locator: Locator) -> Located:
    """Write the new bag.

    Raises:
        UsageError: the new bag exists already.
        OSError: it cannot be written; then nothing is left of it.
    """
    if os.path.lexists(target):
        raise UsageError("%s exists already: name another file for the new bag" % target)
    heard = {"%s/%s" % (robot.namespace, name) for name in ("pose", "sonar", "scan")}
    numbers: Dict[Any, int] = {}
    with writing(target) as part, contextlib.closing(BagWriter(part)) as writer, Progress("locating") as progress:
        reader: BagReader = read_bag(source, progress=progress)
        old = OldBag(reader, robot.namespace, robot.odom_frame)
        for message in reader:
            connection = message.connection
            kept, data = old.topic(message.topic), old.data(connection, message.data)
            if kept and (data or not message.data):
                key = kept, connection.caller, connection.md5sum, connection.latching
                if key not in numbers:
                    numbers[key] = writer.connect(kept, dict(connection.header, topic=kept))
                writer.write(numbers[key], data, message.time)
            kind = connection.type if connection.type == SCAN else kind_of(connection)
            if message.topic not in heard or kind not in locator.hears:
                continue
            try:
                made = locator.take(kind, decode(connection, message.data))
            except BagError:
                continue        # `reader.damage` tells
            for name, each in made:
                topic = name if name.startswith("/") else "%s/%s" % (robot.namespace, name)
                if topic not in numbers:
                    numbers[topic] = writer.connect(topic, connection_header(topic, each))
                writer.write(numbers[topic], serialized(each), message.time)
    return Located(locator.heard, locator.sure, locator.by_laser, reader.damage)


def connection_header(topic: str, message: Any) -> Dict[str, str]:
    """Return the header of a connection in a bag, for messages that this program makes."""
    latched = {"latching": "1"} if isinstance(message, (OccupancyGrid, msg.RobotInfo)) else {}
    return {"topic": topic, "type": message._type, "md5sum": message._md5sum, "message_definition": message._full_text,
            "callerid": "/locate_bag", **latched}


def usable_laser(path: str, robot: BagRobot) -> Optional[BagLaser]:
    """Return the laser of a robot in a bag. None: it has none, or its scans cannot be used; people are told why."""
    try:
        return laser_of(path, robot.namespace, robot.base_frame)
    except UsageError as error:
        print("locate_bag: the scans of the laser are not used: %s" % error, file=sys.stderr)
        return None


def main(arguments: Optional[Sequence[str]] = None) -> int:
    """Locate the robot of the bag that the command line names.

    Returns:
        The exit status. 0: all is written. 1: the old bag is damaged, and the new bag has what could be read; or the
        new bag is written, but not its map. 2: nothing is written.
    """
    options = parser_of("locate_bag", __doc__.split("\n\n")[1], OPTIONS).parse_args(arguments)
    done: Optional[Located] = None
    saved = ""
    try:
        if options.map and options.save_map:
            raise UsageError("--save-map %s: a map is made only without --map" % options.save_map)
        if options.save_map:
            check_map_file(Path(options.save_map))      # before the work, which may take minutes
        floor = load_floor_map(options.map) if options.map else None
        robot = robot_of(options.bag, options.robot, options.model)
        pilot = Pilot(floor, robot.chassis, seed=options.seed)
        if options.start:
            pilot.start_at(Pose(*options.start), 0.3, 0.2)
        laser = usable_laser(options.bag, robot) if floor is not None and not options.no_laser else None
        locator = Locator(pilot, robot, laser)
        done = locate(options.bag, options.output, robot, locator)
        if locator.unused:
            print("locate_bag: %d scans of the laser are not used; the first of them: %s" % (
                locator.unused, locator.why_unused), file=sys.stderr)
        if options.save_map:
            pilot.finish()
            saved = "; the map is %s" % write_map(pilot.grid, {}, options.save_map)
    except PioneerError as error:
        print("locate_bag: %s%s" % (error, "; %s is written" % options.output if done else ""), file=sys.stderr)
        return 1 if done else 2
    except OSError as error:
        print("locate_bag: %s cannot be written: %s. Nothing is left of it" % (options.output, error.strerror),
              file=sys.stderr)
        return 2
    print("%s -> %s: %d sonar messages, sure of the pose in %.0f %%%s%s%s" % (
        options.bag, options.output, done.heard, 100.0 * done.sure / max(1, done.heard),
        ", by the laser in %.0f %%" % (100.0 * done.by_laser / max(1, done.heard)) if laser is not None else "", saved,
        "; %s What could be read was used." % done.damage if done.damage else ""))
    return 1 if done.damage else 0


if __name__ == "__main__":
    sys.exit(main())
