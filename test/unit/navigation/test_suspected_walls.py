"""Where walls may go on that a robot hears only beside it."""

import math

import numpy as np
import pytest

from pioneer_control.floor_poses import Pose
from pioneer_control.navigation.frames import out_of
from pioneer_control.navigation.sonar_grid import SonarBeams
from pioneer_control.navigation.suspected_walls import SuspectedWalls, suspected_walls
from pioneer_control.navigation.tuned import SuspicionNumbers

NUMBERS = SuspicionNumbers()
NO_BEAMS = SonarBeams(*(np.zeros(0),) * 4)


def wall(turned: float = 0.0, first: float = -0.5, last: float = 0.1, scatter: float = 0.0):
    """Return places of a wall 0.3 m to the left, turned by an angle (rad) about the robot."""
    along = np.arange(first, last + 1e-6, 0.05)
    left = 0.3 + scatter * np.where(np.arange(len(along)) % 2, 1.0, -1.0)
    return (along * math.cos(turned) - left * math.sin(turned), along * math.sin(turned) + left * math.cos(turned))


def beam(x: float, y: float, heading: float, far: float) -> SonarBeams:
    """Return one firing."""
    return SonarBeams(*(np.array([each]) for each in (x, y, heading, far)))


@pytest.mark.parametrize("turned", [0.0, 0.4, -0.4, 1.5, -2.8])
@pytest.mark.parametrize("scatter", [0.0, 0.015])
def test_a_wall_may_go_on_at_both_ends(turned, scatter):
    x, y = suspected_walls(*wall(turned, scatter=scatter), NO_BEAMS, NUMBERS)
    along, left = x * math.cos(turned) + y * math.sin(turned), y * math.cos(turned) - x * math.sin(turned)
    assert left == pytest.approx(np.full(len(left), 0.3), abs=0.03)
    assert along.max() == pytest.approx(0.1 + NUMBERS.reach, abs=0.05)
    assert along.min() == pytest.approx(-0.5 - NUMBERS.reach, abs=0.05)
    assert not ((along > -0.5) & (along < 0.1)).any()


@pytest.mark.parametrize("far", [2.0, math.inf])
def test_a_beam_that_goes_on_squarely_says_that_it_has_ended(far):
    x, _ = suspected_walls(*wall(), beam(0.25, 0.0, math.pi / 2.0, far), NUMBERS)
    assert not ((x > 0.2) & (x < 0.3)).any() and (x > 0.35).any()


@pytest.mark.parametrize("heading, far", [(math.pi / 2.0, 0.3), (math.pi / 4.0, 2.0), (-math.pi / 2.0, 2.0)])
def test_no_other_beam_does(heading, far):
    """One that meets it, one that slants, one that looks away."""
    x, _ = suspected_walls(*wall(), beam(0.25 - 0.3 / math.tan(heading), 0.0, heading, far), NUMBERS)
    assert x == pytest.approx(suspected_walls(*wall(), NO_BEAMS, NUMBERS)[0])


@pytest.mark.parametrize("places", [
    wall(first=0.0, last=0.1),      # too few
    (np.full(8, 0.3) + 0.01 * np.arange(8), np.full(8, 0.3)),       # too short
    (np.array([-0.5, -0.3, 0.0, 0.2, 0.5, 0.1]), np.array([0.5, -0.4, 0.45, -0.6, 0.3, -0.2])),     # not straight
    tuple(3.0 * each for each in wall()),       # too far away
    (np.zeros(0), np.zeros(0)),
])
def test_what_is_no_wall_beside_it_does_not_go_on(places):
    x, y = suspected_walls(*places, NO_BEAMS, NUMBERS)
    assert len(x) == len(y) == 0


def test_two_walls_go_on_each_by_itself():
    left, right = wall(), wall(math.pi)
    x, y = suspected_walls(*(np.append(a, b) for a, b in zip(left, right)), NO_BEAMS, NUMBERS)
    assert (y > 0.25).any() and (y < -0.25).any()


def test_without_a_reach_nothing_is_suspected():
    x, _ = suspected_walls(*wall(), NO_BEAMS, SuspicionNumbers(reach=0.0))
    assert len(x) == 0


def test_where_the_robot_drove_no_wall_goes_on():
    walls, odometry = SuspectedWalls(0.2, NUMBERS), Pose(5.0, -3.0, 2.0)
    free, _ = walls.places(*wall(), NO_BEAMS, odometry)
    assert (free > 0.25).any() and (free < -0.6).any()
    walls.drive(Pose(*out_of(odometry, 0.3, 0.3), 0.0))
    left, _ = walls.places(*wall(), NO_BEAMS, odometry)
    assert not (left > 0.12).any() and (left < -0.6).any()
    walls.forget()
    again, _ = walls.places(*wall(), NO_BEAMS, odometry)
    assert again == pytest.approx(free)


def test_firings_are_told_in_the_frame_of_odometry():
    walls, odometry = SuspectedWalls(0.2, NUMBERS), Pose(5.0, -3.0, 2.0)
    x, y = out_of(odometry, 0.25, 0.0)
    passed, _ = walls.places(*wall(), beam(x, y, 2.0 + math.pi / 2.0, 2.0), odometry)
    assert not ((passed > 0.2) & (passed < 0.3)).any() and (passed > 0.35).any()
