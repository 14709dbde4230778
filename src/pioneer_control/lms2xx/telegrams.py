"""Telegrams: where one begins and ends on the line of a laser, and whether it arrived whole (laser sheet 1.1, 1.2).

::

    02  00  02 00  20 24  34 08         a request: stream complete scans
    │   │   │      │  │   └ CRC, low byte first, as all numbers are
    │   │   │      │  └ data
    │   │   │      └ command
    │   │   └ length: from the command to the last byte before the CRC
    │   └ address: 00 is every laser; a laser answers with 80 more
    └ STX

    06  02  80  03 00  A0 00  10  16 0A         the answer: heard, and done
    │                  │      └ status of the laser, in each reply
    │                  └ command, and 80 more
    └ ACK: this request arrived whole. After a wrong CRC comes NAK (15) alone

Bytes are not escaped: ``02`` may occur inside a telegram.
"""

import enum
from typing import Any, List, NamedTuple, Optional, Union

import numpy as np

from ..errors import EncodingError
from ..wire_fields import checked_integer

Array = Any     # of numpy

STX = b"\x02"
ANSWERED = 0x80
"""What a laser adds to the address and to the command in its reply."""
OVERHEAD = 6
"""Bytes of a telegram that its length does not count: STX, address, the length itself, and the CRC."""
LONGEST = 814
"""Bytes of the longest telegram: a scan of 401 values with its two indices."""
PARTIAL_TIMEOUT = 0.1
"""Time (s) without a byte inside a telegram, after which the rest will not come. Then call
`TelegramDecoder.drop_partial`. A laser pauses for 14 ms at most; an adapter of USB may add as much again."""


class Answer(enum.Enum):
    """The single byte by which a laser says whether a request arrived whole. Not all programs look at it."""

    ACK = 0x06
    NAK = 0x15


_ANSWERS = {answer.value: answer for answer in Answer}


class Telegram(NamedTuple):
    """One telegram.

    Attributes:
        command: its number: 0..127 is a request, 128..255 a reply.
        data: what follows the command.
        status: of the laser, in a reply; None in a request. See `Status`.
        address: of the laser, without the 80 (hex) that a reply adds.
    """

    command: int
    data: bytes = b""
    status: Optional[int] = None
    address: int = 0

    @property
    def length(self) -> int:
        """The number of bytes of the whole telegram on the line."""
        return OVERHEAD + 1 + len(self.data) + (self.status is not None)


class Status(enum.IntFlag):
    """Bits of the status byte, above the three of `Severity`."""

    NORMAL = 0x10
    """An ordinary device. Together with the next bit: a special one."""
    SPECIAL = 0x08
    RESTART_INPUT = 0x20
    IMPLAUSIBLE_VALUES = 0x40
    DIRTY_WINDOW = 0x80


class Severity(enum.IntEnum):
    """What the lowest three bits of the status byte say."""

    OK = 0
    INFORMATION = 1
    WARNING = 2
    ERROR = 3
    FATAL = 4


def severity(status: int) -> int:
    """Return what a status byte says of the laser: a `Severity`, or 5 to 7, which nobody has explained."""
    return status & 0x07


class TelegramCounts(NamedTuple):
    """Counters of a `TelegramDecoder`, since it was made."""

    telegrams: int = 0
    """Number of telegrams that it has returned."""
    answers: int = 0
    """Number of ACK and NAK that it has returned."""
    discarded_bytes: int = 0
    """Number of bytes that belonged to none of these."""
    wrong_crcs: int = 0
    """How often bytes looked like a telegram, but the CRC was wrong."""


def _shifted(register: Array) -> Array:
    """What a register of the CRC becomes when the next byte comes, before that byte is added."""
    return (register << 1 ^ (register >> 15) * 0x8005) & 0xFFFF


def _shares() -> Array:
    """What each bit of the longest telegram adds to the CRC: eight numbers for each place of a byte, from the first
    place to the last one, and from the highest bit to the lowest one.
    """
    bits = 1 << np.arange(7, -1, -1)
    rows = [bits]                               # at the end: the byte itself
    rows.append(_shifted(bits) ^ bits << 8)     # one before it: also as the previous byte of the last one
    while len(rows) < LONGEST:
        rows.append(_shifted(rows[-1]))
    return np.array(rows[::-1], dtype=np.uint16).ravel()


_SHARES = _shares()


def crc(data: bytes) -> int:
    """The CRC of a telegram, from its STX to the last byte before the CRC: at most `LONGEST` bytes.

    A register is 0 at first. Each byte shifts it by one bit: it is none of the usual CRCs of 16 bits, which shift by
    eight. 8005 (hex) is added when a 1 leaves the register. Then the previous byte and this one are added, as a high
    and a low byte. To add is to XOR, so the CRC is the XOR of what each bit adds for itself, which is in a table.
    Without the table, the CRC would be most of what a scan costs.
    """
    bits = np.unpackbits(np.frombuffer(data, np.uint8))
    return int(np.bitwise_xor.reduce(_SHARES[len(_SHARES) - len(bits):] * bits))


