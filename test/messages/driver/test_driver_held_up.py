"""Velocities that a network held up, and delivers at once when it is back, do not move the robot."""

import pytest
from bottle import Bottle
from geometry_msgs.msg import Twist, Vector3

from pioneer_control.driver.requests import AT_ONCE, SETTLES, Arrivals
from pioneer_control.msg import MotorState, WheelVelocities

TIMEOUT = 0.6
DRIVE = {"cmd_vel": Twist(Vector3(0.3, 0, 0), Vector3(0, 0, 0)),
         "teleop/cmd_vel": Twist(Vector3(0.3, 0, 0), Vector3(0, 0, 0)), "cmd_wheels": WheelVelocities(0.3, 0.3)}


def held_up(*times, timeout=TIMEOUT):
    arrivals = Arrivals(object())
    return [arrivals.held_up(time, timeout) for time in times]


@pytest.mark.parametrize("times", [
    [0.0],
    [0.0, 0.1, 0.2, 5.0, 5.1, 5.2],             # a program that paused
    [0.0, 0.0, 0.0, 0.001, 0.002],              # one that begins with many
    [0.0, 1.0, 2.0, 3.0],                       # one that is too slow
    [0.0, 2.0, 2.01, 2.02, 2.03],               # 100 Hz
    [0.0, 0.5, 0.5, 0.5],                       # no silence
])
def test_programs_that_send_as_they_drive_are_obeyed(times):
    assert not any(held_up(*times))


def test_what_comes_at_once_after_a_silence_is_old_until_it_has_settled():
    late = [3.0, 3.0005, 3.001, 3.1, 3.2]
    expected = [False, False, True, True, True, True, False, False, False]
    assert held_up(0.0, *late, 3.0 + SETTLES, 3.4, 3.4001) == expected


def test_they_may_come_in_more_than_one_piece():
    """TCP sends the first piece alone, and the rest when that is acknowledged."""
    assert held_up(0.0, 3.0, 3.05, 3.0505, 3.1, 3.0 + SETTLES) == [False, False, False, True, True, False]


def test_a_program_that_has_settled_may_send_two_at_once():
    assert not any(held_up(0.0, 3.0, 3.1, 3.2, 3.3, 3.3001, 3.4, 3.4001))


def test_the_limits():
    assert held_up(0.0, TIMEOUT, TIMEOUT) == [False, False, False]
    assert held_up(0.0, TIMEOUT + 0.01, TIMEOUT + 0.01 + AT_ONCE / 2)[-1]
    assert not held_up(0.0, 1.0, 1.0 + 1.01 * AT_ONCE)[-1]


@pytest.mark.parametrize("topic", sorted(DRIVE))
@pytest.mark.parametrize("ended, moved", [(True, 0.01), (False, 0.05)])
def test_a_robot_stands_when_old_velocities_of_a_program_arrive(monkeypatch, topic, ended, moved):
    def script(bottle):
        bottle.send("cmd_motor_state", MotorState(1))
        yield 0.5
        for _ in range(10):
            bottle.send(topic, DRIVE[topic])
            yield 0.1
        yield 5.0
        begin = bottle.firmware.true_pose[0]
        for _ in range(3):
            bottle.send(topic, DRIVE[topic])
        yield 0.0 if not ended else 2.0
        bottle.old = bottle.firmware.true_pose[0] - begin
        if not ended:
            for _ in range(20):
                yield 0.1
                bottle.send(topic, DRIVE[topic])
        bottle.new = bottle.firmware.true_pose[0] - begin

    bottle = Bottle(monkeypatch, script)
    assert abs(bottle.old) < moved and bottle.says("held up")
    assert ended or bottle.new > 0.2


def test_another_connection_has_nothing_old(monkeypatch):
    def script(bottle):
        bottle.send("cmd_motor_state", MotorState(1))
        yield 0.5
        bottle.send("cmd_vel", DRIVE["cmd_vel"])
        yield 5.0
        bottle.connect_anew()
        for _ in range(3):
            bottle.send("cmd_vel", DRIVE["cmd_vel"])
        yield 0.5
        bottle.speed = bottle.firmware.velocity[0]

    bottle = Bottle(monkeypatch, script)
    assert bottle.speed > 0.1 and not bottle.says("held up")
