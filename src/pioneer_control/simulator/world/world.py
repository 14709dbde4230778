"""The floor the simulated robot stands on: what its sonar sees, what stops its body, what its gripper can take.

A world knows nothing of robots' models or packets. Metres, radians, map frame (x and y of REP 103).
"""

import functools
import math
from dataclasses import dataclass
from types import MappingProxyType
from typing import List, Mapping, Optional, Protocol, Sequence, Tuple

import numpy as np

from ...errors import WorldError
from .crowd import Crowd
from .echoes import Ear
from .geometry import Array, Finder, Solids
from .grids import flood
from .poses import Point, Pose, hypot

SONAR_PLANE = 0.17
"""Height of the sonar above the floor (m): what is lower is not seen."""

FREE, OCCUPIED, UNKNOWN = 0, 100, -1
"""Values of an occupancy map, as nav_msgs/OccupancyGrid has them."""

START_CLEARANCE = 0.55
"""Least distance (m) of a start that no file names from anything solid: more than half the diagonal of any Pioneer."""

_CLOSE = 0.5  # m: where a body moves among solids, and few of them are near
_SIDE = 2.0  # m: of the squares of floor round which solids are found once
_KEPT_NEIGHBOURHOODS = 4096


class Holder(Protocol):
    """A gripper that holds cans."""

    @property
    def height(self) -> float:
        """How high (m) it lifts what it holds."""


@dataclass
class Can:
    """An upright tin, light enough to be pushed and small enough to be gripped; too low for the sonar.

    Attributes:
        held_by: the gripper that holds it, None while it stands on the floor.
    """

    x: float
    y: float
    radius: float = 0.033
    height: float = 0.115
    held_by: Optional[Holder] = None


def begin_at(start: Pose) -> str:
    """A sentence that says where robots begin, for files that do not say it."""
    return "robots begin at x %.2f, y %.2f" % start[:2]


