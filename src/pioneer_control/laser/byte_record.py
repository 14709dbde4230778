"""Writes down every byte on the line of a laser, for a bug report: one line of text for each piece, with its time.

::

    0.000213 > 02 00 02 00 20 25 35 08
    0.051871 < 06 02 80 03 00 A0 00 10 16 0A

Seconds since the start; ``>`` is to the laser, ``<`` is from it. `lms2xx` knows what the telegrams mean.
"""

import contextlib
import time
from typing import Callable

from ..client.transport import Transport, tap
from ..errors import ParameterError


class ByteRecord:
    """A file with all bytes of a line.

    Args:
        path: of the file, which is begun anew.

    Raises:
        ParameterError: it cannot be written.
    """

    def __init__(self, path: str) -> None:
        try:
            self._file = open(path, "w", encoding="ascii", buffering=1)
        except OSError as error:
            raise ParameterError("~record: %s cannot be written: %s" % (path, error.strerror or error)) from error
        self._began = time.monotonic()

    def opener(self, open_port: Callable[[str, int], Transport]) -> Callable[[str, int], Transport]:
        """Return a function that opens a port as `open_port` does, and has all its bytes written down."""
        def open_recorded(url: str, baud: int) -> Transport:
            transport = open_port(url, baud)
            tap(transport, self.write)
            return transport

        return open_recorded

    def write(self, to_laser: bool, data: bytes) -> None:
        """Write down some bytes. A full disk is no reason to stop the laser: then nothing more is written."""
        pieces = data.hex(" ").upper()
        with contextlib.suppress(OSError):
            self._file.write("%.6f %s %s\n" % (time.monotonic() - self._began, ">" if to_laser else "<", pieces))

    def close(self) -> None:
        """Close the file."""
        with contextlib.suppress(OSError):
            self._file.close()
