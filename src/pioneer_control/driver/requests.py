"""In: commands to the robot. A table of the topics and a table of the services say which method obeys a command.

The methods are called on threads of rospy. `commands` says which messages are obeyed.
"""

import math
from functools import partial
from operator import attrgetter
from time import monotonic
from typing import Any, Callable, Mapping, NamedTuple, Sequence

import rospy
from geometry_msgs.msg import Twist
from std_srvs.srv import Empty, SetBool, Trigger

from ..client import MotorsAnswered, Robot
from ..errors import LinkError, NotConfirmedError, PioneerError, UsageError
from ..msg import GripperState, MotorState, WheelVelocities
from . import commands
from .notices import Watch
from .parameters import DriverParameters
from .senders import Senders

QUEUE = 10
VELOCITY_QUEUE = 3
"""So many velocities may come in a bunch: a fast line takes some at once, and one waits (client.line). Of more than
these, the newest count.
"""
CONFIRM_TIMEOUT = 2.0
"""Seconds the robot has to confirm that its motors or its sonar are on or off."""
ANSWER_WITHIN = 3
"""States within which the robot shows a command that it has heard."""
AXES = ("linear.x", "linear.y", "linear.z", "angular.x", "angular.y", "angular.z")
WHEELS = ("left", "right")


class Requests:
    """All subscribers and services of the node.

    Args:
        robot: obeys them.
        watch: is shown the velocities.
        warn: tells the user of warnings, texts by kind.
    """

    def __init__(self, parameters: DriverParameters, robot: Robot, watch: Watch,
                 warn: Callable[[Mapping[str, str]], None]) -> None:
        self._accept_replay = parameters.accept_replay
        self._robot = robot
        self._watch = watch
        self._warn = warn
        self._senders = Senders(watch)
        self._switch_on = parameters.enable_motors_on_start     # the motors, with the first connection
        for topic in TOPICS:
            rospy.Subscriber(topic.name, topic.message, partial(self._hear, topic), queue_size=topic.queue,
                             tcp_nodelay=True)
        for service in SERVICES:
            rospy.Service(service.name, service.kind, partial(self._serve, service))

    def connected(self) -> None:
        """The robot is connected. With the first connection its motors go on, if the user wants that.

        The parameter is enable_motors_on_start.
        """
        switch_on, self._switch_on = self._switch_on, False
        if switch_on and self._robot.link.reconnects:     # this is told late: listeners were held up
            rospy.logwarn("enable_motors_on_start counts no more: the robot has been connected again meanwhile")
        elif switch_on:
            rospy.logwarn("enable_motors_on_start is set: motors are switched on now, with nobody asking")
            try:
                self._robot.request_motors(True, CONFIRM_TIMEOUT)
            except PioneerError as error:
                self._warn({"enable_motors_on_start": str(error)})

    def motors_answered(self, answer: MotorsAnswered) -> None:
        """The robot has answered a request for its motors: of a topic, a service or the parameter."""
        if answer.error is not None:
            self._warn({"motors": str(answer.error)})
        elif answer.changed:
            rospy.loginfo("motors are %s", "on" if answer.on else "off")

    # What obeys a command. Each method raises PioneerError when it does not obey; the error says why. The methods of
    # services return the text of the answer.

    def drive(self, message: Twist) -> None:
        """Forward and turning speed."""
        check_finite("cmd_vel", message, AXES)
        self._robot.set_velocity(message.linear.x, message.angular.z)
        self._show(message.linear.x, message.angular.z)

    def drive_wheels(self, message: WheelVelocities) -> None:
        """Left and right speed."""
        check_finite("cmd_wheels", message, WHEELS)
        self._robot.set_wheel_velocities(message.left, message.right)
        self._show(message.left, message.right)

    def _show(self, *rates: float) -> None:
        self._warn(self._watch.velocity(monotonic(), any(rates), self._robot.state))

    def move_gripper(self, message: GripperState) -> None:
        """Paddles and lift."""
        for order in commands.gripper_orders(message):
            self._robot.gripper(*order)

    def follow_motor_state(self, message: MotorState) -> None:
        """Motors on or off.

        Nobody waits for the robot's answer here, because the next message may want the opposite. The answer comes to
        motors_answered().
        """
        self._robot.request_motors(commands.motors_wanted(message), CONFIRM_TIMEOUT)

    def switch_motors(self, on: bool) -> str:
        """Ask for the motors and wait until the robot has confirmed it."""
        self._robot.request_motors(on, CONFIRM_TIMEOUT)()
        return "motors are %s" % ("on" if on else "off")

    def switch_sonar(self, on: bool) -> str:
        """Tell the sonar to go on or off until the robot's flags show it."""
        what = "on" if on else "off"
        before, give_up_at = self._robot.use_sonar, monotonic() + CONFIRM_TIMEOUT
        while monotonic() < give_up_at:
            try:
                self._robot.set_sonar(on)
                if any(self._robot.wait_for_state().sonar_enabled == on for _ in range(ANSWER_WITHIN)):
                    return "the sonar is %s" % what
            except LinkError:       # the caller is told that it failed: so a reconnect must not do it later
                self._robot.use_sonar = before
                raise
        raise NotConfirmedError("asked to switch its sonar %s, the robot did not confirm it within %.0f s"
                                % (what, CONFIRM_TIMEOUT))

    def reset_odometry(self) -> str:
        """Let the place where the robot stands be 0, 0, 0 of the odometry frame. The robot itself is told nothing."""
        self._robot.reset_odometry()
        return "the next pose is 0, 0, 0"

    # How it is heard.

    def _hear(self, topic: "SubscribedTopic", message: Any) -> None:
        """Obey a message on a topic, if its sender does not play a bag."""
        connection = getattr(message, "_connection_header", None) or {}
        known = self._senders.known.get((topic.name, connection.get("callerid", "")))
        if known is not connection and not self._accept_replay:
            why_not = self._senders.why_not(message, topic.name, topic.stops)
            if why_not:
                self._warn(why_not)
                return
        try:
            topic.obey(self, message)
        except PioneerError as error:
            self._warn({topic.name: str(error)})

    def _serve(self, service: "OfferedService", request: Any) -> Any:
        """Answer a service: with success and a text, if its answer has such fields. Else an error says why not."""
        response = vars(service.kind)["_response_class"]
        tells = "success" in response.__slots__
        try:
            text = service.obey(self, request)
        except PioneerError as error:
            if tells:
                return response(False, str(error))
            raise rospy.ServiceException(str(error)) from None
        return response(True, text) if tells else response()


