"""How well poses explain scans, against numbers by hand."""

import math

import numpy as np
import pytest
from small_worlds import square_map, unknown_map

from pioneer_control.navigation.laser_field import LaserField
from pioneer_control.navigation.measurement import Beams
from pioneer_control.navigation.tuned import LaserSenseNumbers

NUMBERS = LaserSenseNumbers(sigma=0.1, sigma_coarse=0.4, anywhere=0.1, worth=2.0, near=0.15)
FIELD = LaserField(square_map(80), NUMBERS)      # 4 x 4 m; the middles of its walls' cells are at 0.025 and 3.975 m
HERE = np.array([[2.025, 2.025, 0.0]])      # the middle of a cell


def ahead(*ranges):
    """Return readings of a laser in the middle of the robot that looks ahead."""
    zeros = np.zeros(len(ranges))
    return Beams(zeros, zeros, zeros, FIELD.number_of(ranges), np.arange(len(ranges)))


def log(distance, sigma):
    """Return the log-likelihood of a ray that ends so far from a wall, by paper and pencil."""
    return 2.0 * math.log(0.9 * math.exp(-0.5 * (distance / sigma) ** 2) + 0.1)


@pytest.mark.parametrize("coarse, sigma", [(False, 0.1), (True, 0.4)])
def test_the_log_likelihood_is_that_of_the_distance_to_the_wall(coarse, sigma):
    # 1.95 m: in the wall; 1.80 m: three cells before it; 1.0 m: more than sigma can tell
    logs = FIELD.log_likelihoods(HERE, ahead(1.95, 1.80, 1.0), coarse)[0]
    assert logs[0] == pytest.approx(0.0, abs=1e-6)
    assert logs[1:] == pytest.approx([log(0.15, sigma), log(0.95, sigma)], abs=0.05)


def test_a_pose_and_its_heading_say_where_a_ray_ends():
    beams = Beams(*map(np.array, ([0.2], [0.0], [math.pi / 2])), FIELD.number_of([1.95]), np.array([0]))
    poses = np.array([[2.0, 2.025, 0.0], [2.025, 2.0, -math.pi / 2], [2.0, 1.0, 0.0]])
    left, ahead_of_it, wrong = FIELD.log_likelihoods(poses, beams)[:, 0]
    assert (left, ahead_of_it) == pytest.approx((0.0, 0.0), abs=1e-6) and wrong < -4.0


def test_what_ends_outside_of_the_map_is_far_from_every_wall():
    assert FIELD.log_likelihoods(HERE, ahead(1.95, 2.5, 100.0))[0, 1:] == pytest.approx([2.0 * math.log(0.1)] * 2)


def test_on_a_map_without_walls_all_is_far_from_them():
    empty = LaserField(unknown_map(), NUMBERS)
    assert empty.log_likelihoods(HERE, ahead(1.0, 0.1))[0] == pytest.approx([2.0 * math.log(0.1)] * 2)


def test_a_ray_is_explained_that_ends_near_a_wall():
    assert FIELD.explained(HERE[0], ahead(1.95, 1.82, 1.6, 2.3)).tolist() == [1.0, 1.0, 0.0, 0.0]


def test_both_are_the_same_as_each_alone():
    poses, beams = np.array([[2.0, 2.0, 0.1], [1.0, 2.0, 0.5]]), ahead(1.95, 1.5, 0.3)
    logs, explained = FIELD.both(poses, HERE[0], beams)
    assert logs == pytest.approx(FIELD.log_likelihoods(poses, beams).sum(axis=1))
    assert explained.tolist() == FIELD.explained(HERE[0], beams).tolist()


def test_what_is_not_finite_is_no_echo():
    assert FIELD.number_of([1.234, math.inf, math.nan]).tolist() == [123, FIELD.none, FIELD.none]


def test_rays_that_end_at_one_spot_count_once():
    assert FIELD.spot_shares(ahead(1.95, 1.94, 1.0)).tolist() == [0.5, 0.5, 1.0]
