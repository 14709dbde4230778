"""Ports on a WebSocket: frames in any pieces, refusals, servers that are none, TLS, and a key that nobody is told."""

import base64
import contextlib
import hashlib
import io
import json
import logging
import os
import pathlib
import re
import select
import selectors
import socket
import ssl
import struct
import sys
import threading
import time
import traceback
import types

import pytest
import websocket
from hypothesis import given
from hypothesis import strategies as st

from pioneer_control.client import transport, web_socket
from pioneer_control.client.ports import is_serial, open_transport
from pioneer_control.client.tcp import connect
from pioneer_control.client.web_socket import (BINARY, CLOSE, CONTINUED, PING, PONG, TEXT, EncryptedSocket,
                                               WebSocketTransport, encrypt)
from pioneer_control.errors import LinkLostError, PortError

KEY = "s3same/öffne+dich"
LIMIT = 30.0
CERTIFICATE = str(pathlib.Path(__file__).resolve().parents[2] / "data" / "localhost.pem")
WELCOME = b'{"robot": "rosie", "news": ["for a later client"]}'


def frame(kind, data=b"", last=True):
    """A frame as a server sends it."""
    length = bytes([len(data)]) if len(data) < 126 else b"\x7e" + struct.pack("!H", len(data))
    return bytes([kind | (0x80 if last else 0)]) + length + data


def close_frame(code, reason=""):
    return frame(CLOSE, struct.pack("!H", code) + reason.encode())


class Peer:
    """The server's end of a connection."""

    def __init__(self, connection):
        self.connection = connection
        self.sendall = connection.sendall

    def exactly(self, count):
        data = b""
        while len(data) < count:
            more = self.connection.recv(count - len(data))
            assert more, "the client has closed"
            data += more
        return data

    def request(self):
        """Read the HTTP request. Return its lines."""
        data = b""
        while not data.endswith(b"\r\n\r\n"):
            data += self.exactly(1)
        return data.decode().split("\r\n")

    def upgrade(self):
        """Take the connection as a WebSocket. Return the first line of the request."""
        lines = self.request()
        word, = [line.partition(": ")[2] for line in lines if line.startswith("Sec-WebSocket-Key: ")]
        accept = base64.b64encode(hashlib.sha1((word + "258EAFA5-E914-47DA-95CA-C5AB0DC85B11").encode()).digest())
        self.sendall(b"HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
                     b"Sec-WebSocket-Accept: " + accept + b"\r\n\r\n")
        return lines[0]

    def frame(self):
        """Read one frame of the client. Return its kind and its data."""
        head, length = self.exactly(2)
        assert head & 0x80 and length & 0x80, "a client masks, and this one sends whole messages"
        length &= 0x7f
        if length >= 126:
            length, = struct.unpack(*(("!H", self.exactly(2)) if length == 126 else ("!Q", self.exactly(8))))
        mask, data = self.exactly(4), self.exactly(length)
        return head & 0x0f, bytes(byte ^ mask[number % 4] for number, byte in enumerate(data))

    def admit(self):
        """Take the connection, its key, and give the robot."""
        self.upgrade()
        assert json.loads(self.frame()[1]) == {"key": KEY}
        self.sendall(frame(TEXT, WELCOME))


@pytest.fixture
def server():
    """A function that starts a server of one connection, and returns its URL. The server does ``script(peer)``."""
    with contextlib.ExitStack() as at_end:
        def start(script, context=None):
            def serve():
                with contextlib.suppress(OSError, AssertionError):      # the client has gone
                    connection = listener.accept()[0]
                    if context is not None:
                        connection = context.wrap_socket(connection, server_side=True)
                    connection.settimeout(LIMIT)
                    with connection:
                        script(Peer(connection))

            listener = at_end.enter_context(socket.create_server(("127.0.0.1", 0)))
            thread = threading.Thread(target=serve, daemon=True)
            thread.start()
            at_end.callback(thread.join, LIMIT)
            return "%s://localhost:%d/robot/7" % ("ws" if context is None else "wss", listener.getsockname()[1])

        yield start


