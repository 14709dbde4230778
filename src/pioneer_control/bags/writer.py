"""Write a bag (format 2.0, see `records`) from serialized messages, in little memory.

``rosbag.Bag`` keeps an entry of every message in memory. It writes the name, type and latching flag of a topic's first
publisher for all publishers of the topic. This writer keeps each connection as it is, so a topic can have several
publishers (/tf, /rosout) and several types.
"""

import bz2
import io
from typing import Any, Callable, Dict, List, Mapping, Tuple, Union

from .records import CHUNK, CHUNK_INFO, CONNECTION, FILE_HEADER, INDEX, MAGIC, TIME, U32, U64

MESSAGE_HEADER = b"\x26\0\0\0" b"\x04\0\0\0op=\x02" b"\x09\0\0\0conn=%b" b"\x0d\0\0\0time=%b" b"%b"
"""The header of a message record, and the length of its data. The gaps are for connection, time and length.

Most records of a bag are messages, so this header is not built by `_record`."""
CHUNK_SIZE = 768 * 1024
"""A chunk ends when it has more bytes than this before compression, as in rosbag record."""
FILE_HEADER_SIZE = 4096
VERSION = U32.pack(1)
"""The format version of index data and chunk infos."""


def _header(fields: Mapping[str, Union[str, bytes]]) -> bytes:
    """Convert fields to the bytes of a header: for each field its length, then ``name=value``."""
    written = [name.encode() + b"=" + (value if isinstance(value, bytes) else value.encode())
               for name, value in fields.items()]
    return b"".join(U32.pack(len(field)) + field for field in written)


def _record(op: int, data: bytes, **fields: Union[str, bytes]) -> bytes:
    """Return the bytes of a record: its header (with `op` as the first field) and its data."""
    header = _header({"op": bytes([op]), **fields})
    return U32.pack(len(header)) + header + U32.pack(len(data)) + data


def _time(nanoseconds: int) -> bytes:
    return TIME.pack(*divmod(nanoseconds, 10 ** 9))


def _lz4(data: bytes) -> bytes:
    from roslz4 import LZ4Compressor    # imported here because only bags with lz4 need it

    compressor = LZ4Compressor()
    return compressor.compress(data) + compressor.flush()


def serialized(message: Any) -> bytes:
    """Return the serialized bytes of a message object."""
    buffer = io.BytesIO()
    message.serialize(buffer)
    return buffer.getvalue()


COMPRESSIONS: Dict[str, Callable[[bytes], bytes]] = {"none": bytes, "bz2": bz2.compress, "lz4": _lz4}


class BagWriter:
    """Writes one bag. The index is written by `close`; tools refuse the file until then.

    Args:
        path: the path of the bag.
        compression: the compression of the chunks: none, bz2 or lz4.
    """

    def __init__(self, path: str, compression: str = "none") -> None:
        self._compress, self._compression = COMPRESSIONS[compression], compression
        self._connections: List[bytes] = []                     # the connection records
        self._chunk_infos: List[bytes] = []                     # the chunk info records, for the index
        self._chunk = bytearray()
        # by connection: time (ns) and position in the present chunk of each message
        self._index: Dict[int, List[Tuple[int, int]]] = {}
        self._file = open(path, "wb")
        self._file.write(MAGIC + self._file_header(0))

    def connect(self, topic: str, header: Mapping[str, str]) -> int:
        """Add a connection.

        Args:
            topic: the name of the topic.
            header: the fields of the connection, such as type, md5sum and message_definition.

        Returns:
            The number of the connection, for `write`.
        """
        number = len(self._connections)
        record = _record(CONNECTION, _header(header), conn=U32.pack(number), topic=topic)
        self._connections.append(record)
        self._chunk += record
        return number

    def write(self, connection: int, data: bytes, time: int) -> None:
        """Add a message.

        Args:
            connection: the number of the connection, from `connect`.
            data: the serialized message.
            time: the time when the message was recorded (ns).
        """
        self._index.setdefault(connection, []).append((time, len(self._chunk)))
        self._chunk += MESSAGE_HEADER % (U32.pack(connection), _time(time), U32.pack(len(data)))
        self._chunk += data
        if len(self._chunk) > CHUNK_SIZE:
            self._end_chunk()

    def close(self) -> None:
        """Write the last chunk and the index, and close the file. Then the file is a complete bag."""
        if self._chunk:
            self._end_chunk()
        index = self._file.tell()
        self._file.write(b"".join(self._connections + self._chunk_infos))
        self._file.seek(len(MAGIC))
        self._file.write(self._file_header(index))
        self._file.close()

    def _file_header(self, index: int) -> bytes:
        """Return the file header record, which has the position of the index (bytes). 0: the bag is not closed yet.

        The record always has the same length, so that `close` can overwrite it.
        """
        fields = dict(conn_count=U32.pack(len(self._connections)), chunk_count=U32.pack(len(self._chunk_infos)),
                      index_pos=U64.pack(index))
        return _record(FILE_HEADER, b" " * (FILE_HEADER_SIZE - len(_record(FILE_HEADER, b"", **fields))), **fields)

    def _end_chunk(self) -> None:
        """Write the collected messages as a chunk, and behind it the index data of the chunk. Begin a new chunk."""
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
