"""The rooms without ROS on a laptop with Windows: they import and run without what only POSIX systems have."""

import pathlib
import re
import signal
import subprocess
import sys

import pytest

import pioneer_control

import laptop
from real_time import LIMIT

PACKAGE = pathlib.Path(pioneer_control.__file__).resolve().parent
ROOMS = ("p2os", "robots", "client", "simulator")
NEED_ROS = {"pioneer_control.simulator.node"}

DRIVE = """
import sys, time
from pioneer_control.client import Robot

with Robot(sys.argv[1]) as robot:
    robot.enable_motors()
    begin = time.monotonic()
    while robot.state.x < 0.2:
        assert time.monotonic() - begin < %g, robot.state
        robot.set_velocity(0.2, 0.0)
        robot.wait_for_state()
    robot.stop()
    while robot.state.linear:
        assert time.monotonic() - begin < %g, robot.state
        robot.wait_for_state()
    print("driven %%.2f m, serial %%s" %% (robot.state.x, "serial" in sys.modules))
""" % (LIMIT, LIMIT)


def modules():
    """Return the dotted names of all modules of the rooms, but those that need ROS."""
    files = [path.relative_to(PACKAGE.parent).with_suffix("") for room in ROOMS
             for path in sorted((PACKAGE / room).rglob("*.py"))]
    names = [".".join(file.parts[:-1] if file.name == "__init__" else file.parts) for file in files]
    return [name for name in names if name not in NEED_ROS]


def command(*arguments):
    return [sys.executable, laptop.__file__, *arguments]


def run(*arguments):
    return subprocess.run(command(*arguments), stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=2 * LIMIT,
                          universal_newlines=True)


@pytest.fixture
def simulator():
    """The URL of a simulated robot on the laptop, started as a user does."""
    with subprocess.Popen(command("-m", "pioneer_control.simulator", "--world", "empty", "--tcp", "0"),
                          stdout=subprocess.PIPE, universal_newlines=True) as process:
        try:
            yield next(line.strip() for line in process.stdout if "socket://" in line)
            process.send_signal(signal.SIGINT)
            assert process.wait(LIMIT) == 0
        finally:
            process.kill()


def test_every_module_imports():
    assert len(modules()) > 80
    done = run("-c", "import importlib\nfor name in %r: importlib.import_module(name)" % modules())
    assert (done.returncode, done.stdout) == (0, "")


@pytest.mark.parametrize("without", [
    [], [word for name in ("serial", "websocket", "numpy", "PIL") for word in ("--without", name)]])
def test_a_client_drives_a_simulated_robot_and_stops(simulator, without):
    done = run(*without, "-c", DRIVE, simulator)
    found = re.fullmatch(r"driven (\d\.\d\d) m, serial False\n", done.stdout)
    assert found and 0.2 <= float(found[1]) < 0.5, done.stdout


def test_the_report_of_the_client(simulator):
    done = run("--without", "serial", "-m", "pioneer_control.client", simulator)
    assert done.returncode == 0 and "p3dx-sh" in done.stdout


def test_a_cable_that_is_pulled_leaves_no_file_to_wait_for_and_the_simulator_goes_on():
    code = """
import threading
from pioneer_control.simulator.line import Server, fault_of
from pioneer_control.simulator.firmware import Firmware
from pioneer_control.robots import find_model
from pioneer_control.simulator.world import load_world

ended = threading.Event()
with Server(Firmware(find_model("p3dx-sh"), load_world("empty")), tcp=0, faults=[fault_of("cable from 0.1 to 0.3")],
            say=lambda sentence: ended.set() if "ends" in sentence else print(sentence)) as server:
    assert ended.wait(%g) and server.running
""" % LIMIT
    done = run("-c", code)
    assert done.returncode == 0, done.stdout


def test_a_pseudo_terminal_is_refused_with_what_to_do(tmp_path):
    done = run("-m", "pioneer_control.simulator", "--pty", str(tmp_path / "robot"))
    assert done.returncode == 1 and "no pseudo-terminals" in done.stdout and "--tcp 8101" in done.stdout
    assert len(done.stdout.splitlines()) == 1


def test_a_serial_port_needs_pyserial_and_says_so():
    done = run("--without", "serial", "-m", "pioneer_control.client", "COM3")
    assert done.returncode == 1 and "pip install pyserial" in done.stdout and len(done.stdout.splitlines()) == 1


@pytest.mark.parametrize("code", [
    *("import " + name for name in laptop.MODULES), "import os; os.pipe2(0)", "import os; os.O_CLOEXEC",
    "import select; select.poll()", "import selectors; selectors.EpollSelector()",
    "import select; select.select([], [], [], 0)", "import select; select.select([0], [], [], 0)",
    "import signal; signal.SIGHUP", "import socket; socket.AF_UNIX",
    "import os, socket; os.read(socket.socketpair()[0].fileno(), 1)",
    "import os, socket; os.write(socket.socketpair()[0].fileno(), b'')",
    "import serial",        # on this system it needs termios
])
def test_what_is_hidden_is_not_there(code):
    done = run("-c", code)
    last = done.stdout.splitlines()[-1]
    assert done.returncode == 1 and re.match("(ImportError|AttributeError|OSError): ", last), done.stdout


def test_what_is_not_hidden_is_there():
    done = run("-c", "import select, socket; a, b = socket.socketpair(); b.send(b'!'); "
                     "print(select.select([a], [], [], 5)[0] == [a], a.recv(1))")
    assert done.stdout == "True b'!'\n"
