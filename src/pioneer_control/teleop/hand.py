"""What the hand of a person wants, and for how long. Pure: time (monotonic, s) is an argument."""

import math
from typing import NamedTuple, Tuple

FIRST_PRESS = 0.6
"""Time (s) for which the first press of a key counts. A terminal knows no release, and repeats a held key only after
about half a second.
"""
REPEATED = 0.25
"""Time (s) for which each repetition of a held key counts. Terminals repeat a key every 30 to 100 ms."""
SLOW = 0.2
"""The limit of speed (m/s) at the start."""
STEP = 0.1
"""By how much the limit is raised or lowered (m/s)."""


class Wish(NamedTuple):
    """What the hand wants, as shares (-1 to 1) of the limits: forward, and left, are positive."""

    forward: float = 0.0
    turn: float = 0.0


STAND = Wish()


class KeyHand:
    """The hand on the keys of a terminal. A wish lives for a short time: nobody tells when the key is let go."""

    def __init__(self) -> None:
        self._wish = STAND
        self._until = -math.inf

    def press(self, wish: Wish, now: float) -> None:
        """Take one press, or one repetition, of a key that drives."""
        is_held = wish == self._wish and now < self._until
        self._wish, self._until = wish, now + (REPEATED if is_held else FIRST_PRESS)

    def let_go(self) -> None:
        """Forget the wish: another key was pressed."""
        self._wish, self._until = STAND, -math.inf

    def wish(self, now: float) -> Wish:
        """Return what the hand wants now."""
        return self._wish if now < self._until else STAND


class Limit:
    """How fast a person drives at most. It is slow until somebody raises it.

    Args:
        linear: the limit at the start (m/s).

    Attributes:
        linear: the limit (m/s).
        robot: the robot's own limits (m/s, rad/s).
    """

    def __init__(self, linear: float = SLOW) -> None:
        self.linear = linear
        self.robot = (0.5, 1.745)   # the driver's defaults, until the robot tells its own

    def change(self, steps: int) -> None:
        """Raise the limit by so many steps, or lower it. It stays between one step and the robot's own limit."""
        wanted = round(self.linear + steps * STEP, 3)
        self.linear = min(max(wanted, STEP), self.robot[0])

    @property
    def angular(self) -> float:
        """The limit of turns (rad/s), in the same proportion to the robot's own."""
        return self.robot[1] * min(1.0, self.linear / self.robot[0])

    def velocity(self, wish: Wish) -> Tuple[float, float]:
        """Return the velocity for a wish: m/s forward, rad/s counter-clockwise."""
        return wish.forward * min(self.linear, self.robot[0]), wish.turn * self.angular
