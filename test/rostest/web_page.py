#!/usr/bin/python3
"""The page of a ROS graph: it finds robots by their topics, shows and drives them, and when it dies they stand."""

import os
import pathlib
import re
import signal
import subprocess
import sys
import types
import unittest

import rospy
import rostest
from actionlib_msgs.msg import GoalID
from geometry_msgs.msg import Pose2D, PoseStamped, PoseWithCovarianceStamped
from nav_msgs.msg import Odometry
from std_srvs.srv import SetBool

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))
sys.path.insert(0, str(HERE.parent / "integration"))

from pioneer_control.msg import Helm, Navigation
from web_site import Viewer
from witness import PATIENCE, Witness, wait_until

TOPICS = {"pioneer/ground_truth": Odometry, "second/ground_truth": Odometry, "pioneer/helm": Helm,
          "pioneer/move_base_simple/goal": PoseStamped, "pioneer/initialpose": PoseWithCovarianceStamped,
          "pioneer/move_base/cancel": GoalID}


class PageOfAGraph(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        cls.witness = Witness(TOPICS)
        for robot in ("pioneer", "second"):
            rospy.wait_for_service(robot + "/set_motors", PATIENCE)
            set_motors = rospy.ServiceProxy(robot + "/set_motors", SetBool)
            wait_until("motors are on", lambda: set_motors(True).success)

    def setUp(self):
        self.node = subprocess.Popen(["rosrun", "pioneer_control", "web", "_port:=0"], stdin=subprocess.DEVNULL,
                                     stdout=subprocess.PIPE, universal_newlines=True, start_new_session=True)
        self.addCleanup(self.end)
        address = next(re.search(r"http://\S+", line).group() for line in self.node.stdout if "http" in line)
        base, key = address.split("#")
        self.viewer = Viewer(types.SimpleNamespace(base=base, key=key))
        self.addCleanup(self.viewer.__exit__)

    def end(self):
        if self.node.poll() is None:
            os.killpg(self.node.pid, signal.SIGTERM)
            self.node.wait()
        self.node.stdout.close()

    def number_of(self, name):
        def found():
            return [robot["robot"] for robot in self.viewer.newest("robots") or [] if robot["name"] == name]

        wait_until("%s is on the page" % name, found)
        number, = found()
        wait_until("it is seen", lambda: number in self.viewer.frames)
        return number

    def speed(self, robot, wanted):
        self.witness.next(robot + "/ground_truth")
        self.witness.wait("%s drives %.1f m/s" % (robot, wanted), lambda: all(
            abs(message.twist.twist.linear.x - wanted) < 0.01
            for message in self.witness.seen[robot + "/ground_truth"][-10:]))

    def hold(self, number):
        self.viewer.drive(number, forward=0.0)
        self.viewer.hold(number)

    def test_1_both_robots_are_shown_with_world_and_helm(self):
        first, second = self.number_of("pioneer"), self.number_of("second")
        wait_until("a world", lambda: self.viewer.newest("world"))
        wait_until("origins of both", lambda: set(self.viewer.newest("origins") or {}) == {str(first), str(second)})
        wait_until("both helms", lambda: {each["robot"] for each in self.viewer.of("helm")} == {first, second})
        goal = PoseStamped()
        goal.header.frame_id, goal.pose.position.x, goal.pose.position.y = "map", 3.0, 4.0
        publisher = rospy.Publisher("second/move_base_simple/goal", PoseStamped, queue_size=1, latch=True)
        publisher.publish(goal)
        wait_until("a goal", lambda: self.viewer.newest("goals") == {str(second): [3.0, 4.0]})

        def whole():
            frame = self.viewer.frames[first]
            return frame.flags & 1 and frame.flags & 2 and len(frame.sonar) == 16 and frame.gripper

        wait_until("all that the first one has", whole)

    def test_2_a_held_key_drives_and_the_page_killed_means_stand(self):
        self.hold(self.number_of("pioneer"))
        self.speed("pioneer", 0.2)
        self.assertEqual(self.witness.seen["pioneer/helm"][-1].commander, "teleop/cmd_vel")
        os.killpg(self.node.pid, signal.SIGKILL)
        self.node.wait()
        self.speed("pioneer", 0.0)

    def test_3_the_page_stopped_means_stand_and_nothing_moves_when_it_goes_on(self):
        self.hold(self.number_of("second"))
        self.speed("second", 0.2)
        os.killpg(self.node.pid, signal.SIGSTOP)
        self.speed("second", 0.0)
        os.killpg(self.node.pid, signal.SIGCONT)
        wait_until("the held key is refused", lambda: self.viewer.said("let go"))
        self.speed("second", 0.0)

    def test_4_stop_locks_the_driver_and_unlock_unlocks_it(self):
        number = self.number_of("pioneer")
        self.viewer.do("stop", robot=number)
        self.witness.wait("the driver is locked", lambda: self.witness.seen["pioneer/helm"][-1].locks == ["stop_all"])
        self.viewer.picture(number)
        self.viewer.do("unlock", robot=number)
        self.witness.wait("it is unlocked", lambda: not self.witness.seen["pioneer/helm"][-1].locks)

    def programs(self, robot, wanted):
        """Wait until the page, which refuses by what it knows, knows what programs may do."""
        wait_until("programs are " + wanted, lambda: [
            helm["programs"] for helm in self.viewer.of("helm") if helm["robot"] == robot][-1:] == [wanted])

    def test_5_navigation_is_shown_and_told_and_where_there_is_none_it_is_said(self):
        number, second = self.number_of("pioneer"), self.number_of("second")
        state = Navigation(state="idle", sure=True, pose=Pose2D(1.0, 2.0, 0.0))
        state.header.frame_id = "map"
        publisher = rospy.Publisher("pioneer/navigation", Navigation, queue_size=1)
        timer = rospy.Timer(rospy.Duration(0.1), lambda _: publisher.publish(state))
        self.addCleanup(timer.shutdown)
        wait_until("the new page is heard", lambda: all(
            self.witness.heard(topic) for topic in TOPICS if topic.endswith(("goal", "initialpose", "cancel"))))
        wait_until("navigation is shown", lambda: (self.viewer.newest("navigation") or {}).get("pose") == [1, 2, 0])
        self.viewer.picture(number)
        self.viewer.do("take", robot=number)
        self.programs(number, "locked out")
        self.viewer.do("go", robot=number, x=9.0, y=9.0, heading=0.0)
        wait_until("it is refused", lambda: self.viewer.said("let programs drive"))
        self.viewer.do("release", robot=number)
        self.programs(number, "free")
        self.viewer.do("go", robot=number, x=3.0, y=-1.5, heading=0.0)
        self.witness.wait("it is sent", lambda: self.witness.seen["pioneer/move_base_simple/goal"])
        goal = self.witness.seen["pioneer/move_base_simple/goal"][-1]
        self.assertEqual((goal.header.frame_id, goal.pose.position.x, goal.pose.position.y), ("map", 3.0, -1.5))
        self.viewer.do("here", robot=number, x=1.0, y=2.0, heading=3.0)
        self.witness.wait("it is told", lambda: self.witness.seen["pioneer/initialpose"])
        here = self.witness.seen["pioneer/initialpose"][-1].pose
        self.assertAlmostEqual(here.pose.orientation.z, 0.997495, 5)
        self.assertTrue(here.covariance[0] > 0 and here.covariance[7] > 0 and here.covariance[35] > 0)
        self.viewer.do("cancel", robot=number)
        self.witness.wait("it is called back", lambda: self.witness.seen["pioneer/move_base/cancel"])
        self.viewer.picture(second)
        self.viewer.do("here", robot=second, x=3.0, y=-1.5, heading=0.0)
        wait_until("no navigation", lambda: self.viewer.said("does navigation run"))
        timer.shutdown()
        wait_until("silence is said", lambda: self.viewer.newest("navigation")["state"] == "silent")

    def test_6_a_robot_that_goes_leaves_the_page(self):
        self.number_of("second")
        for node in ("p2os", "simulator"):
            subprocess.run(["rosnode", "kill", "/second/" + node], stdout=subprocess.DEVNULL, timeout=PATIENCE)
        wait_until("second has gone", lambda: [each["name"] for each in self.viewer.newest("robots")] == ["pioneer"])


if __name__ == "__main__":
    rospy.init_node("web_page")
    rostest.rosrun("pioneer_control", "web_page", PageOfAGraph)
