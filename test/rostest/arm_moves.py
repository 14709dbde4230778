#!/usr/bin/python3
"""A simulated arm behind a real driver: motions, diagnostics, and above all the ends of a driver."""

import contextlib
import os
import signal
import sys
import time
import unittest

import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import Twist, Vector3
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool
from std_srvs.srv import SetBool, Trigger
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

sys.path[:0] = [os.path.dirname(os.path.abspath(__file__))]

from driver_lines import Driver
from pioneer_control.msg import Arm
from pioneer_control.robots import find_model
from pioneer_control.simulator.firmware import Firmware
from pioneer_control.simulator.line import Server
from pioneer_control.simulator.world import load_world
from witness import PATIENCE, Witness, wait_until

KILLED_AFTER = 15.0
"""Time (s) after SIGINT at which roslaunch kills a node."""
BASE = "arm_base_joint"


class ArmMoves(unittest.TestCase):
    """Each test has a robot, a driver and a namespace of its own."""

    def setUp(self):
        self.ending = contextlib.ExitStack()
        self.addCleanup(self.ending.close)
        self.namespace = "/" + self.id().rpartition(".")[2]

    def begin(self, arm=True, **parameters):
        """Start a robot and its driver, and wait until the driver knows about the arm."""
        firmware = Firmware(find_model("p3dx-sh"), load_world("empty"), arm=arm)
        self.server = self.ending.enter_context(Server(firmware, tcp=0))
        self.firmware = firmware
        self.witness = Witness({self.namespace + "/arm/state": Arm, self.namespace + "/joint_states": JointState,
                                "/diagnostics": DiagnosticArray})
        self.driver = Driver(self.namespace, port=self.server.url, use_arm="true", **parameters)
        self.ending.callback(self.driver.end, signal.SIGKILL)
        self.condition("off" if arm else "none")

    def condition(self, *wanted):
        """Wait until the driver publishes one of these conditions of the arm."""
        topic = self.namespace + "/arm/state"
        self.witness.wait("the arm is %s" % (wanted,), lambda: any(
            message.condition in wanted for message in self.witness.seen[topic][-1:]))

    def call(self, name, kind, *values):
        """Call a service of the driver. Returns its answer."""
        rospy.wait_for_service("%s/%s" % (self.namespace, name), PATIENCE)
        return rospy.ServiceProxy("%s/%s" % (self.namespace, name), kind)(*values)

    def publish(self, name, message):
        """Publish a message when the driver listens."""
        publisher = rospy.Publisher("%s/%s" % (self.namespace, name), type(message), queue_size=1)
        wait_until("the driver listens", lambda: publisher.get_num_connections())
        publisher.publish(message)
        return publisher

    def move(self, position, seconds=0.0):
        self.publish("arm_controller/command", JointTrajectory(joint_names=[BASE], points=[JointTrajectoryPoint(
            positions=[position], time_from_start=rospy.Duration.from_sec(seconds))]))

    def of_arm(self, what):
        """Return something of the simulated arm."""
        with self.server.lock:
            return what(self.firmware.hardware.arm)

    def power(self):
        answer = self.call("arm/power", SetBool, True)
        self.assertTrue(answer.success, answer.message)

    def test_it_moves_where_it_is_told_and_parks(self):
        self.begin()
        self.assertFalse(self.of_arm(lambda arm: arm.powered or any(arm.moving)))
        self.power()
        self.move(0.5)
        joints = self.namespace + "/joint_states"
        self.witness.wait("it is there", lambda: any(
            BASE in message.name and abs(message.position[0] - 0.5) < 0.01
            for message in self.witness.seen[joints][-3:]))
        self.assertEqual(self.of_arm(lambda arm: arm.servos[0].position), 163)
        answer = self.call("arm/park", Trigger)
        self.assertTrue(answer.success, answer.message)
        self.assertEqual(self.of_arm(lambda arm: (arm.powered, arm.drops)), (False, 0))
        self.assertEqual(self.driver.end(), 0)

    def test_a_lock_stops_it(self):
        self.begin()
        self.power()
        self.move(1.5)
        self.condition("moving")
        lock = self.publish("stop_all", Bool(True))
        self.condition("on")
        position = self.of_arm(lambda arm: arm.servos[0].position)
        self.assertLess(position, 230)
        answer = self.call("arm/home", Trigger)
        self.assertEqual((answer.success, answer.message), (False, "arm/home refused: stop_all is set"))
        self.assertEqual(self.of_arm(lambda arm: (arm.servos[0].position, arm.powered)), (position, True))
        lock.publish(Bool(False))

    def test_the_end_stops_the_wheels_first_then_parks_the_arm_then_closes(self):
        self.begin(max_xspeed=0.5)
        self.power()
        self.move(1.5)
        self.condition("moving")
        answer = self.call("set_motors", SetBool, True)
        self.assertTrue(answer.success, answer.message)
        drive = self.publish("cmd_vel", Twist(Vector3(0.3, 0, 0), Vector3()))
        rospy.Timer(rospy.Duration(0.1), lambda _: drive.publish(Twist(Vector3(0.3, 0, 0), Vector3())))
        wait_until("it drives", lambda: self.firmware.velocity[0] > 0.2)
        self.driver.process.send_signal(signal.SIGINT)
        begun = time.monotonic()
        wait_until("the wheels stand", lambda: self.firmware.velocity == (0.0, 0.0))
        self.assertTrue(self.of_arm(lambda arm: arm.powered))      # the arm only then; velocities still come
        wait_until("the arm is off", lambda: not self.of_arm(lambda arm: arm.powered))
        self.assertEqual(self.firmware.velocity, (0.0, 0.0))
        self.assertEqual(self.driver.exit_code(), 0)
        self.assertLess(time.monotonic() - begun, KILLED_AFTER)
        self.assertEqual(self.of_arm(lambda arm: (arm.drops, arm.servos[0].position)), (0, 130))
        self.assertFalse(self.firmware.motors_enabled)
        self.driver.says("keep clear: the arm parks, because the driver ends")

    def test_the_end_without_power_takes_no_time(self):
        self.begin()
        begun = time.monotonic()
        self.assertEqual(self.driver.end(), 0)
        self.assertLess(time.monotonic() - begun, 8.0)

    def test_diagnostics_have_a_task_of_it(self):
        self.begin(arm=False)
        name = self.namespace[1:] + "/p2os: Arm"
        self.witness.wait("a task of the arm", lambda: any(
            status.name == name and status.level == DiagnosticStatus.WARN and "no arm" in status.message
            for message in self.witness.seen["/diagnostics"] for status in message.status))
        answer = self.call("arm/power", SetBool, True)
        self.assertEqual(answer.message, "power on refused: the robot reports that it has no arm")
        self.assertEqual(self.driver.end(), 0)

    def test_a_killed_driver_leaves_an_arm_that_parks_with_the_next_session(self):
        self.begin()
        self.power()
        self.move(0.5)
        self.condition("moving")
        self.driver.end(signal.SIGKILL)
        again = Driver(self.namespace, port=self.server.url, use_arm="true")
        self.ending.callback(again.end, signal.SIGKILL)
        again.says("connected to")      # by a CLOSE first: the arm parks
        wait_until("the arm is off", lambda: not self.of_arm(lambda arm: arm.powered))
        self.assertEqual(self.of_arm(lambda arm: arm.drops), 0)
        self.assertEqual(again.end(), 0)


if __name__ == "__main__":
    rospy.init_node("arm_moves_commander")
    rostest.rosrun("pioneer_control", "arm_moves", ArmMoves)
