"""Finds the borders of walls, and the places with enough room, in a grid of cells.

Cells are boolean arrays ``[row, column]``; row 0 has the lowest y. All lengths are in cells. Cell [0, 0] extends from
0 to 1 in x and in y.
"""

import functools
from typing import Dict, List, Optional, Tuple

import numpy as np

from .geometry import Array

STRAIGHTENED_SQUARED = 2
"""Square of the largest distance (cells) between a straightened border and the cell corners that it replaces.

The steps that a slanted wall makes in a grid are not wider than this.
"""

Corner = Tuple[int, int]
Run = Tuple[Corner, Corner]


def borders(walls: Array) -> List[Tuple[int, int, int, int]]:
    """Return the borders between wall cells and other cells as a few long segments ``x1 y1 x2 y2`` (in cells).

    Wall cells that touch only at a corner are joined, because nothing can pass between them.

    Args:
        walls: boolean array (rows, columns), True for the wall cells.
    """
    segments: Dict[Tuple[Corner, Corner], None] = {}
    for ring in _rings(walls):
        corners = _straightened(ring)
        for first, second in zip(corners, corners[1:] + corners[:1]):
            if (second, first) not in segments:  # if both are there, the wall has no thickness
                segments[first, second] = None
    return [first + second for first, second in segments]


def flood(seeds: Array, free: Array) -> Array:
    """Return the `free` cells that can be reached from `seeds` over free cells by steps along x or y.

    The arguments and the result are boolean arrays (rows, columns).
    """
    width = free.shape[1] + 2
    unvisited = np.pad(free, 1).ravel()  # a border of occupied cells stops the flood at the edges
    front = np.flatnonzero(np.pad(seeds & free, 1))
    while len(front):
        unvisited[front] = False
        beside = (front[:, None] + np.array([1, -1, width, -width])).ravel()
        front = np.unique(beside[unvisited[beside]])
    return free & ~unvisited.reshape(-1, width)[1:-1, 1:-1]


def roomiest(free: Array, wanted: Tuple[float, float], room: float) -> Optional[Tuple[float, float]]:
    """Return a place (x, y) with room for a robot, in cells.

    Args:
        free: boolean array (rows, columns), True for the free cells.
        wanted: preferred place (x, y). It may lie outside the grid.
        room: distance from `wanted`, in cells, within which all cells must be free.

    Returns:
        `wanted` if there is enough room. Else the middle of the largest free square; if several free squares are
        equally large, the one nearest to the middle of the grid. None when no cell is free.
    """
    low_x, low_y = int(wanted[0] - room), int(wanted[1] - room)
    high_x, high_y = int(wanted[0] + room) + 1, int(wanted[1] + room) + 1
    inside = min(wanted) >= room and high_x <= free.shape[1] and high_y <= free.shape[0]
    if inside and free[low_y:high_y, low_x:high_x].all():
        return wanted
    sums = np.pad(np.cumsum(np.cumsum(free, axis=0), axis=1), ((1, 0), (1, 0)))
    least, side = 0, min(free.shape) + 1  # a free square of side `least` exists, one of side `side` does not
    while side - least > 1:
        middle = (least + side) // 2
        least, side = (middle, side) if _squares(sums, middle).any() else (least, middle)
    if not least:
        return None
    rows, columns = np.nonzero(_squares(sums, least))
    y, x = rows + least / 2.0, columns + least / 2.0
    from_middle = np.square(x - free.shape[1] / 2.0) + np.square(y - free.shape[0] / 2.0)
    nearest = np.argmin(from_middle)
    return float(x[nearest]), float(y[nearest])


def _squares(sums: Array, side: int) -> Array:
    """Return a boolean array [row, column]: whether the square with its lowest corner there has only free cells.

    Args:
        sums: two-dimensional cumulative sums of the free cells, with a row and a column of zeros before them.
        side: side of the square, in cells.
    """
    whole: Array = sums[side:, side:] - sums[:-side, side:] - sums[side:, :-side] + sums[:-side, :-side] == side * side
    return whole


