"""How the drives follow what they are told: trapezoidal ramps, for translation and for rotation alike.

Everything here is in SI units (m and m/s for translation, rad and rad/s for rotation) and knows neither packets nor
walls.
"""

import math
from dataclasses import dataclass
from typing import Optional, Tuple


def ramp(speed: float, target: float, rise: float, fall: float, dt: float) -> Tuple[float, float]:
    """The speed after `dt` seconds of changing from `speed` to `target`, and the distance covered meanwhile.

    Away from zero the speed changes by `rise` per second, towards zero by `fall`; through zero it does first the one
    and then the other. Exact for any `dt`, so that one long step equals many short ones.
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
    """Speed after `dt` seconds on the way to a point `remaining` ahead (behind when negative), and the distance
    covered.

    The speed stays within `limit`, and such that `fall` still stops the drive at the point: it arrives with speed
    zero and never runs past.
    """
    direction = math.copysign(1.0, remaining)
    ahead, along = abs(remaining), speed * direction
    if along < 0.0:
        after, travelled = ramp(along, 0.0, rise, fall, dt)
        return after * direction, travelled * direction
    # The highest speed at the end of this step from which `fall` stops the drive within what is left then.
    spare = dt * dt / 4.0 + (2.0 * ahead - along * dt) / fall
    brakable = fall * (math.sqrt(spare) - dt / 2.0) if spare > 0.0 else 0.0
    after = max(0.0, min(brakable, limit, along + rise * dt), along - fall * dt)
    travelled = min((along + after) / 2.0 * dt, ahead)
    return after * direction, travelled * direction


@dataclass
class Limits:
    """What a channel may do (SI units).

    Attributes:
        limit: the speed limit.
        top: the highest speed limit that can be set.
        rise: the acceleration.
        fall: the deceleration.
        rate_top: the highest acceleration or deceleration that can be set.
        back_limit: the speed limit backward or clockwise; None where it is the same.
    """

    limit: float
    top: float
    rise: float
    fall: float
    rate_top: float
    back_limit: Optional[float] = None

    def set_limit(self, value: float) -> None:
        """A new speed limit for later commands, clipped to the top."""
        self.limit = min(abs(value), self.top)
        self.back_limit = None

    def set_limit_towards(self, value: float) -> None:
        """The same for one way only: a negative one is the limit of the other way."""
        if value >= 0.0:
            self.back_limit = self.towards(-1.0)
            self.limit = min(value, self.top)
        else:
            self.back_limit = min(-value, self.top)

    def towards(self, direction: float) -> float:
        """The speed limit in a direction, by its sign."""
        return self.limit if direction >= 0.0 or self.back_limit is None else self.back_limit

    def set_rate(self, value: float) -> None:
        """A new acceleration, or deceleration when negative, clipped to the top; zero changes nothing."""
        if value > 0.0:
            self.rise = min(value, self.rate_top)
        elif value < 0.0:
            self.fall = min(-value, self.rate_top)


class Channel:
    """One of the two things a robot can be told independently: to translate, or to rotate.

    Args:
        limits: what it may do.
        arrived: how near (m or rad) to the goal of a set distance counts as there.
        speed: at first (m/s or rad/s).

    Attributes:
        remaining: what is left of a set distance (m or rad), None while a speed is set.
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
        """Whether this channel has somewhere to go or has yet to stop."""
        return self.speed != 0.0 or self._target != 0.0

    def set_speed(self, speed: float) -> None:
        """Go at `speed`, clipped to the limit of this moment."""
        self._target = max(-self.limits.towards(-1.0), min(self.limits.limit, speed))
        self.remaining = None
        self._emergency = False

    def set_distance(self, distance: float) -> None:
        """Go `distance` at the speed limit of this moment, and stop there."""
        self._target = self.limits.towards(distance)
        self.remaining = distance
        self._emergency = False

    def emergency_stop(self) -> None:
        """Stop as fast as the drive can, and stay there until told something else."""
        self.set_speed(0.0)
        self._emergency = True

    def step(self, dt: float, held: bool) -> float:
        """Advance by `dt` seconds.

        Args:
            held: stops the drive. It keeps what it was told.

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
        """Take the last step's `travelled` back: something stands in the way."""
        self.speed = 0.0
        if self.remaining is not None:
            self.remaining += travelled