def check_finite(topic: str, message: Any, names: Sequence[str]) -> None:
    """Refuse a velocity in which any number is not finite, even one that is not used: its sender is in trouble.

    Args:
        topic: on which the message came.
        message: the velocity.
        names: of the numbers in the message.

    Raises:
        UsageError: names a number that is not finite.
    """
    for name, value in zip(names, attrgetter(*names)(message)):
        if not math.isfinite(value):
            raise UsageError("%s refused: %s is %s, and a velocity must be finite" % (topic, name, value))


class SubscribedTopic(NamedTuple):
    """A row: a topic that commands come on, how many may wait, and what obeys them."""

    name: str
    message: type
    queue: int
    obey: Callable[[Requests, Any], None]
    stops: Callable[[Any], bool]
    """whether a message does nothing but stop: that is obeyed from whomever it comes"""


class OfferedService(NamedTuple):
    """A row: a service, and what obeys a request and returns the answer's text."""

    name: str
    kind: type
    obey: Callable[[Requests, Any], str]


TOPICS = (
    SubscribedTopic("cmd_vel", Twist, VELOCITY_QUEUE, Requests.drive,
                    lambda twist: twist.linear.x == twist.angular.z == 0),
    SubscribedTopic("cmd_wheels", WheelVelocities, VELOCITY_QUEUE, Requests.drive_wheels,
                    lambda wheels: wheels.left == wheels.right == 0),
    SubscribedTopic("cmd_motor_state", MotorState, QUEUE, Requests.follow_motor_state,
                    lambda motors: motors.state == 0),
    SubscribedTopic("gripper_control", GripperState, QUEUE, Requests.move_gripper, commands.gripper_stops),
)

SERVICES = (
    OfferedService("set_motors", SetBool, lambda self, request: self.switch_motors(request.data)),
    OfferedService("enable_motors", Empty, lambda self, _: self.switch_motors(True)),
    OfferedService("disable_motors", Empty, lambda self, _: self.switch_motors(False)),
    OfferedService("set_sonar", SetBool, lambda self, request: self.switch_sonar(request.data)),
    OfferedService("reset_odometry", Trigger, lambda self, _: self.reset_odometry()),
)
