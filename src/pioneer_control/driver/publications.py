"""Out: what the robot reports, on topics. Called on the client's I/O thread."""

import rospy
import tf2_ros
from nav_msgs.msg import Odometry

from ..client import RobotIdentity, RobotState
from ..msg import AIO, DIO, BatteryState, GripperState, MotorState, RobotInfo, SonarArray
from . import conversions
from .parameters import DriverParameters

QUEUE = 10


class Publications:
    """All publishers of the node."""

    def __init__(self, parameters: DriverParameters) -> None:
        self._parameters = parameters
        self._gripper_reporter = conversions.GripperReporter()
        self._pose = _publisher("pose", Odometry)
        self._sonar = _publisher("sonar", SonarArray)
        self._motor_state = _publisher("motor_state", MotorState)
        self._battery_state = _publisher("battery_state", BatteryState)
        self._dio = _publisher("dio", DIO)
        self._aio = _publisher("aio", AIO)
        self._robot_info = _publisher("robot_info", RobotInfo, latch=True)
        self._gripper_state = None  # advertised when a robot with a gripper is there
        self._transform = tf2_ros.TransformBroadcaster() if parameters.publish_tf else None

    def identity(self, identity: RobotIdentity) -> None:
        """Once per connection: what robot it is."""
        if identity.has_gripper and self._gripper_state is None:
            self._gripper_state = _publisher("gripper_state", GripperState)
        self._robot_info.publish(conversions.robot_info(identity, rospy.Time.now(), self._parameters.base_link_frame))

    def state(self, state: RobotState) -> None:
        """Once per SIP; all messages with one stamp."""
        stamp, base_link = rospy.Time.now(), self._parameters.base_link_frame
        pose = conversions.odometry(state, stamp, self._parameters.odom_frame, base_link)
        self._pose.publish(pose)
        if self._transform is not None:
            self._transform.sendTransform(conversions.transform(pose))
        if state.sonar_enabled:
            self._sonar.publish(conversions.sonar_array(state, stamp, base_link))
        if state.gripper is not None and self._gripper_state is not None:
            self._gripper_state.publish(self._gripper_reporter.message(state.gripper))
        self._motor_state.publish(conversions.motor_state(state))
        self._battery_state.publish(conversions.battery_state(state, stamp, base_link))
        for publisher, message in ((self._dio, conversions.digital_inputs(state)), (self._aio, conversions.analog_input(state))):
            if message is not None:
                publisher.publish(message)


def _publisher(name: str, message_class: type, latch: bool = False) -> rospy.Publisher:
    return rospy.Publisher(name, message_class, queue_size=QUEUE, latch=latch)
