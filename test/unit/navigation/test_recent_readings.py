"""Readings with the place of their sensor: the newest are kept, and each is where its sensor was when it fired."""

import math

import numpy as np
import pytest

from pioneer_control.floor_poses import Pose
from pioneer_control.navigation.measurement import Beams
from pioneer_control.navigation.recent_readings import FiringPoses, RecentReadings
from pioneer_control.navigation.values import Firing, Sensing
from pioneer_control.robots import Transducer


def readings(*numbers):
    """Readings of a sensor 0.1 m before the robot that looks to its left; `numbers` are their range numbers."""
    ones = np.ones(len(numbers))
    return Beams(0.1 * ones, 0.0 * ones, math.pi / 2 * ones, np.array(numbers), np.array(numbers) + 100)


def test_the_newest_readings_stay_in_their_order_while_the_rows_are_copied_down():
    recent, added = RecentReadings(5), []
    for number in range(40):
        some = list(range(len(added), len(added) + 1 + number % 3))
        recent.add(Pose(float(number), 0.0, 0.0), readings(*some))
        added += some
        seen = recent.seen_from(Pose(0.0, 0.0, 0.0))
        assert seen.measured.tolist() == added[-5:]
        assert seen.sensor.tolist() == [each + 100 for each in added[-5:]]
        assert (len(recent), recent.heard) == (min(5, len(added)), len(added))
        assert seen.x[-1] == pytest.approx(number + 0.1)


def test_readings_are_relative_to_where_the_robot_is_now():
    recent = RecentReadings(5)
    recent.add(Pose(1.0, 2.0, math.pi / 2), readings(7))
    seen = recent.seen_from(Pose(1.0, 1.1, 0.0))
    assert (seen.x[0], seen.y[0], seen.heading[0]) == pytest.approx((0.0, 1.0, math.pi))


def test_some_of_the_newest_can_be_kept_and_all_forgotten():
    recent = RecentReadings(5)
    recent.add(Pose(0.0, 0.0, 0.0), readings(1, 2, 3))
    recent.keep(2)
    assert recent.seen_from(Pose(0.0, 0.0, 0.0)).measured.tolist() == [2, 3]
    recent.add(Pose(0.0, 0.0, 0.0), readings(4))
    assert recent.seen_from(Pose(0.0, 0.0, 0.0)).measured.tolist() == [2, 3, 4]
    recent.forget()
    assert len(recent) == 0 and recent.heard == 4


@pytest.mark.parametrize("most, kept", [(2, [3, 4]), (9, [2, 3, 4])])
def test_those_that_came_after_a_mark_can_be_kept(most, kept):
    recent, here = RecentReadings(5), Pose(0.0, 0.0, 0.0)
    recent.add(here, readings(1))
    recent.mark()
    recent.add(here, readings(2, 3, 4))
    recent.keep_marked(most)
    assert recent.seen_from(here).measured.tolist() == kept


# --- FiringPoses ---

FRONT = Transducer(3, 0.2, 0.0, 0.0)


def placed(packets):
    """The beams of packets: each is a time, an odometry, and the times of its firings of the transducer 3."""
    poses = FiringPoses([FRONT])
    for time, odometry, fired in packets:
        poses.add(Sensing(time, odometry, tuple(Firing(3, 1.0, each) for each in fired)))
    return poses.beams(np.array)


@pytest.mark.parametrize("fired, x", [
    (1.1, 0.2), (1.05, 0.15), (1.0, 0.1), (0.975, 0.05),    # between packets, also before the last but one
    (0.5, 0.0), (1.2, 0.2),                                 # older than all that is kept; newer than the packet
])
def test_a_sensor_was_where_the_odometry_between_two_packets_says(fired, x):
    beams = placed([(0.95, Pose(0.0, 0.0, 0.0), []), (1.0, Pose(0.1, 0.0, 0.0), []),
                    (1.1, Pose(0.2, 0.0, 0.0), [fired])])
    assert beams.x[0] == pytest.approx(x - 0.2 + FRONT.x)
    assert (beams.y[0], beams.heading[0], beams.sensor[0]) == pytest.approx((0.0, 0.0, 3))


def test_a_sensor_was_where_the_turn_between_two_packets_says():
    beams = placed([(1.0, Pose(0.0, 0.0, 0.0), []), (1.1, Pose(0.0, 0.0, 0.4), [1.075])])
    assert (beams.x[0], beams.y[0]) == pytest.approx((0.2 * math.cos(-0.1), 0.2 * math.sin(-0.1)))
    assert beams.heading[0] == pytest.approx(-0.1)


def test_firings_are_told_once_and_those_of_unknown_sensors_never():
    poses = FiringPoses([FRONT])
    poses.add(Sensing(1.0, Pose(0.0, 0.0, 0.0), (Firing(3, 1.0, 1.0), Firing(4, 1.0, 1.0))))
    assert poses.beams(np.array).sensor.tolist() == [3]
    assert poses.beams(np.array).sensor.tolist() == []


def test_two_packets_of_the_same_time_divide_by_no_zero():
    beams = placed([(1.0, Pose(0.0, 0.0, 0.0), []), (1.0, Pose(0.1, 0.0, 0.0), [1.0])])
    assert beams.x[0] == pytest.approx(FRONT.x)
