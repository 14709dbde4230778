"""Read what ``rosbag record`` wrote, front to back, in bounded memory, whole or damaged: `read_bag`.

``rosbag.Bag`` keeps an entry of every message in memory and refuses a bag that was not closed. This reader keeps little
more than a chunk. In a bag that was closed it reads the index first, and passes over chunks without a wanted topic. In
any other bag it reads all that is there. Where bytes are damaged it goes on behind them, and says afterwards what is
missing. The format is in `records`.
"""

import contextlib
import functools
import heapq
import itertools
import os
import re
from typing import (Any, Callable, Collection, Counter, Dict, Iterable, Iterator, List, NamedTuple,
                    Optional, Sequence, Set, Tuple, Union)

from .records import (BETWEEN_CHUNKS, BLOCK, CHUNK, CHUNK_INFO, CONNECTION, FIELDS, FILE_HEADER, INDEX, MAGIC, MESSAGE,
                      TIME, U32, U64, BagError, BagRecord, Source, decompressed, fields_of, nanoseconds, next_record,
                      record_at, records, source_of_bytes)

LATE = 10 ** 9
"""ns by which a message may be recorded too late in a bag without index; it is still given in the right order."""
HELD = 1 << 25
"""Bytes of messages kept back at most, to put them in order."""
OVERHEAD = 200
"""Bytes that Python takes for each of them on top."""
TAIL = 1 << 24
"""Bytes at the end of a file in which its index is looked for, where its place is not known. A bag of 100 GB has an
index about as long."""
LONGEST_ARRAY = 1 << 20
"""Values of an array of fixed length that a definition may have: each message has room for all of them."""
NEVER = 1 << 63
"""ns: later than any message."""
PLACES = 3
"""Damaged places that are told one by one."""

Progress = Callable[[int, int], Any]
Latched = Dict[Tuple[str, str], bytes]
"""The first latched message by topic and publisher."""


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
    """Bytes of a file that hold no records."""

    begin: int
    end: int
    when: str
    """how far the run had come there, in words"""


class _Chunk(NamedTuple):
    """What the index says of a chunk."""

    start: int
    """ns: its first message"""
    end: int
    """ns: its last message"""
    messages: int
    """how many are in it"""
    foreign: bool
    """whether nothing in it is wanted"""
    earliest: int
    """ns: the first message in it and in all later chunks"""


class _Head:
    """The first messages of a part, as long as they can be those that ``rosbag record --repeat-latched`` repeats there.

    rosbag begins a part with the first message (not the newest) of each publisher that latches, all with the time of
    that moment. Then comes the message for which it began the part. That one waited, so its time is earlier. In the
    connections of the repeated messages rosbag 1.15 leaves out who published, and that it latches; 1.17 keeps both.
    (Seen with 1.15.15 and 1.17.0.)

    Args:
        is_part: whether the file is one of several parts; a bag alone has no head.

    Attributes:
        open: whether the next message may still belong to the head.
        repeats: whether the first message behind the head, if there is one, is as early as rosbag's would be.
    """

    def __init__(self, is_part: bool) -> None:
        self.open, self.repeats = is_part, True
        self._first: Optional[Tuple[int, bool]] = None      # message: its time, and whether its publisher is named
        self._publishers: Set[Tuple[str, str]] = set()

    def takes(self, time: int, connection: BagConnection) -> bool:
        """Whether a message is in the head. Called with all messages of the part in their order, as long as it is open.

        Args:
            time: of the message, ns.
            connection: of the message.
        """
        alike, publisher = (time, bool(connection.caller)), (connection.topic, connection.caller)
        self._first = self._first or alike
        may_be_repeated = not connection.caller or connection.latching and publisher not in self._publishers
        self.open = alike == self._first and may_be_repeated
        self._publishers.add(publisher)
        self.repeats = self.open or time <= self._first[0]
        return self.open


