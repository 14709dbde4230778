"""What stood still is remembered on the map, where the robot is not near any more."""

import numpy as np
import pytest

from pioneer_control.floor_poses import Pose
from pioneer_control.navigation.standing_obstacles import StandingObstacles
from pioneer_control.navigation.tuned import ObstacleNumbers

NUMBERS = ObstacleNumbers(kept_standing=100.0, away=1.0, cell=0.05)
BOX = np.array([(2.02, 1.02), (2.12, 1.02)])
NOTHING = np.zeros((0, 2))
FAR, BESIDE = Pose(5.0, 1.0, 0.0), Pose(2.0, 1.5, 0.0)


def after(*seen):
    """Return the places that are left after some places were seen, each with the robot's pose and the time."""
    standing = StandingObstacles(NUMBERS)
    for each in seen:
        standing.remember(*each)
    return standing.places


@pytest.mark.parametrize("pose, now, number", [
    (FAR, 199.0, 2), (FAR, 201.0, 0), (BESIDE, 101.0, 0), (Pose(2.02, 2.05, 0.0), 101.0, 2)])
def test_it_is_remembered_for_a_time_and_not_near_the_robot(pose, now, number):
    assert len(after((BOX, FAR, 100.0), (NOTHING, pose, now))) == number


def test_what_was_beside_the_robot_is_looked_for_anew():
    assert len(after((BOX, FAR, 100.0), (NOTHING, BESIDE, 101.0), (NOTHING, FAR, 102.0))) == 0


def test_what_is_seen_again_counts_once_and_from_then_on():
    seen = (BOX, FAR, 100.0), (BOX + 0.01, FAR, 150.0)
    assert len(after(*seen)) == len(after(*seen, (NOTHING, FAR, 240.0))) == 2


def test_some_or_all_may_be_forgotten():
    standing = StandingObstacles(NUMBERS)
    standing.remember(BOX, FAR, 100.0)
    standing.keep(standing.places[:, 0] > 2.1)
    assert standing.places.tolist() == [[2.12, 1.02]]
    standing.forget()
    assert len(standing.places) == 0
