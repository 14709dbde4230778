"""The page on the command line, without ROS: ``python3 -m pioneer_control.web [PORT ...]``."""

from .. import interrupt  # noqa: F401  # first: from here on Ctrl-C is no error

import argparse
import contextlib
import importlib.util
import os
import re
import secrets
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import webbrowser
from typing import Any, Dict, Iterator, List, Optional

from ..errors import PioneerError, UsageError

LOOPBACK, EVERYWHERE = ("127.0.0.1", "::1"), ("0.0.0.0", "::")
PACKAGE = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
SIMULATOR_STARTS_WITHIN = 30.0      # s
ENDS_WITHIN = 3.0                   # s
SHARED = """\
Every machine that reaches this one and has an address below can see the robot and drive it. What is sent is not
encrypted: share only in a network that you trust."""


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
    for port in options.robots:
        if port.endswith((".bag", ".bag.active")):
            raise UsageError("%s: recordings are not shown yet; give the port of a robot, or nothing" % port)
    if importlib.util.find_spec("tornado") is None:
        raise PioneerError("the page needs tornado: sudo apt install python3-tornado (or pip install tornado)")
    with contextlib.ExitStack() as stack:
        simulated = not options.robots
        # The simulator starts while this program imports the rest.
        truth = options.truth
        if simulated:
            truth = os.path.join(stack.enter_context(tempfile.TemporaryDirectory(prefix="pioneer-")), "truth")
        simulator = stack.enter_context(simulator_process(truth)) if simulated else None
        from .owner import Owner, Told, listen      # late, see above
        sockets = listen(EVERYWHERE if options.share else LOOPBACK, options.port)
        for each in sockets:
            stack.callback(each.close)
        urls = options.robots if simulator is None else [url_of(simulator, ending)]
        if ending.wanted.is_set():
            return
        teacher, others = secrets.token_urlsafe(16), secrets.token_urlsafe(16)
        names = own_names() if options.share else ["localhost"]
        title = "simulated robot" if simulated else ", ".join(urls)
        told = Told({teacher: True, others: False} if options.share else {teacher: True}, title, names)
        owner = Owner(urls, sockets, told, simulated=simulated or bool(truth), folder=options.folder,
                      truth=truth, say=say)
        ending.then = owner.end
        port = sockets[0].getsockname()[1]
        address = "http://127.0.0.1:%d/#%s" % (port, teacher)
        if options.share:
            print(SHARED, file=sys.stderr)
            for host in own_addresses():
                print("For others:  http://%s:%d/#%s" % (host, port, others))
            print("For you, the teacher:  %s" % address)
        else:
            print("The page:  %s" % address)
        print("Ctrl-C ends it.", flush=True)
        if options.browser:
            threading.Thread(target=webbrowser.open, args=(address,), daemon=True).start()
        if ending.wanted.is_set():
            return
        owner.run()


def say(sentence: str) -> None:
    """Print a line for the person at the terminal. A terminal that is gone is no error."""
    with contextlib.suppress(OSError):
        print("web: %s" % sentence, file=sys.stderr, flush=True)


@contextlib.contextmanager
def simulator_process(truth: Optional[str]) -> Iterator["subprocess.Popen[bytes]"]:
    """Run a simulated robot as a child, which ends at the end of the context, and when this process is killed.

    ``truth``: the path of the socket at which it is to tell its map; None for none.
    """
    environment: Dict[str, str] = dict(
        os.environ, PYTHONPATH=os.pathsep.join(filter(None, [os.path.dirname(PACKAGE), os.environ.get("PYTHONPATH")])))
    process = subprocess.Popen(
        [sys.executable, "-m", "pioneer_control.web.tied", "pioneer_control.simulator", "--tcp", "0",
         *([] if truth is None else ["--truth", truth])],
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


def url_of(simulator: "subprocess.Popen[bytes]", ending: "Signals") -> str:
    """Return the URL that the simulator prints. What else it prints is thrown away. Returns "" if a signal came.

    Raises:
        PioneerError: it ended, or printed none within SIMULATOR_STARTS_WITHIN s.
    """
    found: List[str] = []
    come = threading.Event()

    def read() -> None:
        assert simulator.stdout is not None
        for line in simulator.stdout:
            match = re.search(r"socket://[\w.:\[\]-]+", line.decode("utf-8", "replace"))
            if match and not found:
                found.append(match.group())
                come.set()
        come.set()

    threading.Thread(target=read, daemon=True).start()
    for _ in range(round(SIMULATOR_STARTS_WITHIN / 0.05)):
        if come.wait(0.05) or ending.wanted.is_set():
            break
    if not found and not ending.wanted.is_set():
        raise PioneerError("the simulated robot did not start; `python3 -m pioneer_control.simulator` says why")
    return found[0] if found else ""


def own_names() -> List[str]:
    """Return the names by which browsers may call this machine."""
    name = socket.gethostname().lower()
    short = name.partition(".")[0]
    return sorted({"localhost", name, short, short + ".local"})


def own_addresses() -> List[str]:
    """Return the addresses of this machine in its networks, best first; its name if there is none."""
    found = []
    with contextlib.suppress(OSError), socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.connect(("192.0.2.1", 9))     # sends nothing: only asks which address would be used
        found.append(probe.getsockname()[0])
    with contextlib.suppress(OSError):
        found += [str(each[4][0]) for each in socket.getaddrinfo(socket.gethostname(), None, socket.AF_INET)]
    return [each for each in dict.fromkeys(found) if not each.startswith("127.")] or [socket.gethostname()]


def parser() -> argparse.ArgumentParser:
    """Return the argument parser of the command line."""
    result = argparse.ArgumentParser(
        prog="python3 -m pioneer_control.web", description="Robots on a page in the browser, to see and to drive.")
    result.add_argument("robots", nargs="*", metavar="PORT",
                        help="/dev/ttyUSB0 or socket://host:port: a robot; without one a simulated robot starts")
    result.add_argument("--port", type=port_number, default=8080, metavar="N",
                        help="TCP port of the page; 0: any that is free (default: %(default)s)")
    result.add_argument("--browser", action="store_true", help="open the page in the browser")
    result.add_argument("--share", action="store_true", help="let other machines open the page; prints addresses")
    result.add_argument("--truth", metavar="PATH",
                        help="the simulator's socket of this option: shows the map of its robots")
    result.add_argument("--folder", help=argparse.SUPPRESS)     # of another page: for tests
    return result


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