@pytest.fixture
def opened(server):
    """A function that opens a line, and returns it and the server's end of it."""
    with contextlib.ExitStack() as at_end:
        def start(context=None):
            peers, is_there, leave = [], threading.Event(), threading.Event()

            def script(peer):
                peer.admit()
                peers.append(peer)
                is_there.set()
                leave.wait(2 * LIMIT)

            line = open_transport(server(script, context), 9600, KEY)
            assert is_there.wait(LIMIT)
            at_end.callback(leave.set)
            at_end.callback(line.close)
            at_end.callback(peers[0].connection.close)      # first, so that closing the line does not wait for it
            return line, peers[0]

        yield start


def read_all(line, count):
    """Read until so many bytes have come."""
    data, end = b"", time.monotonic() + LIMIT
    while len(data) < count:
        assert time.monotonic() < end, "%d of %d bytes" % (len(data), count)
        data += line.read(1.0)
    return data


def test_it_has_no_line_speed(opened):
    line, _ = opened()
    assert line.baud is None and not is_serial(line.url)
    line.set_baud(9600)
    assert line.baud is None


def test_it_carries_every_byte_both_ways_in_binary_messages(opened):
    line, peer = opened()
    every = bytes(range(256))
    line.write(every)
    assert peer.frame() == (BINARY, every)
    peer.sendall(frame(BINARY, every))
    assert line.read(LIMIT) == every


def test_the_server_is_asked_for_the_path_and_told_the_key_in_the_first_message(server):
    told = []

    def script(peer):
        told.append(peer.upgrade())
        told.append(peer.frame())
        peer.sendall(frame(TEXT, WELCOME))

    open_transport(server(script) + "?seat=3", 9600, KEY).close()
    assert told[0] == "GET /robot/7?seat=3 HTTP/1.1"
    assert told[1][0] == TEXT and json.loads(told[1][1]) == {"key": KEY}


def test_without_a_key_the_server_gets_an_empty_one(server):
    def script(peer):
        peer.upgrade()
        peer.sendall(close_frame(4401, "this needs a key") if json.loads(peer.frame()[1]) == {"key": ""} else b"")

    with pytest.raises(PortError, match="refuses: this needs a key"):
        open_transport(server(script), 9600)


def test_bytes_may_be_cut_into_messages_and_frames_anyhow(opened):
    line, peer = opened()
    peer.sendall(frame(BINARY, b"ab") + frame(BINARY) + frame(BINARY, b"c", last=False) + frame(CONTINUED, b"d", False)
                 + frame(PING, b"?") + frame(CONTINUED, b"e") + frame(BINARY, b"f"))
    assert read_all(line, 6) == b"abcdef"


def test_later_text_messages_are_ignored(opened):
    line, peer = opened()
    peer.sendall(frame(TEXT, b'{"people": "see this"', False) + frame(CONTINUED, b"}") + frame(TEXT, b"\xff no JSON"))
    assert line.read(0.01) == b""
    peer.sendall(frame(TEXT, b"{}") + frame(BINARY, b"robot"))
    assert read_all(line, 5) == b"robot"


@pytest.mark.parametrize("data", [b"robot", bytes(300)])
def test_a_frame_that_comes_in_halves_does_not_hold_up_the_reader(opened, data):
    line, peer = opened()
    whole = frame(BINARY, data)
    for cut in range(1, 12 if len(data) > 12 else len(whole)):
        peer.sendall(whole[:cut])
        assert line.read(0.0) == line.read(0.001) == b""
        peer.sendall(whole[cut:])
        assert read_all(line, len(data)) == data


def test_a_ping_is_answered(opened):
    line, peer = opened()
    peer.sendall(frame(PING, b"are you there?"))
    reading = threading.Thread(target=line.read, args=(LIMIT,))
    reading.start()
    assert peer.frame() == (PONG, b"are you there?")
    peer.sendall(frame(PONG) + frame(BINARY, b"!"))
    reading.join(LIMIT)
    assert not reading.is_alive()


def flood(peer):
    """Send frames of no use, more than a client can read, until it has gone."""
    with contextlib.suppress(OSError):
        while True:
            peer.sendall(frame(PONG) * 10_000)


