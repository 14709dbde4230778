"""The simulated robot behind a TCP port and behind a pseudo-terminal. The tests use a bare socket and pyserial."""

import contextlib
import math
import os
import select
import signal
import socket
import subprocess
import sys
import time
from types import SimpleNamespace

import pytest
import serial

from pioneer_control import p2os
from pioneer_control.errors import ParameterError, PortError
from pioneer_control.p2os.recording import entries
from pioneer_control.robots import find_model
from pioneer_control.simulator.line import fault_of
from pioneer_control.simulator.firmware import Firmware, FirmwareState
from pioneer_control.simulator.line.lines import PTY_UNREAD_LIMIT, STANDARD_PORT, PtyLine, TcpLine
from pioneer_control.simulator.line.server import LONGEST_BACKLOG, Server
from pioneer_control.simulator.simulation import Simulation
from pioneer_control.simulator.world import World

from real_time import LIMIT, until


def robot(**options):
    return Firmware(find_model("p3dx-sh"), World("hall"), **options)


class Computer:
    """The far end of a line: sends frames, collects packets."""

    def __init__(self, read, write):
        self._read, self.write = read, write
        self._decoder = p2os.FrameDecoder()
        self.packets = []

    def send(self, name, *values):
        self.write(p2os.encode_command(name, *values))

    def listen(self):
        self.packets += [p2os.decode_packet(frame) for frame in self._decoder.feed(self._read())]
        return self.packets

    def expect(self, kind, count=1):
        """Wait until this many more packets of a class have come."""
        have = sum(isinstance(packet, kind) for packet in self.packets)
        until(lambda: sum(isinstance(packet, kind) for packet in self.listen()) >= have + count, kind.__name__)
        return [packet for packet in self.packets if isinstance(packet, kind)][-1]

    def open(self):
        for number in (0, 1):
            self.write(p2os.encode_frame(number))
            self.expect(p2os.SyncEcho)
        self.write(p2os.encode_frame(2))
        self.expect(p2os.SyncReply)
        self.send("OPEN")
        self.expect(p2os.Sip, 2)


def dial(place, buffer=None):
    """Return a socket that is connected to a server, a line or a berth."""
    host, _, port = place.url[len("socket://"):].rpartition(":")
    line = socket.socket()
    line.settimeout(LIMIT)
    if buffer is not None:
        line.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, buffer)
    line.connect((host, int(port)))
    line.settimeout(0.05)
    return line


def over_tcp(line):
    def read():
        try:
            data = line.recv(4096)
        except socket.timeout:
            return b""
        if not data:
            raise ConnectionError("hung up on")
        return data
    return Computer(read, line.sendall)


@contextlib.contextmanager
def tcp_computer(server):
    with contextlib.closing(dial(server)) as line:
        yield over_tcp(line)


def terminal_of(server, baud):
    """Open the computer's end of the server's terminal at this line speed."""
    return serial.Serial(server.pty_link, baud, timeout=0.05)


@contextlib.contextmanager
def pty_computer(server):
    with contextlib.closing(serial.Serial(server.pty_link, timeout=0.05)) as line:
        yield Computer(lambda: line.read(max(1, line.in_waiting)), line.write)


@pytest.fixture(params=[tcp_computer, pty_computer])
def place(request, tmp_path):
    """Return where a server is to listen, and how to connect to it."""
    return {"tcp": 0} if request.param is tcp_computer else {"pty": str(tmp_path / "robot")}, request.param


@pytest.fixture
def line(place):
    """Return a server with one kind of line, and how to connect to it."""
    options, connect = place
    with Server(robot(), **options) as server:
        yield server, connect


def test_a_session_in_real_time(line):
    server, connect = line
    with connect(server) as computer:
        computer.open()
        computer.send("ENABLE", 1)
        computer.send("VEL", 200)
        until(lambda: computer.expect(p2os.Sip).left_velocity_units == 200, "200 mm/s")
        with server.lock:
            assert server.firmware.motors_enabled

        def takes_time():
            start = time.monotonic()
            computer.expect(p2os.Sip, 20)
            return time.monotonic() - start > 1.0

        # on a busy machine SIPs that nobody has read yet come at once; those behind them do not
        until(takes_time, "20 SIPs at the pace of real time")


