"""`test/run_all.py` with stand-ins for the suites: what runs side by side, what hangs, what fails, and what ends what.
"""

import os
import pathlib
import signal
import subprocess
import sys
import time

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "test"))

import run_all

LIMIT = 30.0        # s: generous; nothing waits that long


class NoInterruption:
    """An Interruption that never happens."""

    def __bool__(self):
        return False


def suite(name, script):
    return run_all.Suite("rostest", name, ["/bin/bash", "-c", script])


def until(condition):
    end = time.monotonic() + LIMIT
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.01)


@pytest.fixture
def run_rows(tmp_path, capsys):
    """Run rows. Returns the statuses, and the output."""
    def run(*rows, limit=LIMIT):
        run_all.run(rows, tmp_path / "results", tmp_path / "logs", NoInterruption(), limit)
        statuses = {path.parent.name: path.read_text().strip() for path in (tmp_path / "results").rglob("status")}
        return statuses, capsys.readouterr().out
    (tmp_path / "logs").mkdir()
    return run


@pytest.fixture
def run(run_rows):
    """Run suites as one row. Returns the statuses, and the output."""
    return lambda *suites, at_once=1, **limit: run_rows(run_all.Row(list(suites), at_once), **limit)


def test_a_good_suite_is_told_in_a_line(run):
    statuses, printed = run(suite("good", "echo fine"))
    assert statuses == {"good": "0"}
    assert "good" in printed and "ok" in printed and "fine" not in printed


def test_the_end_of_a_bad_suites_log_is_shown(run):
    statuses, printed = run(suite("bad", "echo '..F.... [ 10%]'; echo why; exit 3"))
    assert statuses == {"bad": "3"}
    assert "FAILED" in printed and "| why" in printed and "rostest-bad.log" in printed
    assert "[ 10%]" not in printed


def pair_that_meets(tmp_path):
    """Return two suites, each of which waits for the file of the other."""
    meet = "touch {0}/{1}; until [ -e {0}/{2} ]; do sleep 0.01; done"
    return [suite(one, meet.format(tmp_path, one, other)) for one, other in ("ab", "ba")]


def test_suites_run_beside_each_other(run, tmp_path):
    statuses, _ = run(*pair_that_meets(tmp_path), at_once=2)
    assert statuses == {"a": "0", "b": "0"}


def test_rows_run_beside_each_other(run_rows, tmp_path):
    statuses, _ = run_rows(*(run_all.Row([each]) for each in pair_that_meets(tmp_path)))
    assert statuses == {"a": "0", "b": "0"}


def test_no_more_of_them_than_may(run, tmp_path):
    alone = "mkdir %s/alone && sleep 0.2 && rmdir %s/alone" % (tmp_path, tmp_path)
    statuses, _ = run(*(suite(name, alone) for name in "abc"), at_once=1)
    assert set(statuses.values()) == {"0"}


def test_a_suite_that_hangs_is_ended_and_named(run, tmp_path):
    script = "trap 'touch %s/ended; exit' INT; while :; do sleep 0.01; done" % tmp_path
    statuses, printed = run(suite("hung", script), suite("next", "true"), limit=0.5)
    assert statuses["hung"].startswith("124") and statuses["next"] == "0"
    assert "hung" in printed and "FAILED" in printed
    assert (tmp_path / "ended").exists()


def test_a_suite_that_does_not_end_when_told_is_killed_with_its_programs(run, tmp_path, monkeypatch):
    monkeypatch.setattr(run_all, "GRACE", 0.2)
    script = "trap '' INT; sleep 1000 & echo $! >%s/sleeper; while :; do sleep 0.01; done" % tmp_path
    statuses, _ = run(suite("deaf", script), limit=0.5)
    assert statuses["deaf"].startswith("124")
    until(lambda: not is_alive(int((tmp_path / "sleeper").read_text())))


def is_alive(pid):
    try:
        state = pathlib.Path("/proc/%d/stat" % pid).read_text().rpartition(")")[2].split()[0]
    except OSError:
        return False
    return state != "Z"


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_an_interrupted_run_ends_all_in_order_and_starts_no_more(tmp_path, number):
    """It runs in a process of its own. Its suites are replaced by two that run and one that waits."""
    (tmp_path / "logs").mkdir()
    program = """
import pathlib, sys
sys.path.insert(0, %r)
import run_all
script = "trap 'sleep 0.2; touch %s/ended-$0; exit' INT; touch %s/began-$0; while :; do sleep 0.01; done"
suites = [run_all.Suite("rostest", name, ["/bin/bash", "-c", script, name]) for name in "abc"]
later = [run_all.Suite("rostest", "later", ["/bin/bash", "-c", script, "later"])]
run_all.all_rows = lambda *_: [run_all.Row(suites[:1] + later), run_all.Row(suites[1:] + later)]
sys.exit(run_all.main(sys.argv[1:]))
""" % (str(ROOT / "test"), tmp_path, tmp_path)
    command = [sys.executable, "-c", program, str(ROOT), str(tmp_path / "results"), str(tmp_path / "logs")]
    with subprocess.Popen(command, stdout=subprocess.PIPE, universal_newlines=True) as process:
        until(lambda: (tmp_path / "began-a").exists() and (tmp_path / "began-b").exists())
        os.kill(process.pid, number)
        printed = process.communicate(timeout=LIMIT)[0]
    assert process.returncode == 130
    assert sorted(path.name for path in tmp_path.glob("*-*")) == ["began-a", "began-b", "ended-a", "ended-b"]
    assert signal.Signals(number).name in printed


def test_every_folder_and_rostest_is_in_a_row():
    suites = [each for row in run_all.all_rows(ROOT, pathlib.Path("results"), 2) for each in row.suites]
    folders = {each.command[-1] for each in suites if each.name == "pytest"}
    assert folders == {"test/unit", "test/messages", "test/integration", "test/browser"}
    rostests = [each.name for each in suites if each.kind == "rostest"]
    assert sorted(rostests) == sorted(path.stem for path in (ROOT / "test" / "rostest").glob("*.test"))
    assert tuple(rostests[:len(run_all.LONGEST_FIRST)]) == run_all.LONGEST_FIRST


def test_rostests_run_beside_the_suites_of_pytest():
    rows = [{each.kind for each in row.suites} for row in run_all.all_rows(ROOT, pathlib.Path("results"), 2)]
    assert rows == [{"integration", "browser", "unit", "messages"}, {"rostest", "mypy", "flake8"}]
