"""How a table is read and written: the one reader and the one writer of packet fields.

A packet is a frozen dataclass, and the dataclass is its table: each field is a row

    name_with_unit: type = wire(WIRE_TYPE, "unit", "meaning")

in the order in which the bytes travel (`later` instead of `wire` if older firmware stops before it). A field with
neither is not in the data: the frame's id says it.
All integers are little-endian, negative ones two's complement; strings end with a NUL (protocol 1.4).
"""

import operator
import struct
from dataclasses import field, fields
from functools import cached_property, lru_cache
from typing import Any, Callable, Dict, List, NamedTuple, Optional, Sequence, Tuple

from ..errors import EncodingError


class TooShort(Exception):
    """The data end before the field does. Never leaves this folder: it becomes a `MalformedPacket`."""


class Row(NamedTuple):
    """One field of a packet."""

    name: str
    type: Any
    unit: str
    meaning: str
    optional: bool


def wire(type, unit: str, meaning: str):
    """A dataclass field that travels as `type`; `unit` is that of one step (``"mm"``, ``"0.1 V"``), if it has one."""
    return field(metadata={"wire": (type, unit, meaning, False)})


def later(type, unit: str, meaning: str):
    """The same for a field that older firmware does not send: then it is None, as is everything behind it."""
    return field(default=None, metadata={"wire": (type, unit, meaning, True)})


class Layout:
    """Where everything is in data that are all numbers: read in one go, for a robot says the same ten times a second.

    `number` records stand in the one row of `table` that holds `Many`, if it has one.
    """

    def __init__(self, table: Tuple[Row, ...], number: int, absent: Tuple[Row, ...] = ()):
        self._letters: Dict[str, str] = {}      # of each row
        self._records = None
        for at, row in enumerate(table):
            if isinstance(row.type, Many):
                record, width = row.type.item.record_class, len(row.type.item.letters)
                first = at + 1      # behind their count
                end = first + number * width
                self._records = first, end, [slice(first + column, end, width) for column in range(width)], record
                self._letters[row.name] = row.type.count.letter + row.type.item.letters * number
            else:
                self._letters[row.name] = row.type.letter
        self._names = tuple(row.name for row in (*table, *absent))
        self._absent = (None,) * len(absent)
        self._struct = struct.Struct("<" + "".join(self._letters.values()))
        self.size = self._struct.size

    def read(self, data: bytes) -> Dict[str, Any]:
        """The values by name; those of the rows `absent` are None."""
        values = self._struct.unpack_from(data)
        if self._records is not None:
            first, end, columns, record = self._records
            values = (*values[:first - 1], tuple(map(record, *map(values.__getitem__, columns))), *values[end:])
        return dict(zip(self._names, values + self._absent))

    def part(self, names: Sequence[str]) -> Callable[[bytes], Tuple[Optional[int], ...]]:
        """What reads just these rows of one number each, which are named in wire order; the last of them may be absent, and are None."""
        letters = (letters if name in names else "%dx" % struct.calcsize("<" + letters) for name, letters in self._letters.items())
        unpack = struct.Struct("<" + "".join(letters)).unpack_from
        absent = (None,) * len(set(names) - set(self._letters))
        return (lambda data: unpack(data) + absent) if absent else unpack

    def write(self, values: Sequence[Any]) -> Optional[bytes]:
        """The data; None if not all of the values fit: then `write_fields` finds out which."""
        if self._records is not None:
            first, _, _, record = self._records
            records = values[first - 1]
            if any(type(each) is not record for each in records):
                return None
            flat = [value for each in records for value in vars(each).values()]
            values = [*values[:first - 1], len(records), *flat, *values[first:]]
        if bool in map(type, values):
            return None
        try:
            return self._struct.pack(*values)
        except struct.error:
            return None


