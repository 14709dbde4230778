"""Velocities, deadman and motors: the packets on the wire, and their times."""

import math

import pytest

from pioneer_control import p2os
from pioneer_control.client.velocities import FairRounding
from pioneer_control.client.events import CommandTimedOut, MotionCleared, Unmoved
from pioneer_control.errors import LinkLostError, NotConfirmedError, RefusedError, UsageError

from fake_robot import Bench, FakeRobot, config, sip


def velocities(robot):
    """Return the pairs of VEL and RVEL in the order in which the robot heard them."""
    linear = [heard.value for heard in robot.heard if heard.name == "VEL"]
    return list(zip(linear, [heard.value for heard in robot.heard if heard.name == "RVEL"]))


def with_motors(bench):
    """Return a bench that is ready, with motors on and the robot at rest for a while."""
    bench.until_ready()
    request = enable(bench)
    bench.run_until(lambda: request.done)
    bench.run(0.5)
    return bench


def enable(bench, on=True, timeout=2.0):
    return bench.session.connected.drive.request_motors(on, bench.now, timeout)


def test_a_velocity_on_an_idle_line_is_one_write_at_once():
    bench = Bench(link_check=False).until_ready()
    bench.run(0.5)
    bench.writes.clear()
    bench.drive(0.2, -0.5)
    assert bench.writes == {bench.now: [bytes.fromhex("FAFB060B3BC800D33B") + bytes.fromhex("FAFB06151B1D00321B")]}


@pytest.mark.parametrize("linear, angular", [(math.nan, 0.5), (0.2, math.nan), (math.inf, 0), (0, -math.inf)])
def test_what_is_no_finite_number_is_refused_and_changes_nothing(linear, angular):
    bench = Bench().until_driving(0.2)
    with pytest.raises(UsageError, match="finite"):
        bench.drive(linear, angular)
    bench.run(0.3)
    assert set(velocities(bench.robot)) == {(200, 0)}
    bench.drive(0.1, 0.0)
    assert velocities(bench.robot)[-1] == (100, 0)


@pytest.mark.parametrize("linear, angular, sent", [
    (65.6, 0, (750, 0)), (-65.6, 0, (-750, 0)), (0, 1e9, (0, 100)), (1e300, -1e300, (750, -100))])
def test_velocities_are_clamped_to_what_the_robot_can_do(linear, angular, sent):
    bench = Bench().until_ready()
    bench.drive(linear, angular)
    assert velocities(bench.robot)[-1] == sent


def test_the_users_limits_are_below_the_robots():
    bench = Bench(max_linear=0.3, max_angular=math.radians(20.4)).until_ready()
    bench.drive(1, 1)
    bench.run(0.5)
    assert velocities(bench.robot)[-1] == (300, 20)
    assert Bench(max_linear=9.0).until_ready().session.connected.identity.max_linear == 0.75


def test_a_limit_beyond_the_wire_is_cut_at_the_wire():
    robot = FakeRobot()
    robot.config = config(translation_velocity_max_mm_s=65535, translation_velocity_top_mm_s=65535)
    bench = Bench(robot).until_ready()
    bench.drive(60.0, 0.0)
    assert velocities(robot)[-1] == (32767, 0)


def test_a_creep_ends_at_zero():
    bench = Bench().until_driving(0.3)
    bench.drive(0.01, 0)
    bench.run(0.1)
    assert bench.robot.set_point["VEL"] == 10
    bench.drive(0, 0)
    assert bench.robot.set_point["VEL"] == 0


def test_zero_overtakes_a_velocity_that_waits_for_a_slow_line():
    bench = Bench(rates=(9600,)).until_driving(0.3)
    bench.run(0.1)
    bench.robot.heard.clear()
    for linear in (0.1, 0.2, 0.0):
        bench.drive(linear, 0.0)
    assert velocities(bench.robot) == [(100, 0), (0, 0)]
    bench.run(0.1)
    assert bench.robot.set_point["VEL"] == 0


