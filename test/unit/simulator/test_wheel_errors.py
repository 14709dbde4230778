"""Options of the wheels: each has the right effect, and none when it is off."""

import dataclasses
import math
import statistics

import pytest
from robot_on_bench import Bench

from pioneer_control.simulator.hardware import standard_numbers
from pioneer_control.simulator.hardware.wheels import WheelErrors

RAD_PER_METRE = 5.0     # wheels 0.4 m apart


def numbers(**options):
    return dataclasses.replace(standard_numbers(), wheels=dataclasses.replace(standard_numbers().wheels, **options))


def errors(seed=0, **options):
    return WheelErrors(numbers(**options).wheels, RAD_PER_METRE, seed)


@pytest.mark.parametrize("options, distance, turn, expected", [
    ({}, 1.0, 0.0, (1.0, 0.0)),
    ({}, 0.1, 0.3, (0.1, 0.3)),
    ({"larger": 0.02}, 1.0, 0.5, (1.02, 0.51)),
    ({"larger": -0.02}, -1.0, 0.5, (-0.98, 0.49)),
    ({"right_larger": 0.02}, 1.0, 0.0, (1.0, 0.05)),        # left: the right wheel goes 0.01 m more, the left one less
    ({"right_larger": 0.02}, -1.0, 0.0, (-1.0, -0.05)),
    ({"right_larger": -0.02}, 1.0, 0.0, (1.0, -0.05)),
    ({"right_larger": 0.02}, 0.0, 1.0, (0.002, 1.0)),
    ({"wider_apart": 0.25}, 1.0, 1.0, (1.0, 0.8)),
    ({"wider_apart": -0.2}, 1.0, -1.0, (1.0, -1.25)),
])
def test_systematic_errors(options, distance, turn, expected):
    assert errors(**options).moved(distance, turn) == pytest.approx(expected, abs=1e-12)


def test_nothing_is_touched_when_off():
    for way in ((0.1, 0.2), (1e-17, -3.0), (0.0, 0.0)):
        assert errors().moved(*way) is not None
        assert errors().moved(*way) == way


def test_slip_loses_half_of_it_on_average_and_never_more():
    slipping = errors(slip=0.1)
    ways = [slipping.moved(0.01, 0.0)[0] for _ in range(2000)]
    assert 0.009 <= min(ways) and max(ways) <= 0.01 and statistics.mean(ways) == pytest.approx(0.0095, rel=0.005)


@pytest.mark.parametrize("steps", [1, 10, 100])
def test_noise_has_the_size_it_says_however_the_way_is_cut(steps):
    """After 4 m each wheel is off by noise * sqrt(4), so their mean by that over sqrt(2)."""
    ends = []
    for seed in range(400):
        noisy = errors(seed, noise=0.01)
        ends.append(sum(noisy.moved(4.0 / steps, 0.0)[0] for _ in range(steps)) - 4.0)
    assert statistics.mean(ends) == pytest.approx(0.0, abs=0.0025)
    assert statistics.pstdev(ends) == pytest.approx(0.02 / math.sqrt(2.0), rel=0.12)


def test_the_seed_decides():
    def run(seed):
        noisy = errors(seed, slip=0.1, noise=0.01)
        return [noisy.moved(0.01, 0.002) for _ in range(5)]

    assert run(3) == run(3) != run(4)


def driven(command, value, seconds, **options):
    """Return a robot after a command, and the bytes that it sent."""
    bench = Bench(numbers=numbers(**options), gripper=False).open().send("SETV", 500).send(command, value)
    return bench.wait(seconds, alive=True)


