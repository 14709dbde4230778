"""Firings vote for cells that are free and for cells that are occupied."""

import math

import numpy as np
import pytest

from pioneer_control.maps import FREE, OCCUPIED, UNKNOWN
from pioneer_control.navigation.sonar_grid import SonarBeams, SonarGrid, Votes
from pioneer_control.navigation.tuned import MapNumbers


def beams(*each):
    return SonarBeams(*map(np.array, zip(*each)))


def filled(grid, *each, times=1):
    for _ in range(times):
        grid.add(grid.votes(beams(*each)))
    return grid.grid_map()


def test_an_echo_frees_its_way_and_occupies_its_arc():
    found = filled(SonarGrid(MapNumbers()), (0.0, 0.0, 0.0, 1.5), times=20)
    assert found.at(0.8, 0.0) == FREE
    assert found.at(1.51, 0.01) == OCCUPIED
    assert found.at(1.8, 0.0) == UNKNOWN


def test_an_echo_so_near_that_it_frees_nothing_occupies_its_arc():
    numbers = MapNumbers()
    votes = SonarGrid(numbers).votes(beams((0.0, 0.0, 0.0, numbers.short_of + 0.5 * numbers.resolution)))
    assert votes.free.sum() == 0.0
    assert votes.occupied.sum() == pytest.approx(numbers.occupied, abs=1e-4)


def test_nothing_is_freed_behind_a_wall():
    grid = SonarGrid(MapNumbers())
    for y in np.arange(-0.5, 0.5, 0.05):
        filled(grid, (0.0, y, 0.0, 1.03), times=10)
    behind = filled(grid, (0.0, 0.0, 0.0, 2.2), times=30)
    assert behind.at(1.03, 0.03) == OCCUPIED
    assert behind.at(1.6, 0.0) == UNKNOWN
    assert filled(SonarGrid(MapNumbers()), (0.0, 0.0, 0.0, 2.2), times=30).at(1.6, 0.0) == FREE


@pytest.mark.parametrize("aside", [0.0, 0.02, 0.04])
def test_no_sound_slips_between_two_cells_of_a_slanting_wall(aside):
    """The cells of a wall that slants by 45 degrees touch each other at their corners alone."""
    grid = SonarGrid(MapNumbers())
    numbers = np.arange(-12, 13)
    wall = np.zeros((25, 25), np.float32)
    wall[numbers + 12, numbers + 12] = 3.0
    grid.add(Votes(-12, 8, np.zeros_like(wall), wall))
    beyond = filled(grid, (0.0, 1.0 + aside, -math.pi / 4.0, 2.2), times=30)
    x, y = beyond.middle(*np.nonzero(beyond.cells == FREE))
    assert len(x) and (y - x > -1.0 - 0.01).all()


@pytest.mark.parametrize("row, column", [(1, 2), (2, 1)])
def test_sound_that_grazes_a_wall_ends_there(row, column):
    """All of a thin beam steps from cell (1, 1) to (2, 2), past the corner of the only cell that is a wall."""
    grid = SonarGrid(MapNumbers(half_cone=0.05))
    thin = beams((0.025, 0.025, math.pi / 4.0, 2.2))
    assert np.nonzero(grid.votes(thin).free)[0].max() + grid.votes(thin).row > 10
    grid.add(Votes(row, column, np.zeros((1, 1), np.float32), np.full((1, 1), 3.0, np.float32)))
    assert np.nonzero(grid.votes(thin).free)[0].max() + grid.votes(thin).row == 1


def test_votes_can_be_taken_out_again():
    grid = SonarGrid(MapNumbers())
    votes = grid.votes(beams((0.0, 0.0, 1.0, 1.5), (3.0, -7.0, 2.0, math.inf)))
    grid.add(votes)
    grid.add(votes, -1)
    assert (grid.grid_map().cells == UNKNOWN).all()


def test_a_window_can_be_without_some_votes():
    grid = SonarGrid(MapNumbers())
    first, second = beams((0.0, 0.0, 1.0, 1.5)), beams((0.3, 0.5, 0.0, 2.0), (0.3, -4.0, 3.0, 0.8))
    grid.add(grid.votes(first))
    alone, *_ = grid.window((-1.0, -1.0), (2.0, 2.0))
    votes = grid.votes(second)
    grid.add(votes)
    assert not np.allclose(grid.window((-1.0, -1.0), (2.0, 2.0))[0], alone)
    assert grid.window((-1.0, -1.0), (2.0, 2.0), [votes])[0] == pytest.approx(alone, abs=1e-5)


def test_the_grid_grows_without_moving_what_it_has():
    grid = SonarGrid(MapNumbers())
    before = filled(grid, (0.0, 0.0, 0.0, 1.5), times=20)
    after = filled(grid, (-30.0, 25.0, 0.0, 1.5), times=20)
    assert after.at(1.51, 0.01) == before.at(1.51, 0.01) == OCCUPIED
    assert after.at(-28.49, 25.01) == OCCUPIED
