#!/usr/bin/python3
"""The node of a laser, with a simulated laser: scans, tf, diagnostics, a cut line, its end, its launch file."""

import contextlib
import math
import os
import re
import subprocess
import signal
import sys
import tempfile
import time
import unittest

import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticArray
from sensor_msgs.msg import LaserScan
from tf2_msgs.msg import TFMessage

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [HERE, os.path.join(HERE, "..", "integration")]

from client_lines import SpoiltLine
from driver_lines import Driver
from pioneer_control.client.fault_flags import Level
from pioneer_control.lms2xx import Mode
from pioneer_control.robots import find_model
from pioneer_control.simulator import load_world, simulate
from pioneer_control.simulator.line import LaserPorts, Server
from witness import PATIENCE, Witness, wait_until


class LaserScans(unittest.TestCase):
    """Each test has a laser, a node and a namespace of its own."""

    def setUp(self):
        self.ending = contextlib.ExitStack()
        self.addCleanup(self.ending.close)
        self.namespace = "/" + self.id().rpartition(".")[2]
        self.scan = self.namespace + "/scan"

    def node(self, program="laser", **parameters):
        node = Driver(self.namespace, program=program, **parameters)
        self.ending.callback(node.end)
        return node

    def witness(self):
        return Witness({self.scan: LaserScan, "/diagnostics": DiagnosticArray, "/tf_static": TFMessage})

    def server(self, **ports):
        world = load_world("tutorial").with_start((2.0, 1.5, math.pi / 2.0))
        return self.ending.enter_context(Server(simulate(world, find_model("p3dx-sh"), 1, None, 0), tcp=0,
                                                lasers=LaserPorts(**ports)))

    def health(self, seen):
        """Return the newest status of this test's laser."""
        name = "%s/laser: Laser" % self.namespace[1:]
        return next((status for message in reversed(seen.seen["/diagnostics"]) for status in message.status
                     if status.name == name and status.level in list(Level)), None)

    def wait_for_health(self, seen, level, text):
        def is_so():
            health = self.health(seen)
            return health is not None and health.level == level and text in health.message

        seen.wait("diagnostics: %s %s" % (level, text), is_so)
        return {each.key: each.value for each in self.health(seen).values}

    def test_scans_of_a_simulated_robot_through_a_cut_line(self):
        seen = self.witness()
        simulator = self.node("p2os_simulator", tcp=0, laser="lms200", start="[2.0, 1.5, 1.5708]")
        simulator.says("its laser is at")
        port = int(re.search(r"its laser is at socket://[\d.]+:(\d+)", simulator.printed).group(1))
        line = self.ending.enter_context(SpoiltLine(port))
        laser = self.node(port=line.url, angle=180, resolution=1, place="p3dx-sh")
        scan = seen.last(self.scan)
        self.assertEqual((len(scan.ranges), len(scan.intensities), scan.header.frame_id), (181, 0, "laser"))
        self.assertAlmostEqual(scan.angle_min, -math.pi / 2.0, 5)
        self.assertAlmostEqual(scan.angle_increment, math.radians(1.0), 6)
        self.assertAlmostEqual(scan.time_increment, 1.0 / 75.0 / 360.0, 7)
        self.assertAlmostEqual(scan.scan_time, 1.0 / 75.0, 5)
        self.assertAlmostEqual(scan.range_max, 8.183, 4)
        self.assertAlmostEqual(scan.ranges[180], 2.0, delta=0.05)       # the wall at x = 0 is on the left
        self.assertLess(abs(rospy.get_time() - scan.header.stamp.to_sec()), PATIENCE)
        stamps = [message.header.stamp.to_sec() for message in seen.seen[self.scan]]
        self.assertEqual(stamps, sorted(stamps))

        seen.wait("tf of the laser", lambda: any(
            each.child_frame_id == "laser" and abs(each.transform.translation.x - 0.021) < 1e-9
            and each.header.frame_id == "base_link" for message in seen.seen["/tf_static"]
            for each in message.transforms))
        laser.says("how high the laser of a p3dx-sh sits is not known")
        values = self.wait_for_health(seen, Level.OK, "all scans arrive")
        self.assertEqual((values["Laser"], values["Baud"]), ("LMS200;301063;V02.10", "500000"))

        line.cut()
        laser.says("closed the line")
        seen.next(self.scan, 3)
        self.assertEqual(self.wait_for_health(seen, Level.OK, "all scans arrive")["Times the laser was lost"], "1")
        errors = [status.message for message in seen.seen["/diagnostics"] for status in message.status
                  if status.level == Level.ERROR and status.name == self.namespace[1:] + "/laser: Laser"]
        self.assertTrue(errors[-1].startswith("no scans: %s: the other side closed the line" % line.url), errors)

        begun = time.monotonic()
        self.assertEqual(laser.end(), 0, laser.printed)
        self.assertLess(time.monotonic() - begun, 10.0)
        self.assertNotIn("Traceback", laser.printed)
        laser.says("closed after")

    def test_on_a_line_with_a_speed_the_laser_is_told_to_stop(self):
        folder = self.ending.enter_context(tempfile.TemporaryDirectory())
        server, seen = self.server(pty=os.path.join(folder, "laser")), self.witness()
        device = server.lasers[0].laser.device
        record = os.path.join(folder, "laser.txt")
        laser = self.node(record=record, port=server.lasers[0].place, baud=38400, resolution=0.5, frame_id="front",
                          frame_prefix="r/", inverted="true", no_echo="max", time_offset=5.0)
        scan = seen.last(self.scan)
        self.assertEqual((len(scan.ranges), scan.time_increment, scan.header.frame_id), (361, 0.0, "r/front"))
        self.assertAlmostEqual(scan.ranges[0], 2.0, delta=0.05)         # as it hangs, left is on the right
        self.assertTrue(all(math.isfinite(each) for each in scan.ranges))
        self.assertGreater(scan.header.stamp.to_sec(), rospy.get_time())
        self.assertEqual((device.operation.mode, device.baud), (Mode.STREAM, 38400))
        laser.says("at 38400 baud (found at 9600, and gets that back at the end)")
        self.assertEqual(laser.end(signal.SIGTERM), 0, laser.printed)
        self.assertNotIn("Traceback", laser.printed)
        wait_until("the laser is silent, at its old speed", lambda: (
            device.operation.mode, device.baud) == (Mode.ON_REQUEST, 9600))

        with open(record) as lines:
            kept = [line.split(None, 2) for line in lines]
        stop = "02 00 02 00 20 25 35 08"
        self.assertEqual({line[1] for line in kept}, {">", "<"})
        self.assertGreaterEqual(sum(line[2].strip() == stop for line in kept), 2, "at the begin, and at the end")

    def test_the_launch_file(self):
        server, seen = self.server(), self.witness()
        launch = subprocess.Popen([
            "roslaunch", "pioneer_control", "laser.launch", "robot:=" + self.namespace[1:],
            "port:=" + server.lasers[0].place, "place:=[0.1, 0, 0.3, 0]"])
        self.ending.callback(launch.kill)
        self.assertEqual(seen.last(self.scan).header.frame_id, self.namespace[1:] + "/laser")
        seen.wait("tf of the laser", lambda: any(
            each.child_frame_id == self.namespace[1:] + "/laser" and each.transform.translation.z == 0.3
            for message in seen.seen["/tf_static"] for each in message.transforms))
        launch.send_signal(signal.SIGINT)
        self.assertEqual(launch.wait(PATIENCE), 0)
        wait_until("the laser is silent", lambda: server.lasers[0].laser.device.operation.mode == Mode.ON_REQUEST)

    def test_a_port_that_is_not_there(self):
        laser = self.node(port="/dev/nowhere")
        laser.says("/dev/nowhere: no such port")
        laser.says("--laser lms200 simulates one")
        self.assertEqual(laser.end(), 0, laser.printed)

    def test_bad_parameters_are_named_and_end_the_node(self):
        laser = self.node(port="/dev/null", baud=57600, resoluton=0.5)
        self.assertEqual(laser.exit_code(), 2)
        for text in ("~baud = 57600 is not legal", "did you mean ~resolution?"):
            self.assertIn(text, laser.printed)
        self.assertNotIn("Traceback", laser.printed)

    def test_parameters_without_effect_are_told(self):
        laser = self.node(port="/dev/nowhere", connect_delay=30)
        laser.says("~connect_delay has no effect: a laser that has just got power is waited for (power_on)")


if __name__ == "__main__":
    rospy.init_node("laser_scans_witness")
    rostest.rosrun("pioneer_control", "laser_scans", LaserScans)
