#!/usr/bin/python3
"""A whole class on one computer: thirty simulated robots, thirty students' programs, thirty pages and the teacher's.

    python3 bench/full_class.py                      # some minutes
    python3 bench/full_class.py --students 10 --seconds 20

`./pioneer class 30` as it is (simulator, owner, web server). All students have joined: two in Chromium, the others by a
socket that reads and acknowledges as a page does. The teacher's page is in a third Chromium. The students' programs
drive over WebSockets, all in one process of this machine. bench/web.md has the measurements.
"""

import argparse
import contextlib
import json
import multiprocessing
import pathlib
import re
import selectors
import statistics
import sys
import tempfile
import threading
import time
from typing import Any, Dict, Iterator, List, Sequence, Tuple

ROOT = pathlib.Path(__file__).resolve().parents[1]
for folder in ("src", "test/integration", "test/browser", "bench"):
    sys.path.insert(0, str(ROOT / folder))

from class_site import ClassSite, TruthWatch
from page import Watcher, processor_time
from page_driver import start_browser
from pioneer_control.client import Robot
from pioneer_control.errors import LinkLostError
from real_time import until
from screencast import HAS_PICTURE, drawn_delays, note_drawn, shown_delays
from times import HEAD, row

IN_BROWSERS = 2         # students
SETTLED = 5.0           # s that are not measured
Program = Tuple[int, str]   # the robot's number, and its URL with the key


# --- The students' programs, in a process of their own


def wander(robot: Robot, ended: Any) -> None:
    """Drive, and turn away from what is near, until the end."""
    robot.enable_motors()
    with contextlib.suppress(LinkLostError):    # it is closed at the end
        while not ended.is_set():
            state = robot.wait_for_state()
            near = [each.range for each in state.sonar[1:7] if each is not None and each.range is not None]
            free = min(near, default=5.0)
            robot.set_velocity(0.2 if free > 0.6 else 0.0, 0.0 if free > 0.6 else 0.8)


def programs(given: List[Program], pipe: Any) -> None:
    """Run all programs. Each time something is received, answer with how many states each of them got until now."""
    counts = {number: 0 for number, _ in given}
    ended = threading.Event()

    def counter(number: int) -> Any:
        def count(_: Any) -> None:
            counts[number] += 1
        return count

    with contextlib.ExitStack() as stack:
        robots = [stack.enter_context(Robot(url, on_state=counter(number))) for number, url in given]
        for robot in robots:
            threading.Thread(target=wander, args=(robot, ended), daemon=True).start()
        while pipe.recv():
            pipe.send(dict(counts))
        ended.set()


@contextlib.contextmanager
def running_programs(given: List[Program]) -> Iterator[Any]:
    """Run the programs. Yields the pipe to their process."""
    ours, theirs = multiprocessing.Pipe()
    process = multiprocessing.get_context("spawn").Process(target=programs, args=(given, theirs))
    process.start()
    try:
        yield ours
    finally:
        ours.send(False)
        process.join(20)


# --- The students' pages


class Readers:
    """The pages that are sockets: read in a thread, so that none of them waits."""

    def __init__(self) -> None:
        self.all: List[Watcher] = []
        self._selector = selectors.DefaultSelector()
        threading.Thread(target=self._run, daemon=True).start()

    def add(self, watcher: Watcher) -> Watcher:
        """Read a page's socket from now on."""
        self.all.append(watcher)
        self._selector.register(watcher.line.sock, selectors.EVENT_READ, watcher)
        return watcher

    def _run(self) -> None:
        with contextlib.suppress(ConnectionError):      # at the end the server closes all
            while True:
                for chosen, _ in self._selector.select(0.1):
                    for _ in chosen.data.read():
                        pass
                for watcher in list(self.all):
                    watcher.acknowledge()


def join_by_socket(site: ClassSite, readers: Readers, number: int) -> Program:
    """Let a student join whose page is a socket. Returns where the program finds the robot."""
    watcher = readers.add(Watcher(site.base.replace("http", "ws") + "page", site.students))
    watcher.line.send(json.dumps({"do": "join", "name": "Student %d" % number}))
    told = until(lambda: watcher.texts.get("program"), "a robot for student %d" % number)
    return told["robot"], url_of(site, told)


def join_in_browser(site: ClassSite, driver: Any, name: str) -> Tuple[float, Program]:
    """Let a student join in Chromium. Returns the time (s) from the opened link to the robot on the screen, without the
    time for the name, and where the program finds the robot.
    """
    began = time.monotonic()
    driver.get("%s#%s" % (site.base, site.students))
    until(lambda: driver.execute_script("return document.body.classList.contains('joins')"), "the page asks for a name")
    driver.execute_script("document.getElementById('my-name').value = arguments[0];"
                          "document.getElementById('me').requestSubmit()", name)
    until(lambda: driver.execute_script("return document.getElementById('program').textContent"), "a robot")
    until(lambda: driver.execute_script(HAS_PICTURE), "a picture")
    took = time.monotonic() - began
    words = driver.execute_script("return document.getElementById('program').textContent")
    path, key = re.search(r'(/robot/\d+)", key="([^"]+)"', words).groups()  # type: ignore[union-attr]
    number = int(path.rsplit("/", 1)[1])
    return took, (number, url_of(site, {"path": path, "key": key}))


