"""How far an outline can move, in cases that can be calculated by hand."""

import math

import pytest

from pioneer_control.tutorial.clearance import Outline, hull_edges

# 0.6 m long, 0.4 m wide, turning about a point 0.2 m behind its front
BODY = Outline([(-0.4, -0.2), (0.2, -0.2), (0.2, 0.2), (-0.4, 0.2)])


def test_hull_of_a_body_with_paddles_spans_them_and_forgets_the_notches():
    corners = [(-0.3, -0.2), (0.2, -0.2), (0.2, -0.1), (0.35, -0.1), (0.35, 0.1), (0.2, 0.1), (0.2, 0.2), (-0.3, 0.2)]
    begins, ends = zip(*hull_edges(corners))
    assert set(begins) == set(ends) == set(corners) - {(0.2, -0.1), (0.2, 0.1)} and len(begins) == 6


def test_measures_of_the_outline():
    assert BODY.reach == pytest.approx(math.hypot(0.4, 0.2))
    assert (BODY.half_width, BODY.rear) == (0.2, 0.4)


@pytest.mark.parametrize("point, distance", [
    ((0.5, 0.0), 0.3), ((0.0, 0.0), -0.2), ((0.2, 0.3), 0.1), ((-0.5, 0.1), 0.1)])
def test_distance_is_outside_positive_inside_negative(point, distance):
    assert BODY.distance(*point) == pytest.approx(distance)


def test_straight_on_until_it_touches():
    assert BODY.straight([(0.9, 0.0)], 0.05, 3.0) == pytest.approx(0.7)
    assert BODY.straight([(0.9, 0.0), (0.5, 0.19)], 0.05, 3.0) == pytest.approx(0.3)


def test_straight_back_until_it_touches():
    assert BODY.straight([(-0.9, 0.0), (0.3, 0.0)], 0.05, 3.0, -1) == pytest.approx(0.5)


@pytest.mark.parametrize("side", [1, -1])
def test_the_margin_counts_at_the_sides(side):
    assert BODY.straight([(0.9, side * 0.249)], 0.05, 3.0) == pytest.approx(0.7)
    assert BODY.straight([(0.9, side * 0.251)], 0.05, 3.0) == 3.0


def test_what_stands_beside_does_not_hinder_but_what_is_inside_does():
    assert BODY.straight([(0.0, 0.21)], 0.05, 3.0) == 3.0
    assert BODY.straight([(0.0, 0.19)], 0.05, 3.0) == 0.0


def test_what_is_passed_does_not_hinder():
    assert BODY.straight([(-0.6, 0.0)], 0.05, 3.0) == 3.0


def test_the_turning_circle_goes_until_it_touches():
    radius = BODY.reach + 0.05
    assert BODY.circle_straight([(1.0, 0.0)], 0.05, 3.0) == pytest.approx(1.0 - radius)
    assert BODY.circle_straight([(1.0, radius + 0.01), (-1.0, 0.0)], 0.05, 3.0) == 3.0


def test_what_is_inside_its_margin_hinders_it_only_ahead_of_the_bare_circle():
    between = BODY.reach + 0.02
    assert BODY.circle_straight([(0.1, between)], 0.05, 3.0) == 3.0
    assert BODY.circle_straight([(between, 0.0)], 0.05, 3.0) == pytest.approx(0.02)
    assert BODY.circle_straight([(0.3, 0.3)], 0.05, 3.0) == 0.0


def test_a_turn_is_free_when_nothing_stands_in_the_circle():
    assert BODY.turn([(0.48, 0.0), (-0.3, 0.4)], 1, 0.03, 1.0) == 1.0


def test_a_turn_ends_where_a_corner_would_touch():
    # The rear left corner turns left into what stands behind. It is at 153.4 degrees now, so it gets there before 26.6.
    behind = [(-0.43, 0.0)]
    free = BODY.turn(behind, 1, 0.0, 2.0)
    assert 0.2 < free < math.radians(180) - math.atan2(0.2, -0.4)
    assert BODY.turn(behind, -1, 0.0, 2.0) == pytest.approx(free)


def test_a_turn_away_from_something_near_is_free():
    near_the_front_left_corner = [(0.15, 0.21)]
    assert BODY.turn(near_the_front_left_corner, -1, 0.03, 0.3) == 0.3
    assert BODY.turn(near_the_front_left_corner, 1, 0.03, 0.3) < 0.3
