"""Sonar ranges, compared with closed forms from paper and with brute force, and never with another cone caster."""

import math
import random

import numpy as np
import pytest

import robot_on_bench
from pioneer_control.errors import UsageError
from pioneer_control.simulator.world import Can, World

HALF = math.radians(12.5)
MAXIMUM = 5.0


def heard(world, x=0.0, y=0.0, heading=0.0, half_width=HALF, maximum=MAXIMUM):
    """Return the range that one sensor measures."""
    return robot_on_bench.heard(world, x, y, heading, half_width, maximum)


def wall_at(distance, normal_deg, half_length=20.0):
    """Return a wall at a distance from the origin. Its nearest point is in the direction `normal_deg`."""
    angle = math.radians(normal_deg)
    x, y = distance * math.cos(angle), distance * math.sin(angle)
    along_x, along_y = -math.sin(angle) * half_length, math.cos(angle) * half_length
    return (x - along_x, y - along_y, x + along_x, y + along_y)


def test_wall_square_on():
    assert heard(World("wall", walls=[(2.0, -3.0, 2.0, 3.0)])) == 2.0


@pytest.mark.parametrize("normal_deg", [-12.4, -5.0, 0.0, 7.0, 12.4])
def test_wall_at_an_angle_within_the_cone_is_heard_at_its_perpendicular(normal_deg):
    assert heard(World("wall", walls=[wall_at(1.5, normal_deg)])) == pytest.approx(1.5, abs=1e-12)


@pytest.mark.parametrize("normal_deg", [-80.0, -45.0, -13.0, 12.6, 30.0, 60.0, 82.0])
def test_wall_at_a_greater_angle_is_heard_along_the_edge_of_the_cone(normal_deg):
    expected = 0.5 / math.cos(math.radians(abs(normal_deg) - 12.5))
    assert heard(World("wall", walls=[wall_at(0.5, normal_deg)])) == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize("normal_deg", [102.6, -102.6, 120.0, 167.4, -167.4, 167.6, -167.6, 180.0])
def test_wall_that_no_edge_of_the_cone_leads_to_is_not_heard(normal_deg):
    assert heard(World("wall", walls=[wall_at(0.01, normal_deg, half_length=1000.0)])) == MAXIMUM


def test_grazing_wall_is_heard_only_within_the_maximum():
    just_within = math.degrees(math.acos(0.5 / 4.99)) + 12.5
    just_beyond = math.degrees(math.acos(0.5 / 5.01)) + 12.5
    assert heard(World("wall", walls=[wall_at(0.5, just_within)])) == pytest.approx(4.99, abs=1e-9)
    assert heard(World("wall", walls=[wall_at(0.5, just_beyond)])) == MAXIMUM


def test_wall_seen_exactly_from_its_end():
    assert heard(World("end on", walls=[(2.0, 0.0, 4.0, 0.0)])) == 2.0
    assert heard(World("end on", walls=[(4.0, 0.0, 2.0, 0.0)])) == 2.0
    assert heard(World("behind", walls=[(-4.0, 0.0, -2.0, 0.0)])) == MAXIMUM


@pytest.mark.parametrize("low_deg, high_deg, nearest_deg", [
    (-40.0, 40.0, 0.0),      # fills the cone: the perpendicular
    (5.0, 40.0, 5.0),        # begins within the cone: its beginning
    (-40.0, -5.0, -5.0),
    (-3.0, 9.0, 0.0),        # all of it within the cone
    (4.0, 9.0, 4.0),
])
def test_part_of_a_wall_within_the_cone(low_deg, high_deg, nearest_deg):
    low, high, nearest = (2.0 * math.tan(math.radians(angle)) for angle in (low_deg, high_deg, nearest_deg))
    world = World("piece", walls=[(2.0, low, 2.0, high)])
    assert heard(world) == pytest.approx(math.sqrt(4.0 + nearest ** 2), abs=1e-12)


@pytest.mark.parametrize("low_deg, high_deg", [(12.6, 40.0), (-40.0, -12.6)])
def test_wall_beside_the_cone_is_not_heard(low_deg, high_deg):
    low, high = (2.0 * math.tan(math.radians(angle)) for angle in (low_deg, high_deg))
    assert heard(World("beside", walls=[(2.0, low, 2.0, high)])) == MAXIMUM


