"""Grids of cells: borders as few long segments, and the free room."""

import math

import numpy as np
import pytest

from pioneer_control.simulator.world.grids import borders, roomiest


def grid(*rows):
    """Return cells from a picture, the highest y first; # is true."""
    return np.array([[cell == "#" for cell in row] for row in reversed(rows)])


def sides(segments):
    """Return segments in a form that can be compared: the direction and the order of the segments make no difference.
    """
    return sorted(tuple(sorted((segment[:2], segment[2:]))) for segment in segments)


def box(x1, y1, x2, y2):
    return sides([(x1, y1, x2, y1), (x2, y1, x2, y2), (x2, y2, x1, y2), (x1, y2, x1, y1)])


@pytest.mark.parametrize("rows, expected", [
    (["...", "..."], []),
    (["#"], box(0, 0, 1, 1)),
    (["....", ".##.", "...."], box(1, 1, 3, 2)),
    (["####", "####", "####"], box(0, 0, 4, 3)),
    (["#..", "...", "..#"], sorted(box(0, 2, 1, 3) + box(2, 0, 3, 1))),
    # a room
    (["######", "######", "##..##", "##..##", "######", "######"], sorted(box(0, 0, 6, 6) + box(2, 2, 4, 4))),
    # a corner
    (["###...", "###...", "###...", "######", "######", "######"],
     sides([(0, 0, 6, 0), (6, 0, 6, 3), (6, 3, 3, 3), (3, 3, 3, 6), (3, 6, 0, 6), (0, 6, 0, 0)])),
])
def test_borders_of_pictures(rows, expected):
    assert sides(borders(grid(*rows))) == expected


def test_cells_that_touch_at_a_corner_are_joined():
    """A diagonal wall of single cells has one border, not one for each cell."""
    assert len(borders(np.eye(30, dtype=bool))) <= 4
    assert len(borders(np.eye(30, dtype=bool)[::-1])) <= 4


@pytest.mark.parametrize("angle_deg", [0, 1, 3, 7, 20, 30, 45, 62, 80, 90])
def test_a_slanted_room_has_few_segments_within_a_cell_of_it(angle_deg):
    angle, size = math.radians(angle_deg), 300
    y, x = np.mgrid[0:size, 0:size] + 0.5 - size / 2.0
    ahead, aside = x * math.cos(angle) + y * math.sin(angle), y * math.cos(angle) - x * math.sin(angle)
    outside = np.maximum(np.abs(ahead) / 90.0, np.abs(aside) / 60.0) > 1.0
    inner = [np.array(segment) - size / 2.0 for segment in borders(outside) if not {0, size} & set(segment)]
    assert 4 <= len(inner) <= 12
    for segment in inner:
        for end_x, end_y in (segment[:2], segment[2:]):
            cosine, sine = math.cos(angle), math.sin(angle)
            ahead, aside = end_x * cosine + end_y * sine, end_y * cosine - end_x * sine
            assert abs(max(abs(ahead) - 90.0, abs(aside) - 60.0)) < 1.5
    assert sum(math.hypot(x2 - x1, y2 - y1) for x1, y1, x2, y2 in inner) == pytest.approx(600.0, rel=0.01)


def test_rough_walls_are_straightened_and_stay_closed():
    """Here and there the wall is a cell thicker, as in a measured map."""
    rng = np.random.RandomState(3)
    cells = np.zeros((60, 400), dtype=bool)
    cells[:10] = True
    cells[10] = rng.rand(400) < 0.5
    segments = borders(cells)
    assert len(segments) <= 8
    assert all(9 <= y <= 12 for x1, y1, x2, y2 in segments for x, y in ((x1, y1), (x2, y2)) if 2 < x < 398)


@pytest.mark.parametrize("seed", range(20))
def test_every_border_is_closed_and_near_every_edge(seed):
    """This holds for any cells: the ends meet, and each edge between a wall and no wall has a segment within a cell."""
    cells = np.random.RandomState(seed).rand(12, 15) < 0.1 + 0.04 * seed
    segments = borders(cells)
    ends = [end for x1, y1, x2, y2 in segments for end in ((x1, y1), (x2, y2))]
    assert all(ends.count(end) >= 2 for end in ends)
    padded = np.pad(cells, 1)
    middles = [(column + 0.5, row) for row, column in zip(*np.nonzero(padded[1:, 1:-1] != padded[:-1, 1:-1]))]
    middles += [(column, row + 0.5) for row, column in zip(*np.nonzero(padded[1:-1, 1:] != padded[1:-1, :-1]))]
    for x, y in middles:
        assert min(distance(x, y, segment) for segment in segments) <= 1.42


def distance(x, y, segment):
    x1, y1, x2, y2 = segment
    squared = (x2 - x1) ** 2 + (y2 - y1) ** 2
    share = min(max(((x - x1) * (x2 - x1) + (y - y1) * (y2 - y1)) / squared, 0.0), 1.0)
    return math.hypot(x1 + share * (x2 - x1) - x, y1 + share * (y2 - y1) - y)


FREE = grid(
    "######....",
    "######....",
    "######....",
    "######..##",
    "######..##",
    "######....",
)


def test_the_wanted_place_if_there_is_room():
    assert roomiest(FREE, (2.0, 2.0), 2.0) == (2.0, 2.0)


@pytest.mark.parametrize("wanted, room", [
    ((2.0, 2.0), 2.5),
    ((6.0, 2.0), 0.5),
    ((-3.0, 2.0), 0.5),
    ((2.0, 99.0), 0.5),
])
def test_else_the_middle_of_the_largest_square(wanted, room):
    assert roomiest(FREE, wanted, room) == (3.0, 3.0)


def test_of_squares_alike_the_one_nearest_to_the_middle():
    assert roomiest(grid("##.##.##", "##.##.##"), (2.0, 1.0), 1.0) == (4.0, 1.0)


def test_nowhere():
    assert roomiest(grid("...", "..."), (1.0, 1.0), 0.4) is None
