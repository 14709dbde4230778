"""The body: it moves on exact arcs, and walls stop it."""

import math

import pytest

from pioneer_control.simulator.hardware.body import SKINS, Body, box_round
from pioneer_control.simulator.world.poses import along_arc, compose, relative
from pioneer_control.simulator.world import World

SQUARE = ((-0.2, -0.2), (0.2, -0.2), (0.2, 0.2), (-0.2, 0.2))


def body(walls=(), posts=(), pose=(0.0, 0.0, 0.0), outline=SQUARE):
    return Body(World("test", walls=walls, posts=posts), outline, pose)


def test_a_quarter_circle():
    x, y, heading = along_arc((1.0, 2.0, 0.0), math.pi / 2 * 3.0, math.pi / 2)
    assert (x, y, heading) == (pytest.approx(4.0), pytest.approx(5.0), pytest.approx(math.pi / 2))


def test_a_straight_line_backwards():
    assert along_arc((0.0, 0.0, math.pi / 2), -2.0, 0.0) == (pytest.approx(0.0), pytest.approx(-2.0), math.pi / 2)


def test_many_short_arcs_are_one_long_one():
    pose = (0.0, 0.0, 0.3)
    for _ in range(1000):
        pose = along_arc(pose, 0.01, -0.003)
    assert pose == pytest.approx(along_arc((0.0, 0.0, 0.3), 10.0, -3.0))


def test_relative_undoes_compose():
    frame, pose = (3.0, -1.0, 2.5), (0.4, 0.7, -9.0)
    assert relative(frame, compose(frame, pose)) == pytest.approx(pose)


def test_the_box_round_an_outline_is_a_skin_larger_all_round():
    outline = ((-0.3, -0.2), (0.2, -0.2), (0.35, -0.1), (0.35, 0.1), (0.2, 0.2), (-0.3, 0.2))
    (x1, y1), (x2, y2), (x3, y3), (x4, y4) = box_round(outline, 0.05)
    assert (x1, x2, x3, x4) == pytest.approx((-0.35, 0.4, 0.4, -0.35))
    assert (y1, y2, y3, y4) == pytest.approx((-0.25, -0.25, 0.25, 0.25))


def drive(robot, steps, distance, turn=0.0):
    return sum(robot.move(distance, turn) for _ in range(steps))


def test_a_wall_stops_the_body_within_a_step():
    robot = body(walls=[(1.0, -5.0, 1.0, 5.0)])
    moved = drive(robot, 200, 0.01)
    assert 79 <= moved <= 80 and robot.pose[0] == pytest.approx(0.8, abs=0.0101)
    assert robot.blocked and robot.contacts == 1


def test_pressing_on_is_one_contact_and_coming_back_another():
    robot = body(walls=[(1.0, -5.0, 1.0, 5.0)])
    drive(robot, 200, 0.01)
    assert drive(robot, 10, -0.01) == 10 and not robot.blocked
    drive(robot, 200, 0.01)
    assert robot.contacts == 2


def test_a_corner_cannot_turn_into_a_wall():
    robot = body(walls=[(0.25, -5.0, 0.25, 5.0)])
    drive(robot, 100, 0.0, 0.01)
    # The corner at 0.2828 m under 45 degrees reaches x = 0.25 when it has turned by 45 - acos(0.25 / 0.2828).
    assert robot.pose[2] == pytest.approx(math.radians(45) - math.acos(0.25 / math.hypot(0.2, 0.2)), abs=0.0101)


def test_a_thin_pole_stops_it_too():
    robot = body(posts=[(1.0, 0.19, 0.01)])
    drive(robot, 200, 0.01)
    assert robot.pose[0] == pytest.approx(0.79, abs=0.0101) and robot.contacts == 1


@pytest.mark.parametrize("speed", [0.001, 0.007, 0.03])
def test_the_shortcut_when_nothing_is_near_misses_nothing(speed):
    robot = body(walls=[(2.0, -5.0, 2.0, 5.0)], posts=[(1.5, 0.3, 0.05)])
    for _ in range(int(3.0 / speed)):
        before = robot.pose
        robot.move(speed, speed * 0.1)
        assert not robot.touches(SQUARE), before
    assert robot.contacts == 1


def test_carried_elsewhere_it_looks_again():
    robot = body(walls=[(50.0, -5.0, 50.0, 5.0)])
    assert robot.move(0.01, 0.0)
    robot.place((49.79, 0.0, 0.0))
    assert not robot.move(0.02, 0.0)


def test_skin_is_no_contact():
    robot = body(walls=[(0.2 + SKINS[-1] / 2, -5.0, 0.2 + SKINS[-1] / 2, 5.0)])
    assert robot.move(0.001, 0.0) and robot.contacts == 0