def url_of(site: ClassSite, told: Dict[str, Any]) -> str:
    """Return the URL for a program, from what the page was told."""
    return "%s%s#key=%s" % (site.base.replace("http", "ws").rstrip("/"), told["path"], told["key"])


# --- What is measured


class Load:
    """The load of all processes and the pace of the robots, from now on."""

    def __init__(self, site: ClassSite, truth: TruthWatch, readers: Readers) -> None:
        self._truth, self._readers = truth, readers
        simulator = next(pid for pid, command in site.children().items() if "pioneer_control.simulator" in command)
        self._pids = {"owner": site.process.pid, "web server": site.server_pid(), "simulator": simulator}
        for watcher in readers.all:
            watcher.bytes = 0
        self._used = {name: processor_time(pid) for name, pid in self._pids.items()}
        self._began, self._simulated = self._next_state()

    def _next_state(self) -> Tuple[float, float]:
        """Return the real and the simulated time of the next state that the simulator tells."""
        before = self._truth.newest
        until(lambda: self._truth.newest is not before, "another state")
        return time.monotonic(), self._truth.newest["time"]

    def rows(self, words: str) -> List[str]:
        """Return what was measured until now, as rows of the table of shares."""
        now, simulated = self._next_state()
        seconds = now - self._began
        shares = ", ".join("%s %.0f %%" % (name, 100 * (processor_time(pid) - self._used[name]) / seconds)
                           for name, pid in self._pids.items())
        kilobytes = [watcher.bytes / seconds / 1000 for watcher in self._readers.all]
        return ["| %s: simulated seconds in a real one | %.3f | 0.99 |" % (
                    words, (simulated - self._simulated) / seconds),
                "| %s: processors, of a core | %s | web server 35 %% |" % (words, shares),
                "| %s: kB/s for a viewer, mean and most | %.1f, %.1f | 15 |" % (
                    words, statistics.mean(kilobytes), max(kilobytes))]


def measure(students: int, seconds: float, folder: pathlib.Path) -> None:
    """Run a class, and print what is measured."""
    times: List[str] = []
    shares: List[str] = []
    words = "%d robots, %d viewers, 3 of them Chromium" % (students, students + 1)
    with contextlib.ExitStack() as stack:
        site = stack.enter_context(ClassSite(folder, students, page=None))
        truth, readers = TruthWatch(site.truth), Readers()
        given = [join_by_socket(site, readers, number) for number in range(1, students - IN_BROWSERS + 1)]
        browsers = [start_browser() for _ in range(IN_BROWSERS + 1)]
        for driver in browsers:
            stack.callback(driver.quit)
            note_drawn(driver)
        browsers[0].get("%s#%s" % (site.base, site.key))
        until(lambda: browsers[0].execute_script(HAS_PICTURE), "the teacher's picture")
        joined = [join_in_browser(site, driver, "Browser_%d" % number) for number, driver in enumerate(browsers[1:])]
        given += [program for _, program in joined]
        times.append(row("a student's link opened to the robot on the screen", [took for took, _ in joined], "3000"))
        for programs_too in (False, True):
            about = words + (", %d programs" % students if programs_too else "")
            with contextlib.ExitStack() as these:
                pipe = these.enter_context(running_programs(given)) if programs_too else None
                time.sleep(SETTLED)
                for driver in browsers:
                    drawn_delays(driver)
                load, before = Load(site, truth, readers), counts(pipe)
                began = time.monotonic()
                time.sleep(seconds)
                got, took = counts(pipe), time.monotonic() - began
                shares += load.rows(about)
                delays = [drawn_delays(driver) for driver in browsers]
                times.append(row("packet to drawn, student's page: " + about, delays[1] + delays[2], "50"))
                times.append(row("the same, teacher's page", delays[0], "50"))
                if pipe is not None:
                    arrived = sorted((got[number] - before[number]) / (10 * took) for number in got)
                    shares.append("| %s: packets that arrive at programs, worst and median | %.3f, %.3f | 0.99 |" % (
                        about, arrived[0], statistics.median(arrived)))
        drawn_delays(browsers[1])
        shown = shown_delays(browsers[1], seconds)
        times.append(row("without programs, by the page's clock, beside a screencast", drawn_delays(browsers[1]), ""))
        times.append(row("the same, by the screencast: packet to picture of the browser", shown, "50"))
    print(HEAD, *times, "", "| what | measured | limit |\n|---|---|---|", *shares, sep="\n", flush=True)


def counts(pipe: Any) -> Dict[int, int]:
    """Return how many states each program got until now."""
    if pipe is None:
        return {}
    pipe.send(True)
    found: Dict[int, int] = pipe.recv()
    return found


def main(arguments: Sequence[str]) -> None:
    """Measure what the arguments say."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--students", type=int, default=30)
    parser.add_argument("--seconds", type=float, default=30.0, help="of each part (default: %(default)s)")
    options = parser.parse_args(arguments)
    with tempfile.TemporaryDirectory() as folder:
        measure(options.students, options.seconds, pathlib.Path(folder))


if __name__ == "__main__":
    main(sys.argv[1:])
