#!/usr/bin/python3
"""A robot at work without a keyboard: its service is installed, crashed, misled, stopped and removed, and the truth of
a simulated robot says what that one did.

    as root, on a computer (or in a container) that systemd runs, in ./pioneer shell:
    python3 bench/at_boot.py --user robot [--repeat 5]

The robot is a process of its own, as a real one is: it goes on when its driver dies. bench/at_boot.md has a run.
"""

import argparse
import re
import statistics
import sys
import tempfile
import time

import rospy
from geometry_msgs.msg import Twist
from std_srvs.srv import SetBool

from pioneer_control.msg import MotorState
from true_robot import ROOT, TrueRobot, output, wait_for

NAME, PORT = "pioneer-bench", 8171
SPEED, RATE = 0.3, 10.0


class Person:
    """A program that drives, and goes on whatever happens."""

    def __init__(self) -> None:
        self.motors, self.heard, self.wanted = None, 0.0, 0.0
        self._publisher = rospy.Publisher("/pioneer/cmd_vel", Twist, queue_size=1)
        rospy.Subscriber("/pioneer/motor_state", MotorState, self._note, queue_size=1)
        rospy.Timer(rospy.Duration(1 / RATE), self._tell)

    def _note(self, message: MotorState) -> None:
        self.motors, self.heard = message.state, time.monotonic()

    def _tell(self, _) -> None:
        twist = Twist()
        twist.linear.x = self.wanted
        self._publisher.publish(twist)

    def drive(self, robot: TrueRobot) -> None:
        """Switch the motors on, and drive until the robot is at its speed."""
        wait_for("motors", lambda: rospy.ServiceProxy("/pioneer/set_motors", SetBool)(True).success)
        self.wanted = SPEED
        wait_for("speed", lambda: robot.speed > 0.9 * SPEED)

    def comes_back(self, since: float) -> float:
        """Wait for the next news of the robot. Return how long after a time (monotonic, s) it came."""
        wait_for("the driver", lambda: self.heard > since + 0.5)
        return self.heard - since


def driver_pid() -> str:
    listed = output("systemctl", "status", NAME, "--no-pager", "-l")
    return re.search(r"(\d+) /usr/bin/python3 \S*p2os_driver", listed).group(1)


def state() -> str:
    return output("systemctl", "show", NAME, "--property=ActiveState,NRestarts,ExecMainStatus").replace("\n", " ")


def install(user: str, *words: str) -> str:
    return output(str(ROOT / "nodes" / "install_service"), "--name", NAME, "--user", user, "--no-udev",
                  "pioneer.launch", *words)


def main() -> None:
    """Run the bench."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--user", required=True)
    parser.add_argument("--repeat", type=int, default=3)
    options = parser.parse_args()
    robot = TrueRobot(tempfile.mkdtemp() + "/truth", PORT)
    try:
        install(options.user, "port:=socket://localhost:%d" % PORT)
        begin = time.monotonic()
        wait_for("the master", lambda: "/rosout" in output("rosnode", "list").split())
        rospy.init_node("bench", disable_signals=True)
        person = Person()
        wait_for("the driver", lambda: person.motors is not None)
        print("found after %.1f s, motors %d" % (time.monotonic() - begin, person.motors))
        for what, victim in (("driver killed", driver_pid), ("all of it killed", None)):
            stands, back, on = [], [], []
            for _ in range(options.repeat):
                person.drive(robot)
                if victim is None:
                    output("systemctl", "kill", "--signal=KILL", NAME)
                else:
                    output("kill", "-9", victim())
                killed = time.monotonic()
                stands.append(wait_for("a stop", lambda: robot.stands))
                back.append(person.comes_back(killed))
                time.sleep(2.0)     # it is told to drive all the while
                on.append(person.motors)
                assert robot.stands, "it moved by itself"
                person.wanted = 0.0
            print("%s while it drives: stands after %s s, driver back after %s s, motors then %s" % (
                what, spread(stands), spread(back), sorted(set(on))))
        person.drive(robot)
        begin = time.monotonic()
        output("systemctl", "stop", NAME)
        print("stopped while it drives: %.1f s; robot stands: %s" % (time.monotonic() - begin, robot.stands), state())
        print("master with it, after %.1f s" % wait_for("its end", lambda: output(
            "systemctl", "is-active", NAME + "-master").strip() == "inactive"))
        for words in (("prot:=/dev/ttyS0",), ("baud:=12345",)):
            print("installed with %s:" % words[0], install(options.user, *words).strip().splitlines()[-1])
        wait_for("the end", lambda: "failed" in state())
        time.sleep(8.0)
        print("a wrong parameter, 8 s later:", state())
        print(output(str(ROOT / "nodes" / "uninstall_service"), "--name", NAME))
        print("left:", output("sh", "-c", "ls -d /etc/systemd/system/*bench* /etc/systemd/system/*/*bench* "
                                          "/etc/pioneer_control 2>&1 | grep -v 'cannot access'").split())
    finally:
        robot.end()


def spread(values) -> str:
    """Return median and range."""
    return "%.1f (%.1f to %.1f)" % (statistics.median(values), min(values), max(values))


if __name__ == "__main__":
    sys.exit(main())
