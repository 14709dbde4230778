"""The runs in the poses of a recording."""

import math

import pytest

from made_runs import track_of
from pioneer_control.calibration.pieces import PoseOrRate, in_words, kind_of_track, pieces
from pioneer_control.calibration.plan import AheadLeg, TurnLeg, line, square, turns
from pioneer_control.calibration.runs import RunKind
from pioneer_control.floor_poses import Pose, compose


def recorded(*runs, rest=8.0, gyro=False):
    """Return the poses of runs, ten in a second, with a rest before, between and after them."""
    samples, time, pose = [], 100.0, Pose(3.0, -2.0, 1.0)

    def stand():
        nonlocal time
        for _ in range(round(rest * 10)):
            sample(0.0)

    def sample(turned):
        nonlocal time
        time += 0.1
        samples.append(PoseOrRate(time, pose))
        if gyro:
            samples.append(PoseOrRate(time + 0.01, None, turned / 0.1))

    stand()
    for run in runs:
        track = track_of(run)
        for ahead, turned in zip(track.ahead, track.turned):
            pose = compose(pose, Pose(ahead * math.cos(turned / 2), ahead * math.sin(turned / 2), turned))
            sample(turned)
        stand()
    return samples


PUSHED = (AheadLeg(0.3), TurnLeg(1.0), AheadLeg(0.2))


def test_runs_are_found_between_rests_and_what_is_none_is_left_out():
    found = list(pieces(recorded(turns(2).legs, PUSHED, line(5.0).legs, square(1.0, -1).legs, turns(-1).legs)))
    assert [(each.kind, each.turns) for each in found] == [
        (RunKind.TURN, 2), (RunKind.LINE, 0), (RunKind.SQUARE, -1), (RunKind.TURN, -1)]
    assert found[0].track.turn == pytest.approx(4 * math.pi) and found[1].track.way == pytest.approx(5.0)
    assert found[0].begin == pytest.approx(8.0, abs=0.2)
    assert in_words(found[1]).endswith(": 5.00 m, 0 degrees by odometry")


def test_a_gyro_between_the_poses_costs_no_step():
    found = list(pieces(recorded(turns(1).legs, line(2.0).legs, gyro=True)))
    assert [each.kind for each in found] == [RunKind.TURN, RunKind.LINE]
    assert found[0].track.turn == pytest.approx(2 * math.pi) and found[0].track.gyro == pytest.approx(2 * math.pi)


def test_a_short_rest_ends_no_run():
    assert [each.turns for each in pieces(recorded(turns(1).legs, turns(1).legs, rest=4.0))] == [2]


@pytest.mark.parametrize("legs", [
    (AheadLeg(0.8),), (TurnLeg(4.0),), (AheadLeg(3.0), AheadLeg(-3.0)), (AheadLeg(2.0), TurnLeg(1.0), AheadLeg(2.0)),
    (TurnLeg(2 * math.pi), AheadLeg(0.5))])
def test_what_is_no_run(legs):
    assert kind_of_track(track_of(legs)) is None and list(pieces(recorded(legs))) == []


def test_a_line_backwards_is_no_line_ahead_but_one_all_the_same():
    assert kind_of_track(track_of((AheadLeg(-3.0),))) == (RunKind.LINE, 0)


def test_a_line_that_is_steered_to_and_fro_is_a_line():
    wiggling = (AheadLeg(0.1), TurnLeg(0.05), AheadLeg(0.1), TurnLeg(-0.05)) * 25
    assert kind_of_track(track_of(wiggling)) == (RunKind.LINE, 0)


def test_a_run_in_which_odometry_jumps_is_left_out():
    samples = recorded(line(5.0).legs, line(3.0).legs)
    jumped = [each._replace(pose=Pose(0.0, 0.0, 0.0)) if number == 120 else each for number, each in enumerate(samples)]
    assert [each.track.way for each in pieces(jumped)] == pytest.approx([3.0])


def test_an_empty_recording():
    assert list(pieces([])) == []
