#!/usr/bin/python3
"""Several simulated robots in one node. Each has its own ground truth, line and STOP button. Faults come by service.
The simulation publishes the clock.
"""

import math
import os
import sys
import time
import unittest

import rospy
import rostest
import serial
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Bool
from std_srvs.srv import SetBool, Trigger
from visualization_msgs.msg import MarkerArray

from pioneer_control import p2os
from pioneer_control.simulator.world import load_world
from pioneer_control.srv import AddFault

DEADLINE = 30.0
TOPICS = {"robot1/ground_truth": Odometry, "robot2/ground_truth": Odometry, "markers": MarkerArray,
          "world_markers": MarkerArray, "/clock": Clock}


class Line:
    """A client of one robot."""

    def __init__(self, link):
        self._port = serial.Serial(link, timeout=0.0)
        self._decoder, self.sip = p2os.FrameDecoder(), None
        for number in (0, 1, 2, 1):
            self._port.write(p2os.encode_frame(number))
        self.send("ENABLE", 1)

    def send(self, name, *values):
        self._port.write(p2os.encode_command(name, *values))

    def listen(self):
        for packet in map(p2os.decode_packet, self._decoder.feed(self._port.read(4096))):
            self.sip = packet if isinstance(packet, p2os.Sip) else self.sip


class SimulatorFleet(unittest.TestCase):
    """Two robots on a free floor."""

    @classmethod
    def setUpClass(cls):
        rospy.init_node("simulator_fleet")
        cls.heard, cls.lines = {}, []
        for topic, kind in TOPICS.items():
            rospy.Subscriber(topic, kind, lambda message, topic=topic: cls.heard.__setitem__(topic, message))
        link = rospy.get_param("simulator/pty")
        cls.until(lambda: os.path.exists(link + "2"), "the terminals")
        rospy.wait_for_service("simulator/add_fault")
        cls.call("clear_faults", Trigger)
        cls.lines = [Line(link + number) for number in "12"]
        cls.until(lambda: all(line.sip is not None for line in cls.lines), "a SIP of each")

    @classmethod
    def call(cls, service, kind, *values):
        return rospy.ServiceProxy("simulator/" + service, kind)(*values)

    @classmethod
    def until(cls, condition, what):
        """Listen to the robots until a condition holds."""
        end = time.monotonic() + DEADLINE
        while not condition():
            if time.monotonic() > end:
                raise AssertionError("never happened: " + what)
            time.sleep(0.01)
            for line in cls.lines:
                line.listen()

    def tearDown(self):
        self.call("clear_faults", Trigger)

    def flags(self, number):
        return self.lines[number - 1].sip.flags

    def place(self, number):
        """Return x and y of the true pose of a robot."""
        position = self.heard["robot%d/ground_truth" % number].pose.pose.position
        return position.x, position.y

    def test_each_robot_has_its_truth(self):
        self.until(lambda: set(TOPICS) <= set(self.heard), "every topic")
        frames = [self.heard["robot%d/ground_truth" % number].child_frame_id for number in (1, 2)]
        self.assertEqual(frames, ["robot1/base_link", "robot2/base_link"])
        places = [self.place(number) for number in (1, 2)]
        self.assertNotEqual(*places)
        self.lines[1].send("MOVE", -100)
        self.until(lambda: math.dist(self.place(2), places[1]) > 0.08, "the second one drives")
        self.assertEqual(self.place(1), places[0])

    def test_what_stands_around_is_drawn(self):
        self.until(lambda: {"markers", "world_markers"} <= set(self.heard), "markers")
        world, kinds = load_world("cans"), [marker.ns for marker in self.heard["markers"].markers]
        self.assertEqual({kind: kinds.count(kind) for kind in set(kinds)},
                         {"can": len(world.cans), "outline": 2, "paddle": 4})
        walls = [marker for marker in self.heard["world_markers"].markers if marker.ns == "wall"]
        self.assertEqual(len(walls[0].points), 6 * len(world.walls))

    def test_the_clock_is_that_of_the_simulation(self):
        """The clock runs five times as fast as real time at most. On a slow machine it may run slower."""
        self.until(lambda: "/clock" in self.heard, "a clock")
        real, simulated = time.monotonic(), self.heard["/clock"].clock.to_sec()
        self.until(lambda: self.heard["/clock"].clock.to_sec() > simulated + 3.0, "three seconds")
        self.assertGreater(time.monotonic() - real, 3.0 / 5 - 0.2)
        truth = self.heard["robot1/ground_truth"].header.stamp.to_sec()
        self.assertLess(abs(truth - self.heard["/clock"].clock.to_sec()), 5.0)

    def test_the_clock_stands_while_it_is_paused(self):
        clocks = []
        listener = rospy.Subscriber("/clock", Clock, lambda message: clocks.append(message.clock))
        answer = self.call("pause", SetBool, True)
        self.assertTrue(answer.success and answer.message.startswith("simulated time stands at "))
        clocks.clear()      # one of them may have been on its way
        self.until(lambda: len(clocks) > 20 and len(set(clocks[-20:])) == 1, "a clock that stands")
        self.assertEqual(self.call("pause", SetBool, False).message, "simulated time passes")
        self.until(lambda: clocks[-1] > clocks[0], "a clock that goes on")
        listener.unregister()

    def test_reset_carries_all_back(self):
        self.until(lambda: set(TOPICS) <= set(self.heard), "every topic")
        self.assertTrue(self.call("reset", Trigger).success)
        self.until(lambda: self.place(1) == (0.0, 0.0), "the start of the world")
        self.lines[0].send("ENABLE", 1)
        self.lines[0].send("MOVE", -150)
        self.until(lambda: self.place(1)[0] < -0.1, "driven away")
        answer = self.call("reset", Trigger)
        self.assertEqual((answer.success, answer.message), (True, "all robots and cans are where they began"))
        self.until(lambda: self.place(1) == (0.0, 0.0), "back at the start")

    def test_the_stop_button_of_one(self):
        button = rospy.Publisher("robot2/stop_button", Bool, queue_size=1, latch=True)
        button.publish(True)
        self.until(lambda: self.flags(2) & p2os.Flags.STOP_BUTTON, "pressed")
        self.assertFalse(self.flags(1) & p2os.Flags.STOP_BUTTON)
        button.publish(False)
        self.until(lambda: not self.flags(2) & p2os.Flags.STOP_BUTTON, "released")

    def test_faults_by_service(self):
        answer = self.call("add_fault", AddFault, "stop_button robot 1")
        self.assertEqual((answer.success, answer.message), (True, "stop_button robot 1: now, until it is cleared"))
        self.until(lambda: self.flags(1) & p2os.Flags.STOP_BUTTON, "the fault")
        self.assertEqual(self.call("list_faults", Trigger).message, "stop_button robot 1")
        self.assertFalse(self.flags(2) & p2os.Flags.STOP_BUTTON)
        self.assertEqual(self.call("clear_faults", Trigger).message, "1 ended")
        self.until(lambda: not self.flags(1) & p2os.Flags.STOP_BUTTON, "its end")
        self.assertEqual(self.call("list_faults", Trigger).message, "none")

    def test_a_fault_that_makes_no_sense(self):
        for words, problem in (("los 0.1", "there are loss"), ("loss 2", "give a number from 0 to 1"),
                               ("cable robot 3", "there are 1 to 2")):
            answer = self.call("add_fault", AddFault, words)
            self.assertFalse(answer.success)
            self.assertIn(problem, answer.message)


if __name__ == "__main__":
    rostest.rosrun("pioneer_control", "simulator_fleet", SimulatorFleet, sys.argv)