def test_a_terminal_at_another_speed_carries_only_noise(tmp_path):
    with Server(robot(), pty=str(tmp_path / "robot")) as server, terminal_of(server, 19200) as port:
        computer = Computer(lambda: port.read(max(1, port.in_waiting)), port.write)
        for _ in range(10):
            computer.write(p2os.encode_frame(0))
            assert computer.listen() == []
        assert server.firmware.session is FirmwareState.WAITING
        port.baudrate = 9600
        computer.open()
        port.baudrate = 115200
        noise = until(lambda: port.read(1), "noise")
        port.baudrate = 9600
        assert noise
        computer.expect(p2os.Sip, 3)


def test_hostbaud_changes_the_speed_until_the_end_of_the_session(tmp_path):
    with Server(robot(), pty=str(tmp_path / "robot")) as server, terminal_of(server, 9600) as port:
        computer = Computer(lambda: port.read(max(1, port.in_waiting)), port.write)
        computer.open()
        computer.send("CONFIG", 1)
        config = computer.expect(p2os.Config)
        assert (config.host_baud, config.autobaud) == (0, 2)
        computer.send("HOSTBAUD", 4)
        until(lambda: server.firmware.baud == 115200, "changed")
        port.baudrate = 115200
        computer.expect(p2os.Sip, 3)
        computer.write(bytes.fromhex("FAFB06323B0900 3B3B".replace(" ", "")))       # there is no code 9
        computer.expect(p2os.Sip, 2)
        assert server.firmware.baud == 115200
        computer.send("CLOSE")
        until(lambda: server.firmware.session is FirmwareState.WAITING, "closed")
        assert server.firmware.baud == 9600
        port.baudrate = 9600
        computer.open()


def test_a_polite_client_can_come_again_and_again(line):
    server, connect = line
    for _ in range(3):
        with connect(server) as computer:
            computer.open()
            computer.send("CLOSE")
            until(lambda: server.firmware.session is FirmwareState.WAITING, "end of the session")


def test_a_rude_client_leaves_the_robot_open_until_the_next_one_closes_it(line):
    server, connect = line
    with connect(server) as computer:
        computer.open()
        computer.send("ENABLE", 1)
        computer.send("VEL", 300)
        until(lambda: server.firmware.velocity[0] == 0.3, "300 mm/s")
    assert server.firmware.session is FirmwareState.OPEN
    until(lambda: server.firmware.watchdog_expired and server.firmware.velocity[0] == 0.0, "stop by the watchdog")
    assert server.firmware.session is FirmwareState.OPEN and server.firmware.motors_enabled
    with connect(server) as computer:
        # not PULSE: any other packet would let it drive on; over TCP the connection alone has done it
        computer.send("CLOSE")
        until(lambda: server.firmware.session is FirmwareState.WAITING, "end of the session")
        assert not server.firmware.motors_enabled
        until(lambda: computer.listen() is None or server.firmware.velocity[0] == 0.0, "standstill")
        computer.open()


def test_twenty_clients_in_a_row_over_tcp_rude_and_polite():
    """A new client gets the same answers as the first one, even when the previous client left the robot driving. A
    client that has sent CLOSE may keep its socket open.
    """
    with Server(robot(), tcp=0, speed=10.0) as server, contextlib.ExitStack() as held:
        for count in range(20):
            line = held.enter_context(contextlib.closing(dial(server)))
            computer = over_tcp(line)
            computer.open()
            assert [type(packet) for packet in computer.packets[:3]] == [p2os.SyncEcho, p2os.SyncEcho, p2os.SyncReply]
            assert not computer.expect(p2os.Sip).flags & p2os.Flags.MOTORS_ENABLED
            computer.send("ENABLE", 1)
            computer.send("RVEL", 30)
            until(lambda: computer.expect(p2os.Sip).type_id == p2os.MOVING, "turning")
            if count % 2:
                computer.send("CLOSE")
                until(lambda: server.firmware.session is FirmwareState.WAITING, "end of the session")
            else:
                line.close()
        assert server.firmware.closed_sessions >= 19


