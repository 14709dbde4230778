"""The distance between two tracks whose deviation is known."""

import math

import numpy as np
import pytest

import run_factory as make
from pioneer_control.bags.compare import deviation, driven, first_movement, from_its_start, pushes, standing
from pioneer_control.bags.recorded_run import CanPath, GripperEvent, Track


def track(*rows):
    """Return a track from rows of (s, m, m, rad)."""
    return Track(*np.array(rows, dtype=float).T)


def straight(seconds=10.0, speed=0.2, veer=0.0, rest=0.0, step=0.1):
    """Return the track of a robot that stands for ``rest`` seconds and then drives for ``seconds``. It drives at an
    angle of ``veer`` rad to its heading, which stays 0.
    """
    time = np.arange(0.0, rest + seconds + step / 2, step)
    way = speed * np.clip(time - rest, 0.0, None)
    return Track(time, way * math.cos(veer), way * math.sin(veer), np.zeros_like(time))


def test_a_track_does_not_deviate_from_itself():
    assert deviation(straight(), straight()) == pytest.approx((0.0, 0.0, 0.0, 0.0))


def test_neither_place_nor_heading_nor_the_recorders_start_count():
    other = straight(rest=3.0).seen_from((5.0, -2.0, 2.5))
    other = other._replace(time=other.time + 1e9)
    assert deviation(straight(), other) == pytest.approx((0.0, 0.0, 0.0, 0.0), abs=1e-6)


def test_one_that_veers():
    apart = 2 * 2.0 * math.sin(0.1 / 2)
    found = deviation(straight(), straight(veer=0.1))
    assert found.maximum == found.at_end == pytest.approx(apart, rel=1e-6)
    assert found.mean == pytest.approx(apart / 2, rel=0.01)
    assert found.turn_at_end == 0.0


def test_one_that_ends_sooner_stands_there():
    found = deviation(straight(10.0), straight(5.0))
    assert found.at_end == found.maximum == pytest.approx(1.0)
    assert found.mean == pytest.approx(0.25, rel=0.01)
    assert deviation(straight(5.0), straight(10.0)) == pytest.approx(found)


def test_far_apart_and_back_again():
    there = track((0, 0, 0, 0), (1, 1, 0, 0), (3, 1, 0, 0))
    detour = track((0, 0, 0, 0), (1, 1, 0, 0), (2, 1, 0.5, 0), (3, 1, 0, 0))
    found = deviation(there, detour)
    assert (found.maximum, found.at_end) == pytest.approx((0.5, 0.0)) and found.mean == pytest.approx(0.5 / 2.99)


@pytest.mark.parametrize("end, turn", [(0.5, 0.5), (-0.5, -0.5), (2 * math.pi + 0.5, 0.5), (4.0, 4.0 - 2 * math.pi)])
def test_turn_at_the_end(end, turn):
    turning = track((0, 0, 0, 0), (1, 1, 0, 0), (2, 1, 0, end))
    assert deviation(track((0, 0, 0, 0), (1, 1, 0, 0), (2, 1, 0, 0)), turning).turn_at_end == pytest.approx(turn)


def test_the_clock_begins_between_two_poses():
    assert first_movement(track((10, 0, 0, 0), (11, 0, 0, 0), (12, 0.02, 0, 0))) == pytest.approx(11.5)
    assert first_movement(track((10, 0, 0, 0), (11, 0, 0, math.radians(-4)))) == pytest.approx(10.25)


@pytest.mark.parametrize("still", [track((7, 1, 2, 3)), track((7, 1, 2, 3), (9, 1.009, 2, 3))])
def test_robots_that_stay(still):
    assert first_movement(still) == 7.0
    assert from_its_start(still).pose(0) == pytest.approx((0.0, 0.0, 0.0))
    assert deviation(still, still) == (0.0, 0.0, 0.0, 0.0)
    assert deviation(straight(), still).at_end == pytest.approx(2.0, abs=0.01)


def drives(*legs, step=0.1):
    """Return the track of a robot that drives for some seconds at some m/s, for each leg. At 0 m/s it stands."""
    speeds = np.concatenate([np.full(round(seconds / step), float(speed)) for seconds, speed in legs])
    x = np.concatenate(([0.0], np.cumsum(speeds * step)))
    return Track(100.0 + step * np.arange(len(x)), x, np.zeros_like(x), np.zeros_like(x))


