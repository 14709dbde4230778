"""Read a whole or damaged bag of ``rosbag record`` in bounded memory, with `read_bag`.

``rosbag.Bag`` keeps an entry of every message in memory and refuses a bag that was not closed. This reader keeps little
more than one chunk in memory. In a closed bag it reads the index first, and skips chunks without a wanted topic. In a
bag that was not closed it reads everything. It skips damaged bytes, and can then report what is missing. The file
`records` describes the format of bags.
"""

import contextlib
import functools
import heapq
import itertools
import os
import re
from typing import (Any, Callable, Collection, Counter, Dict, Iterable, Iterator, List, NamedTuple,
                    Optional, Sequence, Set, Tuple, Union)

from .plain_messages import plain_class
from .records import (BETWEEN_CHUNKS, BLOCK, CHUNK, CHUNK_INFO, CONNECTION, FIELDS, FILE_HEADER, INDEX, MAGIC, MESSAGE,
                      TIME, U32, U64, BagError, BagRecord, Source, decompressed, fields_of, nanoseconds, next_record,
                      record_at, records, source_of_bytes)

LATE = 10 ** 9
"""The largest delay (ns) of a recorded message in a bag without an index that is still put in the right order."""
HELD = 1 << 25
"""The largest number of bytes of messages that wait in memory to be put in order of time."""
OVERHEAD = 200
"""The number of bytes that Python needs for each waiting message, in addition to its data."""
TAIL = 1 << 24
"""The number of bytes at the end of a file in which the index is searched, if its position is not known.

The index of a bag of 100 GB is about as long."""
LONGEST_ARRAY = 1 << 20
"""The largest legal length of a fixed-length array in a message definition.

Every message object has memory for all values of such an array."""
NEVER = 1 << 63
"""A time (ns) that is later than any message."""
PLACES = 3
"""The number of damaged places that are reported one by one. Further places are only counted."""

Progress = Callable[[int, int], Any]
Latched = Dict[Tuple[str, str], bytes]
"""The data of the first latched message of each publisher, by topic and name of the publisher."""


class BagConnection(NamedTuple):
    """The connection of one publisher to a topic, as a bag describes it."""

    topic: str
    type: str
    """the message type, for example nav_msgs/Odometry"""
    md5sum: str
    definition: str
    """the definition of the message type and of all types in it"""
    latching: bool
    """whether late subscribers get the last message"""
    caller: str
    """the name of the node that published; empty if the bag does not have it"""
    header: Dict[str, str]
    """all fields of the connection in the bag, as rosbag.Bag.write takes them as connection_header"""


class Message(NamedTuple):
    """One recorded message."""

    topic: str
    connection: BagConnection
    data: bytes
    """the serialized message; `decode` converts it to a message object"""
    time: int
    """when the recorder received it: ns since 1970, or ns of simulated time"""


class _Place(NamedTuple):
    """A damaged place in a file: bytes from `begin` to `end` that hold no records."""

    begin: int
    end: int
    when: str
    """the time in the recording at this place, in words, such as after 12.3 s"""


class _Chunk(NamedTuple):
    """The information about one chunk in the index of a bag."""

    start: int
    """the time of its first message (ns)"""
    end: int
    """the time of its last message (ns)"""
    messages: int
    """the number of messages in it"""
    foreign: bool
    """whether no message in it is wanted"""
    earliest: int
    """the time (ns) of the earliest message in this chunk and in all later chunks of the file"""


class _Head:
    """Finds the head of a part of a recording: its first messages, which can be repeated latched messages.

    ``rosbag record --repeat-latched`` begins a part with the first message (not the newest) of each latching publisher.
    All these messages have the time at which the part begins. The next message is the message for which rosbag began
    the part. This message waited for the new file, so its time is earlier. In the connections of the repeated messages
    rosbag 1.15.15 leaves out the name of the publisher and the latching flag. rosbag 1.17.0 keeps both.

    Args:
        is_part: whether the file is one of several parts. A single file has no head.

    Attributes:
        open: whether the next message may still belong to the head.
        repeats: False if the first message behind the head is later than the head. Then rosbag repeated nothing.
    """

    def __init__(self, is_part: bool) -> None:
        self.open, self.repeats = is_part, True
        self._first: Optional[Tuple[int, bool]] = None      # the first message's time, and whether it has a publisher
        self._publishers: Set[Tuple[str, str]] = set()

    def takes(self, time: int, connection: BagConnection) -> bool:
        """Return whether a message is in the head of the part.

        Call this with every message of the part in file order, until `open` is False.

        Args:
            time: the time of the message (ns).
            connection: the connection of the message.
        """
        alike, publisher = (time, bool(connection.caller)), (connection.topic, connection.caller)
        self._first = self._first or alike
        may_be_repeated = not connection.caller or connection.latching and publisher not in self._publishers
        self.open = alike == self._first and may_be_repeated
        self._publishers.add(publisher)
        self.repeats = self.open or time <= self._first[0]
        return self.open


