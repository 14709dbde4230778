"""A robot that has no way on goes aside: others get by who wait until it is gone, and it may find another way to begin.
"""

import math
from typing import Any, Optional

import numpy as np

from ..floor_poses import Pose
from .planning import DrivableFloor, RoutePlan
from .tuned import NavigatorNumbers
from .values import Point

Array = Any     # of numpy

_THERE = 0.15       # m: so near to the place it is there
_DIRECTIONS = np.linspace(-math.pi, math.pi, 16, endpoint=False)


class Aside:
    """The steps aside on the way to one goal.

    Attributes:
        count: how many there were.
    """

    def __init__(self, numbers: NavigatorNumbers):
        self._numbers, self.count = numbers, 0
        self._plan: Optional[RoutePlan] = None
        self._began = -math.inf     # s

    def is_due(self, progress_at: float, now: float) -> bool:
        """Return whether to begin one, when the robot got on last at some time (s)."""
        return now - max(progress_at, self._began) > self._numbers.aside_after

    def begin(self, floor: DrivableFloor, pose: Pose, places: Array, now: float) -> None:
        """Begin one from a pose (map frame). `places`: array (number, 2) of what is on no map (m)."""
        place = roomy(floor, pose, places, self._numbers.aside)
        self._plan, self._began = None if place is None else floor.to(place), now
        self.count += 1

    def plan(self, pose: Pose, progress_at: float, now: float) -> Optional[RoutePlan]:
        """Return the plan to the place aside while the robot is on its way there. For the arguments see the others."""
        plan = self._plan
        if plan is None or now - self._began > self._numbers.aside_time or progress_at > self._began:
            return None
        return plan if math.hypot(pose.x - plan.goal[0], pose.y - plan.goal[1]) > _THERE else None


def roomy(floor: DrivableFloor, pose: Pose, places: Array, way: float) -> Optional[Point]:
    """Return the place with most room of those to which `way` (m) leads straight from a pose; None if there is none.

    For the other arguments see `Aside.begin`.
    """
    found, most = None, 0.0
    for turn in _DIRECTIONS:
        x, y = pose.x + way * math.cos(pose.heading + turn), pose.y + way * math.sin(pose.heading + turn)
        if floor.straight(pose[:2], (x, y)):
            room = min(floor.room(x, y), float(np.hypot(*(places - (x, y)).T).min(initial=math.inf)))
            if room > most:
                found, most = (x, y), room
    return found
