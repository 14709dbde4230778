"""The socket at which other programs get the true state of the simulated world, and give orders."""

import contextlib
import json
import os
import signal
import socket
import stat
import subprocess
import sys
import time

import pytest

from pioneer_control import p2os
from pioneer_control.errors import PortError
from pioneer_control.robots import find_model
from pioneer_control.simulator.line import Server
from pioneer_control.simulator.simulation import Simulation, simulate
from pioneer_control.simulator.truth import TruthService, service
from pioneer_control.simulator.truth.visit import LONGEST_LINE, ORDERS_IN_A_TURN
from pioneer_control.simulator.world import World, load_world

from real_time import LIMIT, until


class Page:
    """A program at the socket."""

    def __init__(self, path):
        self.line = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        self.line.settimeout(LIMIT)
        self.line.connect(str(path))
        self._unread = b""
        self.world, self.truth, self.truths, self.orders = None, None, 0, 0

    def close(self):
        self.line.close()

    def read(self):
        """Return the next line from the simulator, and note what it tells."""
        while b"\n" not in self._unread:
            data = self.line.recv(65536)
            if not data:
                raise ConnectionError("hung up on")
            self._unread += data
        line, self._unread = self._unread.split(b"\n", 1)
        message = json.loads(line.decode("ascii"))
        self.world = message.get("world", self.world)
        if "truth" in message:
            self.truth, self.truths = message["truth"], self.truths + 1
        return message

    def until(self, condition):
        """Read until a condition holds for the newest truth. Return that truth."""
        end = time.monotonic() + LIMIT
        while self.truth is None or not condition(self.truth):
            assert time.monotonic() < end, "never so; at last %s" % self.truth
            self.read()
        return self.truth

    def answer(self, line):
        """Send a line, and return the next answer."""
        self.line.sendall(line + b"\n")
        while True:
            message = self.read()
            if "answer" in message:
                return message

    def order(self, order, **values):
        """Give an order. Return whether it was obeyed, and the text about it."""
        self.orders += 1
        answer = self.answer(json.dumps({"id": self.orders, "order": order, **values}).encode())
        assert answer["answer"] == self.orders
        return answer["ok"], answer["text"]


def visit(path):
    return contextlib.closing(Page(path))


@contextlib.contextmanager
def program(*arguments):
    """Start a simulator, and wait until it is ready or has ended."""
    with subprocess.Popen(
        [sys.executable, "-m", "pioneer_control.simulator", "--tcp", "0", *map(str, arguments)],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, universal_newlines=True,
    ) as process:
        try:
            process.said = []
            while not process.said or process.said[-1] not in ("", "Ctrl-C ends it.\n"):
                process.said.append(process.stdout.readline())
            yield process
        finally:
            process.kill()


@pytest.fixture
def path(tmp_path):
    return tmp_path / "truth"


@pytest.fixture
def served(path):
    """Return a page at a simulator in a process of its own, with two robots in the world `cans`."""
    with program("--world", "cans", "--robots", "2", "--truth", path), visit(path) as page:
        page.read()     # the world
        yield page


def driver_of(page, number):
    """Connect to a robot at the URL that the page was told. Return its socket, with an open session."""
    host, _, port = page.world["robots"][number - 1]["url"][len("socket://"):].rpartition(":")
    line = socket.create_connection((host, int(port)), LIMIT)
    line.sendall(b"".join(p2os.encode_frame(step) for step in (0, 1, 2, 1)))
    line.sendall(p2os.encode_command("ENABLE", 1))
    return contextlib.closing(line)


