"""Reads and writes the fields of all packets, by the table of each packet.

A packet is a frozen dataclass, and a group of fields inside it is a NamedTuple. This class is also the table of the
packet or group. Each of its fields is a row of the form

    name_with_unit: type = wire(WIRE_TYPE, "unit", "meaning")

The rows are in the order of the bytes. A field that older firmware does not send has `later` instead of `wire`. A field
without `wire` and `later` is not in the data: its value comes from the id of the frame.
All integers are little-endian. Negative integers are two's complement. Strings end with a NUL (protocol sheet 1.4).
The robot's protocol and those of devices on it are written in such tables.

To save time, neighbouring numbers are read and written together, with one `struct`: a robot sends the same forty
numbers ten times a second. When a number does not fit, the numbers are written one by one to find it.
"""

import operator
import struct
from bisect import bisect_right
from dataclasses import field, fields
from functools import cached_property, lru_cache, partial
from itertools import groupby
from typing import Any, Collection, Dict, List, NamedTuple, Optional, Sequence, Tuple, Type, Union

from .errors import EncodingError


class TooShort(Exception):
    """The data end before the end of a field. Programs get a `MalformedPacket` instead of this exception."""


class Row(NamedTuple):
    """One field of a packet. `type` reads and writes its value. `unit` is the unit of one step of a number.

    An `optional` field may be missing. Then all fields behind it are missing, too.
    """

    name: str
    type: Any
    unit: str
    meaning: str
    optional: bool

    @property
    def length(self) -> int:
        """How many values this row reads and writes: one."""
        return 1

    def read(self, data: bytes, at: int) -> Tuple[Tuple[Any, ...], int]:
        """A tuple with the value at index `at`, and the index of the next field.

        When an optional field is missing, its value is None, and the index is the end of the data. When another field
        is missing, this raises TooShort.
        """
        try:
            value, end = self.type.read(data, at)
        except TooShort as short:
            if not self.optional:
                raise TooShort("%s: %s" % (self.name, short)) from None
            value, end = None, len(data)
        return (value,), end

    def write(self, values: Sequence[Any], owner: str) -> bytes:
        """The bytes of the one value in `values`; no bytes when `values` is empty.

        Raises EncodingError, which names the packet `owner`, when the value does not fit.
        """
        return b"".join([self.type.write(value, "%s.%s" % (owner, self.name)) for value in values])


def wire(type: Any, unit: str, meaning: str) -> Any:
    """A dataclass field that `type` reads and writes. `unit` is the unit of one step: ``"mm"``, ``"0.1 V"``, or empty.
    """
    return field(metadata={"wire": (type, unit, meaning, False)})


def later(type: Any, unit: str, meaning: str) -> Any:
    """A dataclass field as `wire` makes it, for a value that older firmware does not send. Its default is None."""
    return field(default=None, metadata={"wire": (type, unit, meaning, True)})


def packed(layout: struct.Struct, numbers: Collection[Any]) -> Optional[bytes]:
    """The bytes of `numbers` in this layout. None when a number does not fit or is a bool."""
    if bool in map(type, numbers):
        return None
    try:
        return layout.pack(*numbers)
    except struct.error:
        return None


class NumberRun:
    """Neighbouring rows of a table that are numbers. They are read and written together, as far as the data go."""

    def __init__(self, rows: Sequence[Row]) -> None:
        self._rows = rows
        self.length = len(rows)
        letters = "".join(row.type.letter for row in rows)
        self._layouts = [struct.Struct("<" + letters[:number]) for number in range(len(rows) + 1)]
        self._sizes = [layout.size for layout in self._layouts]

    def read(self, data: bytes, at: int) -> Tuple[Tuple[Any, ...], int]:
        """The values of all rows from index `at` on, and the index behind them. Missing optional values are None.

        Raises TooShort when another value is missing.
        """
        layout = self._layouts[bisect_right(self._sizes, len(data) - at) - 1]
        values = layout.unpack_from(data, at)
        if len(values) == self.length:
            return values, at + layout.size
        missing = self._rows[len(values):]
        if not missing[0].optional:
            missing[0].read(data, at + layout.size)     # raises TooShort, with its name
        return values + (None,) * len(missing), len(data)

    def write(self, values: Sequence[Any], owner: str) -> bytes:
        """The bytes of `values`, which are the values of the first rows, or of all rows.

        Raises EncodingError, which names the packet `owner`, when a value does not fit.
        """
        data = packed(self._layouts[len(values)], values)
        if data is None:    # one does not fit: find out which
            data = b"".join(row.write([value], owner) for row, value in zip(self._rows, values))
        return data


