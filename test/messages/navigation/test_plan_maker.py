"""Plans, asked for as clients of move_base ask: with an empty start, without headings, with a tolerance."""

import math

import numpy as np
import pytest
import rospy
from geometry_msgs.msg import Point, PoseStamped, Quaternion
from geometry_msgs.msg import Pose as PoseMessage
from nav_msgs.srv import GetPlanRequest
from rospy import Time
from std_msgs.msg import Header

from pioneer_control.errors import RefusedError
from pioneer_control.floor_poses import Pose
from pioneer_control.maps import FREE, OCCUPIED, UNKNOWN, GridMap
from pioneer_control.navigation.node.messages import pose_of
from pioneer_control.navigation.node.plan_maker import DIRECTIONS, RINGS, PlanMaker

NONE, AHEAD, LEFT = Quaternion(), Quaternion(w=1.0), Quaternion(z=math.sqrt(0.5), w=math.sqrt(0.5))


class Floor:
    """A pilot on a floor of 10 m by 10 m. A wall is at its left, its right is unknown, and a goal needs y > 2."""

    makes_map = False
    tries = 0

    def __init__(self):
        cells = np.full((100, 100), FREE, dtype=np.int8)
        cells[:, :5], cells[:, 95:] = OCCUPIED, UNKNOWN
        self.grid = GridMap(cells, 0.1, (0.0, 0.0))

    def way(self, start, goal):
        self.tries += 1
        if not 2.0 < goal.y < 10.0:
            raise RefusedError("the goal (%.2f, %.2f) lies in a wall" % goal[:2])
        return [start[:2], goal[:2]]


@pytest.fixture
def plan(monkeypatch):
    """Return a function that asks for a plan, and returns its poses (x, y, heading) and what the log says."""
    lines = []
    monkeypatch.setattr(Time, "now", lambda: Time(7))
    monkeypatch.setattr(rospy, "logwarn", lambda text, *values: lines.append(text % values))

    def ask(start, goal, tolerance=0.0, pilot=None):
        maker = PlanMaker(pilot or Floor(), "map", lambda header, pose: pose, lambda: Pose(5.0, 5.0, 0.0))
        answer = maker.serve(GetPlanRequest(start, goal, tolerance))
        assert answer.plan.header.frame_id == "map"
        return [pose_of(each.pose) for each in answer.plan.poses], " ".join(lines)

    return ask


def at(x, y, turn=AHEAD, frame="map"):
    return PoseStamped(Header(frame_id=frame), PoseMessage(Point(x, y, 0.0), turn))


def test_a_plan_ends_with_the_heading_of_the_goal(plan):
    poses, log = plan(at(1.0, 3.0), at(4.0, 3.0, LEFT))
    assert [each.heading for each in poses] == pytest.approx([0.0, math.pi / 2]) and log == ""


@pytest.mark.parametrize("empty", [PoseStamped(), at(0.0, 0.0, AHEAD, frame="")])
def test_an_empty_start_means_where_the_robot_is(plan, empty):
    poses, _ = plan(empty, at(4.0, 3.0))
    assert poses[0][:2] == (5.0, 5.0)


def test_headings_may_be_left_out(plan):
    poses, log = plan(at(4.0, 3.0, NONE), at(4.0, 4.0, NONE))
    assert [each.heading for each in poses] == pytest.approx([math.pi / 2] * 2) and log == ""


@pytest.mark.parametrize("x, named", [
    (100.0, r"no plan: the start (100, 3) lies outside of the map, which has x from 0.00 to 10.00"),
    (1e300, "no plan: the start (1e+300, 3) lies outside"), (0.2, "no plan: the start (0.20, 3.00) lies in a wall"),
    (9.7, "no plan: the start (9.70, 3.00) lies where the map is unknown"),
])
def test_a_start_where_no_robot_can_be_has_no_plan(plan, x, named):
    poses, log = plan(at(x, 3.0), at(4.0, 3.0))
    assert poses == [] and named in log


def test_the_nearest_place_within_the_tolerance_is_as_good_as_the_goal(plan):
    poses, log = plan(at(1.0, 3.0), at(4.0, 1.5, LEFT), tolerance=1.0)
    assert 2.0 < poses[-1].y <= 2.1 and abs(poses[-1].x - 4.0) < 0.4 and log == ""
    assert poses[-1].heading == pytest.approx(math.pi / 2)


@pytest.mark.parametrize("tolerance", [0.0, 0.4, -1.0, math.nan])
def test_farther_than_the_tolerance_nothing_is_taken(plan, tolerance):
    poses, log = plan(at(1.0, 3.0), at(4.0, 1.5), tolerance)
    assert poses == [] and log == "no plan: the goal (4.00, 1.50) lies in a wall"


def test_no_tolerance_takes_long(plan):
    floor = Floor()
    assert plan(at(1.0, 3.0), at(4.0, -50.0), math.inf, floor)[0] == []
    assert floor.tries == 1 + RINGS * DIRECTIONS
