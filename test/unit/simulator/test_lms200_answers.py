"""What a simulated laser answers to each request, byte by byte as the laser sheet prints it, and what it refuses."""

import dataclasses
import pathlib

import pytest
import yaml

from laser_on_bench import READY, LaserBench, acked, wire
from pioneer_control import lms2xx
from pioneer_control.lms2xx import Answer, Mode
from pioneer_control.simulator.lms200 import FirmwareNumbers

DATA = yaml.safe_load((pathlib.Path(__file__).parents[2] / "data" / "lms2xx-golden.yaml").read_text())
REQUESTS = [each for each in DATA["examples"] if not wire(each["bytes"])[1] & 0x80]

A0_OK, A0_WRONG, NOT_POSSIBLE = ("02 80 03 00 A0 00 10 16 0A", "02 80 03 00 A0 01 10 14 0B", "02 80 02 00 92 10 7F 33")
F4 = ("02 80 24 00 F4 00 00 46 00 00 00 01 00 00 02 02 02 00 00 0A 0A 50 64 00 0A 0A 50 64 00 0A 0A 50 64"
      " 00 00 00 00 02 00 10 0A 2F")
POWER_ON = "02 80 17 00 90 4C 4D 53 32 30 30 3B 33 30 31 30 36 33 3B 56 30 32 2E 31 30 20 10 63 5E"
B1 = ("02 80 9A 00 B1 56 30 32 2E 31 30 20 25 00x58 94 00x39 B4 00 32 00 02 00 00 00 00 67 80 02 00 00 00 01 01"
      " 56 30 32 2E 31 30 20 00x22 10 5A 5D")

# A request of the sheet, and the reply that the sheet prints for it.
PRINTED = {
    "02 00 01 00 10 34 12": "02 80 02 00 91 10 79 30 " + POWER_ON,
    "02 00 0A 00 20 00 53 49 43 4B 5F 4C 4D 53 BE C5": A0_OK,
    "02 00 0A 00 20 30 53 49 43 4B 5F 4C 4D 53 EE F5": A0_OK,
    "02 00 02 00 20 25 35 08": A0_OK,
    "02 00 02 00 20 42 52 08": A0_OK,
    "02 00 02 00 20 41 51 08": A0_OK,
    "02 00 02 00 20 40 50 08": A0_OK,
    "02 00 02 00 20 48 58 08": A0_OK,
    "02 00 01 00 31 15 12": B1,
    "02 00 01 00 32 16 12": "02 80 02 00 B2 10 3F 13",
    "02 00 01 00 3A 1E 12":
        "02 80 17 00 BA 4C 4D 53 32 30 30 3B 33 30 31 30 36 33 3B 56 30 32 2E 31 30 20 10 22 61",
    "02 00 05 00 3B B4 00 64 00 97 49": "02 80 07 00 BB 01 B4 00 64 00 10 5B 30",
    "02 00 05 00 3B B4 00 32 00 3B 1F": "02 80 07 00 BB 01 B4 00 32 00 10 03 9D",
    "02 00 05 00 3B 64 00 19 00 E7 72": "02 80 07 00 BB 01 64 00 19 00 10 BB 46",
    "02 00 05 00 3B B4 00 00 00 5F 2D": "02 80 07 00 BB 01 B4 00 32 00 10 03 9D",
    "02 00 02 00 66 01 9D 4E": "02 80 04 00 E6 01 01 10 CF FD",
    "02 00 01 00 74 50 12": F4,
    # outside the installation mode
    "02 00 08 00 77 00 00 46 00 00 01 01 A2 4E": NOT_POSSIBLE,
    "02 00 21 00 77 00 00 46 00 00 05 01 00 00 02 02 00x21 5B 51": NOT_POSSIBLE,
}
# What the sheet does not print: the begin of the reply
BEGINS = {
    "02 00 02 00 20 24 34 08": A0_OK,
    "02 00 02 00 20 2A 3A 08": A0_OK,
    "02 00 06 00 20 27 1B 00 2B 01 FF FE": A0_OK,
    "02 00 02 00 30 01 31 18": "02 80 D6 02 B0 69 41",
    "02 00 02 00 30 08 38 18": "02 80 6E 01 B0 B5 60",      # the eighth turn: whole degrees
    "02 00 05 00 3B 64 00 64 00 1D 0F": "02 80 07 00 BB 01 64 00 64 00 10",
    "02 00 05 00 3B 64 00 32 00 B1 59": "02 80 07 00 BB 01 64 00 32 00 10",
    "02 00 02 00 66 00 9C 4E": "02 80 04 00 E6 01 00 10",
}


