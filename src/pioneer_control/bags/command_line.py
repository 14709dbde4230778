"""What the commands of the package `bags` share: tables of options, checks of arguments, names of bags, progress bar.
"""

import argparse
import contextlib
import glob
import itertools
import os
import re
import shlex
import sys
import time
from typing import Any, Dict, Iterable, List, Sequence

from ..errors import UsageError
from ..parameters import Number
from .records import BagError

PATIENCE = 1.0
"""Time (s) after which a progress bar appears."""
MASTER_PATIENCE = 5.0
"""The longest time (s) to wait for an answer of the ROS master, or of a node."""


def refuse_launch_arguments(words: Iterable[str], names: Iterable[str]) -> None:
    """Refuse arguments of a launch file, such as ``speed:=0.5``, on the command line of ``rosrun``.

    ROS takes ``speed:=0.5`` for a remapping of names, so it would silently do nothing.

    Args:
        words: the words of the command line.
        names: the names of the launch file's arguments.

    Raises:
        UsageError: a word sets an argument of the launch file.
    """
    for word in words:
        if word.partition(":=")[0] in names:
            raise UsageError("%s: this is the form for roslaunch; --help lists the options here" % word)


def no_master() -> UsageError:
    """Return the error to raise when the ROS master does not answer."""
    import rosgraph

    return UsageError("there is no ROS master at %s: start roscore, or use the launch file of this program"
                      % rosgraph.get_master_uri())


def check_alone(node: str) -> None:
    """Check that no node with this full name runs. A new node with the name would end it.

    Raises:
        UsageError: a node with this name runs, or the ROS master does not answer.
    """
    from ..ros_node import NO_ANSWER, is_at_work    # imported here because it imports all of rospy

    try:
        if is_at_work(node, MASTER_PATIENCE):
            raise UsageError("%s runs already, and a new node of this name would end it. End it first (rosnode kill "
                             "%s), or give a node that you start yourself another name (__name:=NAME)" % (node, node))
    except NO_ANSWER:
        raise no_master() from None


def parser_of(program: str, description: str, options: Dict[str, Dict[str, Any]],
              **more: Any) -> argparse.ArgumentParser:
    """Make a parser from a table of options.

    Args:
        program: name of the program.
        description: what the program does, for --help.
        options: by the name of an option (or its names, with spaces between them): the arguments of `add_argument`.
        more: further arguments of `ArgumentParser`.
    """
    parser = argparse.ArgumentParser(prog=program, description=description, **more)
    for name, option in options.items():
        parser.add_argument(*name.split(), **option)
    return parser


def number(name: str, text: str, low: float, high: float) -> float:
    """Convert the text of an option to a number.

    Args:
        name: name of the option, for the error message.
        text: the text that the user gave.
        low: the smallest legal number.
        high: the largest legal number.

    Raises:
        UsageError: the text is not a number from `low` to `high`.
    """
    kind = Number(low, high)
    try:
        return kind.accept(float(text))
    except ValueError:
        raise UsageError("%s: %r is not legal: give %s" % (name, text, kind.legal)) from None


def say(sentence: str) -> None:
    """Print a sentence without delay, because other programs print in between."""
    print(sentence, flush=True)


def stem(path: str) -> str:
    """Return the path of a bag without its ending .bag or .bag.active (the ending of a bag that was not closed)."""
    return re.sub(r"(\.bag)?(\.active)?$", "", path)


def in_order(parts: Sequence[str]) -> List[str]:
    """Sort the files of a recording by their numbers: FILE_2.bag before FILE_10.bag. A shell sorts them differently."""
    return sorted(
        parts, key=lambda path: [int(word) if word.isdigit() else word for word in re.split("([0-9]+)", path)])


def bag_files(given: str) -> List[str]:
    """Return the files that a text names.

    Args:
        given: one file, several files with spaces between them, or a pattern such as ``run_*.bag``. ~ is expanded.

    Raises:
        BagError: the text names no file, or a file that does not exist.
    """
    words = [given]
    if not os.path.exists(os.path.expanduser(given)):
        with contextlib.suppress(ValueError):   # a quote that stands alone
            words = shlex.split(given)
    files: List[str] = []
    for word in (os.path.expanduser(word) for word in words):   # no shell does it in bag:=~/FILE.bag
        found = [word] if os.path.exists(word) else in_order(glob.glob(word))
        if not found:
            raise BagError("%s: no such file%s" % (word, "" if os.path.isabs(word) else " in " + os.getcwd()))
        files += found
    if not files:
        raise BagError("no bag is named: give its file, bag:=FILE.bag")
    return files


def free_name(bag: str, what: str) -> str:
    """Return a path for a new bag in the folder of another bag. No file with this path exists yet.

    Args:
        bag: path of the other bag, for example RUN.bag.
        what: is added to the name: "redrive" gives RUN-redrive.bag, or RUN-redrive-2.bag if that exists, ...
    """
    beside = "%s-%s" % (stem(bag), what)
    names = itertools.chain([beside + ".bag"], ("%s-%s.bag" % (beside, number) for number in itertools.count(2)))
    return next(path for path in names if not os.path.exists(path))


class Progress(contextlib.AbstractContextManager):
    """A progress bar on stderr, if it is a terminal. It appears after `PATIENCE` seconds.

    Use it in a ``with`` block. The bar disappears at the end of the block.

    Args:
        name: the text before the bar.
    """

    def __init__(self, name: str) -> None:
        self._name, self._begin = name, time.monotonic()
        self._bar: Any = None

    def __call__(self, done: int, total: int) -> None:
        """Show how many bytes of a bag are read.

        Args:
            done: number of bytes that are read.
            total: number of bytes to read.
        """
        if self._bar is None and sys.stderr.isatty() and time.monotonic() - self._begin > PATIENCE:
            from tqdm import tqdm  # imported here because few bags are long enough to need it

            self._bar = tqdm(desc=self._name, total=total, unit="B", unit_scale=True, leave=False)
        if self._bar is not None:
            self._bar.update(done - self._bar.n)

    def __exit__(self, *_: Any) -> None:
        if self._bar is not None:
            self._bar.close()
