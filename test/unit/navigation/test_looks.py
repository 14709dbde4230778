"""What a turn tells anew: only what the robot has not looked at from its place."""

import math

import pytest

from pioneer_control.floor_poses import Pose
from pioneer_control.navigation.looks import Looks

STEP = math.radians(2.5)
ABOUT = math.radians(10.0)


def turned(looks, start, steps, x=0.0):
    """Turn on the spot by some steps, to the right if they are negative. Return how much of it was new (rad)."""
    headings = [start + math.copysign(STEP, steps) * number for number in range(1, abs(steps) + 1)]
    return sum(looks.new_part(Pose(x, 0.0, heading), math.copysign(STEP, steps)) for heading in headings)


def test_a_first_turn_is_new():
    assert turned(Looks(0.15, 50.0), 0.0, 36) == pytest.approx(math.radians(90.0), abs=ABOUT)


def test_a_turn_back_is_not_new():
    looks = Looks(0.15, 50.0)
    turned(looks, 0.0, 36)
    assert turned(looks, math.radians(90.0), -36) == pytest.approx(0.0, abs=ABOUT)
    assert turned(looks, 0.0, 36) == pytest.approx(0.0, abs=ABOUT)


def test_no_more_than_a_circle_is_new():
    assert turned(Looks(0.15, 50.0), 0.3, 500) == pytest.approx(2.0 * math.pi)


def test_from_another_place_it_is_new_again():
    looks = Looks(0.15, 50.0)
    turned(looks, 0.0, 144)
    assert turned(looks, 0.0, 36, x=0.1) == pytest.approx(0.0, abs=ABOUT)
    assert turned(looks, 0.0, 36, x=0.2) == pytest.approx(math.radians(90.0), abs=ABOUT)


def test_after_much_turning_it_is_new_again():
    looks = Looks(0.15, math.radians(720.0))
    assert turned(looks, 0.0, 288) == pytest.approx(2.0 * math.pi, abs=ABOUT)
    assert turned(looks, 0.0, 36) == pytest.approx(math.radians(90.0), abs=ABOUT)


def test_forgotten_all_is_new():
    looks = Looks(0.15, 50.0)
    turned(looks, 0.0, 144)
    looks.forget()
    assert turned(looks, 0.0, 36) == pytest.approx(math.radians(90.0), abs=ABOUT)
