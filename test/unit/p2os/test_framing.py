"""Frames in a stream, with any pieces and any noise. No whole frame is lost, and no broken frame is accepted."""

import random

import golden
import pytest

from pioneer_control import p2os
from pioneer_control.errors import EncodingError

STOP = bytes.fromhex("FA FB 03 1D 00 1D")
VEL = bytes.fromhex("FA FB 06 0B 1B C8 00 D3 1B")
JUNK = [b"\0", b"\xFA", b"\xFB", b"\xFA\xFA", b"\xFB\xFA", b"\xFA\x03", b"\xFA\xFB\x02", b"\xFA\xFB\x00", b"WMS2\r",
        bytes(range(256)), VEL[:-1] + b"\0", b"\xFA\xFB\x05\x01\x02\x03\x04\x05"]

examples = pytest.mark.parametrize("data", [golden.wire(example) for example in golden.EXAMPLES],
                                   ids=[golden.label(example) for example in golden.EXAMPLES])


def long_frame(count: int, id: int = 0x32) -> bytes:
    """Return a frame with this byte count, which may be larger than we send."""
    body = bytes([id]) + bytes(at * 7 % 256 for at in range(count - 3))
    return b"\xFA\xFB" + bytes([count]) + body + p2os.checksum(body).to_bytes(2, "big")


def test_checksum_against_a_plain_sum():
    """The checksum is compared with the rule of the manual, step by step, on seeded bodies of every length."""
    draw = random.Random(1)
    for length in range(1, 254):
        body = bytes(draw.randrange(256) for _ in range(length))
        total = 0
        for at in range(0, length - 1, 2):
            total = (total + (body[at] << 8) + body[at + 1]) % 65536
        if length % 2:
            total ^= body[-1]
        assert p2os.checksum(body) == total


@examples
def test_split_anywhere(data):
    whole = [golden.frame(data)]
    for at in range(len(data)):
        decoder = p2os.FrameDecoder()
        assert decoder.feed(data[:at]) == []
        assert decoder.waiting == (at > 0)
        assert decoder.feed(data[at:]) == whole
        assert decoder.counts == (1, 0, 0, 0) and not decoder.waiting


@examples
def test_byte_by_byte(data):
    decoder = p2os.FrameDecoder()
    frames = [decoder.feed(data[at:at + 1]) for at in range(len(data))]
    assert frames == [[]] * (len(data) - 1) + [[golden.frame(data)]]


@pytest.mark.parametrize("junk", JUNK, ids=bytes.hex)
@pytest.mark.parametrize("data", [STOP, VEL], ids=["STOP", "VEL"])
def test_after_junk(data, junk):
    decoder = p2os.FrameDecoder()
    frames = decoder.feed(junk + data) + decoder.feed(STOP)
    frames += decoder.drop_partial()
    assert frames == [golden.frame(data), golden.frame(STOP)]
    assert decoder.counts.discarded_bytes == len(junk)


@examples
def test_a_corrupt_byte_never_yields_the_frame(data):
    """Every single-bit error in each byte: the frame is not delivered, and the next frames are."""
    for at in range(len(data)):
        for bit in range(8):
            corrupt = bytearray(data)
            corrupt[at] ^= 1 << bit
            decoder = p2os.FrameDecoder()
            frames = decoder.feed(bytes(corrupt) + STOP * 2) + decoder.drop_partial()
            assert frames == [golden.frame(STOP)] * 2
            assert decoder.counts.discarded_bytes == len(data)


@pytest.mark.parametrize("data", [STOP, VEL, long_frame(40)], ids=["STOP", "VEL", "40"])
def test_no_wrong_byte_is_believed(data):
    """Every wrong value of each byte."""
    for at in range(len(data)):
        for value in set(range(256)) - {data[at]}:
            decoder = p2os.FrameDecoder()
            frames = decoder.feed(data[:at] + bytes([value]) + data[at + 1:]) + decoder.drop_partial()
            assert frames == []


def test_a_lost_byte_costs_one_frame_at_most():
    for at in range(len(VEL)):
        decoder = p2os.FrameDecoder()
        frames = decoder.feed(VEL[:at] + VEL[at + 1:] + STOP + VEL) + decoder.drop_partial()
        assert frames == [golden.frame(STOP), golden.frame(VEL)]


