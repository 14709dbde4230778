"""What ties one stretch of a path to another, and how a stretch draws its own walls."""

import math

import numpy as np
import pytest

from pioneer_control.floor_poses import Pose, relative
from pioneer_control.navigation.drawn_stretch import DrawnStretch
from pioneer_control.navigation.stretch import Ears, Stretch
from pioneer_control.navigation.ties import HeardWalls, by_odometry, by_walls
from pioneer_control.navigation.tuned import MapNumbers, MapperNumbers, MatchNumbers
from pioneer_control.navigation.values import Firing, Sensing
from pioneer_control.navigation.wheel_motion import WheelBias
from pioneer_control.robots import find_model

SONAR = find_model("p3dx-sh").sonar
NUMBERS, MATCH = MapperNumbers(), MatchNumbers()
END = 3.0
"""The robot drives along y = 0 of a corridor 2 m wide, towards its end at this x (m)."""
EXACT = WheelBias()


def heard_in_corridor(x, y, heading):
    """The range that a transducer hears: the nearest wall in its cone."""
    nearest = math.inf
    for off in np.radians(np.arange(-12.0, 12.1, 1.0)):
        cosine, sine = math.cos(heading + off), math.sin(heading + off)
        nearest = min(nearest, (END - x) / cosine if cosine > 1e-9 else math.inf,
                      ((1.0 if sine > 0.0 else -1.0) - y) / sine if abs(sine) > 1e-9 else math.inf)
    return nearest if nearest < 5.0 else math.inf


def driven(first, last, odometry=1.0):
    """A stretch from x = `first` to `last` (m); the wheels tell so many metres for each."""
    stretch, places = Stretch(0.0, Ears(SONAR)), np.linspace(first, last, 21)
    for number, (before, after) in enumerate(zip(places, places[1:])):
        time = 0.1 * (number + 1)
        firings = tuple(Firing(each.number, heard_in_corridor(after + each.x, each.y, each.heading), time)
                        for each in SONAR)
        before, after = (Pose(odometry * (x - first), 0.0, 0.0) for x in (before, after))
        stretch.add(before, Sensing(time, after, firings), before.x, 0.0)
    return stretch


def drawn_alone(stretch, bias=EXACT, pose=Pose(0.0, 0.0, 0.0)):
    drawn = DrawnStretch(stretch, pose)
    drawn.draw_alone(bias, MapNumbers(), MATCH.own_wall)
    return drawn


def of_end(stretch, pose, hits):
    """The readings of the end wall, when the stretch was found at this pose."""
    beams = stretch.beams(EXACT)
    which = np.nonzero((np.abs(beams.heading) < 0.3) & (beams.range < MATCH.reach))[0]
    return HeardWalls(stretch, pose, which, hits[np.arange(len(which)) % len(hits)])


def tie(drawn, stretch, found, bias=EXACT):
    """The tie of a stretch that was found at this pose (map frame) by the wall at the end."""
    hits = drawn.walls[drawn.walls[:, 0] > drawn.walls[:, 0].max() - 0.1]
    return by_walls(0, drawn, 1, of_end(stretch, found, hits), bias, NUMBERS, MATCH)


def expected(between, bias):
    """What is measured when the wheels err so, array (3)."""
    return np.array(between.pose) + between.by_bias @ np.array(bias)


def test_what_odometry_measures_grows_with_the_wheels():
    between = by_odometry(4, driven(0.0, 1.0), NUMBERS)
    assert between[:2] == (4, 5) and tuple(between.pose) == pytest.approx((1.0, 0.0, 0.0))
    assert between.by_bias == pytest.approx(np.array(((1.0, 0.0, 0.0), (0.0, 0.0, 0.5), (0.0, 0.0, 1.0))), abs=0.03)
    assert not between.doubted


def test_a_stretch_draws_its_own_walls_where_they_are():
    walls = drawn_alone(driven(1.0, 2.0), pose=Pose(1.0, 0.0, 0.0)).walls
    off = np.minimum(np.abs(walls[:, 0] - END), np.abs(np.abs(walls[:, 1]) - 1.0))
    assert len(walls) > 30 and np.median(off) < 0.06
    assert (np.abs(walls[:, 0] - END) < 0.05).sum() > 5


def test_its_own_walls_move_with_it():
    drawn = drawn_alone(driven(1.0, 2.0))
    before, drawn.pose = drawn.walls, Pose(1.0, 2.0, math.pi / 2)
    assert drawn.walls == pytest.approx(np.stack((1.0 - before[:, 1], 2.0 + before[:, 0]), axis=1))


def test_it_has_none_before_it_has_drawn_them():
    assert DrawnStretch(driven(1.0, 2.0), Pose(0.0, 0.0, 0.0)).walls.shape == (0, 2)


@pytest.mark.parametrize("bias, anew", [(WheelBias(0.001, 0.001, 0.001), False), (WheelBias(0.1, 0.0, 0.0), True)])
def test_it_draws_them_anew_when_the_wheels_err_otherwise(bias, anew):
    drawn = drawn_alone(driven(1.0, 2.0))
    before = drawn.walls
    drawn.draw_alone(bias, MapNumbers(), MATCH.own_wall)
    assert (before.shape != drawn.walls.shape or bool((before != drawn.walls).any())) is anew


