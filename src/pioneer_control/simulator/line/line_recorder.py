"""What went over the lines, as a file; `pioneer_control.p2os.recording` is its format."""

from typing import Optional, TextIO

from ...errors import ParameterError
from ...p2os.recording import TITLE, Entry, written


class LineRecorder:
    """A file that is being written.

    Args:
        path: of the file; None: nothing is written anywhere. An older one of that name is replaced.

    Raises:
        ParameterError: it cannot be written; says why.
    """

    def __init__(self, path: Optional[str]):
        self._file: Optional[TextIO] = None
        if path is not None:
            try:
                self._file = open(path, "w", buffering=1, encoding="utf-8")
            except OSError as error:
                raise ParameterError("cannot record to %s: %s" % (path, error.strerror)) from error
            self._file.write(TITLE + "\n")

    def put(self, time: float, robot: int, to_robot: bool, data: bytes, note: str = "") -> None:
        """Write bytes that a client of a robot (from 1) sent or got, or a note for people."""
        if self._file is not None and (data or note):
            self._file.write(written(Entry(time, robot, to_robot, data, note)) + "\n")

    def note(self, time: float, text: str) -> None:
        """Write a sentence for people."""
        self.put(time, 0, False, b"", text)

    def close(self) -> None:
        """Close the file."""
        if self._file is not None:
            self._file.close()
            self._file = None
