"""A scan as the numbers of a sensor_msgs/LaserScan. Pure: no ROS, no clock (laser sheet 1.7, 1.8, 4.1; REP 103, 117).

The angles go counter-clockwise about the z axis of the laser's frame, which points up: 0 is straight ahead, and the
first ray is the rightmost. A laser that hangs upside down measures from the robot's left to its right. Either its frame
hangs with it (then nothing is to be done here: z points down, and the values are as they are), or its frame is upright,
and its values are put into the opposite order. Never both.

The laser fires one ray each 37 microseconds. Neighbours of a scan in steps of 0.5 or 0.25 degrees are not of one turn
of the mirror, so their times are in no order. Nor are they when the values were put into the opposite order. Then the
increment of time is 0: all rays count as fired with the first one.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from ..lms2xx import MEASURING_MODES, RAY_S, farthest_m, ranges_m, reflector_levels
from .session import ScanHeard

NEAREST = 0.05
"""`ScanNumbers.range_min` (m). SICK says 0, and states accuracy from 1 m on: this number is invented."""
BELOW_MAX = 0.02
"""What is given for "no echo" if it must be a number: `range_max` less this (m). gmapping clears the floor along a ray
that is shorter than `range_max` - 0.01 (laser sheet 4.2)."""


class ScanNumbers(NamedTuple):
    """The numbers of a LaserScan, in SI units.

    Attributes:
        first_ray: when the first of all rays was fired (s, on the clock of the session).
        angle_min, angle_max, angle_increment: of the first ray, of the last one, and between two (rad).
        time_increment: from one ray to the next (s); 0 if they were fired in another order.
        scan_time: from one scan to the next (s), as the speed of the line allows it.
        range_min, range_max: what is not between these is no distance (m).
        ranges: one for each ray (m), float32: infinity where no echo came back, NaN where the laser could not measure.
        intensities: level of a reflector for each ray, float32; empty if the measuring mode tells none.
    """

    first_ray: float
    angle_min: float
    angle_max: float
    angle_increment: float
    time_increment: float
    scan_time: float
    range_min: float
    range_max: float
    ranges: Any
    intensities: Any


def numbers_of(heard: ScanHeard, inverted: bool = False, no_echo_is_max: bool = False) -> ScanNumbers:
    """Return the numbers of a scan.

    Args:
        heard: the scan.
        inverted: the laser hangs upside down, and its frame is upright.
        no_echo_is_max: give a little less than `range_max` instead of infinity.
    """
    variant, configuration = heard.info.variant, heard.info.configuration
    mode = MEASURING_MODES[configuration.measuring_mode]
    ranges, intensities = ranges_m(heard.scan, mode), reflector_levels(heard.scan, mode)
    farthest = farthest_m(mode, heard.scan.unit)
    if no_echo_is_max:
        ranges[np.isposinf(ranges)] = farthest - BELOW_MAX
    if inverted:
        ranges, intensities = ranges[::-1], intensities[::-1]
    return ScanNumbers(
        first_ray=heard.first_ray,
        angle_min=variant.first_angle_rad,
        angle_max=variant.first_angle_rad + math.radians(variant.angle_deg),
        angle_increment=variant.step_rad,
        time_increment=RAY_S if variant.turns == 1 and not inverted else 0.0,
        scan_time=heard.info.scan_time,
        range_min=NEAREST,
        range_max=farthest,
        ranges=ranges,
        intensities=intensities)
