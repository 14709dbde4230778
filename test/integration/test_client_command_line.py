"""``python3 -m pioneer_control.client PORT`` as a user runs it: what it prints and how it ends. Nothing ever moves."""

import os
import re
import signal
import socket
import subprocess
import sys
import threading

import pytest

from pioneer_control import p2os
from pioneer_control.client.ports import open_transport
from pioneer_control.errors import PortError
from pioneer_control.robots import find_model
from pioneer_control.simulator.firmware import Firmware, FirmwareState
from pioneer_control.simulator.world import load_world
from pioneer_control.simulator.line import Server

from real_time import LIMIT, until

COMMAND = [sys.executable, "-m", "pioneer_control.client"]
MOTION = {"VEL", "RVEL", "VEL2", "MOVE", "ROTATE", "HEAD", "DHEAD", "DCHEAD"}


class Recorder(Firmware):
    """A simulated robot that remembers the commands it got."""

    def __init__(self, *arguments, **options):
        super().__init__(*arguments, **options)
        self.told = []
        self._recording = p2os.FrameDecoder()

    def receive(self, data):
        self.told += [p2os.decode_command(frame) for frame in self._recording.feed(data)]
        super().receive(data)


def run(*arguments):
    return subprocess.run(COMMAND + list(arguments), stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                          universal_newlines=True, timeout=LIMIT)


def firmware(**options):
    return Recorder(find_model("p3dx-sh"), load_world("empty"), **options)


@pytest.fixture
def server(tmp_path):
    with Server(firmware(name="rosie"), tcp=0, pty=str(tmp_path / "robot")) as running:
        yield running


def rows(text):
    words = "STOP button"       # all other names are one
    return dict((words, line[len(words):].strip()) if line.startswith(words) else line.split(None, 1)
                for line in text.splitlines())


@pytest.mark.parametrize("line", ["tcp", "pty"])
def test_the_report(server, line):
    port = server.url if line == "tcp" else server.pty_link
    result = run(port)
    assert (result.returncode, result.stderr) == (0, "")
    report = rows(result.stdout)
    assert (report["name"] == "rosie" and report["model"].startswith("p3dx-sh") and
            report["firmware"].startswith("ARCOS 2.9"))
    assert (report["battery"] == "13.0 V (alarm at 11.5 V)" and report["motors"] == "off" and
            report["STOP button"] == "released")
    assert (report["limits"].startswith("0.75 m/s, 100 deg/s") and
            report["gripper"] == "paddles open, lift up, beams clear")
    assert report["sonar"].startswith("on; m: 0:- 1:-") and "15:-" in report["sonar"] and "?" not in report["sonar"]
    assert re.fullmatch(r"\d+ packets, 0 bad checksums, \d+ bytes discarded", report["link"])
    # A busy machine may hold up a packet for so long that the client gives it up. That is luck; a defect is each time.
    until(lambda: rows(run(port).stdout)["link"].endswith(", 0 bytes discarded"), "a report without discarded bytes")


def test_it_never_moves_anything_and_closes_politely(server):
    assert run(server.url).returncode == 0
    told = server.firmware.told
    assert not [command for command in told if command.name in MOTION | {"ENABLE"} and command.value]
    assert told[-1].name == "CLOSE" and server.firmware.session is FirmwareState.WAITING
    assert server.firmware.true_pose == (0.0, 0.0, 0.0)


def test_a_pressed_stop_button_and_no_gripper():
    with Server(firmware(gripper=False), tcp=0) as server:
        with server.lock:
            server.firmware.press_stop_button(True)
        report = rows(run(server.url).stdout)
    assert report["STOP button"].startswith("PRESSED") and report["gripper"] == "none"


def test_an_unknown_subtype_is_printed_with_what_to_do(server):
    model = server.firmware.model
    server.firmware.hardware.model = type(model)(**dict(model.__dict__, subtype="p3dz-sh"))
    result = run(server.url)
    assert result.returncode == 2 and result.stdout == ""
    for word in ("rosie", "Pioneer", "p3dz-sh", "p3dx-sh", "model"):
        assert word in result.stderr
    assert run(server.url, "--model", "p3dx-sh").returncode == 0


@pytest.mark.parametrize("port, message", [
    ("/dev/nonesuch", "no such port"), ("socket://localhost:1", "connection refused"),
    ("http://robot", "cannot understand")])
def test_ports_that_do_not_open(port, message):
    result = run(port)
    assert result.returncode == 1 and message in result.stderr and len(result.stderr.splitlines()) == 1


def test_nobody_answers():
    with socket.create_server(("127.0.0.1", 0)) as deaf:
        result = run("localhost:%d" % deaf.getsockname()[1])
    assert result.returncode == 1 and "nothing answers as a robot" in result.stderr and "Traceback" not in result.stderr


@pytest.mark.parametrize("arguments, message", [([], "PORT"), (["/dev/null", "--baud", "fast"], "--baud")])
def test_wrong_arguments(arguments, message):
    result = run(*arguments)
    assert result.returncode == 2 and message in result.stderr


@pytest.mark.parametrize("arguments", [["--models-file", "/nonesuch"], ["--model", "/nonesuch"]])
def test_a_model_or_models_file_that_does_not_exist(arguments):
    result = run("/dev/ttyUSB0", *arguments)
    assert result.returncode == 2 and "/nonesuch" in result.stderr and "Traceback" not in result.stderr


@pytest.mark.parametrize("number, code", [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_signal_ends_it_politely(server, number, code):
    opened = threading.Event()
    take = server.firmware.receive

    def receive(data):
        take(data)
        if server.firmware.session is FirmwareState.OPEN:
            # it never gets the state it waits for, and so cannot end before the signal
            server.firmware.advance = lambda dt: b""
            opened.set()

    server.firmware.receive = receive
    before = signal.signal(number, signal.SIG_DFL)      # a shell lets what it starts in the background ignore SIGINT
    try:
        program = subprocess.Popen(COMMAND + [server.url], stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    finally:
        signal.signal(number, before)
    with program:
        assert opened.wait(LIMIT)
        program.send_signal(number)
        _, said = program.communicate(timeout=LIMIT)
    assert program.returncode == code and b"Traceback" not in said
    assert server.firmware.session is FirmwareState.WAITING and server.firmware.told[-1].name == "CLOSE"


def test_no_permission_as_an_ordinary_user():
    descriptor, slave = os.openpty()
    path = os.ttyname(slave)
    os.chmod(path, 0o600 if os.geteuid() == 0 else 0)
    reader, writer = os.pipe()
    child = os.fork()
    if child == 0:
        if os.geteuid() == 0:
            os.setuid(65534)
        try:
            open_transport(path, 9600)
        except PortError as error:
            os.write(writer, str(error).encode())
        os._exit(0)
    os.waitpid(child, 0)
    os.close(writer)
    said = os.read(reader, 1000).decode()
    for number in (reader, descriptor, slave):
        os.close(number)
    assert said.startswith("%s: no permission." % path)
