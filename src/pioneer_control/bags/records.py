"""The format of bags, version 2.0 (http://wiki.ros.org/Bags/Format/2.0), read front to back, also around damage.

A bag begins with ``#ROSBAG V2.0``. Then come records.

A record is a header (its length, then fields ``name=value``, each after its own length) and data (their length, then
bytes); numbers are little-endian. The field ``op`` says what it is:

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

All connections again, and the chunk infos, stand at ``index_pos``, which is zero until the recorder closes the bag.
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
"""Fields that a record has at least, by its op, with their length in bytes (None: any).

What has them all is taken for a record."""
ENTRY = {INDEX: 12, CHUNK_INFO: 8}
"""Bytes of data for each of ``count``."""
COMPRESSIONS = (b"none", b"bz2", b"lz4")
BETWEEN_CHUNKS = (INDEX, CHUNK, CHUNK_INFO)
"""Kinds of records that can follow a compressed chunk.

A record of another kind that is found behind a damaged chunk may be a piece of the chunk: lz4 leaves some bytes as they
are."""
LONGEST_HEADER = 1 << 16
"""Bytes; a topic's name is the longest thing in a header."""
OP = re.compile(rb"\x04\0\0\0op=[\x02-\x07]")
OP_WITHIN = 64
"""Bytes from the begin of a header to its op, at most: recorders write the fields in order of their names, or the op
first."""
USUAL_MESSAGE = re.compile(
    rb"\x26\0\0\0(?:\x09\0\0\0conn=(....)\x04\0\0\0op=\x02|\x04\0\0\0op=\x02\x09\0\0\0conn=(....))"
    rb"\x0d\0\0\0time=(........)(....)", re.DOTALL)
"""A message's header and the length of its data, as all recorders known write them: most of a bag is this."""
USUAL_LENGTH = 46

BLOCK = 1 << 16
"""Bytes read at once. Longer data is read only as far as it is needed."""
LARGEST_CHUNK = 1 << 28
"""Bytes of a chunk after decompressing; rosbag record makes them of 768 KiB, or of one message."""

U32 = struct.Struct("<I")
U64 = struct.Struct("<Q")
TIME = struct.Struct("<II")


class BagError(UsageError):
    """A file that cannot be read as a bag, or not as the run of a robot; the message says why and what to do."""


class BagRecord(NamedTuple):
    """Where a record is, in bytes from the begin of a file or of a decompressed chunk, and what its header says."""

    position: int
    op: int
    fields: Dict[bytes, bytes]
    """empty for most messages"""
    connection: int
    """number of a connection, where it has one"""
    time: int
    """ns, of a message"""
    begin: int
    """of its data"""
    end: int
    """of its data, and so of the record"""

    @property
    def entries(self) -> int:
        """Entries in the data of an INDEX or CHUNK_INFO."""
        return U32.unpack(self.fields[b"count"])[0]

    @property
    def compressed(self) -> bool:
        """Whether it is a chunk with records that are to be decompressed."""
        return self.op == CHUNK and self.fields[b"compression"] != b"none"


class Source:
    """Bytes by position, of a file or of a decompressed chunk, read in blocks.

    Args:
        read_at: reads bytes: position, length.
        size: bytes that there are.
        block: the first of them, as far as they have been read.

    Attributes:
        block: the bytes that were read last.
        base: position of the first of them.
    """

    def __init__(self, read_at: Callable[[int, int], bytes], size: int, block: bytes = b"") -> None:
        self.read_at, self.size = read_at, size
        self.block, self.base = block, 0

    def load(self, position: int, length: int) -> int:
        """Have bytes in the block.

        Args:
            position: of the first.
            length: how many are needed; at the end there may be fewer.

        Returns:
            The index of the first in the block.
        """
        index = position - self.base
        if index < 0 or index + length > len(self.block) and self.base + len(self.block) < self.size:
            self.block, self.base, index = self.read_at(position, max(length, BLOCK)), position, 0
            # the file has been cut off meanwhile
            if len(self.block) < min(max(length, BLOCK), self.size - position):
                self.size = position + len(self.block)
        return index

    def get(self, position: int, length: int) -> bytes:
        """Bytes from a position on; fewer than `length` at the end."""
        index = self.load(position, length)
        return self.block[index:index + length]

    def data(self, record: BagRecord) -> bytes:
        """The data of a record."""
        return self.get(record.begin, record.end - record.begin)


