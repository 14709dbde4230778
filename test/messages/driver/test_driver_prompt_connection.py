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


def test_a_connection_that_breaks_while_it_is_written_to_and_while_rospy_drops_it_is_no_deadlock():
    """A subscriber that was killed is back at once: rospy drops its old connection, and holds a lock which a write that fails needs too."""
    writes, drops = threading.Event(), threading.Event()

    class Breaking(Transport):
        def write_data(self, data):
            writes.set()
            assert drops.wait(PATIENCE)
            self.close()
            raise BrokenPipeError(errno.EPIPE, "broken")

    topic = rospy.topics._PublisherImpl("/somewhere", rospy.AnyMsg)
    topic.queue_size = None
    connection = PromptConnection(Breaking(), 10)
    topic.add_connection(connection)

    def write():
        with pytest.raises(BrokenPipeError):
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
    """A signal handler that says something, on the thread that is just saying something else."""
    class Interrupted(Transport):
        def write_data(self, data):
            if data == message(0):
                for number in (1, 2):
                    connection.write_data(message(number))
            return super().write_data(data)

    transport = Interrupted()
    connection = PromptConnection(transport, 10)
    connection.write_data(message(0))
    assert numbers(received(transport, 1500)) == [0, 1, 2]


@pytest.mark.parametrize("size", [700, 30000])
def test_nobody_waits_for_a_subscriber_that_takes_crumbs(size):
    """Over TCP, where a buffer that is empty may still be too small for a large message."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        subscriber = socket.socket()
        subscriber.setsockopt(socket.IPPROTO_TCP, socket.TCP_MAXSEG, 536)
        subscriber.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1)
        subscriber.connect(server.getsockname())
        transport = Transport()
        transport.socket, _ = server.accept()
    connection = PromptConnection(transport, 10)
    publisher = threading.Thread(target=lambda: all(connection.write_data(message(number, size)) for number in range(3000)), daemon=True)
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


def test_rospy_takes_it(monkeypatch):
    monkeypatch.setattr(rospy.topics, "QueuedConnection", rospy.topics.QueuedConnection)
    prompt_connection.send_promptly()
    topic = rospy.topics._PublisherImpl("/somewhere", rospy.AnyMsg)
    topic.set_queue_size(3)
    topic.add_connection(Transport())
    assert [type(connection) for connection in topic.connections] == [PromptConnection]
