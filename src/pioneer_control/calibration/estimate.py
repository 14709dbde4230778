"""The factors of a robot from all its runs, how sure they are, and why a robot cannot be calibrated.

Corrected odometry has to end where the tape says. The factors are those with the least sum of squared misfits, each in
units of what it may be by chance (weighted least squares, Gauss-Newton with differences). What may be by chance grows
with the way of the wheels; a run that is repeated shows whether it does so on this floor.

Lengths in m, angles in rad.
"""

import math
from typing import Any, List, NamedTuple, Optional, Sequence

import numpy as np

from ..errors import CalibrationError
from .runs import START_HEADING_ERROR, TAPE_ERROR, RunKind, TapedRun
from .tracks import Factors

Array = Any     # of numpy

WIDTH = Factors(0.1, 0.15, 0.1)
"""How wrong a robot may be before any run (standard deviations of its factors)."""
ROUNDS = 6
STEPS = Factors(1e-5, 1e-5, 1e-5)
"""Differences for derivatives."""
MOST = Factors(0.15, 0.25, 0.35)
"""How far factors may be from 1, 1 and 0: no wheel is more wrong."""
MOST_MISFIT = 4.0
"""Runs may differ twice as much as on a rough floor: the mean of the squared misfits."""
STRANGE = 5.0
"""A run that misfits all others by more standard deviations than this is asked for again."""
ENOUGH = Factors(0.002, 0.0015, 0.01)
"""Standard deviations at which an estimate is sure enough."""


class Estimate(NamedTuple):
    """What is known of a robot.

    Attributes:
        factors: its factors.
        deviations: their standard deviations.
        misfit: mean of the squared misfits of the runs, 1 where they differ as on the floor that is assumed.
        gyro: turn for each turn that its gyro measures; None without a gyro.
        gyro_deviation: its standard deviation.
    """

    factors: Factors
    deviations: Factors
    misfit: float
    gyro: Optional[float]
    gyro_deviation: float

    def right_larger(self, rad_per_metre: float) -> float:
        """Return the share by which the right wheel is larger than the left.

        ``rad_per_metre``: turn when each right wheel rolls 1 m forward and each left wheel 1 m back.
        """
        return 2.0 * self.factors.curve / (rad_per_metre * self.factors.turn / self.factors.distance)

    @property
    def wider_apart(self) -> float:
        """The share by which the wheels are farther apart than the robot assumes."""
        return self.factors.distance / self.factors.turn - 1.0

    @property
    def is_sure(self) -> bool:
        """Whether it is sure enough to be used."""
        return all(have <= enough for have, enough in zip(self.deviations, ENOUGH))


def estimate(runs: Sequence[TapedRun], rad_per_metre: float) -> Estimate:
    """Return what the runs say of a robot. Without runs: nothing is wrong, and nothing is sure.

    ``rad_per_metre``: turn when each right wheel rolls 1 m forward and each left wheel 1 m back.
    """
    prior, width = np.array(Factors()), np.array(WIDTH)
    at = prior.copy()
    for _ in range(ROUNDS):
        information = np.diag(1.0 / width ** 2)
        towards = (prior - at) / width ** 2
        for run in runs:
            slope, weight = _slope(run, at), np.linalg.inv(run.covariance(rad_per_metre, Factors(*at)))
            information = information + slope.T @ weight @ slope
            towards = towards + slope.T @ weight @ (run.measured - run.predicted(Factors(*at)))
        at = np.clip(at + np.linalg.solve(information, towards), prior - 6.0 * width, prior + 6.0 * width)
        at[:2] = np.maximum(at[:2], 0.2)
    misfits = [_misfit(run, Factors(*at), rad_per_metre) for run in runs]
    free = sum(len(run.measured) for run in runs) - len(prior)
    misfit = sum(misfits) / free if free > 0 else 1.0
    deviations = np.sqrt(np.diag(np.linalg.inv(information)) * max(1.0, misfit))
    return Estimate(Factors(*map(float, at)), Factors(*map(float, deviations)), float(misfit), *_gyro(runs))


