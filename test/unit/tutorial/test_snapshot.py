"""What the wander knows from a robot's shape. A snapshot is of one moment."""

import math

import pytest

from pioneer_control.errors import NoAnswerError
from pioneer_control.floor_poses import Pose
from pioneer_control.tutorial.snapshot import Grip, Heard, Lift, RobotShape
from robots_and_snapshots import shape


def numbers(transducers):
    return [each.number for each in transducers]


def test_front_of_a_full_array_is_the_tutorials_one_to_six_from_left_to_right():
    robot = shape("p3dx-sh")
    assert numbers(robot.front) == [1, 2, 3, 4, 5, 6]
    assert robot.middle == (3, 4)


def test_front_of_an_amigobot_is_what_looks_ahead_of_its_eight():
    robot = shape("amigo-sh")
    assert numbers(robot.front) == [1, 2, 3, 4]
    assert robot.middle == (2, 3)


def test_front_of_an_array_with_one_in_the_middle():
    fan = [(number, 0.1, 0.0, math.radians(degrees)) for number, degrees in enumerate((90, 30, 15, 0, -15, -30, -90))]
    robot = RobotShape(fan, [(-0.2, -0.2), (0.2, -0.2), (0.2, 0.2), (-0.2, 0.2)])
    assert numbers(robot.front) == [1, 2, 3, 4, 5]
    assert set(robot.middle) == {2, 3, 4}


@pytest.mark.parametrize("robot, sees", [
    (shape("p3dx-sh"), True), (shape("p3dx-sh", gripper=True), True), (shape("p3at-sh"), True),
    (shape("p3dx-sh", rear_sonar=False), False), (shape("amigo-sh"), False),
])
def test_only_a_full_rear_array_sees_behind(robot, sees):
    """The two rear sonars of an AmigoBot look to the sides of its way backwards."""
    assert robot.sees_behind is sees


@pytest.mark.parametrize("name, sees", [("p3dx-sh", True), ("p3at-sh", True), ("amigo-sh", False)])
def test_an_amigobot_does_not_see_what_is_thin_and_straight_ahead(name, sees):
    assert shape(name).sees_ahead is sees


def heard():
    return Heard(pose=Pose(1.0, 2.0, 3.0), pose_time=10.0, ranges=(1.0,) * 16, ranges_time=10.1, robot=shape())


def test_a_snapshot_does_not_change_when_something_new_is_heard():
    """Row 18: the original's ranges could change between two reads."""
    before = heard()
    taken = before.snapshot(10.2, 0.2)
    after = before._replace(ranges=(2.0,) * 16, pose=Pose(0.0, 0.0, 0.0))
    assert taken.ranges == (1.0,) * 16 and taken.pose == Pose(1.0, 2.0, 3.0)
    assert after.snapshot(10.2, 0.2).ranges == (2.0,) * 16
    with pytest.raises(AttributeError):
        taken.ranges = ()
    with pytest.raises(TypeError):
        taken.ranges[3] = 0.0


def test_a_snapshot_is_as_old_as_the_oldest_in_it():
    assert heard().age(10.5) == pytest.approx(0.5)
    assert heard()._replace(pose_time=11.0).age(11.1) == pytest.approx(1.0)
    assert heard().snapshot(77.0, 0.5)[:2] == (77.0, 0.5)


@pytest.mark.parametrize("missing", ["pose", "ranges", "robot"])
def test_there_is_no_snapshot_of_what_was_never_heard(missing):
    """Row 17: the original used sixteen zeros that no sonar had measured."""
    with pytest.raises(NoAnswerError):
        heard()._replace(**{missing: None}).snapshot(10.2, 0.2)


@pytest.mark.parametrize("count", [0, 7, 8, 12])
def test_any_number_of_ranges_will_do_and_what_is_not_there_is_not_heard(count):
    """Row 17: the original accepted sixteen ranges or nothing."""
    snapshot = heard()._replace(ranges=(1.0,) * count).snapshot(10.2, 0.2)
    assert snapshot.ranges == (1.0,) * count + (0.0,) * (16 - count)


def test_both_contacts_and_both_beams_have_a_place():
    """Rows 12 and 16: the original had "outer" twice and no "right", and mixed types."""
    assert Grip._fields == ("state", "dir", "inner", "outer", "left", "right")
    assert Lift._fields == ("state", "dir", "position")
