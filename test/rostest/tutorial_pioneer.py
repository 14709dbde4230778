#!/usr/bin/python3
"""The class Pioneer on simulated robots: its reports, its picks, the end of its wander, and that it commands only the
robot that it was given, and only when it is asked to.
"""

import concurrent.futures
import math
import os
import signal
import subprocess
import sys
import unittest

import rosnode
import rospy
import rostest
from geometry_msgs.msg import PoseArray, Twist
from nav_msgs.msg import Odometry

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

from pioneer_control.errors import NoAnswerError, UsageError
from pioneer_control.floor_poses import Pose
from pioneer_control.message_values import GripStatus, LiftStatus
from pioneer_control.msg import Decision, GripperState, MotorState
from pioneer_control.tutorial.pick import Outcome
from pioneer_control.tutorial.pioneer import Pioneer, WanderEnd
from pioneer_control.tutorial.snapshot import Grip, Lift
from witness import PATIENCE, Witness, wait_until

ROBOTS = "pioneer", "lonely", "handless"
TOPICS = {"pioneer/cans": PoseArray}
for name in ROBOTS:
    TOPICS.update({name + "/cmd_vel": Twist, name + "/cmd_motor_state": MotorState,
                   name + "/gripper_control": GripperState,
                   name + "/decision": Decision, name + "/ground_truth": Odometry})
LIFTED = 0.05  # m
COMMAND_TOPICS = "cmd_vel", "cmd_motor_state", "gripper_control"


