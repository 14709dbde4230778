"""A record of a line as text: who sent which bytes when. ``python3 -m pioneer_control.p2os --record FILE`` tells it.

A simulated robot writes it, in simulated s, and `bags.wire` makes one of a bag; `simulator.played_robot` and `simulator.played_client` play it.

::

    # pioneer_control line record 1: s, robot, > to it or < from it, bytes as its client wrote and got them
    0.480000 1 > FA FB 03 00 00 00
    0.480000 1 < FA FB 03 00 00 00
    # 0.500000 fault begins: loss 0.1

Lines that begin with # are for people. A packet may be spread over several lines, which is how it went over the line.
"""

from typing import Dict, Iterable, Iterator, List, NamedTuple, Optional, Tuple

from ..errors import UsageError
from .commands import COMMANDS, SYNC0, SYNC1, SYNC2
from .explain import Piece, explain_piece, in_one_line, parse_hex, pieces
from .framing import HEADER, PARTIAL_TIMEOUT

TITLE = "# pioneer_control line record 1: s, robot, > to it or < from it, bytes as its client wrote and got them"

LATEST = 1e10
"""s: no record is so long, also where a clock was set meanwhile."""


class Entry(NamedTuple):
    """One line of a record: bytes, or a `note`."""

    time: float
    robot: int
    to_robot: bool
    data: bytes
    note: str = ""


def written(entry: Entry) -> str:
    """The line that says it, without its end."""
    if entry.note:
        return f"# {entry.time:.6f} {entry.note}"
    return f"{entry.time:.6f} {entry.robot} {'>' if entry.to_robot else '<'} {entry.data.hex(' ').upper()}"


def entries(lines: Iterable[str]) -> Iterator[Entry]:
    """What the lines of a record say, titles and empty lines left out.

    Raises:
        UsageError: naming the line that says nothing.
    """
    for number, line in enumerate(lines, 1):
        words = line.split(maxsplit=3)
        if not words:
            continue
        try:
            if words[0] == "#":
                yield Entry(float(words[1]), 0, False, b"", line.split(maxsplit=2)[2].strip())
            else:
                time, robot, way, data = words
                entry = Entry(float(time), int(robot), {">": True, "<": False}[way], parse_hex(data))
                if not abs(entry.time) <= LATEST or entry.robot < 1:
                    raise ValueError
                yield entry
        except (ValueError, KeyError, IndexError) as error:
            if words[0] != "#":
                raise UsageError(f"line {number} of the record: {line.strip()!r} is not 'TIME ROBOT > BYTES' or 'TIME ROBOT < BYTES'") from error


def read_record(path: str) -> List[Entry]:
    """All that a file says.

    Raises:
        UsageError: it cannot be read, or a line says nothing.
    """
    try:
        with open(path, encoding="utf-8") as lines:
            return list(entries(lines))
    except (OSError, UnicodeDecodeError, UsageError) as error:
        raise UsageError(unreadable(path, error)) from error


def unreadable(path: str, error: Exception) -> str:
    """Why a file is no record that can be read."""
    if isinstance(error, UnicodeDecodeError):
        return f"{path} is no record of a line, which is text; that of a bag is made by python3 -m pioneer_control.bags.wire FILE.bag"
    return f"{path}: {getattr(error, 'strerror', None) or error}"


def told(lines: Iterable[str], long: bool = False, grip_state_first: bool = True) -> Iterator[str]:
    """A record packet by packet, each with the time of its last byte: in a line, or `long`, as `explain` has it.

    Raises:
        UsageError: as `entries` does.
    """
    streams: Dict[Tuple[int, bool], Tuple[float, bytes]] = {}
    answers: Dict[int, Optional[int]] = {}      # the id of what each robot said last; None since CLOSE: 0, 1, 2 are SYNCs until it is connected

    def step(robot: int, to_robot: bool, piece: Piece) -> str:
        """The name of a step of a connection, whose packets are those of PULSE, OPEN and CLOSE; empty for any other packet."""
        if piece.frame is None or piece.wrong:
            return ""
        number, answer = piece.frame.id, answers.get(robot, -1)
        if not to_robot:
            answers[robot] = number
        elif number == SYNC0 and answer in (None, SYNC0, SYNC1) or number in (SYNC1, SYNC2) and answer == number - 1:
            return f"SYNC{number}"
        elif number == COMMANDS["CLOSE"].number:
            answers[robot] = None
        return ""

    def said(time: float, robot: int, to_robot: bool, found: List[Piece]) -> Iterator[str]:
        head = f"{time:12.6f}  robot {robot} {'<-' if to_robot else '->'} "
        for piece in found:
            if long:
                yield head.rstrip()
                yield from explain_piece(piece, to_robot, not to_robot, grip_state_first)
            else:
                yield head + (step(robot, to_robot, piece) or in_one_line(piece, to_robot, grip_state_first))

    for time, robot, to_robot, data, note in entries(lines):
        for stream, (before, held) in list(streams.items()):
            if held and time - before >= PARTIAL_TIMEOUT:
                yield from said(before, *stream, pieces(held))
                del streams[stream]
        if note:
            yield f"{time:12.6f}  {note}"
            continue
        held = streams.get((robot, to_robot), (time, b""))[1] + data
        found = pieces(held)
        held = found.pop().data if found and _unfinished(found[-1]) else b""
        streams[robot, to_robot] = time, held
        yield from said(time, robot, to_robot, found)
    for stream, (before, held) in streams.items():
        yield from said(before, *stream, pieces(held))


def _unfinished(piece: Piece) -> bool:
    """Whether more bytes can make a packet of it."""
    return piece.data == HEADER[:1] or piece.wrong.startswith("cut off")