def _slope(run: TapedRun, at: Array) -> Array:
    """Return how the numbers of a run change with each factor: one column for each."""
    columns = []
    for index, step in enumerate(STEPS):
        more = at.copy()
        more[index] += step
        columns.append((run.predicted(Factors(*more)) - run.predicted(Factors(*at))) / step)
    return np.array(columns).T


def _misfit(run: TapedRun, factors: Factors, rad_per_metre: float, also: Optional[Array] = None) -> float:
    """Return the squared misfit of a run. ``also``: a covariance besides its own."""
    off = run.measured - run.predicted(factors)
    covariance = run.covariance(rad_per_metre, factors) + (0.0 if also is None else also)
    return float(off @ np.linalg.solve(covariance, off))


def _gyro(runs: Sequence[TapedRun]) -> List[Any]:
    """Return the factor of the gyro and its standard deviation, from the turns on the spot; None without a gyro."""
    seen = [(run.track.gyro, run.turned, run.marks) for run in runs
            if run.kind is RunKind.TURN and run.track.gyro is not None]
    squares = sum(by_gyro ** 2 for by_gyro, _, _ in seen)
    if squares < 1.0:
        return [None, math.inf]
    factor = sum(by_gyro * turned for by_gyro, turned, _ in seen) / squares
    by_tape = START_HEADING_ERROR ** 2 + max(2.0 * (TAPE_ERROR / marks.apart) ** 2 for _, _, marks in seen)
    scatter = sum((turned - factor * by_gyro) ** 2 for by_gyro, turned, _ in seen) / max(1, len(seen) - 1)
    return [factor, math.sqrt(max(by_tape, scatter) / squares)]


def strangeness(run: TapedRun, others: Sequence[TapedRun], rad_per_metre: float) -> float:
    """Return by how many standard deviations a run misfits what the others say, at most along one of its numbers."""
    known = estimate(others, rad_per_metre)
    slope = _slope(run, np.array(known.factors))
    return math.sqrt(_misfit(run, known.factors, rad_per_metre, slope @ np.diag(np.square(known.deviations)) @ slope.T))


def check(runs: Sequence[TapedRun], rad_per_metre: float) -> Estimate:
    """Return what the runs say of a robot.

    Raises:
        CalibrationError: this robot cannot be calibrated: no wheel is so wrong, or its runs contradict each other. The
            message says what was seen, and what to look for.
    """
    found = estimate(runs, rad_per_metre)
    for what, value, middle, most in zip(
            ("drives %.1f %% farther than it counts", "turns %.1f %% farther than it counts",
             "bends by %.1f degrees in each metre that it counts as straight"), found.factors, Factors(), MOST):
        if abs(value - middle) > most:
            amount = math.degrees(value) if middle == 0.0 else 100.0 * (value - middle)
            raise CalibrationError(
                "this robot cannot be calibrated: it %s, and no tyre is so wrong. Look for a wheel that slips or is"
                " loose on its axle, a flat tyre, a castor that sticks; and whether the driver has the right model"
                " (robot_info)"
                % (what % amount))
    free = sum(len(run.measured) for run in runs) - 3
    if free > 0 and found.misfit > MOST_MISFIT * (1.0 + 2.0 / free):
        number, name, times = _worst(runs, found.factors, rad_per_metre)
        raise CalibrationError(
            "this robot cannot be calibrated: its runs differ %.1f times as much as on a rough floor, most of"
            " all run %d (%s), %.1f times. A calibration needs wheels that err the same way each time. Look for a wheel"
            " that slips, a loose tyre, a floor that is wet or a carpet, something that it pushed; and compare what"
            " was typed with the tape" % (math.sqrt(found.misfit), number, name, times))
    return found


def _worst(runs: Sequence[TapedRun], factors: Factors, rad_per_metre: float) -> Any:
    """Return number (from 1) and name of the run with the greatest misfit, and that misfit."""
    misfits = [math.sqrt(_misfit(run, factors, rad_per_metre) / len(run.measured)) for run in runs]
    index = max(range(len(runs)), key=misfits.__getitem__)
    return index + 1, runs[index].name, misfits[index]