def test_zero_is_repeated_until_the_robot_stands():
    bench = Bench(pulse=0).until_driving(0.3)
    bench.robot.coasts = True
    bench.drive(0, 0)
    bench.run(2.0)
    assert velocities(bench.robot).count((0, 0)) >= 9
    bench.robot.coasts = False
    bench.run(0.3)
    bench.robot.heard.clear()
    bench.run(0.8)
    assert bench.robot.heard == []


def test_a_lost_stop_is_made_good():
    bench = Bench().until_driving(0.3)
    bench.robot.deaf = lambda heard: heard.time == lost_at
    lost_at = bench.now
    bench.drive(0, 0)
    assert bench.robot.moving
    assert bench.run_until(lambda: not bench.robot.moving) <= 0.25


def test_a_stop_is_not_held_for_done_by_a_packet_from_before_it():
    bench = with_motors(Bench())
    bench.drive(0.2, 0)
    bench.now = lost_at = bench.now + 0.001
    bench.robot.deaf = lambda heard: heard.time == lost_at
    bench.drive(0, 0)
    bench.session.receive(p2os.encode_packet(sip(flags=p2os.Flags.MOTORS_ENABLED)), lost_at + 0.001)
    assert bench.robot.moving and bench.states[-1].linear == 0, "that packet left the robot before it moved"
    assert bench.run_until(lambda: not bench.robot.moving) <= 0.35


def test_a_robot_that_moves_unbidden_is_told_to_stand():
    bench = with_motors(Bench())
    bench.robot.set_point["VEL"] = 200
    assert bench.run_until(lambda: not bench.robot.moving) <= 0.11


def test_a_velocity_that_nobody_renews_means_stop():
    bench = Bench().until_ready()
    bench.until_driving(0.2)
    start = bench.now - 0.15
    bench.run_until(lambda: not bench.robot.moving)
    assert 0.6 <= bench.now - start < 0.62
    assert bench.event(CommandTimedOut).age == pytest.approx(0.6, abs=0.011)
    bench.run(3.0)
    assert not bench.robot.moving


def test_a_renewed_velocity_goes_on_and_lost_packets_are_made_good():
    bench = Bench().until_driving(0.2)
    bench.robot.heard.clear()
    for _ in range(6):
        bench.drive(0.2, 0)
        bench.run(0.5)
        assert bench.robot.moving
    assert not [event for event in bench.events if isinstance(event, CommandTimedOut)]
    assert len(velocities(bench.robot)) >= 12


@pytest.mark.parametrize("then", ["another command", "motors"])
def test_a_velocity_that_waits_through_a_hold_up_is_not_sent(then):
    """For a while nobody calls the session. The next call comes from a user's thread, before the deadman could act."""
    bench = Bench(rates=(9600,)).until_driving()
    bench.session.connected.command(bench.now, p2os.encode_command("TTY2", b"x" * 100))
    bench.drive(0.3, 0.0)
    assert ("VEL", 300) not in [(heard.name, heard.value) for heard in bench.robot.heard], "the line is busy"
    bench.now += 3.0
    if then == "motors":
        bench.session.connected.drive.request_motors(True, bench.now, 2.0)
    else:
        bench.session.connected.command(bench.now, p2os.encode_command("SONAR", 1))
    bench.act()
    bench.run(0.5)
    assert ("VEL", 300) not in [(heard.name, heard.value) for heard in bench.robot.heard]
    assert not bench.robot.moving and not bench.robot.revived


def test_one_that_was_repeated_and_waits_is_not_sent_either_after_the_command_timeout():
    bench = Bench(rates=(9600,)).until_driving()
    bench.drive(0.3, 0.0)
    bench.run(0.19)
    bench.session.connected.command(bench.now, p2os.encode_command("TTY2", b"x" * 100))
    bench.run(0.03)     # now it would be repeated
    bench.robot.heard.clear()
    bench.now += 0.45
    bench.session.connected.command(bench.now, p2os.encode_command("SONAR", 1))
    bench.act()
    bench.run(0.5)
    assert "SONAR" in bench.robot.names()
    assert ("VEL", 300) not in [(heard.name, heard.value) for heard in bench.robot.heard]


