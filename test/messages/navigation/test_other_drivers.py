"""Programs that drive the robot while navigation has a goal, without a master: velocities are handed to the node."""

import threading
import types

import pytest
import rospy
from geometry_msgs.msg import Twist, Vector3

from pioneer_control.navigation.node import navigation_node
from pioneer_control.navigation.node.navigation_node import LAST_WORDS, NavigationNode

DRIVES, STANDS = Twist(linear=Vector3(x=0.1)), Twist()


@pytest.fixture
def ended(monkeypatch):
    """Return a function that hands a velocity to a node, and returns why its goal ends."""
    monkeypatch.setattr(rospy, "get_name", lambda: "/pioneer/navigation")
    monkeypatch.setattr(navigation_node, "monotonic", lambda: 100.0)

    def hand_over(velocity, driver, since=10.0, accept_replay=False, goal=(1.0, 2.0), explores=False):
        reasons = []
        node = types.SimpleNamespace(
            _sent_at=100.0 - since, _lock=threading.Lock(), _goals=types.SimpleNamespace(dropped=reasons.append),
            _parameters=types.SimpleNamespace(accept_replay=accept_replay),
            _pilot=types.SimpleNamespace(goal=goal, explores=explores, cancel=lambda: reasons.append("cancelled")))
        velocity._connection_header = {"callerid": driver}
        NavigationNode._hear_velocity(node, velocity)
        return reasons

    return hand_over


def test_a_goal_ends_when_another_program_drives(ended):
    assert ended(DRIVES, "/mine") == ["cancelled", "/mine drives the robot"]
    assert ended(DRIVES, "/mine", goal=None, explores=True) == ["cancelled", "/mine drives the robot"]


@pytest.mark.parametrize("velocity, driver, how", [
    (STANDS, "/mine", {}), (DRIVES, "/pioneer/navigation", {}), (DRIVES, "/play_1234", {}),
    (DRIVES, "/mine", {"goal": None}), (DRIVES, "/mine", {"since": 0.9 * LAST_WORDS})])
def test_no_goal_ends_by_a_stop_its_own_velocities_a_bag_or_the_last_words_of_who_sent_the_goal(
        ended, velocity, driver, how):
    assert ended(velocity, driver, **how) == []


def test_a_bag_that_may_drive_ends_a_goal(ended):
    assert ended(DRIVES, "/play_1234", accept_replay=True)
    assert ended(DRIVES, "/mine", since=1.1 * LAST_WORDS)
