"""A short run of bench/fuzz_lasers.py. The tests also check that it finds the errors it looks for."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[3] / "bench"))

import fuzz_lasers

from pioneer_control import lms2xx
from pioneer_control.simulator.lms200 import answers, serial_output

SEED = 11


@pytest.mark.parametrize("name, number, least_telegrams", [("decoder", 4000, 2000), ("device", 8000, 1500)])
def test_random_input_upsets_neither_decoder_nor_laser(name, number, least_telegrams):
    tally = fuzz_lasers.TARGETS[name](number, SEED)
    assert tally.inputs == number and tally.telegrams > least_telegrams and tally.sent_bytes > 50000


def test_an_exception_of_the_laser_is_seen(monkeypatch):
    def planted(device, operation, request):
        raise ZeroDivisionError("planted")
    monkeypatch.setitem(answers.ANSWERS, lms2xx.KeepSpeed, answers.AnswerRow(planted))
    with pytest.raises(fuzz_lasers.Wrong, match=r"seed 11, number \d+: ZeroDivisionError: planted"):
        fuzz_lasers.throw_at_device(2000, SEED)


def test_a_laser_that_no_longer_answers_is_seen(monkeypatch):
    def planted(device, operation, request):
        return answers.REFUSED
    monkeypatch.setitem(answers.ANSWERS, lms2xx.AskErrors, answers.AnswerRow(planted))
    with pytest.raises(fuzz_lasers.Wrong, match="Wrong: no answer"):
        fuzz_lasers.throw_at_device(2000, SEED)


def test_a_line_that_carries_too_much_is_seen(monkeypatch):
    monkeypatch.setattr(serial_output._LineRun, "complete_bytes", lambda run, now_us: len(run.data))
    with pytest.raises(fuzz_lasers.Wrong, match="more than its line carries"):
        fuzz_lasers.throw_at_device(2000, SEED)


def test_a_decoder_that_loses_a_byte_is_seen(monkeypatch):
    feed = lms2xx.TelegramDecoder.feed

    def lossy(decoder, data):
        return feed(decoder, data[:-1] if len(data) > 200 else data)

    monkeypatch.setattr(lms2xx.TelegramDecoder, "feed", lossy)
    with pytest.raises(fuzz_lasers.Wrong, match="pieces say something else|not accounted for"):
        fuzz_lasers.throw_at_decoder(2000, SEED)


def test_a_decoder_that_drops_a_whole_telegram_after_a_wrong_crc_is_seen(monkeypatch):
    """As two clients do (laser sheet 1.2). Then noise may hide what follows."""
    monkeypatch.setattr(lms2xx.TelegramDecoder, "drop_partial", lambda decoder: [])
    with pytest.raises(fuzz_lasers.Wrong, match="given up|not accounted"):
        fuzz_lasers.throw_at_decoder(2000, SEED)
