"""Sonar to messages: the readings of each transducer as array, ranges and points, and the frames of the messages."""

import dataclasses
import math
import struct

import pytest

from pioneer_control import standard_messages
from pioneer_control.client import SonarRange
from pioneer_control.driver import conversions
from pioneer_control.robots import find_model
from sensor_msgs.msg import Range
from sensor_msgs.point_cloud2 import read_points

from robot_reports import DRIVING, OLD, STAMP, STATE, identity_of, sonar_array_of, state_of

SONAR = find_model("p3dx-sh").sonar
STANDING = dataclasses.replace(STATE, linear=0.0, angular=0.0)


def heard(state=STANDING, **readings):
    """Return the state with these readings, s3=(range, age) for transducer 3."""
    sonar = [None] * 16
    for name, (distance, age) in readings.items():
        sonar[int(name[1:])] = SonarRange(distance, state.time - age)
    return dataclasses.replace(state, sonar=tuple(sonar))


def points(state):
    return list(read_points(conversions.sonar_points(state, STAMP, "base_link", SONAR)))


def test_the_array_expires_to_zero_and_ends_at_no_echo():
    message = sonar_array_of(STATE)
    assert list(message.ranges) == [1.5, 5.0, 0.0, 0.0, 5.0], "heard, no echo, too old, never heard, beyond"
    assert (message.ranges_count, message.header.stamp, message.header.frame_id) == (5, STAMP, "base_link")


def test_ranges_are_those_of_this_packet_only():
    first, second = conversions.sonar_ranges(state_of(DRIVING), STAMP, "two/", math.inf)
    assert (first.header.frame_id, second.header.frame_id) == ("two/sonar_3", "two/sonar_4")
    assert (first.range, second.range) == (1.5, 2.2) and first.header.stamp == second.header.stamp == STAMP
    assert (first.radiation_type, first.min_range, first.max_range) == (Range.ULTRASOUND, 0.1, 5.0)
    assert math.degrees(first.field_of_view) == pytest.approx(25)


def test_a_packet_without_sonar_makes_no_ranges():
    assert conversions.sonar_ranges(state_of(OLD, identity_of("p2dx")), STAMP, "", math.inf) == []
    assert conversions.sonar_ranges(heard(s3=(1.0, 0.1)), STAMP, "", math.inf) == [], "heard before"


@pytest.mark.parametrize("distance, no_echo, expected", [
    (4.999, math.inf, 4.999), (5.0, math.inf, math.inf), (5.4, math.inf, math.inf), (5.0, 5.0, 5.0), (5.4, 5.0, 5.0),
    (0.1, math.inf, 0.1), (0.0, math.inf, 0.1),
])
def test_no_echo_is_infinite_or_the_maximum_and_nothing_is_below_the_minimum(distance, no_echo, expected):
    message, = conversions.sonar_ranges(heard(s0=(distance, 0.0)), STAMP, "", no_echo)
    assert message.range == expected


def test_points_lie_where_the_echoes_came_from():
    found = points(heard(s3=(2.0, 0.0), s7=(1.0, 0.3)))
    ahead, left = 2 * math.cos(math.radians(10)), 2 * math.sin(math.radians(10))
    assert found[0] == pytest.approx((0.166 + ahead, 0.027 + left, 0.17))
    assert found[1] == pytest.approx((0.069, -0.136 - 1.0, 0.17), abs=1e-6)
    assert len(found) == 2


def test_what_is_not_in_sight_or_no_longer_heard_is_no_point():
    assert points(heard(s0=(5.0, 0.0), s1=(5.4, 0.0), s2=(1.0, 2.1))) == []
    cloud = conversions.sonar_points(heard(), STAMP, "base_link", SONAR)
    assert (cloud.width, cloud.height, cloud.row_step, bytes(cloud.data)) == (0, 1, 0, b"")


def test_the_cloud_is_laid_out_as_it_says():
    cloud = conversions.sonar_points(heard(s7=(1.0, 0.0), s8=(1.0, 0.0)), STAMP, "two/base_link", SONAR)
    assert (cloud.header.stamp, cloud.header.frame_id) == (STAMP, "two/base_link")
    fields = [(field.name, field.offset, field.datatype, field.count) for field in cloud.fields]
    assert fields == [("x", 0, 7, 1), ("y", 4, 7, 1), ("z", 8, 7, 1)]
    assert (cloud.width, cloud.height, cloud.point_step, cloud.row_step) == (2, 1, 12, 24)
    assert (cloud.is_dense, cloud.is_bigendian) == (True, False)
    assert struct.unpack("<6f", cloud.data)[::3] == pytest.approx((0.069, -0.157))


@pytest.mark.parametrize("linear, angular", [(0.5, 0.0), (-0.3, 0.0), (0.0, 1.5), (0.4, -1.0)])
def test_an_older_echo_stays_in_the_world_while_the_robot_goes_on(linear, angular):
    """The place of a pole is calculated from the circle that the robot drives."""
    age, steps = 0.3, 10000
    x = y = heading = 0.0
    for _ in range(steps):
        heading += angular * age / steps
        x, y = x + linear * age / steps * math.cos(heading), y + linear * age / steps * math.sin(heading)
    pole = (0.166 + 2 * math.cos(math.radians(10)), 0.027 + 2 * math.sin(math.radians(10)))
    ahead, left = pole[0] - x, pole[1] - y
    expected = (
        math.cos(heading) * ahead + math.sin(heading) * left,
        math.cos(heading) * left - math.sin(heading) * ahead)
    (found,) = points(heard(dataclasses.replace(STATE, linear=linear, angular=angular), s3=(2.0, age)))
    assert found[:2] == pytest.approx(expected, abs=1e-3)


def test_every_transducer_has_a_frame_that_looks_along_its_axis():
    message = standard_messages.sonar_frames(SONAR, STAMP, "two/base_link", "two/")
    children = [transform.child_frame_id for transform in message.transforms]
    assert children == ["two/sonar_%d" % number for number in range(16)]
    assert {transform.header.frame_id for transform in message.transforms} == {"two/base_link"}
    second = message.transforms[1].transform
    assert (second.translation.x, second.translation.y, second.translation.z) == (0.114, 0.119, 0.17)
    assert math.degrees(2 * math.atan2(second.rotation.z, second.rotation.w)) == pytest.approx(50)


def test_frames_keep_the_numbers_of_the_wire_where_some_are_missing():
    message = standard_messages.sonar_frames(find_model("powerbot-sh").sonar, STAMP, "b", "")
    frames = {transform.child_frame_id for transform in message.transforms}
    assert "sonar_6" in frames and "sonar_7" not in frames and "sonar_8" in frames