def test_frames_of_no_use_without_end_do_not_hold_up_the_reader(opened):
    line, peer = opened()
    flooding = threading.Thread(target=flood, args=(peer,))
    flooding.start()
    assert line.read(0.05) == b""
    peer.connection.shutdown(socket.SHUT_RDWR)
    flooding.join(LIMIT)


def test_a_read_ends_empty_and_can_be_woken(opened):
    line, peer = opened()
    assert line.read(0.01) == b"" and line.read(-1.0) == b""
    line.wake()
    assert line.read(LIMIT) == b""
    peer.sendall(frame(BINARY, b"half")[:3])
    waiting = threading.Thread(target=line.read, args=(60.0,))
    waiting.start()
    line.wake()
    waiting.join(LIMIT)
    assert not waiting.is_alive()


@pytest.mark.parametrize("order", [1, -1])
def test_a_wake_that_comes_with_half_a_frame_is_noticed(opened, monkeypatch, order):
    """Whichever of the two the system tells of first."""
    line, peer = opened()
    select = selectors.DefaultSelector.select
    monkeypatch.setattr(selectors.DefaultSelector, "select", lambda *arguments: select(*arguments)[::order])
    line.wake()
    peer.sendall(frame(BINARY, b"half")[:3])
    with selectors.SelectSelector() as arrival:
        arrival.register(line._port, selectors.EVENT_READ)
        assert arrival.select(LIMIT)
    waiting = threading.Thread(target=line.read, args=(60.0,), daemon=True)
    waiting.start()
    waiting.join(LIMIT / 3)
    assert not waiting.is_alive()


@pytest.mark.parametrize("code, reason, said", [
    (1000, "the lesson is over", "the lesson is over"), (4409, "taken by another", "taken by another"),
    (1001, "", "no reason .code 1001."), (4401, "no %s here" % KEY, "no .the key. here"),
])
def test_a_close_by_the_server_is_a_lost_link_with_its_reason(opened, code, reason, said):
    line, peer = opened()
    peer.sendall(frame(BINARY, b"last words") + close_frame(code, reason))
    assert line.read(LIMIT) == b"last words"
    with pytest.raises(LinkLostError, match=re.escape(line.url) + ": the server closed the connection: .*" + said):
        line.read(LIMIT)


def test_a_server_that_is_gone_without_a_word(opened):
    line, peer = opened()
    peer.connection.close()
    with pytest.raises(LinkLostError, match="closed the line"):
        line.read(LIMIT)


@pytest.mark.parametrize("garbage", [
    b"\xff\x01" + bytes(5), frame(7, b"x"), frame(CLOSE, b"\x00"), frame(PING, b"", last=False)])
def test_garbage_is_a_lost_link(opened, garbage):
    line, peer = opened()
    peer.sendall(garbage)
    with pytest.raises(LinkLostError, match="no WebSocket frame"):
        line.read(LIMIT)


def test_a_frame_without_end_is_a_lost_link(opened):
    line, peer = opened()
    sending = threading.Thread(target=lambda: peer.sendall(
        b"\x82\x7f" + struct.pack("!Q", 1 << 40) + bytes(web_socket.LONGEST_FRAME)))
    sending.start()
    with pytest.raises(LinkLostError, match="more than 1048576 bytes"):
        while True:
            assert line.read(LIMIT) == b""
    sending.join(LIMIT)


def test_a_server_that_takes_no_bytes_is_a_lost_link(opened):
    line, _ = opened()
    with pytest.raises(LinkLostError, match="takes no more bytes"):
        for _ in range(1000):
            line.write(bytes(100000))


def test_a_write_waits_no_longer_for_another_than_for_the_line(opened, monkeypatch):
    line, _ = opened()
    monkeypatch.setattr(web_socket, "WRITE_TIMEOUT", 0.01)
    with line._sending:
        failed = []

        def write():
            try:
                line.write(b"stop")
            except LinkLostError as error:
                failed.append(error)

        writing = threading.Thread(target=write)
        writing.start()
        writing.join(LIMIT)
    assert "takes no more bytes" in str(failed[0])


