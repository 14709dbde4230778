"""One direction of a robot's line, in simulated time: what goes in comes out when the line has carried it, spoilt by
its faults.

No socket, no clock. A serial line takes ten bits for a byte; TCP takes no time here.
"""

import random
from collections import deque
from typing import Deque, List, NamedTuple, Optional, Tuple

from ...p2os.framing import HEADER, SMALLEST_COUNT
from ..clock import NEVER_US

BITS_PER_BYTE = 10
"""Start, eight data, stop."""
FIFO = 16
"""Bytes that a serial port hands over at a time, as the common ones do: packets arrive in pieces."""
SPLIT_PAUSE_US = 50000
"""Between the two pieces of a packet that a fault splits: less than what ends a packet that stays incomplete."""


class LineErrors(NamedTuple):
    """What is wrong with one direction of a line. The names are those of the faults."""

    loss: float = 0.0
    """share of the packets that never arrive"""
    flips: float = 0.0
    """share of the bytes that arrive with one bit wrong"""
    splits: float = 0.0
    """share of the packets that come in two pieces"""
    delay: float = 0.0
    """seconds by which everything comes later"""
    silence: bool = False
    """nothing arrives"""


class Burst(NamedTuple):
    """Bytes that come out together, and the line speed they were sent at; None for TCP."""

    due_us: int
    baud: Optional[int]
    data: bytes


class OneWay:
    """One direction of a line.

    Args:
        seed: of what the errors leave to chance; the same bytes meet the same luck, in whatever pieces they are sent.

    Attributes:
        errors: what is wrong with it now.
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
        """Take bytes that begin now, or behind those that the line is still busy with."""
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
        """What has come out by now, oldest first."""
        out: List[Burst] = []
        while self.next_us <= now_us:
            out.append(self._under_way.popleft())
        return [] if self.errors.silence else out

    @property
    def next_us(self) -> int:
        """When the next bytes come out."""
        return self._under_way[0].due_us if self._under_way else NEVER_US

    def backlog_us(self, now_us: int) -> int:
        """How long the line is busy with what it has taken."""
        return max(0, self._free_at_us - now_us)

    def clear(self) -> None:
        """Lose what is under way."""
        self._under_way.clear()
        self._free_at_us = 0

    def _spoilt(self, data: bytes) -> List[Tuple[int, bytes]]:
        """The bytes without those that are lost, in runs, each with the pause (us) ahead of it."""
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
    """Tells where packets begin in a stream of bytes, one byte at a time.

    A byte that belongs to no packet counts as a packet of its own.
    """

    def __init__(self) -> None:
        self._at = 0        # bytes of the present packet so far
        self._length = 0    # of all of it; 0: not yet known

    def begins(self, byte: int) -> bool:
        """Take a byte; whether a packet begins with it."""
        begins = self._at == 0 or self._at == 1 and byte == HEADER[0]
        self._at = 1 if begins else self._at + 1
        if self._at == 3:
            self._length = 3 + byte
        legal = byte == HEADER[self._at - 1] if self._at < 3 else self._length >= 3 + SMALLEST_COUNT
        if not legal or self._at == self._length:
            self._at = self._length = 0
        return begins

    def skip(self, data: bytes) -> None:
        """Take many bytes."""
        one_packet = data[:2] == HEADER and len(data) > 2 + SMALLEST_COUNT and len(data) == 3 + data[2]
        if self._at > 0 or not one_packet:      # nearly always it is one
            for byte in data:
                self.begins(byte)

    def is_cut(self, share: float) -> bool:
        """Whether the byte just taken is the first beyond this share of its packet (1: none is).

        The first three bytes and the last two of a packet stay together.
        """
        return share < 1.0 and self._length > 0 and self._at == 1 + max(3, int(share * (self._length - 1)))
