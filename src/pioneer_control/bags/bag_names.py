"""Names of bags: their stem, the order of parts, the files that a text on a command line names, and free names."""

import contextlib
import glob
import itertools
import os
import re
import shlex
from typing import List, Sequence

from .records import BagError


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
