"""How fast an LMS2xx measures and sends, and when it fired a ray (laser sheet 1.8).

The mirror turns 75 times a second, and fires a ray at each whole degree. A finer scan takes several turns, each shifted
by a part of a degree; its values are sorted by angle, so neighbours were measured a turn apart. A complete scan is sent
after its last turn. The laser measures on meanwhile, and what it finished while the line was busy is lost: between two
scans that it sends passes a whole number of scans.
"""

import math
from functools import lru_cache
from typing import NamedTuple, Tuple

from .scans import MOST_VALUES

TURN_S = 1.0 / 75.0
"""Time of one turn of the mirror."""
RAY_S = TURN_S / 360.0
"""Time from one ray to the next in one turn, one degree farther (laser sheet 1.8: 37.0 us)."""
BITS_OF_A_BYTE = 10
"""On the line: a start bit, eight of data, a stop bit."""
_OTHER_BYTES = 10
"""Bytes of the telegram of a scan besides its values: six around, command, the word in front, and the status."""


class Variant(NamedTuple):
    """How wide a laser looks, and how fine.

    Attributes:
        angle_deg: between the first and the last ray.
        step_hundredths: hundredths of a degree between two rays.
    """

    angle_deg: int
    step_hundredths: int

    @property
    def is_possible(self) -> bool:
        """Whether a laser can look so, also one of a type that is not in `VARIANTS`."""
        return 0 < self.angle_deg <= 180 and self.step_hundredths in (25, 50, 100) and self.values <= MOST_VALUES

    @property
    def values(self) -> int:
        """The number of values of a complete scan."""
        return self.angle_deg * 100 // self.step_hundredths + 1

    @property
    def turns(self) -> int:
        """The number of turns of the mirror that a complete scan takes."""
        return 100 // self.step_hundredths

    @property
    def first_angle_rad(self) -> float:
        """The angle of the first ray, which is the rightmost; straight ahead is 0, positive is left."""
        return -math.radians(self.angle_deg) / 2.0

    @property
    def step_rad(self) -> float:
        """The angle between two rays."""
        return math.radians(self.step_hundredths / 100.0)


VARIANTS: Tuple[Variant, ...] = tuple(Variant(angle, step) for angle, step in (
    (180, 100), (180, 50), (100, 100), (100, 50), (100, 25)))
"""All variants of an LMS2xx."""


def scan_bytes(values: int, indices: bool = False) -> int:
    """Return the length (bytes) of the telegram of a scan."""
    return 2 * values + _OTHER_BYTES + (2 if indices else 0)


def time_on_line(count: int, baud: int) -> float:
    """Return the time (s) that some bytes take on the line."""
    return count * BITS_OF_A_BYTE / baud


@lru_cache(maxsize=None)
def scan_time(variant: Variant, baud: int, indices: bool = False) -> float:
    """Return the time (s) from one scan to the next in a stream."""
    sending = time_on_line(scan_bytes(variant.values, indices), baud)
    scan = variant.turns * TURN_S
    return math.ceil(sending / scan - 1e-9) * scan


def first_ray_before_first_byte(variant: Variant) -> float:
    """Return the time (s) from the firing of a complete scan's first ray to the first byte of its telegram."""
    return variant.turns * TURN_S
