"""Values of navigation as ROS messages, and back."""

import math

import numpy as np
import pytest
from geometry_msgs.msg import Point, Quaternion, Transform, Vector3
from geometry_msgs.msg import Pose as PoseMessage
from rospy import Time
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Header
from tf.transformations import quaternion_from_euler

from pioneer_control.errors import UsageError
from pioneer_control.floor_poses import Pose
from pioneer_control.maps import FREE, OCCUPIED, UNKNOWN, GridMap
from pioneer_control.navigation.node.messages import (check_start, cloud_message, footprint_message, map_message,
                                                      mount_of, path_message, pose_message, pose_of,
                                                      pose_with_covariance, spread_of, sweep_of)

STAMP = Time(5)


def test_a_pose_comes_back_as_it_went():
    assert pose_of(pose_message(Pose(1.0, -2.0, 3.0))) == pytest.approx((1.0, -2.0, 3.0))


@pytest.mark.parametrize("turn, named", [
    ((0.0, 0.0, 0.0, 0.0), "unit quaternion"), ((0.0, 0.0, 2.0, 2.0), "length 2.83"),
    ((0.0, 0.0, math.nan, 1.0), "finite"), ((0.0, 0.0, 0.0, math.inf), "finite"),
    ((0.0, 0.0, 1e200, 0.0), "length 1e.200"),
])
def test_an_orientation_that_is_none_is_named(turn, named):
    with pytest.raises(UsageError, match=named):
        pose_of(PoseMessage(Point(), Quaternion(*turn)))


def test_a_place_that_is_not_finite_is_named_in_a_short_line():
    with pytest.raises(UsageError, match="nan") as caught:
        pose_of(PoseMessage(Point(math.nan, 1e300, 0.0), Quaternion(w=1.0)))
    assert len(str(caught.value)) < 100


def test_a_covariance_has_x_y_and_heading_at_their_places():
    covariance = np.arange(9.0).reshape(3, 3)
    message = pose_with_covariance(Pose(1.0, 2.0, 0.0), covariance, "map", STAMP)
    whole = np.array(message.pose.covariance).reshape(6, 6)
    assert (whole[0, 1], whole[5, 0], whole[5, 5], whole[2, 2]) == (1.0, 6.0, 8.0, 0.0)
    assert message.header.frame_id == "map" and message.header.stamp == STAMP


def test_a_spread_is_read_from_a_covariance():
    numbers = [0.0] * 36
    numbers[0], numbers[7], numbers[35] = 0.04, 0.25, 0.01
    assert spread_of(numbers) == pytest.approx((0.5, 0.1))
    for wrong in (-1.0, math.nan, math.inf):
        numbers[7] = wrong
        with pytest.raises(UsageError, match="variances"):
            spread_of(numbers)


def test_nobody_is_told_more_exactly_than_people_know_nor_to_more_than_half_a_turn():
    assert spread_of([0.0] * 36) == (0.05, 0.05)
    assert spread_of([1e300] * 36) == pytest.approx((1e150, math.pi))


def test_a_start_lies_on_the_map():
    grid = GridMap(np.full((40, 60), FREE, dtype=np.int8), 0.1, (-1.0, 2.0))      # x from -1 to 5, y from 2 to 6
    check_start(Pose(4.9, 2.1, 0.0), 7.0, grid)
    for x, y, spread, named in ((5.1, 3.0, 0.1, r"\(5.1, 3\) lies outside .* -1.00 to 5.00 and y from 2.00 to 6.00"),
                                (1e300, 3.0, 0.1, r"\(1e.300, 3\) lies outside"), (0.0, 1.9, 0.1, "outside"),
                                (0.0, 3.0, 8.0, "deviation of 8 m is more than the size of the map, 7.2 m"),
                                (0.0, 3.0, 1e150, r"deviation of 1e.150 m")):
        with pytest.raises(UsageError, match=named):
            check_start(Pose(x, y, 0.0), spread, grid)


def test_a_map_is_row_by_row_from_its_corner():
    grid = GridMap(np.array([[FREE, OCCUPIED], [UNKNOWN, FREE], [FREE, FREE]], dtype=np.int8), 0.05, (-1.0, 2.0))
    message = map_message(grid, "map", STAMP)
    assert message.data == [0, 100, -1, 0, 0, 0] and (message.info.width, message.info.height) == (2, 3)
    assert (message.info.origin.position.x, message.info.origin.position.y) == (-1.0, 2.0)


def test_each_pose_of_a_path_looks_to_the_next():
    message = path_message([(0.0, 0.0), (1.0, 1.0), (1.0, 2.0)], "map", STAMP)
    headings = [pose_of(pose.pose).heading for pose in message.poses]
    assert headings == pytest.approx([math.pi / 4, math.pi / 2, math.pi / 2])
    assert path_message([(1.0, 2.0)], "map", STAMP).poses[0].pose.position.x == 1.0
    assert path_message([], "map", STAMP).poses == [] == path_message([], "map", STAMP, 1.0).poses
    end = path_message([(0.0, 0.0), (1.0, 1.0)], "map", STAMP, -1.0).poses[1].pose
    assert pose_of(end).heading == pytest.approx(-1.0)


def test_a_cloud_and_a_footprint():
    cloud = cloud_message(np.array([[1.0, 2.0, 0.5], [3.0, 4.0, -0.5]]), 500, "map", STAMP)
    assert [pose_of(pose).heading for pose in cloud.poses] == pytest.approx([0.5, -0.5])
    outline = footprint_message([(0.2, 0.1), (-0.2, 0.1), (-0.2, -0.1)], "base_link", STAMP)
    assert [round(corner.x, 3) for corner in outline.polygon.points] == [0.2, -0.2, -0.2]


