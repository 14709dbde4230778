"""The session with a laser and the simulated laser, joined by a line that has a speed, noise and a cable."""

import math
import random

import pytest

from pioneer_control import lms2xx
from pioneer_control.laser.conversation import SetLineSpeed
from pioneer_control.laser.session import LaserLost, LaserSession, Measuring, ScanHeard
from pioneer_control.laser.settings import LaserSettings, check
from pioneer_control.simulator.lms200 import PERFECT, FirmwareNumbers, LaserFirmware, Optics, standing
from pioneer_control.simulator.world import load_world

STEP = 0.001        # s
HERE = (1.0, 1.0, 0.3)      # the laser's pose in the tutorial's world
QUICK = FirmwareNumbers(boot=0.0)
SPEEDS = sorted(lms2xx.SPEEDS)


class Line:
    """A session and a laser on one line, in simulated time.

    Attributes:
        lost, junk: shares of the laser's bytes that get lost, and of noise bytes between them.
        cable: whether it is plugged.
    """

    def __init__(self, numbers=QUICK, pose_at=standing(HERE), seed=1, boot=None, **settings):
        numbers = numbers if boot is None else FirmwareNumbers(boot=boot)
        self.laser = LaserFirmware(Optics(load_world("tutorial"), PERFECT), pose_at, numbers)
        self.session = LaserSession(check(LaserSettings(**settings)), True, 0.0)
        self.port_baud, self.now, self.chance = 9600, 0.0, random.Random(seed)
        self.lost = self.junk = 0.0
        self.cable = True
        self.events = []

    def run(self, seconds):
        """Let time pass, and return what the session told meanwhile."""
        told = len(self.events)
        for _ in range(round(seconds / STEP)):
            self.step()
        return self.events[told:]

    def until(self, kind, most=100.0):
        """Let time pass until the session tells this, and return it."""
        while self.now < most + 1000.0:
            for event in self.run(0.01):
                if isinstance(event, kind):
                    return event
        raise AssertionError("never: %s" % kind.__name__)

    def step(self):
        if self.now >= self.session.due or self.session.due - self.now < STEP:
            self.events += self.session.tick(self.now)
        for output in self.session.take_output():
            if isinstance(output, SetLineSpeed):
                self.port_baud = output.baud
            elif self.cable:
                self.laser.receive(output, self.port_baud)
        self.now += STEP
        self.laser.run_to(round(self.now * 1e6))
        data = b""
        for sent in self.laser.take_sent_with_speeds():
            data += sent.data if sent.baud == self.port_baud else self.chance.getrandbits(
                8 * len(sent.data)).to_bytes(len(sent.data), "big")
        if data and self.cable:
            self.events += self.session.receive(self.spoilt(data), self.now)

    def spoilt(self, data):
        if not self.lost and not self.junk:
            return data
        spoilt = bytearray()
        for byte in data:
            if self.chance.random() >= self.lost:
                spoilt.append(byte)
            if self.chance.random() < self.junk:
                spoilt.append(self.chance.getrandbits(8))
        return bytes(spoilt)


@pytest.mark.parametrize("variant", lms2xx.VARIANTS, ids=lambda variant: "%d by %d" % variant)
@pytest.mark.parametrize("baud", SPEEDS)
def test_scans_a_second_and_their_stamps(variant, baud):
    line = Line(baud=baud, angle_deg=variant.angle_deg, step_hundredths=variant.step_hundredths)
    info = line.until(Measuring).info
    assert (info.variant, info.baud, info.remarks) == (variant, baud, ())
    period = lms2xx.scan_time(variant, baud)
    line.run(2.0 * period)
    scans = [event for event in line.run(max(2.0, 4.0 * period)) if isinstance(event, ScanHeard)]
    times = [scan.first_ray for scan in scans]
    assert (len(times) - 1) / (times[-1] - times[0]) == pytest.approx(1.0 / period, rel=0.01)
    assert all(len(scan.scan.values) == variant.values for scan in scans)
    ready = line.laser.device.operation.ready_us * 1e-6
    for time in times:      # a scan begins with a turn of the mirror
        turns = (time - ready) / lms2xx.TURN_S
        assert abs(turns - round(turns)) * lms2xx.TURN_S < STEP + lms2xx.time_on_line(1, baud)


@pytest.mark.parametrize("found", SPEEDS)
@pytest.mark.parametrize("streams", [False, True])
def test_a_laser_that_somebody_left_at_any_speed_is_found(found, streams):
    line = Line()
    line.laser.run_to(round(0.05 * 1e6))
    line.laser.device.baud = found
    if streams:
        line.laser.device.operation.mode = lms2xx.Mode.STREAM
    info = line.until(Measuring).info
    assert (info.found_baud, info.baud) == (found, 38400)


