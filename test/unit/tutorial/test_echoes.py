"""What is remembered of the sonar ranges, and what deletes it."""

import math

import pytest

from pioneer_control.tutorial.echoes import FORGOTTEN_BEYOND, NEAR, NEAREST, REMEMBERED, Echo, remember
from robots_and_snapshots import shape, snapshot

ROBOT = shape("p3dx-sh")
LEFT = next(each for each in ROBOT.transducers if each.number == 0)  # looks straight to the left
ON_THE_LEFT = (LEFT.x, LEFT.y + 0.4)  # on the axis of that sonar


def take(ranges, echoes=(), *, turning=False, **more):
    """Take a snapshot. Returns what is remembered, and what is then known around the robot."""
    kept, around = remember(tuple(echoes), snapshot(ranges, ROBOT, **more), turning)
    return kept, [(round(x, 3), round(y, 3)) for x, y in around]


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
    kept, around = remember((), snapshot({0: heard}, small), False)
    assert (left.x, pytest.approx(small.outline.half_width)) in around
    assert [(echo.x, echo.y) for echo in kept] == [(left.x, pytest.approx(small.outline.half_width))]


def test_many_echoes_of_one_thing_are_one():
    kept = ()
    for step in range(20):
        kept, _ = take({0: 0.4 + 0.001 * (step % 3)}, kept, time=100 + step / 10)
    assert len(kept) == 1


@pytest.mark.parametrize("age, remembered", [(REMEMBERED - 0.1, True), (REMEMBERED + 0.1, False)])
def test_it_fades_with_time(age, remembered):
    beside_no_sonar = Echo(0.0, 0.3, 100.0 - age)
    assert bool(take({}, [beside_no_sonar])[0]) is remembered


@pytest.mark.parametrize("distance, remembered", [(FORGOTTEN_BEYOND - 0.1, True), (FORGOTTEN_BEYOND + 0.1, False)])
def test_it_fades_with_distance(distance, remembered):
    angle = math.radians(70)
    echo = Echo(distance * math.cos(angle), distance * math.sin(angle), 100.0)
    assert (echo in take({}, [echo], everything_else=0.2)[0]) is remembered


@pytest.mark.parametrize("heard, refuted", [
    (5.0, False), (4.8, True), (0.42, True), (0.40, False), (0.2, False)])
def test_a_sonar_that_looks_there_and_hears_farther_refutes_it(heard, refuted):
    """5.0 m means that no echo came back. A slanting wall may have lost it."""
    echo = Echo(LEFT.x, LEFT.y + 0.36, 99.0)
    assert (echo not in take({0: heard}, [echo], everything_else=0.2)[0]) is refuted


@pytest.mark.parametrize("degrees, turning, refuted", [
    (0, False, True), (9, False, True), (11, False, False), (-11, False, False), (5, True, True), (9, True, False)])
def test_only_near_its_axis_and_nearer_still_while_the_robot_turns(degrees, turning, refuted):
    angle = LEFT.heading + math.radians(degrees)
    echo = Echo(LEFT.x + 0.4 * math.cos(angle), LEFT.y + 0.4 * math.sin(angle), 99.0)
    kept, _ = take({0: 3.0}, [echo], turning=turning, everything_else=0.2)
    assert (echo not in kept) is refuted


@pytest.mark.parametrize("away, turning, refuted", [
    (0.15, False, True), (0.15, True, False), (0.29, True, False), (0.31, True, True)])
def test_while_the_robot_turns_a_longer_echo_does_not_refute_what_is_near(away, turning, refuted):
    """The tip of a wedge of smooth walls, 15 to 18 cm away, returned few echoes, and the robot drove into it."""
    echo = Echo(LEFT.x, LEFT.y + away, 99.0)
    kept, _ = take({0: 3.0}, [echo], turning=turning, everything_else=0.2)
    assert (echo not in kept) is refuted
