"""Collectors keep what navigation said in a bag: where it believed to be, its plans, its cloud, its goals, and its map.

Their memory stays small however long the bag is, as that of `collectors`.
"""

import math
from typing import Any, List, Optional, Tuple

import numpy as np

from .collectors import CHANGE_OF_PLACE, SpanCollector, Thinned, heading_in, is_plausible, map_of
from .recorded_run import EXPLORED, Goal, Map, Navigated, Track

PLAN_EVERY, CLOUD_EVERY = 5.0, 10.0     # s between two plans, and between two clouds, that are kept at first
MOST_PLANS, MOST_CLOUDS, MOST_GOALS = 40, 20, 500
MOST_POSES = 60                         # of one cloud
DRIVES, WAITS, UNSURE = "drives to a goal", "waits", "not sure where"
"""What the spans of `Navigated` say."""
SPANS_OF = {"driving": DRIVES, "waiting": WAITS}
ENDS = ("reached", "failed")
EXPLORES = "exploring"
"""How navigation's reason begins when it chooses a goal itself."""


class Sparse:
    """Keeps some of many things over time: at most so many, and ever fewer of a longer time.

    Args:
        every: the least time (s) between two that are kept.
        most: how many are kept.

    Attributes:
        kept: what is kept, in order of time.
    """

    def __init__(self, every: float, most: int) -> None:
        self.kept: List[np.ndarray] = []
        self._every, self._most = every, most
        self._last_at = -math.inf

    def is_due(self, time: float) -> bool:
        """Return whether something at a time (s) is to be kept."""
        return not 0.0 <= time - self._last_at < self._every

    def begin_anew(self) -> None:
        """The next one is to be kept in any case."""
        self._last_at = -math.inf

    def add(self, time: float, thing: np.ndarray) -> None:
        """Keep something."""
        self._last_at = time
        self.kept.append(thing)
        if len(self.kept) > self._most:
            del self.kept[1::2]
            self._every *= 2.0


class NavigationCollector:
    """Keeps what the topics of navigation say."""

    def __init__(self) -> None:
        self._places = Thinned(self._place_of, *CHANGE_OF_PLACE)
        self._heading = 0.0
        self._states = SpanCollector(lambda message: SPANS_OF.get(message.state, ""))
        self._unsure = SpanCollector(lambda message: "" if message.sure else UNSURE)
        self._plans, self._clouds = Sparse(PLAN_EVERY, MOST_PLANS), Sparse(CLOUD_EVERY, MOST_CLOUDS)
        self._goals: List[Goal] = []
        self._under_way = self._explores = False
        self._sure_from: Optional[float] = None

    def add(self, time: float, message: Any) -> None:
        """Add a Navigation that was recorded at `time` (s)."""
        self._places.add(time, message)
        for spans in (self._states, self._unsure):
            spans.add(time, message)
        if message.sure and self._sure_from is None:
            self._sure_from = time
        for goal in message.goal[:1]:
            if not self._under_way or (goal.x, goal.y) != (self._goals[-1].x, self._goals[-1].y):
                self._begin(time, goal, message.reason)
        if self._under_way and not message.goal:
            self._end(message.state if message.state in ENDS else "cancelled")
            self._under_way = False

    def add_plan(self, time: float, message: Any) -> None:
        """Add a Path that was recorded at `time` (s)."""
        if message.poses and self._plans.is_due(time):
            self._plans.add(time, _places(each.pose for each in message.poses)[:, :2])

    def add_cloud(self, time: float, message: Any) -> None:
        """Add a PoseArray that was recorded at `time` (s)."""
        if message.poses and self._clouds.is_due(time):
            self._clouds.add(time, _places(message.poses[::-(-len(message.poses) // MOST_POSES)]))

    def navigated(self) -> Optional[Navigated]:
        """Return what was collected; None when navigation said nothing."""
        places = self._places.columns()
        if not places.size:
            return None
        return Navigated(Track(*places), tuple(self._states.spans), tuple(self._unsure.spans),
                         tuple(self._plans.kept), tuple(self._clouds.kept), tuple(self._goals), self._sure_from)

    def _begin(self, time: float, goal: Any, reason: str) -> None:
        if not is_plausible(goal.x, goal.y, goal.theta):
            raise ValueError("no goal")
        if self._under_way:
            self._end("replaced")
        self._goals = [*self._goals[1 - MOST_GOALS:], Goal(time, goal.x, goal.y, "under way")]
        self._under_way, self._explores = True, reason.startswith(EXPLORES)
        self._plans.begin_anew()

    def _end(self, how: str) -> None:
        self._goals[-1] = self._goals[-1]._replace(end=EXPLORED if self._explores else how)

    def _place_of(self, message: Any) -> Tuple[float, float, float]:
        place = message.pose
        if not is_plausible(place.x, place.y, place.theta):
            raise ValueError("no place")
        self._heading = place.theta + math.tau * round((self._heading - place.theta) / math.tau)
        return place.x, place.y, self._heading


class MapCollector:
    """Keeps the last map of a topic.

    Attributes:
        last: the map; None before the first message.
        made: whether it has changed meanwhile, because the robot makes it.
    """

    def __init__(self) -> None:
        self.last: Optional[Map] = None
        self.made = False

    def add(self, time: float, message: Any) -> None:
        """Add an OccupancyGrid that was recorded at `time` (s)."""
        newest = map_of(message)
        self.made |= self.last is not None and not np.array_equal(self.last.cells, newest.cells)
        self.last = newest


def _places(poses: Any) -> np.ndarray:
    """Return x, y (m) and heading (rad) of geometry_msgs/Poses: an array of shape (n, 3). Raises ValueError if one is
    not plausible.
    """
    found = np.array([(each.position.x, each.position.y, heading_in(each.orientation)) for each in poses])
    if not is_plausible(*found.flat):
        raise ValueError("no places")
    return found
