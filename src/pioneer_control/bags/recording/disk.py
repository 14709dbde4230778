"""Sizes for people, and for how long a recording has room. rosbag itself warns of a full disk, and ends."""

KB, MB, GB = 2 ** 10, 2 ** 20, 2 ** 30
USUAL_RATE = {"lz4": 25 * MB, "bz2": 22 * MB, "none": 120 * MB}
"""Bytes an hour of one robot; bench/recording.md."""


def in_words(size: float) -> str:
    """A size in words. `size`: bytes."""
    unit, name = next((each for each in ((GB, "GB"), (MB, "MB"), (KB, "kB")) if size >= each[0]), (1, "bytes"))
    return "%.3g %s" % (size / unit, name) if size < 1000 * unit else "%.0f %s" % (size / unit, name)


def room(free: int, keep_free: int, rate: float) -> str:
    """For how long a recording has room, in words.

    Args:
        free: bytes on the disk.
        keep_free: bytes below which rosbag ends.
        rate: bytes an hour.
    """
    seconds = max(0, free - keep_free) / rate * 3600
    unit, name = next((each for each in ((86400, "days"), (3600, "hours"), (60, "minutes")) if seconds >= 2 * each[0]),
                      (1, "s"))
    long = "more than a year" if seconds > 366 * 86400 else "about %.0f %s" % (seconds / unit, name)
    return "room for %s at the usual %s an hour" % (long, in_words(rate))
