#!/usr/bin/python3
"""What was told a recorded robot is told another one: a simulated one of its own, or a "real" one on a port, which is a simulated one here, too."""

import math
import os
import re
import signal
import subprocess
import sys
import tempfile
import unittest

import numpy as np
import rosnode
import rospy
import rostest
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from std_msgs.msg import String
from std_srvs.srv import SetBool

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "messages", "bags"))

import bag_factory as make  # noqa: E402
from pioneer_control.bags.replaying.redrive_schedule import VALID  # noqa: E402
from pioneer_control.bags.run import read_run  # noqa: E402
from pioneer_control.msg import MotorState, WheelVelocities  # noqa: E402
from witness import PATIENCE, Witness  # noqa: E402

START = (3.0, 2.0, 1.0)  # m, m, rad: where the recorded robot stood
SPEED, DRIVEN, LAST_TURN = 0.3, 1.6, 1.2  # m/s, s, s
RADIUS = 0.3  # m: of the arc that ends it


def told():
    """(topic, message, s): straight on, then to the left by the wheels; and where the robot was, as if it had no inertia."""
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


class Redrive(unittest.TestCase):
    """The recorded commands, in every way."""

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
        """What it says, and its exit code."""
        process = self.start(*arguments)
        said, _ = process.communicate(timeout=2 * PATIENCE)
        return said.decode(), process.returncode

    def robot_on_a_port(self):
        """A simulated robot that nobody knows to be one, and its line."""
        line = os.path.join(self.folder.name, "line")
        command = ["rosrun", "pioneer_control", "p2os_simulator", "__ns:=bench", "_world:=empty", f"_pty:={line}"]
        robot = subprocess.Popen(command, stdin=subprocess.DEVNULL)
        self.addCleanup(robot.wait)
        self.addCleanup(lambda: rosnode.kill_nodes(["/bench/p2os_simulator"]))
        witness = Witness({"/bench/ground_truth": Odometry, "/redrive/motor_state": MotorState})
        witness.last("/bench/ground_truth")
        return line, witness

    def test_1_into_a_simulated_robot(self):
        """The same model at the same place, which drives the same way; a world that is gone is told."""
        output = os.path.join(self.folder.name, "new.bag")
        said, code = self.run_to_its_end("--output=" + output)
        self.assertEqual(code, 0, said)
        self.assertIn("The world 'no such world' of the recording is not here", said)
        self.assertIn("A simulated p3dx-sh in the world 'empty' at x 3.00 m, y 2.00 m, 57 degrees", said)
        length, new = map(float, re.search(r"recorded path is ([\d.]+) m long, the new one ([\d.]+) m", said).groups())
        self.assertAlmostEqual(length, SPEED * DRIVEN + 0.15 * (LAST_TURN + VALID), delta=0.05)
        self.assertAlmostEqual(new, length, delta=0.1)  # the recorded one had no inertia
        self.assertLess(float(re.search(r"([\d.]+) cm at most", said).group(1)), 20.0)
        run = read_run(output, "redrive")
        self.assertLess(max(np.abs(np.array(run.truth.pose(0)) - START)), 0.001)
        self.assertEqual(run.model, "p3dx-sh")
        self.assertGreater(run.truth.heading[-1] - START[2], 0.2)
        self.assertTrue(os.path.getsize(output[:-4] + ".png") > 10000)
        self.assertEqual([node for node in rosnode.get_node_names() if node.startswith("/redrive")], [])
        self.assertFalse(rospy.has_param("/redrive"))

    def test_2_into_a_real_robot_it_is_slower_and_waits_for_its_motors(self):
        line, witness = self.robot_on_a_port()
        process = self.start("--into=real", f"--port={line}", "--speed=0.5")
        begin = witness.last("/bench/ground_truth").pose.pose.position
        witness.next("/redrive/motor_state", 10)
        self.assertEqual({message.state for message in witness.seen["/redrive/motor_state"]}, {0}, "nobody has asked for the motors")
        rospy.wait_for_service("/redrive/set_motors", PATIENCE)
        rospy.ServiceProxy("/redrive/set_motors", SetBool)(True)
        said = process.communicate(timeout=2 * PATIENCE)[0].decode()
        self.assertEqual(process.returncode, 0, said)
        self.assertIn(f"A REAL robot on {line} is going to move", said)
        self.assertIn("rosservice call /redrive/set_motors true", said)
        truth = witness.seen["/bench/ground_truth"]
        end = witness.next("/bench/ground_truth")
        self.assertLessEqual(max(message.twist.twist.linear.x for message in truth), 0.5 * SPEED + 0.01)
        way = math.hypot(end.pose.pose.position.x - begin.x, end.pose.pose.position.y - begin.y)
        self.assertAlmostEqual(way, SPEED * DRIVEN + 0.15 * (LAST_TURN + VALID), delta=0.15)  # half as fast for twice as long
        self.assertEqual(end.twist.twist.linear.x, 0.0)

    def test_3_ctrl_c_stops_a_real_robot(self):
        line, witness = self.robot_on_a_port()
        process = self.start("--into=real", f"--port={line}", "--motors=true")
        witness.wait("it moves", lambda: witness.last("/bench/ground_truth").twist.twist.linear.x > 0.05)
        process.send_signal(signal.SIGINT)
        said = process.communicate(timeout=PATIENCE)[0].decode()
        self.assertEqual(process.returncode, 1, said)
        self.assertIn("the robot was stopped", said)
        witness.wait("it stands", lambda: witness.last("/bench/ground_truth").twist.twist.linear.x == 0.0)
        place = witness.last("/bench/ground_truth").pose.pose.position
        self.assertEqual(witness.next("/bench/ground_truth", 5).pose.pose.position, place)


if __name__ == "__main__":
    rospy.init_node("bag_redrive_test")
    rostest.rosrun("pioneer_control", "bag_redrive", Redrive)
