"""The owner and a server that dies, hangs or talks nonsense: it is replaced, and nothing it says ends the owner."""

import json
import socket
import threading
import time

import pytest

from pioneer_control.errors import PioneerError
from pioneer_control.web import owner as owner_module
from pioneer_control.web.backend import Person
from pioneer_control.web.exchange import BEAT_MESSAGE, CONFIGURE, GONE, ORDER, SAID, Unpacker, packed, packed_json
from pioneer_control.web.owner import Owner, Told
from pioneer_control.web.site import listen

LIMIT = 20.0        # s
TEACHER, VISITOR = Person(1, "t" * 16, "T", True), Person(2, "v" * 16)


class Actor:
    """Plays the server: the same as ServerProcess for the owner, and the other end of its socket for the test."""

    all = []

    def __init__(self, listening, folder):
        self.end, self.mine = socket.socketpair()
        self.end.setblocking(False)
        self.mine.settimeout(LIMIT)
        self.unpacker, self._parts = Unpacker(), Unpacker()
        self.started = self.heard = time.monotonic()
        self.speaks = self.killed = False
        Actor.all.append(self)

    def kill(self):
        self.killed = True

    def close(self):
        self.end.close()

    def say(self, data):
        self.mine.sendall(data)

    def order(self, person, **message):
        self.say(packed_json(ORDER, {"person": list(person), "message": message}))

    def hear(self, kind):
        """Return the next message of this kind, as JSON."""
        while True:
            for each, contents in self._parts.take(self.mine.recv(65536)):
                if each == kind:
                    return json.loads(contents.decode())


def wait_for_server(number):
    """Return the server with this number, counted from 0."""
    end = time.monotonic() + LIMIT
    while len(Actor.all) <= number:
        assert time.monotonic() < end, "no server %d was started" % number
        time.sleep(0.005)
    return Actor.all[number]


@pytest.fixture
def said(monkeypatch):
    """Run an owner without robots, with actors as servers. Gives what it says to the person at the terminal."""
    monkeypatch.setattr(owner_module, "ServerProcess", Actor)
    sentences, Actor.all = [], []
    owner = Owner([], Told({"k": True}, "title", ["localhost"]), say=sentences.append)
    thread = threading.Thread(target=owner.run)
    thread.start()
    yield sentences
    owner.end()
    thread.join(LIMIT)
    assert not thread.is_alive()
    for actor in Actor.all:
        actor.mine.close()


def test_a_new_server_is_told_keys_and_title_first(said):
    assert wait_for_server(0).hear(CONFIGURE) == {
        "keys": {"k": True}, "title": "title", "hosts": ["localhost"], "kind": "live"}


@pytest.mark.parametrize("nonsense", [
    b"\0\0\0\0", b"\xff\xff\xff\xffB", packed(ORDER, b"{"), packed(ORDER, b"\xff"), packed(GONE, b"x"),
    packed_json(ORDER, []), packed_json(ORDER, {}), packed_json(ORDER, {"person": 1, "message": {}}),
    packed_json(ORDER, {"person": [1] * 9, "message": {}}), packed_json(ORDER, None),
    packed_json(ORDER, {"person": list(TEACHER), "message": []})])
def test_a_server_that_talks_nonsense_is_replaced(said, nonsense):
    wait_for_server(0).say(nonsense)
    wait_for_server(1)
    assert Actor.all[0].killed and "makes no sense" in said[0]


def test_what_is_unknown_is_skipped_and_what_is_wrong_is_answered(said):
    server = wait_for_server(0)
    server.say(packed(b"?", b"later") + packed(BEAT_MESSAGE) + packed_json(GONE, 77))
    server.order(VISITOR, do="fly")
    assert server.hear(SAID)["viewers"] == [2]
    server.order(VISITOR, do="drive", robot=-1, forward=1, turn=0, stamp=1)
    assert "robot is -1" in server.hear(SAID)["text"]
    server.order(VISITOR, do="take", robot=1)
    assert "no robot 1" in server.hear(SAID)["text"]
    server.order(VISITOR, do="name", name="V")
    server.order(VISITOR, do="say", text="hi")
    assert "only the teacher" in server.hear(SAID)["text"]
    server.order(TEACHER, do="say", text="hi")
    assert server.hear(SAID) == {"level": "info", "text": "T: hi", "robot": None, "viewers": None}
    assert len(Actor.all) == 1


def test_a_server_that_dies_again_and_again_is_started_ever_later(said):
    starts = []
    for number in range(4):
        server = wait_for_server(number)
        starts.append(time.monotonic())
        server.mine.close()
    pauses = [after - before for before, after in zip(starts, starts[1:])]
    assert pauses[0] >= 0.09 and pauses[1] >= 0.19 and pauses[2] >= 0.39


def test_a_server_that_hangs_is_replaced(said, monkeypatch):
    monkeypatch.setattr(owner_module, "HUNG", 0.3)
    server = wait_for_server(0)
    server.say(packed(BEAT_MESSAGE))
    wait_for_server(1)
    assert server.killed


def test_listening():
    with pytest.raises(PioneerError, match="port 1 of 203.0.113.7"):
        listen(["203.0.113.7"], 1)      # an address that no machine has
    sockets = listen(["127.0.0.1", "203.0.113.7"], 0)
    assert len(sockets) == 1            # the second is left out
    port = sockets[0].getsockname()[1]
    with pytest.raises(PioneerError, match="port %d of 127.0.0.1.*--port 0" % port):
        listen(["127.0.0.1"], port)
    sockets[0].close()
