"""How a simulated laser streams: how often, what is in a scan, from which time, and what interrupts it."""

import itertools
import math

import numpy as np
import pytest

from laser_on_bench import READY, ROOM, LaserBench, acked, laser, to_wall, wire
from pioneer_control import lms2xx
from pioneer_control.lms2xx import SPEEDS, TURN_S, VARIANTS, Answer, Mode, PartReply, ScanReply, Variant
from pioneer_control.simulator.lms200 import FirmwareNumbers, moving
from pioneer_control.simulator.lms200.device import Operation

STREAM, STOP = lms2xx.SetMode(Mode.STREAM, b""), lms2xx.SetMode(Mode.ON_REQUEST, b"")
MODES = lms2xx.MEASURING_MODES


def bench_at(baud, variant=Variant(180, 100), **options):
    """Return a bench with this speed and variant."""
    bench = LaserBench(**options)
    if baud != 9600:
        bench.speed(baud)
    return bench.variant(*variant)


def arrivals(bench, seconds, step=0.001):
    """Return when each telegram was complete (s), to a millisecond, and the telegrams."""
    found = []
    for number in range(round(seconds / step)):
        bench.wait(step)
        found += [((number + 1) * step, message) for message in bench.take()]
    return found


# -- how often

@pytest.mark.parametrize("baud, variant", itertools.product(SPEEDS, VARIANTS))
def test_scans_per_second_at_every_speed_and_variant(baud, variant):
    bench = bench_at(baud, variant).mode(Mode.STREAM)
    between = lms2xx.scan_time(variant, baud)
    bench.wait(2 * between).take()
    count = 12
    bench.wait(count * between)
    scans = [each for each in bench.take() if isinstance(each, ScanReply)]
    assert len(scans) == count, "%.2f scans a second are %.2f" % (len(scans) / (count * between), 1 / between)
    assert {len(each.scan.values) for each in scans} == {variant.values}


@pytest.mark.parametrize("baud, angle, step, rate", [       # sheet 1.8; a laser streamed 4.7 at 38400 and half a degree
    (500000, 180, 100, 75.0), (500000, 180, 50, 37.5), (500000, 100, 25, 18.75), (38400, 180, 50, 4.7),
    (38400, 180, 100, 10.3), (19200, 180, 100, 5.2), (9600, 180, 100, 2.6), (9600, 180, 50, 1.3)])
def test_scans_per_second_of_the_sheet(baud, angle, step, rate):
    bench = bench_at(baud, Variant(angle, step)).mode(Mode.STREAM)
    times = [when for when, message in arrivals(bench, 5.0 if baud < 100000 else 1.0)]
    found = (len(times) - 1) / (times[-1] - times[0])
    assert found == pytest.approx(rate, rel=0.1) and found <= rate * 1.01


def test_turns_in_whole_microseconds():
    operation = Operation(ready_us=17)
    assert operation.turn_end_us(75 * 1000) == 17 + 1000 * 1000000
    for number in range(1, 50):
        end = operation.turn_end_us(number)
        assert end == pytest.approx(17 + number * TURN_S * 1e6, abs=1.0)
        assert (operation.turns_ended(end - 1), operation.turns_ended(end)) == (number - 1, number)


def test_without_a_line_each_scan_comes():
    for variant, rate in ((Variant(180, 100), 75), (Variant(180, 50), 37.5), (Variant(100, 25), 18.75)):
        bench = bench_at(9600, variant, line_takes_time=False).mode(Mode.STREAM).wait(0.1)
        bench.take()
        assert len(bench.wait(4.0).take()) == 4 * rate


@pytest.mark.parametrize("baud", SPEEDS)
def test_no_more_bytes_leave_than_the_line_carries(baud):
    simulated = bench_at(baud).mode(Mode.STREAM).laser
    for milliseconds in (1, 3, 10, 1, 50, 200, 7):
        sent = simulated.advance(milliseconds * 1e-3)
        assert len(sent) <= milliseconds * 1e-3 * baud / 10 + 1


@pytest.mark.parametrize("baud", SPEEDS)
def test_a_reply_takes_its_time_on_the_line(baud):
    bench = bench_at(baud)
    bench.send(lms2xx.AskStatus())
    begin, end = READY.other, READY.other + lms2xx.time_on_line(160, baud)
    bench.wait(end - 3e-6)
    assert len(bench.raw) == 1 + 159 or begin < lms2xx.time_on_line(1, baud)
    assert len(bench.wait(6e-6 + lms2xx.time_on_line(1, baud)).raw) == 161


# -- what

