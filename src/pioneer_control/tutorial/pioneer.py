"""The class `Pioneer`: the interface of one robot for a user's program. It uses only ROS topics of the driver.

::

    init_node("mine")                      # from pioneer_control.ros_node; with rospy.init_node Ctrl-C may hang
    with Pioneer("pioneer") as robot:      # waits for the driver, then switches the motors on
        robot.wander(20)
        if robot.pick():
            print("got one")
                                           # the robot stops at the end of the block, also after an exception
"""

import math
import numbers
import time
from functools import partial
from typing import TYPE_CHECKING, Optional, Sequence, Tuple, Union

import rospy
from rosgraph.names import is_legal_name

from ..errors import NoAnswerError, NotConfirmedError, RefusedError, UsageError
from ..floor_poses import Pose
from ..message_values import GripCommand, LiftCommand
from ..robots import find_model
from .commander import Commander
from .following import LOOK_AGAIN, SILENCE, follow
from .getting_ready import wait_until_ready
from .pick import CLOSE, LOWER, OPEN, PICK, RAISE, Outcome, Step, holds, judge
from .reports import Reports, Stopwatch
from .snapshot import Grip, Heard, Lift, RobotShape, Snapshot
from .wander import SPEED, can_leave
from .wandering import WanderEnd, Wandering

if TYPE_CHECKING:
    from .travel import Travel

CONNECT_TIMEOUT = 15.0  #: s, time-out for the driver and its first data; a robot may need 10 s to answer
LISTENERS_TIMEOUT = 2.0  #: s, time-out for other subscribers; a subscriber that crashed never connects
MOTORS_TIMEOUT = 5.0  #: s, time-out for the robot to report that its motors are on
STEP_TIMEOUT = 10.0  #: s, time-out for one movement of the gripper; the slowest takes 3.5 s
ASK_AGAIN = 0.5  #: s between two requests for the motors
LEAVE = 5.0  #: s of a wander that leaves an object behind before a way to a place begins


