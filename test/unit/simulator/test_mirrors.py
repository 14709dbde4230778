"""What sonar hears among walls that it meets at a slant: closed forms from paper, and brute force with rays."""

import math
import random

import numpy as np
import pytest
from robot_on_bench import Bench, heard

from pioneer_control.simulator.world import World
from pioneer_control.simulator.world.mirrors import SCATTERED
from pioneer_control.simulator.world.poses import box_walls, unit

HALF = math.radians(12.5)
SLANTING = (2.0, 0.0, 3.0, 1.0)    # met at 45 degrees and more from the origin
SQUARE_ON = (4.0, -3.0, 4.0, 3.0)


def heard_at(specular_deg, world, x=0.0, y=0.0, heading=0.0, half_width=HALF, listener=None):
    """Return the range of one sensor to which walls return no echo beyond `specular_deg`."""
    ear = world.ear(half_width, 5.0, math.tan(math.radians(specular_deg)))
    return ear.echo(x, y, heading, unit(heading - half_width), unit(heading + half_width), listener)


@pytest.mark.parametrize("walls, expected", [
    ([(1.0, -2.0, 3.0, 2.0)], 5.0),                                             # met at 14 degrees at best: lost
    ([(1.0, -2.0, 3.0, 2.0), SQUARE_ON], 5.0),                                  # and so is what is behind it
    ([SQUARE_ON], 4.0),
    ([SLANTING, SQUARE_ON], 4.0),                                               # still heard beside its end
    ([(1.0, -0.1, 3.0, 0.8), (1.0, -0.1, 3.0, -0.8), SQUARE_ON], 5.0),          # a wedge fills the cone
    ([(3.0, -0.1, 2.0, -1.0), SLANTING, SQUARE_ON], 4.0),                       # a door between two slanting walls
    ([SLANTING, (1.9, -0.5, 1.9, 0.5)], 1.9),                                   # a wall before it is heard
    ([SLANTING, (2.5, 0.05, 2.5, 0.45)], 5.0),                                  # just behind it
    ([SLANTING, (2.5, -0.2, 2.5, 3.0)], 2.5),                                   # reaches out beside its end
    ([SLANTING, (2.2, 0.1, 2.2, 1.0)], math.hypot(2.2, 0.2)),                   # crosses it: heard from there on
])
def test_slanting_walls_hide_what_is_behind_them(walls, expected):
    assert heard_at(10, World("walls", walls)) == pytest.approx(expected, abs=1e-6)


def test_the_nearest_point_in_sight_is_heard_not_the_nearest_point():
    """A mirror hides the foot of the perpendicular; the first point beside the mirror is 10 degrees off the axis."""
    edge = 2.0 * math.tan(math.radians(10.0))
    walls = [(1.0, -1.0, 2.0, edge), SQUARE_ON]
    assert heard_at(15, World("walls", walls)) == pytest.approx(4.0 / math.cos(math.radians(10.0)), abs=1e-5)
    assert heard_at(9, World("walls", walls)) == 5.0     # met there at 10 degrees


def test_the_slanting_part_of_a_wall_that_is_heard_elsewhere_hides_things_too():
    wall = (1.0, 0.0, 1.0, 10.0)    # square on at 1 m in the direction 0; beyond 20 degrees a mirror
    behind = (2.0, 1.0, 1.0, 2.0)   # met squarely in the direction 45 degrees
    heading = math.radians(45.0)
    assert heard_at(20, World("behind", [behind]), heading=heading) == pytest.approx(math.sqrt(4.5))
    assert heard_at(20, World("both", [wall, behind]), heading=heading) == 5.0


@pytest.mark.parametrize("y, radius, expected", [
    (0.0, 0.1, 2.9),                # beside the end of the wall, its nearest point in sight
    (-0.3, 0.1, math.hypot(3.0, 0.3) - 0.1),
    (0.5, 0.1, 5.0),                # behind the wall
    (0.5, 0.6, 3.0 - math.sqrt(0.36 - 0.25)),    # reaches out beside it: heard where it enters the free part
])
def test_a_post_behind_a_slanting_wall(y, radius, expected):
    assert heard_at(20, World("post", [(2.0, 0.0, 2.9, 1.0)], [(3.0, y, radius)])) == pytest.approx(expected, abs=1e-6)


