"""Turns raw readings into a turn rate, for a gyro that the client has to read (has_gyro 1 in CONFIGpac; protocol 5.6).
"""

import math
from typing import Optional

from .. import p2os
from .identity import RobotIdentity

# 5 V are 1023 units, 300 deg/s are 2.5 V, and all models share one calibration factor.
RAD_S_PER_UNIT = math.radians(5 / 1023 * 300 / 2.5 * 1.626)
NOMINAL_CENTRE = 512.0      # what a gyro at rest reads, more or less
NEAR_CENTRE = 30.0          # how much more or less; beyond it, something turns the robot while its wheels stand
MOST_AT_REST = 200          # readings (5 s) over which the centre is averaged
# Value of has_gyro in CONFIGpac. From 2 on the robot itself reads the gyro, and GYRO chooses the source of its heading.
FOR_CLIENT = 1


def is_for_client(identity: RobotIdentity) -> bool:
    """Return whether the robot has a gyro that the client has to read."""
    return identity.config is not None and identity.config.has_gyro == FOR_CLIENT


class GyroReader:
    """Turns GYROpacs into turn rates. It learns the zero of the gyro while the robot stands.

    Args:
        factor: how far this robot turns for each turn that its gyro measures; see RobotModel.
    """

    def __init__(self, factor: float = 1.0) -> None:
        self._rad_s_per_unit = RAD_S_PER_UNIT * factor
        self._centre = NOMINAL_CENTRE
        self._at_rest = 0

    def rate(self, packet: p2os.Gyro, standing: bool) -> Optional[float]:
        """Return the mean turn rate (rad/s, counter-clockwise) of one packet; None for a packet without readings.

        ``standing`` is True when the wheels do not turn. Then the readings also correct the zero of the gyro.
        """
        rates = [reading.rate for reading in packet.readings]
        if not rates:
            return None
        for rate in rates:
            if standing and abs(rate - NOMINAL_CENTRE) <= NEAR_CENTRE:
                self._at_rest = min(self._at_rest + 1, MOST_AT_REST)
                self._centre += (rate - self._centre) / self._at_rest
        return (self._centre - sum(rates) / len(rates)) * self._rad_s_per_unit
