"""Runs a program at a task, and prints its points: ``python3 -m pioneer_control.simulator.tasks square program.py``.

The program is any Python program that drives the robot at the URL in its first argument. It runs as a child, and the
simulated robot in this process. Simulated time waits for the program (see ``line/lockstep``), so that the same program
with the same seed gets the same points.
"""

import argparse
import contextlib
import math
import os
import signal
import subprocess
import sys
import textwrap
import time
from pathlib import Path
from typing import Iterator, List, NamedTuple, Optional

from ...errors import PioneerError, UsageError
from ...parameters import nearest
from ...robots import find_model
from ..firmware import FirmwareState
from ..line import Server
from ..simulation import simulate
from ..world import World
from .arena import Grounds
from .referee import OVER, Referee
from .scores import Score
from .task import Task, load_tasks

MODEL = "p3dx-sh"
CONNECTS_WITHIN = 30.0
"""Real time (s) within which the program must connect to the robot."""
ENDS_WITHIN = 1.0
"""Real time (s) for which the program may go on when the task is over. Then it is ended."""
COMES_BACK_WITHIN = 10.0
"""Real time (s) for which a program that has closed its connection may go on: no simulated time passes meanwhile."""
ANSWERS_WITHIN = 10.0
"""Real time (s) for which simulated time waits for the program."""
LOOK = 0.02
"""Real time (s) between two looks at the program."""
ROOT = Path(__file__).resolve().parents[3]


class TaskRun(NamedTuple):
    """What came of one run: the points, and what went wrong (empty if nothing did)."""

    score: Score
    problem: str


def main(arguments: Optional[List[str]] = None) -> int:
    """Run a program at a task, as often as the options say.

    Returns:
        The exit code. 0: all runs were scored, and gave the same points. 1: they were not. 2: an argument is not legal.
        130 after Ctrl-C.
    """
    options = parser().parse_args(arguments)
    for number in (signal.SIGTERM, getattr(signal, "SIGHUP", signal.SIGTERM)):
        signal.signal(number, lambda number, _: sys.exit(128 + number))
    try:
        tasks = load_tasks()
        if options.list:
            print("\n\n".join(map(described, tasks)))
            return 0
        task = chosen(options.task, tasks)
        if not os.path.isfile(options.program or ""):
            raise UsageError("%sgive the path of a Python program" % (
                "" if options.program is None else "there is no file %s: " % options.program))
        return report([one_run(task, options, number) for number in range(1, options.times + 1)])
    except PioneerError as error:
        print("task: %s" % error, file=sys.stderr)
        return 2 if isinstance(error, ValueError) else 1
    except KeyboardInterrupt:
        return 130


def described(task: Task) -> str:
    """Return a task in words: its name, its title, its duration, and what to do."""
    return "%s: %s, within %g s\n%s" % (task.name, task.title, task.rates.limit_s, textwrap.indent(
        textwrap.fill(task.text, 100), "    "))


def chosen(name: Optional[str], tasks: List[Task]) -> Task:
    """Return the task of this name.

    Raises:
        UsageError: there is none.
    """
    known = {task.name: task for task in tasks}
    if name not in known:
        near = nearest(name or "", known)
        raise UsageError("%s; %sthere are %s" % (
            "give a task" if name is None else "there is no task %s" % name,
            "did you mean %s? " % near if near else "", ", ".join(known)))
    return known[name]


def one_run(task: Task, options: argparse.Namespace, number: int) -> TaskRun:
    """Run the program once, print its points, and return them."""
    run = attempt(task, options.program, options.seed, options.real_time)
    print("run %d: %g points: %s" % (number, *run.score), flush=True)
    if run.problem:
        print("task: %s" % run.problem, file=sys.stderr, flush=True)
    return run


def report(runs: List[TaskRun]) -> int:
    """Print whether all runs gave the same points, and return the exit code."""
    same = len({run.score for run in runs}) == 1
    if len(runs) > 1:
        print("all %d runs gave the same points" % len(runs) if same else "the runs did not give the same points")
    return 0 if same and not any(run.problem for run in runs) else 1


