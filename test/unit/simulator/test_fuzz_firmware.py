"""A short run of bench/fuzz_firmware.py. The tests also check that it finds the errors it looks for."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[3] / "bench"))

import fuzz_firmware

from pioneer_control.simulator.firmware import Firmware
from pioneer_control.simulator.firmware.commands import HANDLERS, Handler

SEED = 11


@pytest.mark.parametrize("name, number", [("strings", 8800), ("commands", 4400), ("laser", 3200)])
def test_random_input_never_upsets_a_robot_of_any_family(name, number):
    make, longest = fuzz_firmware.KINDS[name]
    counts = fuzz_firmware.throw(make, number, SEED, longest, look_every=100)
    assert counts.inputs == number and counts.packets > 1000 and counts.obeyed > 50


def thrown(name="commands", number=2000):
    make, longest = fuzz_firmware.KINDS[name]
    return fuzz_firmware.throw(make, number, SEED, longest, look_every=100)


def test_an_exception_is_seen(monkeypatch):
    def planted(robot, value):
        raise ZeroDivisionError("planted")
    monkeypatch.setitem(HANDLERS, "HEAD", Handler(int, planted))
    with pytest.raises(fuzz_firmware.Wrong, match=r"seed 11, number \d+: ZeroDivisionError: planted"):
        thrown()


def test_a_robot_that_no_longer_answers_is_seen(monkeypatch):
    deafen = Handler(int, lambda robot, value: setattr(robot, "receive", lambda data: None))
    monkeypatch.setitem(HANDLERS, "HEAD", deafen)
    with pytest.raises(fuzz_firmware.Wrong, match="no answer to SYNC0"):
        thrown()


def test_bytes_that_are_no_packet_are_seen(monkeypatch):
    advance = Firmware.advance

    def advance_and_babble(robot, seconds):
        return advance(robot, seconds) + (b"\x55" if robot.time > 1.5 else b"")

    monkeypatch.setattr(Firmware, "advance", advance_and_babble)
    with pytest.raises(fuzz_firmware.Wrong, match="said something that is no packet"):
        thrown()


def test_a_robot_in_a_wall_is_seen(monkeypatch):
    monkeypatch.setitem(HANDLERS, "HEAD", Handler(int, lambda robot, value: robot.hardware.body.place((4.0, 0.0, 0.0))))
    with pytest.raises(fuzz_firmware.Wrong, match="stands in a wall"):
        thrown()
