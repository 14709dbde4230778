"""Programs on other computers, over the port of the page: they drive, persons go before them, nobody else notices.

Figures are printed (pytest -s).
"""

import contextlib
import json
import os
import re
import signal
import subprocess
import sys
import time

import pytest
import websocket

from pioneer_control.client import Robot
from pioneer_control.errors import PioneerError, PortError
from pioneer_control.p2os import encode_command, encode_frame
from pioneer_control.web.exchange import JOIN, OPENED, PROGRAM_GONE, packed_bytes, packed_json

from class_site import TruthWatch
from real_time import LIMIT, until
from web_site import Alone, Site, Viewer, freeze, signal_server, site_with_robot
from web_programs import close_of, key_of, program, raw, url_of

SAFE, BUSY = 0.6, 0.4   # s until a robot is told to stand, and what a busy machine may add


SIMULATED = 4.0         # s in which thirty programs hear their robots


@contextlib.contextmanager
def with_viewer(site, robot, heard):
    """A page that looks on, and an error log in which nothing is found afterwards."""
    with Viewer(site) as viewer:
        viewer.picture()
        yield site, robot, heard, viewer
    assert "Traceback" not in site.errors and key_of(viewer) not in site.errors


@pytest.fixture
def all_of_it(tmp_path):
    with site_with_robot(tmp_path) as everything, with_viewer(*everything) as with_page:
        yield with_page


@pytest.fixture(scope="module")
def long_lived(tmp_path_factory):
    with site_with_robot(tmp_path_factory.mktemp("site")) as everything:
        yield everything


@pytest.fixture
def left_alone(long_lived):
    """The same as `all_of_it`, for tests in which nobody gets the robot: after them everything is as before."""
    with with_viewer(*long_lived) as with_page:
        yield with_page


def speed(robot):
    return round(robot.firmware.velocity[0], 2)


def drives(client, robot, wanted=0.2):
    """Set a velocity until the robot has it."""
    def reached():
        client.set_velocity(wanted, 0.0)
        return speed(robot) == wanted
    until(reached, "the robot drives %g m/s" % wanted)


def test_a_program_drives_and_sees_and_the_page_says_so(all_of_it):
    site, robot, heard, viewer = all_of_it
    at = time.monotonic()
    with program(site, viewer) as client:
        print("connected after %.2f s" % (time.monotonic() - at))
        assert client.identity.name == "sim_0001" and len(client.wait_for_state().sonar) == 16
        assert {each["programs"] for each in viewer.of("helm")} == {"free"}, "a sign of life is no driving"
        client.enable_motors()
        drives(client, robot)
        until(lambda: viewer.newest("helm")["commander"] == "program", "the page says so")
        assert viewer.newest("helm")["programs"] == "driving"
        until(lambda: client.wait_for_state().x > 0.05, "it sees itself move")
        counts = client.link
    until(lambda: speed(robot) == 0 and not robot.firmware.motors_enabled, "it stands, motors off")
    assert counts.bad_checksums == counts.discarded_bytes == 0
    until(lambda: viewer.newest("helm")["programs"] == "free", "and the page says so")


def test_a_person_takes_over_and_releases(all_of_it):
    site, robot, heard, viewer = all_of_it
    with program(site, viewer) as client:
        client.enable_motors()
        drives(client, robot)
        viewer.do("take", robot=1)

        def stands():
            client.set_velocity(0.2, 0.0)
            return speed(robot) == 0.0
        until(stands, "it stands")
        until(lambda: viewer.newest("helm")["programs"] == "locked out", "the page says so")
        for _ in range(10):
            client.wait_for_state()
            assert stands()
        until(lambda: viewer.said("a person has the helm"), "the page tells why")
        viewer.do("release", robot=1)
        drives(client, robot)
        viewer.do("stop", robot="all")
        until(stands, "STOP")
        viewer.do("unlock", robot=1)
        drives(client, robot)


