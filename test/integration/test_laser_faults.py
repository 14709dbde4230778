"""The fault matrix of a laser: what the node runs on its port hears a simulated laser over a line with every kind of
fault, in simulated time.

A row of FAULTS says what goes wrong and for how long, what the diagnostics must say meanwhile and at which level, and
whether the laser is lost. The laser turns all the time, so no scan is like another. The judge in bench/laser_rig.py
compares every scan that is published with those that the laser has measured: values, stamp, angles, setting. After each
fault scans must come at full rate again, and the diagnostics be OK.
"""

import re
import sys
from pathlib import Path
from typing import Callable, Iterator, NamedTuple, Optional

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "bench"))

from laser_rig import LaserRig

from pioneer_control import lms2xx
from pioneer_control.client.fault_flags import Level
from pioneer_control.laser.session import LaserLost, Measuring, ScanHeard
from pioneer_control.simulator.lms200 import FirmwareNumbers

BOOT = 20.0         # s from power to the first answer
# s after the end of any fault until scans come again: a laser that starts, and the search at all speeds
RECOVERY = BOOT + 15.0


# What befalls a rig: each of these begins, lasts while the generator is at its yield, and ends

def nothing(rig):
    yield


def of_bytes(**shares):
    """Shares of the bytes in both directions that get lost, have noise behind them, or have a bit wrong."""
    def befall(rig):
        vars(rig).update(shares)
        yield
        vars(rig).update(dict.fromkeys(shares, 0.0))
    return befall


def silence(*ways):
    """Nothing arrives: 0 at the laser, 1 at this computer."""
    def befall(rig):
        for way in ways:
            rig.cable[way] = False
        yield
        rig.cable[:] = [True, True]
    return befall


def cable_pulled(rig):
    rig.plugged = False
    yield
    rig.plugged = True


def pulled_and_taken(rig):
    """The adapter comes back, but another program is quicker."""
    rig.plugged, rig.taken = False, True
    yield
    rig.plugged = True
    yield
    rig.taken = False


def power_cut(rig):
    rig.laser.power_off()
    yield
    rig.laser.power_on()


def others_say(*requests):
    """Another program on the same line tells the laser something, as none should."""
    def befall(rig):
        for request in requests:
            rig.laser.receive(lms2xx.encode(request), rig.laser.baud)
            yield
    return befall


def laser_is(**state):
    """The laser is otherwise for a while."""
    def befall(rig):
        device = rig.laser.device
        before = {name: getattr(device, name) for name in state}
        vars(device).update(state)
        yield
        vars(device).update(before)
    return befall


def busy(rig):
    """This computer does something else."""
    rig.busy = True
    yield
    rig.busy = False


def dazzled(rig):
    """The sun shines into it."""
    device, measure = rig.laser.device, rig.laser.device.scan

    def scan(*arguments):
        true = measure(*arguments)
        sun = true._replace(values=(8190,) * 50 + true.values[50:])
        rig.judge.measured[-1] = rig.judge.measured[-1]._replace(scan=sun)
        return sun

    device.scan = scan
    yield
    device.scan = measure


MODE = lms2xx.SetMode
STREAM, STOP = MODE(lms2xx.Mode.STREAM, b""), MODE(lms2xx.Mode.ON_REQUEST, b"")
INSTALL = MODE(lms2xx.Mode.INSTALLATION, lms2xx.PASSWORD)
WIDER = lms2xx.WriteConfiguration(lms2xx.FACTORY.changed(measuring_mode=5))


class Row(NamedTuple):
    """A fault: what befalls the rig; for how many s, each time it yields; the level and the words (a regular
    expression) that the diagnostics must say; whether the laser is lost; and whether scans come meanwhile, None:
    perhaps.
    """

    befall: Callable[[LaserRig], Iterator[None]]
    seconds: float
    level: Level = Level.OK
    words: str = "all scans arrive"
    loses: bool = False
    scans: Optional[bool] = True
    baud: int = 38400


DAMAGED = Level.WARN, "[1-9][0-9]* telegrams were damaged in the last [0-9]+ s: check the cable"
FEWER = Level.WARN, "only [0-9.]+ of 4.7 scans a second arrive"
SILENT = Level.ERROR, "no scans: the laser is silent for 1.[01] s: its power, its cable or another program", True
NO_SCANS = Level.ERROR, "no scans: the laser (is silent|does not answer)", True, None
LOST = Level.ERROR, "no scans: no laser answers at 38400, 9600, 19200, 500000 baud", True, False
NO_PORT = Level.ERROR, "no scans: /dev/lms200: no such port", True, False
OTHERS = Level.ERROR, "no scans: the laser begins anew, or another program has changed it", True, None

