"""Explains bytes of a laser's line in words, for a person who reads a hex dump or a record of a line.

All names, units and meanings come from the tables in the other files of this folder. A record of a line is what the
laser's node writes when it is asked to (parameter ``record``); see `laser.byte_record`::

    0.000213 > 02 00 02 00 20 25 35 08          seconds, > to the laser or < from it, bytes
"""

from typing import Any, Dict, Iterable, Iterator, List, NamedTuple, Tuple, Union

from ..errors import UsageError
from ..wire_fields import Row, rows
from ..wire_words import hex_of, in_table, parse_hex, value_in_words
from .configuration import Configuration, Unit
from .messages import MESSAGES, MalformedMessage, UnknownMessage, decode
from .replies import DeviceError, ErrorsReply
from .scans import RawScan
from .telegrams import (ANSWERED, LONGEST, OVERHEAD, PARTIAL_TIMEOUT, STX, Answer, Severity, Status, Telegram, crc,
                        severity)

SHOWN = 8
"""How many values of a scan are shown."""
UNITS = {Unit.CENTIMETRES: "cm", Unit.MILLIMETRES: "mm", Unit.TEN_CENTIMETRES: "10 cm"}


class LinePiece(NamedTuple):
    """Some bytes of a line: a telegram, ACK or NAK, or bytes that are none of these. Then `wrong` says why.

    Bytes with a wrong CRC have a telegram, too: the one that they would be with a right CRC.
    """

    data: bytes
    found: Union[Telegram, Answer, None]
    wrong: str = ""


def line_pieces(data: bytes) -> List[LinePiece]:
    """`data` cut into pieces: telegrams of either direction, ACK, NAK, and the bytes between them."""
    found: List[LinePiece] = []
    at = 0
    while at < len(data):
        found.append(_piece_at(data, at))
        at += len(found[-1].data)
    return found


def _piece_at(data: bytes, at: int) -> LinePiece:
    """The piece of `data` that begins at index `at`. If it is no telegram, it ends before the next STX."""
    if data[at] in (Answer.ACK.value, Answer.NAK.value):
        return LinePiece(data[at:at + 1], Answer(data[at]))
    following = data.find(STX, at + 1)
    noise, rest = data[at:following if following >= 0 else len(data)], data[at:at + LONGEST]
    if rest[:1] != STX:
        return LinePiece(noise, None, "noise: no STX (02)")
    if len(rest) < 4:
        return LinePiece(noise, None, "cut off: STX, and not even a length behind it")
    length = int.from_bytes(rest[2:4], "little")
    is_reply = rest[1] >= ANSWERED
    least = 2 if is_reply else 1
    if not least <= length <= LONGEST - OVERHEAD:
        return LinePiece(noise, None, "no telegram: length %d (%d..%d is legal)" % (
            length, least, LONGEST - OVERHEAD))
    if len(rest) > 4 and (rest[4] >= ANSWERED) is not is_reply:
        return LinePiece(noise, None, "no telegram: address %02X does not go with command %02X" % (rest[1], rest[4]))
    missing = length + OVERHEAD - len(rest)
    if missing > 0:
        return LinePiece(noise, None, "cut off: length %d, %d bytes missing" % (
            length, missing))
    whole, sent = rest[:length + OVERHEAD - 2], rest[length + OVERHEAD - 2:length + OVERHEAD]
    telegram = (Telegram(whole[4], whole[5:-1], whole[-1], whole[1] - ANSWERED) if is_reply
                else Telegram(whole[4], whole[5:], None, whole[1]))
    right = crc(whole).to_bytes(2, "little")
    if sent == right:
        return LinePiece(whole + sent, telegram)
    return LinePiece(noise, telegram, "wrong CRC: %s, should be %s" % (hex_of(sent), hex_of(right)))


def explain_line(data: bytes) -> Iterator[str]:
    """The lines of text that explain `data`: any bytes that went over the line of a laser."""
    for piece in line_pieces(data):
        yield from explain_line_piece(piece)


def explain_line_piece(piece: LinePiece) -> Iterator[str]:
    """The lines of text that explain one piece of a line."""
    yield hex_of(piece.data)
    telegram = piece.found
    if telegram is None:
        yield "  %s" % piece.wrong
        return
    if isinstance(telegram, Answer):
        yield "  from the laser: %s" % ANSWERS[telegram]
        return
    yield "  length %d, command %02X, %s" % (
        telegram.length - OVERHEAD, telegram.command,
        piece.wrong + "; it would say:" if piece.wrong else "CRC %s is right" % hex_of(piece.data[-2:]))
    way = "to" if telegram.status is None else "from"
    message = decode(telegram)
    if isinstance(message, UnknownMessage):
        yield "  %s the laser: a telegram of unknown command; data: %s" % (way, value_in_words(message.data))
    elif isinstance(message, MalformedMessage):
        yield "  %s the laser: %s, malformed: its data end too soon: %s" % (
            way, MESSAGES[message.command].__name__, message.problem)
    else:
        yield "  %s the laser: %s. %s" % (way, type(message).__name__, (type(message).__doc__ or "").splitlines()[0])
        sentences, values = _told(message)
        yield from ("    " + line for line in sentences + list(in_table(values, _rows_of(message))))
    if telegram.status is not None:
        yield "    status %02X: %s" % (telegram.status, status_in_words(telegram.status))


