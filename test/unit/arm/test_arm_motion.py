"""Motions through several positions: what is refused, and what is sent (arm sheet 19)."""

import math

import pytest

from test_arm_joints import ARM, found

from pioneer_control.arm.joints import JOINT_NAMES
from pioneer_control.arm.motion import MOST_POINTS, Point, plan
from pioneer_control.errors import UsageError

JOINTS = found().joints
HOME = tuple(row[1] for row in ARM)
BASE, SHOULDER, ELBOW, ROLL, WRIST, GRIPPER = JOINT_NAMES


def planned(names, *points, ticks=HOME, step=1.6):
    return plan(JOINTS, ticks, names, [Point(*point) for point in points], step)


def test_one_joint_takes_its_time():
    segment, = planned([BASE], ([math.radians(30)], 2.0))
    assert segment.goals == {1: 165} and segment.speeds == {1: 57}      # 35 ticks in 2 s
    assert segment.ends == 2.0 and segment.lasts == pytest.approx(35 * 0.057)


def test_a_joint_that_cannot_be_so_fast_is_as_fast_as_it_may():
    for time in (0.0, 0.1):
        segment, = planned([BASE], ([math.radians(30)], time))
        assert segment.speeds == {1: 30} and segment.lasts == pytest.approx(1.05)


def test_a_joint_that_cannot_be_so_slow_is_early():
    segment, = planned([BASE], ([math.radians(30)], 60.0))
    assert segment.speeds == {1: 127} and segment.ends == 60.0


def test_several_joints_share_the_line():
    fast = {name: joint._replace(fastest_ms=1) for name, joint in JOINTS.items()}
    names = [BASE, ROLL, WRIST, GRIPPER]
    segment, = plan(fast, HOME, names, [Point([0.5, 0.5, 0.5, 0.0], 0.0)], 9.0)
    assert set(segment.speeds.values()) == {8}
    segment, = plan(fast, HOME, names, [Point([0.5, 0.0, fast[WRIST].value(183), 0.054 * 110 / 130], 0.0)], 9.0)
    assert segment.speeds == {1: 2} and segment.goals == {1: 163, 4: 130, 5: 183, 6: 180}


def test_each_segment_begins_where_the_one_before_ended():
    first, second, third = planned([BASE], ([0.5], 1.0), ([0.5], 2.0), ([-0.5], 4.0))
    assert [each.goals[1] for each in (first, second, third)] == [163, 163, 97]
    assert second.speeds == {} and second.lasts == 0.0 and third.speeds == {1: 30} and third.ends == 4.0


def test_joints_that_are_not_named_stay_out_of_it():
    assert planned([WRIST], ([0.0], 1.0))[0].goals == {5: 130}


@pytest.mark.parametrize("names, points, problem", [
    ([], [([], 1.0)], "no joint is named; there are arm_base_joint, arm_shoulder_joint"),
    (["gripper"], [([0.0], 1.0)], "there is no joint 'gripper'; there are arm_base_joint"),
    ([BASE, BASE], [([0.0, 0.0], 1.0)], "arm_base_joint is there twice"),
    ([BASE], [], "0 points are given, and a motion has 1 to 1000"),
    ([BASE], [([0.0], 1.0 + each) for each in range(MOST_POINTS + 1)], "1001 points are given"),
    ([BASE], [([], 1.0)], "point 0 has 0 positions for 1 joints"),
    ([BASE], [([0.0, 0.0], 1.0)], "point 0 has 2 positions for 1 joints"),
    ([BASE], [([math.nan], 1.0)], "arm_base_joint of point 0 is nan, and a position must be finite"),
    ([BASE], [([0.0], 1.0), ([-math.inf], 2.0)], "arm_base_joint of point 1 is -inf"),
    ([BASE], [([1.6], 1.0)], "arm_base_joint of point 0 is 1.600, and may be -1.571 to 1.571 rad"),
    ([GRIPPER], [([0.06], 1.0)], "arm_gripper_joint of point 0 is 0.060, and may be 0.000 to 0.054 m"),
    ([BASE], [([0.0], -1.0)], "time_from_start of point 0 is -1.0 s"),
    ([BASE], [([0.0], math.nan)], "time_from_start of point 0 is nan s"),
    ([BASE], [([0.0], 1.0), ([0.1], 1.0)], "time_from_start of point 1 is 1 s, not after that of the point before"),
    ([BASE], [([0.0], 2.0), ([0.1], 1.0)], "time_from_start of point 1 is 1 s, not after"),
    ([SHOULDER], [([-0.5], 9.0)], r"point 0 moves arm_shoulder_joint by 1.88 rad, and one step is at most 1.60 rad"),
    ([BASE], [([1.0], 2.0), ([-1.0], 4.0)], "point 1 moves arm_base_joint by 2.00 rad"),
])
def test_what_is_refused(names, points, problem):
    with pytest.raises(UsageError, match=problem):
        planned(names, *points)


def test_a_gripper_may_go_all_the_way_at_once():
    assert planned([GRIPPER], ([0.0], 0.0), step=0.01)[0].goals == {6: 70}
