"""The grid of a map: which cell has which point."""

import numpy as np
import pytest

from pioneer_control.errors import UsageError
from pioneer_control.maps import FREE, OCCUPIED, UNKNOWN, GridMap

MAP = GridMap(np.array([[FREE, OCCUPIED, UNKNOWN], [FREE, FREE, FREE]], dtype=np.int8), 0.5, (-1.0, 2.0))


def test_rows_run_along_x_and_row_0_is_the_lowest():
    assert MAP.bounds == (-1.0, 2.0, 0.5, 3.0)
    assert MAP.cell(-0.4, 2.1) == (0, 1)
    assert MAP.middle(0, 1) == (-0.25, 2.25)
    assert MAP.at(-0.4, 2.1) == OCCUPIED and MAP.at(0.1, 2.6) == FREE


def test_points_come_as_arrays_too_and_outside_nothing_is_known():
    assert MAP.at(np.array([-0.9, -0.4, 9.0, -1.1]), np.array([2.1, 2.1, 2.1, 2.1])).tolist() == [
        FREE, OCCUPIED, UNKNOWN, UNKNOWN]


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("far", [1e12, 1e300, -1e308])
def test_no_finite_point_is_too_far_to_be_outside(far):
    assert MAP.at(far, 2.1) == MAP.at(-0.4, far) == UNKNOWN
    row, column = MAP.cell(np.array([far, -0.4]), np.array([far, 2.1]))
    assert (row[0] > 2 and column[0] > 2) if far > 0.0 else (row[0] < 0 and column[0] < 0)
    assert (row[1], column[1]) == (0, 1)


def test_two_maps_are_equal_when_their_cells_and_places_are():
    assert MAP == GridMap(MAP.cells.copy(), 0.5, (-1.0, 2.0))
    assert MAP != GridMap(MAP.cells, 0.5, (-1.0, 2.1))
    assert MAP != GridMap(1 - MAP.cells, 0.5, (-1.0, 2.0))


@pytest.mark.parametrize("cells, resolution, named", [
    (np.zeros(3), 0.1, "shape"), (np.zeros((0, 3)), 0.1, "shape"), (np.zeros((2, 2)), 0.0, "resolution 0"),
    (np.zeros((2, 2)), float("nan"), "resolution nan"),
])
def test_what_is_no_map_is_named(cells, resolution, named):
    with pytest.raises(UsageError, match=named):
        GridMap(cells, resolution, (0.0, 0.0))
