"""The drives of a robot, which control translation and rotation, or each wheel; also stalls, and motor power.

All values are in SI units. This file does not depend on packets or walls.
"""

import math
from dataclasses import replace
from typing import List, Optional, Tuple

from ...robots import RobotModel
from .battery import BatteryPack
from .ramps import Channel, Limits
from .robot_numbers import DriveNumbers

ARRIVED = 0.0005
"""Distance (m) or angle (rad) from the goal at which a commanded distance or turn counts as done."""
NO_E_STALL = frozenset(["PSOS", "P2OS", "AmigOS"])
"""Families of firmware whose motors stay on when the STOP button is pressed, until command E_STALL changes this.

Source: protocol sheet 3.6.
"""
TRUE_WHEELS = frozenset(["PSOS", "P2OS", "AmigOS", "AROS"])
"""Families of firmware in which command VEL2 controls the speed of each wheel.

The other families convert VEL2 to a translation and a rotation.

Source: protocol sheet 7.
"""


class Drives:
    """The drives of a robot: their set points, and their present speeds.

    Attributes:
        linear: translation (m, m/s; forward positive).
        angular: rotation (rad, rad/s; counter-clockwise positive).
    """

    def __init__(self, model: RobotModel, numbers: DriveNumbers):
        self._numbers, self._model = numbers, model
        self.linear, self.angular = (Channel(limits, ARRIVED) for limits in limits_of(numbers, model))
        self._wheels: Optional[List[Channel]] = None    # left, right; None while not used
        self._wheels_commanded = False

    def reset(self) -> None:
        """Set speed limits and accelerations to their power-on values."""
        self.linear.limits, self.angular.limits = limits_of(self._numbers, self._model)
        self._wheels_commanded = False

    @property
    def moving(self) -> bool:
        """Whether the robot moves."""
        return self.linear.speed != 0.0 or self.angular.speed != 0.0

    @property
    def driven(self) -> bool:
        """Whether the drives move, or have a set point other than zero."""
        return self.linear.driven or self.angular.driven or self._wheels is not None

    @property
    def wheel_speeds(self) -> Tuple[float, float]:
        """The speeds (m/s) of the left wheels and the right wheels."""
        difference = self.angular.speed / self._model.diff_rad_per_mm / 1000.0
        return self.linear.speed - difference, self.linear.speed + difference

    def turn_wheels(self, left: float, right: float) -> None:
        """Set the speeds of the left wheels and the right wheels (m/s), until the next motion command."""
        self._wheels_commanded = True
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
        """Set the speed of translation and rotation to zero if the last motion command was `turn_wheels`.

        Every other motion command calls this first.
        """
        if self._wheels_commanded:
            self._wheels_commanded = False
            self.set_speeds(0.0, 0.0)

    def set_speeds(self, linear: float, angular: float) -> None:
        """Set the speeds of translation (m/s) and rotation (rad/s), instead of all earlier set points."""
        self._wheels = None
        self.linear.set_speed(linear)
        self.angular.set_speed(angular)

    def emergency_stop(self) -> None:
        """Stop with the highest deceleration, and drop all set points."""
        self._wheels = None
        self.linear.emergency_stop()
        self.angular.emergency_stop()

    def restart(self) -> None:
        """Set the speeds of translation and rotation to zero at once."""
        self.linear.speed = self.angular.speed = 0.0

    def step(self, dt: float, held: bool) -> Tuple[float, float]:
        """Drive for `dt` seconds.

        Args:
            dt: duration (s).
            held: whether the watchdog keeps the drives at speed zero.

        Returns:
            The distance (m) and the turn (rad) of this step, if nothing blocks the robot.
        """
        if self._wheels is None:
            return self.linear.step(dt, held), self.angular.step(dt, held)
        ways = [wheel.step(dt, held) for wheel in self._wheels]
        self.linear.speed, self.angular.speed = self._together(*[wheel.speed for wheel in self._wheels])
        return self._together(*ways)

    def blocked(self, distance: float, turn: float) -> None:
        """Undo the last step, because an obstacle stopped the robot: set all speeds to zero.

        `distance` (m) and `turn` (rad) are the result of that step.
        """
        self.linear.blocked(distance)
        self.angular.blocked(turn)
        for wheel in self._wheels or ():
            wheel.blocked(0.0)

    def _together(self, left: float, right: float) -> Tuple[float, float]:
        """Convert distances (m) or speeds (m/s) of the left and right wheels to translation and rotation of the robot.

        Returns:
            Translation (m or m/s) and rotation (rad or rad/s).
        """
        return (left + right) / 2.0, (right - left) / 2.0 * (1000.0 * self._model.diff_rad_per_mm)


