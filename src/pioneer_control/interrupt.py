"""Import this module to make Ctrl-C end the program without a traceback, also while the program still imports.

A program imports it before all modules that are not in Python's standard library.
"""

import sys
from types import TracebackType
from typing import Optional, Type

_say_others = sys.excepthook


def _say_error(kind: Type[BaseException], error: BaseException, traceback: Optional[TracebackType]) -> None:
    """Print an uncaught exception with its traceback, but print nothing for KeyboardInterrupt (Ctrl-C)."""
    if not issubclass(kind, KeyboardInterrupt):
        _say_others(kind, error, traceback)


sys.excepthook = _say_error
