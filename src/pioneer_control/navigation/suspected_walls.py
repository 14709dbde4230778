"""Walls that may go on where no sonar hears them, beside a robot that makes its map.

A wall that slants away from a beam gives no echo. So a robot that drives along a wall hears it beside, but not where it
goes on ahead; the map there is free, by sound that went past. Only a beam that meets the wall about squarely, and goes
on, tells that it has ended. Until then it is suspected to go on for a little.
"""

import math
from collections import deque
from typing import Any, Deque, Optional, Tuple

import numpy as np

from ..floor_poses import Pose
from ..robots import HALF_CONE
from .frames import into, turned, wrapped_angles
from .sonar_grid import SonarBeams
from .tuned import SuspicionNumbers
from .wall_directions import most_agree

Array = Any     # of numpy

_TRIED = np.radians(np.arange(0.0, 180.0, 4.0))
"""Directions (rad) across a wall that are tried first."""
_MOST_WALLS = 3
_STEP = 0.04
"""Distance (m) of the places that stand for a suspected wall."""
_THROUGH = math.tan(0.7 * HALF_CONE)
"""A beam passes what is nearer to its axis than this share of the way there: the edge of a cone may hear nothing."""
_DROVE, _DROVE_STEP = 200, 0.1      # poses; m


class SuspectedWalls:
    """Walls that may go on, but not where the robot has driven.

    Args:
        half_width: of the robot (m).
        numbers: how far they are suspected.
    """

    def __init__(self, half_width: float, numbers: SuspicionNumbers):
        self._half_width, self._numbers = half_width, numbers
        self._drove: Deque[Pose] = deque(maxlen=_DROVE)

    def drive(self, odometry: Pose) -> None:
        """The robot is here now."""
        if not self._drove or math.hypot(odometry.x - self._drove[-1].x, odometry.y - self._drove[-1].y) > _DROVE_STEP:
            self._drove.append(odometry)

    def forget(self) -> None:
        """The frame of odometry is another one now: forget where the robot has driven."""
        self._drove.clear()

    def places(self, x: Array, y: Array, looks: SonarBeams, odometry: Pose) -> Tuple[Array, Array]:
        """Return places (m, robot's frame) where walls may go on.

        Args:
            x, y: places of walls (m, robot's frame).
            looks: the last firings, in the frame of odometry.
            odometry: the robot's pose in it.
        """
        beams = SonarBeams(*into(odometry, looks.x, looks.y), looks.heading - odometry.heading, looks.range)
        x, y = suspected_walls(x, y, beams, self._numbers)
        drove_x, drove_y = into(odometry, *np.array([each[:2] for each in self._drove]).reshape(-1, 2).T)
        left = (np.hypot(x[:, np.newaxis] - drove_x, y[:, np.newaxis] - drove_y) > self._half_width).all(axis=1)
        return x[left], y[left]


def suspected_walls(x: Array, y: Array, beams: SonarBeams, numbers: SuspicionNumbers) -> Tuple[Array, Array]:
    """Return places (m) where straight walls beside the robot may go on.

    Args:
        x, y: places of walls (m, robot's frame).
        beams: the last firings, in the same frame.
        numbers: how far it is suspected.
    """
    near = np.hypot(x, y) < numbers.near
    points, ends = np.column_stack((x[near], y[near])), [np.zeros((0, 2))]
    for _ in range(_MOST_WALLS):
        wall = _wall(points, numbers)
        if wall is None:
            break
        across, distance, fits = wall
        ends.append(_ends(points[fits], across, distance, beams, numbers))
        points = points[~fits]
    places = np.concatenate(ends)
    return places[:, 0], places[:, 1]


def _wall(points: Array, numbers: SuspicionNumbers) -> Optional[Tuple[float, float, Array]]:
    """Return of the straight wall on which most points lie the direction across it (rad), how far (m) it is from the
    origin that way, and a mask of its points; None if there is none.
    """
    if len(points) < numbers.least:
        return None
    distances = np.outer(np.cos(_TRIED), points[:, 0]) + np.outer(np.sin(_TRIED), points[:, 1])
    best, distance = most_agree(distances, np.ones(distances.shape, dtype=bool), numbers.band)
    across = float(_TRIED[best])
    for _ in range(2):
        along, off = _from_wall(points, across, distance)
        fits = np.abs(off) < numbers.band
        if fits.sum() < numbers.least:
            return None
        slope = np.polyfit(along[fits], off[fits], 1)[0] if np.ptp(along[fits]) > numbers.span / 2.0 else 0.0
        across -= math.atan(slope)
        distance = float((points[fits] @ (math.cos(across), math.sin(across))).mean())
    along, off = _from_wall(points, across, distance)
    fits = np.abs(off) < numbers.band
    return (across, distance, fits) if fits.any() and np.ptp(along[fits]) >= numbers.span else None


def _from_wall(points: Array, across: float, distance: float) -> Tuple[Array, Array]:
    """Return where points lie along a wall (m), and how far beyond it (m)."""
    off, along = turned(points[:, 0], points[:, 1], -across)
    return along, off - distance


def _ends(points: Array, across: float, distance: float, beams: SonarBeams, numbers: SuspicionNumbers) -> Array:
    """Return the places, array (n, 2), where a wall may go on beyond both its ends."""
    along, _ = _from_wall(points, across, distance)
    steps = np.arange(_STEP, numbers.reach, _STEP)
    places = np.column_stack(turned(distance, np.concatenate((along.max() + steps, along.min() - steps)), across))
    squarely = np.abs(np.abs(wrapped_angles(beams.heading - across)) - math.pi / 2.0) > (
        math.pi / 2.0 - numbers.square)
    beams = beams.chosen(squarely)
    ahead, aside = turned(places[:, 0] - beams.x[:, np.newaxis], places[:, 1] - beams.y[:, np.newaxis],
                          -beams.heading[:, np.newaxis])
    passed = (np.abs(aside) < ahead * _THROUGH + _STEP) & (ahead < beams.range[:, np.newaxis] - numbers.passed)
    return places[~passed.any(axis=0)]