class TestPioneer(unittest.TestCase):
    """Each test has its own Pioneer. The robots stay where the previous test left them."""

    @classmethod
    def setUpClass(cls):
        cls.witness = Witness(TOPICS)
        for robot in ROBOTS:
            cls.witness.last(robot + "/ground_truth")

    def pioneer(self, namespace="pioneer", **more):
        robot = Pioneer(namespace, seed=1, **more)
        self.addCleanup(robot.close)
        return robot

    def commanded(self, namespace):
        return [message for topic in COMMAND_TOPICS for message in self.witness.seen[namespace + "/" + topic]]

    def decided(self, namespace, since):
        """Return the stamps (s) of the sensor data from `since` on that a program decided on."""
        stamps = [each.header.stamp.to_sec() for each in self.witness.seen[namespace + "/decision"]]
        return [stamp for stamp in stamps if stamp >= since]

    def cans_up(self):
        return [can for can in self.witness.seen["pioneer/cans"][-1].poses if can.position.z > LIFTED]

    def test_1_it_commands_nothing_until_it_is_asked_to(self):
        robot = self.pioneer()
        with self.assertRaises(NoAnswerError):
            robot.snapshot()
        robot.wait_until_ready()
        robot.stop()
        robot.close()
        self.witness.next("pioneer/ground_truth", 5)
        self.assertEqual(self.commanded("pioneer"), [])

    def test_2_what_it_reports_has_the_tutorials_names_and_types(self):
        """Rows 12, 14, 16, 17."""
        robot = self.pioneer()
        robot.wait_until_ready()
        self.assertIsInstance(robot.pose, Pose)
        self.assertEqual(len(robot.ranges), 16)
        self.assertTrue(all(isinstance(each, float) for each in robot.ranges))
        self.assertIsInstance(robot.grip, Grip)
        self.assertIsInstance(robot.lift, Lift)
        self.assertIn(robot.grip.state, list(GripStatus))
        self.assertIn(robot.lift.state, list(LiftStatus))
        self.assertTrue(all(isinstance(each, bool) for each in robot.grip[2:]))
        self.assertLess(robot.snapshot().age, 5.0)

    def test_3_one_robot_picks_a_can_while_another_finds_nothing_to_pick(self):
        """Both picks take long, and wait for their own robots only."""
        with concurrent.futures.ThreadPoolExecutor() as both:
            for done in [both.submit(self.wanders_to_the_can_picks_it_keeps_it_puts_it_down_and_leaves_it),
                         both.submit(self.a_pick_of_nothing_says_so)]:
                done.result()

    def wanders_to_the_can_picks_it_keeps_it_puts_it_down_and_leaves_it(self):
        """Rows 15, 24, 26; the world has a can straight ahead of the start."""
        with self.pioneer() as robot:
            self.assertIs(robot.wander(60.0), WanderEnd.AT_CAN)
            self.assertTrue(robot.grip.outer)
            self.assertEqual((robot.lift.position, robot.grip.state), (0.0, GripStatus.OPEN))
            self.assertTrue(robot.pick())
            self.witness.wait("a can is up", self.cans_up)
            self.assertIs(robot.gripper_raise(), Outcome.ALREADY_THERE)
            self.assertTrue(robot.pick(), "it is held already, and stays so")
            self.assertEqual(len(self.cans_up()), 1)
            self.assertIs(robot.wander(2.0), WanderEnd.TIME_UP)
            self.assertEqual(len(self.cans_up()), 1)
            self.assertTrue(robot.put_down())
            self.witness.wait("no can is up", lambda: not self.cans_up())
            place = self.witness.seen["pioneer/cans"][-1].poses
            self.assertIs(robot.wander(6.0, stop_at_can=True), WanderEnd.TIME_UP)
            self.assertFalse(robot.grip.outer, "the can stands elsewhere now")
            self.assertEqual(self.witness.seen["pioneer/cans"][-1].poses, place, "no can was moved")

    def a_pick_of_nothing_says_so(self):
        """Row 26."""
        with self.pioneer("lonely") as robot:
            self.assertFalse(robot.pick())
            self.assertIs(robot.gripper_close(), Outcome.ALREADY_THERE)
            self.assertIs(robot.gripper_open(), Outcome.DONE)
            self.assertIs(robot.gripper_lower(), Outcome.DONE)
            self.assertIs(robot.gripper_close(), Outcome.DONE)

    def test_5_a_robot_without_gripper_and_with_eight_sonars_wanders_and_picks_nothing(self):
        """Row 17."""
        with self.pioneer("handless") as robot:
            self.assertFalse(robot.has_gripper)
            self.assertEqual(len(robot.ranges), 8)
            self.assertFalse(robot.pick())
            self.assertIs(robot.gripper_open(), Outcome.NO_GRIPPER)
            before = robot.pose
            self.assertIs(robot.wander(3.0), WanderEnd.TIME_UP)
            self.assertGreater(math.hypot(robot.pose.x - before.x, robot.pose.y - before.y), 0.1)
        self.assertEqual(self.witness.seen["handless/gripper_control"], [])

    def test_6_a_wander_lasts_as_long_as_it_is_told(self):
        """Rows 11, 23."""
        with self.pioneer("handless") as robot:
            begin = rospy.get_time()
            robot.wander(3.0)
            self.assertGreater(rospy.get_time() - begin, 2.5)
            # How long, the stamps of the sensor data tell: a busy computer may be late.
            self.witness.wait("a decision", lambda: self.decided("handless", begin))
            stamps = self.decided("handless", begin)
            self.assertLess(stamps[-1] - stamps[0], 3.0)

    def test_7_after_close_it_drives_no_more(self):
        robot = self.pioneer("handless")
        robot.wait_until_ready()
        robot.close()
        with self.assertRaises(rospy.ROSInterruptException):
            robot.drive(0.1, 0.0)

    def test_7b_programs_of_several_robots_run_side_by_side_each_with_its_own(self):
        """Both nodes, and the second node twice. No two nodes have the same name, and each commands the robot that it
        was given.
        """
        told = {name: len(self.witness.seen[name + "/cmd_vel"]) for name in ROBOTS}
        arguments = (("rosPioneer1.py", "lonely"), ("rosPioneer2.py", "lonely"), ("rosPioneer2.py", "handless"))
        programs = []
        for node, robot in arguments:
            programs.append(subprocess.Popen(["rosrun", "pioneer_control", node, robot], stdout=subprocess.DEVNULL))
            self.addCleanup(programs[-1].wait)
            self.addCleanup(programs[-1].kill)
        names = {"/rosPioneer1_lonely", "/rosPioneer2_lonely", "/rosPioneer2_handless"}
        wait_until("all three run", lambda: names <= set(rosnode.get_node_names()))
        for robot in ("lonely", "handless"):
            self.witness.wait(robot + " is told", lambda: len(self.witness.seen[robot + "/cmd_vel"]) > told[robot])
        self.assertEqual([program.poll() for program in programs], [None] * 3, "one ended another")
        for program in programs:
            program.send_signal(signal.SIGINT)
            program.wait(PATIENCE)
        self.assertEqual(len(self.witness.seen["pioneer/cmd_vel"]), told["pioneer"])

    def test_8_numbers_that_make_no_sense_are_refused(self):
        robot = self.pioneer("handless")
        for nonsense in (0.0, -0.1, math.nan, math.inf, "fast"):
            with self.assertRaisesRegex(UsageError, "speed is"):
                Pioneer("handless", speed=nonsense)
            with self.assertRaisesRegex(UsageError, "duration is"):
                robot.wander(nonsense)


if __name__ == "__main__":
    rospy.init_node("tutorial_pioneer_witness")
    rostest.rosrun("pioneer_control", "tutorial_pioneer", TestPioneer)
