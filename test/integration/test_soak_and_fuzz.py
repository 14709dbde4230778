"""Short runs of bench/soak.py and bench/fuzz.py. The tests also check that both find the errors they look for."""

import os
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "bench"))

import fuzz
import soak


@pytest.mark.parametrize("baud", [None, 9600])
def test_some_minutes_of_everything(baud):
    day = soak.Day(seed=3, baud=baud)
    day.live(0.25)
    assert not day.rig.judge.wrongs
    assert sum(day.faults.values()) > 30 and day.rig.judge.distance > 50


def test_a_robot_that_is_never_ready_again_is_seen(monkeypatch):
    day = soak.Day(seed=3, baud=None)
    monkeypatch.setattr(day.rig, "mend", lambda: None)
    monkeypatch.setattr(soak, "FAULTS", {"pulled": soak.pull})
    monkeypatch.setattr(day, "faults", {"pulled": 0})
    day.live(0.01)
    assert any("no recovery" in wrong for wrong in day.rig.judge.wrongs)


@pytest.mark.parametrize("values, growing", [
    ([100] * 20, False), ([50, 90] + [100] * 18, False), (list(range(100, 120)), True), ([100] * 18 + [120] * 2, True)])
def test_growth_is_seen(values, growing):
    assert soak.grown(values) is growing


def test_what_a_process_holds():
    assert soak.resident_kb(os.getpid()) > 1000


@pytest.mark.parametrize("name", sorted(fuzz.TARGETS))
def test_a_few_inputs_break_nothing_and_reach_something(name):
    said = []
    assert fuzz.search(name, seconds=0.0, seed=1, say=said.append) == []
    assert int(said[-1].split(" arcs")[0].rpartition(" ")[2]) > 200, said


@pytest.mark.parametrize("found", ["01", "5d62077c9d6d960000fafb090ffb", "03ac27070a2b4d070a0a0aa9af4d"])
def test_what_was_found_once_breaks_nothing_any_more(found):
    fuzz.try_session(bytes.fromhex(found))


def test_a_planted_fault_is_found_and_shortened(monkeypatch):
    def planted(data):
        assert fuzz.PIECES[0] not in data

    monkeypatch.setitem(fuzz.TARGETS, "decoder", planted)
    finding, = fuzz.search("decoder", seconds=0.0, seed=1, say=lambda _: None)
    assert "AssertionError in test_soak_and_fuzz.py" in finding.what
    assert finding.data == fuzz.PIECES[0]
