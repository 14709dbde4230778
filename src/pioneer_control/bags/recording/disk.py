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
        return Notice("info", "%s free in %s: room for %s at the usual "
                      "%s an hour" % (in_words(sample.free), self._place, _time(hours * 3600), in_words(self._usual)))

    def look(self, sample: Sample) -> Iterator[Notice]:
        """What to say now; often nothing."""
        self._samples.append(sample)
        while sample.time - self._samples[0].time > WINDOW:
            self._samples.popleft()
        room = sample.free - self._keep_free
        if room <= 0:
            if not self.full:
                self.full = True
                yield Notice("error", "the disk is full: %s free in %s. "
                             "Below %s (keep_free) rosbag closes the bag, within 20 s, and ends; "
                             "what comes later is not recorded" % (in_words(sample.free), self._place, in_words(self._keep_free)))
            return
        if self.full:
            self.full = False
            yield Notice("warning", "there is room again in %s, %s: the recording goes on" % (self._place, in_words(sample.free)))
        rate, measured = self.rate()
        left = room / rate if rate > 0 else float("inf")
        if measured and not self._measured:
            self._measured = True
            written = self._written()
            yield Notice("info", "%s an hour are written: room for %s" % (in_words(written * 3600), _time(left))
                         + (" (others fill the disk too: %s an hour in all)" % in_words(rate * 3600) if rate > 2 * written + 1 else ""))
        self._warned = [limit for limit in self._warned if left < 2 * limit]
        due = [limit for limit in WARNINGS if left < limit and limit not in self._warned]
        if due:
            self._warned += due
            yield Notice("warning", "the disk will be full in %s: %s free in %s, and rosbag ends "
                         "below %s (keep_free). Make room, or record elsewhere (bag:=)" % (_time(left), in_words(sample.free), self._place, in_words(self._keep_free)))

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
            return "%.3g %s" % (size / unit, name) if size < 1000 * unit else "%.0f %s" % (size / unit, name)
    return "%.0f bytes" % size


def _time(seconds: float) -> str:
    """A time for people."""
    for unit, name in ((86400.0, "days"), (3600.0, "hours"), (60.0, "minutes")):
        if seconds >= 2 * unit:
            return "more than a year" if seconds > 366 * 86400 else "about %.0f %s" % (seconds / unit, name)
    return "about %.0f s" % max(0.0, seconds)