def packets_of(seconds):
    """Return what a robot sends in this time, as one piece for each 0.1 s. Its I/O data are requested, too."""
    firmware = robot()
    for packet in [p2os.encode_frame(number) for number in (0, 1, 2, 1)] + [p2os.encode_command("IOREQUEST", 2)]:
        firmware.receive(packet)
    firmware.advance(0.0)
    return [firmware.advance(0.1) for _ in range(round(seconds * 10))]


def test_a_tcp_client_that_does_not_read_loses_the_oldest_and_finds_whole_packets():
    with contextlib.closing(TcpLine(0)) as line, contextlib.closing(dial(line, buffer=4096)) as client:
        until(lambda: line.read(False) or line.client, "connection")
        said = packets_of(60) * 10
        for packet in said:
            line.write(packet)
        computer = over_tcp(client)
        newest = p2os.decode_packet(p2os.FrameDecoder().feed(said[-1])[-1])
        line.write(p2os.encode_frame(255))
        until(lambda: line.write(b"") or computer.listen()[-1:] == [p2os.Reset(255, b"")], "the last packet")
        heard = len(computer.packets)
        assert 100 < heard < len(said)
        assert not any(isinstance(packet, (p2os.MalformedPacket, p2os.UnknownPacket)) for packet in computer.packets)
        assert computer.packets[-2] == newest


def test_what_a_tcp_client_sent_before_it_closed_is_read_also_after_a_write_failed():
    with contextlib.closing(TcpLine(0)) as line:
        with contextlib.closing(dial(line)) as client:
            until(lambda: line.read(False) or line.client, "connection")
            client.sendall(b"bye")
        poll = select.poll()
        poll.register(line.client, select.POLLIN)
        line.write(b"a packet")     # nobody is there to take it, so the client's computer answers with a reset
        until(lambda: any(event & select.POLLERR for _, event in poll.poll(0)), "the reset")
        line.write(b"another packet")
        assert line.read(False) == b"bye"
        assert (line.read(False), line.client) == (b"", None)


def test_a_terminal_that_nobody_reads_keeps_the_newest(tmp_path):
    with contextlib.closing(PtyLine(str(tmp_path / "robot"))) as line:
        said = packets_of(60) * 10
        for packet in said:
            line.write(packet)
        with contextlib.closing(serial.Serial(line.link, timeout=0.2)) as client:
            # pyserial forgets on opening what came before, as far as the kernel has brought it across; what comes now
            # arrives
            newest, heard = p2os.encode_frame(255), bytearray()
            line.write(newest)
            until(lambda: heard.extend(client.read(100)) or heard.endswith(newest), "the newest")
            assert len(heard) <= PTY_UNREAD_LIMIT + len(said[-1]) + len(newest)


def test_close_makes_room_though_the_old_socket_stays_open():
    with Server(robot(), tcp=0) as server, tcp_computer(server) as first:
        first.open()
        first.send("CLOSE")
        until(lambda: server.firmware.session is FirmwareState.WAITING, "end of the session")
        with tcp_computer(server) as second:
            second.open()
        assert server.firmware.session is FirmwareState.OPEN


def test_a_second_client_is_turned_away():
    with Server(robot(), tcp=0) as server, tcp_computer(server) as first:
        first.open()
        with contextlib.closing(dial(server)) as intruder:
            intruder.settimeout(LIMIT)
            assert intruder.recv(10) == b""
        first.expect(p2os.Sip, 3)


def test_two_lines_one_client(tmp_path):
    with Server(robot(), tcp=0, pty=str(tmp_path / "robot")) as server:
        with pty_computer(server) as first:
            first.open()
            with contextlib.closing(dial(server)) as intruder:
                intruder.settimeout(LIMIT)
                first.send("PULSE")
                assert intruder.recv(10) == b""
            first.send("CLOSE")
            until(lambda: server.firmware.session is FirmwareState.WAITING, "end of the session")
        with tcp_computer(server) as second:
            second.open()


