"""15-bit counts become an exact pose (protocol sheet 4.3)."""

import math

import pytest

from pioneer_control.client.odometry import Odometry
from pioneer_control.p2os import wrapped


@pytest.mark.parametrize("before, after, step", [
    (32760, 8, 16), (5, 32763, -10), (0, 0xFFC8, -56), (0, 0x7FC8, -56), (0, 0x3FFF, 0x3FFF), (0, 0x4000, -0x4000)])
def test_steps_across_the_wrap(before, after, step):
    odometry = Odometry(1.0, 4096)
    odometry.update(before, 0, 0)
    odometry.update(after, 0, 0)
    assert odometry.x_counts == step


def test_the_first_packet_is_no_motion():
    odometry = Odometry(1.0, 4096)
    odometry.update(1234, 30000, 512)
    assert odometry.pose == (0.0, 0.0, 0.0) and (odometry.x_counts, odometry.y_counts) == (0, 0)


@pytest.mark.parametrize("units", [4096, 1024])
@pytest.mark.parametrize("form", [
    lambda raw, full: raw % full, lambda raw, full: wrapped(raw, full), lambda raw, full: raw])
def test_a_heading_may_come_in_any_range(units, form):
    odometry = Odometry(1.0, units)
    for eighth in range(0, 25):
        odometry.update(0, 0, form(eighth * units // 8, units))
        turns = math.remainder(eighth * math.pi / 4, 2 * math.pi)
        assert abs(odometry.pose[2]) == pytest.approx(abs(turns)) and abs(odometry.pose[2]) <= math.pi
    assert odometry.heading_units == 3 * units


def test_a_thousand_small_steps_lose_nothing():
    odometry = Odometry(0.485, 4096)
    for counts in range(5001):
        odometry.update(counts, -counts, 0)
    assert odometry.pose[0] == pytest.approx(2.425, abs=1e-12) and odometry.pose[1] == pytest.approx(-2.425, abs=1e-12)


def test_reset_makes_here_and_now_the_origin_whatever_way_the_robot_looks():
    odometry = Odometry(1.0, 4096)
    odometry.update(0, 0, 0)
    odometry.update(2000, 1000, 1024)
    odometry.reset()
    assert odometry.pose == (0.0, 0.0, 0.0)
    odometry.update(2000, 1500, 1024)           # half a metre in the robot's y, which is straight ahead
    assert odometry.pose == pytest.approx((0.5, 0.0, 0.0))
    assert (odometry.x_counts, odometry.y_counts) == (2000, 1500)


def test_the_way_travelled_and_turned_is_summed_whatever_the_frame():
    odometry = Odometry(1.0, 4096)
    way = [(0, 0, 1024), (0, 300, 1024), (0, 200, 1024), (0, 200, 2048), (-500, 200, -2048), (-500, 200, 1024)]
    for x, y, heading in way:
        odometry.update(x, y, heading)
    odometry.reset()
    assert odometry.travel == pytest.approx(0.3 - 0.1 + 0.5) and odometry.turned == pytest.approx(0.0)
    odometry.rebase()
    odometry.update(9000, 9000, 0)              # a new frame is no way
    odometry.update(9100, 9000, 1024)           # a quarter turn along the chord
    assert odometry.travel == pytest.approx(0.7 + 0.1 * math.sqrt(0.5))
    assert odometry.turned == pytest.approx(math.pi / 2)


def test_a_circle_of_small_steps_is_as_long_as_it_is():
    odometry = Odometry(1.0, 4096)
    for step in range(1025):
        angle = step / 512 * math.pi
        odometry.update(round(1000 * math.sin(angle)), round(1000 - 1000 * math.cos(angle)), step * 4 % 4096)
    assert odometry.travel == pytest.approx(2 * math.pi, rel=1e-3) and odometry.turned == pytest.approx(2 * math.pi)


def test_reset_before_the_first_packet():
    odometry = Odometry(1.0, 4096)
    odometry.reset()
    odometry.update(7, 7, 7)
    assert odometry.pose == (0.0, 0.0, 0.0)


def test_after_a_reconnect_the_pose_goes_on_in_the_robots_new_frame():
    odometry = Odometry(1.0, 4096)
    odometry.update(0, 0, 0)
    odometry.update(3000, 0, 1024)
    odometry.rebase()
    odometry.update(40, 50, 0)                  # the robot calls its heading zero again
    assert odometry.pose == pytest.approx((3.0, 0.0, math.pi / 2))
    odometry.update(1040, 50, 0)
    assert odometry.pose == pytest.approx((3.0, 1.0, math.pi / 2))


def test_an_odometry_fits_robots_with_its_units_only():
    odometry = Odometry(0.485, 4096)
    assert odometry.fits(0.485, 4096) and not odometry.fits(1.0, 4096) and not odometry.fits(0.485, 1024)


def moved(*steps):
    """Return an odometry after SIPs every 0.1 s with these x, y (mm) and headings (units), and which SIPs it believed.
    """
    odometry = Odometry(1.0, 4096)
    return odometry, [odometry.update(*step, 0.1) for step in steps]


@pytest.mark.parametrize("wild", [(9000, 0, 0), (0, -9000, 0), (100, 0, 2000), (0x4000, 0, 0)])
def test_a_packet_that_would_have_the_robot_where_it_cannot_be_changes_nothing(wild):
    odometry, believed = moved((0, 0, 0), (100, 0, 0), wild, (200, 0, 0))
    assert believed == [True, True, False, True]
    assert odometry.pose == (0.2, 0.0, 0.0) and odometry.travel == pytest.approx(0.2) and odometry.turned == 0.0


def test_wild_packets_that_do_not_agree_are_all_not_believed():
    odometry, believed = moved((0, 0, 0), (9000, 0, 0), (-9000, 0, 0), (0, 5000, 0), (150, 0, 0))
    assert believed == [True, False, False, False, True] and odometry.pose == (0.15, 0.0, 0.0)


def test_a_robot_that_goes_on_counting_from_elsewhere_is_believed_and_its_pose_does_not_jump():
    odometry, believed = moved((0, 0, 0), (100, 0, 0), (9000, 0, 0), (9100, 0, 0), (9200, 0, 0))
    assert believed == [True, True, False, True, True]
    assert odometry.pose == pytest.approx((0.2, 0.0, 0.0)), "tied at the second of the two that agree"


def test_what_one_packet_too_many_said_is_not_held_for_long():
    odometry, believed = moved((0, 0, 0), (9000, 0, 0), (100, 0, 0), (9000, 0, 0), (200, 0, 0))
    assert believed == [True, False, True, False, True] and odometry.pose == (0.2, 0.0, 0.0)


@pytest.mark.parametrize("step, seconds", [
    ((300, 0, 0), 0.1), ((900, 0, 0), 0.1), ((9000, 0, 0), 2.0), ((0, 0, 1000), 0.2), ((400, 0, 200), 0.0)])
def test_what_a_robot_can_do_in_its_time_is_believed(step, seconds):
    odometry = Odometry(1.0, 4096)
    odometry.update(0, 0, 0)
    assert odometry.update(*step, seconds)
