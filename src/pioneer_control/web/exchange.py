"""What the owner of the robots and the web server say to each other, over one stream socket.

Each message is its length (u32, little-endian, of what follows), one byte for its kind, and its contents:

====  ============  ===================================================================================================
kind  from          contents
====  ============  ===================================================================================================
C     owner         JSON, first: ``{"keys": {key: whether it is a teacher's}, "title": text, "hosts": [names],
                    "kind": "live" or "recording"}``
W     owner         one binary message of a recording, which each viewer gets as it is, before all frames
F     owner         one frame, as frames.encode_frame() gives it
T     owner         JSON: ``{"kind": ..., "robot": number or null, "value": ..., "seat": visitor or "", "to": for
                    whom, as Feed.text() takes it}``
S     owner         JSON: ``{"level": ..., "text": ..., "robot": number or null, "viewers": [numbers] or null (all)}``
B     server        empty: the server lives; every BEAT s
O     server        JSON, an order: ``{"person": [the fields of backend.Person], "message": the page's message}``
V     server        JSON, a viewer has come: the fields of backend.Person
G     server        JSON: the number of a viewer who is gone
J     server        JSON, a program asks for a robot: ``{"program": number of its connection, "robot": number or null,
                    "key": text}``
A     owner         JSON, it has the robot: ``{"program": number, "robot": name}``
X     owner         JSON, its connection is to be closed: ``{"program": number, "code": ..., "reason": ...}``
P     both          bytes of a program, or for it: the number of its connection (u32), and the bytes
Q     server        JSON: the number of a program that is gone
====  ============  ===================================================================================================
"""

import contextlib
import json
import socket
import struct
import threading
from collections import deque
from typing import Any, Deque, Dict, List, Optional, Sequence, Tuple

from ..errors import UsageError
from .backend import TEACHERS
from .guard import Farewell

BEAT = 0.1                      # s between two beats of the server
CONFIGURE, WHOLE, FRAME, TEXT, SAID = b"C", b"W", b"F", b"T", b"S"
BEAT_MESSAGE, ORDER, CAME, GONE = b"B", b"O", b"V", b"G"
JOIN, OPENED, CLOSED, BYTES, PROGRAM_GONE = b"J", b"A", b"X", b"P", b"Q"
LENGTH = struct.Struct("<I")
LONGEST = 64 * 2 ** 20          # bytes: a map may be large
MOST_WAITING = 200              # sentences
MOST_FOR_PROGRAMS = 2000        # messages: more than come before the lines of a silent server end
READ_SIZE = 65536

Part = Tuple[bytes, bytes]
"""A message: its kind and its contents."""


def packed(kind: bytes, contents: bytes = b"") -> bytes:
    """Return a message as bytes."""
    return LENGTH.pack(len(contents) + 1) + kind + contents


def packed_json(kind: bytes, value: Any) -> bytes:
    """Return a message with a value as JSON."""
    return packed(kind, json.dumps(value, separators=(",", ":"), allow_nan=False).encode())


def packed_bytes(number: int, data: bytes) -> bytes:
    """Return the message with bytes of a program, or for it."""
    return packed(BYTES, LENGTH.pack(number) + data)


def bytes_of(contents: bytes) -> Tuple[int, bytes]:
    """Return the number of a program and the bytes, of the contents of a message BYTES.

    Raises:
        ValueError: the contents are too short.
    """
    if len(contents) < LENGTH.size:
        raise ValueError("a message for a program has %d bytes" % len(contents))
    number, = LENGTH.unpack_from(contents)
    return number, contents[LENGTH.size:]


class Unpacker:
    """Takes bytes in any pieces, and gives whole messages."""

    def __init__(self) -> None:
        self._data = bytearray()

    def take(self, data: bytes) -> List[Part]:
        """Take bytes. Returns the messages that are whole now. Raises UsageError for a length that is not legal."""
        self._data += data
        found, at = [], 0
        while len(self._data) - at >= LENGTH.size:
            length, = LENGTH.unpack_from(self._data, at)
            if not 1 <= length <= LONGEST:
                raise UsageError("a message has %d bytes; legal: 1 to %d" % (length, LONGEST))
            end = at + LENGTH.size + length
            if end > len(self._data):
                break
            begin = at + LENGTH.size
            found.append((bytes(self._data[begin:begin + 1]), bytes(self._data[begin + 1:end])))
            at = end
        del self._data[:at]
        return found