def test_the_command_timeout_can_be_chosen():
    bench = Bench(command_timeout=2.5).until_driving(0.2)
    bench.run(2.2)
    assert bench.robot.moving
    bench.run(0.3)
    assert not bench.robot.moving


def test_a_stop_is_stop_and_zero_set_points():
    bench = Bench().until_driving(0.2)
    bench.robot.heard.clear()
    bench.session.connected.drive.stop(bench.now)
    bench.step()
    assert [(heard.name, heard.value) for heard in bench.robot.heard[:3]] == [("STOP", None), ("VEL", 0), ("RVEL", 0)]


# Motors

def test_motors_are_off_until_asked_and_confirmed_by_the_robot():
    bench = Bench().until_ready()
    bench.run(1.0)
    assert not bench.robot.motors and not bench.states[-1].motors_enabled
    request = enable(bench)
    bench.step()
    assert not request.done
    bench.run_until(lambda: request.done)
    assert request.error is None and bench.states[-1].motors_enabled


def test_the_first_packet_of_enabling_is_a_stop():
    bench = Bench().until_ready()
    bench.run(0.5)
    bench.robot.heard.clear()
    enable(bench)
    bench.run(0.1)
    assert bench.robot.names()[:4] == ["STOP", "VEL", "RVEL", "ENABLE"]


def test_enabling_again_does_not_stop_a_robot_that_drives():
    bench = Bench().until_driving(0.2)
    request = enable(bench)
    bench.run(0.2)
    assert request.done and request.error is None and bench.robot.moving


def test_a_lost_enable_is_sent_again():
    bench = Bench().until_ready()
    bench.robot.deaf = lambda heard: heard.name == "ENABLE" and heard.time < bench.now_limit
    bench.now_limit = bench.now + 0.5
    request = enable(bench)
    assert 0.5 < bench.run_until(lambda: request.done) < 0.9
    assert request.error is None and bench.robot.names().count("ENABLE") >= 4


def test_motors_that_are_never_confirmed_are_given_up_and_not_asked_for_again():
    bench = Bench().until_ready()
    bench.robot.deaf = lambda heard: heard.name == "ENABLE"
    request = enable(bench, timeout=1.0)
    assert bench.run_until(lambda: request.done) == pytest.approx(1.0, abs=0.02)
    assert isinstance(request.error, NotConfirmedError)
    bench.run(0.1)
    assert bench.session.wake_at > bench.now
    bench.robot.deaf = lambda heard: False
    bench.robot.heard.clear()
    bench.run(2.0)
    assert "ENABLE" not in bench.robot.names() and not bench.robot.motors


@pytest.mark.parametrize("stalled", [False, True])
def test_a_stall_is_given_as_the_reason_why_motors_stay_off(stalled):
    bench = Bench().until_ready()
    bench.robot.stalled = stalled
    bench.robot.deaf = lambda heard: heard.name == "ENABLE"
    request = enable(bench, timeout=1.0)
    bench.run_until(lambda: request.done)
    assert ("did not confirm it in time" in str(request.error), "stalled" in str(request.error)) == (True, stalled)


def test_a_pressed_stop_button_refuses_and_its_release_enables_nothing():
    bench = Bench().until_ready()
    bench.robot.press_stop_button(True)
    bench.run(0.3)
    bench.robot.heard.clear()
    request = enable(bench)
    assert request.done and isinstance(request.error, RefusedError) and "STOP button" in str(request.error)
    bench.robot.press_stop_button(False)
    bench.run(2.0)
    assert "ENABLE" not in bench.robot.names() and not bench.robot.motors


