"""What a program tells its robot, on the robot's topics."""

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

ASK_AGAIN = 0.1  #: s between two questions to the master


class Commander:
    """Publishes what the robot shall do. After `end` it raises ROSInterruptException instead."""

    def __init__(self, prefix: str):
        """Advertise the robot's topics, which begin with `prefix`."""
        self._velocity = rospy.Publisher(prefix + "cmd_vel", Twist, queue_size=1)
        self._motors = rospy.Publisher(prefix + "cmd_motor_state", MotorState, queue_size=1)
        self._gripper = rospy.Publisher(prefix + "gripper_control", GripperState, queue_size=2)
        self._decisions = rospy.Publisher(prefix + "decision", Decision, queue_size=0)  # 0: none is ever dropped
        self._sender = Sender(self._velocity, Twist())
        self._driving = self._ended = False

    def drive(self, linear: float, angular: float) -> None:
        """Command a velocity [m/s, rad/s]."""
        self._driving = True
        self._send(self._velocity, Twist(Vector3(x=linear), Vector3(z=angular)))

    def stop(self) -> None:
        """Command the robot to stand. Does nothing unless this program drives."""
        if self._driving:
            self._sender.send(self._velocity, Twist())
            self._driving = False

    def enable_motors(self) -> None:
        """Ask for the motors."""
        self._send(self._motors, MotorState(state=MOTORS_ON))

    def move_gripper(self, grip: GripCommand, lift: LiftCommand) -> None:
        """Command the paddles and the lift."""
        self._send(self._gripper, GripperState(GripState(state=grip), LiftState(state=lift)))

    def tell(self, number: int, wandering: Wandering, sight: Sight, move: Move) -> None:
        """Publish what the wander of this number decided on a sight."""
        message = Decision(wander=number, seed=wandering.seed, speed=wandering.speed, **move._asdict())
        message.header.stamp = rospy.Time(nsecs=sight.stamp)
        self._send(self._decisions, message)

    def end(self) -> None:
        """Command the robot to stand, and command nothing any more."""
        self._ended = True
        self._sender.end()

    def unheard(self) -> List[str]:
        """The topics on which a driver must listen, and nobody does."""
        return ["listener on %s" % each.resolved_name for each in (self._velocity, self._motors)
                if not each.get_num_connections()]

    def wait_for_listeners(self, timeout: float) -> None:
        """Wait until all that listen, by what the master knows, are connected, at most `timeout` seconds.

        A recorder that is not connected yet would miss the first messages. A program that was killed never connects.
        """
        ours = self._velocity, self._motors, self._gripper, self._decisions
        end = time.monotonic() + timeout
        while time.monotonic() < end:
            known = listeners(end - time.monotonic())
            if all(each.get_num_connections() >= len(known.get(each.resolved_name, ())) for each in ours):
                return
            time.sleep(ASK_AGAIN)

    def _send(self, publisher: rospy.Publisher, message: genpy.Message) -> None:
        if self._ended or rospy.is_shutdown():
            raise rospy.ROSInterruptException("this program is ending and drives the robot no more")
        self._sender.send(publisher, message)
