"""How well poses explain readings."""

from dataclasses import replace

import numpy as np
import pytest
from small_worlds import RAY, square_map

from pioneer_control.navigation.expected_ranges import SONAR_BEAM
from pioneer_control.navigation.measurement import Beams, RangeModel, likelihoods
from pioneer_control.navigation.pose_search import PoseSearch
from pioneer_control.navigation.tuned import SONAR_NUMBERS, EchoShares, LocalisationNumbers, SensorNumbers

RAY_NUMBERS = SensorNumbers((EchoShares(0.8, 0.04, 0.04),), 1, sigma=0.06, sigma_per_metre=0.02, short=0.09)
MODEL = RangeModel(square_map(80), SONAR_BEAM, SONAR_NUMBERS, 0.0)
NONE = MODEL.expected.none


def ahead(*measured):
    """Return readings of a transducer in the middle of the robot that looks ahead."""
    zeros = np.zeros(len(measured))
    return Beams(zeros, zeros, zeros, np.array(measured), np.arange(len(measured)))


MIDDLE = np.array([[2.0, 2.0, 0.0]])    # 1.975 m before a wall: number 99


@pytest.mark.parametrize("beam, numbers", [(SONAR_BEAM, SONAR_NUMBERS), (RAY, RAY_NUMBERS)])
def test_likelihoods_of_all_that_can_be_measured_add_up_to_1(beam, numbers):
    count = round(beam.maximum / beam.unit) + 2
    table = likelihoods(np.arange(count) * beam.unit, beam, numbers)
    assert table.shape == (count * beam.slants, count) and table.min() > 0.0
    assert table.sum(axis=1) == pytest.approx(1.0)


def test_the_expected_range_is_the_likeliest_where_the_sensor_looks_at_a_wall_squarely():
    hit, longer, shorter, none = MODEL.log_likelihoods(MIDDLE, ahead(99, 160, 40, NONE))[0]
    assert hit > max(longer + 4.0, shorter + 4.0, none + 0.8)


# The edge of the cone meets the wall at y = 0 after about 1.9 m, at 58 degrees to its normal: number 95.
ALONG_A_WALL = np.array([[1.0, 1.0, np.radians(-20.0)]])


def test_where_a_wall_slants_the_sensor_often_hears_nothing_or_what_is_behind():
    hit, longer, shorter, none = MODEL.log_likelihoods(ALONG_A_WALL, ahead(95, 140, 40, NONE))[0]
    square = MODEL.log_likelihoods(MIDDLE, ahead(99, 149, 40, NONE))[0]
    assert hit < square[0] - 1.0 and longer > square[1] + 2.0 and none > square[3] + 2.0
    assert shorter == pytest.approx(square[2], abs=0.3)


def test_a_ray_looks_at_all_walls_alike():
    ray = RangeModel(square_map(80), RAY, RAY_NUMBERS, 0.0)
    numbers = ray.expected.number_of([0.975 / np.sin(np.radians(40.0)), 0.975])
    poses = np.array([[1.0, 1.0, np.radians(-40.0)], [1.0, 1.0, np.radians(-90.0)]])
    logs = ray.log_likelihoods(poses, ahead(*numbers, ray.expected.none))
    assert [logs[0, 0], logs[0, 2]] == pytest.approx([logs[1, 1], logs[1, 2]], abs=0.3)


def test_no_echo_is_likeliest_where_nothing_is_in_reach():
    large = RangeModel(square_map(160), SONAR_BEAM, SONAR_NUMBERS, 0.0)
    poses = np.array([[4.0, 4.0, 0.0], [1.5, 4.0, 0.0]])     # 4 m and 6.5 m before a wall
    before_a_wall, before_nothing = large.log_likelihoods(poses, ahead(NONE))[:, 0]
    assert before_nothing > before_a_wall + 1.0


def test_the_pose_of_the_robot_moves_and_turns_its_sensors():
    beams = Beams(*map(np.array, ([0.5], [0.0], [np.pi / 2], [74], [0])))      # 1.475 m to the left
    poses = np.array([[2.0, 2.5, 0.0], [1.5, 2.0, -np.pi / 2], [2.0, 2.0, 0.0]])
    right, turned, wrong = MODEL.log_likelihoods(poses, beams)[:, 0]
    assert right > wrong + 3.0
    assert turned < right - 3.0      # there the sensor looks along x, 2.475 m from the wall


def test_a_coarse_comparison_forgives_more():
    near_miss = ahead(112)
    fine, coarse = (MODEL.log_likelihoods(MIDDLE, near_miss, coarse) for coarse in (False, True))
    assert coarse > fine + 0.5


def test_no_echo_explains_nothing_and_contradicts_nothing():
    explained = MODEL.explained(MIDDLE[0], ahead(99, 103, 130, 40, NONE))
    assert explained[:4].tolist() == [1.0, 1.0, 0.0, 0.0] and np.isnan(explained[4])


def test_what_is_behind_a_wall_that_slants_much_contradicts_nothing():
    near, just_behind, behind, before = MODEL.explained(ALONG_A_WALL[0], ahead(90, 99, 140, 40))
    assert (near, just_behind, before) == (1.0, 1.0, 0.0) and np.isnan(behind)
    nothing_lost = RangeModel(square_map(80), SONAR_BEAM, replace(SONAR_NUMBERS, lost=4), 0.0)
    assert nothing_lost.explained(ALONG_A_WALL[0], ahead(140)) == 0.0


def test_what_is_heard_again_and_again_counts_once():
    """Somebody beside a robot that turned a little was heard 80 times: it believed that it was 7 m away (1507)."""
    beams = ahead(*[50] * 4, 59, 99, NONE, NONE)        # two of them 0.18 m apart, in one square
    assert MODEL.spot_shares(beams) == pytest.approx([0.2] * 5 + [1.0, 0.5, 0.5])
    moved = beams._replace(y=np.arange(8) * 0.25)
    assert MODEL.spot_shares(moved) == pytest.approx(1.0)


def test_silence_is_of_one_spot_when_a_sensor_looks_almost_the_same_way():
    silent = ahead(NONE, NONE, NONE)._replace(heading=np.array([0.05, 0.15, 0.25]))
    assert MODEL.spot_shares(silent) == pytest.approx([0.5, 0.5, 1.0])


def test_a_search_prefers_a_pose_that_explains_more_spots_to_one_that_explains_more_readings():
    search = PoseSearch(MODEL, np.zeros((0, 2)), 0.0, LocalisationNumbers(), None)
    beams = ahead(*[49] * 20, 99, 99, 99, 99)
    beams = beams._replace(y=np.array([0.0] * 20 + [0.5, -0.5, 1.0, -1.0]))
    nearer = [3.0, 2.0, 0.0]    # 0.975 m before the wall: number 49
    found = search.scored(np.array([nearer, MIDDLE[0]]), beams)
    assert found.poses[0].tolist() == MIDDLE[0].tolist() and MODEL.spot_shares(beams).sum() == pytest.approx(5.0)