class Pioneer:
    """One robot: properties such as `pose` and `ranges` give its newest reports, methods such as `wander` command it.

    An instance publishes no command before a method is called. The robot stops at the end of a ``with`` block, after
    `close`, and when ROS shuts down (Ctrl-C, ``rosnode kill``).
    """

    def __init__(
            self, namespace: str = "pioneer", *, speed: float = SPEED, seed: Optional[int] = None, model: str = "",
            gripper: bool = False, begin_at: Sequence[float] = (), end_at: Sequence[float] = ()):
        """Subscribe to the topics of the robot and advertise the command topics.

        Args:
            namespace: the namespace of the robot's topics.
            speed: the speed of a wander [m/s].
            seed: the seed for the random choices of a wander. None: the program takes the time of the clock as seed.
            model: the robot model, when the driver publishes no ``robot_info``. A ``robot_info`` message replaces it.
            gripper: used only with `model`: whether a gripper is fitted.
            begin_at: to repeat a run from a bag: the stamp [s] of the first ``decision`` message of each wander.
            end_at: to repeat a run from a bag: the stamp [s] of the last ``decision`` message of each wander. With
                both, each wander decides on the same sensor messages as in the recorded run.

        Raises:
            UsageError: the program is no node yet, the namespace is no name of ROS, the speed is not greater than 0, or
                the seed is not a whole number of 64 bits.
            UnknownModelError: the table of models has no such model.
        """
        if not rospy.rostime.is_rostime_initialized():
            raise UsageError(
                'this program is no ROS node yet: before Pioneer("%s"), call init_node("my_robot"), '
                "from pioneer_control.ros_node" % namespace)
        if not is_legal_name(namespace):
            raise UsageError("the namespace of the robot is %r: give letters, digits, _ and /, such as pioneer"
                             % namespace)
        self._prefix = namespace.rstrip("/") + "/" if namespace else ""
        self._speed = _number("speed", speed, "m/s", above=0)
        self._seed = int(time.time()) if seed is None else _whole("seed", seed)
        self._limits, self._wanders = {"begin_at": begin_at, "end_at": end_at}, 0
        self._leaving = False  # something was put down just before
        known = Heard(robot=RobotShape.of_model(find_model(model)), has_gripper=gripper) if model else Heard()
        self._travel: Optional["Travel"] = None
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
        """The pose of the robot by odometry (m, rad; odom frame). None before the first message."""
        return self._reports.heard.pose

    @property
    def ranges(self) -> Optional[Tuple[float, ...]]:
        """The sonar ranges [m] by transducer number. 0.0 means no recent reading. None before the first message."""
        return self._reports.heard.ranges

    @property
    def grip(self) -> Optional[Grip]:
        """The reported state of the paddles. None when no gripper is fitted, and before the first message."""
        return self._reports.heard.grip

    @property
    def lift(self) -> Optional[Lift]:
        """The reported state of the gripper's lift. None when no gripper is fitted, and before the first message."""
        return self._reports.heard.lift

    @property
    def has_gripper(self) -> bool:
        """Whether a gripper is fitted."""
        return self._reports.heard.has_gripper

    @property
    def holding(self) -> bool:
        """Whether the gripper holds an object."""
        return self.has_gripper and holds(self.grip)

    @property
    def driven(self) -> float:
        """The distance that the robot has driven since this program started, by odometry [m]."""
        return self._reports.heard.driven

    @property
    def stalls(self) -> int:
        """How often a wheel began to stall since this program started: an obstacle held the robot."""
        return self._reports.heard.stalls

    def snapshot(self) -> Snapshot:
        """Return the newest sensor data as one value, the data that a decision of the wander uses.

        Raises:
            NoAnswerError: pose, sonar or robot_info has not arrived yet.
        """
        return self._reports.heard.snapshot(rospy.get_time(), self._reports.heard.age(time.monotonic()))

    # Getting ready

    def wait_until_ready(self, timeout: float = CONNECT_TIMEOUT) -> None:
        """Wait until the driver subscribes to the command topics, and each topic of the robot has sent a message.

        Raises:
            NoAnswerError: a subscriber or a message did not come within `timeout` seconds. The error message names the
                topics.
        """
        wait_until_ready(self._prefix, self._reports, self._commander, timeout)
        self._commander.wait_for_listeners(LISTENERS_TIMEOUT)

    def enable_motors(self, timeout: float = MOTORS_TIMEOUT) -> None:
        """Request that the motors are switched on, again and again, until the robot reports that they are on.

        Raises:
            NotConfirmedError: the robot does not report it within `timeout` seconds.
        """
        passed = Stopwatch()
        while not self._reports.heard.motors:
            if passed() > timeout:
                raise NotConfirmedError(
                    "the motors stay off after %.0f s of asking: %s" % (timeout, self._reports.why_motors_off()))
            self._commander.enable_motors()
            self._reports.wait(lambda: self._reports.heard.motors, ASK_AGAIN)

    # Driving

    def drive(self, linear: float, angular: float) -> None:
        """Publish a velocity: forward [m/s] and counter-clockwise [rad/s].

        Repeat the call: the driver stops the robot when no new velocity comes within 0.6 s.

        Raises:
            UsageError: a value is not a finite number.
            RefusedError: the motors are off. Call `enable_motors` to switch them on.
        """
        linear, angular = _number("linear", linear, "m/s"), _number("angular", angular, "rad/s")
        if not self._reports.heard.motors:
            raise RefusedError("the robot's motors are off, it does not drive: %s" % self._reports.why_motors_off())
        self._commander.drive(linear, angular)

    def stop(self) -> None:
        """Stop the robot. Do nothing when this program has not driven it since the last stop."""
        self._commander.stop()

    def wander(self, duration: float = 20.0, *, stop_at_can: bool = True) -> WanderEnd:
        """Drive around without touching anything, then stop.

        When the gripper holds nothing, it first opens and goes down. When `put_down` has put an object down, the robot
        first backs away from the object.

        The program makes one decision for each sonar message, in order, and publishes it on ``decision``. Only the
        newest decision is sent to the robot.

        Args:
            duration: how long to wander, in seconds of ROS time.
            stop_at_can: end the wander when an object breaks the outer beam of the gripper, and is not held.

        Returns:
            Why the wander ended.

        Raises:
            UsageError: the duration is not greater than 0.
            NoAnswerError: pose, sonar or robot_info has not arrived yet.
            RefusedError: the motors are off, or go off during the wander.
        """
        _number("duration", duration, "s", above=0)
        rospy.loginfo("wander, for %g s at most", duration)
        if self.has_gripper and not self.holding:
            self.gripper_open()
            self.gripper_lower()
        wandering = self._begin_wander(duration, stop_at_can)
        try:
            follow(wandering, duration, self._reports, self.drive, self.stop,
                   partial(self._commander.tell, self._wanders, wandering))
        finally:
            self._seed = wandering.memory.seed
            self.stop()
        end = wandering.end or WanderEnd.TIME_UP
        rospy.loginfo("stopped: %s", end.value)
        return end

    def _begin_wander(self, duration: float, stop_at_can: bool) -> Wandering:
        """Return a new wander (arguments as in `wander`). Raises NoAnswerError when sensor data are missing."""
        limits = {name: stamps[self._wanders] for name, stamps in self._limits.items() if self._wanders < len(stamps)}
        self._wanders += 1
        self._reports.wait(lambda: self.pose and self.ranges and self._reports.heard.robot, LOOK_AGAIN)
        self.snapshot()
        if "begin_at" not in limits:
            self._reports.sights.clear()
        leaving, self._leaving = self._leaving, False
        return Wandering(self._seed, self._speed, duration, stop_at_can=stop_at_can, leaving=leaving, **limits)

    # Places on the map: with navigation (navigate.launch), this package's or another with the names of move_base

    def where(self) -> Optional[Pose]:
        """Return where the robot is on the map (m, rad). None while it does not know.

        Raises:
            NoAnswerError: there is no navigation.
        """
        return self.navigation.where()

    def go_to(self, place: Union[str, float], y: Optional[float] = None, heading: Optional[float] = None) -> bool:
        """Drive to a place on the map and wait until the robot is there: ``go_to(3.0, 1.5)``, ``go_to("kitchen")``.

        Args:
            place: the name of a place, or x [m].
            y: y [m], with x.
            heading: where the robot looks at the end [rad]. None: as the place says, or as it comes.

        Returns:
            Whether the robot is there. If not, the log says why.

        Raises:
            UsageError: no place has the name, a number is not finite, or `y` comes with a name.
            NoAnswerError: there is no navigation, or it ends meanwhile.
            RefusedError: the motors are off.
        """
        travel = self.navigation
        goal = travel.goal_of(place, y, heading)
        if not self._reports.heard.motors:
            raise RefusedError("the robot's motors are off, it does not drive: %s" % self._reports.why_motors_off())
        if self._leaving:
            self.wander(LEAVE)      # which first backs away from what was put down
        self.stop()
        rospy.loginfo("go to %s", place if isinstance(place, str) else "%.2f, %.2f" % (goal.x, goal.y))
        why_not = travel.go_to(goal)
        if why_not:
            rospy.logwarn("not there: %s", why_not)
        else:
            rospy.loginfo("there")
        return not why_not

    def explore(self) -> bool:
        """Drive where the map ends until all that can be reached is known, and home. Return whether that succeeded.

        Raises:
            NoAnswerError: there is no navigation, or it ends meanwhile.
        """
        rospy.loginfo("explore: drive where the map ends until all is known, then home; an office takes ten minutes")
        why_not = self.navigation.explore()
        if why_not:
            rospy.logwarn("not explored: %s", why_not)
        else:
            rospy.loginfo("explored, home again")
        return not why_not

    @property
    def navigation(self) -> "Travel":
        """The client of navigation, which can also save the map, and give a place a name."""
        if self._travel is None:        # most programs need none
            from .travel import Travel
            self._travel = Travel(self._prefix)
        return self._travel

    # The gripper

    def gripper_lower(self) -> Outcome:
        """Lower the lift, and wait until it is down."""
        return self._step(LOWER)

    def gripper_open(self) -> Outcome:
        """Open the paddles, and wait until they are open."""
        return self._step(OPEN)

    def gripper_close(self) -> Outcome:
        """Close the paddles, and wait until they are closed, with or without an object between them."""
        return self._step(CLOSE)

    def gripper_raise(self) -> Outcome:
        """Raise the lift, and wait until it is up."""
        return self._step(RAISE)

    def pick(self) -> bool:
        """Pick up an object: lower the lift, open the paddles, close them, raise the lift.

        When the gripper holds an object already, it does not move.

        Returns:
            Whether the gripper holds an object at the end.
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
        """Put down the held object: lower the lift and open the paddles.

        The next `wander` first backs away from the object. So the robot keeps the object when its sonars do not show
        free space behind it.

        Returns:
            Whether an object was put down.
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
        """Do one movement of the gripper, and wait until it ends. After STEP_TIMEOUT seconds stop the gripper.

        Raises:
            NoAnswerError: the movement timed out, and the robot sends no data any more.
        """
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
        """Stop the robot, and publish no more commands. ROS calls this method too when it shuts down."""
        self._reports.end()
        if self._travel is not None:
            self._travel.end()
        self._commander.end()


def _whole(name: str, value: int) -> int:
    """Return the value as int. Raises UsageError with `name` when it is not a whole number of at most 64 bits."""
    if isinstance(value, numbers.Integral) and -2 ** 63 <= value < 2 ** 63:
        return int(value)
    raise UsageError("%s is %r: it must be a whole number of at most 64 bits" % (name, value))


def _number(name: str, value: float, unit: str, above: float = -math.inf) -> float:
    """Return the value. Raises UsageError (with `name`, `unit`) when it is not a finite number greater than `above`."""
    if isinstance(value, (int, float)) and above < value < math.inf:
        return value
    raise UsageError("%s is %r: it must be a number above %g, and finite (%s)" % (name, value, above, unit))
