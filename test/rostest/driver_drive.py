#!/usr/bin/python3
"""The driver drives the simulated robot: motors, distances, angles, sonar ranges as geometry gives them, and all that
must stop the robot or keep it still.
"""

import math
import os
import subprocess
import sys
import threading
import unittest

import dynamic_reconfigure.client
import rospy
import rostest
import tf
from geometry_msgs.msg import Point, PointStamped, Twist
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Log
from sensor_msgs.msg import BatteryState as Battery
from sensor_msgs.msg import JointState, PointCloud2, Range
from sensor_msgs.point_cloud2 import read_points
from std_msgs.msg import Bool, Header
from std_srvs.srv import Empty, SetBool, Trigger

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

from pioneer_control.msg import (AIO, DIO, IO, BatteryState, GripperState, GripState, LiftState, MotorState,
                                 RobotInfo, SonarArray, Sounds, Stall, WheelVelocities)
from pioneer_control.ros_node import is_at_work
from pioneer_control.srv import SetDigitalOut
from witness import PATIENCE, Witness, heading_of

TOPICS = {
    "pioneer/pose": Odometry, "pioneer/sonar": SonarArray, "pioneer/gripper_state": GripperState,
    "pioneer/motor_state": MotorState,
    "pioneer/battery_state": BatteryState, "pioneer/dio": DIO, "pioneer/aio": AIO, "pioneer/robot_info": RobotInfo,
    "pioneer/sonar_ranges": Range, "pioneer/sonar_points": PointCloud2, "pioneer/joint_states": JointState,
    "pioneer/battery": Battery,
    "pioneer/stall": Stall, "pioneer/e_stop": Bool, "pioneer/io": IO,
    "pioneer/ground_truth": Odometry, "/rosout": Log,
}
OF_EVERY_PACKET = "sonar", "sonar_points", "joint_states", "battery", "battery_state", "stall"
WHEEL_RADIUS = 0.0975
NOISE = 0.004   # m: the simulated sonar's, and the wire's whole millimetres
HALF_CONE = math.radians(12.5)


class Commander:
    """Publishes one velocity at 10 Hz until it gets another one. With None it publishes nothing."""

    def __init__(self):
        self.publisher = rospy.Publisher("pioneer/cmd_vel", Twist, queue_size=1)
        self.velocity = None
        self._ended = threading.Event()
        threading.Thread(target=self._run, daemon=True).start()

    def _run(self):
        while not self._ended.wait(0.1):
            velocity = self.velocity
            if velocity is not None:
                twist = Twist()
                twist.linear.x, twist.angular.z = velocity
                self.publisher.publish(twist)


