"""Which rays make a scan, and when each of them is fired (laser sheet 1.7, 1.8).

The mirror turns 75 times a second. In each turn the laser fires rays 1 degree apart, from right to left. A finer scan
takes several turns. The rays of each turn are shifted by one step, and the values are sorted by angle.
A turn begins when its first ray is fired.
"""

import functools
import math
from typing import NamedTuple, Tuple

from ...lms2xx import RAY_S, TURN_S, Variant

QUARTERS = 4
"""Quarters of a degree in a degree. Partial scans count their shift in quarters."""


class RayPlan(NamedTuple):
    """The rays of one scan, sorted by angle from right to left.

    Attributes:
        angles: direction of each ray (rad, frame of the laser: 0 is straight ahead, positive is left).
        after: time (s) from the beginning of the scan's first turn to the ray.
        turns: number of turns that the scan takes.
    """

    angles: Tuple[float, ...]
    after: Tuple[float, ...]
    turns: int


@functools.lru_cache(maxsize=None)
def complete_scan(variant: Variant) -> RayPlan:
    """Return the rays of a complete scan."""
    numbers = [divmod(index, variant.turns) for index in range(variant.values)]
    return RayPlan(
        tuple(variant.first_angle_rad + index * variant.step_rad for index in range(variant.values)),
        tuple(turn * TURN_S + degree * RAY_S for degree, turn in numbers),
        variant.turns)


@functools.lru_cache(maxsize=None)
def partial_scan(quarter: int) -> RayPlan:
    """Return the rays of one turn. They always cover the full 180 degrees (laser sheet 1.7).

    Args:
        quarter: quarters of a degree by which the rays are shifted to the left, 0..3.
    """
    count = 181 if quarter == 0 else 180
    return RayPlan(tuple(math.radians(degree - 90.0 + quarter / QUARTERS) for degree in range(count)),
                   tuple(degree * RAY_S for degree in range(count)), 1)


def quarter_of_turn(variant: Variant, turn: int) -> int:
    """Return the quarters of a degree by which the rays of a turn are shifted.

    Args:
        variant: how wide and how fine the laser looks.
        turn: number of the turn in the scan, from 0 on.
    """
    return turn * variant.step_hundredths * QUARTERS // 100
