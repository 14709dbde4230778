"""The floor that a robot covers until it stands."""

import math

import numpy as np
import pytest

from pioneer_control.navigation.chassis import Manoeuvre, after
from pioneer_control.navigation.frames import out_of
from pioneer_control.navigation.swept_outlines import SweptOutlines

OUTLINE = (0.2, -0.15), (0.2, 0.15), (-0.2, 0.15), (-0.2, -0.15)
STRAIGHT, LEFT = Manoeuvre(1, 0.0), Manoeuvre(1, 3.6)


def nearest(x, y, *ways):
    return SweptOutlines(OUTLINE, ways).nearest(np.array(x), np.array(y))


@pytest.mark.parametrize("x, distance", [(-0.3, 0.1), (0.3, -0.15), (0.5, -0.15), (0.7, 0.0), (0.8, 0.1)])
def test_straight_on_it_covers_all_between_its_tail_here_and_its_nose_there(x, distance):
    assert nearest([x], [0.0], (STRAIGHT, 0.5))[0] == pytest.approx(distance)


def test_in_a_curve_every_place_where_a_corner_comes_is_covered_but_for_a_centimetre():
    corners = np.array(OUTLINE).T
    for way in np.linspace(0.0, 0.28, 29):
        x, y = out_of(after(LEFT, way), *corners)
        for corner in zip(x, y):
            assert nearest(*([each] for each in corner), (LEFT, 0.28))[0] < 0.01


def test_a_curve_leaves_free_what_lies_outside_of_it():
    x, y = [0.4], [-0.15]
    assert nearest(x, y, (STRAIGHT, 0.28), (LEFT, 0.28)) == pytest.approx([0.0, 0.07], abs=0.05)
    assert nearest(x, y, (LEFT, 0.28))[0] > 0.05


def test_the_nearest_of_several_places_counts_and_none_is_infinitely_far():
    assert nearest([9.0, 1.0], [0.0, 0.0], (STRAIGHT, 0.0), (STRAIGHT, 0.5)) == pytest.approx([0.8, 0.3])
    assert nearest([], [], (STRAIGHT, 0.5), (LEFT, 0.5)).tolist() == [math.inf, math.inf]
