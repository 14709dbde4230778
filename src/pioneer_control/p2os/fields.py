"""How a table is read and written: the one reader and the one writer of packet fields.

A packet is a frozen dataclass, and the dataclass is its table: each field is a row

    name_with_unit: type = wire(WIRE_TYPE, "unit", "meaning")

in the order in which the bytes travel. A field that older firmware does not send has `later` instead of `wire`. A field
without both is not in the data: the id of the frame says its value.
All integers are little-endian, negative ones two's complement; strings end with a NUL (protocol sheet 1.4).

Neighbouring numbers are read and written together, with one `struct`: a robot sends the same forty numbers ten times a
second. When one of them does not fit, each is written alone, to find out which it is.
"""

import operator
import struct
from bisect import bisect_right
from dataclasses import field, fields
from functools import cached_property, lru_cache
from itertools import groupby, starmap
from typing import Any, Collection, Dict, List, NamedTuple, Optional, Sequence, Tuple, Type, Union

from ..errors import EncodingError


class TooShort(Exception):
    """The data end before the field does. Programs never see this exception: they get a `MalformedPacket`."""


class Row(NamedTuple):
    """One field of a packet. `unit` is the unit of one step of a number.

    When an `optional` field is missing, all fields behind it are missing, too.
    """

    name: str
    type: Any
    unit: str
    meaning: str
    optional: bool

    @property
    def length(self) -> int:
        """How many values it writes."""
        return 1

    def read(self, data: bytes, at: int) -> Tuple[Tuple[Any, ...], int]:
        """The value at `at` in a tuple, and where the next field begins.

        Where an optional field is missing, the value is None, and the data count as read to their end.
        """
        try:
            value, end = self.type.read(data, at)
        except TooShort as short:
            if not self.optional:
                raise TooShort("%s: %s" % (self.name, short)) from None
            value, end = None, len(data)
        return (value,), end

    def write(self, values: Sequence[Any], owner: str) -> bytes:
        """The bytes of the value in `values`; no bytes when it is empty. `owner` is the packet that an error names."""
        return b"".join([self.type.write(value, "%s.%s" % (owner, self.name)) for value in values])


def wire(type: Any, unit: str, meaning: str) -> Any:
    """A dataclass field that travels as `type`. `unit` is the unit of one step: ``"mm"``, ``"0.1 V"``, or empty."""
    return field(metadata={"wire": (type, unit, meaning, False)})


def later(type: Any, unit: str, meaning: str) -> Any:
    """A dataclass field, as `wire` makes it, which older firmware does not send. A missing field is None."""
    return field(default=None, metadata={"wire": (type, unit, meaning, True)})


def packed(layout: struct.Struct, numbers: Collection[Any]) -> Optional[bytes]:
    """The bytes of whole numbers. None when one of them does not fit, or is a bool."""
    if bool in map(type, numbers):
        return None
    try:
        return layout.pack(*numbers)
    except struct.error:
        return None


class NumberRun:
    """Neighbouring rows of a table that are numbers. They are read and written in one go, as far as the data reach."""

    def __init__(self, rows: Sequence[Row]) -> None:
        self._rows = rows
        self.length = len(rows)
        letters = "".join(row.type.letter for row in rows)
        self._layouts = [struct.Struct("<" + letters[:number]) for number in range(len(rows) + 1)]
        self._sizes = [layout.size for layout in self._layouts]

    def read(self, data: bytes, at: int) -> Tuple[Tuple[Any, ...], int]:
        """The values from `at` on, and where they end. Missing optional values are None."""
        number = bisect_right(self._sizes, len(data) - at) - 1
        layout, missing = self._layouts[number], self._rows[number:]
        if missing and not missing[0].optional:
            missing[0].read(data, at + layout.size)     # raises TooShort, with its name
        return layout.unpack_from(data, at) + (None,) * len(missing), len(data) if missing else at + layout.size

    def write(self, values: Sequence[Any], owner: str) -> bytes:
        """The bytes of the values of the first rows. `owner` is the packet that an error names."""
        data = packed(self._layouts[len(values)], values)
        if data is None:    # one does not fit: find out which
            data = b"".join(row.write([value], owner) for row, value in zip(self._rows, values))
        return data