def test_a_streamed_scan_is_the_room():
    bench = bench_at(38400, Variant(180, 50)).mode(Mode.STREAM)
    bench.take()
    reply = bench.wait(0.5).take()[0]
    assert (reply.scan.unit, reply.scan.partial, reply.scan.indices) == (1, False, None)
    found = lms2xx.ranges_m(reply.scan, MODES[0])
    wanted = [to_wall(math.radians(index / 2 - 90.0)) for index in range(361)]
    assert np.abs(found - wanted).max() <= 0.0006, "rounded to a millimetre"


@pytest.mark.parametrize("unit, step, farthest", [(0, 0.01, 81.83), (1, 0.001, 8.183)])
def test_units(unit, step, farthest):
    bench = LaserBench().configure(unit=unit)
    scan = bench.scan()
    assert scan.unit == unit
    assert scan.values[180] == round(4.0 / step)
    assert lms2xx.farthest_m(MODES[0], unit) == pytest.approx(farthest)


@pytest.mark.parametrize("mode, bits", [(0, 13), (1, 13), (2, 13), (3, 14), (4, 14), (5, 15), (6, 15)])
def test_no_echo_and_too_far_are_codes(mode, bits):
    far = ROOM.changed(walls=[(40.0, -9.0, 40.0, 9.0)])
    bench = LaserBench(world=far).configure(measuring_mode=mode)
    scan = bench.scan()
    assert scan.values[0] == (1 << bits) - 1, "nothing there"
    assert scan.values[180] == (1 << bits) - 9, "40 m are too far"
    assert math.isinf(lms2xx.ranges_m(scan, MODES[mode])[180])


def test_a_mode_that_has_no_codes():
    scan = LaserBench(world=ROOM.changed(walls=[(40.0, -9.0, 40.0, 9.0)])).configure(measuring_mode=0x0F).scan()
    assert (scan.values[0], scan.values[180]) == (0xFFFF, 40000)


def test_just_below_full_scale_is_a_distance():
    for distance, value in ((8.182, 8182), (8.1824, 8182), (8.1826, 8183), (8.2, 8183)):
        world = ROOM.changed(walls=[(distance, -9.0, distance, 9.0)])
        assert LaserBench(world=world).scan().values[180] == value


def test_indices():
    bench = bench_at(500000).configure(availability=lms2xx.Availability.INDICES).mode(Mode.STREAM)
    scans = [each.scan.indices for each in bench.wait(0.5).take()]
    assert len(scans) > 30
    for before, after in zip(scans, scans[1:]):
        assert ((after.turn - before.turn) % 256, (after.telegram - before.telegram) % 256) == (1, 1)


def test_indices_tell_of_lost_scans():
    bench = bench_at(38400).configure(availability=lms2xx.Availability.INDICES).mode(Mode.STREAM)
    scans = [each.scan.indices for each in bench.wait(2.0).take() if isinstance(each, ScanReply)]
    lost = round(lms2xx.scan_time(Variant(180, 100), 38400, True) / TURN_S)
    assert lost == 8
    for before, after in zip(scans, scans[1:]):
        assert ((after.turn - before.turn) % 256, (after.telegram - before.telegram) % 256) == (8, 1)


def test_partial_scans_in_turn():
    bench = bench_at(500000, Variant(180, 50)).mode(Mode.STREAM_OF_PARTIAL_SCANS).wait(0.1)
    bench.take()
    scans = [each.scan for each in bench.wait(1.0).take()]
    assert len(scans) == 75
    assert all(each.partial for each in scans)
    assert {(each.quarter, len(each.values)) for each in scans} == {(0, 181), (2, 180)}
    assert all(first.quarter != second.quarter for first, second in zip(scans, scans[1:]))
    for scan in scans[:2]:
        wanted = [to_wall(math.radians(degree - 90.0 + scan.quarter / 4)) for degree in range(len(scan.values))]
        assert np.abs(lms2xx.ranges_m(scan, MODES[0]) - wanted).max() <= 0.0006


def test_partial_scans_of_a_quarter_of_a_degree_cover_180_degrees():
    bench = bench_at(500000, Variant(100, 25)).mode(Mode.STREAM_OF_PARTIAL_SCANS)
    scans = [each.scan for each in bench.wait(0.3).take() if isinstance(each, ScanReply)]
    assert {(each.quarter, len(each.values)) for each in scans} == {(0, 181), (1, 180), (2, 180), (3, 180)}


def test_a_part_of_the_values():
    bench = bench_at(38400, Variant(180, 50))
    whole = bench.scan()
    bench.mode(Mode.STREAM_OF_A_PART, wire("1B 00 2B 01"))
    parts = [each for each in bench.wait(1.0).take() if isinstance(each, PartReply)]
    assert parts and parts[0] == PartReply(27, 299, lms2xx.RawScan(whole.values[26:299]))
    bench.take()
    assert bench.send(STOP).wait(0.1).raw.endswith(wire("06 02 80 03 00 A0 00 10 16 0A"))