ANSWERS = {Answer.ACK: "ACK: the request arrived whole", Answer.NAK: "NAK: the request arrived with a wrong CRC"}
BITS = {
    Status.SPECIAL: "a special device",
    Status.RESTART_INPUT: "restart input",
    Status.IMPLAUSIBLE_VALUES: "implausible values",
    Status.DIRTY_WINDOW: "dirty window",
}
"""What the bits of a status byte say, above those of its severity. An ordinary device has `Status.NORMAL`."""


def status_in_words(status: int) -> str:
    """Return what a status byte says."""
    told = severity(status)
    words = [Severity(told).name.lower() if told in list(Severity) else "severity %d" % told]
    return ", ".join(words + [text for bit, text in BITS.items() if status & bit])


def _told(message: Any) -> Tuple[List[str], Dict[str, Any]]:
    """What a message says: sentences, and values by name. What is reserved is left out, if it is 0 as in the manual."""
    if isinstance(message, ErrorsReply):
        return [_error(error) for error in message.errors] or ["no errors"], {}
    sentences: List[str] = []
    values: Dict[str, Any] = {}
    for name, value in vars(message).items():
        if isinstance(value, RawScan):
            sentences.append(_scan(value))
        elif isinstance(value, Configuration):
            values.update(vars(value))
        elif not name.startswith("reserved_") or (any(value) if isinstance(value, tuple) else value):
            values[name] = value
    return sentences, values


def _error(error: DeviceError) -> str:
    kind = Severity(error.severity).name.lower() if error.severity in list(Severity) else "kind %d" % error.severity
    return "%s, number %d%s" % (kind, error.number, ", over" if error.is_old else "")


def _scan(scan: RawScan) -> str:
    """A scan in one line. What the highest bits of its values are depends on the measuring mode, which it has not."""
    shown = ", ".join(map(str, scan.values[:SHOWN])) + ", ..." * (len(scan.values) > SHOWN)
    return "%s%d values in %s: %s%s" % (
        "partial scan from x.%02d degrees on, " % (25 * scan.quarter) if scan.partial else "", len(scan.values),
        UNITS.get(Unit(scan.unit), "") if scan.unit in list(Unit) else "unit %d" % scan.unit, shown,
        "; turn %d, telegram %d" % scan.indices if scan.indices else "")


def _rows_of(message: Any) -> List[Row]:
    kind: Any = type(message)
    return [*rows(kind), *rows(Configuration)]


def line_piece_in_one_line(piece: LinePiece) -> str:
    """The meaning of one piece of a line, in one line."""
    if isinstance(piece.found, Answer):
        return piece.found.name
    if piece.found is None or piece.wrong:
        data = hex_of(piece.data[:SHOWN]) + " ..." * (len(piece.data) > SHOWN)
        return "%s  (%s)" % (data, piece.wrong)
    message, status = decode(piece.found), piece.found.status or 0
    if isinstance(message, (UnknownMessage, MalformedMessage)):
        text = "%s %02X" % (type(message).__name__, message.command)
    else:
        sentences, values = _told(message)
        table = {row.name: row for row in _rows_of(message)}
        told = sentences + ["%s %s" % (name, value_in_words(value, table.get(name)))
                            for name, value in values.items() if value is not None]
        text = type(message).__name__ + ": " * bool(told) + ", ".join(told)
    well = piece.found.status in (None, Status.NORMAL)
    return text + ("" if well else "  (status %02X: %s)" % (status, status_in_words(status)))


class RecordedBytes(NamedTuple):
    """One line of a record."""

    time: float
    """s"""
    to_laser: bool
    data: bytes


def recorded_bytes(lines: Iterable[str]) -> Iterator[RecordedBytes]:
    """The entries in the lines of a record.

    Raises:
        UsageError: a line is no entry. The message has its number and its text.
    """
    for number, line in enumerate(lines, 1):
        if line.strip():
            try:
                time, way, data = line.split(maxsplit=2)
                yield RecordedBytes(float(time), {">": True, "<": False}[way], parse_hex(data))
            except (ValueError, KeyError) as error:
                raise UsageError("line %d of the record: %r is not 'TIME > BYTES' or 'TIME < BYTES'"
                                 % (number, line.strip())) from error


def explain_laser_record(record: Iterable[RecordedBytes], long: bool = False) -> Iterator[str]:
    """The lines of text that explain a record, each piece with the time (s) of its last byte.

    Args:
        record: the entries of the record.
        long: True to explain each piece byte by byte; False for one line per piece.
    """
    held: Dict[bool, Tuple[float, bytes]] = {}      # the last time and the unfinished bytes of each way

    def lines(time: float, to_laser: bool, found: List[LinePiece]) -> Iterator[str]:
        head = "%12.6f  %s " % (time, ">" if to_laser else "<")
        for piece in found:
            if long:
                yield head.rstrip()
                yield from explain_line_piece(piece)
            else:
                yield head + line_piece_in_one_line(piece)

    for time, to_laser, data in record:
        for way, (before, rest) in list(held.items()):
            if rest and time - before >= PARTIAL_TIMEOUT:
                yield from lines(before, way, line_pieces(rest))
                del held[way]
        found = line_pieces(held.get(to_laser, (time, b""))[1] + data)
        whole = next((index for index, piece in enumerate(found) if piece.wrong.startswith("cut off")), len(found))
        held[to_laser] = time, b"".join(piece.data for piece in found[whole:])
        yield from lines(time, to_laser, found[:whole])
    for way, (before, rest) in held.items():
        yield from lines(before, way, line_pieces(rest))
