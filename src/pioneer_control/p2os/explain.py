"""Explains bytes of the protocol in words, for a person who reads a hex dump.

All names, units and meanings come from the tables in the other files of this folder.
"""

import re
from enum import IntFlag
from fractions import Fraction
from typing import Any, Iterator, List, NamedTuple, Optional

from ..errors import UsageError
from ..wire_fields import Row
from .commands import (COMMAND_NUMBERS, NEGATIVE, OTHER_MEANINGS, POSITIVE, TEXT, Argument, Command, decode_command,
                       two_bytes)
from .flags import GripperCommand
from .framing import HEADER, SMALLEST_COUNT, Frame, checksum
from .packets import NAMES_ONLY, MalformedPacket, UnknownPacket, decode_packet, packet_rows

LONGEST = 3 + 0xFF
"""Number of bytes in the longest frame."""


class Piece(NamedTuple):
    """Some bytes of a stream: either a whole frame, or bytes that are not a frame. Then `wrong` says why.

    Bytes with a wrong checksum have a `frame`, too. It is the frame that they would be with a right checksum.
    """

    data: bytes
    frame: Optional[Frame]
    wrong: str = ""


def parse_hex(text: str) -> bytes:
    """The bytes in a text such as ``FA FB 06``, ``fafb06``, ``0xFA, 0xFB, 0x06`` or ``\\xfa\\xfb\\x06``.

    Raises:
        UsageError: a word is not hexadecimal. The message names the word.
    """
    data = bytearray()
    for word in re.sub(r"0[xX]|\\x|[\s,;:]", " ", text).split():
        if not re.fullmatch(r"[0-9A-Fa-f]|([0-9A-Fa-f]{2})+", word):
            why = "has an odd number of digits" if re.fullmatch(r"[0-9A-Fa-f]+", word) else "is not hexadecimal"
            raise UsageError("%r %s; bytes are given like this: FA FB 03 1D 00 1D" % (word, why))
        data += bytes.fromhex(word.rjust(2, "0"))
    return bytes(data)


def pieces(data: bytes) -> List[Piece]:
    """`data` cut into pieces: whole frames, and the bytes between them with the reason why they are not a frame."""
    found: List[Piece] = []
    at = 0
    while at < len(data):
        found.append(_piece_at(data, at))
        at += len(found[-1].data)
    return found


def _piece_at(data: bytes, at: int) -> Piece:
    """The piece of `data` that begins at index `at`. If it is not a whole frame, it ends before the next header."""
    header = data.find(HEADER, at + 1)
    noise, rest = data[at:header if header >= 0 else len(data)], data[at:at + LONGEST]
    if rest[:2] != HEADER:
        return Piece(noise, None, "noise: no header FA FB")
    if len(rest) == 2:
        return Piece(noise, None, "cut off: a header, and nothing behind it")
    count = rest[2]
    if count < SMALLEST_COUNT:
        return Piece(
            noise, None, "no packet: byte count %d, but id and checksum alone are %d" % (count, SMALLEST_COUNT))
    if len(rest) < 3 + count:
        return Piece(noise, None, "cut off: byte count %d, %d missing" % (count, 3 + count - len(rest)))
    frame, sent = Frame(rest[3], rest[4:count + 1]), rest[count + 1:count + 3]
    right = checksum(rest[3:count + 1]).to_bytes(2, "big")
    wrong = "wrong checksum: %s, should be %s; it would say:" % (_hex(sent), _hex(right))
    return Piece(rest[:3 + count], frame) if sent == right else Piece(noise, frame, wrong)


def explain(data: bytes, to_robot: bool = True, from_robot: bool = True,
            grip_state_first: bool = True) -> Iterator[str]:
    """The lines of text that explain `data`.

    Args:
        data: any bytes that went over a line.
        to_robot, from_robot: the directions to consider. The same frame has one meaning when it goes to the robot, and
            another when it comes from the robot. If only one of these meanings makes sense, only this one is given.
        grip_state_first: as in `decode_packet`.
    """
    for piece in pieces(data):
        yield from explain_piece(piece, to_robot, from_robot, grip_state_first)


def explain_piece(piece: Piece, to_robot: bool = True, from_robot: bool = True,
                  grip_state_first: bool = True) -> Iterator[str]:
    """The lines of text that explain one piece of a stream. The other arguments are those of `explain`."""
    frame = piece.frame
    yield _hex(piece.data)
    if frame is None:
        yield "  %s" % piece.wrong
        return
    yield "  byte count %d, id %d (0x%02X), %s" % (
        frame.length - 3, frame.id, frame.id, piece.wrong or "checksum %s is right" % _hex(piece.data[-2:]))
    is_command = frame.id in COMMAND_NUMBERS and not _argument_fault(frame.data)
    is_packet = not isinstance(decode_packet(frame), (UnknownPacket, MalformedPacket))
    if to_robot and (is_command or not (from_robot and is_packet)):
        yield from _explain_command(frame)
    if from_robot and (is_packet or not (to_robot and is_command)):
        yield from _explain_packet(frame, grip_state_first)


