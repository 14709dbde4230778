"""config/pioneer-env: what roslaunch starts on a robot's computer, and what ends with the desk."""

import pathlib
import subprocess

import pytest

LIMIT = 60.0
LOADER = pathlib.Path(__file__).resolve().parents[3] / "config" / "pioneer-env"
HOSTILE = "a b $HOME \"q\" 'r' \\"


@pytest.fixture
def start(tmp_path):
    """Start the loader, with a setup.bash of this text or none, and a command."""
    def start(setup, *words):
        if setup is not None:
            (tmp_path / "setup.bash").write_text(setup)
        loader = tmp_path / "pioneer-env"
        loader.write_text(LOADER.read_text().replace("~/catkin_ws/devel/setup.bash", str(tmp_path / "setup.bash")))
        return subprocess.Popen(["/bin/bash", str(loader), *words], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                stderr=subprocess.DEVNULL, universal_newlines=True)
    return start


def test_the_workspace_is_set_up_and_each_word_passed_on(start):
    with start('export SEEN="$#"\n', "/bin/sh", "-c", 'printf "%s\\n" "$SEEN" "${ROS_HOSTNAME:+named}" "$@"', "-",
               HOSTILE) as loader:
        assert loader.stdout.read() == "0\nnamed\n%s\n" % HOSTILE


def test_what_it_started_ends_when_the_desk_is_gone(start):
    with start("", "/bin/sh", "-c", "echo begun; exec sleep 600") as loader:
        assert loader.stdout.readline() == "begun\n" and loader.poll() is None
        loader.stdin.close()
        assert loader.wait(LIMIT) == -2     # SIGINT


def test_without_the_workspace_nothing_starts(start):
    with start(None, "/bin/echo", "begun") as loader:
        assert loader.stdout.read() == "" and loader.wait(LIMIT)