class Stall:
    """The stall of blocked wheels. After a time of pressing, the wheels stall; they rest for a moment, then try again.

    Attributes:
        held: whether a simulated fault holds the wheels, so that they stall when they are driven.
        left: whether the left wheels have stalled.
        right: whether the right wheels have stalled.
        pressed_s: time (s) for which the blocked wheels have tried to turn.
        rest_s: time (s) that the stalled wheels still rest before they try again.
    """

    def __init__(self, numbers: DriveNumbers):
        self._numbers = numbers
        self.held = False
        self.clear()

    def clear(self) -> None:
        """End the stall of all wheels, and set the times of pressing and resting to zero."""
        self.left = self.right = False
        self.pressed_s = self.rest_s = 0.0

    def hold(self, held: bool) -> None:
        """Hold the wheels so that they cannot turn, or release them."""
        self.held = held

    def press(self, dt: float, bumped: bool, left: bool, right: bool) -> None:
        """Note that blocked wheels have tried to turn for `dt` seconds. Stall them if they have tried for too long.

        Args:
            dt: duration (s).
            bumped: whether a pressed bumper stalls the wheels at once.
            left: whether the left wheels have tried to turn.
            right: whether the right wheels have tried to turn.
        """
        self.pressed_s += dt
        if self.pressed_s >= self._numbers.stall_time - 1e-9 or bumped:
            self.left, self.right = left, right
            self.pressed_s, self.rest_s = 0.0, self._numbers.stall_recovery

    def rest(self, dt: float) -> None:
        """Let stalled wheels rest for `dt` seconds. End the stall when the time of resting is over."""
        self.rest_s -= dt
        if self.rest_s <= 1e-9:
            self.clear()


class MotorPower:
    """The power of the motors, and the STOP button, which can switch it off.

    Attributes:
        enabled: whether the motors have power.
        stop_button: whether the STOP button is pressed. Releasing it does not switch the motors on again.
        stop_button_stalls: whether a pressed STOP button switches the motors off.
    """

    def __init__(self, drives: Drives, battery: BatteryPack, family: str):
        self._drives, self._battery, self._family = drives, battery, family
        self.enabled = False
        self.stop_button = False
        self.reset()

    def reset(self) -> None:
        """Set `stop_button_stalls` to its power-on value, which depends on the family of firmware."""
        self.stop_button_stalls = self._family not in NO_E_STALL

    @property
    def e_stalled(self) -> bool:
        """Whether the STOP button keeps the motors off."""
        return self.stop_button and self.stop_button_stalls

    def enable(self) -> None:
        """Switch the motors on, unless a pressed STOP button keeps them off or the battery is empty."""
        if not self.e_stalled and not self._battery.is_empty:
            self.enabled = True

    def disable(self) -> None:
        """Switch the motors off, and drop all set points of the drives."""
        self.enabled = False
        self._drives.emergency_stop()

    def press_stop_button(self, pressed: bool) -> None:
        """Press the STOP button, or release it."""
        self.stop_button = pressed
        self._obey_stop_button()

    def set_stop_button_stalls(self, stalls: bool) -> None:
        """Set whether a pressed STOP button switches the motors off. If it is pressed now, this happens at once."""
        self.stop_button_stalls = stalls
        self._obey_stop_button()

    def _obey_stop_button(self) -> None:
        if self.e_stalled:
            self.disable()


def limits_of(numbers: DriveNumbers, model: RobotModel) -> Tuple[Limits, Limits]:
    """Return the power-on limits of translation (m/s, m/s^2) and of rotation (rad/s, rad/s^2)."""
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
