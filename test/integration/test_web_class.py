"""A class: thirty students of a script, ten of them hostile; the teacher's orders; laptops with nothing but Python.

Figures are printed (pytest -s).
"""

import contextlib
import json
import os
import re
import signal
import subprocess
import sys
import threading
import time

import pytest
import websocket

from pioneer_control.client import Robot
from pioneer_control.errors import PortError

from class_site import ClassSite, TruthWatch
from real_time import LIMIT, until
from web_programs import key_of, program, raw, url_of
from web_site import Viewer, signal_server


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    with ClassSite(tmp_path_factory.mktemp("small"), 4) as site:
        yield site


@pytest.fixture
def teacher(small):
    """The teacher's page of the small class, in which all robots are free before and after."""
    with Viewer(small, visitor="teacher0123456789") as viewer:
        viewer.picture(4)
        yield viewer
    with Viewer(small, visitor="teacher0123456789") as viewer:      # another one: its server may be gone
        viewer.picture(4)
        viewer.do("pause", on=False)
        viewer.do("unlock", robot="all")
        viewer.do("clear_faults")
        viewer.do("task", name="")
        for robot, _, _ in viewer.newest("class")["students"]:
            viewer.do("free", robot=robot)
        until(lambda: viewer.newest("class")["students"] == [], "all robots are free: %s" % viewer.texts[-3:])
        until(lambda: viewer.newest("time")["paused"] is False, "time passes")
    assert "Traceback" not in small.errors and small.key not in small.errors and small.students not in small.errors


def test_what_it_prints(small):
    assert "This serves this computer only" in small.printed
    assert "4 robots stand in the world 'classroom'" in small.printed
    assert "\u2588\u2588" in small.printed and small.students != small.key


def test_a_student_joins_and_keeps_the_robot(small, teacher):
    with contextlib.ExitStack() as stack:
        ada, robot = small.joined(stack, 1, "Ada")
        assert ada.newest("join") is False and ada.newest("hello")["teacher"] is False
        key = key_of(ada, robot)
        until(lambda: [robot, "Ada", "here"] in teacher.newest("class")["students"], "the teacher sees who is who")
        assert teacher.newest("class")["address"] == "%s#%s" % (small.base, small.students)
        assert len(teacher.newest("class")["qr"]) > 20 and not any(each["yours"] for each in ada.newest("robots"))
        other, others = small.joined(stack, 2, "Ada")
        assert others != robot and other.newest("mine")["name"] == "Ada 2"
        tab = stack.enter_context(small.student(1))
        until(lambda: tab.of("mine")[-1:] == [{"robot": robot, "name": "Ada"}], "a second tab")
        assert tab.newest("join") is False
        assert {each["robot"] for each in tab.of("program")} == {robot} and tab.of("class") == []
        pid, _ = signal_server(small, signal.SIGKILL)
        until(lambda: small.server_pid() not in (None, pid), "another server")
        again = stack.enter_context(small.student(1))
        until(lambda: again.of("mine")[-1:] == [{"robot": robot, "name": "Ada"}],     # at first it may know nobody
              "the robot after a restart of the server")
        assert key_of(again, robot) == key


def test_when_all_robots_are_taken(small, teacher):
    with contextlib.ExitStack() as stack:
        for number in range(1, 5):
            small.joined(stack, number)
        late = stack.enter_context(small.student(9))
        late.do("join", name="Late")
        until(lambda: late.said("all 4 robots are taken: ask the teacher"), "the reason")
        assert late.newest("join") is True
        teacher.do("free", robot=2)
        until(lambda: [each[0] for each in teacher.newest("class")["students"]] == [1, 3, 4], "free")
        late.do("join", name="Late")
        until(lambda: late.newest("mine")["robot"] == 2, "its robot")