def test_a_stop_button_pressed_while_waiting_refuses():
    bench = Bench().until_ready()
    bench.robot.deaf = lambda heard: heard.name == "ENABLE"
    request = enable(bench)
    bench.run(0.3)
    bench.robot.press_stop_button(True)
    bench.run(0.15)
    assert isinstance(request.error, RefusedError)


def test_disabling_stops_first_and_is_confirmed():
    bench = Bench().until_driving(0.2)
    bench.robot.heard.clear()
    request = enable(bench, on=False)
    bench.run_until(lambda: request.done)
    assert request.error is None and not bench.robot.motors
    assert bench.robot.names()[:4] == ["STOP", "VEL", "RVEL", "ENABLE"]
    assert not [event for event in bench.events if isinstance(event, MotionCleared)]


def test_a_second_request_overtakes_the_first():
    bench = Bench().until_ready()
    bench.robot.deaf = lambda heard: heard.name == "ENABLE" and heard.value == 1
    first = enable(bench)
    bench.run(0.05)
    second = enable(bench, on=False)
    assert first.done and isinstance(first.error, NotConfirmedError)
    bench.run_until(lambda: second.done)
    assert second.error is None


def test_the_same_request_again_joins_the_first():
    bench = Bench().until_ready()
    bench.robot.deaf = lambda heard: heard.name == "ENABLE"
    first = enable(bench, timeout=1.0)
    bench.run(0.5)
    assert enable(bench, timeout=1.0) is first
    assert bench.run_until(lambda: first.done) == pytest.approx(0.5, abs=0.02)


def test_who_asks_again_and_again_gets_an_answer_too():
    bench = Bench().until_ready()
    bench.robot.deaf = lambda heard: heard.name == "ENABLE"
    first = enable(bench, timeout=1.0)
    for _ in range(15):
        enable(bench, timeout=1.0)
        bench.run(0.1)
    assert isinstance(first.error, NotConfirmedError)


def test_a_flood_of_motor_requests_does_not_outlive_itself():
    bench = Bench(rates=(9600,)).until_ready()
    for number in range(999):
        request = enable(bench, on=number % 2 == 1)
        if number % 5 == 0:
            bench.step()
    request = enable(bench, on=False)
    bench.run(1.0)
    assert request.done and request.error is None and not bench.robot.motors
    bench.robot.heard.clear()
    bench.run(1.0)
    assert "ENABLE" not in bench.robot.names()


def test_flags_from_before_the_request_confirm_nothing():
    bench = Bench().until_driving(0.2)
    first = enable(bench, on=False)
    second = enable(bench)
    assert first.done and not second.done, "the last packet still says on"
    bench.run_until(lambda: second.done)
    assert second.error is None and bench.robot.motors


def test_a_packet_that_was_under_way_when_motors_were_switched_confirms_nothing():
    bench = Bench().until_ready()
    enable(bench)
    bench.run(0.03)
    bench.robot.deaf = lambda heard: heard.name == "ENABLE" and heard.value == 0
    request = enable(bench, on=False)
    bench.session.receive(p2os.encode_packet(sip()), bench.now + 0.03)
    assert not request.done and bench.robot.motors
    bench.robot.deaf = lambda heard: False
    bench.run_until(lambda: request.done)
    assert request.error is None and not bench.robot.motors


def test_motors_that_come_on_after_they_were_given_up_are_switched_off():
    bench = Bench().until_ready()
    bench.robot.mute = lambda packet: True      # it obeys, but that is not heard
    request = enable(bench, timeout=1.0)
    bench.run_until(lambda: request.done)
    bench.step()
    assert isinstance(request.error, NotConfirmedError) and not bench.robot.motors


