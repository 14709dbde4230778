"""What bytes say, in words: for a person with a hex dump.

Names, units and meanings come from the tables of this folder: nothing is known only here.
"""

import re
from enum import IntFlag
from fractions import Fraction
from typing import Iterator, List, NamedTuple, Optional

from ..errors import UsageError
from .commands import (COMMAND_NUMBERS, NEGATIVE, OTHER_MEANINGS, POSITIVE, TEXT, Argument, decode_command,
                       two_bytes)
from .flags import GripperCommand
from .framing import HEADER, SMALLEST_COUNT, Frame, FrameDecoder, checksum
from .packets import NAMES_ONLY, MalformedPacket, UnknownPacket, decode_packet, packet_rows


LONGEST = 3 + 0xFF
"""Bytes of the longest frame."""


class Piece(NamedTuple):
    """Some bytes of a stream: a whole frame, or bytes that belong to none, with what is `wrong` with them.

    Those of a wrong checksum have a frame all the same: what they would say.
    """

    data: bytes
    frame: Optional[Frame]
    wrong: str = ""


def parse_hex(text: str) -> bytes:
    """The bytes that `text` writes down: ``FA FB 06``, ``fafb06``, ``0xFA, 0xFB, 0x06`` or ``\\xfa\\xfb\\x06``.

    Raises:
        UsageError: naming what is no hex.
    """
    data = bytearray()
    for word in re.sub(r"0[xX]|\\x|[\s,;:]", " ", text).split():
        if not re.fullmatch(r"[0-9A-Fa-f]|([0-9A-Fa-f]{2})+", word):
            why = "has an odd number of digits" if re.fullmatch(r"[0-9A-Fa-f]+", word) else "is not hexadecimal"
            raise UsageError(f"{word!r} {why}; bytes are given like this: FA FB 03 1D 00 1D")
        data += bytes.fromhex(word.rjust(2, "0"))
    return bytes(data)


def pieces(data: bytes) -> List[Piece]:
    """`data` cut into whole frames and what lies between them, each with what is wrong with it."""
    found, noise_from, at = [], 0, 0
    while at < len(data):
        frame = _frame_at(data, at)
        if frame is None:
            at += 1
            continue
        found += _noise(data, noise_from, at)
        end = at + len(frame.data) + SMALLEST_COUNT + 3
        found.append(Piece(data[at:end], frame))
        noise_from = at = end
    return found + list(_noise(data, noise_from, at))


def _frame_at(data: bytes, at: int) -> Optional[Frame]:
    if data[at:at + 2] != HEADER or at + 2 == len(data):
        return None
    frames = FrameDecoder().feed(data[at:at + 3 + data[at + 2]])
    return frames[0] if frames and len(frames[0].data) + SMALLEST_COUNT == data[at + 2] else None


def _noise(data: bytes, start: int, end: int) -> Iterator[Piece]:
    """`data[start:end]`, in which no frame is whole, cut before each header."""
    while start < end:
        following = data.find(HEADER, start + 1, end)
        following = following if following >= 0 else end
        yield _broken(data[start:following], data[start:start + LONGEST])
        start = following


def _broken(noise: bytes, rest: bytes) -> Piece:
    """What is wrong with `noise`; `rest` is what the stream has from there on, as far as a frame can reach."""
    if noise[:2] != HEADER:
        return Piece(noise, None, "noise: no header FA FB")
    if len(rest) == 2:
        return Piece(noise, None, "cut off: a header, and nothing behind it")
    count = rest[2]
    if count < SMALLEST_COUNT:
        return Piece(noise, None, f"no packet: byte count {count}, but id and checksum alone are {SMALLEST_COUNT}")
    missing = 3 + count - len(rest)
    if missing > 0:
        return Piece(noise, None, f"cut off: byte count {count}, {missing} missing")
    body, sent = rest[3:count + 1], rest[count + 1:count + 3]
    right = _hex(checksum(body).to_bytes(2, "big"))
    return Piece(noise, Frame(body[0], body[1:]), f"wrong checksum: {_hex(sent)}, should be {right}; it would say:")


def explain(data: bytes, to_robot: bool = True, from_robot: bool = True,
            grip_state_first: bool = True) -> Iterator[str]:
    """The lines that explain `data`.

    Args:
        to_robot, from_robot: the directions to be considered. A number is one thing to the robot and another from it:
            of both, a reading that makes no sense is left out when the other one does.
        grip_state_first: as in `decode_packet`.
    """
    for piece in pieces(data):
        yield from explain_piece(piece, to_robot, from_robot, grip_state_first)


def explain_piece(piece: Piece, to_robot: bool = True, from_robot: bool = True, grip_state_first: bool = True) -> Iterator[str]:
    """The lines that explain one of the `pieces`; arguments as of `explain`."""
    frame = piece.frame
    yield _hex(piece.data)
    if frame is None:
        yield f"  {piece.wrong}"
        return
    checked = piece.wrong or f"checksum {_hex(piece.data[-2:])} is right"
    yield f"  byte count {len(frame.data) + SMALLEST_COUNT}, id {frame.id} (0x{frame.id:02X}), {checked}"
    sense_to, sense_from = _is_command(frame), _is_packet(frame)
    if to_robot and (sense_to or not (from_robot and sense_from)):
        yield from _explain_command(frame)
    if from_robot and (sense_from or not (to_robot and sense_to)):
        yield from _explain_packet(frame, grip_state_first)