class _Queue:
    """Messages of a file that wait until no earlier one can come. Those that the recorder only repeats are left out.

    Args:
        head: of the file.
        latched: what was latched in the parts before. What is new is added to it.

    Attributes:
        size: bytes that the messages take.
    """

    def __init__(self, head: _Head, latched: Latched) -> None:
        self._head, self._latched = head, latched
        # a heap, by time; of one time those in the head of a part come last, and the others as they came
        self._waiting: List[Tuple[int, bool, int, Message]] = []
        self.size, self._numbers = 0, itertools.count()

    def add(self, message: Message, in_head: bool) -> None:
        """Let a message wait. `in_head`: whether it is in the head of a part."""
        heapq.heappush(self._waiting, (message.time, in_head, next(self._numbers), message))
        self.size += len(message.data) + OVERHEAD

    def take(self, before: int) -> Iterator[Message]:
        """Messages before a time (ns), and as many more as are too much to keep."""
        while self._waiting and (self._waiting[0][0] < before or self.size > HELD):
            _, in_head, _, message = heapq.heappop(self._waiting)
            _, connection, data, _ = message
            self.size -= len(data) + OVERHEAD
            if not (in_head and self._head.repeats and _is_known(connection, data, self._latched)):
                if connection.latching:
                    self._latched.setdefault((connection.topic, connection.caller), data)
                yield message


