"""A map as a grid of square cells: free, occupied or unknown.

Lengths are in metres, coordinates in the map frame (REP 103). The grid is not turned: its rows run along x, its
columns along y.
"""

from dataclasses import dataclass
from typing import Any, Tuple

import numpy as np

from ..errors import UsageError

Array = Any     # of numpy
FAR = 1e9
"""A coordinate (m) outside any map. Points beyond it count as if they were there, as their cells have no number."""

FREE, OCCUPIED, UNKNOWN = 0, 100, -1
"""Values of a cell, equal to those of nav_msgs/OccupancyGrid."""
FORBIDDEN = 99
"""The value of a cell that no robot may use, though nothing stands there: only in grids for planning."""


@dataclass(frozen=True)
class GridMap:
    """A grid of cells.

    Attributes:
        cells: int8 array (rows of increasing y, columns of increasing x) of `FREE`, `OCCUPIED` and `UNKNOWN`.
        resolution: side of a cell (m).
        origin: x and y (m) of the grid's corner with the smallest x and y.

    Raises:
        UsageError: the cells are no table, or the resolution is not above 0.
    """

    cells: Array
    resolution: float
    origin: Tuple[float, float]

    def __post_init__(self) -> None:
        if self.cells.ndim != 2 or not self.cells.size:
            raise UsageError("cells of the shape %s: a map needs rows and columns" % (self.cells.shape,))
        if not self.resolution > 0.0:
            raise UsageError("resolution %g m: must be above 0" % self.resolution)

    def __eq__(self, other: object) -> bool:
        return (isinstance(other, GridMap) and (self.resolution, self.origin) == (other.resolution, other.origin)
                and np.array_equal(self.cells, other.cells))

    @property
    def bounds(self) -> Tuple[float, float, float, float]:
        """Smallest x and y, then largest x and y (m)."""
        rows, columns = self.cells.shape
        x, y = self.origin
        return x, y, x + columns * self.resolution, y + rows * self.resolution

    def cell(self, x: Array, y: Array) -> Tuple[Array, Array]:
        """Return row and column of the cell that has a point (m), as integers. They may lie outside the grid.

        Arrays of x and y give arrays of rows and columns.
        """
        x, y = (np.minimum(np.maximum(along, -FAR), FAR) for along in (x, y))
        return (np.floor((y - self.origin[1]) / self.resolution).astype(int),
                np.floor((x - self.origin[0]) / self.resolution).astype(int))

    def middle(self, row: Array, column: Array) -> Tuple[Array, Array]:
        """Return x and y (m) of the middle of a cell, or of each cell of two arrays."""
        return (self.origin[0] + (np.asarray(column) + 0.5) * self.resolution,
                self.origin[1] + (np.asarray(row) + 0.5) * self.resolution)

    def at(self, x: Array, y: Array) -> Array:
        """Return the value of the cell at a point (m), or at each point of two arrays; `UNKNOWN` outside the grid."""
        row, column = self.cell(x, y)
        rows, columns = self.cells.shape
        inside = (row >= 0) & (row < rows) & (column >= 0) & (column < columns)
        return np.where(inside, self.cells[np.where(inside, row, 0), np.where(inside, column, 0)], UNKNOWN)
