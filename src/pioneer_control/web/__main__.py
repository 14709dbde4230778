"""The page on the command line, without ROS: ``python3 -m pioneer_control.web [PORT ...]``."""

from .. import interrupt  # noqa: F401  # first: from here on Ctrl-C is no error

import argparse
import contextlib
import importlib.util
import os
import re
import signal
import subprocess
import sys
import tempfile
import threading
import webbrowser
from time import monotonic
from typing import TYPE_CHECKING, Any, Dict, Iterator, List, Optional

from ..errors import PioneerError, UsageError
from ..port_url import without_key
from .owner import Owner
from .site import KEY, Site, open_site

if TYPE_CHECKING:
    from .task_board import TaskBoard
    from .truth import TruthLine

BAGS = ".bag", ".bag.active"
PACKAGE = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
SIMULATOR_STARTS_WITHIN = 30.0      # s
MOST_STUDENTS = 50
ENDS_WITHIN = 3.0                   # s


def main(arguments: Optional[List[str]] = None) -> int:
    """Serve the page until Ctrl-C, SIGTERM or SIGHUP.

    Returns:
        The exit code. 0: ended by the user. 1: a failure. 2: an argument is not legal.
    """
    options = parser().parse_args(arguments)
    ending = Signals()
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, ending.signalled)
    try:
        serve(options, ending)
        return 0
    except PioneerError as error:
        print("web: %s" % error, file=sys.stderr)
        return 2 if isinstance(error, ValueError) else 1


class Signals:
    """Whether a signal wants the program to end. ``then`` is called with the first signal."""

    def __init__(self) -> None:
        self.wanted = threading.Event()
        self.then: Any = lambda: None

    def signalled(self, *_: object) -> None:
        """Take a signal."""
        self.wanted.set()
        self.then()


def serve(options: argparse.Namespace, ending: "Signals") -> None:
    """Do what the options say, until a signal comes.

    Raises:
        PioneerError: the port is taken, tornado is not installed, the simulated robot does not start, ...
    """
    if importlib.util.find_spec("tornado") is None:
        raise PioneerError("the page needs tornado: sudo apt install python3-tornado (or pip install tornado)")
    bags = [name for name in options.robots if name.endswith(BAGS)]
    if options.task is not None and options.students is None:
        raise UsageError("a task is for a class: give --class N too")
    if options.students is not None and options.robots:
        raise UsageError("a class has simulated robots: give --class or robots, but not both")
    if options.real and options.robots:
        raise UsageError("--real is for simulated robots: give --real or robots, but not both")
    if bags and len(bags) < len(options.robots):
        raise UsageError("give bags, or ports of robots, but not both: %s" % " ".join(options.robots))
    with contextlib.ExitStack() as stack:
        if options.students is not None:
            serve_class(options, ending, stack)
        elif bags:
            serve_recording(bags, options, ending, stack)
        else:
            serve_robots(options, ending, stack)


def serve_recording(bags: List[str], options: argparse.Namespace, ending: "Signals",
                    stack: contextlib.ExitStack) -> None:
    """Serve a recorded run until a signal comes. Several bags are the parts of one recording."""
    from ..bags.command_line import in_order, stem      # late: they import numpy
    from .recorded import read_recording
    name = os.path.basename(stem(bags[0]))
    recording = read_recording(in_order(bags), name)
    site = opened(name, options, stack)
    run(site, Owner(site.listening, site.told._replace(kind="recording"), recording=recording.parts,
                    folder=options.folder, say=say), options, ending)


def serve_robots(options: argparse.Namespace, ending: "Signals", stack: contextlib.ExitStack) -> None:
    """Serve the robots whose ports are named, or a simulated one, until a signal comes."""
    truth, urls = options.truth, options.robots
    simulated = not urls
    if simulated:
        # The simulator starts while this program imports the rest.
        truth = os.path.join(stack.enter_context(tempfile.TemporaryDirectory(prefix="pioneer-")), "truth")
        simulator = stack.enter_context(simulator_process(truth, *real_option(options)))
    from .client_crew import ClientCrew     # late, see above
    site = opened("simulated robot" if simulated else ", ".join(map(without_key, urls)), options, stack)
    if simulated:
        urls = urls_of(simulator, ending, 1)
    if not ending.wanted.is_set():
        owner = Owner(site.listening, site.told, folder=options.folder, say=say)
        crew = ClientCrew(urls, truth, owner)
        stack.callback(crew.close)
        owner.look = crew.look
        run(site, owner, options, ending)


