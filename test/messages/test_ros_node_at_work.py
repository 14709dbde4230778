"""Whether a node is at work. The master and the node itself are asked. In these tests both answer over XML-RPC, or do
not answer.
"""

import socket
import threading
from xmlrpc.server import SimpleXMLRPCServer

import pytest

from pioneer_control.ros_node import NO_ANSWER, is_at_work

PATIENCE, SHORT = 30.0, 0.1  # s: where somebody answers, and where nobody does


@pytest.fixture
def serve():
    """Start a server that answers XML-RPC methods from a table, {name: answer}. Returns its address."""
    servers = []

    def start(answers):
        server = SimpleXMLRPCServer(("localhost", 0), logRequests=False)
        for name, answer in answers.items():
            server.register_function(lambda *_, answer=answer: answer, name)
        threading.Thread(target=server.serve_forever, kwargs=dict(poll_interval=0.01), daemon=True).start()
        servers.append(server)
        return "http://localhost:%d" % server.server_address[1]

    yield start
    for server in servers:
        server.shutdown()
        server.server_close()


@pytest.fixture
def hanging():
    """Return an address that accepts connections and never answers."""
    with socket.create_server(("localhost", 0)) as listener:
        yield "http://localhost:%d" % listener.getsockname()[1]


@pytest.fixture
def master(serve, monkeypatch):
    """Start a master that gives this answer when it is asked for a node, and set ROS_MASTER_URI to it."""
    return lambda *answer: monkeypatch.setenv("ROS_MASTER_URI", serve({"lookupNode": list(answer)}))


def test_one_that_answers_is(serve, master):
    master(1, "", serve({"getPid": [1, "", 7]}))
    assert is_at_work("/node", PATIENCE)


def test_one_that_nobody_knows_is_not(master):
    master(-1, "unknown node", "")
    assert not is_at_work("/node", PATIENCE)


def test_one_that_was_killed_is_not(master):
    master(1, "", "http://localhost:1")
    assert not is_at_work("/node", PATIENCE)


def test_a_master_that_is_not_there_or_hangs_is_told(hanging, monkeypatch):
    for address in ("http://localhost:1", hanging):
        monkeypatch.setenv("ROS_MASTER_URI", address)
        with pytest.raises(NO_ANSWER):
            is_at_work("/node", SHORT)
