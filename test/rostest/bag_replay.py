#!/usr/bin/python3
"""A recorded run, played back with no robot, shows a Pioneer what it would have seen beside the robot.

As a test: drives, records with launch/record.launch, ends the robot, plays back with launch/replay.launch to a program that is
this file with the argument "listen", and compares what that heard with what the bag holds.
"""

import json
import math
import os
import signal
import subprocess
import sys
import tempfile
import time
import unittest

import rosbag
import rosgraph
import rosnode
import rospy
import rostest

from pioneer_control.bags.recorder import subscribed
from pioneer_control.tutorial.pioneer import Pioneer

PATIENCE = 40.0  # s
MISSED = 0.05  # share of the messages a Pioneer may miss: it keeps only the newest when the machine is busy
ROBOT_NODES = "/pioneer/p2os", "/pioneer/simulator"


class Listener(Pioneer):
    """A Pioneer that keeps all it hears, in order."""

    def __init__(self):
        self.heard = {"pose": [], "ranges": [], "grip": [], "lift": []}
        super().__init__("pioneer")

    def _hear(self, **what):
        super()._hear(**what)
        for name, kept in self.heard.items():
            if name in what:
                kept.append(what[name])


def listen():
    """Be a program beside the replay: say when ready, tell all that was heard when standard input ends."""
    rospy.init_node("listener", disable_signals=True)
    listener = Listener()
    master = rosgraph.Master("/listener")
    wait_until("the topics are subscribed", lambda: len([t for t, nodes in master.getSystemState()[1] if "/listener" in nodes]) >= 5)
    print("ready", flush=True)
    sys.stdin.read()
    json.dump(listener.heard, sys.stdout)


def wait_until(what, condition):
    """Until a condition holds; AssertionError that says what did not happen."""
    end = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < end, f"not within {PATIENCE:.0f} s: {what}"
        time.sleep(0.05)


def end(process):
    """Ctrl-C to a roslaunch, and wait for it."""
    process.send_signal(signal.SIGINT)
    process.wait(PATIENCE)


def recorded(path):
    """What a Listener must hear of a bag."""
    heard = {"pose": [], "ranges": [], "grip": [], "lift": []}
    with rosbag.Bag(path) as bag:
        for topic, message, _ in bag.read_messages():
            if topic == "/pioneer/pose":
                place = message.pose.pose
                heard["pose"].append([place.position.x, place.position.y, 2 * math.atan2(place.orientation.z, place.orientation.w)])
            elif topic == "/pioneer/sonar":
                heard["ranges"].append(list(message.ranges))
            elif topic == "/pioneer/gripper_state":
                grip, lift = message.grip, message.lift
                heard["grip"].append([grip.state, grip.dir, grip.inner_beam, grip.outer_beam, grip.left_contact, grip.right_contact])
                heard["lift"].append([lift.state, lift.dir, lift.position])
    return heard


def missing(heard, expected):
    """How many of the expected, lists of numbers, were not heard; None when something else was, or in another order."""
    rest = iter(expected)
    same = lambda a, b: len(a) == len(b) and all(abs(one - other) < 1e-9 for one, other in zip(a, b))  # noqa: E731
    if not all(any(same(value, other) for other in rest) for value in heard):
        return None
    return len(expected) - len(heard)


class Replay(unittest.TestCase):
    """The whole way, once."""

    def test_missing_finds_what_is_missing(self):
        self.assertEqual(missing([[1], [2]], [[1], [2]]), 0)
        self.assertEqual(missing([[1], [3]], [[1], [2], [3]]), 1)
        self.assertIsNone(missing([[3], [1]], [[1], [3]]))
        self.assertIsNone(missing([[1], [2.1]], [[1], [2]]))

    def record(self, bag):
        """Drive a metre, turn and close the gripper, while record.launch records."""
        recorder = subprocess.Popen(["roslaunch", "pioneer_control", "record.launch", f"bag:={bag}"], stdout=subprocess.DEVNULL)
        try:
            master = rosgraph.Master("/bag_replay")
            wait_until("the recorder listens", lambda: subscribed("/pioneer/recorder", master.getSystemState()))
            rospy.init_node("bag_replay_driver", disable_signals=True)
            with Pioneer("pioneer") as robot:
                for linear, angular in ((0.3, 0.0), (0.0, 0.6)):
                    start = robot.pose
                    there = lambda: abs(robot.pose.x - start.x) > 0.4 or abs(robot.pose.heading - start.heading) > 0.6  # noqa: E731
                    wait_until("the robot moves", lambda: robot.drive(linear, angular) or there())
                robot.stop()
                robot.gripper_close()
        finally:
            end(recorder)
        self.assertTrue(os.path.exists(bag))
        self.assertFalse(os.path.exists(bag + ".active"))

    def end_robot(self):
        """No driver, no simulated robot any more."""
        rosnode.kill_nodes(ROBOT_NODES)
        wait_until("the robot is gone", lambda: not set(ROBOT_NODES) & set(rosnode.get_node_names()))

    def replay(self, bag):
        """What a listener heard while replay.launch played a bag."""
        rospy.set_param("/use_sim_time", True)  # before the listener starts, as in a terminal opened after replay.launch
        listener = subprocess.Popen([sys.executable, __file__, "listen"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self.addCleanup(listener.kill)
        self.assertEqual(listener.stdout.readline(), "ready\n")
        command = ["roslaunch", "pioneer_control", "replay.launch", f"bag:={bag}", "options:=--quiet --delay=1"]
        subprocess.run(command, check=True, timeout=PATIENCE, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL)
        told, _ = listener.communicate(timeout=PATIENCE)
        return json.loads(told)

    def test_a_pioneer_hears_of_the_bag_what_it_heard_of_the_robot(self):
        with tempfile.TemporaryDirectory() as folder:
            bag = os.path.join(folder, "run.bag")
            self.record(bag)
            with rosbag.Bag(bag) as run:
                told = run.get_type_and_topic_info().topics
            self.end_robot()
            heard, expected = self.replay(bag), recorded(bag)
        # The first that a program commands is to switch the motors on: nothing of the beginning is missing.
        self.assertLessEqual({"/pioneer/cmd_motor_state", "/pioneer/cmd_vel", "/pioneer/gripper_control"}, set(told))
        for name in expected:
            with self.subTest(heard=name):
                missed = missing(heard[name], expected[name])
                self.assertIsNotNone(missed, "what was heard is not what was recorded")
                self.assertLessEqual(missed, MISSED * len(expected[name]))
        # The comparison compared something: the run had a drive, a turn, echoes and a gripper that closed.
        self.assertGreater(max(x for x, _, _ in heard["pose"]), 0.4)
        self.assertGreater(max(heading for _, _, heading in heard["pose"]), 0.5)
        self.assertGreater(len({tuple(ranges) for ranges in heard["ranges"]}), 20)
        self.assertEqual({state for state, *_ in heard["grip"]}, {1, 2, 3})
        self.assertGreater(len(heard["pose"]), 40)


if __name__ == "__main__":
    if sys.argv[1:] == ["listen"]:
        listen()
    else:
        rostest.rosrun("pioneer_control", "bag_replay", Replay)
