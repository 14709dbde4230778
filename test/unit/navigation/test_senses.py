"""What was sensed, from the topics of a robot: which ranges are new, and where the robot was."""

import math

import pytest

from pioneer_control.floor_poses import Pose, relative
from pioneer_control.navigation.senses import FiringWatch, Senses
from pioneer_control.navigation.values import LaserSweep


def numbers_of(firings):
    return [number for number, _ in firings]


@pytest.fixture
def watch():
    watch = FiringWatch(range(8))
    assert numbers_of(watch.new(0.0, [1.0] * 8)) == list(range(8))
    return watch


def ranges(**changed):
    return [changed.get("s%d" % number, 1.0) for number in range(8)]


def test_what_has_changed_is_new(watch):
    assert watch.new(0.1, ranges(s0=1.1, s1=1.2)) == [(0, 1.1), (1, 1.2)]
    assert numbers_of(watch.new(0.2, ranges(s0=1.1, s1=1.2, s2=1.3, s3=1.3, s4=1.3))) == [2, 3, 4]


def test_one_that_heard_the_same_again_lies_between_new_ones(watch):
    watch.new(0.1, ranges(s0=1.1, s1=1.2))
    assert watch.new(0.2, ranges(s0=1.1, s1=1.2, s4=1.3)) == [(2, 1.0), (3, 1.0), (4, 1.3)]


def test_where_nothing_changes_the_sequence_goes_on(watch):
    watch.new(0.08, ranges(s0=1.1, s1=1.2))
    assert numbers_of(watch.new(0.16, ranges(s0=1.1, s1=1.2))) == [2, 3]
    assert numbers_of(watch.new(0.28, ranges(s0=1.1, s1=1.2))) == [4, 5, 6]


def test_a_round_begins_again_after_the_last_transducer(watch):
    for step in range(1, 5):
        newest = ranges(**{"s%d" % number: 1.0 + step for number in range(2 * step)})
        watch.new(0.08 * step, newest)
    assert numbers_of(watch.new(0.40, [9.0] + newest[1:])) == [0]


def test_a_sequence_of_the_users_own_gives_what_has_changed(watch):
    watch.new(0.08, ranges(s0=1.1, s1=1.2))
    assert numbers_of(watch.new(0.16, ranges(s0=1.1, s1=1.2, s7=2.0))) == [7]


def test_after_a_gap_all_that_is_heard_counts_once(watch):
    assert numbers_of(watch.new(60.0, ranges())) == list(range(8))
    assert numbers_of(watch.new(1.0, ranges())) == list(range(8)), "time has jumped back"


def test_transducers_that_are_not_heard_yet_say_nothing():
    watch = FiringWatch([0, 1, 8, 9])
    assert watch.new(0.0, [1.0, 0.0] + [0.0] * 6 + [2.0, 0.0]) == [(0, 1.0), (8, 2.0)]
    assert watch.new(0.1, [1.0]) == [(0, 1.0)], "a message that is too short"


def test_a_sonar_message_waits_for_its_pose():
    senses = Senses(range(8))
    assert senses.hear_sonar(1.0, [2.0] * 8) == []
    sensing, = senses.hear_pose(1.0, Pose(3.0, 4.0, 0.5))
    assert (sensing.time, sensing.odometry) == (1.0, (3.0, 4.0, 0.5)) and len(sensing.firings) == 8
    assert senses.hear_pose(1.1, Pose(3.1, 4.0, 0.5)) == []
    sensing, = senses.hear_sonar(1.1, [2.1] * 8)
    assert sensing.odometry.x == 3.1


def test_a_pose_between_two_is_on_the_way_from_one_to_the_other():
    senses = Senses(range(8))
    senses.hear_pose(1.0, Pose(0.0, 0.0, math.pi - 0.1))
    senses.hear_sonar(1.05, [2.0] * 8)
    sensing, = senses.hear_pose(1.1, Pose(-0.1, 0.0, -math.pi + 0.1))
    assert sensing.odometry == pytest.approx((-0.05, 0.0, math.pi)) or sensing.odometry == pytest.approx(
        (-0.05, 0.0, -math.pi))


def test_when_time_jumps_back_nothing_old_is_joined():
    senses = Senses(range(8))
    senses.hear_pose(100.0, Pose(9.0, 9.0, 0.0))
    assert senses.hear_pose(1.0, Pose(0.0, 0.0, 0.0)) == []
    sensing, = senses.hear_sonar(1.0, [2.0] * 8)
    assert relative(sensing.origin, sensing.odometry) == pytest.approx((0.0, 0.0, 0.0))


def test_while_time_stands_nothing_is_sensed():
    senses = Senses(range(8))
    senses.hear_pose(1.0, Pose(0.0, 0.0, 0.0))
    assert len(senses.hear_sonar(1.0, [2.0] * 8)) == 1
    for jitter in (0.0, -0.03, 0.005):
        senses.hear_pose(1.0 + jitter, Pose(0.1, 0.0, 0.0))
        assert senses.hear_sonar(1.0 + jitter, [1.9] * 8) == []
    senses.hear_pose(1.1, Pose(0.2, 0.0, 0.0))
    assert len(senses.hear_sonar(1.1, [1.8] * 8)) == 1


