"""A program waits for a recorder. It asks the master."""

import os
import sys
import time
from types import SimpleNamespace

import pytest

from pioneer_control.bags.recording import when_recording


@pytest.mark.parametrize(
    "subscribers, expected",
    [
        ([], False),
        ([["/pioneer/pose", ["/rviz"]]], False),
        ([["/clock", ["/recorder"]]], False),
        ([["/pioneer/pose", ["/rviz", "/recorder"]]], True),
    ],
)
def test_subscribed(subscribers, expected):
    assert when_recording.subscribed("/recorder", [[["/pioneer/pose", ["/recorder"]]], subscribers, []]) is expected


@pytest.fixture
def waited(monkeypatch):
    """Return a function that runs a program which waits for a recorder. The recorder listens when the master is asked
    for the ``asked``-th time. The function returns the times that the program slept.
    """

    def waited(asked):
        slept, became = [], []

        def state():
            return [[], [["/pioneer/pose", ["/recorder"]]] if len(slept) == asked - 1 else [], []]

        monkeypatch.setitem(sys.modules, "rosgraph",
                            SimpleNamespace(Master=lambda name: SimpleNamespace(getSystemState=state)))
        monkeypatch.setattr(time, "sleep", slept.append)
        monkeypatch.setattr(os, "execv", lambda *command: became.append(command))
        when_recording.main(["/recorder", "/bin/echo", "1"])
        assert became == [("/bin/echo", ["/bin/echo", "1"])]
        return slept

    return waited


@pytest.mark.parametrize("asked", [1, 2, 21])
def test_waits_no_longer_than_needed(waited, capsys, asked):
    assert waited(asked) == [when_recording.INTERVAL] * (asked - 1)
    assert capsys.readouterr().err == ""


def test_gives_up(waited, capsys):
    assert sum(waited(10 ** 6)) == pytest.approx(when_recording.PATIENCE, abs=2 * when_recording.INTERVAL)
    assert "no recorder /recorder after 15 s" in capsys.readouterr().err


def test_usage():
    with pytest.raises(SystemExit, match="usage"):
        when_recording.main(["/recorder"])
