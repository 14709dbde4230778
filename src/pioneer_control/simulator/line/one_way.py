"""One direction of a robot's line, in simulated time. It delays bytes by their transmission time, and damages or drops
bytes when it has a fault.

This file uses no sockets and no real time. A serial line sends ten bits for each byte; TCP takes no time here.
"""

import random
from collections import deque
from typing import Deque, List, NamedTuple, Optional, Tuple

from ...p2os.framing import HEADER, SMALLEST_COUNT
from ..clock import NEVER_US

BITS_PER_BYTE = 10
"""Bits that a serial line sends for one byte: a start bit, eight data bits, a stop bit."""
FIFO = 16
"""Number of bytes that a serial port delivers at a time, as common UARTs do. Therefore packets arrive in pieces."""
SPLIT_PAUSE_US = 50000
"""Pause between the two pieces of a split packet (microseconds). It is shorter than the time-out of partial packets."""


class LineErrors(NamedTuple):
    """The active errors of one direction of a line. Each field has the name of its kind of fault."""

    loss: float = 0.0
    """Share of the packets that never arrive, 0 to 1."""
    flips: float = 0.0
    """Share of the bytes that arrive with one wrong bit, 0 to 1."""
    splits: float = 0.0
    """Share of the packets that arrive in two pieces, 0 to 1."""
    delay: float = 0.0
    """Additional delay of all bytes (s)."""
    silence: bool = False
    """Whether no bytes arrive."""


class Burst(NamedTuple):
    """Bytes that arrive together, at the simulated time `due_us` (microseconds).

    `baud` is the baud rate with which they were sent, None for TCP.
    """

    due_us: int
    baud: Optional[int]
    data: bytes


class OneWay:
    """One direction of a line, with its errors and the bytes that are on their way.

    Args:
        seed: seed of the random errors. The same bytes get the same errors, in whatever pieces they are sent.

    Attributes:
        errors: present errors of this direction.
    """

    def __init__(self, seed: str):
        self.errors = LineErrors()
        self._chance = random.Random(seed)
        self._ruler = Ruler()
        self._lost = False
        self._cut = 1.0
        self._free_at_us = 0
        self._under_way: Deque[Burst] = deque()

    def send(self, data: bytes, now_us: int, baud: Optional[int] = None) -> None:
        """Send bytes over the line, after the bytes that it still transmits.

        Args:
            data: the bytes.
            now_us: present simulated time (microseconds).
            baud: baud rate, or None for TCP, which takes no time.
        """
        at_us = max(now_us, self._free_at_us)
        delay_us = round(self.errors.delay * 1e6)
        for pause_us, run in self._spoilt(data):
            at_us += pause_us
            if baud is None:
                self._under_way.append(Burst(at_us + delay_us, None, run))
                continue
            for end in range(FIFO, len(run) + FIFO, FIFO):
                due_us = at_us + min(end, len(run)) * BITS_PER_BYTE * 1000000 // baud
                self._under_way.append(Burst(due_us + delay_us, baud, run[end - FIFO:end]))
            at_us += len(run) * BITS_PER_BYTE * 1000000 // baud
        self._free_at_us = at_us

    def arrived(self, now_us: int) -> List[Burst]:
        """Remove and return the bytes that have arrived until `now_us` (microseconds), oldest first.

        They are lost, and the list is empty, while the line has the error `silence`.
        """
        out: List[Burst] = []
        while self.next_us <= now_us:
            out.append(self._under_way.popleft())
        return [] if self.errors.silence else out

    @property
    def next_us(self) -> int:
        """The simulated time at which the next bytes arrive (microseconds). `NEVER_US` if no bytes are on their way."""
        return self._under_way[0].due_us if self._under_way else NEVER_US

    def backlog_us(self, now_us: int) -> int:
        """Return how long after `now_us` the line is still busy with its bytes (microseconds). 0 if it is not busy."""
        return max(0, self._free_at_us - now_us)

    def clear(self) -> None:
        """Drop all bytes that are on their way."""
        self._under_way.clear()
        self._free_at_us = 0

    def _spoilt(self, data: bytes) -> List[Tuple[int, bytes]]:
        """Apply the errors loss, flips and splits to bytes.

        Returns:
            Pieces of the bytes that are not lost, each with the pause before it (microseconds).
        """
        loss, flips, splits = self.errors[:3]
        if not (loss or flips or splits):
            self._lost, self._cut = False, 1.0
            self._ruler.skip(data)
            return [(0, data)]
        chance, runs = self._chance, [(0, bytearray())]
        for byte in data:
            if self._ruler.begins(byte):
                self._lost = chance.random() < loss
                self._cut = chance.random() if chance.random() < splits else 1.0
            flipped = chance.random() < flips
            wrong = 1 << chance.randrange(8)
            if self._ruler.is_cut(self._cut):
                runs.append((SPLIT_PAUSE_US, bytearray()))
            if not self._lost:
                runs[-1][1].append(byte ^ wrong if flipped else byte)
        return [(pause_us, bytes(run)) for pause_us, run in runs if run]


class Ruler:
    """Finds the beginnings of packets in a stream of bytes, byte by byte.

    A byte that does not belong to a packet counts as a packet of one byte.
    """

    def __init__(self) -> None:
        self._at = 0        # number of processed bytes of the present packet
        self._length = 0    # length of the present packet in bytes; 0 while it is not known

    def begins(self, byte: int) -> bool:
        """Process the next byte of the stream, and return whether a packet begins with it."""
        begins = self._at == 0 or self._at == 1 and byte == HEADER[0]
        self._at = 1 if begins else self._at + 1
        if self._at == 3:
            self._length = 3 + byte
        legal = byte == HEADER[self._at - 1] if self._at < 3 else self._length >= 3 + SMALLEST_COUNT
        if not legal or self._at == self._length:
            self._at = self._length = 0
        return begins

    def skip(self, data: bytes) -> None:
        """Process several bytes of the stream. This is fast if they are exactly one packet."""
        one_packet = data[:2] == HEADER and len(data) > 2 + SMALLEST_COUNT and len(data) == 3 + data[2]
        if self._at > 0 or not one_packet:      # the usual case is exactly one packet
            for byte in data:
                self.begins(byte)

    def is_cut(self, share: float) -> bool:
        """Return whether a packet that is split at `share` of its length is split just before the last processed byte.

        `share` is from 0 to 1; 1 means that the packet is not split. The first three bytes of a packet stay
        together, and so do its last two bytes.
        """
        return share < 1.0 and self._length > 0 and self._at == 1 + max(3, int(share * (self._length - 1)))
