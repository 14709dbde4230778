"""Loads the ``.map`` files of ARIA and MobileSim as worlds. These are text files in millimetres and degrees.

The lines of a map become the walls. In a map without lines, the scanned points become the walls. The points are put
into a grid whose cells are twice as wide as the resolution of the scan, so that no gaps stay between them. The borders
of the occupied cells become few long segments (see `grids.borders`).

The objects of a map: ``RobotHome`` is a start, ``Dock...`` is a dock, ``Goal`` and ``GoalWithHeading`` are goals,
``Sim.BoxObstacle`` is a box that never moves, ``Reflector`` is a wall that reflects light to a laser, and the sides of
``ForbiddenLine`` and ``ForbiddenArea`` are forbidden to navigation. All other objects are skipped, and `World.skipped`
lists them. In a map without a ``RobotHome``, the robot starts at the origin if there is room, else at the most spacious
place, else outside the walls.
"""

import collections
import math
import re
from pathlib import Path
from typing import Callable, Dict, List, NoReturn, Tuple

import numpy as np

from ...errors import WorldError
from .grids import borders, roomiest
from .materials import Material
from .poses import Point, Pose, Wall, closed, placed
from .world import START_CLEARANCE, World, begin_at

FIRST_LINE = "2D-Map"
OUTSIDE = 1.0
"""Distance (m), along x and along y, from the lower left corner of all walls to a start outside them.

A robot starts there when there is no room among the walls.
"""
START_CELL = 0.1
"""Side (m) of a cell of the grid that is searched for a start. In a world wider than 1000 cells, cells are larger."""
LEAST_CELL = 0.02
"""Least side (m) of a cell of the grid that the points of a map are put into."""
MOST_CELLS = 10000
"""Most cells along x, and along y, of the grid that the points of a map are put into."""
FARTHEST = 1e7
"""Greatest legal number in a map, either way: 10 km, in mm."""
QUIET_KEYS = {
    "MinPos", "MaxPos", "NumPoints", "PointsAreSorted", "Resolution", "LineMinPos", "LineMaxPos", "NumLines",
    "LinesAreSorted", "OriginLatLongAlt", "MapInfo",
}
"""Keys of the header that are skipped and not listed in `World.skipped`, because a world does not need them."""

NUMBER = r"\s+(\S+)"
CAIRN = re.compile(r"(\S+)" + 3 * NUMBER + r'\s+"[^"]*"\s+(\S+)\s+"([^"]*)"\s*(.*)')
CAIRN_FORM = 'Cairn: TYPE x y theta "" ICON "NAME" [x1 y1 x2 y2]'


