"""How well poses explain the scan of a laser: the nearer each ray ends to a wall of the map, the better.

A laser measures to a centimetre or two, and its rays are narrow. So where a ray ends tells more than how long it should
be: on the map there is something, or nothing (a likelihood field). One table has the distance of each cell of the map
to the nearest wall; asking it takes some nanoseconds a ray, and it is made in milliseconds, when the first scan comes.
"""

from typing import Any, Tuple

import numpy as np
from scipy import ndimage

from ..maps import OCCUPIED, GridMap
from .measurement import Beams, spot_shares
from .tuned import LaserSenseNumbers

Array = Any     # of numpy

_UNIT = 0.01    # m: distances and ranges are whole numbers of it
_FARTHEST = 255     # larger distances from a wall count as this one
_NO_ECHO = 1 << 20      # number of a range that is none


class LaserField:
    """Compares the ranges of a laser with a map. It answers the same questions as `measurement.RangeModel`.

    Args:
        grid_map: the map.
        numbers: how ranges scatter.

    Attributes:
        unit: step (m) in which it counts ranges.
        none: the number that stands for no echo.
    """

    unit, none = _UNIT, _NO_ECHO

    def __init__(self, grid_map: GridMap, numbers: LaserSenseNumbers):
        occupied = np.pad(grid_map.cells == OCCUPIED, 1)
        far = np.full(occupied.shape, np.inf)
        if occupied.any():
            far = ndimage.distance_transform_edt(~occupied) * grid_map.resolution
        far[[0, -1], :] = far[:, [0, -1]] = np.inf      # of all that is outside of the map
        self._rows, self._columns = far.shape
        self._distances = np.minimum(far / _UNIT, _FARTHEST).astype(np.uint8).ravel()
        self._resolution = grid_map.resolution
        self._first = tuple(each - grid_map.resolution for each in grid_map.origin)     # corner of the first cell
        distances = np.arange(_FARTHEST + 1) * _UNIT
        self._fine, self._coarse = (_logs(distances, sigma, numbers) for sigma in (numbers.sigma, numbers.sigma_coarse))
        self._near = numbers.near / _UNIT

    def number_of(self, measured: Array) -> Array:
        """Return measured ranges (m) as whole numbers of `unit`; `none` for those that are not finite."""
        ranges = np.asarray(measured, dtype=float)
        finite = np.isfinite(ranges)
        return np.where(finite, np.rint(np.where(finite, ranges, 0.0) / _UNIT), _NO_ECHO).astype(np.int32)

    def log_likelihoods(self, poses: Array, beams: Beams, coarse: bool = False) -> Array:
        """Return the log-likelihood of each reading for each pose, as `RangeModel.log_likelihoods`."""
        return (self._coarse if coarse else self._fine).take(self._apart(poses, beams)).T

    def both(self, poses: Array, pose: Array, beams: Beams) -> Tuple[Array, Array]:
        """Return the sum of `log_likelihoods` for each of some poses, and `explained` for one."""
        apart = self._apart(np.vstack((poses, pose)), beams)
        return self._fine.take(apart[:, :-1]).sum(axis=0), self._judged(apart[:, -1])

    def explained(self, pose: Array, beams: Beams) -> Array:
        """Return for each reading 1 if a pose (x, y, heading) explains it, 0 if not."""
        return self._judged(self._apart(np.reshape(pose, (1, 3)), beams)[:, 0])

    def spot_shares(self, beams: Beams) -> Array:
        """Return the weight of each reading: 1 / the number of readings of its spot, as `RangeModel.spot_shares`."""
        return spot_shares(beams, beams.measured * _UNIT, np.zeros(len(beams.x)))

    def _judged(self, apart: Array) -> Array:
        return (apart <= self._near).astype(float)

    def _apart(self, poses: Array, beams: Beams) -> Array:
        """Return how far each ray ends from the nearest wall: array (readings, poses) of numbers of `unit`."""
        heading = poses[:, 2]
        pose_x, pose_y, cosine, sine = (
            each.astype(np.float32) for each in (
                (poses[:, 0] - self._first[0]) / self._resolution, (poses[:, 1] - self._first[1]) / self._resolution,
                np.cos(heading) / self._resolution, np.sin(heading) / self._resolution))
        far = beams.measured * _UNIT
        end_x, end_y = (each.astype(np.float32)[:, None] for each in (
            beams.x + far * np.cos(beams.heading), beams.y + far * np.sin(beams.heading)))
        column = cosine * end_x
        column -= sine * end_y
        column += pose_x
        row = sine * end_x
        row += cosine * end_y
        row += pose_y
        index = _cell(row, self._rows) * self._columns
        index += _cell(column, self._columns)
        return self._distances.take(index)


def _cell(places: Array, count: int) -> Array:
    """Return the cells of places (in cells), cut to the border, which is outside of the map."""
    return np.minimum(np.maximum(places, 0.0, out=places), count - 1.0, out=places).astype(np.intp)


def _logs(distances: Array, sigma: float, numbers: LaserSenseNumbers) -> Array:
    """Return the log-likelihood of a ray that ends so far (m) from a wall. Of one that ends at a wall it is 0."""
    anywhere = numbers.anywhere
    logs = np.log((1.0 - anywhere) * np.exp(-0.5 * np.square(distances / sigma)) + anywhere)
    return (numbers.worth * logs).astype(np.float32)
