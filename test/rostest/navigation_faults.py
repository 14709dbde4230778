#!/usr/bin/python3
"""Faults of a computer and of people while a robot drives to a goal: the map gone, time that stands or jumps, odometry
that is reset, the tf of a second robot, somebody who carries the robot away, and another robot at the driver.
"""

import math
import os
import shutil
import subprocess
import sys
import tempfile
import unittest

import rospy
import rostest
from actionlib_msgs.msg import GoalID, GoalStatusArray
from geometry_msgs.msg import Point, Pose2D, PoseStamped, Quaternion, Transform, TransformStamped, Vector3
from geometry_msgs.msg import Pose as PoseMessage
from nav_msgs.msg import OccupancyGrid, Odometry
from nav_msgs.srv import GetMap
from rosgraph_msgs.msg import Log
from std_msgs.msg import Header
from std_srvs.srv import SetBool, Trigger
from tf2_msgs.msg import TFMessage

from clock import Time
from pioneer_control.maps import write_ros_map
from pioneer_control.maps.goals_file import goals_file, write_goals
from pioneer_control.msg import Navigation, RobotInfo
from pioneer_control.navigation.node.map_files import load_floor_map
from pioneer_control.srv import Carry, GoTo
from witness import Witness, wait_until

NAVIGATION, TRUTH, STATUS = "pioneer/navigation", "pioneer/ground_truth", "pioneer/move_base/status"
TOPICS = {NAVIGATION: Navigation, TRUTH: Odometry, STATUS: GoalStatusArray, "/rosout": Log}
LOOKING_AROUND = 0.45    # rad/s: a robot that does not know where it is may turn at 0.4 rad/s, to hear more


