"""Read what ``rosbag record`` wrote, front to back, in bounded memory, whole or damaged: `read_bag`.

``rosbag.Bag`` keeps an entry of every message in memory and refuses a bag that was not closed. This keeps little more
than a chunk. Of a bag that was closed it reads the index first, and passes over chunks without a wanted topic; of
another one it reads all that is there. Where bytes are damaged it goes on behind them, and says afterwards what is
missing. The format is in `records`.
"""

import bisect
import functools
import os
import re
from typing import (Any, Callable, Collection, Dict, FrozenSet, Iterator, List, NamedTuple, Optional, Sequence, Set,
                    Tuple, Union)

from .records import (BETWEEN_CHUNKS, BLOCK, CHUNK, CHUNK_INFO, CONNECTION, FIELDS, FILE_HEADER, INDEX, MAGIC, MESSAGE,
                      TIME, U32, U64, BagError, BagRecord, Source, decompressed, fields_of, nanoseconds, next_record,
                      record_at, records, source_of_bytes)

LATE = 10 ** 9
"""ns by which messages may be recorded in the wrong order and are still given in the right one, in a bag without index.
"""
HELD = 1 << 25
"""Bytes of messages kept back at most, to put them in order."""
OVERHEAD = 200
"""Bytes that Python takes for each of them on top."""
TAIL = 1 << 24
"""Bytes at the end in which the index of a bag is, where it is not known; of 100 GB it has about as many."""
LONGEST_ARRAY = 1 << 20
"""Values of an array of fixed length that a definition may have: each message has room for all of them."""
NEVER = 1 << 63
"""ns: later than any message."""
PLACES = 3
"""Damaged places that are told one by one."""

Progress = Callable[[int, int], Any]


class BagConnection(NamedTuple):
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
    connection: BagConnection
    data: bytes
    """as it was sent; `decode` makes a message of it"""
    time: int
    """ns since 1970, or of simulated time: when the recorder got it"""


class _Place(NamedTuple):
    """Bytes of a file that are no records."""

    begin: int
    end: int
    after: Optional[float]
    """s from the first message to the last before it; None before the first"""


class _Chunk(NamedTuple):
    """What the index says of a chunk."""

    start: int
    """ns: its first message"""
    end: int
    earliest: int
    """ns: the first message in it and in all later ones"""
    messages: int
    """in it"""
    foreign: FrozenSet[int]
    """the connections in it, where none of them is wanted; else empty"""


Latched = Dict[Tuple[str, str], bytes]
"""The first latched message by topic and publisher."""


class _Waiting(NamedTuple):
    """A message that is not given yet; sorted as they are given."""

    time: int
    """ns"""
    in_head: bool
    """whether it is in the head of a part"""
    place: int
    """in the file"""
    connection: BagConnection
    data: bytes

    @property
    def size(self) -> int:
        """Bytes that it takes."""
        return len(self.data) + OVERHEAD