def test_a_robot_that_a_program_drives_is_driven_by_hand_at_once(all_of_it):
    site, robot, heard, viewer = all_of_it
    with program(site, viewer) as client:
        client.enable_motors()
        drives(client, robot, 0.4)
        viewer.hold(forward=-1.0)

        def backwards():
            client.set_velocity(0.4, 0.0)
            return speed(robot) == -0.2
        until(backwards, "the person drives it")


def test_no_such_robot(left_alone):
    site, robot, heard, viewer = left_alone
    names = ["-1", "0", "2", "99999", "1e3", "007x", "1/2", "", "1%00", "1" * 500]
    connections = [raw(site, name) for name in names]       # each refusal takes a second
    for each in connections:
        each.send(json.dumps({"key": key_of(viewer)}))
    for name, each in zip(names, connections):
        assert close_of(each) == (4404, "there is no such robot; there are: 1"), name


def test_an_address_in_other_letters_is_the_same(all_of_it):
    site, robot, heard, viewer = all_of_it
    connection = raw(site, "%31")
    connection.send(json.dumps({"key": key_of(viewer)}))
    assert json.loads(connection.recv_data()[1].decode())["robot"] == "sim_0001"
    connection.shutdown()


def test_a_wrong_key_is_told_after_a_second(left_alone):
    site, robot, heard, viewer = left_alone
    at = time.monotonic()
    with pytest.raises(PortError, match="the server refuses: the key of robot 1 is another one"):
        with Robot(url_of(site), key="wrong"):
            pass
    assert 1.0 <= time.monotonic() - at < 4.0
    with pytest.raises(PortError, match="key"):     # the page's own key is none
        with Robot(url_of(site), key=site.key):
            pass
    assert heard.moves(at) == [] and "ENABLE" not in {name for _, name, _ in heard.since(at)}


@pytest.mark.parametrize("words", [
    "", "{", "[]", '{"key": 1}', '{"key": "k", "robot": 1}', '{"key": NaN}', '{"robot": 1}', "[" * 3000,
    '{"key": "%s"}' % ("k" * 5000), b"\xfa\xfb\x03\x00\x00\x00"])
def test_first_words_that_make_no_sense(left_alone, words):
    connection = raw(left_alone[0])
    (connection.send_binary if isinstance(words, bytes) else connection.send)(words)
    assert close_of(connection)[0] == 4400


def test_where_it_may_come_from(left_alone):
    site, robot, heard, viewer = left_alone
    base = site.base.replace("http", "ws") + "robot/1"
    for url, options, status in (
            (base, dict(origin="http://evil.example"), 403), (base, dict(host="evil.example"), 421),
            (base + "?key=" + key_of(viewer), {}, 400)):
        with pytest.raises(websocket.WebSocketBadStatusException) as caught:
            websocket.create_connection(url, timeout=LIMIT, suppress_origin="origin" not in options, **options)
        assert caught.value.status_code == status
    raw(site, origin=site.base.rstrip("/")).shutdown()      # a page of this server may


def session(site, viewer):
    """Return a raw connection that has the robot."""
    connection = raw(site)
    connection.send(json.dumps({"key": key_of(viewer)}))
    assert connection.recv_data()[0] == 1
    return connection


@pytest.mark.parametrize("kind", ["messages", "packets", "long message", "text", "10 MB"])
def test_a_flood_is_closed_and_disturbs_nobody(all_of_it, kind):
    site, robot, heard, viewer = all_of_it
    connection = session(site, viewer)
    with pytest.raises((OSError, websocket.WebSocketException)) if kind == "10 MB" else contextlib.ExitStack():
        if kind == "messages":      # in one go, however busy the machine is
            message = websocket.ABNF.create_frame(b"x", websocket.ABNF.OPCODE_BINARY).format()
            connection.sock.sendall(message * 500)
        for _ in range(5 if kind != "messages" else 0):
            if kind == "text":
                connection.send('{"do": "stop", "robot": "all"}')
            else:
                connection.send_binary({"packets": encode_command("E_STOP") * 500, "long message": b"x" * 4097,
                                        "10 MB": b"x" * 10000000}[kind])
        while True:
            code, data = connection.recv_data()
            if code == 8:
                break
        assert int.from_bytes(data[:2], "big") == (4400 if kind == "text" else 4429), data
    stamp = viewer.frames[1].stamp
    until(lambda: viewer.frames[1].stamp != stamp, "the picture goes on")
    with program(site, viewer) as client:
        client.enable_motors()
        drives(client, robot)


