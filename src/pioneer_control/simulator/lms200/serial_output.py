"""The bytes that a laser sends, on their way over its serial line: ten bits a byte, one after the other."""

from collections import deque
from dataclasses import dataclass
from typing import Deque, List, NamedTuple

from ...lms2xx.rates import BITS_OF_A_BYTE

_BIT_TIME = BITS_OF_A_BYTE * 1000000     # microseconds that a byte takes, times the speed (baud)


class SentBytes(NamedTuple):
    """Bytes that have left the laser, and the speed (baud) at which they were sent."""

    baud: int
    data: bytes


@dataclass
class _LineRun:
    """Bytes that leave without a pause.

    `begin_us` is the time at which the first bit leaves. `taken` is the number of bytes that were already taken.
    """

    begin_us: int
    baud: int
    data: bytes
    taken: int = 0

    def complete_bytes(self, now_us: int) -> int:
        """Return how many of the bytes have left completely."""
        return max(0, min(len(self.data), (now_us - self.begin_us) * self.baud // _BIT_TIME))

    def begun_bytes(self, now_us: int) -> int:
        """Return how many of the bytes have left, or are just leaving."""
        return max(0, min(len(self.data), _ceil((now_us - self.begin_us) * self.baud, _BIT_TIME)))

    @property
    def end_us(self) -> int:
        """The time at which the last byte has left."""
        return self.begin_us + _ceil(len(self.data) * _BIT_TIME, self.baud)


class SerialOutput:
    """The sending half of the laser's serial line, in simulated time (microseconds).

    Args:
        takes_time: whether bytes take their time on the line. If not, they leave at once.
    """

    def __init__(self, takes_time: bool = True):
        self._takes_time = takes_time
        self._under_way: Deque[_LineRun] = deque()
        self._left: List[SentBytes] = []

    def free_at_us(self, now_us: int) -> int:
        """Return the time at which all bytes will have left; `now_us` if they have."""
        return max(now_us, self._under_way[-1].end_us) if self._under_way else now_us

    def put(self, data: bytes, baud: int, now_us: int) -> None:
        """Send bytes at some speed (baud), after those that are on their way."""
        if self._takes_time:
            self._under_way.append(_LineRun(self.free_at_us(now_us), baud, data))
        else:
            self._left.append(SentBytes(baud, data))

    def cut(self, now_us: int) -> None:
        """Stop. The byte that is just leaving leaves completely, and all bytes behind it are dropped."""
        for run in self._under_way:
            run.data = run.data[:run.begun_bytes(now_us)]
        self._under_way = deque(run for run in self._under_way if run.data)

    def take(self, now_us: int) -> List[SentBytes]:
        """Return all bytes that have left until `now_us` and were not returned before, in their order."""
        left, self._left = self._left, []
        while self._under_way:
            run = self._under_way[0]
            count = run.complete_bytes(now_us)
            if count > run.taken:
                left.append(SentBytes(run.baud, run.data[run.taken:count]))
                run.taken = count
            if count < len(run.data):
                break
            self._under_way.popleft()
        return left


def _ceil(number: int, divisor: int) -> int:
    return -(-number // divisor)