class _Queue:
    """Messages that wait until no earlier one can come."""

    def __init__(self) -> None:
        self._waiting: List[_Waiting] = []
        self._size = self._count = 0

    def add(self, time: int, in_head: bool, connection: BagConnection, data: bytes) -> None:
        self._count += 1
        entry = _Waiting(time, in_head, self._count, connection, data)
        self._waiting.append(entry)
        self._size += entry.size

    def overflow(self) -> List[_Waiting]:
        """The earlier half where they are more than `HELD`; else none."""
        return self._take(lambda: len(self._waiting) // 2) if self._size > HELD else []

    def before(self, time: int) -> List[_Waiting]:
        """Those that are earlier."""
        return self._take(lambda: bisect.bisect_left(self._waiting, (time,)))

    def rest(self) -> List[_Waiting]:
        return self._take(lambda: len(self._waiting))

    def _take(self, number: Callable[[], int]) -> List[_Waiting]:
        """Take so many out of those that wait, which are sorted before they are counted."""
        self._waiting.sort()
        count = number()
        taken, self._waiting = self._waiting[:count], self._waiting[count:]
        self._size -= sum(entry.size for entry in taken)
        return taken


class _Head:
    """The first messages of a part, as long as they can be those that ``rosbag record --repeat-latched`` repeats there.

    rosbag begins a part with the first message (not the newest) of each publisher that latches, all with the time of
    that moment. Then comes the message for which it began the part; that one waited, so its time is earlier. In the
    repeated ones' connections rosbag 1.15 leaves out who published and that it latches; 1.17 keeps both. (Seen with
    1.15.15 and 1.17.0.)

    Attributes:
        open: whether the next message may still be one of them.
        repeats: whether what came after them, if anything did, fits to that.
    """

    def __init__(self) -> None:
        self.open, self.repeats = True, True
        self._first: Optional[Tuple[int, bool]] = None      # message: its time, and whether its publisher is named
        self._publishers: Set[Tuple[str, str]] = set()

    def takes(self, time: int, connection: BagConnection) -> bool:
        """Whether a message is in the head. Called with all messages of the part, in their order in the file.

        Args:
            time: ns.
            connection: of the message.
        """
        if not self.open:
            return False
        alike, publisher = (time, bool(connection.caller)), (connection.topic, connection.caller)
        self._first = self._first or alike
        may_be_repeated = not connection.caller or connection.latching and publisher not in self._publishers
        self.open = alike == self._first and may_be_repeated
        self._publishers.add(publisher)
        self.repeats = self.open or time <= self._first[0]
        return self.open


class _File:
    """One file of a recording."""

    def __init__(self, path: str, is_wanted: Callable[[BagConnection], bool]) -> None:
        self.path = path
        self.connections: Dict[int, BagConnection] = {}
        self.compression = ""
        self._begin, self._end = NEVER, -1          # ns, of the messages so far
        self.indexed = False        # with an index that is whole
        self._is_wanted = is_wanted
        self._wanted: Dict[int, bool] = {}
        self._chunks: Dict[int, _Chunk] = {}    # by position
        self._first = len(MAGIC)                # record
        self._index = 0                         # where it begins; 0 where the recorder did not close the bag
        self._searched: Collection[int] = FIELDS
        self._places: List[_Place] = []
        self._missing = 0           # messages that are listed behind their chunk, but were not in it
        self._nameless = 0          # messages of connections that are not described
        self._ambiguous: Set[str] = set()       # topics that are described in two ways
        self._head: Optional[_Head] = None      # while a part is read
        try:
            with open(path, "rb", buffering=0) as file:
                self.size = os.fstat(file.fileno()).st_size
                self._look(_source_of(file, self.size))
        except FileNotFoundError:
            raise BagError("%s: no such file" % path) from None
        except OSError as error:
            raise BagError("%s cannot be read: %s" % (path, error.strerror or error)) from None

    def _look(self, source: Source) -> None:
        """Whether it is a bag, and what its index says."""
        magic = source.get(0, len(MAGIC))
        if not magic:
            raise BagError("%s is empty (0 bytes): its recorder wrote nothing, or the disk was full" % self.path)
        if magic.startswith(b"#ROSBAG V1."):
            raise BagError("%s is a bag of the old format %s; only 2.0 is read. "
                           "To make one of it: rosbag filter OLD.bag NEW.bag True"
                           % (self.path, magic[9:12].decode("ascii", "replace")))
        if magic != MAGIC:
            self._first = next_record(source_of_bytes(source.get(0, BLOCK)), 0)
            if self._first >= min(self.size, BLOCK):
                raise BagError("%s is not a bag, or nothing is left of it: it does not begin with %s"
                               % (self.path, MAGIC.decode().strip()))
            self._damaged(0, self._first)
        chunk = record_at(source, next_record(source, self._first, (CHUNK,)))
        if chunk is not None:
            self.compression = chunk.fields[b"compression"].decode()
            self._searched = BETWEEN_CHUNKS if chunk.compressed else FIELDS
        self._look_for_index(source, record_at(source, self._first))
        if not self.indexed:
            self._read_tail(source)

    def _look_for_index(self, source: Source, head: Optional[BagRecord]) -> None:
        """Read the index, where the first record says that there is one."""
        if head is None or head.op != FILE_HEADER:
            return
        if head.fields.get(b"encryptor", b"") not in (b"", b"rosbag/NoEncryptor"):
            raise BagError("%s is encrypted. To make a bag of it that can be read: rosbag decrypt" % self.path)
        self._index, = U64.unpack(head.fields[b"index_pos"])
        if 0 < self._index <= self.size:
            self._read_index(source, *(U32.unpack(head.fields[name])[0] for name in (b"conn_count", b"chunk_count")))

    def _read_index(self, source: Source, connection_count: int, chunk_count: int) -> None:
        """Learn of all connections and chunks, unless something there is damaged or missing."""
        connections: Dict[int, Optional[BagConnection]] = {}
        chunks: Dict[int, _Chunk] = {}
        bad: List[int] = []
        # most chunks have the same connections: one set for all of them
        same: Dict[FrozenSet[int], FrozenSet[int]] = {}
        for record in records(source, self._index, lambda chunk: True, lambda begin, end: bad.append(begin)):
            if record.op == CONNECTION:
                connections[record.connection] = _connection(record, source.data(record))
            elif record.op == CHUNK_INFO:
                # by connection
                counts: Dict[int, int] = {number: count for number, count in TIME.iter_unpack(source.data(record))}
                inside = same.setdefault(frozenset(counts), frozenset(counts))
                position, = U64.unpack(record.fields[b"chunk_pos"])
                start, end = nanoseconds(record.fields[b"start_time"]), nanoseconds(record.fields[b"end_time"])
                chunks[position] = _Chunk(start, end, start, sum(counts.values()), inside)
            else:
                return
        if bad or None in connections.values() or (len(connections), len(chunks)) != (connection_count, chunk_count):
            return
        self.indexed = True
        for number, connection in connections.items():
            self._know(number, connection)
        earliest = NEVER
        for position in sorted(chunks, reverse=True):
            chunk = chunks[position]
            earliest = min(chunk.start, earliest)
            wanted = any(self._wanted.get(number, True) for number in chunk.foreign)
            self._chunks[position] = chunk._replace(earliest=earliest, foreign=frozenset() if wanted else chunk.foreign)

    def _read_tail(self, source: Source) -> None:
        """Learn of the connections at the end of the file, where there is no whole index."""
        position = next_record(source, max(self._first, self.size - TAIL), (CONNECTION,))
        for record in records(source, position, lambda chunk: True, lambda begin, end: None, (CONNECTION, CHUNK_INFO)):
            if record.op == CONNECTION:
                self._know(record.connection, _connection(record, source.data(record)))

    def _know(self, number: int, connection: Optional[BagConnection]) -> None:
        if connection is None:
            return
        if self.connections.setdefault(number, connection) != connection:
            self._ambiguous.add(self.connections[number].topic)
        elif number not in self._wanted:
            self._wanted[number] = bool(self._is_wanted(connection))

    @property
    def begin(self) -> Optional[int]:
        """ns: the earliest message so far; None before the first."""
        return None if self._end < 0 else self._begin

    @property
    def end(self) -> Optional[int]:
        """ns: the latest message so far; None before the first."""
        return None if self._end < 0 else self._end

    @property
    def _seconds(self) -> Optional[float]:
        """From the earliest message so far to the latest; None before the first."""
        return None if self._end < 0 else (self._end - self._begin) / 1e9

    def _saw(self, time: int) -> None:
        self._begin, self._end = min(self._begin, time), max(self._end, time)

    def _damaged(self, begin: int, end: int) -> None:
        if self._places and begin <= self._places[-1].end:
            self._places[-1] = self._places[-1]._replace(end=max(end, self._places[-1].end))
        else:
            self._places.append(_Place(begin, end, self._seconds))

    def _passes_over(self, source: Source, chunk: BagRecord) -> bool:
        """Whether nothing in a chunk is wanted.

        The index and the lists behind the chunk must both say so: then one wrong byte loses no chunk. While the head
        of a part may go on, all chunks are read.
        """
        known = self._chunks.get(chunk.position)
        if known is None or not known.foreign or self._head is not None and self._head.open:
            return False
        return known.foreign == _listed(source, chunk.end)

    def messages(self, progress: Callable[[int], Any], latched: Optional[Latched] = None) -> Iterator[Message]:
        """The wanted messages in order of time, as far as `LATE` and `HELD` allow.

        Args:
            progress: called now and then with the bytes read.
            latched: of a part of a recording, what was latched in the parts before. What the recorder only repeats of
                it is left out, and what is new is added to it. None: this is no part.
        """
        queue = _Queue()
        self._head = None if latched is None else _Head()
        met = listed = 0
        known: Optional[_Chunk] = None
        passed = False
        with open(self.path, "rb", buffering=0) as file:
            for source, record in self._contents(_source_of(file, self.size)):
                if record.op == MESSAGE:
                    met += 1
                    # else a byte of it is wrong
                    if known is None or known.start <= record.time <= known.end or self._end < 0:
                        self._saw(record.time)
                    wanted = self._wanted.get(record.connection)
                    if wanted is None:
                        self._nameless += 1
                        continue
                    connection = self.connections[record.connection]
                    in_head = self._head is not None and self._head.takes(record.time, connection)
                    if wanted:
                        queue.add(record.time, in_head, connection, source.data(record))
                        yield from self._news(queue.overflow(), latched)
                elif record.op == CONNECTION:
                    self._know(record.connection, _connection(record, source.data(record)))
                elif record.op == INDEX:
                    listed += record.entries
                elif record.op == CHUNK:
                    self._missing += _missing(known, passed, listed, met)
                    met = listed = 0
                    progress(record.position)
                    known, passed = self._chunks.get(record.position), self._passes_over(source, record)
                    if known is not None and passed:
                        self._saw(known.start)
                        self._saw(known.end)
                    earliest = max(self._end, 0) - LATE if known is None else known.earliest
                    yield from self._news(queue.before(earliest), latched)
            yield from self._news(queue.rest(), latched)
        self._missing += _missing(known, passed, listed, met)
        progress(self.size)

    def _news(self, ready: List[_Waiting], latched: Optional[Latched]) -> Iterator[Message]:
        """Messages without those that are only repeated."""
        for time, in_head, _, connection, data in ready:
            if in_head and self._head is not None and self._head.repeats and _is_known(connection, data, latched or {}):
                continue
            if latched is not None and connection.latching:
                latched.setdefault((connection.topic, connection.caller), data)
            yield Message(connection.topic, connection, data, time)

    def _contents(self, source: Source) -> Iterator[Tuple[Source, BagRecord]]:
        """All records and where their data are, those in chunks too, but for chunks in which nothing is wanted."""

        def passes_over(chunk: BagRecord) -> bool:
            return self._passes_over(source, chunk)

        for record in records(source, self._first, passes_over, self._damaged, self._searched):
            yield source, record
            if record.compressed and not passes_over(record):
                data = decompressed(source, record)
                bad: List[int] = []
                inner = source_of_bytes(data)
                for entry in records(inner, 0, passes_over, lambda begin, end: bad.append(begin)):
                    yield inner, entry
                if bad or len(data) != U32.unpack(record.fields[b"size"])[0]:
                    self._damaged(record.begin, record.end)

    def damage(self) -> str:
        """What is missing, in sentences, after all was read; of a bag called "it"."""
        index = self._index if 0 < self._index < self.size else self.size
        places = [place for place in self._places if place.begin < index]
        cut = bool(places) and places[-1].end == self.size
        inner = places[:-1] if cut else places
        sentences = [
            "it is damaged at %s of the file%s: %s bytes there are no messages"
            % (_percent(place.begin / self.size), _after(place.after), place.end - place.begin)
            for place in inner[:PLACES]]
        if len(inner) > PLACES:
            sentences.append("so it is at %s" % plural(len(inner) - PLACES, "more place"))
        if self._missing:
            sentences.append("%s that it lists could not be read" % plural(self._missing, "message"))
        if self._nameless:
            sentences.append("%s cannot be understood: the description of the topic is lost"
                             % plural(self._nameless, "message"))
        sentences += ["it describes %s in two ways, of which one must be wrong" % topic
                      for topic in sorted(self._ambiguous)]
        if not self.indexed:
            sentences.append(self._ending(cut))
        return "; ".join(sentences)

    def _ending(self, cut: bool) -> str:
        """How a bag ends whose index is not whole."""
        seconds = "before its first message" if self._seconds is None else "after %.1f s" % self._seconds
        if self._index > self.size:
            return ("it is cut off %s, at %s of its length: the rest is missing"
                    % (seconds, _percent(self.size / self._index)))
        if self._index:
            return ("its index is damaged or cut off: all messages before it are there, but rosbag wants it mended "
                    "(rosbag reindex)")
        if cut:
            return ("it was not closed and ends within a message %s: its recorder was killed, or the disk was full"
                    % seconds)
        return "it was not closed and ends %s: its recorder was killed, or still records" % seconds


def _source_of(file: Any, size: int) -> Source:
    def read_at(position: int, length: int) -> bytes:
        try:
            return os.pread(file.fileno(), length, position)
        except OSError:     # a disk that has lost some bytes, and what lies behind them is to be read
            return bytes(min(length, size - position))

    return Source(read_at, size)


def _listed(source: Source, position: int) -> Set[int]:
    """The connections in the lists of messages that stand behind a chunk."""
    found = set()
    record = record_at(source, position)
    while record is not None and record.op == INDEX:
        found.add(record.connection)
        record = record_at(source, record.end)
    return found


def _missing(chunk: Optional[_Chunk], passed: bool, listed: int, met: int) -> int:
    """How many messages of a chunk were not there, by the index or else by the lists behind it."""
    return 0 if passed else max(0, (listed if chunk is None else chunk.messages) - met)


def _is_known(connection: BagConnection, data: bytes, latched: Latched) -> bool:
    """Whether this was the first latched message of its publisher; of an unknown publisher, of any of the topic."""
    if connection.caller:
        return latched.get((connection.topic, connection.caller)) == data
    return any(topic == connection.topic and first == data for (topic, _), first in latched.items())


def _connection(record: BagRecord, data: bytes) -> Optional[BagConnection]:
    """The BagConnection of a record and its data; None if they make none."""
    fields = fields_of(data)
    if not fields or not {b"type", b"md5sum", b"message_definition"} <= set(fields):
        return None
    header = {name.decode("utf-8", "replace"): value.decode("utf-8", "replace") for name, value in fields.items()}
    topic = record.fields[b"topic"].decode("utf-8", "replace")
    return BagConnection(
        topic, header["type"], header["md5sum"], header["message_definition"], header.get("latching") == "1",
        header.get("callerid", ""), header)


def plural(count: int, what: str) -> str:
    """1 message, 2 messages."""
    return "%s %s%s" % (count, what, "s" * (count != 1))


def _percent(share: float) -> str:
    return "%.0f %%" % (100 * share) if share <= 0.99 else "%.2f %%" % (100 * share)


def _after(seconds: Optional[float]) -> str:
    return ", before its first message" if seconds is None else ", after %.1f s" % seconds


class BagReader:
    """Iterate over it, once, for the Messages of a recording. Made by `read_bag`."""

    def __init__(self, paths: Sequence[str], is_wanted: Callable[[BagConnection], bool],
                 progress: Progress) -> None:
        self._progress = progress
        self._files: List[_File] = []
        self._refused: List[str] = []
        self._several = len(paths) > 1
        for path in paths:
            try:
                self._files.append(_File(path, is_wanted))
            except BagError as error:
                if len(paths) == 1 or not os.path.exists(path):
                    raise
                self._refused.append(str(error))    # the other parts are there
        if not self._files:
            raise BagError(" ".join(self._refused) or "no bag is named")

    def __iter__(self) -> Iterator[Message]:
        whole, done = sum(file.size for file in self._files), 0
        latched: Optional[Latched] = {} if self._several else None
        for file in self._files:
            try:
                yield from file.messages(lambda position: self._progress(done + position, whole), latched)
            except OSError as error:
                raise BagError("%s cannot be read: %s" % (file.path, error.strerror or error)) from None
            done += file.size

    @property
    def connections(self) -> List[BagConnection]:
        """Those known so far: of a bag that was closed all, and of others those in what was read."""
        return [connection for file in self._files for connection in file.connections.values()]

    @property
    def indexed(self) -> bool:
        """Whether all parts were closed and their indices are whole: then `connections` has all from the start."""
        return all(file.indexed for file in self._files)

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
        """What is missing and where, in a sentence, after all was read; empty if nothing is. A single bag is "it"."""
        told = [(os.path.basename(file.path) + ": ") * self._several + file.damage()
                for file in self._files if file.damage()]
        return "; ".join(told + self._refused) + "." if told or self._refused else ""


def read_bag(paths: Union[str, Sequence[str]],
             topics: Union[None, Collection[str], Callable[[BagConnection], bool]] = None,
             progress: Progress = lambda done, total: None) -> BagReader:
    """Read a bag, or the parts of one recording in their order.

    Args:
        paths: one file, or several; of several, what the recorder only repeated at the begin of a part is passed over.
        topics: the names of those wanted, or what says of a BagConnection whether it is; None: all.
        progress: called with the bytes done and all bytes, for each chunk.

    Raises:
        BagError: a file is missing, empty, or no bag. What is damaged in a bag raises nothing: see `BagReader.damage`.
    """
    paths = [paths] if isinstance(paths, str) else list(paths)
    if callable(topics):
        return BagReader(paths, topics, progress)
    names = None if topics is None else set(topics)
    return BagReader(paths, lambda connection: names is None or connection.topic in names, progress)


def _check_arrays(definition: str) -> None:
    """Whether messages have no more values than they have bytes, or not many more. Raises ValueError."""
    if any(int(length) > LONGEST_ARRAY for length in re.findall(r"\[(\d+)\]", definition)):
        raise ValueError("an array in it is too long")
    for part in re.split("^=+$", definition, flags=re.MULTILINE):
        name = re.match(r"\s*MSG:\s*(?:\S+/)?(\S+)", part)
        lines = [line.split("#")[0] for line in part.splitlines() if not line.strip().startswith("MSG:")]
        if name and not any(line.strip() and "=" not in line
                            for line in lines) and re.search(r"\b%s\[" % re.escape(name[1]), definition):
            raise ValueError("it has an array of %s, which is nothing, and so as long as it says" % name[1])


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
        _check_arrays(definition)
        return genpy.dynamic.generate_dynamic(type_name, definition)[type_name]
    except Exception as error:  # it parses text of the file
        raise BagError("the bag's definition of %s makes no sense: %s" % (type_name, error)) from None


def message_class(connection: BagConnection) -> type:
    """The class of the messages of a connection. Raises BagError when the bag's definition of it is damaged."""
    return _class_of(connection.type, connection.md5sum, connection.definition)


def decode(connection: BagConnection, data: bytes, into: Any = None) -> Any:
    """The message in recorded bytes, in a new one or into one of the class. Raises BagError when they are none."""
    made = message_class(connection)() if into is None else into
    try:
        made.deserialize(data)
    except Exception as error:  # genpy's own, or what struct and codecs raise on its way
        raise BagError("a message on %s is damaged: %s" % (connection.topic, error)) from None
    return made
