"""The explainer of a laser's line, as a reader wants it."""

import io
import random

import pytest
from test_lms2xx_golden import EXAMPLES, expected, wire

from pioneer_control import lms2xx
from pioneer_control.errors import UsageError
from pioneer_control.lms2xx.__main__ import main
from pioneer_control.lms2xx.explain import explain_laser_record, explain_line, line_pieces, recorded_bytes
from pioneer_control.wire_words import hex_of

STREAM = "02 00 02 00 20 24 34 08"
DONE = "02 80 03 00 A0 00 10 16 0A"


def said(text):
    """Return all lines for these bytes, with single spaces."""
    return "\n".join(" ".join(line.split()) for line in explain_line(wire(text)))


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda example: example["bytes"][:40])
def test_every_golden_telegram(example):
    data, message = wire(example["bytes"]), expected(example)
    text = said(example["bytes"])
    assert text.startswith(hex_of(data) + "\nlength ") and "is right" in text
    way = "from" if data[1] & 0x80 else "to"
    assert "%s the laser: %s. " % (way, type(message).__name__) in text
    assert ("status %02X: " % example.get("status", 0x10) in text) is (way == "from")
    for name, value in vars(message).items():
        if isinstance(value, int) and not name.startswith("reserved_"):
            assert "%s %d" % (name, value) in text
    assert "None" not in text and "reserved_" not in text.replace("reserved_118 2", "")


def test_what_a_person_wants_to_know():
    assert "mode 36 STREAM" in said(STREAM)
    assert "53 49 43 4B 5F 4C 4D 53 'SICK_LMS'" in said("02 00 0A 00 20 00 53 49 43 4B 5F 4C 4D 53 BE C5")
    assert "warning, number 18\nstatus 12: warning" in said("02 80 04 00 B2 02 12 12 42 3A")
    assert "no errors" in said("02 80 02 00 B2 10 3F 13")
    assert "1 values in mm: 1234\nstatus 92: warning, dirty window" in said("02 80 06 00 B0 01 40 D2 04 92 72 B9")
    assert "partial scan from x.50 degrees on, 2 values in mm: 1000, 1001" in said(
        "02 80 08 00 B0 02 70 E8 03 E9 03 10 48 80")
    assert "2 values in mm: 58844, 1500; turn 42, telegram 7" in said(
        "02 80 0A 00 B0 02 40 DC E5 DC 05 2A 07 10 54 18")
    long = said(hex_of(lms2xx.encode(lms2xx.ScanReply(lms2xx.RawScan(tuple(range(361)))))))
    assert "361 values in mm: 0, 1, 2, 3, 4, 5, 6, 7, ...\n" in long
    assert "step_hundredths 50 = 0.5 deg" in said("02 00 05 00 3B B4 00 32 00 3B 1F")
    old = lms2xx.encode(lms2xx.ErrorsReply(bytes((0x83, 7, 0x09, 1))), status=0x68)
    assert ("error, number 7, over\nkind 9, number 1\nstatus 68: ok, a special device, restart input, implausible"
            in said(hex_of(old)))


def test_answers_unknown_and_malformed():
    assert "ACK: the request arrived whole" in said("06") and "NAK" in said("15")
    assert "a telegram of unknown command; data: 01 02" in said(
        hex_of(lms2xx.encode_telegram(lms2xx.Telegram(0x11, b"\x01\x02"))))
    assert "from the laser: ScanReply, malformed: its data end too soon: " in said(
        hex_of(lms2xx.encode_telegram(lms2xx.Telegram(0xB0, b"\x05\x40", 0x10))))


@pytest.mark.parametrize("text, wrong", [
    ("02 00 02 00 20 24 34 09", "wrong CRC: 34 09, should be 34 08; it would say:\nto the laser: SetMode."),
    ("02 00 00 00 34 08", "no telegram: length 0 (1..808 is legal)"),
    ("02 80 FF FF 34 08", "no telegram: length 65535 (2..808 is legal)"),
    ("02 80 02 00 20 24 34 08", "no telegram: address 80 does not go with command 20"),
    ("FF 00", "noise: no STX (02)"),
])
def test_broken_bytes(text, wrong):
    assert wrong in said(text)
    assert said(text + " " + STREAM).endswith(said(STREAM))


