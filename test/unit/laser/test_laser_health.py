"""How a laser is: each problem makes its level and its text."""

import pytest

from pioneer_control import lms2xx
from pioneer_control.client.fault_flags import Level
from pioneer_control.laser.conversation import LaserInfo
from pioneer_control.laser.health import LaserHealth
from pioneer_control.laser.line import PortDown, StillLooking
from pioneer_control.laser.session import LaserCounts, LaserLost, Measuring, ScanHeard

INFO = LaserInfo("LMS200;301063;V02.10", lms2xx.Variant(180, 50), lms2xx.FACTORY, 38400, 9600, ())
SCAN = ScanHeard(lms2xx.RawScan((1000,) * 361), INFO, 0.0, lms2xx.WELL)
RATE = 37.5 / 8


def counts(scans=0, wrong=0, malformed=0):
    return LaserCounts(lms2xx.TelegramCounts(scans, 0, 0, wrong), scans, malformed, 0, 0)


class Watched:
    """A laser that has been measuring for ten seconds."""

    def __init__(self, info=INFO):
        self.health, self.scans, self.now, self.wrong, self.malformed = LaserHealth("/dev/lms200"), 0.0, 0.0, 0, 0
        self.health.event(Measuring(info))
        self.after(10.0)

    def after(self, seconds, share=1.0):
        for _ in range(round(seconds / 0.5)):
            self.now += 0.5
            self.scans += 0.5 * RATE * share
            finding = self.report()
        return finding

    def report(self):
        return self.health.report(self.now, counts(int(self.scans), self.wrong, self.malformed))


def test_before_a_laser_is_found():
    health = LaserHealth("/dev/lms200")
    finding = health.report(1.0, counts())
    assert finding.level is Level.ERROR and finding.message == "no scans: still looking for the laser"
    assert finding.values["Port"] == "/dev/lms200" and "Laser" not in finding.values
    assert health.hardware_id == "none"


def test_a_laser_that_is_well():
    finding = Watched().report()
    assert (finding.level, finding.message) == (Level.OK, "all scans arrive")
    assert finding.values["Laser"] == "LMS200;301063;V02.10" and finding.values["Baud"] == "38400"
    assert finding.values["Looks"] == "180 degrees wide in steps of 0.50"
    assert finding.values["Measures to"] == "8.183 m"
    assert finding.values["Scans a second the line allows"] == "4.7"
    assert float(finding.values["Scans a second"]) == pytest.approx(RATE, abs=0.3)


@pytest.mark.parametrize("event, text", [
    (LaserLost("the laser is silent for 1.1 s"), "no scans: the laser is silent"),
    (PortDown("/dev/lms200: no such port"), "no scans: /dev/lms200: no such port"),
    (StillLooking("no laser has answered yet"), "no scans: no laser has answered yet")])
def test_no_scans(event, text):
    watched = Watched()
    assert watched.health.event(event), "it is told at once"
    finding = watched.report()
    assert finding.level is Level.ERROR and finding.message.startswith(text)
    assert not watched.health.event(event), "once"
    assert watched.health.event(SCAN) and watched.report().level is Level.OK


@pytest.mark.parametrize("status, level, text", [
    (0x90, Level.WARN, "the window of the laser is dirty"), (0x50, Level.WARN, "implausible"),
    (0x12, Level.WARN, "reports a warning"), (0x13, Level.ERROR, "reports an error"),
    (0x14, Level.ERROR, "reports a fatal error"), (0x17, Level.ERROR, "reports a fatal error"),
    (0x11, Level.OK, "all scans arrive"), (0x30, Level.OK, "all scans arrive")])
def test_what_the_laser_says_of_itself(status, level, text):
    watched = Watched()
    assert watched.health.event(SCAN._replace(status=status))
    finding = watched.report()
    assert finding.level is level and text in finding.message
    assert watched.health.event(SCAN) and watched.report().level is Level.OK


def test_the_numbers_of_its_errors():
    errors = lms2xx.DeviceError(2, 18, False), lms2xx.DeviceError(3, 7, True), lms2xx.DeviceError(1, 5, False)
    watched = Watched()
    watched.health.event(SCAN._replace(status=0x12, info=INFO._replace(errors=errors)))
    finding = watched.report()
    assert finding.message == "the laser reports a warning: warning 18"
    assert finding.values["Errors that it tells"] == "warning 18, error 7 (over), information 5"
    watched.health.event(SCAN._replace(info=INFO._replace(errors=(lms2xx.DeviceError(9, 1, False),))))
    assert watched.report().values["Errors that it tells"] == "kind 9, 1"
    watched.health.event(SCAN)
    assert watched.report().values["Errors that it tells"] == "none"


@pytest.mark.parametrize("dazzled, level", [(18, Level.OK), (19, Level.WARN), (361, Level.WARN)])
def test_a_laser_that_the_sun_dazzles(dazzled, level):
    watched = Watched()
    values = (8190,) * dazzled + (8191,) * min(7, 361 - dazzled)
    watched.health.event(SCAN._replace(scan=lms2xx.RawScan(values + (1000,) * (361 - len(values)))))
    finding = watched.report()
    assert finding.level is level
    assert ("%d of 361 rays are dazzled" % dazzled in finding.message) == (level is Level.WARN)
    told = finding.values["Rays without a distance"]
    assert "dazzled %d" % dazzled in told and ("no echo came back 7" in told) == (dazzled < 361)


def test_before_the_first_scan_no_ray_is_told_of():
    health = LaserHealth("/dev/lms200")
    health.event(Measuring(INFO))
    assert health.report(0.0, counts()).values["Rays without a distance"] == "none"


@pytest.mark.parametrize("name", ["wrong", "malformed"])
def test_damaged_telegrams_are_told_for_a_while(name):
    watched = Watched()
    setattr(watched, name, 3)
    finding = watched.report()
    assert finding.level is Level.WARN and "3 telegrams were damaged in the last 4 s" in finding.message
    assert watched.after(5.0).level is Level.OK


def test_scans_that_are_missing():
    finding = Watched().after(5.0, share=0.5)
    assert finding.level is Level.WARN and "only 2." in finding.message and "of 4.7 scans a second" in finding.message


def test_what_the_laser_refused():
    finding = Watched(INFO._replace(remarks=("its unit is 1, not 0 as asked",))).report()
    assert finding.level is Level.WARN and "its unit is 1" in finding.message


def test_a_laser_that_has_just_begun_is_not_judged_by_its_rate():
    health = LaserHealth("/dev/lms200")
    health.event(Measuring(INFO))
    health.report(0.0, counts())
    finding = health.report(0.5, counts())
    assert finding.level is Level.OK and finding.values["Scans a second"] == "not known yet"
