"""In: commands to the robot, from topics and services. Called on the subscribers' threads; `commands` says what is obeyed."""

import threading
from time import monotonic
from typing import Callable, Dict, Iterable

import rospy
from geometry_msgs.msg import Twist
from std_srvs.srv import SetBool, SetBoolResponse

from ..client import Robot
from ..errors import PioneerError
from ..msg import GripperState, MotorState
from . import commands
from .notices import Notice, Watch
from .parameters import DriverParameters

QUEUE = 10
CONFIRM_TIMEOUT = 2.0
"""Seconds the robot has to confirm that its motors are on or off."""


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
        self._players: Dict[str, bool] = {}     # nodes that sent commands: is it `rosbag play`?
        rospy.Subscriber("cmd_vel", Twist, self._on_cmd_vel, queue_size=1, tcp_nodelay=True)
        rospy.Subscriber("cmd_motor_state", MotorState, self._on_cmd_motor_state, queue_size=QUEUE)
        rospy.Subscriber("gripper_control", GripperState, self._on_gripper_control, queue_size=QUEUE)
        rospy.Service("set_motors", SetBool, self._set_motors)

    def _refuse(self, kind: str, error: Exception) -> None:
        self._warn([Notice(kind, str(error))])

    def _replay_refused(self, message, topic: str) -> bool:
        """Whether this is a recorded command that must not move the robot; says so."""
        if self._parameters.accept_replay or not (commands.is_replayed(message) or self._plays_a_bag(commands.sender(message))):
            return False
        self._warn([Notice("replay " + topic, "%s refused: it is played back from a bag; set the parameter accept_replay to obey it" % topic)])
        return True

    def _plays_a_bag(self, node: str) -> bool:
        """Whether a node is a `rosbag play` under another name: it offers a service of its own. Asked once per node."""
        if node not in self._players:
            try:
                found, _, _ = rospy.get_master().lookupService(node + "/pause_playback")
            except OSError:     # the master is gone
                found = 0
            self._players[node] = found == 1
        return self._players[node]

    def _on_cmd_vel(self, message: Twist) -> None:
        if self._replay_refused(message, "cmd_vel"):
            return
        try:
            commands.check_twist(message)
            self._robot.set_velocity(message.linear.x, message.angular.z)
        except PioneerError as error:
            self._refuse("cmd_vel", error)
        else:
            self._warn(self._watch.velocity(monotonic(), bool(message.linear.x or message.angular.z), self._robot.state))

    def _on_cmd_motor_state(self, message: MotorState) -> None:
        if self._replay_refused(message, "cmd_motor_state"):
            return
        try:
            wait = self._request_motors(commands.motors_wanted(message))
        except PioneerError as error:
            self._refuse("cmd_motor_state", error)
        else:   # waits elsewhere: the next message may want the opposite
            threading.Thread(target=self._hear_answer, args=(wait,), name="motors", daemon=True).start()

    def _hear_answer(self, wait: Callable[[], None]) -> None:
        try:
            wait()
        except PioneerError as error:
            self._refuse("cmd_motor_state", error)

    def _on_gripper_control(self, message: GripperState) -> None:
        if self._replay_refused(message, "gripper_control"):
            return
        try:
            for command in commands.gripper_commands(message):
                self._robot.gripper(command)
        except PioneerError as error:
            self._refuse("gripper_control", error)

    def _set_motors(self, request) -> SetBoolResponse:
        try:
            self._request_motors(request.data)()
        except PioneerError as error:
            return SetBoolResponse(False, str(error))
        return SetBoolResponse(True, "motors are %s" % ("on" if request.data else "off"))

    def _request_motors(self, on: bool) -> Callable[[], None]:
        """Ask for the motors at once. Returns what waits for the robot's answer; both raise PioneerError with the reason when it is no."""
        before = self._robot.state
        answer = self._robot.request_motors(on, CONFIRM_TIMEOUT)

        def wait() -> None:
            answer()
            if before is None or before.motors_enabled != on:
                rospy.loginfo("motors are %s", "on" if on else "off")

        return wait
