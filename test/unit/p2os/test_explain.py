"""The output of the explainer, as a reader wants it."""

import io
import random

import golden
import pytest

from pioneer_control.errors import UsageError
from pioneer_control.p2os.__main__ import main
from pioneer_control.p2os.explain import explain, pieces
from pioneer_control.wire_words import parse_hex

VEL = "FA FB 06 0B 1B C8 00 D3 1B"


def said(text: str, **options) -> str:
    """Return all lines for these bytes, with single spaces."""
    return "\n".join(" ".join(line.split()) for line in explain(parse_hex(text), **options))


@pytest.mark.parametrize("text", [
    VEL, VEL.lower(), VEL.replace(" ", ""), ", ".join("0x" + byte for byte in VEL.split()), VEL.replace(" ", ":"),
    "".join("\\x" + byte for byte in VEL.split()), VEL.replace(" ", "\n"), "FAFB 0x6 b 1bC8,0,d3;1B",
])
def test_ways_to_write_bytes(text):
    assert parse_hex(text) == bytes.fromhex(VEL)


@pytest.mark.parametrize("text, why", [
    ("FA FG", "'FG' is not hexadecimal"), ("hello", "'hello' is not"), ("FA -1", "'-1' is not"),
    ("FAF", "'FAF' has an odd number of digits"), ("0xFAB", "'FAB' has an odd number"),
])
def test_no_hex(text, why):
    with pytest.raises(UsageError, match=why):
        parse_hex(text)


@pytest.mark.parametrize("example", golden.EXAMPLES, ids=golden.label)
def test_every_golden_packet(example):
    """Each packet is shown by its name, with the values of the data file."""
    options = {"grip_state_first": example.get("order") != "port first"}
    text = said(example["bytes"], **options)
    assert text.startswith(example["bytes"] + "\nbyte count ") and "is right" in text
    if "command" in example:
        assert f"to the robot: {example['command'][0]}" in text
        for value in example["command"][1:]:
            assert str(value) in text
    if example.get("packet") == "MalformedPacket":
        assert "from the robot: malformed, its data end too soon: Playlist.length" in text
    elif "packet" in example:
        assert f"from the robot: {example['packet']}." in text
        for name, expected in example["fields"].items():
            assert (name + " " in text) == (expected is not None) or name in text.partition("not sent by")[2]
            if isinstance(expected, (str, int)) and expected:
                assert str(expected) in text
            elif isinstance(expected, list) and expected and isinstance(expected[0], str):
                assert ", ".join(expected) in text


def test_physical_meaning():
    text = said(golden.SIP["bytes"])
    for expected in ("heading_units 512 = 45 deg", "battery_dv 128 = 12.8 V", "rotation_velocity_ddeg_s 32 = 3.2 deg/s",
                     "flags 0x07 MOTORS_ENABLED, SONAR_1, SONAR_2", "number 3, range_units 1500", "0 NOT_CHARGING",
                     "not sent by this firmware: lateral_velocity_mm_s, temperature_c"):
        assert expected in text


def test_directions():
    """1 is SYNC1 and OPEN, and its echo. A SIP is no command, and a command is no packet."""
    both = said("FA FB 03 01 00 01")
    assert "to the robot: OPEN" in both and "from the robot: SyncEcho" in both
    assert "from the robot" not in said("FA FB 03 01 00 01", from_robot=False)
    assert "to the robot" not in said("FA FB 03 01 00 01", to_robot=False)
    assert "from the robot" not in said(VEL)
    assert "from the robot: a packet of unknown type" in said(VEL, to_robot=False)
    sip = golden.SIP["bytes"]
    assert "to the robot" not in said(sip)
    assert "AUX1BAUD" in said(sip, from_robot=False) and "D2 is no argument type" in said(sip, from_robot=False)
    assert "from the robot: IMU" in said("FA FB 03 9A 00 9A")


def test_commands():
    assert "GRIPPER 5 LIFT_DOWN" in said("FA FB 06 21 3B 05 00 26 3B")
    assert "VEL2 -10, 10" in said("FA FB 06 20 1B F6 09 16 24")
    assert "DIGOUT 255, 5" in said("FA FB 06 1E 1B FB 00 19 1B")
    assert "121, out of range (2..120 is legal)" in said("FA FB 06 30 3B 79 00 A9 3B")
    assert "(old simulators: exit)" in said("FA FB 06 3E 3B 01 00 3F 3B")
    assert "command 200, which no Pioneer knows" in said("FA FB 03 C8 00 C8", from_robot=False)
    assert "an integer that is cut off" in said("FA FB 05 0B 3B 01 0B 3A")
    assert "a string that is cut off" in said("FA FB 06 2A 2B 09 68 33 43")


@pytest.mark.parametrize("text, wrong", [
    ("FA FB 06 0B 3B C8 00 D3 3A", "wrong checksum: D3 3A, should be D3 3B; it would say:\nto the robot: VEL 200"),
    ("FA FB 06 0B 3B C8 00 3B D3", "wrong checksum: 3B D3, should be D3 3B"),
    ("FA FB 02 00 00", "no packet: byte count 2, but id and checksum alone are 3"),
    ("FA FB 06 0B", "cut off: byte count 6, 5 missing"),
    ("FA FB", "cut off: a header, and nothing behind it"),
    ("12 34", "noise: no header FA FB"),
])
def test_broken_bytes(text, wrong):
    assert wrong in said(text)
    after = said(text + " " + VEL)
    assert after.endswith(f"{VEL}\nbyte count 6, id 11 (0x0B), checksum D3 1B is right\nto the robot: VEL -200\n"
                          "mm/s, + forward: translation speed")


def test_nothing_is_left_out():
    """The pieces of any stream together are the stream."""
    draw = random.Random(5)
    for _ in range(200):
        words = [draw.choice([VEL, "FA", "FB", "FA FB", "03", "00", "1D", "FF"]) for _ in range(draw.randrange(12))]
        data = bytes.fromhex(" ".join(words))
        assert b"".join(piece.data for piece in pieces(data)) == data
        assert sum(piece.data == bytes.fromhex(VEL) and not piece.wrong for piece in pieces(data)) == words.count(VEL)
        assert len(list(explain(data))) >= len(pieces(data))


def test_the_program(capsys, monkeypatch):
    assert main(VEL.split()) == 0
    assert "VEL -200" in capsys.readouterr().out
    monkeypatch.setattr("sys.stdin", io.StringIO(VEL + "\n00\n"))
    assert main([]) == 1, "one byte was noise"
    assert "noise" in capsys.readouterr().out
    assert main(["--from-robot", "FA", "FB", "03", "FF", "00", "FF"]) == 0
    assert "Reset" in capsys.readouterr().out
    assert main(["--port-first", "FA FB 06 E0 02 B3 0A 93 0C"]) == 0
    assert "PADDLES_MOVING" in capsys.readouterr().out


@pytest.mark.parametrize("arguments, says", [
    (["FA", "FG"], "'FG' is not hexadecimal"),
    ([], "no bytes given"),
    (["--to-robot", "--from-robot", "FA"], "not allowed"),
])
def test_bad_input_ends_with_2(capsys, monkeypatch, arguments, says):
    monkeypatch.setattr("sys.stdin", io.StringIO(""))
    with pytest.raises(SystemExit) as end:
        main(arguments)
    assert end.value.code == 2
    assert says in capsys.readouterr().err
