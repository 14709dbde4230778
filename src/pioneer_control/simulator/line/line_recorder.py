"""Records the bytes that are sent over the lines to a file, in the format of `pioneer_control.p2os.recording`."""

from typing import Optional

from ...errors import ParameterError
from ...p2os.recording import TITLE, Entry, written


class LineRecorder:
    """Writes a recording of the lines to a file.

    Args:
        path: path of the file, which is overwritten if it exists. If None, the recorder writes nothing.

    Raises:
        ParameterError: the file cannot be written. The message has the reason.
    """

    def __init__(self, path: Optional[str]):
        try:
            self._file = None if path is None else open(path, "w", buffering=1, encoding="utf-8")
        except OSError as error:
            raise ParameterError("cannot record to %s: %s" % (path, error.strerror)) from error
        if self._file is not None:
            self._file.write(TITLE + "\n")

    def put(self, entry: Entry) -> None:
        """Write an entry: bytes that a client sent or received, or a note. Ignore an entry without bytes and note."""
        if self._file is not None and (entry.data or entry.note):
            self._file.write(written(entry) + "\n")

    def close(self) -> None:
        """Close the file. Later entries are ignored."""
        if self._file is not None:
            self._file.close()
            self._file = None