class _Queue:
    """A queue that puts the messages of a file in order of time. It leaves out latched messages that rosbag repeated.

    A message waits in the queue until no earlier message can come.

    Args:
        head: the head of the file.
        latched: the latched messages of the earlier parts. The queue adds the new latched messages of this file.

    Attributes:
        size: the memory (bytes) of the waiting messages.
    """

    def __init__(self, head: _Head, latched: Latched) -> None:
        self._head, self._latched = head, latched
        # A heap in order of time. Of messages with the same time, those in the head of a part come last. The others
        # keep the order in which they were added.
        self._waiting: List[Tuple[int, bool, int, Message]] = []
        self.size, self._numbers = 0, itertools.count()

    def add(self, message: Message, in_head: bool) -> None:
        """Add a message to the queue. `in_head` is whether the message is in the head of the file."""
        heapq.heappush(self._waiting, (message.time, in_head, next(self._numbers), message))
        self.size += len(message.data) + OVERHEAD

    def take(self, before: int) -> Iterator[Message]:
        """Remove and yield the messages before a time (ns), in order of time.

        If the other messages need more memory than `HELD`, it yields the earliest of them too.
        """
        while self._waiting and (self._waiting[0][0] < before or self.size > HELD):
            _, in_head, _, message = heapq.heappop(self._waiting)
            _, connection, data, _ = message
            self.size -= len(data) + OVERHEAD
            if not (in_head and self._head.repeats and _is_known(connection, data, self._latched)):
                if connection.latching:
                    self._latched.setdefault((connection.topic, connection.caller), data)
                yield message


