"""The port of a laser, with a port and a clock that a test holds: opened, read, broken, opened again, and let go."""

import pytest

from test_laser_session import SCAN, ScriptedLaser

from pioneer_control import lms2xx
from pioneer_control.errors import LinkLostError, PortError
from pioneer_control.laser import line as line_file
from pioneer_control.laser.line import CLOSING, LOOKING, LaserLine, PortDown, StillLooking
from pioneer_control.laser.session import LaserLost, Measuring, ScanHeard
from pioneer_control.laser.settings import LaserSettings


class Site:
    """A laser, its port, and a clock that passes while the port is read. `plan` says what happens at which time."""

    def __init__(self, url="/dev/lms200", laser=None, **settings):
        self.now, self.plan = 100.0, []
        self.laser = laser or ScriptedLaser()
        self.opened, self.problems, self.port = [], [], None
        self.events = []
        self.line = LaserLine(url, LaserSettings(**settings), self.events.append, self.open, lambda: self.now)
        self.line._ending.wait = self.wait

    def open(self, url, baud):
        self.opened.append((url, baud))
        if self.problems:
            raise self.problems.pop(0)
        self.port = StandInPort(self, baud)
        return self.port

    def wait(self, seconds):
        self.pass_time(seconds)

    def pass_time(self, seconds):
        self.now += seconds
        while self.plan and self.plan[0][0] <= self.now:
            self.plan.pop(0)[1]()

    def at(self, seconds, act):
        self.plan.append((100.0 + seconds, act))

    def run(self):
        self.line.run()
        assert self.line.ended.is_set() and (self.port is None or self.port.closed)
        return self.events

    def told(self, kind):
        return [event for event in self.events if isinstance(event, kind)]


class StandInPort:
    """A port whose other end is a ScriptedLaser, which streams 4 scans a second."""

    def __init__(self, site, baud):
        self.site, self.baud, self.waiting = site, baud if site.line.url.startswith("/") else None, b""
        self.closed, self.broken, self.writes, self.next_scan = False, None, [], site.now
        self.deaf = False

    def read(self, timeout):
        assert not self.closed and timeout >= 0.0
        if not self.waiting:
            self.site.pass_time(max(timeout, 0.001))
        if self.broken:
            raise LinkLostError(self.broken)
        if self.site.laser.streams and self.site.laser.power and self.site.now >= self.next_scan:
            self.next_scan = self.site.now + 0.25
            self.waiting += lms2xx.encode(lms2xx.ScanReply(SCAN))
        data, self.waiting = self.waiting, b""
        return data

    def write(self, data):
        assert not self.closed
        if self.broken:
            raise LinkLostError(self.broken)
        self.writes.append(data)
        if not self.deaf:
            self.waiting += self.site.laser.hear(data, self.baud)
            self.site.laser.baud = self.site.laser.next_baud

    def set_baud(self, baud):
        self.baud = baud

    def wake(self):
        assert not self.closed

    def close(self):
        self.closed = True


def test_it_measures_until_the_end_and_then_the_laser_stops_and_has_its_speed_back():
    site = Site()
    site.at(10.0, site.line.end)
    site.run()
    assert len(site.told(Measuring)) == 1 and len(site.told(ScanHeard)) > 20
    assert not site.laser.streams and site.laser.baud == 9600
    assert site.now < 110.5 and site.opened == [("/dev/lms200", 38400)]


def test_on_a_socket_no_speed_is_set():
    site = Site("socket://localhost:8102", ScriptedLaser(19200))
    site.at(5.0, site.line.end)
    site.run()
    assert site.port.baud is None and site.told(Measuring)[0].info.baud == 19200 and not site.laser.streams


def test_a_port_that_is_not_there_is_told_and_tried_again():
    site = Site()
    site.problems = [PortError("no such port")] * 3
    site.at(12.0, site.line.end)
    assert site.run()[:3] == [PortDown("no such port")] * 3
    assert len(site.opened) == 4 and site.told(Measuring)


def test_a_line_that_breaks_is_opened_again():
    site = Site()
    site.at(6.0, lambda: setattr(site.port, "broken", "the line broke"))
    site.at(20.0, site.line.end)
    site.run()
    assert site.told(LaserLost) == [LaserLost("the line broke")]
    assert len(site.opened) == 2 and len(site.told(Measuring)) == 2 and site.line.session.counts.lost == 1
    assert not site.laser.streams


def test_a_line_that_breaks_at_a_write():
    site = Site()
    site.at(0.0, lambda: setattr(site.port, "broken", "the line broke"))
    site.at(30.0, site.line.end)
    site.run()
    assert LaserLost("the line broke") in site.events and site.told(Measuring)


def test_the_end_while_there_is_no_port():
    site = Site()
    site.problems = [PortError("no such port")] * 100
    site.at(5.0, site.line.end)
    site.run()
    assert site.now < 107.0 and set(site.events) == {PortDown("no such port")}


def test_the_end_while_no_laser_answers():
    site = Site()
    site.laser.power = False
    site.at(5.0, site.line.end)
    site.run()
    assert site.now < 105.5 and site.events == []


def test_a_laser_that_does_not_hear_the_end_delays_it_for_a_moment():
    site = Site()

    def end():
        site.port.deaf = True
        site.line.end()

    site.at(6.0, end)
    site.run()
    assert site.told(Measuring) and 106.0 < site.now < 106.0 + CLOSING + 0.5


def test_a_line_that_breaks_at_the_end_is_no_news():
    site = Site()

    def end():
        site.port.broken = "gone"
        site.line.end()

    site.at(6.0, end)
    site.run()
    assert site.told(LaserLost) == [] and len(site.opened) == 1


def test_nobody_answers_for_a_while():
    site = Site()
    site.laser.power = False
    site.at(30.0, site.line.end)
    site.run()
    [looking] = site.told(StillLooking)
    assert "/dev/lms200: no laser has answered yet" in looking.reason and LOOKING < 30.0


@pytest.mark.parametrize("baud, pieces", [(38400, 1), (500000, 8)])
def test_a_fast_line_gets_bytes_one_by_one(monkeypatch, baud, pieces):
    """A laser needs a pause after each byte at 500000 baud."""
    pauses = []
    monkeypatch.setattr(line_file.time, "sleep", pauses.append)
    site = Site(laser=ScriptedLaser(baud), baud=baud)
    site.at(5.0, site.line.end)
    site.run()
    assert site.told(Measuring) and not site.laser.streams
    stop = bytes.fromhex("0200020020253508")
    assert b"".join(site.port.writes[:pieces]) == stop and len(pauses) == (
        0 if baud < 100000 else len(site.port.writes))


def test_the_advice_for_a_port_that_is_not_there():
    line = LaserLine("socket://127.0.0.1:1", LaserSettings(), print)
    with pytest.raises(PortError, match="connection refused.*--laser lms200 simulates one"):
        line._open_port(line.url, 38400)
    with pytest.raises(PortError, match="no such port.*--laser lms200"):
        line._open_port("/dev/nowhere-at-all", 38400)
