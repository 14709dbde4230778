#!/usr/bin/python3
"""`rosrun pioneer_control calibrate` on a real pseudo-terminal: a person holds the key and reads the tape, the robot's
wheels are wrong in a known way. Then the same runs once more, from a bag.
"""

import contextlib
import math
import os
import pty
import re
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest

import rosbag
import rospy
import rostest
import yaml
from nav_msgs.msg import Odometry
from sensor_msgs.msg import Imu

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

from pioneer_control.msg import Calibration, MotorState, RobotInfo
from pioneer_control.robots import find_model
from witness import PATIENCE, Witness, heading_of, wait_until

TOPICS = {"pioneer/ground_truth": Odometry, "pioneer/pose": Odometry, "pioneer/robot_info": RobotInfo,
          "pioneer/imu": Imu, "pioneer/calibration": Calibration, "pioneer/motor_state": MotorState}
LARGER, RIGHT_LARGER, WIDER, GYRO = 0.025, 0.01, -0.03, 0.2      # test/data/wrong-wheels.yaml
TRUE_TURN = (1 + LARGER) / (1 + WIDER)
TRUE_CURVE_DEG = math.degrees(RIGHT_LARGER / 2 * 5.6 / (1 + WIDER))
FRONT, REAR = 0.21, -0.301
PROMPTS = r"in cm\? \[[\d.]+\] |stands there\. |if you can: |Hold w|Let go of the key|are right: "
RESTS = 15          # messages in 1.5 s, 6 s of simulated time: a bag tells runs apart by the rests between them
REPEAT = 0.05       # s between two repetitions of a held key


class PersonWithTape:
    """`calibrate` on a pseudo-terminal, with a person who holds the key when told, and reads the tape."""

    def __init__(self, witness, *arguments):
        self.master, terminal = pty.openpty()
        self.process = subprocess.Popen(["rosrun", "pioneer_control", "calibrate", *arguments], stdin=terminal,
                                        stdout=terminal, stderr=terminal, start_new_session=True)
        os.close(terminal)
        self.said, self.answers = "", []
        self.holds = True           # the key, while told to
        self._told_to_hold = False
        self._heard = 0
        self._witness, self._line = witness, None
        threading.Thread(target=self._listen, daemon=True).start()
        threading.Thread(target=self._press, daemon=True).start()

    def _listen(self):
        with contextlib.suppress(OSError):
            while True:
                self.said += os.read(self.master, 4096).decode(errors="replace")
                self._react()

    def _react(self):
        """Do what the newest words ask for."""
        before = self._heard
        for match in re.finditer(PROMPTS, self.said[before:]):
            words = match.group()
            self._heard = before + match.end()
            if words == "Hold w":
                self._told_to_hold = True
            elif words == "Let go of the key":
                self._told_to_hold = False
            elif words == "stands there. ":
                self._line = self._witness.next("pioneer/ground_truth", RESTS).pose.pose
                self._type("\n")
            elif words == "if you can: ":
                self.answers.append(self._reads(self.said[before:self._heard]))
                self._type(self.answers[-1] + "\n")
            else:
                self._type("\n")

    def _reads(self, question):
        """Return what the tape says, in cm."""
        (front_x, front_y), (_, rear_y) = self._mark(FRONT), self._mark(REAR)
        if "rear mark?" in question:
            return "%.1f %.1f" % (100 * front_y, 100 * rear_y)
        return "%.1f %.1f" % (100 * (front_x - FRONT), 100 * front_y)

    def _mark(self, ahead):
        """Return where a mark is, on the line where the robot stood before the run (m)."""
        now, line = self._witness.next("pioneer/ground_truth", 2).pose.pose, self._line
        x = now.position.x + ahead * math.cos(heading_of(now)) - line.position.x
        y = now.position.y + ahead * math.sin(heading_of(now)) - line.position.y
        cosine, sine = math.cos(heading_of(line)), math.sin(heading_of(line))
        return x * cosine + y * sine, y * cosine - x * sine

    def _press(self):
        while self.process.poll() is None:
            if self._told_to_hold and self.holds:
                self._type("w")
            time.sleep(REPEAT)

    def _type(self, text):
        with contextlib.suppress(OSError):
            os.write(self.master, text.encode())

    def close(self):
        if self.process.poll() is None:
            os.killpg(self.process.pid, 9)
        self.process.wait()
        with contextlib.suppress(OSError):
            os.close(self.master)


