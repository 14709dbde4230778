"""The class `Pioneer`: a robot as a program of its user sees it, over ROS topics only.

::

    init_node("mine")                      # of pioneer_control.ros_node: with rospy's own a program may hang at Ctrl-C
    with Pioneer("pioneer") as robot:      # waits for the driver, has the motors switched on
        robot.wander(20)
        if robot.pick():
            print("got one")
                                           # stands still, however this block is left
"""

import math
import operator
import time
from contextlib import suppress
from typing import List, Optional, Sequence, Tuple

import rospy

from ..errors import NoAnswerError, NotConfirmedError, RefusedError, UsageError
from ..message_values import GripCommand, LiftCommand
from ..robots import find_model
from .commander import Commander
from .pick import CLOSE, LOWER, OPEN, PICK, RAISE, Outcome, Step, holds, judge
from .reports import Reports, Stopwatch
from .snapshot import Grip, Heard, Lift, Pose, RobotShape, Snapshot
from .wander import SPEED, STALE, can_leave, no_news
from .wandering import WanderEnd, Wandering

CONNECT_TIMEOUT = 15.0  #: s for driver and first data; a robot may need ten to answer
LISTENERS_TIMEOUT = 2.0  #: s for others than the driver; one that has died without a word never connects
MOTORS_TIMEOUT = 5.0  #: s for the robot to report that its motors are on
STEP_TIMEOUT = 10.0  #: s for one movement of the gripper; the slowest takes 3.5
ASK_AGAIN = 0.5  #: s between two requests for the motors
SILENCE = 2.0  #: s without news before that is said: in slow time each message is late
TELL_AGAIN = 15.0  #: s after which the same is told again, with the numbers of now
LOOK_AGAIN = 0.25  #: s between two looks whether there is news


