"""Where the rays of a scan begin and look, also of a robot that moves."""

import math

import numpy as np
import pytest

from pioneer_control.floor_poses import Pose
from pioneer_control.navigation.laser_rays import rays_of
from pioneer_control.navigation.recent_readings import scan_beams
from pioneer_control.navigation.values import Scan

HERE = Pose(1.0, 2.0, math.pi / 2)
STANDS = Scan(5.0, HERE, Pose(0.1, 0.0, 0.0), -math.pi / 2, math.pi / 4, [1.0, 2.0, math.inf, math.nan, 5.0])


def test_a_laser_looks_from_where_it_sits():
    rays = rays_of(STANDS, HERE)
    assert rays.number.tolist() == [0, 1, 4] and rays.range.tolist() == [1.0, 2.0, 5.0]
    assert rays.x == pytest.approx([1.0] * 3) and rays.y == pytest.approx([2.1] * 3)
    assert rays.heading == pytest.approx([0.0, math.pi / 4, math.pi])


def test_an_upside_down_laser_looks_the_other_way_round():
    turned = STANDS._replace(first_angle=math.pi / 2, angle_step=-math.pi / 4)
    assert rays_of(turned, HERE).heading == pytest.approx([math.pi, math.pi * 3 / 4, 0.0])


def test_each_ray_is_from_where_the_robot_was_when_it_was_fired():
    """It drove 0.2 m and turned by 0.4 rad from the first ray to the last one, evenly."""
    rays = rays_of(STANDS._replace(motion=Pose(0.2, 0.0, 0.4), mount=Pose(0.0, 0.0, 0.0)), Pose(0.0, 0.0, 0.0))
    assert rays.x == pytest.approx([-0.1, -0.05, 0.1]) and rays.y == pytest.approx([0.0] * 3)
    assert rays.heading == pytest.approx([-math.pi / 2 - 0.2, -math.pi / 4 - 0.1, math.pi / 2 + 0.2])


def test_some_rays_are_spread_over_the_scan():
    scan = STANDS._replace(ranges=np.ones(181), angle_step=math.radians(1.0))
    rays = rays_of(scan, HERE, 10)
    assert rays.number.tolist() == [0, 20, 40, 60, 80, 100, 120, 140, 160, 180]
    assert len(rays_of(scan, HERE, 500).number) == len(rays_of(scan, HERE).number) == 181


def test_readings_of_a_scan_are_relative_to_where_the_robot_is_now():
    beams = scan_beams(STANDS, Pose(1.0, 2.5, math.pi / 2), lambda ranges: (ranges * 100).astype(int), 40)
    assert beams.x == pytest.approx([-0.4] * 3) and beams.y == pytest.approx([0.0] * 3, abs=1e-9)
    assert beams.heading == pytest.approx([-math.pi / 2, -math.pi / 4, math.pi / 2])
    assert beams.measured.tolist() == [100, 200, 500] and beams.sensor.tolist() == [0, 1, 4]
