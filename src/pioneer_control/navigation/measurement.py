"""How well poses explain what a sensor measured: the same for sonar and for a laser, with other numbers.

`Beams` are readings of one moment or of a while, each with the pose that its sensor had relative to the robot as it
stands now. `RangeModel` gives each robot pose the log-likelihood of each reading. The likelihood of a measured range is
a sum of five parts: near the expected range, longer, none, shorter, and any. How likely the first three are depends on
how the wall slants.
"""

from dataclasses import replace
from typing import Any, NamedTuple, Tuple

import numpy as np

from ..maps import GridMap
from .expected_ranges import Beam, ExpectedRanges
from .tuned import EchoShares, SensorNumbers

Array = Any     # of numpy

COARSER = 4.0
"""For poses that are only roughly right, the standard deviations are so many times larger."""
SPOT = 0.2
"""Readings that end in one square of this side (m) tell of one spot."""
NO_ECHO_AT = 1.0
"""A reading without an echo counts as if it ended so far (m) from its sensor."""
NEAR = 2.5
"""A reading is explained when it is within so many standard deviations of the expected range."""


class Beams(NamedTuple):
    """Readings, as arrays of one length.

    Attributes:
        x: x of the sensor at its reading, relative to the robot's present pose (m).
        y: y of the sensor, relative in the same way (m).
        heading: direction in which the sensor looked, relative to the robot's present heading (rad).
        measured: number of the range, see `ExpectedRanges.number_of`.
        sensor: number of the transducer, or of the ray of a scan.
    """

    x: Array
    y: Array
    heading: Array
    measured: Array
    sensor: Array

    def some(self, which: Array) -> "Beams":
        """Return the readings with these indices."""
        return Beams(*(each[which] for each in self))


class RangeModel:
    """Compares measured ranges with those that a map lets expect.

    Args:
        grid_map: the map.
        beam: what the sensor looks with.
        numbers: how its readings scatter.
        bias: see `ExpectedRanges`.

    Attributes:
        expected: the table of expected ranges.
        none: the number that stands for no echo.
    """

    def __init__(self, grid_map: GridMap, beam: Beam, numbers: SensorNumbers, bias: float):
        self.expected = ExpectedRanges(grid_map, beam, bias)
        self.none, self.number_of = self.expected.none, self.expected.number_of
        self._count, self._lost = self.none + 1, numbers.lost
        ranges = np.arange(self._count) * beam.unit
        self._near = np.rint(NEAR * (numbers.sigma + numbers.sigma_per_metre * ranges) / beam.unit).astype(np.int32)
        coarse = replace(numbers, sigma=numbers.sigma * COARSER, sigma_per_metre=numbers.sigma_per_metre * COARSER)
        self._fine_logs, self._coarse_logs = (
            np.log(likelihoods(ranges, beam, each)).astype(np.float32).ravel() for each in (numbers, coarse))

    def log_likelihoods(self, poses: Array, beams: Beams, coarse: bool = False) -> Array:
        """Return the log-likelihood of each reading for each pose: float32 array (poses, readings).

        Args:
            poses: array (poses, 3) of x, y (m) and heading (rad) of the robot now, map frame.
            beams: the readings.
            coarse: the poses are only roughly right, so readings may differ more.
        """
        logs = self._coarse_logs if coarse else self._fine_logs
        return logs.take(self._expected(poses, beams, coarse) * self._count + beams.measured[:, None]).T

    def spot_shares(self, beams: Beams) -> Array:
        """Return the weight of each reading, see `spot_shares`."""
        silent = beams.measured == self.none
        return spot_shares(beams, np.where(silent, NO_ECHO_AT, beams.measured * self.expected.beam.unit), silent)

    def explained(self, pose: Array, beams: Beams) -> Array:
        """Return for each reading 1 if a pose (x, y, heading) explains it, 0 if not, and NaN if it says nothing.

        A reading without an echo says nothing: a wall may have bounced the sound away. So it is with a longer range
        than that of a wall that slants much.
        """
        return self._judged(self._expected(np.reshape(pose, (1, 3)), beams)[:, 0], beams)

    def both(self, poses: Array, pose: Array, beams: Beams) -> Tuple[Array, Array]:
        """Return the sum of `log_likelihoods` for each of some poses, and `explained` for one, in half the time."""
        expected = self._expected(np.vstack((poses, pose)), beams)
        logs = self._fine_logs.take(expected[:, :-1] * self._count + beams.measured[:, None]).sum(axis=0)
        return logs, self._judged(expected[:, -1], beams)

    def _judged(self, expected: Array, beams: Beams) -> Array:
        number, slant = np.divmod(expected, self.expected.slants)
        near = np.abs(number - beams.measured) <= self._near[number]
        lost = (slant >= self._lost) & (beams.measured > number) & ~near
        return np.where(lost | (beams.measured == self.none), np.nan, near.astype(float))

    def _expected(self, poses: Array, beams: Beams, coarse: bool = False) -> Array:
        """Return the expected echoes: array (readings, poses), since numpy is faster along the longer axis."""
        heading = poses[:, 2]
        pose_x, pose_y, cosine, sine, heading = (
            each.astype(np.float32) for each in (poses[:, 0], poses[:, 1], np.cos(heading), np.sin(heading), heading))
        beam_x, beam_y, beam_heading = (each.astype(np.float32)[:, None] for each in beams[:3])
        x, y = cosine * beam_x, sine * beam_x
        x -= sine * beam_y
        y += cosine * beam_y
        x += pose_x
        y += pose_y
        return self.expected.echoes(x, y, heading + beam_heading, coarse).astype(np.intp, copy=False)


