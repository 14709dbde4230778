"""What is remembered of the sonar ranges, and what deletes it."""

import math

import pytest

from pioneer_control.tutorial.echoes import (
    FORGOTTEN_BEYOND, NEAR, NEAREST, REMEMBERED, Echo, Motion, remember)
from pioneer_control.tutorial.wander import NARROW
from robots_and_snapshots import shape, snapshot

ROBOT = shape("p3dx-sh")
LEFT = next(each for each in ROBOT.transducers if each.number == 0)  # looks straight to the left
ON_THE_LEFT = (LEFT.x, LEFT.y + 0.4)  # on the axis of that sonar


def take(ranges, echoes=(), *, motion=Motion.DRIVES, passed=0.1, **more):
    """Take a snapshot. Returns what is remembered, and what is then known around the robot."""
    kept, around = remember(tuple(echoes), snapshot(ranges, ROBOT, **more), motion, passed)
    return kept, [(round(x, 3), round(y, 3)) for x, y in around]


def _is_refuted(echo, heard, motion):
    """Return whether a range of the left sonar deletes an echo. The others hear something near, which is kept."""
    kept, _ = take({0: heard}, [echo], motion=motion, everything_else=0.2)
    return all((each.x, each.y) != (echo.x, echo.y) for each in kept)


def test_an_echo_lies_on_the_axis_of_its_cone():
    kept, around = take({0: 0.4})
    assert (round(ON_THE_LEFT[0], 3), round(ON_THE_LEFT[1], 3)) in around
    assert [(echo.x, echo.y) for echo in kept] == [pytest.approx(ON_THE_LEFT)]


def test_it_is_remembered_where_it_is_not_where_the_robot_was():
    """The robot is at (2, 1) and faces along y. Its left is -x."""
    kept, _ = take({0: 0.4}, pose=(2.0, 1.0, math.pi / 2))
    assert [(echo.x, echo.y) for echo in kept] == [pytest.approx((2.0 - ON_THE_LEFT[1], 1.0 + ON_THE_LEFT[0]))]
    _, around = take({0: 0.4}, kept, pose=(0.0, 0.0, 0.0), everything_else=0.3)
    assert len(around) == 16, "so far away it is forgotten"


def test_only_near_echoes_are_remembered():
    assert not take({0: NEAR + 0.01})[0]
    assert take({0: NEAR - 0.01})[0]


def test_a_sonar_that_was_not_heard_is_an_obstacle_now_but_is_not_remembered():
    kept, around = take({0: 0.0})
    assert not kept
    assert (LEFT.x, round(LEFT.y + NEAREST, 3)) in around


@pytest.mark.parametrize("heard", [0.05, NEAREST])
def test_what_is_heard_at_the_shortest_range_may_be_nearer_and_lies_at_the_outline(heard):
    small = shape("amigo-sh")
    left = next(each for each in small.transducers if each.number == 0)
    kept, around = remember((), snapshot({0: heard}, small), Motion.DRIVES, 0.1)
    assert (left.x, pytest.approx(small.outline.half_width)) in around
    assert [(echo.x, echo.y) for echo in kept] == [(left.x, pytest.approx(small.outline.half_width))]


def test_many_echoes_of_one_thing_are_one():
    kept = ()
    for step in range(20):
        kept, _ = take({0: 0.4 + 0.001 * (step % 3)}, kept, time=100 + step / 10)
    assert len(kept) == 1


@pytest.mark.parametrize("motion", Motion)
def test_it_fades_with_time_and_slowly_while_the_robot_stands(motion):
    """Trapped at the end of a wall, a robot stood until it had forgotten the wall, and then drove into it."""
    kept, passed = (Echo(0.0, 0.3),), REMEMBERED[motion] / 10.0      # beside no sonar
    for _ in range(9):
        kept, _ = take({}, kept, motion=motion, passed=passed)
        assert len(kept) == 1
    assert take({}, kept, motion=motion, passed=0.9 * passed)[0]
    assert not take({}, kept, motion=motion, passed=1.1 * passed)[0]


def test_it_is_remembered_longer_than_a_slow_turn_all_round_takes():
    """Where no sonar looks, a corner of the body swept over the end of a wall that it had forgotten meanwhile."""
    assert REMEMBERED[Motion.DRIVES] < 2 * math.pi / NARROW.rate < REMEMBERED[Motion.TURNS] < REMEMBERED[Motion.STANDS]


def test_a_new_echo_of_the_same_thing_is_young_again():
    old, _ = take({0: 0.4})
    old, _ = take({}, old, passed=6.0)
    assert old[0].age == 0.5
    assert [echo.age for echo in take({0: 0.4}, old, passed=3.0)[0]] == [0.0]


@pytest.mark.parametrize("distance, remembered", [(FORGOTTEN_BEYOND - 0.1, True), (FORGOTTEN_BEYOND + 0.1, False)])
def test_it_fades_with_distance(distance, remembered):
    angle = math.radians(70)
    echo = Echo(distance * math.cos(angle), distance * math.sin(angle))
    kept, _ = take({}, [echo], everything_else=0.2)
    assert ((echo.x, echo.y) in [(each.x, each.y) for each in kept]) is remembered


@pytest.mark.parametrize("heard, refuted", [
    (5.0, False), (4.8, True), (0.42, True), (0.40, False), (0.2, False)])
def test_a_sonar_that_looks_there_and_hears_farther_refutes_it(heard, refuted):
    """5.0 m means that no echo came back. A slanting wall may have lost it."""
    echo = Echo(LEFT.x, LEFT.y + 0.36)
    assert _is_refuted(echo, heard, Motion.DRIVES) is refuted


@pytest.mark.parametrize("degrees, motion, refuted", [
    (0, Motion.DRIVES, True), (9, Motion.DRIVES, True), (11, Motion.DRIVES, False), (-11, Motion.DRIVES, False),
    (5, Motion.TURNS, True), (9, Motion.TURNS, False), (9, Motion.STANDS, True)])
def test_only_near_its_axis_and_nearer_still_while_the_robot_turns(degrees, motion, refuted):
    angle = LEFT.heading + math.radians(degrees)
    echo = Echo(LEFT.x + 0.4 * math.cos(angle), LEFT.y + 0.4 * math.sin(angle))
    assert _is_refuted(echo, 3.0, motion) is refuted


@pytest.mark.parametrize("away, motion, refuted", [
    (0.15, Motion.DRIVES, True), (0.15, Motion.TURNS, False), (0.29, Motion.TURNS, False), (0.31, Motion.TURNS, True)])
def test_while_the_robot_turns_a_longer_echo_does_not_refute_what_is_near(away, motion, refuted):
    """The tip of a wedge of smooth walls, 15 to 18 cm away, returned few echoes, and the robot drove into it."""
    echo = Echo(LEFT.x, LEFT.y + away)
    assert _is_refuted(echo, 3.0, motion) is refuted