class Table(tuple):
    """The rows of a packet or record, in wire order."""

    @cached_property
    def names(self) -> Tuple[str, ...]:
        """Those of the rows."""
        return tuple(row.name for row in self)

    def layout(self, data: bytes) -> Optional[Layout]:
        """How to read all of these data; None if they need the row by row of `read_fields`."""
        if not self._is_plain:
            return None
        at = self._count_at
        if at is None:
            return self._layout(len(data), 0)
        return self._layout(len(data), data[at]) if at < len(data) else None

    def layout_of(self, values: List[Any]) -> Optional[Layout]:
        """How to write these values of the first rows; None if they need the row by row of `write_fields`."""
        if not self._is_plain:
            return None
        many = self._many
        if many is None:
            return self._layout_to_write(len(values), 0)
        return self._layout_to_write(len(values), len(values[many])) if len(values) > many and type(values[many]) is tuple else None

    def part(self, names: Sequence[str]) -> Callable[[bytes], Optional[Tuple[Optional[int], ...]]]:
        """What reads just these rows of a plain table with records, as `Layout.part` does; None for data that cannot all be read."""
        at = self._count_at
        assert self._is_plain and at is not None

        @lru_cache(maxsize=64)
        def part_of(length: int, number: int) -> Callable[[bytes], Optional[Tuple[Optional[int], ...]]]:
            layout = self._layout(length, number)
            return (lambda data: None) if layout is None else layout.part(names)

        def read(data: bytes) -> Optional[Tuple[Optional[int], ...]]:
            length = len(data)
            return part_of(length, data[at])(data) if at < length else None

        return read

    @cached_property
    def _is_plain(self) -> bool:
        """Whether the rows are all numbers, but for at most one of records of numbers."""
        others = [row.type for row in self if not isinstance(row.type, Number)]
        return not others or len(others) == 1 and isinstance(others[0], Many) and others[0].is_plain

    @cached_property
    def _many(self) -> Optional[int]:
        """Which row holds records, if one does."""
        return next((index for index, row in enumerate(self) if isinstance(row.type, Many)), None)

    @cached_property
    def _count_at(self) -> Optional[int]:
        """Where in the data the count of the records is, if there are any; of a plain table."""
        return None if self._many is None else sum(row.type.size for row in self[:self._many])

    @cached_property
    def _layout(self) -> Callable[[int, int], Optional[Layout]]:
        return lru_cache(maxsize=64)(self._make_layout)

    @cached_property
    def _layout_to_write(self) -> Callable[[int, int], Layout]:
        return lru_cache(maxsize=64)(lambda length, number: Layout(self[:length], number))

    def _make_layout(self, length: int, number: int) -> Optional[Layout]:
        """For data of this length with so many records; None when something is missing that has to be there."""
        for end in range(len(self), 0, -1):
            layout = Layout(self[:end], number, self[end:])
            if layout.size <= length:
                return layout
            if not self[end - 1].optional:
                break
        return None


@lru_cache(maxsize=None)
def rows(packet_class) -> Table:
    """The table of a packet class."""
    return Table(Row(f.name, *f.metadata["wire"]) for f in fields(packet_class) if "wire" in f.metadata)


def read_fields(table: Table, data: bytes, at: int = 0) -> Tuple[Dict[str, Any], int]:
    """The values of the fields of `table` in `data` from `at` on, and where they end. Bytes behind them are ignored.

    Raises:
        TooShort: a field that is not optional is missing.
    """
    values: Dict[str, Any] = {}
    for row in table:
        try:
            values[row.name], at = row.type.read(data, at)
        except TooShort as short:
            if row.optional:
                return {**dict.fromkeys(table.names), **values}, at
            raise TooShort(f"{row.name}: {short}") from None
    return values, at


def made(packet_class, values: Dict[str, Any]):
    """A packet or record of these values: what its __init__ does one by one, as a frozen dataclass must, in one go."""
    packet = object.__new__(packet_class)
    object.__setattr__(packet, "__dict__", values)
    return packet


def write_fields(table: Table, packet) -> bytes:
    """The data of `packet`, up to its last field that is not None.

    Raises:
        EncodingError: a value does not fit its field, or a None stands before fields that are set.
    """
    values = [getattr(packet, name) for name in table.names]
    while values and values[-1] is None and table[len(values) - 1].optional:
        values.pop()
    layout = table.layout_of(values)
    data = layout.write(values) if layout is not None else None
    if data is not None:
        return data
    name = type(packet).__name__
    return b"".join(row.type.write(value, f"{name}.{row.name}") for row, value in zip(table, values))


def checked_integer(value, low: int, high: int, what: str) -> int:
    """`value` as an int, if it is a whole number in `low`..`high` (anything with ``__index__``, but no bool).

    Raises:
        EncodingError: naming `what`, the value and the legal range.
    """
    if isinstance(value, bool) or not hasattr(value, "__index__"):
        raise EncodingError(f"{what}: {value!r} is not an integer ({low}..{high} is legal)")
    number = operator.index(value)
    if not low <= number <= high:
        raise EncodingError(f"{what}: {number} is out of range ({low}..{high} is legal)")
    return number


class Number:
    """A little-endian integer, given by its `struct` letter. `names` is the IntFlag or IntEnum that names its bits or values, if one does."""

    def __init__(self, letter: str, names=None):
        self.letter, self.names = letter, names
        self._struct = struct.Struct("<" + letter)
        self.size = self._struct.size
        bits = 8 * self.size
        self.low, self.high = (-1 << bits - 1, (1 << bits - 1) - 1) if letter.islower() else (0, (1 << bits) - 1)

    def of(self, names) -> "Number":
        """The same integer, with `names`. It is read as a plain int all the same: newer firmware may know more numbers than we do."""
        return Number(self.letter, names)

    def read(self, data: bytes, at: int) -> Tuple[int, int]:
        """The integer at `at`, and where the next field begins."""
        end = at + self.size
        if end > len(data):
            raise TooShort(f"needs {self.size} bytes, {len(data) - at} left")
        value, = self._struct.unpack_from(data, at)
        return value, end

    def write(self, value: int, what: str) -> bytes:
        """The bytes of `value`."""
        if type(value) is int and self.low <= value <= self.high:  # nearly always: a robot writes 40 of these in a SIP
            return self._struct.pack(value)
        return self._struct.pack(checked_integer(value, self.low, self.high, what))