@pytest.mark.parametrize("radius", [0.025, 0.15, 1.0])
@pytest.mark.parametrize("bearing_deg", [-12.4, 0.0, 9.0])
def test_pole_in_the_cone_is_heard_at_its_rim(radius, bearing_deg):
    angle = math.radians(bearing_deg)
    world = World("pole", posts=[(3.0 * math.cos(angle), 3.0 * math.sin(angle), radius)])
    assert heard(world) == pytest.approx(3.0 - radius, abs=1e-12)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_pole_that_reaches_into_the_cone_is_heard_where_the_edge_enters_it(side):
    radius, beyond = 0.3, 0.2
    angle = side * (HALF + math.asin(beyond / 3.0))
    world = World("pole", posts=[(3.0 * math.cos(angle), 3.0 * math.sin(angle), radius)])
    assert heard(world) == pytest.approx(math.sqrt(9.0 - beyond ** 2) - math.sqrt(radius ** 2 - beyond ** 2), abs=1e-12)


@pytest.mark.parametrize("bearing_deg", [12.5 + 5.75, -12.5 - 5.75, 90.0, 180.0])
def test_pole_beside_or_behind_the_cone_is_not_heard(bearing_deg):
    angle = math.radians(bearing_deg)  # a pole of 0.3 m at 3 m ends 5.74 degrees beside its middle
    assert heard(World("pole", posts=[(3.0 * math.cos(angle), 3.0 * math.sin(angle), 0.3)])) == MAXIMUM


def test_sensor_inside_a_post_hears_it_at_once():
    assert heard(World("post", posts=[(-0.1, 0.0, 0.3)])) == 0.0


def test_corner_that_points_at_the_sensor_is_heard_at_its_tip():
    walls = [(2.0, 0.3, 3.0, 1.3), (2.0, 0.3, 3.0, -0.7)]
    assert heard(World("outer corner", walls=walls)) == pytest.approx(math.hypot(2.0, 0.3), abs=1e-12)


def test_corner_looked_into_is_heard_along_both_edges_of_the_cone():
    walls = [(2.0, 0.0, 0.0, 2.0), (2.0, 0.0, 0.0, -2.0)]  # each at 45 degrees, sqrt(2) from the sensor
    along_an_edge = math.sqrt(2.0) / math.cos(math.radians(45.0 - 12.5))
    assert heard(World("inner corner", walls=walls)) == pytest.approx(along_an_edge, abs=1e-12)


def test_nearest_of_several_is_heard():
    walls, posts = [(3.0, -1.0, 3.0, 1.0), (2.5, -1.0, 2.5, 1.0)], [(2.0, 0.0, 0.1), (4.0, 0.0, 0.5)]
    world = World("several", walls=walls, posts=posts)
    assert heard(world) == pytest.approx(1.9, abs=1e-12)
    assert heard(world, x=2.2) == pytest.approx(0.3, abs=1e-12)


def test_maximum():
    assert heard(World("near", walls=[(4.99, -1.0, 4.99, 1.0)])) == 4.99
    assert heard(World("far", walls=[(5.01, -1.0, 5.01, 1.0)])) == 5.0
    assert heard(World("far", walls=[(5.01, -1.0, 5.01, 1.0)]), maximum=6.0) == 5.01


def test_no_least_distance():
    assert heard(World("at the nose", walls=[(0.03, -1.0, 0.03, 1.0)])) == 0.03


def test_empty_world():
    assert heard(World("empty")) == MAXIMUM


def test_cans_are_below_the_sonar():
    assert heard(World("can", cans=[Can(1.0, 0.0)])) == MAXIMUM


@pytest.mark.parametrize("half_width", [0.0, -0.1, math.radians(46.0), math.nan])
def test_cone_too_wide_or_without_width_is_refused(half_width):
    with pytest.raises(UsageError, match="half_width"):
        heard(World("empty"), half_width=half_width)


def crowd(rng):
    """Return a few walls and posts at random places about the origin."""
    walls = [[rng.uniform(-3.0, 3.0) for _ in range(4)] for _ in range(rng.randint(0, 5))]
    posts = [(rng.uniform(-3.0, 3.0), rng.uniform(-3.0, 3.0), rng.choice([0.025, 0.1, 0.8]))
             for _ in range(rng.randint(0, 3))]
    return walls, posts


