"""Write a bag (format 2.0, see `records`), message after message as bytes, in bounded memory.

``rosbag.Bag`` keeps an entry of every message in memory, and gives all publishers of a topic the first one's name, type
and latching. Here each connection stays itself: a topic may have several publishers (/tf, /rosout), and types.
"""

import bz2
import io
from typing import Any, Callable, Dict, List, Mapping, Tuple, Union

from .records import CHUNK, CHUNK_INFO, CONNECTION, FILE_HEADER, INDEX, MAGIC, TIME, U32, U64

MESSAGE_HEADER = b"\x26\0\0\0" b"\x04\0\0\0op=\x02" b"\x09\0\0\0conn=%b" b"\x0d\0\0\0time=%b" b"%b"
"""With op, connection, time, and the length of the message: most of a bag is messages."""
CHUNK_SIZE = 768 * 1024
"""Bytes before compression; the same as rosbag record's."""
FILE_HEADER_SIZE = 4096
VERSION = U32.pack(1)
"""Of index data and chunk infos."""


def _header(fields: Mapping[str, Union[str, bytes]]) -> bytes:
    """Fields as bytes, each after its length."""
    written = [name.encode() + b"=" + (value if isinstance(value, bytes) else value.encode())
               for name, value in fields.items()]
    return b"".join(U32.pack(len(field)) + field for field in written)


def _record(op: int, data: bytes, **fields: Union[str, bytes]) -> bytes:
    """A record; its op comes first, as recorders write it."""
    header = _header({"op": bytes([op]), **fields})
    return U32.pack(len(header)) + header + U32.pack(len(data)) + data


def _time(nanoseconds: int) -> bytes:
    return TIME.pack(*divmod(nanoseconds, 10 ** 9))


def _lz4(data: bytes) -> bytes:
    from roslz4 import LZ4Compressor    # a reader of such a bag has it

    compressor = LZ4Compressor()
    return compressor.compress(data) + compressor.flush()


def serialized(message: Any) -> bytes:
    """A message as it goes over the line."""
    buffer = io.BytesIO()
    message.serialize(buffer)
    return buffer.getvalue()


COMPRESSIONS: Dict[str, Callable[[bytes], bytes]] = {"none": bytes, "bz2": bz2.compress, "lz4": _lz4}


class BagWriter:
    """Writes one bag. Until it is closed, tools do not take the file for a bag.

    Args:
        path: of the bag.
        compression: none, bz2 or lz4.
    """

    def __init__(self, path: str, compression: str = "none") -> None:
        self._compress, self._compression = COMPRESSIONS[compression], compression
        self._connections: List[bytes] = []                     # their records
        self._chunk_infos: List[bytes] = []                     # the records of the chunks, for the index
        self._chunk = bytearray()
        # of the chunk: time and place of the messages, by connection
        self._index: Dict[int, List[Tuple[int, int]]] = {}
        self._file = open(path, "wb")
        self._file.write(MAGIC + self._file_header(0))

    def connect(self, topic: str, header: Mapping[str, str]) -> int:
        """Add a connection.

        Args:
            topic: its name.
            header: fields of the connection's header.

        Returns:
            The number by which `write` knows the connection.
        """
        number = len(self._connections)
        record = _record(CONNECTION, _header(header), conn=U32.pack(number), topic=topic)
        self._connections.append(record)
        self._chunk += record
        return number

    def write(self, connection: int, data: bytes, time: int) -> None:
        """Add a message.

        Args:
            connection: number of its connection.
            data: the message as it was sent.
            time: ns, when it was recorded.
        """
        self._index.setdefault(connection, []).append((time, len(self._chunk)))
        self._chunk += MESSAGE_HEADER % (U32.pack(connection), _time(time), U32.pack(len(data)))
        self._chunk += data
        if len(self._chunk) > CHUNK_SIZE:
            self._end_chunk()

    def close(self) -> None:
        """Write the rest and the index. Afterwards the file is a bag."""
        if self._chunk:
            self._end_chunk()
        index = self._file.tell()
        self._file.write(b"".join(self._connections + self._chunk_infos))
        self._file.seek(len(MAGIC))
        self._file.write(self._file_header(index))
        self._file.close()

    def _file_header(self, index: int) -> bytes:
        """The record that says where the index is; it has the same length whatever it says."""
        fields = dict(conn_count=U32.pack(len(self._connections)), chunk_count=U32.pack(len(self._chunk_infos)),
                      index_pos=U64.pack(index))
        return _record(FILE_HEADER, b" " * (FILE_HEADER_SIZE - len(_record(FILE_HEADER, b"", **fields))), **fields)

    def _end_chunk(self) -> None:
        """Write what has been collected, and where each message of it is."""
        position = self._file.tell()
        self._file.write(_record(CHUNK, self._compress(bytes(self._chunk)), compression=self._compression,
                                 size=U32.pack(len(self._chunk))))
        for connection, entries in self._index.items():
            places = b"".join(_time(time) + U32.pack(place) for time, place in sorted(entries))
            self._file.write(_record(INDEX, places, conn=U32.pack(connection), count=U32.pack(len(entries)),
                                     ver=VERSION))
        times = [time for entries in self._index.values() for time, _ in entries] or [0]
        counts = b"".join(TIME.pack(connection, len(entries)) for connection, entries in self._index.items())
        self._chunk_infos.append(_record(
            CHUNK_INFO, counts, chunk_pos=U64.pack(position), start_time=_time(min(times)), end_time=_time(max(times)),
            count=U32.pack(len(self._index)), ver=VERSION))
        self._chunk, self._index = bytearray(), {}
