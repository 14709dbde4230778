"""Converts velocities in SI to commands in whole units: of the robot (VEL, RVEL) or of its wheels (VEL2).

The velocities are kept within the limits of the robot and of the user.

**Rounding.** The robot takes whole mm/s and deg/s, and for its wheels steps of 20 mm/s. A rate between two units is
sent as the lower unit and the higher unit in turn. So the average over a second is the wanted rate. For example, a rate
of 0.4 deg/s turns the robot by 24 degrees in a minute. With plain rounding it would not turn at all. Zero is always
exactly zero.
"""

import itertools
import math
from abc import ABC, abstractmethod
from functools import lru_cache
from typing import Iterable, Tuple

from ..p2os import COMMANDS, encode_command
from .identity import RobotIdentity

WIRE_LIMIT = 32767              # the largest number that VEL and RVEL carry
WHEEL_LIMIT = COMMANDS["VEL2"].high[0]
ROUNDING_PERIOD = 1.0           # s over which a rate is exact on average
# s for which a wheel keeps one of the two steps. Its ramp from one to the other takes 0.07 s; a shorter time would make
# the average wrong.
HOLD = 0.2
LEGAL = 1 + 1e-9                # factor on a limit, because of rounding errors
FASTEST = 1000.0                # m/s: more than any wheel does, and small enough to calculate with

packet = lru_cache(maxsize=4096)(encode_command)
"""encode_command() for numbers that are sent again and again."""


class FairRounding:
    """Rounds one rate to whole units. The average of the units over time is the wanted rate.

    Attributes:
        sent: the whole number of units that was sent last.
    """

    def __init__(self) -> None:
        self._wanted = 0.0
        self.sent = 0
        self._owed = 0.0        # unit-seconds by which the robot is behind
        self._since = 0.0

    def units(self, wanted: float, limit: int, now: float) -> int:
        """Return the whole number to send at ``now`` (s) for a rate of ``wanted`` units, within +-``limit`` units."""
        self.sent = round(clamped(self.aim(clamped(wanted, limit), now), limit))
        return self.sent

    def aim(self, wanted: float, now: float) -> float:
        """Return the rate (in units, not rounded) to send from ``now`` (s) on: ``wanted``, corrected for past rounding.

        The caller must set ``sent`` to the whole number that it sends for this rate.
        """
        self._owed = clamped(self._owed + (self._wanted - self.sent) * (now - self._since), 1)
        self._wanted, self._since = wanted, now
        if wanted == 0:
            self._owed = 0.0
        return wanted + self._owed / ROUNDING_PERIOD


class Velocity(ABC):
    """Base class: rounds two wanted rates, and makes the packets that command both of them."""

    def __init__(self, identity: RobotIdentity) -> None:
        self._rounding = (FairRounding(), FairRounding())
        self.follow(identity)

    @abstractmethod
    def follow(self, identity: RobotIdentity) -> None:
        """Use the limits of this identity from now on."""

    @abstractmethod
    def packets(self, first: float, second: float, now: float) -> Tuple[bytes, ...]:
        """Return the packets to send at ``now`` (s) for two rates in SI units."""

    def rest(self, now: float) -> None:
        """Set both wanted rates to zero at ``now`` (s), and forget past rounding errors."""
        for rounding in self._rounding:
            rounding.units(0, 0, now)


class BodyVelocity(Velocity):
    """Translation (m/s) and rotation (rad/s), each clamped to its own limit."""

    def follow(self, identity: RobotIdentity) -> None:
        self._limits = (_units(identity.max_linear * 1000), _units(math.degrees(identity.max_angular)))

    def packets(self, linear: float, angular: float, now: float) -> Tuple[bytes, ...]:
        return (packet("VEL", self._rounding[0].units(linear * 1000, self._limits[0], now)),
                packet("RVEL", self._rounding[1].units(math.degrees(angular), self._limits[1], now)))


class WheelVelocities(Velocity):
    """Velocities of left and right wheel (m/s).

    Beyond a limit both are scaled down by the same factor, so that the curve stays.
    """

    def __init__(self, identity: RobotIdentity) -> None:
        super().__init__(identity)
        self._units = (0, 0)
        self._until = -math.inf         # when new units may be chosen although the wanted velocity has not changed

    def follow(self, identity: RobotIdentity) -> None:
        model = identity.model
        self._unit = model.vel2_mm_s_per_unit / 1000
        self._max_sum = 2 * identity.max_linear / self._unit
        self._max_difference = 2 * identity.max_angular / (model.diff_rad_per_mm * model.vel2_mm_s_per_unit)

    def packets(self, left: float, right: float, now: float) -> Tuple[bytes, ...]:
        scale = FASTEST / max(FASTEST, abs(left), abs(right)) / self._unit
        wheels = self._within(left * scale, right * scale)
        aims = self._within(*(rounding.aim(wheel, now) for rounding, wheel in zip(self._rounding, wheels)))
        # whether the present units are a rounded form of this pair
        near = abs(self._units[0] - wheels[0]) < 1 and abs(self._units[1] - wheels[1]) < 1
        if now >= self._until or not near or self._excess(*self._units) > LEGAL:
            self._until, self._units = now + HOLD, self._nearest(*aims)
        for rounding, each in zip(self._rounding, self._units):
            rounding.sent = each
        return (packet("VEL2", *self._units),)

    def rest(self, now: float) -> None:
        super().rest(now)
        self._until = now

    def _excess(self, left: float, right: float) -> float:
        """Return the wheel velocities (units of VEL2) as a multiple of the tightest limit. Above 1 is too fast."""
        pairs: Iterable[Tuple[float, float]] = (
            (left, WHEEL_LIMIT), (right, WHEEL_LIMIT), (left + right, self._max_sum),
            (right - left, self._max_difference))
        return max(abs(rate) / limit if limit else math.inf if rate else 0.0 for rate, limit in pairs)

    def _within(self, left: float, right: float) -> Tuple[float, float]:
        excess = max(1.0, self._excess(left, right))
        return left / excess, right / excess

    def _nearest(self, left: float, right: float) -> Tuple[int, int]:
        """Return the whole units within the limits that are nearest to this pair (units of VEL2)."""
        first, second = (range(math.floor(aim) - 1, math.floor(aim) + 3) for aim in (left, right))
        legal = (choice for choice in itertools.product(first, second) if self._excess(*choice) <= LEGAL)
        return min(legal, key=lambda choice: (choice[0] - left) ** 2 + (choice[1] - right) ** 2, default=(0, 0))


def clamped(rate: float, limit: float) -> float:
    """Return ``rate``, clamped to +-``limit``."""
    return min(max(rate, -limit), limit)


def _units(limit: float) -> int:
    """Return the largest whole number that does not exceed ``limit`` or WIRE_LIMIT."""
    return min(math.floor(limit + 1e-9), WIRE_LIMIT)
