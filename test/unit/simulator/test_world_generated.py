"""Worlds that are drawn from seeds, and their measures of free space."""

import math
import pathlib
import sys

import numpy as np
import pytest

from pioneer_control.errors import WorldError
from pioneer_control.robots import find_model
from pioneer_control.simulator.world.grids import flood
from pioneer_control.simulator.world.world import FREE, START_CLEARANCE, World

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[3] / "bench"))

from free_space import gap_open, room
from random_worlds import KINDS, START_ROOM, random_world


def test_two_hundred_worlds_are_closed_and_have_a_fair_start():
    outlines = [find_model(name).outline(gripper=name == "p3dx-sh") for name in ("p3dx-sh", "p3at-sh", "amigo-sh")]
    assert max(math.hypot(*corner) for outline in outlines for corner in outline) < START_CLEARANCE - 0.1
    for seed in range(200):
        world = random_world(seed)
        x, y, _ = world.starts[0]
        assert world.clearance(x, y) >= START_CLEARANCE, world.name
        assert room(world, x, y) >= START_ROOM, world.name
        cells, _ = world.occupancy(0.1)
        border = np.concatenate((cells[0], cells[-1], cells[:, 0], cells[:, -1]))
        assert (border != FREE).all(), world.name


def test_kinds_come_in_turn():
    names = {"%s-%d" % (kind, seed) for seed, kind in enumerate(sorted(KINDS))}
    assert {random_world(seed).name for seed in range(5)} == names


@pytest.mark.parametrize("kind", sorted(KINDS))
def test_same_seed_same_world(kind):
    first, again, other = random_world(7, kind), random_world(7, kind), random_world(8, kind)
    assert first.walls.tobytes() == again.walls.tobytes() and first.posts.tobytes() == again.posts.tobytes()
    assert first.starts == again.starts
    assert first.walls.tobytes() != other.walls.tobytes()


def test_a_seed_means_the_same_world_for_ever():
    """Published results name their seeds, so nobody may change the generator by accident."""
    assert {kind: [round(value, 6) for value in random_world(1, kind).starts[0]] for kind in sorted(KINDS)} == PINNED


PINNED = {
    "clutter": [-10.375259, -0.718574, 2.976818],
    "corners": [0.0, 0.0, -2.959124],
    "corridors": [-0.571515, 3.900636, 2.485474],
    "dead_ends": [0.368506, 3.069369, 1.639583],
    "poles": [-2.272958, -0.177039, 2.99693],
}


def test_hard_things_are_among_them():
    posts = np.concatenate([random_world(seed, "poles").posts for seed in range(10)])
    assert posts[:, 2].min() == 0.025
    assert all(len(random_world(seed, "clutter").walls) >= 44 for seed in range(10))


def test_unknown_kind():
    with pytest.raises(WorldError, match="'jungle'; known: clutter, corners, corridors, dead_ends, poles"):
        random_world(1, "jungle")


def hall(width):
    """Return two chambers of 4 by 4 m, joined by a passage of 2 m length and the given width."""
    low, high = -width / 2.0, width / 2.0
    corners = [
        (-6, -2), (-2, -2), (-2, low), (0, low), (0, -2), (4, -2),
        (4, 2), (0, 2), (0, high), (-2, high), (-2, 2), (-6, 2),
    ]
    walls = [first + second for first, second in zip(corners, corners[1:] + corners[:1])]
    return World("hall", walls, starts=[(-4.0, 0.0, 0.0)])


def test_room_ends_where_the_disc_does_not_fit():
    assert room(hall(1.2), -4.0, 0.0) == pytest.approx(9.0, abs=0.11)    # both chambers, less 0.5 m on either side
    assert room(hall(0.9), -4.0, 0.0) == pytest.approx(3.25, abs=0.11)   # only this one, and its door
    assert room(hall(0.9), -4.0, 0.0, clearance=0.4) == pytest.approx(9.2, abs=0.11)
    assert room(hall(0.9), -1.0, 0.0) == 0.0                             # no place for it in the passage


@pytest.mark.parametrize("width, is_open", [(1.2, True), (0.9, False)])
def test_gap_is_open_from_a_chamber_s_door(width, is_open):
    walls = [(-1.0, -0.7, -1.0, 0.7), (-1.0, 0.7, 0.6, 0.7), (-1.0, -0.7, 0.6, -0.7), (0.6, width - 0.7, 0.6, 0.7)]
    world = World("pocket", walls + [(5.0, -5.0, 5.0, 5.0)])
    assert gap_open(world, 0.0, 0.0) is is_open


def test_gap_is_looked_for_from_beside_a_wall_but_not_through_it():
    walls = [(-4.0, -4.0, 4.0, -4.0), (-4.0, 4.0, 4.0, 4.0), (-4.0, -4.0, -4.0, 4.0), (4.0, -4.0, 4.0, 4.0)]
    cell = [(-4.0, -3.2, -2.6, -3.2), (-2.6, -4.0, -2.6, -3.2)]        # 1.4 by 0.8 m in a corner of a large room
    world = World("room", walls + cell)
    assert gap_open(world, 3.7, 0.0)
    assert not gap_open(world, -3.3, -3.36)     # as close to the wall as the narrowest robot gets
    assert gap_open(world, -3.3, -2.9)


def test_flood_goes_round_but_not_across():
    free = np.array([[1, 1, 0, 1], [0, 1, 0, 1], [1, 0, 0, 1]], dtype=bool)
    seeds = np.zeros_like(free)
    seeds[0, 0] = True
    assert flood(seeds, free).astype(int).tolist() == [[1, 1, 0, 0], [0, 1, 0, 0], [0, 0, 0, 0]]
    seeds[0, 2] = True  # a seed that is not free starts nothing
    assert flood(seeds, free).sum() == 3
