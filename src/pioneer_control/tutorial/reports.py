"""Subscribes to the topics of the robot, keeps the newest data, and lets a program wait for data with a time-out."""

import math
import threading
import time
from collections import deque
from typing import Any, Callable, Deque, Iterable, Tuple

import rospy
from nav_msgs.msg import Odometry
from std_msgs.msg import Bool

from ..floor_poses import Pose
from ..message_values import heading_of
from ..msg import GripperState, MotorState, RobotInfo, SonarArray, Stall
from ..robots import Transducer
from .sights import KEPT, Sight, Sights
from .snapshot import Grip, Heard, Lift, RobotShape

MOTORS_ON = 1  #: the value of `state` in messages on motor_state and cmd_motor_state when motors are on
LINK_LOST = 1.0  #: s without a pose after which the link counts as down; then the driver has switched the motors off
NO_STEP = 0.5  #: m; when the pose changes by more than this between two messages, odometry was reset


class Stopwatch:
    """A stopwatch that starts when it is made. Call the object to get the seconds that have passed.

    It measures real time and ROS time, and returns the shorter time. So a time-out lasts longer when simulated time is
    slow or paused, but not shorter when simulated time is fast. When ROS time jumps back, the jump does not count.
    """

    def __init__(self) -> None:
        self._began, self._ros, self._last = time.monotonic(), 0.0, rospy.get_time()

    def __call__(self) -> float:
        now = rospy.get_time()
        self._ros, self._last = self._ros + max(0.0, now - self._last), now
        return min(self._ros, time.monotonic() - self._began)


class Reports:
    """Subscribes to the topics of one robot.

    Attributes:
        heard: the newest data of every topic.
        sights: a queue of (arrival time, `Sight`) pairs that still wait for a decision. The time is monotonic (s).
    """

    def __init__(self, prefix: str, known: Heard):
        """Subscribe to the topics whose names begin with `prefix`. Messages replace the values that are in `known`."""
        self.heard = known
        self.sights: Deque[Tuple[float, Sight]] = deque(maxlen=KEPT)  #: (arrival time [s, monotonic], sight)
        self._sights = Sights()
        self._news = threading.Condition()
        self._ended = False
        self._subscribers = [  # pose, sonar and stall have no queue_size: so rospy drops none of their messages
            rospy.Subscriber(prefix + "pose", Odometry, self._take_pose),
            rospy.Subscriber(prefix + "sonar", SonarArray, self._take_sonar),
            rospy.Subscriber(prefix + "stall", Stall, self._take_stall),
            rospy.Subscriber(prefix + "gripper_state", GripperState, self._take_gripper, queue_size=1),
            rospy.Subscriber(prefix + "motor_state", MotorState, self._take_motors, queue_size=1),
            rospy.Subscriber(
                prefix + "e_stop", Bool, lambda message: self._store(stop_button=message.data), queue_size=1),
            rospy.Subscriber(prefix + "robot_info", RobotInfo, self._take_info, queue_size=1),
        ]

    def why_motors_off(self) -> str:
        """Return the likely reason why the motors are off, and what the user can do, as a text."""
        heard, age = self.heard, self.heard.age(time.monotonic())
        if age > LINK_LOST:
            return "the link to the robot is down, it told nothing for %.1f s. The driver's log says why" % age
        if heard.stop_button:
            return "its STOP button is pressed. Release it and start again"
        if heard.silence > LINK_LOST:
            return (
                "the link to the robot was down for %.1f s, and after that its motors stay off until somebody asks for "
                "them. Start again; the driver's log says why it was down" % heard.silence)
        return "was its STOP button pressed? Release it and start again; the driver's log tells more"

    def wait(
            self, condition: Callable[[], object], timeout: float, clock: Callable[[], float] = time.monotonic) -> bool:
        """Wait until `condition` returns true.

        The condition runs while this object holds its lock, so no message can be received meanwhile. It must not wait
        for anything, for example for the ROS master.

        Args:
            condition: a function without arguments. It is called after each message, and at least every 0.1 s.
            timeout: the longest time to wait [s].
            clock: a function that returns a time [s], used for the time-out.

        Returns:
            True when the condition became true, False after the time-out.

        Raises:
            ROSInterruptException: the program ends.
        """
        end = clock() + timeout
        with self._news:
            while not condition():
                left = end - clock()
                if left <= 0:
                    return False
                if self._ended or rospy.is_shutdown():
                    raise rospy.ROSInterruptException("this program is ending")
                self._news.wait(min(left, 0.1))
        return True

    def end(self) -> None:
        """End every call of `wait`. A signal handler may call this method, because it takes no lock."""
        self._ended = True

    def _store(self, sights: Iterable[Sight] = (), **what: Any) -> None:
        """Store new data, and wake up the threads in `wait`.

        Args:
            sights: new `Sight` objects for the queue `sights`.
            what: new values for fields of `heard`.
        """
        with self._news:
            self.sights.extend((time.monotonic(), sight) for sight in sights)
            self.heard = self.heard._replace(**what)
            self._news.notify_all()

    def _take_pose(self, message: Odometry) -> None:
        position, turn = message.pose.pose.position, message.pose.pose.orientation
        pose = Pose(position.x, position.y, heading_of(turn.x, turn.y, turn.z, turn.w))
        now = time.monotonic()
        with self._news:
            sights = self._sights.add_pose(message.header.stamp.to_nsec(), pose, rospy.Time.now().to_nsec())
            driven, silence = self.heard.driven, self.heard.silence
            if self.heard.pose is not None:
                step = math.hypot(pose.x - self.heard.pose.x, pose.y - self.heard.pose.y)
                driven += step if step < NO_STEP else 0.0
                silence = max(silence, now - self.heard.pose_time)
            self._store(sights, pose=pose, pose_time=now, driven=driven, silence=silence)

    def _take_sonar(self, message: SonarArray) -> None:
        ranges = tuple(message.ranges)
        with self._news:
            sights = self._sights.add_sonar(message.header.stamp.to_nsec(), ranges)
            self._store(sights, ranges=ranges, ranges_time=time.monotonic())

    def _take_stall(self, message: Stall) -> None:
        stalled = message.left or message.right
        with self._news:
            sights = self._sights.add_stall(message.header.stamp.to_nsec(), stalled)
            begins = stalled and not self.heard.stalled and self.heard.motors
            self._store(sights, stalled=stalled, stalls=self.heard.stalls + bool(begins))

    def _take_gripper(self, message: GripperState) -> None:
        grip, lift = message.grip, message.lift
        self._store(
            grip=Grip(
                grip.state, grip.dir, grip.inner_beam, grip.outer_beam, grip.left_contact, grip.right_contact),
            lift=Lift(lift.state, lift.dir, lift.position))

    def _take_motors(self, message: MotorState) -> None:
        motors = message.state == MOTORS_ON
        self._store(motors=motors, silence=0.0 if motors else self.heard.silence)

    def _take_info(self, message: RobotInfo) -> None:
        self._store(has_gripper=message.has_gripper, robot=RobotShape(
            [Transducer(number, pose.x, pose.y, pose.theta)
             for number, pose in zip(message.sonar_numbers, message.sonar_poses)],
            [(point.x, point.y) for point in message.footprint.points]))
