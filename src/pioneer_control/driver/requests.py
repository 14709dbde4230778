"""In: commands to the robot, from topics and services: a table of each, and what obeys by it. Called on threads of rospy's.

`commands` says which messages are obeyed.
"""

import threading
from time import monotonic
from typing import Any, Callable, Dict, Iterable, NamedTuple, Optional, Tuple

import rospy
from geometry_msgs.msg import Twist
from std_srvs.srv import Empty, SetBool, Trigger

from ..client import Robot
from ..errors import LinkError, NotConfirmedError, PioneerError
from ..msg import GripperState, MotorState, WheelVelocities
from ..ros_node import is_offered
from . import commands
from .notices import Notice, Watch
from .parameters import DriverParameters

QUEUE = 10
VELOCITY_QUEUE = 3
"""Of a bunch those that a fast line takes at once, and one that waits (client.line); of more the newest."""
CONFIRM_TIMEOUT = 2.0
"""Seconds the robot has to confirm that its motors or its sonar are on or off."""
MASTER_TIMEOUT = 0.3
"""Seconds, at most, in which the master must say who sent a command; then it is asked no more for as long."""
ANSWER_WITHIN = 3
"""States within which the robot shows a command that it has heard."""


class Requests:
    """All subscribers and services of the node.

    Args:
        robot: obeys them.
        watch: is shown the velocities.
        warn: tells the user.
    """

    def __init__(self, parameters: DriverParameters, robot: Robot, watch: Watch, warn: Callable[[Iterable[Notice]], None]) -> None:
        self._parameters = parameters
        self._robot = robot
        self._watch = watch
        self._warn = warn
        self._players: Dict[Tuple[str, str], Tuple[Any, bool]] = {}     # who sent commands on a topic: by which connection, and is it `rosbag play`?
        self._ask_again_at = 0.0                # what the master did not say
        self._first_connection = True
        for topic in TOPICS:
            rospy.Subscriber(topic.name, topic.message, self._listener(topic), queue_size=topic.queue, tcp_nodelay=True)
        for service in SERVICES:
            rospy.Service(service.name, service.kind, self._server(service))

    def connected(self) -> None:
        """The robot is found; for the first time it may be told to switch its motors on, if the user wants that."""
        first, self._first_connection = self._first_connection, False
        if first and self._parameters.enable_motors_on_start:
            rospy.logwarn("enable_motors_on_start is set: motors are switched on now, with nobody asking")
            try:
                self.switch_motors_and_tell(True, "enable_motors_on_start")
            except PioneerError as error:
                self._refuse("enable_motors_on_start", error)

    # What is obeyed. Each raises PioneerError with the reason why not; those of services return what they say when it worked.

    def drive(self, message: Twist) -> None:
        """Forward and turning speed."""
        commands.check_twist(message)
        self._robot.set_velocity(message.linear.x, message.angular.z)
        self._show(message.linear.x, message.angular.z)

    def drive_wheels(self, message: WheelVelocities) -> None:
        """Left and right speed."""
        commands.check_wheels(message)
        self._robot.set_wheel_velocities(message.left, message.right)
        self._show(message.left, message.right)

    def _show(self, *rates: float) -> None:
        self._warn(self._watch.velocity(monotonic(), any(rates), self._robot.state))

    def move_gripper(self, message: GripperState) -> None:
        """Paddles and lift."""
        for order in commands.gripper_orders(message):
            self._robot.gripper(*order)

    def follow_motor_state(self, message: MotorState) -> None:
        """Motors on or off."""
        self.switch_motors_and_tell(commands.motors_wanted(message), "cmd_motor_state")

    def switch_motors_and_tell(self, on: bool, who: str) -> None:
        """Ask for the motors, and do not wait: the next message may want the opposite. Why they do not obey becomes a warning."""
        wait = self._request_motors(on)

        def hear_answer() -> None:
            try:
                wait()
            except PioneerError as error:
                self._refuse(who, error)

        threading.Thread(target=hear_answer, name="motors", daemon=True).start()

    def switch_motors(self, on: bool) -> str:
        """Ask for the motors and wait until the robot has confirmed it."""
        self._request_motors(on)()
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
            except LinkError:       # who hears no is not to find it done after a reconnect
                self._robot.use_sonar = before
                raise
        raise NotConfirmedError("asked to switch its sonar %s, the robot did not confirm it within %.0f s" % (what, CONFIRM_TIMEOUT))

    def reset_odometry(self) -> str:
        """The robot stands at 0, 0, 0 of the odometry frame; the robot itself is told nothing."""
        self._robot.reset_odometry()
        return "the next pose is 0, 0, 0"

    def _request_motors(self, on: bool) -> Callable[[], None]:
        """Ask for the motors at once. Returns what waits for the robot's answer; both raise PioneerError with the reason when it is no."""
        before = self._robot.state
        answer = self._robot.request_motors(on, CONFIRM_TIMEOUT)

        def wait() -> None:
            answer()
            if before is None or before.motors_enabled != on:
                rospy.loginfo("motors are %s", "on" if on else "off")

        return wait

    # How it is heard.

    def _listener(self, topic: "Topic") -> Callable[[Any], None]:
        def hear(message: Any) -> None:
            if not self._parameters.accept_replay and self._sender_refused(message, topic):
                return
            try:
                topic.obey(self, message)
            except PioneerError as error:
                self._refuse(topic.name, error)

        return hear

    def _server(self, service: "Service") -> Callable[[Any], Any]:
        """What answers a service: with success and a text where it has fields for them, else with nothing, or with an error that says why."""
        response = service.kind._response_class
        tells = "success" in response.__slots__

        def serve(request: Any) -> Any:
            try:
                text = service.obey(self, request)
            except PioneerError as error:
                if tells:
                    return response(False, str(error))
                raise rospy.ServiceException(str(error)) from None
            return response(True, text) if tells else response()

        return serve

    def _refuse(self, kind: str, error: Exception) -> None:
        self._warn([Notice(kind, str(error))])

    def _sender_refused(self, message: Any, topic: "Topic") -> bool:
        """Whether this is a recorded command that must not move the robot, or may be one and does more than to stop; says so."""
        replayed = self._plays_a_bag(message, topic.name)
        if replayed:
            self._warn([Notice(
                "replay " + topic.name, "%s refused: it is played back from a bag; set the parameter accept_replay to obey it" % topic.name)])
        elif replayed is None and not topic.stops(message):
            self._warn([Notice("unknown " + topic.name, "%s refused: the ROS master does not say in time whether %s plays a bag" % (
                topic.name, commands.sender(message)))])
        else:
            return False
        return True

    def _plays_a_bag(self, message: Any, topic: str) -> Optional[bool]:
        """Whether its sender is a `rosbag play`, under whatever name: it offers a service of its own. None when the master does not say in time.

        No command waits longer for that than half of cmd_vel_timeout, nor do those behind it: what was asked in vain is not asked again meanwhile.
        A new connection is asked about anew: a player may have the name of a program that was there before.
        """
        node, connection = commands.sender(message), getattr(message, "_connection_header", None)
        known, answer = self._players.get((topic, node), (None, None))
        if answer is None or known is not connection:
            if commands.is_replayed(message):
                return True
            asked_at, timeout = monotonic(), min(MASTER_TIMEOUT, self._watch.cmd_vel_timeout / 2)
            if asked_at < self._ask_again_at:
                return None
            answer = is_offered(node + "/pause_playback", timeout)
            if answer is not None:
                self._players[topic, node] = connection, answer
            if answer is None or monotonic() - asked_at > timeout:
                self._ask_again_at = monotonic() + timeout
                return None
        return answer