def attempt(task: Task, program: str, seed: int, real_time: bool = False) -> TaskRun:
    """Let a program do a task once, with a robot of its own, which is new.

    Args:
        task: the task.
        program: path of the program.
        seed: seed of all that is random.
        real_time: whether simulated time follows real time, and does not wait for the program.
    """
    grounds = Grounds(World("hall"), [(0.0, 0.0, 0.0)], [task])
    simulation = simulate(grounds.world, find_model(MODEL), 1, None, seed)
    referee = Referee(simulation, grounds)
    referee.choose(task.name)
    referee.begin()
    with Server(simulation, tcp=0, seed=seed, lockstep=None if real_time else ANSWERS_WITHIN) as server:
        with program_at(program, "%s%s" % (server.url, "" if real_time else "?lockstep")) as child:
            problem = watched(child, server, referee)
        with server.lock:
            if referee.contest.state != OVER:
                referee.end()
            if not problem and server.pace.late_answers:
                problem = ("the program has answered too late, %d times: another run may give other points"
                           % server.pace.late_answers)
            return TaskRun(referee.contest.scores[0], problem)


def watched(child: "subprocess.Popen[bytes]", server: Server, referee: Referee) -> str:
    """Wait until the program has ended, or is to be ended. Return what went wrong; an empty text if nothing did."""
    begin = talked = time.monotonic()
    over_at = math.inf
    while True:
        ended = waited(child)
        now = time.monotonic()
        with server.lock:
            over = referee.contest.state == OVER
            talks = server.firmware.session is not FirmwareState.WAITING
            connected = server.firmware.closed_sessions or talks
        over_at = min(now, over_at) if over else math.inf
        if ended and not over and child.returncode:
            return "the program has ended with an error, code %d: see above" % child.returncode
        if not connected and (ended or now > begin + CONNECTS_WITHIN):
            return "the program has never connected to the robot, whose URL is its first argument: sys.argv[1]"
        talked = now if talks else talked
        if ended or now > over_at + ENDS_WITHIN or connected and now > talked + COMES_BACK_WITHIN:
            return ""


def waited(child: "subprocess.Popen[bytes]") -> bool:
    """Wait for a moment. Return whether the program has ended."""
    try:
        child.wait(LOOK)
    except subprocess.TimeoutExpired:
        return False
    return True


@contextlib.contextmanager
def program_at(program: str, url: str) -> Iterator["subprocess.Popen[bytes]"]:
    """Run a program with a URL as its argument. What it prints is printed. At the end of the context it is ended, with
    all processes that it has started.
    """
    path = os.pathsep.join(filter(None, [str(ROOT), os.environ.get("PYTHONPATH")]))
    child = subprocess.Popen([sys.executable, program, url], stdin=subprocess.DEVNULL,
                             start_new_session=True,
                             env=dict(os.environ, PYTHONPATH=path, PYTHONUNBUFFERED="1"))
    try:
        yield child
    finally:
        if hasattr(os, "killpg"):
            with contextlib.suppress(ProcessLookupError):       # all have ended
                os.killpg(child.pid, signal.SIGKILL)
        child.kill()
        child.wait()


def count(text: str) -> int:
    """Convert an argument of the command line to a number of runs.

    Raises:
        ArgumentTypeError: the text is not such a number.
    """
    if not (text.isascii() and text.isdigit() and 1 <= int(text) <= 100):
        raise argparse.ArgumentTypeError("%r is not legal: give a whole number from 1 to 100" % text)
    return int(text)


def parser() -> argparse.ArgumentParser:
    """Return the argument parser of the command line."""
    result = argparse.ArgumentParser(
        prog="python3 -m pioneer_control.simulator.tasks",
        description="Runs a program at a task, with a simulated robot, and prints its points.")
    result.add_argument("task", nargs="?", metavar="TASK", help="name of the task; --list shows all")
    result.add_argument("program", nargs="?", metavar="PROGRAM",
                        help="a Python program, which drives the robot at the URL in sys.argv[1]")
    result.add_argument("--list", action="store_true", help="list all tasks")
    result.add_argument("--seed", type=int, default=0, help="random seed of the sonar noise (default: %(default)s)")
    result.add_argument("--times", type=count, default=1, metavar="N",
                        help="run the program N times, and compare the points (default: %(default)s)")
    result.add_argument("--real-time", action="store_true",
                        help="simulated time follows real time, and does not wait for the program")
    return result


if __name__ == "__main__":
    sys.exit(main())
