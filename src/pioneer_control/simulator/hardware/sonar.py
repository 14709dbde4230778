"""The sonar arrays: which transducer fires when, and which range it measures in the world.

An array has eight transducers. All arrays fire at the same time, one transducer of each array per cycle, in the order
of the array's sequence.
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
"""Largest number of firings in the sequence of one array (ARCOS manual)."""

Reading = Tuple[int, float]


Mount = Tuple[float, float, float, Point, Point]
"""Mounting pose of a transducer on a robot: x, y, heading (m, rad; base_link).

It ends with the unit vectors along the right edge and the left edge of the transducer's cone (base_link).
"""


class Sonar:
    """The sonar transducers of one robot, and the order in which they fire.

    Args:
        transducers: the fitted transducers, from `RobotModel.sonar`.
        numbers: ranges, cone, specular angle and cycle time.
        world: world in which the ranges are measured.
        noise: largest random error of a range (m).
        seed: seed of the noise.
        body: body that carries the transducers. They do not detect it.

    Attributes:
        firing: numbers (from 0) of the arrays that are switched on.
        dead: numbers (from 0) of the transducers that fire but never detect an echo.
        cycle_us: time between two firings of an array (microseconds).
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
        """Set sequence and cycle time to their power-on values.

        The power-on sequence fires every fitted transducer once, in the order of their numbers.
        """
        self.cycle_us = self._numbers.cycle_ms * 1000
        self._sequences = {array: [number for number in sorted(self._mounts) if number // ARRAY_SIZE == array]
                           for array in sorted({number // ARRAY_SIZE for number in self._mounts})}
        self._fired = 0
        self._next_us = 0

    def switch(self, on: bool, now_us: int, arrays: Optional[Sequence[int]] = None) -> None:
        """Switch arrays on or off. If no array was on before, the first firing is one cycle after `now_us`.

        Args:
            on: whether to switch the arrays on.
            now_us: present simulated time (microseconds).
            arrays: numbers (from 0) of the arrays to switch, all if None.
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
        """Set the order in which transducers fire. Arrays without a transducer in `numbers` keep their sequence.

        If `numbers` is empty, the sonar is switched off, and all arrays keep their sequences.

        Args:
            numbers: transducers (from 0) in the order of firing. A transducer may appear several times.
            now_us: present simulated time (microseconds).
        """
        if not numbers:
            self.switch(False, now_us)
            return
        for array in {number // ARRAY_SIZE for number in numbers} & set(self._sequences):
            self._sequences[array] = [
                number for number in numbers if number // ARRAY_SIZE == array and number in self._mounts
            ][:LONGEST_SEQUENCE]

    def deafen(self, numbers: Iterable[int]) -> None:
        """Make exactly these transducers (numbers from 0) dead, so that they never detect an echo."""
        self.dead = set(numbers)

    def step(self, now_us: int, pose: Pose) -> None:
        """Fire all transducers that are due until `now_us` (microseconds), on a robot at `pose` (m, rad; map frame)."""
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
        """Return the newest firings since the last call, at most `most`, oldest first. All firings are then forgotten.

        Returns:
            Number (from 0) of the transducer, and range (m), of each firing.
        """
        readings, self._readings = self._readings[-most:], []
        return readings

    def _fire(self, number: int, pose: Pose, forward: Point) -> float:
        """Return the range (m) that a transducer reports: the distance of the nearest echo, with noise.

        The range is never less than the minimum. Without an echo, it is the maximum.

        Args:
            number: number of the transducer, from 0.
            pose: pose of the robot (m, rad; map frame).
            forward: unit vector of the robot's heading (map frame).
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
        if distance >= maximum:
            return maximum
        if self._noise:
            distance += self._random.uniform(-self._noise, self._noise)
        return max(self._numbers.minimum, min(distance, maximum))


@functools.lru_cache(maxsize=None)
def _mounts(transducers: Sequence[Transducer], half_width: float) -> Dict[int, Mount]:
    """Return the mounts of transducers, by number. All robots of a model share one result, which saves memory.

    Args:
        transducers: transducers, from `RobotModel.sonar`.
        half_width: angle (rad) between the axis of a cone and its edge.
    """
    return {number: (x, y, to, unit(to - half_width), unit(to + half_width)) for number, x, y, to in transducers}