class AriaMap:
    """Reads a map file of ARIA line by line, and makes a world of it.

    Args:
        path: path of the file. It gives the name of the world, and is named in errors.
    """

    def __init__(self, path: Path):
        self._path = path
        self._line = 1      # number of the line that is being read
        self._resolution = 0.1
        self._walls: List[Wall] = []
        self._solids: List[Wall] = []       # of boxes
        self._reflectors: List[Wall] = []
        self._boxes: List[List[Point]] = []
        self._forbidden: List[Wall] = []
        self._points: List[Point] = []
        self._starts: List[Pose] = []
        self._docks: List[Pose] = []
        self._goals: Dict[str, Pose] = {}
        self._skipped: Dict[str, List[int]] = collections.defaultdict(list)     # line numbers, by kind of entry

    def world(self, text: str) -> World:
        """Return the world of the map, whose file holds `text`.

        Raises:
            WorldError: the text is not a legal map.
        """
        first, *lines = map(str.strip, text.split("\n"))
        if first != FIRST_LINE:
            self.fail("the first line of an ARIA map must be %s, not %r" % (FIRST_LINE, first[:40]))
        take: Callable[[AriaMap, str], None] = AriaMap._header
        for self._line, line in enumerate(lines, 2):
            if line.rstrip(":") in SECTIONS:
                take = SECTIONS[line.rstrip(":")]
            elif line:
                take(self, line)
        skipped = ["%s, %s from line %s" % (kind, len(at), at[0]) if len(at) > 1 else "%s, line %s" % (kind, at[0])
                   for kind, at in self._skipped.items()]
        if self._points and self._walls:
            skipped.append("%s points: lines alone make the walls" % len(self._points))
        plain = (self._walls or self._walls_of_points()) + self._solids
        walls = plain + self._reflectors
        if not self._starts:
            self._starts = [self._find_start(walls)]
            skipped.append("no RobotHome in the map: %s" % begin_at(self._starts[0]))
        return World(self._path.stem, walls, starts=self._starts, docks=self._docks, goals=self._goals, skipped=skipped,
                     boxes=self._boxes, forbidden=self._forbidden,
                     materials=[Material.PLAIN] * len(plain) + [Material.REFLECTOR] * len(self._reflectors))

    def fail(self, message: str) -> NoReturn:
        """Raise a WorldError that names the file and the line that is being read."""
        raise WorldError("map %s, line %s: %s" % (self._path, self._line, message))

    def numbers(self, text: str, count: int, legal: str) -> List[float]:
        """Return the `count` finite numbers in `text`.

        Raises:
            WorldError: the text does not have exactly these numbers, and the message says that `legal` was expected; or
                a number is too great.
        """
        try:
            values = [float(word) for word in text.split()]
        except ValueError:
            values = []
        if len(values) != count or not all(map(math.isfinite, values)):
            self.fail("expected %s, not %r" % (legal, text))
        if any(abs(value) > FARTHEST for value in values):
            self.fail("%r: numbers from %g to %g (mm, 10 km) are legal" % (text, -FARTHEST, FARTHEST))
        return values

    # -- lines of a file, by the section they are in

    def _header(self, line: str) -> None:
        key, colon, value = line.partition(":")
        if not colon:
            self.fail("expected 'Key: value', LINES or DATA, not %r" % line[:60])
        if key == "Cairn":
            self._cairn(value.strip())
        elif key == "Resolution":
            (resolution,) = self.numbers(value, 1, "Resolution: mm, one number above 0")
            if resolution <= 0.0:
                self.fail("Resolution must be above 0 mm, not %g" % resolution)
            self._resolution = resolution / 1000.0
        elif key not in QUIET_KEYS:
            self._skipped["%s:" % key].append(self._line)

    def _wall(self, line: str) -> None:
        x1, y1, x2, y2 = self.numbers(line, 4, "four numbers, x1 y1 x2 y2 (mm), under LINES")
        if (x1, y1) == (x2, y2):
            self._skipped["a line without length"].append(self._line)
        else:
            self._walls.append((x1 / 1000.0, y1 / 1000.0, x2 / 1000.0, y2 / 1000.0))

    def _point(self, line: str) -> None:
        x, y = self.numbers(line, 2, "two numbers, x y (mm), under DATA")
        self._points.append((x / 1000.0, y / 1000.0))

    # -- objects

    def _cairn(self, text: str) -> None:
        kind = text.split(" ", 1)[0]
        known = [act for pattern, act in OBJECTS if re.fullmatch(pattern, kind)]
        if not known:
            self._skipped[kind or "a Cairn without a type"].append(self._line)
            return
        match = CAIRN.fullmatch(text)
        if not match:
            self.fail("expected %s, not 'Cairn: %s'" % (CAIRN_FORM, text))
        x, y, theta = self.numbers(" ".join(match.group(2, 3, 4)), 3, "x y theta (mm, degrees) in %s" % CAIRN_FORM)
        known[0](self, (x / 1000.0, y / 1000.0, math.radians(theta)), match.group(6), match.group(7))

    def _goal(self, pose: Pose, name: str, rest: str) -> None:
        name = name or "goal %s" % (len(self._goals) + 1)
        if name in self._goals:
            self._skipped["another goal named %r" % name].append(self._line)
        else:
            self._goals[name] = pose

    def _box(self, pose: Pose, name: str, rest: str) -> None:
        x1, y1, x2, y2 = self._extent(rest, "Sim.BoxObstacle")
        corners = placed(((x1, y1), (x2, y1), (x2, y2), (x1, y2)), (0.0, 0.0, pose[2]))
        self._solids += closed(corners)
        if x1 != x2 and y1 != y2:
            self._boxes.append(corners)

    def _reflector(self, pose: Pose, name: str, rest: str) -> None:
        self._reflectors.append(self._line_object(pose, rest, "Reflector"))

    def _forbidden_line(self, pose: Pose, name: str, rest: str) -> None:
        self._forbidden.append(self._line_object(pose, rest, "ForbiddenLine"))

    def _forbidden_area(self, pose: Pose, name: str, rest: str) -> None:
        x1, y1, x2, y2 = self._extent(rest, "ForbiddenArea")
        self._forbidden += closed(placed(((x1, y1), (x2, y1), (x2, y2), (x1, y2)), (0.0, 0.0, pose[2])))

    def _line_object(self, pose: Pose, rest: str, kind: str) -> Wall:
        x1, y1, x2, y2 = self._extent(rest, kind)
        start, end = placed(((x1, y1), (x2, y2)), (0.0, 0.0, pose[2]))
        return start + end

    def _extent(self, rest: str, kind: str) -> List[float]:
        x1, y1, x2, y2 = self.numbers(rest, 4, "x1 y1 x2 y2 (mm) at the end of a %s" % kind)
        if (x1, y1) == (x2, y2):
            self.fail("a %s from %g %g to itself; its corners must differ" % (kind, x1, y1))
        return [value / 1000.0 for value in (x1, y1, x2, y2)]

    # -- walls and a start, where the file does not give them

    def _walls_of_points(self) -> List[Wall]:
        if not self._points:
            return []
        side = max(2.0 * self._resolution, LEAST_CELL)
        at = np.floor(np.array(self._points) / side)
        low = at.min(axis=0)
        columns, rows = (at.max(axis=0) - low + 1).tolist()
        if max(columns, rows) > MOST_CELLS:
            raise WorldError(
                "map %s: its points lie %g m by %g m apart; with Resolution %g mm at most %g m are legal" % (
                    self._path, columns * side, rows * side, self._resolution * 1000, MOST_CELLS * side))
        cells = np.zeros((int(rows), int(columns)), dtype=bool)
        at_column, at_row = (at - low).astype(int).T
        cells[at_row, at_column] = True
        x, y = (low * side).tolist()
        return [(x1 * side + x, y1 * side + y, x2 * side + x, y2 * side + y) for x1, y1, x2, y2 in borders(cells)]

    def _find_start(self, walls: List[Wall]) -> Pose:
        if not walls:
            return (0.0, 0.0, 0.0)
        world = World(self._path.stem, walls)
        low_x, low_y, high_x, high_y = world.bounds
        side = max(START_CELL, max(high_x - low_x, high_y - low_y) / 1000.0)
        column_x, row_y = [low + side * (np.arange(int((high - low) / side) + 1) + 0.5)
                           for low, high in ((low_x, high_x), (low_y, high_y))]
        free = world.clearances(column_x, row_y, limit=side) >= side
        found = roomiest(free, (-low_x / side, -low_y / side), START_CLEARANCE / side)
        x, y = (low_x + found[0] * side, low_y + found[1] * side) if found else (low_x, low_y)
        return (x, y, 0.0) if world.clearance(x, y) >= START_CLEARANCE else (low_x - OUTSIDE, low_y - OUTSIDE, 0.0)


SECTIONS: Dict[str, Callable[[AriaMap, str], None]] = {"LINES": AriaMap._wall, "DATA": AriaMap._point}
"""Method that reads one line of a section, by the line that begins the section."""
OBJECTS: Tuple[Tuple[str, Callable[[AriaMap, Pose, str, str], None]], ...] = (
    ("RobotHome", lambda found, pose, name, rest: found._starts.append(pose)),
    (r"Dock\w*", lambda found, pose, name, rest: found._docks.append(pose)),
    ("Goal|GoalWithHeading", AriaMap._goal),
    (r"Sim\.BoxObstacle", AriaMap._box),
    ("Reflector", AriaMap._reflector),
    ("ForbiddenLine", AriaMap._forbidden_line),
    ("ForbiddenArea", AriaMap._forbidden_area),
)
"""Types of objects that become part of a world: a pattern of the type, and a function that adds one object.

The function gets the `AriaMap`, the object's pose (m, rad), its name, and the rest of its line.
"""