class _File:
    """One file of a recording.

    Args:
        path: of the file.
        is_wanted: whether the messages of a connection are to be read.
        is_part: whether it is one of several parts.

    Attributes:
        begin: ns, the earliest message so far; `NEVER` before the first.
        end: ns, the latest message so far; -1 before the first.
        compression: of the first chunk; empty without one.
        indexed: whether the file has an index that is whole.

    Raises:
        BagError: it cannot be read, or is not a bag.
    """

    def __init__(self, path: str, is_wanted: Callable[[BagConnection], Any], is_part: bool) -> None:
        self.path = path
        self.connections: Dict[int, BagConnection] = {}
        self.compression, self.indexed = "", False
        self.begin, self.end = NEVER, -1
        self._is_wanted = is_wanted
        self._unwanted: Set[int] = set()        # connections
        self._chunks: Dict[int, _Chunk] = {}    # by position
        self._first = len(MAGIC)                # record
        self._index = 0                         # where it begins; 0 where the recorder did not close the bag
        self._searched: Collection[int] = FIELDS
        self._places: List[_Place] = []
        self._missing = 0           # messages that are listed behind their chunk, but were not in it
        self._nameless = 0          # messages of connections that are not described
        self._ambiguous: Set[str] = set()       # topics that are described in two ways
        self._head = _Head(is_part)
        with _opened(path) as source:
            self.size = source.size
            self._look(source)

    def _look(self, source: Source) -> None:
        """Check that the file is a bag, and learn what its index says."""
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
        head = record_at(source, self._first)
        if head is not None and head.op == FILE_HEADER:
            if head.fields.get(b"encryptor", b"") not in (b"", b"rosbag/NoEncryptor"):
                raise BagError("%s is encrypted. To make a bag of it that can be read: rosbag decrypt" % self.path)
            self._index, = U64.unpack(head.fields[b"index_pos"])
            if 0 < self._index <= self.size:
                self._read_index(source, head)
        if not self.indexed:
            self._read_tail(source)

    def _read_index(self, source: Source, head: BagRecord) -> None:
        """Learn of all connections, and of all chunks unless something in the index is damaged or missing.

        Args:
            source: of the file.
            head: its first record, which says how many of each the index has.
        """
        described: Set[int] = set()
        chunks: Dict[int, _Chunk] = {}
        bad: List[int] = []
        for record in records(source, self._index, damaged=lambda begin, end: bad.append(begin)):
            if record.op == CONNECTION and self._know(record, source.data(record)):
                described.add(record.connection)
            elif record.op == CHUNK_INFO:
                counts: List[Tuple[int, ...]] = list(TIME.iter_unpack(source.data(record)))     # connection, messages
                position, = U64.unpack(record.fields[b"chunk_pos"])
                start, end = nanoseconds(record.fields[b"start_time"]), nanoseconds(record.fields[b"end_time"])
                foreign = bool(counts) and all(number in self._unwanted for number, _ in counts)
                chunks[position] = _Chunk(start, end, sum(count for _, count in counts), foreign, start)
            else:
                return
        expected = [U32.unpack(head.fields[name])[0] for name in (b"conn_count", b"chunk_count")]
        if not bad and [len(described), len(chunks)] == expected:
            self.indexed = True
            backwards = sorted(chunks, reverse=True)
            earliest: Iterable[int] = itertools.accumulate((chunks[position].start for position in backwards), min)
            self._chunks = {position: chunks[position]._replace(earliest=first)
                            for position, first in zip(backwards, earliest)}

    def _read_tail(self, source: Source) -> None:
        """Learn of the connections at the end of the file, where there is no whole index."""
        position = next_record(source, max(self._first, self.size - TAIL), (CONNECTION,))
        for record in records(source, position, searched=(CONNECTION, CHUNK_INFO)):
            if record.op == CONNECTION:
                self._know(record, source.data(record))

    def _know(self, record: BagRecord, data: bytes) -> bool:
        """Learn of a connection, by its record and the data of that; returns whether they describe one."""
        fields = {name.decode("utf-8", "replace"): value.decode("utf-8", "replace")
                  for name, value in fields_of(data).items()}
        if not {"type", "md5sum", "message_definition"} <= set(fields):
            return False
        found = BagConnection(
            record.fields[b"topic"].decode("utf-8", "replace"), fields["type"], fields["md5sum"],
            fields["message_definition"], fields.get("latching") == "1", fields.get("callerid", ""), fields)
        known = self.connections.setdefault(record.connection, found)
        if known != found:
            self._ambiguous.add(known.topic)
        elif not self._is_wanted(found):
            self._unwanted.add(record.connection)
        return True

    def _moment(self) -> str:
        """How far the run has come, in words."""
        return "before its first message" if self.end < 0 else "after %.1f s" % ((self.end - self.begin) / 1e9)

    def _saw(self, first: int, last: int) -> None:
        """Take note of messages from one time to another (ns)."""
        self.begin, self.end = min(self.begin, first), max(self.end, last)

    def _damaged(self, begin: int, end: int) -> None:
        """Take note of bytes that hold no records."""
        if self._places and begin <= self._places[-1].end:
            self._places[-1] = self._places[-1]._replace(end=max(end, self._places[-1].end))
        else:
            self._places.append(_Place(begin, end, self._moment()))

    def _passes_over(self, source: Source, chunk: BagRecord) -> bool:
        """Whether nothing in a chunk is wanted.

        The index and the lists behind the chunk must both say so: then one wrong byte loses no chunk. While the head
        of a part may go on, all chunks are read.
        """
        known = self._chunks.get(chunk.position)
        if known is None or not known.foreign or self._head.open:
            return False
        lists = itertools.takewhile(lambda record: record.op == INDEX, records(source, chunk.end))
        listed = {record.connection for record in lists}
        return bool(listed) and listed <= self._unwanted

    def messages(self, progress: Callable[[int], Any], latched: Latched) -> Iterator[Message]:
        """The wanted messages in order of time, as far as `LATE` and `HELD` allow.

        Args:
            progress: called now and then with the bytes read.
            latched: what was latched in the parts before. What the recorder only repeats of it is left out, and what
                is new is added to it.
        """
        queue = _Queue(self._head, latched)
        met = expected = earliest = 0   # met, expected: messages of the chunk that were there, and should have been
        known: Optional[_Chunk] = None
        with _opened(self.path) as file:
            for source, record in self._contents(file):
                if record.op == MESSAGE:
                    met += 1
                    # a time that is not in its chunk has a wrong byte
                    if known is None or known.start <= record.time <= known.end or self.end < 0:
                        self._saw(record.time, record.time)
                    connection = self.connections.get(record.connection)
                    if connection is None:
                        self._nameless += 1
                        continue
                    in_head = self._head.open and self._head.takes(record.time, connection)
                    if record.connection not in self._unwanted:
                        queue.add(Message(connection.topic, connection, source.data(record), record.time), in_head)
                elif record.op == CONNECTION:
                    self._know(record, source.data(record))
                elif record.op == INDEX and known is None:
                    expected += record.entries
                elif record.op == CHUNK:
                    self._missing += max(0, expected - met)
                    met = expected = 0
                    progress(record.position)
                    known = self._chunks.get(record.position)
                    if known is not None and self._passes_over(source, record):
                        self._saw(known.start, known.end)
                    elif known is not None:
                        expected = known.messages
                    earliest = max(self.end, 0) - LATE if known is None else known.earliest
                if record.op == CHUNK or queue.size > HELD:
                    yield from queue.take(earliest)
            yield from queue.take(NEVER)
        self._missing += max(0, expected - met)
        progress(self.size)

    def _contents(self, source: Source) -> Iterator[Tuple[Source, BagRecord]]:
        """All records, each with the source that has its data.

        The records in chunks are among them, except in chunks in which nothing is wanted.
        """
        for record in records(source, self._first, self._passes_over, self._damaged, self._searched):
            yield source, record
            if record.compressed and not self._passes_over(source, record):
                bad: List[int] = []
                inner = source_of_bytes(decompressed(source, record))
                for entry in records(inner, 0, damaged=lambda begin, end: bad.append(begin)):
                    yield inner, entry
                if bad or inner.size != U32.unpack(record.fields[b"size"])[0]:
                    self._damaged(record.begin, record.end)

    def damage(self) -> str:
        """What is missing, in sentences that call the bag "it". To be asked after all was read."""
        index = self._index if 0 < self._index < self.size else self.size
        places = [place for place in self._places if place.begin < index]
        cut = bool(places) and places[-1].end == self.size
        inner = places[:-1] if cut else places
        sentences = [
            "it is damaged at %s of the file, %s: %s bytes there are no messages"
            % (_percent(place.begin / self.size), place.when, place.end - place.begin) for place in inner[:PLACES]]
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
        if self._index > self.size:
            return ("it is cut off %s, at %s of its length: the rest is missing"
                    % (self._moment(), _percent(self.size / self._index)))
        if self._index:
            return ("its index is damaged or cut off: all messages before it are there, but rosbag wants it mended "
                    "(rosbag reindex)")
        return ("it was not closed and ends within a message %s: its recorder was killed, or the disk was full" if cut
                else "it was not closed and ends %s: its recorder was killed, or still records") % self._moment()


