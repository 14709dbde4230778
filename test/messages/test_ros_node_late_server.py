"""A node that a signal ends while it starts reports no error of rospy's server, whose thread may begin too late."""

import socket
import threading

import pytest
import rospy
from rospy.impl.tcpros_base import TCPServer

from pioneer_control import ros_node


def begin_after_shutdown():
    """Begin rospy's server when it was shut down already."""
    server = TCPServer(None)
    server.shutdown()
    server.run()


def reported(monkeypatch, work, forgives=True):
    """Let a thread do some work, and return the kinds of errors that are reported of it."""
    found = []
    monkeypatch.setattr(threading, "excepthook", lambda failure: found.append(failure.exc_type))
    if forgives:
        ros_node._forgive_a_server_that_begins_late()
    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    return found


@pytest.fixture
def ending(monkeypatch):
    """Let the node be ending."""
    monkeypatch.setattr(rospy.core, "is_shutdown_requested", lambda: True)


def test_rospy_alone_reports_an_error(monkeypatch, ending):
    assert reported(monkeypatch, begin_after_shutdown, forgives=False) == [OSError]


def test_a_node_that_ends_reports_none(monkeypatch, ending):
    assert reported(monkeypatch, begin_after_shutdown) == []


def test_a_node_that_does_not_end_reports_it(monkeypatch):
    assert reported(monkeypatch, begin_after_shutdown) == [OSError]


def test_other_errors_are_reported_at_the_end_too(monkeypatch, ending):
    assert reported(monkeypatch, lambda: int("no number")) == [ValueError]


def test_a_closed_socket_of_another_thread_is_reported_at_the_end_too(monkeypatch, ending):
    closed = socket.socket()
    closed.close()
    assert reported(monkeypatch, closed.accept) == [OSError]