@pytest.mark.parametrize("why", ["not confirmed", "STOP button"])
def test_taking_back_the_motors_is_repeated_until_the_robot_shows_it(why):
    bench = Bench().until_ready()

    def deaf(heard):
        off = [each for each in bench.robot.heard if (each.name, each.value) == ("ENABLE", 0)]
        return (heard.name, heard.value) == ("ENABLE", 0) and bench.robot.heard.count(heard) < 2 and len(off) < 4

    bench.robot.deaf = deaf
    bench.robot.mute = lambda packet: True
    request = enable(bench, timeout=1.0)
    if why == "STOP button":
        bench.run(0.1)
        bench.robot.stop_button = True          # seen by the robot, its motors not yet off
        bench.robot.mute = lambda packet: False
    bench.run_until(lambda: request.done)
    bench.robot.mute = lambda packet: False
    bench.run(1.5)
    assert request.error is not None and not bench.robot.motors


@pytest.mark.parametrize("answer", ["confirmed", "given up", "STOP button", "overtaken"])
def test_once_a_request_is_answered_no_repetition_of_it_is_sent(answer):
    """At 9600 baud a repetition may still wait for the line. Meanwhile a user may press and release the STOP button."""
    bench = Bench(rates=(9600,)).until_ready()
    bench.run(0.5)
    bench.robot.deaf = lambda heard: heard.name == "ENABLE" and answer != "confirmed"
    request = enable(bench, timeout=0.7 if answer == "given up" else 5.0)
    for _ in range(20):
        bench.session.connected.command(bench.now, p2os.encode_command("TTY2", b"x" * 100))
    bench.run(0.45)
    if answer == "STOP button":
        bench.robot.press_stop_button(True)
    elif answer == "overtaken":
        bench.session.connected.drive.request_motors(False, bench.now, 5.0)
    bench.run_until(lambda: request.done)
    bench.robot.heard.clear()
    bench.run(4.0)
    assert ("ENABLE", 1) not in [(heard.name, heard.value) for heard in bench.robot.heard]


def test_after_a_hold_up_a_request_that_is_given_up_is_not_sent_before_it_is_taken_back():
    """In the same tick the line becomes free and the time of the request is over."""
    bench = Bench(rates=(9600,)).until_ready()
    bench.run(0.5)
    bench.robot.deaf = lambda heard: heard.name == "ENABLE"
    request = enable(bench, timeout=1.0)
    bench.run(0.1)
    bench.now += 0.5
    bench.session.connected.command(bench.now, p2os.encode_command("TTY2", b"x" * 100))
    bench.session.connected.drive.tick(bench.now)   # ENABLE 1 is repeated, and waits for the line
    bench.act()
    assert bench.session.line.waiting == 1
    bench.now += 1.5
    bench.session.connected.drive.tick(bench.now)
    bench.act()
    assert request.done and bench.writes[bench.now] == [p2os.encode_command("ENABLE", 0)]


def test_a_link_that_breaks_ends_the_wait():
    bench = Bench().until_ready()
    bench.robot.deaf = lambda heard: heard.name == "ENABLE"
    request = enable(bench)
    bench.session.fail(LinkLostError("pulled"))
    assert request.done and isinstance(request.error, LinkLostError)


def test_the_stop_button_clears_the_set_points_and_nothing_moves_after_its_release():
    bench = Bench(command_timeout=60.0).until_driving(0.2)
    bench.robot.press_stop_button(True)
    bench.run(0.3)
    assert "STOP button" in bench.event(MotionCleared).reason
    assert bench.robot.set_point == {"VEL": 0, "RVEL": 0}
    bench.robot.press_stop_button(False)
    bench.robot.motors = True               # by the MOTORS button
    bench.run(3.0)
    assert not bench.robot.moving
    bench.drive(0.1, 0)
    assert bench.robot.moving


# A robot that does not do what it is told

def still_commanding(bench, seconds, linear=0.2, angular=0.0):
    """A user who goes on commanding."""
    end = bench.now + seconds
    while bench.now < end:
        bench.drive(linear, angular)
        bench.run(0.1)


def unmoved(bench):
    return [event for event in bench.events if isinstance(event, Unmoved)]


