"""The bytes that come through a serial line whose ends have different speeds."""

import itertools
import random

import pytest

from pioneer_control import p2os
from pioneer_control.simulator.line.uart import as_heard

PAIRS = list(itertools.permutations(p2os.BAUD_RATES, 2))
SIP = bytes.fromhex("FAFB2833D204C8FF0002BE00D20080000200020700000203DC05049808210500F00080000020000000260D")


@pytest.mark.parametrize("baud", p2os.BAUD_RATES)
def test_at_the_same_speed_all_is_heard_as_sent(baud):
    assert as_heard(bytes(range(256)), baud, baud) == bytes(range(256))


@pytest.mark.parametrize("sent, factor, heard", [
    # Nine low bits look like a start and eight zeros. The end of the byte then looks like one more byte.
    ("00", 2, "00 80"),
    ("FF", 0.5, "FF"),          # only the start bit is low, and too short to be sampled
    ("55", 2, "66 99"),         # every bit twice, from the start bit on
    ("", 2, ""),
])
def test_by_hand(sent, factor, heard):
    assert as_heard(bytes.fromhex(sent), 9600, round(9600 * factor)) == bytes.fromhex(heard)


@pytest.mark.parametrize("sent, heard", PAIRS)
def test_a_nearly_right_speed_is_none_of_the_five_and_no_packet_comes_through(sent, heard):
    decoder = p2os.FrameDecoder()
    assert as_heard(SIP, sent, heard) not in (b"", SIP)
    assert [decoder.feed(as_heard(SIP, sent, heard)) for _ in range(20)] == [[]] * 20
    assert as_heard(SIP, sent, round(sent * 1.02)) == SIP, "two per cent off is what a UART bears"


@pytest.mark.parametrize("sent, heard", PAIRS)
def test_whatever_is_sent_there_is_an_end(sent, heard):
    chance = random.Random(sent + heard)
    for length in range(40):
        data = bytes(chance.randrange(256) for _ in range(length))
        assert len(as_heard(data, sent, heard)) <= 12 * length
