"""A progress bar for what takes long: reading bags of gigabytes."""

import contextlib
import sys
import time
from typing import Any

PATIENCE = 1.0
"""s of reading without a bar."""


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
