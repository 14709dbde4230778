"""Messages leave at once, in order, and no subscriber holds up who publishes."""

import errno
import socket
import threading

import pytest
import rospy.topics

from pioneer_control.driver import prompt_connection
from pioneer_control.driver.prompt_connection import PromptConnection

PATIENCE = 20.0     # s for what happens at once


class Transport:
    """What rospy has for a subscriber: writing waits while the subscriber does not read."""

    def __init__(self, smallest_buffer=False):
        self.socket, self.subscriber = socket.socketpair()
        if smallest_buffer:
            self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 1)
            self.subscriber.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1)
        self.subscriber.settimeout(PATIENCE)
        self.done, self.cleanup_cb, self.endpoint_id = False, None, "subscriber"
        self.writers = []

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
    assert set(transport.writers) == {threading.current_thread()}


def test_a_subscriber_that_does_not_read_holds_up_nobody_and_then_gets_the_newest_in_order():
    transport = Transport(smallest_buffer=True)
    connection = PromptConnection(transport, 10)
    for number in range(1000):      # would wait for ever at the first that does not fit
        connection.write_data(message(number))
    read = []
    while not read or read[-1] != 999:
        read += numbers(received(transport, 500))
    assert read == sorted(set(read)) and read[-10:] == list(range(990, 1000)) and len(read) < 1000, "in order, whole, the oldest lost"
    assert len(set(transport.writers)) == 2


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


def test_all_else_is_asked_of_the_transport():
    connection = PromptConnection(Transport(), 10)
    assert connection.endpoint_id == "subscriber" and not connection.done
    with pytest.raises(AttributeError):
        connection.nothing_like_that


def test_rospy_takes_it(monkeypatch):
    monkeypatch.setattr(rospy.topics, "QueuedConnection", rospy.topics.QueuedConnection)
    prompt_connection.send_promptly()
    topic = rospy.topics._PublisherImpl("/somewhere", rospy.AnyMsg)
    topic.set_queue_size(3)
    topic.add_connection(Transport())
    assert [type(connection) for connection in topic.connections] == [PromptConnection]
