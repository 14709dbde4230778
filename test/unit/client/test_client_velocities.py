"""The velocities of the wheels: golden bytes, clamping that keeps the curve, rounding that is right on average.

All other rules of velocities hold for them too.
"""

import math
import random
from dataclasses import replace

import pytest

from pioneer_control import p2os
from pioneer_control.client.events import CommandTimedOut, MotionCleared
from pioneer_control.client.identity import identify
from pioneer_control.client.velocities import WheelVelocities
from pioneer_control.errors import UsageError
from pioneer_control.robots import find_model

from fake_robot import Bench


def identity(subtype="p3dx-sh", max_linear=0.75, max_angular=math.radians(100)):
    """Return the identity of a robot that reports only these limits."""
    reported = identify(p2os.SyncReply("fake", "Pioneer", subtype), find_model(subtype), None)
    return replace(reported, max_linear=max_linear, max_angular=max_angular)


def units(packet):
    return p2os.two_bytes(p2os.decode_command(p2os.FrameDecoder().feed(packet)[0]).value)


def sent(wheels, left, right, now=0.0):
    packet, = wheels.packets(left, right, now)
    return units(packet)


def wheels_driven(bench):
    return [p2os.two_bytes(heard.value) for heard in bench.robot.heard if heard.name == "VEL2"]


def drive_wheels(bench, left, right):
    bench.session.connected.drive.set_wheel_velocities(left, right, bench.now)
    bench.act()


def with_motors(bench):
    bench.until_driving(0.1)
    bench.drive(0.0, 0.0)
    bench.run(0.5)
    bench.robot.heard.clear()
    return bench


@pytest.mark.parametrize("left, right, golden", [
    (0.2, 0.2, "FA FB 06 20 3B 0A 0A 2A 45"),
    (0.2, -0.2, "FA FB 06 20 3B F6 0A 16 45"),
    (-0.2, 0.2, "FA FB 06 20 3B 0A F6 2B 31"),
])
def test_wheels_are_the_golden_bytes(left, right, golden):
    assert WheelVelocities(identity()).packets(left, right, 0.0) == (bytes.fromhex(golden),)


def test_a_pioneer_1_counts_in_4_mm():
    assert sent(WheelVelocities(identity("pion1m")), 0.2, 0.1) == (50, 25)


@pytest.mark.parametrize("left, right, clamped", [
    (3.0, 3.0, (37, 37)),               # 0.75 m/s are 37.5 units
    (-3.0, -3.0, (-37, -37)),
    (3.0, 1.5, (50, 25)),               # the mean of both is the speed of the robot
    (1.0, -1.0, (15, -15)),             # 100 deg/s are 15.6 units either way
    (1e300, 5e299, (50, 25)), (1.7e308, -1.7e308, (15, -15)),
])
def test_beyond_a_limit_the_curve_stays(left, right, clamped):
    got = sent(WheelVelocities(identity(max_linear=0.75)), left, right)
    assert got == pytest.approx(clamped, abs=1)
    assert math.copysign(1, got[0]) == math.copysign(1, left) and abs(sum(got)) <= 75 and abs(got[1] - got[0]) <= 31.2


def test_a_wheel_goes_no_faster_than_the_wire_carries():
    limits = identity(max_linear=100.0, max_angular=100.0)
    assert sent(WheelVelocities(limits), 30.0, 30.0) == (127, 127)
    assert sent(WheelVelocities(limits), -30.0, 20.0) == (-127, 85)


def test_a_limit_of_nothing_moves_nothing_along_it():
    assert sent(WheelVelocities(identity(max_linear=0.0)), 0.3, 0.2) == (0, 0)
    assert sent(WheelVelocities(identity(max_linear=0.0)), -0.1, 0.1) == (-5, 5)
    assert sent(WheelVelocities(identity(max_angular=0.0)), 0.2, 0.2) == (10, 10)
    assert sent(WheelVelocities(identity(max_linear=0.009)), 0.2, 0.2) == (0, 0), "one unit would be 0.02 m/s"


def test_no_limit_is_exceeded_whatever_is_asked_for_and_whatever_is_owed():
    chance = random.Random(5)
    for _ in range(60):
        max_linear, max_angular = chance.uniform(0.0, 1.5), chance.uniform(0.0, 4.0)
        wheels, now = WheelVelocities(identity(max_linear=max_linear, max_angular=max_angular)), 0.0
        for _ in range(60):
            now += chance.uniform(0.0, 0.5)
            left, right = (each * 0.02 for each in sent(wheels, chance.uniform(-2, 2), chance.uniform(-2, 2), now))
            assert abs(left + right) / 2 <= max_linear + 1e-9 and abs(right - left) / 2 * 5.6 <= max_angular + 1e-9


def test_where_both_limits_meet_the_nearest_speeds_within_them_are_driven():
    chance = random.Random(6)
    for _ in range(300):
        limits = identity(max_linear=chance.uniform(0.2, 1.2), max_angular=chance.uniform(0.5, 4.0))
        difference = limits.max_angular / 5.6
        left, right = sent(WheelVelocities(limits), limits.max_linear - difference, limits.max_linear + difference)
        expected = (limits.max_linear - difference, limits.max_linear + difference)
        assert (left * 0.02, right * 0.02) == pytest.approx(expected, abs=0.045)