class NavigationFaults(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        cls.time, cls.witness = Time(rate=1.0), Witness(TOPICS)
        cls.folder = tempfile.mkdtemp()
        cls.map_file = os.path.join(cls.folder, "office.yaml")
        floor = load_floor_map("office")
        write_ros_map(floor.grid, cls.map_file)
        write_goals(floor.goals, goals_file(cls.map_file))
        cls.places = floor.goals
        cls.errors = tempfile.TemporaryFile("w+")
        cls.navigation = subprocess.Popen(
            ["rosrun", "pioneer_control", "navigate", "__ns:=pioneer", "__name:=navigation", "_map:=" + cls.map_file,
             "_initial_pose:=[%s]" % ", ".join(str(number) for number in floor.starts[0])], stderr=cls.errors)
        cls.services = {}
        for name, kind in (("set_motors", SetBool), ("go_to", GoTo), ("static_map", GetMap),
                           ("simulator/carry", Carry), ("reset_odometry", Trigger)):
            wait_until(name, lambda name=name: cls.is_there("pioneer/" + name))
            cls.services[name] = rospy.ServiceProxy("pioneer/" + name, kind)
        wait_until("motors are on", lambda: cls.services["set_motors"](True).success)
        cls.witness.last(NAVIGATION)
        cls.cancel = rospy.Publisher("pioneer/move_base/cancel", GoalID, queue_size=1)
        cls.simple_goal = rospy.Publisher("pioneer/move_base_simple/goal", PoseStamped, queue_size=1)
        cls.tf = rospy.Publisher("/tf", TFMessage, queue_size=10)
        for publisher in (cls.cancel, cls.simple_goal, cls.tf):
            wait_until("navigation listens", publisher.get_num_connections)

    @staticmethod
    def is_there(service):
        try:
            rospy.wait_for_service(service, 0.1)
        except rospy.ROSException:
            return False
        return True

    @classmethod
    def tearDownClass(cls):
        cls.navigation.terminate()
        cls.navigation.wait()
        sys.stderr.write(cls.printed())
        cls.errors.close()
        shutil.rmtree(cls.folder)

    @classmethod
    def printed(cls):
        """Return the warnings and errors of navigation once it has ended: its last ones may not reach /rosout.

        While it runs, reading would move the place in the file where it writes.
        """
        cls.errors.seek(0)
        return cls.errors.read()

    def setUp(self):
        self.time.rate = 1.0
        self.first_word = len(self.witness.seen["/rosout"])

    def tearDown(self):
        self.time.rate = 1.0
        if self.navigation.poll() is None:
            self.cancel.publish(GoalID())
            self.says("idle")
        self.stands()

    def newest(self, topic=NAVIGATION):
        return self.witness.seen[topic][-1]

    def off(self, pose):
        """Return how far (m) the robot really is from a pose."""
        place = self.newest(TRUTH).pose.pose.position
        return math.hypot(place.x - pose.x, place.y - pose.y)

    def is_sure_and_right(self):
        return self.newest().sure and self.off(self.newest().pose) < 0.3

    def goes(self):
        """Send the robot far away, and wait until it drives."""
        name = max(self.places, key=lambda name: self.off(self.places[name]))
        self.assertTrue(self.services["go_to"](name).success)
        self.drives()

    def drives(self):
        self.witness.next(TRUTH, 2)
        self.witness.wait("the robot drives", lambda: abs(self.newest(TRUTH).twist.twist.linear.x) > 0.1)

    def stands(self):
        self.witness.next(TRUTH, 2)
        self.witness.wait("the robot stands", lambda: all(
            abs(each.twist.twist.linear.x) + abs(each.twist.twist.angular.z) < 0.001
            for each in self.witness.seen[TRUTH][-5:]))

    def says(self, state, word=""):
        self.witness.next(NAVIGATION)
        self.witness.wait("navigation is %s: %s" % (state, word), lambda: (
            self.newest().state == state and word in self.newest().reason))

    def logged(self, word):
        return [each.msg for each in self.witness.seen["/rosout"][self.first_word:] if word in each.msg]

    def test_1_a_map_that_is_gone_changes_nothing(self):
        """It was read at the start, and other people's maps are not heard."""
        self.goes()
        shutil.rmtree(self.folder)
        os.mkdir(self.folder)
        before = self.services["static_map"]().map
        others = rospy.Publisher("pioneer/map", OccupancyGrid, queue_size=1, latch=True)
        others.publish(OccupancyGrid())
        self.addCleanup(others.unregister)
        since = len(self.witness.seen[NAVIGATION])
        self.witness.next(NAVIGATION, 20)
        self.assertLessEqual({each.state for each in self.witness.seen[NAVIGATION][since:]}, {"driving", "waiting"})
        self.drives()
        self.assertEqual(self.services["static_map"]().map, before)
        self.witness.wait("it is sure and right", self.is_sure_and_right)

    def test_2_while_time_stands_the_robot_stands(self):
        self.goes()
        self.time.rate = 0.0
        self.stands()
        self.says("waiting", "time stands still")
        self.time.rate = 1.0
        self.drives()
        self.assertTrue(self.is_sure_and_right())

    def test_3_when_time_jumps_it_says_so_and_drives_on(self):
        for jump in (-500.0, 800.0, -0.6):
            self.goes()
            since = len(self.witness.seen[NAVIGATION])
            self.time.now += jump
            if jump == -500.0:      # of the others within 10 s nothing is said
                self.witness.wait("it says so", lambda: self.logged("time jumps by -"))
            self.witness.next(NAVIGATION, 10)
            self.witness.next(STATUS, 2)
            self.drives()
            self.assertNotIn("failed", {each.state for each in self.witness.seen[NAVIGATION][since:]})
            self.assertTrue(self.is_sure_and_right())
            self.assertAlmostEqual(self.newest().header.stamp.to_sec(), self.time.now, delta=5.0)

    def test_4_when_odometry_is_reset_it_says_so_and_drives_on(self):
        self.goes()
        since = len(self.witness.seen[NAVIGATION])
        self.assertTrue(self.services["reset_odometry"]().success)
        self.witness.wait("it says so", lambda: self.logged("odometry jumps"))
        self.drives()
        self.assertTrue(all(each.sure for each in self.witness.seen[NAVIGATION][since:]))
        self.assertTrue(self.is_sure_and_right())

    def test_5_the_tf_of_a_second_robot_is_said_and_goals_in_its_frames_are_refused(self):
        self.goes()
        ahead = PoseStamped(Header(frame_id="base_link"), PoseMessage(Point(0.2, 0.0, 0.0), Quaternion(0, 0, 0, 1)))
        for frame, parent, rightly in (("base_link", "odom", "/pioneer/p2os"), ("odom", "map", "/pioneer/navigation")):
            since = len(self.witness.seen[NAVIGATION])

            def tell():
                self.tf.publish(TFMessage([TransformStamped(
                    Header(frame_id=parent, stamp=rospy.Time.now()), frame,
                    Transform(Vector3(50.0, 0.0, 0.0), Quaternion(0, 0, 0, 1)))]))
                return True

            wait_until("it says so",
                       lambda: tell() and self.logged("%s: /navigation_faults and %s" % (frame, rightly)))
            self.assertIn("driving", self.newest().state)
            self.simple_goal.publish(ahead)
            wait_until("the goal is refused", lambda: tell() and self.logged("a goal is refused"))
            self.witness.next(NAVIGATION, 5)
            self.assertLessEqual({each.state for each in self.witness.seen[NAVIGATION][since:]}, {"driving", "waiting"})
            self.witness.wait("it is sure and right", self.is_sure_and_right)
            self.first_word = len(self.witness.seen["/rosout"])
        wait_until("the second robot is forgotten", lambda: self.logged("one publisher again"))
        self.simple_goal.publish(ahead)
        self.witness.wait("the goal is taken", lambda: self.logged("goal: "))

    def test_6_carried_away_it_stands_says_so_and_finds_itself_again(self):
        self.goes()
        far = sorted(self.places.values(), key=self.off)[-2]       # its goal is the farthest
        answer = self.services["simulator/carry"](0, Pose2D(far.x, far.y, 2.0))
        self.assertTrue(answer.success, answer.message)
        self.says("waiting", "I do not know where I am")
        self.witness.wait("it drives no more, and turns slowly at most", lambda: all(
            abs(each.twist.twist.linear.x) < 0.001 and abs(each.twist.twist.angular.z) < LOOKING_AROUND
            for each in self.witness.seen[TRUTH][-5:]))
        self.witness.wait("it knows again", self.is_sure_and_right)
        self.drives()

    def test_7_when_the_driver_has_another_robot_navigation_ends_and_says_why(self):
        self.goes()
        info = rospy.wait_for_message("pioneer/robot_info", RobotInfo, 10.0)
        driver = rospy.Publisher("pioneer/robot_info", RobotInfo, queue_size=1)
        wait_until("navigation listens", driver.get_num_connections)
        info.max_linear -= 0.1
        driver.publish(info)
        self.drives()       # somebody has only limited its speed
        info.subtype, info.footprint.points[0].x = "p3at-sh", info.footprint.points[0].x - 0.05
        driver.publish(info)
        wait_until("navigation ends", lambda: self.navigation.poll() is not None)
        self.assertEqual(self.navigation.returncode, 1)
        self.assertIn("the driver has another robot now", self.printed())


if __name__ == "__main__":
    rospy.init_node("navigation_faults")
    rostest.rosrun("pioneer_control", "navigation_faults", NavigationFaults)