def test_noise_half_frames_and_what_no_robot_does_move_nothing(all_of_it):
    site, robot, heard, viewer = all_of_it
    connection = session(site, viewer)
    for number in (0, 1, 2):
        connection.send_binary(encode_frame(number))
    for name, value in (("OPEN", 1), ("VEL", 300), ("HEAD", 90), ("MOVE", 3000), ("RESET", None), ("SETV", 30)):
        connection.send_binary(encode_command(name) if value is None else encode_command(name, value))
    connection.send_binary(os.urandom(4000))
    connection.send_binary(b"\xfa\xfb\xff" + bytes(200))
    connection.send_binary(encode_command("VEL", 300)[:-1])
    until(lambda: viewer.said("MOVE refused"), "the page says what was refused")
    connection.sock.sendall(b"\x82\xfe\x0f\xff\0\0\0\0half a frame")
    time.sleep(0.5)
    assert speed(robot) == 0 and not robot.firmware.motors_enabled
    names = {name for _, name, _ in heard.all}
    assert not names & {"HEAD", "MOVE", "RESET", "SETV"}
    connection.sock.close()
    with program(site, viewer) as client:
        with pytest.raises(PioneerError):
            client.set_velocity(float("nan"), 0.0)
        client.set_velocity(1e308, 0.0)


def test_two_programs_the_newest_has_it(all_of_it):
    site, robot, heard, viewer = all_of_it
    first = program(site, viewer).start()
    first.wait_until_ready(LIMIT)
    first.enable_motors()
    drives(first, robot)
    time.sleep(1.0)
    with program(site, viewer) as second:
        assert first.wait_until_ended(LIMIT)
        with pytest.raises(PioneerError, match="another program has got this robot"):
            first.set_velocity(0.1, 0.0)
        second.enable_motors()
        drives(second, robot, 0.3)
    first.close()


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGSTOP])
def test_a_server_that_is_gone_stops_the_robot_and_the_program_comes_back(all_of_it, number):
    site, robot, heard, viewer = all_of_it
    client = program(site, viewer, reconnect=True).start()
    client.wait_until_ready(LIMIT)
    client.enable_motors()
    drives(client, robot)
    pid, at = freeze(site) if number == signal.SIGSTOP else signal_server(site, number)
    until(lambda: heard.stops(at), "told to stand")
    after = heard.stops(at)[0] - at
    print("server gone: zero on the wire after %.3f s" % after)
    assert after < SAFE + BUSY
    until(lambda: speed(robot) == 0 and not robot.firmware.motors_enabled, "it stands, motors off")
    assert all(moved < at + after for moved in heard.moves(at))
    if number == signal.SIGSTOP:
        os.kill(pid, signal.SIGCONT)
    until(lambda: client.link.reconnects >= 1 and client.ready, "the program is back")
    print("the program is back after %.1f s" % (time.monotonic() - at))
    with_motors(client)
    drives(client, robot)
    client.close()


def with_motors(client):
    """Switch motors on, though the link may break meanwhile."""
    def on():
        try:
            client.enable_motors()
            return True
        except PioneerError:
            return False
    until(on, "motors on")


DARK = """
import sys, time
from pioneer_control.client import Robot
with Robot(sys.argv[1]) as robot:
    robot.enable_motors()
    while True:
        robot.set_velocity(0.2, 0.0)
        time.sleep(0.05)
"""


