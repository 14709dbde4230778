"""Scans: the reply B0, and what its values mean (laser sheet 1.7).

A scan is seen from above and goes counter-clockwise, as ROS wants it: the first value is of the rightmost ray.
"""

import math
import struct
from functools import lru_cache
from typing import Any, Dict, NamedTuple, Optional, Tuple

import numpy as np

from ..wire_fields import BYTE, UINT16, TooShort, checked_integer, packed
from .configuration import MeasuringMode, Unit

Array = Any     # of numpy

MOST_VALUES = 401
_COUNT_BITS, _QUARTER_SHIFT, _PARTIAL_BIT, _UNIT_SHIFT = 0x3FF, 11, 0x2000, 14
METRES: Dict[int, float] = {Unit.CENTIMETRES: 0.01, Unit.MILLIMETRES: 0.001, Unit.TEN_CENTIMETRES: 0.1}
"""The length (m) of one step of a value."""

CODES: Dict[int, Tuple[float, str]] = {
    -1: (math.inf, "no echo came back"),
    -2: (math.nan, "dazzled"),
    -3: (math.nan, "overflow"),
    -5: (math.nan, "too much noise"),
    -6: (math.nan, "read error"),
    -9: (math.inf, "farther than it measures"),
}
"""What the highest distances of a measuring mode mean, counted from the first number that has too many bits: the range
(m), and words. What stands here and what lies between is no distance.
"""
_LOWEST_CODE = min(CODES)
_CODE_RANGES = np.array([CODES.get(code, (math.nan, ""))[0] for code in range(_LOWEST_CODE, 0)], dtype=np.float32)
DAZZLED = CODES[-2][1]


class Indices(NamedTuple):
    """Two counters behind the values, 0..255. A laser sends them if it is configured so."""

    turn: int
    telegram: int


class RawScan(NamedTuple):
    """The data of reply B0.

    Attributes:
        values: one number for each ray, from right to left, with all bits. What they are is said by the measuring mode,
            which the telegram does not name.
        unit: a `Unit`.
        partial: rays 1 degree apart of one turn of the mirror, of a scan that has several.
        quarter: in a partial scan, the quarters of a degree at which its rays are: 0..3.
        indices: None unless the laser is configured to send them.
    """

    values: Tuple[int, ...]
    unit: int = Unit.MILLIMETRES
    partial: bool = False
    quarter: int = 0
    indices: Optional[Indices] = None


class ScanField:
    """The type of a field that is a scan, at the end of the data."""

    def read(self, data: bytes, at: int) -> Tuple[RawScan, int]:
        """The scan from index `at` on, and the index of the end of the data. Raises TooShort when values are missing.
        """
        word, at = UINT16.read(data, at)
        count = word & _COUNT_BITS
        end = at + 2 * count
        if len(data) < end:
            raise TooShort("%d values need %d bytes, %d left" % (count, 2 * count, len(data) - at))
        indices = Indices(*data[end:end + 2]) if len(data) >= end + 2 else None
        values = struct.unpack_from("<%dH" % count, data, at)
        return RawScan(values, word >> _UNIT_SHIFT, bool(word & _PARTIAL_BIT), word >> _QUARTER_SHIFT & 3,
                       indices), len(data)

    def write(self, value: RawScan, what: str) -> bytes:
        """The bytes of a scan. Raises EncodingError, which names `what`, when it has more than 401 values, or a number
        does not fit.
        """
        count = checked_integer(len(value.values), 0, MOST_VALUES, what + ", number of values")
        unit = checked_integer(value.unit, 0, 3, what + ", unit")
        quarter = checked_integer(value.quarter, 0, 3, what + ", quarter")
        word = count | (_PARTIAL_BIT if value.partial else 0) | quarter << _QUARTER_SHIFT | unit << _UNIT_SHIFT
        numbers = packed(struct.Struct("<H%dH" % count), (word, *value.values))
        if numbers is None:     # one does not fit: find out which
            numbers = b"".join(UINT16.write(each, "%s, value %d" % (what, index))
                               for index, each in enumerate(value.values))
        return numbers + b"".join(BYTE.write(each, what + ", index") for each in value.indices or ())


def ranges_m(scan: RawScan, mode: MeasuringMode) -> Array:
    """Return the distances (m) of a scan as float32: infinite where no echo came back or from too far away, NaN where
    the laser could not measure (REP 117).
    """
    return _range_table(mode.distance_bits, scan.unit)[np.array(scan.values, dtype=np.intp)]


@lru_cache(maxsize=None)
def _range_table(distance_bits: int, unit: int) -> Array:
    """Return the distance (m) for each number that a ray can have, as float32."""
    steps = np.arange(1 << 16) & (1 << distance_bits) - 1
    ranges = (steps * METRES[unit]).astype(np.float32)
    if distance_bits < 16:      # else all its bits are the distance: it has no codes
        is_code = steps >= (1 << distance_bits) + _LOWEST_CODE
        ranges[is_code] = _CODE_RANGES[steps[is_code] - (1 << distance_bits)]
    return ranges


def codes_in(scan: RawScan, mode: MeasuringMode) -> Dict[str, int]:
    """Return how many rays of a scan have each of `CODES` instead of a distance, by its words. Codes that none has, and
    those that nobody has explained, are left out.
    """
    if mode.distance_bits == 16:
        return {}
    steps = np.array(scan.values, dtype=np.int32) & (1 << mode.distance_bits) - 1
    counts = {words: int(np.count_nonzero(steps == (1 << mode.distance_bits) + code))
              for code, (_, words) in CODES.items()}
    return {words: count for words, count in counts.items() if count}


def reflector_levels(scan: RawScan, mode: MeasuringMode) -> Array:
    """Return the level of a reflector at each ray as float32, 0 where none is; empty when the mode tells none."""
    if not mode.reflector_bits:
        return np.empty(0, dtype=np.float32)
    return (np.array(scan.values, dtype=np.int32) >> 16 - mode.reflector_bits).astype(np.float32)


def farthest_m(mode: MeasuringMode, unit: int) -> float:
    """Return the distance (m) that is just too far for a measuring mode: its full scale."""
    return ((1 << mode.distance_bits) + _LOWEST_CODE) * METRES[unit]
