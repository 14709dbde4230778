"""The table of all commands to a camera, with their values and answers (camera sheet 4), and how they become bytes.

A command is known by its number and the fixed digits behind it. So "ask zoom" and "ask the greatest zoom" are two rows.
"""

from typing import Any, Dict, List, NamedTuple, Optional, Tuple, Union

from ..errors import EncodingError
from ..wire_fields import checked_integer
from .framing import COMMAND_BEGIN, END, NUMBER_DIGITS
from .units import ZERO, ZOOM_MOST

HEX = b"0123456789ABCDEF"


class Digits(NamedTuple):
    """A number in upper-case hex digits, the most significant first.

    Attributes:
        name: what it is.
        width: how many digits.
        low, high: legal values.
        zero: what is added to the value on the wire.
    """

    name: str
    width: int
    low: int
    high: int
    zero: int = 0

    def write(self, value: Any, what: str) -> bytes:
        """Return the digits of a value. Raises EncodingError, which names `what`, when it is not legal."""
        number = checked_integer(value, self.low, self.high, "%s, %s" % (what, self.name)) + self.zero
        return b"%0*X" % (self.width, number)

    def read(self, digits: bytes) -> Optional[int]:
        """Return the value of the digits, legal or not; None if their number is wrong or one is no digit."""
        if len(digits) != self.width or not all(digit in HEX for digit in digits):
            return None
        return int(digits, 16) - self.zero


class Letters(NamedTuple):
    """A text of a fixed number of ASCII letters."""

    name: str
    width: int

    def write(self, value: Any, what: str) -> bytes:
        """Return the letters of a text. Raises EncodingError, which names `what`, when it does not fit."""
        if not isinstance(value, str) or len(value) != self.width or not value.isascii() or not value.isprintable():
            raise EncodingError("%s, %s: %r is not a text of %d letters" % (what, self.name, value, self.width))
        return value.encode("ascii")

    def read(self, letters: bytes) -> Optional[str]:
        """Return the text; None if a byte is no letter."""
        text = letters.decode("latin-1")
        return text if text.isascii() and text.isprintable() else None


CameraField = Union[Digits, Letters]
PAN = Digits("pan", 4, -1511, 1511, ZERO)       # counts; a VC-C50i that hangs has the widest range
TILT = Digits("tilt", 4, -800, 800, ZERO)       # counts
PAN_SPEED = Digits("pan speed", 3, 8, 800)      # counts a second
TILT_SPEED = Digits("tilt speed", 3, 8, 622)    # counts a second
ZOOM = Digits("zoom", 4, 0, ZOOM_MOST)
PAN_WAY = Digits("pan", 1, 0, 2)
TILT_WAY = Digits("tilt", 1, 0, 2)


class CameraCommand(NamedTuple):
    """One row of the table of commands.

    Attributes:
        name: its name.
        number: its number.
        effect: what it does.
        values: what is said with it.
        fixed: the digits that come before these values, always the same.
        answer: what the camera answers when it accepts the command.
        needs_lamp: only cameras with an infrared lamp know it.
    """

    name: str
    number: int
    effect: str
    values: Tuple[Digits, ...] = ()
    fixed: bytes = b""
    answer: Tuple[CameraField, ...] = ()
    needs_lamp: bool = False

    @property
    def answer_width(self) -> int:
        """How many digits or letters its answer has, when it is accepted."""
        return sum(field.width for field in self.answer)