def test_a_part_that_a_new_variant_does_not_have_ends():
    bench = bench_at(38400, Variant(180, 50)).mode(Mode.STREAM_OF_A_PART, wire("1B 00 2B 01"))
    bench.send(lms2xx.SetVariant(180, 100)).wait(1.0)
    bench.decoder.drop_partial()
    bench.take()
    assert bench.wait(1.0).take() == []
    assert bench.ask(lms2xx.AskStatus())[1].mode == Mode.ON_REQUEST


def test_a_part_that_a_new_variant_has_stays():
    bench = bench_at(38400, Variant(180, 50)).mode(Mode.STREAM_OF_A_PART, wire("1B 00 B5 00"))      # 27..181
    bench.send(lms2xx.SetVariant(180, 100)).wait(0.5)
    bench.decoder.drop_partial()
    bench.take()
    [part, *_] = [each for each in bench.wait(0.5).take() if isinstance(each, PartReply)]
    assert (part.first, part.last, part.scan.values[-1]) == (27, 181, 5000)


@pytest.mark.parametrize("mode", [Mode.ON_REQUEST, Mode.INSTALLATION, Mode.DIAGNOSIS])
def test_in_other_modes_nothing_comes_by_itself(mode):
    bench = bench_at(38400).mode(mode, b"SICK_LMS" if mode == Mode.INSTALLATION else b"")
    bench.take()
    assert bench.wait(3.0).take() == []


# -- when

@pytest.mark.parametrize("baud, variant", itertools.product((38400, 500000), (Variant(180, 100), Variant(180, 50))))
def test_a_scan_was_measured_when_the_driver_thinks(baud, variant):
    """A laser drives towards a wall: the ray straight ahead tells the time at which it was fired."""
    wall = ROOM.changed(walls=[(8.0, -99.0, 8.0, 99.0)])
    bench = LaserBench(world=wall, pose_at=moving((0.0, 0.0, 0.0), 1.0, 0.0))
    if baud != 9600:
        bench.speed(baud)
    bench.variant(*variant).mode(Mode.STREAM)
    bench.take()
    bench.raw = b""
    while not bench.raw:
        bench.wait(lms2xx.time_on_line(1, baud))
    first_byte = bench.laser.clock.seconds - lms2xx.time_on_line(1, baud)     # its begin, to one byte
    scan = bench.wait(lms2xx.time_on_line(732, baud)).take()[0].scan
    middle = len(scan.values) // 2
    fired = 8.0 - lms2xx.ranges_m(scan, MODES[0])[middle]
    after_first = 90 * TURN_S / 360
    wanted = first_byte - lms2xx.first_ray_before_first_byte(variant) + after_first
    assert fired == pytest.approx(wanted, abs=0.0006 + lms2xx.time_on_line(1, baud))


def test_a_turning_laser_skews_its_scan_on_the_line():
    rate = math.radians(100.0)
    bench = LaserBench(pose_at=moving((0.0, 0.0, 0.0), 0.0, rate)).speed(500000).variant(180, 100).mode(Mode.STREAM)
    bench.take()
    begin = bench.laser.clock.now_us
    while not bench.heard:
        bench.wait(0.0001)
    scan = bench.heard[0].scan
    turn = bench.laser.device.operation.turns_ended(bench.laser.clock.now_us)
    began = bench.laser.device.operation.turn_end_us(turn - 1) * 1e-6
    assert began * 1e6 > begin - 20000
    wanted = [to_wall(math.radians(degree - 90.0) + rate * (began + degree * TURN_S / 360)) for degree in range(181)]
    assert np.abs(lms2xx.ranges_m(scan, MODES[0]) - wanted).max() < 0.001


def test_a_streamed_scan_is_of_after_the_request():
    simulated = laser(pose_at=moving((0.0, 0.0, 0.0), 0.0, 0.0))
    simulated.advance(0.5)
    simulated.receive(lms2xx.encode(lms2xx.SetVariant(100, 25)))
    simulated.advance(0.2)
    simulated.receive(lms2xx.encode(STREAM))
    since = READY.mode_change
    assert len(simulated.advance(since + 0.0095)) == 1 + 9
    assert simulated.advance(4 * TURN_S - 0.01) == b"", "four turns must begin after the request"
    assert simulated.advance(5 * TURN_S) != b""


# -- what interrupts it

def in_the_midst():
    """Return a bench that streams at 38400 baud, with a scan that is half on its way."""
    bench = bench_at(38400, Variant(180, 50)).mode(Mode.STREAM)
    bench.take()
    bench.wait(0.6)
    bench.take()
    while not 300 < len(bench.raw) < 400:
        bench.raw = b""
        bench.wait(0.0955)
    bench.take()
    return bench