def test_old_news_is_not_kept_in_a_terminal(tmp_path):
    with contextlib.closing(PtyLine(str(tmp_path / "robot"))) as line:
        forgotten = 0
        for packet in packets_of(60):
            before = line.unread
            line.write(packet)
            until(lambda: line.unread in (before + len(packet), len(packet)),
                  "the packet, brought across by the kernel")
            forgotten += line.unread < before
            assert line.unread <= PTY_UNREAD_LIMIT + len(packet)
        assert forgotten > 20


def test_twenty_clients_after_each_other_every_second_one_rude(place):
    options, connect = place

    def close(computer):
        computer.send("CLOSE")
        until(lambda: server.firmware.session is FirmwareState.WAITING, "end of the session")

    with Server(robot(), speed=5.0, **options) as server:
        for number in range(20):
            with connect(server) as computer:
                if number % 2:
                    close(computer)     # what the one before left open
                computer.open()
                if number % 2:
                    close(computer)


def test_who_comes_before_the_end_of_the_session_was_read_is_let_in_after_it():
    with contextlib.closing(TcpLine(0)) as line, contextlib.closing(dial(line)) as first:
        until(lambda: line.read(False) or line.client, "connection")
        first.sendall(b"bye")
        with contextlib.closing(dial(line)) as second:
            until(lambda: line.read(False) == b"bye", "the end")
            line.finished = True
            second.sendall(b"hello")
            until(lambda: line.read(False) == b"hello", "the next client")


def test_who_comes_while_the_end_of_the_session_is_read_is_let_in_after_it():
    with contextlib.ExitStack() as stack:
        line = stack.enter_context(contextlib.closing(TcpLine(0)))
        first = stack.enter_context(contextlib.closing(dial(line)))
        until(lambda: line.read(False) or line.client, "connection")
        second = []
        receive = line._receive

        def just_before_the_end_comes(*flags):
            data = receive(*flags)
            if not second:
                first.sendall(b"bye")
                first.close()
                second.append(stack.enter_context(contextlib.closing(dial(line))))
            return data

        line._receive = just_before_the_end_comes
        assert line.read(False) == b""
        until(lambda: line.read(False) == b"bye", "the end")
        line.finished = True
        second[0].sendall(b"hello")
        until(lambda: line.read(False) == b"hello", "the next client")


def test_clients_that_follow_at_once_are_all_let_in():
    opening = b"".join(map(p2os.encode_frame, (0, 1, 2, 1)))
    with Server(robot(), tcp=0, speed=20.0) as server:
        for number in range(100):
            with contextlib.closing(dial(server)) as line:
                line.settimeout(LIMIT)
                line.sendall(opening)
                assert line.recv(6) == p2os.encode_frame(0), "client %d" % number
                if number % 2:
                    line.sendall(p2os.encode_command("CLOSE"))


# -- several robots

@pytest.fixture
def three(tmp_path):
    """Return a server of three robots, each at a TCP port and a pseudo-terminal."""
    simulation = Simulation(World("hall", starts=[(0.0, 3.0 * row, 0.0) for row in range(3)]))
    for number in range(3):
        simulation.add(find_model("p3dx-sh"), name="robot%d" % (number + 1))
    with Server(simulation, tcp=0, pty=str(tmp_path / "robot")) as server:
        yield server


def test_each_robot_has_its_own_lines(three, tmp_path):
    assert [berth.pty_link for berth in three.berths] == [str(tmp_path / ("robot%d" % number)) for number in (1, 2, 3)]
    with contextlib.ExitStack() as stack:
        computers = [stack.enter_context(connect(berth))
                     for berth, connect in zip(three.berths, (tcp_computer, pty_computer, tcp_computer))]
        for number, computer in enumerate(computers, 1):
            computer.open()
            reply, = [packet for packet in computer.packets if isinstance(packet, p2os.SyncReply)]
            assert reply.name == "robot%d" % number
        computers[1].send("ENABLE", 1)
        computers[1].send("VEL", 200)
        until(lambda: computers[1].expect(p2os.Sip).left_velocity_units == 200, "200 mm/s")
        assert [computer.expect(p2os.Sip).left_velocity_units for computer in (computers[0], computers[2])] == [0, 0]
        with pytest.raises(PortError, match="in use"):
            Server(robot(), tcp=int(three.berths[2].url.rpartition(":")[2]))
        computers[2].send("CLOSE")
        until(lambda: three.berths[2].robot.session is FirmwareState.WAITING, "end of its session alone")
        assert [berth.robot.session for berth in three.berths[:2]] == [FirmwareState.OPEN] * 2