def test_a_limit_that_becomes_lower_is_kept_at_once():
    wheels = WheelVelocities(identity(max_linear=0.75))
    assert sent(wheels, 1.0, 1.0, 0.0) == (37, 37)
    wheels.follow(identity(max_linear=0.738))
    assert 71 < sum(sent(wheels, 1.0, 1.0, 0.01)) <= 73


@pytest.mark.parametrize("left, right", [
    (0.013, 0.013), (0.11, 0.105), (-0.007, 0.007), (0.0, 0.051), (0.2, -0.011), (0.004, 0.3)])
def test_speeds_between_two_units_are_right_on_average(left, right):
    wheels, totals = WheelVelocities(identity()), [0.0, 0.0]
    for step in range(600):
        for side, each in enumerate(sent(wheels, left, right, 10.0 + step * 0.1)):
            totals[side] += each * 0.02 / 600
    assert totals == pytest.approx([left, right], abs=0.0008)


def test_a_step_is_kept_for_as_long_as_a_ramp_needs_however_often_it_is_asked_for():
    wheels = WheelVelocities(identity())
    steps = [sent(wheels, 0.05, 0.05, number * 0.01)[0] for number in range(1000)]
    changes = [number * 0.01 for number in range(1, 1000) if steps[number] != steps[number - 1]]
    assert set(steps) == {2, 3} and min(after - before for before, after in zip(changes, changes[1:])) > 0.19
    assert sent(wheels, 0.2, 0.05, 9.995)[0] == 10, "a new speed does not wait"


def test_a_wheel_that_shall_stand_stands():
    wheels = WheelVelocities(identity())
    assert {sent(wheels, 0.0, 0.113, step * 0.1)[0] for step in range(100)} == {0}


# On the line, the same rules as any velocity

def test_on_an_idle_line_it_is_one_write_at_once():
    bench = with_motors(Bench(link_check=False))
    bench.writes.clear()
    drive_wheels(bench, 0.2, 0.2)
    assert bench.writes == {bench.now: [bytes.fromhex("FAFB06203B0A0A2A45")]}


@pytest.mark.parametrize("left, right", [(math.nan, 0.1), (0.1, math.inf)])
def test_what_is_no_finite_number_is_refused_and_changes_nothing(left, right):
    bench = with_motors(Bench())
    drive_wheels(bench, 0.2, 0.1)
    with pytest.raises(UsageError, match="finite"):
        drive_wheels(bench, left, right)
    bench.run(0.3)
    assert set(wheels_driven(bench)) == {(10, 5)} and bench.robot.moving


def test_a_wheel_velocity_that_nobody_renews_means_stop():
    bench = with_motors(Bench())
    drive_wheels(bench, 0.2, 0.1)
    start = bench.now
    bench.run_until(lambda: bench.robot.moving)
    bench.run_until(lambda: not bench.robot.moving)
    assert 0.6 <= bench.now - start < 0.62 and bench.event(CommandTimedOut)
    assert len(wheels_driven(bench)) == 3, "at once, and again each 0.2 s"


def test_zero_is_zero_set_points_for_wheels_and_body():
    bench = with_motors(Bench())
    drive_wheels(bench, 0.2, 0.1)
    bench.robot.heard.clear()
    drive_wheels(bench, 0.0, 0.0)
    assert bench.robot.names()[:2] == ["VEL", "RVEL"] and not bench.robot.moving


def test_a_stop_overtakes_wheels_that_wait_for_a_slow_line_and_the_newest_of_them_wins():
    bench = with_motors(Bench(rates=(9600,)))
    bench.session.connected.command(bench.now, p2os.encode_command("SONAR", 1))
    for units_each in (1, 2, 3):
        drive_wheels(bench, units_each * 0.02, units_each * 0.02)
    bench.run(0.1)
    assert wheels_driven(bench) == [(3, 3)]
    bench.session.connected.command(bench.now, p2os.encode_command("SONAR", 1))
    drive_wheels(bench, 0.1, 0.1)
    bench.session.connected.drive.stop(bench.now)
    bench.run(0.1)
    assert wheels_driven(bench) == [(3, 3)] and not bench.robot.moving


def test_body_and_wheels_take_turns_and_the_newest_counts():
    bench = with_motors(Bench(link_check=False))
    drive_wheels(bench, 0.2, 0.1)
    bench.drive(0.3, 0.0)
    bench.robot.heard.clear()
    bench.run(0.4)
    assert bench.robot.set_point == {"VEL": 300, "RVEL": 0} and wheels_driven(bench) == []
    drive_wheels(bench, 0.2, 0.2)
    bench.robot.heard.clear()
    bench.run(0.4)
    assert set(bench.robot.names()) == {"VEL2"}


def test_what_the_body_was_owed_is_forgotten_while_the_wheels_drive():
    bench = with_motors(Bench(command_timeout=60.0))
    bench.drive(0.0, math.radians(0.4))
    drive_wheels(bench, 0.2, 0.1)
    bench.run(5.0)
    bench.drive(0.0, math.radians(10.0))
    assert bench.robot.set_point["RVEL"] == 10


def test_the_stop_button_clears_the_wheels_too():
    bench = with_motors(Bench(command_timeout=60.0))
    drive_wheels(bench, 0.2, 0.2)
    bench.run(0.2)
    bench.robot.press_stop_button(True)
    bench.run(0.3)
    assert "STOP button" in bench.event(MotionCleared).reason and not any(bench.robot.set_point.values())
    bench.robot.press_stop_button(False)
    bench.robot.motors = True
    bench.run(1.0)
    assert not bench.robot.moving
