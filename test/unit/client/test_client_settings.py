"""Settings are checked once. The errors name the value and what is legal."""

import math

import pytest

from pioneer_control.client import Robot
from pioneer_control.client.settings import Settings
from pioneer_control.errors import ParameterError, UnknownModelError, UsageError


@pytest.mark.parametrize("field, value", [
    ("pulse", -0.1), ("pulse", math.nan), ("pulse", math.inf), ("command_timeout", 0.0), ("command_timeout", -1.0),
    ("command_timeout", math.inf), ("max_linear", -0.1), ("max_angular", math.nan)])
def test_nonsense_is_refused(field, value):
    with pytest.raises(ParameterError, match="%s is .*legal" % field):
        Settings(**{field: value})


def test_a_model_or_file_that_is_none_is_refused_at_once(tmp_path):
    with pytest.raises(UnknownModelError, match="p3dx-sh"):
        Settings(model="p3dx-shh")
    with pytest.raises(UsageError, match="nonesuch"):
        Settings(models_file=str(tmp_path / "nonesuch.yaml"))


def test_a_robot_checks_before_anything_is_opened():
    with pytest.raises(ParameterError, match="command_timeout"):
        Robot("/dev/nonesuch", command_timeout=0)


@pytest.mark.parametrize("field, value", [
    ("pulse", 0), ("max_linear", 0), ("max_angular", None), ("command_timeout", 0.05)])
def test_sense_is_taken(field, value):
    assert getattr(Settings(**{field: value}), field) == value


def test_a_robot_is_asked_whether_it_hears_unless_its_user_says_otherwise():
    assert Robot("nowhere")._link.settings == Settings() and Settings().link_check
    assert Robot("nowhere", link_check=False)._link.settings == Settings(link_check=False)


@pytest.mark.parametrize("baud", [9601, 0, "fast"])
def test_a_line_speed_that_no_robot_has_is_named_with_those_it_may_have(baud):
    with pytest.raises(ParameterError, match="host_baud is %r; legal: 9600, .*None" % (baud,)):
        Settings(host_baud=baud)


def test_limits_may_change_before_there_is_a_robot():
    robot = Robot("nowhere")
    robot.set_limits(0.5, 1.0, 0.2)
    settings = robot._link.settings
    assert (settings.max_linear, settings.max_angular, settings.command_timeout) == (0.5, 1.0, 0.2)
    with pytest.raises(ParameterError, match="command_timeout"):
        robot.set_limits(0.4, 1.0, 0.0)
    assert robot._link.settings.max_linear == 0.5, "all or nothing"
