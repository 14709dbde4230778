"""The progress bar: only on a terminal, and only when the work takes long."""

import io

import pytest

from pioneer_control.bags import command_line
from pioneer_control.bags.command_line import PATIENCE, Progress


class Screen(io.StringIO):
    """A terminal or a file, which keeps what is written."""

    def __init__(self, terminal):
        super().__init__()
        self.isatty = lambda: terminal


@pytest.fixture
def shown(monkeypatch):
    """Return what is written while something is read that takes so many seconds for each half."""

    def shown(terminal, seconds):
        screen, now = Screen(terminal), [0.0]
        monkeypatch.setattr(command_line.sys, "stderr", screen)
        monkeypatch.setattr(command_line.time, "monotonic", lambda: now[0])
        with Progress("run.bag") as bar:
            for done in (50_000, 100_000):
                now[0] += seconds
                bar(done, 100_000)
        return screen.getvalue()

    return shown


def test_a_long_bag_on_a_terminal(shown):
    assert "run.bag" in shown(True, 0.6 * PATIENCE) and "100k" in shown(True, 0.6 * PATIENCE)


@pytest.mark.parametrize("terminal, seconds", [(True, 0.4 * PATIENCE), (False, 5 * PATIENCE)])
def test_nothing_is_shown(shown, terminal, seconds):
    assert shown(terminal, seconds) == ""
