"""Ports of every kind, and the errors of ports that do not open."""

import errno
import grp
import os
import pty
import select
import socket
import stat
import sys
import threading
import types

import pytest
import serial

from serial.tools import list_ports

from pioneer_control.client import serial_port, transport
from pioneer_control.client.ports import is_serial, open_transport
from pioneer_control.client.tcp import is_lockstep, tcp_address
from pioneer_control.errors import LinkLostError, PortError


@pytest.mark.parametrize("url, address", [
    ("socket://localhost:8101", ("localhost", 8101)), ("10.0.0.7:8101", ("10.0.0.7", 8101)),
    ("tcp://robot:9000", ("robot", 9000)), ("robot:9000", ("robot", 9000)), ("socket://robot", ("robot", 8101)),
    ("socket://[::1]:5", ("::1", 5)), ("[::1]:5", ("::1", 5)), ("socket://robot:9000?lockstep", ("robot", 9000)),
    ("/dev/ttyUSB0", None), ("/tmp/pty:1", None), ("COM1", None)])
def test_the_url_chooses(url, address):
    assert tcp_address(url) == address
    assert is_lockstep(url) == ("lockstep" in url)
    assert is_serial(url) == (address is None)


@pytest.fixture(params=["waited for", "polled"])
def every_way(request, monkeypatch):
    """Serial ports as everywhere, and as on Windows."""
    monkeypatch.setattr(serial_port, "POLLED", request.param == "polled")
    return request.param


@pytest.fixture
def pseudo_terminal():
    master, slave = pty.openpty()
    os.set_blocking(master, False)
    yield master, os.ttyname(slave)
    for descriptor in (master, slave):
        try:
            os.close(descriptor)
        except OSError:
            pass


@pytest.fixture
def peer():
    listener = socket.create_server(("127.0.0.1", 0))
    listener.settimeout(5)
    yield listener
    listener.close()


def url_of(listener):
    return "socket://127.0.0.1:%d" % listener.getsockname()[1]


def connected(listener):
    line = open_transport(url_of(listener), 9600)
    other, _ = listener.accept()
    other.settimeout(5)
    return line, other


def test_a_pty_carries_every_byte_both_ways(pseudo_terminal, every_way):
    master, path = pseudo_terminal
    line = open_transport(path, 38400)
    every = bytes(range(256))
    line.write(every)
    assert os.read(master, 1000) == every
    os.write(master, every)
    received = b""
    while len(received) < len(every):
        received += line.read(5.0)
    assert received == every
    assert line.baud == 38400
    line.set_baud(9600)
    assert line.baud == 9600
    line.close()


def test_tcp_carries_every_byte_both_ways(peer):
    line, other = connected(peer)
    every = bytes(range(256))
    line.write(every)
    assert other.recv(1000) == every
    other.sendall(every)
    assert line.read(5.0) == every
    assert line.baud is None
    other.close()
    line.close()


def test_a_read_of_a_serial_port_without_bytes_ends_empty_and_can_be_woken(pseudo_terminal, every_way):
    line = open_transport(pseudo_terminal[1], 9600)
    assert line.read(0.01) == b"" and line.read(-1.0) == b""
    line.wake()
    assert line.read(60.0) == b""
    waiting = threading.Thread(target=line.read, args=(60.0,))
    waiting.start()
    line.wake()
    waiting.join(5.0)
    assert not waiting.is_alive()
    line.close()


def test_a_serial_port_that_takes_no_bytes_is_lost(pseudo_terminal, every_way):
    line = open_transport(pseudo_terminal[1], 9600)
    with pytest.raises(LinkLostError, match="takes no more bytes"):
        for _ in range(100):
            line.write(bytes(1000))
    os.read(pseudo_terminal[0], 100000)     # else closing would wait for these bytes
    line.close()


def test_a_read_without_bytes_ends_empty(peer):
    line, other = connected(peer)
    assert line.read(0.01) == b"" and line.read(-1.0) == b""
    other.close()
    line.close()


