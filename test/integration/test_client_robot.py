"""Robot against the simulated robot, in real time, over TCP and over a pseudo-terminal."""

import math
import os
import signal
import subprocess
import sys
import threading
import time

import pytest

from pioneer_control import p2os
from pioneer_control.client import (
    LinkDown, MotionCleared, MotorsAnswered, PacketReceived, Ready, Robot, StatesMissed, threads)
from pioneer_control.errors import (
    LinkLostError, NoAnswerError, NotConfirmedError, PortError, RefusedError, UnknownModelError, UsageError)
from pioneer_control.p2os import GripperCommand, encode_command
from pioneer_control.robots import find_model
from pioneer_control.simulator.firmware import Firmware, FirmwareState
from pioneer_control.simulator.world import load_world
from pioneer_control.simulator.line import Server

from client_lines import SpoiltLine
from real_time import LIMIT, keep_commanding, until


@pytest.fixture
def server(tmp_path):
    with Server(Firmware(find_model("p3dx-sh"), load_world("empty")), tcp=0, pty=str(tmp_path / "robot")) as running:
        yield running


@pytest.fixture(params=["tcp", "pty"])
def url(server, request):
    return server.url if request.param == "tcp" else server.pty_link


def keep_driving(robot, linear, angular, condition):
    keep_commanding(robot, lambda: robot.set_velocity(linear, angular), condition)


def port_of(server):
    return int(server.url.rsplit(":", 1)[1])


def at_rest(server):
    with server.lock:
        return server.firmware.velocity == (0.0, 0.0)


def waiting(server):
    with server.lock:
        return server.firmware.session is FirmwareState.WAITING and not server.firmware.motors_enabled


def test_connect_drive_stop_and_leave(server, url):
    with Robot(url) as robot:
        identity = robot.identity
        assert (identity.subtype, identity.name, identity.has_gripper) == ("p3dx-sh", "sim_0001", True)
        assert not robot.state.motors_enabled and robot.state.gripper is not None
        robot.enable_motors()
        assert robot.state.motors_enabled
        keep_driving(robot, 0.3, 0.0, lambda state: state.x > 0.2)
        robot.stop()
        until(lambda: robot.state.linear == 0, "stopped")
        keep_driving(robot, 0.0, 0.8, lambda state: state.heading > math.pi / 4)
        pose = robot.state
    assert waiting(server)
    assert pose.x > 0.2 and abs(pose.y) < 0.1
    x, y, heading = server.firmware.true_pose
    assert math.hypot(x - pose.x, y - pose.y) < 0.2
    assert robot.link.sips > 5 and robot.link.bad_checksums == 0 and robot.link.last_error is None


def test_a_program_that_falls_silent_is_stopped(server):
    with Robot(server.url) as robot:
        robot.enable_motors()
        robot.set_velocity(0.3, 0.0)
        until(lambda: robot.state.linear > 0.05, "driving")
        until(lambda: robot.state.linear == 0, "stopped by the command time-out")
        assert robot.state.motors_enabled


def test_an_exception_in_the_program_stops_the_robot(server, url):
    with pytest.raises(ZeroDivisionError):
        with Robot(url) as robot:
            robot.enable_motors()
            robot.set_velocity(0.3, 0.0)
            robot.wait_for_state()
            1 / 0
    assert waiting(server)


def test_an_exception_in_a_listener_stops_the_robot_and_is_kept(server, monkeypatch):
    loud = []
    monkeypatch.setattr(threading, "excepthook", loud.append)

    def listener(state):
        if state.motors_enabled:
            raise ZeroDivisionError("in the listener")

    robot = Robot(server.url, on_state=listener).start()
    robot.wait_until_ready()
    robot.request_motors(True)
    assert robot.wait_until_ended(LIMIT)
    until(lambda: loud, "exception said")
    assert waiting(server)
    with pytest.raises(LinkLostError) as error:
        robot.set_velocity(0.1, 0.0)
    assert isinstance(error.value.__cause__, ZeroDivisionError)
    robot.close()


