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
from itertools import groupby, starmap
from typing import Any, Dict, List, NamedTuple, Optional, Tuple, Union

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


class Numbers:
    """Rows of numbers that follow one another, read in one go: they are nearly all of what a robot says ten times a second."""

    def __init__(self, numbers: Tuple[Row, ...]):
        self.rows = numbers
        self._names = [row.name for row in numbers]
        self._named = [(row.name, row.type.named) for row in numbers if row.type.names is not None]
        self._struct = struct.Struct("<" + "".join(row.type.letter for row in numbers))
        self.size = self._struct.size

    @lru_cache(maxsize=None)
    def fitting(self, room: int) -> "Numbers":
        """As many of them, from the first on, as `room` bytes hold."""
        return self if self.size <= room else Numbers(self.rows[:-1]).fitting(room)

    def read(self, data: bytes, at: int) -> Dict[str, Any]:
        """The values at `at`, by name; they are all there."""
        values = dict(zip(self._names, self._struct.unpack_from(data, at)))
        for name, named in self._named:
            values[name] = named(values[name])
        return values


class Table(tuple):
    """The rows of a packet or record, in wire order."""

    @cached_property
    def runs(self) -> List[Union[Row, Numbers]]:
        """The rows as they are read: numbers that follow one another together, all else alone."""
        runs: List[Union[Row, Numbers]] = []
        for are_numbers, some in groupby(self, lambda row: isinstance(row.type, Number)):
            runs += [Numbers(tuple(some))] if are_numbers else some
        return runs


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
    for row in table.runs:
        if isinstance(row, Numbers):
            numbers = row.fitting(len(data) - at)
            values.update(numbers.read(data, at))
            at += numbers.size
            if numbers is row:
                continue
            row = row.rows[len(numbers.rows)]
        try:
            values[row.name], at = row.type.read(data, at)
        except TooShort as short:
            if row.optional:
                break
            raise TooShort(f"{row.name}: {short}") from None
    return values, at


def write_fields(table: Table, packet) -> bytes:
    """The data of `packet`, up to its last field that is not None.

    Raises:
        EncodingError: a value does not fit its field, or a None stands before fields that are set.
    """
    values = [getattr(packet, row.name) for row in table]
    while values and values[-1] is None and table[len(values) - 1].optional:
        values.pop()
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
    """A little-endian integer, given by its `struct` letter. With `names`, its value is one of that enumeration."""

    def __init__(self, letter: str, names=None):
        self.letter, self.names = letter, names
        self._struct = struct.Struct("<" + letter)
        self.named = lru_cache(maxsize=1024)(self._named)
        bits = 8 * self._struct.size
        self.low, self.high = (-1 << bits - 1, (1 << bits - 1) - 1) if letter.islower() else (0, (1 << bits) - 1)

    def of(self, names) -> "Number":
        """The same integer, read as one of the IntFlag or IntEnum `names`; what an IntEnum cannot name stays int."""
        return Number(self.letter, names)

    def read(self, data: bytes, at: int) -> Tuple[int, int]:
        """The integer at `at`, and where the next field begins."""
        end = at + self._struct.size
        if end > len(data):
            raise TooShort(f"needs {self._struct.size} bytes, {len(data) - at} left")
        value, = self._struct.unpack_from(data, at)
        return value if self.names is None else self.named(value), end

    def _named(self, value: int) -> int:
        try:
            return self.names(value)
        except ValueError:  # an IntEnum: newer firmware may know more numbers than we do
            return value

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
        self._struct = struct.Struct("<" + "".join(each.letter for each in types)) if plain else None

    def read_several(self, number: int, data: bytes, at: int) -> Optional[Tuple[tuple, int]]:
        """`number` records in one go, and where the next field begins; None unless they are plain numbers, and all there."""
        if self._struct is None or at + number * self._struct.size > len(data):
            return None
        end = at + number * self._struct.size
        return tuple(starmap(self.record_class, self._struct.iter_unpack(data[at:end]))), end

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

    def read(self, data: bytes, at: int) -> Tuple[tuple, int]:
        """The items from `at` on, and where the next field begins."""
        number, size = self.count, 0
        if isinstance(number, Number):
            number, at = number.read(data, at)
        if self.sized:
            size, at = BYTE.read(data, at)
        elif isinstance(self.item, Record):
            several = self.item.read_several(number, data, at)
            if several is not None:
                return several
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