class _File:
    """Reads one file of a recording.

    Args:
        path: the path of the file.
        is_wanted: a function that returns whether the messages of a connection are wanted.
        is_part: whether the file is one of several parts.

    Attributes:
        begin: the time of the earliest message so far (ns). `NEVER` before the first message.
        end: the time of the latest message so far (ns). -1 before the first message.
        compression: the compression of the first chunk: none, bz2 or lz4. Empty if no chunk was found.
        indexed: whether the file has a complete index.

    Raises:
        BagError: the file cannot be read, or is not a bag.
    """

    def __init__(self, path: str, is_wanted: Callable[[BagConnection], Any], is_part: bool) -> None:
        self.path = path
        self.connections: Dict[int, BagConnection] = {}
        self.compression, self.indexed = "", False
        self.begin, self.end = NEVER, -1
        self._is_wanted = is_wanted
        self._unwanted: Set[int] = set()        # numbers of connections
        self._chunks: Dict[int, _Chunk] = {}    # by position
        self._first = len(MAGIC)                # position of the first record
        self._index = 0                         # position of the index; 0 if the recorder did not close the bag
        self._searched: Collection[int] = FIELDS
        self._places: List[_Place] = []
        self._missing = 0           # number of messages that are listed behind their chunk, but were not in it
        self._nameless = 0          # number of messages whose connection is not described in the file
        self._ambiguous: Set[str] = set()       # topics with two different descriptions of the same connection
        self._head = _Head(is_part)
        with _opened(path) as source:
            self.size = source.size
            self._look(source)

    def _look(self, source: Source) -> None:
        """Check that the file is a bag, and read its index.

        Raises:
            BagError: the file is empty, not a bag, of an old format, or encrypted.
        """
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
        """Read the connections and the chunk infos in the index.

        The chunk infos are used only if the index is complete. Then `indexed` becomes True.

        Args:
            source: the bytes of the file.
            head: the file header record. It has the numbers of connections and of chunks in the index.
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
        """Search the last `TAIL` bytes of a file without a complete index for connection records, and read them."""
        position = next_record(source, max(self._first, self.size - TAIL), (CONNECTION,))
        for record in records(source, position, searched=(CONNECTION, CHUNK_INFO)):
            if record.op == CONNECTION:
                self._know(record, source.data(record))

    def _know(self, record: BagRecord, data: bytes) -> bool:
        """Add the connection that a connection record describes. `data` is the data of the record.

        Returns False if the data lack a required field. Then nothing is added.
        """
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
        """Return the time from the first to the latest message so far in words, for example "after 12.3 s"."""
        return "before its first message" if self.end < 0 else "after %.1f s" % ((self.end - self.begin) / 1e9)

    def _saw(self, first: int, last: int) -> None:
        """Extend `begin` and `end` to messages from time `first` to time `last` (ns)."""
        self.begin, self.end = min(self.begin, first), max(self.end, last)

    def _damaged(self, begin: int, end: int) -> None:
        """Remember that the bytes from position `begin` to position `end` hold no records."""
        if self._places and begin <= self._places[-1].end:
            self._places[-1] = self._places[-1]._replace(end=max(end, self._places[-1].end))
        else:
            self._places.append(_Place(begin, end, self._moment()))

    def _passes_over(self, source: Source, chunk: BagRecord) -> bool:
        """Return whether a chunk can be skipped because no message in it is wanted.

        Both the index and the lists behind the chunk must have only unwanted connections for it. So a single wrong byte
        does not lose a chunk. No chunk is skipped while the head of the part is open.
        """
        known = self._chunks.get(chunk.position)
        if known is None or not known.foreign or self._head.open:
            return False
        lists = itertools.takewhile(lambda record: record.op == INDEX, records(source, chunk.end))
        listed = {record.connection for record in lists}
        return bool(listed) and listed <= self._unwanted

    def messages(self, progress: Callable[[int], Any], latched: Latched) -> Iterator[Message]:
        """Yield the wanted messages of the file in order of time, within the limits `LATE` and `HELD`.

        Args:
            progress: a function that is called at each chunk with the number of bytes read.
            latched: the latched messages of the earlier parts. If rosbag repeated one of them in this file, it is left
                out. New latched messages are added.
        """
        queue = _Queue(self._head, latched)
        # `met` is the number of messages found in a chunk. `expected` is the number that the index or the lists give.
        met = expected = earliest = 0
        known: Optional[_Chunk] = None
        with _opened(self.path) as file:
            for source, record in self._contents(file):
                if record.op == MESSAGE:
                    met += 1
                    # a time outside the times of its chunk comes from a damaged byte
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
        """Yield each record of the file, together with the source of its data.

        The records inside a chunk follow the chunk, unless no message in the chunk is wanted.
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
        """Return what is damaged or missing, in sentences that call the bag "it". Empty if the file is whole.

        Call this after all messages are read.
        """
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
        """Return, in words, how a bag without a complete index ends.

        `cut` is whether the file ends with bytes that hold no records.
        """
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
    """Open a file as a `Source`, for a ``with`` block. Bytes that the disk cannot read are replaced by zeros.

    Raises:
        BagError: the file does not exist or cannot be opened.
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
    """Return whether `data` equal the first latched message of the publisher of a connection.

    If the connection does not name its publisher, `data` are compared with all publishers of the topic.
    """
    return any(topic == connection.topic and caller == (connection.caller or caller) and first == data
               for (topic, caller), first in latched.items())


def plural(count: int, what: str) -> str:
    """Return a number with its noun, for example "1 message" or "2 messages". `what` is the noun in the singular."""
    return "%s %s%s" % (count, what, "s" * (count != 1))


def _percent(share: float) -> str:
    return "%.0f %%" % (100 * share) if share <= 0.99 else "%.2f %%" % (100 * share)


class BagReader:
    """Reads the messages of a recording. `read_bag` makes it.

    Iterate once over the reader for raw messages, or once over `decoded` for decoded messages.

    Attributes:
        undecoded: the number of messages that `decoded` has left out so far, by topic.
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
                self._refused.append(str(error))    # the other parts can still be read
        if not self._files:
            raise BagError(" ".join(self._refused) or "no bag is named")

    def __iter__(self) -> Iterator[Message]:
        whole, done = sum(file.size for file in self._files), 0
        latched: Latched = {}
        for file in self._files:
            yield from file.messages(lambda position: self._progress(done + position, whole), latched)
            done += file.size

    def decoded(self) -> Iterator[Tuple[BagConnection, Any, int]]:
        """Yield each wanted message: its connection, the decoded message, and the time (ns) when it was recorded.

        A message that cannot be decoded is left out and counted in `undecoded`.
        """
        for _, connection, data, time in self:
            try:
                message = decode(connection, data)
            except BagError:
                self.undecoded[connection.topic] += 1
            else:
                yield connection, message, time

    @property
    def connections(self) -> List[BagConnection]:
        """The connections that are known so far.

        In a closed bag all connections are known from the start. In another bag more become known while it is read.
        """
        return [connection for file in self._files for connection in file.connections.values()]

    @property
    def indexed(self) -> bool:
        """Whether all files have a complete index. Then `connections` has all connections from the start."""
        return all(file.indexed for file in self._files)

    @property
    def begin(self) -> Optional[int]:
        """The time (ns) of the earliest message so far, wanted or not. None before the first message."""
        return min((file.begin for file in self._files if file.end >= 0), default=None)

    @property
    def end(self) -> Optional[int]:
        """The time (ns) of the latest message so far, wanted or not. None before the first message.

        For chunks that are skipped, the time comes from the index.
        """
        return max((file.end for file in self._files if file.end >= 0), default=None)

    @property
    def compression(self) -> str:
        """The compression of the first chunk: none, bz2 or lz4. Empty if no file has a chunk."""
        return next((file.compression for file in self._files if file.compression), "")

    @property
    def damage(self) -> str:
        """What is damaged or missing, in words. A single bag is called "it". Empty if nothing is missing.

        Read this property after all messages are read.
        """
        told = [(os.path.basename(file.path) + ": ") * self._several + file.damage()
                for file in self._files if file.damage()] + self._refused
        return "; ".join(told) + "." if told else ""


