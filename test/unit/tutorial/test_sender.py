"""One thread publishes everything in order. It is not the caller's thread. The last velocity is zero."""

import signal
import threading

import pytest

from pioneer_control.tutorial.sender import Sender


class Publisher:
    """Keeps what is published. One thread cannot take its lock twice, as with rospy's connections."""

    def __init__(self):
        self.published = []
        self.lock = threading.Lock()

    def publish(self, message):
        with self.lock:
            self.published.append(message)


@pytest.fixture
def velocity():
    return Publisher()


@pytest.fixture
def sender(velocity):
    sender = Sender(velocity, 0)
    yield sender
    sender.end()


def test_in_order_and_from_another_thread(sender, velocity):
    with velocity.lock:
        for speed in range(100):
            sender.send(velocity, speed)  # would wait for ever for this lock, if it published
    sender.end()
    assert velocity.published[:100] == list(range(100))


def test_the_end_of_a_movement_is_a_stop(sender, velocity):
    sender.send(velocity, 3)
    sender.end()
    assert velocity.published[0] == 3 and len(velocity.published) > 1 and set(velocity.published[1:]) == {0}


def test_who_stands_or_never_drove_is_not_told_again(sender, velocity):
    other = Publisher()
    sender.send(velocity, 3)
    sender.send(velocity, 0)
    sender.send(other, 7)
    sender.end()
    assert velocity.published == [3, 0] and other.published == [7]


def test_nothing_after_the_end(sender, velocity):
    sender.end()
    sender.send(velocity, 3)
    sender.end()
    assert velocity.published == []


def test_a_signal_in_the_middle_of_sending_ends_it_too(sender, velocity):
    """At Ctrl-C rospy calls the hook in the main thread, at any line of it."""
    ended = threading.Event()
    before = signal.signal(signal.SIGALRM, lambda *_: (sender.end(), ended.set()))
    try:
        signal.setitimer(signal.ITIMER_REAL, 0.001)
        while not ended.is_set():
            sender.send(velocity, 3)
    finally:
        signal.signal(signal.SIGALRM, before)
    sender.send(velocity, 3)
    assert velocity.published[-1] == 0 and set(velocity.published[:-1]) == {3, 0}
