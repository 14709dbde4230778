"""Files that are there whole, or not at all: `writing`."""

import contextlib
import os
from typing import Iterator


@contextlib.contextmanager
def writing(path: str) -> Iterator[str]:
    """Write a file under another name, which it keeps until it is whole.

    The ``with`` block gets that name, ``path`` with ``.part`` behind it, and writes the file. At its end the file is
    called ``path``. When something ends the block before (Ctrl-C, a full disk), nothing is left of the file.
    """
    part = path + ".part"
    try:
        yield part
        os.replace(part, path)
    finally:
        with contextlib.suppress(OSError):
            os.remove(part)