def test_it_says_when_it_is_ready():
    assert LaserBench().began == [lms2xx.PowerOn(b"LMS200;301063;V02.10 ")]
    assert LaserBench().laser.baud == 9600


@pytest.mark.parametrize("request_bytes, reply", sorted(PRINTED.items()))
def test_printed_replies(request_bytes, reply):
    assert LaserBench().ask_bytes(request_bytes) == wire("06 " + reply)


@pytest.mark.parametrize("request_bytes, begin", sorted(BEGINS.items()))
def test_replies_that_the_sheet_does_not_print_whole(request_bytes, begin):
    assert LaserBench().ask_bytes(request_bytes).startswith(wire("06 " + begin))


def test_every_request_of_the_sheet_gets_ack_and_a_reply():
    assert len(REQUESTS) >= 30
    for example in REQUESTS:
        bench = LaserBench()
        ack, reply, *_ = bench.ask(wire(example["bytes"]))
        assert ack is Answer.ACK and lms2xx.messages.NUMBERS[type(reply)] >= 0x90


@pytest.mark.parametrize("text", [
    "02 00 23 00 77 00 00 70 00 00 00 01 00 00 02 02 00x21 02 00 11 88",
    "02 00 23 00 77 00 00 46 00x6 02 02 02 00 00 0A 0A 50 64 00 0A 0A 50 64 00 0A 0A 50 64 00 00 00 00 02 00 5A D2",
    "02 00 21 00 77 00 00 46 00 00 05 01 00 00 02 02 00x21 5B 51",
    "02 00 08 00 77 00 00 46 00 00 01 01 A2 4E",
])
def test_a_configuration_of_34_32_or_7_bytes_is_written_in_the_installation_mode(text):
    bench = LaserBench().install()
    telegram = wire(text)
    raw = bench.ask_bytes(text)
    sent = telegram[5:-2]
    now = sent + wire(F4)[5:-3][len(sent):]     # the rest stays as it was
    assert raw == b"\x06" + lms2xx.encode_telegram(lms2xx.Telegram(0xF7, b"\x01" + now, 0x10))
    assert bench.ask_bytes("02 00 01 00 74 50 12") == b"\x06" + lms2xx.encode_telegram(
        lms2xx.Telegram(0xF4, now, 0x10))
    assert bench.laser.device.eeprom.writes == 1


def test_the_printed_reply_to_the_printed_configuration():
    assert LaserBench().install().ask_bytes(
        "02 00 23 00 77 00 00 70 00 00 00 01 00 00 02 02 00x21 02 00 11 88") == wire(
            "06 02 80 25 00 F7 01 00 00 70 00 00 00 01 00 00 02 02 00x21 02 00 10 C5 7A")


@pytest.mark.parametrize("changes", [
    {"measuring_mode": 0x07}, {"measuring_mode": 0x3F}, {"sensitivity": 4}, {"unit": 3}])
def test_a_configuration_that_makes_no_sense_is_refused(changes):
    bench = LaserBench().install()
    wrong = lms2xx.WriteConfiguration(dataclasses.replace(lms2xx.FACTORY, **changes))
    assert bench.ask_bytes(lms2xx.encode(wrong).hex(" ")) == wire(
        "06 02 80 25 00 F7 00 00 00 46 00 00 00 01 00 00 02 02 02 00 00 0A 0A 50 64 00 0A 0A 50 64 00 0A 0A 50 64 00"
        " 00 00 00 02 00 10 53 FE")
    assert bench.laser.device.eeprom.writes == 0 and bench.laser.device.eeprom.configuration == lms2xx.FACTORY


