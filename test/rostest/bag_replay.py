#!/usr/bin/python3
"""A recorded wander is played back without a robot.

The messages are the recorded ones, to the last bit, and a Pioneer that hears them decides the same again. One run is
recorded with launch/record.launch, and then the robot's nodes are ended. All tests use this recording.
"""

import os
import signal
import subprocess
import tempfile
import threading
import unittest
from collections import defaultdict, deque

import rosgraph
import rosnode
import rospy
import rostest
from std_srvs.srv import SetBool

from pioneer_control.bags.reader import decode, read_bag
from pioneer_control.bags.replaying.commands import aside, is_command
from pioneer_control.bags.replaying.programs import connected, graph
from pioneer_control.message_values import GripCommand
from pioneer_control.msg import Decision, GripperState
from witness import PATIENCE, wait_until

ROBOT_NODES = "/pioneer/p2os", "/pioneer/simulator"
PLAYER = "/play_bag"
WANDER = 6  # s
SEED, SPEED = 7, 0.3
FAST = "-r 4"
LAST_TOPIC = "/rosout"
"""The recorder subscribes to its topics one after another, in the order of config/record.yaml. This is the last one."""
RENUMBERED = {"/rosout": 4}
"""Bytes at the begin of messages that rosbag play writes anew.

They are the header.seq of the one topic on which the player says something itself.
"""


def end(process):
    """Send Ctrl-C to a program, and wait for its end."""
    process.send_signal(signal.SIGINT)
    process.wait(PATIENCE)


def record(bag):
    """Record a seeded wander, from its first message to after its last.

    Returns how many decisions were published: a second subscriber hears it from the number of the last one.
    """
    numbers, ended = deque(maxlen=1), threading.Event()
    subscribers = [
        rospy.Subscriber("/pioneer/decision", Decision, lambda m: numbers.append(m.header.seq)),
        rospy.Subscriber("/pioneer/gripper_control", GripperState,
                         lambda m: m.grip.state == GripCommand.CLOSE and ended.set())]
    recorder = subprocess.Popen(["roslaunch", "pioneer_control", "record.launch", "bag:=%s" % bag],
                                stdout=subprocess.DEVNULL)
    program = None
    try:
        master = rosgraph.Master(rospy.get_name())
        wait_until("the recorder listens to all", lambda: {"/pioneer/decision", LAST_TOPIC} <= {
            topic for topic, nodes in master.getSystemState()[1] if "/pioneer/recorder" in nodes})
        for name, value in (("duration", WANDER), ("seed", SEED), ("speed", SPEED), ("stop_at_can", False)):
            rospy.set_param("/rosPioneer2/%s" % name, value)
        program = subprocess.Popen(["rosrun", "pioneer_control", "rosPioneer2.py"])
        assert ended.wait(PATIENCE), "the wander does not end"  # the pick after it closes the paddles
    finally:
        if program:
            end(program)
        end(recorder)
        for subscriber in subscribers:
            subscriber.unregister()
    return numbers[-1]


def headers_in(bag, name):
    """Return the headers of the messages of a topic of the robot, in their order."""
    return [decode(connection, data).header
            for _, connection, data, _ in read_bag(bag, lambda connection: connection.topic == "/pioneer/" + name)]


