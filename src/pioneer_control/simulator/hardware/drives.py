"""The drives: translation and rotation, or each wheel by itself, on their ramps; what makes them give up; and their
power.

SI units; knows neither packets nor walls.
"""

import math
from dataclasses import replace
from typing import List, Optional, Tuple

from ...robots import RobotModel
from .battery import BatteryPack
from .ramps import Channel, Limits
from .robot_numbers import DriveNumbers

ARRIVED = 0.0005
"""A set distance (m) or turn (rad) counts as done this near to its goal."""
NO_E_STALL = frozenset(["PSOS", "P2OS", "AmigOS"])
"""Families of firmware whose motors stay on when the STOP button is pressed, until E_STALL says otherwise.

Source: protocol sheet 3.6.
"""
TRUE_WHEELS = frozenset(["PSOS", "P2OS", "AmigOS", "AROS"])
"""Families whose VEL2 controls each wheel by itself; the others make translation and rotation of it.

Source: protocol sheet 7.
"""


class Drives:
    """What the drives are told, and how they follow.

    Attributes:
        linear: translation (m, m/s).
        angular: rotation (rad, rad/s; counter-clockwise positive).
    """

    def __init__(self, model: RobotModel, numbers: DriveNumbers):
        self._numbers, self._model = numbers, model
        self.linear, self.angular = (Channel(limits, ARRIVED) for limits in limits_of(numbers, model))
        self._wheels: Optional[List[Channel]] = None    # left, right
        self._told_by_wheels = False

    def reset(self) -> None:
        """Take the limits of power-on."""
        self.linear.limits, self.angular.limits = limits_of(self._numbers, self._model)
        self._told_by_wheels = False

    @property
    def moving(self) -> bool:
        """Whether the robot moves."""
        return self.linear.speed != 0.0 or self.angular.speed != 0.0

    @property
    def driven(self) -> bool:
        """Whether the drives have somewhere to go, or have yet to stop."""
        return self.linear.driven or self.angular.driven or self._wheels is not None

    @property
    def wheel_speeds(self) -> Tuple[float, float]:
        """Speeds (m/s) of the left and the right wheels."""
        difference = self.angular.speed / self._model.diff_rad_per_mm / 1000.0
        return self.linear.speed - difference, self.linear.speed + difference

    def turn_wheels(self, left: float, right: float) -> None:
        """Turn the left and the right wheels at these speeds (m/s), until another command of motion."""
        self._told_by_wheels = True
        if self._model.firmware_family in TRUE_WHEELS:
            limits = replace(self.linear.limits, limit=self.linear.limits.top, back_limit=None)
            if self._wheels is None:
                self._wheels = [Channel(limits, ARRIVED, speed) for speed in self.wheel_speeds]
            for wheel, speed in zip(self._wheels, (left, right)):
                wheel.limits = limits
                wheel.set_speed(speed)
        else:
            self.linear.set_speed((left + right) / 2.0)
            self.angular.set_speed((right - left) / 2.0 * 1000.0 * self._model.diff_rad_per_mm)

    def cancel_wheels(self) -> None:
        """Stop both wheels where `turn_wheels` turned them last: each other command of motion begins so."""
        if self._told_by_wheels:
            self._told_by_wheels = False
            self.set_speeds(0.0, 0.0)

    def set_speeds(self, linear: float, angular: float) -> None:
        """Translate (m/s) and rotate (rad/s), and forget what was told before."""
        self._wheels = None
        self.linear.set_speed(linear)
        self.angular.set_speed(angular)

    def emergency_stop(self) -> None:
        """Stop as fast as the drives can, and forget what was told."""
        self._wheels = None
        self.linear.emergency_stop()
        self.angular.emergency_stop()

    def restart(self) -> None:
        """Stand at once, as without power."""
        self.linear.speed = self.angular.speed = 0.0

    def step(self, dt: float, held: bool) -> Tuple[float, float]:
        """Let `dt` seconds pass.

        Args:
            held: the watchdog keeps the drives at zero.

        Returns:
            The distance (m) and the turn (rad) of the step, as the drives would have it.
        """
        if self._wheels is None:
            return self.linear.step(dt, held), self.angular.step(dt, held)
        ways = [wheel.step(dt, held) for wheel in self._wheels]
        self.linear.speed, self.angular.speed = self._together(*[wheel.speed for wheel in self._wheels])
        return self._together(*ways)

    def blocked(self, distance: float, turn: float) -> None:
        """The last step's distance and turn did not happen: something stands in the way."""
        self.linear.blocked(distance)
        self.angular.blocked(turn)
        for wheel in self._wheels or ():
            wheel.blocked(0.0)

    def _together(self, left: float, right: float) -> Tuple[float, float]:
        """What ways or speeds of the left and the right wheel (m, m/s) make the robot do (m and rad, m/s and rad/s)."""
        return (left + right) / 2.0, (right - left) / 2.0 * (1000.0 * self._model.diff_rad_per_mm)