def test_when_odometry_is_reset_the_pose_does_not_jump_and_tells_what_the_wheels_say():
    senses, sensed = Senses(range(8)), []
    for number in range(10):
        x = 0.04 * number + (7.0 if number < 5 else 0.0)
        sensed += senses.hear_pose(0.1 * number, Pose(x, 0.0, 0.0)) + senses.hear_sonar(0.1 * number, [1.0] * 8)
    assert [each.odometry.x for each in sensed] == pytest.approx([7.0 + 0.04 * number for number in range(10)])
    assert [each.odometry.x - each.origin.x for each in sensed[4:6]] == pytest.approx([7.16, 0.2])


def test_a_robot_that_still_rolls_while_time_stands_does_not_jump():
    """The clock of a simulation may stand before the robot does: it drove 0.3 m at the same stamp."""
    senses = Senses(range(8))
    senses.hear_pose(5.0, Pose(0.0, 0.0, 0.0))
    for number in range(10):
        senses.hear_pose(5.1, Pose(0.03 * number, 0.0, 0.0))
    senses.hear_pose(5.2, Pose(0.3, 0.0, 0.0))
    sensing, = senses.hear_sonar(5.2, [1.0] * 8)
    assert sensing.odometry == Pose(0.3, 0.0, 0.0) and sensing.origin == Pose(0.0, 0.0, 0.0)


# Scans of a laser

def sweep(time, duration=0.0):
    """A scan whose ranges tell its time."""
    return LaserSweep(time, duration, Pose(0.1, 0.0, 0.0), -1.0, 1.0, [time] * 3)


def packet(senses, time, pose):
    """Return what is sensed in a packet with a pose and sonar."""
    senses.hear_sonar(time, [1.0, 1.0])
    return senses.hear_pose(time, pose)[0]


@pytest.fixture
def senses():
    senses = Senses([0, 1])
    assert packet(senses, 10.0, Pose(0.0, 0.0, 0.0)).scan is None
    return senses


def test_a_packet_has_the_newest_scan_of_before_it_and_the_pose_of_its_time(senses):
    for time in (10.02, 10.05, 10.08, 10.11):
        senses.hear_sweep(sweep(time))
    scan = packet(senses, 10.1, Pose(0.1, 0.0, 0.2)).scan
    assert scan.ranges == [10.08] * 3 and scan.time == pytest.approx(10.08)
    assert scan.odometry == pytest.approx((0.08, 0.0, 0.16)) and scan.motion == pytest.approx((0.0, 0.0, 0.0))
    assert packet(senses, 10.2, Pose(0.2, 0.0, 0.4)).scan.ranges == [10.11] * 3
    assert packet(senses, 10.3, Pose(0.3, 0.0, 0.6)).scan is None


def test_a_scan_that_takes_time_is_of_its_middle_and_says_how_the_robot_moved(senses):
    senses.hear_sweep(sweep(10.02, 0.04))
    scan = packet(senses, 10.1, Pose(0.1, 0.0, 0.0)).scan
    assert scan.time == pytest.approx(10.04) and scan.odometry == pytest.approx((0.04, 0.0, 0.0))
    assert scan.motion == pytest.approx((0.04, 0.0, 0.0))


def test_a_scan_that_has_not_ended_waits(senses):
    senses.hear_sweep(sweep(10.08, 0.04))
    assert packet(senses, 10.1, Pose(0.0, 0.0, 0.0)).scan is None
    assert packet(senses, 10.2, Pose(0.0, 0.0, 0.0)).scan is not None


def test_of_many_scans_only_some_are_wanted(senses):
    senses.hear_sweep(sweep(10.0))
    assert [senses.wants_sweep(10.0 + after) for after in (0.0, 0.01, 0.02, 0.026)] == [False, False, False, True]


def test_a_stale_scan_is_left_out_and_its_age_is_told(senses):
    assert senses.scan_age is None
    senses.hear_sweep(sweep(5.0))
    assert packet(senses, 10.1, Pose(0.0, 0.0, 0.0)).scan is None and senses.scan_age == pytest.approx(5.1)


def test_a_scan_of_another_clock_is_never_taken_and_its_age_is_told(senses):
    senses.hear_sweep(sweep(100.0))
    assert packet(senses, 10.1, Pose(0.0, 0.0, 0.0)).scan is None and senses.scan_age == pytest.approx(-89.9)


def test_when_its_time_jumps_back_scans_of_before_are_forgotten(senses):
    senses.hear_sweep(sweep(100.0))
    senses.hear_sweep(sweep(10.05))
    assert packet(senses, 10.1, Pose(0.0, 0.0, 0.0)).scan.ranges == [10.05] * 3


def test_a_scan_of_before_the_first_pose_is_left_out():
    senses = Senses([0, 1])
    senses.hear_sweep(sweep(9.9))
    assert packet(senses, 10.0, Pose(0.0, 0.0, 0.0)).scan is None
