"""A map is made while a robot drives, and corrects its odometry."""

import functools
import math

import numpy as np
import pytest

from pioneer_control.floor_poses import Pose, compose
from pioneer_control.maps import FREE, OCCUPIED, UNKNOWN
from pioneer_control.navigation.mapping import Mapper
from pioneer_control.navigation.pose_graph import PoseGraph
from pioneer_control.navigation.tuned import MapperNumbers, WallNumbers
from pioneer_control.navigation.values import Firing, Sensing
from pioneer_control.robots import find_model

ROOM = 5.0, 4.0
SONAR = find_model("p3dx-sh").sonar


def heard(x, y, heading):
    """The range that a transducer hears in a room whose corner is at the origin: the nearest wall in its cone."""
    nearest = math.inf
    for off in np.radians(np.arange(-12.0, 12.1, 2.0)):
        cosine, sine = math.cos(heading + off), math.sin(heading + off)
        across = (ROOM[0] - x) / cosine if cosine > 1e-9 else -x / cosine if cosine < -1e-9 else math.inf
        along = (ROOM[1] - y) / sine if sine > 1e-9 else -y / sine if sine < -1e-9 else math.inf
        nearest = min(nearest, across, along)
    return nearest if nearest < 5.0 else math.inf


@functools.lru_cache(maxsize=None)
def rounds(veer=0.0, count=2, at_once=2, long=0.0):
    """Drive round the room; the odometry turns too much by `veer` (rad/m), and is too long by the share `long`;
    `at_once` transducers fire in each packet. Returns sensings and true poses.
    """
    true, odometry, sensings, truth, time = Pose(1.2, 1.2, 0.0), Pose(0.0, 0.0, 0.0), [], [], 0.0
    ways = [(ROOM[0] - 2.4, math.pi / 2), (ROOM[1] - 2.4, math.pi / 2)] * 2 * count
    steps = [step for way, turn in ways for step in
             [(0.05, 0.0)] * round(way / 0.05) + [(0.0, turn / 40)] * 40]
    for number, (forward, turn) in enumerate(steps):
        true = compose(true, Pose(forward, 0.0, turn))
        odometry = compose(odometry, Pose(forward * (1.0 + long), 0.0, turn + veer * forward))
        time += 0.1
        firings = []
        for each in (SONAR[(at_once * number + more) % 16] for more in range(at_once)):
            at = compose(true, Pose(each.x, each.y, each.heading))
            firings.append(Firing(each.number, heard(*at), time))
        sensings.append(Sensing(time, odometry, tuple(firings)))
        truth.append(true)
    return sensings, truth


def mapped(sensings, pose, corrects=True):
    mapper = Mapper(SONAR, pose=pose, corrects=corrects)
    return mapper, [mapper.update(sensing) for sensing in sensings]


