"""Odometry with the factors of a calibrated robot: by hand calculation, and in whole millimetres as a robot counts."""

import math
from dataclasses import replace

import pytest

from pioneer_control.client.corrected_odometry import CorrectedOdometry, Correction, odometry_of
from pioneer_control.client.odometry import Odometry
from pioneer_control.robots import find_model

UNITS = 4096


def drive(odometry, steps, start=(0.0, 0.0, 0.0)):
    """Let a robot count these steps (mm, rad) from ``start`` (mm, mm, rad), in whole units."""
    x, y, heading = start
    odometry.update(round(x), round(y), round(heading / (2 * math.pi) * UNITS) % UNITS)
    for ahead, turned in steps:
        heading += turned / 2
        x, y = x + ahead * math.cos(heading), y + ahead * math.sin(heading)
        heading += turned / 2
        assert odometry.update(round(x) & 0x7FFF, round(y) & 0x7FFF, round(heading / (2 * math.pi) * UNITS) % UNITS)


@pytest.mark.parametrize("start", [(0.0, 0.0, 0.0), (100.0, -200.0, 2.5)])
def test_a_straight_line_that_is_a_bend(start):
    """5 m that bend 0.02 rad/m: an arc with radius 50 m, whatever the robot's own frame."""
    odometry = CorrectedOdometry(1.0, UNITS, Correction(1.0, 0.02))
    drive(odometry, [(10.0, 0.0)] * 500, start)
    assert odometry.pose == pytest.approx((50 * math.sin(0.1), 50 * (1 - math.cos(0.1)), 0.1), abs=0.004)
    assert odometry.turned == 0.0 and odometry.travel == pytest.approx(5.0, abs=0.005)


def test_whole_turns_that_are_more():
    """Ten turns by its count are ten and a half; then a metre ahead goes back, by its count ahead."""
    odometry = CorrectedOdometry(1.0, UNITS, Correction(1.05, 0.0))
    drive(odometry, [(0.0, math.pi / 30)] * 600)
    turned = odometry.pose[2]
    assert abs(turned) == pytest.approx(math.pi, abs=0.06)
    drive_on = odometry.pose
    for millimetre in range(0, 1001, 20):
        odometry.update(millimetre, 0, odometry.heading_units % UNITS)
    x, y, _ = odometry.pose
    assert (x - drive_on[0], y - drive_on[1]) == pytest.approx((math.cos(turned), math.sin(turned)), abs=0.01)


def test_a_square_of_a_robot_that_turns_too_far():
    """Corners of 0.01 rad too much: by hand it ends 2 * side * 0.01 ahead and as much to the right."""
    odometry = CorrectedOdometry(1.0, UNITS, Correction(1.0 + 0.01 / (math.pi / 2), 0.0))
    side = [(20.0, 0.0)] * 100 + [(0.0, math.pi / 20)] * 10
    drive(odometry, side * 4)
    assert odometry.pose == pytest.approx((0.04, -0.04, 0.04), abs=0.005)


def test_without_a_correction_it_is_the_same_as_ever():
    steps = [(7.0, 0.01), (3.0, -0.2), (0.0, 1.0)] * 50
    plain, corrected = Odometry(1.0, UNITS), CorrectedOdometry(1.0, UNITS, Correction())
    drive(plain, steps, (5.0, 6.0, 1.0))
    drive(corrected, steps, (5.0, 6.0, 1.0))
    assert corrected.pose == pytest.approx(plain.pose, abs=1e-9)


def test_a_reset_and_a_new_frame_of_the_robot():
    odometry = CorrectedOdometry(1.0, UNITS, Correction(1.1, 0.0))
    drive(odometry, [(100.0, 0.0)] * 10)
    odometry.reset()
    assert odometry.pose == (0.0, 0.0, 0.0)
    odometry.rebase()
    drive(odometry, [(100.0, 0.0)] * 10, (3000.0, 50.0, 2.0))
    assert odometry.pose == pytest.approx((1.0, 0.0, 0.0), abs=0.003)


def test_a_step_that_is_impossible_moves_nothing():
    odometry = CorrectedOdometry(1.0, UNITS, Correction(1.1, 0.0))
    odometry.update(0, 0, 0)
    assert not odometry.update(10000, 0, 0, 0.1) and odometry.pose == (0.0, 0.0, 0.0)


def test_which_odometry_a_model_has():
    model = find_model("p3dx-sh")
    wrong = replace(model, turn_factor=1.02)
    plain, corrected = odometry_of(model), odometry_of(wrong)
    assert type(plain) is Odometry and type(corrected) is CorrectedOdometry
    assert odometry_of(model, plain) is plain and odometry_of(wrong, corrected) is corrected
    assert odometry_of(wrong, plain) is not plain and odometry_of(model, corrected) is not corrected
    assert odometry_of(replace(wrong, turn_factor=1.03), corrected) is not corrected
