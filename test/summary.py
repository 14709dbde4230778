"""Adds up what `./pioneer test` left. Names every failure and the slowest tests; its last line is `N passed, N failed`.

The folder given has one folder per kind of test, and in each one folder per suite: JUnit files, and ``status``, the
exit status of the program that ran the suite. A kind without a test, a suite without a test, and a suite that ended
badly although every test in its files is fine (it hung, or crashed) are failures too: silence never passes.
"""

import pathlib
import sys
import xml.etree.ElementTree as ElementTree
from typing import List, NamedTuple

KINDS = ("unit", "mypy", "flake8", "messages", "integration", "browser", "rostest")
SLOWEST = 10
"""So many tests are named."""
REASON = 300
"""Characters of the reason of a failure that are shown."""
TRACEBACK = '\n  File "'
"""Where a traceback begins."""


class Timing(NamedTuple):
    """How long (s) a test took, and its name. The first of them sorted is the shortest."""

    seconds: float
    name: str


class Outcome(NamedTuple):
    """The results of some tests: how many passed and were skipped, a name for each failure, and how long each test
    took.

    For the checkers, a file without findings is a pass and each finding is a failure. ``ignores`` counts what they were
    told to ignore.
    """

    passed: int
    failed: List[str]
    skipped: int
    timings: List[Timing]
    ignores: int = 0


def reason(fault: ElementTree.Element) -> str:
    """Return in one line why a test failed: ``fault`` is the <failure> or <error> of a JUnit file.

    pytest writes the reason into ``message``. rosunit writes it before the traceback, and the exception into ``type``.
    """
    said = fault.get("message") or "%s: %s" % (fault.get("type"), (fault.text or "").split(TRACEBACK)[0])
    return " ".join(said.split())[:REASON]


def suite_outcome(suite: pathlib.Path) -> Outcome:
    """Return the outcome of one suite's folder."""
    passed, failed, skipped, timings, ignores = 0, [], 0, [], 0
    # rostest writes the results of a node once more in its own rostest-*.xml.
    for report in sorted(path for path in suite.glob("**/*.xml") if not path.name.startswith("rostest-")):
        try:
            tree = ElementTree.parse(report)
        except ElementTree.ParseError as error:
            failed.append("%s: %s breaks off: %s" % (suite.name, report.name, error))
            continue
        ignores += sum(int(each.get("value")) for each in tree.iter("property") if each.get("name") == "ignores")
        for case in tree.iter("testcase"):
            name = "%s: %s.%s" % (suite.name, case.get("classname"), case.get("name"))
            timings.append(Timing(float(case.get("time") or 0.0), name))
            fault = next((each for each in case if each.tag in ("failure", "error")), None)
            if fault is not None:
                failed.append("%s: %s" % (name, reason(fault)))
            elif case.find("skipped") is not None:
                skipped += 1
            else:
                passed += 1
    status_file = suite / "status"
    status = status_file.read_text().strip() if status_file.exists() else "unknown"
    if not passed and not failed:
        failed.append("%s: no test ran (status %s)" % (suite.name, status))
    elif not failed and status != "0":
        failed.append("%s: ended with status %s" % (suite.name, status))
    return Outcome(passed, failed, skipped, timings, ignores)


def kind_outcome(kind: pathlib.Path) -> Outcome:
    """Return the outcome of all suites of one kind."""
    suites = [suite_outcome(folder) for folder in sorted(kind.glob("*")) if folder.is_dir()]
    return Outcome(sum(suite.passed for suite in suites),
                   [name for suite in suites for name in suite.failed] if suites else ["tests: none was found"],
                   sum(suite.skipped for suite in suites),
                   [timing for suite in suites for timing in suite.timings],
                   sum(suite.ignores for suite in suites))


def main(results: str) -> int:
    """Print the summary of a folder of results. Returns the exit status: 0 when every test passed."""
    outcomes = {kind: kind_outcome(pathlib.Path(results) / kind) for kind in KINDS}
    for kind, outcome in outcomes.items():
        for name in outcome.failed:
            print("FAILED %s %s" % (kind, name))
    timings = [Timing(seconds, "%s %s" % (kind, name))
               for kind, outcome in outcomes.items() for seconds, name in outcome.timings]
    print("\nslowest %d tests" % SLOWEST)
    for seconds, name in sorted(timings, reverse=True)[:SLOWEST]:
        print("%6.1f s  %s" % (seconds, name))
    print()
    for kind, outcome in outcomes.items():
        print("%-12s %4d passed, %d failed" % (kind, outcome.passed, len(outcome.failed)) +
              (", %d ignores" % outcome.ignores if outcome.ignores else ""))
    passed, failed, skipped = (sum(numbers) for numbers in zip(*(
        (outcome.passed, len(outcome.failed), outcome.skipped) for outcome in outcomes.values())))
    print("%d passed, %d failed" % (passed, failed) + (", %d skipped" % skipped if skipped else ""))
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