def test_square_walls_tell_the_heading():
    sensings, truth = rounds(0.02, 1, 8)
    off = {}
    for share in (1.1, 0.7):
        mapper = Mapper(SONAR, pose=truth[0], wall_numbers=WallNumbers(share=share, slack=0.01, ties_alone=1.0))
        own = [mapper.update(sensing) for sensing in sensings]
        off[share] = worst(own[len(own) // 2:], truth[len(own) // 2:])
    assert off[0.7] < 0.2 * off[1.1], "it drives the room round only once"


def test_stretches_together_tell_of_walls_of_which_each_heard_too_little():
    """As an AmigoBot's eight transducers do, or a robot that turns often."""
    sensings, truth = rounds(0.02, 1, 2)
    off = {}
    for stretches in (1, WallNumbers().stretches):
        mapper = Mapper(SONAR, pose=truth[0], wall_numbers=WallNumbers(stretches=stretches))
        own = [mapper.update(sensing) for sensing in sensings]
        off[stretches] = worst(own[len(own) // 2:], truth[len(own) // 2:])
    assert off.pop(1) > 2.0 * off.popitem()[1]


@functools.lru_cache(maxsize=None)
def mapped_while_it_veers():
    """A map of two rounds with an odometry that veers; nobody changes it."""
    sensings, truth = rounds(0.02)
    return mapped(sensings, truth[0])


def worst(poses, truth):
    return max(math.hypot(a.x - b.x, a.y - b.y) for a, b in zip(poses, truth))


def test_a_room_has_walls_and_a_floor():
    sensings, truth = rounds(0.0, 1)
    mapper, _ = mapped(sensings, truth[0])
    mapper.finish()
    found = mapper.grid_map()
    assert found.at(2.5, 2.0) == FREE
    assert found.at(-1.0, 2.0) == UNKNOWN
    for x, y in ((0.0, 2.0), (5.0, 2.0), (2.5, 0.0), (2.5, 4.0)):
        around = found.at(*np.meshgrid(x + np.arange(-0.1, 0.11, 0.05), y + np.arange(-0.1, 0.11, 0.05)))
        assert (around == OCCUPIED).any()


def test_it_corrects_an_odometry_that_veers():
    sensings, truth = rounds(0.02)
    _, plain = mapped(sensings, truth[0], corrects=False)
    _, own = mapped_while_it_veers()
    assert worst(plain, truth) > 0.5
    assert worst(own, truth) < 0.22, "before it comes round, nothing tells it of the veer"
    assert worst(own[-20:], truth[-20:]) < 0.15


def test_an_odometry_that_is_right_is_not_turned_by_what_is_heard():
    """Stretches that follow each other hear the same walls: their matches err alike, and must not count as many."""
    sensings, truth = rounds(0.0)
    _, own = mapped(sensings, truth[0])
    off = [abs(math.remainder(a.heading - b.heading, 2.0 * math.pi)) for a, b in zip(own, truth)]
    assert max(off) < math.radians(5.0)
    assert worst(own, truth) < 0.16


def test_it_learns_how_the_wheels_err():
    """Where all turns go to one side, nobody can tell a veer from turns that are too small: their sum counts."""
    mapper, _ = mapped_while_it_veers()
    way = 2.0 * (ROOM[0] - 2.4 + ROOM[1] - 2.4)
    assert mapper.bias.veer * way + mapper.bias.turning * 2.0 * math.pi == pytest.approx(-0.02 * way, rel=0.3)


def test_where_stretches_were_found_first_tells_that_the_wheels_measure_too_much():
    """What is found later fits a map of any size."""
    sensings, truth = rounds(0.0, 2, 8, 0.03)
    distance = {}
    for found_first in (1.0, 1000.0):
        mapper = Mapper(SONAR, pose=truth[0], numbers=MapperNumbers(found_first=found_first))
        for sensing in sensings:
            mapper.update(sensing)
        distance[found_first] = mapper.bias.distance
    assert distance[1.0] == pytest.approx(-0.03, abs=0.01)
    assert distance[1000.0] == pytest.approx(0.0, abs=0.005)


def test_the_same_data_give_the_same_map_also_where_the_map_is_asked_for_on_the_way():
    sensings, truth = rounds(0.02, 1)
    mapper, _ = mapped(sensings, truth[0])
    asked = Mapper(SONAR, pose=truth[0])
    for number, sensing in enumerate(sensings):
        asked.update(sensing)
        if number % 10 == 0:
            asked.grid_map()
    assert asked.pose == mapper.pose
    assert asked.grid_map() == mapper.grid_map()


def test_it_begins_at_zero_unless_told_otherwise():
    sensings, _ = rounds()
    assert Mapper(SONAR).update(sensings[0]) == Pose(0.0, 0.0, 0.0)
    assert Mapper(SONAR, pose=Pose(3.0, 2.0, 1.0)).update(sensings[0]) == Pose(3.0, 2.0, 1.0)


def test_a_map_of_nothing_is_unknown():
    assert (Mapper(SONAR).grid_map().cells == UNKNOWN).all()


def test_standing_teaches_nothing_new():
    sensings, truth = rounds()
    mapper, _ = mapped(sensings[:40], truth[0])
    before = mapper.grid_map()
    still = sensings[39]
    for number in range(200):
        time = still.time + 0.1 * (number + 1)
        mapper.update(still._replace(time=time, firings=(Firing(0, 0.4, time),)))
    once = mapper.grid_map()
    changed = (once.at(*cells_of(before)) != before.cells.ravel()).sum()
    assert changed < 30


def cells_of(grid_map):
    rows, columns = np.indices(grid_map.cells.shape)
    return grid_map.middle(rows.ravel(), columns.ravel())


def test_a_packet_has_one_costly_step_at_most(monkeypatch):
    """Finding a stretch, solving the graph and drawing a stretch anew all at once would hold up who drives."""
    sensings, truth = rounds(0.02, 1)
    mapper, steps = Mapper(SONAR, pose=truth[0]), []
    for owner, name in ((mapper, "_match"), (mapper, "_tie"), (mapper, "_redraw"), (PoseGraph, "_step")):
        before = getattr(owner, name)
        monkeypatch.setattr(owner, name, lambda *args, name=name, before=before: steps.append(name) or before(*args))
    done = set()
    for sensing in sensings:
        steps.clear()
        mapper.update(sensing)
        assert len(steps) <= 1 or set(steps) == {"_redraw"} and len(steps) <= 3, "drawing takes little"
        done.update(steps)
    assert done == {"_match", "_tie", "_redraw", "_step"}


def test_in_a_packet_with_other_work_the_map_is_not_corrected(monkeypatch):
    sensings, truth = rounds(0.02, 1)
    mapper, steps = Mapper(SONAR, pose=truth[0]), []
    for name in ("_match", "_tie", "_redraw"):
        before = getattr(mapper, name)
        monkeypatch.setattr(mapper, name, lambda *args, name=name, before=before: steps.append(name) or before(*args))
    for sensing in sensings[:200]:
        mapper.update(sensing, rests=True)
    assert steps == [] and len(mapper.path()) == 200
    for sensing in sensings[200:240]:
        mapper.update(sensing)
    assert {"_match", "_tie", "_redraw"} == set(steps), "then it is made up for"


def test_a_map_is_made_also_where_nothing_is_heard():
    mapper = Mapper(SONAR)
    for number in range(100):
        mapper.update(Sensing(0.1 * number, Pose(0.05 * number, 0.0, 0.0), ()))
    mapper.finish()
    assert mapper.pose.x == pytest.approx(0.05 * 99)


def test_its_path_ends_where_it_is_and_follows_the_corrections():
    sensings, truth = rounds(veer=0.03, count=1)
    mapper = Mapper(SONAR, pose=truth[0])
    assert len(mapper.path()) == 1
    own = [mapper.update(sensing) for sensing in sensings]
    path = mapper.path()
    assert tuple(path[-1]) == pytest.approx(tuple(mapper.pose), abs=1e-6)
    assert path[0] == pytest.approx(truth[0])

    def off(poses):
        """How far (m) they are from the truth."""
        assert len(poses) == len(truth), "a pose for each packet"
        return max(math.hypot(x - each.x, y - each.y) for (x, y, _), each in zip(poses, truth))
    assert off(path) <= off(own)