def test_the_last_bytes_arrive_and_the_close_is_said_though_unread_input_waits(opened):
    line, peer = opened()
    peer.sendall(frame(BINARY, b"SIP" * 1000))
    line.write(b"CLOSE")
    closing = threading.Thread(target=line.close)
    closing.start()
    assert peer.frame() == (BINARY, b"CLOSE") and peer.frame() == (CLOSE, b"\x03\xe8")
    peer.sendall(close_frame(1000))
    closing.join(LIMIT)
    assert not closing.is_alive()


def test_a_tapped_line_tells_of_the_robots_bytes_alone(opened):
    line, peer = opened()
    told = []
    transport.tap(line, lambda to_robot, data: told.append((to_robot, data)))
    line.write(b"question")
    peer.sendall(frame(PING) + frame(TEXT, b"{}") + frame(BINARY, b"answer"))
    assert read_all(line, 6) == b"answer"
    assert told == [(True, b"question"), (False, b"answer")]


# -- no robot

def refuse(code, reason=""):
    def script(peer):
        peer.upgrade()
        peer.frame()
        peer.sendall(close_frame(code, reason))

    return script


def answer(data):
    """A server that sends this after the key."""
    def script(peer):
        peer.upgrade()
        peer.frame()
        peer.sendall(data)
        peer.exactly(1)

    return script


def http(data):
    """A server that answers this to the HTTP request."""
    def script(peer):
        peer.request()
        peer.sendall(data)

    return script


def echo(peer):
    peer.upgrade()
    peer.sendall(frame(TEXT, peer.frame()[1]))


NO_ROBOT = {
    "wrong key": (refuse(4401, "this key opens no robot"), "the server refuses: this key opens no robot"),
    "key repeated": (refuse(4401, "what is %s?" % KEY), r"the server refuses: what is \(the key\)\?"),
    "no reason": (refuse(4404), "it gave no reason .code 4404."),
    "echo": (echo, "does not answer as a server of robots"),
    "no JSON": (answer(frame(TEXT, b"hello")), "does not answer as a server of robots"),
    "no UTF-8": (answer(frame(TEXT, b'{"robot": "\xff"}')), "does not answer as a server of robots"),
    "a list": (answer(frame(TEXT, b'["robot"]')), "does not answer as a server of robots"),
    "deep": (answer(b"\x81\x7f" + struct.pack("!Q", 200000) + b"[" * 200000), "does not answer as a server of robots"),
    "garbage": (answer(b"\xff\x01" + bytes(5)), "no WebSocket frame"),
    "ends after the key": (lambda peer: (peer.upgrade(), peer.frame()), "is this a server of robots"),
    "ends at once": (lambda peer: peer.request(), "is this a server of robots"),
    "not found": (http(b"HTTP/1.1 404 Not Found\r\n\r\n"), "no WebSocket: HTTP status 404"),
    "a page": (http(b"HTTP/1.1 200 OK\r\nContent-Length: 0\r\n\r\n"), "no WebSocket: HTTP status 200"),
    "a page with words": (http(b"HTTP/1.1 403 No\r\nContent-Length: 2\r\n\r\nno"), "no WebSocket: HTTP status 403"),
    "moved": (http(b"HTTP/1.1 301 Moved\r\nLocation: ws://localhost:1/\r\n\r\n"), "no WebSocket: HTTP status 301"),
    "no HTTP": (http(b"220 mail.example.org ESMTP\r\n\r\n"), "no WebSocket"),
    "an empty line": (http(b"\r\n"), "no WebSocket"),
    "no text": (http(b"\xff\xfe\xfd\n\n"), "no WebSocket"),
    "no accept": (http(b"HTTP/1.1 101 Yes\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n\r\n"), "no WebSocket"),
}


