"""The table of expected ranges, against walls made by hand and against the simulator's exact sonar."""

import itertools
import math

import numpy as np
import pytest
from small_worlds import HALF_CONE, RAY, ROOM, map_of, square_map

from pioneer_control.maps import FREE, OCCUPIED, GridMap
from pioneer_control.navigation.expected_ranges import SONAR_BEAM, ExpectedRanges, standing_room
from pioneer_control.simulator.world.poses import unit


def ranges(table, x, y, heading):
    """Return ranges (m) at some places, infinite where nothing is in reach."""
    numbers = echoes(table, x, y, heading) // table.slants
    return np.where(numbers == table.none, math.inf, numbers * table.beam.unit)


def echoes(table, x, y, heading, coarse=False):
    """Return the echoes at some places."""
    return table.echoes(*(np.asarray(each, dtype=float) for each in (x, y, heading)), coarse)


@pytest.mark.parametrize("beam", [SONAR_BEAM, RAY])
@pytest.mark.parametrize("heading", [0.0, math.pi / 2, math.pi, -math.pi / 2, 2 * math.pi, -3 * math.pi])
def test_walls_on_all_four_sides_of_a_square_room(beam, heading):
    table = ExpectedRanges(square_map(80), beam)     # middles of its walls' cells at 0.025 and 3.975 m
    assert ranges(table, [2.0], [2.0], [heading]) == pytest.approx(1.975, abs=0.06)


def test_a_range_changes_with_each_step_between_the_nodes():
    table = ExpectedRanges(square_map(80), SONAR_BEAM)
    x = np.arange(1.0, 2.0, 0.02)
    assert np.diff(ranges(table, x, np.full(50, 2.0), np.zeros(50))) == pytest.approx(-0.02, abs=0.021)


def test_nothing_in_reach_is_none():
    table = ExpectedRanges(square_map(240), SONAR_BEAM)
    assert ranges(table, [6.0], [6.0], [0.0]) == math.inf


def test_a_ray_looks_between_posts_where_sonar_hears_them():
    cells = np.full((80, 80), FREE, dtype=np.int8)
    cells[30, 60] = cells[50, 60] = OCCUPIED
    empty = GridMap(cells, 0.05, (0.0, 0.0))
    assert ranges(ExpectedRanges(empty, RAY), [0.5], [2.0], [0.0]) == math.inf
    assert ranges(ExpectedRanges(empty, SONAR_BEAM), [0.5], [2.0], [0.0]) == pytest.approx(2.53, abs=0.08)


def test_no_ray_slips_between_cells_that_touch_at_their_corners():
    cells = np.full((160, 160), FREE, dtype=np.int8)
    diagonal = np.arange(160)
    cells[diagonal, 159 - diagonal] = OCCUPIED
    table = ExpectedRanges(GridMap(cells, 0.05, (0.0, 0.0)), RAY)
    headings = np.radians(np.arange(10, 81, 2))
    expected = math.sqrt(2.0) / np.cos(headings - math.pi / 4)       # the wall is 1.414 m away along the diagonal
    assert ranges(table, np.full(36, 3.0), np.full(36, 3.0), headings) == pytest.approx(expected, abs=0.12)


def test_the_table_is_that_of_the_simulators_sonar():
    table, ear = ExpectedRanges(map_of(ROOM), SONAR_BEAM, bias=0.02), ROOM.ear(HALF_CONE, 5.0, math.inf)
    luck = np.random.default_rng(1)
    places = standing_room(map_of(ROOM), 0.2)
    poses = [(*place, luck.uniform(-3.1, 3.1)) for place in places[luck.integers(0, len(places), 400)]]
    true = [ear.echo(x, y, to, unit(to - HALF_CONE), unit(to + HALF_CONE)) for x, y, to in poses]
    off = np.abs(ranges(table, *np.transpose(poses)) - true)
    assert np.median(off) < 0.025 and np.quantile(off, 0.9) < 0.12


def wall_map(degrees, thick):
    """Return a map of 8 x 8 m with a straight wall through its middle, which faces to some degrees and back."""
    x, y = np.meshgrid(*2 * [(np.arange(160) + 0.5) * 0.05 - 4.0])
    away = x * math.cos(math.radians(degrees)) + y * math.sin(math.radians(degrees))
    return GridMap(np.where(np.abs(away) <= thick / 2.0, OCCUPIED, FREE).astype(np.int8), 0.05, (-4.0, -4.0))


