"""The supply of a laser that the robot switches (laser sheet part 2, "Power").

Which of its switched supplies feeds a laser differs from robot to robot: newer ones have one for it, and say so in
CONFIGpac. Older ones have a port of their power board. The robot confirms neither.
"""

from typing import Optional

from ..p2os import Config, encode_command

LASER_BIT = 0x0002
"""Bit 1 of `Config.power_bits`: the robot has a supply of its own for a laser."""
LASER_PORT = 11
"""Port of the power board, on robots that have no such supply."""


def laser_power(config: Optional[Config], on: bool) -> bytes:
    """Return the packet that switches the laser's supply of a robot on or off. `config` is its CONFIGpac, if any."""
    if config is not None and (config.power_bits or 0) & LASER_BIT:
        return encode_command("POWER_LRF", int(on))
    return encode_command("TIMER", LASER_PORT, int(on))
