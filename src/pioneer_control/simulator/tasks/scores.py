"""The rules of the tasks: samples of what one robot does come in, points and a note in words come out.

This file uses no robot and no clock. Lengths are in metres, times in seconds, coordinates in the frame of the arena.
"""

import functools
import math
from abc import ABC, abstractmethod
from typing import Dict, NamedTuple, Sequence, Tuple, Type

from ...errors import WorldError
from ..world import World
from ..world.geometry import Array
from ..world.poses import Point, hypot
from ..world.world import MarkedPlace
from .floor import ROOM, Floor

MOST = 100.0
"""Points of a robot that does everything, fast and without contact."""


class Sample(NamedTuple):
    """The true state of one robot at one time.

    Attributes:
        time: time (s) since the robot's first motion.
        x: x of the middle of the robot.
        y: y of the middle of the robot.
        contacts: how many times it has run into something.
        cans: the middles of the cans of its arena that stand on the floor. Held cans are left out.
    """

    time: float
    x: float
    y: float
    contacts: int = 0
    cans: Sequence[Point] = ()


class Score(NamedTuple):
    """Points, from 0 to `MOST`, and a note that says in words what they are for."""

    points: float
    note: str


class Rates(NamedTuple):
    """What time and contacts are worth.

    Attributes:
        limit_s: duration of the task.
        quick_s: up to this time all time points are given, at the limit none.
        time_points: most points for the time, when all is done.
        contact_points: what each contact costs.
    """

    limit_s: float
    quick_s: float
    time_points: float
    contact_points: float


class Rule(ABC):
    """Gives points to one robot. It is made anew when the robot begins again.

    Args:
        arena: the arena, with one start and its places.
        rates: what time and contacts are worth.

    Raises:
        WorldError: the arena has not what the rule needs.
    """

    def __init__(self, arena: World, rates: Rates):
        self._arena, self._rates = arena, rates
        self._time, self._contacts = 0.0, 0

    def take(self, sample: Sample) -> None:
        """Take the next sample. No more may come when all is done."""
        self._time, self._contacts = sample.time, sample.contacts
        self._look(sample)

    @property
    def score(self) -> Score:
        """The points that the robot has at present. Points for the time are among them only when all is done."""
        rates, share = self._rates, self._share
        points = share * (MOST - rates.time_points) - rates.contact_points * self._contacts
        words = [self._words]
        if self.done:
            late = (self._time - rates.quick_s) / (rates.limit_s - rates.quick_s)
            points += rates.time_points * (1.0 - min(max(late, 0.0), 1.0))
            words.append("%.1f s" % self._time)
        if self._contacts:
            words.append("1 contact" if self._contacts == 1 else "%d contacts" % self._contacts)
        return Score(round(max(points, 0.0), 1), ", ".join(words))

    @property
    @abstractmethod
    def done(self) -> bool:
        """Whether the robot has done everything."""

    @abstractmethod
    def _look(self, sample: Sample) -> None:
        """See what the robot has done until this sample."""

    @property
    @abstractmethod
    def _share(self) -> float:
        """How much of the points for the task itself the robot has, from 0 to 1."""

    @property
    @abstractmethod
    def _words(self) -> str:
        """What the robot has done, in words."""

    def _first_place(self) -> MarkedPlace:
        """Return the first place of the arena. Raises a WorldError if it has none."""
        if not self._arena.places:
            raise WorldError("arena %s: its rule needs a place" % self._arena.name)
        return self._arena.places[0]


class Marks(Rule):
    """The robot drives to all places of the arena, in their order, along straight lines.

    Args:
        straight_share: share of the points that is given for straight lines.
        crooked_m: mean distance from the lines at which this share is lost.
    """

    def __init__(self, arena: World, rates: Rates, straight_share: float, crooked_m: float):
        super().__init__(arena, rates)
        self._first_place()
        self._straight_share, self._crooked_m = straight_share, crooked_m
        self._corners = [arena.starts[0][:2], *((place.x, place.y) for place in arena.places)]
        self._reached, self._aside, self._samples = 0, 0.0, 0
        if any(begin == end for begin, end in zip(self._corners, self._corners[1:])):
            raise WorldError("arena %s: a mark is at the same place as the one before it" % arena.name)

    def _look(self, sample: Sample) -> None:
        sides = list(zip(self._corners, self._corners[1:]))[max(0, self._reached - 1):self._reached + 1]
        self._aside += min(_from_side((sample.x, sample.y), *side) for side in sides)
        self._samples += 1
        self._reached += self._arena.places[self._reached].contains(sample.x, sample.y)

    @property
    def done(self) -> bool:
        """Whether the robot was in all places."""
        return self._reached == len(self._arena.places)

    @property
    def _mean_aside(self) -> float:
        return self._aside / max(1, self._samples)

    @property
    def _share(self) -> float:
        crooked = min(1.0, self._mean_aside / self._crooked_m)
        return self._reached / len(self._arena.places) * (1.0 - self._straight_share * crooked)

    @property
    def _words(self) -> str:
        return "%d of %d marks, %.0f cm beside the lines" % (
            self._reached, len(self._arena.places), 100.0 * self._mean_aside)