def test_a_sensor_inside_a_post_hears_it_at_once():
    assert heard_at(20, World("post", [SLANTING], [(0.0, 0.0, 0.3)])) == 0.0


INNER = [(3.0, 0.0, 1.0, 2.0), (3.0, 0.0, 1.0, -2.0)]
OUTER = [(2.0, 0.0, 3.0, 1.0), (2.0, 0.0, 3.0, -1.0)]


@pytest.mark.parametrize("walls, corner_x", [(INNER, 3.0), (OUTER, 2.0), ([(2.0, 0.0, 3.0, 0.0)], 2.0)])
def test_corners_and_ends_of_walls_scatter_sound_over_a_short_distance(walls, corner_x):
    world = World("corner", walls)
    assert heard_at(30, world) == heard_at(30, world, x=corner_x - SCATTERED - 0.01) == 5.0
    assert heard_at(30, world, x=corner_x - 0.9) == pytest.approx(0.9)
    assert heard_at(5, world, x=corner_x - 0.9, heading=0.3) == 5.0     # beside the cone


def test_a_corner_behind_a_mirror_is_not_heard():
    box = box_walls((2.0, 0.0), (0.6, 0.6), math.pi / 4.0)
    assert heard_at(30, World("box", box), x=1.0) == pytest.approx(1.0 - 0.3 * math.sqrt(2.0))
    assert heard_at(5, World("screened", [(1.3, -0.9, 1.7, 0.9), *box]), x=0.9, half_width=0.05) == 5.0


@pytest.mark.parametrize("bend_deg, expected", [(0.0, 5.0), (10.0, 5.0), (30.0, 0.5)])
def test_the_joint_of_two_pieces_of_a_straight_wall_is_no_corner(bend_deg, expected):
    (low_x, low_y), (high_x, high_y) = unit(math.radians(60.0)), unit(math.radians(60.0 + bend_deg))
    wall = [(0.5 - 2.0 * low_x, -2.0 * low_y, 0.5, 0.0), (0.5, 0.0, 0.5 + 2.0 * high_x, 2.0 * high_y)]
    assert heard_at(5, World("joint", wall), half_width=0.1) == pytest.approx(expected)


def test_a_chain_of_mirrors_has_no_cracks():
    """A bent screen, mirrors all along: rounding at its joints lets nothing through."""
    for seed in range(50):
        rng = random.Random(seed)
        angles = np.cumsum([rng.uniform(0.01, 0.1) for _ in range(12)]) - 0.4
        # away and back again, so that no piece is met squarely
        points = [(math.cos(a) * (1.0 + 0.5 * (i % 2)), math.sin(a) * (1.0 + 0.5 * (i % 2)))
                  for i, a in enumerate(angles)]
        screen = [first + second for first, second in zip(points, points[1:])]
        half = min(-angles[0], angles[-1], HALF) - 0.001
        shown = World("screen", screen + [SQUARE_ON], [(3.0, 0.0, 0.3)])
        assert heard_at(60, shown, half_width=half) in [pytest.approx(1.0), 5.0]    # its near corners, or nothing


@pytest.mark.parametrize("heading_deg, expected", [(0.0, 1.18), (30.0, 5.0)])
def test_another_robot_hides_and_returns_echoes_as_walls_do(heading_deg, expected):
    """Its box, seen along an axis, is heard; turned by 30 degrees it is lost, with the wall behind it."""
    world = World("two", [SQUARE_ON], starts=[(0.0, 0.0, 0.0)])
    other = Bench(world=world, pose=(1.5, 0.0, math.radians(heading_deg)), gripper=False).robot
    world.crowd.enter(other.hardware.body)
    heard_now = heard_at(10, world)
    assert heard_now == pytest.approx(expected, abs=0.15) if expected < 5.0 else heard_now == 5.0
    assert heard_at(10, world, listener=other.hardware.body) == 4.0
    assert heard_at(90, world) == pytest.approx(heard(world, 0.0, 0.0, 0.0))