def test_the_world_comes_first_and_then_the_truth(path):
    with program("--world", "office", "--robots", "5", "--truth", path) as process:
        assert "The true state of the world is at %s\n" % path in process.said
        assert stat.S_IMODE(os.stat(path).st_mode) == 0o600
        with visit(path) as page:
            assert list(page.read()) == ["world"]
            assert page.world["name"] == "office" and len(page.world["robots"]) == 5
            assert [robot["url"] for robot in page.world["robots"]] == [
                line.split()[1] for line in process.said if "socket://" in line]
            assert list(page.read()) == ["truth"]
            assert len(page.truth["robots"]) == 5 and page.truth["robots"][0] == [1.0, 6.0, 0.0, 0.0, 0.0, False]
            begin = page.truth["time"]
            page.until(lambda truth: truth["time"] > begin)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_the_socket_is_removed_at_the_end(path, number):
    with program("--truth", path) as process, visit(path) as page:
        page.read()
        process.send_signal(number)
        assert process.wait(LIMIT) == 0 and process.stderr.read() == ""
        assert not os.path.lexists(path)
        with pytest.raises(ConnectionError):
            page.until(lambda truth: False)


def test_the_truth_moves_when_a_robot_drives(served):
    served.until(lambda truth: True)
    with driver_of(served, 2) as driver:
        start = served.truth["robots"]
        driver.sendall(p2os.encode_command("VEL", 200))
        served.until(lambda truth: truth["robots"][1][3] == 0.2)
        served.until(lambda truth: truth["robots"][1][:2] != start[1][:2])
        assert served.truth["robots"][0] == start[0]


def test_pause_and_go_on(served):
    assert served.order("pause")[0]
    paused_at = served.until(lambda truth: truth["paused"])["time"]
    for pressed in (True, False):
        served.order("stop_button", robot=1, pressed=pressed)
        assert served.until(lambda truth: truth["stop_buttons"][0] == pressed)["time"] == paused_at
    assert served.order("go_on") == (True, "simulated time passes")
    assert not served.until(lambda truth: truth["time"] > paused_at)["paused"]


def test_speed(served):
    assert served.order("speed", speed=50)[0]
    served.until(lambda truth: truth["speed"] == 50.0 and truth["time"] > 20.0)


def test_put_and_reset_of_one(served):
    with driver_of(served, 1) as driver:
        driver.sendall(p2os.encode_command("VEL", 200))
        served.until(lambda truth: truth["robots"][0][3] > 0.1)
        assert served.order("put", robot=1, pose=[1.5, 0.9, 3.0]) == (True, "robot 1 is at x 1.5, y 0.9, heading 3")
        served.until(lambda truth: truth["robots"][0] == [1.5, 0.9, 3.0, 0.0, 0.0, False])
        served.until(lambda truth: truth["origins"][0] != [0.0, 0.0, 0.0])
        assert served.order("reset", robot=1) == (True, "robot 1 is where it began")
        served.until(lambda truth: truth["robots"][0] == [0.0, 0.0, 0.0, 0.0, 0.0, False])


def test_reset_of_all(served):
    start = served.until(lambda truth: True)
    assert served.order("put", robot=1, pose=[1.5, 0.0, 0.0])[0]
    assert served.order("put", robot=2, pose=[3.5, 0.9, 0.0])[0]
    with driver_of(served, 1) as driver:
        driver.sendall(p2os.encode_command("VEL", 300))
        served.until(lambda truth: truth["cans"] != start["cans"])
        assert served.order("reset") == (True, "all robots and cans are where they began")
        served.until(lambda truth: truth["cans"] == start["cans"] and truth["robots"] == start["robots"])


def test_a_robot_is_not_put_into_another(served):
    x, y, heading = served.until(lambda truth: True)["robots"][1][:3]
    ok, text = served.order("put", robot=1, pose=[x, y + 0.1, heading])
    assert not ok and text.endswith("in its way is robot 2")


def test_faults_and_stop_buttons(served):
    assert served.order("add_fault", fault="stop_button robot 2")[0]
    served.until(lambda truth: truth["faults"] == ["stop_button robot 2"] and truth["stop_buttons"] == [False, True])
    assert served.order("clear_faults") == (True, "1 ended")
    served.until(lambda truth: truth["faults"] == [] and truth["stop_buttons"] == [False, False])
    assert served.order("stop_button", robot=1, pressed=True)[0]
    served.until(lambda truth: truth["stop_buttons"] == [True, False])


