#!/usr/bin/python3
"""The tutorial's simple node: print where the robot is and what its sonars see, and drive forward slowly for a while.

    rosrun pioneer_control rosPioneer1.py _duration:=5.0

It looks at nothing: whatever stands ahead is run into. Keep three metres of floor free.
"""

import time

import pioneer_control.interrupt  # noqa: F401: Ctrl-C is no error from here on
import rospy
from geometry_msgs.msg import Twist, Vector3
from nav_msgs.msg import Odometry

from pioneer_control.msg import MotorState, SonarArray
from pioneer_control.ros_node import init_node, ticks, wait_for_clock

NAMESPACE = "pioneer"
SPEED = 0.1  # m/s
MOTORS_ON = 1
PATIENCE = 15.0  # s


def show(text):
    print(text + "\n", end="")  # in one piece: two threads print


def print_odometry(message):
    position, turn = message.pose.pose.position, message.pose.pose.orientation
    show("linear: x=%.2f, y=%.2f, z=%.2f" % (position.x, position.y, position.z))
    show("angular (quaternion): x=%.2f, y=%.2f, z=%.2f, w=%.2f" % (turn.x, turn.y, turn.z, turn.w))


def print_sonar(message):
    show("sonar: " + " ".join("%.2f" % distance for distance in message.ranges))


def switch_motors_on(motors):
    """Ask for the motors until the robot says that they are on; False when it does not in time."""
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end and not rospy.is_shutdown():
        motors.publish(MotorState(state=MOTORS_ON))
        try:
            if rospy.wait_for_message(NAMESPACE + "/motor_state", MotorState, timeout=1.0).state == MOTORS_ON:
                return True
        except rospy.ROSException:
            pass  # nothing heard: the driver may still be on its way
    return False


def main():
    init_node("rosPioneer1")
    duration = float(rospy.get_param("~duration", 20.0))  # s
    wait_for_clock()
    velocity = rospy.Publisher(NAMESPACE + "/cmd_vel", Twist, queue_size=1)
    motors = rospy.Publisher(NAMESPACE + "/cmd_motor_state", MotorState, queue_size=1)
    command = Twist(linear=Vector3(x=SPEED))
    if not switch_motors_on(motors):
        rospy.logerr("the motors do not go on: does the driver run, is the robot's STOP button released?")
        return 1

    def stop():
        command.linear.x = 0.0  # also of what the loop below may still publish
        for _ in range(3):  # the process may end next: give the message time to leave
            velocity.publish(command)
            time.sleep(0.05)

    rospy.on_shutdown(stop)  # at the end, at Ctrl-C and at rosnode kill
    rospy.Subscriber(NAMESPACE + "/pose", Odometry, print_odometry, queue_size=1)
    rospy.Subscriber(NAMESPACE + "/sonar", SonarArray, print_sonar, queue_size=1)
    for _ in ticks(10, duration):  # ten times a second: the driver stops a robot that is not told for 0.6 s
        velocity.publish(command)


if __name__ == "__main__":
    try:
        raise SystemExit(main())
    except rospy.ROSInterruptException:
        pass
