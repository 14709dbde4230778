"""Robot against the simulated robot over a serial line that has a speed, and whose port changes after a while."""

import contextlib
import dataclasses
import os

import pytest

from pioneer_control.client import LineSpeed, LinkDown, Robot, host_baud
from pioneer_control.robots import find_model
from pioneer_control.simulator.firmware import Firmware, FirmwareState
from pioneer_control.simulator.firmware.commands import HANDLERS
from pioneer_control.simulator.world import load_world
from pioneer_control.simulator.hardware import standard_numbers
from pioneer_control.simulator.line import Server

from client_lines import Adapter
from real_time import LIMIT, keep_commanding, until


class Heard:
    """A listener that keeps the events of one type."""

    def __init__(self, kind):
        self._kind = kind
        self.events = []

    def __call__(self, event):
        if isinstance(event, self._kind):
            self.events.append(event)

    def last(self, count=1):
        """Wait until so many events have come, and return the newest. A listener hears of an event a moment after it
        happened.
        """
        until(lambda: len(self.events) >= count, "%d events" % count)
        return self.events[-1]


def robot_with(baud=9600, **options):
    numbers = standard_numbers()
    numbers = dataclasses.replace(numbers, session=dataclasses.replace(numbers.session, host_baud=baud))
    return Firmware(find_model("p3dx-sh"), load_world("empty"), numbers=numbers, **options)


@pytest.fixture
def server(tmp_path):
    with Server(robot_with(), pty=str(tmp_path / "robot")) as running:
        yield running


@pytest.fixture
def patience(monkeypatch):
    """Give client and robot more time for the change of speed than a real robot needs. A slow machine may need it."""
    monkeypatch.setattr(host_baud, "SETTLE", 0.3)
    monkeypatch.setattr(host_baud, "ANSWER", 3.0)
    monkeypatch.setattr(host_baud, "TRIES", 1)


def drive(robot, far_enough):
    robot.enable_motors()
    keep_commanding(robot, lambda: robot.set_velocity(0.3, 0.0), far_enough)


def garbled_at(server, baud):
    """From now on every byte arrives as a zero, in both directions, while the robot uses this speed."""
    line, = server._lines
    write, read = line.write, line.read
    line.write = lambda data: write(bytes(len(data)) if line.baud == baud else data)
    line.read = lambda busy: bytes(len(read(busy))) if line.baud == baud else read(busy)


def test_a_robot_at_another_speed_is_found(tmp_path):
    with Server(robot_with(38400), pty=str(tmp_path / "robot")) as server:
        robot = Robot(server.pty_link).start()
        robot.wait_until_ready(LIMIT)
        robot.close()
    assert robot.link.sips


def test_host_baud_changes_the_speed_of_both_ends_for_the_session(server, patience):
    heard = Heard(LineSpeed)
    for connections in (1, 2):
        with Robot(server.pty_link, host_baud=115200, on_event=heard) as robot:
            assert server.firmware.baud == 115200 and heard.last(connections) == LineSpeed(115200, "")
            drive(robot, lambda state: state.linear > 0.1)
            assert robot.state.time - robot.state.sent_time < 0.02
        until(lambda: server.firmware.baud == 9600 and server.firmware.session is FirmwareState.WAITING, "closed")


def test_a_robot_that_ignores_host_baud_works_at_its_own_speed(server, patience, monkeypatch):
    monkeypatch.setitem(HANDLERS, "HOSTBAUD", HANDLERS["HOSTBAUD"]._replace(act=lambda robot, code: None))
    heard = Heard(LineSpeed)
    with Robot(server.pty_link, host_baud=115200, on_event=heard) as robot:
        assert server.firmware.baud == 9600 and "no answer at 115200 baud" in heard.last().problem
        drive(robot, lambda state: state.linear > 0.1)


def test_a_line_that_does_not_carry_host_baud_is_given_up_and_the_robot_found_again_when_it_is_back(server):
    garbled_at(server, 115200)
    heard = Heard((LineSpeed, LinkDown))
    robot = Robot(server.pty_link, host_baud=115200, reconnect=True, on_event=heard).start()
    until(lambda: heard.events, "said that it does not work")
    assert isinstance(heard.events[0], LinkDown) and "from 9600 to 115200 baud" in str(heard.events[0].error)
    with server.lock:
        server.firmware.restart()       # somebody switches it off and on
    robot.wait_until_ready(LIMIT)
    assert (server.firmware.baud == 9600 and
            not [event for event in heard.events if isinstance(event, LineSpeed)]), "not tried again"
    robot.close()


def test_a_robot_that_is_not_understood_at_host_baud_is_told_to_go_back(server, patience):
    line, = server._lines
    write = line.write
    line.write = lambda data: write(bytes(len(data)) if line.baud == 115200 else data)
    heard = Heard(LineSpeed)
    with Robot(server.pty_link, host_baud=115200, on_event=heard) as robot:
        assert server.firmware.baud == 9600 and heard.last().baud == 9600 and heard.last().problem
        drive(robot, lambda state: state.linear > 0.1)


def test_a_robot_left_driving_at_the_raised_speed_by_a_crash_is_found(server, patience):
    first = Robot(server.pty_link, host_baud=115200).start()
    first.wait_until_ready(LIMIT)
    drive(first, lambda state: state.linear > 0.1)
    with first._link.changed:       # a crash: the port is closed, and nobody says goodbye
        first._link.connection.transport.write = lambda data: None
    first.close()
    assert server.firmware.session is FirmwareState.OPEN and server.firmware.baud == 115200
    with Robot(server.pty_link, host_baud=115200) as robot:
        assert server.firmware.baud == 115200
        assert not robot.state.motors_enabled
        until(lambda: server.firmware.velocity == (0.0, 0.0), "standing")


def test_a_port_that_is_another_one_after_a_while_is_found_under_its_link_and_nothing_moves(tmp_path):
    link, heard = str(tmp_path / "pioneer"), Heard(LinkDown)
    with Server(robot_with(), tcp=0) as server:
        port = int(server.url.rpartition(":")[2])
        with Adapter(port) as first, contextlib.ExitStack() as later:
            os.symlink(first.device, link)
            with Robot(link, reconnect=True, on_event=heard) as robot:
                drive(robot, lambda state: state.x > 0.2)
                first.unplug()
                os.unlink(link)
                until(lambda: not robot.ready, "link lost")
                before = robot.state
                os.symlink(later.enter_context(Adapter(port)).device, link)
                until(lambda: robot.ready and robot.link.reconnects == 1, "back")
                now = robot.wait_for_state()
                assert (now.x, now.y, now.heading) == pytest.approx((before.x, before.y, before.heading), abs=0.05)
                assert not now.motors_enabled
                until(lambda: server.firmware.velocity == (0.0, 0.0), "standing")
                x = robot.wait_for_state().x
                assert [robot.wait_for_state().x for _ in range(5)] == [x] * 5
                drive(robot, lambda state: state.x > x + 0.05)
            assert "cable pulled" in str(heard.events[0].error) and server.firmware.session is FirmwareState.WAITING
