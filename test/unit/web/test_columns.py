"""The columns of a recording: a small one by hand, and what is written is read."""

import math
import struct
import zlib

import pytest
from hypothesis import given
from hypothesis import strategies as some

from pioneer_control.errors import EncodingError, UsageError
from pioneer_control.web.columns import columns, read_columns
from pioneer_control.web.frames import RobotFrame


def test_two_rows_by_hand():
    rows = [(0.5, RobotFrame(3, x=1.0, y=-0.5, heading=3.0, linear=0.2, flags=1, sonar=(1.0, None))),
            (0.6, RobotFrame(3, x=1.02, y=-0.5, heading=-3.0, linear=0.2, flags=3, sonar=(math.inf, 0.5)))]
    message = columns(3, rows)
    assert message[:3] == b"\x02\x03\x00"
    turned = round((2 * math.pi - 6.0) * 65536 / (2 * math.pi))      # on over half a turn, not back
    assert struct.unpack("<20i", zlib.decompress(message[3:])) == (
        500, 100, 1000, 20, -500, 0, 31291, turned, 200, 0, 0, 0, 1, 2, 0, 0, 50, 201, 255, -230)


def test_no_rows():
    assert read_columns(columns(9, []), 0, 0) == (9, [])


def test_a_sonar_that_comes_later():
    message = columns(1, [(0.0, RobotFrame(1)), (1.0, RobotFrame(1, sonar=(2.0,)))])
    assert [frame.sonar for _, frame in read_columns(message, 2, 1).frames] == [(None,), (2.0,)]


ROWS = some.lists(some.tuples(
    some.integers(0, 10 ** 9).map(lambda ms: ms / 1000),
    some.builds(RobotFrame, robot=some.just(5), x=some.floats(-2e6, 2e6), y=some.floats(-2e6, 2e6),
                heading=some.floats(-4, 4), linear=some.floats(-2, 2), angular=some.floats(-5, 5),
                flags=some.integers(0, 65535), gripper=some.integers(0, 255),
                sonar=some.tuples(some.none() | some.floats(0, 5)))), max_size=20)


@given(ROWS)
def test_what_is_written_is_read(rows):
    robot, read = read_columns(columns(5, rows), len(rows), 1 if rows else 0)
    assert robot == 5 and len(read) == len(rows)
    for (time, one), (time_read, other) in zip(rows, read):
        assert abs(time - time_read) < 0.0006
        assert abs(one.x - other.x) < 0.0006 and abs(one.y - other.y) < 0.0006 and one.flags == other.flags
        assert abs((one.heading - other.heading + math.pi) % (2 * math.pi) - math.pi) <= 0.0001


def test_errors():
    with pytest.raises(EncodingError, match="time"):
        columns(1, [(-1.0, RobotFrame(1))])
    with pytest.raises(EncodingError, match="time"):
        columns(1, [(math.nan, RobotFrame(1))])
    with pytest.raises(EncodingError, match="robot"):
        columns(-1, [])
    message = columns(1, [(0.0, RobotFrame(1))])
    for wrong, rows in ((b"\x01" + message[1:], 1), (b"", 1), (message[:-3], 1), (message, 2), (b"\x02\0\0abc", 0)):
        with pytest.raises(UsageError):
            read_columns(wrong, rows, 0)