def test_the_teacher_frees_a_robot_that_drives(small, teacher):
    truth = TruthWatch(small.truth)
    with contextlib.ExitStack() as stack:
        ada, robot = small.joined(stack, 1, "Ada")
        key = key_of(ada, robot)
        ada.switch_motors_on(robot)
        ada.hold(robot)
        until(lambda: truth.newest["robots"][robot - 1][3] > 0.1, "it drives")
        teacher.do("free", robot=robot)
        until(lambda: ada.newest("mine")["robot"] is None and ada.newest("join") is True, "the student is told")
        until(lambda: truth.newest["robots"][robot - 1][3] == 0, "it stands")
        until(lambda: ada.said("not yours"), "and drives no more")
        with pytest.raises(PortError, match="key"), Robot(url_of(small, robot), key=key):
            pass


def test_a_students_program_and_the_teachers_stop(small, teacher):
    truth = TruthWatch(small.truth)
    with contextlib.ExitStack() as stack:
        ada, robot = small.joined(stack, 1, "Ada")
        bob, others = small.joined(stack, 2, "Bob")
        client = stack.enter_context(program(small, ada, robot))
        client.enable_motors()

        def speed_is(wanted):
            client.set_velocity(0.2, 0.0)
            return round(truth.newest["robots"][robot - 1][3], 2) == wanted
        until(lambda: speed_is(0.2), "it drives")
        until(lambda: [each for each in bob.of("helm") if each["who"] == "Ada" and each["programs"] == "driving"],
              "who")
        teacher.do("stop", robot="all")
        until(lambda: speed_is(0.0), "the teacher stops all")
        ada.do("unlock", robot=robot)
        until(lambda: ada.said("only the teacher unlocks it"), "not the student")
        teacher.do("unlock", robot="all")
        until(lambda: speed_is(0.2), "it drives on")
        with pytest.raises(PortError, match="the key of robot %d" % others):
            Robot(url_of(small, others), key=key_of(ada, robot)).__enter__()


def test_time_faults_and_reset(small, teacher):
    truth = TruthWatch(small.truth)
    with contextlib.ExitStack() as stack:
        ada, robot = small.joined(stack, 1, "Ada")
        until(lambda: teacher.newest("time"), "time")
        teacher.do("fault", robot=robot, words="loss 0.5")
        until(lambda: teacher.newest("faults"), "the fault")
        assert "robot %d" % robot in teacher.newest("faults")[0] and ada.of("faults") == []
        teacher.do("fault", robot=robot, words="no such")
        until(lambda: teacher.said("no kind 'no'"), "a fault that is none")
        teacher.do("clear_faults")
        until(lambda: teacher.newest("faults") == [], "clear")
        teacher.do("speed", speed=2)
        until(lambda: teacher.newest("class")["speed"] == 2, "speed")
        teacher.do("speed", speed=1)
        ada.switch_motors_on(robot)
        ada.hold(robot)
        until(lambda: truth.driven(robot) > 0.2, "it drives")
        ada.let_go()
        teacher.do("reset", robot=robot)
        until(lambda: truth.driven(robot) == 0, "it is back")
        teacher.do("pause", on=True)
        until(lambda: ada.newest("time") == {"paused": True, "speed": 1.0}, "all know that time stands")
        until(lambda: not any(teacher.frames[each].flags & 1 for each in range(1, 5)), "links are taken for lost")
        assert not [each for each in teacher.of("said") if "no packet" in each["text"]]
        at = time.monotonic()
        teacher.do("pause", on=False)
        until(lambda: ada.newest("time")["paused"] is False, "time passes")
        until(lambda: all(teacher.frames[each].flags & 1 for each in range(1, 5)), "all links are back")
        print("links are back %.1f s after a pause" % (time.monotonic() - at))
        ada.do("pause", on=True)
        until(lambda: ada.said("only the teacher"), "not the student")
        ada.switch_motors_on(robot)


