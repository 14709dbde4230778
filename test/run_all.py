"""Runs every suite of tests, side by side where no suite disturbs another. `summary.py` adds up the results.

Two rows run beside each other. One has the suites of pytest, one at a time: each has workers of its own. The other has
the rostests, which mostly wait, and at last the checks of all code: as many at once as there are processors.

    run_all.py SOURCE RESULTS LOGS

`./pioneer test` calls this in a built workspace. Each suite gets a folder ``RESULTS/KIND/NAME`` for its JUnit files and
its ``status``. Its output goes to ``LOGS/KIND-NAME.log``. A suite that takes longer than its limit is ended. SIGINT,
SIGTERM and SIGHUP end all suites in order, and then this program.
"""

import contextlib
import os
import pathlib
import re
import signal
import subprocess
import sys
import time
from typing import Dict, List, NamedTuple, Sequence

LIMIT = 900.0
"""Seconds for one suite."""
TEST_LIMIT = 300
"""Seconds for one test of pytest, which is named when it takes longer."""
GRACE = 30.0
"""Seconds that a suite has to end its own programs once it was interrupted."""
LONGEST_FIRST = (
    "driver_lines", "tutorial_nodes", "bag_replay", "tutorial_pioneer", "navigation", "drive_by_hand",
    "bag_beside_robot", "navigation_faults")
"""These rostests take longest. They begin, so that none of them is left running alone at the end."""
ENDING = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
LINES_SHOWN = 100
"""Lines of the log of a suite that failed."""
PROGRESS = re.compile(r"[.FEsxX]+ *\[ *\d+%\]")
"""A line of pytest's that is not shown then."""


class Suite(NamedTuple):
    """Tests that one program runs: its command, and variables added to its environment."""

    kind: str
    name: str
    command: List[str]
    environment: Dict[str, str] = {}


class Row(NamedTuple):
    """Suites that begin in this order, at most `at_once` at the same time."""

    suites: List[Suite]
    at_once: int = 1


def all_rows(source: pathlib.Path, results: pathlib.Path, cores: int) -> List[Row]:
    """Return all tests, in rows that run beside each other.

    Together they keep the processors busy, and do not overload them: on an overloaded machine, all takes longer
    altogether, and tests that watch a robot in real time see it stand still.
    """
    rostests = sorted((source / "test" / "rostest").glob("*.test"))
    rostests.sort(key=lambda path: LONGEST_FIRST.index(path.stem) if path.stem in LONGEST_FIRST else len(LONGEST_FIRST))
    of_pytest = [
        pytest_suite("integration", results, 3 * cores), pytest_suite("browser", results, cores + 1),
        pytest_suite("unit", results, cores), pytest_suite("messages", results, cores)]
    checks = [check_suite("mypy", results), check_suite("flake8", results)]
    return [Row(of_pytest), Row([rostest_suite(path, results) for path in rostests] + checks, cores)]


def pytest_suite(kind: str, results: pathlib.Path, workers: int) -> Suite:
    """Return the suite of one folder, run by pytest."""
    report = results / kind / "pytest" / "pytest.xml"
    return Suite(kind, "pytest", [
        sys.executable, "-m", "pytest", "-q", "--no-header", "--continue-on-collection-errors", "-p",
        "no:cacheprovider",
        "-n", str(workers), "--timeout", str(TEST_LIMIT), "--junit-xml=%s" % report, "test/" + kind])


def rostest_suite(path: pathlib.Path, results: pathlib.Path) -> Suite:
    """Return the suite of one .test file. rostest gives it a master of its own."""
    environment = {"ROS_TEST_RESULTS_DIR": str(results / "rostest" / path.stem)}
    return Suite("rostest", path.stem, ["rostest", str(path)], environment)


def check_suite(tool: str, results: pathlib.Path) -> Suite:
    """Return the suite that checks all code with mypy or flake8."""
    report = results / tool / tool / "findings.xml"
    return Suite(tool, tool, [sys.executable, "test/check_code.py", tool, str(report)])


