#!/usr/bin/python3
"""Navigation with the scans of a simulated laser, from its line to a goal; and when the laser dies on the way."""

import math
import os
import signal
import sys
import unittest

import actionlib
import rospy
import rostest
from actionlib_msgs.msg import GoalStatus
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from move_base_msgs.msg import MoveBaseAction
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Log
from sensor_msgs.msg import LaserScan
from std_srvs.srv import SetBool

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

from navigation import goal_at, process_of
from pioneer_control.msg import Navigation
from witness import PATIENCE, Witness, wait_until

TOPICS = {"pioneer/navigation": Navigation, "pioneer/ground_truth": Odometry, "pioneer/scan": LaserScan,
          "/diagnostics": DiagnosticArray, "/rosout": Log}


class NavigationWithLaser(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        cls.witness = Witness(TOPICS)
        cls.client = actionlib.SimpleActionClient("pioneer/move_base", MoveBaseAction)
        assert cls.client.wait_for_server(rospy.Duration(PATIENCE))
        rospy.wait_for_service("pioneer/set_motors", PATIENCE)
        set_motors = rospy.ServiceProxy("pioneer/set_motors", SetBool)
        wait_until("motors are on", lambda: set_motors(True).success)
        start = cls.witness.last("pioneer/ground_truth").pose.pose.position
        cls.home = start.x, start.y

    def says_of_the_laser(self, words):
        """Wait until the diagnostics say this of the laser. Return their level."""
        def told():
            return [(status.level, {each.key: each.value for each in status.values}["laser"])
                    for message in self.witness.seen["/diagnostics"][-20:] for status in message.status
                    if status.name == "pioneer/navigation: Navigation"]

        self.witness.wait("of the laser: %s" % words, lambda: told() and told()[-1][1].startswith(words))
        return told()[-1][0]

    def off(self, x, y):
        """Return how far (m) the robot really is from a place."""
        place = self.witness.next("pioneer/ground_truth").pose.pose.position
        return math.hypot(place.x - x, place.y - y)

    def reaches(self, x, y):
        self.client.send_goal(goal_at(x, y))
        self.assertTrue(self.client.wait_for_result(rospy.Duration(2 * PATIENCE)), "no result")
        self.assertEqual(self.client.get_state(), GoalStatus.SUCCEEDED)
        self.assertLess(self.off(x, y), 0.15)

    def test_01_it_knows_where_it_is_by_its_laser_and_drives_to_a_goal(self):
        x, y = self.home
        self.witness.last("pioneer/scan")
        self.says_of_the_laser("used")
        self.witness.wait("it is sure", lambda: self.witness.seen["pioneer/navigation"]
                          and self.witness.seen["pioneer/navigation"][-1].sure)
        self.reaches(x + 1.0, y)
        here = self.witness.last("pioneer/navigation").pose
        self.assertLess(self.off(here.x, here.y), 0.06)

    def test_02_when_the_laser_dies_it_says_so_and_drives_on_by_sonar(self):
        x, y = self.home
        os.kill(process_of("/pioneer/laser"), signal.SIGKILL)
        self.assertGreaterEqual(self.says_of_the_laser("no scan for"), DiagnosticStatus.WARN)
        self.witness.wait("it says so", lambda: any(
            message.name == "/pioneer/navigation" and "it goes on by sonar alone" in message.msg
            for message in self.witness.seen["/rosout"]))
        self.reaches(x, y)


if __name__ == "__main__":
    rospy.init_node("check_navigation_laser")
    rostest.rosrun("pioneer_control", "navigation_laser", NavigationWithLaser)
