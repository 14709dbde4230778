"""Read the records of a bag (format 2.0, http://wiki.ros.org/Bags/Format/2.0), and skip damaged bytes.

A bag begins with ``#ROSBAG V2.0``. Then come records.

A record is a header and data. The header is its length, then fields ``name=value``, each after its own length. The data
are their length, then bytes. Numbers are little-endian. The field ``op`` is the kind of the record:

==============  ====  ==========================================  =====================================================
record          op    fields                                      data
==============  ====  ==========================================  =====================================================
message         2     conn, time                                  the message as it was sent
file header     3     index_pos, conn_count, chunk_count          padding
index data      4     conn, count, ver                            time and place of each message in the chunk before it
chunk           5     compression (none, bz2, lz4), size          records: connections and messages
chunk info      6     chunk_pos, start_time, end_time, count      how many messages of which connections
connection      7     conn, topic                                 fields: type, md5sum, message_definition, ...
==============  ====  ==========================================  =====================================================

The index begins at ``index_pos``: all connection records again, and the chunk infos. ``index_pos`` is zero until the
recorder closes the bag.
"""

import bz2
import contextlib
import re
import struct
from typing import Any, Callable, Collection, Dict, Iterator, NamedTuple, Optional

from ..errors import UsageError

MAGIC = b"#ROSBAG V2.0\n"
MESSAGE, FILE_HEADER, INDEX, CHUNK, CHUNK_INFO, CONNECTION = range(2, 8)
FIELDS: Dict[int, Dict[bytes, Optional[int]]] = {
    MESSAGE: {b"conn": 4, b"time": 8},
    FILE_HEADER: {b"index_pos": 8, b"conn_count": 4, b"chunk_count": 4},
    INDEX: {b"conn": 4, b"count": 4, b"ver": 4},
    CHUNK: {b"compression": None, b"size": 4},
    CHUNK_INFO: {b"chunk_pos": 8, b"start_time": 8, b"end_time": 8, b"count": 4},
    CONNECTION: {b"conn": 4, b"topic": None},
}
"""The required fields of a record, by its op, with the length of each field in bytes (None: any length).

Bytes that have all required fields of an op are taken for a record."""
ENTRY = {INDEX: 12, CHUNK_INFO: 8}
"""Bytes of one entry in the data of a record, by its op. The field ``count`` is the number of entries."""
COMPRESSIONS = (b"none", b"bz2", b"lz4")
BETWEEN_CHUNKS = (INDEX, CHUNK, CHUNK_INFO)
"""Kinds of records that can follow a compressed chunk.

A record of another kind that is found behind a damaged chunk may be a piece of the chunk, because lz4 leaves some bytes
uncompressed."""
LONGEST_HEADER = 1 << 16
"""The largest legal length (bytes) of a header. The longest field in a header is the name of a topic."""
OP = re.compile(rb"\x04\0\0\0op=[\x02-\x07]")
OP_WITHIN = 64
"""The largest distance (bytes) from the begin of a header to its op.

The distance is short: recorders write the op first, or the fields in order of their names."""
USUAL_MESSAGE = re.compile(
    rb"\x26\0\0\0(?:\x09\0\0\0conn=(....)\x04\0\0\0op=\x02|\x04\0\0\0op=\x02\x09\0\0\0conn=(....))"
    rb"\x0d\0\0\0time=(........)(....)", re.DOTALL)
"""Matches the header of a message and the length of its data, as all known recorders write them.

Most records of a bag match."""
USUAL_LENGTH = 46
"""The number of bytes that `USUAL_MESSAGE` matches."""

BLOCK = 1 << 16
"""The number of bytes that are usually read at once. More are read only when a record needs them."""
LARGEST_CHUNK = 1 << 28
"""The largest number of bytes that a chunk is decompressed to. rosbag record makes chunks of 768 KiB or one message."""

U32 = struct.Struct("<I")
U64 = struct.Struct("<Q")
TIME = struct.Struct("<II")


class BagError(UsageError):
    """A file cannot be read as a bag, or has no run of the wanted robot. The message says why and what to do."""


