#!/usr/bin/python3
"""Every message that was published is in the bag.

Messages are counted by sequence numbers, by a second subscriber, and by what went over the robots' lines.

The robots' cables are pulled while recorders and a witness connect, so that all of them hear from the same packet on.
Their drivers end before the recorders do. One recorder writes parts, with both robots in them and one that nobody has.
Another recorder is killed.
"""

import collections
import glob
import itertools
import math
import os
import signal
import subprocess
import tempfile
import threading
import time
import unittest
import xmlrpc.client

import rosgraph
import rosnode
import rospy
import rostest
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from std_srvs.srv import SetBool, Trigger

from pioneer_control import p2os
from pioneer_control.bags.command_line import in_order
from pioneer_control.bags.reader import decode, read_bag
from pioneer_control.bags.recording.description import description_of
from pioneer_control.p2os.recording import entries
from pioneer_control.srv import AddFault
from witness import PATIENCE, wait_until

ROBOTS = "robot1", "robot2"
OF_EVERY_PACKET = ("pose", "joint_states", "motor_state", "battery_state", "battery", "stall", "gripper_state", "dio",
                   "aio")
NUMBERED = "pose", "sonar", "joint_states", "battery_state", "battery", "stall", "ground_truth"
"""Topics whose messages have a header, with a number that the publisher counts."""
LATCHED = "robot_info", "recording", "e_stop", "p2os/parameter_updates"
ONCE = "/map", "/world", "/robot1/e_stop", "/robot2/e_stop"
"""Topics that latch, on which nothing more is published during the run."""
SHORTEST_SIP = 35
"""Bytes of a SIP without sonar readings are more than this."""


# The checks

def holes(numbers):
    """Return (before, after) for each place where sequence numbers are missing or out of order."""
    return [(one, other) for one, other in zip(numbers, numbers[1:]) if other != one + 1]


def within(part, whole):
    """Return whether a list is a part of another list, without any gap."""
    part, whole = list(part), list(whole)
    return any(whole[start:start + len(part)] == part for start in range(len(whole) - len(part) + 1))


def way(places):
    """Return the places from the last one before the first change to the first one after the last change. Empty if
    nothing changes.
    """
    changes = [number for number, (one, other) in enumerate(zip(places, places[1:])) if one != other]
    return places[changes[0]:changes[-1] + 2] if changes else []


def steps(places):
    """Return for each two neighbouring places whether they differ. Two reports of one motion give the same, whatever
    their units are.
    """
    return [one != other for one, other in zip(places, places[1:])]


def agree(recorded, sent, most_lost):
    """Return whether the bag has the way that was sent on the line, but for so many packets at most."""
    lost = len(sent) - len(recorded)
    return 0 <= lost <= most_lost and any(
        steps([place for number, place in enumerate(sent) if number not in left_out]) == steps(recorded)
        for left_out in itertools.combinations(range(len(sent)), lost))


def sips_on_the_wire(lines, robot):
    """Yield the place (raw) of each SIP that a robot's client got, from the record of the lines."""
    decoder = p2os.FrameDecoder()
    for entry in entries(lines):
        if entry.robot == robot and not entry.to_robot and entry.data:
            for packet in map(p2os.decode_packet, decoder.feed(entry.data)):
                if isinstance(packet, p2os.Sip):
                    yield packet.x_counts, packet.y_counts, packet.heading_units


