"""Receives commands for the robot. The tables TOPICS and SERVICES show which method obeys each topic and service.

Threads of rospy call these methods. The file `commands` checks messages to the motors and the gripper.
"""

import contextlib
import math
from functools import partial
from operator import attrgetter
from time import monotonic
from typing import Any, Callable, ContextManager, Dict, Iterable, Iterator, List, Mapping, NamedTuple, Optional, Tuple

import rospy
from geometry_msgs.msg import Twist
from std_msgs.msg import Bool
from std_srvs.srv import Empty, SetBool, Trigger

from ..client import MotorsAnswered, Robot, SteeredRobot
from ..client.accessories import repeat_until
from ..client.laser_power import laser_power
from ..errors import LinkError, PioneerError, RefusedError, UsageError
from ..msg import Accelerations, GripperState, MotorState, Sounds, WheelVelocities
from ..srv import SetDigitalOut
from . import commands
from .accelerations import BorrowedAccelerations
from .accessory_requests import AccessoryRequests
from .notices import Watch
from .parameters import BY_HAND, DriverParameters
from .senders import Senders

QUEUE = 10
VELOCITY_QUEUE = 3
"""The queue size of the velocity topics. When more velocities come at once, only the newest are used."""
AT_ONCE = 0.005
"""Time (s). Velocities of a program that follow each other faster came in one piece, from a network that had held them
up."""
SETTLES = 0.25
"""Time (s) after a silence. If velocities come in one piece in it, all that come in it count as a stop."""
CONFIRM_TIMEOUT = 2.0
"""The time (s) that the robot has to confirm that its motors or its sonar are on or off."""
TWIST = ("linear.x", "linear.y", "linear.z", "angular.x", "angular.y", "angular.z")
NUMBERS = {"cmd_vel": TWIST, BY_HAND: TWIST, "cmd_wheels": ("left", "right")}
"""The numbers in a velocity message, by topic."""
GRIPPER_INPUTS = {"gripper_control": "cmd_vel", "teleop/gripper_control": BY_HAND}
"""The velocity input that commands by each topic of the gripper: a program, or a person."""
STOP_ALL = "stop_all"
"""The topic that locks the robot, and the name of the lock."""
_get_numbers = {topic: attrgetter(*names) for topic, names in NUMBERS.items()}


