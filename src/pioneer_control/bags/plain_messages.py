"""Messages as plain objects, made from the definitions that a bag has of their types: for computers without ROS.

Values are those that genpy makes: a string is a str, an array of bytes (uint8, char) is bytes, of other numbers a
tuple, of anything else a list; a time or duration has secs and nsecs. See http://wiki.ros.org/msg for definitions, and
http://wiki.ros.org/ROS/Technical%20Overview for the bytes: little-endian, arrays and strings behind their length.
"""

import re
import struct
from typing import Any, Callable, Dict, List, Mapping, NamedTuple, Optional, Tuple

Reader = Callable[[bytes, int], Tuple[Any, int]]
"""Reads a value in bytes from a position on. Returns the value, and the position behind it. Raises struct.error."""

NUMBERS = {"bool": "?", "int8": "b", "byte": "b", "uint8": "B", "char": "B", "int16": "h", "uint16": "H", "int32": "i",
           "uint32": "I", "int64": "q", "uint64": "Q", "float32": "f", "float64": "d"}
"""The number types, with their formats of the module struct."""
TIMES = {"time": "<II", "duration": "<ii"}
BYTES = ("uint8", "char")
LENGTH = struct.Struct("<I")
RULE = re.compile(r"^=+\s*$", re.MULTILINE)
FIELD = re.compile(r"([\w/]+)(\[(\d*)\])?\s+(\w+)\s*")
CONSTANT = re.compile(r"(\w+)\s+(\w+)\s*=\s*(.*)")


class RosTime(NamedTuple):
    """A time or duration of ROS."""

    secs: int
    nsecs: int

    def to_sec(self) -> float:
        """Return it in seconds."""
        return self.secs + self.nsecs / 1e9

    def __sub__(self, other: "RosTime") -> "RosTime":
        return RosTime(*divmod((self.secs - other.secs) * 10 ** 9 + self.nsecs - other.nsecs, 10 ** 9))


class PlainMessage:
    """A message. Its class has the readers of its fields, by name."""

    _readers: Mapping[str, Reader] = {}

    def deserialize(self, data: bytes) -> "PlainMessage":
        """Set all fields from the bytes of a message, and return it. Raises struct.error when bytes are missing."""
        self._read(data, 0)
        return self

    def _read(self, data: bytes, at: int) -> int:
        for name, read in self._readers.items():
            value, at = read(data, at)
            setattr(self, name, value)
        return at


def plain_class(type_name: str, definition: str) -> type:
    """Return the class of a message type (package/Name), made from its definition and those of the types in it.

    Raises:
        ValueError: the definition makes no sense. The error says which line.
    """
    texts = {type_name: ""}
    for number, part in enumerate(RULE.split(definition)):
        head, _, rest = part.lstrip("\r\n").partition("\n")
        if number == 0:
            texts[type_name] = part
        elif head.startswith("MSG:"):
            texts.setdefault(head[4:].strip(), rest)
    return _class(type_name, texts, {}, ())


def _class(name: str, texts: Mapping[str, str], made: Dict[str, type], within: Tuple[str, ...]) -> type:
    if name in within:
        raise ValueError("%s contains itself" % name)
    if name not in made:
        if name not in texts:
            raise ValueError("there is no definition of %s" % name)
        readers: Dict[str, Reader] = {}
        members: Dict[str, Any] = {"_type": name, "_readers": readers}
        for line in texts[name].splitlines():
            constant = CONSTANT.fullmatch(line.strip())
            field = FIELD.fullmatch(line.split("#")[0].strip() + " ")
            if constant:
                members[constant.group(2)] = _constant(constant.group(1), constant.group(3))
            elif field:
                kind, array, length, word = field.groups()
                readers[word] = _reader(kind, array, length, name, lambda inner: _class(
                    inner, texts, made, (*within, name)))
            elif line.split("#")[0].strip():
                raise ValueError("%s: %r is no field" % (name, line))
        made[name] = type(name.rpartition("/")[2], (PlainMessage,), members)
    return made[name]


def _constant(kind: str, text: str) -> Any:
    if kind == "string":
        return text.strip()
    text = text.split("#")[0].strip()
    if kind == "bool":
        return text.lower() in ("true", "1")
    return float(text) if kind.startswith("float") else int(text, 0)


def _reader(kind: str, array: Optional[str], length: str, owner: str, class_of: Callable[[str], type]) -> Reader:
    """Return the reader of a field: of its type, or an array of it with a fixed length or with its length in front."""
    if array is None:
        return _read_one(kind, owner, class_of)
    count = int(length) if length else None
    if kind in NUMBERS:
        return _numbers(kind, count)
    one = _read_one(kind, owner, class_of)

    def read_list(data: bytes, at: int) -> Tuple[List[Any], int]:
        number, at = _count(count, data, at)
        values = []
        for _ in range(number):
            value, at = one(data, at)
            values.append(value)
        return values, at
    return read_list


def _read_one(kind: str, owner: str, class_of: Callable[[str], type]) -> Reader:
    if kind in NUMBERS:
        number = struct.Struct("<" + NUMBERS[kind])
        return lambda data, at: (number.unpack_from(data, at)[0], at + number.size)
    if kind in TIMES:
        pair = struct.Struct(TIMES[kind])
        return lambda data, at: (RosTime(*pair.unpack_from(data, at)), at + pair.size)
    if kind == "string":
        return lambda data, at: _string(data, *_count(None, data, at))
    package = owner.rpartition("/")[0]
    made: Any = class_of("std_msgs/Header" if kind == "Header" else kind if "/" in kind else package + "/" + kind)

    def read_message(data: bytes, at: int) -> Tuple[Any, int]:
        message = made()
        return message, message._read(data, at)
    return read_message


def _numbers(kind: str, count: Optional[int]) -> Reader:
    size = struct.calcsize("<" + NUMBERS[kind])

    def read_numbers(data: bytes, at: int) -> Tuple[Any, int]:
        number, at = _count(count, data, at)
        end = at + number * size
        if end > len(data):
            raise struct.error("%d bytes are missing" % (end - len(data)))
        return (bytes(data[at:end]) if kind in BYTES else
                struct.unpack_from("<%d%s" % (number, NUMBERS[kind]), data, at)), end
    return read_numbers


def _count(fixed: Optional[int], data: bytes, at: int) -> Tuple[int, int]:
    return (fixed, at) if fixed is not None else (LENGTH.unpack_from(data, at)[0], at + LENGTH.size)


def _string(data: bytes, length: int, at: int) -> Tuple[str, int]:
    if at + length > len(data):
        raise struct.error("%d bytes are missing" % (at + length - len(data)))
    return str(data[at:at + length], "utf-8", "replace"), at + length
