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
import operator
import threading
import time
from collections import deque
from typing import Callable, Deque, Iterable, List, Optional, Sequence, Tuple

import genpy
import rosgraph
import rospy
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry

from pioneer_control.errors import NoAnswerError, NotConfirmedError, RefusedError, UsageError
from pioneer_control.message_values import GripCommand, LiftCommand, heading_of
from pioneer_control.msg import Decision, GripperState, MotorState, RobotInfo, SonarArray
from pioneer_control.tutorial.pick import CLOSE, LOWER, OPEN, PICK, RAISE, Outcome, Step, holds, judge
from pioneer_control.tutorial.sender import Sender
from pioneer_control.tutorial.sights import KEPT, Sight, Sights
from pioneer_control.tutorial.snapshot import Command, Grip, Heard, Lift, Pose, RobotShape, Snapshot, Transducer
from pioneer_control.tutorial.wander import SPEED, STALE, no_news
from pioneer_control.tutorial.wandering import WanderEnd, Wandering

CONNECT_TIMEOUT = 15.0  #: s for driver and first data; a robot may need ten to answer
LISTENERS_TIMEOUT = 2.0  #: s for others than the driver; one that has died without a word never connects
MOTORS_TIMEOUT = 5.0  #: s for the robot to report that its motors are on
STEP_TIMEOUT = 10.0  #: s for one movement of the gripper; the slowest takes 3.5
ASK_AGAIN = 0.5  #: s between two requests for the motors
SILENCE = 2.0  #: s without news before that is said: in slow time each message is late
LOOK_AGAIN = 0.25  #: s between two looks whether there is news
MOTORS_ON = 1  #: of cmd_motor_state and motor_state


