#!/usr/bin/python3
"""`rosrun pioneer_control drive` on a real pseudo-terminal: it drives while a key is held, and whatever befalls it, the
robot stands and stays where it is.
"""

import contextlib
import math
import os
import pty
import signal
import subprocess
import sys
import threading
import time
import unittest

import rospy
import rostest
from nav_msgs.msg import Odometry
from std_msgs.msg import Bool
from std_srvs.srv import SetBool, Trigger

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

from pioneer_control.msg import Helm, MotorState
from witness import PATIENCE, Witness, wait_until

TOPICS = {"pioneer/ground_truth": Odometry, "pioneer/helm": Helm, "pioneer/motor_state": MotorState}
REPEAT = 0.05       # s between two repetitions of a held key
PRESS_AGAIN = 3.0   # s


class Terminal:
    """`drive` on a pseudo-terminal, and the finger on its keys."""

    def __init__(self):
        self.master, terminal = pty.openpty()
        self.process = subprocess.Popen(["rosrun", "pioneer_control", "drive", "--gamepad", "none"], stdin=terminal,
                                        stdout=terminal, stderr=terminal, start_new_session=True)
        os.close(terminal)
        self.said = ""
        self._held = None
        self._finger = threading.Lock()
        self._ended = threading.Event()
        for run in (self._listen, self._press):
            threading.Thread(target=run, daemon=True).start()

    def _listen(self):
        with contextlib.suppress(OSError):
            while True:
                self.said += os.read(self.master, 4096).decode(errors="replace")

    def _press(self):
        while not self._ended.wait(REPEAT):
            with self._finger:
                if self._held is not None:
                    self.type(self._held)

    def type(self, key):
        with contextlib.suppress(OSError):
            os.write(self.master, key.encode())

    def hold(self, key):
        self._held = key

    def let_go(self):
        """Type no more: a key that is just repeated comes before what is typed next."""
        with self._finger:
            self._held = None

    def close(self):
        self._ended.set()
        if self.process.poll() is None:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(self.process.pid, signal.SIGCONT)
                os.killpg(self.process.pid, signal.SIGKILL)
        self.process.wait()
        with contextlib.suppress(OSError):
            os.close(self.master)


class DriveByHand(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        cls.witness = Witness(TOPICS)
        cls.lock = rospy.Publisher("pioneer/stop_all", Bool, queue_size=1)
        rospy.wait_for_service("pioneer/set_motors", PATIENCE)
        cls.set_motors = rospy.ServiceProxy("pioneer/set_motors", SetBool)
        cls.release = rospy.ServiceProxy("pioneer/teleop/release", Trigger)
        cls.witness.last("pioneer/ground_truth")

    def setUp(self):
        self.terminal = Terminal()
        self.addCleanup(self.terminal.close)
        wait_until("drive shows the robot", lambda: "at most 0.2 m/s" in self.terminal.said)

    def speeds(self, wanted):
        """Wait until ten messages in a row have one of these speeds."""
        self.witness.next("pioneer/ground_truth")
        self.witness.wait("the robot drives %s m/s" % (wanted,), lambda: all(
            abs(message.twist.twist.linear.x - wanted) < 0.01
            for message in self.witness.seen["pioneer/ground_truth"][-10:]))

    def stays(self):
        """The robot stands, and is where it was after a second of messages."""
        self.speeds(0.0)
        before = self.witness.seen["pioneer/ground_truth"][-1].pose.pose.position.x
        self.assertAlmostEqual(self.witness.next("pioneer/ground_truth", 10).pose.pose.position.x, before, delta=0.001)

    def drives(self):
        wait_until("motors are on", lambda: self.set_motors(True).success)
        self.terminal.hold("w")
        self.speeds(0.2)

    def test_motors_by_their_key_then_a_held_key_drives_and_a_key_let_go_stops(self):
        self.set_motors(False)
        pressed = -math.inf

        def switched_on():
            """A busy ROS master may not say in time who asks. Then the driver refuses, and the key is pressed again."""
            nonlocal pressed
            on = self.witness.seen["pioneer/motor_state"][-1].state == 1
            if not on and time.monotonic() > pressed + PRESS_AGAIN:
                self.terminal.type("m")
                pressed = time.monotonic()
            return on

        wait_until("motors are on", switched_on)
        self.drives()
        self.assertEqual(self.witness.seen["pioneer/helm"][-1].commander, "teleop/cmd_vel")
        self.terminal.let_go()
        self.stays()
        self.assertTrue(self.witness.seen["pioneer/helm"][-1].programs_locked_out)
        self.terminal.type("r")
        self.witness.wait("released", lambda: not self.witness.seen["pioneer/helm"][-1].programs_locked_out)

    def test_the_space_bar_locks_while_a_key_is_held_and_u_unlocks(self):
        self.drives()
        self.terminal.type(" ")
        self.witness.wait("it is locked", lambda: self.witness.seen["pioneer/helm"][-1].locks == ["stop_all"])
        self.stays()
        wait_until("it says so", lambda: "LOCKED by stop_all (u unlocks)" in self.terminal.said)
        self.terminal.let_go()
        self.terminal.type("u")
        self.witness.wait("it is unlocked", lambda: not self.witness.seen["pioneer/helm"][-1].locks)
        self.stays()

    def test_the_program_is_killed(self):
        self.drives()
        os.killpg(self.terminal.process.pid, signal.SIGKILL)
        self.stays()

    def test_the_program_is_stopped_and_goes_on_with_all_that_was_typed_meanwhile(self):
        self.drives()
        os.killpg(self.terminal.process.pid, signal.SIGSTOP)
        self.stays()
        self.terminal.let_go()
        self.terminal.type("wwww")
        os.killpg(self.terminal.process.pid, signal.SIGCONT)
        self.stays()
        self.drives()       # and it still works

    def test_the_terminal_is_closed(self):
        self.drives()
        self.terminal._ended.set()
        os.close(self.terminal.master)
        self.stays()
        wait_until("drive ends", lambda: self.terminal.process.poll() is not None)

    def test_ctrl_c(self):
        self.drives()
        os.killpg(self.terminal.process.pid, signal.SIGINT)
        self.stays()
        wait_until("drive ends", lambda: self.terminal.process.poll() is not None)
        self.assertEqual(self.terminal.process.returncode, 0, self.terminal.said)
        self.assertIn("Programs stay locked out until: rosservice call /pioneer/teleop/release", self.terminal.said)


if __name__ == "__main__":
    rospy.init_node("drive_by_hand")
    rostest.rosrun("pioneer_control", "drive_by_hand", DriveByHand)
