"""The class `Pioneer`: a robot as a program of its user sees it, over ROS topics only.

::

    init_node("mine")                      # of ros_node: a program that uses rospy's own may hang at Ctrl-C, though its robot stands
    with Pioneer("pioneer") as robot:      # waits for the driver, has the motors switched on
        robot.wander(20)
        if robot.pick():
            print("got one")
                                           # stands still, however this block is left
"""

import math
import threading
import time
from enum import Enum
from typing import Callable, List, Optional, Tuple

import genpy
import rosgraph
import rospy
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry

from pioneer_control.errors import NoAnswerError, NotConfirmedError, RefusedError, UsageError
from pioneer_control.message_values import GripCommand, LiftCommand, heading_of
from pioneer_control.msg import GripperState, MotorState, RobotInfo, SonarArray
from pioneer_control.tutorial.pick import CLOSE, LOWER, OPEN, PICK, RAISE, Outcome, Step, holds, judge
from pioneer_control.tutorial.sender import Sender
from pioneer_control.tutorial.snapshot import Grip, Heard, Lift, Pose, RobotShape, Snapshot, Transducer
from pioneer_control.tutorial.wander import SPEED, Memory, wander

CONNECT_TIMEOUT = 15.0  #: s for driver and first data; a robot may need ten to answer
LISTENERS_TIMEOUT = 2.0  #: s for others than the driver; one that has died without a word never connects
MOTORS_TIMEOUT = 5.0  #: s for the robot to report that its motors are on
STEP_TIMEOUT = 10.0  #: s for one movement of the gripper; the slowest takes 3.5
ASK_AGAIN = 0.5  #: s between two requests for the motors
NEXT_SONAR = 0.25  #: s to wait for a sonar message before deciding without
MOTORS_ON = 1  #: of cmd_motor_state and motor_state


class WanderEnd(Enum):
    """Why a wander ended."""

    TIME_UP = "the time is up"
    AT_CAN = "something stands between the paddles"


