#!/usr/bin/python3
"""A program that explores or drives to a place: the robot stands after every way in which the program may end early."""

import os
import signal
import subprocess
import sys
import unittest

import rosnode
import rospy
import rostest
from nav_msgs.msg import Odometry
from std_srvs.srv import SetBool

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

from pioneer_control.msg import Navigation, Places
from witness import PATIENCE, Witness

TRUTH, NAVIGATION, PLACES = "pioneer/ground_truth", "pioneer/navigation", "pioneer/places"
PROGRAM = """
import math

from pioneer_control.ros_node import init_node
from pioneer_control.tutorial.pioneer import Pioneer

init_node("traveller")
with Pioneer("pioneer") as robot:
    h = robot.where().heading
    print("got", %s)
"""
AHEAD = "robot.go_to(robot.where().x + 0.9 * math.cos(h), robot.where().y + 0.9 * math.sin(h))"


class Travel(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        cls.witness = Witness({TRUTH: Odometry, NAVIGATION: Navigation, PLACES: Places})
        cls.witness.last(TRUTH)
        cls.witness.last(NAVIGATION)
        rospy.wait_for_service("pioneer/explore", PATIENCE)
        cls.explore = rospy.ServiceProxy("pioneer/explore", SetBool)

    def setUp(self):
        self.addCleanup(self.explore, False)

    def stands(self):
        self.witness.next(TRUTH)
        self.witness.wait("the robot stands", lambda: all(
            abs(each.twist.twist.linear.x) + abs(each.twist.twist.angular.z) < 0.001
            for each in self.witness.seen[TRUTH][-5:]))

    def start(self, doing):
        """Start a program for a robot that stands, and wait until it drives."""
        self.stands()
        program = subprocess.Popen([sys.executable, "-c", PROGRAM % doing], stdout=subprocess.PIPE,
                                   stderr=subprocess.STDOUT, universal_newlines=True)
        self.addCleanup(program.stdout.close)
        self.addCleanup(program.wait)
        self.addCleanup(program.kill)
        self.witness.next(TRUTH)
        self.witness.wait("the robot drives", lambda: abs(
            self.witness.seen[TRUTH][-1].twist.twist.linear.x) > 0.1)
        return program

    def ends_and_the_robot_stands(self, program):
        output, _ = program.communicate(timeout=PATIENCE)
        self.assertNotIn("Traceback", output)
        self.assertNotIn("got", output)
        self.witness.next(NAVIGATION, 2)
        self.assertEqual(self.witness.seen[NAVIGATION][-1].state, "idle")
        self.stands()
        self.witness.next(NAVIGATION, 5)
        self.assertEqual({each.state for each in self.witness.seen[NAVIGATION][-5:]}, {"idle"})

    def test_1_ctrl_c_ends_exploring(self):
        self.assertEqual(self.witness.last(PLACES).names, [])
        program = self.start("robot.explore()")
        program.send_signal(signal.SIGINT)
        self.ends_and_the_robot_stands(program)

    def test_2_rosnode_kill_ends_exploring(self):
        program = self.start("robot.explore()")
        rosnode.kill_nodes(["/traveller"])
        self.ends_and_the_robot_stands(program)

    def test_3_ctrl_c_ends_the_way_to_a_place(self):
        program = self.start(AHEAD)
        program.send_signal(signal.SIGINT)
        self.ends_and_the_robot_stands(program)

    def test_4_rosnode_kill_ends_the_way_to_a_place(self):
        program = self.start(AHEAD)
        rosnode.kill_nodes(["/traveller"])
        self.ends_and_the_robot_stands(program)

    def test_5_a_program_hears_that_somebody_ended_exploring(self):
        program = self.start("robot.explore()")
        self.explore(False)
        output, _ = program.communicate(timeout=PATIENCE)
        self.assertEqual(program.returncode, 0, output)
        self.assertIn("somebody ended it", output)
        self.assertIn("got False", output)

    def test_6_home_is_where_exploring_began_first(self):
        """The robot has driven since, and begun anew."""
        self.assertTrue(self.explore(True).success)
        places = self.witness.last(PLACES)
        self.assertEqual(places.names, ["home"])
        self.assertLess(abs(places.poses[0].x) + abs(places.poses[0].y) + abs(places.poses[0].theta), 0.05)


if __name__ == "__main__":
    rospy.init_node("travel_test")
    rostest.rosrun("pioneer_control", "travel", Travel)
