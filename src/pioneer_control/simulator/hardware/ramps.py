"""How the drives follow their set points: with trapezoidal speed ramps, for translation and for rotation.

All values are in SI units: m and m/s for translation, rad and rad/s for rotation. This file does not depend on packets
or walls.
"""

import math
from dataclasses import dataclass
from typing import Optional, Tuple


def ramp(speed: float, target: float, rise: float, fall: float, dt: float) -> Tuple[float, float]:
    """Change the speed from `speed` towards `target` for `dt` seconds.

    If the sign of the speed changes, it first falls to zero and then rises. The result is exact for any `dt`: one long
    step equals many short steps.

    Args:
        speed: present speed (m/s or rad/s).
        target: wanted speed (m/s or rad/s).
        rise: acceleration away from zero, positive (m/s^2 or rad/s^2).
        fall: deceleration towards zero, positive (m/s^2 or rad/s^2).
        dt: duration (s).

    Returns:
        The new speed, and the distance covered in this time (m or rad).
    """
    travelled = 0.0
    while dt > 0.0 and speed != target:
        slowing = speed * target < 0.0 or abs(speed) > abs(target)
        goal = (0.0 if speed * target < 0.0 else target) if slowing else target
        rate = fall if slowing else rise
        needed = abs(goal - speed) / rate
        after = goal if needed <= dt else speed + math.copysign(rate * dt, goal - speed)
        needed = min(needed, dt)
        travelled += (speed + after) / 2.0 * needed
        speed = after
        dt -= needed
    return speed, travelled + speed * dt


def approach(speed: float, remaining: float, limit: float, rise: float, fall: float, dt: float) -> Tuple[float, float]:
    """Drive towards a goal for `dt` seconds. The drive reaches the goal with speed zero and does not overshoot.

    Args:
        speed: present speed (m/s or rad/s).
        remaining: distance to the goal (m or rad), negative when the goal is behind.
        limit: highest speed, positive (m/s or rad/s).
        rise: acceleration, positive (m/s^2 or rad/s^2).
        fall: deceleration, positive (m/s^2 or rad/s^2).
        dt: duration (s).

    Returns:
        The new speed, and the distance covered in this time (m or rad).
    """
    direction = math.copysign(1.0, remaining)
    ahead, along = abs(remaining), speed * direction
    if along < 0.0:
        after, travelled = ramp(along, 0.0, rise, fall, dt)
        return after * direction, travelled * direction
    # The highest speed at the end of this step from which deceleration `fall` still stops the drive at the goal.
    spare = dt * dt / 4.0 + (2.0 * ahead - along * dt) / fall
    brakable = fall * (math.sqrt(spare) - dt / 2.0) if spare > 0.0 else 0.0
    after = max(0.0, min(brakable, limit, along + rise * dt), along - fall * dt)
    travelled = min((along + after) / 2.0 * dt, ahead)
    return after * direction, travelled * direction


@dataclass
class Limits:
    """Speed limits and accelerations of a `Channel` (m and s for translation, rad and s for rotation).

    Attributes:
        limit: speed limit.
        top: highest speed limit that can be set.
        rise: acceleration.
        fall: deceleration.
        rate_top: highest acceleration or deceleration that can be set.
        back_limit: speed limit for driving backward or turning clockwise. None when it is equal to `limit`.
    """

    limit: float
    top: float
    rise: float
    fall: float
    rate_top: float
    back_limit: Optional[float] = None

    def set_limit(self, value: float) -> None:
        """Set the speed limit of both directions for later commands, clipped to `top`. The sign is ignored."""
        self.limit = min(abs(value), self.top)
        self.back_limit = None

    def set_limit_towards(self, value: float) -> None:
        """Set the speed limit of one direction for later commands, clipped to `top`.

        A positive value is the limit forward or counter-clockwise, a negative value the limit backward or clockwise.
        """
        if value >= 0.0:
            self.back_limit = self.towards(-1.0)
            self.limit = min(value, self.top)
        else:
            self.back_limit = min(-value, self.top)

    def towards(self, direction: float) -> float:
        """Return the speed limit of a direction: negative is backward or clockwise."""
        return self.limit if direction >= 0.0 or self.back_limit is None else self.back_limit

    def set_rate(self, value: float) -> None:
        """Set the acceleration if `value` is positive, or the deceleration to -`value` if it is negative.

        The result is clipped to `rate_top`. Zero changes nothing.
        """
        if value > 0.0:
            self.rise = min(value, self.rate_top)
        elif value < 0.0:
            self.fall = min(-value, self.rate_top)


class Channel:
    """One axis of motion, with its set point and its speed: translation, rotation, or one wheel.

    Args:
        limits: speed limits and accelerations.
        arrived: distance (m or rad) from the goal at which the goal counts as reached.
        speed: initial speed (m/s or rad/s).

    Attributes:
        limits: as the argument.
        speed: present speed (m/s or rad/s).
        remaining: distance left to the goal (m or rad). None while the set point is a speed.
    """

    def __init__(self, limits: Limits, arrived: float, speed: float = 0.0):
        self.limits = limits
        self.speed = speed
        self.remaining: Optional[float] = None
        self._arrived = arrived
        self._target = 0.0
        self._emergency = False

    @property
    def driven(self) -> bool:
        """Whether this channel moves, or has a set point other than zero."""
        return self.speed != 0.0 or self._target != 0.0

    def set_speed(self, speed: float) -> None:
        """Set a speed as the new set point (m/s or rad/s), clipped to the present limits."""
        self._target = max(-self.limits.towards(-1.0), min(self.limits.limit, speed))
        self.remaining = None
        self._emergency = False

    def set_distance(self, distance: float) -> None:
        """Set a distance as the new set point (m or rad). The channel drives it at the present speed limit, then stops.
        """
        self._target = self.limits.towards(distance)
        self.remaining = distance
        self._emergency = False

    def emergency_stop(self) -> None:
        """Stop with the highest deceleration, and stay at speed zero until the next set point."""
        self.set_speed(0.0)
        self._emergency = True

    def step(self, dt: float, held: bool) -> float:
        """Drive for `dt` seconds.

        Args:
            dt: duration (s).
            held: slow down to speed zero, and keep the set point for later.

        Returns:
            The distance covered (m or rad).
        """
        limits = self.limits
        if held or self.remaining is None:
            target = 0.0 if held else self._target
            if self.speed == target:
                return target * dt
            fall = limits.rate_top if self._emergency else limits.fall
            self.speed, travelled = ramp(self.speed, target, limits.rise, fall, dt)
            if self.remaining is not None:
                self.remaining -= travelled
            return travelled
        self.speed, travelled = approach(self.speed, self.remaining, self._target, limits.rise, limits.fall, dt)
        left = self.remaining - travelled
        if abs(left) < self._arrived and abs(self.speed) * dt < self._arrived:
            travelled, self.speed, self._target = self.remaining, 0.0, 0.0
            self.remaining = None
        else:
            self.remaining = left
        return travelled

    def blocked(self, travelled: float) -> None:
        """Undo the last step, because an obstacle stopped the robot: set the speed to zero.

        `travelled` (m or rad) is the result of that step. It is added back to the remaining distance.
        """
        self.speed = 0.0
        if self.remaining is not None:
            self.remaining += travelled
