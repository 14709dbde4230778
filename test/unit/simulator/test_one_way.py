"""One direction of a line: how long bytes take, and how faults change them."""

import random

import pytest

from pioneer_control import p2os
from pioneer_control.simulator.clock import NEVER_US
from pioneer_control.simulator.line.one_way import FIFO, SPLIT_PAUSE_US, Ruler, OneWay

PULSE = bytes.fromhex("FAFB03000000")
SIP = bytes.fromhex("FAFB2833D204C8FF0002BE00D20080000200020700000203DC05049808210500F00080000020000000260D")


def wire(seed="0", **faults):
    result = OneWay(seed)
    for name, value in faults.items():
        result.errors = result.errors._replace(**{name: value})
    return result


def through(line, packets, gap_us=100000):
    """Return what comes out of a wire when packets are sent one after the other."""
    for number, packet in enumerate(packets):
        line.send(packet, number * gap_us)
    return line.arrived(10 ** 12)


def all_bytes(pieces):
    return b"".join(piece.data for piece in pieces)


def test_over_tcp_bytes_take_no_time():
    line = wire()
    line.send(SIP, 5)
    assert line.next_us == 5 and line.arrived(5) == [(5, None, SIP)]
    assert line.next_us == NEVER_US and line.arrived(10 ** 9) == [] and line.backlog_us(5) == 0


@pytest.mark.parametrize("baud, sip_us", [(9600, 44791), (115200, 3730)])
def test_a_byte_takes_ten_bits_of_a_serial_line(baud, sip_us):
    line = wire()
    line.send(SIP, 1000, baud)
    pieces = line.arrived(10 ** 9)
    assert all_bytes(pieces) == SIP and [len(piece.data) for piece in pieces] == [FIFO, FIFO, len(SIP) - 2 * FIFO]
    assert pieces[-1].due_us == pytest.approx(1000 + sip_us, abs=3)
    assert pieces[0].due_us == pytest.approx(1000 + FIFO * 1e7 / baud, abs=2)


def test_bytes_wait_for_those_ahead_of_them():
    line = wire()
    line.send(PULSE, 0, 9600)
    line.send(PULSE, 100, 9600)
    assert line.backlog_us(100) == 2 * 6250 - 100
    assert [piece.due_us for piece in line.arrived(20000)] == [6250, 12500]
    line.send(PULSE, 50000, 9600)
    assert line.next_us == 56250


def test_nothing_comes_out_early():
    line = wire()
    line.send(PULSE, 0, 9600)
    assert line.arrived(6249) == [] and len(line.arrived(6250)) == 1


@pytest.mark.parametrize("share", [0.1, 0.5])
def test_loss_takes_whole_packets_a_share_of_them(share):
    out = all_bytes(through(wire(loss=share), [PULSE] * 2000))
    assert out == PULSE * (len(out) // 6) and len(out) / 6 == pytest.approx(2000 * (1 - share), rel=0.1)


def test_all_and_nothing():
    assert all_bytes(through(wire(loss=1.0), [SIP] * 10)) == b""
    assert all_bytes(through(wire(loss=0.0, flips=0.0, splits=0.0), [SIP] * 10)) == SIP * 10


def test_flips_change_one_bit_of_a_share_of_the_bytes():
    out = all_bytes(through(wire(flips=0.01), [SIP] * 500))
    changed = [bin(sent ^ heard).count("1") for sent, heard in zip(SIP * 500, out) if sent != heard]
    assert len(out) == 500 * len(SIP) and set(changed) == {1} and len(changed) == pytest.approx(5 * len(SIP), rel=0.25)
    assert all_bytes(through(wire(flips=1.0), [PULSE])) != PULSE


def test_splits_cut_a_packet_in_two_with_a_pause_between():
    pieces = [piece for piece in through(wire(splits=1.0), [SIP] * 50, 10 ** 6) if piece.data]
    assert len(pieces) == 100 and all_bytes(pieces) == SIP * 50
    assert {second.due_us - first.due_us for first, second in zip(pieces[::2], pieces[1::2])} == {SPLIT_PAUSE_US}
    assert len({len(piece.data) for piece in pieces}) > 10
    assert SPLIT_PAUSE_US < p2os.PARTIAL_TIMEOUT * 1e6


def test_delay_holds_back_and_keeps_the_order():
    line = wire(delay=0.5)
    line.send(PULSE, 0)
    line.errors = line.errors._replace(delay=0.0)
    line.send(SIP, 10)
    assert line.arrived(499999) == [] and all_bytes(line.arrived(500000)) == PULSE + SIP


def test_silence():
    line = wire(silence=True)
    line.send(PULSE, 0)
    assert line.arrived(10) == []
    line.errors = line.errors._replace(silence=False)
    line.send(SIP, 20)
    assert all_bytes(line.arrived(20)) == SIP


def test_clear():
    line = wire()
    line.send(SIP, 0, 9600)
    line.clear()
    assert line.next_us == NEVER_US and line.backlog_us(0) == 0


def test_the_same_bytes_meet_the_same_luck_in_whatever_pieces():
    chance = random.Random(4)
    stream = b"".join([SIP, PULSE, b"\xFA", SIP, b"noise", PULSE] * 50)
    outs = set()
    for _ in range(5):
        line, at = wire("7", loss=0.3, flips=0.01, splits=0.2), 0
        while at < len(stream):
            size = chance.randrange(1, 100)
            line.send(stream[at:at + size], 0)
            at += size
        outs.add(all_bytes(line.arrived(10 ** 12)))
    assert len(outs) == 1
    assert all_bytes(through(wire("8", loss=0.3, flips=0.01, splits=0.2), [stream])) not in outs


@pytest.mark.parametrize("stream, begins", [
    (PULSE + PULSE, [0, 6]), (b"ab" + PULSE, [0, 1, 2]), (b"\xFA" + PULSE, [0, 1]), (b"\xFA\x01" + PULSE, [0, 2]),
    (b"\xFA\xFB\x02" + PULSE, [0, 3]), (SIP + PULSE, [0, 43]),
])
def test_where_packets_begin(stream, begins):
    ruler = Ruler()
    assert [at for at, byte in enumerate(stream) if ruler.begins(byte)] == begins
    for size in (1, 3, 6, 43, 100):
        one, other = Ruler(), Ruler()
        for at in range(0, len(stream), size):
            one.skip(stream[at:at + size])
            for byte in stream[at:at + size]:
                other.begins(byte)
            assert vars(one) == vars(other)
