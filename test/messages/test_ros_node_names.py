"""The names of nodes, and who subscribes to their topics."""

import pytest

from pioneer_control import ros_node


@pytest.mark.parametrize("robot, name", [
    ("pioneer", "wanderer"), ("/pioneer/", "wanderer"), ("robot_2", "wanderer_robot_2"), ("/lab/alice",
                                                                                          "wanderer_lab_alice"),
    ("robot-2", "wanderer_robot_2")])
def test_programs_of_several_robots_have_names_of_their_own(robot, name):
    assert ros_node.name_for("wanderer", robot) == name


def test_a_master_that_is_not_there_knows_no_listeners(monkeypatch):
    monkeypatch.setenv("ROS_MASTER_URI", "http://localhost:1")
    assert ros_node.listeners(1.0) == {}