@pytest.mark.parametrize("count, wrong", [(1, "cut off: STX"), (3, "cut off: STX"), (5, "cut off: length 2, 3 bytes")])
def test_bytes_that_are_cut_off(count, wrong):
    assert wrong in said(STREAM[:3 * count])


def test_no_byte_is_left_out():
    draw = random.Random(5)
    for _ in range(300):
        words = [draw.choice([STREAM, DONE, "02", "80", "06", "15", "00", "20", "02 80 03 00", "FF"])
                 for _ in range(draw.randrange(12))]
        data = bytes.fromhex(" ".join(words))
        assert b"".join(piece.data for piece in line_pieces(data)) == data
        assert len(list(explain_line(data))) >= len(line_pieces(data))


RECORD = """0.000100 > 02 00 02 00
0.000300 > 20 24 34 08

0.050000 < 06 02 80 03 00 A0
0.051000 < 00 10 16 0A FF
0.200000 < 02 80 06 00
0.310000 < 06
"""


def test_a_record_is_told_telegram_by_telegram():
    assert list(explain_laser_record(recorded_bytes(RECORD.splitlines()))) == [
        "    0.000300  > SetMode: mode 36 STREAM, parameters none",
        "    0.050000  < ACK",
        "    0.051000  < ModeSet: result 0",
        "    0.051000  < FF  (noise: no STX (02))",
        "    0.200000  < 02 80 06 00  (cut off: length 6, 8 bytes missing)",
        "    0.310000  < ACK",
    ]
    long = "\n".join(explain_laser_record(recorded_bytes(RECORD.splitlines()), long=True))
    assert "    0.000300  >\n02 00 02 00 20 24 34 08\n  length 2" in long


def test_what_is_odd_in_a_record_stays_in_one_line():
    lines = ["0.1 < " + hex_of(each) for each in (
        lms2xx.encode(lms2xx.ErrorsReply(b"\x02\x12"), status=0x12), b"\xFF" * 20,
        lms2xx.encode_telegram(lms2xx.Telegram(0xB0, b"\x05\x40", 0x10)))]
    assert list(explain_laser_record(recorded_bytes(lines))) == [
        "    0.100000  < ErrorsReply: warning, number 18  (status 12: warning)",
        "    0.100000  < FF FF FF FF FF FF FF FF ...  (noise: no STX (02))",
        "    0.100000  < MalformedMessage B0",
    ]


@pytest.mark.parametrize("line", ["0.1 > 0G", "x > 02", "0.1 = 02", "0.1 >", "02 00 02 00 20 24 34 08"])
def test_a_line_that_is_none_is_named(line):
    with pytest.raises(UsageError, match="line 2 of the record: '%s' is not 'TIME > BYTES'" % line):
        list(recorded_bytes(["0.1 > 02", line]))


def test_the_program(capsys, monkeypatch, tmp_path):
    assert main(STREAM.split()) == 0
    assert "SetMode" in capsys.readouterr().out
    monkeypatch.setattr("sys.stdin", io.StringIO(STREAM + "\nFF\n"))
    assert main([]) == 1, "one byte was noise"
    assert "noise" in capsys.readouterr().out
    record = tmp_path / "laser.txt"
    record.write_text(RECORD)
    assert main(["--record", str(record)]) == 0
    assert "ModeSet: result 0" in capsys.readouterr().out
    assert main(["--record", str(record), "--long"]) == 0
    assert "CRC 34 08 is right" in capsys.readouterr().out


@pytest.mark.parametrize("arguments, says", [
    (["02", "0G"], "'0G' is not hexadecimal"), ([], "no bytes given"), (["--record", "/nowhere"], "/nowhere: No such"),
    (["--record", __file__], "line 1 of the record")])
def test_bad_input_ends_with_2(capsys, monkeypatch, arguments, says):
    monkeypatch.setattr("sys.stdin", io.StringIO(""))
    with pytest.raises(SystemExit) as end:
        main(arguments)
    assert end.value.code == 2 and says in capsys.readouterr().err
