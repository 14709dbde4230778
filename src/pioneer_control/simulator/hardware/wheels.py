"""The wheels: how far the firmware thinks they turn, what their encoders count, and how far the body really goes. And
the robot's own pose, which the robot adds up step by step.

Lengths are metres, angles radians, counter-clockwise positive. The firmware counts ticks of the encoders, so its
calibration (TicksMM, RevCount) decides how far the wheels turn. Real wheels are not what the firmware takes them for,
and they slip.
"""

import math
import random
from typing import Tuple

from ...robots import RobotModel
from ..world.poses import Heading, Pose, along_arc
from .robot_numbers import WheelNumbers

REV_COUNT = 16570
"""RevCount at power-on: encoder counts of a whole turn of the robot."""
WIDEST_DRAW = math.sqrt(3.0)
"""Half the width of an even distribution whose standard deviation is 1."""

Motion = Tuple[float, float]
"""A distance (m) and a turn (rad)."""


class Wheels:
    """The wheels of one robot.

    Attributes:
        ticks_per_mm, rev_count: the firmware's calibration: encoder ticks of a mm, and of a whole turn of the robot.
    """

    def __init__(self, model: RobotModel, ticks_per_mm: int):
        self._model = model
        self._true_ticks_per_mm = ticks_per_mm
        self.restart()
        self.reset()

    def reset(self) -> None:
        """Take the calibration of power-on."""
        self.ticks_per_mm, self.rev_count = self._true_ticks_per_mm, REV_COUNT

    def restart(self) -> None:
        """Count from 0."""
        self._left_mm = self._right_mm = 0.0

    @property
    def ticks(self) -> Tuple[int, int]:
        """Encoder ticks of the left and the right wheels since power-on."""
        return round(self._left_mm * self._true_ticks_per_mm), round(self._right_mm * self._true_ticks_per_mm)

    def turn(self, distance: float, turn: float, dt: float) -> Tuple[Motion, Motion]:
        """What the wheels do in a step of `dt` seconds for which the drives want `distance` and `turn`.

        Returns:
            What the firmware, which counts ticks, thinks that they do: all that is wanted, or what the motors can do.
            And what they really do.
        """
        turned = self._turned(distance, turn)
        ahead, around = self._model.max_linear * dt, self._model.max_angular * dt
        if abs(turned[0]) > ahead or abs(turned[1]) > around:
            distance *= min(1.0, ahead / (abs(turned[0]) or ahead))
            turn *= min(1.0, around / (abs(turned[1]) or around))
            turned = self._turned(distance, turn)
        return (distance, turn), turned

    def _turned(self, distance: float, turn: float) -> Motion:
        """How far the wheels turn when the firmware thinks that it is `distance` and `turn`."""
        return distance * self.ticks_per_mm / self._true_ticks_per_mm, turn * self.rev_count / REV_COUNT

    def count(self, distance: float, turn: float) -> None:
        """Count a step of the wheels."""
        difference_mm = turn / self._model.diff_rad_per_mm
        self._left_mm += distance * 1000.0 - difference_mm
        self._right_mm += distance * 1000.0 + difference_mm


class WheelErrors:
    """How far the body really goes when the wheels of one robot turn; exactly as far when all numbers are 0.

    Args:
        numbers: sizes of the errors.
        rad_per_metre: turn of the robot for a metre that each wheel goes more or less than the middle.
        seed: of slip and noise.
    """

    def __init__(self, numbers: WheelNumbers, rad_per_metre: float, seed: int):
        self._left_scale = (1.0 + numbers.larger) * (1.0 - numbers.right_larger / 2.0)
        self._right_scale = (1.0 + numbers.larger) * (1.0 + numbers.right_larger / 2.0)
        self._rad_per_metre = rad_per_metre
        self._really_rad_per_metre = rad_per_metre / (1.0 + numbers.wider_apart)
        self._slip, self._noise = numbers.slip, numbers.noise
        self._random = random.Random("wheels %s" % seed)
        self._none = not any((numbers.larger, numbers.right_larger, numbers.wider_apart, numbers.slip, numbers.noise))

    def moved(self, distance: float, turn: float) -> Motion:
        """How far the body goes and turns while the wheels turn as for `distance` and `turn`."""
        if self._none:
            return distance, turn
        difference = turn / self._rad_per_metre
        left = self._on_floor((distance - difference) * self._left_scale)
        right = self._on_floor((distance + difference) * self._right_scale)
        return (left + right) / 2.0, (right - left) / 2.0 * self._really_rad_per_metre

    def _on_floor(self, way: float) -> float:
        """The way (m) of one wheel over the floor while it rolls `way`.

        Noise grows with the root of the way, in steps of any size.
        """
        if self._slip:
            way *= 1.0 - self._random.uniform(0.0, self._slip)
        if self._noise:
            way += self._random.uniform(-WIDEST_DRAW, WIDEST_DRAW) * self._noise * math.sqrt(abs(way))
        return way


class DeadReckoning:
    """The pose that a robot adds up step by step.

    Args:
        origin: where it stands (m, rad; map frame) while it begins.

    Attributes:
        origin: as the argument.
        pose: x, y (m) and heading (rad, not wrapped) since then, at first 0, 0, 0.
    """

    def __init__(self, origin: Pose):
        self.origin = origin
        self.pose: Pose = (0.0, 0.0, 0.0)
        self._heading = Heading()

    def add(self, distance: float, turn: float) -> None:
        """Add a step: a distance (m) and a turn (rad), both even."""
        self.pose = along_arc(self.pose, distance, turn, self._heading.unit)