def test_ranges_are_those_of_the_world():
    line = Line(angle_deg=180, step_hundredths=100)
    info = line.until(Measuring).info
    scan = line.until(ScanHeard).scan
    ranges = lms2xx.ranges_m(scan, lms2xx.MEASURING_MODES[info.configuration.measuring_mode])
    x, y, heading = HERE
    for index, far in enumerate(ranges.tolist()):
        angle = heading + info.variant.first_angle_rad + index * info.variant.step_rad
        end = x + far * math.cos(angle), y + far * math.sin(angle)
        if math.isfinite(far):      # the room is 9 by 7 m: no ray ends farther out
            assert -0.01 < end[0] < 9.01 and -0.01 < end[1] < 7.01, index
    assert ranges[0] == pytest.approx(1.0 / math.cos(heading), abs=0.01), "to the right: the wall at y = 0"


@pytest.mark.parametrize("share, some_are_whole", [(0.0005, True), (0.01, False)])
@pytest.mark.parametrize("fault", ["lost", "junk"])
def test_spoilt_bytes_cost_scans_and_nothing_else(fault, share, some_are_whole):
    """A scan has 732 bytes: of a line that loses one in a hundred hardly any comes through."""
    line = Line()
    line.until(Measuring)
    setattr(line, fault, share)
    spoilt = line.run(10.0)
    counts = line.session.counts
    assert counts.line.wrong_crcs + counts.line.discarded_bytes > 0
    setattr(line, fault, 0.0)
    line.run(3.0)
    scans = [event for event in line.run(5.0) if isinstance(event, ScanHeard)]
    assert len(scans) >= 20, "at full rate again"
    whole = {scan.scan.values for scan in scans}
    heard = [event.scan.values for event in spoilt if isinstance(event, ScanHeard)]
    assert set(heard) <= whole, "no spoilt scan was believed: the world stands still"
    assert heard or not some_are_whole


def test_a_cable_that_is_pulled_and_plugged_again():
    line = Line()
    line.until(Measuring)
    line.run(1.0)
    line.cable = False
    lost = line.until(LaserLost)
    assert "silent for" in lost.reason
    line.run(60.0)
    line.cable = True
    assert line.until(Measuring).info.baud == 38400


def test_power_that_goes_and_comes_back():
    line = Line(boot=20.0)
    line.until(Measuring)
    line.laser.power_off()
    line.until(LaserLost)
    line.laser.power_on()
    info = line.until(Measuring).info
    assert (info.found_baud, info.baud) == (9600, 38400)


def test_a_laser_that_gets_power_with_the_port():
    line = Line(boot=32.0)
    line.until(Measuring)
    assert 32.0 < line.now < 45.0


def test_at_the_end_it_has_its_speed_back_and_is_silent():
    line = Line(baud=500000)
    line.until(Measuring)
    line.session.close(line.now)
    line.run(1.0)
    assert line.session.closed and line.laser.baud == 9600
    assert line.laser.device.operation.mode == lms2xx.Mode.ON_REQUEST


def test_units_are_written_once_and_only_if_they_may_be():
    asks = dict(unit=lms2xx.Unit.CENTIMETRES, measuring_mode=1)
    line = Line(**asks)
    assert len(line.until(Measuring).info.remarks) == 2 and line.laser.device.eeprom.writes == 0
    line = Line(writes=True, **asks)
    assert line.until(Measuring).info.remarks == () and line.laser.device.eeprom.writes == 1
    scan = line.until(ScanHeard).scan
    assert scan.unit == lms2xx.Unit.CENTIMETRES
    line.session.close(line.now)
    line.run(1.0)
    line.session = LaserSession(check(LaserSettings(writes=True, **asks)), True, line.now)
    line.until(Measuring)
    assert line.laser.device.eeprom.writes == 1, "it is there already"


def test_a_laser_with_another_password():
    line = Line(numbers=FirmwareNumbers(boot=0.0, password=b"SECRET__"), writes=True, unit=0)
    assert "does not take the password" in line.until(LaserLost).reason
    assert line.laser.device.eeprom.writes == 0


def test_a_laser_that_misses_most_requests_while_it_streams():
    line = Line(numbers=FirmwareNumbers(boot=0.0, missed=0.6))
    line.until(Measuring)
    line.session.close(line.now)
    line.run(12.0)
    assert line.session.closed
