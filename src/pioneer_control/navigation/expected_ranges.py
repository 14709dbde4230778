"""The ranges that a sensor should measure on a map, from every place and in every direction: a table.

Asking the table takes some nanoseconds, so localisation can ask it for thousands of poses. The table has nodes every
10 cm, and for each node a range in each of some directions, as a small whole number.

How it is made: for one direction, the cells of the map are swept once, column by column, against the direction. Each
ray remembers the last occupied cell that it met. So one sweep gives the ranges of all nodes in this direction. The
range of a cone is the least range of the rays in it.
"""

import math
from typing import Any, NamedTuple, Tuple

import numpy as np
from scipy import ndimage

from ..maps import FREE, OCCUPIED, GridMap

Array = Any     # of numpy

CELL = 0.05
"""Side (m) of the cells that are swept. Maps with other cells are first changed to such cells."""
CELLS_PER_NODE = 2
"""The table has a node in every second cell."""


class Beam(NamedTuple):
    """What a sensor looks with.

    Attributes:
        cone: full width (rad) of the cone in which the nearest thing is measured; 0 for the ray of a laser.
        maximum: longest range (m).
        directions: number of directions of the table. It is a multiple of 4.
        rays: number of rays per direction. More of them find thinner posts.
        unit: step (m) in which the table has ranges.
    """

    cone: float
    maximum: float
    directions: int
    rays: int
    unit: float = 0.02


SONAR_BEAM = Beam(math.radians(25.0), 5.0, 72, 3)
"""The cone of a Pioneer's sonar."""
LASER_BEAM = Beam(0.0, 8.0, 180, 1, 0.04)
"""A ray of a laser. Navigation uses the first 8 m of it, also if it measures farther."""


class ExpectedRanges:
    """The table of one map and one kind of beam. It takes 1 s and 30 MB for sonar on a map of 50 x 50 m.

    Args:
        grid_map: the map. Only occupied cells stop a beam.
        beam: what the sensor looks with.
        bias: length (m) that is added to all ranges: a wall covers cells also on its near side.

    Attributes:
        beam: the argument.
        none: the number that stands for "nothing within the longest range". It is the largest number of the table.
    """

    def __init__(self, grid_map: GridMap, beam: Beam = SONAR_BEAM, bias: float = 0.0):
        self.beam = beam
        self.none = round(beam.maximum / beam.unit) + 1
        occupied, self._origin = _with_cells(grid_map)
        table = _least_in_cones(_all_rays(occupied, beam, bias, self.none), beam)
        _, self._rows, self._columns = table.shape
        self._table = table.ravel()
        angles = np.arange(beam.directions + 1) * (2.0 * math.pi / beam.directions)     # the last one is the first
        to_unit = CELL * CELLS_PER_NODE / beam.unit
        self._cosines, self._sines = ((each(angles) * to_unit).astype(np.float32) for each in (np.cos, np.sin))
        self._first = np.arange(beam.directions + 1) % beam.directions * self._rows * self._columns

    def numbers(self, x: Array, y: Array, heading: Array, coarse: bool = False) -> Array:
        """Return the range numbers at some sensor poses (m, rad; map frame): integers, an array of the common shape.

        A number is the range in steps of `Beam.unit`, or `none`. Outside the map, the nearest node counts. If `coarse`,
        that of the nearest node counts everywhere, in half the time.
        """
        side, directions = CELL * CELLS_PER_NODE, self.beam.directions
        # adding a half and cutting off rounds, and is faster than rint; what is outside is cut to the border
        x, column = _nearest((x - (self._origin[0] - side / 2.0)) / side, self._columns)
        y, row = _nearest((y - (self._origin[1] - side / 2.0)) / side, self._rows)
        turn = heading * np.float32(1.0 / (2.0 * math.pi))
        turn -= np.floor(turn)      # faster than a remainder
        direction = (turn * np.float32(directions) + np.float32(0.5)).astype(np.intp)
        index = row * self._columns
        index += column
        index += self._first.take(direction)
        at_node = self._table.take(index)
        if coarse:
            return at_node
        # the sensor is nearer to what it sees than its node, or farther from it
        ahead = (x - column - np.float32(0.5)) * self._cosines.take(direction)
        ahead += (y - row - np.float32(0.5)) * self._sines.take(direction)
        np.subtract(at_node + np.float32(0.5), ahead, out=ahead)
        np.minimum(np.maximum(ahead, 0.0, out=ahead), self.none - 1, out=ahead)
        moved = ahead.astype(np.intp)
        moved[at_node == self.none] = self.none
        return moved

    def number_of(self, measured: Array) -> Array:
        """Return measured ranges (m) as numbers like those of the table; longer ones than the longest as `none`."""
        steps = np.minimum(np.asarray(measured, dtype=float) / self.beam.unit, self.none)
        return np.where(steps > self.none - 1, self.none, np.rint(np.maximum(steps, 0.0))).astype(np.int32)


def _nearest(places: Array, count: int) -> Tuple[Array, Array]:
    """Return places (in nodes, from half a node before the first one), cut to `count` nodes, and their nodes."""
    places = places.astype(np.float32, copy=False)
    np.minimum(np.maximum(places, 0.0, out=places), count - 0.5, out=places)
    return places, places.astype(np.intp)


