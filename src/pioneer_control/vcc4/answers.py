"""The answers of a camera: errors, values and the status (camera sheet 3, 4), and how they become bytes.

An answer says that a command was accepted, not that it is done.
"""

import enum
from typing import Any, NamedTuple, Optional, Tuple

from ..errors import EncodingError
from .commands import CAMERA_COMMANDS, Digits, number_digits, split
from .framing import ANSWER_BEGIN, END, ERROR_DIGITS, SHORTEST_ANSWER

ERROR = Digits("error", 2, 0, 0xFF)


class AnswerKind(enum.IntEnum):
    """The first digit of the error byte. Bit 0 (busy) is also set with every other error."""

    ACCEPTED = 0x0
    BUSY = 0x1
    """Not executed: try again after a pause."""
    UNKNOWN_COMMAND = 0x3
    WRONG_VALUE = 0x5
    """A value is out of range, or there are too many or too few digits."""
    WRONG_MODE = 0x9
    """Not in host control, camera not on, or pan and tilt not initialised."""


class CameraStatus(enum.IntFlag):
    """Bits of the status. The last two are in the long form only."""

    FOCUSING = 1 << 0
    MANUAL_FOCUS = 1 << 1
    NEVER_INITIALISED = 1 << 4
    OFF = 1 << 5
    ZOOMING = 1 << 7
    PAN_AT_LIMIT = 1 << 8
    PANNING = 1 << 9
    TILT_AT_LIMIT = 1 << 10
    TILTING = 1 << 11
    LOCAL_MODE = 1 << 18
    MENU_OPEN = 1 << 19


class CameraAnswer(NamedTuple):
    """An answer.

    Attributes:
        error: the error byte, 0 if the command was accepted.
        digits: what follows it: the values that were asked for. See `answer_values`.
    """

    error: int
    digits: bytes = b""

    @property
    def kind(self) -> int:
        """The first digit of the error byte: an `AnswerKind`, or another one, which nobody has explained."""
        return self.error >> 4


def encode_answer(name: str, *values: Any, camera: int = 0) -> bytes:
    """Return the bytes of the answer to a command that is accepted, with the values that it asks for.

    Raises:
        EncodingError: there is no such command, the number of values is wrong, or one does not fit.
    """
    row = CAMERA_COMMANDS.get(name)
    if row is None or len(values) != len(row.answer):
        raise EncodingError("no command of a camera is called %r, with %d values in its answer" % (name, len(values)))
    return _answer(0, b"".join(field.write(value, name) for field, value in zip(row.answer, values)), camera)


def encode_error(kind: AnswerKind, camera: int = 0) -> bytes:
    """Return the bytes of the answer to a command that is not accepted: six, whatever the command."""
    return _answer(kind << 4, b"", camera)


def decode_answer(frame: bytes) -> Optional[CameraAnswer]:
    """Return what a frame from `CameraDecoder` answers. None if it is no answer. Never raises."""
    error = ERROR.read(frame[ERROR_DIGITS])
    if len(frame) < SHORTEST_ANSWER or error is None:
        return None
    return CameraAnswer(error, frame[ERROR_DIGITS.stop:-1])


def answer_values(name: str, answer: CameraAnswer) -> Optional[Tuple[Any, ...]]:
    """Return the values in the answer to a command that was accepted. None if they are not those of this command."""
    return split(CAMERA_COMMANDS[name].answer, answer.digits)


def _answer(error: int, digits: bytes, camera: int) -> bytes:
    return bytes((ANSWER_BEGIN,)) + number_digits(camera) + ERROR.write(error, "answer") + digits + bytes((END,))
