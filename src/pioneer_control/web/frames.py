"""Frames: what changes ten times a second of a robot, as bytes for the page. docs/page-protocol.md has the layout.

>>> data = encode_frame(RobotFrame(robot=7, x=1.5))
>>> read_frames(frames_message([data]))[0].x
1.5

Everything here is pure. The table FIELDS is read by the writer and by the reader.
"""

import math
import struct
from enum import IntFlag
from typing import Any, Dict, Iterable, List, NamedTuple, Optional, Tuple

from ..errors import EncodingError, UsageError

FRAMES, COLUMNS, WHOLE = b"\x01", b"\x02", b"\x03"
"""The first byte of a binary message: frames of live robots, the columns of a recording (see `columns`), or what a
recording says about the whole run.
"""
STAMPS = 2 ** 32
"""Stamps are ms modulo this number."""
TURN = 65536
"""Units of a heading in one turn."""
RANGE_STEP = 0.02       # m
LONGEST_RANGE = 5.0     # m
NO_ECHO, NOT_HEARD = 251, 255
MOST_SONAR = 255


class FrameFlags(IntFlag):
    """The bits of the flags of a frame."""

    LINK = 1
    MOTORS = 2
    STOP_BUTTON = 4
    LEFT_STALL = 8
    RIGHT_STALL = 16
    FRONT_BUMPER = 32
    REAR_BUMPER = 64
    SONAR = 128
    LOCKED = 256
    CHARGING = 512


class GripperBits(IntFlag):
    """The bits of the gripper of a frame. FITTED is set in every frame of a robot that has a gripper."""

    FITTED = 1
    PADDLES_OPEN = 2
    PADDLES_CLOSED = 4
    PADDLES_MOVING = 8
    LIFT_UP = 16
    LIFT_DOWN = 32
    LIFT_MOVING = 64
    HOLDS = 128


class RobotFrame(NamedTuple):
    """The values of one frame.

    A range of the sonar is in m, infinite without an echo, and None when the sonar was not heard for 2 s.
    """

    robot: int
    """The number of the robot, 0 to 65535."""
    stamp: int = 0
    """When the frame was made, as stamp_of() gives it."""
    age: float = 0.0
    """s from the arrival of the robot's packet until the stamp."""
    x: float = 0.0
    """m, in the odometry frame."""
    y: float = 0.0
    heading: float = 0.0
    """rad, counter-clockwise positive. A frame that was read has -pi to pi."""
    linear: float = 0.0
    """m/s, forward positive."""
    angular: float = 0.0
    """rad/s, counter-clockwise positive."""
    flags: int = 0
    """FrameFlags."""
    gripper: int = 0
    """GripperBits."""
    sonar: Tuple[Optional[float], ...] = ()


class FrameField(NamedTuple):
    """One row of the table: how a value of a RobotFrame is written.

    ``type`` is a letter of the module struct. ``scale`` is the number of steps in one unit of the value. ``beyond``
    says what happens to a value that the field cannot hold: "error", "clamp" (the nearest number) or "wrap" (a turn
    more or less is the same).
    """

    name: str
    type: str
    scale: float
    beyond: str

    @property
    def legal(self) -> Tuple[int, int]:
        """The least and the largest number of steps."""
        bits = 8 * struct.calcsize("<" + self.type)
        return (0, 2 ** bits - 1) if self.type.isupper() else (-2 ** (bits - 1), 2 ** (bits - 1) - 1)

    def steps(self, value: float) -> int:
        """Return a value in steps of this field. Raises EncodingError for NaN, and for a value that does not fit."""
        low, high = self.legal
        scaled = value * self.scale
        if self.beyond == "clamp":
            scaled = min(max(scaled, low), high)
        if not math.isfinite(scaled):
            raise EncodingError("%s is %r; legal: a finite number" % (self.name, value))
        number = round(scaled)
        if self.beyond == "wrap":
            return number % TURN
        if not low <= number <= high:
            raise EncodingError("%s is %r; legal: %g to %g" % (self.name, value, low / self.scale, high / self.scale))
        return number


