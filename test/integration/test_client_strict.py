"""Robot against a robot with the strictest handshake, in real time, over TCP and over a pseudo-terminal."""

import os
import signal
import subprocess
import sys
import threading

import pytest

from pioneer_control.client import LinkDown, Ready, Robot
from pioneer_control.errors import NoAnswerError

from strict_robot import StrictRobot, StrictServer

from real_time import LIMIT, keep_commanding, until

DRIVES_ON = """
import time
from pioneer_control.client import Robot
with Robot(%r) as robot:
    robot.enable_motors()
    while True:
        robot.set_velocity(0.2, 0.0)
        time.sleep(0.1)
"""


@pytest.fixture(params=["tcp", "pty"])
def switched_on(request, tmp_path):
    """Return a function that switches the robot on, each time at the same address."""
    before = []

    def switch_on():
        server = StrictServer(pty=str(tmp_path / "robot")) if request.param == "pty" else StrictServer(
            port=before[-1].port if before else 0)
        before.append(server)
        return server

    return switch_on


def clean(server):
    """Return whether no packet came too early, and the robot never hung up."""
    with server.lock:
        return not server.robot.echoes and server.robot.hang_ups == 0


def names(server):
    with server.lock:
        return [name for name, _ in server.robot.heard]


def test_first_connection_and_end(switched_on):
    with switched_on() as server:
        with Robot(server.url) as robot:
            assert robot.identity.name == "MobileSim" and not robot.state.motors_enabled
            robot.enable_motors()
            keep_commanding(robot, lambda: robot.set_velocity(0.2, 0.0), lambda state: state.x > 0.05)
            assert server.pty or names(server)[:3] == ["PULSE", "OPEN", "CLOSE"] and clean(server)
        until(lambda: not server.robot.open and not server.robot.moving, "closed")
        assert not server.robot.echoes


def test_it_is_connected_several_times_in_a_row(switched_on):
    with switched_on() as server:
        for _ in range(5):
            with Robot(server.url) as robot:
                assert robot.wait_for_state().battery_voltage > 10
        assert not server.robot.echoes


def test_what_is_on_that_port(switched_on):
    with switched_on() as server:
        report = subprocess.check_output(
            [sys.executable, "-m", "pioneer_control.client", server.url], universal_newlines=True, timeout=LIMIT)
        assert "MobileSim" in report and not server.robot.echoes
        until(lambda: not server.robot.open, "closed")


def test_it_is_switched_off_and_on_again(switched_on):
    events = []
    server = switched_on()
    with server, Robot(server.url, reconnect=True, on_event=events.append) as robot:
        robot.enable_motors()
        keep_commanding(robot, lambda: robot.set_velocity(0.2, 0.0), lambda state: state.x > 0.1)
        server.switch_off()
        until(lambda: any(isinstance(event, LinkDown) for event in events), "link down")
        far = robot.state.x
        with switched_on() as again:
            until(lambda: robot.ready, "connected again")
            state = robot.wait_for_state()
            assert not again.robot.moving and not again.robot.echoes
            assert state.x == pytest.approx(far, abs=0.05), "SIPs before OPEN begin at 0, and are of a new session"
            robot.close()
            until(lambda: not again.robot.open, "closed")


def test_it_is_switched_on_after_the_client(switched_on):
    first = switched_on()
    with first:
        url = first.url
    events = []
    with_reconnect = Robot(url, reconnect=True, on_event=events.append).start()
    try:
        until(lambda: sum(isinstance(event, LinkDown) for event in events) >= 3, "three attempts")
        with switched_on() as server:
            with_reconnect.wait_until_ready()
            assert any(isinstance(event, Ready) for event in events) and not server.robot.echoes
    finally:
        with_reconnect.close()


def test_its_client_is_killed_and_started_again(switched_on):
    with switched_on() as server:
        for _ in range(3):
            program = subprocess.Popen([sys.executable, "-c", DRIVES_ON % server.url])
            try:
                until(lambda: server.robot.moving, "driving")
            finally:
                os.kill(program.pid, signal.SIGKILL)
                program.wait()
            with Robot(server.url) as robot:
                assert not server.robot.moving and not robot.state.motors_enabled
            until(lambda: not server.robot.open, "closed")
        assert not server.robot.echoes


def test_a_robot_that_was_deaf_at_first_is_found_by_a_later_try(switched_on):
    """The packets wait for the robot. It reads all of them at once."""
    with switched_on() as server:
        server.robot.echoes.clear()
        robot = Robot(server.url, reconnect=True)
        with server.lock:
            robot.start()
            threading.Event().wait(1.2)
        try:
            robot.wait_until_ready()
            assert not server.robot.echoes
        finally:
            robot.close()


@pytest.mark.parametrize("first",
                         ["FAFB03020002", "FAFB031D001D", "FAFB06043B0000043B", "FAFB060B3B00000B3B", "FAFB03000000"])
def test_the_strict_robot_is_as_strict_as_measured(first):
    """Check each row of protocol sheet 13. If the robot were less strict, a client that sends too early could pass the
    tests.
    """
    robot = StrictRobot()
    robot.receive(bytes.fromhex(first), 0.0)
    answer = robot.advance(0.0)
    robot.receive(bytes.fromhex("FAFB03000000"), 0.01)
    then = robot.advance(0.01)
    if first == "FAFB03020002":
        assert b"MobileSim" in answer and then[3] == 0x32 and robot.open
        robot.receive(bytes.fromhex(first), 0.02)
        assert robot.hang_ups == 1 and not robot.open
    elif first == "FAFB03000000":
        assert answer == then == bytes.fromhex(first)
    else:
        number = bytes.fromhex(first)[3:4]
        assert answer == b"\xFA\xFB\x03" + number + b"\x00" + number and then == b""
        robot.receive(bytes.fromhex("FAFB03020002"), 0.02)
        assert robot.hang_ups == 1 and robot.advance(0.02) == b""


@pytest.mark.parametrize("packets, seconds", [(10, 0.0), (1, 10.0)])
def test_a_handshake_that_leads_nowhere_ends(packets, seconds):
    robot = StrictRobot()
    robot.receive(bytes.fromhex("FAFB03000000") * (packets - 1), 0.0)
    assert robot.hang_ups == 0
    robot.receive(bytes.fromhex("FAFB03000000"), 0.0)
    robot.advance(seconds)
    assert robot.hang_ups == 1


def test_nobody_answers_is_still_said():
    with StrictServer() as server, server.lock, pytest.raises(NoAnswerError):
        with Robot(server.url):
            pass
