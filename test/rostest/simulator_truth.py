#!/usr/bin/python3
"""The ground truth, map and cans that the simulator's node publishes are true, and its STOP button works, however
slowly ROS time passes.
"""

import math
import os
import sys
import time
import unittest

import rospy
import rostest
import serial
import tf
from geometry_msgs.msg import PoseArray
from nav_msgs.msg import OccupancyGrid, Odometry
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Bool

from pioneer_control import p2os
from pioneer_control.simulator.world import load_world

DEADLINE = 30.0


class SimulatorTruth(unittest.TestCase):
    """One simulated robot. The tests use its own protocol."""

    @classmethod
    def setUpClass(cls):
        rospy.init_node("simulator_truth")
        cls.heard = {}
        cls.clock = rospy.Publisher("/clock", Clock, queue_size=1)
        for topic, kind in (("map", OccupancyGrid), ("ground_truth", Odometry), ("cans", PoseArray)):
            rospy.Subscriber(topic, kind, lambda message, topic=topic: cls.heard.__setitem__(topic, message))
        cls.frames = tf.TransformListener()
        link = rospy.get_param("simulator/pty")
        cls.until(lambda: os.path.exists(link), "the terminal")
        cls.line = serial.Serial(link, timeout=0.05)
        cls.decoder, cls.sip = p2os.FrameDecoder(), None
        for number in (0, 1, 2, 1):
            cls.line.write(p2os.encode_frame(number))
        cls.until(lambda: cls.sip is not None, "a SIP")

    @classmethod
    def tearDownClass(cls):
        cls.line.write(p2os.encode_command("CLOSE"))
        cls.line.close()

    @classmethod
    def until(cls, condition, what):
        """Listen to the robot and let ROS time pass, a hundred times too slowly, until a condition holds."""
        end = time.monotonic() + DEADLINE
        while not condition():
            if time.monotonic() > end:
                raise AssertionError("never happened: " + what)
            time.sleep(0.01)
            cls.clock.publish(rospy.Time.from_sec(1.0 + time.monotonic() / 100.0))
            if hasattr(cls, "decoder"):
                for frame in cls.decoder.feed(cls.line.read(max(1, cls.line.in_waiting))):
                    packet = p2os.decode_packet(frame)
                    cls.sip = packet if isinstance(packet, p2os.Sip) else cls.sip

    def drive(self, mm):
        """Drive the robot by ``mm``, and wait until it has gone this distance."""
        start = self.heard["ground_truth"].pose.pose.position
        self.line.write(p2os.encode_command("ENABLE", 1) + p2os.encode_command("MOVE", mm))
        self.until(lambda: abs(self.travelled(start) - abs(mm) / 1000.0) < 1e-3, "%d mm" % mm)

    def travelled(self, start):
        self.line.write(p2os.encode_command("PULSE"))
        place = self.heard["ground_truth"].pose.pose.position
        return math.hypot(place.x - start.x, place.y - start.y)

    def test_map_and_cans_are_those_of_the_world(self):
        world = load_world("tutorial")
        self.until(lambda: {"map", "cans"} <= set(self.heard), "latched map and cans")
        grid, cans = self.heard["map"], self.heard["cans"]
        cells, origin = world.occupancy(0.025)
        self.assertEqual((grid.header.frame_id, cans.header.frame_id), ("map", "map"))
        self.assertAlmostEqual(grid.info.resolution, 0.025)
        self.assertEqual((grid.info.height, grid.info.width), cells.shape)
        self.assertEqual((grid.info.origin.position.x, grid.info.origin.position.y), origin)
        self.assertEqual(list(grid.data), cells.reshape(-1).tolist())
        self.assertEqual(len(cans.poses), len(world.cans))

    def test_ground_truth_moves_and_the_odometry_frame_stays_where_it_began(self):
        self.until(lambda: "ground_truth" in self.heard, "ground truth")
        before = self.heard["ground_truth"]
        self.assertEqual((before.header.frame_id, before.child_frame_id), ("map", "rig/base_link"))
        self.drive(200)
        self.line.write(p2os.encode_command("SETO"))
        place = self.heard["ground_truth"].pose.pose.position
        self.drive(-200)

        def origin_is_there():
            (x, y, _), _ = self.frames.lookupTransform("map", "rig/odom", rospy.Time(0))
            return math.hypot(x - place.x, y - place.y) < 2e-3

        self.until(lambda: self.frames.canTransform("map", "rig/odom", rospy.Time(0)) and origin_is_there(),
                   "map -> odom")

    def test_the_stop_button(self):
        button = rospy.Publisher("stop_button", Bool, queue_size=1, latch=True)
        self.line.write(p2os.encode_command("ENABLE", 1))
        self.until(lambda: self.sip.flags & p2os.Flags.MOTORS_ENABLED, "motors on")
        button.publish(True)
        self.until(lambda: self.sip.flags & p2os.Flags.STOP_BUTTON and not self.sip.flags & p2os.Flags.MOTORS_ENABLED,
                   "motors off")
        button.publish(False)
        self.until(lambda: not self.sip.flags & p2os.Flags.STOP_BUTTON, "button released")
        self.assertFalse(self.sip.flags & p2os.Flags.MOTORS_ENABLED)


if __name__ == "__main__":
    rostest.rosrun("pioneer_control", "simulator_truth", SimulatorTruth, sys.argv)
