"""Where a robot goes for a while when it has no way on."""

import math

import numpy as np
import pytest
from floor_for_tests import room

from pioneer_control.floor_poses import Pose
from pioneer_control.navigation.aside import Aside, roomy
from pioneer_control.navigation.planning import DrivableFloor
from pioneer_control.navigation.tuned import NavigatorNumbers, PlanningNumbers

FLOOR = DrivableFloor(room(), 0.2, PlanningNumbers())
NOTHING = np.zeros((0, 2))
HERE = Pose(3.0, 2.0, 0.3)


def begun(now=130.0):
    aside = Aside(NavigatorNumbers(aside_after=20.0, aside_time=10.0, aside=0.8))
    aside.begin(FLOOR, HERE, NOTHING, now)
    return aside


@pytest.mark.parametrize("pose, places", [
    (HERE, np.array([[3.5, 2.0], [3.5, 2.2]])), (HERE, np.array([[3.0, 2.5]])), (Pose(0.5, 0.5, 1.0), NOTHING)])
def test_it_goes_away_from_what_is_on_no_map_and_from_walls(pose, places):
    x, y = roomy(FLOOR, pose, places, 0.8)
    assert math.hypot(x - pose.x, y - pose.y) == pytest.approx(0.8)
    nearest = np.array([[0.0, 0.0], *places])[-1]
    assert math.hypot(*(nearest - (x, y))) > math.hypot(*(nearest - pose[:2])) + 0.5


def test_where_walls_are_all_round_there_is_no_such_place():
    assert roomy(FLOOR, Pose(0.3, 0.3, 0.0), NOTHING, 9.0) is None


def test_it_is_due_some_time_after_the_last_progress_and_after_the_last_one():
    aside = Aside(NavigatorNumbers(aside_after=20.0))
    assert not aside.is_due(100.0, 119.0) and aside.is_due(100.0, 121.0) and aside.count == 0
    aside = begun(121.0)
    assert not aside.is_due(100.0, 140.0) and aside.is_due(100.0, 142.0) and aside.count == 1


@pytest.mark.parametrize("progress, now, arrives, goes", [
    (100.0, 131.0, False, True), (100.0, 141.0, False, False), (131.0, 132.0, False, False),
    (100.0, 131.0, True, False)])
def test_it_is_on_its_way_there_until_it_is_there_or_its_time_is_over_or_it_gets_on(progress, now, arrives, goes):
    aside = begun()
    place = aside.plan(HERE, 100.0, 130.1).goal
    assert (aside.plan(Pose(*place, 0.0) if arrives else HERE, progress, now) is not None) == goes


def test_before_the_first_it_is_on_no_way_aside():
    assert Aside(NavigatorNumbers()).plan(HERE, 0.0, 100.0) is None
