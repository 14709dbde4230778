"""The camera's protocol under any values, any bytes, any pieces and any noise."""

import random

from hypothesis import given
from hypothesis import strategies as st

from pioneer_control import vcc4

NAMES = sorted(vcc4.CAMERA_COMMANDS)


@st.composite
def orders(draw):
    row = vcc4.CAMERA_COMMANDS[draw(st.sampled_from(NAMES))]
    return row, tuple(draw(st.integers(value.low, value.high)) for value in row.values), draw(st.integers(0, 15))


def pieces_of(data, cuts):
    places = sorted({0, len(data), *(cut % (len(data) + 1) for cut in cuts)})
    return [data[begin:end] for begin, end in zip(places, places[1:])]


@given(orders())
def test_each_command_comes_back_as_it_was(order):
    row, values, camera = order
    frame = vcc4.encode_camera_command(row.name, *values, camera=camera)
    assert len(frame) <= vcc4.LONGEST_FRAME
    assert vcc4.decode_camera_command(frame) == vcc4.CameraOrder(camera, row.number, row, values)


@given(st.binary(max_size=60), orders(), st.lists(st.integers(0, 200)))
def test_any_noise_in_any_pieces_hides_no_command(noise, order, cuts):
    row, values, camera = order
    frame = vcc4.encode_camera_command(row.name, *values, camera=camera)
    decoder, found = vcc4.CameraDecoder(vcc4.COMMAND_BEGIN), []
    for piece in pieces_of(noise + frame, cuts):
        found += decoder.feed(piece)
    assert found[-1] == frame
    counts = decoder.counts
    assert counts.frames == len(found)
    assert counts.discarded_bytes == len(noise + frame) - sum(map(len, found))


@given(st.binary(max_size=60), st.integers(-1511, 1511), st.integers(-800, 800), st.lists(st.integers(0, 200)))
def test_any_noise_in_any_pieces_hides_no_answer(noise, pan, tilt, cuts):
    frame = vcc4.encode_answer("ASK_POSITION", pan, tilt)
    decoder, found = vcc4.CameraDecoder(vcc4.ANSWER_BEGIN), []
    for piece in pieces_of(noise + frame, cuts):
        found += decoder.feed(piece)
    assert found[-1] == frame
    assert vcc4.answer_values("ASK_POSITION", vcc4.decode_answer(frame)) == (pan, tilt)


def test_a_share_of_the_fuzz_of_both_decoders():
    """bench/fuzz_camera.py does the same a million times."""
    rng = random.Random(1)
    for _ in range(3000):
        data = bytes(rng.choice((0xFF, 0xFE, 0xEF, 0x30, 0x00, rng.randrange(256))) for _ in range(rng.randrange(40)))
        for begin in (vcc4.COMMAND_BEGIN, vcc4.ANSWER_BEGIN):
            decoder = vcc4.CameraDecoder(begin)
            for frame in decoder.feed(data):
                assert len(frame) <= vcc4.LONGEST_FRAME
                vcc4.decode_camera_command(frame)
                answer = vcc4.decode_answer(frame)
                for name in NAMES if answer is not None else ():
                    vcc4.answer_values(name, answer)
            assert len(decoder.held) < vcc4.LONGEST_FRAME


def test_a_frame_that_does_not_end_is_noise():
    decoder = vcc4.CameraDecoder(vcc4.COMMAND_BEGIN)
    assert decoder.feed(b"\xff" + b"0" * 18) == [] and len(decoder.held) == 19
    assert decoder.feed(b"0") == [] and decoder.held == b"" and decoder.counts.discarded_bytes == 20
    decoder.feed(b"\xff00")
    decoder.drop_partial()
    assert decoder.held == b"" and decoder.counts == (0, 23)
