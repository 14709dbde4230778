"""Another line speed for one session, and the way back when it does not work."""

import pytest

from pioneer_control.client.events import BaudFound, LineSpeed
from pioneer_control.client.handshake import RATES
from pioneer_control.client.host_baud import ANSWER, BEFORE_SPEAKING, SETTLE, TRIES
from pioneer_control.client.phases import Opening
from pioneer_control.errors import LinkLostError

from fake_robot import OPEN, WAITING, Bench, FakeRobot, config

OWN, FAST = 9600, 115200
LONGEST = TRIES * 2 * (SETTLE + BEFORE_SPEAKING + ANSWER) + 0.3     # s, with what HOSTBAUD itself takes on the line


def robot_at(baud=OWN, **fields):
    robot = FakeRobot()
    robot.baud, robot.config = baud, config(**fields)
    return robot


def without(robot):
    """Return the time (s) at which the same robot is ready without host_baud."""
    return Bench(robot, rates=RATES).until_ready().now


def test_the_command_is_that_of_the_protocol_and_goes_out_at_the_old_speed():
    robot = robot_at()
    bench = Bench(robot, rates=RATES, host_baud=38400).until_ready()
    assert bytes.fromhex("FAFB06323B0200343B") in [data for written in bench.writes.values() for data in written]
    assert [heard.value for heard in robot.heard if heard.name == "HOSTBAUD"] == [2]
    assert bench.baud == bench.session.line.baud == robot.baud == 38400
    assert bench.session.connected.own_baud == OWN


@pytest.mark.parametrize("fast", [rate for rate in RATES if rate != OWN])
def test_success(fast):
    robot = robot_at()
    bench = Bench(robot, rates=RATES, host_baud=fast).until_ready()
    assert bench.event(LineSpeed) == LineSpeed(fast, "") and bench.session._link.host_baud.wanted is not None
    assert bench.now < without(robot_at()) + 0.5
    assert bench.states[-1].time > bench.now - 0.15, "the first state is a new one"
    bench.run(3.0)
    assert bench.session.connected and len(bench.states) > 25
    bench.close()
    bench.run_until(lambda: bench.finished)
    assert robot.phase == WAITING and robot.baud == OWN


@pytest.mark.parametrize(
    "wanted, rates", [(None, RATES), (OWN, RATES), (FAST, ())], ids=["not wanted", "so already", "TCP"])
def test_nothing_to_do(wanted, rates):
    bench = Bench(robot_at(rates[0] if rates else None), rates=rates, host_baud=wanted).until_ready()
    assert "HOSTBAUD" not in bench.robot.names()
    assert not [event for event in bench.events if isinstance(event, LineSpeed)]


@pytest.mark.parametrize("fields", [dict(autobaud=0), None])
def test_a_robot_that_says_it_cannot_is_not_asked(fields):
    robot = robot_at(**fields or {})
    robot.config = robot.config if fields else None
    bench = Bench(robot, rates=RATES, host_baud=FAST).until_ready()
    assert "HOSTBAUD" not in robot.names()
    assert "cannot change" in bench.event(LineSpeed).problem and bench.session.line.baud == OWN


def test_a_speed_to_which_no_hostbaud_leads_back_is_not_left():
    bench = Bench(robot_at(4800), rates=(4800,) + RATES, host_baud=FAST).until_ready()
    assert "HOSTBAUD" not in bench.robot.names()
    assert "no way back" in bench.event(LineSpeed).problem and bench.session.line.baud == 4800


def test_a_robot_that_ignores_it_is_ready_at_its_own_speed_in_a_bounded_time():
    robot = robot_at()
    robot.deaf = lambda heard: heard.name == "HOSTBAUD"
    bench = Bench(robot, rates=RATES, host_baud=FAST).until_ready()
    assert bench.session.line.baud == bench.baud == OWN and bench.session._link.host_baud.wanted is None
    assert "no answer at 115200 baud" in bench.event(LineSpeed).problem and bench.event(LineSpeed).baud == OWN
    assert bench.now < without(robot_at()) + LONGEST
    bench.run(1.0)
    assert bench.session.connected