class DriverDrives(unittest.TestCase):
    """One robot. Each test begins where the previous test left the robot."""

    @classmethod
    def setUpClass(cls):
        cls.witness = Witness(TOPICS)
        cls.commander = Commander()
        cls.stop_button = rospy.Publisher("pioneer/stop_button", Bool, queue_size=1)
        rospy.wait_for_service("pioneer/set_motors", PATIENCE)
        cls.set_motors = rospy.ServiceProxy("pioneer/set_motors", SetBool)
        for topic in ("pioneer/sonar", "pioneer/gripper_state", "pioneer/ground_truth"):
            cls.witness.last(topic)
        cls.witness.wait("the driver listens", lambda: cls.commander.publisher.get_num_connections() == 1)

    def truth(self):
        return self.witness.next("pioneer/ground_truth").pose.pose

    def motors_on(self):
        answer = self.set_motors(True)
        self.assertTrue(answer.success, answer.message)

    def stands(self):
        def still():
            twist = self.witness.seen["pioneer/ground_truth"][-1].twist.twist
            return twist.linear.x == 0.0 and twist.angular.z == 0.0

        self.witness.next("pioneer/ground_truth")
        self.witness.wait("the robot stands", still)

    def halt(self):
        self.commander.velocity = (0.0, 0.0)
        self.stands()
        self.commander.velocity = None

    def drive_until(self, velocity, what, condition):
        self.commander.velocity = velocity
        self.witness.wait(what, lambda: condition(self.witness.seen["pioneer/pose"][-1].pose.pose))
        self.halt()

    def warned(self, text, since=0):
        return any(text in entry.msg and entry.name == "/pioneer/p2os"
                   for entry in self.witness.seen["/rosout"][since:])

    def expect_warning(self, text, since=0):
        self.witness.wait("a warning with %r" % text, lambda: self.warned(text, since))

    def test_01_every_topic_says_something_sensible(self):
        seen = {topic: self.witness.last(topic) for topic in TOPICS}
        self.assertEqual(seen["pioneer/pose"].header.frame_id, "odom")
        self.assertEqual(seen["pioneer/pose"].child_frame_id, "base_link")
        self.assertEqual((seen["pioneer/sonar"].ranges_count, len(seen["pioneer/sonar"].ranges)), (16, 16))
        self.assertEqual(seen["pioneer/motor_state"].state, 0)
        self.assertAlmostEqual(seen["pioneer/battery_state"].voltage, 13.0, delta=0.3)
        self.assertEqual((seen["pioneer/dio"].count, seen["pioneer/aio"].voltages_count), (8, 1))
        info = seen["pioneer/robot_info"]
        self.assertEqual((info.type, info.subtype, info.has_gripper), ("Pioneer", "p3dx-sh", True))
        self.assertEqual(list(info.sonar_numbers), list(range(16)))
        battery = seen["pioneer/battery"]
        self.assertAlmostEqual(battery.voltage, 13.0, delta=0.3)
        self.assertTrue(math.isnan(battery.percentage))
        self.assertEqual(battery.power_supply_status, Battery.POWER_SUPPLY_STATUS_DISCHARGING)
        self.assertEqual((len(seen["pioneer/io"].digital_in), len(seen["pioneer/io"].analog)), (4, 9))
        self.assertEqual((seen["pioneer/stall"].left, seen["pioneer/stall"].right, seen["pioneer/e_stop"].data),
                         (False, False, False))

    def test_02_one_stamp_for_all_messages_of_a_packet(self):
        for name in OF_EVERY_PACKET:
            self.witness.next("pioneer/" + name, 3)
        stamps = {message.header.stamp for message in self.witness.seen["pioneer/pose"]}
        for name in OF_EVERY_PACKET:
            self.assertIn(self.witness.seen["pioneer/" + name][-2].header.stamp, stamps, name)
        self.witness.next("pioneer/sonar_ranges", 20)
        ranges = self.witness.seen["pioneer/sonar_ranges"][:]
        together = [message.header.frame_id for message in ranges if message.header.stamp == ranges[-10].header.stamp]
        self.assertIn(ranges[-10].header.stamp, {message.header.stamp for message in self.witness.seen["pioneer/pose"]})
        self.assertTrue(4 <= len(set(together)) == len(together) <= 6,
                        "two arrays fire two or three times in a cycle: %s" % together)

    def test_02_what_this_robot_cannot_feed_is_not_there(self):
        there = {name for name, _ in rospy.get_published_topics("/pioneer")}
        self.assertLessEqual({"/pioneer/" + name for name in OF_EVERY_PACKET}, there)
        self.assertFalse({"/pioneer/bumpers", "/pioneer/imu", "/pioneer/compass"} & there)

    def test_03_sonar_sees_what_geometry_says(self):
        """Each expected range is calculated here in closed form, from the place of the transducer and the world file.
        """
        self.witness.next("pioneer/sonar", 5)  # every transducer has fired since the robot stands here
        ranges = self.witness.seen["pioneer/sonar"][-1].ranges
        edge_of_2 = math.radians(30) - HALF_CONE
        edge_of_13 = math.radians(180 - 150) + HALF_CONE
        expected = {
            # wall square on: the foot of the perpendicular is in the cone
            3: 2.5 - 0.166,
            4: 2.5 - 0.166,
            # ... and here outside: the edge of the cone is nearest
            2: (2.5 - 0.148) / math.cos(edge_of_2),
            # wall at 5 degrees: the perpendicular is 5 degrees off the axis
            0: 1.0 * math.cos(math.radians(5)),
            7: 1.186 - 0.136 - 0.05,                                # pole
            13: (0.9 - 0.078) / math.sin(edge_of_13),               # corner from inside: the nearer of its two walls
            10: 1.2,                                                # corner from outside: the corner itself
        }
        for number, distance in expected.items():
            self.assertAlmostEqual(ranges[number], distance, delta=NOISE, msg="transducer %s" % number)
        self.assertEqual(ranges[6], 5.0, "nothing there: no echo")
        heard = {message.header.frame_id: message.range for message in self.witness.seen["pioneer/sonar_ranges"]}
        self.assertEqual(heard["sonar_6"], math.inf)
        for number, distance in expected.items():
            self.assertAlmostEqual(heard["sonar_%d" % number], distance, delta=NOISE,
                                   msg="frame of transducer %s" % number)

    def test_03_points_lie_on_the_axes_of_the_transducers(self):
        """tf has a frame for each transducer. An echo lies on the x axis of this frame, at the distance of the range.
        """
        listener = tf.TransformListener()
        ranges = self.witness.next("pioneer/sonar", 5).ranges
        echoes = [number for number, distance in enumerate(ranges) if distance < 5.0]
        points = list(read_points(self.witness.next("pioneer/sonar_points")))
        self.assertEqual(len(points), len(echoes))
        for number, (x, y, z) in zip(echoes, points):
            frame = "sonar_%d" % number
            listener.waitForTransform(frame, "odom", rospy.Time(0), rospy.Duration(PATIENCE))
            point = PointStamped(header=Header(frame_id="base_link"), point=Point(x, y, z))
            there = listener.transformPoint(frame, point).point
            self.assertAlmostEqual(there.x, ranges[number], delta=0.01)
            self.assertAlmostEqual(math.hypot(there.y, there.z), 0.0, delta=1e-4)

    def test_04_motors_stay_off_until_asked(self):
        before, since = self.truth(), len(self.witness.seen["/rosout"])
        self.commander.velocity = (0.3, 0.0)
        self.expect_warning("motors are off; to switch them on: rosservice call /pioneer/set_motors true", since)
        self.witness.next("pioneer/motor_state", 10)
        self.commander.velocity = None
        self.assertEqual({message.state for message in self.witness.seen["pioneer/motor_state"]}, {0})
        self.assertEqual(self.truth().position, before.position)

    def test_05_a_distance(self):
        self.motors_on()
        start, before = self.truth(), self.witness.next("pioneer/joint_states").position
        self.drive_until((0.2, 0.0), "0.4 m", lambda pose: pose.position.x > 0.4)
        odometry, truth = self.witness.next("pioneer/pose").pose.pose, self.truth()
        self.assertAlmostEqual(truth.position.x - start.position.x, odometry.position.x, delta=0.003)
        self.assertAlmostEqual(truth.position.y, start.position.y, delta=0.003)
        self.assertLess(odometry.position.x, 0.7)
        for turned in (angle - angle_before
                       for angle, angle_before in zip(self.witness.next("pioneer/joint_states").position, before)):
            self.assertAlmostEqual(turned * WHEEL_RADIUS, truth.position.x - start.position.x, delta=0.003)
        self.assertAlmostEqual(max(message.velocity[0] for message in self.witness.seen["pioneer/joint_states"]),
                               0.2 / WHEEL_RADIUS, delta=0.05)
        self.witness.next("pioneer/sonar", 5)
        self.assertAlmostEqual(self.witness.seen["pioneer/sonar"][-1].ranges[3], 2.5 - 0.166 - truth.position.x,
                               delta=0.004)

    def test_06_an_angle(self):
        self.drive_until((0.0, 0.5), "a quarter turn to the left", lambda pose: heading_of(pose) > math.pi / 2)
        heading = heading_of(self.witness.next("pioneer/pose").pose.pose)
        self.assertAlmostEqual(heading_of(self.truth()), heading, delta=0.005)
        self.assertLess(heading, math.pi / 2 + 0.4)
        self.drive_until((0.0, -0.5), "and back", lambda pose: heading_of(pose) < 0.1)

    def test_07_tf_agrees_with_pose(self):
        listener = tf.TransformListener()
        listener.waitForTransform("odom", "base_link", rospy.Time(0), rospy.Duration(PATIENCE))
        pose = self.witness.next("pioneer/pose", 3).pose.pose
        listener.waitForTransform("odom", "base_link", self.witness.seen["pioneer/pose"][-1].header.stamp,
                                  rospy.Duration(PATIENCE))
        place, _ = listener.lookupTransform("odom", "base_link", rospy.Time(0))
        self.assertAlmostEqual(place[0], pose.position.x, delta=0.002)
        for wheel, side in (("left_wheel", 0.1885), ("right_wheel", -0.1885)):
            listener.waitForTransform("odom", wheel, rospy.Time(0), rospy.Duration(PATIENCE))
            (x, y, z), _ = listener.lookupTransform("base_link", wheel, rospy.Time(0))
            self.assertEqual((x, round(y, 6), round(z, 6)), (0.0, side, WHEEL_RADIUS))

    def test_08_a_commander_that_falls_silent_stops_the_robot(self):
        self.commander.velocity = (0.2, 0.0)
        self.witness.wait("it drives", lambda: (
            self.witness.seen["pioneer/ground_truth"][-1].twist.twist.linear.x > 0.15))
        since = len(self.witness.seen["/rosout"])
        self.commander.velocity = None  # the publisher stays connected, and the driver keeps the link alive
        self.stands()
        self.expect_warning("no velocity came for 0.6 s", since)
        self.assertEqual(self.witness.last("pioneer/motor_state").state, 1)

    def test_09_a_velocity_that_is_not_a_number_moves_nothing(self):
        before, since = self.truth(), len(self.witness.seen["/rosout"])
        self.commander.velocity = (math.nan, 0.5)
        self.expect_warning("linear.x is nan", since)
        self.witness.next("pioneer/ground_truth", 5)
        self.commander.velocity = None
        self.assertEqual(self.truth(), before)

    def test_10_a_velocity_beyond_the_limits_is_clamped(self):
        self.commander.velocity = (-65.6, 0.0)
        self.witness.wait("it drives back", lambda: (
            self.witness.seen["pioneer/ground_truth"][-1].twist.twist.linear.x < -0.25))
        self.halt()
        truth = self.witness.seen["pioneer/ground_truth"]
        self.assertGreaterEqual(min(message.twist.twist.linear.x for message in truth), -0.501)

    def test_11_the_stop_button_is_a_reason_and_nothing_moves_after_it(self):
        self.stop_button.publish(True)
        self.witness.wait("motors go off", lambda: self.witness.seen["pioneer/motor_state"][-1].state == 0)
        answer = self.set_motors(True)
        self.assertFalse(answer.success)
        self.assertIn("STOP button", answer.message)
        self.expect_warning("STOP button is pressed")
        self.assertTrue(self.witness.seen["pioneer/e_stop"][-1].data)
        stall = self.witness.next("pioneer/stall")
        self.assertEqual((stall.left, stall.right), (True, True))
        self.stop_button.publish(False)
        before = self.truth()
        self.witness.wait("motors can be switched on again", lambda: self.set_motors(True).success)
        self.witness.next("pioneer/ground_truth", 5)
        self.assertEqual(self.truth().position, before.position)
        self.assertEqual([message.data for message in self.witness.seen["pioneer/e_stop"]], [False, True, False],
                         "on change")

    def test_12_gripper_commands_work_and_a_status_is_refused(self):
        gripper = rospy.Publisher("pioneer/gripper_control", GripperState, queue_size=5)
        since = len(self.witness.seen["/rosout"])
        self.witness.wait("the driver listens", lambda: gripper.get_num_connections() == 1)
        gripper.publish(GripperState(GripState(state=2), LiftState(state=1)))
        self.expect_warning("lift.state 1 is a status", since)
        self.assertEqual(self.witness.next("pioneer/gripper_state").grip.state, 1)
        gripper.publish(GripperState(GripState(state=2), LiftState(state=5)))
        self.witness.wait("paddles closed, lift down", lambda: (
            self.witness.seen["pioneer/gripper_state"][-1].grip.state,
            self.witness.seen["pioneer/gripper_state"][-1].lift.position) == (2, 0.0))

    def test_13_the_topic_switches_motors_too(self):
        motors = rospy.Publisher("pioneer/cmd_motor_state", MotorState, queue_size=5)
        self.witness.wait("the driver listens", lambda: motors.get_num_connections() == 1)
        for state in (0, 1, 0):
            motors.publish(MotorState(state))
            self.witness.wait("motors %s" % state, lambda: (
                self.witness.seen["pioneer/motor_state"][-1].state == state))

    def test_14_the_services_of_rosaria_fail_with_the_reason(self):
        enable, disable = (rospy.ServiceProxy("pioneer/%s_motors" % what, Empty) for what in ("enable", "disable"))
        self.stop_button.publish(True)
        self.witness.wait("it is pressed", lambda: self.witness.seen["pioneer/e_stop"][-1].data)
        with self.assertRaisesRegex(rospy.ServiceException, "the STOP button is pressed; release it and ask again"):
            enable()
        self.stop_button.publish(False)
        self.witness.wait("it is released", lambda: not self.witness.seen["pioneer/e_stop"][-1].data)
        for service, state in ((enable, 1), (disable, 0), (enable, 1)):
            service()
            self.assertEqual(self.witness.next("pioneer/motor_state").state, state)

    def test_15_the_sonar_goes_off_and_on(self):
        switch = rospy.ServiceProxy("pioneer/set_sonar", SetBool)
        self.assertEqual((switch(False).success, switch(False).message), (True, "the sonar is off"))
        self.witness.next("pioneer/pose", 3)
        heard = len(self.witness.seen["pioneer/sonar"])
        self.witness.next("pioneer/pose", 5)
        self.assertEqual(len(self.witness.seen["pioneer/sonar"]), heard)
        self.assertEqual(switch(True).message, "the sonar is on")
        self.witness.next("pioneer/sonar")

    def test_16_dynamic_reconfigure_changes_what_the_robot_does(self):
        client = dynamic_reconfigure.client.Client("pioneer/p2os", timeout=PATIENCE)
        since = len(self.witness.seen["/rosout"])
        with self.assertRaises(dynamic_reconfigure.DynamicReconfigureCallbackException):
            client.update_configuration({"max_yawspeed": 99.0})
        self.expect_warning("~max_yawspeed = 99.0 is not legal: give a number from 0.02 to 6.3 (rad/s)", since)
        self.assertEqual(client.update_configuration({"max_yawspeed": 0.3, "max_yawaccel": 0.5})["max_yawspeed"], 0.3)
        self.assertEqual(rospy.get_param("pioneer/p2os/max_yawspeed"), 0.3)
        self.witness.wait("robot_info tells it", lambda: self.witness.seen["pioneer/robot_info"][-1].max_angular == 0.3)
        since = len(self.witness.seen["pioneer/ground_truth"])
        self.commander.velocity = (0.0, -2.0)
        self.witness.wait("it turns", lambda: (
            self.witness.seen["pioneer/ground_truth"][-1].twist.twist.angular.z < -0.29))
        self.halt()
        truth = self.witness.seen["pioneer/ground_truth"][since:]
        self.assertGreaterEqual(min(message.twist.twist.angular.z for message in truth), -0.301)

    def test_17_wheels_have_a_topic_of_their_own(self):
        wheels = rospy.Publisher("pioneer/cmd_wheels", WheelVelocities, queue_size=1)
        self.witness.wait("the driver listens", lambda: wheels.get_num_connections() == 1)
        ended = threading.Event()

        def command():
            while not ended.wait(0.1):
                wheels.publish(WheelVelocities(-0.1, -0.06))

        thread = threading.Thread(target=command)
        thread.start()
        try:
            self.witness.wait("a curve", lambda: (lambda twist: twist.linear.x < -0.07 and twist.angular.z > 0.05)(
                self.witness.seen["pioneer/ground_truth"][-1].twist.twist))
        finally:
            ended.set()
            thread.join()
        self.stands()

    def test_18_accessories_over_ros(self):
        outputs = rospy.ServiceProxy("pioneer/dio_out", SetDigitalOut)
        self.assertTrue(outputs(0x30, 0x10).success)
        self.witness.wait("io shows it", lambda: self.witness.last("pioneer/io").digital_out == bytes([0x10]))
        refused = outputs(0x01, 0x01)
        self.assertEqual((refused.success, refused.message),
                         (False, "the outputs 0x01 drive the gripper: use gripper_control"))
        self.assertIn("no charger", rospy.ServiceProxy("pioneer/dock", Trigger)().message)
        self.assertIn("the motors are off" if not self.witness.last("pioneer/motor_state").state else "may drive it",
                      rospy.ServiceProxy("pioneer/set_joystick_drive", SetBool)(True).message)
        rospy.ServiceProxy("pioneer/teleop/release", Trigger)()
        since = len(self.witness.seen["/rosout"])
        speaker = rospy.Publisher("pioneer/say", Sounds, queue_size=1)
        self.witness.wait("the driver listens", lambda: speaker.get_num_connections() == 1)
        speaker.publish(Sounds([0.1, 0.1], [69]))
        self.expect_warning("say refused: there are 2 durations and 1 tones", since)

    def test_19_the_description_is_that_of_the_robot_that_is_there(self):
        self.assertIn('<robot name="p3dx-sh">', rospy.get_param("pioneer/robot_description"))
        listener = tf.TransformListener()
        listener.waitForTransform("base_link", "gripper", rospy.Time(0), rospy.Duration(PATIENCE))
        (x, _, z), _ = listener.lookupTransform("base_link", "sonar_3", rospy.Time(0))
        self.assertEqual((round(x, 6), round(z, 6)), (0.166, 0.17))

    def test_20_a_second_description_leaves_the_first_one_alone(self):
        program = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "nodes", "description")
        ended = subprocess.run([program, "__name:=robot_state_publisher"], stdout=subprocess.PIPE, timeout=PATIENCE,
                               env=dict(os.environ, ROS_NAMESPACE="pioneer"), universal_newlines=True)
        self.assertEqual((ended.returncode, ended.stdout.splitlines()), (0, [
            "/pioneer/robot_state_publisher runs already, and goes on: the robot is described as it was started"]))
        self.assertTrue(is_at_work("/pioneer/robot_state_publisher", PATIENCE))


if __name__ == "__main__":
    rospy.init_node("driver_drive_commander")
    rostest.rosrun("pioneer_control", "driver_drive", DriverDrives)
