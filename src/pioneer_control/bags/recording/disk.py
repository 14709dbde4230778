"""How long there is room for a recording, and what to say of it in time. Pure: time, free space and size go in, sentences come out."""

from collections import deque
from typing import Deque, Iterator, List, NamedTuple, Tuple

KB, MB, GB = 2 ** 10, 2 ** 20, 2 ** 30
USUAL_RATE = {"lz4": 25 * MB, "bz2": 22 * MB, "none": 120 * MB}
"""Bytes an hour of one robot; bench/recording.md."""
MEASURED_AFTER = 60.0
"""s of recording after which the rate is believed."""
WINDOW = 300.0
"""s over which it is measured."""
WARNINGS = 3600.0, 600.0
"""s before the end of the room at which it is said; again when it was twice as long in between."""


class Notice(NamedTuple):
    """A sentence to say."""

    severity: str
    """info, warning or error"""
    text: str


class Sample(NamedTuple):
    """What was seen at one moment."""

    time: float
    """s, of a clock that only goes forwards"""
    free: int
    """bytes free on the disk"""
    size: int
    """bytes of the recording so far, all parts"""


class DiskWatch:
    """Looks at a disk now and then, and warns well before it is full.

    Args:
        place: the directory of the recording, for the sentences.
        keep_free: bytes below which rosbag ends.
        rate: bytes an hour that are usual.
    """

    def __init__(self, place: str, keep_free: int, rate: float) -> None:
        self._place, self._keep_free, self._usual = place, keep_free, rate
        self._samples: Deque[Sample] = deque()
        self._measured = False
        self.full = False
        """whether less than that is left"""
        self._warned: List[float] = []

    def first(self, sample: Sample) -> Notice:
        """What to say at the start."""
        self._samples.append(sample)
        hours = (sample.free - self._keep_free) / self._usual
        return Notice("info", f"{in_words(sample.free)} free in {self._place}: room for {_time(hours * 3600)} at the usual "
                      f"{in_words(self._usual)} an hour")

    def look(self, sample: Sample) -> Iterator[Notice]:
        """What to say now; often nothing."""
        self._samples.append(sample)
        while sample.time - self._samples[0].time > WINDOW:
            self._samples.popleft()
        room = sample.free - self._keep_free
        if room <= 0:
            if not self.full:
                self.full = True
                yield Notice("error", f"the disk is full: {in_words(sample.free)} free in {self._place}. "
                             f"Below {in_words(self._keep_free)} (keep_free) rosbag closes the bag, within 20 s, and ends; "
                             "what comes later is not recorded")
            return
        if self.full:
            self.full = False
            yield Notice("warning", f"there is room again in {self._place}, {in_words(sample.free)}: the recording goes on")
        rate, measured = self.rate()
        left = room / rate if rate > 0 else float("inf")
        if measured and not self._measured:
            self._measured = True
            written = self._written()
            yield Notice("info", f"{in_words(written * 3600)} an hour are written: room for {_time(left)}"
                         + (f" (others fill the disk too: {in_words(rate * 3600)} an hour in all)" if rate > 2 * written + 1 else ""))
        self._warned = [limit for limit in self._warned if left < 2 * limit]
        due = [limit for limit in WARNINGS if left < limit and limit not in self._warned]
        if due:
            self._warned += due
            yield Notice("warning", f"the disk will be full in {_time(left)}: {in_words(sample.free)} free in {self._place}, and rosbag ends "
                         f"below {in_words(self._keep_free)} (keep_free). Make room, or record elsewhere (bag:=)")

    def rate(self) -> Tuple[float, bool]:
        """Bytes a second by which the room shrinks, whoever writes, and whether that is measured; else the usual."""
        first, last = self._samples[0], self._samples[-1]
        seconds = last.time - first.time
        if seconds < MEASURED_AFTER:
            return self._usual / 3600, False
        return max(self._written(), (first.free - last.free) / seconds), True

    def _written(self) -> float:
        """Bytes a second that the recording grows."""
        first, last = self._samples[0], self._samples[-1]
        return (last.size - first.size) / (last.time - first.time)


def in_words(size: float) -> str:
    """Bytes for people."""
    for unit, name in ((GB, "GB"), (MB, "MB"), (KB, "kB")):
        if size >= unit:
            return f"{size / unit:.3g} {name}" if size < 1000 * unit else f"{size / unit:.0f} {name}"
    return f"{size:.0f} bytes"


def _time(seconds: float) -> str:
    """A time for people."""
    for unit, name in ((86400.0, "days"), (3600.0, "hours"), (60.0, "minutes")):
        if seconds >= 2 * unit:
            return "more than a year" if seconds > 366 * 86400 else f"about {seconds / unit:.0f} {name}"
    return f"about {max(0.0, seconds):.0f} s"