def test_a_task_from_its_choice_to_its_end(small, teacher):
    truth = TruthWatch(small.truth)

    def task(viewer):
        return viewer.newest("task") or {"state": "", "ranking": []}

    with contextlib.ExitStack() as stack:
        ada, robot = small.joined(stack, 1, "Ada")
        until(lambda: teacher.newest("class")["tasks"], "the tasks")
        assert ["square", "Drive a square"] in teacher.newest("class")["tasks"] and ada.newest("task") is None
        teacher.do("begin_task")
        until(lambda: teacher.said("no task is chosen"), "none is chosen")
        teacher.do("task", name="sqare")
        until(lambda: teacher.said("did you mean 'square'"), "there is no such task")
        ways = len(ada.of("trail"))
        teacher.do("task", name="square")
        until(lambda: task(ada)["state"] == "ready", "it is chosen")
        until(lambda: ada.newest("world")["name"] == "square", "another floor")
        until(lambda: any(trail["robot"] == robot and len(trail["points"]) <= 1 for trail in ada.of("trail")[ways:]),
              "its way begins anew, perhaps with its new place already")
        assert "1" in {place["name"] for place in ada.newest("world")["places"]}
        assert [(entry["robot"], entry["who"]) for entry in task(ada)["ranking"]] == [(robot, "Ada")]
        for order in ({"do": "begin_task"}, {"do": "end_task"}, {"do": "task", "name": ""}):
            ada.send(**order)
        until(lambda: ada.said("only the teacher"), "not the student")
        assert task(teacher)["state"] == "ready"
        start = truth.newest["robots"][robot - 1][:2]
        teacher.do("begin_task")
        until(lambda: task(ada)["state"] == "running", "it runs")
        ada.switch_motors_on(robot)
        ada.hold(robot)
        until(lambda: truth.driven(robot) > 0.3, "it drives")
        bob, others = small.joined(stack, 2, "Bob")
        until(lambda: {entry["who"] for entry in task(bob)["ranking"]} == {"Ada", "Bob"}, "who comes late, too")
        assert task(bob)["clock"] > 0.0
        ada.let_go()
        teacher.do("reset", robot=robot)
        until(lambda: truth.newest["robots"][robot - 1][:2] == start, "it is back at its start")
        assert task(ada)["state"] == "running"
        teacher.do("end_task")
        until(lambda: task(bob)["state"] == "over", "it is over")
        until(lambda: "the task square has ended: 1. " in small.errors, "the terminal says so")
        teacher.do("task", name="")
        until(lambda: ada.newest("task") is None and ada.newest("world")["name"] == "classroom", "the class again")
        assert not ada.said("task")     # no answer of the simulator to her orders
    assert "the task square begins, for 120 s" in small.errors


def test_a_class_begins_with_a_task(tmp_path):
    with ClassSite(tmp_path, 1, "--task", "maze") as site, site.student(1) as ada:
        until(lambda: (ada.newest("task") or {}).get("state") == "ready", "the task is ready")
        assert ada.newest("task")["name"] == "maze" and ada.newest("world")["name"] == "maze"


@pytest.mark.parametrize("arguments, words", [
    (["--class", "1", "--task", "sqare"], "there is no task 'sqare'; legal: square, goal, sweep, cans, maze"),
    (["--task", "square"], "a task is for a class")])
def test_a_task_that_cannot_be(arguments, words):
    done = subprocess.run([sys.executable, "-m", "pioneer_control.web", *arguments, "--port", "0"],
                          stdout=subprocess.PIPE, stderr=subprocess.PIPE, universal_newlines=True, timeout=LIMIT)
    assert done.returncode == 2 and words in done.stderr and "Traceback" not in done.stderr and done.stdout == ""


def test_a_world_without_room_for_all():
    done = subprocess.run(
        [sys.executable, "-m", "pioneer_control.web", "--class", "50", "--world", "table", "--port", "0"],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, universal_newlines=True, timeout=LIMIT)
    assert re.search(r"has room for \d+ robots .* not for 50", done.stderr) and "Traceback" not in done.stderr
    assert done.returncode == 1 and done.stdout == ""


# A laptop