class Requests:
    """All subscribers and services of the driver.

    Args:
        parameters: the parameters of the driver.
        robot: the robot, for what is no command to move.
        steered: the same robot, for the commands to move: they go through its helm.
        watch: checks velocity commands and makes warnings.
        borrowed: the accelerations that programs borrow.
        warn: a function that logs warnings: texts by kind.
    """

    def __init__(self, parameters: DriverParameters, robot: Robot, steered: SteeredRobot, watch: Watch,
                 borrowed: BorrowedAccelerations, warn: Callable[[Mapping[str, str]], None]) -> None:
        self._accept_replay = parameters.accept_replay
        self._robot = robot
        self._steered = steered
        self._watch = watch
        self._borrowed = borrowed
        self.accessories = AccessoryRequests(robot, steered)
        self._warn = warn
        self._senders = Senders(watch)
        self._arrivals: Dict[str, Arrivals] = {}    # by velocity topic
        self._switch_on = parameters.enable_motors_on_start     # the motors, with the first connection
        self._laser_power: Optional[bool] = parameters.laser_power or None      # None: nobody has asked for it
        self._halts: List[Callable[[], None]] = []
        self.offer(self, TOPICS, SERVICES)

    def offer(self, owner: Any, topics: Iterable["SubscribedTopic"], services: Iterable["OfferedService"],
              halt: Optional[Callable[[], None]] = None) -> None:
        """Subscribe to topics and offer services that an object obeys.

        Args:
            owner: the object: the first argument of all methods of the rows.
            topics, services: the rows.
            halt: called when a lock is set; it makes stand what the object moves. None if it moves nothing else.
        """
        for topic in topics:
            rospy.Subscriber(topic.name, topic.message, partial(self._hear, owner, topic), queue_size=topic.queue,
                             tcp_nodelay=True)
        for service in services:
            rospy.Service(service.name, service.kind, partial(self._serve, owner, service))
        if halt is not None:
            self._halts.append(halt)

    def connected(self) -> None:
        """React to a new connection to the robot. Its laser gets power, or none, if somebody has asked for that before.

        On the first connection the motors are switched on, if the parameter enable_motors_on_start is true.
        """
        self._warn({"dock": self.accessories.warning_at_start()})
        switch_on, self._switch_on = self._switch_on, False
        if switch_on and self._robot.link.reconnects:     # this is told late: listeners were held up
            rospy.logwarn("enable_motors_on_start counts no more: the robot has been connected again meanwhile")
        elif switch_on:
            rospy.logwarn("enable_motors_on_start is set: motors are switched on now, with nobody asking")
            try:
                self._steered.request_motors(True, CONFIRM_TIMEOUT)
            except PioneerError as error:
                self._warn({"enable_motors_on_start": str(error)})
        if self._laser_power is not None:
            try:
                self._send_laser_power(self._laser_power)
            except PioneerError as error:
                self._warn({"laser_power": str(error)})

    def motors_answered(self, answer: MotorsAnswered) -> None:
        """Log the answer of the robot to a request to switch its motors on or off."""
        if answer.error is not None:
            self._warn({"motors": str(answer.error)})
        elif answer.changed:
            rospy.loginfo("motors are %s", "on" if answer.on else "off")

    # The methods that obey messages: the name of the topic, the message, and the node that sent it. Each raises
    # PioneerError with the reason when it does not obey.

    def drive(self, topic: str, message: Twist, sender: str) -> None:
        """Obey cmd_vel or teleop/cmd_vel: forward speed (m/s) and turn rate (rad/s)."""
        check_finite(topic, message)
        self._steered.set_velocity(topic, message.linear.x, message.angular.z, sender)
        self._show(topic, message.linear.x, message.angular.z)

    def drive_wheels(self, topic: str, message: WheelVelocities, sender: str) -> None:
        """Obey cmd_wheels: the speeds of both wheels (m/s)."""
        check_finite(topic, message)
        self._steered.set_wheel_velocities(topic, message.left, message.right, sender)
        self._show(topic, message.left, message.right)

    def _show(self, topic: str, *rates: float) -> None:
        """Give the warnings about a velocity command. ``rates`` are its numbers: all 0 is a stop."""
        state = self._robot.state
        self._warn(self._watch.motors_off(any(rates), state) if topic == BY_HAND
                   else self._watch.velocity(monotonic(), any(rates), state))

    def move_gripper(self, topic: str, message: GripperState, sender: str) -> None:
        """Obey gripper_control or teleop/gripper_control: commands to paddles and lift."""
        orders = commands.gripper_orders(message)
        self._steered.move_gripper(GRIPPER_INPUTS[topic], orders, commands.gripper_stops(message), sender)

    def lock(self, topic: str, message: Bool, sender: str) -> None:
        """Obey stop_all: true stops the robot and locks it, false takes the lock away."""
        was_set = STOP_ALL in self._steered.state().locks
        (self._steered.lock if message.data else self._steered.unlock)(STOP_ALL)
        for halt in self._halts if message.data else ():
            halt()
        if message.data and not was_set:
            rospy.logwarn("%s is set by %s: the robot stands until it is taken away", topic, sender)
        elif was_set and not message.data:
            rospy.loginfo("%s is taken away by %s", topic, sender)

    def follow_motor_state(self, topic: str, message: MotorState, sender: str) -> None:
        """Obey cmd_motor_state: request motors on or off.

        This method does not wait for the answer of the robot, because the next message may request the opposite. The
        answer comes to `motors_answered`.
        """
        self._steered.request_motors(commands.motors_wanted(message), CONFIRM_TIMEOUT)

    def borrow_accelerations(self, topic: str, message: Accelerations, sender: str) -> None:
        """Obey accelerations: the robot gets them as long as the sender repeats the message."""
        if self._borrowed.borrow(message, sender, monotonic()):
            rospy.loginfo("%s borrows accelerations; they are put back when it ends", sender)

    # The methods of services return the text of the answer. Each raises PioneerError with the reason when it fails.

    def switch_motors(self, on: bool) -> str:
        """Switch the motors on or off, and wait until the robot confirms it. Return the text of the answer.

        Raises PioneerError when the robot does not confirm it.
        """
        self._steered.request_motors(on, CONFIRM_TIMEOUT)()
        return "motors are %s" % ("on" if on else "off")

    def switch_sonar(self, on: bool) -> str:
        """Switch the sonar on or off, and return the text of the answer.

        The command is repeated until the flags of the robot show it.

        Raises:
            NotConfirmedError: the flags do not show it within CONFIRM_TIMEOUT seconds.
            LinkError: there is no link.
        """
        what = "on" if on else "off"
        before = self._robot.use_sonar
        try:
            repeat_until(self._robot, lambda: self._robot.set_sonar(on), lambda state: state.sonar_enabled == on,
                         CONFIRM_TIMEOUT, "told to switch its sonar %s" % what)
        except LinkError:       # the caller gets an error, so a reconnect must not switch the sonar later
            self._robot.use_sonar = before
            raise
        return "the sonar is %s" % what

    def switch_laser(self, on: bool) -> str:
        """Switch the robot's supply of a laser on or off, now and after each reconnect. Return the text of the answer.

        Raises LinkError when there is no link.
        """
        self._send_laser_power(on)
        self._laser_power = on
        return ("the robot was told to give its laser %s; it does not say whether it does"
                % ("power: a laser needs up to a minute until it measures" if on else "no power"))

    def _send_laser_power(self, on: bool) -> None:
        identity = self._robot.identity
        self._robot.send(laser_power(None if identity is None else identity.config, on))

    def reset_odometry(self) -> str:
        """Make the current pose of the robot 0, 0, 0 in the odom frame. Return the text of the answer.

        The driver does this alone, without a command to the robot.
        """
        self._robot.reset_odometry()
        return "the next pose is 0, 0, 0"

    def release(self) -> str:
        """Give the helm back to programs: what a person drove stops. Return the text of the answer."""
        if not self._steered.release():
            return "nobody has the helm; programs may command"
        rospy.loginfo("the helm is released: programs may command again")
        return "programs may command again"

    # The callbacks of the subscribers and services.

    def _hear(self, owner: Any, topic: "SubscribedTopic", message: Any) -> None:
        """Obey a message on a topic, or log why not.

        Messages from a bag player (`rosbag play`) are refused, but a lock counts from wherever it comes.
        """
        connection = getattr(message, "_connection_header", None) or {}
        sender = connection.get("callerid", "")
        known = self._senders.known.get((topic.name, sender))
        if known is not connection and not self._accept_replay and not (topic.name == STOP_ALL and message.data):
            why_not = self._senders.why_not(message, topic.name, topic.stops)
            if why_not:
                self._warn(why_not)
                return
        if topic.name in NUMBERS and self._held_up(topic.name, connection):
            self._warn({"held up " + topic.name: "velocities on %s were held up between %s and here, and are too old: "
                        "they count as a stop" % (topic.name, sender)})
            message = topic.message()
        try:
            topic.obey(owner, topic.name, message, sender)
        except PioneerError as error:
            self._warn({topic.name: str(error)})

    def _held_up(self, topic: str, connection: Any) -> bool:
        arrivals = self._arrivals.get(topic)
        if arrivals is None or arrivals.connection is not connection:
            arrivals = self._arrivals[topic] = Arrivals(connection)
        return arrivals.held_up(monotonic(), self._watch.cmd_vel_timeout)

    def _serve(self, owner: Any, service: "OfferedService", request: Any) -> Any:
        """Obey a service request and return the response.

        If the robot does not do it, a response with the fields success and message has the reason. A service type
        without these fields raises rospy.ServiceException.
        """
        response = vars(service.kind)["_response_class"]
        tells = "success" in response.__slots__
        try:
            text = service.obey(owner, request)
        except PioneerError as error:
            if tells:
                return response(False, str(error))
            raise rospy.ServiceException(str(error)) from None
        return response(True, text) if tells else response()


