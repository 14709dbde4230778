"""How the page's processes begin and end: nothing is left behind, robots stand with their motors off, errors are for
people.
"""

import signal
import socket
import subprocess
import sys
import time

import pytest
import websocket

from pioneer_control.simulator.firmware import FirmwareState
from pioneer_control.web.exchange import BEAT_MESSAGE, FRAME, ORDER, packed, packed_json
from pioneer_control.web.frames import RobotFrame, encode_frame, stamp_of

from real_time import LIMIT, until
from web_programs import close_of
from web_site import Alone, Site, Viewer, is_alive, site_with_robot


def run(*arguments):
    """Run the program until it ends by itself. Returns exit code, standard output and standard error."""
    done = subprocess.run([sys.executable, "-m", "pioneer_control.web", *arguments], stdout=subprocess.PIPE,
                          stderr=subprocess.PIPE, universal_newlines=True, timeout=LIMIT)
    return done.returncode, done.stdout, done.stderr


def test_without_arguments_a_simulated_robot(tmp_path):
    with Site(tmp_path) as site, Viewer(site) as viewer:
        frame = viewer.picture()
        print("first picture %.2f s after the start, with the simulator's start" % (time.monotonic() - site.began))
        robot, = viewer.newest("robots")
        assert frame.flags & 1 and robot["simulated"] and robot["name"] == "sim_0001" and len(robot["sonar"]) == 16
        children = site.children()
        assert len(children) == 2
        site.process.send_signal(signal.SIGINT)
        assert site.process.wait(LIMIT) == 0
        assert not any(map(is_alive, children)) and site.errors == ""


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_an_end_stops_the_robot_with_motors_off(tmp_path, number):
    with site_with_robot(tmp_path) as (site, robot, heard), Viewer(site) as viewer:
        viewer.switch_motors_on()
        viewer.hold()
        until(lambda: robot.firmware.velocity[0] > 0.1, "it drives")
        children = site.children()
        at = time.monotonic()
        site.process.send_signal(number)
        assert site.process.wait(LIMIT) == 0
        print("ended after %.2f s" % (time.monotonic() - at))
        assert heard.stops(at)[0] - at < 1.0 and [each for each in heard.since(at) if each[1] == "CLOSE"]
        assert robot.firmware.session is FirmwareState.WAITING and not robot.firmware.motors_enabled
        assert not any(map(is_alive, children)) and site.errors == ""


def test_a_killed_owner_leaves_no_child(tmp_path):
    with Site(tmp_path) as site, Viewer(site) as viewer:
        viewer.picture()
        children = site.children()
        assert len(children) == 2
        site.process.kill()
        site.process.wait(LIMIT)
        until(lambda: not any(map(is_alive, children)), "server and simulator end too")


def test_a_killed_owner_and_a_robot_that_drove(tmp_path):
    """Nobody is left who could stop it: its own watchdog does."""
    with site_with_robot(tmp_path) as (site, robot, heard), Viewer(site) as viewer:
        viewer.switch_motors_on()
        viewer.hold()
        until(lambda: robot.firmware.velocity[0] > 0.1, "it drives")
        at = time.monotonic()
        site.process.kill()
        site.process.wait(LIMIT)
        until(lambda: robot.firmware.velocity == (0.0, 0.0), "it stands")
        print("killed owner: the robot stands after %.2f s" % (time.monotonic() - at))
        assert heard.moves(at + 0.5) == []


def test_the_port_is_taken(tmp_path):
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        code, out, error = run("--port", str(port))
    assert code == 1 and "port %d" % port in error and "--port 0" in error and "Traceback" not in error and out == ""


def test_two_pages_at_once_and_the_same_port_again(tmp_path):
    with site_with_robot(tmp_path) as (site, robot, heard):
        port = site.port
        code, _, error = run(robot.url, "--port", str(port))
        assert code == 1 and "port %d" % port in error
    with Site(tmp_path, robot.url, port=port) as again:
        assert again.port == port


@pytest.mark.parametrize("arguments, code, words", [
    (["--port", "70000"], 2, "0 to 65535"), (["--port", "x"], 2, "0 to 65535"),
    (["run.bag"], 2, "run.bag: no such file"),
    (["--fly"], 2, "--fly"), (["run.bag", "/dev/ttyUSB0"], 2, "but not both")])
def test_arguments_that_make_no_sense(arguments, code, words):
    found = run(*arguments)
    assert found[0] == code and words in found[2] and "Traceback" not in found[2]


