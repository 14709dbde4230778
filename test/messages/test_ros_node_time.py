"""Pausing and repeating in simulated time: before it begins, while it stands, and when it jumps back."""

import threading

import pytest
import rospy
from rospy import rostime

from pioneer_control import ros_node

LIMIT = 30.0  # s: generous; nothing waits that long


@pytest.fixture
def clock(monkeypatch):
    """Set simulated time [s]. At first there is none."""
    monkeypatch.setattr(rostime, "_rostime_current", rospy.Time(0))
    monkeypatch.setattr(rostime, "_rostime_initialized", True)
    monkeypatch.setattr(rospy.core, "is_shutdown", lambda: False)
    return lambda seconds: rostime._set_rostime(rospy.Time.from_sec(seconds))


class Beside:
    """Runs a generator in a thread, and counts what it yields."""

    def __init__(self, work):
        self.count, self.changed, self.ended, self.error = 0, threading.Condition(), False, None
        threading.Thread(target=self._run, args=(work,), daemon=True).start()

    def _run(self, work):
        try:
            for _ in work():
                with self.changed:
                    self.count += 1
                    self.changed.notify_all()
        except rospy.ROSException as error:
            self.error = error
        with self.changed:
            self.ended = True
            self.changed.notify_all()

    def wait(self, condition):
        with self.changed:
            assert self.changed.wait_for(condition, LIMIT)


def once(function, *arguments):
    """Return a generator function that calls `function` and yields nothing."""
    def work():
        function(*arguments)
        yield from ()
    return work


def test_ticks_keep_to_the_time_and_wait_while_it_stands(clock):
    clock(100.0)
    beside = Beside(lambda: ros_node.ticks(10, 0.5))
    for tick in range(1, 5):
        beside.wait(lambda: beside.count == tick)
        clock(100.0 + tick * 0.1 - 0.01)
        assert beside.count == tick and not beside.ended
        clock(100.0 + tick * 0.1 + 0.001)
    beside.wait(lambda: beside.count == 5)
    clock(100.6)
    beside.wait(lambda: beside.ended)
    assert beside.count == 5 and beside.error is None


def test_ticks_are_no_more_when_time_jumps_back(clock):
    clock(100.0)
    beside, now = Beside(lambda: ros_node.ticks(10, 0.5)), 1.0
    while not beside.ended:
        clock(now)
        now += 0.01
        with beside.changed:
            beside.changed.wait(0.001)
    assert beside.count == 5 and beside.error is None


def test_ticks_end_with_ros(clock, monkeypatch):
    monkeypatch.setattr(rospy, "is_shutdown", lambda: True)
    assert list(ros_node.ticks(10, 0.5)) == []


def test_a_pause_begins_again_when_time_jumps_back(clock):
    clock(100.0)
    beside = Beside(once(ros_node.sleep, 2.0))
    clock(101.0)
    clock(50.0)
    clock(51.9)
    with beside.changed:
        assert not beside.changed.wait_for(lambda: beside.ended, 0.1)
    clock(200.0)
    beside.wait(lambda: beside.ended)
    assert beside.error is None


def test_rospys_own_pause_would_raise(clock):
    clock(100.0)
    beside = Beside(once(rospy.sleep, 2.0))
    while not beside.ended:     # until it has begun
        clock(101.0)
        clock(50.0)
        with beside.changed:
            beside.changed.wait(0.001)
    assert isinstance(beside.error, rospy.ROSTimeMovedBackwardsException)


def test_it_is_said_that_there_is_no_time_and_waited_for(clock, monkeypatch):
    said = []
    monkeypatch.setattr(rospy, "loginfo", said.append)
    beside = Beside(once(ros_node.wait_for_clock))
    beside.wait(lambda: beside.ended or said)
    assert "/clock" in said[0] and not beside.ended
    now = 100.0
    while not beside.ended:     # a time alone will not do: it may stand
        clock(now)
        now += 0.1
        with beside.changed:
            beside.changed.wait(0.001)
    assert beside.error is None and len(said) == 1


def test_while_it_waits_for_the_time_ros_may_end(clock, monkeypatch):
    monkeypatch.setattr(rospy, "loginfo", lambda _: None)
    beside = Beside(once(ros_node.wait_for_clock))
    monkeypatch.setattr(rospy.core, "is_shutdown", lambda: True)
    beside.wait(lambda: beside.ended)
    assert isinstance(beside.error, rospy.ROSInterruptException)


def test_real_time_is_not_waited_for(clock, monkeypatch):
    monkeypatch.setattr(rostime, "_rostime_current", None)
    monkeypatch.setattr(rospy, "loginfo", None)     # calling it would raise
    ros_node.wait_for_clock()
