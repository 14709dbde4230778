"""Where poses explain the last readings: found in steps, so that no packet waits."""

import math

import numpy as np
from small_worlds import ROOM, TRANSDUCERS, SensingRobot, map_of

from pioneer_control.floor_poses import Pose
from pioneer_control.navigation.expected_ranges import SONAR_BEAM, standing_room
from pioneer_control.navigation.measurement import RangeModel
from pioneer_control.navigation.pose_search import FIRST_READINGS, PoseSearch
from pioneer_control.navigation.recent_readings import FiringPoses, RecentReadings
from pioneer_control.navigation.tuned import SONAR_NUMBERS, LocalisationNumbers

TUNED = LocalisationNumbers()
AREA = 120.0    # m^2: 18000 poses, which are compared in three steps
START = Pose(3.0, 1.8, 0.6)


def test_a_search_finds_the_pose_and_no_step_compares_more_than_the_first_does(monkeypatch):
    model = RangeModel(map_of(ROOM), SONAR_BEAM, SONAR_NUMBERS, TUNED.map_bias)
    robot, firing_poses, recent = SensingRobot(ROOM, START), FiringPoses(TRANSDUCERS), RecentReadings(TUNED.remembered)
    while len(recent) < TUNED.remembered:
        sensing = robot.step(0.01, 0.05)
        firing_poses.add(sensing)
        recent.add(sensing.odometry, firing_poses.beams(model.expected.number_of))
    compared = []
    log_likelihoods = model.log_likelihoods
    monkeypatch.setattr(model, "log_likelihoods", lambda poses, beams, coarse=False: (
        compared.append(len(poses) * len(beams.x)), log_likelihoods(poses, beams, coarse))[1])
    search = PoseSearch(
        model, standing_room(map_of(ROOM), TUNED.clearance), AREA, TUNED, np.random.default_rng(1))
    search.begin(recent.seen_from(robot.odometry))
    found, steps = None, []
    while found is None:
        compared.clear()
        found = search.step()
        steps.append(sum(compared))
    x, y, heading = found.poses[0]
    assert math.hypot(x - robot.pose.x, y - robot.pose.y) < 0.1
    assert abs(math.remainder(heading - robot.pose.heading, 2.0 * math.pi)) < 0.1
    assert max(steps) == steps[0] == TUNED.poses_per_step * FIRST_READINGS
    assert len(steps) == 3 + 3 and not search.runs
