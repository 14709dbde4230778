"""The robots of a ROS graph, as the page shows them and tells them: found by their topics, coming and going.

Only this file, `graph_navigation` and `node` use ROS here. `from_messages` says what messages mean for the page. The
driver of each robot decides who may command: this file publishes on ``teleop/cmd_vel`` and the like, as any program of
a person does.
"""

import math
import threading
from time import monotonic
from typing import Any, Dict, List, Optional, Set, Tuple

import rosgraph
import rospy
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseArray, PoseStamped, Twist, Vector3
from nav_msgs.msg import OccupancyGrid, Odometry, Path
from rosgraph_msgs.msg import Log
from sensor_msgs.msg import BatteryState as Battery
from std_msgs.msg import Bool, String
from std_srvs.srv import SetBool, Trigger
from tf2_msgs.msg import TFMessage

from ..errors import PioneerError, RefusedError
from ..message_values import GripCommand, LiftCommand
from ..msg import (BatteryState, Bumpers, Decision, GripperState, GripState, Helm, LiftState, MotorState, Navigation,
                   Places, RobotInfo, SonarArray, Stall)
from .backend import REPEAT, Feed, Stage, StatusPace
from .frames import FrameFlags, encode_frame, stamp_of
from .from_messages import SHARED, TOPICS, RobotPicture, WorldPicture, diagnosed, namespace_of, shared_name
from .graph_navigation import GraphNavigation
from .orders import NavigationOrder
from .trail import Trail

CLASSES = {each.__name__: each for each in (
    Odometry, SonarArray, MotorState, Bool, Stall, Bumpers, GripperState, Decision, RobotInfo, Helm, OccupancyGrid,
    String, PoseArray, PoseStamped, TFMessage, Navigation, Path, Places)}
"""The classes of messages by the last part of their type."""
OF_TOPIC = {"battery": Battery, "battery_state": BatteryState}
"""The classes of topics whose types differ only in their packages."""
PERSON = "teleop/cmd_vel"
LOST = 2.0
"""Time (s) without a pose after which the link counts as lost."""
RATE_OVER = 4.0         # s over which poses are counted
LOOK_EVERY = 1.0        # s between two looks at the graph
WITH_SONAR = 0.3        # s after a sonar message in which a frame waits for the next one, which follows its pose
SERVICE_PATIENCE = 3.0  # s
GRIPPER = {
    "open": (GripCommand.OPEN, 0), "close": (GripCommand.CLOSE, 0), "up": (0, LiftCommand.UP),
    "down": (0, LiftCommand.DOWN), "stop": (GripCommand.HALT, 0), "deploy": (GripCommand.DEPLOY, 0),
    "store": (GripCommand.STORE, 0)}
"""The commands of the page to a gripper, as the states of paddles and lift; 0 leaves a part alone."""


