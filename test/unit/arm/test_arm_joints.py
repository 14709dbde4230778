"""Ticks and angles (arm sheet 15), limits, speeds, and joints whose numbers make no sense."""

import math

import pytest

from pioneer_control import p2os
from pioneer_control.arm.joints import JOINT_NAMES, Joint, JointSettings, find_joints

SLOW = JointSettings(0.5)
# The arm of the sheet, 17: speed, home, minimum, centre, maximum, ticks for 90 degrees.
ARM = [(20, 130, 25, 130, 235, 105), (25, 37, 25, 130, 235, 105), (25, 235, 25, 130, 235, 105),
       (15, 130, 25, 130, 235, 105), (15, 183, 25, 130, 235, 105), (15, 180, 70, 128, 200, 128)]
QUARTER = math.pi / 2


def found(rows=ARM, settings=None):
    return find_joints(p2os.ArmInfo("1.7", tuple(p2os.ArmJoint(*row) for row in rows)), settings or (SLOW,) * 6)


def joint(number, row=None, **given):
    rows = list(ARM)
    rows[number - 1] = row or rows[number - 1]
    settings = [SLOW] * 6
    settings[number - 1] = JointSettings(**{"max_speed": 0.5, **given})
    return found(rows, tuple(settings)).joints[JOINT_NAMES[number - 1]]


@pytest.mark.parametrize("number, at_minimum, at_home, at_maximum", [
    (1, -90, 0, 90), (2, 90, 79.714, -90), (3, 90, -90, -90), (4, 90, 0, -90), (5, 90, -45.429, -90)])
def test_angles_of_the_arm_of_the_sheet(number, at_minimum, at_home, at_maximum):
    """Section 15 gives d, section 16 t from it: t1, t4 and t5 with the other sign."""
    one = joint(number)
    assert [math.degrees(one.value(tick)) for tick in (one.minimum, one.home, one.maximum)] == pytest.approx(
        [at_minimum, at_home, at_maximum], abs=1e-3)
    d = [(-1 if number <= 3 else 1) * 90 / 105 * (tick - 130) for tick in (25, 99, 235)]
    t = [(1 if number in (2, 3) else -1) * each for each in d]
    assert [math.degrees(one.value(tick)) for tick in (25, 99, 235)] == pytest.approx(t)
    assert (one.lower, one.upper) == pytest.approx((-QUARTER, QUARTER))


def test_the_gripper_is_metres():
    gripper = joint(6)
    assert [gripper.value(tick) for tick in (70, 135, 200)] == pytest.approx([0.0, 0.027, 0.054])
    assert (gripper.tick(-0.0001), gripper.tick(0.027), gripper.tick(1.0)) == (70, 135, 200)
    assert gripper.is_gripper and gripper.unit_name == "m"


def test_there_and_back_at_every_tick():
    for number in range(1, 7):
        for given in ({}, {"sign": -1}, {"offset": 0.3}):
            one = joint(number, **(given if number < 6 else {}))
            for tick in range(one.minimum, one.maximum + 1):
                assert one.tick(one.value(tick)) == tick


def test_sign_and_offset_of_the_user():
    assert joint(1, sign=-1).value(235) == pytest.approx(-QUARTER)
    moved = joint(1, offset=0.2)
    assert moved.value(130) == pytest.approx(0.2) and (moved.lower, moved.upper) == pytest.approx(
        (0.2 - QUARTER, 0.2 + QUARTER))


def test_limits_of_the_user_can_only_narrow_the_range():
    narrow = joint(2, lower=-0.5, upper=9.0)
    assert (narrow.lower, narrow.upper) == pytest.approx((-0.5, QUARTER))
    assert narrow.tick(-1.5) == narrow.tick(-0.5)
    assert narrow.allows(-0.5) and narrow.allows(-0.507) and not narrow.allows(-0.508)


def test_no_position_beyond_the_servo_is_ever_sent():
    wide = joint(2)._replace(lower=-9.0, upper=9.0)
    assert (wide.tick(9.0), wide.tick(-9.0)) == (25, 235)


@pytest.mark.parametrize("ticks_per_90, max_speed, speed_ms", [
    (105, 0.5, 30), (105, 10.0, 2), (105, 100.0, 1), (105, 0.01, 127), (60, 0.5, 53)])
def test_no_servo_is_faster_than_the_user_lets_it(ticks_per_90, max_speed, speed_ms):
    one = joint(1, (20, 130, 25, 130, 235, ticks_per_90), max_speed=max_speed)
    assert one.fastest_ms == speed_ms
    assert one.speed(speed_ms) <= max_speed or speed_ms == 127


def test_degrees_per_second_of_the_sheet():
    for number, expected in zip(range(1, 6), (42.9, 34.3, 34.3, 57.1, 57.1)):
        assert math.degrees(joint(number).speed(ARM[number - 1][0])) == pytest.approx(expected, abs=0.05)
    assert math.isfinite(joint(1).speed(0))


@pytest.mark.parametrize("row, problem", [
    ((20, 130, 25, 130, 235, 0), "arm_elbow_joint is left alone: the arm reports 0 ticks for 90 degrees"),
    ((20, 130, 235, 130, 25, 105), "arm_elbow_joint is left alone: the arm reports the range 235 to 25 ticks"),
    ((20, 130, 99, 130, 99, 105), "arm_elbow_joint is left alone: the arm reports the range 99 to 99 ticks"),
])
def test_a_joint_without_sense_is_left_alone(row, problem):
    rows = list(ARM)
    rows[2] = row
    arm = found(rows)
    assert "arm_elbow_joint" not in arm.joints and len(arm.joints) == 5
    assert len(arm.problems) == 1 and problem in arm.problems[0]


def test_limits_that_leave_nothing():
    settings = [SLOW] * 6
    settings[0] = JointSettings(0.5, lower=2.0, upper=2.5)
    arm = found(settings=tuple(settings))
    assert list(arm.joints) == list(JOINT_NAMES[1:]) and "have nothing in common" in arm.problems[0]


@pytest.mark.parametrize("count", [0, 1, 2, 5, 6, 7, 255])
def test_any_number_of_joints(count):
    arm = found((ARM * 50)[:count])
    assert list(arm.joints) == list(JOINT_NAMES[:count]) or count > 6
    assert all(isinstance(one, Joint) for one in arm.joints.values())


def test_a_gripper_needs_no_angle():
    rows = [*ARM[:5], (15, 180, 70, 128, 200, 0)]
    assert found(rows).joints["arm_gripper_joint"].tick(0.0) == 70
