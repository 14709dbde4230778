"""The factors from runs, how sure they are, and robots that cannot be calibrated."""

import math
import random

import pytest

from made_runs import RAD_PER_METRE, WRONG, run_of
from pioneer_control.calibration.estimate import STRANGE, check, estimate, strangeness
from pioneer_control.calibration.plan import line, plan_of, square, turns
from pioneer_control.calibration.runs import Tape
from pioneer_control.calibration.tracks import Factors
from pioneer_control.calibration.words import result
from pioneer_control.errors import CalibrationError

ALL = plan_of().runs


def runs(factors=WRONG, planned=ALL, **more):
    return [run_of(each, factors, **more) for each in planned]


def test_the_factors_are_found():
    found = estimate(runs(), RAD_PER_METRE)
    assert found.factors == pytest.approx(WRONG, abs=3e-4)
    assert found.misfit < 0.01 and found.is_sure and found.gyro is None
    assert max(found.deviations[:2]) < 0.0015


def test_without_runs_nothing_is_sure():
    found = estimate((), RAD_PER_METRE)
    assert found.factors == Factors() and not found.is_sure and found.deviations == pytest.approx((0.1, 0.15, 0.1))


def test_more_runs_are_surer():
    few, many = (estimate(runs(planned=plan_of(repeats=times).runs), RAD_PER_METRE) for times in (1, 4))
    assert all(more < less for more, less in zip(many.deviations, few.deviations))


def test_each_kind_of_run_says_something_else():
    lines = estimate(runs(planned=[line(5.0)] * 4), RAD_PER_METRE)
    turned = estimate(runs(planned=[turns(5), turns(-5)]), RAD_PER_METRE)
    squares = estimate(runs(planned=[square(2.0, 1), square(2.0, -1)]), RAD_PER_METRE)
    assert lines.deviations.turn > 0.1 and lines.deviations.distance < 0.002
    assert turned.deviations.distance > 0.09 and turned.deviations.turn < 0.002
    assert squares.deviations.turn < 0.02 and squares.deviations.curve < 0.02
    assert (squares.factors.turn, squares.factors.curve) == pytest.approx(WRONG[1:], abs=0.02)


def test_wheels():
    """The right wheel 1 % larger: its rim rolls 5 mm farther in a metre, the left one's 5 mm less: 0.005 * 5.6 rad."""
    found = estimate(runs(Factors(1.0, 1.0, 0.005 * RAD_PER_METRE)), RAD_PER_METRE)
    assert found.right_larger(RAD_PER_METRE) == pytest.approx(0.01, abs=2e-4)
    found = estimate(runs(Factors(1.02, 1.02 / 1.03, 0.0)), RAD_PER_METRE)
    assert found.wider_apart == pytest.approx(0.03, abs=5e-4)


def test_the_gyro():
    """It measures 5 % more than the robot turns."""
    made = [run_of(turns(count), WRONG, gyro=2 * math.pi * count * WRONG.turn * 1.05) for count in (1, -1, 5, -5)]
    found = estimate(made, RAD_PER_METRE)
    assert found.gyro == pytest.approx(1 / 1.05, abs=1e-6) and 0 < found.gyro_deviation < 0.001
    assert "turns less than its gyro measures" in result(found, RAD_PER_METRE)


def test_how_sure_it_is_holds():
    """Of robots whose runs are off by as much as is assumed, the factors are off by as much as is said."""
    off = []
    for seed in range(30):
        luck = random.Random(seed)
        made = []
        for planned in ALL:
            run = run_of(planned, WRONG)
            spread = run.covariance(RAD_PER_METRE, WRONG)
            if len(spread) == 1:
                beyond = run.turned - 2 * math.pi * run.turns + luck.gauss(0, math.sqrt(spread[0, 0]))
                aside = run.marks.apart * math.sin(beyond)
                made.append(run._replace(tape=Tape(aside, 0.0)))
            else:
                first = luck.gauss(0, math.sqrt(spread[0, 0]))
                rest = spread[1, 1] - spread[0, 1] ** 2 / spread[0, 0]
                second = spread[0, 1] / spread[0, 0] * first + luck.gauss(0, math.sqrt(rest))
                made.append(run._replace(tape=Tape(run.tape.first + first, run.tape.second + second)))
        found = estimate(made, RAD_PER_METRE)
        off += [(value - true) / sure for value, true, sure in zip(found.factors, WRONG, found.deviations)]
        assert found.misfit < 2.5
    assert 0.7 < math.sqrt(sum(each ** 2 for each in off) / len(off)) < 1.2


def test_runs_that_contradict_each_other_are_refused_and_the_worst_is_named():
    made = runs()
    made[4] = run_of(ALL[4], WRONG._replace(turn=WRONG.turn * 0.96))
    with pytest.raises(CalibrationError) as error:
        check(made, RAD_PER_METRE)
    assert "cannot be calibrated: its runs differ" in str(error.value)
    assert "run 5 (5 turns on the spot to the left)" in str(error.value)


@pytest.mark.parametrize("factors, reason", [
    (Factors(1.2, 1.0, 0.0), "drives 20.0 % farther"), (Factors(0.8, 1.0, 0.0), "drives -20.0 % farther"),
    (Factors(1.0, 1.0, 0.45), "bends by 2")])
def test_wheels_that_no_tyre_makes_so_wrong_are_refused(factors, reason):
    with pytest.raises(CalibrationError) as error:
        check(runs(factors, [line(5.0)] * 3), RAD_PER_METRE)
    assert reason in str(error.value) and "Look for a wheel that slips" in str(error.value)


def test_a_robot_that_errs_the_same_way_each_time_is_not_refused():
    assert check(runs(), RAD_PER_METRE).factors == estimate(runs(), RAD_PER_METRE).factors


def test_a_reading_that_does_not_fit_is_strange():
    made = runs(planned=plan_of(repeats=1).runs)
    fits, slip_of_the_pen = run_of(line(5.0), WRONG), run_of(line(5.0), WRONG, off=(0.1, 0.0))
    assert strangeness(fits, made, RAD_PER_METRE) < 1.0
    assert strangeness(slip_of_the_pen, made, RAD_PER_METRE) > STRANGE
    assert strangeness(slip_of_the_pen, (), RAD_PER_METRE) < STRANGE      # nothing is known yet
