"""Messages as plain objects, made from definitions without ROS. The bytes are written here by hand, as ROS has them."""

import struct
import sys

import pytest

from pioneer_control.bags import records
from pioneer_control.bags.plain_messages import RosTime, plain_class
from pioneer_control.bags.reader import BagConnection, decode
from pioneer_control.bags.records import BagError

RULE = "=" * 80 + "\n"
STAMPED = ("# a comment\nHeader header\nuint8 LASER=2   # a constant\nstring NAME= a # b\nPoint[] points  # words\n"
           "uint8[] raw\nfloat32[3] three\nbool on\nstring[] names\nduration d\n" + RULE +
           "MSG: std_msgs/Header\nuint32 seq\ntime stamp\nstring frame_id\n" + RULE +
           "MSG: test/Point\nfloat64 x\nfloat64 y\n")
BYTES = (struct.pack("<III", 7, 12, 500000000) + struct.pack("<I", 3) + b"map" +
         struct.pack("<I4d", 2, 1.0, 2.0, 3.0, 4.0) + struct.pack("<I", 2) + b"\x01\xff" +
         struct.pack("<3f", 0.5, 1.5, 2.5) + b"\x01" + struct.pack("<I", 2) + struct.pack("<I", 1) + b"a" +
         struct.pack("<I", 2) + b"\xc3\xa9" + struct.pack("<ii", -1, 0))


def test_each_kind_of_field():
    message = plain_class("test/Stamped", STAMPED)().deserialize(BYTES)
    assert (message.header.seq, message.header.stamp, message.header.frame_id) == (7, RosTime(12, 500000000), "map")
    assert [(point.x, point.y) for point in message.points] == [(1.0, 2.0), (3.0, 4.0)]
    assert (message.raw, message.three, message.on) == (b"\x01\xff", (0.5, 1.5, 2.5), True)
    assert message.names == ["a", "\u00e9"] and message.d == RosTime(-1, 0)
    assert (message.LASER, message.NAME, message._type) == (2, "a # b", "test/Stamped")


def test_times_are_subtracted():
    assert (RosTime(12, 1) - RosTime(10, 999999999)).to_sec() == pytest.approx(1.000000002)
    assert RosTime(1, 500000000).to_sec() == 1.5


@pytest.mark.parametrize("length", range(len(BYTES)))
def test_what_is_cut_off_is_refused(length):
    with pytest.raises(struct.error):
        plain_class("test/Stamped", STAMPED)().deserialize(BYTES[:length])


@pytest.mark.parametrize("definition", ["uint8[] a", "float64[] a", "string a", "string[] a", "Empty[] a\n" + RULE +
                                        "MSG: test/Empty\nuint8 b\n"])
def test_a_length_beyond_all_bytes_is_refused_at_once(definition):
    with pytest.raises(struct.error):
        plain_class("test/A", definition)().deserialize(b"\xff\xff\xff\xff123")


@pytest.mark.parametrize("definition, words", [
    ("Unknown a", "no definition of test/Unknown"), ("uint8 a b", "is no field"), ("A a", "contains itself"),
    ("B b\n" + RULE + "MSG: test/B\nA a\n", "contains itself"), ("uint8 a=x", "invalid literal"),
    ("<html>", "is no field"),
])
def test_a_definition_that_makes_no_sense_is_refused(definition, words):
    with pytest.raises(ValueError, match=words):
        plain_class("test/A", definition)


@pytest.fixture
def without_ros(monkeypatch):
    for name in ("genpy", "genpy.dynamic", "roslib", "roslib.message", "roslz4", "lz4", "lz4.frame"):
        monkeypatch.setitem(sys.modules, name, None)


def connection(definition, md5sum):
    return BagConnection("/a", "test/A", md5sum, definition, False, "", {})


def test_a_bag_is_read_without_ros(without_ros):
    assert decode(connection("int8 a", "1"), b"\xff").a == -1
    with pytest.raises(BagError, match="a message on /a is damaged"):
        decode(connection("int16 a", "2"), b"\xff")


@pytest.mark.parametrize("definition", ["uint8[99999999] a", "what is this", "C[] c\n" + RULE + "MSG: test/C\n"])
def test_a_hostile_definition_is_an_error_of_the_bag(without_ros, definition):
    with pytest.raises(BagError, match="makes no sense"):
        decode(connection(definition, definition), b"\xff\xff\xff\x7f")


def test_what_is_missing_for_lz4_is_said(without_ros):
    with pytest.raises(BagError, match="pip install lz4"):
        records._decompressor(b"lz4")


def test_damage_in_lz4_is_damage_of_the_chunk(monkeypatch):
    class Frame:
        def decompress(self, piece):
            raise RuntimeError("LZ4F_decompress failed")

    monkeypatch.setitem(sys.modules, "roslz4", None)
    monkeypatch.setitem(sys.modules, "lz4", type(sys)("lz4"))
    monkeypatch.setitem(sys.modules, "lz4.frame", type(sys)("lz4.frame"))
    sys.modules["lz4.frame"].LZ4FrameDecompressor = Frame
    with pytest.raises(OSError, match="failed"):
        records._decompressor(b"lz4")(b"x", 1)
