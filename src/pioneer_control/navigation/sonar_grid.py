"""A map from sonar: each firing votes for cells that are free and for cells that are occupied. The grid grows.

The votes of all firings are summed. So the votes of a part of the path can be taken out, and put in again from better
poses (`mapping`). The sum for a cell is its log-odds to be occupied.

An echo says that something is on its arc, but not where. It gives its votes to the cells of the arc in proportion to
the present odds of each. Nothing is freed behind a cell that is occupied for sure: sound that meets a slanting wall
bounces away, and the sonar then hears too far.
"""

import copy
import math
from typing import Any, NamedTuple, Sequence, Tuple

import numpy as np

from ..floor_poses import Pose
from ..maps import FREE, OCCUPIED, UNKNOWN, GridMap
from .frames import out_of
from .tuned import MapNumbers

Array = Any     # of numpy

_COLUMNS = 13
"""Directions in a cone, odd, so that one is the axis."""
_BLOCK = 64
"""The grid grows by whole blocks of this many cells."""


class SonarBeams(NamedTuple):
    """Firings and where they came from, as arrays of the same length.

    `x`, `y` (m) and `heading` (rad) are of the transducers, `range` (m) is infinite without an echo.
    """

    x: Array
    y: Array
    heading: Array
    range: Array

    def moved(self, x: float, y: float, heading: float) -> "SonarBeams":
        """Return the beams in the frame in which their own frame has this pose."""
        return SonarBeams(*out_of(Pose(x, y, heading), self.x, self.y), self.heading + heading, self.range)

    def chosen(self, which: Array) -> "SonarBeams":
        """Return some of the beams. `which`: a mask of all, or indices."""
        return SonarBeams(*(each[which] for each in self))


class Votes(NamedTuple):
    """What some firings say about the cells of a window.

    `row` and `column` are the first of the window, counted from the cell at the origin of the frame; they may be
    negative. `free` and `occupied` are arrays of log-odds, none negative.
    """

    row: int
    column: int
    free: Array
    occupied: Array


