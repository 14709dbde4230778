#!/usr/bin/python3
"""The tutorial's simple node: print the pose and the sonar ranges, and drive forward slowly for a while.

    rosrun pioneer_control rosPioneer1.py [NAMESPACE] [_duration:=5.0]

NAMESPACE is the namespace of the robot (default: pioneer). The node avoids no obstacles: keep three metres free.
"""

import time

import pioneer_control.interrupt  # noqa: F401  # from here on Ctrl-C is no error
import rospy
from geometry_msgs.msg import Twist, Vector3
from nav_msgs.msg import Odometry

from pioneer_control.msg import MotorState, SonarArray
from pioneer_control.ros_node import init_node, name_for, ticks, wait_for_clock

SPEED = 0.1  # m/s
MOTORS_ON = 1


def show(text):
    print(text + "\n", end="")  # in one piece: two threads print


def print_odometry(message):
    position, turn = message.pose.pose.position, message.pose.pose.orientation
    show("linear: x=%.2f, y=%.2f, z=%.2f" % (position.x, position.y, position.z))
    show("angular (quaternion): x=%.2f, y=%.2f, z=%.2f, w=%.2f" % (turn.x, turn.y, turn.z, turn.w))


def print_sonar(message):
    show("sonar: " + " ".join("%.2f" % distance for distance in message.ranges))


def switch_motors_on(motors, topic):
    """Request motors on until the robot reports that they are on. Return False after 15 s without this report."""
    wrong, end = "nothing comes on %s. Does the driver of this robot run?", time.monotonic() + 15.0  # s
    while time.monotonic() < end and not rospy.is_shutdown():
        motors.publish(MotorState(state=MOTORS_ON))
        try:
            if rospy.wait_for_message(topic, MotorState, timeout=1.0).state == MOTORS_ON:
                return True
            wrong = "%s says that they are off. Is the robot's STOP button pressed?"
        except rospy.ROSException:
            pass  # no message: the driver may still be starting
    rospy.logerr("the motors do not go on: " + wrong, rospy.resolve_name(topic))
    return False


def main():
    robot = (rospy.myargv()[1:] or ["pioneer"])[0].rstrip("/")
    init_node(name_for("rosPioneer1", robot))
    duration = float(rospy.get_param("~duration", 20.0))  # s
    wait_for_clock()
    velocity = rospy.Publisher(robot + "/cmd_vel", Twist, queue_size=1)
    motors = rospy.Publisher(robot + "/cmd_motor_state", MotorState, queue_size=1)
    command = Twist(linear=Vector3(x=SPEED))
    if not switch_motors_on(motors, robot + "/motor_state"):
        return 1

    def stop():
        command.linear.x = 0.0  # the loop below may still publish this message once more
        for _ in range(3):  # the process may end next: give the message time to go out
            velocity.publish(command)
            time.sleep(0.05)

    rospy.on_shutdown(stop)  # at the end, at Ctrl-C and at rosnode kill
    rospy.Subscriber(robot + "/pose", Odometry, print_odometry, queue_size=1)
    rospy.Subscriber(robot + "/sonar", SonarArray, print_sonar, queue_size=1)
    for _ in ticks(10, duration):  # ten times a second: the driver stops the robot after 0.6 s without a velocity
        velocity.publish(command)


if __name__ == "__main__":
    try:
        raise SystemExit(main())
    except rospy.ROSInterruptException:
        pass