def source_of_bytes(data: bytes) -> Source:
    """A source of bytes that are there already: one block."""
    return Source(lambda position, length: data[position:position + length], len(data), data)


def _length(data: bytes, index: int) -> int:
    """The length that stands somewhere in bytes; where they end within it, more than they have."""
    return U32.unpack(data[index:index + 4].ljust(4, b"\xff"))[0]


def fields_of(header: bytes) -> Dict[bytes, bytes]:
    """The fields of a header, or of a connection's data; empty where the bytes are neither."""
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
    """A time in ns."""
    seconds, rest = TIME.unpack(field)
    return seconds * 1000000000 + rest


def record_at(source: Source, position: int) -> Optional[BagRecord]:
    """The record that begins at a position; None if there is none. Its data may end anywhere."""
    index = source.load(position, USUAL_LENGTH)
    usual = USUAL_MESSAGE.match(source.block, index)
    if usual is None:
        return _unusual_record_at(source, position)
    first, second, time, length = usual.groups()
    begin = position + USUAL_LENGTH
    return BagRecord(position, MESSAGE, {}, U32.unpack(first or second)[0], nanoseconds(time), begin,
                     begin + U32.unpack(length)[0])


def _unusual_record_at(source: Source, position: int) -> Optional[BagRecord]:
    """The record that begins at a position, whatever it is; None if there is none."""
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
    """Position of the first record of the kinds `searched` at or after a position; the end if there is none."""
    earliest = position
    while position < source.size:
        index = source.load(position, BLOCK)
        block, base = source.block, source.base
        for found in OP.finditer(block, index):
            if block[found.end() - 1] not in searched:
                continue
            for start in range(max(earliest, base + found.start() - OP_WITHIN), base + found.start() - 3):
                if record_at(source, start):
                    return start
        position = base + len(block) - OP_WITHIN if base + len(block) < source.size else source.size
    return source.size


def records(source: Source, position: int,
            passes_over: Callable[[Source, BagRecord], bool] = lambda source, chunk: True,
            damaged: Callable[[int, int], Any] = lambda begin, end: None,
            searched: Collection[int] = FIELDS) -> Iterator[BagRecord]:
    """Every record from a position on.

    A record counts when another one, or the end, follows where its data end. Else either its length is wrong, or what
    follows. Then the next record is looked for from its data on.

    Args:
        source: of the records.
        position: of the first one.
        passes_over: whether the records in a chunk that is not compressed are left out; unless it is given, they are.
        damaged: is told which bytes hold no records: begin, end.
        searched: kinds of records that are looked for behind damaged bytes.
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
            yield record._replace(end=found)    # as much of it as there is
        else:
            found = next_record(source, record.begin, searched)
            if after <= found:
                yield record
        damaged(after if after <= found else position, found)
        position, record = found, record_at(source, found) if found < source.size else None


def decompressed(source: Source, chunk: BagRecord) -> bytes:
    """The records in a compressed chunk, as far as they can be decompressed: `LARGEST_CHUNK` bytes at most."""
    decompress = _decompressor(chunk.fields[b"compression"])
    found = bytearray()
    with contextlib.suppress(OSError, EOFError):    # damaged, or more bytes than it has
        for position in range(chunk.begin, chunk.end, BLOCK):
            if len(found) < LARGEST_CHUNK:
                found += decompress(source.read_at(position, min(BLOCK, chunk.end - position)),
                                    LARGEST_CHUNK - len(found))
    return bytes(found)


def _decompressor(compression: bytes) -> Callable[[bytes, int], bytes]:
    """A function that decompresses piece after piece. It takes a piece, and how many bytes may come out of it."""
    if compression == b"bz2":
        return bz2.BZ2Decompressor().decompress
    try:
        from roslz4 import LZ4Decompressor
    except ImportError:
        raise BagError("the bag is compressed with lz4: install the Python package roslz4 "
                       "(Debian: python3-roslz4)") from None
    lz4 = LZ4Decompressor()
    return lambda piece, most: lz4.decompress(piece)    # at most 255 times as long