class Replay(unittest.TestCase):
    """The recording is made once, for all tests."""

    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.bag = os.path.join(cls.folder.name, "run.bag")
        cls.decisions = record(cls.bag)
        rosnode.kill_nodes(ROBOT_NODES)
        wait_until("the robot is gone", lambda: not set(ROBOT_NODES) & set(rosnode.get_node_names()))
        rospy.delete_param("/rosPioneer2")

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def test_1_every_message_comes_back_bit_for_bit_and_in_order(self):
        """Checks all topics. Each message comes on its own topic. A command comes on the topic that no driver obeys."""
        expected = defaultdict(list)
        for topic, connection, data, _ in read_bag(self.bag):
            expected[aside(topic) if is_command(topic, connection.type) else topic].append(data)
        self.assertLessEqual({"/pioneer/recorded/cmd_vel", "/pioneer/recorded/cmd_motor_state",
                              "/pioneer/recorded/gripper_control", "/pioneer/pose",
                              "/pioneer/sonar", "/pioneer/robot_info", "/pioneer/map", "/pioneer/decision", "/tf",
                              "/rosout"}, set(expected))
        heard = defaultdict(list)
        count = threading.Semaphore(0)

        def hear(message, topic):
            own = topic == "/rosout" and PLAYER.encode() in message._buff     # what the player says itself
            if message._connection_header["callerid"] == PLAYER and not own:
                heard[topic].append(message._buff)
                count.release()

        listening = [*expected,
                     *("/pioneer/%s" % name
                       for name in ("cmd_vel", "cmd_wheels", "cmd_motor_state", "gripper_control"))]
        subscribers = [rospy.Subscriber(topic, rospy.AnyMsg, hear, topic) for topic in listening]
        player = subprocess.Popen(["roslaunch", "pioneer_control", "replay.launch", "bag:=%s" % self.bag,
                                   "options:=%s --pause --quiet --keep-alive" % FAST],
                                  stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL)
        rospy.wait_for_service(PLAYER + "/pause_playback", PATIENCE)
        wait_until("all is published", lambda: set(expected) <= {
            topic for topic, names in graph()[0].items() if PLAYER in names})
        wait_until("all is connected", lambda: connected(PLAYER, rospy.get_name(), expected))
        rospy.ServiceProxy(PLAYER + "/pause_playback", SetBool)(False)
        for _ in range(sum(map(len, expected.values()))):
            self.assertTrue(count.acquire(timeout=PATIENCE),
                            {topic: (len(expected[topic]), len(heard[topic])) for topic in expected})
        player.send_signal(signal.SIGINT)   # one that ends by itself loses what it has not sent yet on a busy machine
        player.wait(PATIENCE)
        rospy.delete_param("/use_sim_time")
        for subscriber in subscribers:
            subscriber.unregister()
        self.assertEqual({topic: len(data) for topic, data in heard.items()},
                         {topic: len(data) for topic, data in expected.items()})
        for topic, data in expected.items():
            cut = RENUMBERED.get(topic, 0)
            self.assertTrue([each[cut:] for each in heard[topic]] == [each[cut:] for each in data],
                            "%s is not what was recorded" % topic)

    def test_2_all_that_was_decided_is_in_the_bag(self):
        headers = headers_in(self.bag, "decision")
        self.assertEqual([header.seq for header in headers], list(range(1, self.decisions + 1)))
        decided = [header.stamp.to_sec() for header in headers]
        heard = [header.stamp.to_sec() for header in headers_in(self.bag, "sonar")]
        self.assertEqual(decided, [each for each in heard if decided[0] <= each <= decided[-1]], "one for each message")
        after = next(each for each in heard if each > decided[-1])
        self.assertGreater(after - decided[0], WANDER - 0.001, "the first message without one is after the end")

    def rerun(self, *arguments):
        """Return the output of the re-run, and its exit code."""
        command = ["rosrun", "pioneer_control", "replay", "rerun", self.bag, "--options=%s" % FAST, *arguments]
        done = subprocess.run(command, timeout=3 * PATIENCE, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE)
        return done.stdout.decode(), done.returncode

    def test_3_a_pioneer_decides_the_same_again(self):
        said, code = self.rerun()
        self.assertIn("%s decisions live, %s in the re-run: every one is the same." % (self.decisions, self.decisions),
                      said)
        self.assertIn("commands THE SAME", said)
        self.assertEqual(code, 0)
        self.assertEqual(len(headers_in(self.bag[:-4] + "-rerun.bag", "decision")), self.decisions)
        self.assertFalse(rospy.get_param("/use_sim_time", False), "it leaves the time as it was")
        self.assertFalse(rospy.has_param("/rosPioneer2"), "it leaves no parameters")

    def test_4_another_seed_is_seen(self):
        said, code = self.rerun("--args=pioneer _seed:=8", "--output=" + self.bag[:-4] + "-other.bag")
        self.assertIn("%s decisions live" % self.decisions, said)
        self.assertIn("They differ from number 1 on", said)
        self.assertIn("seed was 7, and is 8", said)
        self.assertIn("commands SOMETHING ELSE", said)
        self.assertEqual(code, 1)


if __name__ == "__main__":
    rospy.init_node("bag_replay_test")
    rostest.rosrun("pioneer_control", "bag_replay", Replay)
