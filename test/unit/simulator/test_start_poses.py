"""The places where many robots stand at the start."""

import itertools
import math

import pytest

from pioneer_control.errors import ParameterError
from pioneer_control.robots import find_model
from robot_on_bench import heard

from pioneer_control.simulator.simulation import Simulation, prepared, simulate
from pioneer_control.simulator.world import (
    Can, World, known_worlds, load_world, random_places, standing_places)
from pioneer_control.simulator.world.geometry import outlines_meet
from pioneer_control.simulator.world.poses import placed

MODEL = find_model("p3dx-sh")
OUTLINE = MODEL.outline(MODEL.can_carry_gripper)
REACH = max(math.hypot(x, y) for x, y in OUTLINE)


def hall(side, **parts):
    """Return a square room with its first start in the middle."""
    corners = [(0, 0), (side, 0), (side, side), (0, side)]
    walls = [first + second for first, second in zip(corners, corners[1:] + corners[:1])]
    return World("hall", walls, starts=[(side / 2, side / 2, 0.0)], **parts)


def from_edge(point, start, end):
    """Return the distance (m) from a point to a straight line between two points."""
    (x, y), (along_x, along_y) = (point[0] - start[0], point[1] - start[1]), (end[0] - start[0], end[1] - start[1])
    share = min(1.0, max(0.0, (x * along_x + y * along_y) / (along_x * along_x + along_y * along_y)))
    return math.hypot(x - share * along_x, y - share * along_y)


def gap(first, second):
    """Return the distance (m) between two outlines, 0 if they overlap."""
    if outlines_meet(first, second):
        return 0.0
    return min(from_edge(point, start, end) for one, other in ((first, second), (second, first))
               for point in one for start, end in zip(other, other[1:] + other[:1]))


def least_gap(poses):
    """Return the smallest distance (m) between the outlines of robots at these poses."""
    outlines = [placed(OUTLINE, pose) for pose in poses]
    return min(gap(one, other) for number, one in enumerate(outlines) for other in outlines[:number])


@pytest.mark.parametrize("name", known_worlds())
@pytest.mark.parametrize("subtype", ["p3dx-sh", "amigo-sh"])
def test_five_robots_stand_in_every_world_of_the_gallery_and_can_turn(name, subtype):
    simulation, model = Simulation(load_world(name)), find_model(subtype)
    for pose in standing_places(simulation.world, model, 5):
        simulation.add(model, pose)
    for pose in standing_places(simulation.world, model, 5)[len(simulation.world.starts):]:
        reach = max(math.hypot(x, y) for x, y in model.outline(model.can_carry_gripper))
        assert simulation.world.clearance(*pose[:2]) >= reach


def test_the_starts_of_the_world_come_first_as_they_are():
    world = load_world("office")
    for count in (1, 3, 5):
        assert standing_places(world, find_model("p3dx-sh"), count)[:3] == world.starts[:count][:3]


def test_the_gap_between_robots_is_measured():
    ahead, aside = max(x for x, _ in OUTLINE), max(y for _, y in OUTLINE)
    nose_to_nose = [(0.0, 0.0, 0.0), (2.0, 0.0, math.pi)]
    assert least_gap(nose_to_nose) == pytest.approx(2.0 - 2.0 * ahead)
    assert least_gap([(0.0, 0.0, 0.0), (0.0, 1.0, math.pi)]) == pytest.approx(1.0 - 2.0 * aside)
    assert least_gap([*nose_to_nose, (0.1, 0.1, 1.0)]) == 0.0


@pytest.mark.parametrize("name, between, wall", [("classroom", 1.35, 0.25), ("office", 0.9, 0.4)])
def test_thirty_robots_stand_far_apart_and_away_from_walls(name, between, wall):
    """`between` and `wall` are the least distances (m) between two outlines, and from the circle of a turning robot to
    the nearest wall or post.
    """
    world = load_world(name)
    poses = standing_places(world, MODEL, 30)
    assert poses == standing_places(load_world(name), MODEL, 30), "the same in every run"
    assert least_gap(poses) > between
    assert min(world.clearance(x, y) for x, y, _ in poses) - REACH > wall
    for can in world.cans:
        assert all(math.hypot(x - can.x, y - can.y) > REACH + can.radius for x, y, _ in poses)


def test_thirty_robots_in_a_row_would_not_pass_for_spread():
    crowded = [(0.85 * number, 0.0, math.pi / 2) for number in range(30)]
    assert 0.0 < least_gap(crowded) < 0.5


def test_the_classroom_has_a_start_for_each_of_thirty():
    world = load_world("classroom")
    assert len(world.starts) == 30 and standing_places(world, MODEL, 30) == world.starts
    assert standing_places(world, MODEL, 33)[:30] == world.starts


def test_spread_robots_head_to_free_floor():
    world = load_world("office")
    poses = standing_places(world, MODEL, 30)[len(world.starts):]
    assert min(heard(world, *pose) for pose in poses) > 1.5
    turned = [(x, y, heading + math.pi) for x, y, heading in poses]
    assert min(heard(world, *pose) for pose in turned) < 1.0, "there are walls near"