class Pioneer:
    """One robot: `pose`, `ranges`, `grip` and `lift` as reported, `wander`, `pick`, `stop` and the gripper's movements.

    Nothing is published before the first command, and the robot stands still after `close`, at the end of a ``with``
    block, and when ROS shuts down (Ctrl-C, ``rosnode kill``).
    """

    def __init__(self, namespace: str = "pioneer", *, speed: float = SPEED, seed: Optional[int] = None):
        """Subscribe to the topics below `namespace`. `speed` [m/s] and `seed` are those of `wander`.

        Raises UsageError for a speed that is not above 0.
        """
        self._namespace, self._speed = namespace, _above_zero("speed", speed, "m/s")
        self._seed = int(time.time()) if seed is None else seed
        self._heard = Heard()
        self._news = threading.Condition()
        self._driving = self._closed = False
        self._velocity = rospy.Publisher(self._name("cmd_vel"), Twist, queue_size=1)
        self._motors = rospy.Publisher(self._name("cmd_motor_state"), MotorState, queue_size=1)
        self._gripper = rospy.Publisher(self._name("gripper_control"), GripperState, queue_size=2)
        self._sender = Sender(self._velocity, Twist())
        self._subscribers = [
            rospy.Subscriber(self._name("pose"), Odometry, self._hear_pose, queue_size=1),
            rospy.Subscriber(self._name("sonar"), SonarArray, self._hear_sonar, queue_size=1),
            rospy.Subscriber(self._name("gripper_state"), GripperState, self._hear_gripper, queue_size=1),
            rospy.Subscriber(self._name("motor_state"), MotorState, self._hear_motors, queue_size=1),
            rospy.Subscriber(self._name("robot_info"), RobotInfo, self._hear_info, queue_size=1),
        ]
        rospy.on_shutdown(self.close)

    def __enter__(self) -> "Pioneer":
        self.wait_until_ready()
        self.enable_motors()
        return self

    def __exit__(self, *exception) -> None:
        self.close()

    # What the robot reports

    @property
    def pose(self) -> Optional[Pose]:
        """Where odometry believes the robot is (m, rad)."""
        return self._heard.pose

    @property
    def ranges(self) -> Optional[Tuple[float, ...]]:
        """The sonars' ranges [m], by number; 0.0 is "not heard"."""
        return self._heard.ranges

    @property
    def grip(self) -> Optional[Grip]:
        """The paddles; None without a gripper."""
        return self._heard.grip

    @property
    def lift(self) -> Optional[Lift]:
        """The lift of the gripper; None without one."""
        return self._heard.lift

    @property
    def has_gripper(self) -> bool:
        """Is a gripper fitted?"""
        return self._heard.has_gripper

    def snapshot(self) -> Snapshot:
        """All that is known now, of one moment. Raises NoAnswerError before pose, sonar and robot_info have arrived."""
        return self._heard.snapshot(time.monotonic())

    # Getting ready

    def wait_until_ready(self, timeout: float = CONNECT_TIMEOUT) -> None:
        """Wait until the driver listens and everything has arrived once. Raises NoAnswerError that says what is missing."""
        if self._wait(lambda: not self._missing(), timeout):
            self._wait(self._all_connected, LISTENERS_TIMEOUT)
            return
        raise NoAnswerError(
            "after %.0f s still no %s. Does the driver run (roslaunch pioneer_control pioneer.launch sim:=true, or with the "
            "port of your robot), and in this namespace?" % (timeout, ", ".join(self._missing())))

    def enable_motors(self, timeout: float = MOTORS_TIMEOUT) -> None:
        """Ask for the motors until the robot reports that they are on. Raises NotConfirmedError if it does not."""
        end = time.monotonic() + timeout
        while not self._heard.motors:
            if time.monotonic() > end:
                raise NotConfirmedError(
                    "the motors stay off after %.0f s of asking. Is the STOP button of the robot pressed? Release it and start again; "
                    "the driver's log tells more." % timeout)
            self._send(self._motors, MotorState(state=MOTORS_ON))
            self._wait(lambda: self._heard.motors, ASK_AGAIN)

    def _all_connected(self) -> bool:
        """Is everybody connected who listens to our commands? A recorder that is not yet would miss the first of them."""
        _, subscribers, _ = rosgraph.Master(rospy.get_name()).getSystemState()
        listeners = {topic: len(nodes) for topic, nodes in subscribers}
        commands = self._velocity, self._motors, self._gripper
        return all(each.get_num_connections() >= listeners.get(each.resolved_name, 0) for each in commands)

    def _missing(self) -> List[str]:
        heard = self._heard
        needed = [
            ("listener on %s" % self._velocity.resolved_name, self._velocity.get_num_connections()),
            ("listener on %s" % self._motors.resolved_name, self._motors.get_num_connections()),
            (self._name("robot_info"), heard.robot),
            (self._name("pose"), heard.pose),
            (self._name("motor_state"), heard.motors is not None),
            (self._name("sonar (is use_sonar on?)"), heard.ranges),
            (self._name("gripper_state"), heard.grip or not self.has_gripper),
        ]
        return [name for name, there in needed if not there]

    # Driving

    def drive(self, linear: float, angular: float) -> None:
        """Command a velocity [m/s, rad/s]. The driver stops the robot when it is not repeated within 0.6 s.

        Raises UsageError for what is not a finite number, and RefusedError while the motors are off: nobody but
        `enable_motors` switches them on again.
        """
        twist = Twist()
        twist.linear.x, twist.angular.z = _finite("linear", linear, "m/s"), _finite("angular", angular, "rad/s")
        if not self._heard.motors:
            raise RefusedError("the robot's motors are off, it does not drive. Was its STOP button pressed? Release it and start again")
        self._driving = True
        self._send(self._velocity, twist)

    def stop(self) -> None:
        """Stand still. Does nothing unless this program drives."""
        if self._driving:
            self._sender.send(self._velocity, Twist())
            self._driving = False

    def wander(self, duration: float = 20.0, *, stop_at_can: bool = True) -> WanderEnd:
        """Drive about for `duration` seconds of ROS time and touch nothing, then stop.

        With nothing held the paddles are first opened and lowered; then, if `stop_at_can`, what breaks the outer beam ends the wander.
        Raises UsageError for a duration that is not above 0.
        """
        _above_zero("duration", duration, "s")
        rospy.loginfo("wander, for %g s at most", duration)
        self._show_paddles()
        memory = Memory(seed=self._seed, speed=self._speed)
        narrator = Narrator()
        end = rospy.get_time() + duration
        try:
            while rospy.get_time() < end:
                snapshot = self._next_snapshot()
                if stop_at_can and snapshot.grip and snapshot.grip.outer and not holds(snapshot.grip):
                    return self._ended(WanderEnd.AT_CAN)
                command, memory = wander(snapshot, memory)
                self.drive(command.linear, command.angular)
                narrator.tell(command.reason)
            return self._ended(WanderEnd.TIME_UP)
        finally:
            self._seed = memory.seed
            self.stop()

    def _ended(self, end: WanderEnd) -> WanderEnd:
        self.stop()
        rospy.loginfo("stopped: %s", end.value)
        return end

    def _next_snapshot(self) -> Snapshot:
        """Wait for the next sonar message and the pose that comes with it, but not for ever: what is old tells its age."""
        last = self._heard
        self._wait(lambda: self._heard.ranges_time != last.ranges_time and self._heard.pose_time != last.pose_time, NEXT_SONAR)
        return self.snapshot()

    def _show_paddles(self) -> None:
        if self.has_gripper and not holds(self.grip):
            self.gripper_open()
            self.gripper_lower()

    # The gripper

    def gripper_lower(self) -> Outcome:
        """Lower the lift, and wait until it is down."""
        return self._step(LOWER)

    def gripper_open(self) -> Outcome:
        """Open the paddles, and wait until they are."""
        return self._step(OPEN)

    def gripper_close(self) -> Outcome:
        """Close the paddles, and wait until they are, on nothing or on an object."""
        return self._step(CLOSE)

    def gripper_raise(self) -> Outcome:
        """Raise the lift, and wait until it is up."""
        return self._step(RAISE)

    def pick(self) -> bool:
        """Lower, open, close, raise; True when an object is held then. What was held before is put down first."""
        if not self.has_gripper:
            rospy.loginfo("cannot pick: this robot has no gripper")
            return False
        rospy.loginfo("pick: an object is held already, and put down first" if holds(self.grip) else "pick")
        for step in PICK:
            if not self._step(step).succeeded:
                rospy.logwarn("the pick ends here: the gripper did not %s in time", step.name)
                return False
        held = holds(self.grip)
        rospy.loginfo("picked: an object is held" if held else "picked nothing: the paddles closed on air")
        return held

    def _step(self, step: Step) -> Outcome:
        outcome = judge(step, self.grip, self.lift, commanded=False)
        if outcome is None:
            self._command_gripper(step.grip, step.lift)
            self._wait(lambda: judge(step, self.grip, self.lift, commanded=True), STEP_TIMEOUT)
            outcome = judge(step, self.grip, self.lift, commanded=True)
        if outcome is None:
            self._command_gripper(GripCommand.STOP, LiftCommand.STOP)
            outcome = Outcome.TIMED_OUT
        rospy.loginfo("gripper, %s: %s", step.name, outcome.value)
        return outcome

    def _command_gripper(self, grip: GripCommand, lift: LiftCommand) -> None:
        message = GripperState()
        message.grip.state, message.lift.state = grip, lift
        self._send(self._gripper, message)

    # The end

    def close(self) -> None:
        """Stand still and command nothing any more. Also called when ROS shuts down."""
        self._closed = True
        self._sender.end()

    def _send(self, publisher: rospy.Publisher, message: genpy.Message) -> None:
        self._check_open()
        self._sender.send(publisher, message)

    def _check_open(self) -> None:
        if self._closed or rospy.is_shutdown():
            raise rospy.ROSInterruptException("this program is ending and drives the robot no more")

    # Listening

    def _wait(self, condition: Callable[[], object], timeout: float) -> bool:
        """Wait until something heard makes `condition` true: whether it did within `timeout` seconds of real time."""
        end = time.monotonic() + timeout
        with self._news:
            while not condition():
                left = end - time.monotonic()
                if left <= 0:
                    return False
                self._check_open()
                self._news.wait(min(left, 0.1))
        return True

    def _hear(self, **what) -> None:
        with self._news:
            self._heard = self._heard._replace(**what)
            self._news.notify_all()

    def _hear_pose(self, message: Odometry) -> None:
        position, turn = message.pose.pose.position, message.pose.pose.orientation
        self._hear(pose=Pose(position.x, position.y, heading_of(turn.x, turn.y, turn.z, turn.w)), pose_time=time.monotonic())

    def _hear_sonar(self, message: SonarArray) -> None:
        self._hear(ranges=tuple(message.ranges), ranges_time=time.monotonic())

    def _hear_gripper(self, message: GripperState) -> None:
        grip, lift = message.grip, message.lift
        self._hear(
            grip=Grip(grip.state, grip.dir, grip.inner_beam, grip.outer_beam, grip.left_contact, grip.right_contact),
            lift=Lift(lift.state, lift.dir, lift.position),
        )

    def _hear_motors(self, message: MotorState) -> None:
        self._hear(motors=message.state == MOTORS_ON)

    def _hear_info(self, message: RobotInfo) -> None:
        transducers = [
            Transducer(number, pose.x, pose.y, pose.theta) for number, pose in zip(message.sonar_numbers, message.sonar_poses)]
        footprint = [(point.x, point.y) for point in message.footprint.points]
        self._hear(has_gripper=message.has_gripper, robot=RobotShape(transducers, footprint))

    def _name(self, topic: str) -> str:
        return "%s/%s" % (self._namespace.rstrip("/"), topic) if self._namespace else topic


class Narrator:
    """Tells people what the robot does: each kind of reason once, when it begins."""

    def __init__(self):
        self._told = ""

    def tell(self, reason: str) -> None:
        """Log a reason if what stands before its colon is new."""
        headline = reason.partition(":")[0]
        if headline != self._told:
            rospy.loginfo("%s", reason)
            self._told = headline


def _finite(name: str, value: float, unit: str) -> float:
    """The value, if it is a finite number. Raises UsageError that says what it is instead."""
    if isinstance(value, (int, float)) and math.isfinite(value):
        return value
    raise UsageError("%s is %r: it must be a finite number (%s)" % (name, value, unit))


def _above_zero(name: str, value: float, unit: str) -> float:
    """The value, if it is a number above 0. Raises UsageError that says what it is instead."""
    if isinstance(value, (int, float)) and 0 < value < math.inf:
        return value
    raise UsageError("%s is %r: it must be a number above 0 (%s)" % (name, value, unit))