class World:
    """Walls and posts that never move, cans that may, and the poses where a robot starts, charges or may be sent to.

    Args:
        walls: segments ``(x1, y1, x2, y2)``, none of length zero.
        posts: discs ``(x, y, radius)``, like the walls taller than the sonar plane.
        cans: what can be picked up; the list and its cans are the caller's to change.
        starts: poses ``(x, y, heading)``, at least one.
        docks: poses ``(x, y, heading)`` that a robot has while it charges; see `battery.stands_in`.
        goals: places by name, each a pose ``(x, y, heading)``; nothing here acts on them.
        skipped: what the file that it comes from says and this world has not, a sentence each.

    Raises:
        WorldError: for numbers that are not finite, a wall without length, a post or a can without size, no start.
    """

    def __init__(
        self,
        name: str,
        walls: Sequence[Sequence[float]] = (),
        posts: Sequence[Sequence[float]] = (),
        cans: Sequence[Can] = (),
        starts: Sequence[Pose] = ((0.0, 0.0, 0.0),),
        docks: Sequence[Pose] = (),
        goals: Mapping[str, Pose] = MappingProxyType({}),
        skipped: Sequence[str] = (),
    ):
        self.name = name
        self.walls = _table(name, "wall", walls, 4)
        self.posts = _table(name, "post", posts, 3)
        self.cans: List[Can] = list(cans)
        self.starts = _poses(name, "start", starts)
        self.docks = _poses(name, "dock", docks)
        self.goals = dict(zip(goals, _poses(name, "goal", list(goals.values()))))
        self.skipped = tuple(skipped)
        if not self.starts:
            raise WorldError("world %s: no start; a robot has to stand somewhere" % name)
        for number, (x1, y1, x2, y2) in enumerate(self.walls.tolist(), 1):
            if (x1, y1) == (x2, y2):
                raise WorldError("world %s: wall %s at (%g, %g) has no length" % (name, number, x1, y1))
        for kind, radii in (("post", self.posts[:, 2].tolist()), ("can", [can.radius for can in self.cans])):
            for number, radius in enumerate(radii, 1):
                if not radius > 0.0:
                    raise WorldError("world %s: %s %s has radius %g; must be above 0" % (name, kind, number, radius))
        self._solids = Solids(self.walls, self.posts)
        self.within = Finder(self._solids).within
        """Finds the walls and posts that come within a reach of a point: see `Finder.within`."""
        self._neighbourhood = functools.lru_cache(_KEPT_NEIGHBOURHOODS)(self._find)
        self.ear = functools.lru_cache(maxsize=None)(functools.partial(Ear, self))
        """What hears in this world for transducers of a kind, the same for all of that kind: see `Ear`."""
        self.crowd = Crowd()
        """The bodies of the robots of one `Simulation`, in each other's way."""
        places = [(x, y) for x, y, _ in (*self.starts, *self.docks, *self.goals.values())]
        corners = np.vstack((self._solids.corners(), places + [(can.x, can.y) for can in self.cans]))
        (low_x, low_y), (high_x, high_y) = corners.min(axis=0).tolist(), corners.max(axis=0).tolist()
        self.bounds: Tuple[float, float, float, float] = (low_x, low_y, high_x, high_y)
        """Least x and y, greatest x and y of everything."""

    def with_start(self, start: Pose) -> "World":
        """The same world, in which the first robot stands at `start` and the others at its own starts.

        It takes over the cans.
        """
        return World(
            self.name, self.walls.tolist(), self.posts.tolist(), self.cans, [start, *self.starts], self.docks,
            self.goals, self.skipped)

    def touches(self, outline_xy: Sequence[Point]) -> bool:
        """Whether a body overlaps any wall or post, also one that is wholly inside it. Cans give way and do not count.

        Args:
            outline_xy: (k, 2) corners of the body's polygon in order, convex or not.
        """
        xs, ys = zip(*outline_xy)
        low_x, low_y, high_x, high_y = min(xs), min(ys), max(xs), max(ys)
        # a circle round it
        x, y, radius = (low_x + high_x) / 2.0, (low_y + high_y) / 2.0, hypot(high_x - low_x, high_y - low_y) / 2.0
        solids = self._near(x, y, radius)
        return len(solids) > 0 and solids.overlap(outline_xy, x, y, radius)

    def clearance(self, x: float, y: float) -> float:
        """Distance from a point to the nearest wall or post: infinite where there is none, 0 inside a post."""
        close = self._near(x, y, _CLOSE).nearest(x, y)
        return close if close <= _CLOSE else self._solids.nearest(x, y)

    def clearances(self, column_x: Array, row_y: Array, limit: float = math.inf) -> Array:
        """Clearance at every crossing of a grid: (rows, columns), `limit` where it is more.

        Args:
            column_x: growing, as `row_y`.
            limit: a low one saves much time.
        """
        grid = np.full((len(row_y), len(column_x)), limit)
        for solid in self._solids.each():
            corners = solid.corners()
            (low_x, low_y), (high_x, high_y) = corners.min(axis=0), corners.max(axis=0)
            columns = slice(*np.searchsorted(column_x, (low_x - limit, high_x + limit)))
            rows = slice(*np.searchsorted(row_y, (low_y - limit, high_y + limit)))
            for distances in solid.distances(column_x[None, columns], row_y[rows, None]):
                nearest = np.minimum.reduce(distances, axis=2, initial=math.inf)
                grid[rows, columns] = np.minimum(grid[rows, columns], nearest)
        clearances: Array = np.maximum(grid, 0.0)
        return clearances

    def occupancy(self, resolution: float = 0.05, margin: float = 0.5) -> Tuple[Array, Tuple[float, float]]:
        """The world as a map of square cells, for RViz and pictures.

        Args:
            resolution: side of a cell.
            margin: how far the map goes beyond everything in the world.

        Returns:
            Int8 array (rows of growing y, columns of growing x) of `OCCUPIED` where a wall or post touches a cell's
            middle or passes within half a cell of it, `FREE` where a start can be reached from, else `UNKNOWN`; and
            the map-frame position of the corner with the smallest x and y.
        """
        low_x, low_y, high_x, high_y = self.bounds
        origin = (low_x - margin, low_y - margin)
        column_x, row_y = [
            low + (np.arange(math.ceil((high + margin - low) / resolution)) + 0.5) * resolution
            for low, high in zip(origin, (high_x, high_y))
        ]
        occupied = self.clearances(column_x, row_y, limit=resolution) <= resolution * math.sqrt(0.5)
        cells = np.full(occupied.shape, UNKNOWN, dtype=np.int8)
        start_cells = np.zeros_like(occupied)
        for x, y, _ in self.starts:
            start_cells[int((y - origin[1]) / resolution), int((x - origin[0]) / resolution)] = True
        cells[flood(start_cells, ~occupied)] = FREE
        cells[occupied] = OCCUPIED
        return cells, origin

    def _near(self, x: float, y: float, reach: float) -> Solids:
        """At least every solid within `reach` of a point, found once for each small square of floor and kept."""
        if not len(self._solids):   # an endless floor
            return self._solids
        # of a few sizes only, so that squares are shared
        return self._neighbourhood(math.floor(x / _SIDE), math.floor(y / _SIDE), math.ceil(reach))

    def _find(self, column: int, row: int, reach: int) -> Solids:
        """Every solid within `reach` of a square of floor."""
        return self.within((column + 0.5) * _SIDE, (row + 0.5) * _SIDE, reach + 0.7072 * _SIDE)


def _poses(name: str, kind: str, rows: Sequence[Pose]) -> List[Pose]:
    """Poses as plain numbers."""
    return [(x, y, heading) for x, y, heading in _table(name, kind, rows, 3).tolist()]


def _table(name: str, kind: str, rows: Sequence[Sequence[float]], width: int) -> Array:
    """Rows of numbers as a read-only array (n, width)."""
    table = np.array(rows, dtype=float).reshape(-1, width)
    wrong = np.flatnonzero(~np.isfinite(table).all(axis=1))
    if len(wrong):
        raise WorldError("world %s: %s %s has a number that is not finite" % (name, kind, wrong[0] + 1))
    table.setflags(write=False)
    return table
