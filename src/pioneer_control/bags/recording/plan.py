"""Make the plan of a recording from a command line: the topics, the bag, and the ``rosbag record`` command.

This file also checks that no recording is overwritten, not even an unfinished one, and estimates how long the free disk
space lasts. rosbag itself warns when the disk is almost full, and stops.
"""

import argparse
import glob
import os
import re
import tempfile
import time
from typing import Any, Dict, List, NamedTuple, Sequence, Tuple

from ...errors import UsageError
from ..command_line import in_order, stem
from .topics import NAME, load_list, topics_of

KB, MB, GB = 2 ** 10, 2 ** 20, 2 ** 30

COMPRESSIONS = "lz4", "bz2", "none"
UNITS: Dict[str, Tuple[str, float]] = {
    "MB": ("size", MB), "GB": ("size", GB), "s": ("duration", 1), "min": ("duration", 60), "h": ("duration", 3600)}
CHUNK = 64
"""The size (kB) of a chunk: about 2 s of messages of one robot. A killed recorder loses the last chunk.

With rosbag's default of 768 kB a bag is an eighth smaller, but up to half a minute is lost: see bench/recording.md."""
KEEP_FREE = 256 * MB
"""The default number of bytes that stay free on the disk, so that the computer goes on working.

One robot needs about ten hours to record as much. rosbag warns when less than five times as much is free."""
LEFT = 60.0
"""The time (s) since the last write to an unfinished bag after which its recorder is taken to be dead."""
USUAL_RATE = {"lz4": 25 * MB, "bz2": 22 * MB, "none": 120 * MB}
"""The usual number of bytes per hour for one robot, by compression: see bench/recording.md."""
WHAT_TO_DO = ("is of a recorder that was killed: all is in it but the last seconds. draw_run reads it as it is; "
              "for rosbag: rosbag reindex '%s', and rename it to .bag")


def in_words(size: float) -> str:
    """Return a size in words, for example "1.5 GB". `size` is in bytes. The units count in steps of 1024."""
    unit, name = next((each for each in ((GB, "GB"), (MB, "MB"), (KB, "kB")) if size >= each[0]), (1, "bytes"))
    return "%.3g %s" % (size / unit, name) if size < 1000 * unit else "%.0f %s" % (size / unit, name)


OPTIONS: Dict[str, Dict[str, Any]] = {
    "robots": dict(nargs="*", default=["pioneer"], metavar="ROBOT", help="namespaces of the robots (default: pioneer)"),
    "--bag": dict(default="", metavar="FILE",
                  help="the bag, or a directory for it (default: the robots and the time name the bag)"),
    "--also": dict(default="", metavar="GROUPS",
                   help="groups of topics that are recorded only if you name them, such as 'wire packets'"),
    "--split": dict(default="", metavar="AMOUNT",
                    help="begin a new part after each 1h, 30min, 500MB, ...: FILE_0.bag, FILE_1.bag, ..."),
    "--compression": dict(default="", choices=("", *COMPRESSIONS), metavar="KIND",
                          help="lz4, bz2 or none (default: lz4)"),
    "--keep-free": dict(default="", metavar="SIZE",
                        help="space on the disk that rosbag leaves free, such as 1GB (default: %s)"
                        % in_words(KEEP_FREE)),
    "--topics": dict(default="", metavar="FILE", help="the list of topics (default: config/record.yaml)"),
}
"""The options of the command line. record.launch passes all options. An empty option counts as not given."""


