"""Once this is imported, Ctrl-C ends a program without a traceback, also while it still imports what it needs.

A program imports it before all else that is not Python's own.
"""

import sys
from types import TracebackType
from typing import Optional, Type

_say_others = sys.excepthook


def _say_error(kind: Type[BaseException], error: BaseException, traceback: Optional[TracebackType]) -> None:
    if not issubclass(kind, KeyboardInterrupt):
        _say_others(kind, error, traceback)


sys.excepthook = _say_error
