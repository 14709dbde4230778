"""Hard cases for the whole driver, in simulated time: requests at bad moments, another robot on its cable, flags that
change all the time.
"""

import pytest
from bottle import Bottle
from test_driver_requests import ask, twist

from pioneer_control.client import BaudFound, LineSpeed, Unmoved
from pioneer_control.driver.notices import PERIOD
from pioneer_control.msg import GripperState, GripState, LiftState, MotorState
from pioneer_control.robots import find_model
from pioneer_control.simulator.firmware import Firmware
from pioneer_control.simulator.world import load_world

# Seconds after the cable is pulled and put back: there is no port, then silence, SYNC, OPEN, and the robot is ready.
MOMENTS = [0.0, 0.02, 0.17, 0.32, 0.47, 0.62, 0.77, 0.92]


@pytest.fixture
def run(monkeypatch):
    return lambda script, **options: Bottle(monkeypatch, script, **options)


def lose_the_link(bottle, seconds):
    """Pull the cable for a moment, and then wait so many seconds."""
    bottle.unplug(for_a_moment=True)
    if seconds:
        yield seconds


def find_it_again(bottle):
    while not bottle.robot.ready or bottle.line.lost:
        yield 0.05
    yield 0.3


@pytest.mark.parametrize("service, values, done", [
    ("set_motors", [True], lambda bottle: bottle.firmware.motors_enabled),
    ("enable_motors", [], lambda bottle: bottle.firmware.motors_enabled),
    ("set_sonar", [False], lambda bottle: not bottle.robot.state.sonar_enabled)])
def test_a_service_says_no_while_there_is_no_link_and_nothing_comes_of_it_later(run, service, values, done):
    def script(bottle):
        bottle.answers = []
        for moment in MOMENTS:
            yield from lose_the_link(bottle, moment)
            said_yes, why = yield from ask(bottle, service, *values)
            yield from find_it_again(bottle)
            bottle.answers.append(said_yes)
            assert said_yes or "cable" in why
            assert done(bottle) is said_yes
            if service == "set_sonar":
                yield from ask(bottle, "set_sonar", True)

    assert set(run(script).answers) == {False, True}


def test_a_sonar_that_was_told_to_go_off_over_a_line_that_was_dead_already_is_on_after_the_reconnect(run):
    def script(bottle):
        bottle.unplug()
        bottle.answer = yield from ask(bottle, "set_sonar", False)
        bottle.plug_in()
        yield from find_it_again(bottle)
        bottle.on = bottle.robot.state.sonar_enabled

    bottle = run(script)
    assert not bottle.answer[0] and "cable" in bottle.answer[1] and bottle.on


def test_the_odometry_that_began_anew_while_the_link_was_lost_goes_on_from_there(run):
    def script(bottle):
        bottle.poses = []
        for moment in MOMENTS:
            bottle.send("cmd_motor_state", MotorState(1))
            yield 0.3
            for _ in range(10):
                bottle.send("cmd_vel", twist(0.3))
                yield 0.1
            yield 1.5
            before = bottle.robot.state.x
            yield from lose_the_link(bottle, moment)
            said_yes = bottle.call("reset_odometry").success
            yield from find_it_again(bottle)
            bottle.poses.append((said_yes, before, bottle.robot.state.x))

    for said_yes, before, after in run(script).poses:
        assert before > 0.1 and after == (0.0 if said_yes else pytest.approx(before))


def test_a_gripper_that_is_told_to_close_without_a_link_stays_as_it_is(run):
    def script(bottle):
        for moment in MOMENTS:
            yield from lose_the_link(bottle, moment)
            if not bottle.robot.ready:
                bottle.send("gripper_control", GripperState(GripState(state=2), LiftState()))
            yield from find_it_again(bottle)

    bottle = run(script)
    assert bottle.commands("GRIPPER") == [] and "cable" in bottle.warned


@pytest.mark.parametrize("gripper", [False, True])
def test_another_robot_at_the_cable_is_described_anew(run, gripper):
    def script(bottle):
        yield 1.0
        bottle.unplug()
        model = find_model("peoplebot-sh" if gripper else "amigo-sh")
        bottle.firmware = Firmware(model, load_world("empty"), gripper=gripper)
        yield 0.5
        bottle.published.clear()
        bottle.plug_in()
        yield from find_it_again(bottle)
        yield 2.0

    bottle = run(script)
    model, info = bottle.firmware.model, bottle.messages("robot_info")[-1]
    assert info.subtype == model.subtype and list(info.sonar_numbers) == [each.number for each in model.sonar]
    assert len(bottle.messages("sonar")[-1].ranges) == model.sonar_count
    assert bool(bottle.messages("gripper_state")) is gripper
    assert bottle.messages("motor_state")[-1].state == 0


@pytest.mark.parametrize("befall", [
    lambda firmware, on: setattr(firmware.hardware.motors, "enabled", on),
    lambda firmware, on: firmware.press_stop_button(on),
], ids=["motors", "STOP"])
def test_flags_that_flicker_do_not_flood_the_log(run, befall):
    def script(bottle):
        bottle.send("cmd_motor_state", MotorState(1))
        yield 0.5
        bottle.said.clear()
        for tenths in range(150):
            befall(bottle.firmware, bool(tenths % 2))
            bottle.send("cmd_vel", twist(0.2))
            yield 0.1

    said = [text for level, text in run(script).said if level == "warn"]
    assert 1 <= len(said) <= 3 * (1 + 15.0 / PERIOD), said


def test_what_is_noticed_of_robot_and_line_is_in_the_log(run):
    def script(bottle):
        yield 0.2
        for event in (BaudFound(19200), LineSpeed(38400, ""), LineSpeed(9600, "it fell silent"), Unmoved(2.0)):
            bottle.node._on_event(event)

    said = run(script).said
    assert ("info", "the robot answers at 19200 baud; set the parameter baud to it for a faster start") in said
    assert ("info", "the line runs at 38400 baud") in said
    assert ("warn", "the line runs at 9600 baud: it fell silent") in said
    assert any(level == "warn" and "has not moved for 2 s: does it hear?" in text for level, text in said)


def test_a_robot_that_does_not_hear_is_noticed_by_the_driver(run):
    def script(bottle):
        assert (yield from ask(bottle, "set_motors", True))[0]
        bottle.deaf_to = {"VEL", "RVEL"}
        for _ in range(40):
            bottle.send("cmd_vel", twist(0.3))
            yield 0.1

    assert "does it hear?" in run(script).warned