class Arrivals:
    """When velocities arrive over one connection, to tell which were held up on their way.

    While the network between two computers is down, TCP keeps what a program publishes, and delivers it all at once
    when the network is back: seconds old, and also when the program has ended meanwhile. rospy passes on the newest
    VELOCITY_QUEUE of it. A program that drives does not send like this: after a silence its velocities come one by one.

    Args:
        connection: the connection. With another one, nothing can be old.
    """

    def __init__(self, connection: Any) -> None:
        self.connection = connection
        self._last = math.inf           # when the newest velocity came
        self._first = -math.inf         # when the first one after the newest silence came
        self._settled_at = -math.inf

    def held_up(self, now: float, timeout: float) -> bool:
        """Take note of a velocity that arrives ``now`` (monotonic, s), and return whether it was held up.

        Args:
            now: the time.
            timeout: a longer pause (s) than this is a silence.
        """
        gap, self._last = now - self._last, now
        if gap > timeout:
            self._first = now
        elif gap < AT_ONCE and now - self._first < SETTLES:
            self._settled_at = self._first + SETTLES
        return now < self._settled_at


def check_finite(topic: str, message: Any) -> None:
    """Refuse a velocity message when a number in it is not finite.

    This includes numbers that the driver does not use, because then something is wrong with the sender.

    Args:
        topic: the name of the topic, a key of NUMBERS.
        message: the velocity message.

    Raises:
        UsageError: a number is not finite. The error message names it.
    """
    for name, value in zip(NUMBERS[topic], _get_numbers[topic](message)):
        if not math.isfinite(value):
            raise UsageError("%s refused: %s is %s, and a velocity must be finite" % (topic, name, value))


