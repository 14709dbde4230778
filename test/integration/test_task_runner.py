"""Programs that are run at a task, and their points."""

import signal

import pytest

from pioneer_control.simulator.tasks import __main__ as runner
from pioneer_control.simulator.tasks import load_tasks

from real_time import until
from web_site import is_alive

BEGIN = """
import random
import sys
import time

from pioneer_control.client import Robot

with Robot(sys.argv[1]) as robot:
    robot.enable_motors()
    state = robot.wait_for_state()
"""
AHEAD = BEGIN + """
    while state.x < 2.0:
        robot.set_velocity(0.4, 0.0)
        state = robot.wait_for_state()
        time.sleep(random.choice([0.0, 0.0, 0.0, 0.01]))
    print("I am at mark", 1)
"""
FOR_EVER = BEGIN + """
    while True:
        robot.set_velocity(0.2, 0.0)
        robot.wait_for_state()
"""


@pytest.fixture
def written(tmp_path):
    """Return a function that writes a program, and returns its path."""
    def write(text):
        path = tmp_path / "program.py"
        path.write_text(text)
        return str(path)
    return write


@pytest.fixture
def run(capfd):
    """Return a function that runs the runner: exit code, output, errors."""
    def main(*arguments):
        before = {number: signal.getsignal(number) for number in (signal.SIGTERM, signal.SIGHUP)}
        try:
            code = runner.main(list(arguments))
        finally:
            for number, handler in before.items():
                signal.signal(number, handler)
        out, err = capfd.readouterr()
        return code, out, err
    return main


def short(name, seconds):
    """Return a task that takes only so many seconds."""
    task = {task.name: task for task in load_tasks()}[name]
    return task._replace(rates=task.rates._replace(limit_s=seconds))


def test_the_same_program_gets_the_same_points_three_times(run, written):
    """Though it takes its time, each time another one."""
    code, out, err = run("square", written(AHEAD), "--times", "3", "--seed", "4")
    assert (code, err) == (0, "")
    lines = out.splitlines()
    assert lines[0::2][:3] == ["I am at mark 1"] * 3
    assert [line[:6] for line in lines[1::2]] == ["run 1:", "run 2:", "run 3:"]
    assert len({line[6:] for line in lines[1::2]}) == 1 and "1 of 4 marks, 0 cm beside the lines" in lines[1]
    assert lines[6] == "all 3 runs gave the same points"


def test_what_differs_is_said(capfd):
    assert runner.report([runner.TaskRun(runner.Score(1.0, "a"), ""), runner.TaskRun(runner.Score(1.0, "b"), "")]) == 1
    assert capfd.readouterr().out == "the runs did not give the same points\n"


def test_a_task_that_is_over_ends_the_program(written):
    score, problem = runner.attempt(short("maze", 5.0), written(FOR_EVER), 0)
    assert problem == "" and score.note.startswith("still ") and score.points > 0.0


def test_in_real_time(written):
    text = FOR_EVER.replace("True", "state.x < 0.1").replace("robot.wait", "state = robot.wait")
    score, problem = runner.attempt(short("maze", 60.0), written(text), 0, real_time=True)
    assert problem == "" and score.note.startswith("still ")


@pytest.mark.parametrize("text, problem", [
    (BEGIN + "    print(1 / 0)", "the program has ended with an error, code 1: see above"),
    ("", "the program has never connected to the robot, whose URL is its first argument: sys.argv[1]"),
    ("import sys; sys.exit(3)", "the program has ended with an error, code 3: see above"),
])
def test_a_program_that_fails(run, written, text, problem):
    code, out, err = run("square", written(text))
    assert code == 1 and err.endswith("task: %s\n" % problem) and out == "run 1: 0 points: has not moved\n"
    assert ("ZeroDivisionError" in err) == ("1 / 0" in text)


def test_a_program_that_waits_for_something_else(written, monkeypatch):
    monkeypatch.setattr(runner, "CONNECTS_WITHIN", 0.2)
    run = runner.attempt(short("square", 5.0), written("import time; time.sleep(60)"), 0)
    assert "has never connected" in run.problem


def test_a_program_that_closes_its_connection_and_goes_on(written, monkeypatch):
    monkeypatch.setattr(runner, "COMES_BACK_WITHIN", 0.2)
    run = runner.attempt(short("square", 5.0), written(BEGIN + "time.sleep(60)"), 0)
    assert run == runner.TaskRun(runner.Score(0.0, "has not moved"), "")


def test_what_a_program_has_started_ends_with_it(written, tmp_path):
    note = tmp_path / "pid"
    text = "import os, time\npid = os.fork()\nif not pid:\n    time.sleep(60)\nopen(%r, 'w').write(str(pid))\n"
    runner.attempt(short("square", 5.0), written(text % str(note)), 0)
    until(lambda: not is_alive(int(note.read_text())), "it has ended")


def test_a_program_that_answers_late(written, monkeypatch):
    monkeypatch.setattr(runner, "ANSWERS_WITHIN", 0.2)
    run = runner.attempt(short("square", 60.0), written(BEGIN + "    time.sleep(1)\n    robot.wait_for_state()\n"), 0)
    assert run.problem.startswith("the program has answered too late, ")


def test_the_list_of_tasks(run):
    code, out, err = run("--list")
    assert code == 0 and err == "" and out.startswith("square: Drive a square, within 120 s\n    Drive from mark ")
    assert all(task.title in out for task in load_tasks())


@pytest.mark.parametrize("arguments, problem", [
    ([], "give a task; there are square, goal, sweep, cans, maze"),
    (["sqare", "x.py"], "there is no task sqare; did you mean square? there are square, goal, sweep, cans, maze"),
    (["square"], "give the path of a Python program"),
    (["square", "no/such.py"], "there is no file no/such.py: give the path of a Python program"),
])
def test_arguments_that_are_not_legal(run, arguments, problem):
    assert run(*arguments) == (2, "", "task: %s\n" % problem)


@pytest.mark.parametrize("times", ["0", "101", "-1", "three"])
def test_a_number_of_runs_that_is_not_legal(run, capfd, times):
    with pytest.raises(SystemExit):
        run("square", "x.py", "--times", times)
    assert "%r is not legal: give a whole number from 1 to 100" % times in capfd.readouterr().err.replace("\n", " ")
