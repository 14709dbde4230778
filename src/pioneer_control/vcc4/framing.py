"""Where commands to a camera and its answers begin and end (camera sheet 2).

::

    FF  30 30  00  62  38 33 32 30  37 45 46 35  EF       a command: go to pan 90, tilt -30 degrees
    │   │      │   │   └ values: upper-case hex digits
    │   │      │   └ command
    │   │      └ the high byte of the command, always 0
    │   └ number of the camera, two digits
    └ begin

    FE  30 30  30 30  EF                                  its answer: accepted
    │   │      └ two digits of an error byte; behind them the values that were asked for
    │   └ number of the camera
    └ begin

There is no checksum, and nothing is escaped. Digits are never FA to FF, nor EF. So a first byte that comes in the
middle of a frame begins a new one, and the old one was noise.
"""

from typing import List, NamedTuple

COMMAND_BEGIN = 0xFF
ANSWER_BEGIN = 0xFE
END = 0xEF
LONGEST_FRAME = 20
"""Bytes of a frame beyond which it is noise. The longest command has 15, the longest answer 14."""
SHORTEST_ANSWER = 6
"""Bytes of an answer without values: of each error, whatever the command, and of each command that asks nothing."""
NUMBER_DIGITS = 2
"""Digits of a camera's number, behind the first byte."""
ERROR_DIGITS = slice(3, 5)
"""Where the digits of the error byte are in an answer."""


class CameraCounts(NamedTuple):
    """Counters of a `CameraDecoder`, since it was made."""

    frames: int = 0
    """Number of frames that it has returned."""
    discarded_bytes: int = 0
    """Number of bytes that belonged to none of them."""


class CameraDecoder:
    """Finds the frames in a stream of bytes that may come in pieces of any size, and with any noise.

    It never raises, whatever the bytes are, and holds 19 bytes at most.

    Args:
        begin: the first byte of the frames: `COMMAND_BEGIN` in a camera, `ANSWER_BEGIN` in its client.
    """

    def __init__(self, begin: int) -> None:
        self._begin = begin
        self._held = bytearray()
        self._frames = self._discarded = 0

    @property
    def held(self) -> bytes:
        """The bytes of the unfinished frame."""
        return bytes(self._held)

    @property
    def counts(self) -> CameraCounts:
        """The numbers of frames and of discarded bytes since the decoder was made."""
        return CameraCounts(self._frames, self._discarded)

    def feed(self, data: bytes) -> List[bytes]:
        """Return the frames that are complete with these bytes, from begin to end.

        `data` follows all bytes that were fed before. An unfinished frame is kept.
        """
        found = []
        for byte in data:
            if byte == self._begin or not self._held:
                self.drop_partial()
            self._held.append(byte)
            if self._held[0] != self._begin or len(self._held) == LONGEST_FRAME and byte != END:
                self.drop_partial()
            elif byte == END:
                found.append(bytes(self._held))
                self._frames += 1
                self._held.clear()
        return found

    def drop_partial(self) -> None:
        """Give up the unfinished frame: its rest does not come."""
        self._discarded += len(self._held)
        self._held.clear()