class SonarGrid:
    """The sum of votes. Its frame is the map frame; the cell (0, 0) has its corner at the origin.

    Args:
        numbers: how firings become votes.
    """

    def __init__(self, numbers: MapNumbers) -> None:
        self.numbers = numbers
        self._row = self._column = -_BLOCK // 2
        self._odds = np.zeros((_BLOCK, _BLOCK), dtype=np.float32)
        self._seen = np.zeros((_BLOCK, _BLOCK), dtype=np.float32)
        angles = np.linspace(-1.0, 1.0, _COLUMNS)
        self._angles = angles * numbers.half_cone
        step = numbers.resolution
        self._distances = np.arange(step, numbers.reach, step)
        # Weights of free cells (columns, distances): less off the axis, less far away, less where columns are close.
        crowded = np.minimum(1.0, self._distances * numbers.half_cone * 2.0 / (_COLUMNS - 1) / step)
        self._free = (numbers.free * (1.0 - numbers.aside * angles[:, None] ** 2)
                      * (1.0 - numbers.far * self._distances / numbers.reach) * crowded).astype(np.float32)

    def votes(self, beams: SonarBeams) -> Votes:
        """Return what firings say, when all that the grid has now is taken into account. Frame: that of the map."""
        numbers = self.numbers
        step = numbers.resolution
        if not len(beams.x):
            return Votes(0, 0, np.zeros((1, 1), np.float32), np.zeros((1, 1), np.float32))
        low = _cell(min(beams.x.min(), 1e9) - numbers.reach, step), _cell(beams.y.min() - numbers.reach, step)
        high = _cell(beams.x.max() + numbers.reach, step), _cell(beams.y.max() + numbers.reach, step)
        self._grow(low[1], low[0], high[1] + 1, high[0] + 1)
        shape = high[1] - low[1] + 1, high[0] - low[0] + 1
        window = self._odds[low[1] - self._row:, low[0] - self._column:][:shape[0], :shape[1]]

        silent = ~np.isfinite(beams.range)
        direction = beams.heading[:, None] + self._angles
        cosine, sine = (each(direction).astype(np.float32) for each in (np.cos, np.sin))
        at_x, at_y = ((at / step - first).astype(np.float32) for at, first in zip((beams.x, beams.y), low))
        odds = np.ascontiguousarray(window).ravel()
        # free: points (beams, columns, distances), up to the echo or to the first sure wall
        until = np.where(silent, numbers.reach_of_silence, beams.range - numbers.short_of)
        used = self._distances[self._distances <= max(until.max(), step)]
        away = (used / step).astype(np.float32)
        column = (at_x[:, None, None] + cosine[:, :, None] * away).astype(np.int32)
        row = (at_y[:, None, None] + sine[:, :, None] * away).astype(np.int32)
        rows = row * shape[1]
        cell = rows + column
        sure = odds > numbers.hides
        hides = sure[cell]
        # A step to a cell that only touches the last one at a corner passes two more: one of them may be the wall.
        hides[:, :, 1:] |= sure[rows[:, :, 1:] + column[:, :, :-1]] | sure[rows[:, :, :-1] + column[:, :, 1:]]
        hidden = np.where(hides.any(axis=2), hides.argmax(axis=2), len(used))
        ends = np.minimum(np.searchsorted(used, until, side="right")[:, None], hidden)
        counts = np.arange(len(used)) < ends[:, :, None]
        weight = self._free[:, :len(used)] * np.where(silent, numbers.silent, 1.0).astype(np.float32)[:, None, None]
        count = shape[0] * shape[1]
        free = np.bincount(cell[counts], weight[counts], count)

        # occupied: points (beams, columns) on the arc, in proportion to their odds
        heard = ~silent & (beams.range < numbers.reach)
        distance = np.where(heard, beams.range / step, 1.0)[:, None]
        column = (at_x[:, None] + cosine * distance).astype(np.int32)
        row = (at_y[:, None] + sine * distance).astype(np.int32)
        cell = row * shape[1] + column
        share = np.exp(np.clip(odds[cell], -numbers.certain, numbers.certain))
        share *= (numbers.occupied * heard / share.sum(axis=1))[:, None]
        occupied = np.bincount(cell.ravel(), share.ravel(), count)
        return Votes(low[1], low[0], free.reshape(shape).astype(np.float32), occupied.reshape(shape).astype(np.float32))

    def add(self, votes: Votes, sign: int = 1) -> None:
        """Add votes to the sums; with `sign` -1 take them out."""
        rows, columns = votes.free.shape
        self._grow(votes.row, votes.column, votes.row + rows, votes.column + columns)
        window = np.s_[votes.row - self._row:votes.row - self._row + rows,
                       votes.column - self._column:votes.column - self._column + columns]
        self._odds[window] += sign * (votes.occupied - votes.free)
        self._seen[window] += sign * (votes.occupied + votes.free)

    def copy(self) -> "SonarGrid":
        """Return a grid with the same sums, which goes its own way."""
        other = copy.copy(self)
        other._odds, other._seen = self._odds.copy(), self._seen.copy()
        return other

    def window(self, low: Tuple[float, float], high: Tuple[float, float],
               without: Sequence[Votes] = ()) -> Tuple[Array, int, int]:
        """Return the log-odds of a part of the map, with its first row and column (of the whole lattice).

        Args:
            low: smallest x and y (m).
            high: largest x and y (m).
            without: votes that are taken out.
        """
        step = self.numbers.resolution
        column, row = _cell(low[0], step), _cell(low[1], step)
        end_column, end_row = _cell(high[0], step) + 1, _cell(high[1], step) + 1
        self._grow(row, column, end_row, end_column)
        odds = self._odds[row - self._row:end_row - self._row, column - self._column:end_column - self._column].copy()
        for votes in without:
            rows, columns = votes.free.shape
            first_row, first_column = max(row, votes.row), max(column, votes.column)
            last_row, last_column = min(end_row, votes.row + rows), min(end_column, votes.column + columns)
            if first_row < last_row and first_column < last_column:
                theirs = np.s_[first_row - votes.row:last_row - votes.row,
                               first_column - votes.column:last_column - votes.column]
                odds[first_row - row:last_row - row, first_column - column:last_column - column] -= (
                    votes.occupied[theirs] - votes.free[theirs])
        return odds, row, column

    def grid_map(self, x: float = 0.0, y: float = 0.0, margin: float = 0.0) -> GridMap:
        """Return the map as it is now, as large as what was seen and a point (m), with a margin (m) all round."""
        step = self.numbers.resolution
        row, column = _cell(y, step), _cell(x, step)
        rows, columns = np.nonzero(self._seen > 1e-4)
        more = math.ceil(margin / step)
        low = (min(row, self._row + int(rows.min(initial=10 ** 9))) - more,
               min(column, self._column + int(columns.min(initial=10 ** 9))) - more)
        high = (max(row, self._row + int(rows.max(initial=-10 ** 9))) + more + 1,
                max(column, self._column + int(columns.max(initial=-10 ** 9))) + more + 1)
        self._grow(*low, *high)
        odds = self._odds[low[0] - self._row:high[0] - self._row, low[1] - self._column:high[1] - self._column]
        cells = np.full(odds.shape, UNKNOWN, np.int8)
        cells[odds < self.numbers.floor] = FREE
        cells[odds > self.numbers.wall] = OCCUPIED
        return GridMap(cells, step, (low[1] * step, low[0] * step))

    def _grow(self, row: int, column: int, end_row: int, end_column: int) -> None:
        """Let the grid have these rows and columns."""
        rows, columns = self._odds.shape
        before = [max(0, -(-(mine - wanted) // _BLOCK)) * _BLOCK
                  for mine, wanted in ((self._row, row), (self._column, column))]
        after = [max(0, -(-(wanted - mine) // _BLOCK)) * _BLOCK
                 for mine, wanted in ((self._row + rows, end_row), (self._column + columns, end_column))]
        if any(before + after):
            margins = tuple(zip(before, after))
            self._odds, self._seen = np.pad(self._odds, margins), np.pad(self._seen, margins)
            self._row, self._column = self._row - before[0], self._column - before[1]


def _cell(value: float, step: float) -> int:
    return math.floor(value / step)