class BagRecord(NamedTuple):
    """A record of a bag: its place and the content of its header.

    Places are in bytes from the begin of the file or of the decompressed chunk.
    """

    position: int
    """the begin of the record"""
    op: int
    """the kind of the record, for example `MESSAGE`"""
    fields: Dict[bytes, bytes]
    """the fields of the header; empty for most messages"""
    connection: int
    """the number of the connection; 0 if the record has none"""
    time: int
    """the time of a message (ns); 0 for other records"""
    begin: int
    """the begin of the data"""
    end: int
    """the end of the data, which is the end of the record"""

    @property
    def entries(self) -> int:
        """The number of entries in the data of an INDEX or CHUNK_INFO record."""
        return U32.unpack(self.fields[b"count"])[0]

    @property
    def compressed(self) -> bool:
        """Whether the record is a compressed chunk."""
        return self.op == CHUNK and self.fields[b"compression"] != b"none"


class Source:
    """The bytes of a file or of a decompressed chunk, by position. It reads them in blocks.

    Args:
        read_at: a function that takes a position and a length, and returns the bytes there.
        size: the number of bytes in the file or chunk.
        block: the first bytes, if they are read already.

    Attributes:
        size: the number of bytes. It becomes smaller if the file is cut off while it is read.
    """

    def __init__(self, read_at: Callable[[int, int], bytes], size: int, block: bytes = b"") -> None:
        self.read_at, self.size = read_at, size
        self._block, self._base = block, 0      # the block that was read last, and its position

    def get(self, position: int, length: int) -> bytes:
        """Return `length` bytes from a position on. At the end of the source there may be fewer."""
        index = position - self._base
        if index < 0 or index + length > len(self._block) and self._base + len(self._block) < self.size:
            self._block, self._base, index = self.read_at(position, max(length, BLOCK)), position, 0
            # the file was cut off after it was opened
            if len(self._block) < min(max(length, BLOCK), self.size - position):
                self.size = position + len(self._block)
        return self._block[index:index + length]

    def data(self, record: BagRecord) -> bytes:
        """Return the data of a record. At the end of the source there may be fewer bytes than the record says."""
        return self.get(record.begin, record.end - record.begin)


def source_of_bytes(data: bytes) -> Source:
    """Make a `Source` of bytes in memory."""
    return Source(lambda position, length: data[position:position + length], len(data), data)


def _length(data: bytes, index: int) -> int:
    """Read a length: the 4-byte number at an index of `data`. A huge number if fewer than 4 bytes are left there."""
    return U32.unpack(data[index:index + 4].ljust(4, b"\xff"))[0]


def fields_of(header: bytes) -> Dict[bytes, bytes]:
    """Split a header, or the data of a connection record, into its fields. Empty if the bytes are not fields."""
    fields, index = {}, 0
    while index < len(header):
        begin = index + 4
        index = begin + _length(header, index)
        name, equal, value = header[begin:index].partition(b"=")
        if not equal or index > len(header):
            return {}
        fields[name] = value
    return fields


def nanoseconds(field: bytes) -> int:
    """Convert a time field of a bag (8 bytes: seconds and nanoseconds) to ns."""
    seconds, rest = TIME.unpack(field)
    return seconds * 1000000000 + rest


def record_at(source: Source, position: int) -> Optional[BagRecord]:
    """Return the record that begins at a position. None if no record begins there.

    Only the header is checked. The end of the data may be wrong, even behind the end of the source.
    """
    usual = USUAL_MESSAGE.match(source.get(position, USUAL_LENGTH))
    if usual is None:
        return _unusual_record_at(source, position)
    first, second, time, length = usual.groups()
    begin = position + USUAL_LENGTH
    return BagRecord(position, MESSAGE, {}, U32.unpack(first or second)[0], nanoseconds(time), begin,
                     begin + U32.unpack(length)[0])


def _unusual_record_at(source: Source, position: int) -> Optional[BagRecord]:
    """Return the record of any kind that begins at a position. None if no record begins there.

    `record_at` calls this if the bytes do not match `USUAL_MESSAGE`.
    """
    length = _length(source.get(position, 4), 0)
    header = source.get(position + 4, length + 4) if length <= LONGEST_HEADER else b""
    if len(header) < length + 4:
        return None
    fields = fields_of(header[:length])
    op = fields.get(b"op", b"")
    needed = FIELDS.get(op[0]) if len(op) == 1 else None
    if needed is None or any(name not in fields or size not in (None, len(fields[name]))
                             for name, size in needed.items()):
        return None
    begin = position + length + 8
    record = BagRecord(position, op[0], fields, U32.unpack(fields.get(b"conn", bytes(4)))[0],
                       nanoseconds(fields.get(b"time", bytes(8))), begin, begin + U32.unpack_from(header, length)[0])
    wrong = (fields[b"compression"] not in COMPRESSIONS if record.op == CHUNK
             else record.op in ENTRY and record.end - record.begin != ENTRY[record.op] * record.entries)
    return None if wrong else record


