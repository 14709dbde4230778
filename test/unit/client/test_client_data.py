"""Packets besides the SIP: they are requested until they come, and cancelled until they stop."""

import pytest

from pioneer_control import p2os
from pioneer_control.client.data_requests import AGAIN, DATA, TRIES

from fake_robot import Bench, FakeRobot, config


def asked(bench, command="IOREQUEST"):
    return [heard.value for heard in bench.robot.heard if heard.name == command]


def request(bench, kind, on):
    bench.want(kind, on)
    bench.step()


def ready(**fields):
    robot = FakeRobot()
    robot.config = config(**fields)
    return Bench(robot).until_ready()


@pytest.mark.parametrize("kind, golden", [
    ("encoder",  "FAFB0613 3B020015 3B"),
    ("io",       "FAFB0628 3B02002A 3B"),
    ("gripper",  "FAFB0625 3B020027 3B"),
    ("gyro",     "FAFB063A 3B01003B 3B"),
    ("compass",  "FAFB062D 3B030030 3B"),
    ("arm",      "FAFB0647 3B020049 3B"),
    ("battery",  "FAFB063E 3B020040 3B"),
    ("joystick", "FAFB0611 3B020013 3B"),
])
def test_each_kind_is_asked_for_with_its_command(kind, golden):
    bench = ready(has_gyro=1)
    request(bench, kind, True)
    assert bytes.fromhex(golden) in [data for written in bench.writes.values() for data in written]


def test_asked_a_few_times_for_what_never_comes():
    bench = ready()
    request(bench, "io", True)
    bench.run(TRIES * AGAIN + 3.0)
    assert asked(bench) == [2] * TRIES


def test_asked_once_for_what_comes():
    bench = ready()
    request(bench, "io", True)
    bench.robot.send(p2os.IO((1,), (2,), (3,)))
    bench.run(TRIES * AGAIN + 1.0)
    assert asked(bench) == [2]


def test_a_stop_that_was_lost_is_repeated_while_packets_come_and_not_after():
    bench = ready()
    request(bench, "io", True)
    request(bench, "io", False)
    for _ in range(15):
        bench.robot.send(p2os.IO((1,), (2,), (3,)))
        bench.run(0.1)
    assert asked(bench) == [2, 0, 0, 0]
    bench.run(3.0)
    assert asked(bench) == [2, 0, 0, 0]


def test_packets_that_nobody_here_asked_for_are_left_alone():
    bench = ready()
    for _ in range(20):
        bench.robot.send(p2os.Encoder(1, 2))
        bench.run(0.1)
    assert not {data.command for data in DATA.values()} & set(bench.robot.names())


@pytest.mark.parametrize("has_gyro, sent", [(0, []), (1, [1, 0]), (2, []), (3, []), (None, [])])
def test_a_gyro_that_the_robot_reads_itself_is_never_switched_to_something_else(has_gyro, sent):
    robot = FakeRobot()
    robot.config = None if has_gyro is None else config(has_gyro=has_gyro)
    bench = Bench(robot).until_ready()
    request(bench, "gyro", True)
    bench.robot.send(p2os.Gyro((p2os.GyroReading(512, 100),)))
    bench.run(0.1)
    request(bench, "gyro", False)
    bench.run(1.0)
    assert asked(bench, "GYRO") == sent


def test_what_was_wanted_before_is_asked_for_when_ready_and_what_was_ended_is_not():
    bench = Bench()
    for kind, on in (("io", True), ("encoder", True), ("encoder", False)):
        bench.want(kind, on)
    bench.until_ready()
    bench.run(0.1)
    assert asked(bench) == [2] and asked(bench, "ENCODER") == []


def test_a_full_queue_is_not_made_longer_and_what_found_no_place_is_asked_later():
    bench = Bench(rates=(9600,)).until_ready()
    while not bench.session.line.full:
        bench.session.connected.command(bench.now, p2os.encode_command("SONAR", 1))
    waiting = bench.session.line.waiting
    bench.want("io", True)
    assert bench.session.line.waiting == waiting
    bench.run(2 * AGAIN + 3.0)
    assert asked(bench)[0] == 2
