"""The node that carries cans to a place looks its places up before the robot moves."""

import importlib.util
import math
import pathlib
import sys

import pytest
import rospy

from pioneer_control.errors import UsageError
from pioneer_control.floor_poses import Pose, compose
from pioneer_control.tutorial.travel import Travel

NODE = pathlib.Path(__file__).resolve().parents[3] / "nodes" / "rosPioneer3.py"
BEGAN, DRIVEN = Pose(1.0, 6.0, math.pi / 2), Pose(2.0, 0.0, math.pi)
"""Where the robot begins (m, rad; in the map), and how far it comes by its odometry while it wanders."""


@pytest.fixture
def node(monkeypatch):
    monkeypatch.setattr(rospy, "loginfo", lambda *words: None)
    spec = importlib.util.spec_from_file_location("ros_pioneer3", str(NODE))
    module = importlib.util.module_from_spec(spec)
    monkeypatch.setitem(sys.modules, "ros_pioneer3", module)
    spec.loader.exec_module(module)
    return module


class Robot:
    """A robot that finds a can at once. It notes what it was asked to do."""

    def __init__(self, **places):
        self.done, self.navigation, self.pose = [], Travel.__new__(Travel), Pose(0.0, 0.0, 0.0)
        self.navigation.places = lambda: places

    def where(self):
        return compose(BEGAN, DRIVEN) if self.done else None

    def wander(self, duration):
        self.done.append("wander")
        self.pose = DRIVEN

    def pick(self):
        return True

    def put_down(self):
        return True

    def go_to(self, *where):
        self.done.append(where)
        return True


def test_it_brings_the_can_and_goes_home(node):
    robot = Robot(depot=Pose(2.0, 3.0, 0.0), home=Pose(4.0, 5.0, 1.0))
    node.run(robot, node.Parameters())
    assert robot.done == ["wander", ("depot",), ("home",)]


def test_without_a_home_it_goes_back_to_where_it_began(node):
    robot = Robot(depot=Pose(2.0, 3.0, 0.0))
    node.run(robot, node.Parameters())
    assert robot.done[-1] == pytest.approx(BEGAN), "it did not know where it is before it drove"


@pytest.mark.parametrize("given, wrong", [({}, "depot"), ({"place": "kitchen", "home": "bed"}, "bed")])
def test_a_name_that_no_place_has_is_said_before_it_moves(node, given, wrong):
    robot = Robot(kitchen=Pose(2.0, 3.0, 0.0), sofa=Pose(2.0, 3.0, 0.0))
    with pytest.raises(UsageError, match="'%s' on the map; known: 'kitchen', 'sofa'" % wrong):
        node.run(robot, node.Parameters(**given))
    assert robot.done == []
