"""Learning how wheels err."""

import pytest

from pioneer_control.floor_poses import Pose, compose
from pioneer_control.navigation.wheel_calibration import WheelCalibration


def learnt(turn, curve, way, sure=True):
    """Return a calibration after a drive on which the robot really turns and goes by these factors."""
    wheels, pose = WheelCalibration(), Pose(0.0, 0.0, 0.0)
    for number in range(2000):
        step = Pose(0.04, 0.0, 0.05 if number % 100 < 50 else -0.03)
        wheels.corrected(step)
        pose = compose(pose, Pose(way * 0.04, 0.0, turn * step.heading + curve * 0.04))
        wheels.learn(pose if sure else None)
    return wheels


def test_it_learns_how_much_farther_the_robot_turns_and_goes():
    assert learnt(0.95, 0.015, 1.03).factors == pytest.approx([0.95, 0.015, 1.03], abs=0.008)


def test_exact_wheels_stay_exact():
    assert learnt(1.0, 0.0, 1.0).factors == pytest.approx([1.0, 0.0, 1.0], abs=0.002)


def test_it_learns_nothing_while_the_pose_is_not_sure():
    assert learnt(0.95, 0.015, 1.03, sure=False).factors.tolist() == [1.0, 0.0, 1.0]


def test_odometry_is_corrected_by_what_was_learnt():
    wheels = learnt(0.95, 0.0, 1.02)
    step = wheels.corrected(Pose(1.0, 0.0, 1.0))
    assert step == pytest.approx((1.02, 0.0, 0.95), abs=0.01)


def test_a_jump_of_the_pose_is_no_lesson():
    wheels = WheelCalibration()
    wheels.learn(Pose(0.0, 0.0, 0.0))
    wheels.corrected(Pose(2.1, 0.0, 0.0))
    wheels.learn(Pose(5.0, 0.0, 1.0))
    assert wheels.factors.tolist() == [1.0, 0.0, 1.0]