class Table(Tuple[Row, ...]):
    """The rows of a packet or record, in the order of their bytes."""

    @cached_property
    def names(self) -> Tuple[str, ...]:
        """The names of the rows."""
        return tuple(row.name for row in self)

    @cached_property
    def parts(self) -> List[Union[NumberRun, Row]]:
        """The rows in groups: neighbouring numbers together as one NumberRun, every other row alone."""
        found: List[Union[NumberRun, Row]] = []
        for are_numbers, group in groupby(self, lambda row: isinstance(row.type, NumberField)):
            found += [NumberRun(tuple(group))] if are_numbers else group
        return found


@lru_cache(maxsize=None)
def rows(packet_class: Any) -> Table:
    """The table of a packet or record class: one row for each field that `wire` or `later` made."""
    made_by = getattr(packet_class, "_field_defaults", None) or {each.name: each for each in fields(packet_class)}
    return Table(Row(name, *each.metadata["wire"]) for name, each in made_by.items() if "wire" in each.metadata)


def read_fields(table: Table, data: bytes, at: int = 0) -> Tuple[Dict[str, Any], int]:
    """The values in `data` from index `at` on, by the names in `table`, and the index behind the last value.

    Bytes behind the last value are ignored.

    Raises:
        TooShort: a field that is not optional is missing.
    """
    values: Tuple[Any, ...] = ()
    for part in table.parts:
        found, at = part.read(data, at)
        values += found
    return dict(zip(table.names, values)), at


def made(packet_class: Type[Any], values: Dict[str, Any]) -> Any:
    """A packet with these values. This is faster than the __init__ of a frozen dataclass."""
    packet = object.__new__(packet_class)
    object.__setattr__(packet, "__dict__", values)
    return packet


def write_fields(table: Table, packet: Any) -> bytes:
    """The data of `packet` (a packet or a group), up to its last field that is not None.

    Raises:
        EncodingError: a value does not fit its field, or a value is None although a later value is not.
    """
    values = list(packet if isinstance(packet, tuple) else map(vars(packet).get, table.names))
    while values and values[-1] is None and table[len(values) - 1].optional:
        values.pop()
    data, at, owner = b"", 0, type(packet).__name__
    for part in table.parts:
        data += part.write(values[at:at + part.length], owner)
        at += part.length
    return data


def checked_integer(value: Any, low: int, high: int, what: str) -> int:
    """`value` as an int. Any whole number in `low`..`high` is legal (anything with ``__index__``), but no bool.

    Raises:
        EncodingError: `value` is not legal. The message has `what`, the value and the legal range.
    """
    if isinstance(value, bool) or not hasattr(value, "__index__"):
        raise EncodingError("%s: %r is not an integer (%d..%d is legal)" % (what, value, low, high))
    number = operator.index(value)
    if not low <= number <= high:
        raise EncodingError("%s: %d is out of range (%d..%d is legal)" % (what, number, low, high))
    return number


def checked_bytes(value: Any, what: str) -> bytes:
    """`value` as bytes. It must be bytes, bytearray or memoryview.

    Raises:
        EncodingError: `value` is anything else. The message has `what` and the value.
    """
    if not isinstance(value, (bytes, bytearray, memoryview)):
        raise EncodingError("%s: %r is not bytes" % (what, value))
    return bytes(value)


class NumberField:
    """The type of a field that is a little-endian integer with this `struct` letter.

    `names` is the IntFlag or IntEnum with the names of its bits or values; None for a number without names.
    """

    def __init__(self, letter: str, names: Optional[Type[int]] = None) -> None:
        self.letter, self.names = letter, names
        self._struct = struct.Struct("<" + letter)
        self.size = self._struct.size
        bits = 8 * self.size
        self.low, self.high = (-1 << bits - 1, (1 << bits - 1) - 1) if letter.islower() else (0, (1 << bits) - 1)

    def of(self, names: Type[int]) -> "NumberField":
        """The same type with `names`. Values are still read as a plain int: newer firmware may send unknown numbers."""
        return NumberField(self.letter, names)

    def read(self, data: bytes, at: int) -> Tuple[int, int]:
        """The integer at index `at`, and the index of the next field. Raises TooShort when the data end before."""
        if at + self.size > len(data):
            raise TooShort("needs %d bytes, %d left" % (self.size, len(data) - at))
        return self._struct.unpack_from(data, at)[0], at + self.size

    def write(self, value: int, what: str) -> bytes:
        """The bytes of `value`. Raises EncodingError, which names `what`, when `value` does not fit."""
        return self._struct.pack(checked_integer(value, self.low, self.high, what))