def test_when_both_threads_fail_the_robot_is_stopped_and_nobody_waits_for_them(server, monkeypatch):
    loud = []
    monkeypatch.setattr(threading, "excepthook", loud.append)
    with Robot(server.url) as robot:
        robot.enable_motors()
        monkeypatch.setattr(threads.Session, "events", lambda session: 1 / 0)
        assert robot.wait_until_ended(LIMIT)
        until(lambda: len(loud) == 2, "both have failed")
        until(lambda: waiting(server), "closed")
        with pytest.raises(LinkLostError):
            robot.set_velocity(0.1, 0.0)


@pytest.mark.parametrize("at", ["before the write", "after it"])
def test_a_signal_handler_that_closes_in_the_midst_of_a_command_has_the_last_word(server, at):
    """The handler runs on the thread that gives the command. When the handler returns, that thread goes on, although
    the robot is already stopped and closed.
    """
    with Robot(server.url, command_timeout=10 * LIMIT) as robot:
        robot.enable_motors()
        transport, written = robot._link.connection.transport, []
        write = transport.write

        def interrupted_write(data):
            interrupted = b"".join(written) == b"" and encode_command("VEL", 300) in data
            if interrupted and at == "before the write":
                robot.close(wait=False)
            written.append(data)
            write(data)
            if interrupted and at == "after it":
                robot.close(wait=False)

        transport.write = interrupted_write
        robot.set_velocity(0.3, 0.0)
        said = b"".join(written)
        assert said.index(encode_command("VEL", 300)) < said.rindex(encode_command("STOP")), "when the command returns"
        assert robot.wait_until_ended(LIMIT) and waiting(server)


def test_nothing_is_written_to_a_line_that_is_closed(server, monkeypatch):
    """By then the descriptor may belong to another file, or to the next connection. There the bytes would be the first
    that a waiting robot hears.
    """
    monkeypatch.setattr(threads, "BACK_OFF", 10 * LIMIT)
    events, written = [], []

    def fail(data):
        written.append(data)
        raise LinkLostError("broken")

    with Robot(server.url, reconnect=True, on_event=events.append) as robot:
        robot.enable_motors()
        robot.set_velocity(0.3, 0.0)
        robot._link.connection.transport.write = fail
        until(lambda: [event for event in events if isinstance(event, LinkDown)],
              "the thread that repeats it has noticed")
        count = len(written)
        robot.set_limits(0.2, None, 0.6)
        robot.close()
        assert count == len(written) > 0


class Hang:
    """A listener that hangs when `begins(state)` is true. It does not return until the test lets it."""

    def __init__(self, begins):
        self._begins = begins
        self._go_on = threading.Event()
        self.hanging = threading.Event()

    def __call__(self, state):
        if self._begins(state) and not self._go_on.is_set():
            self.hanging.set()
            self._go_on.wait(10 * LIMIT)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._go_on.set()


def drives(state):
    return state.linear > 0.05


@pytest.fixture
def hang():
    with Hang(drives) as listener:
        yield listener


def heard_by(server):
    """Return a list that gets all bytes that the robot receives from now on, one entry for each read."""
    told, take = [], server.firmware.receive
    server.firmware.receive = lambda data: (told.append(data), take(data))
    return told


def test_a_listener_that_hangs_does_not_keep_the_robot_from_stopping(server, hang):
    robot = Robot(server.url, on_state=hang, command_timeout=10 * LIMIT)
    with robot:
        robot.enable_motors()
        robot.set_velocity(0.3, 0.0)
        assert hang.hanging.wait(LIMIT)
    assert waiting(server), "closed in spite of the listener, which still hangs"


def test_a_listener_that_hangs_holds_up_no_dead_man(server, hang):
    with Robot(server.url, on_state=hang, command_timeout=0.6) as robot:
        robot.enable_motors()
        robot.set_velocity(0.3, 0.0)
        assert hang.hanging.wait(LIMIT)
        told = heard_by(server)
        until(lambda: encode_command("STOP") in b"".join(told), "told to stop")


