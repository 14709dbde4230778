"""Messages leave at once and in order, and no subscriber holds up the publisher.

With another version of rospy, ordinary messages with the same content are published instead.
"""

import dataclasses
import errno
import socket
import threading
from types import SimpleNamespace

import pytest
import rospy.topics
from nav_msgs.msg import Odometry
from tf2_msgs.msg import TFMessage

from pioneer_control import prompt_connection
from pioneer_control.driver import conversions, prompt
from pioneer_control.driver.parameters import DriverParameters
from pioneer_control.msg import SonarArray
from pioneer_control.prompt_connection import PromptConnection

from robot_reports import STAMP, STATE

PATIENCE = 20.0     # s for what happens at once


class Transport:
    """A stand-in for rospy's connection to a subscriber. Writing waits while the subscriber does not read."""

    def __init__(self, smallest_buffer=False):
        self.socket, self.subscriber = socket.socketpair()
        if smallest_buffer:
            self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 1)
            self.subscriber.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1)
        self.subscriber.settimeout(PATIENCE)
        self.done, self.cleanup_cb, self.endpoint_id = False, None, "subscriber"
        self.writers = []       # threads that wrote as rospy does
        self.stat_bytes = self.stat_num_msg = 0

    def fileno(self):
        return self.socket.fileno()

    def set_cleanup_callback(self, callback):
        self.cleanup_cb = callback

    def write_data(self, data):
        self.writers.append(threading.current_thread())
        try:
            self.socket.sendall(data)
        except OSError:
            self.close()        # as rospy does, while it writes
            raise
        return True

    def close(self):
        self.done = True
        self.cleanup_cb(self)


def received(transport, count):
    data = b""
    while len(data) < count:
        data += transport.subscriber.recv(count - len(data))
    return data


def message(number, size=500):
    return number.to_bytes(4, "big") + bytes(size - 4)


def numbers(data, size=500):
    return [int.from_bytes(data[at:at + 4], "big") for at in range(0, len(data), size)]


def test_a_message_is_written_by_who_publishes_it():
    transport = Transport()
    connection = PromptConnection(transport, 10)
    for number in range(3):
        assert connection.write_data(message(number))
    assert numbers(received(transport, 1500)) == [0, 1, 2]
    assert transport.writers == [] and (transport.stat_bytes, transport.stat_num_msg) == (1500, 3)


def test_a_subscriber_that_does_not_read_holds_up_nobody_and_then_gets_the_newest_in_order():
    transport = Transport(smallest_buffer=True)
    connection = PromptConnection(transport, 10)
    for number in range(1000):      # would wait for ever at the first that does not fit
        connection.write_data(message(number))
    read = []
    while not read or read[-1] != 999:
        read += numbers(received(transport, 500))
    assert read == sorted(set(read)), "in order, whole"
    assert read[-10:] == list(range(990, 1000)) and len(read) < 1000, "the oldest lost"
    assert len(set(transport.writers)) == 1


def test_what_waits_goes_before_what_comes():
    transport = Transport(smallest_buffer=True)
    connection = PromptConnection(transport, 0)
    for number in range(200):
        connection.write_data(message(number))
    assert numbers(received(transport, 200 * 500)) == list(range(200)), "an endless queue loses none"


def test_a_connection_that_breaks_says_so_to_who_publishes_and_closes_itself():
    transport = Transport()
    connection = PromptConnection(transport, 10)
    transport.subscriber.close()
    with pytest.raises(OSError) as raised:
        for _ in range(1000000):
            connection.write_data(message(1))
    assert raised.value.errno == errno.EPIPE and transport.done


def test_an_error_of_a_message_that_waited_comes_with_the_next():
    transport = Transport(smallest_buffer=True)
    connection = PromptConnection(transport, 10)
    for number in range(1000):
        connection.write_data(message(number))
    transport.subscriber.close()
    with pytest.raises(OSError):
        for _ in range(1000000):
            connection.write_data(message(0))


