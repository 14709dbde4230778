"""Read what ``rosbag record`` wrote, front to back, in bounded memory, whole or damaged: ``for topic, connection, data, time in read_bag(path)``.

``rosbag.Bag`` keeps an entry of every message in memory and refuses a bag that was not closed. This reads the file as what it is (format 2.0,
http://wiki.ros.org/Bags/Format/2.0): ``#ROSBAG V2.0``, then records. Each is a header (its length, then fields ``name=value``, each after its own
length) and data (its length, then bytes). The field ``op`` says what it is; the others that matter here, numbers little-endian:

==============  ====  ==========================================  =================================================
record          op    fields                                      data
==============  ====  ==========================================  =================================================
file header     3     index_pos                                   padding
chunk           5     compression (none, bz2, lz4), size          records: connections and messages
connection      7     conn, topic                                 fields: type, md5sum, message_definition, ...
message         2     conn, time                                  the message as it was sent
index data      4     conn, count, ver                            not needed here
chunk info      6     chunk_pos, start_time, end_time, count      how many messages of which connections
==============  ====  ==========================================  =================================================

Connections are repeated, and chunk infos stand, at ``index_pos``, which is zero until the recorder closes the bag. With them whole chunks without a
wanted topic are passed over. Without them all is read that is there. Where the bytes are no records, the next record is searched.
"""

import bisect
import bz2
import functools
import os
import re
import struct
from typing import Any, Callable, Collection, Dict, Iterator, List, NamedTuple, Optional, Sequence, Set, Tuple, Union

from ..errors import UsageError

MAGIC = b"#ROSBAG V2.0\n"
MESSAGE, FILE_HEADER, INDEX, CHUNK, CHUNK_INFO, CONNECTION = range(2, 8)
FIELDS: Dict[int, Dict[bytes, Optional[int]]] = {
    MESSAGE: {b"conn": 4, b"time": 8},
    FILE_HEADER: {b"index_pos": 8},
    INDEX: {b"conn": 4, b"count": 4, b"ver": 4},
    CHUNK: {b"compression": None, b"size": 4},
    CHUNK_INFO: {b"chunk_pos": 8, b"start_time": 8, b"end_time": 8, b"count": 4},
    CONNECTION: {b"conn": 4, b"topic": None},
}
"""op -> the fields it has at least, with their length in bytes; None: any. What has them all is taken for a record."""
COMPRESSIONS = (b"none", b"bz2", b"lz4")
LONGEST_HEADER = 1 << 16
"""Bytes; a topic's name is the longest thing in a header."""
OP = re.compile(rb"\x04\0\0\0op=[\x02-\x07]")
OP_WITHIN = 64
"""Bytes from the begin of a header to its op, at most: recorders write the fields in order of their names, or the op first."""
USUAL_MESSAGE = re.compile(
    rb"\x26\0\0\0(?:\x09\0\0\0conn=(....)\x04\0\0\0op=\x02|\x04\0\0\0op=\x02\x09\0\0\0conn=(....))\x0d\0\0\0time=(........)(....)", re.DOTALL)
"""A message's header and the length of its data, as all recorders known write it: most of a bag is this."""

BLOCK = 1 << 16
"""Bytes read at once. Data of messages that nobody wants are not read when they are longer."""
PIECE = 1 << 16
"""Bytes decompressed at once."""
LARGEST_CHUNK = 1 << 30
"""Bytes of a chunk after decompressing; rosbag record makes them of 768 KiB, or of one message."""
LATE = 10 ** 9
"""ns by which messages may be recorded in the wrong order and are still given in the right one, in a bag without chunk infos."""
HELD = 1 << 25
"""Bytes of messages kept back at most, to put them in order."""
STEP = 0.005
"""Share of all bytes between two calls of progress."""
PLACES = 3
"""Damaged places that are told one by one."""

Progress = Callable[[int, int], Any]
_U32 = struct.Struct("<I")


class BagError(UsageError):
    """A file that cannot be read as the run of a robot; the message says why and what to do."""


