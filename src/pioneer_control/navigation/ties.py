"""What ties one stretch of a path to another: odometry, to the next one; and walls that both heard, to any.

Walls tell where one stretch heard them relative to where the other one did, as that one drew them. From the begins of
both to there it is a way by the wheels. So what a tie measures changes with the lasting errors that the wheels are
found to have.
"""

import math
from typing import Any, List, NamedTuple, Optional, Sequence

import numpy as np

from ..floor_poses import Pose, compose, relative
from .frames import wrapped_angles
from .pose_graph import Between
from .sonar_grid import SonarBeams
from .stretch import Stretch
from .tuned import MapperNumbers, MatchNumbers
from .wheel_motion import WheelBias

Array = Any     # of numpy

_BIAS_STEP = 1e-4
_BEGIN = Pose(0.0, 0.0, 0.0)


class DrawnWalls(NamedTuple):
    """Walls that a stretch drew.

    Attributes:
        node: of the stretch.
        stretch: the stretch.
        pose: where its begin was when it drew them (map frame).
    """

    node: int
    stretch: Stretch
    pose: Pose


class HeardWalls(NamedTuple):
    """Readings with which another stretch heard these walls.

    Attributes:
        node: of that stretch.
        stretch: the stretch.
        which: numbers of the readings in it, array (n).
        hits: points (m, map frame) of the walls, one for each reading, array (n, 2).
        pose: where the readings have its begin (map frame).
        information: inverse (3 x 3) of the covariance (x, y (m), heading (rad)) of that.
    """

    node: int
    stretch: Stretch
    which: Array
    hits: Array
    pose: Pose
    information: Array


def by_odometry(number: int, stretch: Stretch, numbers: MapperNumbers) -> Between:
    """Return what odometry measured from the begin of a stretch, the node `number`, to its end, the next node."""
    root_way = math.sqrt(stretch.way + 0.01)
    turn = numbers.roll_turn * root_way + numbers.turn_turn * stretch.turned + 0.001
    along = numbers.roll * root_way + 0.002
    aside = along + 0.5 * turn * stretch.way
    ends = [stretch.end(each) for each in _biases(WheelBias())]
    return Between(number, number + 1, ends[0], np.diag((1.0 / along, 1.0 / aside, 1.0 / turn)), _change(ends), False)


def by_walls(drawn: DrawnWalls, heard: HeardWalls, bias: WheelBias, numbers: MapperNumbers,
             match_numbers: MatchNumbers) -> Optional[Between]:
    """Return where one stretch is relative to another, by walls that this one drew and that one heard.

    Args:
        drawn: what the other one drew.
        heard: what the stretch heard.
        bias: of the wheels, as it is known now.
        numbers, match_numbers: what was tuned.

    Returns:
        The measurement; None when no reading of the other one is of these walls.
    """
    drew = _that_hear(heard.hits, drawn.stretch.beams(bias).moved(*drawn.pose), match_numbers)
    if not len(drew):
        return None
    measured = relative(drawn.pose, heard.pose)
    drew_from = [_heard_from(drawn.stretch, drew, each) for each in _biases(bias)]
    heard_from = [_heard_from(heard.stretch, heard.which, each) for each in _biases(bias)]
    between = relative(drew_from[0], compose(measured, heard_from[0]))      # this is what the walls tell
    by_bias = _change([compose(compose(here, between), relative(there, _BEGIN))
                       for here, there in zip(drew_from, heard_from)])
    unbiased = Pose(*map(float, np.array(measured) - by_bias @ np.array(bias)))
    root = _root(heard.information, drawn.pose.heading, numbers)
    return Between(drawn.node, heard.node, unbiased, root, by_bias, True)


def _root(information: Array, heading: float, numbers: MapperNumbers) -> Array:
    """Return what `Between.root` is, of the inverse covariance of a pose (map frame), with slack.

    Args:
        information: the inverse covariance (3 x 3).
        heading: of the node to which the pose is relative.
        numbers: what was tuned.
    """
    slack = np.diag((numbers.slack ** 2, numbers.slack ** 2, numbers.slack_turn ** 2))
    information = np.linalg.solve(np.eye(3) + information @ slack, information)
    cosine, sine = math.cos(heading), math.sin(heading)
    turned = np.array(((cosine, sine, 0.0), (-sine, cosine, 0.0), (0.0, 0.0, 1.0)))
    values, vectors = np.linalg.eigh(turned @ information @ turned.T)
    return np.sqrt(np.maximum(values, 0.0))[:, None] * vectors.T


def _biases(bias: WheelBias) -> List[WheelBias]:
    """Return a bias of the wheels, and three in which one part differs a little."""
    return [bias] + [WheelBias(*np.array(bias) + step) for step in _BIAS_STEP * np.eye(3)]


def _change(measured: Sequence[Pose]) -> Array:
    """Return how a pose changes with the bias of the wheels, matrix (3 x 3), when it is this for each of `_biases`."""
    change = np.subtract(measured[1:], measured[0])
    change[:, 2] = wrapped_angles(change[:, 2])
    return change.T / _BIAS_STEP


def _heard_from(stretch: Stretch, which: Array, bias: WheelBias) -> Pose:
    """Return the mean pose of the transducers in some firings of a stretch, relative to its begin."""
    beams = stretch.beams(bias).chosen(which)
    return Pose(float(beams.x.mean()), float(beams.y.mean()), float(beams.heading.mean()))


def _that_hear(points: Array, beams: SonarBeams, numbers: MatchNumbers) -> Array:
    """Return the numbers of the beams that heard some points (m), array (n). One that heard several is there as often.
    """
    way_x, way_y = points[:, 0] - beams.x[:, None], points[:, 1] - beams.y[:, None]
    off = np.abs(wrapped_angles(np.arctan2(way_y, way_x) - beams.heading[:, None]))
    miss = np.abs(np.hypot(way_x, way_y) + numbers.nearer - beams.range[:, None])
    return np.nonzero((miss < 2.0 * numbers.blur) & (off < numbers.half_cone))[0]
