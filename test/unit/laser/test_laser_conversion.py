"""A scan as the numbers of a LaserScan, by golden numbers of the laser sheet (1.7, 1.8, 4.1)."""

import math

import numpy as np
import pytest

from pioneer_control import lms2xx
from pioneer_control.laser.conversation import LaserInfo
from pioneer_control.laser.conversion import BELOW_MAX, numbers_of
from pioneer_control.laser.session import ScanHeard


def heard(values=None, variant=(180, 100), baud=38400, unit=1, mode=0, **configuration):
    variant = lms2xx.Variant(*variant)
    values = (1000,) * variant.values if values is None else values
    info = LaserInfo("LMS200", variant, lms2xx.FACTORY.changed(measuring_mode=mode, unit=unit, **configuration), baud,
                     9600, ())
    return ScanHeard(lms2xx.RawScan(tuple(values), unit), info, 12.5, lms2xx.WELL)


@pytest.mark.parametrize("variant, first, last, step, count, increment", [
    ((180, 100), -90.0, 90.0, 1.0, 181, 3.7037e-5), ((180, 50), -90.0, 90.0, 0.5, 361, 0.0),
    ((100, 100), -50.0, 50.0, 1.0, 101, 3.7037e-5), ((100, 50), -50.0, 50.0, 0.5, 201, 0.0),
    ((100, 25), -50.0, 50.0, 0.25, 401, 0.0)])
def test_angles_and_times_of_each_variant(variant, first, last, step, count, increment):
    numbers = numbers_of(heard(variant=variant))
    angles = numbers.angle_min, numbers.angle_max, numbers.angle_increment
    assert [math.degrees(angle) for angle in angles] == pytest.approx([first, last, step])
    assert len(numbers.ranges) == count == 1 + round((last - first) / step)
    assert numbers.time_increment == pytest.approx(increment, rel=1e-4) and numbers.first_ray == 12.5
    assert len(numbers.intensities) == 0, "mode 0 tells no reflectors"


@pytest.mark.parametrize("variant, baud, rate", [
    ((180, 100), 38400, 75 / 8), ((180, 50), 38400, 37.5 / 8), ((180, 100), 500000, 75.0), ((180, 50), 500000, 37.5),
    ((100, 25), 500000, 18.75), ((180, 50), 9600, 37.5 / 29)])
def test_the_time_between_scans_is_what_the_line_allows(variant, baud, rate):
    assert 1.0 / numbers_of(heard(variant=variant, baud=baud)).scan_time == pytest.approx(rate)


def test_the_first_value_is_the_rightmost_ray():
    values = list(range(1000, 1181))
    numbers = numbers_of(heard(values))
    assert numbers.angle_min < 0.0 < numbers.angle_increment
    assert numbers.ranges[0] == pytest.approx(1.0) and numbers.ranges[180] == pytest.approx(1.18)
    assert numbers.ranges.dtype == np.float32


def test_a_laser_upside_down_is_turned_over():
    """Its first ray looks to the left of the robot. Angles stay counter-clockwise, and times are in no order."""
    numbers = numbers_of(heard(list(range(1000, 1181)), mode=1), inverted=True)
    assert numbers.ranges[0] == pytest.approx(1.18) and numbers.ranges[180] == pytest.approx(1.0)
    assert math.degrees(numbers.angle_min) == pytest.approx(-90.0) and numbers.angle_increment > 0.0
    assert numbers.time_increment == 0.0
    levels = numbers_of(heard([0xE000 + 1500] + [1500] * 180, mode=1), inverted=True).intensities
    assert levels[180] == 7.0 and levels[0] == 0.0


CODED = [8191, 8190, 8189, 8188, 8187, 8186, 8185, 8184, 8183, 8182, 0, 49]


def test_what_is_no_distance():
    numbers = numbers_of(heard(CODED + [1000] * 169))
    inf, nan = math.inf, math.nan
    assert numbers.ranges[:12].tolist() == pytest.approx(
        [inf, nan, nan, nan, nan, nan, nan, nan, inf, 8.182, 0.0, 0.049], nan_ok=True)
    assert numbers.range_min == 0.05 and numbers.range_max == pytest.approx(8.183)


def test_no_echo_as_a_number_for_gmapping():
    ranges = numbers_of(heard(CODED + [1000] * 169), no_echo_is_max=True).ranges
    assert ranges[0] == ranges[8] == pytest.approx(8.183 - BELOW_MAX)
    assert ranges[0] < 8.183 - 0.01, "gmapping takes no longer one"
    assert math.isnan(ranges[1]) and ranges[9] == pytest.approx(8.182)


@pytest.mark.parametrize("mode, unit, farthest", [
    (0, 1, 8.183), (0, 0, 81.83), (1, 1, 8.183), (3, 1, 16.375), (5, 1, 32.759), (5, 0, 327.59)])
def test_how_far_it_measures(mode, unit, farthest):
    assert numbers_of(heard(mode=mode, unit=unit)).range_max == pytest.approx(farthest)


def test_values_in_centimetres():
    assert numbers_of(heard([800] * 181, unit=0)).ranges[0] == pytest.approx(8.0)


@pytest.mark.parametrize("mode, value, metres, level", [
    (1, 0xE5DC, 1.5, 7.0), (1, 0x05DC, 1.5, 0.0), (3, 0xC5DC, 1.5, 3.0), (5, 0x85DC, 1.5, 1.0)])
def test_levels_of_reflectors_are_intensities(mode, value, metres, level):
    numbers = numbers_of(heard([value] * 181, mode=mode))
    assert len(numbers.intensities) == len(numbers.ranges)
    assert numbers.ranges[7] == pytest.approx(metres) and numbers.intensities[7] == level
