#!/usr/bin/python3
"""A bag played beside a live robot moves it only where the driver was told to accept that,
and not even that one by replay.launch.

The two robots get the same commands from the same bag: that the trusting one drives shows that they were sent.
"""

import os
import signal
import subprocess
import sys
import tempfile
import threading
import unittest

import rospy
import rostest
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Log
from std_srvs.srv import SetBool

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "messages", "bags"))

import bag_factory as make
from pioneer_control.msg import GripperState, MotorState, WheelVelocities

PATIENCE = 40.0  # s
ROBOTS = "careful", "trusting"
GRIP_CLOSE = 2  # GripState.state of a command


class Witness:
    """Keeps the reports of all robots, and wakes the threads that wait for them."""

    def __init__(self):
        self.changed = threading.Condition()
        self.way = dict.fromkeys(ROBOTS, 0.0)  # m from where the robot was first seen
        self.speed = dict.fromkeys(ROBOTS)  # m/s
        self.places = {}
        self.motors = {robot: [] for robot in ROBOTS}
        self.paddles = {robot: [] for robot in ROBOTS}
        self.said = []
        for robot in ROBOTS:
            rospy.Subscriber("/%s/ground_truth" % robot, Odometry, self.see_place, robot)
            rospy.Subscriber("/%s/motor_state" % robot, MotorState,
                             lambda m, r=robot: self.keep(self.motors[r], m.state))
            rospy.Subscriber("/%s/gripper_state" % robot, GripperState,
                             lambda m, r=robot: self.keep(self.paddles[r], m.grip.state))
        rospy.Subscriber("/rosout", Log, lambda m: self.keep(self.said, (m.name, m.msg)))

    def keep(self, where, value):
        with self.changed:
            where.append(value)
            self.changed.notify_all()

    def see_place(self, message, robot):
        place = message.pose.pose.position
        with self.changed:
            first = self.places.setdefault(robot, place)
            self.way[robot] = max(self.way[robot], abs(place.x - first.x) + abs(place.y - first.y))
            self.speed[robot] = message.twist.twist.linear.x
            self.changed.notify_all()

    def wait(self, what, condition):
        """Wait until a condition holds. Raises AssertionError that names what did not happen."""
        with self.changed:
            assert self.changed.wait_for(condition, PATIENCE), "not within %.0f s: %s" % (PATIENCE, what)


def commands():
    """Yield what a recorder keeps of both robots: motors on, forward (by cmd_vel and by cmd_wheels), paddles closed."""
    for robot in ROBOTS:
        yield "/%s/cmd_motor_state" % robot, MotorState(1), 10.0
        for step in range(20):
            twist = Twist()
            twist.linear.x = 0.3
            yield "/%s/cmd_vel" % robot, twist, 10.5 + 0.1 * step
            yield "/%s/cmd_wheels" % robot, WheelVelocities(0.3, 0.3), 10.55 + 0.1 * step
        close = GripperState()
        close.grip.state = GRIP_CLOSE
        yield "/%s/gripper_control" % robot, close, 11.0


