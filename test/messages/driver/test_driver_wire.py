"""The bytes of the line on a topic: all bytes in order, and none without a subscriber. The robot never waits for this
topic. Bytes that are left out are counted and reported.
"""

import threading
import time

import pytest
import rospy

from pioneer_control.driver import publications, wire_topic
from pioneer_control.driver.wire_topic import WirePublisher

LIMIT = 30.0        # s: generous; nothing waits that long
PIECES = [(True, b"\xFA\xFB\x03\x00\x00\x00"), (False, b"\xFA"), (False, b"noise"), (True, bytes(range(256)))]


class Publisher:
    """A publisher of wire. While `open` is not set, publish() hangs, as it does with a subscriber that reads nothing.
    """

    def __init__(self, name, kind, listener, tcp_nodelay, queue_size):
        self.name, self.listener, self.listeners, self.published = name, listener, 0, []
        self.busy, self.open = threading.Event(), threading.Event()
        self.open.set()

    def get_num_connections(self):
        return self.listeners

    def publish(self, message):
        self.busy.set()
        self.open.wait(LIMIT)
        self.published.append((message.to_robot, bytes(message.data)))
        self.stamp = message.header.stamp.to_sec()

    def begin(self):
        self.listeners = 1
        self.listener.peer_subscribe("wire", None, None)


@pytest.fixture
def topic(monkeypatch):
    """Return the publisher of wire. Its warnings are in ``said``."""
    made, said = [], []
    monkeypatch.setattr(
        rospy, "Publisher", lambda *args, **options: made.append(Publisher(*args, **options)) or made[0])
    monkeypatch.setattr(rospy, "logwarn", lambda text, *values: said.append(text % values))
    monkeypatch.setattr(publications, "ros_time", lambda: 1000.0)
    publisher = WirePublisher()
    made[0].tell, made[0].said = publisher.tell, said
    yield made[0]
    made[0].open.set()
    publisher.close()


def until(condition):
    ends = time.monotonic() + LIMIT
    while not condition() and time.monotonic() < ends:
        time.sleep(0.002)
    assert condition()


def test_every_piece_in_its_order_and_the_first_ones_wait_for_a_recorder(topic):
    for piece in PIECES[:2]:
        topic.tell(*piece)
    topic.begin()
    for piece in PIECES[2:]:
        topic.tell(*piece)
    until(lambda: len(topic.published) == len(PIECES))
    assert topic.published == PIECES and topic.name == "wire" and topic.said == []
    assert 0.0 <= 1000.0 - topic.stamp < LIMIT


def test_nothing_is_published_while_nobody_listens(topic, monkeypatch):
    topic.begin()
    topic.listeners = 0
    topic.tell(*PIECES[0])
    until(lambda: not topic.tell.__self__._pieces)
    topic.listeners = 1
    topic.tell(*PIECES[1])
    until(lambda: topic.published)
    assert topic.published == PIECES[1:2]


def test_a_subscriber_that_hangs_keeps_nobody_waiting_and_what_is_left_out_is_said(topic, monkeypatch):
    monkeypatch.setattr(wire_topic, "LONGEST", 3)
    topic.begin()
    topic.open.clear()
    topic.tell(True, b"0")
    assert topic.busy.wait(LIMIT)       # and it is taken out
    for number in range(1, 9):
        topic.tell(bool(number % 2), b"%d" % number)     # returns, though nothing can be published: 1, 2 and 3 fit
    topic.open.set()
    until(lambda: len(topic.published) == 4)
    assert topic.said == []
    topic.tell(False, b"9")
    until(lambda: len(topic.published) == 6)
    assert [data for _, data in topic.published] == [b"0", b"1", b"2", b"3", b"", b"9"]
    assert topic.said == ["ROS was too slow for all bytes of the line: 5 pieces are missing in wire until now"]


def test_what_is_left_out_again_and_again_does_not_flood_the_log(topic, monkeypatch):
    monkeypatch.setattr(wire_topic, "LONGEST", 1)
    topic.begin()
    for number in range(1, 4):
        topic.open.clear()
        topic.busy.clear()
        topic.tell(True, b"first")
        assert topic.busy.wait(LIMIT)
        topic.tell(True, b"fits")
        topic.tell(True, b"left out")
        topic.open.set()
        topic.busy.clear()
        until(lambda: [data for _, data in topic.published].count(b"fits") == number)
    topic.tell(True, b"last")
    until(lambda: topic.published[-1][1] == b"last")
    assert [data for _, data in topic.published].count(b"") == 3 and len(topic.said) == 1
