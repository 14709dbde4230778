"""Drives the legs of a run by odometry: poses in, velocities out. Pure.

The legs are driven as the robot is known to move: with the factors found so far. So the robot ends near where it
should, and the tape has little to measure. Lengths in m, angles in rad, counter-clockwise positive.
"""

import math
from typing import NamedTuple, Optional, Sequence

from ..floor_poses import Pose, relative
from .plan import AheadLeg, Leg, TurnLeg
from .tracks import Factors

SPEED, TURN_RATE = 0.4, math.radians(40)
"""Velocities (m/s, rad/s) in the middle of a leg: wheels of an indoor robot do not slip at them."""
BRAKING, TURN_BRAKING = 0.2, math.radians(40)
"""Decelerations (m/s^2, rad/s^2) towards the end of a leg, gentler than the robot's own."""
CREEP, TURN_CREEP = 0.02, math.radians(2)
"""Velocities (m/s, rad/s) at the end of a leg."""
NEAR, TURN_NEAR = 0.004, math.radians(0.4)
"""Way and turn (m, rad) before the end of a leg at which it counts as driven."""
LAG = 0.2
"""Time (s) that passes until the robot does what it is told."""
STEER, STEER_BACK = 1.0, 0.6
"""Turn rate (rad/s) on a straight leg for each rad off its heading, and for each m aside."""
MOST_STEERING = math.radians(15)
RESTS = 0.4
"""Time (s) for which the pose must stay the same until the next leg begins."""


class GuidedVelocity(NamedTuple):
    """What the robot is told: m/s ahead, rad/s counter-clockwise."""

    linear: float = 0.0
    angular: float = 0.0


STAND = GuidedVelocity()


class Guide:
    """Drives the legs of one run.

    Args:
        legs: of the run.
        factors: what is known of the robot.

    Attributes:
        done: whether all legs are driven, and the robot stands.
        moves: whether the newest pose is another one than the one before.
    """

    def __init__(self, legs: Sequence[Leg], factors: Factors) -> None:
        self._legs, self._factors = list(legs), factors
        self._x = self._y = self._heading = 0.0         # corrected, from the beginning of the run
        self._from = Pose(0.0, 0.0, 0.0)                # where the leg begins, by plan
        self._last: Optional[Pose] = None
        self._moved_at = -math.inf
        self._ending = False
        self.moves = False
        self.done = not self._legs

    @property
    def leg(self) -> Optional[Leg]:
        """The present leg; None when all are driven."""
        return self._legs[0] if self._legs else None

    def step(self, pose: Pose, now: float) -> GuidedVelocity:
        """Take a pose of odometry and its time (s). Return what the robot is to do."""
        self.moves = self._take(pose)
        if self.moves:
            self._moved_at = now
        while self._legs:
            leg = self._legs[0]
            wanted = self._straight(leg) if isinstance(leg, AheadLeg) else self._around(leg)
            if not self._ending:
                return wanted
            if now - self._moved_at < RESTS:
                return STAND
            self._begin_next()
        self.done = True
        return STAND

    def _take(self, pose: Pose) -> bool:
        """Add the step to a pose, corrected. Return whether the robot moved."""
        last, self._last = self._last, pose
        if last is None or last == pose:
            return last is None
        step = relative(last, pose)
        ahead = self._factors.distance * (step.x * math.cos(step.heading / 2) + step.y * math.sin(step.heading / 2))
        turn = self._factors.turn * step.heading + self._factors.curve * ahead
        self._x += ahead * math.cos(self._heading + turn / 2)
        self._y += ahead * math.sin(self._heading + turn / 2)
        self._heading += turn
        return True

    def _straight(self, leg: AheadLeg) -> GuidedVelocity:
        x, y = self._x - self._from.x, self._y - self._from.y
        cosine, sine = math.cos(self._from.heading), math.sin(self._from.heading)
        left = leg.way - (x * cosine + y * sine)
        self._ending = self._ending or left < NEAR
        aside = y * cosine - x * sine
        speed = _gentle(left, SPEED, BRAKING, CREEP)
        steering = -STEER * (self._heading - self._from.heading) - STEER_BACK * aside - self._factors.curve * speed
        return GuidedVelocity(speed, max(-MOST_STEERING, min(MOST_STEERING, steering)))

    def _around(self, leg: TurnLeg) -> GuidedVelocity:
        side = math.copysign(1.0, leg.turn)
        left = side * (self._from.heading + leg.turn - self._heading)
        self._ending = self._ending or left < TURN_NEAR
        return GuidedVelocity(0.0, side * _gentle(left, TURN_RATE, TURN_BRAKING, TURN_CREEP))

    def _begin_next(self) -> None:
        leg = self._legs.pop(0)
        x, y, heading = self._from
        if isinstance(leg, AheadLeg):
            x, y = x + leg.way * math.cos(heading), y + leg.way * math.sin(heading)
        else:
            heading += leg.turn
        self._from, self._ending = Pose(x, y, heading), False


def _gentle(left: float, fastest: float, braking: float, creep: float) -> float:
    """Return the speed at which a robot still stops in time when ``left`` is its way, or turn, to the end."""
    return max(creep, min(fastest, math.sqrt(2.0 * braking * max(0.0, left)), left / (4.0 * LAG)))