def test_a_read_can_be_woken(peer):
    line, other = connected(peer)
    for _ in range(100000):
        line.wake()
    assert line.read(60.0) == b""
    while line.read(0.0) or select.select([line._wake_reader], [], [], 0)[0]:
        pass
    waiting = threading.Thread(target=line.read, args=(60.0,))
    waiting.start()
    line.wake()
    waiting.join(5.0)
    assert not waiting.is_alive()
    other.close()
    line.close()


def test_the_last_bytes_arrive_though_unread_input_waits(peer):
    line, other = connected(peer)
    other.sendall(b"SIP" * 1000)
    line.write(b"CLOSE")
    closing = threading.Thread(target=line.close)
    closing.start()
    assert other.recv(100) == b"CLOSE" and other.recv(100) == b""
    other.close()
    closing.join(5.0)
    assert not closing.is_alive()


@pytest.mark.parametrize("leave", ["close", "reset"])
def test_the_other_side_is_gone_tcp(peer, leave):
    line, other = connected(peer)
    if leave == "reset":
        other.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, b"\1\0\0\0\0\0\0\0")
    other.close()
    with pytest.raises(LinkLostError, match="127.0.0.1"):
        line.read(5.0)
    line.close()


def test_the_other_side_is_gone_pty(pseudo_terminal, every_way):
    master, path = pseudo_terminal
    line = open_transport(path, 9600)
    os.close(master)
    with pytest.raises(LinkLostError, match=path):
        line.read(5.0)
    with pytest.raises(LinkLostError, match=path):
        line.write(b"too late")
    line.close()


def test_an_unplugged_adapter_that_fails_once_more_at_its_end_ends_no_program(pseudo_terminal, monkeypatch, every_way):
    def fail():
        raise OSError(errno.EIO, os.strerror(errno.EIO))

    line = open_transport(pseudo_terminal[1], 9600)
    close = line._port.close
    monkeypatch.setattr(line._port, "close", fail)
    line.close()
    close()


def test_a_line_that_takes_no_bytes_is_lost(peer):
    line, other = connected(peer)
    with pytest.raises(LinkLostError, match="takes no more bytes"):
        for _ in range(1000):
            line.write(bytes(100000))
    other.close()
    line.close()


def test_a_write_that_the_line_takes_in_parts_arrives_whole(peer):
    line, other = connected(peer)
    data = os.urandom(5_000_000)
    received = []

    def receive():
        while sum(map(len, received)) < len(data):
            received.append(other.recv(65536))

    receiving = threading.Thread(target=receive)
    receiving.start()
    line.write(data)
    receiving.join(5.0)
    assert b"".join(received) == data
    other.close()
    line.close()


def test_a_serial_port_is_locked(pseudo_terminal):
    _, path = pseudo_terminal
    line = open_transport(path, 9600)
    with pytest.raises(PortError, match="in use by another program"):
        open_transport(path, 9600)
    line.close()
    open_transport(path, 9600).close()


def test_no_such_port_names_those_that_are_there(monkeypatch):
    monkeypatch.setattr(list_ports, "comports", lambda: [types.SimpleNamespace(device="/dev/ttyUSB7")])
    message = "/dev/nonesuch: no such port.*/dev/ttyUSB7.*pioneer_control.simulator.*in ROS.*sim:=true"
    with pytest.raises(PortError, match=message):
        open_transport("/dev/nonesuch", 9600)
    monkeypatch.setattr(list_ports, "comports", lambda: [])
    with pytest.raises(PortError, match="machine: none"):
        open_transport("/dev/nonesuch/port", 9600)


def test_no_such_pseudo_terminal_speaks_of_the_simulated_robot(tmp_path):
    with pytest.raises(PortError, match="no such port. Does the simulated robot run"):
        open_transport(str(tmp_path / "line"), 9600)


@pytest.mark.parametrize("mode, gid, message", [
    (0o660, 20, "group dialout .*usermod -a -G dialout"),
    (0o660, 54321, "usermod -a -G 54321"),
    (0o600, 20, "Only its owner"),
])
def test_no_permission_names_the_group_and_the_command(monkeypatch, mode, gid, message):
    def refuse(*_, **__):
        raise serial.SerialException(errno.EACCES, "Permission denied")

    monkeypatch.setattr(serial, "Serial", refuse)
    port, groups = types.SimpleNamespace(st_mode=stat.S_IFCHR | mode, st_gid=gid), {20: "dialout"}
    monkeypatch.setattr(serial_port.os, "stat", lambda path: port)
    monkeypatch.setattr(
        grp, "getgrgid", lambda number: types.SimpleNamespace(gr_name=groups[number]))
    with pytest.raises(PortError, match="/dev/ttyUSB0: no permission.*" + message):
        open_transport("/dev/ttyUSB0", 9600)


