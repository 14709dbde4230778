"""What a body touches, and its distance to it."""

import math
import random

import numpy as np
import pytest

from pioneer_control.errors import WorldError
from pioneer_control.simulator.world.world import FREE, OCCUPIED, UNKNOWN, Can, World

SQUARE = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
FORK = [(-1.0, -1.0), (2.0, -1.0), (2.0, -0.5), (1.0, -0.5), (1.0, 0.5), (2.0, 0.5), (2.0, 1.0), (-1.0, 1.0)]
"""An outline that is open towards x."""


@pytest.mark.parametrize("wall, touched", [
    ((0.9, -3.0, 0.9, 3.0), True),          # right through
    ((1.1, -3.0, 1.1, 3.0), False),
    ((0.5, 0.0, 4.0, 0.0), True),           # one end inside
    ((1.5, 0.0, 4.0, 0.0), False),          # on the line of one that would
    ((-4.0, 0.0, -1.5, 0.0), False),
    ((-0.5, 0.2, 0.3, 0.1), True),          # all of it inside
    ((0.0, 1.9, 1.9, 0.0), True),           # cuts a corner off
    ((0.0, 2.1, 2.1, 0.0), False),          # just passes it, though their boxes overlap
    ((-9.0, 8.0, 8.0, 8.0), False),
])
def test_square_against_a_wall(wall, touched):
    assert World("wall", walls=[wall]).touches(SQUARE) is touched
    assert World("wall", walls=[wall[2:] + wall[:2]]).touches(SQUARE[::-1]) is touched


@pytest.mark.parametrize("post, touched", [
    ((1.2, 0.0, 0.25), True),
    ((1.2, 0.0, 0.15), False),
    ((1.1, 1.1, 0.15), True),               # the corner is 0.141 m away
    ((1.1, 1.1, 0.13), False),
    ((0.1, 0.2, 0.05), True),               # all of it inside
    ((0.0, 0.0, 9.0), True),                # the body inside the post
    ((5.0, 0.0, 0.5), False),
])
def test_square_against_a_post(post, touched):
    assert World("post", posts=[post]).touches(SQUARE) is touched
    assert World("post", posts=[post]).touches(SQUARE[::-1]) is touched


@pytest.mark.parametrize("x, touched", [(1.4, False), (1.0, True), (0.4, True)])
def test_post_between_the_prongs_of_a_fork(x, touched):
    assert World("post", posts=[(x, 0.0, 0.05)]).touches(FORK) is touched


@pytest.mark.parametrize("wall, touched", [
    ((1.2, -0.3, 1.2, 0.3), False),
    ((1.2, -0.3, 1.2, 0.6), True),
    ((1.2, 0.0, 9.0, 0.0), False),
    ((0.8, 0.0, 9.0, 0.0), True),
])
def test_wall_between_the_prongs_of_a_fork(wall, touched):
    assert World("wall", walls=[wall]).touches(FORK) is touched


def test_cans_and_emptiness_stop_nobody():
    assert World("can", cans=[Can(0.0, 0.0)]).touches(SQUARE) is False
    assert World("empty").touches(SQUARE) is False


def test_outline_may_be_an_array():
    assert World("post", posts=[(0.0, 0.0, 0.1)]).touches(np.array(SQUARE)) is True
    assert World("post", posts=[(3.0, 0.0, 0.1)]).touches(np.array(SQUARE)) is False


@pytest.mark.parametrize("seed", range(40))
def test_random_bodies_against_points_sampled_densely(seed):
    """A sampled point inside proves contact; when the nearest sample is well outside there is none."""
    rng = random.Random(seed)
    walls = [[rng.uniform(-4.0, 4.0) for _ in range(4)] for _ in range(3)]
    posts = [(rng.uniform(-4.0, 4.0), rng.uniform(-4.0, 4.0), rng.uniform(0.05, 0.5)) for _ in range(2)]
    world = World("crowd", walls, posts)
    share = np.linspace(0.0, 1.0, 2001)
    samples = [np.stack((x1 + (x2 - x1) * share, y1 + (y2 - y1) * share), axis=1) for x1, y1, x2, y2 in walls]
    samples += [np.stack((x + r * np.cos(7.0 * share), y + r * np.sin(7.0 * share)), axis=1) for x, y, r in posts]
    samples += [np.array([(x, y)]) for x, y, _ in posts]
    points = np.concatenate(samples)
    verdicts = set()
    for _ in range(20):
        x, y, heading = rng.uniform(-4.0, 4.0), rng.uniform(-4.0, 4.0), rng.uniform(-3.0, 3.0)
        cosine, sine = math.cos(heading), math.sin(heading)
        local_x = (points[:, 0] - x) * cosine + (points[:, 1] - y) * sine
        local_y = (points[:, 1] - y) * cosine - (points[:, 0] - x) * sine
        outside = np.maximum(np.abs(local_x) - 0.35, np.abs(local_y) - 0.2).min()  # a rectangle of 0.7 by 0.4 m
        corners = [(-0.35, -0.2), (0.35, -0.2), (0.35, 0.2), (-0.35, 0.2)]
        touched = world.touches([(x + cx * cosine - cy * sine, y + cx * sine + cy * cosine) for cx, cy in corners])
        if abs(outside) > 3e-3:
            assert touched is bool(outside < 0.0)
            verdicts.add(touched)
    assert False in verdicts