class Pioneer:
    """One robot: `pose`, `ranges`, `grip` and `lift` as reported, `wander`, `pick`, `stop` and the gripper's movements.

    Nothing is published before the first command, and the robot stands still after `close`, at the end of a ``with``
    block, and when ROS shuts down (Ctrl-C, ``rosnode kill``).
    """

    def __init__(
            self, namespace: str = "pioneer", *, speed: float = SPEED, seed: Optional[int] = None, begin_at: Sequence[float] = (),
            end_at: Sequence[float] = ()):
        """Subscribe to the topics below `namespace`. `speed` [m/s] and `seed` are those of `wander`.

        For a re-run from a bag, `begin_at` and `end_at` are the stamps [s] of the first and the last `decision` of each wander, in their order:
        it then decides on the very messages it decided on live.

        Raises UsageError for a speed that is not above 0, and for a seed that is no whole number.
        """
        self._namespace, self._speed = namespace, _above_zero("speed", speed, "m/s")
        self._seed = int(time.time()) if seed is None else _whole("seed", seed)
        self._begin_at, self._end_at, self._wanders = begin_at, end_at, 0
        self._heard, self._sights = Heard(), Sights()
        self._seen: Deque[Tuple[float, Sight]] = deque(maxlen=KEPT)  # and when [s], monotonic
        self._news = threading.Condition()
        self._driving = self._closed = False
        self._velocity = rospy.Publisher(self._name("cmd_vel"), Twist, queue_size=1)
        self._motors = rospy.Publisher(self._name("cmd_motor_state"), MotorState, queue_size=1)
        self._gripper = rospy.Publisher(self._name("gripper_control"), GripperState, queue_size=2)
        self._decisions = rospy.Publisher(self._name("decision"), Decision, queue_size=0)  # 0: as many as there are, and none is lost
        self._sender = Sender(self._velocity, Twist())
        self._subscribers = [  # those of the decisions without a queue_size: then rospy drops none
            rospy.Subscriber(self._name("pose"), Odometry, self._hear_pose),
            rospy.Subscriber(self._name("sonar"), SonarArray, self._hear_sonar),
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
        return self._heard.snapshot(rospy.get_time(), self._heard.age(time.monotonic()))

    # Getting ready

    def wait_until_ready(self, timeout: float = CONNECT_TIMEOUT) -> None:
        """Wait until the driver listens and everything has arrived once. Raises NoAnswerError that says what is missing."""
        passed = Passed()
        if not rospy.get_time():
            rospy.loginfo("waiting for the time on /clock: use_sim_time is set")
        if not self._wait(lambda: not self._missing(), timeout) and passed() < timeout:
            rospy.logwarn("ROS time stands or is slow (use_sim_time is set): waiting on for %s", ", ".join(self._missing()))
        if self._wait(lambda: not self._missing(), timeout - passed(), passed):
            self._wait(self._all_connected, LISTENERS_TIMEOUT)
            return
        raise NoAnswerError(
            "after %.0f s still no %s. Does the driver run (roslaunch pioneer_control pioneer.launch sim:=true, or with the "
            "port of your robot), and in this namespace?" % (timeout, ", ".join(self._missing())))

    def enable_motors(self, timeout: float = MOTORS_TIMEOUT) -> None:
        """Ask for the motors until the robot reports that they are on. Raises NotConfirmedError if it does not."""
        passed = Passed()
        while not self._heard.motors:
            if passed() > timeout:
                raise NotConfirmedError(
                    "the motors stay off after %.0f s of asking. Is the STOP button of the robot pressed? Release it and start again; "
                    "the driver's log tells more." % timeout)
            self._send(self._motors, MotorState(state=MOTORS_ON))
            self._wait(lambda: self._heard.motors, ASK_AGAIN)

    def _all_connected(self) -> bool:
        """Is everybody connected who listens to us? A recorder that is not yet would miss the first of them."""
        _, subscribers, _ = rosgraph.Master(rospy.get_name()).getSystemState()
        listeners = {topic: len(nodes) for topic, nodes in subscribers}
        ours = self._velocity, self._motors, self._gripper, self._decisions
        return all(each.get_num_connections() >= listeners.get(each.resolved_name, 0) for each in ours)

    def _missing(self) -> List[str]:
        heard = self._heard
        needed = [
            ("/clock", rospy.rostime.is_wallclock() or rospy.get_time()),
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
        Every sonar message is decided on, in order, and told on ``decision``; the robot is told the newest. Raises UsageError for a
        duration that is not above 0.
        """
        _above_zero("duration", duration, "s")
        rospy.loginfo("wander, for %g s at most", duration)
        self._show_paddles()
        wandering = self._begin_wander(duration, stop_at_can)
        try:
            return self._wander(wandering, duration)
        finally:
            self._seed = wandering.memory.seed
            self.stop()

    def _begin_wander(self, duration: float, stop_at_can: bool) -> Wandering:
        """Raises NoAnswerError when the robot has not told enough yet."""
        given = {"begin_at": self._begin_at, "end_at": self._end_at}
        limits = {name: stamps[self._wanders] for name, stamps in given.items() if self._wanders < len(stamps)}
        self._wanders += 1
        self._wait(lambda: self._heard.pose and self._heard.ranges and self._heard.robot, LOOK_AGAIN)
        self.snapshot()
        if "begin_at" not in limits:
            self._seen.clear()
        return Wandering(self._seed, self._speed, duration, stop_at_can=stop_at_can, **limits)

    def _wander(self, wandering: Wandering, duration: float) -> WanderEnd:
        narrator, passed, news = Narrator(), Passed(), time.monotonic()
        while wandering.end is None:
            sight, command, newest = None, None, wandering.newest
            if self._wait(lambda: self._seen, LOOK_AGAIN):
                seen_at, sight = self._seen.popleft()
                command = wandering.decide(sight, self._heard)
                if wandering.newest != newest:
                    news = seen_at
            age = time.monotonic() - news
            if age > STALE:  # also where the stamps stand still: nobody drives on for ever while time is paused
                self.stop()
                if age > SILENCE and not self._seen:    # not while it catches up: what waits is no silence
                    narrator.tell(no_news(age).reason)
                if passed() >= duration and not wandering.waits:
                    return self._ended(WanderEnd.TIME_UP)
            elif command and not self._seen:
                self.drive(command.linear, command.angular)
                narrator.tell(command.reason)
            if command:
                self._tell(wandering, sight, command)
        return self._ended(wandering.end)

    def _tell(self, wandering: Wandering, sight: Sight, command: Command) -> None:
        message = Decision(wander=self._wanders, seed=wandering.seed, speed=wandering.speed, **command._asdict())
        message.header.stamp = rospy.Time(nsecs=sight.stamp)
        self._send(self._decisions, message)

    def _ended(self, end: WanderEnd) -> WanderEnd:
        self.stop()
        rospy.loginfo("stopped: %s", end.value)
        return end

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
            self._wait(lambda: judge(step, self.grip, self.lift, commanded=True), STEP_TIMEOUT, Passed())
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

    def _wait(self, condition: Callable[[], object], timeout: float, clock: Callable[[], float] = time.monotonic) -> bool:
        """Wait until something heard makes `condition` true: whether it did within `timeout` seconds of `clock`."""
        end = clock() + timeout
        with self._news:
            while not condition():
                left = end - clock()
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
        pose, now = Pose(position.x, position.y, heading_of(turn.x, turn.y, turn.z, turn.w)), rospy.Time.now().to_nsec()
        with self._news:
            self._see(self._sights.hear_pose(message.header.stamp.to_nsec(), pose, now))
            self._hear(pose=pose, pose_time=time.monotonic())

    def _hear_sonar(self, message: SonarArray) -> None:
        ranges = tuple(message.ranges)
        with self._news:
            self._see(self._sights.hear_sonar(message.header.stamp.to_nsec(), ranges))
            self._hear(ranges=ranges, ranges_time=time.monotonic())

    def _see(self, sights: Iterable[Sight]) -> None:
        self._seen.extend((time.monotonic(), sight) for sight in sights)

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


class Passed:
    """Seconds that have passed since it was made, in real time and in ROS time, whichever shows less.

    So who waits for a robot waits longer where time is slow or paused, and no shorter where it is fast; a jump back changes nothing.
    """

    def __init__(self):
        self._began, self._ros, self._last = time.monotonic(), 0.0, rospy.get_time()

    def __call__(self) -> float:
        now = rospy.get_time()
        self._ros, self._last = self._ros + max(0.0, now - self._last), now
        return min(self._ros, time.monotonic() - self._began)


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


def _whole(name: str, value: int) -> int:
    """The value, if it is a whole number of 64 bits, as a message holds it. Raises UsageError that says what it is instead."""
    try:
        number = operator.index(value)
    except TypeError:
        number = None
    if number is None or not -2 ** 63 <= number < 2 ** 63:
        raise UsageError("%s is %r: it must be a whole number of at most 64 bits" % (name, value))
    return number


def _above_zero(name: str, value: float, unit: str) -> float:
    """The value, if it is a number above 0. Raises UsageError that says what it is instead."""
    if isinstance(value, (int, float)) and 0 < value < math.inf:
        return value
    raise UsageError("%s is %r: it must be a number above 0 (%s)" % (name, value, unit))
