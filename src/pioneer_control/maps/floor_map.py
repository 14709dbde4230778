"""A map with what people have written into it: places by name, starts, and lines that nobody should cross.

Coordinates are in metres, in the map frame; headings in radians.
"""

from dataclasses import dataclass, field
from typing import Dict, Tuple

import numpy as np

from ..errors import UsageError
from ..floor_poses import Pose
from ..parameters import nearest
from .grid_map import FORBIDDEN, GridMap

Line = Tuple[float, float, float, float]


@dataclass(frozen=True)
class FloorMap:
    """A map of a floor, with its named places.

    Attributes:
        name: of the map, for people.
        grid: the cells.
        goals: named places, with the heading that a robot has there.
        starts: where robots begin; may be empty.
        forbidden: lines x1, y1, x2, y2 (m) that a robot does not cross. Its sonar hears nothing of them.
    """

    name: str
    grid: GridMap
    goals: Dict[str, Pose] = field(default_factory=dict)
    starts: Tuple[Pose, ...] = ()
    forbidden: Tuple[Line, ...] = ()

    def goal(self, name: str) -> Pose:
        """Return the place of a name.

        Raises:
            UsageError: there is none. The message lists the places that there are.
        """
        if name in self.goals:
            return self.goals[name]
        near = nearest(name, self.goals)
        hint = "did you mean %r? " % near if near else ""
        known = ", ".join(map(repr, self.goals)) or "none"
        raise UsageError("no place named %r on the map %s; %sknown: %s" % (name, self.name, hint, known))

    def drivable(self) -> GridMap:
        """Return the grid for planning: as `grid`, with `FORBIDDEN` cells where its forbidden lines are."""
        if not self.forbidden:
            return self.grid
        cells = self.grid.cells.copy()
        for x1, y1, x2, y2 in self.forbidden:
            steps = int(2.0 * np.hypot(x2 - x1, y2 - y1) / self.grid.resolution) + 2
            row, column = self.grid.cell(np.linspace(x1, x2, steps), np.linspace(y1, y2, steps))
            inside = (row >= 0) & (row < cells.shape[0]) & (column >= 0) & (column < cells.shape[1])
            cells[row[inside], column[inside]] = FORBIDDEN
        return GridMap(cells, self.grid.resolution, self.grid.origin)