def test_a_hostbaud_that_is_lost_is_said_once_more():
    robot, lost = robot_at(), []
    robot.deaf = lambda heard: heard.name == "HOSTBAUD" and not lost and not lost.append(heard)
    bench = Bench(robot, rates=RATES, host_baud=FAST).until_ready()
    assert bench.session.line.baud == FAST and bench.event(LineSpeed).problem == ""


def test_a_robot_that_hears_but_is_not_understood_at_the_new_speed_is_told_to_go_back():
    robot = robot_at()
    bench = Bench(
        robot, rates=RATES, host_baud=FAST, to_client=lambda data: bytes(len(data)) if robot.baud == FAST else data)
    bench.until_ready()
    assert bench.session.line.baud == robot.baud == OWN and bench.session._link.host_baud.wanted is None
    asked = [heard.value for heard in robot.heard if heard.name == "HOSTBAUD"]
    assert asked == [4, 0] * TRIES, "it goes back at the first of three"


def test_a_robot_that_is_understood_but_does_not_hear_at_the_new_speed_is_not_taken_for_one_that_works():
    robot = robot_at()
    robot.deaf = lambda heard: robot.baud == FAST
    bench = Bench(robot, rates=RATES, host_baud=FAST)
    bench.run_until(lambda: bench.finished)
    assert isinstance(bench.session.error, LinkLostError) and "from 9600 to 115200 baud" in str(bench.session.error)
    assert bench.session._link.host_baud.wanted is None and not robot.motors and not bench.states


def test_a_line_that_carries_nothing_at_the_new_speed_loses_the_link_in_a_bounded_time():
    robot = robot_at()
    robot.noisy = (FAST,)
    bench = Bench(robot, rates=RATES, host_baud=FAST)
    bench.run_until(lambda: bench.finished)
    assert bench.session._link.host_baud.wanted is None and bench.now < without(robot_at()) + LONGEST


def test_never_while_the_wheels_turn():
    robot = robot_at()
    robot.coasts = True
    bench = Bench(robot, rates=RATES, host_baud=FAST)
    bench.run(1.0)
    assert isinstance(bench.session.phase, Opening) and "HOSTBAUD" not in robot.names()
    robot.coasts = False
    bench.until_ready()
    assert bench.session.line.baud == FAST


def test_a_robot_that_goes_on_rolling_is_ready_all_the_same_and_asked_the_next_time():
    robot = robot_at()
    robot.coasts = True
    bench = Bench(robot, rates=RATES, host_baud=FAST).until_ready()
    assert "HOSTBAUD" not in robot.names() and "stand still" in bench.event(LineSpeed).problem
    assert bench.session._link.host_baud.wanted is not None
    assert bench.now < without(robot_at()) + 1.2


def test_closing_meanwhile_stops_it():
    robot = robot_at()
    bench = Bench(robot, rates=RATES, host_baud=FAST)
    bench.run_until(lambda: robot.baud == FAST)
    bench.run(0.1)
    bench.close()
    assert bench.run_until(lambda: bench.finished) < 0.9
    assert robot.phase == WAITING and robot.baud == OWN


@pytest.mark.parametrize("rates", [(OWN, FAST, 38400, 19200, 57600), RATES], ids=["told which", "not told"])
def test_a_robot_left_at_the_raised_speed_by_a_crash_is_closed_there_and_found_at_its_own(rates):
    robot = robot_at(FAST)
    robot.own_baud = OWN
    robot.open()
    robot.motors, robot.set_point["VEL"], robot.watchdog_expired = True, 300, True
    bench = Bench(robot, rates=rates).until_ready()
    assert bench.session.connected.own_baud == OWN and not robot.revived and not robot.motors
    assert not [event for event in bench.events if isinstance(event, BaudFound)], "its own speed was the one given"
    assert robot.phase == OPEN