FIELDS: Tuple[FrameField, ...] = (
    FrameField("robot", "H", 1, "error"),
    FrameField("stamp", "I", 1, "error"),
    FrameField("age", "H", 1000, "clamp"),
    FrameField("x", "i", 1000, "error"),
    FrameField("y", "i", 1000, "error"),
    FrameField("heading", "H", TURN / (2 * math.pi), "wrap"),
    FrameField("linear", "h", 1000, "clamp"),
    FrameField("angular", "h", 1000, "clamp"),
    FrameField("flags", "H", 1, "error"),
    FrameField("gripper", "B", 1, "error"),
)
"""In the order of the bytes. The number of sonar ranges (u8) and the ranges (u8 each) follow."""
LAYOUT = struct.Struct("<" + "".join(field.type for field in FIELDS) + "B")
HEAD = struct.Struct("<HIHii")


def stamp_of(now: float) -> int:
    """Return the stamp of a time (monotonic, s)."""
    return int(now * 1000) % STAMPS


def stamp_age(stamp: int, now: float) -> float:
    """Return the age (s) of a stamp at a time (monotonic, s). A stamp of the future is very old."""
    return (stamp_of(now) - stamp) % STAMPS / 1000


def range_code(metres: Optional[float]) -> int:
    """Return the byte of a sonar range (m). Raises EncodingError for a range that is negative or NaN."""
    if metres is None:
        return NOT_HEARD
    if not metres >= 0:
        raise EncodingError("a sonar range is %r; legal: 0 m or more, or None" % metres)
    return NO_ECHO if metres > LONGEST_RANGE else round(metres / RANGE_STEP)


def range_of(code: int) -> Optional[float]:
    """Return the sonar range (m) of a byte: infinite without an echo, None when not heard."""
    return code * RANGE_STEP if code < NO_ECHO else math.inf if code == NO_ECHO else None


def frame_steps(frame: RobotFrame) -> List[int]:
    """Return the values of a frame in steps of their fields, without the sonar. Raises EncodingError."""
    values: Any = frame     # its sonar, the last, has no field
    return [field.steps(value) for field, value in zip(FIELDS, values)]


def frame_from(steps: Iterable[int], codes: Iterable[int]) -> RobotFrame:
    """Return the frame with these steps of its fields and these bytes of its sonar: the inverse of frame_steps()."""
    values: Dict[str, Any] = {}
    for field, number in zip(FIELDS, steps):
        if field.beyond == "wrap":
            number = (number + TURN // 2) % TURN - TURN // 2
        values[field.name] = number if field.scale == 1 else number / field.scale
    return RobotFrame(sonar=tuple(map(range_of, codes)), **values)


def encode_frame(frame: RobotFrame) -> bytes:
    """Return one frame as bytes, without the first byte of a message.

    Age and velocities beyond their fields are clamped. Raises EncodingError for any other value that does not fit.
    """
    if len(frame.sonar) > MOST_SONAR:
        raise EncodingError("there are %d sonar ranges; legal: 0 to %d" % (len(frame.sonar), MOST_SONAR))
    return LAYOUT.pack(*frame_steps(frame), len(frame.sonar)) + bytes(map(range_code, frame.sonar))


def frames_message(frames: Iterable[bytes]) -> bytes:
    """Return a message with these frames, as encode_frame() gives them."""
    return FRAMES + b"".join(frames)


def read_frames(message: bytes) -> List[RobotFrame]:
    """Return the frames of a message. Raises UsageError for a message that is cut off or of another kind."""
    if message[:1] != FRAMES:
        raise UsageError("this message does not begin with 1, the kind of frames, but with %r" % message[:1])
    frames, at = [], 1
    while at < len(message):
        end = at + LAYOUT.size
        count = message[end - 1] if end <= len(message) else MOST_SONAR
        if end + count > len(message):
            raise UsageError("the frame at byte %d is cut off" % at)
        frames.append(frame_from(LAYOUT.unpack_from(message, at), message[end:end + count]))
        at = end + count
    return frames


class FrameHead(NamedTuple):
    """The first fields of a frame as bytes, for a server that only passes frames on: x and y are in m."""

    robot: int
    stamp: int
    x: float
    y: float


def frame_head(frame: bytes) -> FrameHead:
    """Return the first fields of one frame. Raises UsageError if this is not one whole frame."""
    if len(frame) < LAYOUT.size or len(frame) != LAYOUT.size + frame[LAYOUT.size - 1]:
        raise UsageError("%d bytes are not one whole frame" % len(frame))
    robot, stamp, _, x_mm, y_mm = HEAD.unpack_from(frame)
    return FrameHead(robot, stamp, x_mm / 1000, y_mm / 1000)
