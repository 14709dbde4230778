"""Tracks: where corrected odometry ends, by hand calculation."""

import math

import numpy as np
import pytest

from made_runs import RAD_PER_METRE, track_of
from pioneer_control.calibration.plan import AheadLeg, TurnLeg, square
from pioneer_control.calibration.tracks import Factors, OdometryTrack, TrackRecorder
from pioneer_control.errors import CalibrationError
from pioneer_control.floor_poses import Pose

SIDE = 2.0


def test_a_line_that_bends_is_an_arc():
    """5 m with 0.02 rad/m: an arc of 0.1 rad with radius 50 m."""
    end = track_of([AheadLeg(5.0)]).end(Factors(1.0, 1.0, 0.02))
    assert end == pytest.approx((50 * math.sin(0.1), 50 * (1 - math.cos(0.1)), 0.1), abs=1e-6)


def test_the_factors_scale_way_and_turn():
    assert track_of([AheadLeg(5.0)]).end(Factors(1.02)) == pytest.approx((5.1, 0.0, 0.0))
    assert track_of([TurnLeg(4 * math.pi)]).end(Factors(turn=1.05)).heading == pytest.approx(4.2 * math.pi)
    assert track_of([TurnLeg(4 * math.pi)]).scaled(2.0, 0.5).turn == pytest.approx(2 * math.pi)


@pytest.mark.parametrize("direction, at_corners, on_sides, x, y", [
    (1, 0.01, 0.0, 2, -2), (-1, 0.01, 0.0, 2, 2),      # corners that turn too far: the same x both ways
    (1, 0.0, 0.01, 2, -2), (-1, 0.0, 0.01, -2, -2)])   # sides that bend left: the opposite x
def test_a_square_both_ways_tells_corners_from_sides(direction, at_corners, on_sides, x, y):
    """By hand, for small angles: side k ends off by SIDE times its mean error of heading, square to it.

    The errors of heading are 0, 1, 2, 3 times that of a corner; of sides that bend 1/2, 3/2, 5/2, 7/2 times that of
    one.
    """
    factors = Factors(1.0, 1.0 + at_corners / (math.pi / 2), on_sides / SIDE)
    end = track_of(square(SIDE, direction).legs).end(factors)
    error = at_corners + on_sides
    assert (end.x, end.y) == pytest.approx((SIDE * error * x, SIDE * error * y), abs=0.003)


def test_chance_grows_with_the_root_of_the_way():
    """Each wheel is off by 4 mm after 1 m: after 4 m 8 mm, the middle of both 8 / sqrt(2) mm, and the heading

    8 mm / sqrt(2) * 5.6 rad/m. Aside, a random walk of the heading is off by way / sqrt(3) times the heading.
    """
    noise = track_of([AheadLeg(4.0)]).noise(0.004, RAD_PER_METRE, Factors())
    middle = 0.008 / math.sqrt(2)
    assert np.sqrt(np.diag(noise)) == pytest.approx(
        [middle, 4.0 / math.sqrt(3) * middle * RAD_PER_METRE, middle * RAD_PER_METRE], rel=0.01)


def test_a_turn_on_the_spot_rolls_both_wheels():
    noise = track_of([TurnLeg(2 * math.pi)]).noise(0.004, RAD_PER_METRE, Factors())
    rolled = 2 * math.pi / RAD_PER_METRE
    assert math.sqrt(noise[2, 2]) == pytest.approx(0.004 * math.sqrt(rolled / 2) * RAD_PER_METRE, rel=0.01)


def test_a_recorder_makes_steps_of_poses_and_sums_up_the_gyro():
    recorder = TrackRecorder()
    for pose in ((1.0, 2.0, math.pi / 2), (1.0, 2.5, math.pi / 2), (1.0, 2.5, math.pi / 2), (1.0, 2.25, math.pi / 2),
                 (1.0, 2.25, 2.6), (1.0, 2.25, -3.1), (1.0, 2.25, -2.0)):
        recorder.pose(Pose(*pose))
    for time, rate in ((1.0, 9.0), (1.5, 0.4), (1.5, 7.0), (2.0, -0.1)):
        recorder.rate(time, rate)
    track = recorder.track
    assert track.ahead == pytest.approx([0.5, -0.25, 0.0, 0.0, 0.0])
    assert track.way == pytest.approx(0.75)
    assert track.turn == pytest.approx(2 * math.pi - 2.0 - math.pi / 2)
    assert track.gyro == pytest.approx(0.15)


def test_without_a_gyro_there_is_none():
    assert TrackRecorder().track.gyro is None and OdometryTrack([], []).end() == (0, 0, 0)


@pytest.mark.parametrize("pose, reason", [
    (Pose(0, 1.1, 0), "jumped by 1.10 m and 0 degrees"), (Pose(0, 0, -2.0), "jumped by 0.00 m and -115 degrees"),
    (Pose(0, math.nan, 0), "that is no pose"), (Pose(0, 0, math.inf), "that is no pose")])
def test_odometry_that_jumps_is_refused(pose, reason):
    recorder = TrackRecorder()
    recorder.pose(Pose(0, 0, 0))
    with pytest.raises(CalibrationError, match=reason):
        recorder.pose(pose)


def test_a_turn_rate_that_is_none_is_refused():
    with pytest.raises(CalibrationError, match="the gyro says nan"):
        TrackRecorder().rate(1.0, math.nan)
