"""What the tape says, and what may be typed."""

import math

import pytest

from made_runs import MARKS, RAD_PER_METRE, WRONG, run_of
from pioneer_control.calibration.plan import LEGAL_LINE, line, plan_of, square, turns
from pioneer_control.calibration.runs import (RobotMarks, RunKind, Tape, TapedRun, check_turned, mark_of, name_of,
                                              tape_of, whole_turns)
from pioneer_control.calibration.tracks import Factors, OdometryTrack
from pioneer_control.errors import UsageError


@pytest.mark.parametrize("text, first, second", [
    ("498.3 -2.5", 4.983, -0.025), (" 498,3 ; -2,5 ", 4.983, -0.025), ("500 0", 5.0, 0.0),
    ("498.3,-2.5", 4.983, -0.025), ("2040 -400", 20.4, -4.0)])
def test_two_numbers_in_centimetres(text, first, second):
    assert tape_of(text, RunKind.LINE) == pytest.approx((first, second))


@pytest.mark.parametrize("kind, text, reason", [
    (RunKind.LINE, "", "'' is not two numbers in cm: ahead, left"),
    (RunKind.LINE, "500", "'500' is not two numbers"),
    (RunKind.LINE, "1 2 3", "'1 2 3' is not two numbers"),
    (RunKind.LINE, "500 nan", "left is 'nan': give a number from -3000 to 3000, in cm"),
    (RunKind.LINE, "inf 0", "ahead is 'inf': give a number from -3000 to 3000"),
    (RunKind.SQUARE, "5000 0", "ahead is '5000': give a number from -3000 to 3000"),
    (RunKind.TURN, "1 x", "rear mark left is 'x'"),
    (RunKind.LINE, "1e999 0", "ahead is '1e999'")])
def test_what_is_no_reading_is_refused(kind, text, reason):
    with pytest.raises(UsageError) as error:
        tape_of(text, kind)
    assert reason in str(error.value)


def test_marks_farther_apart_than_on_the_robot_are_refused():
    check_turned(Tape(0.25, -0.25), MARKS)
    with pytest.raises(UsageError, match="0.520 m from one to the other, but they are only 0.500 m apart"):
        check_turned(Tape(0.26, -0.26), MARKS)


def test_where_a_mark_is():
    assert mark_of(" ", "front", 0.21) == 0.21 and mark_of("20.5", "front", 0.21) == 0.205
    for text in ("0", "nan", "x", "1000", "-5"):
        with pytest.raises(UsageError, match="front is"):
            mark_of(text, "front", 0.21)


def test_how_many_turns():
    assert [whole_turns(text, 5) for text in ("", "-3", " 4 ")] == [5, -3, 4]
    for text in ("0", "2.5", "51", "many"):
        with pytest.raises(UsageError, match="turns is"):
            whole_turns(text, 5)


def test_a_turn_by_the_tape():
    """The front mark 4 cm left and the rear mark 6 cm right, 50 cm apart: asin(0.2) beyond the whole turns."""
    run = TapedRun(RunKind.TURN, -5, OdometryTrack([], []), Tape(0.04, -0.06), MARKS)
    assert run.turned == pytest.approx(-10 * math.pi + 0.2013579)
    assert run.name == "5 turns on the spot to the right"


def test_names():
    assert [name_of(*each) for each in ((RunKind.TURN, 1), (RunKind.LINE, 0), (RunKind.SQUARE, -1))] == [
        "1 turn on the spot to the left", "straight line", "square to the right"]


def test_the_front_mark_goes_with_the_heading():
    """A robot that only turned by 90 degrees: its mark, 0.2 m ahead, is 0.2 m back and 0.2 m left of where it was."""
    run = TapedRun(RunKind.LINE, 0, OdometryTrack([0.0], [math.pi / 2]), Tape(0, 0), MARKS)
    assert run.predicted(Factors()) == pytest.approx((-0.2, 0.2))


@pytest.mark.parametrize("planned", [line(5.0), turns(-5), square(2.0, 1)])
def test_the_true_factors_predict_the_tape(planned):
    run = run_of(planned, WRONG)
    assert run.predicted(WRONG) == pytest.approx(run.measured, abs=1e-9)
    assert run.predicted(Factors()) != pytest.approx(run.measured, abs=0.01)


def test_a_tape_near_a_right_angle_says_less():
    near = TapedRun(RunKind.TURN, 1, OdometryTrack([], []), Tape(0.0, 0.0), MARKS)
    far = near._replace(tape=Tape(0.24, -0.24))
    assert far.covariance(RAD_PER_METRE, Factors()) > 2 * near.covariance(RAD_PER_METRE, Factors())


def test_the_plan():
    plan = plan_of(5.0, 2.0, 2)
    assert [(run.kind, run.turns) for run in plan.runs][:4] == [(RunKind.TURN, each) for each in (1, -1, 5, -5)]
    assert sum(run.kind is RunKind.LINE for run in plan.runs) == 4
    assert [run.turns for run in plan.runs if run.kind is RunKind.SQUARE] == [1, -1, 1, -1]
    assert not any(run.kind is RunKind.SQUARE for run in plan_of(side=0.0).runs)
    assert LEGAL_LINE.low == 1.0 and RobotMarks._fields == ("front", "apart")


@pytest.mark.parametrize("given, reason", [
    (dict(way=0.5), "line is 0.5: give a number from 1 to 20"), (dict(way=math.nan), "line is nan"),
    (dict(side=11.0), "side is 11.0"), (dict(repeats=0), "repeats is 0: give a whole number from 1 to 10"),
    (dict(side=-1.0), "side is -1.0")])
def test_a_plan_that_is_not_legal(given, reason):
    with pytest.raises(UsageError) as error:
        plan_of(**given)
    assert reason in str(error.value)
