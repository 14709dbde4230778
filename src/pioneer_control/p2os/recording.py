"""The record of a line as text: which bytes went over the line, when, and in which direction.

::

    # pioneer_control line record 1: s, robot, > to it or < from it, bytes as its client wrote and got them
    0.480000 1 > FA FB 03 00 00 00
    0.480000 1 < FA FB 03 00 00 00
    # 0.500000 fault begins: loss 0.1

Lines that begin with # are for people. A packet may be on several lines of the record, in the pieces in which its bytes
came.

A simulated robot writes a record of its own line, with simulated times. The programs of `bags` make a record from a
bag. The simulator plays a record. ``python3 -m pioneer_control.p2os --record FILE`` explains a record.
"""

from contextlib import suppress
from typing import Dict, Iterable, Iterator, List, NamedTuple, Optional, Tuple

from ..errors import UsageError
from ..wire_words import parse_hex
from .commands import COMMANDS, SYNC0, SYNC1, SYNC2
from .explain import Piece, explain_piece, in_one_line, pieces
from .framing import HEADER, PARTIAL_TIMEOUT

TITLE = "# pioneer_control line record 1: s, robot, > to it or < from it, bytes as its client wrote and got them"

LATEST = 1e10
"""The largest legal time (s) in a record. Real times are smaller, even when somebody set the clock meanwhile."""


class Entry(NamedTuple):
    """One line of a record: bytes, or a `note`. `time` is in s. `robot` counts from 1, and is 0 for a note."""

    time: float
    robot: int
    to_robot: bool
    data: bytes
    note: str = ""


def written(entry: Entry) -> str:
    """An entry as a line of text, without the line end."""
    if entry.note:
        return "# %.6f %s" % (entry.time, entry.note)
    return "%.6f %d %s %s" % (
        entry.time, entry.robot, ">" if entry.to_robot else "<", entry.data.hex(" ").upper())


def entries(lines: Iterable[str]) -> Iterator[Entry]:
    """The entries in the lines of a record. Titles and empty lines are left out.

    Raises:
        UsageError: a line is not an entry. The message has the number and the text of the line.
    """
    for number, line in enumerate(lines, 1):
        words = line.split(maxsplit=3)
        if words and words[0] == "#":
            with suppress(ValueError, IndexError):      # a title, or another line for people
                yield Entry(float(words[1]), 0, False, b"", line.split(maxsplit=2)[2].strip())
        elif words:
            try:
                time, robot, way, data = words
                entry = Entry(float(time), int(robot), {">": True, "<": False}[way], parse_hex(data))
                if not abs(entry.time) <= LATEST or entry.robot < 1:
                    raise ValueError
            except (ValueError, KeyError) as error:
                raise UsageError("line %d of the record: %r is not 'TIME ROBOT > BYTES' or 'TIME ROBOT < BYTES'"
                                 % (number, line.strip())) from error
            yield entry


def read_record(path: str) -> List[Entry]:
    """All entries in the file of a record.

    Raises:
        UsageError: the file cannot be read, or one of its lines is not an entry.
    """
    try:
        with open(path, encoding="utf-8") as lines:
            return list(entries(lines))
    except UnicodeDecodeError as error:
        raise UsageError("%s is no record of a line, which is text; that of a bag is made by "
                         "python3 -m pioneer_control.bags.wire FILE.bag" % path) from error
    except (OSError, UsageError) as error:
        raise UsageError("%s: %s" % (path, getattr(error, "strerror", None) or error)) from error


class Steps(Dict[int, Optional[int]]):
    """Finds the SYNC packets in a record. In a session the same packets are PULSE, OPEN and CLOSE.

    A key is the number of a robot. Its value is the id of the last packet from this robot. The value is None after
    CLOSE: from then on 0, 1, 2 are SYNCs, until the robot is connected again. A robot has no key as long as it is
    unknown whether the record begins in a session.
    """

    def name(self, robot: int, to_robot: bool, number: int) -> str:
        """The name of the next packet, which has this id `number`, if it is a SYNC; empty for any other packet."""
        answer = self.get(robot)
        if not to_robot:
            self[robot] = number
        elif number == SYNC0 and answer in (None, SYNC0, SYNC1) or number in (SYNC1, SYNC2) and answer == number - 1:
            return "SYNC%d" % number
        elif number == COMMANDS["CLOSE"].number:
            self[robot] = None
        elif robot not in self:
            self[robot] = number       # a command: a session was open before the record
        return ""


def explain_record(record: Iterable[Entry], long: bool = False, grip_state_first: bool = True) -> Iterator[str]:
    """The lines of text that explain a record packet by packet, each with the time (s) of its last byte.

    Args:
        record: the entries of the record.
        long: True to explain each packet byte by byte, as `explain` does; False for one line per packet.
        grip_state_first: as in `decode_packet`.
    """
    streams: Dict[Tuple[int, bool], Tuple[float, bytes]] = {}   # the last time and the unfinished bytes of each way
    steps = Steps()

    def lines(time: float, robot: int, to_robot: bool, found: List[Piece]) -> Iterator[str]:
        head = "%12.6f  robot %d %s " % (time, robot, "<-" if to_robot else "->")
        for piece in found:
            if long:
                yield head.rstrip()
                yield from explain_piece(piece, to_robot, not to_robot, grip_state_first)
            else:
                step = steps.name(robot, to_robot, piece.frame.id) if piece.frame and not piece.wrong else ""
                yield head + (step or in_one_line(piece, to_robot, grip_state_first))

    for time, robot, to_robot, data, note in record:
        for stream, (before, held) in list(streams.items()):
            if held and time - before >= PARTIAL_TIMEOUT:
                yield from lines(before, *stream, pieces(held))
                del streams[stream]
        if note:
            yield "%12.6f  %s" % (time, note)
            continue
        _, held = streams.get((robot, to_robot), (time, b""))
        found = pieces(held + data)
        held = found.pop().data if found and _unfinished(found[-1]) else b""
        streams[robot, to_robot] = time, held
        yield from lines(time, robot, to_robot, found)
    for stream, (before, held) in streams.items():
        yield from lines(before, *stream, pieces(held))


def _unfinished(piece: Piece) -> bool:
    """Whether this piece may be the beginning of a packet whose other bytes come later."""
    return piece.data == HEADER[:1] or piece.wrong.startswith("cut off")
