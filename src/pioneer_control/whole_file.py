"""Writes a file completely or not at all, with the context manager `writing`."""

import contextlib
import os
from typing import Iterator


@contextlib.contextmanager
def writing(path: str) -> Iterator[str]:
    """Write a file completely or not at all. Use it in a ``with`` block.

    The block gets a temporary name, ``path`` + ".part", and writes the file with this name. At the end of the block the
    file is renamed to ``path``. If an exception ends the block (Ctrl-C, a full disk), the temporary file is deleted.
    """
    part = path + ".part"
    try:
        yield part
        os.replace(part, path)
    finally:
        with contextlib.suppress(OSError):
            os.remove(part)