@contextlib.contextmanager
def _opened(path: str) -> Iterator[Source]:
    """A file whose bytes can be read. What the disk has lost of it is zeros: what lies behind is to be read.

    Raises:
        BagError: it cannot be read.
    """
    def read_at(position: int, length: int) -> bytes:
        try:
            return os.pread(file.fileno(), length, position)
        except OSError:
            return bytes(min(length, size - position))

    try:
        with open(path, "rb", buffering=0) as file:
            size = os.fstat(file.fileno()).st_size
            yield Source(read_at, size)
    except FileNotFoundError:
        raise BagError("%s: no such file" % path) from None
    except OSError as error:
        raise BagError("%s cannot be read: %s" % (path, error.strerror or error)) from None


def _is_known(connection: BagConnection, data: bytes, latched: Latched) -> bool:
    """Whether data are the first latched message of a publisher; where it is unknown, of any publisher of the topic."""
    return any(topic == connection.topic and caller == (connection.caller or caller) and first == data
               for (topic, caller), first in latched.items())


def plural(count: int, what: str) -> str:
    """1 message, 2 messages."""
    return "%s %s%s" % (count, what, "s" * (count != 1))


def _percent(share: float) -> str:
    return "%.0f %%" % (100 * share) if share <= 0.99 else "%.2f %%" % (100 * share)