def test_robots_are_spread_over_every_room_that_a_robot_can_reach():
    """Between two rooms of 4 by 4 m, there is a door of 0.7 m. A third room has no door."""
    walls = [(0, 0, 12, 0), (12, 0, 12, 4), (12, 4, 0, 4), (0, 4, 0, 0), (4, 0, 4, 1.6), (4, 2.3, 4, 4), (8, 0, 8, 4)]
    poses = standing_places(World("rooms", walls, starts=[(2.0, 2.0, 0.0)]), MODEL, 8)
    rooms = [math.floor(x / 4.0) for x, _, _ in poses]
    assert rooms.count(0) == rooms.count(1) == 4
    door_too_narrow = [*walls, (4, 1.6, 4, 1.8)]
    poses = standing_places(World("rooms", door_too_narrow, starts=[(2.0, 2.0, 0.0)]), MODEL, 8)
    assert max(x for x, _, _ in poses) < 4.0


def test_cans_are_no_wall_but_nobody_stands_on_one():
    ring = [Can(3.0 + math.cos(angle), 3.0 + math.sin(angle)) for angle in range(7)]
    poses = standing_places(hall(6.0, cans=ring), MODEL, 10)
    assert max(math.hypot(x - 3.0, y - 3.0) for x, y, _ in poses) > 2.0
    assert all(math.hypot(x - can.x, y - can.y) > REACH + can.radius for x, y, _ in poses[1:] for can in ring)


def test_five_hundred_on_an_open_floor_none_near_another():
    places = standing_places(World("hall", starts=[(1.0, 2.0, 0.5)]), MODEL, 500)
    assert len(places) == 500
    assert min(math.hypot(x - a, y - b) for at, (x, y, _) in enumerate(places) for a, b, _ in places[:at]) > 1.7
    assert max(math.hypot(x - 1.0, y - 2.0) for x, y, _ in places) < 33.0


def test_a_full_hall_is_filled_in_rows():
    with pytest.raises(ParameterError, match="has room for 81 robots of the model p3dx-sh, not for 90"):
        standing_places(hall(10.0), MODEL, 90)
    simulation = Simulation(hall(10.0))
    for pose in standing_places(simulation.world, MODEL, 81):
        simulation.add(MODEL, pose)
    few = standing_places(hall(10.0), MODEL, 12)
    assert least_gap(few) > 1.0, "spread, while there is room"


@pytest.mark.parametrize("name, most", [("office", 106), ("tutorial", 25), ("maze", 43)])
def test_as_many_robots_as_a_world_holds_can_stand_there(name, most):
    simulation = Simulation(load_world(name))
    for pose in standing_places(simulation.world, MODEL, most):
        simulation.add(MODEL, pose)


def test_nobody_stands_beyond_a_wall():
    with pytest.raises(ParameterError, match="the world 'hall' has room for 9 robots of the model p3dx-sh, not for 10"):
        standing_places(hall(4.0), MODEL, 10)
    assert all(0.0 < x < 4.0 and 0.0 < y < 4.0 for x, y, _ in standing_places(hall(4.0), MODEL, 9))


@pytest.mark.parametrize("name", ["office", "offices-7", "empty"])
def test_random_places_have_room_and_differ_by_seed(name):
    world = load_world(name)
    places = random_places(world, MODEL, 5, 3)
    assert places == random_places(world, MODEL, 5, 3) != random_places(world, MODEL, 5, 4)
    assert all(world.clearance(x, y) > 0.3 for x, y, _ in places)
    assert min(math.dist(one[:2], other[:2]) for one, other in itertools.combinations(places, 2)) > 0.6
    simulation = simulate(prepared(world, MODEL, 5, 3, start="random"), MODEL, 5, None, 3)
    assert [robot.true_pose for robot in simulation.robots] == places


def test_random_places_are_spread_over_all_the_floor_that_can_be_reached():
    world = load_world("office")
    places = [place for seed in range(10) for place in random_places(world, MODEL, 5, seed)]
    low_x, low_y, high_x, high_y = world.bounds
    for axis, (low, high) in enumerate(((low_x, high_x), (low_y, high_y))):
        at = sorted(place[axis] for place in places)
        assert at[0] < low + 0.2 * (high - low) and at[-1] > high - 0.2 * (high - low)
    headings = sorted(place[2] for place in places)
    assert headings[0] < -2.5 and headings[-1] > 2.5


def test_no_random_place_is_left():
    with pytest.raises(ParameterError, match="'tutorial' has room for .* at random places, not for 60"):
        random_places(load_world("tutorial"), MODEL, 60, 1)


def test_a_world_prepared_with_nothing_is_the_world():
    world = load_world("office")
    assert prepared(world, MODEL, 1, 0) is world
    assert prepared(world, MODEL, 1, 0, (1.0, 2.0, 0.5)).starts[0] == (1.0, 2.0, 0.5)
    full = prepared(world, MODEL, 1, 0, unmapped=2, walkers=3)
    assert (len(full.unmapped), len(full.walks), len({walk.seed for walk in full.walks})) == (2, 3, 3)
