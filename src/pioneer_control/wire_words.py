"""Bytes and values of a protocol as text for a person, and the other way round. The explainers of all protocols use it.

What a value means comes from the table of its packet (`wire_fields`).
"""

import re
from enum import IntFlag
from fractions import Fraction
from typing import Any, Iterable, Iterator, Mapping, Optional

from .errors import UsageError
from .wire_fields import Row


def parse_hex(text: str) -> bytes:
    """The bytes in a text such as ``FA FB 06``, ``fafb06``, ``0xFA, 0xFB, 0x06`` or ``\\xfa\\xfb\\x06``.

    Raises:
        UsageError: a word is not hexadecimal. The message names the word.
    """
    data = bytearray()
    for word in re.sub(r"0[xX]|\\x|[\s,;:]", " ", text).split():
        if not re.fullmatch(r"[0-9A-Fa-f]|([0-9A-Fa-f]{2})+", word):
            why = "has an odd number of digits" if re.fullmatch(r"[0-9A-Fa-f]+", word) else "is not hexadecimal"
            raise UsageError("%r %s; bytes are given in two hexadecimal digits each, like this: 02 1D FA" % (word, why))
        data += bytes.fromhex(word.rjust(2, "0"))
    return bytes(data)


def hex_of(data: bytes) -> str:
    """Bytes as text, such as ``FA FB 06``."""
    return " ".join("%02X" % byte for byte in data)


def in_table(values: Mapping[str, Any], rows: Iterable[Row]) -> Iterator[str]:
    """Lines of text for the values of a packet that are not None: name, value, meaning. A value without a row is what
    the id of the packet says, and comes first.

    Args:
        values: by name.
        rows: of the packet's table.
    """
    table = {row.name: row for row in rows}
    width = max(map(len, values), default=0)
    for name in sorted(values, key=lambda name: name in table):
        value, row = values[name], table.get(name)
        if value is not None:
            yield ("%-*s  %-20s  %s" % (width, name, value_in_words(value, row), row.meaning if row else "")).rstrip()


def value_in_words(value: Any, row: Optional[Row] = None) -> str:
    """A value as text for a person. `row` is None when the value comes from the id of a packet, not from its data."""
    if isinstance(value, tuple):
        return "; ".join(map(_item, value)) or "none"
    if isinstance(value, bytes):
        return "%s %r" % (hex_of(value), value.decode("latin-1")) if value else "none"
    if isinstance(value, str):
        return repr(value)
    names = None if row is None else row.type.names
    if names is not None and issubclass(names, IntFlag):
        unnamed = value & ~sum(names)
        bits = [str(bit.name) for bit in names if value & bit] + ["0x%X" % unnamed] * bool(unnamed)
        return ("0x%02X %s" % (value, ", ".join(bits))).rstrip()
    if names is not None and value in list(names):
        return "%d %s" % (value, names(value).name)
    return "%d%s" % (value, _in_units(value, row))


def _item(item: Any) -> str:
    """One item of a tuple as text: a number such as ``7``, or a record such as ``number 3, range_units 1500``."""
    return str(item) if isinstance(item, int) else ", ".join("%s %s" % each for each in item._asdict().items())


def _in_units(value: int, row: Optional[Row]) -> str:
    """The text behind a value: its unit, such as ``mm``.

    If the unit has a step, such as ``0.1 V`` or ``5/255 V``, the value is converted: the text is ``= 12.8 V``.
    """
    whole_unit = "" if row is None else row.unit
    step, _, unit = whole_unit.partition(" ")
    text = "= %.6g %s" % (value * Fraction(step), unit) if re.fullmatch(r"[0-9./]+", step) else whole_unit
    return (" %s" % text).rstrip()