def test_glued():
    stream = b"".join(golden.wire(example) for example in golden.EXAMPLES)
    whole = [golden.frame(golden.wire(example)) for example in golden.EXAMPLES]
    assert p2os.FrameDecoder().feed(stream) == whole
    draw, decoder, frames, at = random.Random(2), p2os.FrameDecoder(), [], 0
    while at < len(stream):
        size = draw.randrange(1, 70)
        frames += decoder.feed(stream[at:at + size])
        at += size
    assert frames == whole
    assert decoder.counts == (len(whole), 0, 0, 0)


@pytest.mark.parametrize("count", range(3, 256))
def test_every_byte_count_is_accepted(count):
    frame, = p2os.FrameDecoder().feed(long_frame(count))
    assert len(frame.data) == count - 3


@pytest.mark.parametrize("count", range(3))
def test_no_smaller_byte_count_is(count):
    decoder = p2os.FrameDecoder()
    assert decoder.feed(b"\xFA\xFB" + bytes([count]) + b"\0\0\0" + STOP) == [golden.frame(STOP)]
    assert decoder.counts == (1, 6, 0, 1)


def test_a_frame_inside_a_broken_frame_is_found():
    broken = b"\xFA\xFB\x20\x33" + STOP + VEL + b"\0" * 20
    decoder = p2os.FrameDecoder()
    assert decoder.feed(broken) == [golden.frame(STOP), golden.frame(VEL)]
    assert decoder.counts.bad_checksums == 1


def test_a_frame_inside_a_good_frame_is_data():
    good = p2os.encode_command("TTY2", STOP)
    assert p2os.FrameDecoder().feed(good) == [golden.frame(good)]


def test_drop_partial_gives_back_what_the_partial_frame_hid():
    decoder = p2os.FrameDecoder()
    assert decoder.feed(b"\xFA\xFB\xFF" + STOP + b"\xFA\xFB\x50" + VEL + b"\xFA") == []
    assert decoder.waiting
    assert decoder.drop_partial() == [golden.frame(STOP), golden.frame(VEL)]
    assert not decoder.waiting and decoder.counts == (2, 7, 0, 0)
    assert decoder.drop_partial() == []
    assert decoder.feed(STOP) == [golden.frame(STOP)]


@pytest.mark.parametrize("pattern", [b"\xFA\xFB\xFF", b"\xFA", b"\xFA\xFB", b"\xFA\xFB\xFF\xFA\xFB\x80"], ids=bytes.hex)
def test_a_hostile_line_is_bounded(pattern):
    """Two hundred kilobytes of false starts: the decoder holds few bytes, reads no place twice, and finds a good frame.
    """
    decoder, looked_at = p2os.FrameDecoder(), []
    decoder._frame_end = lambda held, at, look=decoder._frame_end: looked_at.append(at) or look(held, at)
    chunk = pattern * (1000 // len(pattern))
    for _ in range(200):
        assert decoder.feed(chunk) == []
        assert len(decoder._held) <= 257
    assert len(looked_at) <= 200 * (len(chunk) + 1)
    assert decoder.feed(STOP) + decoder.drop_partial() == [golden.frame(STOP)]
    assert decoder.counts.discarded_bytes == 200 * len(chunk)


def test_nothing_on_the_line_raises_and_every_byte_is_accounted_for():
    draw = random.Random(3)
    alphabet = [0xFA, 0xFB, 0x03, 0x06, 0x00, 0xFF, 0x1D]
    decoder, size, delivered = p2os.FrameDecoder(), 0, 0
    for _ in range(3000):
        data = bytes(draw.choice(alphabet) for _ in range(draw.randrange(20)))
        frames = decoder.feed(data) + (decoder.drop_partial() if draw.random() < 0.1 else [])
        size += len(data)
        delivered += sum(len(frame.data) + 6 for frame in frames)
        assert decoder.counts.discarded_bytes + delivered + len(decoder._held) == size
    assert delivered and decoder.counts.bad_checksums and decoder.counts.bad_counts


@pytest.mark.parametrize("id", [-1, 256, True, 1.0, None, "1"])
def test_no_such_id(id):
    with pytest.raises(EncodingError, match="0..255"):
        p2os.encode_frame(id)


def test_too_long():
    assert p2os.encode_frame(66, bytes(197))[2] == 200
    with pytest.raises(EncodingError, match="198 bytes.*0..197"):
        p2os.encode_frame(66, bytes(198))
