"""The last line of `./pioneer test` is true."""

import pathlib
import sys

import pytest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

import summary

GOOD = '<testcase classname="c" name="good"/>'
BAD = '<testcase classname="c" name="bad"><failure>why</failure></testcase>'
BROKEN = '<testcase classname="c" name="broken"><error>why</error></testcase>'
SKIPPED = '<testcase classname="c" name="left out"><skipped/></testcase>'


def write_suite(results, kind, name, cases, status="0", report="rosunit-x.xml"):
    folder = results / kind / name
    folder.mkdir(parents=True, exist_ok=True)
    (folder / report).write_text("<testsuite>%s</testsuite>" % cases)
    (folder / "status").write_text(status + "\n")


@pytest.fixture
def results(tmp_path):
    """Return the results of a run without failures: one test of each kind."""
    for kind in summary.KINDS:
        write_suite(tmp_path, kind, "suite", GOOD)
    return tmp_path


def last_line(capsys):
    return capsys.readouterr().out.splitlines()[-1]


def test_all_is_well(results, capsys):
    assert summary.main(str(results)) == 0
    assert last_line(capsys) == "7 passed, 0 failed"


@pytest.mark.parametrize("case", [BAD, BROKEN])
def test_failures_and_errors_count_and_are_named(results, capsys, case):
    write_suite(results, "rostest", "suite", GOOD + case, status="1")
    assert summary.main(str(results)) == 1
    output = capsys.readouterr().out
    assert output.endswith("7 passed, 1 failed\n")
    assert "FAILED rostest suite: c." in output


@pytest.mark.parametrize("fault, reason", [
    ('<failure type="AssertionError">58 != 60 : of\nthe wander\n  File "x.py", line 3, in test\n    f()\n</failure>',
     "AssertionError: 58 != 60 : of the wander"),
    ('<error type="StopIteration">\n  File "x.py", line 3, in test\n</error>', "StopIteration:"),
    ('<failure message="AssertionError: assert 1 == 2&#10;  where 1 = f()">def test(): ...</failure>',
     "AssertionError: assert 1 == 2 where 1 = f()"),
    ('<failure message="%s"/>' % ("x" * 301), "x" * 300)], ids=("of rosunit", "without a text", "of pytest", "long"))
def test_a_failure_is_shown_with_its_reason(results, capsys, fault, reason):
    write_suite(results, "rostest", "suite", '<testcase classname="c" name="bad">%s</testcase>' % fault)
    summary.main(str(results))
    assert "FAILED rostest suite: c.bad: %s\n" % reason in capsys.readouterr().out


def test_what_rostest_writes_twice_counts_once(results, capsys):
    write_suite(results, "rostest", "suite", GOOD, report="rostest-test_suite.xml")
    summary.main(str(results))
    assert last_line(capsys) == "7 passed, 0 failed"


def test_a_skipped_test_is_not_hidden(results, capsys):
    write_suite(results, "unit", "suite", GOOD + SKIPPED)
    assert summary.main(str(results)) == 0
    assert last_line(capsys) == "7 passed, 0 failed, 1 skipped"


def test_a_kind_without_tests_is_a_failure(results, capsys):
    for path in sorted((results / "integration").rglob("*"), reverse=True):
        path.rmdir() if path.is_dir() else path.unlink()
    assert summary.main(str(results)) == 1
    assert last_line(capsys) == "6 passed, 1 failed"


def test_a_suite_without_tests_is_a_failure(results, capsys):
    write_suite(results, "rostest", "empty", "", status="0")
    assert summary.main(str(results)) == 1
    assert last_line(capsys) == "7 passed, 1 failed"


def test_a_suite_that_hung_after_its_last_test_is_a_failure(results, capsys):
    write_suite(results, "rostest", "hung", GOOD, status="124")
    assert summary.main(str(results)) == 1
    assert last_line(capsys) == "8 passed, 1 failed"


def test_a_report_that_breaks_off_is_a_failure(results, capsys):
    write_suite(results, "rostest", "suite", GOOD)
    write_suite(results, "rostest", "killed", GOOD, status="124")
    (results / "rostest" / "killed" / "rosunit-x.xml").write_text("<testsuite>" + GOOD)
    assert summary.main(str(results)) == 1
    assert last_line(capsys) == "7 passed, 1 failed"


def test_the_slowest_tests_are_named_slowest_first(results, capsys):
    cases = ['<testcase classname="c" name="number %d" time="%d.5"/>' % (number, number) for number in range(12)]
    write_suite(results, "unit", "suite", "".join(cases[::2]))
    write_suite(results, "rostest", "suite", "".join(cases[1::2]))
    summary.main(str(results))
    lines = capsys.readouterr().out.splitlines()
    start = lines.index("slowest 10 tests") + 1
    assert lines[start] == "  11.5 s  rostest suite: c.number 11"
    assert lines[start + 9] == "   2.5 s  unit suite: c.number 2"
    assert lines[start + 10] == ""


def test_the_ignores_of_a_checker_are_printed(results, capsys):
    write_suite(results, "mypy", "suite", '<properties><property name="ignores" value="3"/></properties>' + GOOD)
    assert summary.main(str(results)) == 0
    assert "mypy            1 passed, 0 failed, 3 ignores" in capsys.readouterr().out