def in_one_line(piece: Piece, to_robot: bool, grip_state_first: bool = True) -> str:
    """What one of the `pieces` says, in short."""
    if piece.frame is None or piece.wrong:
        return f"{_hex(piece.data)}  ({piece.wrong.partition(', should')[0]})"
    if to_robot:
        return next(_explain_command(piece.frame)).partition(": ")[2]
    packet = decode_packet(piece.frame, grip_state_first)
    if isinstance(packet, (UnknownPacket, MalformedPacket)):
        return next(_explain_packet(piece.frame, grip_state_first)).partition(": ")[2]
    rows = {row.name: row for row in packet_rows(type(packet), grip_state_first)}
    fields = [f"{name} {_value(value, rows[name]) if name in rows else value}" for name, value in vars(packet).items() if value is not None]
    return f"{type(packet).__name__}: {', '.join(fields)}"


def _is_command(frame: Frame) -> bool:
    return frame.id in COMMAND_NUMBERS and not _argument_fault(frame)


def _is_packet(frame: Frame) -> bool:
    return not isinstance(decode_packet(frame), (UnknownPacket, MalformedPacket))


def _argument_fault(frame: Frame) -> str:
    """What keeps the data of a command from being an argument; empty if nothing does."""
    data = frame.data
    if not data:
        return ""
    if data[0] not in (POSITIVE, NEGATIVE, TEXT):
        return f"{data[0]:02X} is no argument type (3B, 1B, 2B)"
    if data[0] == TEXT and (len(data) < 2 or len(data) < 2 + data[1]):
        return "a string that is cut off"
    if data[0] != TEXT and len(data) == 2:
        return "an integer that is cut off"
    return ""


def _explain_command(frame: Frame) -> Iterator[str]:
    received, command = decode_command(frame), COMMAND_NUMBERS.get(frame.id)
    fault = _argument_fault(frame)
    if command is None:
        yield f"  to the robot: command {frame.id}, which no Pioneer knows"
    else:
        value = "" if received.value is None else f" {_command_value(command, received.value)}"
        yield f"  to the robot: {command.name}{value}"
        yield f"    {command.effect}"
    if fault:
        yield f"    its argument is broken: {fault}"
    for other in OTHER_MEANINGS:
        if other.number == frame.id:
            yield f"    ({other.who}: {other.meaning})"


def _command_value(command, value) -> str:
    if isinstance(value, bytes):
        return _value(value)
    if command.argument is Argument.TWO_BYTES:
        return ", ".join(str(byte if low < 0 else byte & 0xFF) for byte, low in zip(two_bytes(value), command.low))
    if command.name == "GRIPPER" and value in list(GripperCommand):
        return f"{value} {GripperCommand(value).name}"
    if command.low is not None and not command.low <= value <= command.high:
        return f"{value}, out of range ({command.low}..{command.high} is legal)"
    return str(value)


def _explain_packet(frame: Frame, grip_state_first: bool) -> Iterator[str]:
    packet = decode_packet(frame, grip_state_first)
    if isinstance(packet, UnknownPacket):
        name = NAMES_ONLY.get(frame.id, "a packet of unknown type")
        yield f"  from the robot: {name}; what its data mean is not known"
        return
    if isinstance(packet, MalformedPacket):
        yield f"  from the robot: malformed, its data end too soon: {packet.reason}"
        return
    yield f"  from the robot: {type(packet).__name__}. {type(packet).__doc__.splitlines()[0]}"
    table = packet_rows(type(packet), grip_state_first)
    width = max(map(len, vars(packet)), default=0)
    for name in sorted(set(vars(packet)) - {row.name for row in table}):
        yield f"    {name:{width}}  {getattr(packet, name)}"
    for row in table:
        value = getattr(packet, row.name)
        if value is not None:
            yield f"    {row.name:{width}}  {_value(value, row):20}  {row.meaning}".rstrip()
    absent = [row.name for row in table if getattr(packet, row.name) is None]
    if absent:
        yield f"    not sent by this firmware: {', '.join(absent)}"


def _value(value, row=None) -> str:
    if isinstance(value, tuple):
        return "; ".join(map(_item, value)) or "none"
    if isinstance(value, bytes):
        return f"{_hex(value)} {value.decode('latin-1')!r}" if value else "none"
    if isinstance(value, str):
        return repr(value)
    names = row.type.names
    if names is None:
        return f"{value}{_in_units(value, row)}"
    if issubclass(names, IntFlag):
        unnamed = value & ~sum(names)
        bits = [bit.name for bit in names if value & bit] + [f"0x{unnamed:X}"] * bool(unnamed)
        return f"0x{value:02X} {', '.join(bits)}".rstrip()
    return f"{value} {names(value).name}" if value in list(names) else f"{value}{_in_units(value, row)}"


def _item(item) -> str:
    """One of many: a number, or a record as ``number 3, range_units 1500``."""
    return str(item) if isinstance(item, int) else ", ".join(f"{name} {value}" for name, value in vars(item).items())


def _in_units(value: int, row) -> str:
    """`value` in the unit of its row, which may begin with the size of a step: ``0.1 V``, ``5/255 V``."""
    step, _, unit = row.unit.partition(" ")
    if re.fullmatch(r"[0-9./]+", step):
        return f" = {float(value * Fraction(step)):.6g} {unit}".rstrip()
    return f" {row.unit}".rstrip()


def _hex(data: bytes) -> str:
    return " ".join(f"{byte:02X}" for byte in data)
