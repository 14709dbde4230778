"""Distances as the numbers in a telegram (laser sheet 1.5, 1.7). This is the way back from `lms2xx.ranges_m`."""

from typing import Tuple

import numpy as np

from ...lms2xx import MeasuringMode, Unit
from ...lms2xx.scans import METRES
from .optics import Measured

NO_ECHO, DAZZLED, TOO_FAR = -1, -2, -9
"""Keys of `lms2xx.CODES`."""
WORD_BITS = 16


def raw_values(measured: Measured, mode: MeasuringMode, unit: int) -> Tuple[int, ...]:
    """Return the values of a scan. A reflector has the highest level that the mode can say. All bits of fields are 0.

    A mode with 16 bits for the distance has no codes. Its largest number then stands for all of them [inv].

    Args:
        measured: the scan.
        mode: what the bits of a value are.
        unit: the `Unit` of the values, to which the distances are rounded.
    """
    end = 1 << mode.distance_bits
    if mode.distance_bits == 16:
        no_echo = dazzled = too_far = end - 1
    else:
        no_echo, dazzled, too_far = end + NO_ECHO, end + DAZZLED, end + TOO_FAR
    steps = np.minimum(np.rint(measured.distances / METRES[Unit(unit)]), too_far)
    steps = np.where(measured.dazzled, dazzled, np.where(np.isinf(measured.distances), no_echo, steps)).astype(int)
    highest_level = ((1 << mode.reflector_bits) - 1) << (WORD_BITS - mode.reflector_bits)
    return tuple((steps | np.where(measured.reflectors & ~measured.dazzled, highest_level, 0)).tolist())
