"""How much floor a robot can use: whether a generated world has room, and what a wander is compared with.

Questions are answered on a grid of `RESOLUTION`, for a disc that must fit, because a robot turns on the spot.
"""

import functools
import math
from typing import Tuple

import numpy as np

from .geometry import Array
from .grids import flood
from .world import World

RESOLUTION = 0.05
"""Side of a grid cell (m)."""

_LIMIT = 1.0  # m: greater clearances are not told apart


def room(world: World, x: float, y: float, clearance: float = 0.5) -> float:
    """How far a round robot could get about from a place: the longer side (m) of the box round all it can reach.

    A world *has room* for a wander when this is above 1.5 m.

    Args:
        clearance: the least distance its middle keeps from walls and posts, at most 1 m.

    Returns:
        0 where it cannot stand at all.
    """
    column_x, row_y, distance = _grid(world)
    reached = flood(_nearest_cell(column_x, row_y, x, y), distance >= clearance)
    rows, columns = np.nonzero(reached)
    return float(max(np.ptp(rows), np.ptp(columns)) * RESOLUTION) if len(rows) else 0.0


def gap_open(world: World, x: float, y: float, width: float = 1.0, reach: float = 1.5, body: float = 0.14) -> bool:
    """Whether a way out, everywhere wider than `width` (below 2 m), begins at a spot.

    The robot may stand close to a wall: the way may begin up to `body` + `width` / 2 from its middle. What is beyond a
    wall is farther, since its own middle is at least `body` this side of the wall and the middle of the way half the
    width beyond.

    Args:
        reach: how far from the spot the way has to lead.
        body: half the width of the robot; as it stands, of the narrowest there is.
    """
    column_x, row_y, distance = _grid(world)
    from_spot = np.sqrt(np.square(column_x - x) + np.square(row_y[:, None] - y))
    reached = flood(from_spot < body + width / 2.0, distance > width / 2.0)
    return bool((reached & (from_spot >= reach)).any())


@functools.lru_cache(maxsize=16)
def _grid(world: World) -> Tuple[Array, Array, Array]:
    """Return the middles of the columns' and rows' cells, and the clearance (rows, columns) there."""
    low_x, low_y, high_x, high_y = world.bounds
    column_x = np.arange(math.floor(low_x / RESOLUTION) - 40, math.ceil(high_x / RESOLUTION) + 41) * RESOLUTION
    row_y = np.arange(math.floor(low_y / RESOLUTION) - 40, math.ceil(high_y / RESOLUTION) + 41) * RESOLUTION
    return column_x, row_y, world.clearances(column_x, row_y, _LIMIT)


def _nearest_cell(column_x: Array, row_y: Array, x: float, y: float) -> Array:
    """Return a grid that is true only in the cell nearest to a point."""
    cell = np.zeros((len(row_y), len(column_x)), dtype=bool)
    cell[np.argmin(np.abs(row_y - y)), np.argmin(np.abs(column_x - x))] = True
    return cell