CAMERA_COMMANDS: Dict[str, CameraCommand] = {row.name: row for row in (
    # Power and who controls it
    CameraCommand("POWER", 0xA0, "1 on, 0 off", (Digits("on", 1, 0, 1),)),
    CameraCommand("CONTROL", 0x90, "who controls it: 0 this line (host), 1 its remote control (local)",
                  (Digits("local", 1, 0, 1),)),
    CameraCommand("INITIALISE", 0x58, "find the ends of pan and tilt, then 0 go home, 1 go back",
                  (Digits("back", 1, 0, 1),)),
    # Pan and tilt
    CameraCommand("HOME", 0x57, "go to pan 0, tilt 0 at a fixed speed"),
    CameraCommand("GO_TO", 0x62, "go to pan, tilt, both at once at the set speeds", (PAN, TILT)),
    CameraCommand("STOP", 0x53, "stop pan and tilt", fixed=b"0"),
    CameraCommand("RUN_RIGHT", 0x53, "run until a stop, or the end of the range", fixed=b"1"),
    CameraCommand("RUN_LEFT", 0x53, "the same to the left", fixed=b"2"),
    CameraCommand("RUN_UP", 0x53, "the same upwards", fixed=b"3"),
    CameraCommand("RUN_DOWN", 0x53, "the same downwards", fixed=b"4"),
    CameraCommand("RUN_BOTH", 0x60, "run both: pan 0 stop, 1 right, 2 left; tilt 0 stop, 1 up, 2 down",
                  (PAN_WAY, TILT_WAY)),
    CameraCommand("PAN_SPEED", 0x50, "set the speed of pan, effective at once", (PAN_SPEED,)),
    CameraCommand("TILT_SPEED", 0x51, "set the speed of tilt, effective at once", (TILT_SPEED,)),
    CameraCommand("PAN_RANGE", 0x64, "set the movable range of pan", (PAN._replace(name="least"), PAN), b"0"),
    CameraCommand("TILT_RANGE", 0x64, "set the movable range of tilt", (TILT._replace(name="least"), TILT), b"1"),
    CameraCommand("ASK_POSITION", 0x63, "where it looks now, also while it moves", answer=(PAN, TILT)),
    CameraCommand("ASK_PAN_SPEED", 0x52, "the set speed of pan", fixed=b"0", answer=(PAN_SPEED,)),
    CameraCommand("ASK_TILT_SPEED", 0x52, "the set speed of tilt", fixed=b"1", answer=(TILT_SPEED,)),
    CameraCommand("ASK_PAN_SPEED_LEAST", 0x59, "limit of its speed", fixed=b"0", answer=(PAN_SPEED,)),
    CameraCommand("ASK_PAN_SPEED_MOST", 0x59, "limit of its speed", fixed=b"1", answer=(PAN_SPEED,)),
    CameraCommand("ASK_TILT_SPEED_LEAST", 0x59, "limit of its speed", fixed=b"2", answer=(TILT_SPEED,)),
    CameraCommand("ASK_TILT_SPEED_MOST", 0x59, "limit of its speed", fixed=b"3", answer=(TILT_SPEED,)),
    CameraCommand("ASK_PAN_RANGE", 0x65, "the movable range of pan", fixed=b"0", answer=(PAN, PAN)),
    CameraCommand("ASK_TILT_RANGE", 0x65, "the movable range of tilt", fixed=b"1", answer=(TILT, TILT)),
    CameraCommand("ASK_PAN_LEAST", 0x5C, "where its mechanics end", fixed=b"0", answer=(PAN,)),
    CameraCommand("ASK_PAN_MOST", 0x5C, "where its mechanics end", fixed=b"1", answer=(PAN,)),
    CameraCommand("ASK_TILT_LEAST", 0x5C, "where its mechanics end", fixed=b"2", answer=(TILT,)),
    CameraCommand("ASK_TILT_MOST", 0x5C, "where its mechanics end", fixed=b"3", answer=(TILT,)),
    CameraCommand("ASK_PAN_COUNT", 0x5B, "one count in 0.00001 degrees", fixed=b"0",
                  answer=(Digits("ratio", 4, 0, 0xFFFF),)),
    CameraCommand("ASK_TILT_COUNT", 0x5B, "one count in 0.00001 degrees", fixed=b"1",
                  answer=(Digits("ratio", 4, 0, 0xFFFF),)),
    # Zoom and focus
    CameraCommand("ZOOM_TO", 0xB3, "go to a zoom step: 0 wide, 1960 tele", (ZOOM,)),
    CameraCommand("ZOOM_RUN", 0xA2, "0 stop, 1 wide, 2 tele, 3 fast wide, 4 fast tele", (Digits("how", 1, 0, 4),)),
    CameraCommand("ASK_ZOOM", 0xB4, "the zoom step", fixed=b"0", answer=(ZOOM,)),
    CameraCommand("ASK_ZOOM_MOST", 0xB4, "the zoom step of the tele end", fixed=b"3", answer=(ZOOM,)),
    CameraCommand("ASK_ZOOM_SPEED", 0xB4, "the speed of the zoom", fixed=b"2", answer=(Digits("speed", 1, 0, 15),)),
    CameraCommand("COARSE_ZOOM", 0xA3, "go to a coarse step: one is 15.3 fine ones",
                  (Digits("coarse zoom", 2, 0, 0x80),)),
    CameraCommand("ASK_COARSE_ZOOM", 0xA4, "the coarse zoom step", answer=(Digits("coarse zoom", 2, 0, 0x80),)),
    CameraCommand("FOCUS", 0xA1, "0 automatic, 1 by hand, 2 near, 3 far", (Digits("how", 1, 0, 3),)),
    # Lamps, and extras of the VC-C50i
    CameraCommand("FRONT_LAMP", 0x8E, "0 automatic, 1 green, 2 off, 3 red, 4 orange", (Digits("lamp", 1, 0, 4),)),
    CameraCommand("ELECTRONIC_ZOOM", 0xB7, "1, 2, 4, 8 or 12 times", (Digits("times", 2, 1, 12),), needs_lamp=True),
    CameraCommand("INFRARED_FILTER", 0xB5, "0 away (night mode), 1 in place", (Digits("in place", 1, 0, 1),),
                  needs_lamp=True),
    CameraCommand("INFRARED_LAMP", 0x76, "0 off, 6 on for the longest time", (Digits("time", 1, 0, 6),),
                  needs_lamp=True),
    # What it is, and how it is
    CameraCommand("ASK_STATUS", 0x86, "bits of `CameraStatus`, without the last ones",
                  answer=(Digits("status", 3, 0, 0xFFF),)),
    CameraCommand("ASK_LONG_STATUS", 0x86, "all bits of `CameraStatus`", fixed=b"0",
                  answer=(Digits("status", 5, 0, 0xFFFFF),)),
    CameraCommand("ASK_PRODUCT", 0x87, "what it is called", answer=(Letters("product", 5),)),
    CameraCommand("ASK_VERSION", 0x88, "its firmware", answer=(Letters("version", 5),)),
)}
"""All commands by their names."""