class Checks(unittest.TestCase):
    """The checks of this file find the errors that they are for."""

    def test_a_missing_number_is_found(self):
        self.assertEqual(holes([4, 5, 6]), [])
        self.assertEqual(holes([4, 6, 7]), [(4, 6)])
        self.assertEqual(holes([4, 4, 5]), [(4, 4)])
        self.assertEqual(holes([5, 4]), [(5, 4)])

    def test_a_list_with_something_left_out_is_no_piece(self):
        self.assertTrue(within("bc", "abcd"))
        self.assertFalse(within("bd", "abcd"))
        self.assertFalse(within("abcd", "bc"))

    def test_a_report_that_is_missing_changes_the_way(self):
        whole = [0, 0, 0, 1, 2, 2, 3, 3, 3]
        self.assertEqual(way(whole), [0, 1, 2, 2, 3])
        self.assertEqual(steps(way(whole)), steps(way([10 * place for place in whole[1:-1]])),
                         "what is missing outside, and the unit, do not matter")
        for number in range(3, 6):
            self.assertNotEqual(steps(way(whole)), steps(way(whole[:number] + whole[number + 1:])))
        self.assertEqual(way([1, 1]), [])

    def test_a_report_may_be_missing_only_where_the_driver_lost_one(self):
        whole, other = [0, 1, 2, 2, 3], [0, 10, 20, 30]
        self.assertTrue(agree([10 * place for place in whole], whole, 0))
        self.assertFalse(agree(whole[:2] + whole[3:], whole, 0))
        self.assertTrue(agree(other, whole, 1))
        self.assertFalse(agree([0, 0, 10, 10], whole, 1), "another way")
        self.assertFalse(agree(whole + [4], whole, 1), "more than was sent")


class Witness:
    """A second subscriber. It keeps the bytes of all messages in the order of arrival."""

    def __init__(self, topics):
        self.heard = {topic: [] for topic in topics}
        self.subscribers = [rospy.Subscriber(topic, rospy.AnyMsg, self._keep, topic) for topic in topics]

    def _keep(self, message, topic):
        self.heard[topic].append(message._buff)

    def pose(self, robot):
        """Return the newest pose."""
        return Odometry().deserialize(self.heard["/%s/pose" % robot][-1])

    def forget(self):
        for kept in self.heard.values():
            kept.clear()


def destinations(node, topic):
    """Return the names of the nodes to which a node sends a topic, as the node itself reports."""
    uri = rosgraph.Master("/bag_record").lookupNode(node)
    _, _, connections = xmlrpc.client.ServerProxy(uri).getBusInfo("/bag_record")
    return {connection[1] for connection in connections if connection[2] == "o" and connection[4] == topic}


