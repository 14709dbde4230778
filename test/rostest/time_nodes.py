#!/usr/bin/python3
"""Every node that runs beside a robot, in simulated time: before time begins, while it stands, when it runs fast, and
when it jumps back.
"""

import math
import signal
import subprocess
import unittest

import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Log
from std_msgs.msg import Bool
from std_srvs.srv import SetBool

from clock import Time
from pioneer_control.msg import Decision, MotorState
from witness import PATIENCE, Witness, wait_until

TRUTH, POSE, COMMANDS, DECISIONS, MOTORS = (
    "pioneer/" + name for name in ("ground_truth", "pose", "cmd_vel", "decision", "motor_state"))
TOPICS = {TRUTH: Odometry, POSE: Odometry, COMMANDS: Twist, DECISIONS: Decision, MOTORS: MotorState, "/rosout": Log,
          "/diagnostics": DiagnosticArray}
SIMPLE = ["rosrun", "pioneer_control", "rosPioneer1.py"]
ADVANCED = ["rosrun", "pioneer_control", "rosPioneer2.py"]


class TimeNodes(unittest.TestCase):
    """One robot, and one clock that begins late."""

    @classmethod
    def setUpClass(cls):
        cls.witness, cls.time = Witness(TOPICS), Time()
        cls.velocity = rospy.Publisher(COMMANDS, Twist, queue_size=1)
        cls.witness.last(TRUTH)
        cls.witness.last(POSE)
        cls.witness.wait("the driver listens", lambda: cls.velocity.get_num_connections() > 1)

    def setUp(self):
        self.first_command = len(self.witness.seen[COMMANDS])

    def start(self, command):
        """Start a program and keep its output. The program ends with the test."""
        self.first_word = len(self.witness.seen["/rosout"])
        program = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, universal_newlines=True)
        self.addCleanup(program.stdout.close)
        self.addCleanup(program.wait)
        self.addCleanup(program.kill)
        return program

    def wait_for_word(self, word):
        self.witness.wait(word,
                          lambda: any(word in each.msg for each in self.witness.seen["/rosout"][self.first_word:]))

    def given(self):
        return [(each.linear.x, each.angular.z) for each in self.witness.seen[COMMANDS][self.first_command:]]

    def wait_until_it_drives(self):
        begun = len(self.given())
        self.witness.wait("it commands", lambda: any(linear or angular for linear, angular in self.given()[begun:]))
        self.witness.wait("the robot drives", lambda: self.rates() != (0.0, 0.0))

    def wait_until_it_stands(self):
        self.witness.wait("the robot stands", lambda: self.rates() == (0.0, 0.0))

    def rates(self):
        twist = self.witness.seen[TRUTH][-1].twist.twist
        return twist.linear.x, twist.angular.z

    def told_nothing_for_a_second(self):
        told = len(self.given())
        self.witness.next(TRUTH, 10)
        return self.given()[told:] == [] and self.rates() == (0.0, 0.0)

    def ends_at_ctrl_c(self, program):
        program.send_signal(signal.SIGINT)
        output, _ = program.communicate(timeout=PATIENCE)
        self.assertNotIn("Traceback", output)
        return output

    def test_1_before_time_begins_the_driver_works(self):
        """Stamps are zero, velocities time out as always, and diagnostics are published."""
        rospy.wait_for_service("pioneer/set_motors", PATIENCE)
        self.assertTrue(rospy.ServiceProxy("pioneer/set_motors", SetBool)(True).success)
        command = Twist()
        command.angular.z = 0.5
        self.velocity.publish(command)
        self.witness.wait("the robot drives", lambda: self.rates()[1] > 0)
        self.wait_until_it_stands()     # nobody told it: the velocity was good for 0.6 s
        for topic in (POSE, TRUTH):
            self.assertEqual(self.witness.next(topic).header.stamp, rospy.Time(0))
        self.assertEqual(self.witness.next("/diagnostics", 3).header.stamp, rospy.Time(0))

    def test_2_before_time_begins_programs_say_what_they_wait_for(self):
        """Ctrl-C ends the programs."""
        for command in (SIMPLE, ADVANCED):
            self.assert_waits(command)

    def test_3_while_time_stands_nobody_drives(self):
        """The wander runs under a clock that stands, runs, stands, jumps back and runs fast. It sends no more commands
        than needed.
        """
        self.time.rate = 0.0
        self.assert_waits(SIMPLE)
        program = self.start(ADVANCED + ["_duration:=1000", "_stop_at_can:=false", "_seed:=1"])
        self.wait_for_word("stopped: no news")
        self.wait_until_it_stands()
        self.time.rate = 1.0
        self.wait_until_it_drives()
        self.time.rate = 0.0
        self.witness.wait("told to stand", lambda: self.given()[-1] == (0.0, 0.0))
        self.wait_until_it_stands()
        decided = len(self.witness.seen[DECISIONS])
        self.assertTrue(any(self.told_nothing_for_a_second() for _ in range(5)))    # news may have been on their way
        self.assertGreater(len(self.witness.seen[DECISIONS]), decided)     # on each message, though none is sent
        self.time.now -= 500.0
        self.time.rate = 1.0
        self.witness.wait("it decides in the time that jumped back",
                          lambda: self.witness.seen[DECISIONS][-1].header.stamp.to_sec() < 900.0)
        self.wait_until_it_drives()
        self.time.rate = 10.0
        before = self.witness.seen[DECISIONS][-1].header.stamp.to_sec()
        self.witness.wait("it decides in fast time", lambda: (
            self.witness.seen[DECISIONS][-1].header.stamp.to_sec() > before + 20.0))
        self.wait_until_it_drives()
        self.ends_at_ctrl_c(program)
        self.witness.wait("told to stand", lambda: self.given()[-1] == (0.0, 0.0))
        self.wait_until_it_stands()

    def assert_waits(self, command):
        """Check that a program says what it waits for, sends no command, and ends at Ctrl-C."""
        program = self.start(command)
        self.wait_for_word("/clock")
        self.ends_at_ctrl_c(program)
        self.assertEqual(self.given(), [])

    def test_4_the_simple_node_drives_as_far_as_it_is_told_whatever_time_does(self):
        """It sends 10 commands a second for 4 s. Time waits for each command, so a busy machine changes nothing."""
        told_at = []

        def hear(message):
            if message.linear.x:
                told_at.append(self.time.passed)
                self.time.end = self.time.passed + 0.101

        commands = rospy.Subscriber(COMMANDS, Twist, hear)
        self.addCleanup(commands.unregister)
        self.addCleanup(setattr, self.time, "end", math.inf)
        self.time.rate = 0.01   # it takes nearly no time to start
        program = self.start_when_heard(SIMPLE + ["_duration:=4"], commands)
        self.witness.wait("it commands", lambda: told_at)
        self.time.rate = 1.0
        self.wait_until_it_drives()
        self.time.rate = 0.0
        self.wait_until_it_stands()
        self.time.now -= 100.0
        self.time.rate = 1.0
        self.wait_until_it_drives()
        self.time.rate = 10.0
        output, _ = program.communicate(timeout=PATIENCE)
        self.assertEqual(program.returncode, 0, output)
        self.assertNotIn("Traceback", output)
        self.witness.wait("told to stand", lambda: self.given()[-1] == (0.0, 0.0))
        self.assertEqual(len([each for each in self.given() if each == (0.1, 0.0)]), 40)
        self.assertGreaterEqual(self.time.passed - told_at[0], 4.0 - 0.2)   # the jump ends a tick early

    def start_when_heard(self, command, commands):
        """Start the simple node while the STOP button is pressed, so that the node waits. Release the button when the
        subscriber ``commands`` is connected to the node. So it hears the node's commands from the first one on.
        """
        def is_heard():
            return any(each.callerid_pub == "/rosPioneer1" and not each.done for each in commands.impl.connections)

        wait_until("no earlier one is left", lambda: not is_heard())
        button = rospy.Publisher("pioneer/stop_button", Bool, queue_size=1)
        wait_until("the robot has that button", button.get_num_connections)
        button.publish(True)
        self.witness.wait("motors off", lambda: not self.witness.seen[MOTORS][-1].state)
        program = self.start(command)
        wait_until("what it commands is heard", is_heard)
        button.publish(False)
        return program


if __name__ == "__main__":
    rospy.init_node("time_nodes_witness")
    rostest.rosrun("pioneer_control", "time_nodes", TimeNodes)
