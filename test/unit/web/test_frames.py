"""Frames for the page: bytes that were written by hand from docs/page-protocol.md, limits, and every value and back."""

import math
import pathlib
import re

import pytest
from hypothesis import given
from hypothesis import strategies as some

from pioneer_control.errors import EncodingError, UsageError
from pioneer_control.web.frames import (
    FIELDS, LAYOUT, FrameFlags, GripperBits, RobotFrame, encode_frame, frame_head, frames_message, range_code,
    read_frames, stamp_age, stamp_of)

PROTOCOL = (pathlib.Path(__file__).resolve().parents[3] / "docs" / "page-protocol.md").read_text(encoding="utf-8")

GOLDEN = [
    (RobotFrame(robot=0), "0000 00000000 0000 00000000 00000000 0000 0000 0000 0000 00 00"),
    # 1.5 m is 1500 = 05DC; -2 m is -2000 = FFFFF830; a quarter turn is 4000; -0.25 m/s is FF06; 1 rad/s is 03E8
    (RobotFrame(robot=7, stamp=0x01020304, age=0.25, x=1.5, y=-2.0, heading=math.pi / 2, linear=-0.25, angular=1.0,
                flags=FrameFlags.LINK | FrameFlags.MOTORS | FrameFlags.LOCKED,
                gripper=GripperBits.FITTED | GripperBits.HOLDS, sonar=(0.5, 5.0, math.inf, None)),
     "0700 04030201 FA00 DC050000 30F8FFFF 0040 06FF E803 0301 81 04 19 FA FB FF"),
    (RobotFrame(robot=65535, stamp=2 ** 32 - 1, age=99.0, x=-0.001, y=2147483.647, heading=-math.pi / 2, linear=-99.0,
                angular=99.0, flags=65535, gripper=255, sonar=(0.0,)),
     "FFFF FFFFFFFF FFFF FFFFFFFF FFFFFF7F 00C0 0080 FF7F FFFF FF 01 00"),
]


@pytest.mark.parametrize("frame, written", GOLDEN)
def test_bytes_written_by_hand(frame, written):
    assert encode_frame(frame) == bytes.fromhex(written)
    read, = read_frames(b"\x01" + bytes.fromhex(written))
    assert read.sonar == frame.sonar and (read.robot, read.stamp, read.flags, read.gripper) == (
        frame.robot, frame.stamp, frame.flags, frame.gripper)


def test_the_table_is_that_of_the_document():
    """Offsets and types of the document's table are those of FIELDS, in order."""
    part = PROTOCOL[PROTOCOL.index("| offset | type |"):]
    rows = [(int(offset), kind) for offset, kind in re.findall(r"^\| (\d+) \| ([ui]\d+) \|", part, re.MULTILINE)]
    at, expected = 0, []
    for field in FIELDS:
        size = LAYOUT.__class__("<" + field.type).size
        expected.append((at, ("u" if field.type.isupper() else "i") + str(8 * size)))
        at += size
    assert rows == expected + [(at, "u8")] and LAYOUT.size == at + 1


def test_flags_are_those_of_the_document():
    told = re.search(r"^Flags: (.*?\.)$", PROTOCOL, re.MULTILINE | re.DOTALL).group(1)
    numbers = [int(number) for number in re.findall(r"(?:bit |, )(\d) ", told)]
    assert numbers == [flag.value.bit_length() - 1 for flag in FrameFlags]


@pytest.mark.parametrize("name, value", [
    ("robot", -1), ("robot", 65536), ("stamp", -1), ("stamp", 2 ** 32), ("x", 2147484.0), ("y", -2147484.0),
    ("x", math.nan), ("x", math.inf), ("y", -math.inf), ("heading", math.nan), ("heading", math.inf),
    ("linear", math.nan), ("age", math.nan), ("flags", 65536), ("flags", -1), ("gripper", 256)])
def test_a_value_that_does_not_fit_is_named(name, value):
    with pytest.raises(EncodingError, match="^%s is " % name):
        encode_frame(RobotFrame(1)._replace(**{name: value}))