class Topic(NamedTuple):
    """A row: a topic that commands come on, how many may wait, and what obeys them."""

    name: str
    message: type
    queue: int
    obey: Callable[[Requests, Any], None]
    stops: Callable[[Any], bool]
    """whether a message does nothing but stop: that is obeyed from whomever it comes"""


class Service(NamedTuple):
    """A row: a service, and what obeys a request and returns the answer's text."""

    name: str
    kind: type
    obey: Callable[[Requests, Any], str]


TOPICS = (
    Topic("cmd_vel", Twist, VELOCITY_QUEUE, Requests.drive, commands.twist_stops),
    Topic("cmd_wheels", WheelVelocities, VELOCITY_QUEUE, Requests.drive_wheels, commands.wheels_stop),
    Topic("cmd_motor_state", MotorState, QUEUE, Requests.follow_motor_state, commands.motors_stop),
    Topic("gripper_control", GripperState, QUEUE, Requests.move_gripper, commands.gripper_stops),
)

SERVICES = (
    Service("set_motors", SetBool, lambda self, request: self.switch_motors(request.data)),
    Service("enable_motors", Empty, lambda self, _: self.switch_motors(True)),
    Service("disable_motors", Empty, lambda self, _: self.switch_motors(False)),
    Service("set_sonar", SetBool, lambda self, request: self.switch_sonar(request.data)),
    Service("reset_odometry", Trigger, lambda self, _: self.reset_odometry()),
)