@pytest.mark.parametrize("number", [signal.SIGSTOP, signal.SIGKILL])
def test_a_laptop_that_is_dark_stops_its_robot(all_of_it, number):
    site, robot, heard, viewer = all_of_it
    with subprocess.Popen([sys.executable, "-c", DARK, url_of(site) + "#key=" + key_of(viewer)]) as laptop:
        try:
            until(lambda: speed(robot) == 0.2, "it drives")
            at = time.monotonic()
            laptop.send_signal(number)
            until(lambda: heard.stops(at), "told to stand")
            print("laptop %s: zero after %.3f s" % (number.name, heard.stops(at)[0] - at))
            assert heard.stops(at)[0] - at < (2.0 if number == signal.SIGSTOP else 0.2) + BUSY
            until(lambda: speed(robot) == 0, "it stands")
        finally:
            laptop.kill()


def test_a_program_that_reads_nothing_is_closed_and_costs_little(tmp_path):
    """The test is the owner of a server alone, and sends 40 MB for a program."""
    with Alone(tmp_path) as alone:
        connection = raw(alone)
        connection.send(json.dumps({"key": "k"}))
        parts = []
        until(lambda: parts.extend(alone.hear()) or [each for each in parts if each[0] == JOIN], "it asks for a robot")
        number = json.loads([contents for kind, contents in parts if kind == JOIN][0].decode())["program"]
        alone.end.sendall(packed_json(OPENED, {"program": number, "robot": "rosie"}))
        before = alone.memory()
        for _ in range(10000):
            alone.end.sendall(packed_bytes(number, bytes(4000)))
        until(lambda: [each for each in alone.hear() if each[0] == PROGRAM_GONE], "it is closed")
        print("the server grew by %.1f MB" % ((alone.memory() - before) / 1e6))
        assert alone.memory() - before < 10e6
        connection.shutdown()


def test_thirty_programs_at_thirty_robots(tmp_path):
    """Every packet of every robot reaches its program, and the page goes on in time."""
    truth = str(tmp_path / "truth")
    command = [sys.executable, "-m", "pioneer_control.simulator", "--world", "classroom", "--robots", "30", "--tcp",
               "0", "--truth", truth]
    with contextlib.ExitStack() as stack:
        simulator = stack.enter_context(subprocess.Popen(command, stdout=subprocess.PIPE, universal_newlines=True))
        stack.callback(simulator.terminate)
        urls = []
        while len(urls) < 30:
            urls += re.findall(r"socket://[\w.:]+", simulator.stdout.readline())
        site = stack.enter_context(Site(tmp_path, *urls))
        viewer, truth = stack.enter_context(Viewer(site)), TruthWatch(truth)
        for robot in range(1, 31):
            viewer.picture(robot)
        counts = dict.fromkeys(range(1, 31), 0)

        def listener(number):
            def hear(state):
                counts[number] += 1
            return hear

        clients = [program(site, viewer, number, on_state=listener(number)) for number in range(1, 31)]
        for client in clients:      # all at once, as a class begins
            stack.callback(client.close, wait=False)
            client.start()
        for client in clients:
            client.wait_until_ready(LIMIT)
            client.request_motors(True)
        began, before, delays = truth.newest["time"], dict(counts), []
        while truth.newest["time"] - began < SIMULATED:
            for client in clients:
                client.set_velocity(0.1, 0.3)
            at = time.monotonic()
            viewer.do("ping", at=at)
            until(lambda: at in viewer.of("pong"), "the page is answered")
            delays.append(time.monotonic() - at)
            time.sleep(0.1)
        sent = 10 * (truth.newest["time"] - began)
        got = sorted((counts[number] - before[number]) / sent for number in counts)
        moved = [client.state.x for client in clients]
        delays.sort()
        print("30 programs: share of SIPs %.3f to %.3f, mean %.3f; page's ping median %.1f ms, worst %.1f ms" % (
            got[0], got[-1], sum(got) / 30, delays[len(delays) // 2] * 1000, delays[-1] * 1000))
        assert got[0] > 0.8 and all(client.link.bad_checksums == 0 for client in clients)
        assert len([x for x in moved if x]) == 30
        assert delays[len(delays) // 2] < 0.2