def test_several_robots_have_ports_that_follow_each_other():
    host = "127.%d.%d.%d" % tuple(os.getpid().to_bytes(3, "big"))      # where no other test takes the port that follows
    with contextlib.closing(socket.create_server((host, 0))) as placeholder:
        port = placeholder.getsockname()[1]
    simulation = Simulation(World("hall", starts=[(0.0, 0.0, 0.0), (0.0, 3.0, 0.0)]))
    for _ in range(2):
        simulation.add(find_model("amigo-sh"))
    with Server(simulation, tcp="%s:%d" % (host, port)) as server:
        expected = ["socket://%s:%d" % (host, each) for each in (port, port + 1)]
        assert [berth.url for berth in server.berths] == expected
        assert not server.open_to_others


def test_other_machines_only_when_asked():
    with Server(robot(), tcp="0.0.0.0:0") as server:
        assert server.open_to_others


# -- the time of a serial line

def test_a_terminal_takes_the_time_of_a_serial_line(tmp_path):
    """At 9600 baud a SIP takes about 45 ms, so it never comes in one piece."""
    with Server(robot(), pty=str(tmp_path / "robot"),
                record=str(tmp_path / "wire.txt")) as server, pty_computer(server) as computer:
        computer.open()
        computer.expect(p2os.Sip, 5)
    pieces = [entry for entry in entries((tmp_path / "wire.txt").read_text().splitlines()) if not entry.to_robot]
    assert max(len(entry.data) for entry in pieces[20:]) <= 16 * 3
    starts = [number for number, entry in enumerate(pieces) if entry.data[:2] == b"\xFA\xFB" and
              entry.data[3] in (0x32, 0x33)]
    for start, following in zip(starts[:3], starts[1:]):
        sip = pieces[start:following]
        seconds = sum(len(entry.data) for entry in sip[1:]) * 10 / 9600
        assert sip[-1].time - sip[0].time == pytest.approx(seconds, abs=0.002)


def test_what_is_written_too_fast_waits_in_the_terminal_and_nothing_is_lost(tmp_path):
    with Server(robot(), pty=str(tmp_path / "robot")) as server, pty_computer(server) as computer:
        computer.open()
        with server.lock:
            before = server.firmware.command_counts["obeyed"]
        for _ in range(300):    # 1.9 s of line
            computer.send("PULSE")
        until(lambda: server.simulation.backlog(0) > LONGEST_BACKLOG, "a busy line")
        until(lambda: server.firmware.command_counts["obeyed"] >= before + 300, "every command obeyed")
        computer.expect(p2os.Sip, 2)


# -- real time and other times

@pytest.mark.parametrize("speed", [0.25, 10.0])
def test_speed_is_simulated_seconds_in_a_real_one(speed):
    start = time.monotonic()    # before the server's own start: on a busy machine it begins late, and then catches up
    with Server(robot(), tcp=0, speed=speed) as server:
        until(lambda: server.simulation.time > speed / 2, "some time")
        with server.lock:
            end, simulated = time.monotonic(), server.simulation.time
        assert simulated <= (end - start) * speed + 0.05


@pytest.mark.parametrize("speed", [0.0, -1.0, 1000.0, float("nan")])
def test_a_senseless_speed(speed):
    with pytest.raises(ParameterError, match="speed .* is not legal: give a number from 0.01 to 100"):
        Server(robot(), tcp=0, speed=speed)


def simulated(server):
    with server.lock:
        return server.simulation.time


def test_time_stands_while_it_is_paused_and_the_robot_still_answers():
    with Server(robot(), tcp=0) as server, tcp_computer(server) as computer:
        computer.open()
        with server.lock:
            server.pace.paused = True
            paused_at = server.simulation.time
            answered = server.firmware.command_counts["obeyed"]
        server.wake()
        for _ in range(20):
            computer.send("PULSE")
        computer.send("CONFIG")
        computer.expect(p2os.Config)
        assert simulated(server) == paused_at
        assert server.firmware.command_counts["obeyed"] == answered + 21
        with server.lock:
            server.pace.paused = False
        server.wake()
        computer.expect(p2os.Sip, 2)
        assert simulated(server) > paused_at