class CalibrateRobot(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        cls.witness = Witness(TOPICS)
        cls.witness.last("pioneer/ground_truth")
        cls.witness.last("pioneer/calibration")

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def moves(self):
        return abs(self.witness.next("pioneer/ground_truth").twist.twist.linear.x) > 0.01

    def test_a_person_calibrates_and_the_same_comes_from_a_bag(self):
        file = os.path.join(self.folder, "robots.yaml")
        first_pose = len(self.witness.seen["pioneer/pose"])
        person = PersonWithTape(self.witness, "--quick", "--line", "5", "--tell-robot", "--file", file)
        self.addCleanup(person.close)
        wait_until("calibrated", lambda: "Told the robot" in person.said or person.process.poll() is not None)
        poses = self.witness.seen["pioneer/pose"][first_pose:]
        wait_until("it drives while the key is held", self.moves)
        person.holds = False
        wait_until("it stands when the key is let go", lambda: not self.moves())
        person.holds = True
        wait_until("it goes on", self.moves)
        try:
            code = person.process.wait(PATIENCE)
        except subprocess.TimeoutExpired:
            code = None
        self.assertEqual(code, 0, person.said)
        self.assertIn("It became better.", person.said)
        self.assertEqual(self.witness.seen["pioneer/motor_state"][-1].state, 0)

        told = self.witness.seen["pioneer/calibration"][-1]
        self.assertEqual(told.ticks_mm, round(128 / (1 + LARGER)))
        self.assertAlmostEqual(told.rev_count, 16570 / TRUE_TURN, delta=30)
        found = find_model("p3dx-sh", file)
        self.assertAlmostEqual(found.dist_mm_per_unit, (1 + LARGER) * told.ticks_mm / 128, delta=0.003)
        self.assertAlmostEqual(found.turn_factor, TRUE_TURN * told.rev_count / 16570, delta=0.001)
        self.assertAlmostEqual(math.degrees(found.curve_rad_per_m), TRUE_CURVE_DEG, delta=0.2)
        self.assertAlmostEqual(found.gyro_factor, 1 / (1 + GYRO), delta=0.05)     # stamps are coarse at this speed
        with open(file, encoding="utf-8") as read:
            self.assertIn("# It is right only while the robot has these numbers of its own", read.read())
        self.from_bag(poses, person.answers)

    def test_ctrl_c_while_it_drives(self):
        person = PersonWithTape(self.witness, "--quick", "--file", os.path.join(self.folder, "none.yaml"))
        self.addCleanup(person.close)
        self.witness.wait("it turns", lambda: abs(
            self.witness.seen["pioneer/ground_truth"][-1].twist.twist.angular.z) > 0.1)
        os.killpg(person.process.pid, signal.SIGINT)
        self.witness.wait("it stands", lambda: all(
            message.twist.twist.angular.z == 0.0 for message in self.witness.seen["pioneer/ground_truth"][-10:]))
        self.assertEqual(person.process.wait(PATIENCE), 1)
        self.assertNotIn("Traceback", person.said)
        self.assertEqual(os.listdir(self.folder), [])

    def from_bag(self, poses, answers):
        """The runs that were just driven, from a bag, give the numbers of a robot that was told nothing."""
        bag, file = os.path.join(self.folder, "runs.bag"), os.path.join(self.folder, "of_bag.yaml")
        with rosbag.Bag(bag, "w") as writer:
            info = self.witness.last("pioneer/robot_info")
            writer.write("/pioneer/robot_info", info, poses[0].header.stamp)
            for topic, messages in (("/pioneer/pose", poses), ("/pioneer/imu", self.witness.seen["pioneer/imu"])):
                came = poses[0].header.stamp        # stamps may go back a little; what comes does not
                for message in messages:
                    if message.header.stamp >= poses[0].header.stamp:
                        came = max(came, message.header.stamp)
                        writer.write(topic, message, came)
        typed = "\n\n" + "\n%s\n\n%s\n%s\n" % tuple(answers[:3])
        ran = subprocess.run(["rosrun", "pioneer_control", "calibrate", "--bag", bag, "--file", file], input=typed,
                             stdout=subprocess.PIPE, stderr=subprocess.STDOUT, universal_newlines=True,
                             timeout=PATIENCE)
        self.assertEqual(ran.returncode, 0, ran.stdout)
        found = find_model("p3dx-sh", file)
        self.assertAlmostEqual(found.dist_mm_per_unit, 1 + LARGER, delta=0.003, msg=ran.stdout)
        self.assertAlmostEqual(found.turn_factor, TRUE_TURN, delta=0.001)
        self.assertAlmostEqual(found.gyro_factor, 1 / (1 + GYRO), delta=0.05)     # stamps are coarse at this speed
        with open(file, encoding="utf-8") as read:
            self.assertEqual(list(yaml.safe_load(read)["models"]), ["p3dx-sh"])

    def test_nothing_is_driven_without_a_terminal_and_no_file_is_overwritten(self):
        there = os.path.join(self.folder, "there.yaml")
        open(there, "w", encoding="utf-8").close()
        for arguments, reason in (((), "there is no terminal"), (("--file", there), "is there already"),
                                  (("--line", "100"), "line is 100.0: give a number from 1 to 20")):
            ran = subprocess.run(["rosrun", "pioneer_control", "calibrate", *arguments], stdin=subprocess.DEVNULL,
                                 stdout=subprocess.PIPE, stderr=subprocess.STDOUT, universal_newlines=True,
                                 timeout=PATIENCE, cwd=self.folder)
            self.assertEqual(ran.returncode, 2)
            self.assertIn(reason, ran.stdout)


if __name__ == "__main__":
    rospy.init_node("calibrate_robot")
    rostest.rosrun("pioneer_control", "calibrate_robot", CalibrateRobot)