class Record(unittest.TestCase):
    """One run that is recorded twice."""

    @classmethod
    def setUpClass(cls):
        rospy.init_node("bag_record", disable_signals=True)
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = folder.name
        cls.stem, cls.killed = os.path.join(folder.name, "parts"), os.path.join(folder.name, "killed")
        cls.witness = Witness(["/%s/%s" % (robot, name) for robot in ROBOTS for name in OF_EVERY_PACKET])
        wait_until("both robots are there, and heard", lambda: all(cls.witness.heard.values()))
        cls.record()
        cls.parts = in_order(glob.glob(cls.stem + "_*.bag*"))
        cls.messages = list(read_bag(cls.parts))
        cls.by_topic = collections.defaultdict(list)
        for message in cls.messages:
            cls.by_topic[message.topic].append(message)

    @classmethod
    def start(cls, name, *arguments):
        """Start a recorder in a session of its own, as if it had a terminal of its own. Its output goes to a log file.
        """
        log = open(os.path.join(cls.folder, name + ".log"), "w")
        cls.addClassCleanup(log.close)
        process = subprocess.Popen(arguments, cwd=cls.folder, env=dict(os.environ, PWD=cls.folder), stdout=log,
                                   stderr=log, start_new_session=True)
        cls.addClassCleanup(lambda: process.poll() is None and os.killpg(process.pid, signal.SIGKILL))
        return process

    @classmethod
    def refused(cls, *arguments):
        """Run a recorder that refuses to start. Returns the ended process, with its error output."""
        return subprocess.run(["rosrun", "pioneer_control", "record", *arguments], cwd=cls.folder,
                              stderr=subprocess.PIPE, universal_newlines=True)

    @classmethod
    def record(cls):
        """Drive both robots, and record this into the bags."""
        rospy.wait_for_service("/simulator/add_fault", PATIENCE)
        cls.addClassCleanup(os.remove, rospy.get_param("/simulator/record"))
        cls.pull_cables()
        cls.witness.forget()
        parts = cls.start("parts", "roslaunch", "pioneer_control", "record.launch", "robots:=robot1, robot2 nobody",
                          "bag:=parts", "split:=6s")
        killed = cls.start("killed", "rosrun", "pioneer_control", "record", "robot1", "--bag=killed.bag",
                           "__name:=killed")
        recorders = "/robot1/recorder", "/robot1/killed"
        for robot in ROBOTS:
            for name in OF_EVERY_PACKET:
                wanted = set(recorders if robot == "robot1" else recorders[:1]) | {"/bag_record"}
                wait_until("all hear %s's %s" % (robot, name),
                           lambda: wanted <= destinations("/%s/p2os" % robot, "/%s/%s" % (robot, name)))
        cls.second = cls.refused("robot1")
        assert rospy.ServiceProxy("/simulator/clear_faults", Trigger)().success
        wait_until("the robots are back", lambda: all(cls.witness.heard["/%s/pose" % robot] for robot in ROBOTS))
        cls.drive(0.3)
        cls.kill(killed)
        cls.drive(0.1)
        wait_until("it is said that nobody is there", lambda: "nothing is published under /nobody" in cls.log("parts"))
        cls.pull_cables()
        rosnode.kill_nodes(["/%s/p2os" % robot for robot in ROBOTS])
        wait_until("the drivers are gone",
                   lambda: not any(subscriber.get_num_connections() for subscriber in cls.witness.subscribers))
        os.killpg(parts.pid, signal.SIGINT)
        parts.wait(PATIENCE)

    @classmethod
    def log(cls, name):
        with open(os.path.join(cls.folder, name + ".log")) as file:
            return file.read()

    @classmethod
    def pull_cables(cls):
        """Pull both cables: the robots send nothing any more. Wait until the last message has come."""
        for robot in "12":
            assert rospy.ServiceProxy("/simulator/add_fault", AddFault)("cable robot " + robot).success

        def silent():
            before = {topic: len(kept) for topic, kept in cls.witness.heard.items()}
            time.sleep(1.0)
            return before == {topic: len(kept) for topic, kept in cls.witness.heard.items()}
        wait_until("the robots are silent", silent)

    @classmethod
    def drive(cls, distance):
        """Drive both robots on curves, from rest to rest."""
        ended = threading.Event()
        publishers = [rospy.Publisher("/%s/cmd_vel" % robot, Twist, queue_size=1) for robot in ROBOTS]

        def command():
            while not ended.wait(0.1):
                for publisher in publishers:
                    twist = Twist()
                    twist.linear.x, twist.angular.z = 0.2, 0.3
                    publisher.publish(twist)

        start = {robot: cls.witness.pose(robot).pose.pose.position.x for robot in ROBOTS}
        for robot in ROBOTS:
            switch_on = rospy.ServiceProxy("/%s/set_motors" % robot, SetBool)
            wait_until("%s's motors are on" % robot, lambda: switch_on(True).success)
        thread = threading.Thread(target=command)
        thread.start()
        try:
            wait_until("both have driven",
                       lambda: all(abs(cls.witness.pose(robot).pose.pose.position.x - x) > distance
                                   for robot, x in start.items()))
        finally:
            ended.set()
            thread.join()
        sent = {robot: cls.witness.pose(robot).header.seq for robot in ROBOTS}

        def stands(robot):
            pose = cls.witness.pose(robot)
            return pose.header.seq > sent[robot] + 10 and pose.twist.twist.linear.x == 0.0

        wait_until("both stand", lambda: all(map(stands, ROBOTS)))

    @classmethod
    def kill(cls, process):
        """Kill the recorder itself. The started program has become the recorder."""
        process.send_signal(signal.SIGKILL)
        process.wait(PATIENCE)
        wait_until("its attendant has said so", lambda: "the recorder was killed" in cls.log("killed"))

    # What must be so

    def holes(self, messages):
        """Return the missing sequence numbers in a list of messages: (topic, publisher, before, after).

        Latched topics are left out: their publisher also counts the message that each new subscriber gets.
        """
        numbered = {"/%s/%s" % (robot, name) for robot in ROBOTS for name in NUMBERED} | {"/diagnostics"}
        numbers = collections.defaultdict(list)
        for message in messages:
            if message.topic in numbered:
                numbers[message.topic, message.connection.caller].append(
                    decode(message.connection, message.data).header.seq)
        self.assertLessEqual(numbered, {topic for topic, _ in numbers})
        return [(*key, *hole) for key, found in numbers.items() for hole in holes(found)]

    def differing(self, messages):
        """Return the topics of which a list of messages does not have exactly what the witness heard."""
        recorded = collections.defaultdict(list)
        for message in messages:
            recorded[message.topic].append(message.data)
        return [topic for topic, heard in self.witness.heard.items() if recorded[topic] != heard]

    def not_once(self, messages):
        """Return the topics of `ONCE` of which a list of messages does not have exactly one."""
        counts = collections.Counter(message.topic for message in messages)
        return [topic for topic in ONCE if counts[topic] != 1]

    def most_lost(self, robot):
        """Return how many packets at most the driver of a robot gave up, since the rest of one did not come in time.

        A busy machine holds the simulated robot up in the midst of a packet. The driver counts the bytes.
        """
        stray = max(int(value.value) for message in self.by_topic["/diagnostics"]
                    for status in decode(message.connection, message.data).status if robot in status.name
                    for value in status.values if value.key == "Stray bytes")
        return math.ceil(stray / SHORTEST_SIP)

    def ways(self, messages, number):
        """Return the motion of a robot twice: from a list of messages, and from the bytes on its line."""
        poses = [decode(message.connection, message.data).pose.pose
                 for message in messages if message.topic == "/robot%s/pose" % number]
        with open(rospy.get_param("/simulator/record")) as file:
            sent = way(list(sips_on_the_wire(file, number)))
        return way([(pose.position.x, pose.position.y, pose.orientation.z, pose.orientation.w) for pose in poses]), sent

    def test_no_sequence_number_is_missing(self):
        self.assertEqual(self.holes(self.messages), [])

    def test_the_bag_has_what_a_second_subscriber_heard_byte_by_byte(self):
        self.assertEqual(self.differing(self.messages), [])
        for robot in ROBOTS:
            counts = {name: len(self.by_topic["/%s/%s" % (robot, name)]) for name in OF_EVERY_PACKET}
            self.assertEqual(len(set(counts.values())), 1, "each packet has a message on each topic: %s" % counts)

    def test_the_bag_has_a_message_for_each_packet_on_the_line(self):
        for number, robot in enumerate(ROBOTS, 1):
            recorded, sent = self.ways(self.messages, number)
            self.assertGreater(len(recorded), 30)
            self.assertTrue(agree(recorded, sent, self.most_lost(robot)), (recorded, sent, self.most_lost(robot)))
            transforms = [decode(message.connection, message.data).transforms[0] for message in self.by_topic["/tf"]]
            stamps = [decode(message.connection, message.data).header.stamp
                      for message in self.by_topic["/%s/pose" % robot]]
            self.assertEqual([transform.header.stamp for transform in transforms
                              if transform.child_frame_id == robot + "/base_link"], stamps)
            print("%s: %s packets on the line and %s poses in the bag from its first movement to its last; %s poses "
                  "in all, in %s parts" % (robot, len(sent), len(recorded), len(stamps), len(self.parts)))

    def test_a_message_that_is_missing_is_found_by_each_of_these(self):
        moving = self.by_topic["/robot1/pose"]
        lost = moving[len(moving) // 2]
        rest = [message for message in self.messages if message is not lost]
        self.assertEqual([hole[:2] for hole in self.holes(rest)], [("/robot1/pose", "/robot1/p2os")])
        self.assertEqual(self.differing(rest), ["/robot1/pose"])
        self.assertEqual(len(self.ways(rest, 1)[0]), len(self.ways(self.messages, 1)[0]) - 1)

    def test_each_part_has_what_is_latched(self):
        self.assertGreater(len(self.parts), 1)
        self.assertEqual([os.path.basename(path) for path in self.parts],
                         ["parts_%s.bag" % number for number in range(len(self.parts))])
        for path in self.parts:
            there = {message.topic for message in read_bag(path)}
            self.assertLessEqual({"/%s/%s" % (robot, name) for robot in ROBOTS for name in LATCHED} |
                                 {"/tf_static", "/map", "/world"}, there)
        self.assertEqual([message.topic for message in self.messages if not message.connection.caller], [],
                         "read together they have what was published")
        self.assertEqual(self.not_once(self.messages), [], "and as often")
        self.assertEqual(self.not_once(self.messages + self.by_topic["/map"]), ["/map"], "a second delivery is found")

    def test_it_says_of_itself_who_was_there(self):
        made = [description_of(decode(message.connection, message.data).data)
                for message in self.by_topic["/robot2/recording"]]
        self.assertEqual({tuple(each.recording["robots"]) for each in made}, {("robot1", "robot2", "nobody")})
        told = {node for each in made for node in each.nodes}
        self.assertLessEqual({"/robot1/p2os", "/robot2/p2os", "/simulator", "/robot1/recorder"}, told)
        self.assertEqual(made[0].parameters_of("/robot2/p2os")["port"], rospy.get_param("/robot2/p2os/port"))

    def test_the_end_was_clean(self):
        self.assertFalse([path for path in self.parts if path.endswith(".active")])
        reader = read_bag(self.parts)
        self.assertTrue(list(reader))
        self.assertFalse(reader.damage)

    def test_a_killed_recorder_leaves_what_it_has_written(self):
        self.assertEqual(glob.glob(self.killed + ".bag*"), [self.killed + ".bag.active"])
        messages = list(read_bag(self.killed + ".bag.active"))
        recorded = [message.data for message in messages if message.topic == "/robot1/pose"]
        self.assertGreater(len(recorded), 0)
        self.assertTrue(within(recorded, self.witness.heard["/robot1/pose"]))
        self.assertEqual(recorded[0], self.witness.heard["/robot1/pose"][0])
        self.assertIn("rosbag reindex", self.log("killed"))

    def test_what_a_killed_recorder_left_is_not_overwritten(self):
        with open(self.killed + ".bag.active", "rb") as file:
            before = file.read()
        again = self.refused("robot1", "--bag=killed.bag", "__name:=again")
        self.assertEqual(again.returncode, 1)
        self.assertIn("killed.bag.active is there already", again.stderr)
        with open(self.killed + ".bag.active", "rb") as file:
            self.assertEqual(file.read(), before)

    def test_one_that_is_told_to_end_does_not_seem_killed(self):
        self.assertIn("topics into", self.log("parts"))
        self.assertNotIn("was killed", self.log("parts"))

    def test_a_closed_terminal_closes_the_bag(self):
        recorder = self.start("closed", "rosrun", "pioneer_control", "record", "robot1", "--bag=closed",
                              "__name:=closed")
        wait_until("it records", lambda: "topics into" in self.log("closed"))
        os.killpg(recorder.pid, signal.SIGHUP)
        self.assertEqual(recorder.wait(PATIENCE), 0)
        self.assertEqual([os.path.basename(path) for path in glob.glob(os.path.join(self.folder, "closed.bag*"))],
                         ["closed.bag"])

    def test_a_second_recorder_of_the_same_name_does_not_end_the_first(self):
        self.assertEqual(self.second.returncode, 1)
        self.assertIn("/robot1/recorder runs already", self.second.stderr)


if __name__ == "__main__":
    rostest.rosrun("pioneer_control", "bag_record", "__main__")
