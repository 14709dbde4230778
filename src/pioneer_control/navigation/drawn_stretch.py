"""A stretch of path as a map has it: where it is drawn, and the walls that it drew alone."""

from typing import Any, List, Optional

import numpy as np

from ..floor_poses import Pose
from .frames import out_of
from .scan_match import wall_points
from .sonar_grid import SonarGrid, Votes
from .stretch import Stretch
from .tuned import MapNumbers
from .wheel_motion import WheelBias

Array = Any     # of numpy

_ROUNDS = 3
"""How often a stretch draws its own walls: each time, its echoes go to where it had walls before."""
_OTHER_BIAS = WheelBias(0.003, 0.003, 0.003)
"""They are drawn anew when the wheels are found to err so differently."""


class DrawnStretch:
    """A stretch, and how it is drawn at present.

    Args:
        stretch: the stretch.
        pose: of its begin (map frame).

    Attributes:
        votes: what it says about the cells of the map.
        count: of how many firings.
        pose: where its begin was when that was drawn (map frame).
    """

    def __init__(self, stretch: Stretch, pose: Pose) -> None:
        self.stretch, self.pose = stretch, pose
        self.votes: List[Votes] = []
        self.count = 0
        self._walls: Optional[Array] = None
        self._bias = WheelBias()

    @property
    def walls(self) -> Array:
        """Points on the walls that it drew alone, array (n, 2) of x, y (m, map frame). There are none before it did."""
        return np.zeros((0, 2)) if self._walls is None else np.stack(out_of(self.pose, *self._walls.T), axis=1)

    def draw_alone(self, bias: WheelBias, map_numbers: MapNumbers, least: float) -> bool:
        """Draw walls by its own readings alone, unless it has done so with nearly the same bias. Return whether it did.

        Args:
            bias: of the wheels.
            map_numbers: how it draws.
            least: log-odds from which a cell is a wall.
        """
        if self._walls is not None and (np.abs(np.subtract(bias, self._bias)) < _OTHER_BIAS).all():
            return False
        grid, beams = SonarGrid(map_numbers), self.stretch.beams(bias)
        votes = grid.votes(beams)
        for _ in range(_ROUNDS - 1):
            grid.add(votes)
            anew = grid.votes(beams)
            grid.add(votes, -1)
            votes = anew
        self._walls = wall_points(votes.occupied - votes.free, votes.row, votes.column, map_numbers.resolution, least)
        self._bias = bias
        return True