class Connection(NamedTuple):
    """A topic as one publisher sent it."""

    topic: str
    type: str
    """for example nav_msgs/Odometry"""
    md5sum: str
    definition: str
    """text of the message and of all messages in it"""
    latching: bool
    """whether late subscribers get the last message"""
    caller: str
    """name of the node that published it; empty where the bag does not say"""
    header: Dict[str, str]
    """all fields as the bag has them: what rosbag.Bag.write takes as connection_header"""


class Message(NamedTuple):
    """One recorded message."""

    topic: str
    connection: Connection
    data: bytes
    """as it was sent; `decode` makes a message of it"""
    time: int
    """ns since 1970, or of simulated time: when the recorder got it"""


class Damage(NamedTuple):
    """Bytes of a file that are not what they should be."""

    begin: int
    end: int
    after: Optional[float]
    """s from the first message to the last before this place; None before the first"""


class _Record(NamedTuple):
    """A record of a file or of a decompressed chunk: where its data are, in bytes from the begin."""

    position: int
    op: int
    fields: Dict[bytes, bytes]
    connection: int
    time: int
    begin: int
    end: int


class _Source:
    """Bytes by position, read in blocks: ``read_at(position, length)`` gives them, of a file or of a decompressed chunk."""

    def __init__(self, read_at: Callable[[int, int], bytes], size: int, block: int) -> None:
        self.read_at = read_at
        self.size = size
        self._length = block
        self.block = b""
        self.base = 0

    def load(self, position: int, length: int) -> int:
        """Make sure that the block holds so many bytes from a position on, as far as there are; returns their index in the block."""
        index = position - self.base
        if index < 0 or index + length > len(self.block):
            if index < 0 or self.base + len(self.block) < self.size:
                self.block, self.base, index = self.read_at(position, max(length, self._length)), position, 0
        return index

    def get(self, position: int, length: int) -> bytes:
        """Bytes, as far as there are."""
        index = self.load(position, length)
        return self.block[index:index + length]


def _fields(header: bytes) -> Optional[Dict[bytes, bytes]]:
    """The fields of a header; None if it is none."""
    fields, index = {}, 0
    while index < len(header):
        if index + 4 > len(header):
            return None
        length, = _U32.unpack_from(header, index)
        name, equal, value = header[index + 4:index + 4 + length].partition(b"=")
        index += 4 + length
        if not equal or index > len(header):
            return None
        fields[name] = value
    return fields


def _time(value: bytes) -> int:
    """Time of a field, in ns."""
    seconds, nanoseconds = struct.unpack("<II", value)
    return seconds * 10 ** 9 + nanoseconds


def _record_at(source: _Source, position: int) -> Optional[_Record]:
    """The record that begins at a position, whose data may end anywhere; None if there is none."""
    index = source.load(position, 46)
    usual = USUAL_MESSAGE.match(source.block, index)
    if usual:
        first, second, time, length = usual.groups()
        connection, = _U32.unpack(first or second)
        begin = position + 46
        return _Record(position, MESSAGE, {}, connection, _time(time), begin, begin + _U32.unpack(length)[0])
    head = source.get(position, 4)
    if len(head) < 4:
        return None
    length, = _U32.unpack(head)
    if length > LONGEST_HEADER:
        return None
    header = source.get(position + 4, length + 4)
    if len(header) < length + 4:
        return None
    fields = _fields(header[:length])
    op = fields.get(b"op", b"") if fields else b""
    needed = FIELDS.get(op[0]) if len(op) == 1 else None
    if needed is None or any(name not in fields or size not in (None, len(fields[name])) for name, size in needed.items()):
        return None
    if op[0] == CHUNK and fields[b"compression"] not in COMPRESSIONS:
        return None
    connection, = _U32.unpack(fields.get(b"conn", bytes(4)))
    begin = position + 4 + length + 4
    return _Record(position, op[0], fields, connection, _time(fields.get(b"time", bytes(8))), begin, begin + _U32.unpack_from(header, length)[0])