def in_one_line(piece: Piece, to_robot: bool, grip_state_first: bool = True) -> str:
    """The meaning of one piece of a stream, in one line. `to_robot` is its direction."""
    if piece.frame is None or piece.wrong:
        return "%s  (%s)" % (_hex(piece.data), piece.wrong.partition(", should")[0])
    packet = decode_packet(piece.frame, grip_state_first)
    if to_robot or isinstance(packet, (UnknownPacket, MalformedPacket)):
        lines = _explain_command(piece.frame) if to_robot else _explain_packet(piece.frame, grip_state_first)
        return next(lines).partition(": ")[2]
    rows = {row.name: row for row in packet_rows(type(packet), grip_state_first)}
    return "%s: %s" % (type(packet).__name__, ", ".join(
        "%s %s" % (name, _value(value, rows.get(name))) for name, value in vars(packet).items() if value is not None))


def _argument_fault(data: bytes) -> str:
    """Why the data of a command are not a valid argument. Empty for a valid argument, and when there are no data."""
    if not data:
        return ""
    if data[0] not in (POSITIVE, NEGATIVE, TEXT):
        return "%02X is no argument type (3B, 1B, 2B)" % data[0]
    if data[0] == TEXT and (len(data) < 2 or len(data) < 2 + data[1]):
        return "a string that is cut off"
    return "an integer that is cut off" if data[0] != TEXT and len(data) == 2 else ""


def _explain_command(frame: Frame) -> Iterator[str]:
    value, command, fault = decode_command(frame).value, COMMAND_NUMBERS.get(frame.id), _argument_fault(frame.data)
    if command is None:
        yield "  to the robot: command %d, which no Pioneer knows" % frame.id
    else:
        yield "  to the robot: %s%s" % (command.name, "" if value is None else " " + _command_value(command, value))
        yield "    %s" % command.effect
    if fault:
        yield "    its argument is broken: %s" % fault
    yield from ("    (%s: %s)" % (who, meaning) for number, who, meaning in OTHER_MEANINGS if number == frame.id)


def _command_value(command: Command, value: Any) -> str:
    if isinstance(value, bytes):
        return _value(value)
    if command.argument is Argument.TWO_BYTES:
        return ", ".join(str(byte if low < 0 else byte & 0xFF) for byte, low in zip(two_bytes(value), command.low))
    if command.name == "GRIPPER" and value in list(GripperCommand):
        return "%d %s" % (value, GripperCommand(value).name)
    if command.low is not None and not command.low <= value <= command.high:
        return "%d, out of range (%d..%d is legal)" % (value, command.low, command.high)
    return str(value)


def _explain_packet(frame: Frame, grip_state_first: bool) -> Iterator[str]:
    packet = decode_packet(frame, grip_state_first)
    if isinstance(packet, UnknownPacket):
        yield "  from the robot: %s; what its data mean is not known" % NAMES_ONLY.get(
            frame.id, "a packet of unknown type")
        return
    if isinstance(packet, MalformedPacket):
        yield "  from the robot: malformed, its data end too soon: %s" % packet.reason
        return
    yield "  from the robot: %s. %s" % (type(packet).__name__, (type(packet).__doc__ or "").splitlines()[0])
    rows = {row.name: row for row in packet_rows(type(packet), grip_state_first)}
    width = max(map(len, vars(packet)), default=0)
    for name in sorted(vars(packet), key=lambda name: name in rows):    # first what the id says, which has no row
        value, row = getattr(packet, name), rows.get(name)
        if value is not None:
            yield ("    %-*s  %-20s  %s" % (width, name, _value(value, row), row.meaning if row else "")).rstrip()
    absent = [name for name in rows if getattr(packet, name) is None]
    if absent:
        yield "    not sent by this firmware: %s" % ", ".join(absent)


def _value(value: Any, row: Optional[Row] = None) -> str:
    """A value as text for a person. `row` is None when the value comes from the id of the frame, not from its data."""
    if isinstance(value, tuple):
        return "; ".join(map(_item, value)) or "none"
    if isinstance(value, bytes):
        return "%s %r" % (_hex(value), value.decode("latin-1")) if value else "none"
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


def _hex(data: bytes) -> str:
    return " ".join("%02X" % byte for byte in data)
