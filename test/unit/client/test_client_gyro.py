"""The gyro that the client reads, tested with the bytes of the protocol sheet (5.6)."""

import math

import pytest

from pioneer_control import p2os
from pioneer_control.client.gyro import GyroReader

GOLDEN = "FAFB109804000278FE0178FF01780102788BF6"
PER_UNIT = math.radians(5 / 1023 * 120 * 1.626)


def packet(*rates):
    return p2os.Gyro(tuple(p2os.GyroReading(rate, 120) for rate in rates))


def test_the_golden_packet_is_a_robot_that_stands():
    frame, = p2os.FrameDecoder().feed(bytes.fromhex(GOLDEN))
    golden = p2os.decode_packet(frame)
    assert [reading.rate for reading in golden.readings] == [512, 510, 511, 513]
    assert GyroReader().rate(golden, standing=False) == pytest.approx(0.5 * PER_UNIT)
    assert GyroReader().rate(golden, standing=True) == pytest.approx(0.0)


def test_below_the_centre_is_counter_clockwise():
    reader = GyroReader()
    assert reader.rate(packet(412), False) == pytest.approx(100 * PER_UNIT)
    assert reader.rate(packet(612), False) == pytest.approx(-100 * PER_UNIT)


def test_what_it_reads_at_rest_is_learnt_while_the_wheels_stand_and_only_then():
    reader = GyroReader()
    for _ in range(50):
        reader.rate(packet(518, 520), standing=True)
    assert reader.rate(packet(519), False) == pytest.approx(0.0, abs=1e-9)
    for _ in range(50):
        reader.rate(packet(530), standing=False)
    assert reader.rate(packet(519), False) == pytest.approx(0.0, abs=1e-9)


def test_a_slow_drift_is_followed():
    reader = GyroReader()
    for rate in [512] * 2000 + [516] * 2000:
        reader.rate(packet(rate), standing=True)
    assert reader.rate(packet(516), False) == pytest.approx(0.0, abs=0.1 * PER_UNIT)


def test_a_robot_that_is_turned_by_hand_is_not_at_rest():
    reader = GyroReader()
    assert reader.rate(packet(300), standing=True) == pytest.approx(212 * PER_UNIT)


def test_an_empty_packet_says_nothing():
    assert GyroReader().rate(packet(), standing=True) is None


def test_a_gyro_that_is_calibrated():
    assert GyroReader(0.9).rate(packet(412), False) == pytest.approx(90 * PER_UNIT)