class RecordingPlan(NamedTuple):
    """The plan of a recording: which topics of which robots are recorded, and in which file."""

    robots: Tuple[str, ...]
    """the namespaces of the robots; "" is the root namespace"""
    topics: Tuple[str, ...]
    """the full names of all topics to record"""
    asked_for: Tuple[str, ...]
    """the full names of the topics that are recorded only because of --also"""
    stem: str
    """the absolute path of the bag without .bag"""
    compression: str
    split: Tuple[str, int]
    """when a new part begins: ("size", MB) or ("duration", s); ("", 0) for a single file"""
    keep_free: int
    """bytes to leave free on the disk, a multiple of 1 MB"""

    @property
    def folder(self) -> str:
        """The path of the folder of the bag."""
        return os.path.dirname(self.stem)

    @property
    def file(self) -> str:
        """The path of the bag, or of its first part."""
        return self.stem + ("_0.bag" if self.split[0] else ".bag")

    @property
    def parts(self) -> List[str]:
        """The paths of the files of this recording that exist now, finished or not, in their order."""
        pattern = re.compile(re.escape(self.stem) + (r"_\d+" if self.split[0] else "") + r"\.bag(\.active)?")
        return in_order([path for path in glob.glob(glob.escape(self.stem) + "*") if pattern.fullmatch(path)])

    @property
    def command(self) -> List[str]:
        """The ``rosbag record`` command that makes this recording, as a list of words."""
        how, amount = self.split
        return ["rosrun", "rosbag", "record", "--output-name=" + self.stem, "--tcpnodelay",
                "--min-space=%sM" % (self.keep_free // MB), "--chunksize=%s" % CHUNK,
                *([] if self.compression == "none" else ["--" + self.compression]),
                *(["--split", "--%s=%s" % (how, amount), "--repeat-latched"] if how else []),
                *self.topics]


def plan_of(arguments: argparse.Namespace, now: time.struct_time) -> RecordingPlan:
    """Make the plan of a recording from its command line.

    Args:
        arguments: the values of `OPTIONS`.
        now: the local time, for the name of the bag.

    Raises:
        UsageError: an argument is not legal. The error says which values are legal.
    """
    robots = tuple(dict.fromkeys(name.strip("/") for argument in arguments.robots
                                 for name in argument.replace(",", " ").split()))
    for robot in robots:
        if robot and not NAME.fullmatch(robot):
            raise UsageError("%r is no name of a robot: give its namespace, like pioneer; several with spaces between "
                             "them; / if it has none" % robot)
    if not robots:
        raise UsageError("no robot is named: give its namespace, like pioneer")
    rows = load_list(arguments.topics)
    usual, topics = (topics_of(rows, robots, also) for also in ((), arguments.also.replace(",", " ").split()))
    kind, keep_free = amount_of("keep_free", arguments.keep_free or "%sMB" % (KEEP_FREE // MB))
    if kind != "size":
        raise UsageError("keep_free %r is not legal: give a size like 500MB or 1GB" % arguments.keep_free)
    return RecordingPlan(
        robots, topics, tuple(topic for topic in topics if topic not in usual), stem_of(arguments.bag, robots, now),
        arguments.compression or COMPRESSIONS[0], split_of(arguments.split), max(1, int(keep_free / MB)) * MB)


def amount_of(what: str, text: str) -> Tuple[str, float]:
    """Read an amount with a unit: "500MB" gives ("size", number of bytes), "30min" gives ("duration", seconds).

    Args:
        what: the name of the option, for the error.
        text: the amount.

    Raises:
        UsageError: the text is not a number with one of `UNITS`.
    """
    found = re.fullmatch(r"\s*(\d+(?:\.\d+)?)\s*([A-Za-z]+)\s*", text)
    if not found or found.group(2) not in UNITS:
        raise UsageError("%s %r is not legal: give a number with a unit, one of %s" % (what, text, ", ".join(UNITS)))
    kind, unit = UNITS[found.group(2)]
    return kind, float(found.group(1)) * unit


def split_of(text: str) -> Tuple[str, int]:
    """Read the value of --split, and return it as rosbag needs it: ("size", MB) or ("duration", s).

    An empty text gives ("", 0): the recording is not split.

    Raises:
        UsageError: the text is not an amount, or less than 1 MB or 1 s.
    """
    if not text:
        return "", 0
    kind, amount = amount_of("split", text)
    whole = int(amount / MB) if kind == "size" else int(amount)
    if whole < 1:
        raise UsageError("split %r is not legal: give at least 1MB or 1s" % text)
    return kind, whole


def stem_of(bag: str, robots: Sequence[str], now: time.struct_time) -> str:
    """Return the absolute path of a new bag without its ending .bag.

    If `bag` does not name a file, the file is named by the robots and the local time.

    Args:
        bag: the file, or a directory for it. Empty: the working directory.
        robots: the namespaces of the robots.
        now: the local time.
    """
    path = os.path.abspath(os.path.expanduser(bag)) if bag else os.getcwd()
    if bag and not bag.endswith("/") and not os.path.isdir(path):
        return stem(path)
    names = [robot or "robot" for robot in robots]
    who = "_".join(names) if len(names) <= 3 else "%s_and_%s_more" % (names[0], len(names) - 1)
    return os.path.join(path, who.replace("/", "-") + time.strftime("_%Y-%m-%d-%H-%M-%S", now))


def check_place(plan: RecordingPlan, free: int) -> None:
    """Check that the bag can be written, and that no file would be overwritten.

    Args:
        plan: the plan of the recording.
        free: the free space on the disk (bytes).

    Raises:
        UsageError: the bag exists already, the folder is not writable, or the disk is too full. The error says what to
            do.
    """
    folder, name = os.path.split(plan.stem)
    there = plan.parts
    if there:
        unfinished = [path for path in there if path.endswith(".active")]
        more = ". %s is being recorded, or %s" % (unfinished[0], WHAT_TO_DO % unfinished[0]) if unfinished else ""
        raise UsageError("%s is there already, and stays as it is: give the new bag another name%s" % (there[0], more))
    try:
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise UsageError("cannot write %s.bag in %s: %s" % (name, folder, error.strerror)) from error
    if free <= plan.keep_free:
        raise UsageError("only %s are free in %s, and rosbag ends below %s: make room, record elsewhere (bag:=), or "
                         "leave less (keep_free:=100MB)" % (in_words(free), folder, in_words(plan.keep_free)))


def left_behind(folder: str, now: float) -> str:
    """Return a warning about one unfinished bag of a killed recorder in a folder. Empty if there is no such bag.

    Args:
        folder: the path of the folder.
        now: the present time (s since 1970).
    """
    unfinished = sorted(entry.path for entry in os.scandir(folder)
                        if entry.name.endswith(".bag.active") and now - entry.stat().st_mtime > LEFT)
    return "%s %s" % (unfinished[-1], WHAT_TO_DO % unfinished[-1]) if unfinished else ""


def room(free: int, keep_free: int, rate: float) -> str:
    """Return in words how long a recording can last until rosbag stops because of the full disk.

    Args:
        free: the free space on the disk (bytes).
        keep_free: the free space at which rosbag stops (bytes).
        rate: the growth of the bag (bytes per hour).
    """
    seconds = max(0, free - keep_free) / rate * 3600
    unit, name = next((each for each in ((86400, "days"), (3600, "hours"), (60, "minutes")) if seconds >= 2 * each[0]),
                      (1, "s"))
    long = "more than a year" if seconds > 366 * 86400 else "about %.0f %s" % (seconds / unit, name)
    return "room for %s at the usual %s an hour" % (long, in_words(rate))