class Running:
    """A suite that runs, in a process group of its own."""

    def __init__(self, suite: Suite, results: pathlib.Path, logs: pathlib.Path):
        self.suite = suite
        self.began = time.monotonic()
        self.log = logs / ("%s-%s.log" % (suite.kind, suite.name))
        self._folder = results / suite.kind / suite.name
        self._folder.mkdir(parents=True)
        with self.log.open("wb") as log:
            self._process = subprocess.Popen(
                suite.command, env=dict(os.environ, **suite.environment), start_new_session=True,
                stdin=subprocess.DEVNULL, stdout=log, stderr=subprocess.STDOUT)

    @property
    def ended(self) -> bool:
        """Return whether its program has ended."""
        return self._process.poll() is not None

    def interrupt(self) -> None:
        """Ask it to end."""
        with contextlib.suppress(ProcessLookupError):
            os.killpg(self._process.pid, signal.SIGINT)

    def end(self) -> None:
        """Wait some time for the end of an interrupted suite, and kill what is left of it."""
        with contextlib.suppress(subprocess.TimeoutExpired):
            self._process.wait(GRACE)
        with contextlib.suppress(ProcessLookupError):
            os.killpg(self._process.pid, signal.SIGKILL)
        self._process.wait()

    def settle(self, status: str) -> None:
        """Write down how it ended, and print it."""
        (self._folder / "status").write_text(status + "\n")
        good = status == "0"
        name = " ".join([self.suite.kind] + [self.suite.name] * (self.suite.kind == "rostest"))
        print("%-32s %-6s %4d s" % (name, "ok" if good else "FAILED", time.monotonic() - self.began), flush=True)
        if not good:
            lines = [line for line in self.log.read_text(encoding="utf-8", errors="replace").splitlines()
                     if not PROGRESS.fullmatch(line)]
            print("\n".join("    | " + line for line in lines[-LINES_SHOWN:]))
            print("    all of its output: %s" % self.log, flush=True)

    def look(self, limit: float) -> bool:
        """Return whether it is over: it has ended, or its time is up."""
        if self.ended:
            self.settle(str(self._process.returncode))
        elif time.monotonic() - self.began > limit:
            self.interrupt()
            self.end()
            self.settle("124 (not within %.0f s)" % limit)
        else:
            return False
        return True


class Interruption:
    """Whether a signal has come that must end everything."""

    def __init__(self) -> None:
        self.signal_name = ""
        for number in ENDING:
            signal.signal(number, self._note)

    def _note(self, number: int, _: object) -> None:
        self.signal_name = signal.Signals(number).name

    def __bool__(self) -> bool:
        return bool(self.signal_name)


class RunningRow:
    """A row that runs."""

    def __init__(self, row: Row, results: pathlib.Path, logs: pathlib.Path, limit: float):
        self._waiting, self._at_once = list(row.suites), row.at_once
        self._running: List[Running] = []
        self._results, self._logs, self._limit = results, logs, limit

    def turn(self) -> bool:
        """Start what may start. Returns whether there is something left that runs or waits."""
        self._running = [suite for suite in self._running if not suite.look(self._limit)]
        while self._waiting and len(self._running) < self._at_once:
            self._running.append(Running(self._waiting.pop(0), self._results, self._logs))
        return bool(self._running)

    def interrupt(self) -> None:
        """Ask all that runs to end."""
        for suite in self._running:
            suite.interrupt()

    def end(self) -> None:
        """Wait some time for the end of what was interrupted, and kill what is left of it."""
        for suite in self._running:
            suite.end()


def run(rows: Sequence[Row], results: pathlib.Path, logs: pathlib.Path, interruption: Interruption,
        limit: float = LIMIT) -> None:
    """Run rows beside each other to their end, or until an interruption."""
    running = [RunningRow(row, results, logs, limit) for row in rows]
    while any([row.turn() for row in running]) and not interruption:
        time.sleep(0.05)
    for row in running:
        row.interrupt()
    for row in running:
        row.end()


def main(arguments: Sequence[str]) -> int:
    """Run all tests. Returns the exit status: 0 when all suites ran to their end, whatever their results are."""
    source, results, logs = map(pathlib.Path, arguments)
    interruption = Interruption()
    run(all_rows(source, results, len(os.sched_getaffinity(0))), results, logs, interruption)
    if interruption:
        print("%s: all tests are ended" % interruption.signal_name)
        return 130
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
