"""What ends the node of navigation at its start, before it waits for a robot."""

import re

import pytest
import rospy

from pioneer_control.navigation.node import navigation_node


@pytest.fixture
def ended(monkeypatch):
    """Return a function that starts the node with parameters and returns its last words."""

    def start(**given):
        def robot_info():
            raise AssertionError("it waits for the robot")

        words = []
        monkeypatch.setattr(navigation_node.os, "nice", lambda much: None)
        monkeypatch.setattr(navigation_node, "init_node", lambda name: None)
        monkeypatch.setattr(navigation_node, "robot_info", robot_info)
        monkeypatch.setattr(rospy, "get_param", lambda name, default: given)
        monkeypatch.setattr(rospy, "loginfo", lambda *line: None)
        monkeypatch.setattr(rospy, "logfatal", lambda text, *values: words.append(text % values))
        assert navigation_node.main() == 2
        return words[0]

    return start


@pytest.mark.parametrize("given, named", [
    ({"map": "office", "initial_pose": [900, 1.0, 0.0]}, r"~initial_pose \(900, 1\) lies outside of the map"),
    ({"save_to": "/nowhere/lab.yaml"}, "~save_to is '/nowhere/lab.yaml': no file can be written in"),
])
def test_a_wrong_parameter_is_named_at_once(ended, given, named):
    assert re.search(named, ended(**given))