class Reach(Rule):
    """The robot drives to the first place of the arena.

    Args:
        way_share: share of the points that a robot can get for coming near.
    """

    def __init__(self, arena: World, rates: Rates, way_share: float):
        super().__init__(arena, rates)
        self._place, self._way_share = self._first_place(), way_share
        self._floor, self._ways = _ways(arena)
        self._whole = self._left = float(self._ways[self._floor.cell(*arena.starts[0][:2])])
        self._there = False
        if not 0.0 < self._whole < math.inf:
            raise WorldError("arena %s: there is no way from the start to the place %r"
                             % (arena.name, self._place.name))

    def _look(self, sample: Sample) -> None:
        self._there = self._place.contains(sample.x, sample.y)
        self._left = min(self._left, float(self._ways[self._floor.cell(sample.x, sample.y)]))

    @property
    def done(self) -> bool:
        """Whether the robot is there."""
        return self._there

    @property
    def _share(self) -> float:
        return 1.0 if self._there else self._way_share * (1.0 - self._left / self._whole)

    @property
    def _words(self) -> str:
        return ("at the %s" if self._there else "still %.1f m to the %%s" % self._left) % self._place.name


class Sweep(Rule):
    """The robot drives over the whole floor.

    Args:
        enough: share of the floor that is enough for all points.
        broom_m: the robot sweeps what is not farther than this from its middle.
    """

    def __init__(self, arena: World, rates: Rates, enough: float, broom_m: float):
        super().__init__(arena, rates)
        self._enough, self._broom_m = enough, broom_m
        self._floor, self._whole = _sweepable(arena)
        self._swept = self._whole & False

    def _look(self, sample: Sample) -> None:
        self._swept |= self._floor.near(sample.x, sample.y, self._broom_m)

    @property
    def _swept_share(self) -> float:
        return int((self._swept & self._whole).sum()) / int(self._whole.sum())

    @property
    def done(self) -> bool:
        """Whether the robot has swept enough."""
        return self._swept_share >= self._enough

    @property
    def _share(self) -> float:
        return min(1.0, self._swept_share / self._enough)

    @property
    def _words(self) -> str:
        return "%d %% of the floor" % (100.0 * self._swept_share)


class BringCans(Rule):
    """The robot brings all cans of the arena to its first place. A can counts while no gripper holds it."""

    def __init__(self, arena: World, rates: Rates):
        super().__init__(arena, rates)
        self._place, self._all, self._there = self._first_place(), len(arena.cans), 0
        if not self._all:
            raise WorldError("arena %s: its rule needs cans" % arena.name)

    def _look(self, sample: Sample) -> None:
        self._there = sum(self._place.contains(x, y) for x, y in sample.cans)

    @property
    def done(self) -> bool:
        """Whether all cans are there."""
        return self._there == self._all

    @property
    def _share(self) -> float:
        return self._there / self._all

    @property
    def _words(self) -> str:
        return "%d of %d cans" % (self._there, self._all)


RULES: Dict[str, Type[Rule]] = {"marks": Marks, "reach": Reach, "sweep": Sweep, "cans": BringCans}
"""All rules, by their names in the table of tasks."""


@functools.lru_cache(maxsize=8)
def _ways(arena: World) -> Tuple[Floor, Array]:
    """Return the floor of an arena, and the lengths of all ways to its first place. Kept, as each robot needs them."""
    floor = Floor(arena)
    return floor, floor.ways_to(arena.places[0])


@functools.lru_cache(maxsize=8)
def _sweepable(arena: World) -> Tuple[Floor, Array]:
    """Return the floor of an arena, and its points that are to be swept. Kept, as each robot needs them."""
    floor = Floor(arena)
    return floor, floor.near_reachable(ROOM)


def _from_side(point: Point, begin: Point, end: Point) -> float:
    """Return the distance from a point to the line from `begin` to `end`."""
    along_x, along_y = end[0] - begin[0], end[1] - begin[1]
    to_x, to_y = point[0] - begin[0], point[1] - begin[1]
    share = (to_x * along_x + to_y * along_y) / (along_x * along_x + along_y * along_y)
    share = min(max(share, 0.0), 1.0)
    return hypot(to_x - share * along_x, to_y - share * along_y)
