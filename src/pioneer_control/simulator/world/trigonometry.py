"""Trigonometry that rounds the same on every computer, for everything whose result reaches the wire.

Made of + - * / and sqrt alone, which IEEE 754 defines to the last bit; what :mod:`math` and numpy take from the C
library may differ in that bit from one Debian to the next. Right to 1e-13 for angles up to a million radians either
way.
"""

import functools
import math
from typing import Callable, Tuple

_QUARTERS_PER_RADIAN = 2.0 / math.pi
_QUARTER_HIGH = float.fromhex("0x1.921fb544p+0")  # of a quarter turn (rad) the first 33 bits: its multiples are exact
_QUARTER_LOW = float.fromhex("0x1.0b4611a626331p-34")  # and the rest


def unit(angle: float) -> Tuple[float, float]:
    """Cosine and sine of an angle (rad): the unit vector in its direction."""
    quarters = math.floor(angle * _QUARTERS_PER_RADIAN + 0.5)
    x = (angle - quarters * _QUARTER_HIGH) - quarters * _QUARTER_LOW
    z = x * x
    sine = x + x * z * (-1 / 6 + z * (1 / 120 + z * (-1 / 5040
                                                     + z * (1 / 362880 + z * (-1 / 39916800 + z * (1 / 6227020800))))))
    cosine = 1.0 + z * (-0.5
                        + z * (1 / 24
                               + z * (-1 / 720
                                      + z * (1 / 40320 + z * (-1 / 3628800 + z * (1 / 479001600 - z / 87178291200))))))
    quarters &= 3
    if quarters == 0:
        return cosine, sine
    if quarters == 1:
        return -sine, cosine
    if quarters == 2:
        return -cosine, -sine
    return sine, -cosine


def heading_unit() -> Callable[[float], Tuple[float, float]]:
    """A `unit` that remembers its last answer, for a heading that stays the same for long: of what stands or goes
    straight on.
    """
    return functools.lru_cache(maxsize=1)(unit)


def hypot(x: float, y: float) -> float:
    """Length of a vector that is neither tiny nor huge."""
    return math.sqrt(x * x + y * y)