class TextField:
    """The type of a field that is a string. The string ends with a NUL or at the end of the data.

    With a `size` the field always has so many bytes, padded with NULs. The string is read as Latin-1, in which any byte
    is legal.
    """

    def __init__(self, size: int = 0) -> None:
        self.size = size

    def read(self, data: bytes, at: int) -> Tuple[str, int]:
        """The string at index `at`, and the index of the next field. Raises TooShort when the data end before."""
        if len(data) - at < max(1, self.size):
            raise TooShort("needs %s bytes, %d left" % (self.size or "a string of", len(data) - at))
        text = data[at:(at + self.size) if self.size else None].partition(b"\0")[0]
        return text.decode("latin-1"), at + (self.size or min(len(text) + 1, len(data) - at))

    def write(self, value: str, what: str) -> bytes:
        """The bytes of `value`. Raises EncodingError, which names `what`, when `value` does not fit."""
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
    """The type of a field that takes all bytes up to the end of the data."""

    def read(self, data: bytes, at: int) -> Tuple[bytes, int]:
        """The bytes from index `at` on, and the index of the end of the data."""
        return bytes(data[at:]), len(data)

    def write(self, value: bytes, what: str) -> bytes:
        """`value` as bytes. Raises EncodingError, which names `what`, when `value` is not bytes."""
        return checked_bytes(value, what)


class Record:
    """The type of a field that is a group of fields: a NamedTuple with its own table."""

    def __init__(self, record_class: Any) -> None:
        self.record_class, self._table = record_class, rows(record_class)
        record_class.__new__.__defaults__ = None    # what `wire` made is a row of the table, and no value
        plain = all(isinstance(row.type, NumberField) for row in self._table)
        self.layout = struct.Struct("<" + "".join(row.type.letter for row in self._table)) if plain else None
        """The `struct` of all fields together, if all of them are numbers; else None."""

    def read(self, data: bytes, at: int) -> Tuple[Any, int]:
        """The record at index `at`, and the index of the next field. Raises TooShort when the data end before."""
        values, end = read_fields(self._table, data, at)
        return self.record_class(**values), end

    def write(self, value: Any, what: str) -> bytes:
        """The bytes of the record `value`. Raises EncodingError, which names `what`, for any other class."""
        if not isinstance(value, self.record_class):
            raise EncodingError("%s: %r is not a %s" % (what, value, self.record_class.__name__))
        return write_fields(self._table, value)


class Many:
    """The type of a field that is a tuple of items.

    Args:
        item: the type of each item.
        count: the type of the number in front of the items, which says how many items follow; None for a byte. Or an
            int: a fixed number of items, with no number in front of them.
        sized: whether a byte with the length of one item (bytes) follows the count. Bytes of an item that our table
            does not have are skipped.
    """

    def __init__(self, item: Any, count: Union[None, int, NumberField] = None, sized: bool = False) -> None:
        self.item, self.count, self.sized = item, BYTE if count is None else count, sized
        self._layout: Optional[struct.Struct] = None if sized else getattr(item, "layout", None)

    def read(self, data: bytes, at: int) -> Tuple[Tuple[Any, ...], int]:
        """The items from index `at` on, and the index of the next field. Raises TooShort when the data end before."""
        number, at = (self.count, at) if isinstance(self.count, int) else self.count.read(data, at)
        if self._layout is not None and at + number * self._layout.size <= len(data):
            end = at + number * self._layout.size
            return tuple(map(partial(tuple.__new__, self.item.record_class),    # faster than its own __new__
                             self._layout.iter_unpack(data[at:end]))), end
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
        """The bytes of the items in `value`, with their count in front. Raises EncodingError, which names `what`."""
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
        """The bytes of `items` if all are records of numbers, in one go. None for other items and illegal numbers."""
        if self._layout is None or set(map(type, items)) - {self.item.record_class}:
            return None
        layout = struct.Struct("<" + self._layout.format[1:] * len(items))
        return packed(layout, [number for item in items for number in item])


BYTE, UINT16, UINT32 = NumberField("B"), NumberField("H"), NumberField("I")
INT8, INT16, INT32 = NumberField("b"), NumberField("h"), NumberField("i")
STRING, REST = TextField(), Rest()


def wrapped(difference: int, full: int) -> int:
    """The `difference` of two numbers on a circle of `full` units, taken the short way: -full/2 <= result < full/2."""
    half = full // 2
    return (difference + half) % full - half
