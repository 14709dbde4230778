"""Ctrl-C while a program imports modules: it ends, and shows no traceback."""

import os
import pathlib
import re
import signal
import subprocess
import sys

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]

INTERRUPTED_IMPORTS = """
import runpy, sys

class CtrlC:
    @staticmethod
    def find_spec(name, *_):
        if name == "rospy" or name.startswith("pioneer_control.") and name != "pioneer_control.interrupt":
            raise KeyboardInterrupt

sys.meta_path.insert(0, CtrlC)
"""


def ended(code, *arguments):
    """Return the exit status of a program, and what it writes to stderr."""
    environment = dict(os.environ, PYTHONPATH=str(ROOT / "src"))
    done = subprocess.run([sys.executable, "-c", code, *arguments], env=environment, stderr=subprocess.PIPE,
                          universal_newlines=True)
    return done.returncode, done.stderr


def scripts():
    """Return the nodes whose imports take long enough for a Ctrl-C. The node that only becomes RViz is not one of them.
    """
    slow = re.compile(r"^(from|import) (rospy|pioneer_control(?!\.interrupt\b))", re.MULTILINE)
    return sorted(path for path in (ROOT / "nodes").iterdir() if path.is_file() and slow.search(path.read_text()))


@pytest.mark.parametrize("script", scripts(), ids=lambda path: path.name)
def test_each_script_ends_without_a_word(script):
    assert ended(INTERRUPTED_IMPORTS + "runpy.run_path(sys.argv[1], run_name='__main__')",
                 str(script)) == (-signal.SIGINT, "")


def test_all_nodes_but_one_are_scripts_with_slow_imports():
    assert {path.name for path in (ROOT / "nodes").iterdir() if path.is_file()} - {path.name for path in scripts()} == {
        "view"}


def test_without_it_python_shows_where():
    code, said = ended(INTERRUPTED_IMPORTS + "import pioneer_control.errors")
    assert code == -signal.SIGINT and "Traceback" in said


def test_any_other_error_is_shown():
    code, said = ended("import pioneer_control.interrupt; 1 / 0")
    assert code == 1 and "Traceback" in said and "ZeroDivisionError" in said
