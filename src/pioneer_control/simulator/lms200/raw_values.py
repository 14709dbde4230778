"""Distances as the numbers in a telegram (laser sheet 1.5, 1.7). This is the way back from `lms2xx.ranges_m`."""

from typing import Any, Tuple

import numpy as np

from ...lms2xx import MeasuringMode, Unit
from ...lms2xx.scans import METRES

NO_ECHO, TOO_FAR = -1, -9
"""Keys of `lms2xx.CODES`."""


def raw_values(distances: Any, mode: MeasuringMode, unit: int) -> Tuple[int, ...]:
    """Return the values of a scan. All bits above the distance are 0: the world knows no reflectors and no fields.

    A mode with 16 bits for the distance has no codes. Its largest number then stands for "no echo" [inv].

    Args:
        distances: array of distances (m), at least 0; infinite where no echo came back.
        mode: what the bits of a value are.
        unit: the `Unit` of the values, to which the distances are rounded.
    """
    end = 1 << mode.distance_bits
    if mode.distance_bits == 16:
        no_echo = too_far = end - 1
    else:
        no_echo, too_far = end + NO_ECHO, end + TOO_FAR
    steps = np.minimum(np.rint(distances / METRES[Unit(unit)]), too_far)
    return tuple(np.where(np.isinf(distances), no_echo, steps).astype(int).tolist())