@pytest.mark.parametrize("found", [0.97, 1.0, 1.03])
def test_walls_tell_how_far_apart_two_stretches_are_wherever_the_map_has_one(found):
    between = tie(drawn_alone(driven(0.5, 1.5)), driven(1.5, 2.5), Pose(found, 0.0, 0.0))
    assert between[:2] == (0, 1) and between.doubted
    assert between.pose.x == pytest.approx(1.0, abs=0.01)


def test_what_walls_tell_does_not_depend_on_where_both_are_drawn():
    drawn, stretch = drawn_alone(driven(0.5, 1.5)), driven(1.5, 2.5)
    here = tie(drawn, stretch, Pose(1.0, 0.0, 0.0))
    drawn.pose = Pose(4.0, 0.0, 0.0)
    assert tie(drawn, stretch, Pose(5.0, 0.0, 0.0)).pose.x == pytest.approx(here.pose.x, abs=0.005)


def test_walls_know_nothing_of_the_ways_to_where_they_were_heard():
    """The wheels tell 0.98 m for each metre. From the begin of one stretch to the begin of the other it is a way by the
    wheels, up to where both heard the wall from, and a way by the wall. So a part of it changes with the bias.
    """
    drawn = drawn_alone(driven(0.5, 1.5, 0.98))
    between = tie(drawn, driven(1.5, 2.5, 0.98), Pose(1.0, 0.0, 0.0))
    bias = WheelBias(1.0 / 0.98 - 1.0, 0.0, 0.0)
    assert expected(between, bias)[0] == pytest.approx(1.0, abs=0.012)
    corrected = drawn_alone(driven(0.5, 1.5, 0.98), bias)
    anew = tie(corrected, driven(1.5, 2.5, 0.98), Pose(1.0, 0.0, 0.0), bias)
    assert expected(anew, bias)[0] == pytest.approx(expected(between, bias)[0], abs=0.012)
    assert expected(anew, EXACT)[0] == pytest.approx(expected(between, EXACT)[0], abs=0.012)


def test_a_turn_within_a_stretch_is_by_the_wheels_too():
    """One that turns on the spot: the later it heard the walls, the more its begin turns with the error of turns."""
    early, late = (by_walls(0, drawn_alone(driven(0.5, 1.5)), 1, turning(range(*part)), EXACT, NUMBERS, MATCH)
                   for part in ((0, 5), (15, 20)))
    assert early.by_bias[2, 1] == pytest.approx(-0.1 * 3.0, abs=0.15)
    assert late.by_bias[2, 1] == pytest.approx(-0.1 * 18.0, abs=0.15)


def turning(which):
    """A stretch that turns at x = 2 m by 2 rad in 20 packets, and what it heard of the walls in some of these."""
    stretch = Stretch(0.0, Ears(SONAR))
    hits, numbers = [], []
    for packet in range(20):
        before, after = (Pose(0.0, 0.0, 0.1 * each) for each in (packet, packet + 1))
        firings = []
        for each in SONAR:
            x, y = (each.x * math.cos(after.heading) - each.y * math.sin(after.heading),
                    each.x * math.sin(after.heading) + each.y * math.cos(after.heading))
            firings.append(Firing(each.number, heard_in_corridor(2.0 + x, y, after.heading + each.heading),
                                  0.1 * (packet + 1)))
        first = stretch.heard_count
        stretch.add(before, Sensing(0.1 * (packet + 1), after, tuple(firings)), 0.0, 0.1 * packet)
        if packet in which:
            numbers += list(range(first, stretch.heard_count))
    beams = stretch.beams(EXACT)
    numbers = [each for each in numbers if beams.range[each] < 1.5]
    hits = [(1.5 + beams.x[each] + beams.range[each] * math.cos(beams.heading[each]),
             beams.y[each] + beams.range[each] * math.sin(beams.heading[each])) for each in numbers]
    return HeardWalls(stretch, Pose(1.5, 0.0, 0.0), np.array(numbers), np.array(hits))


def test_readings_that_say_nothing_tie_nothing():
    drawn, stretch = drawn_alone(driven(0.5, 1.5)), driven(1.5, 2.5)
    heard = of_end(stretch, Pose(1.0, 0.0, 0.0), drawn.walls)
    assert by_walls(0, drawn, 1, heard._replace(pose=Pose(60.0, 0.0, 0.0)), EXACT, NUMBERS, MATCH) is None
    assert by_walls(0, drawn, 1, heard._replace(hits=heard.hits + 50.0), EXACT, NUMBERS, MATCH) is None
    assert by_walls(0, DrawnStretch(drawn.stretch, drawn.pose), 1, heard, EXACT, NUMBERS, MATCH) is None


def test_poses_are_relative_to_the_first():
    turned = drawn_alone(driven(0.5, 1.5), pose=Pose(2.0, 1.0, math.pi / 2))
    walls = turned.walls[turned.walls[:, 1] > turned.walls[:, 1].max() - 0.1]
    heard = of_end(driven(1.5, 2.5), Pose(2.0, 2.0, math.pi / 2), walls)
    between = by_walls(0, turned, 1, heard, EXACT, NUMBERS, MATCH)
    assert between.pose[:2] == pytest.approx((1.0, 0.0), abs=0.02)
    assert relative(turned.pose, Pose(2.0, 2.0, math.pi / 2))[:2] == pytest.approx((1.0, 0.0))
    assert np.linalg.norm(between.root[:, 0]) > 3.0 * np.linalg.norm(between.root[:, 1]), "the end tells the way along"
