"""The ranges that a sensor should measure on a map, from every place and in every direction: a table.

Asking the table takes some nanoseconds, so localisation can ask it for thousands of poses. The table has nodes every
10 cm, and for each node an echo in each of some directions, as a whole number: it stands for the range, and for how the
wall slants there. A smooth wall bounces sound that meets it at a slant away, so such an echo is often not heard.

How it is made: for one direction, the cells of the map are swept once, column by column, against the direction. Each
ray remembers the last occupied cell that it met. So one sweep gives the echoes of all nodes in this direction. The
echo of a cone is the nearest one of the rays in it.
"""

import functools
import math
from collections import deque
from typing import Any, Deque, Iterator, NamedTuple, Tuple

import numpy as np
from scipy import ndimage

from ..maps import FREE, OCCUPIED, GridMap

Array = Any     # of numpy

CELL = 0.05
"""Side (m) of the cells that are swept. Maps with other cells are first changed to such cells."""
CELLS_PER_NODE = 2
"""The table has a node in every second cell."""
EDGE, ALONG = 1.0, 1.5
"""To find where a wall faces, cells are blurred by the first, and their edges by the second (standard deviations, in
cells).
"""


class Beam(NamedTuple):
    """What a sensor looks with.

    Attributes:
        cone: full width (rad) of the cone in which the nearest thing is measured; 0 for the ray of a laser.
        maximum: longest range (m).
        directions: number of directions of the table. It is a multiple of 4.
        rays: number of rays per direction. More of them find thinner posts.
        unit: step (m) in which the table has ranges.
        slant_limits: angles (rad) between a ray and the normal of the wall that it meets, rising. They divide walls
            into slants, numbered from 0. Without limits all walls have the slant 0.
    """

    cone: float
    maximum: float
    directions: int
    rays: int
    unit: float = 0.02
    slant_limits: Tuple[float, ...] = ()

    @property
    def none(self) -> int:
        """The range number that stands for "nothing within the longest range". It is the largest one."""
        return round(self.maximum / self.unit) + 1

    @property
    def slants(self) -> int:
        """How many slants there are."""
        return len(self.slant_limits) + 1

    @property
    def echo_type(self) -> Any:
        """The smallest type of numpy that holds each echo."""
        return np.min_scalar_type((self.none + 1) * self.slants - 1)


SONAR_BEAM = Beam(math.radians(25.0), 5.0, 72, 3, slant_limits=tuple(map(math.radians, (20.0, 35.0, 50.0))))
"""The cone of a Pioneer's sonar. Walls return echoes up to 20 degrees of slant or more (docs/worlds.md)."""


