"""The messages between owner and server: whole in any pieces, and the owner never waits and never keeps much."""

import json
import socket

import pytest
from hypothesis import given
from hypothesis import strategies as some

from pioneer_control.errors import UsageError
from pioneer_control.web.backend import TEACHERS
from pioneer_control.web.exchange import (
    BEAT_MESSAGE, BYTES, CLOSED, FRAME, LENGTH, LONGEST, MOST_FOR_PROGRAMS, MOST_WAITING, OPENED, SAID, TEXT, Outbox,
    Unpacker, bytes_of, packed, packed_bytes, packed_json)
from pioneer_control.web.frames import RobotFrame, encode_frame, frame_head
from pioneer_control.web.guard import Farewell


def test_bytes_written_by_hand():
    assert packed(BEAT_MESSAGE) == b"\x01\0\0\0B"
    assert packed_json(TEXT, {"a": 1}) == b'\x08\0\0\0T{"a":1}'


@given(some.lists(some.tuples(some.sampled_from([b"B", b"T", b"F"]), some.binary(max_size=50)), max_size=8),
       some.lists(some.integers(1, 9), min_size=1))
def test_any_pieces_give_whole_messages(parts, sizes):
    data, unpacker, found, turn = b"".join(packed(*part) for part in parts), Unpacker(), [], 0
    while data:
        size = sizes[turn % len(sizes)]
        found += unpacker.take(data[:size])
        data, turn = data[size:], turn + 1
    assert found == parts


@pytest.mark.parametrize("length", [0, LONGEST + 1, 2 ** 32 - 1])
def test_a_length_that_nobody_sends(length):
    with pytest.raises(UsageError, match=str(length)):
        Unpacker().take(LENGTH.pack(length))


@pytest.fixture
def ends():
    ours, theirs = socket.socketpair()
    with ours, theirs:
        for each in (ours, theirs):
            each.setblocking(False)
        yield ours, theirs


def read_all(end, outbox):
    """Return all messages that the outbox has for this end, also those that wait for room."""
    unpacker, found, empty = Unpacker(), [], 0
    while empty < 2:
        try:
            found += unpacker.take(end.recv(65536))
            empty = 0
        except BlockingIOError:
            outbox.flush()
            empty += 1
    return found


def test_without_a_server_only_the_newest_waits(ends):
    ours, theirs = ends
    outbox = Outbox()
    for step in range(1000):
        outbox.frame(encode_frame(RobotFrame(1, step)))
        outbox.text("status", {"step": step}, 1)
        outbox.said("info", str(step))
    outbox.text("robots", [])
    outbox.connect(ours, [packed(b"C", b"first")])
    kinds = read_all(theirs, outbox)
    assert [kind for kind, _ in kinds] == [b"C", TEXT, TEXT, FRAME]
    assert json.loads(kinds[1][1])["kind"] == "robots" and json.loads(kinds[2][1])["value"] == {"step": 999}
    assert frame_head(kinds[3][1]).stamp == 999


def test_a_server_that_does_not_read_costs_little_and_gets_the_newest(ends):
    ours, theirs = ends
    outbox = Outbox()
    outbox.connect(ours, [])
    for step in range(20000):
        outbox.frame(encode_frame(RobotFrame(step % 3, step, sonar=(1.0,) * 16)))
        outbox.said("info", str(step))
    assert outbox.flush() and len(outbox._said) <= MOST_WAITING and len(outbox._frames) <= 3
    found = read_all(theirs, outbox)
    assert sorted(frame_head(data).stamp for kind, data in found if kind == FRAME)[-3:] == [19997, 19998, 19999]
    assert json.loads([data for kind, data in found if kind == SAID][-1])["text"] == "19999"


def test_a_large_text_goes_in_pieces(ends):
    ours, theirs = ends
    outbox = Outbox()
    outbox.connect(ours, [])
    outbox.text("world", "x" * 3000000)
    assert outbox.flush()
    (kind, data), = read_all(theirs, outbox)
    assert kind == TEXT and len(json.loads(data)["value"]) == 3000000


def test_a_server_that_is_gone_is_no_error_and_the_next_one_gets_all(ends):
    ours, theirs = ends
    outbox = Outbox()
    outbox.connect(ours, [])
    theirs.close()
    outbox.text("world", None)
    outbox.text("helm", {"you": False}, 2, "secret")
    outbox.disconnect()
    assert not outbox.flush()
    again, other = socket.socketpair()
    with again, other:
        again.setblocking(False)
        other.setblocking(False)
        outbox.connect(again, [])
        assert [json.loads(data)["kind"] for _, data in read_all(other, outbox)] == ["world", "helm"]


def test_what_is_taken_back_from_a_visitor_is_told_and_not_kept(ends):
    """A class of which students come and go for hours does not grow."""
    ours, theirs = ends
    outbox = Outbox()
    outbox.connect(ours, [])
    outbox.text("mine", None, to=TEACHERS)
    for number in range(100):
        outbox.text("mine", {"robot": 1}, to="visitor%d" % number)
        outbox.text("mine", None, to="visitor%d" % number)
        assert json.loads(read_all(theirs, outbox)[-1][1])["value"] is None
    outbox.text("mine", {"robot": 2}, to="visitor0")
    assert sorted(outbox._known) == [("mine", None, TEACHERS), ("mine", None, "visitor0")]
    again, other = socket.socketpair()
    with again, other:
        again.setblocking(False)
        other.setblocking(False)
        outbox.connect(again, [])
        assert [json.loads(data)["to"] for _, data in read_all(other, outbox)] == [TEACHERS, "visitor0"]


def test_bytes_of_programs_keep_their_order_and_never_grow(ends):
    ours, theirs = ends
    outbox = Outbox()
    outbox.connect(ours, [])
    outbox.open_program(7, "rosie")
    for step in range(MOST_FOR_PROGRAMS):
        outbox.program_bytes(7, bytes([step % 256]) * 500)
    outbox.close_program(7, Farewell(4409, "why"))
    assert outbox.flush() and len(outbox._for_programs) <= MOST_FOR_PROGRAMS
    found = read_all(theirs, outbox)
    assert found[0] == (OPENED, b'{"program":7,"robot":"rosie"}')
    assert json.loads(found[-1][1].decode()) == {"program": 7, "code": 4409, "reason": "why"} and found[-1][0] == CLOSED
    assert [bytes_of(data) for kind, data in found if kind == BYTES][:3] == [
        (7, b"\0" * 500), (7, b"\1" * 500), (7, b"\2" * 500)]
    assert packed_bytes(7, b"x") == b"\x06\0\0\0P\x07\0\0\0x"
    with pytest.raises(ValueError):
        bytes_of(b"abc")


def test_what_is_for_few_is_kept_for_the_next_server(ends):
    ours, theirs = ends
    outbox = Outbox()
    outbox.text("join", True)
    outbox.text("join", False, to="visitor")
    outbox.connect(ours, [])
    assert [json.loads(data)["to"] for _, data in read_all(theirs, outbox)] == ["", "visitor"]
