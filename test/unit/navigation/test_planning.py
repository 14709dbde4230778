"""Planning: which goals are refused and why, and that ways are short, keep away from walls and lead round obstacles."""

import math

import numpy as np
import pytest

from pioneer_control.maps.floor_map import FloorMap
from pioneer_control.maps.grid_map import FREE, OCCUPIED, UNKNOWN, GridMap
from pioneer_control.navigation.planning import NOT_SLOW, DrivableFloor, Slowness, length_of
from pioneer_control.navigation.tuned import PlanningNumbers

HALF_WIDTH = 0.21


def room(rows=60, columns=100):
    """Return the cells of an empty room of 5 x 3 m, walled in."""
    cells = np.full((rows, columns), FREE, dtype=np.int8)
    cells[[0, -1], :] = OCCUPIED
    cells[:, [0, -1]] = OCCUPIED
    return cells


def with_wall(gap_cells):
    """Return the room with a wall across at x = 2.5 m, which has a gap at y = 2 m (0: none)."""
    cells = room()
    cells[:, 50] = OCCUPIED
    cells[40 - gap_cells // 2:40 - gap_cells // 2 + gap_cells, 50] = FREE
    return cells


def floor_of(cells, **more):
    return DrivableFloor(GridMap(cells, 0.05, (0.0, 0.0)), HALF_WIDTH, PlanningNumbers(), **more)


@pytest.mark.parametrize("goal, reason", [
    ((math.nan, 1.0), "is not finite"),
    ((1.0, math.inf), "is not finite"),
    ((7.0, 1.0), "lies outside of the map, which has x from 0.00 to 5.00 and y from 0.00 to 3.00"),
    ((1.0, -0.1), "lies outside of the map"),
    ((1e300, 12.34), "the goal (1e+300, 12.34) lies outside of the map"),
    ((2.52, 1.0), "the goal (2.52, 1.00) lies in a wall"),
    ((0.2, 1.0), "the robot needs 0.26 m"),
    ((4.0, 1.5), "cannot be reached: no way 0.51 m wide leads there from (1.00, 1.50)"),
])
def test_a_goal_is_refused_with_a_reason(goal, reason):
    assert reason in floor_of(with_wall(0)).refusal((1.0, 1.5), goal)


def test_a_legal_goal_is_not_refused():
    assert floor_of(with_wall(0)).refusal((1.0, 1.5), (2.0, 1.5)) == ""
    assert floor_of(with_wall(14)).refusal((1.0, 1.5), (4.0, 1.5)) == ""


def test_a_goal_where_the_map_is_unknown_is_refused_unless_the_robot_explores():
    cells = room()
    cells[:, 60:99] = UNKNOWN
    assert "lies where the map is unknown" in floor_of(cells).refusal((1.0, 1.5), (4.0, 1.5))
    assert floor_of(cells, through_unknown=True).refusal((1.0, 1.5), (4.0, 1.5)) == ""


@pytest.mark.parametrize("goal, reason", [
    ((2.0, 1.5), "the goal (2.00, 1.50) lies on a forbidden line"),
    ((2.1, 1.5), "lies 0.10 m from the nearest wall, forbidden line or unknown floor"),
    ((4.0, 1.5), "no way 0.51 m wide leads there from (1.00, 1.50) that crosses no forbidden line")])
def test_a_goal_that_is_forbidden_is_refused_with_that_reason(goal, reason):
    grid = FloorMap("lab", GridMap(room(), 0.05, (0.0, 0.0)), forbidden=((2.0, 0.0, 2.0, 3.0),)).drivable()
    assert reason in floor_of(grid.cells).refusal((1.0, 1.5), goal)


def test_a_map_without_floor_refuses_every_goal():
    cells = np.full((5, 5), OCCUPIED, dtype=np.int8)
    cells[2, 2] = FREE
    assert floor_of(cells).refusal((0.1, 0.1), (0.12, 0.12)) != ""


def test_a_straight_way_has_the_length_of_the_line():
    floor = floor_of(room())
    assert floor.shortest((1.0, 1.5), (4.0, 1.5)) == pytest.approx(3.0, abs=0.11)
    assert floor.shortest((1.0, 0.5), (4.0, 2.0)) == pytest.approx(math.hypot(3.0, 1.5), rel=0.05)


def test_no_way_is_infinitely_long():
    assert floor_of(with_wall(0)).shortest((1.0, 1.5), (4.0, 1.5)) == math.inf


def test_the_way_leads_through_the_gap_in_its_middle_and_ends_at_the_goal():
    points = floor_of(with_wall(18)).to((4.0, 0.6)).points_from((1.0, 0.6))
    assert points[0] == (1.0, 0.6) and points[-1] == (4.0, 0.6)
    x, y = min(points, key=lambda point: abs(point[0] - 2.525))
    assert abs(y - 2.0) < 0.16
    assert length_of(points) < 4.9


def test_the_way_keeps_its_distance_where_there_is_room():
    floor = floor_of(room())
    points = floor.to((4.0, 0.35)).points_from((1.0, 0.35))
    assert max(y for _, y in points) > 0.5


def test_the_cost_to_go_falls_towards_the_goal_and_the_heading_leads_there():
    plan = floor_of(room()).to((4.0, 1.5))
    costs = plan.cost(np.array([1.0, 2.0, 3.0, 4.0]), np.full(4, 1.5))
    assert (np.diff(costs) < 0).all() and costs[-1] < 0.1
    assert plan.heading(np.array([2.0]), np.array([1.5]))[0] == pytest.approx(0.0, abs=0.2)
    assert plan.cost(np.array([0.02]), np.array([1.5]))[0] > costs[0] + 2.0, "in the wall"


def test_the_way_leads_round_what_is_on_no_map():
    floor = floor_of(room())
    obstacle = np.array([(2.5, 1.5 + 0.05 * k) for k in range(-8, 9)])
    points = floor.past(floor.to((4.0, 1.5)), obstacle, (1.0, 1.5)).points_from((1.0, 1.5))
    x, y = min(points, key=lambda point: abs(point[0] - 2.5))
    assert abs(y - 1.5) > 0.6


@pytest.mark.parametrize("slowness, least, most", [(NOT_SLOW, 0.4, 0.6), (Slowness(0.35, 0.475, 1.0), 0.62, 0.9)])
def test_a_way_keeps_farther_from_what_makes_the_robot_slow(slowness, least, most):
    floor = floor_of(room(), slowness=slowness)
    points = floor.past(floor.to((4.0, 1.5)), np.array([(2.5, 1.5)]), (1.0, 1.5)).points_from((1.0, 1.5))
    assert least < min(math.hypot(x - 2.5, y - 1.5) for x, y in points) < most


def test_what_blocks_the_only_way_makes_it_dear_and_leaves_it():
    floor, goal = floor_of(with_wall(18)), (4.0, 2.0)
    free = floor.to(goal)
    blocked = floor.past(free, np.array([(2.5, 1.8), (2.5, 2.2)]), (1.0, 2.0))
    start = np.array([1.0]), np.array([2.0])
    assert free.cost(*start)[0] + 10.0 < blocked.cost(*start)[0] < math.inf


def test_obstacles_beside_the_map_change_nothing():
    floor = floor_of(room())
    plan = floor.to((4.0, 1.5))
    assert (floor.past(plan, np.array([(90.0, 90.0)]), (1.0, 1.5)).values == plan.values).all()


@pytest.mark.parametrize("start, obstacles", [
    ((1.0, 1.5), [(1.6, 1.5)]), ((1.0, 1.5), [(1.6, 1.2), (1.6, 1.6), (2.0, 2.4)]), ((2.0, 0.6), [(0.8, 2.0)]),
    ((1.0, 1.5), [(4.0, 1.5)])])
def test_a_plan_past_obstacles_costs_what_its_way_costs_and_no_neighbour_knows_a_better_one(start, obstacles):
    floor = floor_of(room())
    by_map = floor.to((4.0, 1.5))
    plan = floor.past(by_map, np.array(obstacles), start)
    net, here = floor._net, plan.to_go < plan.to_go[floor.node(start)] + 1.0
    through = plan.to_go[net.end] + net.length * (plan.costs[net.start] + plan.costs[net.end]) / 2.0
    best = np.full(len(here), np.inf)
    np.minimum.at(best, net.start, through)
    best[floor.node((4.0, 1.5))] = 0.0
    assert plan.to_go[here] == pytest.approx(best[here])
    assert (plan.to_go >= by_map.to_go - 1e-9).all()
    assert plan.points_from(start)[-1] == (4.0, 1.5)


def test_only_what_obstacles_near_the_robot_change_is_searched_again(monkeypatch):
    floor = floor_of(room(columns=300))
    plan = floor.to((14.0, 1.5))
    monkeypatch.setattr(floor, "_whole", None)
    assert floor.past(plan, np.array([(1.0, 1.5)]), (10.0, 1.5)) is plan, "it has passed the obstacle"
    anew = floor.past(plan, np.array([(9.0, 1.5)]), (8.0, 1.5))
    far, near = np.array([1.0]), np.array([11.0])
    assert anew.cost(near, near - 9.5) == plan.cost(near, near - 9.5)
    assert length_of(anew.points_from((8.0, 1.5))) > length_of(plan.points_from((8.0, 1.5)))
    assert plan.cost(far, far) <= anew.cost(far, far) < math.inf
    assert anew.points_from((1.0, 1.0))[-1] == (14.0, 1.5), "also where none was searched"


def test_straight_is_what_has_no_wall_between():
    floor = floor_of(with_wall(18))
    assert floor.straight((1.0, 2.0), (4.0, 2.0))
    assert not floor.straight((1.0, 1.0), (4.0, 1.0))
    assert not floor.straight((1.0, 1.0), (9.0, 1.0))


def test_a_way_of_one_square_has_both_ends():
    assert floor_of(room()).to((2.0, 1.5)).points_from((2.0, 1.5)) == [(2.0, 1.5), (2.0, 1.5)]
