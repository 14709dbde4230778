"""What holds for all bytes and all values. hypothesis searches for counterexamples."""

import math

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as some

from pioneer_control import lms2xx
from pioneer_control.errors import EncodingError
from pioneer_control.wire_fields import rows

REPLIES = some.builds(lms2xx.Telegram, some.integers(0x80, 0xFF), some.binary(max_size=300), some.integers(0, 0xFF),
                      some.integers(0, 0x7F))
REQUESTS = some.builds(lms2xx.Telegram, some.integers(0, 0x7F), some.binary(max_size=300), some.none(),
                       some.integers(0, 0x7F))
NOISE = some.one_of(some.binary(max_size=40),
                    some.sampled_from([b"\x02", b"\x02\x80", b"\x02\x00\x03\x00\x20", b"\x02\x80\xFF\xFF", b"\x06"]))
TELEGRAMS = some.one_of(REPLIES, REQUESTS)
STREAMS = some.lists(some.one_of(TELEGRAMS.map(lms2xx.encode_telegram), NOISE), max_size=8).map(b"".join)
DIRECTIONS = some.booleans()


def cut(data, at):
    """Return the pieces of data between these places."""
    places = sorted({0, len(data), *(place % (len(data) + 1) for place in at)})
    return [data[begin:end] for begin, end in zip(places, places[1:])]


def all_found(pieces, from_laser):
    """Return what a decoder finds in the pieces, and the decoder."""
    decoder, found = lms2xx.TelegramDecoder(from_laser), []
    for piece in pieces:
        found += decoder.feed(piece)
        assert len(decoder._held) < lms2xx.LONGEST
    return found, decoder


def crc_of_the_sheet(data):
    """The CRC byte by byte, as the laser sheet (1.1) has it."""
    register = previous = 0
    for byte in data:
        register = (register << 1 ^ 0x8005) & 0xFFFF if register & 0x8000 else register << 1
        register ^= previous << 8 | byte
        previous = byte
    return register


@given(some.binary(max_size=lms2xx.LONGEST))
@example(b"")
@example(bytes(range(256)) * 3)
@example(b"\xFF" * lms2xx.LONGEST)
@example(b"\x80" + bytes(lms2xx.LONGEST - 1))
def test_the_table_of_the_crc_is_the_register_of_the_sheet(data):
    assert lms2xx.crc(data) == crc_of_the_sheet(data)


@given(STREAMS, some.lists(some.integers(0), max_size=10), DIRECTIONS)
@example(b"\x02\x80\x03\x00" + lms2xx.encode(lms2xx.Resetting()), [], True)
def test_however_it_is_cut_a_stream_says_the_same(stream, places, from_laser):
    whole, one = all_found([stream], from_laser)
    parts, other = all_found(cut(stream, places), from_laser)
    assert whole == parts and one.counts == other.counts and one._held == other._held


@given(STREAMS, DIRECTIONS)
def test_every_byte_is_part_of_a_telegram_an_answer_or_discarded(stream, from_laser):
    found, decoder = all_found([stream], from_laser)
    found += decoder.drop_partial()
    assert not decoder.waiting
    telegrams = [each for each in found if isinstance(each, lms2xx.Telegram)]
    counts = decoder.counts
    assert (counts.telegrams, counts.answers) == (len(telegrams), len(found) - len(telegrams))
    assert sum(each.length for each in telegrams) + counts.answers + counts.discarded_bytes == len(stream)


@given(STREAMS, TELEGRAMS)
def test_after_a_pause_a_telegram_is_heard_whatever_came_before(stream, sent):
    _, decoder = all_found([stream], sent.status is not None)
    decoder.drop_partial()
    assert decoder.feed(lms2xx.encode_telegram(sent)) == [sent]


@given(TELEGRAMS, some.integers(0), some.integers(0, 7))
def test_one_wrong_bit_is_never_believed(sent, place, bit):
    data = bytearray(lms2xx.encode_telegram(sent))
    data[place % len(data)] ^= 1 << bit
    found, decoder = all_found([bytes(data)], sent.status is not None)
    assert sent not in found + decoder.drop_partial()


@given(some.integers(0, 0xFF), some.binary(max_size=200))
def test_no_data_are_too_strange_to_decode(command, data):
    message = lms2xx.decode(lms2xx.Telegram(command, data))
    if isinstance(message, (lms2xx.UnknownMessage, lms2xx.MalformedMessage)):
        assert (message.command, message.data) == (command, data)
    else:
        assert isinstance(message, lms2xx.MESSAGES[command])


def values_of(row):
    """Return values that fit a field."""
    kind = row.type
    if hasattr(kind, "low"):
        return some.integers(kind.low, kind.high)
    return {
        "Rest": some.binary(max_size=50),
        "TextField": some.text("ABC;.0129 ", max_size=getattr(kind, "size", 0)),
        "Many": some.lists(some.integers(0, 255), min_size=getattr(kind, "count", 0) or 0,
                           max_size=getattr(kind, "count", 0) or 0).map(tuple),
        "ScanField": SCANS,
        "ConfigurationField": some.just(lms2xx.FACTORY),
    }[type(kind).__name__]


SCANS = some.builds(lms2xx.RawScan, some.lists(some.integers(0, 0xFFFF), max_size=401).map(tuple), some.integers(0, 3),
                    some.booleans(), some.integers(0, 3),
                    some.one_of(some.none(), some.builds(lms2xx.Indices, *[some.integers(0, 255)] * 2)))
MESSAGES = some.sampled_from(sorted(lms2xx.MESSAGES.values(), key=lambda message: message.__name__)).flatmap(
    lambda message: some.builds(message, **{row.name: values_of(row) for row in rows(message)}))