@pytest.mark.parametrize("request_bytes, reply", [
    ("02 00 0A 00 20 00 53 49 43 4B 5F 4C 4D 54 BB C5", A0_WRONG),      # SICK_LMT
    (lms2xx.encode(lms2xx.SetMode(Mode.INSTALLATION, b"")).hex(" "), A0_WRONG),
    (lms2xx.encode(lms2xx.SetMode(Mode.TEST_PASSWORD, b"SICK_LMX")).hex(" "), A0_WRONG),
])
def test_a_wrong_password(request_bytes, reply):
    bench = LaserBench()
    request = wire(request_bytes)
    request = request[:-2] + lms2xx.crc(request[:-2]).to_bytes(2, "little")
    assert bench.ask_bytes(request.hex(" ")) == wire("06 " + reply)
    assert bench.laser.device.operation.mode == Mode.ON_REQUEST
    assert bench.ask(lms2xx.WriteConfiguration(lms2xx.FACTORY)) == acked(lms2xx.NotPossible())


@pytest.mark.parametrize("changes", [
    *({"measuring_mode": mode} for mode in (0, 1, 2, 3, 4, 5, 6, 0x0F)), {"sensitivity": 3}, {"unit": 2}, {"unit": 0}])
def test_a_configuration_that_makes_sense_is_written(changes):
    bench = LaserBench().configure(**changes)
    assert bench.laser.device.eeprom.configuration == dataclasses.replace(lms2xx.FACTORY, **changes)
    assert bench.ask(lms2xx.AskScan(1))[1].scan.unit == changes.get("unit", 1)


def test_a_tested_password_opens_nothing():
    bench = LaserBench()
    assert bench.ask(lms2xx.SetMode(Mode.TEST_PASSWORD, b"SICK_LMS")) == acked(lms2xx.ModeSet(0))
    assert bench.ask(lms2xx.WriteConfiguration(lms2xx.FACTORY)) == acked(lms2xx.NotPossible())


IMPOSSIBLE = {
    "mode 20": lms2xx.SetMode(Mode.MINIMUM_PER_TURN, b""),
    "mode 99": lms2xx.SetMode(0x99, b""),
    "part of values that are not there": lms2xx.SetMode(Mode.STREAM_OF_A_PART, wire("01 00 6A 01")),
    "part from 0": lms2xx.SetMode(Mode.STREAM_OF_A_PART, wire("00 00 09 00")),
    "part backwards": lms2xx.SetMode(Mode.STREAM_OF_A_PART, wire("09 00 08 00")),
    "part without an end": lms2xx.SetMode(Mode.STREAM_OF_A_PART, wire("09 00")),
    "scan 02": lms2xx.AskScan(2),
    "mean": lms2xx.AskMean(2),
    "values from 0": lms2xx.AskValues(0, 5),
    "values that are not there": lms2xx.AskValues(1, 362),
    "keep speed 2": lms2xx.KeepSpeed(2),
    "unknown command": lms2xx.encode_telegram(lms2xx.Telegram(0x4A)),
    "mode without its number": lms2xx.encode_telegram(lms2xx.Telegram(0x20)),
    "half a variant": lms2xx.encode_telegram(lms2xx.Telegram(0x3B, wire("B4 00 64"))),
}


@pytest.mark.parametrize("name", sorted(IMPOSSIBLE))
def test_what_is_not_possible_gets_ack_and_92_and_changes_nothing(name):
    bench = LaserBench()
    assert bench.ask(IMPOSSIBLE[name]) == acked(lms2xx.NotPossible())
    assert bench.laser.device.operation.mode == Mode.ON_REQUEST
    assert bench.laser.device.operation.variant == lms2xx.Variant(180, 50)
    assert bench.laser.device.eeprom.writes == 0