class Text:
    """A string that ends with a NUL or with the data; with `size`, one of that many bytes, padded with NULs.

    Read as Latin-1, so that any byte is legal.
    """

    def __init__(self, size: int = 0):
        self.size = size

    def read(self, data: bytes, at: int) -> Tuple[str, int]:
        """The string at `at`, and where the next field begins."""
        if len(data) - at < max(1, self.size):
            raise TooShort(f"needs {self.size or 'a string of'} bytes, {len(data) - at} left")
        text = data[at:at + self.size] if self.size else data[at:]
        text = text.partition(b"\0")[0]
        return text.decode("latin-1"), at + (self.size or min(len(text) + 1, len(data) - at))

    def write(self, value: str, what: str) -> bytes:
        """The bytes of `value`."""
        try:
            text = value.encode("latin-1")
        except (AttributeError, UnicodeEncodeError):
            raise EncodingError(f"{what}: {value!r} is not a string of Latin-1 characters") from None
        if b"\0" in text:
            raise EncodingError(f"{what}: {value!r} contains the NUL that ends a string")
        if self.size and len(text) > self.size:
            raise EncodingError(f"{what}: {value!r} has {len(text)} characters (0..{self.size} is legal)")
        return text.ljust(self.size, b"\0") if self.size else text + b"\0"


class Rest:
    """All bytes that are left."""

    def read(self, data: bytes, at: int) -> Tuple[bytes, int]:
        """The bytes from `at` on, and the end of the data."""
        return bytes(data[at:]), len(data)

    def write(self, value: bytes, what: str) -> bytes:
        """`value` itself."""
        return checked_bytes(value, what)


class Record:
    """A group of fields: a dataclass with a table of its own."""

    def __init__(self, record_class):
        self.record_class = record_class
        types = [row.type for row in rows(record_class)]
        plain = all(isinstance(each, Number) and each.names is None for each in types)
        self.letters = "".join(each.letter for each in types) if plain else ""
        """Those of its fields, if they are numbers and nothing else."""

    def read(self, data: bytes, at: int):
        """The record at `at`, and where the next field begins."""
        values, end = read_fields(rows(self.record_class), data, at)
        return self.record_class(**values), end

    def write(self, value, what: str) -> bytes:
        """The bytes of the record `value`."""
        if not isinstance(value, self.record_class):
            raise EncodingError(f"{what}: {value!r} is not a {self.record_class.__name__}")
        return write_fields(rows(self.record_class), value)


class Many:
    """A tuple of items. How many travels before them as `count` (a `Number`), unless `count` itself is the number.

    With `sized`, the length of one item in bytes follows the count; what an item has beyond our table is skipped.
    """

    def __init__(self, item, count=None, sized: bool = False):
        self.item, self.count, self.sized = item, BYTE if count is None else count, sized

    @property
    def is_plain(self) -> bool:
        """Whether a byte says how many records of numbers there are, and nothing else is to be minded."""
        return self.count is BYTE and not self.sized and isinstance(self.item, Record) and bool(self.item.letters)

    def read(self, data: bytes, at: int) -> Tuple[tuple, int]:
        """The items from `at` on, and where the next field begins."""
        number, size = self.count, 0
        if isinstance(number, Number):
            number, at = number.read(data, at)
        if self.sized:
            size, at = BYTE.read(data, at)
        items = []
        for index in range(number):
            try:
                item, end = self.item.read(data[:at + size] if self.sized else data, at)
            except TooShort as short:
                raise TooShort(f"item {index + 1} of {number}: {short}") from None
            items.append(item)
            at = min(at + size, len(data)) if self.sized else end
        return tuple(items), at

    def write(self, value: tuple, what: str) -> bytes:
        """The bytes of the items `value`, with their count."""
        try:
            value = tuple(value)
        except TypeError:
            raise EncodingError(f"{what}: {value!r} is not a sequence") from None
        items = [self.item.write(item, f"{what}[{index}]") for index, item in enumerate(value)]
        prefix = b""
        if isinstance(self.count, Number):
            prefix = self.count.write(len(items), f"{what}, how many")
        elif len(items) != self.count:
            raise EncodingError(f"{what}: {len(items)} items ({self.count} are needed)")
        if self.sized:
            prefix += BYTE.write(len(items[0]) if items else 0, f"{what}, size of one")
        return prefix + b"".join(items)


def checked_bytes(value: bytes, what: str) -> bytes:
    """`value` as bytes, if it is bytes already (not str, not a number).

    Raises:
        EncodingError: naming `what` and the value.
    """
    if not isinstance(value, (bytes, bytearray, memoryview)):
        raise EncodingError(f"{what}: {value!r} is not bytes")
    return bytes(value)


BYTE, UINT16, UINT32 = Number("B"), Number("H"), Number("I")
INT8, INT16, INT32 = Number("b"), Number("h"), Number("i")
STRING, REST = Text(), Rest()