def serve_class(options: argparse.Namespace, ending: "Signals", stack: contextlib.ExitStack) -> None:
    """Serve a class with a simulated robot for each student, until a signal comes."""
    count, world = options.students, options.world
    truth = os.path.join(stack.enter_context(tempfile.TemporaryDirectory(prefix="pioneer-")), "truth")
    simulator = stack.enter_context(simulator_process(
        truth, "--robots", str(count), "--world", world, "--tasks", *real_option(options)))
    from .class_desk import ClassDesk       # late: the simulator starts meanwhile
    from .client_crew import ClientCrew
    from .paced_feed import PacedFeed
    from .qr import qr_image, qr_lines, qr_rows
    from .task_board import TaskBoard
    site = opened("class", options, stack, is_class=True)
    urls = urls_of(simulator, ending, count)
    if ending.wanted.is_set():
        return
    owner = Owner(site.listening, site.told, folder=options.folder, say=say)
    code = qr_rows(site.class_address)
    desk = ClassDesk(range(1, count + 1), {"address": site.class_address, "qr": qr_image(code), "worlds": [world]},
                     owner.outbox, owner.programs, owner.vacate, owner.halt)
    owner.rules = desk
    paced = PacedFeed(desk)
    board = TaskBoard(paced, desk.who, say)
    crew = ClientCrew(urls, truth, owner, board)
    stack.callback(crew.close)
    desk.simulator = crew.truth
    if options.task is not None and crew.truth is not None:
        choose_task(options.task, crew.truth, board, ending)

    def look() -> None:
        crew.look()
        board.turn()
        paced.turn(monotonic())

    owner.look = look
    run(site, owner, options, ending, [
        "You, the teacher:  %s" % site.address, "", *qr_lines(code), "", "Students open", "",
        "    %s" % site.class_address, "",
        "%d robots stand in the world %r." % (count, world),
        *([] if site.shared else ["This serves this computer only. --share lets others in."])])


def real_option(options: argparse.Namespace) -> List[str]:
    """Return the simulator's option for wheels and sonar that err, if it is wanted."""
    return ["--real"] * bool(options.real)


def choose_task(name: str, truth: "TruthLine", board: "TaskBoard", ending: "Signals") -> None:
    """Choose a task before students come. A signal may cut it short.

    Raises:
        UsageError: there is no such task. The error names those that there are.
    """
    for _ in range(round(SIMULATOR_STARTS_WITHIN / 0.05)):
        truth.turn(monotonic())
        if board.tasks or ending.wanted.wait(0.05):
            break
    names = [task for task, _ in board.tasks]
    if name in names:
        truth.order("task", None, {"name": name}, lambda done, sentence: say(sentence))
    elif not ending.wanted.is_set():
        raise UsageError("there is no task %r; legal: %s" % (
            name, ", ".join(names) or "none, for the simulator tells of no tasks"))


def opened(title: str, options: argparse.Namespace, stack: contextlib.ExitStack, is_class: bool = False) -> Site:
    """Open the site of the options, until the stack ends."""
    site = open_site(title, options.port, options.share, os.environ.get(KEY), is_class)
    stack.callback(site.close)
    return site


def run(site: Site, owner: Owner, options: argparse.Namespace, ending: "Signals",
        welcome: Optional[List[str]] = None) -> None:
    """Say where the page is, or ``welcome``, and serve the page until a signal comes."""
    ending.then = owner.end
    if site.warning:
        print(site.warning, file=sys.stderr)
    print(*(site.welcome() if welcome is None else welcome), "Ctrl-C ends it.", sep="\n", flush=True)
    if options.browser:
        threading.Thread(target=webbrowser.open, args=(site.address,), daemon=True).start()
    if not ending.wanted.is_set():
        owner.run()


def say(sentence: str) -> None:
    """Print a line for the person at the terminal. A terminal that is gone is no error."""
    with contextlib.suppress(OSError):
        print("web: %s" % sentence, file=sys.stderr, flush=True)


