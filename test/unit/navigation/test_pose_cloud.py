"""What a cloud of poses says about where the robot is."""

import numpy as np
import pytest

from pioneer_control.navigation.pose_cloud import PoseCloud
from pioneer_control.navigation.tuned import LocalisationNumbers

HERE, THERE = (1.0, 2.0, 0.0), (2.3, 2.0, 0.0)


def cloud(there, best_there=False):
    """Return 300 poses, a share of them in another place. The single likeliest pose is there, or here."""
    made = PoseCloud(LocalisationNumbers(), np.random.default_rng(1))
    made.put(np.array([HERE, THERE]), np.log([1.0 - there, max(there, 1e-9)]), 0.02, 0.02, 300)
    x, logs = made.poses[:, 0], np.zeros(300)
    logs[x.argmax() if best_there else x.argmin()] = 0.5
    made.weigh(logs, 300)
    return made


@pytest.mark.parametrize("best_there", [False, True])
def test_the_pose_is_of_the_place_with_most_of_the_weight_whichever_pose_is_likeliest(best_there):
    pose = cloud(0.03, best_there).spread().pose
    assert pose == pytest.approx(HERE, abs=0.02)


@pytest.mark.parametrize("best_there", [False, True])
def test_poses_elsewhere_make_the_spread_wider(best_there):
    one, two = cloud(0.0).spread(), cloud(0.1, best_there).spread()
    assert one.position < 0.03 and two.position > 0.3


def test_a_place_across_the_seam_of_headings_is_one_place():
    made = cloud(0.0)
    made.poses[:, 2] += np.pi + 6.0 * np.pi
    assert abs(made.spread().pose.heading) > 3.0 and made.spread().heading < 0.05