def test_a_robot_that_hears_nothing_is_told_of_once_until_it_has_moved():
    bench = Bench().until_driving(0.2)
    bench.robot.deaf = lambda heard: True
    still_commanding(bench, 2.0)        # it drives on, until its watchdog stops it
    assert not unmoved(bench)
    still_commanding(bench, 6.0)
    assert [event.age for event in unmoved(bench)] == [pytest.approx(2.05, abs=0.06)]
    bench.robot.deaf = lambda heard: False
    still_commanding(bench, 1.0)
    bench.robot.deaf = lambda heard: True
    still_commanding(bench, 6.0)
    assert len(unmoved(bench)) == 2


@pytest.mark.parametrize("why", [
    "the motors are off", "a wheel is stalled", "nobody wants more", "it is too slow to be sure of"])
def test_a_robot_that_has_a_reason_to_stand_is_not(why):
    bench = with_motors(Bench())
    bench.robot.deaf = lambda heard: heard.name in ("VEL", "RVEL")
    bench.robot.motors = why != "the motors are off"
    bench.robot.stalled = why == "a wheel is stalled"
    wanted = {"nobody wants more": dict(linear=0.0), "it is too slow to be sure of": dict(linear=0.01)}
    still_commanding(bench, 6.0, **wanted.get(why, {}))
    assert not unmoved(bench)


# Rounding

def average(rate, seconds=60.0, period=0.1):
    rounding, total, now = FairRounding(), 0.0, 100.0
    for _ in range(round(seconds / period)):
        total += rounding.units(rate, 100, now) * period
        now += period
    return total / seconds


@pytest.mark.parametrize("rate", [0.4, 0.04, 0.5, 1.5, -0.4, 17.3, -99.9])
def test_rates_between_two_units_are_right_on_average(rate):
    assert average(rate) == pytest.approx(rate, abs=0.02)


def test_zero_is_zero_whatever_is_owed():
    rounding = FairRounding()
    for index in range(9):
        rounding.units(0.4, 100, index * 0.1)
    assert [rounding.units(0, 100, 5 + index * 0.1) for index in range(20)] == [0] * 20


def test_what_a_limit_took_away_is_not_owed():
    rounding = FairRounding()
    for index in range(9):
        rounding.units(1e9, 100, index * 1.0)
    assert rounding.units(10.0, 100, 9.0) == 10


def test_rounding_never_exceeds_the_limit():
    rounding = FairRounding()
    assert max(rounding.units(99.7, 99, index * 0.1) for index in range(100)) == 99
    rounding.units(0.4, 100, 20.0)
    assert rounding.units(100.0, 100, 25.0) == 100, "though two degrees are owed"


def test_a_slow_turn_is_not_lost_over_a_minute():
    bench = Bench().until_driving(0.0, math.radians(2.0))
    bench.robot.heard.clear()
    turned, now = 0.0, bench.now
    while bench.now < now + 60:
        bench.drive(0.0, math.radians(0.4))
        bench.step()
        turned += bench.robot.set_point["RVEL"] * 0.005
    assert turned == pytest.approx(24.0, abs=1.0)


def test_speeds_are_reported_in_si():
    bench = Bench().until_driving(0.2, 0.5)
    bench.run(0.2)
    assert bench.states[-1].linear == pytest.approx(0.2)
    assert bench.states[-1].angular == pytest.approx(math.radians(28.6), abs=math.radians(1.1))
    assert isinstance(bench.states[-1].flags, p2os.Flags)


def test_motors_that_do_not_go_off_are_given_up_and_nothing_is_taken_back():
    bench = Bench().until_driving()
    bench.robot.deaf = lambda heard: heard.name == "ENABLE"
    request = bench.session.connected.drive.request_motors(False, bench.now, 1.0)
    assert bench.run_until(lambda: request.done) == pytest.approx(1.0, abs=0.02)
    assert isinstance(request.error, NotConfirmedError) and "asked to switch its motors off" in str(request.error)
    bench.robot.heard.clear()
    bench.run(2.0)
    assert "ENABLE" not in bench.robot.names() and not bench.robot.moving
