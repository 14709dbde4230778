"""Adds up what `./pioneer test` left, names every failure, and ends with the line `N passed, N failed`.

The folder given has one folder per kind of test, and in each one folder per suite: JUnit files, and ``status``, the exit status
of the program that ran the suite. A kind without a test, a suite without a test, and a suite that ended badly although every
test in its files is fine (it hung, or crashed) are failures too: silence never passes.
"""

import pathlib
import sys
import xml.etree.ElementTree as ElementTree
from typing import List, NamedTuple

KINDS = ("unit", "messages", "integration", "rostest")


class Outcome(NamedTuple):
    """What came of some tests: how many passed and were skipped, and a name for each that failed."""

    passed: int
    failed: List[str]
    skipped: int


def suite_outcome(suite: pathlib.Path) -> Outcome:
    """The outcome of one suite's folder."""
    passed, failed, skipped = 0, [], 0
    # rostest writes the results of a node once more in its own rostest-*.xml.
    for report in sorted(path for path in suite.glob("**/*.xml") if not path.name.startswith("rostest-")):
        try:
            cases = list(ElementTree.parse(report).iter("testcase"))
        except ElementTree.ParseError as error:
            failed.append("%s: %s breaks off: %s" % (suite.name, report.name, error))
            continue
        for case in cases:
            if case.find("failure") is not None or case.find("error") is not None:
                failed.append("%s: %s.%s" % (suite.name, case.get("classname"), case.get("name")))
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
    return Outcome(passed, failed, skipped)


def kind_outcome(kind: pathlib.Path) -> Outcome:
    """The outcome of all suites of one kind."""
    suites = [suite_outcome(folder) for folder in sorted(kind.glob("*")) if folder.is_dir()]
    return Outcome(sum(suite.passed for suite in suites),
                   [name for suite in suites for name in suite.failed] if suites else ["tests: none was found"],
                   sum(suite.skipped for suite in suites))


def main(results: str) -> int:
    """Print the summary of a folder of results; the exit status: 0 when every test passed."""
    outcomes = {kind: kind_outcome(pathlib.Path(results) / kind) for kind in KINDS}
    for kind, outcome in outcomes.items():
        for name in outcome.failed:
            print("FAILED %s %s" % (kind, name))
    for kind, outcome in outcomes.items():
        print("%-12s %4d passed, %d failed" % (kind, outcome.passed, len(outcome.failed)))
    passed, failed, skipped = (sum(numbers) for numbers in zip(*(
        (outcome.passed, len(outcome.failed), outcome.skipped) for outcome in outcomes.values())))
    print("%d passed, %d failed" % (passed, failed) + (", %d skipped" % skipped if skipped else ""))
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
