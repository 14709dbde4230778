#!/usr/bin/python3
"""Programs and persons command one robot: each is a process of its own, in each order, and each is lost once."""

import os
import subprocess
import sys
import unittest

import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticArray
from nav_msgs.msg import Odometry
from std_msgs.msg import Bool
from std_srvs.srv import SetBool, Trigger

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

from pioneer_control.msg import Helm
from witness import PATIENCE, Witness, wait_until

PROGRAM, PERSON = 0.3, 0.1      # m/s
TOPICS = {"pioneer/ground_truth": Odometry, "other/ground_truth": Odometry, "pioneer/helm": Helm, "other/helm": Helm,
          "/diagnostics": DiagnosticArray}


class Commanders:
    """Processes that publish one velocity at 10 Hz each."""

    def __init__(self):
        self._running = {}

    def start(self, topic, speed):
        self._running[topic] = subprocess.Popen(
            ["rostopic", "pub", "-r", "10", topic, "geometry_msgs/Twist", "{linear: {x: %g}}" % speed],
            stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL)

    def kill(self, topic):
        process = self._running.pop(topic)
        process.kill()
        process.wait()

    def kill_all(self):
        for topic in list(self._running):
            self.kill(topic)


class PersonAndProgram(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        cls.witness = Witness(TOPICS)
        cls.lock = rospy.Publisher("pioneer/stop_all", Bool, queue_size=1, latch=True)
        cls.services = {}
        for robot in ("pioneer", "other"):
            for name, kind in (("set_motors", SetBool), ("teleop/release", Trigger)):
                rospy.wait_for_service("%s/%s" % (robot, name), PATIENCE)
                cls.services[robot, name] = rospy.ServiceProxy("%s/%s" % (robot, name), kind)
            cls.witness.last(robot + "/ground_truth")
            wait_until("motors are on", lambda: cls.services[robot, "set_motors"](True).success)

    def setUp(self):
        self.commanders = Commanders()
        self.addCleanup(self.commanders.kill_all)
        for robot in ("pioneer", "other"):
            self.services[robot, "teleop/release"]()

    def drives(self, speed, robot="pioneer"):
        """Wait until the robot really has this speed, in ten messages one after the other."""
        self.witness.next(robot + "/ground_truth")

        def steady():
            newest = self.witness.seen[robot + "/ground_truth"][-10:]
            return all(abs(message.twist.twist.linear.x - speed) < 0.01 for message in newest)

        self.witness.wait("%s drives %.1f m/s" % (robot, speed), steady)

    def helm(self, commander, locked_out, robot="pioneer"):
        self.witness.wait("%r commands" % commander, lambda: (
            self.witness.seen[robot + "/helm"] and self.witness.seen[robot + "/helm"][-1].commander == commander
            and self.witness.seen[robot + "/helm"][-1].programs_locked_out == locked_out))

    def test_a_program_first_then_a_person_who_is_lost_then_a_release(self):
        self.commanders.start("pioneer/cmd_vel", PROGRAM)
        self.drives(PROGRAM)
        self.helm("cmd_vel", False)
        self.commanders.start("pioneer/teleop/cmd_vel", PERSON)
        self.drives(PERSON)
        self.helm("teleop/cmd_vel", True)
        self.assertTrue(self.witness.seen["pioneer/helm"][-1].node.startswith("/rostopic"))
        self.commanders.kill("pioneer/teleop/cmd_vel")
        self.drives(0.0)
        self.helm("", True)
        self.assertTrue(self.services["pioneer", "teleop/release"]().success)
        self.drives(PROGRAM)

    def test_a_person_first_then_a_program_that_is_lost(self):
        self.commanders.start("pioneer/teleop/cmd_vel", PERSON)
        self.drives(PERSON)
        self.commanders.start("pioneer/cmd_vel", PROGRAM)
        self.drives(PERSON)
        self.commanders.kill("pioneer/cmd_vel")
        self.drives(PERSON)

    def test_the_lock_stays_when_who_set_it_is_gone(self):
        self.commanders.start("pioneer/cmd_vel", PROGRAM)
        self.drives(PROGRAM)
        subprocess.run(["rostopic", "pub", "-1", "pioneer/stop_all", "std_msgs/Bool", "true"],
                       stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, timeout=PATIENCE, check=True)
        self.drives(0.0)
        self.assertEqual(self.witness.last("pioneer/helm").locks, ["stop_all"])
        answer = self.services["pioneer", "set_motors"](True)
        self.assertFalse(answer.success)
        self.assertIn("stop_all is set", answer.message)
        self.lock.publish(False)
        self.drives(PROGRAM)
        self.assertEqual(self.witness.last("pioneer/helm").locks, [])

    def test_topics_of_other_drivers_and_a_lock_for_all_by_remapping(self):
        self.commanders.start("/RosAria/cmd_vel", PROGRAM)
        self.drives(PROGRAM, "other")
        self.commanders.start("/joy_teleop/cmd_vel", PERSON)
        self.drives(PERSON, "other")
        lock_all = rospy.Publisher("/stop_all", Bool, queue_size=1, latch=True)
        lock_all.publish(True)
        self.drives(0.0, "other")
        lock_all.publish(False)
        self.drives(PERSON, "other")

    def test_diagnostics_say_who_commands(self):
        def newest():
            for message in reversed(self.witness.seen["/diagnostics"]):
                for status in message.status:
                    if status.name == "pioneer/p2os: Helm":
                        return status
            return None

        self.commanders.start("pioneer/teleop/cmd_vel", 0.0)
        self.witness.wait("a person commands", lambda: newest() and "a person commands" in newest().message)
        self.commanders.kill("pioneer/teleop/cmd_vel")
        self.witness.wait("a person has the helm", lambda: "a person has the helm" in newest().message)


if __name__ == "__main__":
    rospy.init_node("driver_helm")
    rostest.rosrun("pioneer_control", "driver_helm", PersonAndProgram)
