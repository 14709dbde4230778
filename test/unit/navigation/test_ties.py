"""What ties one stretch of a path to another."""

import math

import numpy as np
import pytest

from pioneer_control.floor_poses import Pose, compose
from pioneer_control.navigation.stretch import Ears, Stretch
from pioneer_control.navigation.ties import DrawnWalls, HeardWalls, by_odometry, by_walls
from pioneer_control.navigation.tuned import MapperNumbers, MatchNumbers
from pioneer_control.navigation.values import Firing, Sensing
from pioneer_control.navigation.wheel_motion import WheelBias
from pioneer_control.robots import find_model

SONAR = find_model("p3dx-sh").sonar
NUMBERS, MATCH = MapperNumbers(), MatchNumbers()
END = 3.0
"""The robot drives along y = 0 of a corridor 2 m wide, towards its end at this x (m)."""
EXACT = WheelBias()
INFORMATION = np.diag((1e2, 1e4, 2.5e3))
"""The readings tell x to 10 cm, y to 1 cm, the heading to 0.02 rad."""


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


def tie(drawn, stretch, drawn_at=Pose(0.0, 0.0, 0.0), found_at=Pose(1.0, 0.0, 0.0), bias=EXACT, part=slice(None)):
    """The tie of two stretches by the wall at the end, from where one is drawn and the other was found (map frame).
    Part of the readings of the other one are used.
    """
    drew, heard = at_end(drawn), at_end(stretch)[part]
    beams = drawn.beams(bias).moved(*drawn_at).chosen(drew)
    hits = np.stack((beams.x + beams.range * np.cos(beams.heading),
                     beams.y + beams.range * np.sin(beams.heading)), axis=1)
    return by_walls(DrawnWalls(0, drawn, drawn_at), HeardWalls(1, stretch, heard, hits, found_at, INFORMATION), bias,
                    NUMBERS, MATCH)


def at_end(stretch):
    """The numbers of the readings of the wall at the end."""
    beams = stretch.beams(EXACT)
    return np.nonzero((np.abs(beams.heading) < 0.3) & (beams.range < MATCH.reach))[0]


def expected(between, bias):
    """What is measured when the wheels err so, array (3)."""
    return np.array(between.pose) + between.by_bias @ np.array(bias)


def test_what_odometry_measures_grows_with_the_wheels():
    between = by_odometry(4, driven(0.0, 1.0), NUMBERS)
    assert between[:2] == (4, 5) and tuple(between.pose) == pytest.approx((1.0, 0.0, 0.0))
    assert between.by_bias == pytest.approx(np.array(((1.0, 0.0, 0.0), (0.0, 0.0, 0.5), (0.0, 0.0, 1.0))), abs=0.03)
    assert not between.doubted


@pytest.mark.parametrize("at", [Pose(0.0, 0.0, 0.0), Pose(4.0, -2.0, 0.0), Pose(2.0, 1.0, math.pi / 2)])
def test_one_stretch_is_relative_to_where_the_other_is_drawn(at):
    between = tie(driven(0.5, 1.5), driven(1.5, 2.5), at, compose(at, Pose(1.0, 0.02, 0.1)))
    assert between[:2] == (0, 1) and between.doubted
    assert tuple(between.pose) == pytest.approx((1.0, 0.02, 0.1))


@pytest.mark.parametrize("part", [slice(0, 8), slice(-8, None)])
def test_ways_to_where_walls_were_heard_are_by_the_wheels(part):
    """From the begin of one stretch to the begin of the other it is a way by the wheels, to where the one heard the
    wall from; a way by the wall; and a way by the wheels, back from where the other heard it.
    """
    bias, one, other = WheelBias(0.02, 0.0, 0.0), driven(0.5, 1.5), driven(1.5, 2.5)
    between = tie(one, other, bias=bias, part=part)
    drew = one.beams(EXACT).chosen(at_end(one)).x.mean()
    heard = other.beams(EXACT).chosen(at_end(other)[part]).x.mean()
    assert abs(drew - heard) > 0.2
    assert between.by_bias[0, 0] == pytest.approx(drew - heard, abs=0.1)
    assert expected(between, bias) == pytest.approx((1.0, 0.0, 0.0), abs=1e-6)
    assert expected(between, EXACT)[0] == pytest.approx(1.0 - 0.02 * (drew - heard), abs=0.003)


def test_a_turn_within_a_stretch_is_by_the_wheels_too():
    """One that turns on the spot: the later it heard the walls, the more its begin turns with the error of turns."""
    drawn = DrawnWalls(0, driven(0.5, 1.5), Pose(0.0, 0.0, 0.0))
    early, late = (by_walls(drawn, turning(range(*part)), EXACT, NUMBERS, MATCH) for part in ((0, 5), (15, 20)))
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
    return HeardWalls(1, stretch, np.array(numbers), np.array(hits), Pose(1.5, 0.0, 0.0), INFORMATION)


def test_walls_that_the_other_one_did_not_hear_tie_nothing():
    stretch = driven(1.5, 2.5)
    heard = HeardWalls(1, stretch, at_end(stretch), np.array(((50.0, 0.0),)), Pose(1.0, 0.0, 0.0), INFORMATION)
    assert by_walls(DrawnWalls(0, driven(0.5, 1.5), Pose(0.0, 0.0, 0.0)), heard, EXACT, NUMBERS, MATCH) is None


@pytest.mark.parametrize("heading", [0.0, 0.7, math.pi / 2])
def test_a_tie_is_as_sure_as_its_readings_but_for_some_slack(heading):
    """The readings tell the way across y of the map, whatever the heading of the stretch that drew the walls."""
    at = Pose(0.0, 0.0, heading)
    root = tie(driven(0.5, 1.5), driven(1.5, 2.5), at, compose(at, Pose(1.0, 0.0, 0.0))).root
    cosine, sine = math.cos(heading), math.sin(heading)
    of_map = np.linalg.inv(root.T @ root)[:2, :2]
    of_map = np.array(((cosine, -sine), (sine, cosine))) @ of_map @ np.array(((cosine, sine), (-sine, cosine)))
    assert of_map == pytest.approx(np.diag((0.1 ** 2, 0.01 ** 2)) + NUMBERS.slack ** 2 * np.eye(2), abs=1e-6)
