"""The guide drives legs as the robot is known to move, and the lookout stands for what the sonar sees."""

import math

import pytest

from made_runs import WRONG
from pioneer_control.calibration.guide import SPEED, STAND, TURN_RATE, Guide, GuidedVelocity
from pioneer_control.calibration.lookout import CLEAR_FOR, FREE, Lookout
from pioneer_control.calibration.plan import AheadLeg, TurnLeg, square
from pioneer_control.calibration.tracks import Factors
from pioneer_control.floor_poses import Pose, compose, distance_between
from pioneer_control.robots import find_model
from pioneer_control.tutorial.snapshot import RobotShape, Snapshot

PERIOD = 0.1
MODEL = find_model("p3dx-sh")
SHAPE = RobotShape(MODEL.sonar, MODEL.outline())


def moved(pose, velocity, factors=Factors()):
    """Return the pose after a period, of a robot that does at once what it is told, times its factors."""
    way = velocity.linear * PERIOD * factors.distance
    turn = velocity.angular * PERIOD * factors.turn + way * factors.curve
    return compose(pose, Pose(way * math.cos(turn / 2), way * math.sin(turn / 2), turn))


def driven(guide, factors=Factors(), longest=300.0):
    """Drive to the end. Return the true pose then, all velocities, and the time (s)."""
    counted, true, now, velocities = Pose(7.0, 3.0, 2.0), Pose(0, 0, 0), 0.0, []
    while not guide.done:
        assert now < longest
        velocities.append(guide.step(counted, now))
        counted, true = moved(counted, velocities[-1]), moved(true, velocities[-1], factors)
        now += PERIOD
    return true, velocities, now


@pytest.mark.parametrize("factors", [Factors(), WRONG, Factors(0.97, 0.95, -0.03)])
def test_a_square_closes_when_the_factors_are_known(factors):
    end, velocities, _ = driven(Guide(square(2.0, 1).legs, factors), factors)
    assert distance_between(end, Pose(0, 0, 0)) < 0.05 and abs(math.remainder(end.heading, 2 * math.pi)) < 0.03
    assert max(each.linear for each in velocities) <= SPEED and max(each.angular for each in velocities) <= TURN_RATE


def test_a_line_ends_where_it_should():
    end, velocities, time = driven(Guide((AheadLeg(5.0),), Factors()))
    assert end == pytest.approx((5.0, 0.0, 0.0), abs=0.006) and time < 25
    assert velocities[-1] == STAND


def test_a_turn_to_the_right_goes_all_the_way_round():
    end, velocities, _ = driven(Guide((TurnLeg(-4 * math.pi),), Factors()))
    assert all(each.angular <= 0 for each in velocities)
    assert sum(each.angular for each in velocities) * PERIOD == pytest.approx(-4 * math.pi, abs=0.02)
    assert (end.x, end.y) == (0, 0)


def test_a_robot_that_is_pushed_aside_is_steered_back():
    guide = Guide((AheadLeg(5.0),), Factors())
    guide.step(Pose(0, 0, 0), 0.0)
    assert guide.step(Pose(0.1, 0.05, 0.1), 0.1).angular < 0
    assert guide.step(Pose(0.2, -0.05, -0.1), 0.2).angular > 0


def test_a_robot_beside_its_line_that_looks_along_it_is_steered_back():
    """0.5 m at 0.1 rad to the right, then it turned back: 5 cm to the right of the line."""
    guide, pose, now = Guide((AheadLeg(5.0),), Factors()), Pose(0, 0, -0.1), 0.0
    guide.step(Pose(0, 0, 0), now)
    for velocity in [GuidedVelocity(0.5)] * 10 + [GuidedVelocity(0.0, 1.0)]:
        guide.step(pose, now)
        pose, now = moved(pose, velocity), now + PERIOD
    assert pose == pytest.approx((0.4975, -0.0499, 0.0), abs=1e-3)
    assert guide.step(pose, now).angular > 0.02


def test_it_waits_between_legs_until_the_robot_rests():
    guide = Guide((AheadLeg(0.5), TurnLeg(1.0)), Factors())
    guide.step(Pose(0, 0, 0), 0.0)
    assert guide.step(Pose(0.5, 0, 0), 0.1) == STAND        # it still moves
    assert guide.step(Pose(0.5, 0, 0), 0.3) == STAND
    assert guide.step(Pose(0.5, 0, 0), 0.6).angular > 0


def test_legs_that_are_none():
    assert Guide((), Factors()).done and Guide((), Factors()).leg is None and STAND == GuidedVelocity(0.0, 0.0)


def sees(time, ranges=None, age=0.0, stalled=False):
    """Return a snapshot of a robot that hears nothing but the ranges given by number."""
    heard = [5.0] * SHAPE.sonar_count
    for number, distance in (ranges or {}).items():
        heard[number] = distance
    return Snapshot(time, age, Pose(0, 0, 0), tuple(heard), SHAPE, stalled=stalled)


AHEAD, LEFT = AheadLeg(5.0), TurnLeg(6.0)


@pytest.mark.parametrize("snapshot, leg, reason", [
    (sees(1.0), AHEAD, ""), (sees(1.0), LEFT, ""), (sees(1.0), None, ""),
    (sees(1.0, {3: 0.4}), AHEAD, "the sonar sees something 0."),
    (sees(1.0, {3: 0.4}), LEFT, ""),
    (sees(1.0, {11: 0.4}), AHEAD, ""),                          # behind
    (sees(1.0, {10: 0.12}), LEFT, ""),                          # the rear corner comes there from the other side
    (sees(1.0, {10: 0.12}), TurnLeg(-6.0), "something that a turn would touch"),
    (sees(1.0, {3: 0.0}), AHEAD, "the sonar sees something"),   # no reading counts as an obstacle
    (sees(1.0, age=0.6), AHEAD, "the robot has told nothing for 0.6 s"),
    (sees(1.0, stalled=True), LEFT, "a wheel is stalled")])
def test_what_the_robot_stands_for(snapshot, leg, reason):
    why_not = Lookout().why_not(snapshot, leg)
    assert reason in why_not and bool(reason) == bool(why_not)


def test_it_stops_in_time_from_full_speed():
    """The robot's own deceleration, 0.3 m/s^2, and 0.3 s until it begins."""
    assert SPEED ** 2 / (2 * 0.3) + 0.3 * SPEED < FREE


def test_it_goes_on_a_moment_after_the_way_is_free():
    lookout = Lookout()
    assert lookout.why_not(sees(1.0, {3: 0.4, 4: 0.4}), AHEAD)
    farther = {3: 4.0, 4: 4.0}
    assert lookout.why_not(sees(1.2, farther), AHEAD) == "the way was not free just now"
    assert lookout.why_not(sees(1.3 + CLEAR_FOR, farther), AHEAD) == ""
