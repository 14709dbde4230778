"""Publishes the commands of a program on the topics of the robot."""

import time
from typing import List

import genpy
import rospy
from geometry_msgs.msg import Twist, Vector3

from ..message_values import GripCommand, LiftCommand
from ..msg import Decision, GripperState, GripState, LiftState, MotorState
from ..ros_node import listeners
from .reports import MOTORS_ON
from .sender import Sender
from .sights import Sight
from .wander import Move
from .wandering import Wandering

ASK_AGAIN = 0.1  #: s between two requests to the ROS master


class Commander:
    """Publishes commands to the robot. After `end`, a method that publishes raises ROSInterruptException."""

    def __init__(self, prefix: str):
        """Advertise the command topics of the robot. Their names begin with `prefix`."""
        self._velocity = rospy.Publisher(prefix + "cmd_vel", Twist, queue_size=1)
        self._motors = rospy.Publisher(prefix + "cmd_motor_state", MotorState, queue_size=1)
        self._gripper = rospy.Publisher(prefix + "gripper_control", GripperState, queue_size=2)
        self._decisions = rospy.Publisher(prefix + "decision", Decision, queue_size=0)  # 0: none is ever dropped
        self._sender = Sender(self._velocity, Twist())
        self._driving = self._ended = False

    def drive(self, linear: float, angular: float) -> None:
        """Publish a velocity: forward [m/s] and counter-clockwise [rad/s]."""
        self._driving = True
        self._send(self._velocity, Twist(Vector3(x=linear), Vector3(z=angular)))

    def stop(self) -> None:
        """Publish velocity 0. Do nothing when this program has not published a velocity since the last stop."""
        if self._driving:
            self._sender.send(self._velocity, Twist())
            self._driving = False

    def enable_motors(self) -> None:
        """Publish the request to switch the motors on."""
        self._send(self._motors, MotorState(state=MOTORS_ON))

    def move_gripper(self, grip: GripCommand, lift: LiftCommand) -> None:
        """Publish a command to the paddles (`grip`) and the lift."""
        self._send(self._gripper, GripperState(GripState(state=grip), LiftState(state=lift)))

    def tell(self, number: int, wandering: Wandering, sight: Sight, move: Move) -> None:
        """Publish a decision of the wander on the topic ``decision``.

        Args:
            number: which wander of this program it is: 1, 2, ...
            wandering: the wander that decided.
            sight: the sensor data that it decided on. The message gets the stamp of this data.
            move: the decision.
        """
        message = Decision(wander=number, seed=wandering.seed, speed=wandering.speed, **move._asdict())
        message.header.stamp = rospy.Time(nsecs=sight.stamp)
        self._send(self._decisions, message)

    def end(self) -> None:
        """Stop the robot if it drives, and publish no more commands."""
        self._ended = True
        self._sender.end()

    def unheard(self) -> List[str]:
        """Return "listener on TOPIC" for each velocity and motor topic that has no subscriber. A driver subscribes."""
        return ["listener on %s" % each.resolved_name for each in (self._velocity, self._motors)
                if not each.get_num_connections()]

    def wait_for_listeners(self, timeout: float) -> None:
        """Wait until all subscribers that the ROS master knows are connected, at most `timeout` seconds.

        A recorder that is not connected yet would miss the first messages. The time-out is needed because the master
        may still know a program that was killed, and that never connects.
        """
        ours = self._velocity, self._motors, self._gripper, self._decisions
        end = time.monotonic() + timeout
        while time.monotonic() < end:
            known = listeners(end - time.monotonic())
            if all(each.get_num_connections() >= len(known.get(each.resolved_name, ())) for each in ours):
                return
            time.sleep(ASK_AGAIN)

    def _send(self, publisher: rospy.Publisher, message: genpy.Message) -> None:
        """Publish a message soon, in the sender's thread. Raises ROSInterruptException when the program ends."""
        if self._ended or rospy.is_shutdown():
            raise rospy.ROSInterruptException("this program is ending and drives the robot no more")
        self._sender.send(publisher, message)