def test_while_a_listener_hangs_the_robot_drives_on_and_is_heard_and_listeners_are_told_what_they_missed(
        server, monkeypatch):
    monkeypatch.setattr(threads, "MOST_WAITING", 20)
    events, states = [], []
    with Hang(drives) as hang, Robot(server.url, on_state=hang, on_event=events.append) as robot:
        robot.listen(on_state=states.append)
        robot.enable_motors()
        keep_driving(robot, 0.3, 0.0, lambda state: hang.hanging.is_set())
        count = len(states)
        with server.lock:
            server.firmware.press_stop_button(True)
        until(lambda: robot.link.missed > 10, "the line is read, beyond what the queue holds")
        assert len(states) == count and robot.ready and robot.state.stop_button
        missed = robot.link.missed
        hang.__exit__()
        until(lambda: [event for event in events if isinstance(event, MotionCleared)], "no event is missed")
        until(lambda: robot.state in states, "the newest state is told")
    assert sum(event.number for event in events if isinstance(event, StatesMissed)) >= missed
    assert [state.time for state in states] == sorted(state.time for state in states)


def test_a_shorter_time_out_holds_at_once_also_while_a_listener_hangs(server, hang):
    with Robot(server.url, on_state=hang, command_timeout=10 * LIMIT) as robot:
        robot.enable_motors()
        robot.set_velocity(0.3, 0.0)
        assert hang.hanging.wait(LIMIT)
        robot.set_limits(None, None, 0.2)
        told = heard_by(server)
        until(lambda: encode_command("STOP") in b"".join(told), "told to stop")


def test_a_session_that_is_closed_during_a_hang_goes_on_to_its_end(server, hang):
    robot = Robot(server.url, on_state=hang, command_timeout=10 * LIMIT, pulse=0).start()
    robot.wait_until_ready()
    robot.enable_motors()
    robot.set_velocity(0.3, 0.0)
    assert hang.hanging.wait(LIMIT)
    robot.close(wait=False)
    assert robot.wait_until_ended(LIMIT)
    assert waiting(server)
    robot.close()