def _rings(walls: Array) -> List[List[Corner]]:
    """Return every closed border as a list of its corners, in the direction that has the wall on the left."""
    starting: Dict[Corner, List[Run]] = {}
    for straight in _runs(walls):
        starting.setdefault(straight[0], []).append(straight)
    rings: List[List[Corner]] = []
    while starting:
        run: Optional[Run] = next(iter(starting.values()))[0]
        rings.append([])
        while run:
            rings[-1].append(run[0])
            starting[run[0]].remove(run)
            if not starting[run[0]]:
                del starting[run[0]]
            following = starting.get(run[1])
            run = min(following, key=functools.partial(_turn, run)) if following else None
    return rings


def _turn(before: Run, after: Run) -> int:
    """Return a positive number if the border turns left from `before` to `after`, a negative one if it turns right.

    At a corner where two walls touch, the border takes the right turn, and so keeps the two walls together.
    """
    (x1, y1), (x2, y2), (x3, y3) = *before, after[1]
    return (x2 - x1) * (y3 - y2) - (y2 - y1) * (x3 - x2)


def _runs(walls: Array) -> List[Run]:
    """Return every straight piece of a border as its two corners, in the direction that has the wall on the left."""
    cells = np.pad(walls, 1).astype(np.int8)
    runs = []
    for turned, step in ((cells, 1), (cells.T, -1)):
        edges = np.diff(turned, axis=0)[:, 1:-1]  # 1 where a wall begins above a grid line, -1 where it ends
        for sign in (1, -1):
            ends = np.diff(np.pad((edges == sign).astype(np.int8), ((0, 0), (1, 1))), axis=1)
            lines, begins = np.nonzero(ends == 1)
            finishes = np.nonzero(ends == -1)[1]
            for line, begin, finish in zip(lines.tolist(), begins.tolist(), finishes.tolist()):
                first, second = ((begin, line), (finish, line)) if sign * step > 0 else ((finish, line), (begin, line))
                runs.append((first, second) if step > 0 else (first[::-1], second[::-1]))
    return runs


def _straightened(ring: List[Corner]) -> List[Corner]:
    """Return the few corners of a closed border that keep its shape.

    The lines between the returned corners are within the distance of `STRAIGHTENED_SQUARED` from all dropped corners.
    A corner between two sides of three cells or more is always kept. Shorter sides may come from a slanted wall, which
    makes steps of one or two cells in the grid.
    """
    points = np.array(ring, dtype=np.int64)
    points = np.roll(points, -int(np.lexsort((points[:, 1], points[:, 0]))[0]), axis=0)
    far = int(np.argmax(np.square(points - points[0]).sum(axis=1)))
    points = np.vstack((points, points[:1]))
    long = np.abs(np.diff(points, axis=0)).sum(axis=1) > 2
    kept = {0, far, *np.flatnonzero(long & np.roll(long, 1)).tolist()}
    ends = sorted(kept) + [len(points) - 1]
    open_ends = list(zip(ends, ends[1:]))
    sides = set(open_ends) if len(kept) == 2 else ()  # a thin wall keeps its thickness
    while open_ends:
        first, last = open_ends.pop()
        if last - first < 2:
            continue
        squared = _squared_distances(points[first + 1:last], points[first], points[last])
        if (first, last) in sides or squared.max() > STRAIGHTENED_SQUARED:
            worst = first + 1 + int(np.argmax(squared))
            kept.add(worst)
            open_ends += [(first, worst), (worst, last)]
    return [(x, y) for x, y in points[sorted(kept)].tolist()]


def _squared_distances(points: Array, first: Array, last: Array) -> Array:
    """Return the squared distances from `points` (n, 2) to the segment from `first` to `last`."""
    (along_x, along_y), (x, y) = last - first, (points - first).T
    length_squared = max(along_x * along_x + along_y * along_y, 1)
    share = np.clip((x * along_x + y * along_y) / length_squared, 0.0, 1.0)
    squared: Array = np.square(x - share * along_x) + np.square(y - share * along_y)
    return squared
