"""Worlds that are drawn from seeds, and their measures of free space."""

import math
import random

import numpy as np
import pytest
from robot_on_bench import heard

from pioneer_control.errors import WorldError
from pioneer_control.robots import find_model
from pioneer_control.simulator.world import load_world
from pioneer_control.simulator.world.free_space import gap_open, room
from pioneer_control.simulator.world.furnishing import Furnishing, box, chair, post
from pioneer_control.simulator.world.generated import (
    IN_TURN, KINDS, START_ROOM, random_world, with_unmapped)
from pioneer_control.simulator.world.geometry import is_inside
from pioneer_control.simulator.world.grids import flood
from pioneer_control.simulator.world.offices import _Plan, office
from pioneer_control.simulator.world.people import Footways
from pioneer_control.simulator.world.poses import closed
from pioneer_control.simulator.world.world import FREE, START_CLEARANCE, World


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
    names = {"%s-%d" % (kind, seed) for seed, kind in enumerate(IN_TURN)}
    assert {random_world(seed).name for seed in range(5)} == names
    mixed = [random_world(seed, kinds=["poles", "offices"]).name for seed in range(3)]
    assert mixed == ["poles-0", "offices-1", "poles-2"]


@pytest.mark.parametrize("kind", sorted(KINDS))
def test_same_seed_same_world(kind):
    first, again, other = random_world(7, kind), random_world(7, kind), random_world(8, kind)
    assert first.walls.tobytes() == again.walls.tobytes() and first.posts.tobytes() == again.posts.tobytes()
    assert first.starts == again.starts
    assert first.walls.tobytes() != other.walls.tobytes()


def test_a_seed_means_the_same_world_for_ever():
    """Published results name their seeds, so nobody may change the generator by accident."""
    assert {kind: [round(value, 6) for value in random_world(1, kind).starts[0]] for kind in sorted(KINDS)} == PINNED


OFFICE_7 = (75, 29, 12, 1682.726586)
PINNED = {
    "clutter": [-10.375259, -0.718574, 2.976818],
    "corners": [0.0, 0.0, -2.959124],
    "corridors": [-0.571515, 3.900636, 2.485474],
    "offices": [10.07988, 0.12293, -0.961762],
    "dead_ends": [0.368506, 3.069369, 1.639583],
    "poles": [-2.272958, -0.177039, 2.99693],
}


def test_hard_things_are_among_them():
    posts = np.concatenate([random_world(seed, "poles").posts for seed in range(10)])
    assert posts[:, 2].min() == 0.025
    assert all(len(random_world(seed, "clutter").walls) >= 44 for seed in range(10))


def test_unknown_kind():
    with pytest.raises(WorldError, match="'jungle'; known: clutter, corners, corridors, dead_ends, offices, poles"):
        random_world(1, "jungle")


@pytest.mark.parametrize("kind", sorted(KINDS))
def test_a_generated_world_by_its_name(kind):
    world = load_world("%s-7" % kind)
    assert world.name == "%s-7" % kind and world.walls.tobytes() == random_world(7, kind).walls.tobytes()


@pytest.mark.parametrize("name, message", [
    ("jungle-7", "no world named 'jungle-7'.*KIND-SEED, such as offices-7, with one of the kinds clutter, .*poles"),
    ("offices", "no world named 'offices'.*KIND-SEED"),
    ("offices-", "world offices-: seed '' is not legal: give a whole number from 0 to 999999999, such as offices-7"),
    ("offices-seven", "seed 'seven' is not legal"),
    ("poles-1.5", "seed '1.5' is not legal"),
    ("poles--1", "seed '-1' is not legal"),
    ("poles-1000000000", "seed '1000000000' is not legal"),
])
def test_a_name_with_an_unknown_kind_or_a_bad_seed_says_what_is_legal(name, message):
    with pytest.raises(WorldError, match=message):
        load_world(name)


def test_a_seed_that_has_no_name_is_refused():
    with pytest.raises(WorldError, match="world poles--1: seed -1 is not legal"):
        random_world(-1, "poles")


@pytest.mark.parametrize("seed", range(0, 60, 4))
def test_a_narrow_robot_gets_into_every_room_of_an_office(seed):
    plan = _Plan(random.Random(seed))
    drawn = office(random.Random(seed))
    world = World("office", drawn.walls, drawn.posts, starts=[(*drawn.start, 0.0)])
    low_x, low_y, high_x, high_y = world.bounds
    assert (low_x, low_y) == (0.0, 0.0) and 10.0 <= high_x <= 22.0 and 8.0 <= high_y <= 16.0
    assert 1.6 <= plan.corridor.high_y - plan.corridor.low_y <= 2.4
    x, y = np.arange(0.025, high_x, 0.05), np.arange(0.025, high_y, 0.05)
    start = (abs(x - drawn.start[0]) < 0.1) & (abs(y - drawn.start[1]) < 0.1)[:, None]
    reached = flood(start, world.clearances(x, y, limit=0.3) >= 0.25)
    assert all((reached & (x > room.low_x) & (x < room.high_x)
                & ((y > room.low_y) & (y < room.high_y))[:, None]).sum() > 200 for room in plan.rooms)
    assert drawn.boxes and all(len(corners) == 4 for corners in drawn.boxes)


