"""The wheels: how far the firmware assumes that they turn, their encoder counts, and how far the body really moves.
Also the odometry of the robot.

Lengths are in metres, angles in radians, counter-clockwise positive. The firmware controls the wheels by encoder ticks,
so its calibration (TicksMM, RevCount) decides how far the wheels really turn. Real wheels differ from this calibration
in size and distance, and they slip.
"""

import math
import random
from typing import Tuple

from ...robots import RobotModel
from ..world.poses import Heading, Pose, along_arc, compose, relative
from .robot_numbers import WheelNumbers

REV_COUNT = 16570
"""RevCount at power-on: encoder ticks of one full turn of the robot."""
PATCH = 0.25
"""Way (m) after which a wheel that lost its grip loses another share."""
WIDEST_DRAW = math.sqrt(3.0)
"""Half the width of a uniform distribution whose standard deviation is 1."""

Motion = Tuple[float, float]
"""A distance (m) and a turn (rad)."""


class Wheels:
    """The wheels of one robot, with their encoders and their motors' speed limits.

    Args:
        model: model of the robot.
        ticks_per_mm: real number of encoder ticks per millimetre.

    Attributes:
        ticks_per_mm: calibration of the firmware (TicksMM): encoder ticks per millimetre.
        rev_count: calibration of the firmware (RevCount): encoder ticks of one full turn of the robot.
    """

    def __init__(self, model: RobotModel, ticks_per_mm: int):
        self._model = model
        self._true_ticks_per_mm = ticks_per_mm
        self.restart()
        self.reset()

    def reset(self) -> None:
        """Set the calibration of the firmware to its power-on values."""
        self.ticks_per_mm, self.rev_count = self._true_ticks_per_mm, REV_COUNT

    def restart(self) -> None:
        """Set the encoder counts to 0."""
        self._left_mm = self._right_mm = 0.0

    @property
    def ticks(self) -> Tuple[int, int]:
        """Encoder ticks of the left and the right wheels since power-on."""
        return round(self._left_mm * self._true_ticks_per_mm), round(self._right_mm * self._true_ticks_per_mm)

    def turn(self, distance: float, turn: float, dt: float) -> Tuple[Motion, Motion]:
        """Return how far the wheels turn in one step, limited to what the motors can do.

        Args:
            distance: distance (m) that the drives want, by the firmware's calibration.
            turn: turn (rad) that the drives want, by the firmware's calibration.
            dt: duration of the step (s).

        Returns:
            First the motion by the firmware's calibration, then the real motion.
        """
        turned = self._turned(distance, turn)
        ahead, around = self._model.max_linear * dt, self._model.max_angular * dt
        if abs(turned[0]) > ahead or abs(turned[1]) > around:
            distance *= min(1.0, ahead / (abs(turned[0]) or ahead))
            turn *= min(1.0, around / (abs(turned[1]) or around))
            turned = self._turned(distance, turn)
        return (distance, turn), turned

    def _turned(self, distance: float, turn: float) -> Motion:
        """Convert a motion (m, rad) by the firmware's calibration to the real motion of the wheels."""
        return distance * self.ticks_per_mm / self._true_ticks_per_mm, turn * self.rev_count / REV_COUNT

    def count(self, distance: float, turn: float) -> None:
        """Add the real motion of the wheels in one step (m, rad) to the encoder counts."""
        difference_mm = turn / self._model.diff_rad_per_mm
        self._left_mm += distance * 1000.0 - difference_mm
        self._right_mm += distance * 1000.0 + difference_mm


class WheelErrors:
    """Errors of odometry: the differences between the motion of the wheels and the motion of the body.

    When all numbers are 0, there are no differences.

    Args:
        numbers: sizes of the errors.
        rad_per_metre: turn (rad) of the robot when each right wheel rolls 1 m forward and each left wheel 1 m back.
        seed: seed of the random slip and noise.
    """

    def __init__(self, numbers: WheelNumbers, rad_per_metre: float, seed: int):
        self._left_scale = (1.0 + numbers.larger) * (1.0 - numbers.right_larger / 2.0)
        self._right_scale = (1.0 + numbers.larger) * (1.0 + numbers.right_larger / 2.0)
        self._rad_per_metre = rad_per_metre
        self._really_rad_per_metre = rad_per_metre / (1.0 + numbers.wider_apart)
        self._slip, self._noise = numbers.slip, numbers.noise
        self._left_slip, self._left_loses, self._patch_left = numbers.left_slip, 0.0, 0.0
        self._random = random.Random("wheels %s" % seed)
        self._none = not any((numbers.larger, numbers.right_larger, numbers.wider_apart, numbers.slip,
                              numbers.left_slip, numbers.noise))

    def moved(self, distance: float, turn: float) -> Motion:
        """Return the real motion of the body (m, rad), when the wheels turn as for `distance` (m) and `turn` (rad)."""
        if self._none:
            return distance, turn
        difference = turn / self._rad_per_metre
        left = self._on_floor(self._gripped((distance - difference) * self._left_scale))
        right = self._on_floor((distance + difference) * self._right_scale)
        return (left + right) / 2.0, (right - left) / 2.0 * self._really_rad_per_metre

    def _gripped(self, way: float) -> float:
        """Return what is left of the way (m) of a left wheel that loses a share of it, another one on each patch."""
        if self._left_slip:
            self._patch_left -= abs(way)
            if self._patch_left <= 0.0:
                self._patch_left = PATCH
                self._left_loses = self._random.uniform(0.0, self._left_slip)
            way *= 1.0 - self._left_loses
        return way

    def _on_floor(self, way: float) -> float:
        """Return the distance (m) that one wheel moves over the floor while it rolls `way` (m), with slip and noise.

        The standard deviation of the noise grows with the square root of the distance. So the noise of a long
        distance does not depend on the number of steps.
        """
        if self._slip:
            way *= 1.0 - self._random.uniform(0.0, self._slip)
        if self._noise:
            way += self._random.uniform(-WIDEST_DRAW, WIDEST_DRAW) * self._noise * math.sqrt(abs(way))
        return way


class DeadReckoning:
    """The odometry of a robot, which adds up its motion step by step.

    Args:
        origin: pose of the robot at the start of the odometry (m, rad; map frame).

    Attributes:
        origin: the argument, until the robot is carried.
        pose: x, y (m) and heading (rad, not wrapped) in the odometry frame, at first 0, 0, 0.
    """

    def __init__(self, origin: Pose):
        self.origin = origin
        self.pose: Pose = (0.0, 0.0, 0.0)
        self._heading = Heading()

    def carry(self, pose: Pose) -> None:
        """Move the origin, because the robot was carried to `pose` (m, rad; map frame) and its wheels have not turned.

        The odometry is then exact there: its error so far is left out.
        """
        self.origin = compose(pose, relative(self.pose, (0.0, 0.0, 0.0)))

    def add(self, distance: float, turn: float) -> None:
        """Add one step along an arc: a distance (m) and a turn (rad, counter-clockwise positive)."""
        self.pose = along_arc(self.pose, distance, turn, self._heading.unit)
