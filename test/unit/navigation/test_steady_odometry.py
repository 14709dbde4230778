"""A pose by odometry that never jumps, of poses that are reset."""

import pytest

from pioneer_control.floor_poses import Pose, compose, relative
from pioneer_control.navigation.steady_odometry import SteadyOdometry

ZERO = Pose(0.0, 0.0, 0.0)
STEP = Pose(0.04, 0.0, 0.1)


def along(steady, begin, count, time=0.0):
    """Return the steady poses of a robot that goes on by STEP from where its wheels begin, every 0.1 s."""
    poses, told = [], begin
    for number in range(count):
        poses.append(steady.of(told, time + 0.1 * number))
        told = compose(told, STEP)
    return poses


def test_poses_that_go_on_stay_as_they_are():
    steady = SteadyOdometry()
    assert steady.of(Pose(3.0, 1.0, 2.0), 7.0) == Pose(3.0, 1.0, 2.0)
    assert steady.of(Pose(3.03, 1.0, 2.1), 7.1) == pytest.approx(Pose(3.03, 1.0, 2.1))
    assert steady.origin == ZERO


@pytest.mark.parametrize("begin", [Pose(0.0, 0.0, 0.0), Pose(7.0, -3.0, 1.0), Pose(3.0, 1.0, -1.0)])
def test_after_a_reset_the_robot_goes_on_as_it_drove(begin):
    never, steady = along(SteadyOdometry(), Pose(3.0, 1.0, 2.0), 20), SteadyOdometry()
    poses = along(steady, Pose(3.0, 1.0, 2.0), 10)
    poses += along(steady, begin, 1, 1.0)
    origin = steady.origin
    assert relative(origin, poses[-1]) == pytest.approx(begin) and origin != ZERO
    poses += [steady.of(compose(begin, STEP), 1.1)]
    assert [tuple(each) for each in poses] == [pytest.approx(tuple(each)) for each in never[:12]]
    assert steady.origin == origin


@pytest.mark.parametrize("step, passed, jumped", [
    (Pose(0.16, 0.0, 0.5), 0.1, False),     # the fastest robots
    (Pose(0.14, 0.0, 0.2), 0.001, False),   # packets that were held up
    (Pose(1.5, 0.0, 0.0), 1.0, False),      # packets are missing
    (Pose(0.4, 0.0, 0.0), 0.1, True),
    (Pose(0.0, -0.4, 0.0), 0.1, True),
    (Pose(0.0, 0.0, -0.9), 0.1, True),
    (Pose(0.2, 0.0, 0.0), -500.0, True),
])
def test_only_what_no_robot_can_drive_is_a_jump(step, passed, jumped):
    steady = SteadyOdometry()
    steady.of(Pose(0.0, 0.0, 0.0), 5.0)
    steady.of(step, 5.0 + passed)
    assert (steady.origin != ZERO) == jumped