def test_a_request_cuts_the_scan_and_is_answered():
    bench = in_the_midst()
    bench.send(STOP).wait(0.2)
    assert len(bench.raw) == 1 + 1 + 9, "the byte that was just leaving, ACK, A0"
    assert bench.raw[1:] == wire("06 02 80 03 00 A0 00 10 16 0A")
    assert lms2xx.Telegram(0xA0, b"\0", 0x10) in bench.decoder.drop_partial(), "a decoder finds it in the rest"
    bench.take()
    assert bench.wait(2.0).raw == b""


def test_after_another_request_it_streams_on():
    bench = in_the_midst()
    bench.send(lms2xx.AskErrors()).wait(1.0)
    assert bench.raw[1:10] == wire("06 02 80 02 00 B2 10 3F 13")
    decoder = lms2xx.TelegramDecoder(from_laser=True)
    scans = decoder.feed(bench.raw[10:])
    assert len(scans) == 4 and {each.command for each in scans} == {0xB0} and decoder.counts.discarded_bytes == 0


def test_a_wrong_crc_interrupts_too():
    bench = in_the_midst()
    bench.send(wire("02 00 02 00 20 25 35 09")).wait(0.02)
    assert bench.raw[1:2] == b"\x15"


def test_it_may_miss_a_request_while_it_streams():
    deaf = FirmwareNumbers(boot=0.0, missed=1.0)
    bench = bench_at(38400, numbers=deaf).mode(Mode.STREAM)
    bench.send(STOP).wait(1.0)
    assert bench.laser.missed_requests == 1
    assert len([each for each in bench.take() if isinstance(each, ScanReply)]) >= 8
    assert bench.decoder.counts.discarded_bytes == 0
    bench.laser.power_off()
    bench.laser.power_on()
    bench.wait(0.1)
    bench.decoder.drop_partial()
    assert bench.ask(lms2xx.AskErrors()) == acked(lms2xx.ErrorsReply(b"")), "only while it streams"


def test_three_tries_are_mostly_enough():
    tries = []
    for seed in range(40):
        bench = bench_at(38400, numbers=FirmwareNumbers(boot=0.0, missed=0.3), seed=seed)
        bench.send(STREAM).wait(0.2)
        for count in range(1, 20):
            bench.send(STOP).wait(0.2)
            if bench.laser.device.operation.mode == Mode.ON_REQUEST:
                break
        tries.append(count)
    assert max(tries) > 1 and sum(count <= 3 for count in tries) >= 36


# -- speeds

def test_the_reply_to_a_new_speed_has_the_old_one():
    simulated = laser()
    simulated.advance(0.5)
    simulated.receive(lms2xx.encode(lms2xx.SetMode(Mode.BAUD_500000, b"")), 9600)
    simulated.advance(READY.mode_change + 0.0087)
    assert simulated.baud == 9600, "the last byte is still on its way"
    simulated.advance(0.001)
    assert simulated.baud == 500000
    simulated.receive(lms2xx.encode(lms2xx.AskErrors()), 500000)
    simulated.run_to(simulated.clock.now_us + 10000)
    assert {sent.baud for sent in simulated.take_sent_with_speeds()} == {500000}


def test_the_speed_of_each_byte_is_told():
    simulated = laser()
    simulated.advance(0.5)
    simulated.receive(lms2xx.encode(lms2xx.SetMode(Mode.BAUD_38400, b"")) + lms2xx.encode(lms2xx.AskErrors()))
    simulated.run_to(simulated.clock.now_us + 200000)
    runs = simulated.take_sent_with_speeds()
    assert [(baud, b"".join(run.data for run in same)) for baud, same in itertools.groupby(runs, lambda run: run.baud)
            ] == [(9600, wire("06 02 80 03 00 A0 00 10 16 0A")), (38400, wire("06 02 80 02 00 B2 10 3F 13"))]


@pytest.mark.parametrize("own, sent", itertools.permutations(SPEEDS, 2))
def test_at_a_wrong_speed_it_understands_nothing(own, sent):
    bench = bench_at(own)
    bench.take()
    bench.send(STOP, sent).wait(1.0)
    assert bench.raw == b"" and bench.laser.ignored_bytes == 8
    bench.send(STOP, own).wait(1.0)
    assert bench.take() == [Answer.ACK, lms2xx.ModeSet(0)]


def test_noise_of_a_wrong_speed_spoils_a_request():
    bench = LaserBench()
    data = lms2xx.encode(STOP)
    bench.send(data[:4], 9600).send(b"\x02", 38400).send(data[4:], 9600).wait(1.0)
    assert bench.raw == b""