@pytest.fixture
def sleepy_server(monkeypatch):
    """Return a server that has answered once, and then waits for a quarter of an hour if nobody wakes it."""
    monkeypatch.setattr("pioneer_control.simulator.line.line_simulation.LONGEST_REST_US", 10 * 1000000)
    with Server(robot(), tcp=0, speed=0.01) as server, tcp_computer(server) as computer:
        computer.write(p2os.encode_frame(0))
        computer.expect(p2os.SyncEcho)
        yield server


def test_another_speed_counts_at_once(sleepy_server):
    with sleepy_server.lock:
        sleepy_server.pace.speed = 100.0
    sleepy_server.wake()
    until(lambda: simulated(sleepy_server) > 1.0, "a second at the new speed")


def test_a_slow_server_ends_at_once(sleepy_server):
    sleepy_server.stop(LIMIT)
    assert not sleepy_server.running
    sleepy_server.wake()    # nothing is left to wake


# -- faults

def test_a_pulled_cable_hangs_up_and_nobody_is_let_in_until_it_is_back(line):
    server, connect = line
    with connect(server) as computer:
        computer.open()
        with server.lock:
            server.simulation.faults.add(fault_of("cable to 0.5"), server.simulation.clock.now_us)
        with pytest.raises((OSError, serial.SerialException)):
            until(lambda: computer.listen() is None, "hung up on")
    with pytest.raises((OSError, serial.SerialException)):
        with connect(server) as computer:       # refused; or hung up on, if it comes just before the port is closed
            until(lambda: computer.listen() is None or not server.simulation.links[0].unplugged, "hung up on")
            raise OSError("a slow machine: it is back already")

    def back():
        with server.lock:
            return not server.simulation.links[0].unplugged

    until(back, "cable back")
    assert server.firmware.session is FirmwareState.OPEN
    with connect(server) as computer:
        computer.send("CLOSE")
        until(lambda: server.firmware.session is FirmwareState.WAITING, "end of the session")
        computer.open()


def test_faults_are_named_and_what_went_over_the_line_is_recorded(tmp_path):
    said, path = [], tmp_path / "wire.txt"
    with Server(robot(), tcp=0, faults=[fault_of("loss 1 way from-robot from 0.1 to 1")], say=said.append,
                record=str(path)) as server:
        with tcp_computer(server) as computer:
            for number in (0, 1, 2, 1):
                computer.write(p2os.encode_frame(number))
            until(lambda: len(said) == 2, "begin and end")
            computer.expect(p2os.Sip, 2)
    assert said == ["0.100 s: fault begins: loss 1 way from-robot", "1.000 s: fault ends: loss 1 way from-robot"]
    recorded = list(entries(path.read_text().splitlines()))
    assert [entry.note for entry in recorded if entry.note] == [text.partition(": ")[2] for text in said]
    assert b"".join(entry.data for entry in recorded if entry.to_robot).startswith(
        b"".join(map(p2os.encode_frame, (0, 1, 2, 1))))
    assert not [entry for entry in recorded if not entry.to_robot and 0.1 < entry.time < 1.0]
    assert [entry for entry in recorded if not entry.to_robot and entry.time > 1.0]


def test_what_cannot_be_recorded_or_spoilt_is_told_before_anything_is_open(tmp_path):
    link = tmp_path / "robot"
    with pytest.raises(ParameterError, match="cannot record to /nowhere/wire: No such file"):
        Server(robot(), pty=str(link), record="/nowhere/wire")
    with pytest.raises(ParameterError, match="there is no robot 2"):
        Server(robot(), pty=str(link), faults=[fault_of("cable robot 2")])
    assert not os.path.lexists(str(link))


# -- links and ports

def test_the_link_is_removed_and_a_stale_one_replaced(tmp_path):
    link = tmp_path / "robot"
    link.symlink_to("/dev/pts/999999")
    with Server(robot(), pty=str(link)):
        assert os.path.realpath(str(link)).startswith("/dev/pts/") and link.exists()
    assert not os.path.lexists(str(link))