@given(MESSAGES, some.integers(0, 255), some.integers(0, 127))
def test_what_is_encoded_is_decoded(message, status, address):
    data = lms2xx.encode(message, status, address)
    [telegram], decoder = all_found([data], data[1] >= 0x80)
    assert lms2xx.decode(telegram) == message and telegram.address == address
    assert decoder.counts == lms2xx.TelegramCounts(telegrams=1)


@pytest.mark.parametrize("message, named", [
    (lms2xx.SetVariant(-1, 100), "angle_deg: -1"),
    (lms2xx.SetVariant(180, 65536), "step_hundredths: 65536"),
    (lms2xx.KeepSpeed(True), "keep: True"),
    (lms2xx.ScanReply(lms2xx.RawScan((70000,))), "value 0: 70000"),
    (lms2xx.ScanReply(lms2xx.RawScan((0,) * 402)), "number of values: 402"),
    (lms2xx.ScanReply(lms2xx.RawScan((1,), unit=4)), "unit: 4"),
    (lms2xx.ScanReply(lms2xx.RawScan((1,), quarter=-1)), "quarter: -1"),
    (lms2xx.ScanReply(lms2xx.RawScan((1,), indices=lms2xx.Indices(256, 0))), "index: 256"),
    (lms2xx.WriteConfiguration(b"\0" * 34), "not a Configuration"),
    ("reset", "no message"),
])
def test_what_does_not_fit_is_refused_by_name(message, named):
    with pytest.raises(EncodingError, match=named):
        lms2xx.encode(message)


@pytest.mark.parametrize("telegram, named", [
    (lms2xx.Telegram(256), "command of a telegram: 256"),
    (lms2xx.Telegram(0x20, address=0x80), "address of a telegram: 128"),
    (lms2xx.Telegram(0xA0, status=256), "status of a telegram: 256"),
    (lms2xx.Telegram(0xA0), "a reply"),
    (lms2xx.Telegram(0x20, status=0x10), "a reply"),
    (lms2xx.Telegram(0x20, b"\0" * 808), "815 bytes"),
    (lms2xx.Telegram(True), "command of a telegram: True"),
])
def test_a_telegram_that_does_not_fit_is_refused(telegram, named):
    with pytest.raises(EncodingError, match=named):
        lms2xx.encode_telegram(telegram)


def test_the_longest_telegram_and_one_byte_more():
    longest = lms2xx.encode_telegram(lms2xx.Telegram(0x77, b"\0" * 807))
    assert len(longest) == lms2xx.LONGEST
    assert all_found([longest], False)[0] == [lms2xx.Telegram(0x77, b"\0" * 807)]
    too_long = b"\x02\x00" + (lms2xx.LONGEST - 5).to_bytes(2, "little")
    assert all_found([too_long], False)[1].counts.discarded_bytes == 4


@pytest.mark.parametrize("mode", sorted(lms2xx.MEASURING_MODES))
@pytest.mark.parametrize("unit", [lms2xx.Unit.CENTIMETRES, lms2xx.Unit.MILLIMETRES])
def test_every_value_is_a_distance_or_a_code(mode, unit):
    mode = lms2xx.MEASURING_MODES[mode]
    steps = range(1 << mode.distance_bits)
    scan = lms2xx.RawScan(tuple(steps), unit)
    ranges = lms2xx.ranges_m(scan, mode)
    farthest = lms2xx.farthest_m(mode, unit)
    if mode.distance_bits == 16:
        assert np.isfinite(ranges).all()
        return
    finite = np.isfinite(ranges)
    assert finite.sum() == len(steps) - 9 and finite[:-9].all(), "the highest nine are codes"
    assert ranges[finite].max() < farthest == pytest.approx((len(steps) - 9) * lms2xx.scans.METRES[unit])
    assert [value for value in ranges[-9:].tolist() if math.isinf(value)] == [math.inf, math.inf]


def test_flags_are_no_distance():
    mode = lms2xx.MEASURING_MODES[0]
    plain = lms2xx.ranges_m(lms2xx.RawScan((1000, 8190)), mode)
    assert lms2xx.ranges_m(lms2xx.RawScan((1000 | 0xE000, 8190 | 0x8000)), mode).tolist()[0] == plain.tolist()[0]
    assert math.isnan(plain[1])


def test_a_configuration_takes_what_it_leaves_out_from_the_one_before():
    short = lms2xx.decode(lms2xx.Telegram(0x77, bytes((0, 0, 70, 0, 0, 1, 1)))).configuration
    assert short.dazzle_evaluations is None
    whole = short.over(lms2xx.FACTORY)
    assert (whole.measuring_mode, whole.unit) == (1, 1)
    assert whole.dazzle_evaluations == 2 and None not in vars(whole).values()


def test_errors_are_pairs():
    assert lms2xx.ErrorsReply(b"\x02\x12\x83\x05\x01").errors == [
        lms2xx.DeviceError(lms2xx.Severity.WARNING, 18, False), lms2xx.DeviceError(lms2xx.Severity.ERROR, 5, True)]


@pytest.mark.parametrize("status, said", [(0x10, lms2xx.Severity.OK), (0x92, lms2xx.Severity.WARNING),
                                          (0x14, lms2xx.Severity.FATAL)])
def test_severity(status, said):
    assert lms2xx.severity(status) == said


def test_speeds_have_their_modes_and_words():
    assert {baud: (speed.mode.value, speed.word) for baud, speed in lms2xx.SPEEDS.items()} == {
        9600: (0x42, 0x8067), 19200: (0x41, 0x8033), 38400: (0x40, 0x8019), 500000: (0x48, 0x8001)}
