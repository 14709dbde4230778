"""How far the body really goes when the wheels turn: wheels are not what the firmware takes them for, and they slip.

Lengths are metres, angles radians, counter-clockwise positive.
"""

import math
import random
from typing import Tuple

WIDEST_DRAW = math.sqrt(3.0)
"""Half the width of an even distribution whose standard deviation is 1."""


class WheelErrors:
    """The errors of one robot's wheels; none at all when all numbers are 0.

    :param numbers: sizes of the errors (`WheelNumbers`).
    :param rad_per_metre: turn of the robot for a metre that each wheel goes more or less than the middle.
    :param seed: of slip and noise.
    """

    def __init__(self, numbers, rad_per_metre: float, seed: int):
        self._left_scale = (1.0 + numbers.larger) * (1.0 - numbers.right_larger / 2.0)
        self._right_scale = (1.0 + numbers.larger) * (1.0 + numbers.right_larger / 2.0)
        self._rad_per_metre = rad_per_metre
        self._really_rad_per_metre = rad_per_metre / (1.0 + numbers.wider_apart)
        self._slip, self._noise = numbers.slip, numbers.noise
        self._random = random.Random("wheels %s" % seed)
        self._none = not any((numbers.larger, numbers.right_larger, numbers.wider_apart, numbers.slip, numbers.noise))

    def moved(self, distance: float, turn: float) -> Tuple[float, float]:
        """How far the body goes and turns while the wheels turn as for `distance` and `turn`."""
        if self._none:
            return distance, turn
        difference = turn / self._rad_per_metre
        left = self._on_floor((distance - difference) * self._left_scale)
        right = self._on_floor((distance + difference) * self._right_scale)
        return (left + right) / 2.0, (right - left) / 2.0 * self._really_rad_per_metre

    def _on_floor(self, way: float) -> float:
        """The way of one wheel over the floor, of what it has rolled. Noise grows with the root of the way, however it is cut in steps."""
        if self._slip:
            way *= 1.0 - self._random.uniform(0.0, self._slip)
        if self._noise:
            way += self._random.uniform(-WIDEST_DRAW, WIDEST_DRAW) * self._noise * math.sqrt(abs(way))
        return way