@pytest.mark.parametrize("mode", [Mode.DIAGNOSIS, Mode.INSTALLATION, Mode.STREAM, Mode.STREAM_OF_PARTIAL_SCANS])
@pytest.mark.parametrize("request_", [lms2xx.AskScan(1), lms2xx.AskScan(8), lms2xx.AskValues(1, 2)])
def test_scans_on_request_only_in_their_mode(mode, request_):
    bench = LaserBench()
    bench.mode(mode, b"SICK_LMS" if mode == Mode.INSTALLATION else b"")
    bench.take()
    bench.send(request_).wait(0.012)
    assert wire("06 " + NOT_POSSIBLE) in bench.raw      # before it: what was cut off of a stream


@pytest.mark.parametrize("angle, step, accepted, now", [
    (100, 100, 1, (100, 100)), (100, 50, 1, (100, 50)), (100, 25, 1, (100, 25)), (180, 100, 1, (180, 100)),
    (180, 0, 1, (180, 50)), (100, 0, 1, (100, 50)),
    (180, 25, 0, (180, 50)), (90, 50, 0, (180, 50)), (0, 0, 0, (180, 50)), (180, 10, 0, (180, 50)),
])
def test_variants(angle, step, accepted, now):
    bench = LaserBench()
    assert bench.ask(lms2xx.SetVariant(angle, step)) == acked(lms2xx.VariantSet(accepted, *now))
    assert len(bench.scan().values) == lms2xx.Variant(*now).values


def test_a_step_of_0_means_the_present_one():
    bench = LaserBench().variant(180, 100)
    assert bench.ask(lms2xx.SetVariant(180, 0)) == acked(lms2xx.VariantSet(1, 180, 100))
    bench.variant(100, 25)
    assert bench.ask(lms2xx.SetVariant(180, 0)) == acked(lms2xx.VariantSet(0, 100, 25))


