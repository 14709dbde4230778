"""The three kinds of run, the marks on robot and floor, and what the tape says about the end of a run.

A run begins with the robot on a line on the floor: its front mark and its rear mark lie over the line, and it looks
along it. Lengths in m, angles in rad; ahead along the line, left of it is positive.
"""

import math
from enum import Enum
from typing import Any, NamedTuple

import numpy as np

from ..errors import UsageError
from ..parameters import Number
from .tracks import Factors, OdometryTrack

Array = Any     # of numpy

TAPE_ERROR = 0.003
"""Standard deviation (m) of one number that the tape says, with that of the start where it belongs to it."""
START_HEADING_ERROR = math.radians(0.5)
"""Standard deviation (rad) of how the robot looks along the line at the start."""
WHEEL_NOISE = 0.004
"""Standard deviation (m) of the way of one wheel after 1 m, by chance. Smooth floors have less."""


class RunKind(Enum):
    """The kinds of run, by what a person calls them."""

    LINE = "straight line"
    TURN = "turn on the spot"
    SQUARE = "square"


class RobotMarks(NamedTuple):
    """Where the two marks are on the robot.

    Attributes:
        front: way (m) from the axle of the wheels ahead to the front mark.
        apart: way (m) from the rear mark to the front mark.
    """

    front: float
    apart: float


class Tape(NamedTuple):
    """Two numbers (m) that the tape says at the end of a run.

    Of a line and a square: how far the front mark is ahead of where it was, and how far left. Of a turn: how far the
    front mark is left of the line, and how far the rear mark is.
    """

    first: float
    second: float


LEGAL_MARK = Number(-3.0, 3.0)
LEGAL_TAPE = Number(-30.0, 30.0)        # also of a line of 20 m by a robot that is wrong by as much as any
LEGAL_MARKS = {"front": Number(0.05, 2.0), "apart": Number(0.1, 3.0)}
NAMES = {
    RunKind.LINE: (("ahead", LEGAL_TAPE), ("left", LEGAL_TAPE)),
    RunKind.SQUARE: (("ahead", LEGAL_TAPE), ("left", LEGAL_TAPE)),
    RunKind.TURN: (("front mark left", LEGAL_MARK), ("rear mark left", LEGAL_MARK)),
}
"""The names of the two numbers of a tape, and what is legal in m."""


def check_turned(tape: Tape, marks: RobotMarks) -> None:
    """Check that the tape has the marks no farther apart than they are on the robot. Raises UsageError."""
    if abs(tape.first - tape.second) > marks.apart:
        raise UsageError(
            "the front mark %.3f m left and the rear mark %.3f m left: that is %.3f m from one to the other, but they"
            " are only %.3f m apart" % (*tape, abs(tape.first - tape.second), marks.apart))


def name_of(kind: RunKind, turns: int) -> str:
    """Return what a run is in words, such as "5 turns on the spot to the left"."""
    side = "left" if turns > 0 else "right"
    if kind is RunKind.TURN:
        return "%d turn%s on the spot to the %s" % (abs(turns), "" if abs(turns) == 1 else "s", side)
    return "straight line" if kind is RunKind.LINE else "square to the %s" % side


class TapedRun(NamedTuple):
    """One run: what odometry measured, and what the tape says.

    Attributes:
        kind: what was driven.
        turns: whole turns to the left, right is negative; of a line 0, of a square 1 or -1.
        track: by odometry.
        tape: at the end.
        marks: on the robot.
    """

    kind: RunKind
    turns: int
    track: OdometryTrack
    tape: Tape
    marks: RobotMarks

    @property
    def name(self) -> str:
        """What it is in words."""
        return name_of(self.kind, self.turns)

    @property
    def measured(self) -> Array:
        """What the tape says as numbers that odometry can say, too: ahead and left (m), or the whole turn (rad)."""
        if self.kind is RunKind.TURN:
            return np.array([self.turned])
        return np.array(self.tape)

    @property
    def turned(self) -> float:
        """The whole turn (rad) of a turn on the spot, by the tape."""
        beyond = math.asin((self.tape.first - self.tape.second) / self.marks.apart)
        return 2.0 * math.pi * self.turns + beyond

    def predicted(self, factors: Factors) -> Array:
        """Return the same numbers by corrected odometry."""
        end = self.track.end(factors)
        if self.kind is RunKind.TURN:
            return np.array([end.heading])
        front = self.marks.front
        return np.array([end.x + front * (math.cos(end.heading) - 1.0), end.y + front * math.sin(end.heading)])

    def covariance(self, rad_per_metre: float, factors: Factors, wheel_noise: float = WHEEL_NOISE) -> Array:
        """Return how far these numbers may be off: by wheels on a floor, by the tape, by how the robot was put."""
        noise = self.track.noise(wheel_noise, rad_per_metre, factors)
        end = self.track.end(factors)
        if self.kind is RunKind.TURN:
            beyond = (self.tape.first - self.tape.second) / self.marks.apart
            reading = 2.0 * TAPE_ERROR ** 2 / self.marks.apart ** 2 / max(0.01, 1.0 - beyond ** 2)
            return noise[2:, 2:] + reading + START_HEADING_ERROR ** 2
        front = self.marks.front
        of_mark = np.array([[1.0, 0.0, -front * math.sin(end.heading)], [0.0, 1.0, front * math.cos(end.heading)]])
        ahead, left = self.predicted(factors)
        of_start = np.array([[-left], [ahead + front]])
        return (of_mark @ noise @ of_mark.T + np.eye(2) * TAPE_ERROR ** 2
                + of_start @ of_start.T * START_HEADING_ERROR ** 2)


def tape_of(text: str, kind: RunKind) -> Tape:
    """Return the two numbers that a person types, in cm, such as "498.3 -2.5" or "498,3; -2,5".

    Args:
        text: what was typed.
        kind: of the run: it says which numbers are expected, and what is legal.

    Raises:
        UsageError: there are not two numbers, or one is not legal. The message names the value and what is legal.
    """
    names = NAMES[kind]
    words = text.replace(";", " ").split()
    if len(words) == 1 and words[0].count(",") == 1 and "." in words[0]:      # 498.3,-2.5
        words = words[0].split(",")
    if len(words) != 2:
        raise UsageError("%r is not two numbers in cm: %s, %s. For example: %s" % (
            text.strip(), names[0][0], names[1][0], "498.3 -2.5" if kind is RunKind.LINE else "1.2 -0.8"))
    return Tape(*(_centimetres(word, name, legal) for word, (name, legal) in zip(words, names)))


def _centimetres(word: str, name: str, legal: Number) -> float:
    try:
        return legal.accept(float(word.replace(",", ".")) / 100.0)
    except ValueError:
        raise UsageError("%s is %r: give a number from %g to %g, in cm" % (
            name, word, legal.low * 100.0, legal.high * 100.0)) from None


def mark_of(text: str, name: str, default: float) -> float:
    """Return a place of a mark (m) that a person types in cm; an empty text is the default.

    Raises:
        UsageError: it is no number, or not legal.
    """
    return default if not text.strip() else _centimetres(text.strip(), name, LEGAL_MARKS[name])


def whole_turns(text: str, likely: int) -> int:
    """Return how many whole turns a person types, left positive; an empty text is what is likely.

    Raises:
        UsageError: it is not a whole number from 1 to 50, or one that is negative.
    """
    try:
        count = int(text) if text.strip() else likely
    except ValueError:
        count = 0
    if not 1 <= abs(count) <= 50:
        raise UsageError("turns is %r: give a whole number from 1 to 50, to the right negative" % text.strip())
    return count
