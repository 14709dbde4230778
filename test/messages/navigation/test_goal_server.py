"""Goals as actionlib's server has them, without a master: messages are handed to it, and what it publishes is kept."""

import contextlib
import types

import pytest
import rospy
from actionlib_msgs.msg import GoalID, GoalStatus
from geometry_msgs.msg import PoseStamped
from move_base_msgs.msg import MoveBaseActionGoal, MoveBaseGoal
from rospy import Time
from std_msgs.msg import Header

from pioneer_control.floor_poses import Pose
from pioneer_control.navigation.node import goal_server
from pioneer_control.navigation.node.navigation_node import NavigationNode


class Topic:
    """A topic of rospy's that keeps what is published."""

    def __init__(self, *name_and_kind, **options):
        self.told = []

    def publish(self, message):
        self.told.append(message)

    def shutdown(self):
        """As a timer."""


class Pilot:
    """What the node asks of the pilot, with a goal."""

    def __init__(self):
        self.goal, self.explores = Pose(1.0, 2.0, 0.0), False

    def cancel(self):
        self.goal, self.explores = None, False


class Robot:
    """A goal server, the time it has, and what it does."""

    def __init__(self, monkeypatch):
        self.accepted, self.cancels, self.log, self.why_not, self.fault = [], 0, [], "", None
        self.at(100.0)
        monkeypatch.setattr(rospy, "Publisher", Topic)
        monkeypatch.setattr(rospy, "Subscriber", Topic)
        monkeypatch.setattr(rospy, "Timer", Topic)
        monkeypatch.setattr(rospy, "has_param", lambda name: False)
        monkeypatch.setattr(rospy, "search_param", lambda name: None)
        monkeypatch.setattr(rospy, "get_param", lambda name, default: default)
        monkeypatch.setattr(rospy, "is_shutdown", lambda: False)
        for kind in ("loginfo", "logwarn", "logerr"):
            monkeypatch.setattr(rospy, kind, self._log)
        monkeypatch.setattr(rospy, "logwarn_throttle", lambda period, text, *values: self._log(text, *values))
        self.server = goal_server.GoalServer(self._accept, self._cancel, lambda message: self.why_not)
        self.server.start()
        self.actionlib = self.server._server

    def _log(self, text, *values):
        self.log.append(text % values)

    def _accept(self, pose):
        if self.fault is not None:
            raise self.fault
        self.accepted.append(pose.pose.position.x)

    def _cancel(self):
        self.cancels += 1

    @staticmethod
    def at(seconds):
        rospy.rostime._rostime_current = Time.from_sec(seconds)

    def send(self, x, name="", stamp=0.0):
        """Send a goal through the action, and return its status after the two looks that a refusal takes."""
        self.take(MoveBaseActionGoal(Header(), GoalID(Time.from_sec(stamp), name), self.goal(x)))
        for _ in range(2):
            self.server.look()
        return self.statuses()[-1]

    def take(self, message):
        """Take a goal as from its topic: rospy logs what goes wrong, and goes on."""
        with contextlib.suppress(ArithmeticError):
            self.actionlib.internal_goal_callback(message)

    @staticmethod
    def goal(x):
        goal = MoveBaseGoal(PoseStamped(Header(frame_id="map"), PoseStamped().pose))
        goal.target_pose.pose.position.x = x
        return goal

    def send_simply(self, x):
        """Send a goal as RViz does, and hand on what this sends to the action."""
        self.server._simple_goal(self.goal(x).target_pose, lambda message: self.why_not)
        self.take(self.server._own_goals.told[-1])

    def statuses(self):
        return [types.SimpleNamespace(state=each.status.status, text=each.status.text, id=each.status.goal_id.id)
                for each in self.actionlib.status_list]


@pytest.fixture
def robot(monkeypatch):
    monkeypatch.setattr(rospy.rostime, "_rostime_initialized", True)
    monkeypatch.setattr(rospy.rostime, "_rostime_current", None)
    return Robot(monkeypatch)


def test_a_goal_that_cannot_even_be_read_is_rejected(robot):
    robot.fault = OverflowError("too large")
    status = robot.send(1.0)
    assert status.state == GoalStatus.REJECTED and "OverflowError: too large" in status.text
    assert any("too large" in line for line in robot.log)


def test_while_time_stands_each_simple_goal_is_a_goal_of_its_own(robot):
    for x in (1.0, 2.0):
        robot.send_simply(x)
    assert robot.accepted == [1.0, 2.0]
    first, second = robot.statuses()
    assert first.id != second.id and (first.state, second.state) == (GoalStatus.PREEMPTED, GoalStatus.ACTIVE)


def test_a_goal_older_than_the_last_cancel_is_recalled_and_that_is_logged(robot):
    robot.actionlib.internal_cancel_callback(GoalID(Time(99), ""))
    assert robot.send(1.0, "late", stamp=98.0).state == GoalStatus.RECALLED
    assert any("a goal is recalled" in line for line in robot.log)
    assert robot.send(1.0, "timely", stamp=99.5).state == GoalStatus.ACTIVE


def test_a_cancel_counts_no_more_when_time_has_jumped_back(robot):
    robot.actionlib.internal_cancel_callback(GoalID(Time(99), ""))
    robot.at(40.0)
    assert robot.send(1.0, "a", stamp=40.0).state == GoalStatus.ACTIVE
    robot.actionlib.internal_cancel_callback(GoalID(Time(41), ""))
    robot.at(10.0)
    robot.server.look()
    robot.at(40.5)      # before a goal came, time was as late again
    assert robot.send(2.0, "b", stamp=40.5).state == GoalStatus.ACTIVE
    assert not any("recalled" in line for line in robot.log)


def test_a_goal_that_must_not_be_obeyed_is_rejected_with_its_reason(robot):
    robot.why_not = "it is played back from a bag"
    status = robot.send(1.0, "recorded", stamp=99.0)
    assert (status.state, status.text) == (GoalStatus.REJECTED, "it is played back from a bag")
    assert robot.accepted == [] and len(robot.log) == 1
    robot.why_not = ""
    assert robot.send(2.0).state == GoalStatus.ACTIVE


def test_a_goal_that_is_cancelled_ends(robot):
    robot.send(1.0, "a")
    robot.actionlib.internal_cancel_callback(GoalID(Time(), "a"))
    assert robot.statuses()[-1].state == GoalStatus.PREEMPTED and robot.cancels == 1


@pytest.mark.parametrize("send, said", [
    (lambda robot: robot.send(1.0), "the goal at 1.00, 2.00 ends: somebody cancels it"),
    (lambda robot: robot.send_simply(1.0), "the goal at 1.00, 2.00 ends: somebody cancels it"),
    (lambda robot: None, "the goal at 1.00, 2.00 ends: somebody cancels it"),       # of the service
    (lambda robot: setattr(robot.pilot, "explores", True), "exploring ends: somebody cancels it")])
def test_whatever_is_cancelled_is_logged_once(robot, send, said):
    robot.pilot = Pilot()
    node = types.SimpleNamespace(_pilot=robot.pilot, _stand=lambda: None)
    robot.server._cancel = robot.actionlib._cancel_all = lambda: NavigationNode._cancel(node)
    send(robot)
    for _ in range(2):
        robot.actionlib.internal_cancel_callback(GoalID())
    assert robot.log == [said]
