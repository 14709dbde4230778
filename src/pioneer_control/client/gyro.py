"""A gyro that the client has to read (CONFIGpac: has_gyro 1; protocol 5.6): raw readings to a turn rate."""

import math
from typing import Optional

from .. import p2os
from .identity import RobotIdentity

# volts, full scale, and the calibration that all models share.
RAD_S_PER_UNIT = math.radians(5 / 1023 * 300 / 2.5 * 1.626)
NOMINAL_CENTRE = 512.0      # what a gyro at rest reads, more or less
NEAR_CENTRE = 30.0          # how much more or less; beyond it, something turns the robot while its wheels stand
MOST_AT_REST = 200          # readings (5 s) over which the centre is averaged
# has_gyro in CONFIGpac; from 2 on the robot reads it, and GYRO chooses what its heading is made of.
FOR_CLIENT = 1


def is_for_client(identity: RobotIdentity) -> bool:
    """Whether a gyro is fitted that the client has to read."""
    return identity.config is not None and identity.config.has_gyro == FOR_CLIENT


class GyroReader:
    """Turns GYROpacs into turn rates; learns from a standing robot what the gyro reads at rest."""

    def __init__(self) -> None:
        self._centre = NOMINAL_CENTRE
        self._at_rest = 0

    def rate(self, packet: p2os.Gyro, standing: bool) -> Optional[float]:
        """The mean turn rate (rad/s, counter-clockwise) of one packet; None for an empty one.

        ``standing``: the wheels do not turn.
        """
        rates = [reading.rate for reading in packet.readings]
        if not rates:
            return None
        for rate in rates:
            if standing and abs(rate - NOMINAL_CENTRE) <= NEAR_CENTRE:
                self._at_rest = min(self._at_rest + 1, MOST_AT_REST)
                self._centre += (rate - self._centre) / self._at_rest
        return (self._centre - sum(rates) / len(rates)) * RAD_S_PER_UNIT
