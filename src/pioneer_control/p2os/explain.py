"""Explains bytes of the protocol in words, for a person who reads a hex dump.

All names, units and meanings come from the tables in the other files of this folder.
"""

from typing import Any, Iterator, List, NamedTuple, Optional

from ..wire_words import hex_of, in_table, value_in_words
from .commands import (COMMAND_NUMBERS, NEGATIVE, OTHER_MEANINGS, POSITIVE, TEXT, Argument, Command, decode_command,
                       two_bytes)
from .flags import GripperCommand
from .framing import HEADER, SMALLEST_COUNT, Frame, checksum
from .packets import NAMES_ONLY, MalformedPacket, UnknownPacket, decode_packet, packet_rows
from .simulator_commands import SIMULATOR_COMMANDS, decode_simulator_command

LONGEST = 3 + 0xFF
"""Number of bytes in the longest frame."""


class Piece(NamedTuple):
    """Some bytes of a stream: either a whole frame, or bytes that are not a frame. Then `wrong` says why.

    Bytes with a wrong checksum have a `frame`, too. It is the frame that they would be with a right checksum.
    """

    data: bytes
    frame: Optional[Frame]
    wrong: str = ""


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
    wrong = "wrong checksum: %s, should be %s; it would say:" % (hex_of(sent), hex_of(right))
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
    yield hex_of(piece.data)
    if frame is None:
        yield "  %s" % piece.wrong
        return
    yield "  byte count %d, id %d (0x%02X), %s" % (
        frame.length - 3, frame.id, frame.id, piece.wrong or "checksum %s is right" % hex_of(piece.data[-2:]))
    is_command = frame.id in COMMAND_NUMBERS and not _argument_fault(frame.data)
    is_packet = not isinstance(decode_packet(frame), (UnknownPacket, MalformedPacket))
    if to_robot and (is_command or not (from_robot and is_packet)):
        yield from _explain_command(frame)
    if from_robot and (is_packet or not (to_robot and is_command)):
        yield from _explain_packet(frame, grip_state_first)


def in_one_line(piece: Piece, to_robot: bool, grip_state_first: bool = True) -> str:
    """The meaning of one piece of a stream, in one line. `to_robot` is its direction."""
    if piece.frame is None or piece.wrong:
        return "%s  (%s)" % (hex_of(piece.data), piece.wrong.partition(", should")[0])
    packet = decode_packet(piece.frame, grip_state_first)
    if to_robot or isinstance(packet, (UnknownPacket, MalformedPacket)):
        lines = _explain_command(piece.frame) if to_robot else _explain_packet(piece.frame, grip_state_first)
        return next(lines).partition(": ")[2]
    rows = {row.name: row for row in packet_rows(type(packet), grip_state_first)}
    return "%s: %s" % (type(packet).__name__, ", ".join(
        "%s %s" % (name, value_in_words(value, rows.get(name)))
        for name, value in vars(packet).items() if value is not None))


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
    order = decode_simulator_command(frame)
    if order is not None:
        values = " ".join(value_in_words(each) for each in order.values)
        yield "    (simulators: %s: %s)" % (" ".join(filter(None, (order.name, values))),
                                            SIMULATOR_COMMANDS[order.name].effect)
    yield from ("    (%s: %s)" % (who, meaning) for number, who, meaning in OTHER_MEANINGS if number == frame.id)


def _command_value(command: Command, value: Any) -> str:
    if isinstance(value, bytes):
        return value_in_words(value)
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
    rows = packet_rows(type(packet), grip_state_first)
    yield from ("    " + line for line in in_table(vars(packet), rows))
    absent = [row.name for row in rows if getattr(packet, row.name) is None]
    if absent:
        yield "    not sent by this firmware: %s" % ", ".join(absent)