def by_rays(walls, posts, x, y, heading, half_width, specular_deg):
    """Return the least distance to the first thing that each of many rays meets, where that returns an echo."""
    angles = heading + np.linspace(-half_width, half_width, 4001)
    dx, dy = np.cos(angles), np.sin(angles)
    first, audible = np.full(angles.shape, 5.0), np.zeros(angles.shape, dtype=bool)
    for x1, y1, x2, y2 in walls:
        ux, uy = np.array([x2 - x1, y2 - y1]) / math.hypot(x2 - x1, y2 - y1)
        across = dx * uy - dy * ux
        with np.errstate(all="ignore"):
            distance = ((x1 - x) * uy - (y1 - y) * ux) / across
            along = (x + distance * dx - x1) * ux + (y + distance * dy - y1) * uy
        met = (distance > 0) & (along >= 0) & (along <= math.hypot(x2 - x1, y2 - y1)) & (distance < first)
        first[met] = distance[met]
        audible[met] = (np.abs(across) >= math.cos(math.radians(specular_deg)))[met]
    for px, py, radius in posts:
        ahead, aside = (px - x) * dx + (py - y) * dy, (px - x) * dy - (py - y) * dx
        distance = ahead - np.sqrt(np.maximum(radius * radius - aside * aside, 0.0))
        met = (np.abs(aside) <= radius) & (distance > 0) & (distance < first)
        first[met], audible[met] = distance[met], True
    nearest = float(first[audible].min(initial=5.0))
    for end_x, end_y in [end for x1, y1, x2, y2 in walls for end in ((x1, y1), (x2, y2))]:
        distance, bearing = math.hypot(end_x - x, end_y - y), math.atan2(end_y - y, end_x - x)
        off = math.remainder(bearing - heading, 2.0 * math.pi)
        if distance < SCATTERED and abs(off) < half_width:
            before = first[abs(np.remainder(angles - bearing + np.pi, 2.0 * np.pi) - np.pi).argmin()]
            nearest = min(nearest, distance) if before > distance - 0.02 else nearest
    return nearest


@pytest.mark.parametrize("seed", range(40))
def test_random_rooms_against_rays(seed):
    rng = random.Random(seed)
    walls = [[rng.uniform(-3.0, 3.0) for _ in range(4)] for _ in range(rng.randint(0, 6))]
    walls += box_walls((rng.uniform(-2, 2), rng.uniform(-2, 2)), (0.8, 0.4), rng.uniform(-3, 3))
    world = World("room", walls)
    posts = [(x, y, radius) for x, y, radius in
             ((rng.uniform(-3.0, 3.0), rng.uniform(-3.0, 3.0), rng.choice([0.025, 0.1, 0.4])) for _ in range(4))
             if world.clearance(x, y) > radius]
    world = World("room", walls, posts)
    half_width, specular_deg = rng.choice([0.05, 0.218, 0.7]), rng.choice([10, 20, 40, 70])
    for _ in range(6):
        pose = rng.uniform(-3.0, 3.0), rng.uniform(-3.0, 3.0), rng.uniform(-7.0, 7.0)
        if world.clearance(*pose[:2]) > 0.0:
            expected = by_rays(walls, posts, *pose, half_width, specular_deg)
            assert heard_at(specular_deg, world, *pose, half_width) == pytest.approx(expected, abs=0.03), pose


@pytest.mark.parametrize("seed", range(10))
def test_at_nearly_ninety_degrees_all_is_as_without_mirrors(seed):
    rng = random.Random(seed)
    walls = [[rng.uniform(-3.0, 3.0) for _ in range(4)] for _ in range(6)]
    world = World("room", walls, [(1.0, 1.0, 0.2)])
    for _ in range(5):
        pose = rng.uniform(-3.0, 3.0), rng.uniform(-3.0, 3.0), rng.uniform(-7.0, 7.0)
        assert heard_at(89.999999, world, *pose) == pytest.approx(heard(world, *pose), abs=1e-6)