LESSON = """
import sys
from pioneer_control.client import Robot
assert "numpy" not in sys.modules and "serial" not in sys.modules
with Robot(sys.argv[1], key=sys.argv[2]) as robot:
    robot.enable_motors()
    while robot.state.x < 0.1:
        robot.set_velocity(0.2, 0.0)
        robot.wait_for_state()
    print("drove", len(robot.state.sonar))
"""


def test_a_laptop_with_nothing_but_python_installs_offline_and_drives(small, teacher, tmp_path):
    venv = tmp_path / "laptop"
    subprocess.run([sys.executable, "-m", "venv", str(venv)], check=True, timeout=120)
    clean = {name: value for name, value in os.environ.items() if name not in ("PYTHONPATH", "PIP_INDEX_URL")}
    at = time.monotonic()
    done = subprocess.run(
        [str(venv / "bin" / "python"), "-m", "pip", "install", "--no-index", "--find-links",
         small.base + "packages/", "pioneer_control"], stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
        universal_newlines=True, timeout=120, env=clean)
    assert done.returncode == 0, done.stdout
    print("pip took %.1f s: %s" % (time.monotonic() - at, done.stdout.splitlines()[-1]))
    with contextlib.ExitStack() as stack:
        ada, robot = small.joined(stack, 1, "Ada")
        done = subprocess.run([str(venv / "bin" / "python"), "-c", LESSON, url_of(small, robot), key_of(ada, robot)],
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, universal_newlines=True, timeout=60,
                              cwd=str(tmp_path), env=clean)
        assert done.returncode == 0 and done.stdout == "drove 16\n", done.stdout


# Thirty, ten of them hostile

MARKUP = ("<script>alert(1)</script>", "\"><img src=x>", "'; DROP TABLE", "&lt;b&gt;", "%s%n{0}", "../../etc/passwd",
          "Ada\u0301\u0301\u0301", "<b>\u674e</b>", "null", "__proto__")


def hostile(site, number, robots, ended):
    """One hostile student: joins under a name with markup, then tries everything until it is told to end."""
    turn = number       # ten of them do all of it at once
    while not ended.is_set():
        turn += 1
        with contextlib.suppress(OSError, websocket.WebSocketException, AssertionError, KeyError):
            with site.student(100 + number) as viewer:
                viewer.do("join", name=MARKUP[number][:24])
                for robot in [*robots, -1, 0, 65535, 1e308, "all", None, True, "1", [1], {"a": 1}]:
                    stamp = next((frame.stamp for frame in viewer.frames.values()), 0)
                    viewer.do("drive", robot=robot, forward=1.0, turn=0.0, stamp=stamp)
                    viewer.do(("motors", "take", "release", "free", "pause", "say", "reset", "unlock")[turn % 8],
                              **[dict(robot=robot, on=True), dict(robot=robot), dict(robot=robot), dict(robot=robot),
                                 dict(on=True), dict(text=MARKUP[number]), dict(robot=robot),
                                 dict(robot=robot)][turn % 8])
                    time.sleep(0.03)
                bad = ['{"do": "drive", "robot": 1, "forward": NaN, "turn": 0, "stamp": 0}',
                       '{"do": "drive", "robot": 1, "forward": 1e308, "turn": 0, "stamp": 0}', "[" * 4000, "x" * 5000,
                       "x" * 10000000, b"\xfa\xfb" * 1000]
                piece = bad[turn % len(bad)]
                (viewer.socket.send_binary if isinstance(piece, bytes) else viewer.socket.send)(piece)
                for _ in range(300):
                    viewer.do("stop", robot=robots[turn % len(robots)])
                viewer.socket.sock.sendall(b"\x81\xfe\x0f\xff\0\0\0\0half a frame")
        with contextlib.suppress(OSError, websocket.WebSocketException):
            for robot in (robots[turn % len(robots)], -1, "1e308", "NaN"):
                connection = raw(site, robot)
                connection.send(json.dumps({"key": site.students if turn % 2 else "x" * 3000}))
                connection.send_binary(b"\xfa\xfb\x06\x01\x3b\x01\x00\x01\x3c" * 400)
                connection.sock.close()