def test_bad_orders_are_answered_and_do_no_harm(served):
    for line, text in (
            (b"go", "this is not JSON"), (b"\x80", "this is not JSON"), (b"[]", "[] is no order"),
            (b'{"order": "reset", "robot": 9}', "robot 9 is not legal: give a whole number from 1 to 2"),
            (b"x" * (LONGEST_LINE + 1), "a line has more than 65536 bytes")):
        answer = served.answer(line)
        assert not answer["ok"] and answer["text"].startswith(text)
    served.line.sendall(b'{"order"')       # the rest comes later
    served.read()
    assert served.answer(b': "pause"}')["ok"]
    served.until(lambda truth: truth["paused"])


def test_a_flood_of_orders_is_answered_in_order(served):
    count = 5 * ORDERS_IN_A_TURN
    served.line.sendall(b"".join(b'{"id": %d, "order": "stop_button", "robot": 1, "pressed": true}\n' % number
                                 for number in range(count)))
    answers = []
    while len(answers) < count:
        message = served.read()
        answers += [message["answer"]] if "answer" in message else []
    assert answers == list(range(count)) and served.truths > 2, "and the truth came in between"


def test_two_programs_see_the_same_world(served, path):
    with visit(path) as other:
        assert list(other.read()) == ["world"]
        served.order("put", robot=1, pose=[1.5, 0.9, 0.0])
        for page in (served, other):
            page.until(lambda truth: truth["robots"][0][:2] == [1.5, 0.9])
        assert served.world == other.world
    served.order("pause")
    served.until(lambda truth: truth["paused"])
    with visit(path) as late:
        assert late.until(lambda truth: True)["paused"], "also who comes while nothing changes"


def test_who_does_not_read_gets_the_newest_state_and_disturbs_nobody(path):
    with program("--world", "classroom", "--robots", "30", "--truth", path), visit(path) as slow, visit(path) as other:
        begin = other.until(lambda truth: True)["time"]
        seen = other.truths
        other.until(lambda truth: other.truths > seen + 40)     # 100 kB, of which the system keeps a part
        now = other.truth["time"]
        assert list(slow.read()) == ["world"]
        slow.until(lambda truth: truth["time"] >= now)
        assert slow.truths < 30 and slow.truth["time"] > begin


def test_rude_programs_are_forgotten(served, path):
    for farewell in (b"", b"{", b'{"order": "pause"}\n' * 200):
        with visit(path) as rude:
            rude.line.sendall(farewell)
    served.order("go_on")
    served.until(lambda truth: truth["time"] > 0.0)
    assert served.order("go_on")[0]


def test_the_socket_of_a_dead_simulator_is_replaced_and_of_a_live_one_not(path):
    with program("--truth", path) as first:
        first.send_signal(signal.SIGKILL)
        first.wait(LIMIT)
    assert path.is_socket()
    with program("--truth", path):
        with program("--truth", path) as second:
            assert second.wait(LIMIT) == 1
            assert second.stderr.read() == (
                "simulator: %s is the socket of another simulator: stop that one, or choose another path\n" % path)
        with visit(path) as page:
            page.until(lambda truth: True)


@pytest.mark.parametrize("arguments, code, message", [
    (("--truth", "no/such/folder/truth"), 1, "cannot make the socket no/such/folder/truth: No such file"),
    (("--tasks",), 2, "--tasks needs --truth: a task is chosen by an order at that socket"),
    (("--truth", "x" * 200), 1, "AF_UNIX path too long; choose another path"),
    (("--truth", "truth", "--play", "wire.txt"), 2, "not allowed with argument"),
    (("--truth", "truth", "--client", "wire.txt"), 2, "not allowed with argument"),
])
def test_where_there_can_be_no_socket(arguments, code, message):
    with program(*arguments) as process:
        assert process.wait(LIMIT) == code and message in process.stderr.read()


