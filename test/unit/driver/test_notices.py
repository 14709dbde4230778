"""The warnings for the driver's user: once per period, and only while they are true."""

from dataclasses import dataclass
from types import SimpleNamespace
from typing import Optional

import pytest

from pioneer_control.client.alarms import battery_levels
from pioneer_control.driver.notices import NEWS_PERIOD, PERIOD, Throttle, Watch


@dataclass
class State:
    """The fields of a RobotState that are watched. All is well in it."""

    battery_voltage: float = 12.5
    left_stall: bool = False
    right_stall: bool = False
    stop_button: bool = False
    motors_enabled: bool = True


def identity(battery_class=12, low_battery_dv: Optional[int] = 115, shutdown_dv: Optional[int] = 110):
    config = SimpleNamespace(low_battery_dv=low_battery_dv, shutdown_dv=shutdown_dv)
    return SimpleNamespace(model=SimpleNamespace(battery_class=battery_class), config=config)


@pytest.fixture
def watch():
    watch = Watch(0.6, "rosservice call /pioneer/set_motors true")
    watch.identified(identity())
    return watch


def said(warnings):
    """Return the warnings that have a text, by kind."""
    return {kind: text for kind, text in warnings.items() if text}


def test_all_well_is_not_mentioned(watch):
    assert said(watch.state(State())) == said(watch.velocity(0.0, True, State())) == {}


def test_low_battery_names_voltage_and_level(watch):
    text, = said(watch.state(State(battery_voltage=11.4))).values()
    assert "11.4 V" in text and "11.5 V" in text
    assert said(watch.state(State(battery_voltage=11.5))) == {}


@pytest.mark.parametrize(
    "battery_class, reported_dv, level",
    [(12, 115, 11.5), (12, 120, 12.0), (12, None, 11.5), (12, 0, 11.5),
     (24, 230, 23.0), (24, 115, 23.0), (24, None, 23.0)],
)
def test_the_alarm_level_is_the_robots_own_in_its_own_volts(watch, battery_class, reported_dv, level):
    watch.identified(identity(battery_class, reported_dv))
    assert list(said(watch.state(State(battery_voltage=level - 0.05)))) == ["battery"]
    assert said(watch.state(State(battery_voltage=level + 0.05))) == {}


@pytest.mark.parametrize(
    "battery_class, low_dv, shutdown_dv, empty",
    [(12, 115, 108, 10.8), (12, 115, None, 11.0), (12, 105, 110, 10.5),
     (24, 230, 216, 21.6), (24, 230, 110, 22.0), (24, 230, 0, 22.0)],
)
def test_an_empty_battery_is_at_the_robots_own_shutdown_and_never_above_a_low_one(
        battery_class, low_dv, shutdown_dv, empty):
    assert battery_levels(identity(battery_class, low_dv, shutdown_dv)).empty == pytest.approx(empty)


def test_the_levels_of_a_robot_that_never_sent_its_configuration_are_those_of_its_class():
    silent = SimpleNamespace(model=SimpleNamespace(battery_class=24), config=None)
    assert battery_levels(silent) == (23.0, 22.0)


def test_a_stalled_wheel_is_named(watch):
    left, both = (said(watch.state(State(left_stall=True, right_stall=right))) for right in (False, True))
    assert list(left) == list(both) == ["stall"]
    assert "the left wheel is stalled" in left["stall"]
    assert "the left and the right wheels are stalled" in both["stall"]


def test_the_stop_button_explains_its_stalls_and_says_what_to_do(watch):
    warnings = watch.state(State(stop_button=True, left_stall=True, right_stall=True, motors_enabled=False))
    (kind, text), = said(warnings).items()
    assert kind == "stop button" and "release it, then rosservice call /pioneer/set_motors true" in text


def test_a_velocity_with_motors_off_says_how_to_enable(watch):
    text, = said(watch.velocity(0.0, True, State(motors_enabled=False))).values()
    assert "motors are off" in text and "rosservice call /pioneer/set_motors true" in text


def test_a_zero_velocity_with_motors_off_is_nothing(watch):
    assert said(watch.velocity(0.0, False, State(motors_enabled=False))) == {}


def test_commands_slower_than_the_time_out_are_told(watch):
    assert said(watch.velocity(0.0, True, State())) == said(watch.velocity(1.0, True, State())) == {}
    text, = said(watch.velocity(2.0, True, State())).values()
    assert "every 1.0 s" in text and "0.6 s" in text


@pytest.mark.parametrize("moves, gap", [(True, 0.5), (True, 6.0), (False, 1.0)])
def test_steady_commanders_and_separate_drives_are_not(watch, moves, gap):
    for turn in range(4):
        assert said(watch.velocity(turn * gap, moves, State())) == {}


def test_a_pause_between_two_drives_is_not(watch):
    for time in (0.0, 0.1, 2.1, 2.2, 4.2, 4.3):
        assert said(watch.velocity(time, True, State())) == {}


def test_the_throttle_lets_each_kind_pass_once_a_period():
    throttle = Throttle()
    assert throttle.passes("a", 0.0) and throttle.passes("b", 0.1)
    assert not throttle.passes("a", PERIOD - 0.1) and throttle.passes("a", PERIOD + 0.1)


def test_another_mistake_at_the_same_topic_is_told_soon_and_never_floods_the_log():
    throttle = Throttle()
    first, second = "refused: no joint 'pan'", "refused: ptz_pan_joint is nan"
    assert throttle.passes("ptz_joint_control", 0.0, first)
    assert not throttle.passes("ptz_joint_control", NEWS_PERIOD - 0.1, second)
    assert throttle.passes("ptz_joint_control", NEWS_PERIOD + 0.1, second)
    assert not throttle.passes("ptz_joint_control", PERIOD, second)
    given = [throttle.passes("ptz_joint_control", 100.0 + 0.01 * step, "refused: joint " + "ab"[step % 2])
             for step in range(1000)]
    assert sum(given) <= 10.0 / NEWS_PERIOD


def test_the_same_trouble_with_another_number_in_it_is_no_news():
    """Each attempt on a noisy line counts a different number of bytes."""
    throttle = Throttle()
    text = "link: socket://robot:8101: nothing answers as a robot, tried over TCP (%d bytes came that make no packet)"
    assert [throttle.passes(text % count, 4.0 * attempt) for attempt, count in enumerate((280000, 303000, 17, 4))] == [
        True, False, False, True]
    assert throttle.passes("link: socket://robot:8101: connection refused", 4.0)
