"""The robot's moves: how far each goes before it touches something, and along which some transducer looks."""

import math

import numpy as np
import pytest
from floor_for_tests import chassis_of

from pioneer_control.navigation.chassis import FAR, Manoeuvre, Moves, after, distance_outside
from pioneer_control.robots import find_model

MARGIN = 0.045


def moves_of(subtype="p3dx-sh", rear=True):
    return Moves(chassis_of(subtype, rear), MARGIN)


def way(moves, move, *points):
    x, y = (np.array(each) for each in zip(*points))
    return moves.ways(x, y)[moves.each.index(Manoeuvre(*move))]


def test_without_points_every_move_is_free():
    moves = moves_of()
    free = moves.ways(np.zeros(0), np.zeros(0))
    assert set(free[moves.direction != 0]) == {FAR} and (free[moves.direction == 0] == 2 * math.pi).all()


def test_straight_on_ends_before_the_point_ahead():
    assert way(moves_of(), (1, 0.0), (0.9, 0.0)) == pytest.approx(0.9 - 0.21 - MARGIN, abs=0.02)


def test_straight_back_ends_before_the_point_behind():
    assert way(moves_of(), (-1, 0.0), (-0.9, 0.1)) == pytest.approx(0.9 - 0.301 - MARGIN, abs=0.02)


def test_what_is_beside_the_way_does_not_end_it():
    assert way(moves_of(), (1, 0.0), (0.9, 0.2125 + MARGIN + 0.03)) == FAR
    assert way(moves_of(), (1, 0.0), (0.9, 0.2125 + MARGIN - 0.03)) < 0.7


@pytest.mark.parametrize("move", [(1, 0.8), (1, -2.6), (-1, 0.5), (-1, -1.2)])
def test_an_arc_ends_where_its_outline_meets_the_point(move):
    moves, chassis, point = moves_of(), chassis_of(), (0.55 * move[0], math.copysign(0.3, move[1] * move[0]))
    found = way(moves, move, point)
    assert 0.0 < found < FAR

    def distance(length):
        x, y, heading = after(Manoeuvre(*move), length)
        dx, dy = point[0] - x, point[1] - y
        return float(distance_outside(
            chassis.outline, np.array([dx * math.cos(heading) + dy * math.sin(heading)]),
            np.array([dy * math.cos(heading) - dx * math.sin(heading)]))[0])

    assert distance(found) == pytest.approx(MARGIN, abs=0.04)
    assert all(distance(found * share) > MARGIN - 0.03 for share in np.linspace(0.0, 0.95, 30))


@pytest.mark.parametrize("point, expected", [
    ((0.34, 0.0), -0.01), ((0.0, 0.2), -0.0125), ((0.36, 0.0), 0.01), ((0.0, 0.2225), 0.01), ((-0.2, -0.2125), 0.0)])
def test_the_paddles_of_a_gripper_belong_to_the_robot(point, expected):
    outline = find_model("p3dx-sh").outline(gripper=True)
    assert len(outline) == 8
    off = distance_outside(outline, *np.array(point, dtype=np.float32)[:, np.newaxis])
    assert float(off[0]) == pytest.approx(expected, abs=0.001)


def test_a_turn_ends_when_the_rear_corner_comes_to_the_point():
    moves = moves_of()
    assert 0.1 < way(moves, (0, 1.0), (0.0, -0.33)) < 1.2
    assert way(moves, (0, 1.0), (0.0, -0.45)) == pytest.approx(2 * math.pi)


def test_what_is_within_the_margin_forbids_only_what_brings_it_nearer():
    moves, ahead = moves_of(), (0.23, 0.0)
    assert way(moves, (1, 0.0), ahead) == pytest.approx(0.0, abs=0.01)
    assert way(moves, (-1, 0.0), ahead) == FAR


def test_left_and_right_are_mirrored():
    moves = moves_of("p3at-sh")
    for bend in (0.45, 2.6):
        assert way(moves, (1, bend), (0.7, 0.2)) == pytest.approx(way(moves, (1, -bend), (0.7, -0.2)), abs=0.03)


def test_a_wider_robot_touches_sooner():
    assert way(moves_of("p3at-sh"), (1, 0.0), (0.9, 0.24)) < FAR == way(moves_of("amigo-sh"), (1, 0.0), (0.9, 0.24))


@pytest.mark.parametrize("subtype, rear, back", [
    ("p3dx-sh", True, True), ("p3dx-sh", False, False), ("p3at-sh", True, True), ("pion1m", True, False)])
def test_without_sonar_behind_it_does_not_drive_back(subtype, rear, back):
    moves, chassis = moves_of(subtype, rear), chassis_of(subtype, rear)
    covered = moves.covered(each.number for each in chassis.transducers)
    assert covered[moves.each.index(Manoeuvre(1, 0.8))]
    assert covered[moves.each.index(Manoeuvre(-1, 0.0))] == back


def test_an_amigobot_does_not_drive_where_the_gap_between_its_cones_leads():
    moves, chassis = moves_of("amigo-sh"), chassis_of("amigo-sh")
    covered = moves.covered(each.number for each in chassis.transducers)
    unseen = [move for move, looked in zip(moves.each, covered) if not looked]
    assert {(1, 0.0), (-1, 0.0)} < set(unseen) and (1, 0.2) not in unseen and (1, -2.6) not in unseen


def test_transducers_that_do_not_fire_do_not_look():
    moves = moves_of()
    assert not moves.covered(range(8, 16))[moves.direction == 1].any()
    assert not moves.covered([])[moves.direction != 0].any()
    assert moves.covered(range(8))[(moves.direction == 1) & (abs(moves.bend) < 3.0)].all()
    assert not moves.covered(range(8))[moves.direction == -1].any()