class Pioneer:
    """One robot: `pose`, `ranges`, `grip` and `lift` as reported, `wander`, `pick`, `stop` and the gripper's movements.

    Nothing is published before the first command, and the robot stands still after `close`, at the end of a ``with``
    block, and when ROS shuts down (Ctrl-C, ``rosnode kill``).
    """

    def __init__(
            self, namespace: str = "pioneer", *, speed: float = SPEED, seed: Optional[int] = None, model: str = "",
            gripper: bool = False, begin_at: Sequence[float] = (), end_at: Sequence[float] = ()):
        """Subscribe to the topics below `namespace`.

        Args:
            namespace: the robot's.
            speed: of a wander [m/s].
            seed: of what chance decides in a wander; None: the clock's.
            model: of the robot, for a driver that publishes no ``robot_info``. If one comes, it counts instead.
            gripper: with `model`, is a gripper fitted?
            begin_at: for a re-run from a bag, the stamps [s] of the first ``decision`` of each wander, in their order.
            end_at: likewise the stamps [s] of the last ones. It then decides on the messages it decided on live.

        Raises:
            UsageError: the speed is not above 0, or the seed is no whole number.
            UnknownModelError: there is no such model.
        """
        self._prefix = namespace.rstrip("/") + "/" if namespace else ""
        self._speed = _number("speed", speed, "m/s", above=0)
        self._seed = int(time.time()) if seed is None else _whole("seed", seed)
        self._limits, self._wanders = {"begin_at": begin_at, "end_at": end_at}, 0
        self._leaving = False  # something was put down just before
        known = Heard(robot=RobotShape.of_model(find_model(model)), has_gripper=gripper) if model else Heard()
        self._commander = Commander(self._prefix)
        self._reports = Reports(self._prefix, known)
        rospy.on_shutdown(self.close)

    def __enter__(self) -> "Pioneer":
        self.wait_until_ready()
        self.enable_motors()
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    # What the robot reports

    @property
    def pose(self) -> Optional[Pose]:
        """Where odometry believes the robot is (m, rad)."""
        return self._reports.heard.pose

    @property
    def ranges(self) -> Optional[Tuple[float, ...]]:
        """The sonars' ranges [m], by number; 0.0 is "not heard"."""
        return self._reports.heard.ranges

    @property
    def grip(self) -> Optional[Grip]:
        """The paddles; None without a gripper."""
        return self._reports.heard.grip

    @property
    def lift(self) -> Optional[Lift]:
        """The lift of the gripper; None without one."""
        return self._reports.heard.lift

    @property
    def has_gripper(self) -> bool:
        """Is a gripper fitted?"""
        return self._reports.heard.has_gripper

    @property
    def holding(self) -> bool:
        """Is an object held?"""
        return self.has_gripper and holds(self.grip)

    @property
    def driven(self) -> float:
        """How far the robot went since this program began, by its wheels [m]."""
        return self._reports.heard.driven

    @property
    def stalls(self) -> int:
        """How often its wheels stalled since this program began: something held the robot."""
        return self._reports.heard.stalls

    def snapshot(self) -> Snapshot:
        """All that is known now, of one moment.

        Raises:
            NoAnswerError: pose, sonar and robot_info have not all arrived yet.
        """
        return self._reports.heard.snapshot(rospy.get_time(), self._reports.heard.age(time.monotonic()))

    # Getting ready

    def wait_until_ready(self, timeout: float = CONNECT_TIMEOUT) -> None:
        """Wait until the driver listens and everything has arrived once.

        Raises:
            NoAnswerError: something did not come within `timeout` seconds; it says what.
        """
        passed, wait = Stopwatch(), self._reports.wait
        if not rospy.get_time():
            rospy.loginfo("waiting for the time on /clock: use_sim_time is set")
        if not wait(lambda: not self._missing(), timeout) and passed() < timeout:
            rospy.logwarn(
                "ROS time stands or is slow (use_sim_time is set): waiting on for %s", ", ".join(self._missing()))
        if not wait(lambda: not self._missing(), timeout - passed(), passed):
            raise NoAnswerError("after %.0f s still no %s. %s" % (timeout, ", ".join(self._missing()), self._advice()))
        self._commander.wait_for_listeners(LISTENERS_TIMEOUT)

    def enable_motors(self, timeout: float = MOTORS_TIMEOUT) -> None:
        """Ask for the motors until the robot reports that they are on.

        Raises:
            NotConfirmedError: it does not, within `timeout` seconds.
        """
        passed = Stopwatch()
        while not self._reports.heard.motors:
            if passed() > timeout:
                raise NotConfirmedError(
                    "the motors stay off after %.0f s of asking: %s" % (timeout, self._reports.why_motors_off()))
            self._commander.enable_motors()
            self._reports.wait(lambda: self._reports.heard.motors, ASK_AGAIN)

    def _missing(self) -> List[str]:
        """The topics that this program still waits for."""
        heard = self._reports.heard
        return self._commander.unheard() + [name for name, there in (
            ("/clock", rospy.rostime.is_wallclock() or rospy.get_time()),
            (self._prefix + "robot_info", heard.robot),
            (self._prefix + "pose", heard.pose),
            (self._prefix + "motor_state", heard.motors is not None),
            (self._prefix + "sonar (is use_sonar on?)", heard.ranges),
            (self._prefix + "gripper_state", heard.grip or not self.has_gripper),
        ) if not there]

    def _advice(self) -> str:
        """What to do about what is missing."""
        if self._missing() == [self._prefix + "robot_info"]:
            return (
                "A driver runs, but not this package's: it tells neither the robot's outline nor where its sonars "
                "look. Name the model, and both come from a table: _model:=p3dx-sh, or Pioneer(model=...) in a program "
                "of your own. python3 -m pioneer_control.robots lists the models")
        if not self._commander.unheard() and not self._reports.heard.pose:
            return "A driver listens, but has told nothing of its robot. Has it a link? Its log says why not"
        return (
            "Does the driver run (roslaunch pioneer_control pioneer.launch sim:=true, or with the port of your robot), "
            "and in this namespace?")

    # Driving

    def drive(self, linear: float, angular: float) -> None:
        """Command a velocity [m/s, rad/s]. The driver stops the robot when it is not repeated within 0.6 s.

        Raises:
            UsageError: not a finite number.
            RefusedError: the motors are off. Nobody but `enable_motors` switches them on again.
        """
        linear, angular = _number("linear", linear, "m/s"), _number("angular", angular, "rad/s")
        if not self._reports.heard.motors:
            raise RefusedError("the robot's motors are off, it does not drive: %s" % self._reports.why_motors_off())
        self._commander.drive(linear, angular)

    def stop(self) -> None:
        """Stand still. Does nothing unless this program drives."""
        self._commander.stop()

    def wander(self, duration: float = 20.0, *, stop_at_can: bool = True) -> WanderEnd:
        """Drive about and touch nothing, then stop.

        With nothing held the paddles are first opened and lowered. What `put_down` has put down is left.
        Every sonar message is decided on, in order, and told on ``decision``; the robot is told the newest.

        Args:
            duration: s of ROS time.
            stop_at_can: what breaks the outer beam ends the wander. Not while something is held.

        Returns:
            Why it ended.

        Raises:
            UsageError: the duration is not above 0.
            NoAnswerError: the robot has not told enough yet.
            RefusedError: the motors are off, or go off.
        """
        _number("duration", duration, "s", above=0)
        rospy.loginfo("wander, for %g s at most", duration)
        if self.has_gripper and not self.holding:
            self.gripper_open()
            self.gripper_lower()
        wandering = self._begin_wander(duration, stop_at_can)
        try:
            self._go_on(wandering, duration)
        finally:
            self._seed = wandering.memory.seed
            self.stop()
        end = wandering.end or WanderEnd.TIME_UP
        rospy.loginfo("stopped: %s", end.value)
        return end

    def _begin_wander(self, duration: float, stop_at_can: bool) -> Wandering:
        limits = {name: stamps[self._wanders] for name, stamps in self._limits.items() if self._wanders < len(stamps)}
        self._wanders += 1
        self._reports.wait(lambda: self.pose and self.ranges and self._reports.heard.robot, LOOK_AGAIN)
        self.snapshot()
        if "begin_at" not in limits:
            self._reports.sights.clear()
        leaving, self._leaving = self._leaving, False
        return Wandering(self._seed, self._speed, duration, stop_at_can=stop_at_can, leaving=leaving, **limits)

    def _go_on(self, wandering: Wandering, duration: float) -> None:
        """Decide and drive until the wander is over, or its time is up without news."""
        narrator, passed, news = Narrator(), Stopwatch(), time.monotonic()
        sights = self._reports.sights
        while wandering.end is None:
            move, newest = None, wandering.newest
            if self._reports.wait(lambda: sights, LOOK_AGAIN):
                seen_at, sight = sights.popleft()
                move = wandering.decide(sight, self._reports.heard)
                if wandering.newest != newest:
                    news = seen_at
            age = time.monotonic() - news
            if age > STALE:  # also where the stamps stand still: nobody drives on for ever while time is paused
                self.stop()
                if age > SILENCE and not sights:    # not while it catches up: what waits is no silence
                    narrator.tell(no_news(age).reason)
                if passed() >= duration and not wandering.waits:
                    return
            elif move and not sights:
                self.drive(move.linear, move.angular)
                narrator.tell(move.reason)
            if move:
                self._commander.tell(self._wanders, wandering, sight, move)

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
        """Lower, open, close, raise. What is held already stays held.

        Returns:
            Is an object held now?
        """
        if not self.has_gripper:
            rospy.loginfo("cannot pick: this robot has no gripper")
            return False
        if self.holding:
            rospy.loginfo("no pick: an object is held already")
            return True
        rospy.loginfo("pick")
        for step in PICK:
            if not self._step(step).succeeded:
                rospy.logwarn("the pick ends here: the gripper did not %s in time", step.name)
                return False
        rospy.loginfo("picked: an object is held" if self.holding else "picked nothing: the paddles closed on air")
        return self.holding

    def put_down(self) -> bool:
        """Lower and open. The next `wander` backs away from what was put down, and goes another way.

        So the robot puts nothing down where it cannot back away: its sonars must look behind it, and see room.

        Returns:
            Was something put down?
        """
        if not self.holding:
            return False
        if not can_leave(self.snapshot()):
            rospy.loginfo("keeps what it holds: sonars see no room behind, to leave it")
            return False
        rospy.loginfo("put down")
        self._leaving = all([self._step(step).succeeded for step in (LOWER, OPEN)])
        return self._leaving

    def _step(self, step: Step) -> Outcome:
        outcome = judge(step, self.grip, self.lift, commanded=False)
        if outcome is None:
            self._commander.move_gripper(step.grip, step.lift)
            self._reports.wait(
                lambda: judge(step, self.grip, self.lift, commanded=True), STEP_TIMEOUT, Stopwatch())
            outcome = judge(step, self.grip, self.lift, commanded=True)
        if outcome is None:
            self._commander.move_gripper(GripCommand.STOP, LiftCommand.STOP)
            outcome = Outcome.TIMED_OUT
            if self._reports.heard.age(time.monotonic()) > SILENCE:
                raise NoAnswerError("the gripper did not %s: %s" % (step.name, self._reports.why_motors_off()))
        rospy.loginfo("gripper, %s: %s", step.name, outcome.value)
        return outcome

    # The end

    def close(self) -> None:
        """Stand still and command nothing any more. Also called when ROS shuts down."""
        self._reports.end()
        self._commander.end()


def _whole(name: str, value: int) -> int:
    """The value, if it is a whole number of 64 bits, as a message holds it. Raises UsageError that says what it is."""
    with suppress(TypeError):
        number = operator.index(value)
        if -2 ** 63 <= number < 2 ** 63:
            return number
    raise UsageError("%s is %r: it must be a whole number of at most 64 bits" % (name, value))


def _number(name: str, value: float, unit: str, above: float = -math.inf) -> float:
    """The value, if it is a finite number above a bound. Raises UsageError that says what it is instead."""
    if isinstance(value, (int, float)) and above < value < math.inf:
        return value
    raise UsageError("%s is %r: it must be a number above %g, and finite (%s)" % (name, value, above, unit))


class Narrator:
    """Tells people what the robot does: each kind of reason when it begins, and again while it lasts."""

    def __init__(self) -> None:
        self._headline, self._told_at = "", 0.0

    def tell(self, reason: str) -> None:
        """Log a reason if what stands before its colon is new, or was told long ago."""
        headline, now = reason.partition(":")[0], time.monotonic()
        if headline != self._headline or now - self._told_at > TELL_AGAIN:
            rospy.loginfo("%s", reason)
            self._headline, self._told_at = headline, now