def test_what_is_not_our_link_is_left_alone(tmp_path):
    precious = tmp_path / "thesis.tex"
    precious.write_text("words")
    pointer = tmp_path / "pointer"
    pointer.symlink_to(precious)
    for path in (precious, pointer, tmp_path):
        with pytest.raises(PortError, match="is not the link of a simulated robot"):
            Server(robot(), pty=str(path))
    assert precious.read_text() == "words" and pointer.is_symlink()
    with pytest.raises(PortError, match="No such file or directory"):
        Server(robot(), pty=str(tmp_path / "nowhere" / "robot"))


def test_a_link_that_somebody_else_took_over_is_left_to_him(tmp_path):
    link = str(tmp_path / "robot")
    first = Server(robot(), pty=link).start()
    with Server(robot(), pty=link) as second:
        first.stop()
        assert os.path.realpath(link) == second._lines[0].device


def test_a_port_in_use_says_what_to_do(tmp_path):
    with Server(robot(), tcp=0) as server:
        port = int(server.url.rpartition(":")[2])
        with pytest.raises(PortError, match="TCP port %s is in use.*choose another port" % port):
            Server(robot(), tcp=port, pty=str(tmp_path / "robot"))
    assert not os.path.lexists(str(tmp_path / "robot"))
    with Server(robot(), tcp=port):
        pass


@pytest.mark.parametrize("address", ["abc", 65536, "host:x", -1])
def test_a_senseless_port(address):
    with pytest.raises(PortError, match="is no TCP port"):
        Server(robot(), tcp=address)


def test_the_standard_port_is_used_when_no_line_is_asked_for(monkeypatch):
    assert STANDARD_PORT == 8101
    monkeypatch.setattr("pioneer_control.simulator.line.server.STANDARD_PORT", 0)    # another simulator may have it
    with Server(robot()) as simulator:
        assert simulator.url.startswith("socket://127.0.0.1:")


def test_stop_before_start_and_twice(tmp_path):
    server = Server(robot(), tcp=0, pty=str(tmp_path / "robot"))
    server.stop()
    server.stop()
    assert not server.running and not os.path.lexists(str(tmp_path / "robot"))


# -- the command line

@contextlib.contextmanager
def program(*arguments):
    with subprocess.Popen(
        [sys.executable, "-m", "pioneer_control.simulator", *arguments],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, universal_newlines=True,
    ) as process:
        try:
            yield process
        finally:
            process.kill()


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_the_program_says_where_to_connect_and_ends_cleanly(tmp_path, number):
    link = tmp_path / "robot"
    with program("--tcp", "0", "--pty", str(link), "--world", "empty") as process:
        said = [process.stdout.readline() for _ in range(4)]
        assert "p3dx-sh stands in the world 'empty'" in said[0] and said[2].strip() == str(link)
        host, _, port = said[1].strip()[len("socket://"):].rpartition(":")
        with contextlib.closing(socket.create_connection((host, int(port)), timeout=LIMIT)) as line:
            over_tcp(line).open()
        process.send_signal(number)
        assert process.wait(LIMIT) == 0 and process.stderr.read() == ""
    assert not os.path.lexists(str(link))


@pytest.mark.parametrize("arguments, code, message", [
    (("--model", "p3dx-hs"), 2, "unknown robot model 'p3dx-hs'"),
    (("--world", "nowhere"), 2, "no world named 'nowhere'"),
    (("--gripper", "--model", "amigo-sh"), 2, "amigo-sh cannot carry a gripper"),
    (("--tcp", "seven"), 1, "is no TCP port"),
    (("--numbers", "/nowhere.yaml"), 2, "cannot read /nowhere.yaml"),
    (("--fault", "los 0.1"), 2, "no kind 'los'; did you mean 'loss'? there are loss"),
    (("--fault", "cable robot 2"), 2, "there is no robot 2"),
    (("--faults", "/nowhere.yaml"), 2, "cannot read /nowhere.yaml"),
    (("--record", "/nowhere/wire"), 2, "cannot record to /nowhere/wire"),
    (("--speed", "0"), 2, "speed 0.0 is not legal"),
    (("--lockstep", "0"), 2, "lockstep 0.0 is not legal: give a number of seconds from 0.05 to 3600"),
    (("--lockstep", "--robots", "2"), 2, "lockstep is for one simulated robot on a TCP port"),
    (("--robots", "500", "--world", "office"), 2, "has room for"),
])
def test_mistakes_are_told_in_one_line(arguments, code, message):
    with program(*arguments) as process:
        errors = process.communicate(timeout=LIMIT)[1]
        assert process.returncode == code and message in errors and errors.count("\n") == 1


