"""Transforms of poses."""

import math

import pytest

from pioneer_control.floor_poses import Pose, between, compose, relative, wrapped


def test_a_pose_in_a_turned_frame():
    placed = compose(Pose(1.0, 2.0, math.pi / 2), Pose(3.0, 1.0, 3.0))
    assert placed == pytest.approx((0.0, 5.0, 3.0 + math.pi / 2 - 2 * math.pi))
    assert relative(Pose(1.0, 2.0, math.pi / 2), placed) == pytest.approx((3.0, 1.0, 3.0))


@pytest.mark.parametrize("angle, same", [(3.5 * math.pi, -math.pi / 2), (-0.1, -0.1), (-4.0, 2 * math.pi - 4.0)])
def test_angles_are_wrapped(angle, same):
    assert wrapped(angle) == pytest.approx(same)


def test_a_pose_between_two_others_turns_the_shorter_way():
    before, after = Pose(1.0, 2.0, 3.0), Pose(3.0, 1.0, -3.0)
    assert between(before, after, 0.0) == pytest.approx(before)
    assert between(before, after, 0.25) == pytest.approx((1.5, 1.75, 3.0 + (2 * math.pi - 6.0) / 4))
    assert between(before, after, 1.0) == pytest.approx(after)