class Outbox:
    """The owner's way to the server: a Feed that any thread may use, that never blocks, and keeps only the newest.

    Without a server the newest of each kind waits for the next one.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._socket: Optional[socket.socket] = None
        self._rest = b""                                            # of a message that is under way
        self._known: Dict[Tuple[str, Optional[int], str], bytes] = {}   # the newest text of each kind
        self._texts: Dict[Tuple[str, Optional[int], str], bytes] = {}   # those that are not sent yet
        self._for_programs: Deque[bytes] = deque(maxlen=MOST_FOR_PROGRAMS)
        self._frames: Dict[int, bytes] = {}
        self._said: Deque[bytes] = deque(maxlen=MOST_WAITING)

    def frame(self, frame: bytes) -> None:
        """Send the newest frame of a robot. See Feed.frame()."""
        with self._lock:
            self._frames[frame[0] | frame[1] << 8] = frame
            self._flush()

    def text(self, kind: str, value: Any, robot: Optional[int] = None, seat: str = "", to: str = "") -> None:
        """Send the newest text of a kind. See Feed.text()."""
        data = packed_json(TEXT, {"kind": kind, "robot": robot, "value": value, "seat": seat, "to": to})
        with self._lock:
            self._known[kind, robot, to] = self._texts[kind, robot, to] = data
            if value is None and to not in ("", TEACHERS):
                del self._known[kind, robot, to]    # visitors come without end: nothing is kept of one who has nothing
            self._flush()

    def said(self, level: str, text: str, robot: Optional[int] = None,
             viewers: Optional[Sequence[int]] = None) -> None:
        """Send a sentence. See Feed.said(). Of very many that wait the oldest are dropped."""
        data = packed_json(SAID, {"level": level, "text": text, "robot": robot,
                                  "viewers": None if viewers is None else list(viewers)})
        with self._lock:
            self._said.append(data)
            self._flush()

    def open_program(self, number: int, name: str) -> None:
        """Tell a program that it has the robot of this name."""
        self._tell_program(packed_json(OPENED, {"program": number, "robot": name}))

    def close_program(self, number: int, farewell: Farewell) -> None:
        """Close the connection of a program."""
        self._tell_program(packed_json(CLOSED, {"program": number, **farewell._asdict()}))

    def program_bytes(self, number: int, data: bytes) -> None:
        """Send bytes to a program."""
        self._tell_program(packed_bytes(number, data))

    def _tell_program(self, message: bytes) -> None:
        with self._lock:
            self._for_programs.append(message)
            self._flush()

    def connect(self, end: socket.socket, first: Sequence[bytes]) -> None:
        """Use this socket, which never blocks, to a new server. It gets ``first``, then all that is known."""
        with self._lock:
            self._socket, self._rest = end, b"".join(first)
            self._texts = dict(sorted(self._known.items(), key=lambda known: known[0][0] != "robots"))
            self._said.clear()      # for viewers of another server
            self._for_programs.clear()
            self._flush()

    def disconnect(self) -> None:
        """Use no socket any more, until the next connect()."""
        with self._lock:
            self._socket, self._rest = None, b""

    def flush(self) -> bool:
        """Send what waits, as far as the socket takes it. Returns whether something still waits for the socket."""
        with self._lock:
            self._flush()
            return self._socket is not None and bool(self._rest)

    def _flush(self) -> None:
        end = self._socket
        if end is None:
            return
        with contextlib.suppress(OSError):      # it takes no more now, or is closed: the owner sees that when it reads
            while True:
                if not self._rest:
                    self._rest = self._next()
                    if not self._rest:
                        return
                self._rest = self._rest[end.send(self._rest):]

    def _next(self) -> bytes:
        """Take the next piece out of what waits: all texts, all for programs, then sentences, then all frames."""
        if self._texts:
            pieces = list(self._texts.values())
            self._texts.clear()
        elif self._for_programs:
            pieces = list(self._for_programs)
            self._for_programs.clear()
        elif self._said:
            pieces = [self._said.popleft()]
        else:
            pieces = [packed(FRAME, frame) for frame in self._frames.values()]
            self._frames.clear()
        return b"".join(pieces)