class Table(Tuple[Row, ...]):
    """The rows of a packet or record, in the order in which they travel."""

    @cached_property
    def names(self) -> Tuple[str, ...]:
        """The names of the rows."""
        return tuple(row.name for row in self)

    @cached_property
    def parts(self) -> List[Union[NumberRun, Row]]:
        """The rows in the groups in which they are read and written."""
        found: List[Union[NumberRun, Row]] = []
        for are_numbers, group in groupby(self, lambda row: isinstance(row.type, NumberField)):
            found += [NumberRun(tuple(group))] if are_numbers else group
        return found


@lru_cache(maxsize=None)
def rows(packet_class: Any) -> Table:
    """The table of a packet class."""
    return Table(Row(f.name, *f.metadata["wire"]) for f in fields(packet_class) if "wire" in f.metadata)


def read_fields(table: Table, data: bytes, at: int = 0) -> Tuple[Dict[str, Any], int]:
    """The values of the fields of `table` in `data` from `at` on, and where they end. Bytes behind them are ignored.

    Raises:
        TooShort: a field that is not optional is missing.
    """
    values: Tuple[Any, ...] = ()
    for part in table.parts:
        found, at = part.read(data, at)
        values += found
    return dict(zip(table.names, values)), at


def made(packet_class: Type[Any], values: Dict[str, Any]) -> Any:
    """A packet or record with these values, set at once. The __init__ of a frozen dataclass sets them one by one."""
    packet = object.__new__(packet_class)
    object.__setattr__(packet, "__dict__", values)
    return packet


def write_fields(table: Table, packet: Any) -> bytes:
    """The data of `packet`, up to its last field that is not None.

    Raises:
        EncodingError: a value does not fit its field, or a None stands before fields that are set.
    """
    values = [getattr(packet, name) for name in table.names]
    while values and values[-1] is None and table[len(values) - 1].optional:
        values.pop()
    data, at, owner = b"", 0, type(packet).__name__
    for part in table.parts:
        data += part.write(values[at:at + part.length], owner)
        at += part.length
    return data


def checked_integer(value: Any, low: int, high: int, what: str) -> int:
    """`value` as an int, if it is a whole number in `low`..`high` (anything with ``__index__``, but no bool).

    Raises:
        EncodingError: naming `what`, the value and the legal range.
    """
    if isinstance(value, bool) or not hasattr(value, "__index__"):
        raise EncodingError("%s: %r is not an integer (%d..%d is legal)" % (what, value, low, high))
    number = operator.index(value)
    if not low <= number <= high:
        raise EncodingError("%s: %d is out of range (%d..%d is legal)" % (what, number, low, high))
    return number


def checked_bytes(value: Any, what: str) -> bytes:
    """`value` as bytes, if it is bytes already (not str, not a number).

    Raises:
        EncodingError: naming `what` and the value.
    """
    if not isinstance(value, (bytes, bytearray, memoryview)):
        raise EncodingError("%s: %r is not bytes" % (what, value))
    return bytes(value)


class NumberField:
    """A little-endian integer, given by its `struct` letter.

    `names` is the IntFlag or IntEnum that names its bits or values, if one does.
    """

    def __init__(self, letter: str, names: Optional[Type[int]] = None) -> None:
        self.letter, self.names = letter, names
        self._struct = struct.Struct("<" + letter)
        self.size = self._struct.size
        bits = 8 * self.size
        self.low, self.high = (-1 << bits - 1, (1 << bits - 1) - 1) if letter.islower() else (0, (1 << bits) - 1)

    def of(self, names: Type[int]) -> "NumberField":
        """The same integer with `names`. It is still read as a plain int: newer firmware may send unknown numbers."""
        return NumberField(self.letter, names)

    def read(self, data: bytes, at: int) -> Tuple[int, int]:
        """The integer at `at`, and where the next field begins."""
        if at + self.size > len(data):
            raise TooShort("needs %d bytes, %d left" % (self.size, len(data) - at))
        return self._struct.unpack_from(data, at)[0], at + self.size

    def write(self, value: int, what: str) -> bytes:
        """The bytes of `value`."""
        return self._struct.pack(checked_integer(value, self.low, self.high, what))