class TestDriven:
    def test_a_robot_that_stops_on_its_way(self):
        found = driven(drives((3, 0), (5, 0.2), (2, 0), (5, 0.2), (4, 0)))
        assert found == pytest.approx((12.0, 2.0, 2.0 / 12.0, 1))

    def test_what_is_no_stop(self):
        assert driven(drives((5, 0.2), (0.3, 0), (5, 0.2))).stops == 0
        turning = drives((5, 0.2), (2, 0), (5, 0.2))
        turning = turning._replace(heading=0.4 * np.clip(turning.time - 105.0, 0.0, 2.0))
        assert driven(turning).stops == 0

    def test_one_that_never_moves(self):
        assert driven(drives((5, 0))) == (0.0, 0.0, 0.0, 0)

    def test_a_single_pose(self):
        assert driven(track((7, 1, 2, 3))) == (0.0, 0.0, 0.0, 0)

    def test_a_pause_between_two_poses_far_apart(self):
        assert standing(track((0, 0, 0, 0), (1, 0.2, 0, 0), (9, 0.21, 0, 0), (10, 0.41, 0, 0))) == [(1.0, 9.0)]


class TestPushes:
    """In a simulated world it is known where each can is."""

    def pushes(self, *cans, **fields):
        track = make.track(20.0, bend=0.0)  # 0.2 m/s along x
        paths = tuple(CanPath(make.BEGIN + np.array(time), *(np.array(each, dtype=float) for each in path))
                      for time, *path in cans)
        found = pushes(make.run(track, truth=track, cans=paths, **fields))
        return [(push.can, round(push.time - make.BEGIN, 3), round(push.distance, 3)) for push in found]

    def test_one_that_moves_is_pushed(self):
        assert self.pushes(((0, 5, 5.1, 5.2), (1, 1, 1.1, 1.2), (2, 2, 2, 2), (0, 0, 0, 0))) == [(1, 5.0, 0.2)]

    def test_each_push_and_each_can(self):
        twice = (0, 5, 5.1, 9, 9.1), (1, 1, 1.1, 1.1, 1.3), (0,) * 5, (0,) * 5
        assert self.pushes(twice, ((0, 1), (3, 3.5), (0, 0), (0, 0))) == [(2, 0.0, 0.5), (1, 5.0, 0.1), (1, 9.0, 0.2)]

    def test_a_nudge_is_none(self):
        assert self.pushes(((0, 5, 5.1), (1, 1, 1.04), (0, 0, 0), (0, 0, 0))) == []

    def test_one_that_is_carried_is_none(self):
        assert self.pushes(((0, 5, 5.1), (1, 1, 1.5), (0, 0, 0), (0.1, 0.1, 0.1))) == []

    def test_one_that_the_gripper_holds_is_none_and_another_one_is(self):
        """It is lifted a moment after the paddles hold it. One that stands between them is not held."""
        time = (0, 10, 11, 12, 13)
        ahead = [0.2 * second + 0.31 for second in (10, 10, 11, 12, 13)]    # between the paddles
        events = (GripperEvent(make.BEGIN + 9.5, "picked up"),)
        lifted, low = (time, ahead, (0,) * 5, (0, 0, 0, 0, 0.1)), (time, ahead, (0,) * 5, (0,) * 5)
        elsewhere = (time, (5, 5, 5.2, 5.4, 5.4), (1,) * 5, (0,) * 5)
        assert self.pushes(lifted, elsewhere, low, gripper=events) == [(2, 10.0, 0.4), (3, 10.0, 0.6)]
        assert self.pushes(low) == [(1, 10.0, 0.6)], "pushed by open paddles"

    def test_one_that_was_put_down_is_pushed_like_any_other(self):
        time, ahead = (0, 8, 10, 11, 12), [0.2 * second + 0.31 for second in (8, 8, 10, 11, 12)]
        events = (GripperEvent(make.BEGIN + 7.5, "picked up"), GripperEvent(make.BEGIN + 10.5, "put down"))
        can = (time, ahead, (0,) * 5, (0, 0.1, 0, 0, 0))
        assert self.pushes(can, gripper=events) == [(1, 10.0, 0.4)]

    def test_without_cans(self):
        assert self.pushes() == []