def test_clearance():
    world = World("both", walls=[(2.0, -1.0, 2.0, 1.0)], posts=[(0.0, 3.0, 0.5)])
    assert world.clearance(0.0, 0.0) == 2.0
    assert world.clearance(1.7, 0.0) == pytest.approx(0.3)
    assert world.clearance(2.3, 1.4) == pytest.approx(0.5)        # 0.3 and 0.4 beyond the wall's end
    assert world.clearance(0.0, 2.0) == pytest.approx(0.5)
    assert world.clearance(0.0, 2.9) == 0.0
    assert World("empty").clearance(0.0, 0.0) == math.inf


def test_clearance_near_and_far_is_the_same_measure():
    rng = random.Random(3)
    walls = [[rng.uniform(-20.0, 20.0) for _ in range(4)] for _ in range(50)]
    world = World("many", walls=walls, posts=[(0.0, 0.0, 1.0)])
    xs, ys = np.linspace(-20.0, 20.0, 60), np.linspace(-20.0, 20.0, 50)
    each = np.array([[world.clearance(x, y) for x in xs] for y in ys])
    assert world.clearances(xs, ys) == pytest.approx(each, abs=1e-12)


def test_occupancy_tells_walls_floor_and_the_unreachable_apart():
    box = [(0.0, 0.0, 4.0, 0.0), (4.0, 0.0, 4.0, 2.0), (4.0, 2.0, 0.0, 2.0), (0.0, 2.0, 0.0, 0.0)]
    cells, (x, y) = World("box", box, posts=[(3.0, 1.0, 0.3)], starts=[(1.0, 1.0, 0.0)]).occupancy(0.1, margin=0.55)
    assert (x, y) == pytest.approx((-0.55, -0.55))
    assert cells.dtype == np.int8 and cells.shape == (31, 51)      # rows of y, columns of x
    assert cells[5, 10] == OCCUPIED                                # (0.5, 0.0), a wall
    assert cells[15, 15] == FREE                                   # (1.0, 1.0)
    assert cells[15, 35] == OCCUPIED                               # (3.0, 1.0), inside the post
    assert cells[25, 5] == OCCUPIED and cells[5, 45] == OCCUPIED   # corners (0, 2) and (4, 0)
    assert cells[2, 2] == UNKNOWN and cells[28, 25] == UNKNOWN     # outside
    assert set(np.unique(cells)) == {FREE, OCCUPIED, UNKNOWN}


def test_occupancy_of_nothing_is_floor():
    cells, _ = World("empty").occupancy(0.1)
    assert cells.size and (cells == FREE).all()


@pytest.mark.parametrize("parts, message", [
    (dict(walls=[(0, 0, 1, 1), (2, 2, 2, 2)]), "wall 2 .* no length"),
    (dict(walls=[(0, 0, 1, math.nan)]), "wall 1 .* not finite"),
    (dict(posts=[(0, 0, 0.0)]), "post 1 has radius 0"),
    (dict(posts=[(0, 0, -0.1)]), "post 1 has radius -0.1"),
    (dict(cans=[Can(0, 0, radius=0.0)]), "can 1 has radius 0"),
    (dict(starts=[]), "no start"),
    (dict(starts=[(0, math.inf, 0)]), "start 1 .* not finite"),
    (dict(docks=[(0, 0, math.nan)]), "dock 1 .* not finite"),
    (dict(goals={"a": (0, 0, 0), "b": (0, math.inf, 0)}), "goal 2 .* not finite"),
])
def test_impossible_worlds_are_refused(parts, message):
    with pytest.raises(WorldError, match=message):
        World("impossible", **parts)


def test_walls_cannot_be_moved_behind_the_world_s_back():
    world = World("wall", walls=[(0, 0, 1, 1)])
    with pytest.raises(ValueError):
        world.walls[0, 0] = 5.0
