"""The packets that switch the supply of a laser, byte by byte (laser sheet part 2)."""

from types import SimpleNamespace

import pytest

from pioneer_control.client.laser_power import laser_power

OWN_ON, BOARD_ON = "FA FB 06 60 3B 01 00 61 3B", "FA FB 06 1F 3B 01 0B 20 46"
OWN_OFF, BOARD_OFF = "FA FB 06 60 3B 00 00 60 3B", "FA FB 06 1F 3B 00 0B 1F 46"


@pytest.mark.parametrize("power_bits, on, off", [
    (0x0002, OWN_ON, OWN_OFF), (0xFFFF, OWN_ON, OWN_OFF), (0xFFFD, BOARD_ON, BOARD_OFF), (0, BOARD_ON, BOARD_OFF),
    (None, BOARD_ON, BOARD_OFF)])       # older firmware ends before the power bits
def test_the_supply_that_the_robot_has(power_bits, on, off):
    config = SimpleNamespace(power_bits=power_bits)
    assert (laser_power(config, True), laser_power(config, False)) == (bytes.fromhex(on), bytes.fromhex(off))


def test_a_robot_without_a_configuration():
    assert laser_power(None, True) == bytes.fromhex(BOARD_ON)
