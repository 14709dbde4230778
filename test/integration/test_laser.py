"""What the node of a laser runs on its port, and the simulated laser, joined by a line with a speed, in simulated time:
bench/laser_rig.py. test_laser_faults.py has what goes wrong.
"""

import math
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "bench"))

from laser_rig import HERE, TURN, LaserRig

from pioneer_control import lms2xx
from pioneer_control.laser.conversion import numbers_of
from pioneer_control.laser.session import LaserLost, Measuring, ScanHeard
from pioneer_control.simulator.lms200 import FirmwareNumbers
from pioneer_control.simulator.world import World

SPEEDS = sorted(lms2xx.SPEEDS)
variants = pytest.mark.parametrize("variant", lms2xx.VARIANTS, ids=lambda variant: "%d by %d" % variant)


def measuring(rig, seconds=0.0):
    """A script: wait until the laser measures, and then for some time."""
    yield from rig.until(Measuring)
    yield seconds


def measured(seconds=0.0, script=measuring, **options):
    """Return a rig whose laser has measured for some time, and was told to stop."""
    return LaserRig(**options).play(lambda rig: script(rig, seconds))


def info_of(rig):
    return rig.told(Measuring)[-1].info


@variants
@pytest.mark.parametrize("baud", SPEEDS)
def test_scans_a_second_and_their_stamps(variant, baud):
    """The judge of the rig compares each stamp with the time at which the laser fired the first ray."""
    period, step = lms2xx.scan_time(variant, baud), min(0.001, lms2xx.time_on_line(1, baud))
    rig = measured(8.0 * period, baud=baud, angle_deg=variant.angle_deg, step_hundredths=variant.step_hundredths,
                   step=step)
    info = info_of(rig)
    assert (info.variant, info.baud, info.remarks) == (variant, baud, ())
    times = [scan.first_ray for scan in rig.told(ScanHeard)][1:]
    assert len(times) >= 3
    assert (len(times) - 1) / (times[-1] - times[0]) == pytest.approx(1.0 / period, rel=0.01)
    assert rig.judge.wrongs == [] and rig.judge.worst < 1.01 * max(step, lms2xx.time_on_line(1, baud))


@pytest.mark.parametrize("found", SPEEDS)
@pytest.mark.parametrize("streams", [False, True])
def test_a_laser_that_somebody_left_at_any_speed_is_found(found, streams):
    rig = LaserRig()
    rig.laser.run_to(0)
    rig.laser.device.baud = found
    if streams:
        rig.laser.device.operation.mode = lms2xx.Mode.STREAM
    rig.play(measuring)
    info = info_of(rig)
    assert (info.found_baud, info.baud, rig.laser.baud) == (found, 38400, found)


ROOM = World("room", walls=[(0, 0, 7, 0), (7, 0, 7, 4), (7, 4, 0, 4), (0, 4, 0, 0)])


def to_wall(pose, angle):
    """Return the distance (m) to the wall of `ROOM`."""
    x, y, heading = pose
    c, s = math.cos(heading + angle), math.sin(heading + angle)
    along_x = ((7.0 if c > 0 else 0.0) - x) / c if abs(c) > 1e-9 else math.inf
    along_y = ((4.0 if s > 0 else 0.0) - y) / s if abs(s) > 1e-9 else math.inf
    return min(along_x, along_y)


@pytest.mark.parametrize("unit, half_a_step", [(lms2xx.Unit.MILLIMETRES, 0.0006), (lms2xx.Unit.CENTIMETRES, 0.0051)])
@variants
def test_ranges_are_those_of_the_world(variant, unit, half_a_step):
    """Each ray was fired when stamp and time_increment say. Where that is no single time, the laser stands."""
    turn_rate = 1.7 if variant.turns == 1 else 0.0
    rig = measured(0.3, baud=500000, angle_deg=variant.angle_deg, step_hundredths=variant.step_hundredths, unit=unit,
                   writes=True, world=ROOM, turn_rate=turn_rate)
    numbers = numbers_of(rig.told(ScanHeard)[-1])
    assert len(numbers.ranges) == variant.values and numbers.angle_min == -math.radians(variant.angle_deg) / 2
    for index, far in enumerate(numbers.ranges.tolist()):
        heading = HERE[2] + turn_rate * (numbers.first_ray + index * numbers.time_increment)
        angle = numbers.angle_min + index * numbers.angle_increment
        walls = [to_wall((*HERE[:2], heading + late * 1e-4 * turn_rate), angle) for late in range(-16, 17)]
        assert min(walls) - half_a_step < far < max(walls) + half_a_step, "within the 1.6 ms of the stamp"


def test_a_laser_that_gets_power_with_the_port():
    rig = measured(numbers=FirmwareNumbers(boot=32.0))
    assert rig.told(LaserLost) == [] and 32.0 < rig.events[-1][0] < 45.0


def test_at_the_end_it_has_its_speed_back_and_is_silent():
    rig = measured(baud=500000)
    assert rig.laser.baud == 9600 and rig.laser.device.operation.mode == lms2xx.Mode.ON_REQUEST


def test_units_are_written_once_and_only_if_they_may_be():
    asks = dict(unit=lms2xx.Unit.CENTIMETRES, measuring_mode=1)
    rig = measured(**asks)
    assert len(info_of(rig).remarks) == 2 and rig.laser.device.eeprom.writes == 0

    def again(rig):
        yield from measuring(rig, 0.5)
        assert rig.told(ScanHeard)[-1].scan.unit == lms2xx.Unit.CENTIMETRES
        rig.plugged = False
        yield from rig.until(LaserLost)
        rig.plugged = True
        yield from rig.until(Measuring)

    rig = LaserRig(writes=True, **asks).play(again)
    assert info_of(rig).remarks == () and rig.laser.device.eeprom.writes == 1, "the second time it was there already"


def test_reflectors_are_intensities():
    rig = measured(0.5, measuring_mode=1, writes=True)
    numbers = numbers_of(rig.told(ScanHeard)[-1])
    assert len(numbers.intensities) == len(numbers.ranges) == 361


def test_a_laser_with_another_password():
    def refused(rig):
        yield from rig.until(LaserLost)

    rig = LaserRig(FirmwareNumbers(boot=0.0, password=b"SECRET__"), writes=True, unit=0).play(refused)
    assert "does not take the password" in rig.told(LaserLost)[-1].reason and rig.laser.device.eeprom.writes == 0


def test_a_laser_that_misses_most_requests_while_it_streams():
    rig = measured(numbers=FirmwareNumbers(boot=0.0, missed=0.6))
    assert rig.line.session.closed


def test_the_judge_sees_what_is_wrong():
    rig = LaserRig()

    def forge(rig):
        yield from measuring(rig, 1.0)
        heard = rig.told(ScanHeard)[-1]
        for wrong in (heard._replace(scan=lms2xx.RawScan((1,) * 361)), heard._replace(first_ray=rig.now),
                      heard._replace(info=heard.info._replace(variant=lms2xx.Variant(100, 25))), heard):
            rig.judge.event(wrong)

    rig.play(forge)
    said = " ".join(rig.judge.wrongs)
    for words in ("not measured", "stamp that is off", "another setting", "not newer"):
        assert words in said
    assert TURN > 0.0, "no scan is like another"
