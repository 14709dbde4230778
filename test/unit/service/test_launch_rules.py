"""What a launch file may not do at boot, and what the end of its programs means."""

import pytest

from pioneer_control.service.launch_rules import (CRASHED, OK, WRONG, Death, LaunchedNode, exit_code_of, refusals,
                                                  strangers, unknown_arguments)

DRIVER = LaunchedNode("pioneer_control", "p2os_driver", "")


@pytest.mark.parametrize("nodes, parameters, words", [
    ([DRIVER], {"/pioneer/p2os/enable_motors_on_start": True}, "/pioneer/p2os/enable_motors_on_start is True"),
    ([DRIVER], {"/pioneer/p2os/enable_motors_on_start": "true"}, "is 'true'"),
    ([DRIVER], {"/pioneer": {"p2os": {"enable_motors_on_start": 1}}}, "/pioneer/p2os/enable_motors_on_start is 1"),
    ([DRIVER._replace(arguments="_enable_motors_on_start:=true")], {}, "p2os_driver gets _enable_motors_on_start"),
    ([DRIVER, LaunchedNode("pioneer_control", "rosPioneer2.py", "")], {}, "rosPioneer2.py switches the motors on"),
])
def test_what_switches_motors_on_by_itself_is_refused(nodes, parameters, words):
    found = refusals(nodes, parameters)
    assert len(found) == 1 and words in found[0]


@pytest.mark.parametrize("parameters", [{}, {"/pioneer/p2os/enable_motors_on_start": False}, {"/a": {"port": "x"}}])
def test_what_leaves_them_off_is_not(parameters):
    assert refusals([DRIVER], parameters) == []


def test_nodes_of_others_are_named_once():
    other = LaunchedNode("joy", "joy_node", "")
    assert strangers([DRIVER, other, other, LaunchedNode("rosbag", "record", "")]) == ["joy/joy_node"]


def test_arguments_that_a_launch_file_does_not_know():
    known = ["port", "sim", "world"]
    assert unknown_arguments(["port:=/dev/pioneer", "sim:="], known) == []
    assert unknown_arguments(["wrld:=office"], known) == [
        "the launch file has no argument 'wrld'; did you mean world?"]
    assert unknown_arguments(["x:=1"], known) == ["the launch file has no argument 'x'; it has: port, sim, world"]
    assert unknown_arguments(["x:=1"], []) == ["the launch file has no argument 'x'; it has: none"]


@pytest.mark.parametrize("deaths, code", [
    ([], OK),
    ([Death(True, 0)], OK),
    ([Death(True, 2)], WRONG),
    ([Death(True, -9)], CRASHED),
    ([Death(True, None)], CRASHED),
    ([Death(False, 2), Death(True, -9)], CRASHED),      # another node's wrong parameter does not end the run
    ([Death(False, 1), Death(True, 0)], OK),
    ([Death(False, 0), Death(False, 1)], CRASHED),
    ([Death(False, 2), Death(False, 1)], WRONG),
])
def test_the_exit_code_says_whether_starting_again_can_help(deaths, code):
    assert exit_code_of(deaths) == code