@contextlib.contextmanager
def unless_locked(using: Callable[[], ContextManager[float]], locks: Callable[[], Tuple[str, ...]],
                  what: str) -> Iterator[float]:
    """Let the caller command a device in a ``with`` block, unless a lock is set. It gets the time (s).

    The locks are looked for in the block of ``using``: whoever sets one later stops what was begun here (``halt`` of
    `Requests.offer`). Raises RefusedError, which names the lock and ``what`` was asked.
    """
    with using() as now:
        for lock in locks():
            raise RefusedError("%s refused: %s is set" % (what, lock))
        yield now


class SubscribedTopic(NamedTuple):
    """One row of the table TOPICS: the name, message type and queue size of a topic, and the method that obeys it."""

    name: str
    message: type
    queue: int
    obey: Callable[[Any, str, Any, str], None]
    """Obey a message. Its arguments are the owner (see `Requests.offer`), the topic, the message, and the sender."""
    stops: Callable[[Any], bool]
    """Return whether a message just stops the robot. Only such a message is obeyed when its sender may be a bag player.
    """


class OfferedService(NamedTuple):
    """One row of the table SERVICES: the name and type of a service, and a function that obeys it.

    The function gets the owner (see `Requests.offer`) and the request. It returns the text of the answer.
    """

    name: str
    kind: type
    obey: Callable[[Any, Any], str]


def _stands(twist: Twist) -> bool:
    return bool(twist.linear.x == twist.angular.z == 0)


TOPICS = (
    SubscribedTopic("cmd_vel", Twist, VELOCITY_QUEUE, Requests.drive, _stands),
    SubscribedTopic(BY_HAND, Twist, VELOCITY_QUEUE, Requests.drive, _stands),
    SubscribedTopic("cmd_wheels", WheelVelocities, VELOCITY_QUEUE, Requests.drive_wheels,
                    lambda wheels: wheels.left == wheels.right == 0),
    SubscribedTopic("cmd_motor_state", MotorState, QUEUE, Requests.follow_motor_state,
                    lambda motors: motors.state == 0),
    SubscribedTopic("gripper_control", GripperState, QUEUE, Requests.move_gripper, commands.gripper_stops),
    SubscribedTopic("teleop/gripper_control", GripperState, QUEUE, Requests.move_gripper, commands.gripper_stops),
    SubscribedTopic("accelerations", Accelerations, QUEUE, Requests.borrow_accelerations, lambda _: False),
    SubscribedTopic("say", Sounds, QUEUE, lambda self, topic, message, sender: self.accessories.say(message),
                    lambda _: False),
    SubscribedTopic(STOP_ALL, Bool, QUEUE, Requests.lock, lambda lock: lock.data),
)

SERVICES = (
    OfferedService("set_motors", SetBool, lambda self, request: self.switch_motors(request.data)),
    OfferedService("enable_motors", Empty, lambda self, _: self.switch_motors(True)),
    OfferedService("disable_motors", Empty, lambda self, _: self.switch_motors(False)),
    OfferedService("set_sonar", SetBool, lambda self, request: self.switch_sonar(request.data)),
    OfferedService("set_laser_power", SetBool, lambda self, request: self.switch_laser(request.data)),
    OfferedService("reset_odometry", Trigger, lambda self, _: self.reset_odometry()),
    OfferedService("dio_out", SetDigitalOut, lambda self, request: self.accessories.set_outputs(
        request.mask, request.states)),
    OfferedService("set_joystick_drive", SetBool, lambda self, request: self.accessories.let_joystick_drive(
        request.data)),
    OfferedService("dock", Trigger, lambda self, _: self.accessories.dock()),
    OfferedService("undock", Trigger, lambda self, _: self.accessories.undock()),
    OfferedService("teleop/release", Trigger, lambda self, _: self.release()),
)