@pytest.mark.parametrize("case", NO_ROBOT)
def test_a_server_that_gives_no_robot_is_a_port_that_does_not_open_and_the_key_stays_secret(server, case, caplog):
    caplog.set_level(logging.DEBUG)
    script, said = NO_ROBOT[case]
    url = server(script)
    with pytest.raises(PortError, match=re.escape(url) + ": .*" + said) as raised:
        open_transport(url, 9600, KEY)
    told = "".join(traceback.format_exception(raised.type, raised.value, raised.tb)) + repr(raised.value) + caplog.text
    assert KEY not in told and json.dumps(KEY)[1:-1] not in told


def never(peer):
    peer.request()
    peer.exactly(1)


def never_after_the_key(peer):
    peer.upgrade()
    peer.frame()
    peer.exactly(1)


def drip(peer):
    peer.request()
    peer.sendall(b"HTTP/1.1 101 Y")
    while True:
        peer.sendall(b"e")


def flood_after_the_key(peer):
    peer.upgrade()
    peer.frame()
    flood(peer)


@pytest.mark.parametrize("script", [never, never_after_the_key, drip, flood_after_the_key])
def test_a_handshake_that_never_ends_is_given_up(server, script, monkeypatch):
    monkeypatch.setattr(web_socket, "ANSWER_TIMEOUT", 0.1)
    url = server(script)
    with pytest.raises(PortError, match=re.escape(url) + ": no answer within"):
        open_transport(url, 9600, KEY)


@pytest.mark.parametrize("url, message", [
    ("ws://localhost:1/robot/7", "connection refused: nothing listens on port 1 of localhost. Does the server run"),
    ("ws://no.such.host.invalid/robot/7", "no such host"), ("ws://localhost:99999/", "Port out of range"),
    ("ws://localhost:first/", "cannot understand"), ("ws:///robot/7", "give ws://host:port/path"),
    ("ws://[::1/", "cannot understand"), ("wss://localhost:1/", "connection refused"),
])
def test_urls_that_do_not_open(url, message):
    with pytest.raises(PortError, match=message) as raised:
        open_transport(url, 9600, KEY)
    assert url in str(raised.value) and KEY not in str(raised.value)


def test_no_websocket_client_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "websocket", None)
    with pytest.raises(PortError, match="ws://robot/: .*pip install websocket-client"):
        open_transport("ws://robot/", 9600, KEY)


# -- whatever comes

@contextlib.contextmanager
def line_from(data):
    """A line whose server has sent these bytes and closed."""
    ours, theirs = socket.socketpair()
    ours.setblocking(False)
    with theirs:
        theirs.sendall(data)
        theirs.shutdown(socket.SHUT_WR)
        line = WebSocketTransport("ws://robot/", ours, KEY, websocket)
        yield line
    line.close()


HTTP_PARTS = st.sampled_from([
    b"HTTP/1.1 101 Switching\r\n", b"HTTP/1.1 ", b"101", b"301", b"\r\n", b"\r\n\r\n", b"Upgrade: websocket\r\n",
    b"Connection: upgrade\r\n", b"Sec-WebSocket-Accept: x\r\n", b"Set-Cookie: a=1; domain=x\r\n",
    b"Set-Cookie: ;[=\r\n", b":", b" "])


@given(st.lists(HTTP_PARTS | st.binary(max_size=9), max_size=12).map(b"".join))
def test_whatever_answers_to_the_request_is_a_port_that_does_not_open(data):
    with line_from(data) as line, pytest.raises(PortError):
        line.begin("ws://robot/")


FRAMES = st.tuples(st.sampled_from([CONTINUED, TEXT, BINARY, CLOSE, PING, PONG, 3, 0x70]),
                   st.binary(max_size=200), st.booleans()).map(lambda words: frame(*words))


@given(st.lists(FRAMES | st.binary(max_size=9), max_size=12).map(b"".join))
def test_whatever_frames_come_end_as_a_lost_link_at_last(data):
    with line_from(data) as line:
        line._web.sock, line._stream.is_open = line._stream, True
        with pytest.raises(LinkLostError):
            while True:
                line.read(LIMIT)


# -- encrypted

@pytest.fixture
def context():
    made = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    made.load_cert_chain(CERTIFICATE)
    return made


@pytest.fixture
def trusted(monkeypatch):
    monkeypatch.setenv("SSL_CERT_FILE", CERTIFICATE)