class ExpectedRanges:
    """The table of one map and one kind of beam.

    Args:
        grid_map: the map. Only occupied cells stop a beam.
        beam: what the sensor looks with.
        bias: length (m) that is added to all ranges: a wall covers cells also on its near side.

    Attributes:
        beam: the argument.
        none: `Beam.none`.
        slants: `Beam.slants`.
    """

    def __init__(self, grid_map: GridMap, beam: Beam = SONAR_BEAM, bias: float = 0.0):
        self.beam = beam
        self.none, self.slants = beam.none, beam.slants
        occupied, self._origin = _with_cells(grid_map)
        table = _nearest_in_cones(occupied, beam, bias)
        _, self._rows, self._columns = table.shape
        self._table = table.ravel()
        angles = np.arange(beam.directions + 1) * (2.0 * math.pi / beam.directions)     # the last one is the first
        to_unit = CELL * CELLS_PER_NODE / beam.unit
        self._cosines, self._sines = ((each(angles) * to_unit).astype(np.float32) for each in (np.cos, np.sin))
        self._first = np.arange(beam.directions + 1) % beam.directions * self._rows * self._columns

    def echoes(self, x: Array, y: Array, heading: Array, coarse: bool = False) -> Array:
        """Return the echoes at some sensor poses (m, rad; map frame): integers, an array of the common shape.

        An echo is its range number times `slants`, plus its slant. A range number is the range in steps of `Beam.unit`,
        or `none`, which has the slant 0. Outside the map, the nearest node counts. If `coarse`, that of the nearest
        node counts everywhere, in half the time.
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
        number = at_node // self.slants
        # the sensor is nearer to what it sees than its node, or farther from it
        ahead = (x - column - np.float32(0.5)) * self._cosines.take(direction)
        ahead += (y - row - np.float32(0.5)) * self._sines.take(direction)
        np.subtract(number + np.float32(0.5), ahead, out=ahead)
        np.minimum(np.maximum(ahead, 0.0, out=ahead), self.none - 1, out=ahead)
        moved = ahead.astype(np.intp)
        moved[number == self.none] = self.none
        moved -= number
        moved *= self.slants
        moved += at_node        # with its slant
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


def _nearest_in_cones(occupied: Array, beam: Beam, bias: float) -> Array:
    """Return the nearest echo in each cone: array (directions, rows of nodes, columns of nodes)."""
    rows, columns = (-(-size // CELLS_PER_NODE) for size in occupied.shape)
    nearest = np.empty((beam.directions, rows, columns), dtype=beam.echo_type)
    half = int(beam.cone / 2.0 / (2.0 * math.pi / (beam.directions * beam.rays)))
    cone: Deque[Array] = deque(maxlen=2 * half + 1)
    for middle, echoes in enumerate(_rays(occupied, beam, bias, half), -2 * half):
        cone.append(echoes)
        if middle >= 0 and middle % beam.rays == 0:
            nearest[middle // beam.rays] = functools.reduce(np.minimum, cone)
    return nearest


def _rays(occupied: Array, beam: Beam, bias: float, more: int) -> Iterator[Array]:
    """Yield the echoes of the rays from all nodes, one direction after the other: arrays (rows of nodes, columns of
    nodes).

    Ray number i looks to i / (directions * rays) of a full turn. The first one is number -`more`, and the last one is
    `more` - 1 beyond the full turn.
    """
    count, facing = beam.directions * beam.rays, _facing(occupied)
    for number in range(-more, count + more):
        cosine, sine = math.cos(2.0 * math.pi * number / count), math.sin(2.0 * math.pi * number / count)
        slant = np.zeros(occupied.shape, dtype=np.int8)
        slant[occupied] = _slants(facing, cosine, sine, beam)
        along_x = abs(cosine) >= abs(sine)
        ahead, aside = (cosine, sine) if along_x else (sine, cosine)
        cells, slant = (occupied, slant) if along_x else (occupied.T, slant.T)
        swept = _swept(cells, slant, beam.slants, ahead > 0.0, aside / abs(ahead))
        echoes = _echoes_of_columns(CELL / abs(ahead), bias, beam).take(swept, mode="clip")
        yield echoes if along_x else echoes.T


def _echoes_of_columns(step: float, bias: float, beam: Beam) -> Array:
    """Return the echo for each number that `_swept` returns. `step`: the way (m) of the ray in a column."""
    ranges = np.arange(math.ceil((beam.maximum - bias) / step) + 2) * step + bias
    numbers = np.where(ranges > beam.maximum, beam.none, np.rint(ranges / beam.unit))[:, None]
    echoes = numbers * beam.slants + np.where(numbers < beam.none, np.arange(beam.slants), 0)
    return echoes.ravel().astype(beam.echo_type)


def _facing(occupied: Array) -> Tuple[Array, Array]:
    """Return for each occupied cell where its wall faces: cosine and sine of twice the angle of the normal.

    Twice, since a thin wall faces to both sides. Where walls meet, both are nearer to 0 than those of an angle.
    """
    up, right = np.gradient(ndimage.gaussian_filter(occupied.astype(np.float32), EDGE))
    xx, xy, yy = (ndimage.gaussian_filter(each, ALONG)[occupied] for each in (right * right, right * up, up * up))
    both = np.maximum(xx + yy, 1e-12)
    return (xx - yy) / both, 2.0 * xy / both


def _slants(facing: Tuple[Array, Array], cosine: float, sine: float, beam: Beam) -> Array:
    """Return the slants of walls that face somewhere, see `_facing`, for a ray in a direction."""
    twice_cosine, twice_sine = cosine * cosine - sine * sine, 2.0 * cosine * sine
    square = 0.5 * (1.0 + facing[0] * twice_cosine + facing[1] * twice_sine)     # of the cosine between ray and normal
    return np.searchsorted(-np.square(np.cos(beam.slant_limits)), -square)


def _swept(cells: Array, slant: Array, slants: int, forward: bool, slope: float) -> Array:
    """Return for each node the next occupied cell on its ray: how many columns it is away, times `slants`, plus its
    slant. An array (node rows, node columns).

    Args:
        cells: which cells are occupied (rows, columns).
        slant: the slant of each of them.
        slants: how many slants there are.
        forward: the rays go to larger columns, otherwise to smaller ones.
        slope: rows that a ray rises in each column that it goes, from -1 to 1.
    """
    rows, columns = cells.shape
    by_column = np.ascontiguousarray(cells.T)
    has_any = by_column.any(axis=1)
    rise = np.rint(np.arange(columns) * slope).astype(int)      # along a ray, counted from the column where it begins
    begin = (rise.max() - rise).tolist()        # the ray through the first row of each column
    kind: Any = np.int16 if 2 * slants * columns < np.iinfo(np.int16).max else np.int32
    never = np.iinfo(kind).max      # a ray has met no cell; it is far more than any place
    places = np.arange(columns, dtype=kind) * kind(slants)      # of columns along a ray
    numbers = np.add(slant.T, (places if forward else places[::-1])[:, None], order="C")
    met = np.full(rows + int(np.ptp(rise)), never, dtype=kind)      # for each ray, the number of the last cell
    away = np.empty((-(-columns // CELLS_PER_NODE), -(-rows // CELLS_PER_NODE)), dtype=kind)
    for place in range(columns - 1, -1, -1):
        column = place if forward else columns - 1 - place
        rays = met[begin[place]:begin[place] + rows]
        if has_any[column]:
            np.putmask(rays, by_column[column], numbers[column])
            if place and begin[place - 1] != begin[place]:      # a ray does not slip between two cells at a corner
                np.putmask(met[begin[place - 1]:begin[place - 1] + rows], by_column[column], numbers[column])
        if column % CELLS_PER_NODE == 0:
            np.subtract(rays[::CELLS_PER_NODE], places[place], out=away[column // CELLS_PER_NODE])
    return away.T