def test_another_file_is_not_replaced(path):
    path.write_text("precious")
    with program("--truth", path) as process:
        assert process.wait(LIMIT) == 1 and "exists and is no socket" in process.stderr.read()
    assert path.read_text() == "precious"


# -- in this process

@contextlib.contextmanager
def serving(path, robots=1):
    simulation = simulate(load_world("empty"), find_model("p3dx-sh"), robots, None, 0)
    with Server(simulation, tcp=0) as server, TruthService(server, simulation, str(path)) as truth:
        yield server, truth


def test_not_too_many_programs(path, monkeypatch):
    monkeypatch.setattr(service, "MOST_VISITS", 2)
    with serving(path):
        with visit(path) as first, visit(path) as second:
            first.until(lambda truth: True)
            second.until(lambda truth: True)
            with visit(path) as third, pytest.raises(ConnectionError):
                third.read()

        def let_in():
            with visit(path) as page, contextlib.suppress(ConnectionError):
                return page.until(lambda truth: True)

        until(let_in, "room again")


def test_a_task_is_chosen_begun_and_scored(path):
    with program("--world", "cans", "--robots", "2", "--truth", path, "--tasks", "--speed", "10"), \
            visit(path) as page, visit(path) as other:
        first = page.read()["world"]
        assert [name for name, _ in first["tasks"]] == ["square", "goal", "sweep", "cans", "maze"]
        assert page.until(lambda truth: True)["task"] is None
        assert page.order("task", name="square") == (True, "the task square is ready")
        for reader in (page, other):
            told = reader.until(lambda truth: truth["task"] is not None)
            assert told["cans"] == [] and told["task"]["state"] == "ready"
            assert reader.world["name"] == "square" and reader.world["bounds"] != first["bounds"]
            assert [place["name"] for place in reader.world["places"]] == ["1", "2", "3", "4"] * 2
            assert [robot[:3] for robot in told["robots"]] == [robot["start"] for robot in reader.world["robots"]]
        with visit(path) as late:
            assert late.read()["world"]["name"] == "square"
        assert page.order("begin_task")[0]
        with driver_of(page, 2) as driver:
            driver.sendall(p2os.encode_command("VEL", 300))
            task = page.until(lambda truth: "of 4 marks" in truth["task"]["scores"][1][1])["task"]
            assert task["state"] == "running" and task["clock"] > 0.0 and task["scores"][0] == [
                0.0, "has not moved"]
        assert page.order("end_task")[0]
        page.until(lambda truth: truth["task"]["state"] == "over")
        assert page.order("task", name="")[0]
        page.until(lambda truth: truth["task"] is None)
        assert page.world == first


def test_robots_are_watched_only_while_somebody_is_there(path):
    with serving(path) as (server, _):
        assert not server.watched
        with visit(path) as page:
            page.until(lambda truth: True)
            assert server.watched
        until(lambda: not server.watched, "nobody there")


def test_stop_twice_and_before_start(path):
    simulation = Simulation(World("hall"))
    simulation.add(find_model("p3dx-sh"))
    server = Server(simulation, tcp=0)
    truth = TruthService(server, simulation, str(path))
    with pytest.raises(PortError, match="is the socket of another simulator"):
        TruthService(server, simulation, str(path))
    truth.stop()
    assert not os.path.lexists(path)
    path.write_text("precious")
    truth.stop()
    server.stop()
    assert path.read_text() == "precious"


def test_the_socket_of_somebody_else_is_left_at_the_end(path):
    with serving(path) as (_, truth):
        os.unlink(path)
        with contextlib.closing(socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)) as other:
            placeholder = path.with_name("placeholder")      # keeps the number of the old file from being used again
            placeholder.write_text("")
            other.bind(str(path))
            truth.stop()
            assert os.path.lexists(path)
