#!/usr/bin/python3
"""Diagnostics of real drivers. Each fault is named while it lasts and is gone afterwards, and the aggregator knows
every task name, for two robots.
"""

import os
import re
import sys
import unittest

import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import Twist

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [HERE, os.path.join(HERE, "..", "integration")]

from driver_lines import Driver
from pioneer_control.client.fault_flags import Level
from pioneer_control.client.health import TASKS
from pioneer_control.robots import find_model
from pioneer_control.simulator.line import Server, fault_of
from pioneer_control.simulator.firmware import Firmware
from pioneer_control.simulator.world import load_world
from witness import Witness

OK, WARN, ERROR, STALE = Level
WELL = dict.fromkeys(TASKS, OK)
UNKNOWN = dict(dict.fromkeys(TASKS, STALE), Link=ERROR)


class DriverDiagnostics(unittest.TestCase):
    """Two robots and their drivers. The tests run one after the other."""

    @classmethod
    def setUpClass(cls):
        cls.witness = Witness({"/diagnostics": DiagnosticArray, "/diagnostics_agg": DiagnosticArray})
        cls.servers, cls.drivers = {}, {}
        for robot in ("left", "fleet/right"):
            cls.servers[robot] = cls.server(robot.replace("/", "_"))
            cls.drivers[robot] = Driver("/" + robot, port=cls.servers[robot].url)

    @classmethod
    def tearDownClass(cls):
        for driver in cls.drivers.values():
            driver.end()
        for server in cls.servers.values():
            server.stop()

    @staticmethod
    def server(name, tcp=0):
        return Server(Firmware(find_model("p3dx-sh"), load_world("empty"), name=name), tcp=tcp).start()

    def newest(self, robot):
        """Return {task: status}: the newest diagnostics of a robot's driver."""
        prefix = robot + "/p2os: "
        for message in reversed(self.witness.seen["/diagnostics"]):
            statuses = {status.name[len(prefix):]: status for status in message.status
                        if status.name.startswith(prefix)}
            if len(statuses) == len(TASKS):     # else one of those that diagnostic_updater sends while a node starts
                return statuses
        return {}

    def expect(self, levels, robot="left"):
        """Wait until all tasks of a robot have these levels; returns their statuses."""
        self.witness.wait("%s: %s" % (robot, levels), lambda: {
            task: status.level for task, status in self.newest(robot).items()} == levels)
        return self.newest(robot)

    def aggregated(self):
        return {status.name: status.level for status in self.witness.seen["/diagnostics_agg"][-1].status}

    def test_01_levels_are_those_of_the_message(self):
        self.assertEqual([DiagnosticStatus.OK, DiagnosticStatus.WARN, DiagnosticStatus.ERROR, DiagnosticStatus.STALE],
                         list(Level))

    def test_02_all_is_well_of_two_robots_under_their_names(self):
        for robot in self.servers:
            self.assertEqual({status.hardware_id for status in self.expect(WELL, robot).values()},
                             {robot.replace("/", "_")})

    def test_03_the_aggregator_knows_exactly_what_the_drivers_say(self):
        """By robot. Nothing is missing, and nothing is left over for the group Other."""
        names = ["/" + robot + end for robot in self.servers for end in [""] + ["/" + task for task in TASKS]]
        self.witness.wait("a tree of two robots that are well", lambda: (
            self.witness.seen["/diagnostics_agg"] and self.aggregated() == dict.fromkeys(names, OK)))

    def test_04_faults_are_named_while_they_last_and_leave_the_other_robot_alone(self):
        firmware, lock = self.servers["left"].firmware, self.servers["left"].lock
        since = len(self.witness.seen["/diagnostics"])
        battery = firmware.hardware.battery

        def stall(stalled):
            firmware.hardware.stall.left = stalled

        for harm, mend, task, level, words in (
            (lambda: firmware.press_stop_button(True), lambda: firmware.press_stop_button(False), "Motors", WARN,
             "the STOP button is pressed"),
            (lambda: stall(True), lambda: stall(False), "Stall", WARN, "the left wheel is stalled"),
            (lambda: battery.pretend(11.2), lambda: battery.pretend(0.0), "Battery", WARN,
             "11.2 V, the alarm level is 11.5 V; charge it"),
            (lambda: battery.pretend(10.8), lambda: battery.pretend(0.0), "Battery", ERROR,
             "battery nearly empty: 10.8 V"),
        ):
            with lock:
                harm()
            self.assertIn(words, self.expect(dict(WELL, **{task: level}))[task].message)
            if level == ERROR:
                self.witness.wait("the aggregator says so too", lambda: self.aggregated()["/left"] == level)
            with lock:
                mend()
            self.expect(WELL)
        others = [status.level for message in self.witness.seen["/diagnostics"][since:] for status in message.status
                  if status.name.startswith("fleet/right/p2os: ") and not status.name.endswith("Link")]
        self.assertEqual(set(others), {OK})

    def test_05_what_gets_lost_on_its_way_to_the_robot_is_named_while_velocities_come(self):
        """Its motors stay off: questions are sent with velocities all the same."""
        server, twist = self.servers["left"], Twist()
        twist.angular.z = 0.3
        publisher = rospy.Publisher("/left/cmd_vel", Twist, queue_size=1)
        commander = rospy.Timer(rospy.Duration(0.1), lambda event: publisher.publish(twist))
        self.addCleanup(commander.shutdown)

        def unanswered():
            link = self.newest("left").get("Link")
            if link is None:
                return ""
            return {value.key: value.value for value in link.values}["Questions without an answer"]

        self.witness.wait("ten questions or more are answered", lambda: re.match("[0-9] of [0-9]{2}", unanswered()))
        self.expect(WELL)
        with server.lock:
            server.simulation.faults.add(fault_of("loss 0.5 way to-robot"), server.simulation.clock.now_us)
        named = "[1-9][0-9]* of [0-9]+ questions .* not answered"
        self.witness.wait("it is named", lambda: re.search(named, self.newest("left")["Link"].message))
        self.expect(dict(WELL, Link=WARN))
        with server.lock:
            server.simulation.faults.clear(server.simulation.clock.now_us)
        self.expect(WELL)
        self.assertRegex(unanswered(), "^[1-9][0-9]* of [0-9]{2}")

    def test_06_a_robot_that_is_gone_is_named_and_all_is_well_when_it_is_back(self):
        port = int(self.servers["left"].url.rpartition(":")[2])
        self.servers["left"].stop()
        link = self.expect(UNKNOWN)["Link"]
        self.assertTrue(link.message.startswith("no link: socket://127.0.0.1:%d" % port), link.message)
        self.assertEqual(link.hardware_id, "left")
        self.servers["left"] = self.server("left", port)
        link = self.expect(WELL)["Link"]
        values = {value.key: value.value for value in link.values}
        self.assertEqual(values["Reconnects"], "1")
        self.assertIn(str(port), values["Last error"])

    def test_07_a_clock_that_stands_does_not_hold_them_up(self):
        """Simulated time is on, and nobody publishes a clock."""
        rospy.set_param("/use_sim_time", True)
        try:
            driver = Driver("/timeless", port="/dev/nowhere")
            self.drivers["timeless"] = driver
            driver.says("/dev/nowhere: no such port")
        finally:
            rospy.set_param("/use_sim_time", False)
        self.assertIn("/dev/nowhere: no such port", self.expect(UNKNOWN, "timeless")["Link"].message)
        said = len(self.witness.seen["/diagnostics"])
        self.witness.wait("three more", lambda: 3 <= sum(
            status.name == "timeless/p2os: Link" for message in self.witness.seen["/diagnostics"][said:]
            for status in message.status))


if __name__ == "__main__":
    rospy.init_node("driver_diagnostics_witness")
    rostest.rosrun("pioneer_control", "driver_diagnostics", DriverDiagnostics)
