"""What the commands of this room have in common: tables of options, checks of what was given, names of bags, progress.
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
"""s of reading without a bar."""


def refuse_launch_arguments(words: Iterable[str], names: Iterable[str]) -> None:
    """Refuse ``speed:=0.5`` behind ``rosrun``: to ROS it is the new name of a topic, and would silently do nothing.

    Args:
        words: of the command line.
        names: of the launch file's arguments.

    Raises:
        UsageError: a word of the command line gives an argument of the launch file.
    """
    for word in words:
        if word.partition(":=")[0] in names:
            raise UsageError("%s: this is the form for roslaunch; --help lists the options here" % word)


def parser_of(program: str, description: str, options: Dict[str, Dict[str, Any]],
              **more: Any) -> argparse.ArgumentParser:
    """A parser of options.

    Args:
        program: its name.
        description: what it does.
        options: for each option, its name (or names, with spaces between them) and the arguments of `add_argument`.
        more: arguments of the parser itself.
    """
    parser = argparse.ArgumentParser(prog=program, description=description, **more)
    for name, option in options.items():
        parser.add_argument(*name.split(), **option)
    return parser


def yes_or_no(text: str) -> bool:
    """The value of "true" or "false", as launch files write it.

    Raises:
        ArgumentTypeError: the text is neither.
    """
    if text.lower() not in ("true", "false"):
        raise argparse.ArgumentTypeError("%r is not legal: give true or false" % text)
    return text.lower() == "true"


def number(name: str, text: str, low: float, high: float) -> float:
    """The number that an option gives.

    Args:
        name: of the option, for the error.
        text: what was given.
        low: the least legal number.
        high: the greatest legal number.

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
    """The name of a bag without its ending: .bag, or .bag.active of one that was not closed."""
    return re.sub(r"(\.bag)?(\.active)?$", "", path)


def in_order(parts: Sequence[str]) -> List[str]:
    """Parts of a recording by their numbers: FILE_2.bag before FILE_10.bag. A shell sorts them the other way."""
    return sorted(
        parts, key=lambda path: [int(word) if word.isdigit() else word for word in re.split("([0-9]+)", path)])


def bag_files(given: str) -> List[str]:
    """The files that a text names: one, several with spaces between them, or a pattern such as ``run_*.bag``.

    Raises:
        BagError: the text names no file, or one that does not exist.
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
    """A name beside a bag that no file has yet: RUN-redrive.bag, or RUN-redrive-2.bag, ..."""
    beside = "%s-%s" % (stem(bag), what)
    names = itertools.chain([beside + ".bag"], ("%s-%s.bag" % (beside, number) for number in itertools.count(2)))
    return next(path for path in names if not os.path.exists(path))


class Progress(contextlib.AbstractContextManager):
    """A bar on a terminal, for what takes longer than `PATIENCE`. ``with`` removes it at the end.

    Args:
        name: written before the bar.
    """

    def __init__(self, name: str) -> None:
        self._name, self._begin = name, time.monotonic()
        self._bar: Any = None

    def __call__(self, done: int, total: int) -> None:
        """Show how far it is.

        Args:
            done: bytes that are read.
            total: all bytes.
        """
        if self._bar is None and sys.stderr.isatty() and time.monotonic() - self._begin > PATIENCE:
            from tqdm import tqdm  # here: few bags are that long

            self._bar = tqdm(desc=self._name, total=total, unit="B", unit_scale=True, leave=False)
        if self._bar is not None:
            self._bar.update(done - self._bar.n)

    def __exit__(self, *_: Any) -> None:
        if self._bar is not None:
            self._bar.close()
