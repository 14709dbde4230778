"""Where a robot goes that explores."""

import math

import numpy as np
import pytest

from pioneer_control.floor_poses import Pose
from pioneer_control.maps import FREE, OCCUPIED, UNKNOWN, GridMap
from pioneer_control.navigation.exploring import Explorer, next_goal

HERE = Pose(1.0, 1.0, 0.0)
RADIUS = 0.25


def floor(*gaps):
    """A room of 4 m x 2 m with walls round it, in unknown land. Gaps: first and last y (m) of holes in its right wall.
    """
    cells = np.full((60, 120), UNKNOWN, dtype=np.int8)
    cells[0:40, 0:80] = OCCUPIED
    cells[1:39, 1:79] = FREE
    for low, high in gaps:
        cells[round(low / 0.05):round(high / 0.05), 79] = UNKNOWN
    return GridMap(cells, 0.05, (0.0, 0.0))


def test_a_closed_room_leaves_nothing():
    goal = next_goal(floor(), HERE, RADIUS)
    assert goal.pose is None
    assert goal.reason == "all that can be reached is known"


def test_it_goes_to_the_hole_and_looks_through_it():
    goal = next_goal(floor((0.5, 1.5)), HERE, RADIUS)
    assert goal.pose[:2] == pytest.approx((3.9, 1.0), abs=0.15)
    assert abs(goal.pose.heading) < math.radians(50)
    assert "2.9 m away" in goal.reason


def test_a_hole_that_is_too_narrow_is_none():
    assert next_goal(floor((0.8, 1.2)), HERE, RADIUS).pose is None
    assert next_goal(floor((0.6, 1.4)), HERE, RADIUS).pose is not None


def test_unknown_cells_along_a_wall_are_no_end_of_the_map():
    found = floor()
    found.cells[1:3, 5:70] = UNKNOWN
    assert next_goal(found, HERE, RADIUS).pose is None


def test_what_cannot_be_reached_does_not_count():
    found = floor((0.5, 1.5))
    found.cells[:, 60] = OCCUPIED
    assert next_goal(found, HERE, RADIUS).pose is None
    assert next_goal(found, Pose(3.5, 1.0, 0.0), RADIUS).pose is not None


def test_the_nearer_of_two_equal_ends_is_chosen():
    found = floor((0.5, 1.5))
    found.cells[10:30, 0] = UNKNOWN
    found = GridMap(np.pad(found.cells, ((0, 0), (60, 0)), constant_values=UNKNOWN), 0.05, (-3.0, 0.0))
    assert next_goal(found, Pose(1.0, 1.0, 0.0), RADIUS).pose.x < 1.0
    assert next_goal(found, Pose(3.2, 1.0, 0.0), RADIUS).pose.x > 3.2


def test_more_to_see_is_worth_a_longer_way():
    found = floor((0.5, 1.5))
    found.cells[10:30, 0] = UNKNOWN
    found = GridMap(np.pad(found.cells, ((0, 0), (8, 0)), constant_values=UNKNOWN), 0.05, (-0.4, 0.0))
    found.cells[:, 0] = OCCUPIED
    assert next_goal(found, Pose(1.8, 1.0, math.pi / 2), RADIUS).pose.x > 3.0


def test_what_was_given_up_is_left_alone_and_told():
    found = floor((0.5, 1.5))
    first = next_goal(found, HERE, RADIUS)
    second = next_goal(found, HERE, RADIUS, [first.pose[:2]])
    assert second.pose is None
    assert "1 places that were given up" in second.reason


def test_before_anything_is_known_it_looks_round_where_it_stands():
    nothing = GridMap(np.full((1, 1), UNKNOWN, dtype=np.int8), 0.05, (0.0, 0.0))
    goal = next_goal(nothing, Pose(5.0, 5.0, 0.0), RADIUS)
    assert math.hypot(goal.pose.x - 5.0, goal.pose.y - 5.0) < 0.6


def test_a_robot_in_a_wall_gets_no_goal():
    found = floor()
    found.cells[:] = OCCUPIED
    assert "no known floor" in next_goal(found, HERE, RADIUS).reason


def test_first_it_looks_round():
    explorer = Explorer(Pose(2.0, 1.0, 0.5), RADIUS)
    pose, turned = HERE, 0.0
    for _ in range(3):
        goal = explorer.next(floor((0.5, 1.5)), pose)
        assert goal.with_heading and goal.pose[:2] == HERE[:2]
        turned += math.remainder(goal.pose.heading - pose.heading, 2.0 * math.pi)
        pose = goal.pose
    assert turned == pytest.approx(2.0 * math.pi)
    assert not explorer.next(floor((0.5, 1.5)), HERE).with_heading


def test_after_all_it_goes_home():
    explorer = Explorer(Pose(2.0, 1.0, 0.5), RADIUS)
    for _ in range(3):
        explorer.next(floor((0.5, 1.5)), HERE)
    goal = explorer.next(floor((0.5, 1.5)), HERE)
    assert not explorer.homeward
    explorer.give_up(goal.pose)
    last = explorer.next(floor((0.5, 1.5)), HERE)
    assert explorer.homeward
    assert last.pose == Pose(2.0, 1.0, 0.5)
    assert last.reason.endswith(": home")
