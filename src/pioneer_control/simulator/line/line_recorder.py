"""What went over the lines, as a file; `pioneer_control.p2os.recording` is its format."""

from typing import Optional

from ...errors import ParameterError
from ...p2os.recording import TITLE, Entry, written


class LineRecorder:
    """A file that is being written.

    Args:
        path: of the file, which replaces an older one of that name. None: the recorder writes nothing.

    Raises:
        ParameterError: the file cannot be written; the message says why.
    """

    def __init__(self, path: Optional[str]):
        try:
            self._file = None if path is None else open(path, "w", buffering=1, encoding="utf-8")
        except OSError as error:
            raise ParameterError("cannot record to %s: %s" % (path, error.strerror)) from error
        if self._file is not None:
            self._file.write(TITLE + "\n")

    def put(self, entry: Entry) -> None:
        """Write bytes that a client of a robot sent or got, or a note for people."""
        if self._file is not None and (entry.data or entry.note):
            self._file.write(written(entry) + "\n")

    def close(self) -> None:
        """Close the file. What comes now is written nowhere."""
        if self._file is not None:
            self._file.close()
            self._file = None
