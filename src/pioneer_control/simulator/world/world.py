"""The world of simulated robots: walls and posts that sonar detects and that stop a body, and cans for the gripper.

This file does not depend on robot models or packets. Lengths are in metres, angles in radians, coordinates in the map
frame (x and y of REP 103).
"""

import functools
import math
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, Dict, List, Mapping, NamedTuple, Optional, Protocol, Sequence, Tuple

import numpy as np

from ...errors import WorldError
from ...maps import FREE, OCCUPIED, UNKNOWN
from .crowd import Crowd
from .geometry import Array, Solids, joined
from .grids import flood
from .materials import Material
from .mirrors import ear_of
from .poses import Point, Pose, Wall, closed, hypot

SONAR_PLANE = 0.17
"""Height (m) of the sonar above the floor. The sonar does not detect lower objects."""

START_CLEARANCE = 0.55
"""Least distance (m) between a start that this package chooses itself and any wall or post.

It is more than half the diagonal of any Pioneer.
"""

_SIDE = 2.0  # m: side of the squares of floor for which near walls and posts are found once and kept
_KEPT_NEIGHBOURHOODS = 4096


class Holder(Protocol):
    """A gripper that holds cans."""

    @property
    def height(self) -> float:
        """The height (m) to which the gripper has lifted its cans, above the lowest position of the paddles."""


@dataclass
class Can:
    """An upright can that a robot can push, and that a gripper can hold if it is not too wide. Sonar cannot detect it.

    Attributes:
        x: x of its middle (m, map frame).
        y: y of its middle (m, map frame).
        radius: its radius (m).
        height: its height (m).
        held_by: the gripper that holds the can. None while the can stands on the floor.
    """

    x: float
    y: float
    radius: float = 0.033
    height: float = 0.115
    held_by: Optional[Holder] = None


class MarkedPlace(NamedTuple):
    """A place on the floor with a name, into which cans are brought: a rectangle or a disc. Robots cannot sense it.

    `x` and `y` are its middle (m, map frame). `size` has the sides of the rectangle along x and y, or the diameter of
    the disc alone (m).
    """

    name: str
    x: float
    y: float
    size: Tuple[float, ...]

    def contains(self, x: float, y: float) -> bool:
        """Return whether a point (m, map frame) is in this place, or on its border."""
        if len(self.size) == 1:
            return hypot(x - self.x, y - self.y) <= self.size[0] / 2.0
        return abs(x - self.x) <= self.size[0] / 2.0 and abs(y - self.y) <= self.size[1] / 2.0


class Furniture(NamedTuple):
    """Something that stands on the floor: a box by its four corners, or posts ``(x, y, radius)`` that belong together.

    The other of the two is empty. `material` is what light finds at it.
    """

    corners: Tuple[Point, ...] = ()
    posts: Tuple[Tuple[float, float, float], ...] = ()
    material: Material = Material.PLAIN

    @property
    def walls(self) -> List[Wall]:
        """The sides of the box."""
        return closed(self.corners)

    @property
    def solids(self) -> Solids:
        """The walls and posts in the form for computation."""
        walls, posts = np.array(self.walls).reshape(-1, 4), np.array(self.posts).reshape(-1, 3)
        return Solids(walls, posts, np.full(len(walls) + len(posts), int(self.material)))


class Walk(NamedTuple):
    """How a person walks: to and fro along the corners of `path` (m, map frame), or to random places by `seed`.

    `path` is empty, or has two points or more. `speed` is in m/s; `pause` is the rest (s) at each end of a way. A
    person looks, and does not walk into a robot. If `blind`, the person walks on.
    """

    path: Tuple[Point, ...] = ()
    seed: int = 0
    speed: float = 0.5
    pause: float = 2.0
    blind: bool = False


def begin_at(start: Pose) -> str:
    """Return a text with x and y (m, map frame) of a start. It is reported to users of a map file that has no start."""
    return "robots begin at x %.2f, y %.2f" % start[:2]