class GraphRobot:
    """One robot of the graph: it feeds the page, and obeys the seats (it is their Controls).

    Args:
        number: its number for the page.
        namespace: its namespace, without slashes at its ends.
        feed: takes frames, at once and from any thread.
        stage: told what happens.
    """

    def __init__(self, number: int, namespace: str, feed: Feed, stage: Stage) -> None:
        self.number, self.namespace = number, namespace
        self.picture = RobotPicture(number, namespace)
        self.trail = Trail()
        self.introduced = False
        self.asked: Optional[int] = None
        self._feed, self._stage = feed, stage
        self._lock = threading.Lock()
        self._framed_at = self._sonar_at = -math.inf
        self._frame_due = False
        self._pace = StatusPace()
        self._poses: List[float] = []
        self._prefix = prefix = "/%s/" % namespace if namespace else "/"
        self._velocity = rospy.Publisher(prefix + PERSON, Twist, queue_size=1, tcp_nodelay=True)
        self._stop_all = rospy.Publisher(prefix + "stop_all", Bool, queue_size=1, tcp_nodelay=True)
        self._gripper = rospy.Publisher(prefix + "teleop/gripper_control", GripperState, queue_size=1)
        self._navigation = GraphNavigation(prefix, self.picture.navigation, self._call)
        self._subscribers = [
            rospy.Subscriber(prefix + name, OF_TOPIC.get(name) or CLASSES[topic.type], self._hear, name,
                             queue_size=5, tcp_nodelay=True)
            for name, topic in TOPICS.items()]

    def start(self) -> None:
        """Nothing: it listens since it was made."""

    def close(self, wait: bool = True) -> None:
        """Listen no more, and publish no more. The owner has stopped what persons drive."""
        for each in (*self._subscribers, self._velocity, self._stop_all, self._gripper, self._navigation):
            each.unregister()

    # What is shown

    @property
    def entry(self) -> Dict[str, Any]:
        """The entry of this robot in the text ``robots``."""
        return self.picture.entry("/" + self.namespace)

    @property
    def limits(self) -> Tuple[float, float]:
        """The robot's own limits (m/s, rad/s)."""
        entry = self.entry
        return entry["max_linear"], entry["max_angular"]

    def hear_diagnostics(self, task: str, level: int, text: str) -> None:
        """Take one task of the diagnostics of this robot. Any thread may call it."""
        with self._lock:
            self.picture.take_diagnostics(task, level, text)
            happened = self._happened()
        self._tell(happened)

    def hear_log(self, level: int, text: str) -> None:
        """Take what a node of this robot logged. Any thread may call it."""
        with self._lock:
            self.picture.take_log(level, text)
            happened = self._happened()
        self._tell(happened)

    def repeat(self, now: float) -> None:
        """Send the last frame again, with its age, if none was sent for REPEAT s, or one waits for its sonar."""
        with self._lock:
            if now - self._framed_at >= REPEAT or self._frame_due:
                self._send_frame(now)
            self._tell_navigation(now)

    def status(self, now: float) -> Optional[Dict[str, Any]]:
        """Return the text ``status`` if it is time to tell a new one; else None."""
        if not self._pace.is_due(now):
            return None
        with self._lock:
            silent = now - self.picture.pose_at
            self._poses = [time for time in self._poses if now - time < RATE_OVER]
            lost = "" if silent < LOST else "no pose has come for %.0f s: does its driver run?" % min(silent, 9999.0)
            status = self.picture.status(now, "looking for the robot" if lost else "ok", lost,
                                         len(self._poses) / RATE_OVER)
        return self._pace.take(status, now, "counts", "lost")

    def _hear(self, message: Any, name: str) -> None:
        now = monotonic()
        with self._lock:
            before = self.picture.helm
            try:
                self.picture.take(name, message, now)
            except (ValueError, TypeError) as error:
                rospy.logwarn_throttle(10.0, "%s is not shown: %s" % (name, error))
                return
            if name == "pose":
                place = message.pose.pose.position
                self.trail.go(place.x, place.y)
                self._poses.append(now)
                self._frame_due = True
            elif name == "sonar":
                self._sonar_at = now
            if self._frame_due and (name == "sonar" or now - self._sonar_at > WITH_SONAR):
                self._send_frame(now)
            happened = self._happened()
        self._tell(happened)
        if name == "robot_info" or name == "helm" and message != before or name == "pose" and not self.introduced:
            self._stage.changed(self)

    def _tell_navigation(self, now: float) -> None:
        """Tell what has changed of navigation, while the lock is held."""
        if self.introduced:
            for kind, value in self.picture.navigation.changes(now):
                self._feed.text(kind, value, self.number)

    def _happened(self) -> List[Any]:
        happened, self.picture.happened = self.picture.happened, []
        return happened

    def _tell(self, happened: List[Any]) -> None:
        for each in happened:
            if each.kind != "decision":
                self._stage.tell(self, each.level, each.text)

    def _send_frame(self, now: float) -> None:
        """Send a frame, while the lock is held."""
        self._frame_due = False
        if self.introduced and self.picture.pose_at > 0:
            self._framed_at = now
            frame = self.picture.frame(stamp_of(now), now)
            if now - self.picture.pose_at > LOST:
                frame = frame._replace(flags=frame.flags & ~FrameFlags.LINK, linear=0.0, angular=0.0)
            try:
                self._feed.frame(encode_frame(frame))
            except PioneerError as error:   # a pose that no robot has
                rospy.logwarn_throttle(10.0, "/%s is not shown: %s" % (self.namespace, error))

    # Controls

    def drive(self, linear: float, angular: float) -> None:
        """Drive for teleop_timeout. See Controls.drive()."""
        if not self._velocity.get_num_connections():
            raise RefusedError("nobody listens on /%s/%s: this robot's driver takes no commands of a person" % (
                self.namespace, PERSON))
        self._velocity.publish(Twist(linear=Vector3(x=linear), angular=Vector3(z=angular)))

    def stop(self) -> None:
        """End what drive() began, at once."""
        self._velocity.publish(Twist())

    def lock(self) -> None:
        """Stop, and let nothing but zero through."""
        self._stop_all.publish(True)

    def unlock(self) -> None:
        """Take the lock away."""
        self._stop_all.publish(False)

    def motors(self, on: bool) -> None:
        """Ask for motors on or off. What the driver answers comes as a sentence."""
        self._call("set_motors", SetBool, on)

    def gripper(self, command: str) -> None:
        """Give the gripper one of orders.GRIPPER_COMMANDS."""
        grip, lift = GRIPPER[command]
        self._gripper.publish(GripperState(grip=GripState(state=grip), lift=LiftState(state=lift)))

    def take(self) -> None:
        """Stop what programs do, and lock them out."""
        self._velocity.publish(Twist())

    def release(self) -> None:
        """Let programs command again."""
        self._call("teleop/release", Trigger)

    def navigate(self, order: NavigationOrder) -> None:
        """Pass an order on to navigation. What it answers comes as a sentence."""
        self._navigation.navigate(order)

    @property
    def locks(self) -> Tuple[str, ...]:
        """Why the robot stands whatever it is told."""
        helm = self.picture.helm
        return () if helm is None else tuple(helm.locks)

    @property
    def programs(self) -> str:
        """Whether programs may command, as the driver says it."""
        helm = self.picture.helm
        if helm is not None and helm.programs_locked_out:
            return "locked out"
        return "driving" if helm is not None and helm.commander not in ("", PERSON) else "free"

    def _call(self, name: str, kind: Any, *values: Any) -> None:
        """Call a service of the robot in a thread of its own, and say what it answers if it fails."""
        def call() -> None:
            service = rospy.ServiceProxy(self._prefix + name, kind)
            try:
                service.wait_for_service(SERVICE_PATIENCE)
                answer = service(*values)
                if not answer.success:
                    self._stage.tell(self, "error", answer.message)
            except (rospy.ROSException, rospy.ServiceException, OSError) as error:
                self._stage.tell(self, "error", "%s: %s" % (service.resolved_name, error))

        threading.Thread(target=call, daemon=True).start()


