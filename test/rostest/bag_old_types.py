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
from pioneer_control import msg  # noqa: E402

PATIENCE = 30.0  # s

# A value for every field, none of them what an untouched message holds.
VALUES = {
    "SonarArray": dict(ranges_count=3, ranges=[0.5, 5.0, 1.25]),
    "GripperState": {
        "grip.state": 2, "grip.dir": -1, "grip.inner_beam": True, "grip.outer_beam": True, "grip.left_contact": True,
        "grip.right_contact": True, "lift.state": 1, "lift.dir": 1, "lift.position": 0.5,
    },
    "MotorState": dict(state=1),
    "BatteryState": dict(voltage=12.5),
    "DIO": dict(count=8, bits=165),
    "AIO": dict(voltages_count=1, voltages=[2.5]),
    "PTZState": dict(pan=10, tilt=-5, zoom=100, relative=True),
}  # fmt: skip


def filled(message, values):
    """A message with values by dotted names."""
    for name, value in values.items():
        *path, last = name.split(".")
        part = message
        for step in path:
            part = getattr(part, step)
        setattr(part, last, value)
    return message


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
                (f"/{package}/{name}", filled(make.message_class(name, package)(), values), 10.0 + 0.01 * index)
                for index, (name, values) in enumerate(VALUES.items())
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
        for name, values in VALUES.items():
            with self.subTest(message=name):
                self.assertIn(name, received)
                sent = filled(getattr(msg, name)(), values)
                if hasattr(sent, "header"):
                    sent.header = received[name].header
                self.assertEqual(received[name], sent)

    def test_p2os_driver(self):
        """Bags from before p2os was split into packages."""
        self.check("p2os_driver")

    def test_p2os_msgs(self):
        """Bags of today's p2os."""
        self.check("p2os_msgs")


if __name__ == "__main__":
    rospy.init_node("bag_old_types_listener")
    rostest.rosrun("pioneer_control", "bag_old_types", OldTypes)
