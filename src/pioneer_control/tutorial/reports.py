"""What a robot reports, as its topics bring it, and how long a program has waited for that."""

import math
import threading
import time
from collections import deque
from typing import Any, Callable, Deque, Iterable, Tuple

import rospy
from nav_msgs.msg import Odometry
from std_msgs.msg import Bool

from ..message_values import heading_of
from ..msg import GripperState, MotorState, RobotInfo, SonarArray, Stall
from ..robots import Transducer
from .sights import KEPT, Sight, Sights
from .snapshot import Grip, Heard, Lift, Pose, RobotShape

MOTORS_ON = 1  #: of motor_state and cmd_motor_state
LINK_LOST = 1.0  #: s without a pose: the link was down, and the driver has switched the motors off
NO_STEP = 0.5  #: m; a pose that is farther from the one before has been reset


class Stopwatch:
    """Call it: seconds that have passed since it was made, in real time or in ROS time, whichever shows less.

    So a program waits longer where ROS time is slow or paused, and not shorter where it is fast. A jump back of ROS
    time changes nothing.
    """

    def __init__(self) -> None:
        self._began, self._ros, self._last = time.monotonic(), 0.0, rospy.get_time()

    def __call__(self) -> float:
        now = rospy.get_time()
        self._ros, self._last = self._ros + max(0.0, now - self._last), now
        return min(self._ros, time.monotonic() - self._began)


class Reports:
    """The newest that a robot reported, `heard`, and the `sights` that nobody has decided on yet."""

    def __init__(self, prefix: str, known: Heard):
        """Subscribe to the robot's topics, which begin with `prefix`. What is `known` counts until the robot speaks."""
        self.heard = known
        self.sights: Deque[Tuple[float, Sight]] = deque(maxlen=KEPT)  #: each with when it came [s], monotonic
        self._sights = Sights()
        self._news = threading.Condition()
        self._ended = False
        self._subscribers = [  # those of the sights without a queue_size: then rospy drops no message
            rospy.Subscriber(prefix + "pose", Odometry, self._hear_pose),
            rospy.Subscriber(prefix + "sonar", SonarArray, self._hear_sonar),
            rospy.Subscriber(prefix + "stall", Stall, self._hear_stall),
            rospy.Subscriber(prefix + "gripper_state", GripperState, self._hear_gripper, queue_size=1),
            rospy.Subscriber(prefix + "motor_state", MotorState, self._hear_motors, queue_size=1),
            rospy.Subscriber(
                prefix + "e_stop", Bool, lambda message: self._hear(stop_button=message.data), queue_size=1),
            rospy.Subscriber(prefix + "robot_info", RobotInfo, self._hear_info, queue_size=1),
        ]

    def why_motors_off(self) -> str:
        """Why the motors are off, as far as the robot tells, and what to do."""
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
        """Wait until something heard makes `condition` true.

        The condition is asked while nothing can be heard: it must not ask others, who may not answer.

        Args:
            condition: is asked after each message.
            timeout: s.
            clock: tells how much time has passed [s].

        Returns:
            Whether it became true in time.

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
        """Whoever waits stops waiting. A signal handler may call it: it takes no lock."""
        self._ended = True

    def _hear(self, sights: Iterable[Sight] = (), **what: Any) -> None:
        """Take `what` a message tells, and the sights that it completes."""
        with self._news:
            self.sights.extend((time.monotonic(), sight) for sight in sights)
            self.heard = self.heard._replace(**what)
            self._news.notify_all()

    def _hear_pose(self, message: Odometry) -> None:
        position, turn = message.pose.pose.position, message.pose.pose.orientation
        pose = Pose(position.x, position.y, heading_of(turn.x, turn.y, turn.z, turn.w))
        now = time.monotonic()
        with self._news:
            sights = self._sights.hear_pose(message.header.stamp.to_nsec(), pose, rospy.Time.now().to_nsec())
            driven, silence = self.heard.driven, self.heard.silence
            if self.heard.pose is not None:
                step = math.hypot(pose.x - self.heard.pose.x, pose.y - self.heard.pose.y)
                driven += step if step < NO_STEP else 0.0
                silence = max(silence, now - self.heard.pose_time)
            self._hear(sights, pose=pose, pose_time=now, driven=driven, silence=silence)

    def _hear_sonar(self, message: SonarArray) -> None:
        ranges = tuple(message.ranges)
        with self._news:
            self._hear(self._sights.hear_sonar(message.header.stamp.to_nsec(), ranges),
                       ranges=ranges, ranges_time=time.monotonic())

    def _hear_stall(self, message: Stall) -> None:
        stalled = message.left or message.right
        with self._news:
            sights = self._sights.hear_stall(message.header.stamp.to_nsec(), stalled)
            begins = stalled and not self.heard.stalled and self.heard.motors
            self._hear(sights, stalled=stalled, stalls=self.heard.stalls + bool(begins))

    def _hear_gripper(self, message: GripperState) -> None:
        grip, lift = message.grip, message.lift
        self._hear(
            grip=Grip(
                grip.state, grip.dir, grip.inner_beam, grip.outer_beam, grip.left_contact, grip.right_contact),
            lift=Lift(lift.state, lift.dir, lift.position))

    def _hear_motors(self, message: MotorState) -> None:
        motors = message.state == MOTORS_ON
        self._hear(motors=motors, silence=0.0 if motors else self.heard.silence)

    def _hear_info(self, message: RobotInfo) -> None:
        self._hear(has_gripper=message.has_gripper, robot=RobotShape(
            [Transducer(number, pose.x, pose.y, pose.theta)
             for number, pose in zip(message.sonar_numbers, message.sonar_poses)],
            [(point.x, point.y) for point in message.footprint.points]))