def test_its_thread_ends_with_the_connection():
    before = set(threading.enumerate())
    transport = Transport()
    PromptConnection(transport, 10)
    thread, = set(threading.enumerate()) - before
    transport.close()
    thread.join(PATIENCE)
    assert not thread.is_alive()


def test_a_connection_that_breaks_while_it_is_written_to_and_while_rospy_drops_it_is_no_deadlock():
    """A killed subscriber comes back at once. rospy drops its old connection, and holds a lock that a failed write
    needs, too.
    """
    writes, drops = threading.Event(), threading.Event()

    class Breaking(Transport):
        def write_data(self, data):
            writes.set()
            assert drops.wait(PATIENCE)
            self.close()
            raise BrokenPipeError(errno.EPIPE, "broken")

    topic = rospy.topics._PublisherImpl("/somewhere", rospy.AnyMsg)
    topic.queue_size = None
    transport = Breaking()
    transport.subscriber.close()
    connection = PromptConnection(transport, 10)
    topic.add_connection(connection)

    def write():
        with pytest.raises(BrokenPipeError):
            while True:
                connection.write_data(message(1))

    def drop():
        assert writes.wait(PATIENCE)
        with topic.c_lock:
            drops.set()
            connection.close()

    threads = [threading.Thread(target=each, daemon=True) for each in (write, drop)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(PATIENCE / 4)
    assert not any(thread.is_alive() for thread in threads)


def test_what_is_written_in_the_middle_of_a_write_waits_its_turn():
    """A signal handler publishes a message on the thread that is just publishing another one."""
    class Interrupted:
        def __init__(self, connected):
            self._socket = connected

        def send(self, data, flags):
            count = self._socket.send(data[:100], flags)
            if data == message(0):
                for number in (1, 2):
                    connection.write_data(message(number))
            return count

    transport = Transport()
    transport.socket, sendall = Interrupted(transport.socket), transport.socket.sendall
    transport.write_data = sendall
    connection = PromptConnection(transport, 10)
    connection.write_data(message(0))
    assert numbers(received(transport, 1500)) == [0, 1, 2]


@pytest.mark.parametrize("size", [700, 30000])
def test_nobody_waits_for_a_subscriber_that_takes_crumbs(size):
    """Over TCP an empty buffer may still be too small for a large message."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        subscriber = socket.socket()
        subscriber.setsockopt(socket.IPPROTO_TCP, socket.TCP_MAXSEG, 536)
        subscriber.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1)
        subscriber.connect(server.getsockname())
        transport = Transport()
        transport.socket, _ = server.accept()
    connection = PromptConnection(transport, 10)
    publisher = threading.Thread(
        target=lambda: all(connection.write_data(message(number, size)) for number in range(3000)), daemon=True)
    publisher.start()
    publisher.join(PATIENCE / 4)
    stuck = publisher.is_alive()
    transport.done = True
    subscriber.close()
    assert not stuck


def test_all_else_is_asked_of_the_transport():
    connection = PromptConnection(Transport(), 10)
    assert connection.endpoint_id == "subscriber" and not connection.done
    with pytest.raises(AttributeError):
        connection.nothing_like_that


@pytest.fixture
def rospys_own(monkeypatch):
    """Return rospy's own connection class, and put it back after the test."""
    monkeypatch.setattr(rospy.topics, "QueuedConnection", rospy.topics.QueuedConnection)
    return rospy.topics.QueuedConnection


def connected_by_rospy(transport):
    topic = rospy.topics._PublisherImpl("/somewhere", rospy.AnyMsg)
    topic.set_queue_size(3)
    topic.add_connection(transport)
    connection, = topic.connections
    return connection


def test_rospy_takes_it(rospys_own):
    assert prompt_connection.send_promptly()
    assert type(connected_by_rospy(Transport())) is PromptConnection


def test_a_connection_that_is_no_socket_goes_rospys_own_way(rospys_own):
    assert prompt_connection.send_promptly()
    transport = Transport()
    number = transport.fileno()
    transport.tcp, transport.socket, transport.fileno = transport.socket, None, lambda: number
    connection = connected_by_rospy(transport)
    transport.close()
    assert type(connection) is rospys_own


def test_a_rospy_that_makes_connections_in_another_way_is_left_as_it_is(rospys_own, monkeypatch):
    class Another:
        def __init__(self, connection, queue_size, newly_invented):
            pass

    monkeypatch.setattr(rospy.topics, "QueuedConnection", Another)
    assert not prompt_connection.send_promptly() and rospy.topics.QueuedConnection is Another
    monkeypatch.delattr(rospy.topics, "QueuedConnection")
    assert not prompt_connection.send_promptly() and not hasattr(rospy.topics, "QueuedConnection")


COVARIANCE = conversions.covariances(DriverParameters())
PROMPT = {
    Odometry: (prompt.PoseMessage("odom", "base_link", COVARIANCE), lambda state, stamp: conversions.odometry(
        state, stamp, "odom", "base_link", COVARIANCE[state.moving])),
    TFMessage: (prompt.TransformMessage("odom", "base_link"), lambda state, stamp: conversions.transform(
        state, stamp, "odom", "base_link")),
    SonarArray: (prompt.SonarMessage("base_link"), lambda state, stamp: conversions.sonar(state, stamp, "base_link")),
}
kinds = pytest.mark.parametrize("kind", PROMPT)


@kinds
def test_a_message_writes_itself_where_rospy_publishes_it_so(kind):
    message, plain = PROMPT[kind]
    assert prompt.converter(message, plain)(STATE, STAMP) is message


def writes_other_bytes(monkeypatch):
    monkeypatch.setattr(rospy.topics, "serialize_message", lambda buffer, number, message: buffer.write(b"other"))


def has_no_such_topic(monkeypatch):
    monkeypatch.delattr(rospy.topics, "_PublisherImpl")


@pytest.mark.parametrize("change", [writes_other_bytes, has_no_such_topic])
@kinds
def test_where_rospy_is_another_ordinary_messages_are_published(kind, monkeypatch, change):
    change(monkeypatch)
    assert type(prompt.converter(*PROMPT[kind])(STATE, STAMP)) is kind


class Subscriber:
    """A connection to one subscriber, which may be gone."""

    def __init__(self, is_gone=False):
        self.is_gone, self.is_closed, self.heard = is_gone, False, []

    def write_data(self, data):
        if self.is_gone:
            raise BrokenPipeError
        self.heard.append(data)

    def close(self):
        self.is_closed = True


@kinds
def test_each_subscriber_gets_each_message_and_one_that_is_gone_is_closed(kind):
    topic = rospy.topics._PublisherImpl("/somewhere", kind)
    before, gone, behind = topic.connections = [Subscriber(), Subscriber(is_gone=True), Subscriber()]
    for _ in range(2):
        prompt.publish(SimpleNamespace(impl=topic), PROMPT[kind][0].of(STATE, STAMP))
    assert before.heard == behind.heard and len(before.heard) == topic.seq == 2
    assert topic.message_data_sent == sum(map(len, before.heard))
    assert (before.is_closed, gone.is_closed, behind.is_closed) == (False, True, False)


@kinds
def test_on_a_topic_that_rospy_has_closed_nobody_gets_a_message(kind):
    topic, subscriber = rospy.topics._PublisherImpl("/somewhere", kind), Subscriber()
    topic.close()
    topic.connections = [subscriber]
    prompt.publish(SimpleNamespace(impl=topic), PROMPT[kind][0].of(STATE, STAMP))
    assert not subscriber.heard and topic.seq == 0


@pytest.mark.parametrize("state", [
    STATE, dataclasses.replace(STATE, linear=0.0, angular=0.0, heading=-3.0), dataclasses.replace(STATE, sonar=())])
@kinds
def test_both_kinds_of_messages_say_the_same(kind, state):
    message, plain = PROMPT[kind]
    assert prompt._sent(message.of(state, STAMP), kind) == prompt._sent(plain(state, STAMP), kind)