def test_parts_of_a_scan_on_request():
    bench = LaserBench()
    whole = bench.scan().values
    assert len(whole) == 361
    assert bench.ask(lms2xx.AskScan(6))[1].scan.values == whole[::2]
    assert bench.ask(lms2xx.AskScan(7))[1].scan.values == whole[::20]
    assert bench.ask(lms2xx.AskValues(27, 299))[1] == lms2xx.PartReply(27, 299, lms2xx.RawScan(whole[26:299]))
    partial = bench.ask(lms2xx.AskScan(8))[1].scan
    assert partial.partial and len(partial.values) == {0: 181, 2: 180}[partial.quarter]
    assert partial.values == whole[partial.quarter // 2::2]


def test_a_status_tells_what_is_now():
    bench = LaserBench().configure(measuring_mode=5, unit=0).variant(100, 25).speed(38400)
    bench.ask(lms2xx.KeepSpeed(1))
    reply = bench.ask(lms2xx.AskStatus())[1]
    assert (reply.mode, reply.measuring_mode, reply.unit, reply.angle_deg, reply.step_hundredths, reply.speed_word,
            reply.keeps_speed, reply.defect) == (0x25, 5, 0, 100, 25, 0x8019, 1, 0)
    assert len(lms2xx.encode(reply)) == 152 + 8


@pytest.mark.parametrize("baud", sorted(lms2xx.SPEEDS))
def test_the_status_names_the_speed(baud):
    assert LaserBench().speed(baud).ask(lms2xx.AskStatus())[1].speed_word == lms2xx.SPEEDS[baud].word


def test_errors_and_a_dirty_window_are_in_the_status_byte():
    bench = LaserBench()
    device = bench.laser.device
    device.errors.append(lms2xx.DeviceError(lms2xx.Severity.WARNING, 18, False))
    assert bench.ask_bytes("02 00 01 00 32 16 12") == wire("06 02 80 04 00 B2 02 12 12 42 3A")
    assert bench.ask(lms2xx.AskStatus())[1].defect == 0, "a warning is no defect"
    device.errors[:] = [lms2xx.DeviceError(lms2xx.Severity.WARNING, 18, True)]
    assert bench.ask_bytes("02 00 01 00 32 16 12")[-5:-2] == b"\x82\x12\x10"
    device.errors[:] = [lms2xx.DeviceError(lms2xx.Severity.WARNING, 18, False)]
    device.dirty_window = True
    assert bench.ask_bytes("02 00 01 00 3A 1E 12")[-3] == 0x92
    device.errors[:] = [lms2xx.DeviceError(lms2xx.Severity.ERROR, 5, True)]
    assert bench.ask_bytes("02 00 01 00 32 16 12")[-5:-2] == b"\x83\x05\x90", "an old error is none of now"
    assert bench.ask(lms2xx.AskStatus())[1].defect == 0
    device.errors[:] = [lms2xx.DeviceError(lms2xx.Severity.FATAL, 1, False)]
    device.dirty_window = False
    assert bench.ask(lms2xx.AskStatus())[1].defect == 1
    assert bench.laser.device.status == 0x14


# -- what is a request at all

STOP = "02 00 02 00 20 25 35 08"


def test_a_wrong_crc_gets_nak_alone():
    assert LaserBench().ask_bytes(STOP[:-2] + "35") == b"\x15"


@pytest.mark.parametrize("baud", [9600, None])
@pytest.mark.parametrize("example", REQUESTS, ids=lambda example: example["bytes"][:23])
def test_a_request_that_is_sent_again_after_nak_is_heard(example, baud):
    """The sheet lets a client send again after 30 ms. 30 01 has the begin of a telegram of 310 bytes inside."""
    bench, request = LaserBench(), wire(example["bytes"])
    bench.send(request[:-1] + bytes((request[-1] ^ 1,)), baud).wait(0.03)
    assert bench.raw == b"\x15"
    assert bench.take() == [Answer.NAK]
    assert bench.send(request, baud).wait(1.0).take()[0] is Answer.ACK


@pytest.mark.parametrize("row", [each for each in DATA["rejected"] if each["bytes"].startswith("02 00")],
                         ids=lambda row: row["why"])
def test_misprints_get_nak_alone(row):
    assert LaserBench().ask_bytes(row["bytes"]) == b"\x15"


@pytest.mark.parametrize("own, asked, answers", [(0, 0, True), (0, 1, False), (5, 5, True), (5, 0, True),
                                                 (5, 6, False), (0, 0x7F, False)])
def test_it_hears_its_own_address_and_0(own, asked, answers):
    bench = LaserBench(address=own)
    raw = bench.ask_bytes(lms2xx.encode(lms2xx.AskErrors(), address=asked).hex(" "))
    assert raw == (b"\x06" + lms2xx.encode(lms2xx.ErrorsReply(b""), address=own) if answers else b"")


def test_replies_are_no_requests():
    bench = LaserBench()
    for text in (A0_OK, B1, POWER_ON):
        assert bench.ask_bytes(text) == b""


def test_a_pause_within_a_request_loses_it():
    for baud, pause, heard in ((9600, 0.0055, True), (9600, 0.0065, False), (None, 0.09, True), (None, 0.11, False)):
        bench = LaserBench()
        bench.send(wire(STOP)[:5], baud).wait(pause).send(wire(STOP)[5:], baud).wait(0.5)
        assert bench.raw == (wire("06 " + A0_OK) if heard else b""), (baud, pause)
        assert bench.take() is not None and bench.ask_bytes(STOP) == wire("06 " + A0_OK), "the next one is heard"


def test_requests_in_a_bunch_are_answered_in_their_order():
    bench = LaserBench()
    assert bench.ask_bytes(STOP + " 02 00 01 00 32 16 12 02 00 01 00 3A 1E 12") == wire(
        "06 " + A0_OK + " 06 02 80 02 00 B2 10 3F 13 06 " + PRINTED["02 00 01 00 3A 1E 12"])


def test_too_many_requests_in_a_bunch_are_missed():
    bench = LaserBench()
    assert bench.ask(lms2xx.encode(lms2xx.AskErrors()) * 20) == acked(lms2xx.ErrorsReply(b"")) * 9
    assert bench.laser.missed_requests == 11
    assert bench.ask(lms2xx.AskErrors()) == acked(lms2xx.ErrorsReply(b""))


# -- power

def test_it_is_away_until_it_is_ready():
    laser = LaserBench(numbers=FirmwareNumbers()).laser      # has waited 0.1 s
    assert laser.advance(29.85) == b"" and not laser.is_ready
    laser.receive(wire(STOP))
    assert laser.advance(0.05) == b"" and laser.ignored_bytes == 8
    assert laser.is_ready
    assert laser.advance(0.1) == wire(POWER_ON)


def test_a_reset_forgets_all_but_the_eeprom():
    bench = LaserBench(numbers=dataclasses.replace(READY, boot=10.0))
    bench.wait(10.5).take()
    bench.configure(measuring_mode=1).variant(100, 100).speed(38400).mode(Mode.STREAM)
    bench.take()
    bench.send(lms2xx.ResetLaser())
    bench.wait(0.5)
    raw = bench.raw
    assert raw.endswith(wire("06 02 80 02 00 91 10 79 30"))
    assert not bench.laser.is_ready and bench.laser.baud == 9600
    assert bench.send(wire(STOP)).wait(9.0).raw == raw
    assert bench.wait(1.0).raw == raw + wire(POWER_ON)
    bench.decoder.drop_partial()
    status = bench.ask(lms2xx.AskStatus())[1]
    assert (status.mode, status.angle_deg, status.step_hundredths, status.measuring_mode, status.speed_word) == (
        0x25, 180, 50, 1, 0x8067)


def test_power_off_and_on():
    bench = LaserBench().configure(unit=0).variant(100, 100).speed(500000).mode(Mode.STREAM)
    bench.laser.power_off()
    assert bench.laser.advance(0.001)[1:] == b"", "the byte on the line may be whole, no other one"
    bench.take()
    assert bench.ask(lms2xx.AskStatus()) == [] and not bench.laser.is_ready
    bench.laser.power_on()
    bench.decoder.drop_partial()
    assert bench.wait(0.1).take() == [lms2xx.PowerOn(b"LMS200;301063;V02.10 ")]
    status = bench.ask(lms2xx.AskStatus())[1]
    assert (status.mode, status.angle_deg, status.unit, status.speed_word) == (0x25, 180, 0, 0x8067)
    assert bench.laser.device.eeprom.writes == 1


def test_power_on_does_nothing_to_a_laser_that_is_on():
    bench = LaserBench().variant(100, 25)
    bench.laser.power_on()
    assert bench.wait(1.0).take() == [] and len(bench.scan().values) == 401
    starting = LaserBench(numbers=dataclasses.replace(READY, boot=2.0))
    starting.laser.power_on()
    assert starting.wait(1.95).take() == [lms2xx.PowerOn(b"LMS200;301063;V02.10 ")]


@pytest.mark.parametrize("keep, after", [(1, 38400), (0, 9600)])
def test_a_kept_speed_is_there_after_power_on(keep, after):
    bench = LaserBench().speed(38400)
    assert bench.ask(lms2xx.KeepSpeed(keep)) == acked(lms2xx.SpeedKept(1, keep))
    bench.laser.power_off()
    assert bench.laser.baud == after
    bench.laser.power_on()
    assert bench.wait(0.1).take() == [lms2xx.PowerOn(b"LMS200;301063;V02.10 ")]
    assert bench.laser.baud == after and bench.laser.device.eeprom.writes == 1
    assert bench.ask(lms2xx.AskStatus())[1].keeps_speed == keep