@pytest.mark.parametrize("thick", [0.07, 0.5])
@pytest.mark.parametrize("faces", range(0, 180, 15))
def test_an_echo_tells_how_the_wall_slants(thick, faces):
    """The cone is 12.5 degrees wide to each side, and the ray that meets the wall most squarely is the shortest."""
    table = ExpectedRanges(wall_map(faces, thick), SONAR_BEAM)
    wrong = []
    for (angle, slant), side, coarse in itertools.product(
            [(0, 0), (40, 1), (-40, 1), (55, 2), (-70, 3)], [0.0, math.pi], [False, True]):
        along = math.radians(faces) + side + math.radians(angle) + math.pi
        to_wall = thick / 2.0 + 1.0 * math.cos(math.radians(angle))
        x = to_wall * math.cos(math.radians(faces) + side)
        y = to_wall * math.sin(math.radians(faces) + side)
        told = int(echoes(table, [x], [y], [along], coarse)[0] % table.slants)
        wrong += [(angle, side, coarse, told)] * (told != slant)
    assert not wrong


@pytest.mark.parametrize("limits, slants", [((), {0}), ((0.1,), {0, 1})])
def test_there_are_as_many_slants_as_the_beam_divides_walls_into(limits, slants):
    table = ExpectedRanges(wall_map(20.0, 0.07), RAY._replace(slant_limits=limits))
    x, y = np.meshgrid(np.linspace(-3.0, 3.0, 20), np.linspace(-3.0, 3.0, 20))
    assert set((echoes(table, x, y, np.full((20, 20), 0.5)) % table.slants).ravel().tolist()) == slants


def test_where_nothing_is_in_reach_nothing_slants():
    table = ExpectedRanges(square_map(240), SONAR_BEAM)
    assert [int(echoes(table, [6.0], [6.0], [0.3], coarse)[0]) for coarse in (False, True)] == 2 * [
        table.none * table.slants]


def test_a_map_with_too_many_columns_for_the_small_numbers_has_the_same_echoes():
    """A ray that has met nothing stays so, and one that meets a wall far back on the map has its range."""
    cells = np.full((4, 9000), FREE, dtype=np.int8)
    cells[:, 20] = cells[:, 8980] = OCCUPIED
    beam = RAY._replace(directions=4, slant_limits=(0.3, 0.6, 0.9))
    table = ExpectedRanges(GridMap(cells, 0.05, (0.0, 0.0)), beam)
    assert ranges(table, [2.0, 448.0, 250.0, 250.0, 5.0, 445.0], 6 * [0.1], [math.pi, 0.0, 0.0, math.pi, 0.0, math.pi]
                  ) == pytest.approx([0.975, 1.025, *4 * [math.inf]], abs=0.06)


def test_a_bias_is_added():
    plain, longer = (ranges(ExpectedRanges(square_map(80), SONAR_BEAM, bias), [2.0], [2.0], [0.3])
                     for bias in (0.0, 0.1))
    assert longer - plain == pytest.approx(0.1, abs=0.021)


@pytest.mark.parametrize("resolution, cells", [(0.02, 200), (0.1, 40), (0.05, 80)])
def test_maps_of_any_resolution(resolution, cells):
    table = ExpectedRanges(square_map(cells, resolution), SONAR_BEAM)
    assert ranges(table, [1.0, 3.0], [2.0, 2.0], [0.0, math.pi]) == pytest.approx(2.95, abs=0.1)


def test_measured_ranges_become_numbers_of_the_same_steps():
    table = ExpectedRanges(square_map(80), SONAR_BEAM)
    assert table.number_of([0.0, 1.0, 4.99, 5.0, 5.2, math.inf, -1.0]).tolist() == [0, 50, 250, 250, 251, 251, 0]


def test_a_robot_stands_on_free_cells_away_from_walls():
    room = standing_room(square_map(80), 0.5)
    assert room.min() == pytest.approx(0.525) and room.max() == pytest.approx(3.475)
    assert len(standing_room(GridMap(np.full((9, 9), OCCUPIED, dtype=np.int8), 0.05, (0.0, 0.0)), 0.1)) == 0


def test_a_map_of_a_large_building_is_ready_soon():
    """50 x 50 m must be ready within 2 s. Here a quarter of it, with much to spare for a busy computer."""
    import time
    begin = time.process_time()
    ExpectedRanges(square_map(500), SONAR_BEAM)
    assert time.process_time() - begin < 2.0