@pytest.mark.parametrize("count, told", [(1, 1), (500, 500), (501, 251), (999, 500), (1200, 400), (20000, 500)])
def test_a_cloud_has_at_most_as_many_poses_as_wanted_from_all_of_it(count, told):
    particles = np.arange(count)[:, None] * [1.0, 0.0, 0.0]
    cloud = cloud_message(particles, 500, "map", STAMP)
    assert len(cloud.poses) == told
    assert cloud.poses[0].position.x == 0.0 and cloud.poses[-1].position.x > 0.99 * count - 2


# Scans of a laser

def transform(x, y, roll=0.0, pitch=0.0, yaw=0.0):
    return Transform(Vector3(x, y, 0.3), Quaternion(*quaternion_from_euler(roll, pitch, yaw)))


@pytest.mark.parametrize("turn, pose, upside_down", [
    (dict(), (0.1, 0.2, 0.0), False), (dict(yaw=2.0), (0.1, 0.2, 2.0), False),
    (dict(roll=math.pi), (0.1, 0.2, 0.0), True), (dict(roll=math.pi, yaw=0.5), (0.1, 0.2, 0.5), True),
    (dict(roll=0.05, yaw=1.0), (0.1, 0.2, 1.0), False),
])
def test_a_mount_is_the_pose_of_the_laser_and_which_side_is_up(turn, pose, upside_down):
    mount, turned = mount_of(transform(0.1, 0.2, **turn))
    assert mount == pytest.approx(pose, abs=1e-9) and turned is upside_down


@pytest.mark.parametrize("turn, angle", [(dict(pitch=0.5), 29), (dict(roll=math.pi / 2), 90), (dict(roll=3.0), 8)])
def test_a_laser_that_leans_is_of_no_use(turn, angle):
    with pytest.raises(UsageError, match="leans by %d degrees" % angle):
        mount_of(transform(0.0, 0.0, **turn))


def test_a_mount_of_no_number_is_refused():
    with pytest.raises(UsageError, match="leans"):
        mount_of(Transform(Vector3(), Quaternion(math.nan, 0.0, 0.0, 1.0)))
    with pytest.raises(UsageError, match="finite, not .nan, 0"):
        mount_of(Transform(Vector3(math.nan, 0.0, 0.0), Quaternion(w=1.0)))


@pytest.mark.parametrize("place", [(11.0, 0.0), (1e300, -1e300)])
def test_a_mount_that_is_on_no_robot_is_refused(place):
    with pytest.raises(UsageError, match="more than 10 m from its robot"):
        mount_of(Transform(Vector3(*place, 0.0), Quaternion(w=1.0)))


def scan(**changed):
    """A scan of three rays: to the right, ahead, to the left."""
    values = dict(header=Header(stamp=Time(7), frame_id="laser"), angle_min=-1.0, angle_max=1.0, angle_increment=1.0,
                  time_increment=0.01, scan_time=0.1, range_min=0.05, range_max=8.0, ranges=[1.0, 2.0, 3.0])
    return LaserScan(**dict(values, **changed))


MOUNT = Pose(0.1, 0.0, 0.0)


def test_a_scan_is_what_the_laser_measured():
    sweep = sweep_of(scan(), MOUNT, False, 0.5)
    assert (sweep.time, sweep.duration, sweep.mount) == (7.5, 0.02, MOUNT)
    assert (sweep.first_angle, sweep.angle_step, list(sweep.ranges)) == (-1.0, 1.0, [1.0, 2.0, 3.0])


def test_the_scan_of_a_laser_that_is_upside_down_runs_clockwise():
    sweep = sweep_of(scan(), MOUNT, True, 0.0)
    assert (sweep.first_angle, sweep.angle_step) == (1.0, -1.0)


def test_ranges_beyond_the_limits_are_none():
    sweep = sweep_of(scan(ranges=[0.01, 9.0, -1.0, math.nan, math.inf], angle_max=3.0), MOUNT, False, 0.0)
    assert np.isnan(sweep.ranges).tolist() == [True, False, True, True, False]
    assert np.isposinf(sweep.ranges).tolist() == [False, True, False, False, True]


def test_a_range_that_no_laser_measures_is_none_whatever_the_limits_are():
    sweep = sweep_of(scan(ranges=[900.0, 1e6, 3e38], range_max=math.inf), MOUNT, False, 0.0)
    assert sweep.ranges.tolist() == [900.0, math.inf, math.inf]


@pytest.mark.parametrize("wrong, named", [
    (dict(ranges=[]), "0 ranges"), (dict(ranges=[1.0]), "1 ranges"), (dict(ranges=[1.0] * 5), "5 ranges, but .* are 3"),
    (dict(ranges=[1.0] * 5000, angle_increment=1e-6), "5000 ranges, 1e-06 rad apart: it must have 2 to 4000"),
    (dict(angle_increment=0.0), "0 rad apart"), (dict(angle_increment=math.nan), "angle_increment of a scan is nan"),
    (dict(angle_min=math.inf), "angle_min of a scan is inf"), (dict(angle_max=-1.0), "to angle_max -1 "),
    (dict(angle_max=math.nan), "angle_max of a scan is nan"), (dict(angle_increment=9.0, angle_max=17.0), "one turn"),
    (dict(time_increment=-0.1), "took -0.2 s"), (dict(time_increment=9.0), "took 18 s"),
    (dict(time_increment=math.nan), "time_increment"), (dict(range_max=math.nan), "range_max nan"),
    (dict(range_min=9.0), "range_min 9 and range_max 8"),
])
def test_a_scan_whose_numbers_do_not_fit_is_refused(wrong, named):
    with pytest.raises(UsageError, match=named):
        sweep_of(scan(**wrong), MOUNT, False, 0.0)