FAULTS = {
    "none": Row(nothing, 5.0),
    "none, at 9600 baud": Row(nothing, 5.0, baud=9600),
    "none, at 500000 baud": Row(nothing, 5.0, baud=500000),
    "junk among the bytes": Row(of_bytes(junk=0.0005), 20.0, *DAMAGED),
    "junk among the bytes, at 500000 baud": Row(of_bytes(junk=0.0005), 5.0, *DAMAGED, baud=500000),
    "much junk": Row(of_bytes(junk=0.02), 20.0, *NO_SCANS),
    "some bytes lost": Row(of_bytes(lost=0.0005), 20.0, *DAMAGED),
    "many bytes lost": Row(of_bytes(lost=0.02), 20.0, *NO_SCANS),
    "some bits wrong": Row(of_bytes(flips=0.0005), 20.0, *DAMAGED),
    "many bits wrong": Row(of_bytes(flips=0.02), 20.0, *NO_SCANS),
    "0.5 s of silence": Row(silence(0, 1), 0.5, scans=None),
    "3 s of silence": Row(silence(0, 1), 3.0, *SILENT, False),
    "60 s of silence": Row(silence(0, 1), 60.0, *SILENT, False),
    "60 s of silence from the laser": Row(silence(1), 60.0, *SILENT, False),
    "90 s of silence": Row(silence(0, 1), 90.0, *LOST),
    "60 s in which the laser hears nothing": Row(silence(0), 60.0),
    "cable pulled and put back at once": Row(cable_pulled, 0.1, *NO_PORT[:3], scans=None),
    "cable pulled and put back": Row(cable_pulled, 5.0, *NO_PORT),
    "cable pulled for a minute": Row(cable_pulled, 60.0, *NO_PORT),
    "another program takes the port": Row(pulled_and_taken, 5.0, Level.ERROR, "in use by another program", True, False),
    "power cut": Row(power_cut, 1.0, *SILENT, False),
    "power cut for a minute": Row(power_cut, 60.0, *SILENT, False),
    "another program resets it": Row(others_say(lms2xx.ResetLaser()), 5.0, *OTHERS),
    "another program stops it": Row(others_say(STOP), 5.0, *SILENT, None),
    "another program takes it to another speed": Row(others_say(MODE(lms2xx.SPEEDS[19200].mode, b"")), 5.0,
                                                     Level.ERROR, "no scans: what comes is no scan", True, None),
    "another program has it look otherwise": Row(others_say(lms2xx.SetVariant(100, 50)), 5.0, *OTHERS),
    "another program has it measure otherwise": Row(others_say(INSTALL, WIDER, STREAM), 0.3, *OTHERS),
    "a dirty window": Row(laser_is(dirty_window=True), 5.0, Level.WARN, "the window of the laser is dirty"),
    "a warning": Row(laser_is(errors=[lms2xx.DeviceError(2, 18, False)]), 5.0, Level.WARN,
                     "the laser reports a warning: warning 18"),
    "an error": Row(laser_is(errors=[lms2xx.DeviceError(3, 7, False)]), 5.0, Level.ERROR,
                    "the laser reports an error: error 7"),
    "the sun in its window": Row(dazzled, 5.0, Level.WARN, "50 of 361 rays are dazzled"),
    "a busy computer": Row(busy, 0.9, scans=None),
    "a busy computer, at 500000 baud": Row(busy, 0.9, scans=None, baud=500000),
    "a very busy computer": Row(busy, 5.0, *FEWER, scans=None),
}


@pytest.mark.parametrize("name", FAULTS)
def test_the_matrix(name):
    row = FAULTS[name]
    rig = LaserRig(FirmwareNumbers(boot=0.0), baud=row.baud, seed=len(name))

    def script(rig):
        yield from rig.until(Measuring)
        yield 6.0
        assert rig.diagnosis.now.level is Level.OK, rig.diagnosis.now
        assert not rig.told(LaserLost) and not rig.judge.wrongs
        rig.laser.numbers = FirmwareNumbers(boot=BOOT)
        rig.diagnosis.said.clear()
        begin = rig.now
        for _ in row.befall(rig):
            yield row.seconds
        meanwhile = len(rig.told(ScanHeard, begin + 0.5))
        after = rig.now
        yield from rig.until(lambda: rig.told(ScanHeard, after + 1.0), RECOVERY)
        yield 6.0
        said = [(each.level, each.message) for each in rig.diagnosis.said]
        assert any(level is row.level and re.search(row.words, message) for level, message in said), set(said)
        assert all(level <= row.level for level, _ in said), set(said)
        assert bool(rig.told(LaserLost)) == row.loses
        assert row.scans in (None, bool(meanwhile))
        assert (rig.diagnosis.now.level, rig.diagnosis.now.message) == (Level.OK, "all scans arrive")
        recent = rig.told(ScanHeard, rig.now - 4.0)
        period = lms2xx.scan_time(recent[-1].info.variant, row.baud)
        assert len(recent) >= 4.0 / period - 1.5
        assert recent[-1].info.baud == row.baud

    rig.play(script)
    assert rig.judge.wrongs == []
    assert rig.laser.device.operation.mode == lms2xx.Mode.ON_REQUEST, "it was told to stop"


@pytest.mark.parametrize("name, words", [("none", "not named"), ("power cut", "OK")])
def test_a_row_that_is_not_true_is_seen(monkeypatch, name, words):
    monkeypatch.setitem(FAULTS, name, FAULTS[name]._replace(level=Level.WARN, words="nothing says this"))
    with pytest.raises(AssertionError):
        test_the_matrix(name)
