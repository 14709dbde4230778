"""Where the gripper is when the joints have given angles, and the other way round. Pure geometry (arm sheet 16).

Angles t1 to t5 are in rad: base, shoulder, elbow, roll, wrist. All 0 is the arm stretched straight ahead. Positive is:
t1 left, t2, t3 and t5 up, t4 about the forward axis by the right-hand rule. Positions are in m, from the arm's origin:
on the axis of its base, at the height of the shoulder; x ahead, y left, z up.
"""

import math
from typing import List, NamedTuple, Sequence, Tuple

from ..errors import UsageError

Vector = Tuple[float, float, float]
Angles = Tuple[float, float, float, float, float]


class ArmShape(NamedTuple):
    """Lengths of the parts (m)."""

    base: float = 0.06875
    """Axis of the base to that of the shoulder, horizontal."""
    upper_arm: float = 0.16
    """Shoulder to elbow."""
    forearm: float = 0.13775
    """Elbow to wrist; the roll joint is at the elbow."""
    hand: float = 0.11321
    """Wrist to the gripper's reference point."""

    @property
    def reach(self) -> float:
        """Distance of the reference point from the axis of the base, stretched out."""
        return sum(self)


PIONEER_ARM = ArmShape()
STRAIGHT = 1e-9
"""A wrist bent by less than this (its sine) counts as straight: then the roll has no effect on the approach."""


class GripperPose(NamedTuple):
    """Where the gripper is, in the frame of the arm."""

    position: Vector
    """Of its reference point."""
    approach: Vector
    """Unit vector: where it points."""
    up: Vector
    """Unit vector: its upper side."""


def forward(angles: Sequence[float], shape: ArmShape = PIONEER_ARM) -> GripperPose:
    """Return where the gripper is with these five angles."""
    turn, shoulder, elbow, roll, wrist = angles
    ahead = _ahead(turn)
    left = (-math.sin(turn), math.cos(turn), 0.0)
    along, across = _tilted(ahead, shoulder + elbow)
    at_wrist = _sum((shape.base, ahead), (shape.upper_arm, _tilted(ahead, shoulder)[0]), (shape.forearm, along))
    rolled = _sum((-math.sin(roll), left), (math.cos(roll), across))
    approach = _sum((math.cos(wrist), along), (math.sin(wrist), rolled))
    up = _sum((-math.sin(wrist), along), (math.cos(wrist), rolled))
    return GripperPose(_sum((1.0, at_wrist), (shape.hand, approach)), approach, up)


def inverse(position: Vector, approach: Vector, shape: ArmShape = PIONEER_ARM) -> List[Angles]:
    """Return the angles with which the gripper is at ``position`` and points to ``approach``: up to four solutions.

    The base may look to the wrist or away from it, and the elbow may be up or down. Roll and wrist have two solutions
    for each of these, half a turn of the roll apart: the one whose roll is at most a quarter turn is returned, because
    the servo turns no farther. Limits of joints are not looked at.

    Args:
        position: where the reference point of the gripper shall be (m).
        approach: where the gripper shall point; of any length but 0.
        shape: lengths of the parts.

    Raises:
        UsageError: a number is not finite, the approach is 0, or the arm does not reach as far.
    """
    length = math.sqrt(sum(value * value for value in approach))
    if not all(map(math.isfinite, (*position, length))) or not length:
        raise UsageError("position %s and approach %s must be finite, and the approach not 0" % (position, approach))
    pointing = approach[0] / length, approach[1] / length, approach[2] / length
    x, y, height = _sum((1.0, position), (-shape.hand, pointing))
    turn = math.atan2(y, x)
    found = []
    for angle, out in ((turn, math.hypot(x, y)), (turn + math.pi, -math.hypot(x, y))):
        for shoulder, elbow in _two_links(out - shape.base, height, shape):
            found.append(_solution(angle, shoulder, elbow, pointing))
    if not found:
        nearest, farthest = abs(shape.upper_arm - shape.forearm), shape.upper_arm + shape.forearm
        raise UsageError(
            "the arm does not reach (%.3f, %.3f, %.3f) so: its wrist would be %.3f m from the shoulder, and it can be"
            " %.3f to %.3f m" % (*position, math.hypot(math.hypot(x, y) - shape.base, height), nearest, farthest))
    return found


def _two_links(out: float, height: float, shape: ArmShape) -> List[Tuple[float, float]]:
    """Return shoulder and elbow (rad) that bring the wrist ``out`` and up (m) from the shoulder: elbow down, then up.

    An empty list when it is out of reach, one pair when the arm must be straight.
    """
    upper, lower = shape.upper_arm, shape.forearm
    cosine = (out * out + height * height - upper * upper - lower * lower) / (2.0 * upper * lower)
    if abs(cosine) > 1.0 + STRAIGHT:
        return []
    bend = math.acos(max(-1.0, min(1.0, cosine)))
    return [(math.atan2(height, out) - math.atan2(lower * math.sin(elbow), upper + lower * math.cos(elbow)), elbow)
            for elbow in ((bend, -bend) if bend else (bend,))]


def _solution(turn: float, shoulder: float, elbow: float, approach: Vector) -> Angles:
    """Return all five angles, when the first three are known: roll and wrist turn the gripper to the approach."""
    along, across = _tilted(_ahead(turn), shoulder + elbow)
    left = (-math.sin(turn), math.cos(turn), 0.0)
    ahead, aside, up = _dot(approach, along), _dot(approach, left), _dot(approach, across)
    bend = math.hypot(aside, up)
    roll = math.atan2(-aside, up) if bend > STRAIGHT else 0.0
    if abs(roll) > math.pi / 2.0:
        roll, bend = roll - math.copysign(math.pi, roll), -bend
    return _wrapped(turn), _wrapped(shoulder), _wrapped(elbow), roll, math.atan2(bend, ahead)


def _ahead(turn: float) -> Vector:
    """Return the horizontal direction of an arm whose base is turned."""
    return math.cos(turn), math.sin(turn), 0.0


def _tilted(ahead: Vector, angle: float) -> Tuple[Vector, Vector]:
    """Return the direction that is ``angle`` above ``ahead``, and the one a quarter turn above that."""
    return (_sum((math.cos(angle), ahead), (math.sin(angle), (0.0, 0.0, 1.0))),
            _sum((-math.sin(angle), ahead), (math.cos(angle), (0.0, 0.0, 1.0))))


def _sum(*terms: Tuple[float, Vector]) -> Vector:
    """Return the sum of vectors, each with its factor."""
    return (sum(factor * vector[0] for factor, vector in terms), sum(factor * vector[1] for factor, vector in terms),
            sum(factor * vector[2] for factor, vector in terms))


def _dot(one: Vector, other: Vector) -> float:
    return one[0] * other[0] + one[1] * other[1] + one[2] * other[2]


def _wrapped(angle: float) -> float:
    """Return the same angle, between -pi and pi."""
    return math.remainder(angle, 2.0 * math.pi)
