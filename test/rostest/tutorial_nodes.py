#!/usr/bin/python3
"""Both tutorial nodes from start to end, and every way in which they may end early. The robot stands still afterwards.
"""

import math
import os
import signal
import subprocess
import sys
import unittest

import numpy
import rosnode
import rospy
import rostest
from geometry_msgs.msg import PoseArray, Twist
from nav_msgs.msg import Odometry
from std_msgs.msg import Bool

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

from pioneer_control.msg import MotorState
from pioneer_control.robots import find_model
from pioneer_control.simulator.world import load_world
from witness import PATIENCE, Witness, heading_of, wait_until

TRUTH, CANS, COMMANDS, MOTORS = "pioneer/ground_truth", "pioneer/cans", "pioneer/cmd_vel", "pioneer/motor_state"
TOPICS = {TRUTH: Odometry, CANS: PoseArray, COMMANDS: Twist, MOTORS: MotorState}
SIMPLE = ["rosrun", "pioneer_control", "rosPioneer1.py"]
ADVANCED = ["rosrun", "pioneer_control", "rosPioneer2.py"]
LIFTED = 0.05  # m

FAILING_PROGRAM = """
import rospy
from pioneer_control.tutorial.pioneer import Pioneer
rospy.init_node("failing")
with Pioneer("pioneer") as robot:
    for _ in range(10):
        robot.drive(0.1, 0.0)
        rospy.sleep(0.1)
    raise RuntimeError("a mistake of the user's")
"""


def distance(one, other):
    """Return the distance between two ground truths (m)."""
    a, b = one.pose.pose.position, other.pose.pose.position
    return math.hypot(a.x - b.x, a.y - b.y)