def read_bag(paths: Union[str, Sequence[str]], is_wanted: Callable[[BagConnection], Any] = lambda connection: True,
             progress: Progress = lambda done, total: None) -> BagReader:
    """Open a bag, or the parts of one recording.

    Args:
        paths: the bag, or the parts in their order. Latched messages that rosbag repeated at the begin of a part are
            left out.
        is_wanted: a function that returns whether the messages of a connection are wanted. The default is all messages.
        progress: a function that is called at each chunk with the number of bytes read so far and of all bytes.

    Raises:
        BagError: a file does not exist, or no file is a readable bag. Damage inside a bag raises no error: see
            `BagReader.damage`.
    """
    return BagReader([paths] if isinstance(paths, str) else paths, is_wanted, progress)


def _check_arrays(definition: str) -> None:
    """Check that no array in a message definition can have many values in a few bytes.

    Raises:
        ValueError: a fixed-length array is longer than `LONGEST_ARRAY`, or an array has elements without any field.
    """
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
    """Return the class of a message type.

    If the installed class has the same MD5 sum, it is returned. If not, a class is made from the definition in the bag:
    without ROS a plain one.

    Raises:
        BagError: the definition is damaged.
    """
    try:
        import genpy.dynamic
        import roslib.message
    except ImportError:
        try:
            _check_arrays(definition)
            return plain_class(type_name, definition)
        except ValueError as error:
            raise BagError("the bag's definition of %s makes no sense: %s" % (type_name, error)) from None

    with contextlib.suppress(Exception):    # a broken package can raise any exception when it is imported
        known = roslib.message.get_message_class(type_name)
        if known is not None and known._md5sum == md5sum:
            return known
    try:
        _check_arrays(definition)
        return genpy.dynamic.generate_dynamic(type_name, definition)[type_name]
    except Exception as error:  # genpy can raise any exception when it parses a damaged definition
        raise BagError("the bag's definition of %s makes no sense: %s" % (type_name, error)) from None


def message_class(connection: BagConnection) -> type:
    """Return the class of the messages of a connection. Raises BagError if the bag's definition of it is damaged."""
    return _class_of(connection.type, connection.md5sum, connection.definition)


def decode(connection: BagConnection, data: bytes, into: Any = None) -> Any:
    """Deserialize a recorded message.

    Args:
        connection: the connection of the message.
        data: the bytes of the message.
        into: a message object to fill, of the class `message_class` returns. None: a new object is made.

    Raises:
        BagError: the bytes are not a message of this type, or the definition of the type is damaged.
    """
    made = message_class(connection)() if into is None else into
    try:
        made.deserialize(data)
    except Exception as error:  # exceptions of genpy, struct or codecs
        raise BagError("a message on %s is damaged: %s" % (connection.topic, error)) from None
    return made