def _next_record(source: _Source, position: int) -> int:
    """Position of the first record at or after a position; the end if there is none."""
    earliest = position
    while position < source.size:
        index = source.load(position, BLOCK)
        block, base = source.block, source.base
        for found in OP.finditer(block, index):
            op = base + found.start()
            for start in range(max(earliest, op - OP_WITHIN), op - 3):
                if _record_at(source, start):
                    return start
        position = base + len(block) - OP_WITHIN if base + len(block) < source.size else source.size
    return source.size


def _records(source: _Source, position: int, passes_over: Callable[[_Record], bool], damaged: Callable[[int, int], Any]) -> Iterator[_Record]:
    """Every record from a position on, those in uncompressed chunks too, but for the ones in chunks that are passed over.

    A record counts when another one, or the end, follows where its data end; else either its length is wrong, or what follows. Then the next record is
    searched from its data on, and ``damaged`` told which bytes are none: begin, end.
    """
    record = _record_at(source, position)
    while position < source.size:
        compressed = entered = False
        after, found = position, 0
        if record is not None:
            compressed = record.op == CHUNK and record.fields[b"compression"] != b"none"
            entered = record.op == CHUNK and not compressed and not passes_over(record)
            after = record.begin if entered else record.end
            following = _record_at(source, after) if after < source.size else None
            if following or after == source.size:
                yield record
                position, record = after, following
                continue
        found = _next_record(source, position + 1 if record is None else record.begin)
        if record is not None and compressed:  # as much of it as there is
            yield record._replace(end=found)
        elif record is not None and after <= found:
            yield record
        damaged(after if after <= found else position, found)
        position, record = found, _record_at(source, found) if found < source.size else None


def _decompressed(source: _Source, chunk: _Record) -> bytes:
    """The records in a compressed chunk, as far as they can be had."""
    decompress = _decompressor(chunk.fields[b"compression"])
    pieces, total = [], 0
    try:
        for position in range(chunk.begin, chunk.end, PIECE):
            pieces.append(decompress(source.read_at(position, min(PIECE, chunk.end - position))))
            total += len(pieces[-1])
            if total > LARGEST_CHUNK:
                break
    except (OSError, EOFError):  # damaged, or beyond its end
        pass
    return b"".join(pieces)


def _decompressor(compression: bytes) -> Callable[[bytes], bytes]:
    if compression == b"bz2":
        return bz2.BZ2Decompressor().decompress
    try:
        from roslz4 import LZ4Decompressor
    except ImportError:
        raise BagError("the bag is compressed with lz4: install the Python package roslz4 (Debian: python3-roslz4)") from None
    return LZ4Decompressor().decompress