class Stall:
    """Drives that cannot turn their wheels give up for a moment, and try again.

    Attributes:
        held: something holds the wheels, so that they stall when driven.
        left, right: these wheels have stalled.
        pressed_s: for so long (s) they have tried to turn in vain.
        rest_s: for so long (s) the drives give up from now on.
    """

    def __init__(self, numbers: DriveNumbers):
        self._numbers = numbers
        self.held = False
        self.clear()

    def clear(self) -> None:
        """No wheel has stalled, and none presses."""
        self.left = self.right = False
        self.pressed_s = self.rest_s = 0.0

    def hold(self, held: bool) -> None:
        """Hold the wheels, or let them go."""
        self.held = held

    def press(self, dt: float, bumped: bool, left: bool, right: bool) -> None:
        """The wheels have tried in vain for `dt` seconds; `left` and `right` say which.

        A bumper that stalls ends that at once.
        """
        self.pressed_s += dt
        if self.pressed_s >= self._numbers.stall_time - 1e-9 or bumped:
            self.left, self.right = left, right
            self.pressed_s, self.rest_s = 0.0, self._numbers.stall_recovery

    def rest(self, dt: float) -> None:
        """Wait for `dt` seconds before the next try."""
        self.rest_s -= dt
        if self.rest_s <= 1e-9:
            self.clear()


class MotorPower:
    """Whether the motors have power, and the STOP button that takes it away.

    Attributes:
        enabled: the motors have power.
        stop_button: the STOP button is pressed. Letting it go does not give the power back.
        stop_button_stalls: pressing the STOP button takes the power away.
    """

    def __init__(self, drives: Drives, battery: BatteryPack, family: str):
        self._drives, self._battery, self._family = drives, battery, family
        self.enabled = False
        self.stop_button = False
        self.reset()

    def reset(self) -> None:
        """Let the STOP button take the power away as it does at power-on."""
        self.stop_button_stalls = self._family not in NO_E_STALL

    @property
    def e_stalled(self) -> bool:
        """Whether the STOP button keeps the motors off."""
        return self.stop_button and self.stop_button_stalls

    def enable(self) -> None:
        """Switch the motors on, unless a pressed STOP button or an empty battery forbids it."""
        if not self.e_stalled and not self._battery.is_empty:
            self.enabled = True

    def disable(self) -> None:
        """Take the power from the motors; set points are forgotten."""
        self.enabled = False
        self._drives.emergency_stop()

    def press_stop_button(self, pressed: bool) -> None:
        """Press the STOP button, or let it go."""
        self.stop_button = pressed
        self._obey_stop_button()

    def set_stop_button_stalls(self, stalls: bool) -> None:
        """Say whether the STOP button takes the power from the motors, from now on and if it is pressed already."""
        self.stop_button_stalls = stalls
        self._obey_stop_button()

    def _obey_stop_button(self) -> None:
        if self.e_stalled:
            self.disable()


def limits_of(numbers: DriveNumbers, model: RobotModel) -> Tuple[Limits, Limits]:
    """Limits of translation (m/s, m/s^2) and of rotation (rad/s, rad/s^2) at power-on."""
    linear_top = min(numbers.linear_top_mm_s / 1000.0, model.max_linear)
    angular_top = min(math.radians(numbers.angular_top_deg_s), model.max_angular)
    return (
        Limits(
            limit=min(numbers.linear_limit_mm_s / 1000.0, linear_top),
            top=linear_top,
            rise=numbers.linear_acceleration_mm_s2 / 1000.0,
            fall=numbers.linear_deceleration_mm_s2 / 1000.0,
            rate_top=numbers.linear_acceleration_top_mm_s2 / 1000.0,
        ),
        Limits(
            limit=min(math.radians(numbers.angular_limit_deg_s), angular_top),
            top=angular_top,
            rise=math.radians(numbers.angular_acceleration_deg_s2),
            fall=math.radians(numbers.angular_deceleration_deg_s2),
            rate_top=math.radians(numbers.angular_acceleration_top_deg_s2),
        ),
    )
