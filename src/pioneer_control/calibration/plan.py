"""Which runs are driven, and the legs of each. Lengths in m, angles in rad, counter-clockwise positive."""

import math
from typing import Any, NamedTuple, Tuple, Union

from ..errors import UsageError
from ..parameters import Number, Rate, Whole
from .runs import RunKind


class AheadLeg(NamedTuple):
    """A leg straight ahead (m)."""

    way: float


class TurnLeg(NamedTuple):
    """A leg that turns on the spot (rad)."""

    turn: float


Leg = Union[AheadLeg, TurnLeg]


class PlannedRun(NamedTuple):
    """A run that is to be driven: its kind, its whole turns (left positive, 0 for a line), and its legs."""

    kind: RunKind
    turns: int
    legs: Tuple[Leg, ...]


class RunPlan(NamedTuple):
    """What is driven: the runs from which the robot is calibrated, and those that show what became better."""

    runs: Tuple[PlannedRun, ...]
    proof: Tuple[PlannedRun, ...]


LEGAL_LINE, LEGAL_SIDE, LEGAL_REPEATS = Number(1.0, 20.0), Rate(0.5, 10.0), Whole(1, 10)


def line(way: float) -> PlannedRun:
    """Return a straight line."""
    return PlannedRun(RunKind.LINE, 0, (AheadLeg(way),))


def turns(count: int) -> PlannedRun:
    """Return whole turns on the spot, to the right if ``count`` is negative."""
    return PlannedRun(RunKind.TURN, count, (TurnLeg(2.0 * math.pi * count),))


def square(side: float, direction: int) -> PlannedRun:
    """Return a square with sides of ``side`` m, to the left (1) or to the right (-1), with a corner at its end."""
    return PlannedRun(RunKind.SQUARE, direction, (AheadLeg(side), TurnLeg(direction * math.pi / 2.0)) * 4)


def plan_of(way: float = 5.0, side: float = 2.0, repeats: int = 2) -> RunPlan:
    """Return the plan: one turn each way, then five; lines; squares both ways; all ``repeats`` times.

    One turn goes first: a robot that turns 8 % too far would be off by more than a right angle after five.

    Args:
        way: of a line (m).
        side: of a square (m). 0: no squares.
        repeats: how often: five turns and a square each way, and two lines.

    Raises:
        UsageError: a value is not legal.
    """
    checks: Tuple[Tuple[str, Any, Any], ...] = (
        ("line", way, LEGAL_LINE), ("side", side, LEGAL_SIDE), ("repeats", repeats, LEGAL_REPEATS))
    for name, value, legal in checks:
        try:
            legal.accept(value)
        except ValueError:
            raise UsageError("%s is %r: give %s" % (name, value, legal.legal)) from None
    runs = (turns(1), turns(-1)) + (turns(5), turns(-5)) * repeats + (line(way),) * (2 * repeats)
    if side:
        runs += (square(side, 1), square(side, -1)) * repeats
    return RunPlan(runs, (line(way), turns(1), turns(-1)))
