"""The sonar arrays: which transducer fires when, and what it hears in the world.

Arrays of eight fire in step, one transducer each per cycle, in the order of their sequence.
"""

import functools
import math
import random
from typing import Dict, Iterable, List, Optional, Sequence, Set, Tuple

from ...robots import ARRAY_SIZE, Transducer
from ..world.poses import Heading, Point, Pose, unit
from ..world.world import World
from .body import Body
from .robot_numbers import SonarNumbers

LONGEST_SEQUENCE = 16
"""Firings that the sequence of one array can name (ARCOS manual)."""

Reading = Tuple[int, float]


Mount = Tuple[float, float, float, Point, Point]
"""Where on a robot a transducer sits and looks: x, y, heading (m, rad, base_link).

And the unit vectors along the right and the left edge of its cone.
"""


class Sonar:
    """The transducers that are fitted to a robot, and their firing.

    Args:
        transducers: as `RobotModel.sonar` lists them.
        numbers: ranges, cone, specular loss, cycle and noise.
        world: where it hears.
        noise: every range is off by up to this much (m).
        seed: of the noise.
        body: that it is on, which it does not hear.

    Attributes:
        firing: numbers (from 0) of those arrays that are switched on.
        dead: numbers of transducers that fire and hear nothing.
        cycle_us: time between two firings of an array.
    """

    def __init__(
        self, transducers: Sequence[Transducer], numbers: SonarNumbers, world: World, noise: float, seed: int,
        body: Optional[Body] = None,
    ):
        half_width = math.radians(numbers.cone_deg) / 2.0
        self._mounts = _mounts(tuple(transducers), half_width)
        self._numbers, self._noise, self._body = numbers, noise, body
        cosine, sine = unit(math.radians(numbers.specular_deg))
        slant = sine / cosine if numbers.specular_deg < 90.0 else math.inf
        self._ear = world.ear(half_width, numbers.maximum, slant)
        self._random = random.Random(seed)
        self._heading = Heading()
        self._readings: List[Reading] = []
        self.firing: Sequence[int] = ()
        self.dead: Set[int] = set()
        self.reset()

    def reset(self) -> None:
        """Take the sequence and cycle of power-on: every fitted transducer once, in the order of the numbers."""
        self.cycle_us = self._numbers.cycle_ms * 1000
        self._sequences = {array: [number for number in sorted(self._mounts) if number // ARRAY_SIZE == array]
                           for array in sorted({number // ARRAY_SIZE for number in self._mounts})}
        self._fired = 0
        self._next_us = 0

    def switch(self, on: bool, now_us: int, arrays: Optional[Sequence[int]] = None) -> None:
        """Start or stop firing some arrays, all if None.

        When no array fired before, they begin one cycle from now, with the first transducers of their sequences.
        """
        named = set(self._sequences if arrays is None else arrays)
        before = self.firing
        self.firing = [array for array in self._sequences if (on if array in named else array in before)]
        if self.firing and not before:
            self._fired = 0
            self._next_us = now_us + self.cycle_us
        if not self.firing:
            self._readings.clear()

    def set_sequence(self, numbers: Sequence[int], now_us: int) -> None:
        """Fire these transducers (numbers from 0, repeats allowed) in this order; arrays not named keep theirs.

        No numbers at all switch the sonar off and keep every sequence.
        """
        if not numbers:
            self.switch(False, now_us)
            return
        for array in {number // ARRAY_SIZE for number in numbers} & set(self._sequences):
            self._sequences[array] = [
                number for number in numbers if number // ARRAY_SIZE == array and number in self._mounts
            ][:LONGEST_SEQUENCE]

    def deafen(self, numbers: Iterable[int]) -> None:
        """Let these transducers (numbers from 0), and no others, hear nothing."""
        self.dead = set(numbers)

    def step(self, now_us: int, pose: Pose) -> None:
        """Fire what is due at `now_us`, from a robot at `pose` (map frame)."""
        while self.firing and self._next_us <= now_us:
            forward = self._heading.unit(pose[2])
            for array in self.firing:
                sequence = self._sequences[array]
                if sequence:
                    number = sequence[self._fired % len(sequence)]
                    self._readings.append((number, self._fire(number, pose, forward)))
            self._fired += 1
            self._next_us += self.cycle_us

    def take_readings(self, most: int) -> List[Reading]:
        """Number and range (m) of every firing since the last call, oldest first; only the newest `most` of them."""
        readings, self._readings = self._readings[-most:], []
        return readings

    def _fire(self, number: int, pose: Pose, forward: Point) -> float:
        """The range (m) that a transducer of a robot at `pose`, which looks `forward`, reports.

        The electronics add noise to an echo, and report no less than the minimum; the maximum where there is no echo.
        """
        maximum = self._numbers.maximum
        if number in self.dead:
            return maximum
        x, y, heading, (right_x, right_y), (left_x, left_y) = self._mounts[number]
        cosine, sine = forward
        right = right_x * cosine - right_y * sine, right_x * sine + right_y * cosine
        left = left_x * cosine - left_y * sine, left_x * sine + left_y * cosine
        x, y = pose[0] + x * cosine - y * sine, pose[1] + x * sine + y * cosine
        distance = self._ear.echo(x, y, pose[2] + heading, right, left, self._body)
        if distance < maximum and self._noise:
            distance += self._random.uniform(-self._noise, self._noise)
        return max(self._numbers.minimum, min(distance, maximum))


@functools.lru_cache(maxsize=None)
def _mounts(transducers: Sequence[Transducer], half_width: float) -> Dict[int, Mount]:
    """How transducers sit, by number: the same for all robots of a model, so that many of them need not be read from
    memory again and again.
    """
    return {number: (x, y, to, unit(to - half_width), unit(to + half_width)) for number, x, y, to in transducers}
