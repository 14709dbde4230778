"""A recorder that connects to all topics of a node at once need not wait."""

import contextlib
import socket
import types

import pytest

from pioneer_control import ros_node

AT_ONCE = 40
"""Connections; a driver has 25 topics."""
PATIENCE = 0.3
"""s; what does not connect at once tries again after one second."""


def connected(server):
    """Return how many of AT_ONCE connections are made while the server accepts none."""
    with contextlib.ExitStack() as stack:
        made = 0
        for number in range(AT_ONCE):
            client = stack.enter_context(socket.socket())
            client.settimeout(PATIENCE)
            with contextlib.suppress(OSError):
                client.connect(server.getsockname())
                made += 1
            if made <= number:
                break
        return made


@pytest.fixture
def server(monkeypatch):
    """Return a listening socket as rospy makes it, in the place of rospy's own."""
    with socket.socket() as listening:
        listening.bind(("127.0.0.1", 0))
        listening.listen(5)
        tcpros = types.SimpleNamespace(tcp_ros_server=types.SimpleNamespace(server_sock=listening),
                                       start_server=lambda: None)
        monkeypatch.setattr(ros_node, "init_tcpros_server", lambda: tcpros)
        yield listening


def test_all_are_made_at_once(server):
    ros_node._raise_listen_backlog()
    assert connected(server) == AT_ONCE


def test_rospy_alone_would_let_some_wait(server):
    assert connected(server) < AT_ONCE


def test_a_node_that_has_ended_already(server):
    server.close()
    ros_node._raise_listen_backlog()
