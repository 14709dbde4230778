"""Ports on a WebSocket: ``ws://host:port/path`` and, encrypted, ``wss://host:port/path``.

The robot's bytes go in binary messages, both ways, cut anyhow. Before them, there are two text messages in JSON:

::

    client                                        server
      │── {"key": "..."} ──────────────────────────>│      may this program have the robot?
      │<───────────────────── {"robot": "rosie"} ───│      yes
      │<── or: close, code 4000 to 4999, reason ────│      no: the reason is a text for people
      │<══ binary messages: P2OS ══════════════════>│

Later text messages are for newer clients; this one ignores them.

Only this file uses websocket-client (Debian: python3-websocket), and imports it only when such a port is opened. The
library makes and reads frames. What it takes for its socket is a _Stream: this file waits for the bytes itself, with
the code of TCP, so a frame that comes in halves never holds up the reader, and any thread can wake it.
"""

import contextlib
import json
import socket
import ssl
import threading
import time
from typing import Any, Callable, Tuple
from urllib.parse import urlsplit

from ..errors import LinkLostError, PortError
from .tcp import CONNECT_TIMEOUT, SocketTransport, connect
from .transport import NO_MORE_BYTES, WRITE_TIMEOUT, Transport

ANSWER_TIMEOUT = 5.0        # s in which the server must have taken the connection and answered to the key
LONGEST_FRAME = 1 << 20     # bytes: a server that sends longer ones is no server of robots
SWITCHING_PROTOCOLS = 101   # the HTTP status of a WebSocket
CONTINUED, TEXT, BINARY, CLOSE, PING, PONG = 0, 1, 2, 8, 9, 10      # kinds of frames (RFC 6455, 5.2)
NORMAL = 1000               # the code of a close without a problem (RFC 6455, 7.4.1)


def open_web_socket(url: str, key: str) -> Transport:
    """Connect to a server of robots, tell it the key, and wait until it gives the robot. ``url`` has no key.

    Raises PortError that says why there is no robot and what to do. It never contains the key.
    """
    try:
        import websocket
    except ImportError as error:
        raise PortError("%s: a WebSocket needs websocket-client (%s): pip install websocket-client, or on Debian "
                        "apt install python3-websocket" % (url, error)) from error
    try:
        parts = urlsplit(url)
        encrypted = parts.scheme == "wss"
        host, port = parts.hostname, parts.port or (443 if encrypted else 80)
    except ValueError as error:
        raise PortError("%s: cannot understand this port: %s" % (url, error)) from error
    if not host:
        raise PortError("cannot understand the port %r: give ws://host:port/path" % url)
    connection = connect(url, host, port, "Does the server run, and is this its address?")
    transport = WebSocketTransport(url, encrypt(url, host, connection) if encrypted else connection, key, websocket)
    with contextlib.ExitStack() as on_failure:
        on_failure.callback(transport.close)
        transport.begin(parts.geturl())
        on_failure.pop_all()
    return transport


class WebSocketTransport(SocketTransport):
    """A connection to a server of robots. Call begin() first.

    Args:
        url: the port without its key, for error messages.
        connection: a connected socket, or EncryptedSocket, that never blocks. The transport closes it.
        key: the key of the robot.
        library: the module websocket.
    """

    def __init__(self, url: str, connection: Any, key: str, library: Any) -> None:
        super().__init__(url, connection)
        self._key = key
        self._library = library
        self._web = library.WebSocket()
        self._stream = _Stream(url, super().read, super().write)
        # Frames do not mix. Reentrant: a signal handler may stop the robot while its thread writes.
        self._sending = threading.RLock()
        self._message = CONTINUED       # kind of the message whose frames arrive

    def begin(self, target: str) -> None:
        """Make the connection a WebSocket, and ask for the robot. ``target`` is the URL for the server.

        Raises PortError if the server refuses, is no server of robots, or does not answer within ANSWER_TIMEOUT.
        """
        self._stream.deadline = time.monotonic() + ANSWER_TIMEOUT
        try:
            self._upgrade(target)
            self._send(TEXT, json.dumps({"key": self._key}).encode())
            self._take_robot()
        except BlockingIOError as error:
            raise PortError("%s: no answer within %.0f s: is this a server of robots?"
                            % (self.url, ANSWER_TIMEOUT)) from error
        except LinkLostError as error:
            raise PortError("%s (before it gave the robot: is this a server of robots?)" % error) from error
        self._stream.is_open = True

    def read(self, timeout: float) -> bytes:
        deadline = self._stream.deadline = time.monotonic() + timeout
        with contextlib.suppress(BlockingIOError):
            while True:
                kind, data, _ = self._frame()
                if kind == CLOSE:
                    raise LinkLostError("%s: the server closed the connection: %s" % (self.url, self._reason(data)))
                if kind == BINARY and data:
                    return data
                if time.monotonic() >= deadline:
                    break
        return b""

    def write(self, data: bytes) -> None:
        self._send(BINARY, data)

    def _upgrade(self, target: str) -> None:
        try:
            self._web.connect(target, socket=self._stream, redirect_limit=0)
            status = self._web.getstatus()
        except (BlockingIOError, LinkLostError):
            raise
        except self._library.WebSocketBadStatusException as error:
            status = error.status_code
        except Exception as error:      # the library has no one kind of error for an answer that makes no sense
            raise PortError("%s: what answers is no WebSocket. Is this the port of a server of robots?"
                            % self.url) from error
        if status != SWITCHING_PROTOCOLS:
            raise PortError("%s: what answers is no WebSocket: HTTP status %s. Is the path right?" % (self.url, status))

    def _take_robot(self) -> None:
        """Wait for the answer to the key. Raises PortError if the server does not give the robot."""
        text, is_whole = b"", False
        while not is_whole:
            if time.monotonic() >= self._stream.deadline:
                raise BlockingIOError
            kind, data, is_last = self._frame()
            if kind == CLOSE:
                raise PortError("%s: the server refuses: %s" % (self.url, self._reason(data)))
            if kind == TEXT:
                text, is_whole = text + data, is_last
        try:
            answer = json.loads(text.decode())
        except (ValueError, RecursionError):
            answer = None
        if not isinstance(answer, dict) or "robot" not in answer:
            raise PortError("%s: a WebSocket, but it does not answer as a server of robots" % self.url)

    def _frame(self) -> Tuple[int, bytes, bool]:
        """Return the next frame: its kind, its data, and whether it is the last one of its message. Answer to pings.

        A frame that continues a message has the kind of the message. Raises BlockingIOError when no whole frame has
        come before the deadline of the stream.
        """
        try:
            frame = self._web.recv_frame()
        except self._library.WebSocketException as error:
            raise LinkLostError("%s: what the server sends is no WebSocket frame" % self.url) from error
        self._stream.length = 0
        kind, data = int(frame.opcode), bytes(frame.data)
        if kind == PING:
            self._send(PONG, data)
        elif kind in (TEXT, BINARY):
            self._message = kind
        return self._message if kind == CONTINUED else kind, data, bool(frame.fin)

    def _send(self, kind: int, data: bytes) -> None:
        """Send one frame. Raises LinkLostError as write() does."""
        deadline = time.monotonic() + WRITE_TIMEOUT
        if not self._sending.acquire(timeout=WRITE_TIMEOUT):
            raise LinkLostError(NO_MORE_BYTES % self.url)
        try:
            self._write_until(deadline, self._library.ABNF.create_frame(data, kind).format())
        finally:
            self._sending.release()

    def _say_end(self) -> None:
        self._send(CLOSE, NORMAL.to_bytes(2, "big"))

    def _reason(self, data: bytes) -> str:
        """Return why the server has closed, from the data of its frame: a text for people, without the key."""
        reason = data[2:].decode(errors="replace")
        if self._key:
            reason = reason.replace(self._key, "(the key)")
        return reason or "it gave no reason (code %d)" % int.from_bytes(data[:2], "big")


