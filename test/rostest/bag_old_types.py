#!/usr/bin/python3
"""Plays bags with the types of older packages to subscribers of ours, with the real rosbag play."""

import math
import os
import subprocess
import sys
import tempfile
import threading
import unittest

import rospy
import rostest
import tf
from sensor_msgs.msg import BatteryState, LaserScan, PointCloud2, Range

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "messages", "bags"))

import bag_factory as make
import old_messages
from pioneer_control import msg
from pioneer_control.bags.converting import convert
from pioneer_control.robots import find_model

PATIENCE = 30.0  # s

# parts of GripperState, on no topic of their own
VALUES = [name for name in old_messages.VALUES if name not in ("GripState", "LiftState")]


def play(bag):
    """Run rosbag play to its end."""
    subprocess.run(["rosbag", "play", "--quiet", "--wait-for-subscribers", bag], check=True, timeout=PATIENCE,
                   stdin=subprocess.DEVNULL)


class OldTypes(unittest.TestCase):
    """One test for each older package, and one for a converted bag."""

    def played(self, package):
        """Return the messages that our subscribers receive from a bag of an older package, by message name."""
        received, all_received = {}, threading.Event()

        def receive(message, name):
            received[name] = message
            if set(received) == set(VALUES):
                all_received.set()

        subscribers = [rospy.Subscriber("%s/%s" % (package, name), getattr(msg, name), receive, name)
                       for name in VALUES]
        with tempfile.TemporaryDirectory() as folder:
            entries = [
                ("/%s/%s" % (package, name), old_messages.old_message(name, package), 10.0 + 0.01 * index)
                for index, name in enumerate(VALUES)
            ]
            play(make.write_bag(os.path.join(folder, "old.bag"), entries))
        all_received.wait(PATIENCE)
        for subscriber in subscribers:
            subscriber.unregister()
        return received

    def check(self, package):
        received = self.played(package)
        for name in VALUES:
            with self.subTest(message=name):
                self.assertIn(name, received)
                sent = old_messages.serialized(old_messages.old_message(name, package))
                self.assertEqual(received[name], getattr(msg, name)().deserialize(sent))

    def test_p2os_driver(self):
        """Bags from before p2os was split into packages."""
        self.check("p2os_driver")

    def test_p2os_msgs(self):
        """Bags of today's p2os."""
        self.check("p2os_msgs")

    def test_converted(self):
        """Programs that do not know this package receive a converted bag of p2os, and tf has the places of the sonar's
        transducers.
        """
        received, all_received = {}, threading.Event()
        types = {"robot_info": msg.RobotInfo, "sonar_ranges": Range, "sonar_points": PointCloud2,
                 "sonar_scan": LaserScan, "battery": BatteryState}

        def receive(message, name):
            received[name] = message
            if set(received) == set(types):
                all_received.set()

        subscribers = [rospy.Subscriber("converted/%s" % name, message, receive, name)
                       for name, message in types.items()]
        listener = tf.TransformListener()
        with tempfile.TemporaryDirectory() as folder:
            ranges = make.sonar([5.0, 5.0, 5.0, 1.5], "p2os_msgs")
            entries = [("/converted/sonar", ranges, 10.0),
                       ("/converted/battery_state", old_messages.old_message("BatteryState", "p2os_msgs"), 10.1)]
            new = os.path.join(folder, "new.bag")
            wanted = convert.Options(tuple(convert.CONVERSIONS), find_model("p3dx-sh"), replace=True)
            convert.convert(make.write_bag(os.path.join(folder, "old.bag"), entries), new, wanted)
            play(new)
        self.assertTrue(all_received.wait(PATIENCE), received)
        self.assertEqual((received["sonar_ranges"].header.frame_id, received["sonar_ranges"].range), ("sonar_3", 1.5))
        self.assertEqual((received["sonar_points"].width, received["battery"].voltage), (1, 12.5))
        self.assertEqual([round(reading, 2) for reading in received["sonar_scan"].ranges if math.isfinite(reading)],
                         [1.67])
        listener.waitForTransform("base_link", "sonar_3", rospy.Time(0), rospy.Duration(PATIENCE))
        self.assertEqual([round(value, 3) for value in listener.lookupTransform(
            "base_link", "sonar_3", rospy.Time(0))[0]], [0.166, 0.027, 0.17])
        for subscriber in subscribers:
            subscriber.unregister()


if __name__ == "__main__":
    rospy.init_node("bag_old_types_listener")
    rostest.rosrun("pioneer_control", "bag_old_types", OldTypes)