def next_record(source: Source, position: int, searched: Collection[int] = FIELDS) -> int:
    """Return the position of the first record at or behind `position` whose kind is in `searched`.

    Returns the size of the source if there is no such record.
    """
    earliest = position
    while position < source.size:
        block = source.get(position, BLOCK)
        for found in OP.finditer(block):
            if block[found.end() - 1] not in searched:
                continue
            for start in range(max(earliest, position + found.start() - OP_WITHIN), position + found.start() - 3):
                if record_at(source, start):
                    return start
        position = position + len(block) - OP_WITHIN if position + len(block) < source.size else source.size
    return source.size


def records(source: Source, position: int,
            passes_over: Callable[[Source, BagRecord], bool] = lambda source, chunk: True,
            damaged: Callable[[int, int], Any] = lambda begin, end: None,
            searched: Collection[int] = FIELDS) -> Iterator[BagRecord]:
    """Yield every record from a position on, and skip damaged bytes.

    A record is right if another record, or the end of the source, follows its data. If not, the length of the record is
    wrong, or the bytes behind the record are damaged. Then the next record is searched from the begin of the data on.

    Args:
        source: the bytes of the records.
        position: the position of the first record.
        passes_over: a function that takes the source and an uncompressed chunk. It returns whether to skip the records
            inside the chunk. The default skips them in all chunks.
        damaged: a function that is called with the begin and the end of bytes that hold no records.
        searched: the kinds of records that are searched behind damaged bytes.
    """
    record = record_at(source, position)
    while position < source.size:
        after = position
        if record is not None:
            enters = record.op == CHUNK and not record.compressed and not passes_over(source, record)
            after = record.begin if enters else record.end
            following = record_at(source, after) if after < source.size else None
            if following is not None or after == source.size:
                yield record
                position, record = after, following
                continue
        if record is None:
            found = next_record(source, position + 1, searched)
        elif record.compressed:
            found = next_record(source, record.begin, BETWEEN_CHUNKS)
            yield record._replace(end=found)    # the part of the chunk before the next record
        else:
            found = next_record(source, record.begin, searched)
            if after <= found:
                yield record
        damaged(after if after <= found else position, found)
        position, record = found, record_at(source, found) if found < source.size else None


def decompressed(source: Source, chunk: BagRecord) -> bytes:
    """Decompress a chunk.

    The result ends before the first damaged byte, and at about `LARGEST_CHUNK` bytes.
    """
    decompress = _decompressor(chunk.fields[b"compression"])
    found = bytearray()
    with contextlib.suppress(OSError, EOFError):    # the chunk is damaged, or has bytes behind its compressed data
        for position in range(chunk.begin, chunk.end, BLOCK):
            if len(found) < LARGEST_CHUNK:
                found += decompress(source.read_at(position, min(BLOCK, chunk.end - position)),
                                    LARGEST_CHUNK - len(found))
    return bytes(found)


def _decompressor(compression: bytes) -> Callable[[bytes, int], bytes]:
    """Return a function that decompresses a chunk piece by piece.

    The function takes the next piece and the largest number of bytes to return, and returns the decompressed bytes.
    For lz4 it ignores this number. `compression` is b"bz2" or b"lz4".
    """
    if compression == b"bz2":
        return bz2.BZ2Decompressor().decompress
    try:
        from roslz4 import LZ4Decompressor      # imported here because only bags with lz4 need it
    except ImportError:
        return _decompressor_without_ros()
    lz4 = LZ4Decompressor()
    return lambda piece, most: lz4.decompress(piece)    # the result is at most 255 times as long as the piece


def _decompressor_without_ros() -> Callable[[bytes, int], bytes]:
    """Return the same for lz4, made of the library lz4 of PyPI.

    Raises:
        BagError: that is not installed either.
    """
    try:
        from lz4.frame import LZ4FrameDecompressor
    except ImportError:
        raise BagError("the bag is compressed with lz4, and neither ROS nor the library lz4 is here: pip install lz4, "
                       "or record with --compression bz2") from None
    lz4 = LZ4FrameDecompressor()

    def decompress(piece: bytes, most: int) -> bytes:
        try:
            return bytes(lz4.decompress(piece))
        except RuntimeError as error:       # damaged
            raise OSError(str(error)) from None
    return decompress