def test_a_robot_that_is_switched_on_later(tmp_path):
    with socket.create_server(("127.0.0.1", 0)) as probe:
        port = probe.getsockname()[1]
    with Site(tmp_path, "socket://127.0.0.1:%d" % port) as site, Viewer(site) as viewer:
        until(lambda: viewer.newest("status"), "the page tells of it")
        assert viewer.newest("status")["link"] == "looking for the robot" and viewer.frames == {}
        until(lambda: "connection refused" in viewer.newest("status")["lost"], "and why, also to who comes later")
        viewer.do("drive", robot=1, forward=1.0, turn=0.0, stamp=stamp_of(time.monotonic()))
        until(lambda: viewer.said("there is no robot 1"), "nothing drives")
        with subprocess.Popen([sys.executable, "-m", "pioneer_control.simulator", "--tcp", str(port)],
                              stdout=subprocess.DEVNULL) as simulator:
            viewer.picture()
            until(lambda: viewer.newest("status")["link"] == "ok", "the link works")
            assert site.errors.count("connection refused") == 1, "said once"
            simulator.terminate()


def test_shared_with_other_machines(tmp_path):
    page = tmp_path / "page"
    page.mkdir()
    command = [sys.executable, "-m", "pioneer_control.web", "--share", "--port", "0", "--folder", str(page)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                          universal_newlines=True) as process:
        lines = [process.stdout.readline()]
        while "Ctrl-C" not in lines[-1]:
            lines.append(process.stdout.readline())
        process.terminate()
        _, errors = process.communicate(timeout=LIMIT)
    others = [line for line in lines if line.startswith("For others:")]
    teacher, = [line for line in lines if line.startswith("For you")]
    assert others and process.returncode == 0
    assert "encrypted" in errors and "can see the robots and drive them" in errors
    assert others[0].split("#")[1] != teacher.split("#")[1]


# The server alone: the test is its owner

@pytest.fixture
def alone(tmp_path):
    with Alone(tmp_path) as server:
        yield server


def test_the_server_beats_and_ends_with_its_link(alone):
    assert alone.hear()[0] == (BEAT_MESSAGE, b"")
    at = time.monotonic()
    alone.end.close()
    assert alone.process.wait(LIMIT) == 0
    print("the server ended %.3f s after its link" % (time.monotonic() - at))


def test_a_viewer_that_reads_nothing_costs_little_and_delays_nobody(alone):
    """30 MB are shown. The socket of one viewer takes some, and of the rest only the newest is kept for it."""
    alone.end.sendall(packed_json(b"T", {"kind": "robots", "robot": None, "value": [], "seat": ""}))
    with Viewer(alone, reads=False) as slow, Viewer(alone, visitor="fast0123456789abcd") as fast:
        until(lambda: fast.of("robots"), "the first picture")
        before = alone.memory()
        for number in range(30):
            value = {"number": number, "cells": "x" * 1000000}
            alone.end.sendall(packed_json(b"T", {"kind": "world", "robot": None, "value": value, "seat": ""}))
            alone.end.sendall(packed(FRAME, encode_frame(RobotFrame(1, stamp_of(time.monotonic())))))
            slow.do("drawn", stamp=stamp_of(time.monotonic()))
            time.sleep(0.01)        # 100 messages of a viewer in a second
        until(lambda: fast.newest("world") and fast.newest("world")["number"] == 29, "the last for who reads")
        grown = alone.memory() - before
        print("the server grew by %.1f MB" % (grown / 1e6))
        assert grown < 15e6 and slow.closed is None


@pytest.mark.parametrize("address", ["page", "robot/1"])
def test_who_says_nothing_is_closed(tmp_path, address):
    with Alone(tmp_path, FIRST_WORDS_WITHIN=1.0) as alone:
        at = time.monotonic()
        connection = websocket.create_connection(alone.base.replace("http", "ws") + address, timeout=LIMIT)
        assert close_of(connection) == (4408, "nothing was said for 1 s") and time.monotonic() - at > 1.0


def test_a_viewer_that_answers_no_ping_is_closed_in_the_end(tmp_path):
    with Alone(tmp_path, PING_EVERY=0.5, PONG_WITHIN=1.5) as alone, Viewer(alone, reads=False) as slow:
        parts = []
        until(lambda: parts.extend(alone.hear()) or [each for each in parts if each[0] == b"G"], "it is forgotten")
        assert slow.closed is None


def test_an_owner_that_does_not_read_costs_the_server_little(alone):
    """0.7 MB of orders are for it: what the socket does not take, and is more than the server keeps, is dropped."""
    sent = 200
    with Viewer(alone) as viewer:
        until(lambda: viewer.of("hello"), "the first picture")
        for _ in range(sent):
            viewer.do("say", text="\U0001f600" * 300)
            time.sleep(0.0105)
        viewer.do("ping", at=1)
        until(lambda: viewer.of("pong"), "the server lives")
    heard = []
    until(lambda: heard.extend(alone.hear()) or [each for each in heard if each[0] == b"G"], "the viewer left")
    orders = [contents for kind, contents in heard if kind == ORDER]
    print("%d of %d orders came, %d bytes" % (len(orders), sent, sum(map(len, orders))))
    assert 0 < len(orders) < sent
