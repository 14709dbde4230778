#!/usr/bin/python3
"""Plays bags with the types of older packages to subscribers of ours, with the real rosbag play."""

import os
import subprocess
import sys
import tempfile
import threading
import unittest

import rospy
import rostest

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "messages", "bags"))

import bag_factory as make  # noqa: E402
import old_messages  # noqa: E402
from pioneer_control import msg  # noqa: E402

PATIENCE = 30.0  # s

VALUES = [name for name in old_messages.VALUES if name not in ("GripState", "LiftState")]  # parts of GripperState, on no topic of their own


class OldTypes(unittest.TestCase):
    """One test per older package."""

    def play(self, package):
        """What our subscribers receive of a bag of an older package's messages, by message name."""
        received, all_received = {}, threading.Event()

        def receive(message, name):
            received[name] = message
            if set(received) == set(VALUES):
                all_received.set()

        subscribers = [rospy.Subscriber(f"{package}/{name}", getattr(msg, name), receive, name) for name in VALUES]
        with tempfile.TemporaryDirectory() as folder:
            entries = [
                (f"/{package}/{name}", old_messages.old_message(name, package), 10.0 + 0.01 * index)
                for index, name in enumerate(VALUES)
            ]
            bag = make.write_bag(os.path.join(folder, "old.bag"), entries)
            command = ["rosbag", "play", "--quiet", "--wait-for-subscribers", bag]
            subprocess.run(command, check=True, timeout=PATIENCE, stdin=subprocess.DEVNULL)
        all_received.wait(PATIENCE)
        for subscriber in subscribers:
            subscriber.unregister()
        return received

    def check(self, package):
        received = self.play(package)
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


if __name__ == "__main__":
    rospy.init_node("bag_old_types_listener")
    rostest.rosrun("pioneer_control", "bag_old_types", OldTypes)
