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


class Time:
    """A clock that only sleeping moves on."""

    now = 0.0

    def clock(self):
        return self.now

    def sleep(self, seconds):
        self.now += seconds


def test_waits_no_longer_than_needed():
    time = Time()
    assert when_recording.wait_for(lambda: time.now >= 1.0, 5.0, time.clock, time.sleep)
    assert time.now == pytest.approx(1.0, abs=2 * when_recording.INTERVAL)


def test_gives_up():
    time = Time()
    assert not when_recording.wait_for(lambda: False, 5.0, time.clock, time.sleep)
    assert time.now == pytest.approx(5.0, abs=2 * when_recording.INTERVAL)


def test_usage():
    with pytest.raises(SystemExit, match="usage"):
        when_recording.main(["/recorder"])