BY_NUMBER: Dict[int, List[CameraCommand]] = {}
"""The commands by their numbers: those with fixed digits first, as they are looked for."""
for _row in sorted(CAMERA_COMMANDS.values(), key=lambda row: -len(row.fixed)):
    BY_NUMBER.setdefault(_row.number, []).append(_row)


class CameraOrder(NamedTuple):
    """A command as a camera receives it.

    Attributes:
        camera: the number of the camera that is meant; None if it is none.
        number: the number of the command, 0 to FFFF (hex).
        command: its row; None if there is no row for this number with these digits.
        values: its values, legal or not.
    """

    camera: Optional[int]
    number: int
    command: Optional[CameraCommand]
    values: Tuple[int, ...] = ()

    @property
    def is_legal(self) -> bool:
        """Whether its digits are those of a command, with legal values."""
        return self.command is not None and all(
            row.low <= value <= row.high for row, value in zip(self.command.values, self.values))


def encode_camera_command(name: str, *values: int, camera: int = 0) -> bytes:
    """Return the bytes of a command.

    Args:
        name: its name.
        values: its values, as its row has them.
        camera: number of the camera, 0 to 15.

    Raises:
        EncodingError: there is no such command, the number of values is wrong, or one is not legal. Nothing is clamped.
    """
    row = CAMERA_COMMANDS.get(name)
    if row is None:
        raise EncodingError("no command of a camera is called %r" % name)
    if len(values) != len(row.values):
        raise EncodingError("%s takes %d values, not %d (%s)" % (name, len(row.values), len(values), row.effect))
    digits = row.fixed + b"".join(each.write(value, name) for each, value in zip(row.values, values))
    return bytes((COMMAND_BEGIN,)) + number_digits(camera) + bytes((0, row.number)) + digits + bytes((END,))


def decode_camera_command(frame: bytes) -> Optional[CameraOrder]:
    """Return what a frame from `CameraDecoder` says to a camera. None if it is too short. Never raises."""
    if len(frame) < 6:
        return None
    number, digits = int.from_bytes(frame[3:5], "big"), frame[5:-1]
    camera = Digits("camera", NUMBER_DIGITS, 0, 0xFF).read(frame[1:3])
    for row in BY_NUMBER.get(number, ()):
        values = split(row.values, digits[len(row.fixed):]) if digits.startswith(row.fixed) else None
        if values is not None:
            return CameraOrder(camera, number, row, values)
    return CameraOrder(camera, number, None)


def split(fields: Tuple[CameraField, ...], digits: bytes) -> Optional[Tuple[Any, ...]]:
    """Return the values of fields, whose digits follow each other. None if their number is wrong or one is no digit."""
    values, at = [], 0
    if len(digits) != sum(field.width for field in fields):
        return None
    for field in fields:
        values.append(field.read(digits[at:at + field.width]))
        at += field.width
    return None if None in values else tuple(values)


def number_digits(camera: int) -> bytes:
    """Return the digits of the number of a camera (0 to 15). Raises EncodingError when it is another."""
    return Digits("number", NUMBER_DIGITS, 0, 15).write(camera, "camera")