def sampled_echo(walls, posts, x, y, heading, half_width):
    """Return the distance to the nearest of many points on all walls and rims that are in the cone. arctan2 decides
    which are. Inside a post the distance is 0.
    """
    share = np.linspace(0.0, 1.0, 20001)
    points = [(x1 + (x2 - x1) * share, y1 + (y2 - y1) * share) for x1, y1, x2, y2 in walls]
    points += [(px + r * np.cos(2 * np.pi * share), py + r * np.sin(2 * np.pi * share)) for px, py, r in posts]
    nearest = MAXIMUM
    for px, py in points:
        bearing = (np.arctan2(py - y, px - x) - heading + np.pi) % (2.0 * np.pi) - np.pi
        distances = np.hypot(px - x, py - y)[np.abs(bearing) <= half_width]
        nearest = min(nearest, distances.min(initial=MAXIMUM))
    return 0.0 if any(math.hypot(px - x, py - y) <= r for px, py, r in posts) else nearest


@pytest.mark.parametrize("seed", range(60))
def test_random_worlds_against_points_sampled_densely(seed):
    rng = random.Random(seed)
    walls, posts = crowd(rng)
    half_width = math.radians(rng.choice([12.5, 12.5, 4.0, 45.0]))
    poses = [(rng.uniform(-3.0, 3.0), rng.uniform(-3.0, 3.0), rng.uniform(-7.0, 7.0)) for _ in range(4)]
    world = World("crowd", walls, posts)
    for pose in poses:
        assert heard(world, *pose, half_width) == pytest.approx(sampled_echo(walls, posts, *pose, half_width), abs=2e-3)


@pytest.mark.parametrize("seed", range(20))
def test_moving_and_turning_everything_changes_nothing(seed):
    rng = random.Random(seed)
    walls, posts = crowd(rng)
    turn, dx, dy = rng.uniform(-4.0, 4.0), rng.uniform(-50.0, 50.0), rng.uniform(-50.0, 50.0)

    def moved(x, y):
        return x * math.cos(turn) - y * math.sin(turn) + dx, x * math.sin(turn) + y * math.cos(turn) + dy

    poses = [(rng.uniform(-3.0, 3.0), rng.uniform(-3.0, 3.0), rng.uniform(-3.0, 3.0)) for _ in range(5)]
    there = World("there", [moved(*wall[:2]) + moved(*wall[2:]) for wall in walls],
                  [moved(x, y) + (r,) for x, y, r in posts])
    here = World("here", walls, posts)
    for x, y, heading in poses:
        assert heard(there, *moved(x, y), heading + turn) == pytest.approx(heard(here, x, y, heading), abs=1e-9)


def test_a_world_that_was_heard_before_gives_the_very_bytes_of_a_new_one():
    rng = random.Random(5)
    walls = [[rng.uniform(-30.0, 30.0) for _ in range(4)] for _ in range(40)]
    world = World("large", walls, [(1.0, 1.0, 0.2)])
    poses = [(rng.uniform(-30.0, 30.0), rng.uniform(-30.0, 30.0), rng.uniform(-3.0, 3.0)) for _ in range(50)]
    together = [heard(world, *pose) for pose in poses]
    apart = [heard(World("large", walls, [(1.0, 1.0, 0.2)]), *pose) for pose in poses]
    assert together == apart
    assert min(apart) < MAXIMUM == max(apart)


@pytest.mark.parametrize("walls, places", [
    ([], 1),
    ([(1000.0, -3.0, 1000.0, 3.0)], 1),
    ([(2.0, -300.0, 2.0, 300.0)], 100),
])
def test_a_floor_without_end_takes_no_memory_where_nothing_is(walls, places):
    world = World("floor", walls=walls)
    for metres in range(100):
        heard(world, y=float(metres))
    ear = world.ear(HALF, MAXIMUM)
    assert len({id(ear._earshot(0, metres)) for metres in range(100)}) == places
    assert world.clearance(0.0, 0.0) == (walls[0][0] if walls else math.inf)
    world.touches([(0.0, 0.0), (0.1, 0.0), (0.0, 0.1)])
    assert (world._neighbourhood.cache_info().currsize == 0) is (not walls)