def test_offices_have_chairs_and_their_furniture_is_filled():
    worlds = [random_world(seed, "offices") for seed in range(5)]
    assert all(len(world.boxes) > 3 and world.posts[:, 2].min() == 0.02 for world in worlds)


def test_an_office_is_the_same_down_to_its_furniture():
    world = random_world(7, "offices")
    assert (len(world.walls), len(world.posts), len(world.boxes)) == OFFICE_7[:3]
    assert round(float(np.abs(world.walls).sum()), 6) == OFFICE_7[3]


def test_an_obstacle_that_cuts_off_floor_is_not_put():
    world = hall(1.2)    # two chambers, a passage 2 m long
    furnishing = Furnishing(world, kept=[(-4.0, 0.0, 0.5)])
    whole = len(furnishing.reached())
    assert not furnishing.put(box((-1.0, 0.0), (0.2, 1.0), 0.0))            # blocks the passage
    assert not furnishing.put(post((-1.0, 0.1), 0.15))                      # so does this, for a robot
    assert not furnishing.put(box((-4.2, 0.0), (0.4, 0.4), 0.0))            # a kept place
    assert not furnishing.put(box((4.0, 0.0), (0.4, 0.4), 0.0))             # in a wall
    assert whole == len(furnishing.reached()) and furnishing.obstacles == []
    assert furnishing.put(box((2.0, 0.5), (1.0, 0.8), 0.3))
    assert not furnishing.put(post((2.0, 0.5), 0.1))                        # in the box
    assert not furnishing.put(box((2.4, 0.7), (0.6, 0.6), 1.0))             # overlaps it
    assert furnishing.put(chair((2.0, -1.0), 0.4, 0.5))
    assert len(furnishing.obstacles) == 2 and len(furnishing.reached()) < whole - 100


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


@pytest.mark.parametrize("name", ["office", "offices-7", "poles-4"])
def test_obstacles_that_are_on_no_map(name):
    world = load_world(name)
    cluttered = with_unmapped(world, 4, 5)
    assert len(cluttered.unmapped) == 4 and world.unmapped == []
    assert cluttered.walls.tobytes() == world.walls.tobytes() and cluttered.posts.tobytes() == world.posts.tobytes()
    assert cluttered.occupancy()[0].tobytes() == world.occupancy()[0].tobytes()
    assert cluttered.unmapped == with_unmapped(world, 4, 5).unmapped != with_unmapped(world, 4, 6).unmapped
    for each in cluttered.unmapped:
        x, y = each.corners[0] if each.corners else each.posts[0][:2]
        assert cluttered.clearance(x, y) < 1e-6 < world.clearance(x, y)
        assert cluttered.touches([(x - 0.01, y - 0.01), (x + 0.01, y - 0.01), (x, y + 0.01)])
        assert min(math.dist((x, y), start[:2]) for start in world.starts) > START_CLEARANCE
    free = Furnishing(world).reached()
    after = {tuple(point) for point in Furnishing(cluttered).reached().tolist()}
    lost = [point for point in free.tolist() if tuple(point) not in after]
    assert lost and all(cluttered.clearance(*point) < 0.3 or any(
        each.corners and is_inside(*point, each.corners) for each in cluttered.unmapped) for point in lost)


def test_what_is_on_no_map_shuts_nobody_in_with_a_robot():
    world = random_world(1038, "corridors")
    for seed in range(6):
        before, after = (Footways(each)._free.sum() for each in (world, with_unmapped(world, 3, seed)))
        assert after > 0.8 * before


def test_a_full_floor_gets_fewer_obstacles():
    narrow = World("cell", closed([(-0.8, -0.8), (0.8, -0.8), (0.8, 0.8), (-0.8, 0.8)]))
    assert len(with_unmapped(narrow, 9, 1).unmapped) < 9


def test_sonar_hears_what_is_on_no_map():
    world = World("bare", walls=[(4.0, -1.0, 4.0, 1.0)])
    behind = world.changed(unmapped=[post((2.0, 0.0), 0.1)])
    assert heard(world, 0.0, 0.0, 0.0) == 4.0 and heard(behind, 0.0, 0.0, 0.0) == pytest.approx(1.9)
    assert behind.with_start((-1.0, 0.0, 0.0)).unmapped == behind.unmapped