def exchange(connection, data, count):
    """Send bytes on an encrypted connection and receive ``count`` bytes, at the same time but in one thread.

    OpenSSL does not allow two.
    """
    connection.setblocking(False)
    received = b""
    while data or len(received) < count:
        select.select([connection], [connection] if data else [], [], LIMIT)
        with contextlib.suppress(ssl.SSLWantReadError):
            received += connection.recv(100_000)
        with contextlib.suppress(ssl.SSLWantWriteError):
            data = data[connection.send(data[:50_000]):] if data else data
    return received


@pytest.mark.parametrize("version", [ssl.TLSVersion.TLSv1_2, ssl.TLSVersion.TLSv1_3])
def test_an_encrypted_line_carries_much_both_ways_at_once(opened, context, trusted, version, monkeypatch):
    monkeypatch.setattr(web_socket, "WRITE_TIMEOUT", LIMIT)     # this server reads slowly
    context.minimum_version = context.maximum_version = version
    line, peer = opened(context)
    there = [os.urandom(30_000) for _ in range(50)]
    back = os.urandom(3_000_000)
    # Larger than what one read takes, and than what one record of TLS holds.
    frames = [frame(BINARY, back[start:start + 60_000]) for start in range(0, len(back), 60_000)]
    length = sum(len(data) + 8 for data in there)       # a head of 4 bytes, and a mask
    heard = []
    threads = [threading.Thread(target=lambda: heard.append(exchange(peer.connection, b"".join(frames), length))),
               threading.Thread(target=lambda: [line.write(data) for data in there])]
    for thread in threads:
        thread.start()
    assert read_all(line, len(back)) == back
    for thread in threads:
        thread.join(LIMIT)
    written = Peer(types.SimpleNamespace(sendall=None, recv=io.BytesIO(heard[0]).read))
    assert [written.frame() for _ in there] == [(BINARY, data) for data in there]
    line.wake()
    assert line.read(LIMIT) == b""


def test_no_bytes_stay_behind_that_are_decrypted_but_not_read(opened, context, trusted):
    line, peer = opened(context)
    peer.sendall(frame(BINARY, bytes(3 * transport.READ_SIZE)))     # one record of TLS
    assert read_all(line, 3 * transport.READ_SIZE) == bytes(3 * transport.READ_SIZE)


def test_an_encrypted_connection_is_in_the_hands_of_one_thread_at_a_time():
    def use(argument):
        other = threading.Thread(target=lambda: free.append(encrypted._lock.acquire(blocking=False)))
        other.start()
        other.join(LIMIT)
        return b""

    free = []
    connection = types.SimpleNamespace(recv=use, send=lambda data: len(use(data)), pending=lambda: 0, fileno=None,
                                       close=None)
    encrypted = EncryptedSocket(connection)
    encrypted.recv(1)
    encrypted.send(b"!")
    assert free == [False, False]


def test_a_certificate_that_this_machine_does_not_trust(server, context):
    with pytest.raises(PortError, match="does not trust the certificate of the server: .*SSL_CERT_FILE"):
        open_transport(server(lambda peer: None, context), 9600, KEY)


def test_a_certificate_of_another_host(server, context, trusted):
    url = server(lambda peer: None, context)
    connection = connect(url, "localhost", int(url.split(":")[2].partition("/")[0]), "")
    with pytest.raises(PortError, match="does not trust the certificate of the server: .*robot.example.org"):
        encrypt(url, "robot.example.org", connection)


def test_a_server_that_does_not_encrypt(server, trusted):
    url = server(lambda peer: peer.sendall(b"HTTP/1.1 400 Bad Request\r\n\r\n")).replace("ws:", "wss:")
    with pytest.raises(PortError, match="cannot encrypt the connection: .*Does the server speak ws:// only"):
        open_transport(url, 9600, KEY)


def test_an_encrypted_server_that_is_gone_without_a_word(opened, context, trusted):
    line, peer = opened(context)
    peer.connection.shutdown(socket.SHUT_RDWR)
    with pytest.raises(LinkLostError, match="closed the line"):
        line.read(LIMIT)