class _File:
    """One file of a recording."""

    def __init__(self, path: str, is_wanted: Callable[[Connection], bool]) -> None:
        self.path = path
        self.connections: Dict[int, Connection] = {}
        self.begin: Optional[int] = None
        self.end: Optional[int] = None
        self.compression = ""
        self._is_wanted = is_wanted
        self._wanted: Dict[int, bool] = {}
        self._chunks: Dict[int, Tuple[int, Set[int]]] = {}      # by position: the first time in it or a later one, and the connections in it
        self._first = len(MAGIC)    # record
        self._index = 0             # where it begins; 0 in a bag that was not closed
        self._places: List[Damage] = []
        self._nameless = 0          # messages of connections that are not described
        try:
            with open(path, "rb", buffering=0) as file:
                self.size = os.fstat(file.fileno()).st_size
                self._look(_source_of(file, self.size))
        except FileNotFoundError:
            raise BagError(f"{path}: no such file") from None
        except OSError as error:
            raise BagError(f"{path} cannot be read: {error.strerror or error}") from None

    def _look(self, source: _Source) -> None:
        """Whether it is a bag, and what its index says."""
        magic = source.get(0, len(MAGIC))
        if not magic:
            raise BagError(f"{self.path} is empty (0 bytes): its recorder wrote nothing, or the disk was full")
        if magic != MAGIC:
            if magic.startswith(b"#ROSBAG V1"):
                raise BagError(f"{self.path} is a bag of an old format, {magic[8:].decode('ascii', 'replace').strip()}: only 2.0 is read. "
                               "This makes one of it: rosbag filter OLD.bag NEW.bag True")
            self._first = _next_record(_source_of_bytes(source.get(0, BLOCK)), 0)
            if self._first >= min(self.size, BLOCK):
                raise BagError(f"{self.path} is not a bag, or nothing of it is left: it does not begin with {MAGIC.decode().strip()!r}, and no record follows")
            self._damaged(0, self._first)
        head = _record_at(source, self._first)
        if head is None or head.op != FILE_HEADER:
            return
        if head.fields.get(b"encryptor", b"") not in (b"", b"rosbag/NoEncryptor"):
            raise BagError(f"{self.path} is encrypted: rosbag decrypt makes a bag of it that can be read")
        self._index, = struct.unpack("<Q", head.fields[b"index_pos"])
        if self._index < self.size:
            self._read_index(source)

    def _read_index(self, source: _Source) -> None:
        """Learn of the connections and chunks, unless something there is damaged."""
        connections, chunks, damages = {}, {}, []
        for record in _records(source, self._index, lambda position: True, lambda begin, end: damages.append(begin)):
            if record.op == CONNECTION:
                connections[record.connection] = _connection(record, source.get(record.begin, record.end - record.begin))
            elif record.op == CHUNK_INFO:
                numbers = source.get(record.begin, record.end - record.begin)
                position, = struct.unpack("<Q", record.fields[b"chunk_pos"])
                chunks[position] = _time(record.fields[b"start_time"]), {number for number, _ in struct.iter_unpack("<II", numbers[:len(numbers) & -8])}
            else:
                damages.append(record.begin)
        if damages or None in connections.values():
            return
        for number, connection in connections.items():
            self._know(number, connection)
        earliest = None
        for position in sorted(chunks, reverse=True):
            start, inside = chunks[position]
            earliest = start if earliest is None else min(start, earliest)
            foreign = inside and all(self._wanted.get(number, True) is False for number in inside)
            self._chunks[position] = earliest, inside if foreign else set()

    def _know(self, number: int, connection: Optional[Connection]) -> None:
        if connection is not None and number not in self.connections:
            self.connections[number] = connection
            self._wanted[number] = bool(self._is_wanted(connection))

    def _damaged(self, begin: int, end: int) -> None:
        """Keep in mind a place that is no record."""
        after = None if self.begin is None else (self.end - self.begin) / 1e9
        if self._places and begin <= self._places[-1].end:
            self._places[-1] = self._places[-1]._replace(end=max(end, self._places[-1].end))
        else:
            self._places.append(Damage(begin, end, after))

    def messages(self, progress: Callable[[int], Any]) -> Iterator[Message]:
        """The wanted messages in order of time, as far as `LATE` and `HELD` allow."""
        waiting: List[Tuple[int, int, Connection, bytes]] = []
        held = count = 0
        with open(self.path, "rb", buffering=0) as file:
            for source, record in self._contents(_source_of(file, self.size)):
                if record.op == MESSAGE:
                    time, number = record.time, record.connection
                    if self.begin is None:
                        self.begin = self.end = time
                    elif time > self.end:
                        self.end = time
                    elif time < self.begin:
                        self.begin = time
                    wanted = self._wanted.get(number)
                    if wanted:
                        count += 1
                        held += record.end - record.begin
                        waiting.append((time, count, self.connections[number], source.get(record.begin, record.end - record.begin)))
                        if held > HELD:
                            yield from _give(waiting, sorted(waiting)[len(waiting) // 2][0])
                            held = sum(len(entry[-1]) for entry in waiting)
                    elif wanted is None:
                        self._nameless += 1
                elif record.op == CONNECTION:
                    self._know(record.connection, _connection(record, source.get(record.begin, record.end - record.begin)))
                elif record.op == CHUNK:
                    self.compression = self.compression or record.fields[b"compression"].decode()
                    progress(record.position)
                    earliest = self._chunks[record.position][0] if record.position in self._chunks else (self.end or 0) - LATE
                    yield from _give(waiting, earliest)
                    held = sum(len(entry[-1]) for entry in waiting)
            yield from _give(waiting, None)
        progress(self.size)

    def _contents(self, source: _Source) -> Iterator[Tuple[_Source, _Record]]:
        """All records and where their data are, those in chunks too, but for chunks in which nothing is wanted."""

        def passes_over(chunk):
            inside = self._chunks.get(chunk.position, (0, None))[1]
            return bool(inside) and inside == _indexed(source, chunk.end)   # both say so: one flipped byte loses no chunk

        for record in _records(source, self._first, passes_over, self._damaged):
            yield source, record
            if record.op == CHUNK and record.fields[b"compression"] != b"none" and not passes_over(record):
                data = _decompressed(source, record)
                bad: List[int] = []
                inner = _source_of_bytes(data)
                for entry in _records(inner, 0, passes_over, lambda begin, end: bad.append(begin)):
                    yield inner, entry
                if bad or len(data) != _U32.unpack(record.fields[b"size"])[0]:
                    self._damaged(record.begin, record.end)

    def damage(self) -> List[str]:
        """What is missing, in sentences."""
        sentences = []
        cut = bool(self._places) and self._places[-1].end == self.size
        places = [place for place in self._places if place.begin < (self._index or self.size)]
        for place in places[:PLACES]:
            if cut and place is self._places[-1]:
                continue
            size = place.end - place.begin
            sentences.append(f"{self.path} is damaged at {_percent(place.begin / self.size)} of the file{_after(place.after)}: {size} bytes there are lost.")
        more = len(places) - PLACES - (cut and len(places) > PLACES)
        if more > 0:
            sentences.append(f"So it is at {more} more places.")
        seconds = "before its first message" if self.begin is None else f"after {(self.end - self.begin) / 1e9:.1f} s"
        if self._index > self.size:
            sentences.append(f"{self.path} is cut off {seconds}, at {_percent(self.size / self._index)} of its length: the rest is missing.")
        elif not self._index and cut:
            sentences.append(f"{self.path} was not closed and ends in the middle of something {seconds}: its recorder was killed, or the disk was full.")
        elif not self._index:
            sentences.append(f"{self.path} was not closed and ends {seconds}: its recorder was killed, or still records.")
        elif cut and places and places[-1] is self._places[-1]:
            sentences.append(f"{self.path} is damaged from {_percent(places[-1].begin / self.size)} of the file on, {seconds}: the rest is missing.")
        elif cut:
            sentences.append(f"{self.path} is cut off in its index: all messages are there, but rosbag wants it mended (rosbag reindex).")
        if self._nameless:
            sentences.append(f"{self.path} does not say any more what {self._nameless} of its messages are: these are lost.")
        return sentences


def _source_of(file, size: int) -> _Source:
    return _Source(lambda position, length: os.pread(file.fileno(), length, position), size, BLOCK)


def _source_of_bytes(data: bytes) -> _Source:
    return _Source(lambda position, length: data, len(data), len(data))


def _indexed(source: _Source, position: int) -> Set[int]:
    """The connections of the index data from a position on."""
    found = set()
    record = _record_at(source, position)
    while record is not None and record.op == INDEX:
        found.add(record.connection)
        record = _record_at(source, record.end)
    return found


def _connection(record: _Record, data: bytes) -> Optional[Connection]:
    """The Connection of a record and its data; None if they make none."""
    fields = _fields(data)
    if not fields or not {b"type", b"md5sum", b"message_definition"} <= set(fields):
        return None
    header = {name.decode("utf-8", "replace"): value.decode("utf-8", "replace") for name, value in fields.items()}
    topic = record.fields[b"topic"].decode("utf-8", "replace")
    return Connection(
        topic, header["type"], header["md5sum"], header["message_definition"], header.get("latching") == "1", header.get("callerid", ""), header)


def _give(waiting: List[Tuple[int, int, Connection, bytes]], before: Optional[int]) -> Iterator[Message]:
    """Take those out of what waits that are earlier than a time (ns; None: all), in order."""
    waiting.sort()
    number = len(waiting) if before is None else bisect.bisect_left(waiting, (before,))
    ready = waiting[:number]
    del waiting[:number]
    for time, _, connection, data in ready:
        yield Message(connection.topic, connection, data, time)


def _percent(share: float) -> str:
    return f"{100 * share:.0f} %" if share <= 0.99 else f"{100 * share:.2f} %"


def _after(seconds: Optional[float]) -> str:
    return ", before its first message" if seconds is None else f", after {seconds:.1f} s"


class BagReader:
    """Iterate over it, once, for the Messages of a recording. Made by `read_bag`."""

    def __init__(self, paths: Sequence[str], is_wanted: Callable[[Connection], bool], progress: Optional[Progress]) -> None:
        self._progress = progress
        self._files = [_File(path, is_wanted) for path in paths]

    def __iter__(self) -> Iterator[Message]:
        whole, done = sum(file.size for file in self._files), 0
        told = -whole
        for file in self._files:
            def progress(position):
                nonlocal told
                if self._progress and (done + position - told >= whole * STEP or done + position == whole):
                    told = done + position
                    self._progress(told, whole)

            try:
                yield from file.messages(progress)
            except OSError as error:
                raise BagError(f"{file.path} cannot be read: {error.strerror or error}") from None
            done += file.size

    @property
    def connections(self) -> List[Connection]:
        """Those known so far: of a bag that was closed all, and of others those in what was read."""
        return [connection for file in self._files for connection in file.connections.values()]

    @property
    def closed(self) -> bool:
        """Whether all connections are known from the start, and whether that is all."""
        return all(file.connections for file in self._files)

    @property
    def begin(self) -> Optional[int]:
        """ns: the earliest message so far, wanted or not."""
        return min((file.begin for file in self._files if file.begin is not None), default=None)

    @property
    def end(self) -> Optional[int]:
        """ns: the latest message so far, wanted or not, where the bag did not tell that nothing is wanted around it."""
        return max((file.end for file in self._files if file.end is not None), default=None)

    @property
    def compression(self) -> str:
        """How the first chunk so far is compressed: none, bz2 or lz4; empty before it."""
        return next((file.compression for file in self._files if file.compression), "")

    @property
    def damage(self) -> str:
        """What is missing and where, in sentences, after all was read; empty if nothing is."""
        return " ".join(sentence for file in self._files for sentence in file.damage())


def read_bag(paths: Union[str, Sequence[str]], topics: Union[None, Collection[str], Callable[[Connection], bool]] = None,
             progress: Optional[Progress] = None) -> BagReader:
    """Read a bag, or the parts of one recording in their order.

    Args:
        paths: one file, or several.
        topics: the names of those wanted, or what says of a Connection whether it is; None: all.
        progress: called now and then with the bytes done and all bytes.

    Raises:
        BagError: a file is missing, empty, or no bag. What is damaged in a bag raises nothing: see `BagReader.damage`.
    """
    if topics is None:
        is_wanted = lambda connection: True     # noqa: E731
    elif callable(topics):
        is_wanted = topics
    else:
        names = set(topics)
        is_wanted = lambda connection: connection.topic in names    # noqa: E731
    return BagReader([paths] if isinstance(paths, str) else list(paths), is_wanted, progress)


@functools.lru_cache(maxsize=None)
def _class_of(type_name: str, md5sum: str, definition: str) -> type:
    """The class of messages of a type: the installed one where it is the same, else one made of the definition."""
    import genpy.dynamic
    import roslib.message

    try:
        known = roslib.message.get_message_class(type_name)
    except Exception:   # whatever a broken package raises when it is imported
        known = None
    if known is not None and known._md5sum == md5sum:
        return known
    try:
        return genpy.dynamic.generate_dynamic(type_name, definition)[type_name]
    except Exception as error:  # it parses text of the file
        raise BagError(f"the bag's definition of {type_name} makes no sense: {error}") from None


def message_class(connection: Connection) -> type:
    """The class of the messages of a connection. Raises BagError when the bag's definition of it is damaged."""
    return _class_of(connection.type, connection.md5sum, connection.definition)


def decode(connection: Connection, data: bytes) -> Any:
    """The message in recorded bytes. Raises BagError when they are none."""
    made = message_class(connection)()
    try:
        made.deserialize(data)
    except Exception as error:  # genpy's own, or what struct and codecs raise on its way
        raise BagError(f"a message on {connection.topic} is damaged: {error}") from None
    return made
