"""Finding the solids near a point, and polygons that overlap."""

import math
import random

import numpy as np
import pytest

from pioneer_control.simulator.world.geometry import Solids, is_inside, outlines_meet

SQUARE = ((-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0))


def solids(walls=(), posts=()):
    return Solids(np.array(walls, dtype=float).reshape(-1, 4), np.array(posts, dtype=float).reshape(-1, 3))


def distance(x, y, x1, y1, x2, y2):
    """Return the distance from a point to a segment, calculated in another way than ours."""
    share = np.dot((x - x1, y - y1), (x2 - x1, y2 - y1)) / math.dist((x1, y1), (x2, y2)) ** 2
    share = min(1.0, max(0.0, share))
    return math.dist((x, y), (x1 + share * (x2 - x1), y1 + share * (y2 - y1)))


@pytest.mark.parametrize("seed", range(10))
def test_what_lies_within_reach_of_a_point(seed):
    rng, found = random.Random(seed), 0
    size = rng.choice([1.0, 10.0, 100.0])
    everything = solids(
        [[rng.uniform(-size, size) for _ in range(4)] for _ in range(rng.randint(0, 80))],
        [(rng.uniform(-size, size), rng.uniform(-size, size), rng.choice([0.02, 0.6, 7.0]))
         for _ in range(rng.randint(0, 20))])
    for _ in range(50):
        x, y, reach = rng.uniform(-1.2 * size, 1.2 * size), rng.uniform(-1.2 * size, 1.2 * size), rng.choice([0.3, 5.0])
        near = everything.within(x, y, reach)
        assert near.walls.tolist() == [wall for wall in everything.walls.tolist() if distance(x, y, *wall) <= reach]
        assert near.posts.tolist() == [[px, py, radius] for px, py, radius in everything.posts.tolist()
                                       if math.dist((x, y), (px, py)) - radius <= reach]
        found += len(near)
    assert found or size > 10.0 or not len(everything)


def test_a_wall_much_longer_than_all_others_is_found_everywhere():
    near = solids([(-1e6, 0.0, 1e6, 1.0), (3.0, 3.0, 4.0, 4.0)]).within
    assert [len(near(x, 0.5, 2.0)) for x in (-9e5, 0.0, 123456.0, 9.99e5, 2e6)] == [1, 1, 1, 1, 0]


@pytest.mark.parametrize("x, y, size, meet", [
    (1.9, 0.0, 1.0, True),
    (2.1, 0.0, 1.0, False),
    (1.9, 1.9, 1.0, True),
    (0.0, 0.0, 0.3, True),
    (0.2, 0.1, 5.0, True),
    (-4.0, 3.0, 2.0, False),
])
def test_polygons_meet(x, y, size, meet):
    other = [(x + size * cx, y + size * cy) for cx, cy in SQUARE]
    assert outlines_meet(SQUARE, other) is meet and outlines_meet(other[::-1], SQUARE) is meet


def test_polygons_that_only_point_at_each_other_do_not_meet():
    assert outlines_meet(SQUARE, [(1.1, 0.0), (2.0, -0.5), (2.0, 0.5)]) is False
    assert outlines_meet(SQUARE, [(0.9, 0.0), (2.0, -0.5), (2.0, 0.5)]) is True


@pytest.mark.parametrize("point, inside", [
    ((0.0, 0.0), True), ((0.99, -0.99), True), ((1.01, 0.0), False), ((-3.0, 0.5), False), ((0.0, 9.0), False)])
def test_a_point_inside_a_polygon(point, inside):
    assert is_inside(*point, SQUARE) is inside
    assert is_inside(*point, SQUARE[::-1]) is inside
    assert not is_inside(*point, [point] * 4), "a polygon without size has no inside"