class BesideRobot(unittest.TestCase):
    """Both drivers, with the real rosbag play."""

    def setUp(self):
        self.witness = Witness()
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        motors = ["/%s/cmd_motor_state" % robot for robot in ROBOTS]
        self.bag = make.write_bag(os.path.join(self.folder.name, "commands.bag"), commands(), latched=motors)
        for robot in ROBOTS:
            self.witness.wait("%s is there" % robot, lambda r=robot: r in self.witness.places and
                              self.witness.motors[r])

    def play(self, *arguments):
        command = ["rosbag", "play", "--quiet", "--wait-for-subscribers", self.bag, *arguments]
        subprocess.run(command, check=True, timeout=PATIENCE, stdin=subprocess.DEVNULL)

    def heard_from(self, robot):
        """Wait for a motor_state that is sent after this call. Everything that was sent before has had its effect then.
        """
        count = len(self.witness.motors[robot]) + 5
        self.witness.wait("%s goes on reporting" % robot, lambda: len(self.witness.motors[robot]) >= count)

    def assert_untouched(self, robot):
        self.heard_from(robot)
        self.assertLess(self.witness.way[robot], 0.001)
        self.assertNotIn(GRIP_CLOSE, self.witness.paddles[robot])

    def test_1_motors_stay_off(self):
        """The careful driver refuses all commands and says so. The trusting driver obeys all of them."""
        self.play()
        self.witness.wait("trusting drives", lambda: self.witness.way["trusting"] > 0.2)
        self.witness.wait("trusting closes its paddles", lambda: GRIP_CLOSE in self.witness.paddles["trusting"])
        self.assertIn(1, self.witness.motors["trusting"])
        self.assert_untouched("careful")
        self.assertEqual(set(self.witness.motors["careful"]), {0})
        self.witness.wait("careful says why", lambda: any(
            name == "/careful/p2os" and "accept_replay" in text for name, text in self.witness.said))
        self.assertFalse([text for name, text in self.witness.said if name == "/trusting/p2os" and
                          "accept_replay" in text])

    def test_2_motors_that_are_on_do_not_obey_either(self):
        """The motors of the careful robot are already on when the bag is played."""
        rospy.wait_for_service("/careful/set_motors", PATIENCE)
        answer = rospy.ServiceProxy("/careful/set_motors", SetBool)(True)
        self.assertTrue(answer.success, answer.message)
        self.witness.wait("motors are on", lambda: self.witness.motors["careful"][-1] == 1)
        self.play()
        self.witness.wait("trusting drives", lambda: self.witness.way["trusting"] > 0.2)
        self.assert_untouched("careful")

    def test_3_a_bag_under_another_name_is_still_a_bag(self):
        """As in the test before, but the player uses another node name."""
        way = self.witness.way["trusting"]
        rospy.ServiceProxy("/careful/set_motors", SetBool)(True)
        self.play("__name:=somebody")
        self.witness.wait("trusting drives on", lambda: self.witness.way["trusting"] > way + 0.2)
        self.assert_untouched("careful")

    def launch(self, *arguments):
        """Start replay.launch with these arguments."""
        return subprocess.Popen(["roslaunch", "pioneer_control", "replay.launch", "bag:=%s" % self.bag, *arguments],
                                stdin=subprocess.DEVNULL)

    def motors_on(self):
        """Switch the motors of both robots on, while they stand. Then any velocity that reaches them would move them.
        """
        for robot in ROBOTS:
            self.witness.wait("%s stands" % robot, lambda r=robot: self.witness.speed[r] == 0.0)
            rospy.ServiceProxy("/%s/set_motors" % robot, SetBool)(True)
            self.witness.wait("motors of %s are on" % robot, lambda r=robot: self.witness.motors[r][-1] == 1)

    def assert_neither_moved(self, way):
        self.assert_untouched("careful")
        self.heard_from("trusting")
        self.assertEqual(self.witness.way["trusting"], way, "replay.launch moves nobody, whatever a driver accepts")

    def test_4_looking_moves_nobody(self):
        """The bag is played in a loop. Its commands go to topics that no driver subscribes to."""
        self.motors_on()
        way = self.witness.way["trusting"]
        said = {name: [] for name in ("cmd_vel", "cmd_wheels", "cmd_motor_state", "gripper_control")}
        for name, kept in said.items():
            rospy.Subscriber("/trusting/recorded/%s" % name, rospy.AnyMsg,
                             lambda m, kept=kept: self.witness.keep(kept, m))
        looking = self.launch("options:=-l -r 4 --quiet")
        self.witness.wait("the bag goes round", lambda: len(said["cmd_vel"]) > 50 and
                          all(len(each) > 2 for each in said.values()))
        looking.send_signal(signal.SIGINT)
        looking.wait(PATIENCE)
        self.assert_neither_moved(way)
        rospy.delete_param("/use_sim_time")

    def test_5_a_rerun_moves_nobody(self):
        """The re-run is refused: the program would hear the robot and the bag at once."""
        self.motors_on()
        way = self.witness.way["trusting"]
        command = ["rosrun", "pioneer_control", "replay", "rerun", self.bag]
        done = subprocess.run([*command, "--robot=trusting"], stdin=subprocess.DEVNULL, stderr=subprocess.PIPE,
                              timeout=PATIENCE)
        self.assertEqual(done.returncode, 2)
        self.assertIn("/careful/p2os (/careful/motor_state), /trusting/p2os (/trusting/motor_state) is on this master",
                      done.stderr.decode())
        self.assertIn("Choose one with robot:=NAME",
                      subprocess.run(command, stderr=subprocess.PIPE, timeout=PATIENCE).stderr.decode())
        self.assert_neither_moved(way)

    def test_6_a_redrive_moves_its_own_robot_only(self):
        """The re-drive starts a simulated robot of its own."""
        self.motors_on()
        way = self.witness.way["trusting"]
        moved = []
        rospy.Subscriber("/redrive/ground_truth", Odometry, lambda m: self.witness.keep(moved, m.pose.pose.position.x))
        driving = self.launch("way:=redrive", "robot:=trusting")
        self.witness.wait("the re-driven robot drives", lambda: moved and moved[-1] - moved[0] > 0.3)
        driving.wait(PATIENCE)
        self.assert_neither_moved(way)


if __name__ == "__main__":
    rospy.init_node("bag_beside_robot_witness")
    rostest.rosrun("pioneer_control", "bag_beside_robot", BesideRobot)