class BagReader:
    """Iterate over it, or over `decoded`, once, for the messages of a recording. Made by `read_bag`.

    Attributes:
        undecoded: how many messages `decoded` has left out so far, by topic.
    """

    def __init__(self, paths: Sequence[str], is_wanted: Callable[[BagConnection], Any], progress: Progress) -> None:
        self.undecoded: Counter[str] = Counter()
        self._progress = progress
        self._files: List[_File] = []
        self._refused: List[str] = []
        self._several = len(paths) > 1
        for path in paths:
            try:
                self._files.append(_File(path, is_wanted, self._several))
            except BagError as error:
                if not self._several or not os.path.exists(path):
                    raise
                self._refused.append(str(error))    # the other parts are there
        if not self._files:
            raise BagError(" ".join(self._refused) or "no bag is named")

    def __iter__(self) -> Iterator[Message]:
        whole, done = sum(file.size for file in self._files), 0
        latched: Latched = {}
        for file in self._files:
            yield from file.messages(lambda position: self._progress(done + position, whole), latched)
            done += file.size

    def decoded(self) -> Iterator[Tuple[BagConnection, Any, int]]:
        """All messages that make sense, each with its connection and the time (ns) when the recorder got it."""
        for _, connection, data, time in self:
            try:
                message = decode(connection, data)
            except BagError:
                self.undecoded[connection.topic] += 1
            else:
                yield connection, message, time

    @property
    def connections(self) -> List[BagConnection]:
        """Those that are known so far: all of a bag that was closed; of another one, those in what was read."""
        return [connection for file in self._files for connection in file.connections.values()]

    @property
    def indexed(self) -> bool:
        """Whether all parts were closed and their indices are whole: then `connections` has all from the start."""
        return all(file.indexed for file in self._files)

    @property
    def begin(self) -> Optional[int]:
        """ns: the earliest message so far, wanted or not; None before the first."""
        return min((file.begin for file in self._files if file.end >= 0), default=None)

    @property
    def end(self) -> Optional[int]:
        """ns: the latest message so far, wanted or not; None before the first.

        Of parts of a bag in which nothing is wanted, it is what the index says.
        """
        return max((file.end for file in self._files if file.end >= 0), default=None)

    @property
    def compression(self) -> str:
        """How the first chunk so far is compressed: none, bz2 or lz4; empty before it."""
        return next((file.compression for file in self._files if file.compression), "")

    @property
    def damage(self) -> str:
        """What is missing and where, in a sentence that calls a single bag "it"; empty if nothing is missing.

        To be asked after all was read.
        """
        told = [(os.path.basename(file.path) + ": ") * self._several + file.damage()
                for file in self._files if file.damage()] + self._refused
        return "; ".join(told) + "." if told else ""


def read_bag(paths: Union[str, Sequence[str]], is_wanted: Callable[[BagConnection], Any] = lambda connection: True,
             progress: Progress = lambda done, total: None) -> BagReader:
    """Read a bag, or the parts of one recording in their order.

    Args:
        paths: one file, or several; of several, what the recorder only repeated at the begin of a part is passed over.
        is_wanted: whether the messages of a connection are wanted; of all unless it is given.
        progress: called with the bytes done and all bytes, for each chunk.

    Raises:
        BagError: a file is missing, empty, or not a bag. Damage in a bag raises nothing: see `BagReader.damage`.
    """
    return BagReader([paths] if isinstance(paths, str) else paths, is_wanted, progress)


def _check_arrays(definition: str) -> None:
    """Check that messages of a definition have hardly more values than bytes. Raises ValueError where they could."""
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

    with contextlib.suppress(Exception):    # whatever a broken package raises when it is imported
        known = roslib.message.get_message_class(type_name)
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
    """Make a message of recorded bytes.

    Args:
        connection: by which they came.
        data: the bytes.
        into: a message of that class that is filled; None: a new one.

    Raises:
        BagError: the bytes are not such a message.
    """
    made = message_class(connection)() if into is None else into
    try:
        made.deserialize(data)
    except Exception as error:  # genpy's own, or what struct and codecs raise on its way
        raise BagError("a message on %s is damaged: %s" % (connection.topic, error)) from None
    return made