def test_busy_by_the_kernels_word(monkeypatch):
    def refuse(*_, **__):
        raise serial.SerialException(errno.EBUSY, "Device or resource busy")

    monkeypatch.setattr(serial, "Serial", refuse)
    with pytest.raises(PortError, match="in use"):
        open_transport("/dev/ttyUSB0", 9600)


@pytest.mark.parametrize("url, message", [
    (__file__, "not a serial port"), ("/dev/null", "not a serial port"),
    ("http://robot:1", "cannot understand"), ("/dev/ttyUSB0?lockstep", "needs a simulated robot on TCP; give socket:"),
    ("socket://localhost:1?lockstpe", "cannot understand"), ("8501", "give socket://localhost:8501"),
    ("socket://..:1", "no such host"), ("socket://no.such.host.invalid:1", "no such host"),
    ("socket://localhost:99999999", "no TCP port 99999999"),
])
def test_other_ports_that_do_not_open(url, message):
    with pytest.raises(PortError, match=message):
        open_transport(url, 9600)


def test_windows_says_itself_why_a_port_does_not_open(monkeypatch):
    def refuse(*_, **__):
        raise serial.SerialException("could not open port 'COM9': PermissionError(13, 'Access is denied.', None, 5)")

    monkeypatch.setattr(serial_port, "POLLED", True)
    monkeypatch.setattr(serial, "Serial", refuse)
    monkeypatch.setattr(list_ports, "comports", lambda: [types.SimpleNamespace(device="COM3")])
    with pytest.raises(PortError, match="^COM9: could not open .*Access is denied.*Serial ports of this machine: COM3"):
        open_transport("COM9", 9600)


def test_a_serial_port_without_pyserial_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "serial", None)
    with pytest.raises(PortError, match="/dev/ttyUSB0: .*pip install pyserial"):
        open_transport("/dev/ttyUSB0", 9600)


def test_a_silly_baud_rate(pseudo_terminal):
    with pytest.raises(PortError, match="-5|baud"):
        open_transport(pseudo_terminal[1], -5)


def test_a_speed_that_the_adapter_does_not_have_loses_the_link_and_nothing_worse(pseudo_terminal, every_way):
    line = open_transport(pseudo_terminal[1], 9600)
    with pytest.raises(LinkLostError, match="cannot change to -1 baud"):
        line.set_baud(-1)
    assert line.baud == 9600
    line.close()


def test_connection_refused_mentions_the_simulator(peer):
    url = url_of(peer)
    peer.close()
    with pytest.raises(PortError, match="refused.*pioneer_control.simulator.*sim:=true"):
        open_transport(url, 9600)


def test_a_host_that_never_answers(monkeypatch):
    def hang(*_, **__):
        raise socket.timeout("timed out")

    monkeypatch.setattr(socket, "create_connection", hang)
    with pytest.raises(PortError, match="no answer from robot within 3 s"):
        open_transport("robot:8101", 9600)


def test_a_tapped_line_tells_of_every_byte_in_its_order_and_of_what_closing_drops(peer):
    line, other = connected(peer)
    told = []
    transport.tap(line, lambda to_robot, data: told.append((to_robot, data)))
    assert line.read(0.0) == b""
    line.write(b"question")
    assert other.recv(100) == b"question"
    other.sendall(b"answer")
    assert line.read(5.0) == b"answer"
    other.sendall(b"late")
    other.close()
    line.close()
    assert told == [(True, b"question"), (False, b"answer"), (False, b"late")]


def test_a_question_is_told_of_before_its_answer_can_be():
    line = types.SimpleNamespace(read=None, write=lambda data: told.append("written"))
    told = []
    transport.tap(line, lambda to_robot, data: told.append(data))
    line.write(b"question")
    assert told == [b"question", "written"]