@pytest.mark.parametrize("options, x, heading_deg, within_deg", [
    ({}, 3.0, 0.0, 0.0001),
    ({"larger": 0.05}, 3.15, 0.0, 0.0001),
    ({"slip": 0.1}, 2.85, 0.0, 2.0),                        # each wheel for itself
    ({"right_larger": 0.01}, 3.0, math.degrees(0.01 / 2 * 3.0 * 1000.0 * 0.0056), 0.1),    # DiffConvFactor of a p3dx-sh
])
def test_a_robot_that_counts_three_metres(options, x, heading_deg, within_deg):
    bench = driven("MOVE", 3000, 12, **options)
    true_x, _, heading = bench.robot.true_pose
    assert bench.robot.hardware.odometry.pose == pytest.approx((3.0, 0.0, 0.0), abs=1e-6)
    assert true_x == pytest.approx(x, abs=0.01) and math.degrees(heading) == pytest.approx(heading_deg, abs=within_deg)


@pytest.mark.parametrize("options, turned_deg", [
    ({}, 180.0),
    ({"wider_apart": 0.05}, 171.4),
    ({"wider_apart": -0.05}, 189.5),
    ({"larger": 0.02}, 183.6),
])
def test_a_robot_that_counts_half_a_turn(options, turned_deg):
    bench = driven("DHEAD", 180, 8, **options)
    assert math.degrees(bench.robot.hardware.odometry.pose[2]) == pytest.approx(180.0, abs=0.1)
    assert math.degrees(bench.robot.true_pose[2]) == pytest.approx(turned_deg, abs=0.3)


def test_the_encoders_count_what_the_wheels_rolled():
    wrong, right = driven("MOVE", 1000, 8, larger=0.1, slip=0.3), driven("MOVE", 1000, 8)
    assert wrong.robot.hardware.wheels.ticks == right.robot.hardware.wheels.ticks


def test_a_client_can_calibrate_it_away():
    """The owner of a real robot corrects TICKSMM and REVCOUNT: 2 percent larger wheels need 2 percent fewer ticks."""
    bench = Bench(numbers=numbers(larger=0.024), gripper=False).open().send("TICKSMM", 125).send("MOVE", 2000)
    bench.wait(10, alive=True)
    assert bench.robot.true_pose[0] == pytest.approx(2.0, abs=0.005)


def test_a_gyro_feels_the_true_turn():
    """A robot that makes its heading with a gyro knows how far it really turned, however far apart its wheels are."""
    fused = dataclasses.replace(numbers(wider_apart=0.1), gyro=dataclasses.replace(standard_numbers().gyro, kind=2))
    bench = Bench(numbers=fused, gripper=False).open().send("DHEAD", 90).wait(6, alive=True)
    assert bench.robot.hardware.odometry.pose[2] == pytest.approx(bench.robot.true_pose[2], abs=1e-9)
    assert bench.robot.hardware.odometry.pose[2] < math.radians(90.0)


def test_a_left_wheel_without_grip_loses_another_share_on_each_patch():
    slipping = errors(left_slip=0.5)
    lost = []
    for _ in range(400):
        forward, turn = slipping.moved(0.06, 0.0)
        lost.append(2.0 * (0.06 - forward) / 0.06)
        assert turn == pytest.approx(0.06 * lost[-1] / 2.0 * RAD_PER_METRE)     # to the left
    assert 0.0 <= min(lost) and max(lost) <= 0.5 and statistics.mean(lost) == pytest.approx(0.25, abs=0.05)
    assert len({round(each, 9) for each in lost}) == pytest.approx(80, abs=1)   # 24 m, five steps on each patch


def test_a_gyro_of_the_client_that_measures_too_much():
    made = dataclasses.replace(numbers(), gyro=dataclasses.replace(standard_numbers().gyro, kind=1, larger=0.1))
    bench = Bench(numbers=made, gripper=False).open().send("DHEAD", 90)
    gyro, measured = bench.robot.hardware.gyro, 0.0
    for _ in range(60):
        bench.wait(0.1, alive=True)
        measured += sum(512 - reading for reading, _ in gyro.take_readings()) * 0.025
    unit = math.radians(5.0 / 1023.0 * 300.0 / 2.5 * 1.626)
    assert measured * unit == pytest.approx(1.1 * bench.robot.true_pose[2], rel=0.01)
