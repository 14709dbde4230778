"""Straight walls beside the way: where they face, and which are square to each other."""

import math
from dataclasses import replace

import numpy as np
import pytest

from pioneer_control.navigation.sonar_grid import SonarBeams
from pioneer_control.navigation.tuned import WallNumbers
from pioneer_control.navigation.wall_directions import _bend, square_walls, wall_directions

NUMBERS = WallNumbers()


def past_wall(heading: float, distance: float = 0.8, count: int = 12, way: float = 1.0, noise: float = 0.0,
              looks: float = math.pi / 2.0) -> SonarBeams:
    """Return the beams of a robot that drives along the x axis with a transducer that looks to `looks`, past a wall
    that faces `heading` at a distance (m) from the origin.
    """
    x = np.linspace(0.0, way, count)
    wobble = noise * (-1.0) ** np.arange(count)
    return SonarBeams(x, np.zeros(count), np.full(count, looks), distance - x * math.cos(heading) + wobble)


def both(first: SonarBeams, second: SonarBeams) -> SonarBeams:
    return SonarBeams(*(np.concatenate(pair) for pair in zip(first, second)))


def facing(beams: SonarBeams):
    return [each.heading for each in wall_directions(beams, NUMBERS)]


@pytest.mark.parametrize("off_deg", [-10.0, -3.0, 0.0, 1.0, 6.5, 11.0])
def test_a_wall_faces_the_robot_by_how_its_range_changes(off_deg):
    heading = math.radians(90.0 + off_deg)
    assert facing(past_wall(heading)) == [pytest.approx(heading, abs=1e-3)]


def test_the_deviation_is_about_that_of_the_direction():
    walls = wall_directions(past_wall(math.pi / 2.0, noise=0.02), NUMBERS)
    assert abs(walls[0].heading - math.pi / 2.0) < 3.0 * walls[0].deviation
    assert 0.005 < walls[0].deviation < 0.03


def test_walls_on_both_sides_are_two():
    beams = both(past_wall(1.6), past_wall(-1.5, 1.1, looks=-math.pi / 2.0))
    assert sorted(each if each < math.pi else each - 2.0 * math.pi for each in facing(beams)) == [
        pytest.approx(-1.5, abs=1e-3), pytest.approx(1.6, abs=1e-3)]


@pytest.mark.parametrize("beams", [
    past_wall(math.pi / 2.0, count=5),                      # few readings
    past_wall(math.pi / 2.0, way=0.4),                      # heard from one place
    past_wall(math.pi / 2.0, distance=3.0),                 # far away
    past_wall(math.pi / 2.0)._replace(range=np.full(12, np.inf)),
    past_wall(math.radians(120.0)),                         # nothing in the cone faces there
    SonarBeams(*np.zeros((4, 0))),
])
def test_what_does_not_tell_a_direction_is_no_wall(beams):
    assert not facing(beams)


@pytest.mark.parametrize("distance", [0.7, 1.3, 2.0])
def test_a_post_is_no_wall(distance):
    """The range to it changes little while the robot goes past, as that of a wall does."""
    x = np.linspace(-0.4, 0.4, 17)
    for looks in (90.0, 75.0, 105.0):
        assert not facing(SonarBeams(x, np.zeros(17), np.full(17, math.radians(looks)), np.hypot(x, distance)))


def looking_left(ranges, x=np.linspace(-0.4, 0.4, 17)):
    return SonarBeams(x, np.zeros(17), np.full(17, math.pi / 2.0), ranges)


def test_what_is_bent_the_other_way_is_no_wall_either():
    assert not facing(looking_left(2.6 - np.hypot(np.linspace(-0.4, 0.4, 17), 1.3)))


@pytest.mark.parametrize("x", [np.linspace(-0.4, 0.4, 17), np.linspace(2.6, 3.4, 17)])
@pytest.mark.parametrize("radius, bend", [(0.0, 1.0), (1.5, 0.5)])
def test_how_bent_posts_are(x, radius, bend):
    beams = looking_left(np.hypot(x - x.mean(), 1.5 + radius) - radius, x)
    assert _bend(beams, math.pi / 2.0) == pytest.approx(bend, abs=0.1)


def test_a_wall_that_is_met_at_a_slant_is_straight():
    x = np.linspace(0.0, 1.0, 17) ** 2
    assert _bend(looking_left(1.3 + 0.1 * x, x), math.pi / 2.0) == pytest.approx(0.0, abs=0.01)


def test_clutter_beside_a_wall_does_not_turn_it():
    clutter = SonarBeams(np.linspace(0.0, 1.0, 7), np.zeros(7), np.full(7, math.pi / 2.0),
                         np.array((0.3, 0.5, 0.25, 0.6, 0.35, 0.5, 0.2)))
    assert facing(both(past_wall(1.55), clutter))[0] == pytest.approx(1.55, abs=1e-3)


def squared(degrees, deviation=0.01):
    headings = np.radians(degrees)
    return square_walls(headings, np.full(len(headings), deviation), NUMBERS)


def test_walls_that_are_square_say_how_far_each_is_off():
    square = squared([1.0, 89.0, 180.5, -90.5, 30.0, 0.0])
    assert square.which.tolist() == [True, True, True, True, False, True]
    assert np.degrees(square.off).tolist() == pytest.approx([1.0, -1.0, 0.5, -0.5, 0.0], abs=1e-9)


@pytest.mark.parametrize("degrees", [
    [0.0, 90.0, 180.0, 270.0],                      # too few
    [0.0, 90.0, 180.0, 270.0, 40.0],                # too few of these are square
    [0.0, 90.0, 180.0, 270.0, 0.0, 10.0, 20.0, 30.0, 40.0, 55.0, 70.0],     # five of eleven
    [0.0, 15.0, 30.0, 45.0, 60.0, 75.0],
    [],
])
def test_walls_are_held_square_only_where_half_of_many_are(degrees):
    assert squared(degrees) is None


def test_half_of_the_walls_is_enough():
    """The others may face anywhere, as tables and crosses in a classroom do."""
    found = squared([0.0, 90.0, 180.0, 270.0, 0.0, 15.0, 30.0, 45.0, 60.0, 75.0])
    assert found.which.tolist() == [True] * 5 + [False] * 5


@pytest.mark.parametrize("count", [5, 6, 7, 8, 10, 12])
def test_walls_that_face_anywhere_are_seldom_square_by_chance(count):
    luck = np.random.default_rng(count)
    by_chance = [square_walls(luck.uniform(0.0, 2.0 * math.pi, count), luck.uniform(0.01, 0.03, count), NUMBERS)
                 for _ in range(300)]
    assert sum(each is not None for each in by_chance) < 9


def test_a_wall_that_is_less_sure_counts_less():
    headings = np.radians([0.0, 0.0, 0.0, 0.0, 3.0])
    square = square_walls(headings, np.array([0.01, 0.01, 0.01, 0.01, 0.1]), replace(NUMBERS, slack=0.01))
    assert abs(square.off[0]) < math.radians(0.05)
    assert square.weights[4] < 0.2 * square.weights[0]