def spot_shares(beams: Beams, far: Array, silent: Array) -> Array:
    """Return the weight of each reading: 1 / the number of readings of its spot. So each spot counts once.

    A robot that turns beside a thing on no map hears it again and again. That is one coincidence, not many. The sum of
    the weights is the number of spots.

    Args:
        beams: the readings.
        far: how far (m) from its sensor each ends.
        silent: which have no echo. They tell of other spots than those that have one.
    """
    squares = np.floor(np.stack((beams.x + far * np.cos(beams.heading),
                                 beams.y + far * np.sin(beams.heading))) / SPOT)
    keys = (squares[0] * 1e4 + squares[1]) * 2.0 + silent
    _, number, count = np.unique(keys, return_inverse=True, return_counts=True)
    return 1.0 / count[number]


def likelihoods(ranges: Array, beam: Beam, numbers: SensorNumbers) -> Array:
    """Return the likelihood of each measured number for each expected echo: array (echoes, measured).

    Each row has the sum 1. The last column stands for no echo.
    """
    of_slants = [_likelihoods(ranges, beam, numbers, shares) for shares in numbers.shares]
    return np.stack(of_slants, axis=1).reshape(-1, len(ranges))


def _likelihoods(ranges: Array, beam: Beam, numbers: SensorNumbers, shares: EchoShares) -> Array:
    """Return the likelihood of each measured number for each expected number: array (expected, measured)."""
    expected, measured = ranges[:, None], ranges[None, :-1]
    sigma = numbers.sigma + numbers.sigma_per_metre * expected
    near = _shares(np.exp(-0.5 * np.square((measured - expected) / sigma)))
    longer, shorter = _shares((measured > expected).astype(float)), _shares((measured < expected).astype(float))
    anything = np.full_like(near, 1.0 / near.shape[1])
    echoes = (shares.hit * near + shares.long * longer + numbers.short * shorter + numbers.random * anything)
    all_parts = np.hstack((echoes, np.full((len(ranges), 1), shares.none + numbers.random * 0.05)))
    # nothing is in reach: no echo, or that of a thing that is on no map
    all_parts[-1, :-1] = numbers.short * shorter[-1] + numbers.random * anything[-1]
    all_parts[-1, -1] = sum(shares)
    return all_parts / all_parts.sum(axis=1, keepdims=True)


def _shares(rows: Array) -> Array:
    """Scale each row to the sum 1. Rows of zeros stay so."""
    return rows / np.maximum(rows.sum(axis=1, keepdims=True), 1e-12)