@contextlib.contextmanager
def simulator_process(truth: Optional[str], *options: str) -> Iterator["subprocess.Popen[bytes]"]:
    """Run a simulator as a child, which ends at the end of the context, and when this process is killed.

    Args:
        truth: the path of the socket at which it is to tell its map; None for none.
        options: more options for it.
    """
    environment: Dict[str, str] = dict(
        os.environ, PYTHONPATH=os.pathsep.join(filter(None, [os.path.dirname(PACKAGE), os.environ.get("PYTHONPATH")])))
    process = subprocess.Popen(
        [sys.executable, "-m", "pioneer_control.web.tied", "pioneer_control.simulator", "--tcp", "0",
         *([] if truth is None else ["--truth", truth]), *options],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, start_new_session=True, env=environment)
    try:
        yield process
    finally:
        assert process.stdin is not None
        process.stdin.close()       # which ends it
        try:
            process.wait(ENDS_WITHIN)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()


def urls_of(simulator: "subprocess.Popen[bytes]", ending: "Signals", count: int) -> List[str]:
    """Return the URLs of robots that the simulator prints. What else it prints is thrown away. A signal may cut it
    short.

    Raises:
        PioneerError: it ended, or printed fewer within SIMULATOR_STARTS_WITHIN s.
    """
    found: List[str] = []
    come = threading.Event()

    def read() -> None:
        assert simulator.stdout is not None
        for line in simulator.stdout:
            match = re.search(r"socket://[\w.:\[\]-]+", line.decode("utf-8", "replace"))
            if match and len(found) < count:
                found.append(match.group())
                if len(found) == count:
                    come.set()
        come.set()

    threading.Thread(target=read, daemon=True).start()
    for _ in range(round(SIMULATOR_STARTS_WITHIN / 0.05)):
        if come.wait(0.05) or ending.wanted.is_set():
            break
    if len(found) < count and not ending.wanted.is_set():
        raise PioneerError("the simulator did not start%s" % (
            "; `python3 -m pioneer_control.simulator` says why" if count == 1 else ": see the line above"))
    return found


def parser() -> argparse.ArgumentParser:
    """Return the argument parser of the command line."""
    result = argparse.ArgumentParser(
        prog="python3 -m pioneer_control.web", description="Robots on a page in the browser, to see and to drive.")
    result.add_argument("robots", nargs="*", metavar="PORT_OR_BAG",
                        help="/dev/ttyUSB0 or socket://host:port: a robot; FILE.bag: a recorded run (several: its "
                             "parts); without any a simulated robot starts")
    result.add_argument("--port", type=port_number, default=8080, metavar="N",
                        help="TCP port of the page; 0: any that is free (default: %(default)s)")
    result.add_argument("--browser", action="store_true", help="open the page in the browser")
    result.add_argument("--share", action="store_true", help="let other machines open the page; prints addresses")
    result.add_argument("--class", dest="students", type=student_count, metavar="N",
                        help="a class: N simulated robots, a page for the teacher, and one for each student")
    result.add_argument("--world", default="classroom", help="the world of a class (default: %(default)s)")
    result.add_argument("--task", metavar="NAME", help="a class begins with this task chosen: square, goal, ...")
    result.add_argument("--real", action="store_true", help="wheels and sonar of simulated robots err as real ones do")
    result.add_argument("--truth", metavar="PATH",
                        help="the simulator's socket of this option: shows the map of its robots")
    result.add_argument("--folder", help=argparse.SUPPRESS)     # of another page: for tests
    return result


def student_count(text: str) -> int:
    """Convert an argument of the command line to a number of students. Raises ArgumentTypeError, see port_number()."""
    if not text.isascii() or not text.isdigit() or not 1 <= int(text) <= MOST_STUDENTS:
        raise argparse.ArgumentTypeError("%r is not legal: give a whole number from 1 to %d" % (text, MOST_STUDENTS))
    return int(text)


def port_number(text: str) -> int:
    """Convert an argument of the command line to a TCP port.

    Raises:
        ArgumentTypeError: the text is not such a number.
    """
    if not text.isdigit() or int(text) > 65535:
        raise argparse.ArgumentTypeError("%r is not legal: give a whole number from 0 to 65535" % text)
    return int(text)


if __name__ == "__main__":
    sys.exit(main())