def test_a_fleet_on_the_command_line(tmp_path):
    """Everything at once: robots, faults from words and from a file, a record, time ten times as fast, and the
    explained record.
    """
    faults, record = tmp_path / "faults.yaml", tmp_path / "wire.txt"
    faults.write_text("- {fault: stop_button, robot: 2, from: 0.2}")
    with program("--robots", "3", "--tcp", "0", "--pty", str(tmp_path / "robot"), "--speed", "10", "--seed", "4",
                 "--fault", "gyro 1 from 0.1 to 0.3",
                 "--faults", str(faults), "--record", str(record)) as process:
        said = [process.stdout.readline().strip() for _ in range(8)]
        assert (said[0] == "3 simulated p3dx-sh stand in the world 'tutorial'. Connect to them at" and
                said[4] == "Ctrl-C ends it.")
        names, urls, links = zip(*(line.split() for line in said[1:4]))
        assert names == ("sim_0001", "sim_0002", "sim_0003") and links[2] == str(tmp_path / "robot3")
        assert said[5:] == ["0.100 s: fault begins: gyro 1", "0.200 s: fault begins: stop_button robot 2",
                            "0.300 s: fault ends: gyro 1"]
        host, _, port = urls[1][len("socket://"):].rpartition(":")
        with contextlib.closing(socket.create_connection((host, int(port)), timeout=LIMIT)) as line:
            computer = over_tcp(line)
            computer.open()
            assert computer.expect(p2os.Sip).flags & p2os.Flags.STOP_BUTTON
        process.send_signal(signal.SIGINT)
        assert process.wait(LIMIT) == 0 and process.stderr.read() == ""
    told = subprocess.run([sys.executable, "-m", "pioneer_control.p2os", "--record", str(record)],
                          stdout=subprocess.PIPE, check=True).stdout.decode()
    assert ("robot 2 <- OPEN" in told and "robot 2 -> SyncReply: name 'sim_0002'" in told and
            "fault begins: stop_button robot 2" in told)


@pytest.mark.parametrize("text", ["0", "-1", "x", "2001"])
def test_a_senseless_number_of_robots(text):
    with program("--robots", text) as process:
        assert "give a whole number from 1 to 2000" in process.communicate(timeout=LIMIT)[1] and process.returncode == 2


def test_listening_to_other_machines_is_told():
    with program("--tcp", "0.0.0.0:0") as process:
        assert "every machine that reaches this one can drive it" in process.stderr.readline()


def test_what_a_round_takes_delays_no_later_one(monkeypatch):
    """On a clock of the test: each round of the server takes 3 ms, and it wakes when the next step of time is due."""
    server = Server(robot(), tcp=0)
    server.watched, clock, late = True, [100.0], []
    monkeypatch.setattr("pioneer_control.simulator.line.server.time", SimpleNamespace(monotonic=lambda: clock[0]))
    run_to = server.simulation.run_to

    def work(now_us):
        clock[0] += 0.003
        return run_to(now_us)

    def sleep(timeout):
        clock[0] += math.ceil(timeout * 1e3) * 1e-3     # as epoll waits
        late.append(server.pace.due_us(clock[0]) - server.simulation.next_us)
        if len(late) == 20:
            server._stopping.set()
        return []

    monkeypatch.setattr(server.simulation, "run_to", work)
    monkeypatch.setattr(server, "_selector", SimpleNamespace(select=sleep, close=server._selector.close))
    server._run()
    assert len(late) == 20 and all(0 <= each <= 1000 for each in late[2:]), late     # us; it begins on a whole ms