def test_listeners_are_called_in_order_and_one_at_a_time(server):
    inside, order, overlaps = [], [], []

    def listener(number):
        def listen(state):
            overlaps.extend(inside)
            inside.append(number)
            time.sleep(0.02)        # longer than it takes the other thread to have the next packet ready
            order.append((number, state.time))
            inside.remove(number)
        return listen

    robot = Robot(server.url, on_state=listener(1))
    robot.listen(on_state=listener(2))
    with robot:
        until(lambda: len(order) > 10, "some states")
    assert overlaps == []
    assert [number for number, _ in order] == [1, 2] * (len(order) // 2)
    assert [at for _, at in order] == sorted(at for _, at in order)


def test_both_threads_take_turns(server):
    """While a listener takes long, the other thread takes the port. It keeps the port, so it also calls the listeners
    for the states that come then.
    """
    names = set()

    def listener(state):
        if not names:
            time.sleep(2 * threads.TURN)
        names.add(threading.current_thread().name)

    with Robot(server.url, on_state=listener):
        until(lambda: len(names) == 2, "both of them")


def test_what_threads_tell_each_other_is_only_written_under_the_lock(server):
    unlocked, written = [], []

    class Watched(threads.Connection):
        @property
        def read_until(self):
            return self.__dict__["read_until"]

        @read_until.setter
        def read_until(self, value):
            written.append(value)
            if not robot._link.changed._is_owned():
                unlocked.append(value)
            self.__dict__["read_until"] = value

    robot = Robot(server.url)
    with pytest.MonkeyPatch.context() as monkeypatch:
        monkeypatch.setattr(threads, "Connection", Watched)
        with robot:
            for _ in range(3):
                robot.wait_for_state()
            assert len(written) > 5 and unlocked == []
            robot._link.connection.read_until = 0.0
            assert unlocked == [0.0], "and the test would notice"


def test_closing_stops_at_once_and_not_when_a_thread_finds_time(server, hang, monkeypatch):
    monkeypatch.setattr("pioneer_control.client.threads.CLOSE_TIMEOUT", 10 * LIMIT)
    robot = Robot(server.url, on_state=hang, command_timeout=10 * LIMIT).start()
    robot.wait_until_ready()
    robot.enable_motors()
    robot.set_velocity(0.3, 0.0)
    assert hang.hanging.wait(LIMIT)
    told = heard_by(server)
    closing = threading.Thread(target=robot.close)
    closing.start()
    until(lambda: encode_command("STOP") in b"".join(told), "told to stop")
    hang.__exit__()
    closing.join(LIMIT)
    assert waiting(server)


def test_closing_without_waiting_has_written_the_stop_and_the_rest_follows(server):
    robot = Robot(server.url).start()
    robot.wait_until_ready(LIMIT)
    written, write = [], robot._link.connection.transport.write
    robot._link.connection.transport.write = lambda data: (written.append(data), write(data))
    robot.close(wait=False)
    assert encode_command("STOP") in b"".join(written)
    assert encode_command("CLOSE") not in b"".join(written)
    assert robot.wait_until_ended(LIMIT)
    assert waiting(server)
    robot.close()


def test_who_waits_for_a_robot_that_is_closed_hears_that_and_of_no_time(server):
    with Robot(server.url) as robot:
        threading.Timer(0.3, robot.close).start()
        with pytest.raises(LinkLostError, match=": closed$"):
            while True:
                robot.wait_for_state(10 * LIMIT)
    with pytest.raises(LinkLostError, match=": closed$"):
        robot.set_velocity(0.1, 0.0)


def test_closing_can_be_repeated(server):
    robot = Robot(server.url)
    robot.close()
    with Robot(server.url) as robot:
        assert not robot.wait_until_ended(0.01)
    assert robot.wait_until_ended(0.0)
    robot.close()
    assert not robot.ready
    robot.stop()
    with pytest.raises(LinkLostError):
        robot.set_velocity(0.1, 0.0)


def test_nan_is_refused_and_the_robot_drives_on(server):
    with Robot(server.url) as robot:
        robot.enable_motors()
        robot.set_velocity(0.2, 0.0)
        with pytest.raises(UsageError):
            robot.set_velocity(math.nan, 0.5)
        keep_driving(robot, 0.2, 0.0, lambda state: state.linear > 0.1)


def test_the_stop_button(server):
    with Robot(server.url) as robot:
        robot.enable_motors()
        keep_driving(robot, 0.3, 0.0, lambda state: state.linear > 0.1)
        with server.lock:
            server.firmware.press_stop_button(True)
        until(lambda: robot.state.stop_button and not robot.state.motors_enabled, "STOP button reported")
        with pytest.raises(RefusedError, match="STOP button"):
            robot.enable_motors()
        with server.lock:
            server.firmware.press_stop_button(False)
        until(lambda: not robot.state.stop_button, "STOP button released")
        robot.enable_motors()
        until(lambda: robot.state.linear == 0, "standing")
        robot.disable_motors()
        assert not robot.state.motors_enabled


def test_of_two_motor_requests_in_a_row_the_last_holds(server):
    with Robot(server.url) as robot:
        overtaken, answer = robot.request_motors(True), robot.request_motors(False)
        answer()
        with pytest.raises(NotConfirmedError, match="overtaken"):
            overtaken()
        assert not robot.wait_for_state().motors_enabled


def test_sonar_gripper_outputs_and_odometry_reset(server):
    with Robot(server.url) as robot:
        robot.set_sonar(False)
        until(lambda: not robot.state.sonar_enabled, "sonar off")
        robot.set_sonar(True)
        until(lambda: robot.state.sonar_enabled and all(robot.state.sonar), "all sonars heard")
        assert {heard.range for heard in robot.state.sonar} == {5.0}
        robot.gripper(GripperCommand.CLOSE)
        until(lambda: robot.state.gripper.paddles_closed, "closed")
        robot.gripper(4)
        robot.set_digital_out(0b11, 0b01)
        until(lambda: robot.state.digital_out & 0b11 == 0b01, "outputs set")
        robot.enable_motors()
        keep_driving(robot, 0.3, 0.5, lambda state: state.heading > 0.3)
        robot.stop()
        until(lambda: robot.state.linear == robot.state.angular == 0, "standing")
        robot.reset_odometry()
        robot.wait_for_state()
        assert (robot.state.x, robot.state.y, robot.state.heading) == (0.0, 0.0, 0.0)


@pytest.mark.parametrize("command, value", [
    (0, None), (99, None), ("open", None), (GripperCommand.OPEN, 5), (16, None), (16, 0), (16, 101), (17, 0),
    (17, -256)])
def test_gripper_commands_that_mean_nothing_are_refused(server, command, value):
    with pytest.raises(UsageError, match="gripper command"):
        Robot(server.url).gripper(command, value)


def test_pressure_and_carry_bring_their_value(server):
    with Robot(server.url) as robot:
        robot.gripper(GripperCommand.LIFT_DOWN)
        until(lambda: robot.state.gripper.lift_down, "down")
        robot.gripper(GripperCommand.CARRY, 25)
        until(lambda: not robot.state.gripper.lift_down, "half a second up")
        robot.gripper(GripperCommand.PRESSURE, 10)


def test_packets_besides_the_sip_are_asked_for_again_after_a_reconnect_and_end_with_the_session(server):
    got = []
    with SpoiltLine(port_of(server)) as line:
        robot = Robot(line.url, reconnect=True, on_event=lambda event: isinstance(event, PacketReceived) and
                      got.append(type(event.packet)))
        robot.request_data("io")
        with robot:
            robot.request_data("encoder")
            until(lambda: {p2os.IO, p2os.Encoder} <= set(got), "both kinds")
            line.cut()
            until(lambda: robot.link.reconnects == 1, "reconnected")
            got.clear()
            until(lambda: {p2os.IO, p2os.Encoder} <= set(got), "both kinds again")
            robot.request_data("encoder", False)
            until(lambda: got[-3:] == [p2os.IO] * 3, "no more of one")
            with pytest.raises(UsageError, match="'sonar'; legal: io, gyro"):
                robot.request_data("sonar")
    got.clear()
    with Robot(server.url, on_event=lambda event: isinstance(event, PacketReceived) and
               got.append(type(event.packet))) as robot:
        robot.wait_for_state()
        robot.wait_for_state()
        assert got == []


def test_a_robot_without_gripper_refuses():
    with Server(Firmware(find_model("p3dx-sh"), load_world("empty"), gripper=False, rear_sonar=False), tcp=0) as server:
        with Robot(server.url) as robot:
            assert robot.state.gripper is None and len(robot.state.sonar) == 8
            with pytest.raises(RefusedError, match="no gripper"):
                robot.gripper(GripperCommand.OPEN)


DRIVES_UNTIL_KILLED = """
import sys
from pioneer_control.client import Robot
robot = Robot(sys.argv[1]).start()
robot.wait_until_ready()
robot.enable_motors()
while True:
    robot.set_velocity(0.3, 0.0)
    if robot.wait_for_state().linear > 0.1:
        print("driving", flush=True)
"""


def test_killed_while_driving_and_started_again(server, url):
    with subprocess.Popen([sys.executable, "-c", DRIVES_UNTIL_KILLED, url], stdout=subprocess.PIPE) as program:
        assert program.stdout.readline() == b"driving\n"
        os.kill(program.pid, signal.SIGKILL)
        program.wait(LIMIT)
    assert server.firmware.session is FirmwareState.OPEN and server.firmware.motors_enabled
    with Robot(url) as robot:
        assert not robot.state.motors_enabled
        until(lambda: at_rest(server), "standing")
        x = robot.state.x
        time.sleep(0.5)     # the time in which it would have driven on
        assert robot.state.x == x and at_rest(server)


def test_a_program_that_ends_without_closing_is_closed(server):
    script = DRIVES_UNTIL_KILLED.replace('print("driving", flush=True)', "break")
    subprocess.run([sys.executable, "-c", script, server.url], check=True, timeout=LIMIT)
    until(lambda: waiting(server), "closed")


def test_half_of_the_traffic_malformed(server):
    with SpoiltLine(port_of(server), seed=5) as line, Robot(line.url) as robot:
        robot.enable_motors()
        line.spoil = 0.5
        keep_driving(robot, 0.3, 0.0, lambda state: state.x > 1.0)
        assert robot.ready and line.spoilt > 20
        assert robot.link.bad_checksums > 0 and robot.link.discarded_bytes > 100
        robot.stop()
        until(lambda: robot.state.linear == 0, "stopped in spite of lost stops")


def test_a_cut_line_is_reconnected_the_pose_goes_on_and_nothing_moves(server):
    events = []
    with SpoiltLine(port_of(server)) as line, Robot(line.url, reconnect=True, on_event=events.append) as robot:
        robot.enable_motors()
        keep_driving(robot, 0.3, 0.0, lambda state: state.x > 0.3)
        before = robot.state
        line.cut()
        until(lambda: any(isinstance(event, LinkDown) for event in events), "link down said")
        until(lambda: robot.ready and robot.state is not before and robot.link.reconnects == 1, "reconnected")
        assert robot.state.x == pytest.approx(before.x, abs=0.1)
        assert not robot.state.motors_enabled
        until(lambda: at_rest(server), "standing")
        x = robot.wait_for_state().x
        time.sleep(0.5)     # the time in which it would have driven on
        assert robot.state.x == x
        robot.enable_motors()
        keep_driving(robot, 0.3, 0.0, lambda state: state.x > x + 0.1)
    assert len([event for event in events if isinstance(event, Ready)]) == 2
    assert robot.link.last_error and waiting(server)


def test_a_cut_line_without_reconnect_is_final(server):
    with SpoiltLine(port_of(server)) as line, Robot(line.url) as robot:
        line.cut()
        until(lambda: not robot.ready, "link lost")
        with pytest.raises(LinkLostError):
            robot.enable_motors()
        with pytest.raises(LinkLostError):
            robot.wait_for_state()


@pytest.mark.parametrize("by", ["a command", "the I/O thread"])
def test_a_write_that_fails_is_told_and_ends_the_link(server, by):
    def refuse(data):
        raise LinkLostError("takes no more bytes")

    with Robot(server.url) as robot:
        robot._link.connection.transport.write = refuse
        if by == "a command":
            with pytest.raises(LinkLostError, match="takes no more bytes"):
                robot.set_velocity(0.1, 0.0)
        assert robot.wait_until_ended(LIMIT)
        assert not robot.ready and "takes no more" in robot.link.last_error


def test_a_line_that_is_found_dead_between_two_reads_is_connected_again(server):
    """A command writes to a line that takes no bytes, while no thread reads from it."""
    robot = Robot(server.url, reconnect=True)
    with robot:
        link, keep, broken = robot._link, robot._link._serve, threading.Event()

        def refuse(data):
            raise LinkLostError("takes no more bytes")

        def break_first(connection):
            if not broken.is_set():
                connection.transport.write = refuse
                with pytest.raises(LinkLostError):
                    robot.set_velocity(0.1, 0.0)
                broken.set()
            return keep(connection)

        link._serve = break_first
        assert broken.wait(LIMIT)
        until(lambda: robot.link.reconnects, "connected again")


def test_started_before_the_robot_is_there():
    firmware = Firmware(find_model("p3dx-sh"), load_world("empty"))
    with Server(firmware, tcp=0) as placeholder:
        port = port_of(placeholder)
    events = []
    robot = Robot("localhost:%d" % port, reconnect=True, on_event=events.append).start()
    with pytest.raises(PortError, match="refused"):
        robot.wait_until_ready(0.3)
    with Server(firmware, tcp=port):
        robot.wait_until_ready(LIMIT)
        robot.close()
    assert [type(event) for event in events].count(LinkDown) >= 1 and events[0].retry_in > 0
    assert robot.link.reconnects == 0


def test_an_unknown_subtype_is_final_even_with_reconnect(server):
    known = server.firmware.model
    server.firmware.hardware.model = type(known)(**dict(known.__dict__, subtype="p3dz-sh"))
    robot = Robot(server.url, reconnect=True).start()
    with pytest.raises(UnknownModelError, match="p3dz-sh.*near: .*p3dx-sh.*model"):
        robot.wait_until_ready(LIMIT)
    assert robot.wait_until_ended(LIMIT), "no further attempt"
    robot.close()
    assert waiting(server)
    with Robot(server.url, model="p3dx-sh") as robot:
        assert robot.identity.model == known.with_arrays(True, True)


def test_nothing_answers():
    import socket
    with socket.create_server(("127.0.0.1", 0)) as deaf:
        with pytest.raises(NoAnswerError, match="nothing answers"):
            with Robot("localhost:%d" % deaf.getsockname()[1]):
                pass


def test_two_clients_on_a_serial_port(server):
    with Robot(server.pty_link):
        with pytest.raises(PortError, match="in use"):
            with Robot(server.pty_link):
                pass


def test_two_clients_on_tcp_the_first_keeps_its_robot(server):
    with Robot(server.url) as first:
        first.enable_motors()
        with pytest.raises((LinkLostError, NoAnswerError)):
            with Robot(server.url):
                pass
        keep_driving(first, 0.2, 0.0, lambda state: state.linear > 0.1)


def test_no_reconnect_comes_between_what_the_sonar_is_told_and_what_it_is_told_after_a_reconnect(server, monkeypatch):
    with Robot(server.url) as robot:
        change, held = robot._link.change, []
        monkeypatch.setattr(robot._link, "change", lambda **settings: (
            held.append(robot._link.changed._is_owned()), change(**settings)))
        robot.set_sonar(False)
        assert held == [True] and not robot.use_sonar
        robot.use_sonar = True
        assert held == [True, False], "and the test would notice"


@pytest.mark.parametrize("closes", [False, True])
def test_a_listener_may_switch_motors_and_close(server, closes):
    said = []

    def listener(event):
        if isinstance(event, Ready):
            robot.enable_motors()
            said.append(robot.state.motors_enabled)
            if closes:
                robot.close()

    robot = Robot(server.url, on_event=listener).start()
    until(lambda: said, "answered")
    assert said == [True]
    if closes:
        assert robot.wait_until_ended(LIMIT)
        until(lambda: waiting(server), "closed")
    robot.close()


def test_the_answer_to_a_request_for_the_motors_is_told(server):
    events = []
    with Robot(server.url, on_event=events.append) as robot:
        robot.request_motors(True)
        until(lambda: MotorsAnswered(True, True, None) in events, "on")
        robot.enable_motors()
        until(lambda: MotorsAnswered(True, False, None) in events, "on again")
        with server.lock:
            server.firmware.press_stop_button(True)
        until(lambda: robot.state.stop_button, "pressed")
        robot.request_motors(True)
        until(lambda: any("STOP button" in str(event.error) for event in events if isinstance(event, MotorsAnswered)),
              "refused")


def test_threads_and_descriptors_are_given_back(server):
    def descriptors():
        return len(os.listdir("/proc/self/fd"))

    with Robot(server.url):
        pass
    until(lambda: not [thread for thread in threading.enumerate() if thread.name.startswith("pioneer ")],
          "no thread left")
    before = descriptors()
    for _ in range(3):
        with Robot(server.pty_link):
            pass
    until(lambda: not [thread for thread in threading.enumerate() if thread.name.startswith("pioneer ")],
          "no thread left")
    assert descriptors() == before
