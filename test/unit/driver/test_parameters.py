"""The driver's parameters: what is legal passes, what is not is named with its legal range."""

import ast
import dataclasses
import math
import pathlib

import pytest

from pioneer_control.driver import parameters as parameters_module
from pioneer_control.driver.parameters import WITHOUT_EFFECT, DriverParameters, check_parameters
from pioneer_control.errors import ParameterError

LEGAL = [
    ("port", "socket://localhost:8101", "socket://localhost:8101"), ("baud", 115200, 115200),
    ("model", "p3at-sh", "p3at-sh"), ("models_file", "", ""),
    ("gripper", "auto", None), ("gripper", "true", True), ("gripper", False, False),
    ("pulse", 1, 1.0), ("pulse", -1, -1.0), ("pulse", 1.5, 1.5), ("use_sonar", False, False),
    ("max_xspeed", 1, 1.0), ("max_yawspeed", 0.5, 0.5), ("cmd_vel_timeout", 0.1, 0.1), ("cmd_vel_timeout", 2, 2.0),
    ("accept_replay", True, True), ("odom_frame_id", "o", "o"), ("base_link_frame_id", "b", "b"),
    ("frame_prefix", "two/", "two/"), ("publish_tf", False, False),
]

ILLEGAL = [
    ("port", "", "not empty"), ("port", 8101, "a text"), ("baud", 9601, "9600, 19200"), ("baud", "9600", "9600"),
    ("baud", True, "9600"), ("model", 3, "a text"), ("models_file", None, "a text"),
    ("gripper", "yes", "auto, true or false"), ("gripper", 1, "auto"), ("gripper", [], "auto"),
    ("pulse", "1.0", "-1 to 1.5"), ("pulse", 2.0, "-1 to 1.5"), ("pulse", math.nan, "-1 to 1.5"), ("pulse", True, "number"),
    ("use_sonar", 1, "true or false"), ("use_sonar", "true", "true or false"),
    ("max_xspeed", 0, "0.01 to 3"), ("max_xspeed", -0.5, "0.01 to 3"), ("max_xspeed", math.inf, "0.01 to 3"),
    ("max_yawspeed", 0.0, "rad/s"), ("max_yawspeed", 0.015, "0.02 to 6.3"), ("cmd_vel_timeout", 0, "0.1 to 2"), ("cmd_vel_timeout", -1, "0.1 to 2"),
    ("cmd_vel_timeout", 60, "0.1 to 2"), ("accept_replay", "no", "true or false"),
    ("odom_frame_id", "", "not empty"), ("odom_frame_id", "/odom", "not beginning with '/'"),
    ("base_link_frame_id", "/base_link", "not beginning"), ("frame_prefix", "/two", "not beginning"),
    ("publish_tf", 0, "true or false"),
]


def test_nothing_given_is_all_defaults():
    """An empty parameter server is legal, and the time-out is on."""
    parameters, warnings = check_parameters({})
    assert parameters == DriverParameters() and not warnings
    assert parameters.cmd_vel_timeout == 0.6 and not parameters.accept_replay


def test_every_default_is_legal():
    """No default is a value that the user could not have given."""
    for entry in dataclasses.fields(DriverParameters):
        given = "auto" if entry.name == "gripper" else entry.default
        assert entry.metadata["kind"].accept(given) == entry.default


@pytest.mark.parametrize("name, given, expected", LEGAL)
def test_legal_value(name, given, expected):
    """A legal value arrives, in its own type."""
    value = getattr(check_parameters({name: given})[0], name)
    assert value == expected and type(value) is type(expected)


@pytest.mark.parametrize("name, given, says", ILLEGAL)
def test_illegal_value(name, given, says):
    """An illegal one is refused by name, with the value and what would be legal."""
    with pytest.raises(ParameterError) as caught:
        check_parameters({name: given})
    message = str(caught.value)
    assert message.startswith("~%s = %r" % (name, given)) and says in message


def test_the_cases_cover_every_parameter():
    """A new parameter needs a legal and an illegal case here."""
    names = {entry.name for entry in dataclasses.fields(DriverParameters)}
    assert {name for name, _, _ in LEGAL} == names == {name for name, _, _ in ILLEGAL}


def test_all_problems_are_told_at_once():
    """Three mistakes, one message of one line."""
    with pytest.raises(ParameterError) as caught:
        check_parameters({"pulse": "x", "baud": 1, "use_sonr": True})
    message = str(caught.value)
    assert "~pulse" in message and "~baud" in message and "did you mean ~use_sonar?" in message
    assert "\n" not in message


@pytest.mark.parametrize("slip, meant", [
    ("prot", "port"), ("use_sonars", "use_sonar"), ("cmd_vel_timeot", "cmd_vel_timeout"), ("max_speed", "max_xspeed"),
    ("odom_frame", "odom_frame_id"), ("pulses", "pulse"), ("accept_replays", "accept_replay")])
def test_misspelt_name_is_refused(slip, meant):
    """A name that is nearly one of ours is an error: the value its author meant would silently be missing."""
    with pytest.raises(ParameterError, match="~%s .*did you mean ~%s\\?" % (slip, meant)):
        check_parameters({slip: 1})


@pytest.mark.parametrize("name", sorted(WITHOUT_EFFECT) + ["lab_room"])
def test_foreign_name_is_a_warning(name):
    """Old launch files still start; what has no effect is said."""
    parameters, warnings = check_parameters({name: 1})
    assert parameters == DriverParameters()
    assert len(warnings) == 1 and "~" + name in warnings[0] and "no effect" in warnings[0]


def test_prefix_goes_before_every_frame():
    """One prefix sets all frames."""
    parameters, _ = check_parameters({"frame_prefix": "two/", "odom_frame_id": "o"})
    assert (parameters.odom_frame, parameters.base_link_frame) == ("two/o", "two/base_link")


def test_the_node_tells_of_every_parameter_what_is_true():
    """The table that a user reads has the names, units and defaults of the table that is checked."""
    source = pathlib.Path(parameters_module.__file__).with_name("node.py").read_text(encoding="utf-8")
    table = ast.get_docstring(ast.parse(source)).partition("*Parameters*")[2].splitlines()
    heading = next(line for line in table if line.startswith("name "))
    unit, default, meaning = (heading.index(column) for column in ("unit", "default", "meaning"))
    told = {row.split("``")[1]: (row[unit:default].strip(), row[default:meaning].strip()) for row in table if row.startswith("``")}
    spelled = {"None": "auto", "True": "true", "False": "false"}
    assert told == {entry.name: (entry.metadata["unit"], spelled.get(str(entry.default), str(entry.default)))
                    for entry in dataclasses.fields(DriverParameters)}


def test_frozen():
    """Nobody changes a parameter behind the driver's back."""
    with pytest.raises(dataclasses.FrozenInstanceError):
        check_parameters({})[0].pulse = 0.0
