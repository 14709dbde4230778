"""Waiting for a recorder, by what the master says."""

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


@pytest.mark.parametrize("asked", [1, 2, 21])
def test_waits_no_longer_than_needed(asked):
    answers, slept = iter([False] * (asked - 1) + [True]), []
    assert when_recording.wait_for(lambda: next(answers), slept.append)
    assert slept == [when_recording.INTERVAL] * (asked - 1)


def test_gives_up():
    slept = []
    assert not when_recording.wait_for(lambda: False, slept.append)
    assert sum(slept) == pytest.approx(when_recording.PATIENCE, abs=2 * when_recording.INTERVAL)


def test_usage():
    with pytest.raises(SystemExit, match="usage"):
        when_recording.main(["/recorder"])