class TutorialNodes(unittest.TestCase):
    """One robot, one node after the other."""

    @classmethod
    def setUpClass(cls):
        cls.witness = Witness(TOPICS)
        cls.stop_button = rospy.Publisher("pioneer/stop_button", Bool, queue_size=1)
        for topic in (TRUTH, CANS, MOTORS):
            cls.witness.last(topic)
        cls.witness.wait("the simulator listens", cls.stop_button.get_num_connections)

    def start(self, command):
        """Start a program and keep its output. The program ends with the test."""
        program = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, universal_newlines=True)
        self.addCleanup(program.stdout.close)
        self.addCleanup(program.wait)
        self.addCleanup(program.kill)
        self.first_command = len(self.witness.seen[COMMANDS])
        return program

    def start_node(self, command, node):
        """Start a program and wait until it is a node. On a busy machine that takes longer than what it does then."""
        program = self.start(command)
        wait_until("the node %s" % node, lambda: node in rosnode.get_node_names())
        return program

    def end_of(self, program, patience=PATIENCE):
        """Return the output of a program, and its exit status."""
        output, _ = program.communicate(timeout=patience)
        return output, program.returncode

    def given(self):
        """Return the velocities that the program of this test commanded."""
        return [(each.linear.x, each.angular.z) for each in self.witness.seen[COMMANDS][self.first_command:]]

    def wait_until_it_drives(self):
        self.witness.wait("the robot drives", lambda: self.witness.seen[TRUTH][-1].twist.twist.linear.x > 0.05)

    def assert_told_to_stand_and_stands(self):
        """Check that the last command is zero: the program stopped the robot, and did not leave this to the driver's
        time-out.
        """
        self.witness.wait("the last command is zero", lambda: self.given()[-1:] == [(0.0, 0.0)])
        self.witness.next(TRUTH)
        self.witness.wait("the robot stands", lambda: self.witness.seen[TRUTH][-1].twist.twist.linear.x == 0.0)
        self.assertEqual(self.given()[-1], (0.0, 0.0))

    def test_1_the_simple_node_prints_drives_and_stops(self):
        """Rows 5 to 9, 11, 29: it starts, subscribes, has the motors switched on, and drives for the stated time at 10
        Hz.
        """
        before = self.witness.next(TRUTH)
        output, status = self.end_of(self.start(SIMPLE + ["_duration:=3.0"]))
        self.assertEqual(status, 0, output)
        self.assert_told_to_stand_and_stands()
        self.assertIn("linear: x=", output)
        self.assertIn("angular (quaternion): x=0.00, y=0.00, z=", output)
        self.assertIn("sonar: ", output)
        self.assertEqual(self.witness.seen[MOTORS][-1].state, 1)
        forward = [each for each in self.given() if each == (0.1, 0.0)]
        self.assertTrue(25 <= len(forward) <= 31, "%d commands in 3 s" % len(forward))
        self.assertAlmostEqual(distance(before, self.witness.next(TRUTH)), 0.3, delta=0.05)

    def test_2_the_simple_node_stops_at_ctrl_c(self):
        """Row 10."""
        program = self.start(SIMPLE)
        self.wait_until_it_drives()
        program.send_signal(signal.SIGINT)
        self.end_of(program)
        self.assert_told_to_stand_and_stands()

    def test_3_the_advanced_node_wanders_picks_wanders_picks_and_touches_nothing(self):
        """Rows 8 to 11, 15, 22 to 24: the program comes to its end, a can is lifted, and the robot touched no wall."""
        first_truth = len(self.witness.seen[TRUTH])
        program = self.start(ADVANCED + ["_speed:=0.2", "_duration:=6.0", "_seed:=3"])
        output, status = self.end_of(program, patience=3 * PATIENCE)
        self.assertEqual(status, 0, output)
        self.assert_told_to_stand_and_stands()
        for said in ("driving: ", "gripper, lower: ", "gripper, open: ", "gripper, close: ", "gripper, raise: done",
                     "picked: "):
            self.assertIn(said, output)
        truths = self.witness.seen[TRUTH][first_truth:]
        self.assertGreater(max(distance(truths[0], each) for each in truths), 0.3)
        self.assert_no_contact(truths)
        self.assertRegex(output,
                         r"the end: [0-9.]+ m driven, [12] of 2 picks got something, nothing held it on its way")
        self.assertTrue(any(can.position.z > LIFTED for cans in self.witness.seen[CANS] for can in cans.poses), output)

    def assert_no_contact(self, truths):
        world, outline = load_world("tutorial"), numpy.array(find_model("p3dx-sh").outline(True))
        for truth in truths:
            heading, place = heading_of(truth.pose.pose), truth.pose.pose.position
            cosine, sine = numpy.cos(heading), numpy.sin(heading)
            body = outline @ numpy.array([[cosine, sine], [-sine, cosine]]) + (place.x, place.y)
            self.assertFalse(world.touches(body), "the body touched something at %.2f, %.2f" % (place.x, place.y))

    def test_4_the_advanced_node_stops_at_ctrl_c(self):
        """Row 10. A signal may come while the main thread talks to the master or publishes. The test starts the node
        several times, to hit some of these moments.
        """
        for _ in range(4):
            self.ends_while_it_drives(lambda program: program.send_signal(signal.SIGINT))

    def test_5_the_advanced_node_stops_at_sigterm(self):
        """Row 10: roslaunch sends SIGTERM to a node that does not end at SIGINT."""
        for _ in range(4):
            self.ends_while_it_drives(lambda program: program.terminate())

    def test_5b_the_advanced_node_stops_when_its_terminal_closes(self):
        self.ends_while_it_drives(lambda program: program.send_signal(signal.SIGHUP))

    def test_6_the_advanced_node_stops_at_rosnode_kill(self):
        """Row 10."""
        kill = ["rosnode", "kill", "/rosPioneer2"]
        self.ends_while_it_drives(lambda program: subprocess.run(kill, check=True, stdout=subprocess.DEVNULL))

    def wait_until_it_commands(self):
        self.witness.wait("it commands", lambda: any(linear or angular for linear, angular in self.given()))

    def ends_while_it_drives(self, end):
        program = self.start(ADVANCED + ["_stop_at_can:=false"])
        self.wait_until_it_commands()
        end(program)
        output, _ = self.end_of(program)
        self.assertNotIn("Traceback", output)
        self.assert_told_to_stand_and_stands()

    def test_7_a_program_that_fails_leaves_the_robot_standing(self):
        """Row 10: an exception in the user's own code."""
        output, status = self.end_of(self.start([sys.executable, "-c", FAILING_PROGRAM]))
        self.assertNotEqual(status, 0)
        self.assertIn("a mistake of the user's", output)
        self.assertIn((0.1, 0.0), self.given())
        self.assert_told_to_stand_and_stands()

    def test_8_a_pressed_stop_button_and_a_driver_that_is_not_there_are_said(self):
        """Rows 8 and 9: neither node drives, and both say what to check, what to start, or what they wait for. All wait
        for a while, side by side.
        """
        self.addCleanup(self.stop_button.publish, Bool(False))
        self.stop_button.publish(Bool(True))
        self.witness.wait("the motors are off", lambda: self.witness.seen[MOTORS][-1].state == 0)
        first_command = len(self.witness.seen[COMMANDS])
        told = [(self.start_node(command, node), texts) for command, node, texts in (
            (SIMPLE, "/rosPioneer1", ["STOP button"]),
            (ADVANCED, "/rosPioneer2", ["STOP button"]),
            (SIMPLE + ["nobody"], "/rosPioneer1_nobody", ["nothing comes on /nobody/motor_state"]),
            (ADVANCED + ["nobody"], "/rosPioneer2_nobody", ["Does the driver run", "/nobody/cmd_vel"]))]
        for program, texts in told:
            output, status = self.end_of(program)
            self.assertEqual(status, 1, output)
            for text in texts:
                self.assertIn(text, output)
            self.assertNotIn("Traceback", output)
        self.assertEqual(self.witness.seen[COMMANDS][first_command:], [])

    def test_8b_a_stop_button_pressed_on_the_way_ends_the_wander(self):
        """The motors stay off until a user asks for them."""
        self.addCleanup(self.stop_button.publish, Bool(False))
        self.stop_button.publish(Bool(False))
        program = self.start(ADVANCED + ["_stop_at_can:=false"])
        self.wait_until_it_commands()
        self.stop_button.publish(Bool(True))
        output, status = self.end_of(program)
        self.assertEqual(status, 1, output)
        self.assertIn("motors are off", output)
        self.assertEqual(self.witness.seen[MOTORS][-1].state, 0)
        self.assert_told_to_stand_and_stands()

    def test_9_with_a_model_it_drives_beside_a_driver_without_robot_info(self):
        """p2os is such a driver. Here the topic has another name."""
        elsewhere = ["/pioneer/robot_info:=/nowhere/robot_info"]
        program = self.start(ADVANCED + elsewhere + ["_model:=p3dx-sh", "_gripper:=true", "_stop_at_can:=false"])
        self.addCleanup(rospy.delete_param, "/rosPioneer2")
        self.wait_until_it_commands()
        program.send_signal(signal.SIGINT)
        self.end_of(program)
        self.assert_told_to_stand_and_stands()

    def test_9b_a_mistyped_parameter_is_said_before_anything_moves(self):
        self.addCleanup(rospy.delete_param, "/rosPioneer2")
        output, status = self.end_of(self.start(ADVANCED + ["_druation:=5", "_speed:=fast"]))
        self.assertEqual(status, 1, output)
        self.assertIn("did you mean ~duration?", output)
        self.assertIn("~speed = 'fast' is not legal", output)
        self.assertIn("rosparam delete /rosPioneer2", output)
        self.assertEqual(self.given(), [])


if __name__ == "__main__":
    rospy.init_node("tutorial_nodes_witness")
    rostest.rosrun("pioneer_control", "tutorial_nodes", TutorialNodes)