class _Stream:
    """The bytes below the frames: what the library takes for a socket that never blocks.

    Attributes:
        deadline: the time (monotonic, s) until which recv() waits.
        is_open: whether the robot's bytes flow. Then somebody may wake a read(), and recv() does not go on waiting.
        length: number of bytes that have come since the last frame. The owner sets it to 0 after each frame.
    """

    def __init__(self, url: str, read: Callable[[float], bytes], write: Callable[[bytes], None]) -> None:
        self.deadline = 0.0
        self.is_open = False
        self.length = 0
        self._url = url
        self._read, self._write = read, write
        self._unread = b""

    def recv(self, count: int) -> bytes:
        """Return at most ``count`` bytes. Raises BlockingIOError when there are none until the deadline."""
        while count and not self._unread:
            self._unread = self._read(self.deadline - time.monotonic())
            if not self._unread and (self.is_open or time.monotonic() >= self.deadline):
                raise BlockingIOError
        data, self._unread = self._unread[:count], self._unread[count:]
        self.length += len(data)
        if self.length > LONGEST_FRAME:
            raise LinkLostError("%s: the server sends more than %d bytes in one piece" % (self._url, LONGEST_FRAME))
        return data

    def send(self, data: bytes) -> int:
        """Write all bytes, and return their number."""
        self._write(data)
        return len(data)

    def gettimeout(self) -> float:
        """Return 0: the library shall not wait by itself."""
        return 0.0

    def close(self) -> None:
        """Do nothing: the transport closes the connection."""


class EncryptedSocket:
    """A TLS connection that never blocks, for one thread that reads and one that writes. OpenSSL allows only one."""

    def __init__(self, connection: ssl.SSLSocket) -> None:
        self._connection = connection
        self._lock = threading.RLock()      # reentrant for signal handlers, too
        self.fileno = connection.fileno
        self.close = connection.close

    def recv(self, count: int) -> bytes:
        """Return bytes as the method of a socket does; more than ``count``, if more of them are decrypted already.

        Whoever waits for the socket cannot see the decrypted ones.
        """
        with self._lock:
            data = self._try(self._connection.recv, count)
            while self._connection.pending():
                data += self._connection.recv(self._connection.pending())
            return bytes(data)

    def send(self, data: bytes) -> int:
        """Send bytes as the method of a socket does, and return their number."""
        with self._lock:
            return int(self._try(self._connection.send, data))

    @staticmethod
    def _try(function: Callable[[Any], Any], argument: Any) -> Any:
        try:
            return function(argument)
        except (ssl.SSLWantReadError, ssl.SSLWantWriteError):
            raise BlockingIOError from None


def encrypt(url: str, host: str, connection: socket.socket) -> EncryptedSocket:
    """Begin TLS on a connection to ``host``. Raises PortError, also when the host cannot prove that it is the host."""
    try:
        connection.settimeout(CONNECT_TIMEOUT)
        encrypted = ssl.create_default_context().wrap_socket(connection, server_hostname=host)
        encrypted.setblocking(False)
        return EncryptedSocket(encrypted)
    except ssl.SSLCertVerificationError as error:
        raise PortError("%s: this machine does not trust the certificate of the server: %s. SSL_CERT_FILE in the "
                        "environment can name a file with the certificate to trust"
                        % (url, error.verify_message)) from error
    except (OSError, ValueError) as error:
        connection.close()
        raise PortError("%s: cannot encrypt the connection: %s. Does the server speak ws:// only?"
                        % (url, error)) from error
