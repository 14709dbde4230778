"""A stretch of path is found on a map, and tells how sure that is."""

import math
from dataclasses import replace

import numpy as np
import pytest

from pioneer_control.floor_poses import Pose, relative
from pioneer_control.navigation.scan_match import match, wall_points
from pioneer_control.navigation.sonar_grid import SonarBeams
from pioneer_control.navigation.tuned import MatchNumbers

NUMBERS = MatchNumbers()
HALF_CONE = NUMBERS.half_cone
ALONG = np.arange(-3.975, 4.0, 0.05)
CORRIDOR = np.concatenate([np.stack((ALONG, np.full_like(ALONG, y)), axis=1) for y in (-1.0, 1.0)])
END = np.stack((np.full(40, 2.0), np.linspace(-0.975, 0.975, 40)), axis=1)


def heard(walls, x, y, heading):
    """Return the distance of the nearest point of walls in the cone of a transducer; infinite if there is none."""
    way = walls - (x, y)
    distance = np.hypot(way[:, 0], way[:, 1])
    off = np.abs(np.remainder(np.arctan2(way[:, 1], way[:, 0]) - heading + np.pi, 2.0 * np.pi) - np.pi)
    inside = distance[off < HALF_CONE]
    return float(inside.min()) + NUMBERS.nearer if len(inside) else math.inf


def driven(walls, true, way=1.0, sides=(-90, -50, -10, 10, 50, 90)):
    """Return what is heard on a straight stretch that begins at a pose: relative to that pose, echoes alone."""
    found = []
    for forward in np.arange(0.0, way, 0.1):
        for side in np.radians(sides):
            at = true.x + forward * math.cos(true.heading), true.y + forward * math.sin(true.heading)
            reading = heard(walls, *at, true.heading + side)
            if reading < NUMBERS.reach:
                found.append((forward, 0.0, side, reading))
    return SonarBeams(*map(np.array, zip(*found)))


def found_from(walls, true, guess, **numbers):
    return match(walls, driven(walls, true), guess, 0.2, 0.1, replace(NUMBERS, **numbers))


def off(pose, true):
    away = relative(true, pose)
    return math.hypot(away.x, away.y), abs(away.heading)


@pytest.mark.parametrize("guess", [Pose(0.0, 0.0, 0.0), Pose(0.12, -0.1, 0.05), Pose(-0.1, 0.12, -0.08)])
def test_it_finds_where_a_stretch_lies(guess):
    room = np.concatenate((CORRIDOR, END))
    found = found_from(room, Pose(0.0, 0.0, 0.0), guess)
    distance, turn = off(found.pose, Pose(0.0, 0.0, 0.0))
    assert distance < 0.015 and turn < 0.01
    assert found.fit > 0.9


def test_it_finds_the_same_wherever_the_map_has_its_origin_and_its_axes():
    turned = 2.0
    matrix = np.array(((math.cos(turned), -math.sin(turned)), (math.sin(turned), math.cos(turned))))
    room = np.concatenate((CORRIDOR, END)) @ matrix.T + (30.0, -20.0)
    found = found_from(room, Pose(30.0, -20.0, turned), Pose(30.1, -20.08, turned + 0.05))
    distance, turn = off(found.pose, Pose(30.0, -20.0, turned))
    assert distance < 0.02 and turn < 0.01


def test_what_is_heard_in_a_corridor_says_nothing_about_the_way_along():
    found = found_from(CORRIDOR, Pose(0.0, 0.0, 0.0), Pose(0.0, 0.05, 0.0))
    _, information = found.alone(np.full(len(found.hits), True))
    assert information[1, 1] > 20.0 * information[0, 0]
    assert found.pose.y == pytest.approx(0.0, abs=0.01)


def test_an_end_of_the_corridor_says_how_far_along_it_is():
    found = found_from(np.concatenate((CORRIDOR, END)), Pose(0.0, 0.0, 0.0), Pose(0.0, 0.0, 0.0))
    at_end = found.hits[:, 0] > 1.9
    _, of_end = found.alone(at_end)
    _, of_sides = found.alone(~at_end)
    assert of_end[0, 0] > 1000.0 > of_sides[0, 0]
    assert of_sides[1, 1] > of_end[1, 1]


def test_what_all_readings_say_is_the_sum_of_what_each_says():
    """But for directions in which readings curve upwards: these say nothing."""
    found = found_from(np.concatenate((CORRIDOR, END)), Pose(0.0, 0.0, 0.0), Pose(0.0, 0.0, 0.0))
    at_end = found.hits[:, 0] > 1.9
    parts = found.alone(at_end)[1] + found.alone(~at_end)[1]
    whole = found.alone(np.full(len(at_end), True))[1]
    assert np.diag(whole) == pytest.approx(np.diag(parts), rel=0.1)


def test_readings_whose_wall_was_drawn_aside_alone_have_the_stretch_aside():
    """One side of the corridor is drawn 4 cm too far: its readings alone move the stretch by that."""
    shifted = CORRIDOR.copy()
    shifted[len(ALONG):, 1] += 0.04
    beams = driven(CORRIDOR, Pose(0.0, 0.0, 0.0))
    found = match(shifted, beams, Pose(0.0, 0.0, 0.0), 0.1, 0.05, NUMBERS)
    left = found.hits[:, 1] > 0.0
    by_left, by_right = found.alone(left)[0], found.alone(~left)[0]
    assert by_left.y - by_right.y == pytest.approx(0.04, abs=0.015)


def test_more_trust_is_more_information():
    room = np.concatenate((CORRIDOR, END))
    little, much = (found_from(room, Pose(0.0, 0.0, 0.0), Pose(0.0, 0.0, 0.0), trust=trust) for trust in (0.1, 0.2))
    assert much.alone(slice(None))[1][1, 1] == pytest.approx(2.0 * little.alone(slice(None))[1][1, 1], rel=0.2)


def test_readings_far_from_all_walls_say_nothing():
    assert match(CORRIDOR + (50.0, 0.0), driven(CORRIDOR, Pose(0.0, 0.0, 0.0)), Pose(0.0, 0.0, 0.0), 0.2, 0.1,
                 NUMBERS) is None


def test_a_place_that_does_not_fit_is_told_by_its_fit():
    narrow = CORRIDOR * (1.0, 0.8)
    found = match(narrow, driven(CORRIDOR, Pose(0.0, 0.0, 0.0)), Pose(0.0, 0.0, 0.0), 0.1, 0.05, NUMBERS)
    assert found.fit < 0.6


def test_points_of_a_thick_wall_are_where_the_odds_are_greatest():
    odds = np.zeros((7, 9))
    odds[2:5, :] = np.array((1.2, 3.0, 2.0))[:, None]
    points = wall_points(odds, 10, 20, 0.05, 1.0)
    inside = points[(points[:, 0] > 21 * 0.05) & (points[:, 0] < 28 * 0.05)]
    assert len(inside) == 7
    assert inside[:, 1] == pytest.approx((10 + 3.5 + (2.0 - 1.2) / 6.2) * 0.05, abs=1e-6)
    assert wall_points(np.minimum(odds, 0.9), 10, 20, 0.05, 1.0).shape == (0, 2)