class World:
    """The walls and posts of a floor, its cans, and its starts, docks and goals (m, rad; map frame).

    Args:
        name: name of the world, for users and errors.
        walls: segments ``(x1, y1, x2, y2)``, none of length zero. They never move.
        posts: discs ``(x, y, radius)``, taller than the sonar plane, as walls are. They never move.
        cans: objects that a gripper can pick up. The caller may change each `Can`, and the list `World.cans`.
        starts: poses ``(x, y, heading)`` at which robots start, at least one.
        docks: poses ``(x, y, heading)`` of a robot while it charges; see `battery.stands_in`.
        goals: poses ``(x, y, heading)`` by name. The simulator does not use them.
        skipped: one sentence for each entry of the world's file that is not part of this world.
        boxes: corners of each filled obstacle, for those who draw it. Its walls are among `walls`.
        places: places with names, into which cans are brought. The simulator only tells which cans stand there.
        forbidden: segments, as of `walls`, that robots are asked not to cross. The simulator does not use them.
        unmapped: obstacles that are on no map. They are solid, and sonar detects them.
        walks: how people walk in this world.
        materials: the `Material` of each wall, then of each post. Empty: all are plain.

    Attributes:
        walls, posts: arrays ``(n, 4)`` and ``(n, 3)`` of what is on a map.
        solids: all walls and posts, with those of `unmapped`, in the form for computation.

    Raises:
        WorldError: a number is not finite, a wall has no length, a post or can has no size, there is no start, or the
            materials are not as many as walls and posts.
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
        boxes: Sequence[Sequence[Point]] = (),
        places: Sequence[MarkedPlace] = (),
        forbidden: Sequence[Sequence[float]] = (),
        unmapped: Sequence[Furniture] = (),
        walks: Sequence[Walk] = (),
        materials: Sequence[int] = (),
    ):
        self.name = name
        self.walls = _table(name, "wall", walls, 4)
        self.posts = _table(name, "post", posts, 3)
        self.cans: List[Can] = list(cans)
        self.starts = _poses(name, "start", starts)
        self.docks = _poses(name, "dock", docks)
        self.goals = dict(zip(goals, _poses(name, "goal", list(goals.values()))))
        self.skipped = tuple(skipped)
        self.boxes = [tuple(corners) for corners in boxes]
        self.places = list(places)
        self.forbidden = _table(name, "forbidden line", forbidden, 4)
        self.unmapped = list(unmapped)
        self.walks = list(walks)
        if not self.starts:
            raise WorldError("world %s: no start; a robot has to stand somewhere" % name)
        for number, (x1, y1, x2, y2) in enumerate(self.walls.tolist(), 1):
            if (x1, y1) == (x2, y2):
                raise WorldError("world %s: wall %s at (%g, %g) has no length" % (name, number, x1, y1))
        for kind, radii in (("post", self.posts[:, 2].tolist()), ("can", [can.radius for can in self.cans])):
            for number, radius in enumerate(radii, 1):
                if not radius > 0.0:
                    raise WorldError("world %s: %s %s has radius %g; must be above 0" % (name, kind, number, radius))
        if len(materials) not in (0, len(self.walls) + len(self.posts)):
            raise WorldError("world %s: %d materials for %d walls and %d posts; give one for each, or none"
                             % (name, len(materials), len(self.walls), len(self.posts)))
        self._mapped = self.solids = Solids(
            self.walls, self.posts, np.array(materials, dtype=int) if len(materials) else None)
        if self.unmapped:
            self.solids = joined([self._mapped, *(each.solids for each in self.unmapped)])
        self._neighbourhood = functools.lru_cache(_KEPT_NEIGHBOURHOODS)(self._find)
        self.ear = functools.lru_cache(maxsize=None)(functools.partial(ear_of, self))
        """Function that returns the `Ear` of this world for sonar transducers with the given cone.

        It takes the arguments of `ear_of` without the world. Equal arguments give the same `Ear`.
        """
        self.crowd = Crowd()
        """The bodies of the robots of one `Simulation`, which are obstacles to each other."""
        points = [(x, y) for x, y, _ in (*self.starts, *self.docks, *self.goals.values())]
        points += [(place.x, place.y) for place in self.places] + [(can.x, can.y) for can in self.cans]
        corners = np.vstack((self.solids.corners(), points))
        (low_x, low_y), (high_x, high_y) = corners.min(axis=0).tolist(), corners.max(axis=0).tolist()
        self.bounds: Tuple[float, float, float, float] = (low_x, low_y, high_x, high_y)
        """Smallest x and y, then largest x and y (m, map frame) of all that is in the world."""

    @property
    def materials(self) -> List[int]:
        """The `Material` of each wall, then of each post, without those of `unmapped`."""
        found: List[int] = self._mapped.materials.tolist()
        return found

    def with_start(self, start: Pose) -> "World":
        """Return a copy of this world with `start` (m, rad; map frame) before its other starts.

        The copy uses the same `Can` objects.
        """
        return self.changed(starts=[start, *self.starts])

    def changed(self, **changes: Any) -> "World":
        """Return a copy of this world with other values for some arguments. The copy uses the same `Can` objects.

        With other walls or posts all of them are plain, unless `materials` are given, too.
        """
        values: Dict[str, Any] = dict(
            name=self.name, walls=self.walls.tolist(), posts=self.posts.tolist(), cans=self.cans, starts=self.starts,
            docks=self.docks, goals=self.goals, skipped=self.skipped, boxes=self.boxes, places=self.places,
            forbidden=self.forbidden.tolist(), unmapped=self.unmapped, walks=self.walks,
            materials=() if changes.keys() & {"walls", "posts"} else self.materials)
        return World(**{**values, **changes})

    def touches(self, outline_xy: Sequence[Point]) -> bool:
        """Return whether a body overlaps any wall or post, or has one inside its outline. Cans are ignored.

        Args:
            outline_xy: corners of the body's polygon in order (m, map frame), convex or not.
        """
        xs, ys = zip(*outline_xy)
        low_x, low_y, high_x, high_y = min(xs), min(ys), max(xs), max(ys)
        # a circle around the outline
        x, y, radius = (low_x + high_x) / 2.0, (low_y + high_y) / 2.0, hypot(high_x - low_x, high_y - low_y) / 2.0
        solids = self._near(x, y, radius)
        return len(solids) > 0 and solids.overlap(outline_xy, x, y, radius)

    def clearance(self, x: float, y: float) -> float:
        """Return the distance (m) from a point (m, map frame) to the nearest wall or post.

        It is infinite in a world without walls and posts, and 0 inside a post.
        """
        distances = np.concatenate(self.solids.distances(np.array(x), np.array(y)))
        return max(0.0, float(distances.min(initial=math.inf)))

    def clearances(self, column_x: Array, row_y: Array, limit: float = math.inf) -> Array:
        """Return the distance (m) to the nearest wall or post from every point of a grid, as an array (rows, columns).

        Args:
            column_x: x of the columns (m, map frame), in increasing order.
            row_y: y of the rows (m, map frame), in increasing order.
            limit: largest distance (m) to return. Larger distances are returned as `limit`. A low limit saves time.
        """
        return self.solids.clearances(column_x, row_y, limit)

    def occupancy(self, resolution: float = 0.05, margin: float = 0.5) -> Tuple[Array, Tuple[float, float]]:
        """Return the world as an occupancy map with square cells, for RViz and pictures. It has nothing of `unmapped`.

        Args:
            resolution: side of a cell (m).
            margin: distance (m) from the bounds of the world to the border of the map.

        Returns:
            First an int8 array (rows of increasing y, columns of increasing x). A cell is `OCCUPIED` when a wall or a
            post is not farther from its middle than half its diagonal. It is `FREE` when a start can be reached from
            it. All other cells are `UNKNOWN`. Second the position (m, map frame) of the map's corner with the smallest
            x and y.
        """
        low_x, low_y, high_x, high_y = self.bounds
        origin = (low_x - margin, low_y - margin)
        column_x, row_y = [
            low + (np.arange(math.ceil((high + margin - low) / resolution)) + 0.5) * resolution
            for low, high in zip(origin, (high_x, high_y))
        ]
        occupied = self._mapped.clearances(column_x, row_y, limit=resolution) <= resolution * math.sqrt(0.5)
        cells = np.full(occupied.shape, UNKNOWN, dtype=np.int8)
        start_cells = np.zeros_like(occupied)
        for x, y, _ in self.starts:
            start_cells[int((y - origin[1]) / resolution), int((x - origin[0]) / resolution)] = True
        cells[flood(start_cells, ~occupied)] = FREE
        cells[occupied] = OCCUPIED
        return cells, origin

    def _near(self, x: float, y: float, reach: float) -> Solids:
        """Return all walls and posts within `reach` (m) of a point, and some farther ones.

        They are found once for each small square of floor and then kept.
        """
        if not len(self.solids):   # an endless floor
            return self.solids
        # whole metres only, so that calls with similar reaches share the kept squares
        return self._neighbourhood(math.floor(x / _SIDE), math.floor(y / _SIDE), math.ceil(reach))

    def _find(self, column: int, row: int, reach: int) -> Solids:
        """Return all walls and posts within `reach` (m) of the square of floor in this column and row."""
        return self.solids.within((column + 0.5) * _SIDE, (row + 0.5) * _SIDE, reach + 0.7072 * _SIDE)


def _poses(name: str, kind: str, rows: Sequence[Pose]) -> List[Pose]:
    """Return poses as tuples of floats. `name` and `kind` are for errors.

    Raises:
        WorldError: a number is not finite.
    """
    return [(x, y, heading) for x, y, heading in _table(name, kind, rows, 3).tolist()]


def _table(name: str, kind: str, rows: Sequence[Sequence[float]], width: int) -> Array:
    """Return rows of numbers as a read-only array (n, width). `name` and `kind` are for errors.

    Raises:
        WorldError: a number is not finite.
    """
    table = np.array(rows, dtype=float).reshape(-1, width)
    wrong = np.flatnonzero(~np.isfinite(table).all(axis=1))
    if len(wrong):
        raise WorldError("world %s: %s %s has a number that is not finite" % (name, kind, wrong[0] + 1))
    table.setflags(write=False)
    return table
