#!/usr/bin/python3
"""A simulated robot gets the commands of a recorded robot."""

import math
import os
import re
import signal
import subprocess
import sys
import tempfile
import unittest

import numpy as np
import rosbag
import rosnode
import rospy
import rostest
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from std_msgs.msg import String

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "messages", "bags"))

import bag_factory as make
from pioneer_control.bags.replaying.redrive_schedule import VALID
from pioneer_control.bags.run import read_run
from pioneer_control.msg import MotorState, WheelVelocities
from witness import PATIENCE, Witness

START = (3.0, 2.0, 1.0)  # m, m, rad: where the recorded robot stood
SPEED, DRIVEN, LAST_TURN = 0.3, 1.6, 1.2  # m/s, s, s
IN_TIME = 0.15
"""Messages of a robot come every 0.1 s: when one comes after a longer time (s), the machine has held something up."""


def told():
    """Yield (topic, message, s): commands that drive straight on, then to the left by wheel velocities, and the poses
    of a robot without inertia.
    """
    begin, x, y, heading = 100.0, *START
    yield "/pioneer/robot_info", make.robot_info({}), begin
    yield "/pioneer/world", String("no such world"), begin
    yield "/pioneer/cmd_motor_state", MotorState(1), begin + 0.5
    for step in range(int((DRIVEN + LAST_TURN + VALID) * 10)):
        time, turning = begin + 1.0 + 0.1 * step, step >= DRIVEN * 10
        yield "/pioneer/pose", make.odometry(x, y, heading), time
        yield "/pioneer/ground_truth", make.odometry(x, y, heading, "map"), time
        if turning and step < (DRIVEN + LAST_TURN) * 10:
            yield "/pioneer/cmd_wheels", WheelVelocities(0.1, 0.2), time
        elif not turning:
            twist = Twist()
            twist.linear.x = SPEED
            yield "/pioneer/cmd_vel", twist, time
        speed, rate = (0.15, 0.1 / 0.33) if turning else (SPEED, 0.0)
        x, y, heading = x + 0.1 * speed * math.cos(heading), y + 0.1 * speed * math.sin(heading), heading + 0.1 * rate


def held_up(bag):
    """Return for how long (s) altogether a busy machine held up the simulated robot and its driver in a recorded drive.
    Commands came later by this time at most, and the robot drove on until then.
    """
    times = {"/redrive/pose": [], "/redrive/ground_truth": []}
    with rosbag.Bag(bag) as file:
        for topic, _, time in file.read_messages(topics=list(times)):
            times[topic].append(time.to_sec())
    return sum(float(np.maximum(0.0, np.diff(each) - IN_TIME).sum()) for each in times.values())


class Redrive(unittest.TestCase):
    """The recorded commands are sent to a simulated robot."""

    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.bag = make.write_bag(os.path.join(cls.folder.name, "run.bag"), told())

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def start(self, *arguments):
        command = ["rosrun", "pioneer_control", "replay", "redrive", self.bag, *arguments]
        process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        self.addCleanup(process.kill)
        return process

    def run_to_its_end(self, *arguments):
        """Run a re-drive to its end. Returns its output and its exit code."""
        process = self.start(*arguments)
        said, _ = process.communicate(timeout=2 * PATIENCE)
        return said.decode(), process.returncode

    def test_1_into_a_simulated_robot(self):
        """The same model at the same place drives in the same way. A world that is gone is reported."""
        output = os.path.join(self.folder.name, "new.bag")
        said, code = self.run_to_its_end("--output=" + output)
        self.assertEqual(code, 0, said)
        self.assertIn("The world 'no such world' of the recording is not here", said)
        self.assertIn("A simulated p3dx-sh in the world 'empty' at x 3.00 m, y 2.00 m, 57 degrees", said)
        length, new = map(float, re.search(r"recorded path is ([\d.]+) m long, the new one ([\d.]+) m", said).groups())
        self.assertAlmostEqual(length, SPEED * DRIVEN + 0.15 * (LAST_TURN + VALID), delta=0.05)
        late = held_up(output)
        self.assertAlmostEqual(new, length, delta=0.1 + SPEED * late)   # the recorded one had no inertia
        self.assertLess(float(re.search(r"([\d.]+) cm at most", said).group(1)), 20.0 + 100 * SPEED * late)
        run = read_run(output, "redrive")
        self.assertLess(max(np.abs(np.array(run.truth.pose(0)) - START)), 0.001)
        self.assertEqual(run.model, "p3dx-sh")
        self.assertGreater(run.truth.heading[-1] - START[2], 0.2)
        self.assertTrue(os.path.getsize(output[:-4] + ".png") > 10000)
        self.assertEqual([node for node in rosnode.get_node_names() if node.startswith("/redrive")], [])
        self.assertFalse(rospy.has_param("/redrive"))

    def test_2_ctrl_c_stops_the_robot(self):
        witness = Witness({"/redrive/ground_truth": Odometry, "/redrive/cmd_vel": Twist})
        process = self.start("--speed=0.2", "--output=" + os.path.join(self.folder.name, "stopped.bag"))
        witness.wait("it moves", lambda: witness.seen["/redrive/ground_truth"]
                     and witness.last("/redrive/ground_truth").twist.twist.linear.x > 0.03)
        process.send_signal(signal.SIGINT)
        said = process.communicate(timeout=PATIENCE)[0].decode()
        self.assertEqual(process.returncode, 1, said)
        self.assertIn("the robot was stopped", said)
        witness.wait("it was told to stop", lambda: witness.last("/redrive/cmd_vel").linear.x == 0.0)
        self.assertGreater(len(read_run(os.path.join(self.folder.name, "stopped.bag"), "redrive").commanded.time), 0,
                           "what happened is kept")
        self.assertEqual([node for node in rosnode.get_node_names() if node.startswith("/redrive")], [])


if __name__ == "__main__":
    rospy.init_node("bag_redrive_test")
    rostest.rosrun("pioneer_control", "bag_redrive", Redrive)