def standing_room(grid_map: GridMap, clearance: float) -> Array:
    """Return x and y (m) of the middles of all free cells that are at least `clearance` (m) from an occupied one: array
    (cells, 2). These are the places where a robot can stand.
    """
    free = (grid_map.cells == FREE)
    if (grid_map.cells == OCCUPIED).any():
        free &= ndimage.distance_transform_edt(grid_map.cells != OCCUPIED) * grid_map.resolution >= clearance
    return np.stack(grid_map.middle(*np.nonzero(free)), axis=1)


def _with_cells(grid_map: GridMap) -> Tuple[Array, Tuple[float, float]]:
    """Return which cells of side `CELL` are occupied, and x and y (m) of the middle of the first one."""
    low_x, low_y, high_x, high_y = grid_map.bounds
    shape = math.ceil((high_y - low_y) / CELL - 1e-6), math.ceil((high_x - low_x) / CELL - 1e-6)
    first = low_x + CELL / 2.0, low_y + CELL / 2.0
    if grid_map.resolution < CELL:      # a cell is occupied when any of the small cells in it is
        occupied = np.zeros(shape, dtype=bool)
        x, y = grid_map.middle(*np.nonzero(grid_map.cells == OCCUPIED))
        row, column = ((y - low_y) / CELL).astype(int), ((x - low_x) / CELL).astype(int)
        occupied[np.minimum(row, shape[0] - 1), np.minimum(column, shape[1] - 1)] = True
        return occupied, first
    x, y = first[0] + np.arange(shape[1]) * CELL, first[1] + np.arange(shape[0]) * CELL
    row, _ = grid_map.cell(low_x, y)
    _, column = grid_map.cell(x, low_y)
    rows, columns = grid_map.cells.shape
    return grid_map.cells[np.ix_(np.minimum(row, rows - 1), np.minimum(column, columns - 1))] == OCCUPIED, first


def _all_rays(occupied: Array, beam: Beam, bias: float, none: int) -> Array:
    """Return the range numbers of all rays: array (directions * rays, rows of nodes, columns of nodes).

    Ray number i looks to i / (directions * rays) of a full turn.
    """
    count = beam.directions * beam.rays
    rows, columns = (-(-size // CELLS_PER_NODE) for size in occupied.shape)
    found = np.empty((count, rows, columns), dtype=np.uint8 if none < 256 else np.uint16)
    for number in range(count):
        cosine, sine = math.cos(2.0 * math.pi * number / count), math.sin(2.0 * math.pi * number / count)
        along_x = abs(cosine) >= abs(sine)
        ahead, aside = (cosine, sine) if along_x else (sine, cosine)
        cells, target = (occupied, found[number]) if along_x else (occupied.T, found[number].T)
        step = CELL / abs(ahead)
        lengths = np.arange(math.ceil((beam.maximum - bias) / step) + 2) * step + bias
        to_number = np.where(lengths > beam.maximum, none, np.rint(lengths / beam.unit)).astype(found.dtype)
        target[:] = to_number.take(_swept(cells, ahead > 0.0, aside / abs(ahead)), mode="clip")
    return found


def _swept(cells: Array, forward: bool, slope: float) -> Array:
    """Return how many columns each node is from the next occupied cell on its ray: array (node rows, node columns).

    Args:
        cells: which cells are occupied (rows, columns).
        forward: the rays go to larger columns, otherwise to smaller ones.
        slope: rows that a ray rises in each column that it goes, from -1 to 1.
    """
    rows, columns = cells.shape
    by_column = np.ascontiguousarray(cells.T)
    has_any = by_column.any(axis=1)
    rise = np.rint(np.arange(columns) * slope).astype(int)      # along a ray, counted from the column where it begins
    begin = (rise.max() - rise).tolist()        # the ray through the first row of each column
    never = 30000
    met = np.full(rows + int(np.ptp(rise)), never, dtype=np.int16)      # for each ray, the column that it met last
    away = np.empty((-(-columns // CELLS_PER_NODE), -(-rows // CELLS_PER_NODE)), dtype=np.int16)
    for place in range(columns - 1, -1, -1):
        column = place if forward else columns - 1 - place
        rays = met[begin[place]:begin[place] + rows]
        if has_any[column]:
            rays[by_column[column]] = place
            if place and begin[place - 1] != begin[place]:      # a ray does not slip between two cells at a corner
                met[begin[place - 1]:begin[place - 1] + rows][by_column[column]] = place
        if column % CELLS_PER_NODE == 0:
            np.subtract(rays[::CELLS_PER_NODE], place, out=away[column // CELLS_PER_NODE])
    return away.T


def _least_in_cones(rays: Array, beam: Beam) -> Array:
    """Return the least range number in each cone: array (directions, rows of nodes, columns of nodes)."""
    count = len(rays)
    half = int(beam.cone / 2.0 / (2.0 * math.pi / count))
    if not half and beam.rays == 1:
        return rays
    least = np.empty((beam.directions,) + rays.shape[1:], dtype=rays.dtype)
    for direction in range(beam.directions):
        middle = direction * beam.rays
        least[direction] = rays[middle]
        for ray in range(middle - half, middle + half + 1):
            np.minimum(least[direction], rays[ray % count], out=least[direction])
    return least