@pytest.mark.parametrize("name, value, kept", [
    ("age", 65.6, 65.535), ("age", math.inf, 65.535), ("age", -1.0, 0.0), ("linear", math.inf, 32.767),
    ("angular", -math.inf, -32.768), ("linear", 1e308, 32.767)])
def test_age_and_velocities_are_clamped(name, value, kept):
    read, = read_frames(frames_message([encode_frame(RobotFrame(1)._replace(**{name: value}))]))
    assert getattr(read, name) == kept


@pytest.mark.parametrize("metres, code", [
    (0.0, 0), (0.011, 1), (4.99, 250), (5.0, 250), (5.01, 251), (math.inf, 251), (None, 255)])
def test_ranges(metres, code):
    assert range_code(metres) == code


@pytest.mark.parametrize("metres", [-0.1, math.nan, -math.inf])
def test_a_range_that_no_sonar_has(metres):
    with pytest.raises(EncodingError, match="sonar range"):
        encode_frame(RobotFrame(1, sonar=(metres,)))


def test_more_sonar_than_fit():
    assert len(read_frames(frames_message([encode_frame(RobotFrame(1, sonar=(None,) * 255))]))[0].sonar) == 255
    with pytest.raises(EncodingError, match="256"):
        encode_frame(RobotFrame(1, sonar=(None,) * 256))


FRAMES = some.builds(
    RobotFrame, robot=some.integers(0, 65535), stamp=some.integers(0, 2 ** 32 - 1), age=some.floats(0, 65),
    x=some.floats(-2e6, 2e6), y=some.floats(-2e6, 2e6), heading=some.floats(-10, 10), linear=some.floats(-32, 32),
    angular=some.floats(-32, 32), flags=some.integers(0, 65535), gripper=some.integers(0, 255),
    sonar=some.lists(some.none() | some.floats(0, 5) | some.just(math.inf), max_size=20).map(tuple))


@given(some.lists(FRAMES, max_size=5))
def test_what_is_written_is_read(frames):
    read = read_frames(frames_message(map(encode_frame, frames)))
    assert len(read) == len(frames)
    for one, other in zip(frames, read):
        assert abs(one.x - other.x) <= 0.00051 and abs(one.y - other.y) <= 0.00051
        assert abs(one.linear - other.linear) <= 0.00051 and abs(one.age - other.age) <= 0.00051
        assert abs((one.heading - other.heading + math.pi) % (2 * math.pi) - math.pi) <= 0.0001
        assert -math.pi <= other.heading <= math.pi
        for metres, back in zip(one.sonar, other.sonar):
            assert metres == back if metres is None or metres == math.inf else abs(metres - back) <= 0.0101
        assert encode_frame(other) == encode_frame(read_frames(frames_message([encode_frame(other)]))[0])


@given(some.binary(max_size=200))
def test_any_bytes_are_frames_or_an_error(data):
    try:
        read_frames(data)
    except UsageError:
        pass


@given(some.lists(FRAMES, min_size=1, max_size=3), some.data())
def test_half_a_frame_is_an_error(frames, data):
    pieces = [encode_frame(frame) for frame in frames]
    message = frames_message(pieces)
    whole = {1 + sum(map(len, pieces[:count])) for count in range(len(pieces) + 1)}
    cut = data.draw(some.integers(0, len(message) - 1).filter(lambda length: length not in whole))
    with pytest.raises(UsageError):
        read_frames(message[:cut])


def test_the_head_of_a_frame():
    frame = encode_frame(RobotFrame(300, 77, 1.0, x=1.25, y=-3.5, sonar=(1.0, None)))
    assert frame_head(frame) == (300, 77, 1.25, -3.5)
    for wrong in (b"", frame[:-1], frame + b"\0", frame + frame):
        with pytest.raises(UsageError):
            frame_head(wrong)


def test_stamps_go_round():
    almost = 2 ** 32 / 1000 - 0.1
    assert stamp_of(almost + 0.2) in (99, 100) and abs(stamp_age(stamp_of(almost), almost + 0.2) - 0.2) < 0.0011
    assert stamp_age(stamp_of(10.0), 10.0) == 0.0
    assert stamp_age(stamp_of(10.1), 10.0) > 4e6     # of the future
