"""What holds for all bytes at all times at a simulated laser. hypothesis and chance search for counterexamples."""

import random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as some

from laser_on_bench import LaserBench, acked, laser
from pioneer_control import lms2xx
from pioneer_control.lms2xx import Mode
from pioneer_control.simulator.lms200 import TYPICAL, FirmwareNumbers
from pioneer_control.simulator.lms200.serial_output import SerialOutput

GOOD = [lms2xx.encode(each) for each in (
    lms2xx.ResetLaser(), lms2xx.AskStatus(), lms2xx.AskErrors(), lms2xx.AskType(), lms2xx.AskScan(1),
    lms2xx.AskScan(8), lms2xx.AskValues(1, 9), lms2xx.AskMean(3), lms2xx.SetVariant(100, 25),
    lms2xx.SetVariant(180, 100), lms2xx.SetVariant(180, 0), lms2xx.KeepSpeed(1), lms2xx.AskConfiguration(),
    lms2xx.WriteConfiguration(lms2xx.FACTORY), lms2xx.SetMode(Mode.INSTALLATION, b"SICK_LMS"),
    lms2xx.SetMode(Mode.STREAM_OF_A_PART, b"\x01\0\x09\0"), *(lms2xx.SetMode(mode, b"") for mode in Mode))]
BYTES = some.one_of(some.sampled_from(GOOD), some.binary(max_size=12),
                    some.sampled_from(GOOD).map(lambda data: data[:-1] + b"\0"))
WAITS = some.one_of(some.integers(0, 30000), some.integers(0, 400000))      # microseconds
SCRIPTS = some.lists(some.tuples(BYTES, WAITS), max_size=8)


def played(script, cut):
    """Return the bytes of a laser that gets a script of bytes and pauses. `cut` tells into what a pause is cut."""
    simulated = laser(optics=TYPICAL, seed=5)
    sent = b""
    for data, wait_us in script:
        for piece in cut(data):
            simulated.receive(piece)
        at, end = simulated.clock.now_us, simulated.clock.now_us + wait_us
        for pause in cut(range(at, end)):
            simulated.run_to(pause.stop)
            sent += simulated.take_sent()
        assert simulated.clock.now_us == end
    return sent


def whole(what):
    return [what] if len(what) else []


def cut_by(seed):
    """Return a function that cuts a sequence into pieces by chance."""
    chance = random.Random(seed)

    def cut(what):
        places = sorted({0, len(what), *(chance.randrange(len(what) + 1) for _ in range(chance.randrange(6)))})
        return [what[begin:end] for begin, end in zip(places, places[1:])]
    return cut


@settings(max_examples=100)
@given(SCRIPTS, some.integers(0, 1000))
def test_however_time_and_bytes_are_cut_the_laser_sends_the_same(script, seed):
    assert played(script, whole) == played(script, cut_by(seed))


@settings(max_examples=100)
@given(SCRIPTS)
def test_no_more_bytes_leave_than_the_line_carries(script):
    simulated = laser()
    for data, wait_us in script:
        simulated.receive(data)
        simulated.run_to(simulated.clock.now_us + wait_us)
        needed_us = sum(len(sent.data) * 1e7 / sent.baud for sent in simulated.take_sent_with_speeds())
        assert needed_us <= wait_us + 1e7 / 9600 + 1, "one byte may have begun before"


@settings(max_examples=100)
@given(some.lists(some.sampled_from([each for each in GOOD if each[4] != 0x20]), max_size=6))
def test_without_a_stream_every_byte_is_of_an_answer_or_a_reply(requests):
    bench = LaserBench()
    for data in requests:
        bench.send(data)
    bench.wait(3.0)
    assert bench.decoder.counts.discarded_bytes == 0 and not bench.decoder.waiting
    assert bench.heard.count(lms2xx.Answer.ACK) >= 1 or not requests


@settings(max_examples=100)
@given(some.binary(max_size=300), some.sampled_from([None, 9600, 19200, 38400, 500000]))
def test_after_noise_and_a_pause_a_request_is_answered(noise, baud):
    bench = LaserBench()
    bench.send(noise, baud).wait(3.0)
    bench.take()
    assert bench.ask(lms2xx.AskErrors()) == acked(lms2xx.ErrorsReply(b""))


@pytest.mark.parametrize("seed", range(4))
def test_thousands_of_random_inputs_raise_nothing(seed):
    chance = random.Random(seed)
    simulated = laser(numbers=FirmwareNumbers(boot=0.01, missed=0.1), seed=seed)
    total = 0
    for _ in range(1500):
        data = bytearray(chance.choice(GOOD) if chance.random() < 0.7 else
                         bytes(chance.randrange(256) for _ in range(chance.randrange(20))))
        if data and chance.random() < 0.2:
            data[chance.randrange(len(data))] = chance.randrange(256)
        if chance.random() < 0.1:       # a true CRC and nonsense
            body = bytes((chance.choice((0x20, 0x30, 0x37, 0x3B, 0x66, 0x77, chance.randrange(128))),))
            body += bytes(chance.randrange(256) for _ in range(chance.randrange(40)))
            data = b"\x02\0" + len(body).to_bytes(2, "little") + body
            data += lms2xx.crc(data).to_bytes(2, "little")
        simulated.receive(bytes(data), chance.choice((None, None, None, 9600, 38400)))
        total += len(simulated.advance(chance.choice((0.0, 0.001, 0.01, 0.02, 0.1))))
        if chance.random() < 0.01:
            simulated.power_off()
            simulated.advance(chance.choice((0.0, 1.0)))
            simulated.power_on()
    assert total > 10000
    simulated.power_off()
    simulated.device.eeprom.keeps_speed = False
    simulated.power_on()
    simulated.advance(1.0)
    simulated.receive(lms2xx.encode(lms2xx.AskErrors()))
    assert simulated.advance(1.0) == b"\x06" + lms2xx.encode(lms2xx.ErrorsReply(b""))


def test_the_same_seed_the_same_bytes():
    def sent(seed):
        simulated = laser(optics=TYPICAL, seed=seed)
        simulated.advance(0.1)
        simulated.receive(lms2xx.encode(lms2xx.SetMode(Mode.STREAM, b"")))
        return simulated.advance(3.0)
    assert sent(1) == sent(1) != sent(2)


# -- the line itself

def test_bytes_leave_one_by_one():
    output = SerialOutput()
    output.put(b"abc", 9600, 0)
    assert output.free_at_us(0) == 3125
    assert output.take(1041) == []
    assert output.take(1042)[0].data == b"a"
    assert output.take(3124)[0].data == b"b"
    assert output.take(3125)[0].data == b"c"
    assert output.take(9999) == [] and output.free_at_us(9999) == 9999


def test_a_cut_lets_the_present_byte_leave():
    for at, left in ((0, b""), (1, b"a"), (1041, b"a"), (1043, b"ab"), (9999, b"abc")):
        output = SerialOutput()
        output.put(b"abc", 9600, 0)
        output.put(b"later", 9600, 0)
        output.cut(at)
        taken = b"".join(each.data for each in output.take(20000))
        assert taken == (left if at < 3125 else b"abclater"), at