class TextField:
    """A string that ends with a NUL or with the data; with `size`, one of that many bytes, padded with NULs.

    Read as Latin-1, so that any byte is legal.
    """

    def __init__(self, size: int = 0) -> None:
        self.size = size

    def read(self, data: bytes, at: int) -> Tuple[str, int]:
        """The string at `at`, and where the next field begins."""
        if len(data) - at < max(1, self.size):
            raise TooShort("needs %s bytes, %d left" % (self.size or "a string of", len(data) - at))
        text = data[at:(at + self.size) if self.size else None].partition(b"\0")[0]
        return text.decode("latin-1"), at + (self.size or min(len(text) + 1, len(data) - at))

    def write(self, value: str, what: str) -> bytes:
        """The bytes of `value`."""
        try:
            text = value.encode("latin-1")
        except (AttributeError, UnicodeEncodeError):
            raise EncodingError("%s: %r is not a string of Latin-1 characters" % (what, value)) from None
        if b"\0" in text:
            raise EncodingError("%s: %r contains the NUL that ends a string" % (what, value))
        if self.size and len(text) > self.size:
            raise EncodingError("%s: %r has %d characters (0..%d is legal)" % (what, value, len(text), self.size))
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

    def __init__(self, record_class: Any) -> None:
        self.record_class, self._table = record_class, rows(record_class)
        plain = all(isinstance(row.type, NumberField) for row in self._table)
        self.layout = struct.Struct("<" + "".join(row.type.letter for row in self._table)) if plain else None
        """How the fields lie in the data, if all of them are numbers; else None."""

    def read(self, data: bytes, at: int) -> Tuple[Any, int]:
        """The record at `at`, and where the next field begins."""
        values, end = read_fields(self._table, data, at)
        return made(self.record_class, values), end

    def write(self, value: Any, what: str) -> bytes:
        """The bytes of the record `value`."""
        if not isinstance(value, self.record_class):
            raise EncodingError("%s: %r is not a %s" % (what, value, self.record_class.__name__))
        return write_fields(self._table, value)


class Many:
    """A tuple of items.

    Args:
        item: the type of each.
        count: the number in front of the items that tells how many there are (a byte, if not given); or, where the data
            do not tell it, how many there always are.
        sized: whether the length of one item in bytes follows the count. What an item has beyond our table is skipped.
    """

    def __init__(self, item: Any, count: Union[None, int, NumberField] = None, sized: bool = False) -> None:
        self.item, self.count, self.sized = item, BYTE if count is None else count, sized
        self._layout: Optional[struct.Struct] = None if sized else getattr(item, "layout", None)

    def read(self, data: bytes, at: int) -> Tuple[Tuple[Any, ...], int]:
        """The items from `at` on, and where the next field begins."""
        number, at = (self.count, at) if isinstance(self.count, int) else self.count.read(data, at)
        if self._layout is not None and at + number * self._layout.size <= len(data):
            end = at + number * self._layout.size
            return tuple(starmap(self.item.record_class, self._layout.iter_unpack(data[at:end]))), end
        size, at = BYTE.read(data, at) if self.sized else (0, at)
        items = []
        for index in range(number):
            try:
                item, end = self.item.read(data[:at + size] if self.sized else data, at)
            except TooShort as short:
                raise TooShort("item %d of %d: %s" % (index + 1, number, short)) from None
            items.append(item)
            at = min(at + size, len(data)) if self.sized else end
        return tuple(items), at

    def write(self, value: Sequence[Any], what: str) -> bytes:
        """The bytes of the items `value`, with their count."""
        try:
            value = tuple(value)
        except TypeError:
            raise EncodingError("%s: %r is not a sequence" % (what, value)) from None
        data = self._write_numbers(value)
        if data is None:
            items = [self.item.write(item, "%s[%d]" % (what, index)) for index, item in enumerate(value)]
            size = BYTE.write(len(items[0]) if items else 0, "%s, size of one" % what) if self.sized else b""
            data = size + b"".join(items)
        if isinstance(self.count, NumberField):
            return self.count.write(len(value), "%s, how many" % what) + data
        if len(value) != self.count:
            raise EncodingError("%s: %d items (%d are needed)" % (what, len(value), self.count))
        return data

    def _write_numbers(self, items: Sequence[Any]) -> Optional[bytes]:
        """The bytes of records that have only numbers, in one go. None when they have more, or one does not fit."""
        if self._layout is None or any(type(item) is not self.item.record_class for item in items):
            return None
        pieces = [packed(self._layout, vars(item).values()) or b"" for item in items]
        return b"".join(pieces) if all(pieces) else None


BYTE, UINT16, UINT32 = NumberField("B"), NumberField("H"), NumberField("I")
INT8, INT16, INT32 = NumberField("b"), NumberField("h"), NumberField("i")
STRING, REST = TextField(), Rest()


def wrapped(difference: int, full: int) -> int:
    """The difference of two numbers on a circle of `full` units, the short way round: -full/2 <= step < full/2."""
    half = full // 2
    return (difference + half) % full - half