class Graph:
    """Finds the robots of the graph, and tells about the world that they share.

    Args:
        feed: takes frames and texts, at once and from any thread.
        stage: told what happens to robots.
        wanted: the namespaces of the robots to show. Empty: all.
    """

    def __init__(self, feed: Feed, stage: Stage, wanted: Tuple[str, ...] = ()) -> None:
        self.robots: Dict[str, GraphRobot] = {}
        """By namespace."""
        self._feed, self._stage, self._wanted = feed, stage, wanted
        self._next_number = 1
        self._world = WorldPicture()
        self._lock = threading.Lock()
        self._shared: Dict[str, rospy.Subscriber] = {}
        self._looked_at = -math.inf
        rospy.Subscriber("/diagnostics", DiagnosticArray, self._hear_diagnostics, queue_size=20)
        rospy.Subscriber("/rosout_agg", Log, self._hear_log, queue_size=50)

    def look(self, now: float) -> bool:
        """Look at the graph, if it is time: take robots that came, let go of those that went, and tell goals.

        Returns whether there are other robots now. It waits for the master, but not for long.
        """
        if now - self._looked_at < LOOK_EVERY:
            return False
        self._looked_at = now
        try:
            topics = {topic: kind for topic, kind in rosgraph.Master(rospy.get_name()).getTopicTypes()}
            published = {topic for topic, _ in rosgraph.Master(rospy.get_name()).getSystemState()[0]}
        except (OSError, rosgraph.MasterException):
            return False    # it restarts, perhaps: what is known stays
        self._share({topic: kind for topic, kind in topics.items() if topic in published})
        found = {topic.strip("/").rpartition("/")[0] for topic in published
                 if topic.rpartition("/")[2] == "pose" and topics.get(topic) == Odometry._type}
        found = {namespace for namespace in found if not self._wanted or namespace in self._wanted}
        for namespace in sorted(found - set(self.robots)):
            self.robots[namespace] = GraphRobot(self._next_number, namespace, self._feed, self._stage)
            self._next_number += 1
        gone: Set[str] = set(self.robots) - found
        for namespace in gone:
            self.robots.pop(namespace).close()
        self.tell()
        return bool(gone) or any(not robot.introduced for robot in self.robots.values())

    def _share(self, topics: Dict[str, str]) -> None:
        """Subscribe to new topics that all robots share."""
        for topic, kind in topics.items():
            name = shared_name(topic, kind)
            if name and topic not in self._shared:
                self._shared[topic] = rospy.Subscriber(topic, CLASSES[SHARED[name].type], self._hear, name,
                                                       queue_size=20)

    def _hear(self, message: Any, name: str) -> None:
        with self._lock:
            try:
                self._world.take(name, message, monotonic())
            except (ValueError, TypeError) as error:
                rospy.logwarn_throttle(10.0, "%s is not shown: %s" % (name, error))
                return
            self._tell()

    def tell(self) -> None:
        """Tell what has changed of the world. The owner calls it when robots come."""
        with self._lock:
            self._tell()

    def _tell(self) -> None:
        for kind, value in self._world.changes([robot.picture for robot in list(self.robots.values())]):
            self._feed.text(kind, value)

    def _hear_diagnostics(self, message: Any) -> None:
        for each in diagnosed(message):
            robot = self.robots.get(each.namespace)
            if robot is not None:
                robot.hear_diagnostics(each.task, each.level, each.text)

    def _hear_log(self, message: Any) -> None:
        robot = self.robots.get(namespace_of(message.name))
        if robot is not None:
            robot.hear_log(message.level, message.msg)