@pytest.mark.timeout(180)
def test_thirty_students_ten_of_them_hostile(tmp_path):
    """Nobody else's robot moved or stopped, nobody's page broke, nothing grew."""
    with ClassSite(tmp_path, 30) as site, contextlib.ExitStack() as stack:
        truth = TruthWatch(site.truth)
        teacher = stack.enter_context(Viewer(site, visitor="teacher0123456789"))
        students = [site.joined(stack, number) for number in range(1, 21)]
        for viewer, robot in students:
            viewer.picture(robot)
        still, movers, coders = students[:10], students[10:15], students[15:]
        for viewer, robot in movers:
            viewer.switch_motors_on(robot)
            viewer.obeys = True
            viewer.hold(robot, 0.0, 0.5)
        clients = [program(site, viewer, robot) for viewer, robot in coders]
        for client in clients:
            stack.callback(client.close, wait=False)
            client.start()
        for client in clients:
            client.wait_until_ready(LIMIT)
            client.enable_motors()
        pid, ended, robots = site.server_pid(), threading.Event(), [robot for _, robot in students]
        bad = [threading.Thread(target=hostile, args=(site, number, robots, ended)) for number in range(10)]
        stack.callback(ended.set)
        for thread in bad:
            thread.start()
        time.sleep(2.0)         # until all that is made once is made
        before, began, ages, turned = site.memory(), time.monotonic(), [], dict.fromkeys(robots, 0)

        def turns(some):
            """Return the least share of looks at which one of some robots turned."""
            return min(turned[robot] for _, robot in some) / len(ages)

        def drive_on():
            for client in clients:
                client.set_velocity(0.0, 0.5)
            return True

        def all_has_been_seen():
            """Look once more. Return whether there were 5 s of looks, and who is driven turned at enough of them."""
            at = time.monotonic()
            still[0][0].do("ping", at=at)
            until(lambda: drive_on() and at in still[0][0].of("pong"), "an honest page is answered")
            ages.append(time.monotonic() - at)
            for robot in robots:
                turned[robot] += abs(truth.newest["robots"][robot - 1][4]) > 0.1
            time.sleep(0.1)
            return time.monotonic() - began > 5.0 and turns(coders) > 0.5 and turns(movers) > 0.0

        # A STOP of somebody else would last. A busy machine makes hands and programs late: a robot stands for a moment,
        # and of a page, which has to let go and press again, only that it drove is sure.
        until(all_has_been_seen, "honest students drive their robots")
        grown = site.memory() - before
        ended.set()
        for thread in bad:
            thread.join(LIMIT)
        ages.sort()
        print("hostile: honest ping median %.1f ms, worst %.1f ms; owner and server grew by %.1f MB" % (
            ages[len(ages) // 2] * 1000, ages[-1] * 1000, grown / 1e6))
        print("share of looks at which robots that were driven turned: %.2f at least" % turns(movers + coders))
        assert [truth.driven(robot) for _, robot in still] == [0.0] * 10
        assert [turned[robot] for _, robot in still] == [0] * 10
        assert grown < 20e6 and site.server_pid() == pid
        for viewer, robot in students:
            assert viewer.closed is None and viewer.newest("mine")["robot"] == robot
            assert {each["robot"] for each in viewer.of("program")} == {robot} and viewer.of("class") == []
        assert teacher.closed is None and teacher.newest("time")["paused"] is False
        names = {each[1] for each in teacher.newest("class")["students"]}
        assert len(names) >= 25 and all(len(name) <= 24 for name in names)
        viewer, robot = still[0]
        viewer.switch_motors_on(robot)
        viewer.hold(robot, 0.0, 0.5)
        until(lambda: abs(truth.newest["robots"][robot - 1][4]) > 0.1, "an honest student drives")
        assert "Traceback" not in site.errors and site.key not in site.errors and site.students not in site.errors