def encode_telegram(telegram: Telegram) -> bytes:
    """The bytes of one telegram.

    Raises:
        EncodingError: a number does not fit into its byte, a reply has no status or a request has one, or the telegram
            is longer than 814 bytes.
    """
    for value, most, what in ((telegram.command, 0xFF, "command"), (telegram.address, 0x7F, "address"),
                              (telegram.status or 0, 0xFF, "status")):
        checked_integer(value, 0, most, "%s of a telegram" % what)
    is_reply = telegram.command >= ANSWERED
    if is_reply != (telegram.status is not None):
        raise EncodingError("telegram %02X: a reply (80..FF) has a status, and a request (00..7F) has none"
                            % telegram.command)
    if telegram.length > LONGEST:
        raise EncodingError("telegram %02X: %d bytes are too many (%d are legal)"
                            % (telegram.command, telegram.length, LONGEST))
    head = STX + bytes((telegram.address | (ANSWERED if is_reply else 0),))
    head += (telegram.length - OVERHEAD).to_bytes(2, "little")
    whole = head + bytes((telegram.command,)) + telegram.data
    whole += bytes((telegram.status,)) if telegram.status is not None else b""
    return whole + crc(whole).to_bytes(2, "little")


class TelegramDecoder:
    """Finds the telegrams in a stream of bytes that may come in pieces of any size and with any noise.

    Give all received bytes to `feed`. It never raises, whatever the bytes are. It holds at most one unfinished telegram
    (814 bytes). When bytes look like a telegram but are none, only the first byte is dropped, and the search goes on
    right behind it. So noise never hides a good telegram.

    Args:
        from_laser: the stream comes from a laser: it has replies, ACK and NAK. Otherwise it goes to a laser: it has
            requests.
    """

    def __init__(self, from_laser: bool) -> None:
        self._reply_bit = ANSWERED if from_laser else 0
        self._held = b""
        self._telegrams = self._answers = self._discarded = self._wrong_crcs = 0

    @property
    def waiting(self) -> bool:
        """Whether the decoder holds bytes that may become a telegram."""
        return bool(self._held)

    @property
    def held_bytes(self) -> int:
        """The number of such bytes."""
        return len(self._held)

    @property
    def counts(self) -> TelegramCounts:
        """The numbers of telegrams and of discarded bytes since the decoder was made."""
        return TelegramCounts(self._telegrams, self._answers, self._discarded, self._wrong_crcs)

    def feed(self, data: bytes) -> List[Union[Telegram, Answer]]:
        """What is complete with these bytes, in the order of the line. `data` follows all bytes that were fed before.

        Bytes that cannot become a telegram are dropped. An unfinished telegram is kept.
        """
        held, at, found = self._held + data, 0, []      # type: bytes, int, List[Union[Telegram, Answer]]
        while at < len(held):
            if self._reply_bit and held[at] in _ANSWERS:
                found.append(_ANSWERS[held[at]])
                self._answers += 1
                at += 1
                continue
            end = self._telegram_end(held, at)
            if end is None:
                break
            if end:
                found.append(self._telegram(held[at:end]))
                self._telegrams += 1
                at = end
            else:
                self._discarded += 1
                at += 1
        self._held = held[at:]
        return found

    def drop_partial(self) -> List[Union[Telegram, Answer]]:
        """Give up the unfinished telegram, because `PARTIAL_TIMEOUT` passed without a byte.

        Returns:
            What begins inside the unfinished telegram and is whole. After this call no bytes are held.
        """
        found: List[Union[Telegram, Answer]] = []
        while self._held:
            self._held = self._held[1:]
            self._discarded += 1
            found += self.feed(b"")
        return found

    def _telegram_end(self, held: bytes, at: int) -> Optional[int]:
        """The index behind the telegram at index `at`; 0 if none is there; None if more bytes are needed."""
        head = held[at:at + 5]
        if head[:1] != STX:
            return 0
        if len(head) > 1 and head[1] & ANSWERED != self._reply_bit:
            return 0
        if len(head) < 4:
            return None
        end = at + OVERHEAD + int.from_bytes(head[2:4], "little")
        least = OVERHEAD + (2 if self._reply_bit else 1)
        if not least <= end - at <= LONGEST or (len(head) > 4 and head[4] & ANSWERED != self._reply_bit):
            return 0
        if end > len(held):
            return None
        if crc(held[at:end - 2]) != int.from_bytes(held[end - 2:end], "little"):
            self._wrong_crcs += 1
            return 0
        return end

    def _telegram(self, whole: bytes) -> Telegram:
        """The content of the bytes of a whole telegram."""
        address = whole[1] & ~ANSWERED
        if self._reply_bit:
            return Telegram(whole[4], whole[5:-3], whole[-3], address)
        return Telegram(whole[4], whole[5:-2], None, address)
