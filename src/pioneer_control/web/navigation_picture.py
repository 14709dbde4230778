"""What navigation tells of one robot, as the texts of the page: `navigation`, `plan`, `cloud` and `places`. Pure.

It takes objects with the fields of the messages, and the time (s) at which each came, as `from_messages` does.
"""

import math
from typing import Any, Dict, Iterable, Iterator, List, Optional, Tuple

from ..message_values import heading_of
from .orders import LONGEST_PLACE

LIVES = 3.0
"""Time (s) without a message after which navigation counts as silent."""
SILENT = "silent"
"""The state that the page shows then. The others are those of the message Navigation."""
EVERY = {"navigation": 0.25, "plan": 0.5, "cloud": 0.5, "places": 0.0}
"""For each kind of text: time (s) between two of them."""
MOST_POINTS, MOST_POSES, MOST_PLACES = 200, 100, 200
"""The most points of a plan, poses of a cloud, and places that the page is told."""


class NavigationPicture:
    """What is known of the navigation of one robot.

    Args:
        number: the number of the robot for the page.
        every: for kinds of texts another time (s) between two of them than in EVERY.

    Attributes:
        frame: the frame of all its poses; empty before navigation has told anything.
        goal: where the robot goes: the frame, and x and y in it (m); None: nowhere, or nobody said so.
        news: what has happened since somebody emptied this list, in words.
    """

    def __init__(self, number: int, **every: float) -> None:
        self.frame = ""
        self.goal: Optional[Tuple[str, float, float]] = None
        self.news: List[str] = []
        self._number = number
        self._every = dict(EVERY, **every)
        self._state: Dict[str, Any] = {}
        self._plan: List[List[float]] = []
        self._cloud: List[List[float]] = []
        self._places: List[List[Any]] = []
        self._heard_at = -math.inf
        self._told: Dict[str, Tuple[float, Any]] = {}       # the newest text of each kind, and its time

    def lives(self, now: float) -> bool:
        """Return whether navigation has told something lately (s)."""
        return now - self._heard_at < LIVES

    def changes(self, now: float) -> Iterator[Tuple[str, Dict[str, Any]]]:
        """Return the texts (kind and value) that are others than they were told, and that may be told again now (s)."""
        for kind, value in self._texts(now):
            at, before = self._told.get(kind, (-math.inf, None))
            if value != before and now - at >= self._every[kind]:
                self._told[kind] = now, value
                yield kind, value

    def _texts(self, now: float) -> Iterator[Tuple[str, Dict[str, Any]]]:
        silent = bool(self._state) and not self.lives(now)
        if silent:
            yield "navigation", dict(self._state, robot=self._number, state=SILENT, goal=None, sure=False, unsure="",
                                     reason="nothing has come from it for %.0f s: does it run?" % LIVES)
        elif self._state:
            yield "navigation", dict(self._state, robot=self._number)
        for kind, field, value in (("plan", "points", self._plan), ("cloud", "poses", self._cloud),
                                   ("places", "places", self._places)):
            if kind in self._told or value:
                yield kind, {"robot": self._number, field: [] if silent and kind != "places" else value}

    # What it takes

    def take_state(self, message: Any, now: float) -> None:
        """Take a Navigation. Raises ValueError for a pose that is not finite."""
        before = self._state
        goal = [_pose(each) for each in message.goal[:1]]
        self._state = {
            "state": message.state, "reason": message.reason, "sure": bool(message.sure),
            "unsure": message.unsure_because, "pose": _pose(message.pose), "goal": goal[0] if goal else None}
        self.frame, self._heard_at = message.header.frame_id.strip("/"), now
        self.goal = (self.frame, goal[0][0], goal[0][1]) if goal else None
        if not before:
            return
        # That it does not know, and why it failed, are in its diagnostics.
        if message.sure and not before["sure"]:
            self.news.append("it knows where it is")
        if before["state"] != message.state and message.state != "failed":
            self.news.append("navigation: " + ": ".join(dict.fromkeys(filter(None, (message.state, message.reason)))))

    def take_goal(self, message: Any, now: float) -> None:
        """Take a geometry_msgs/PoseStamped: a goal that somebody gives. Raises ValueError if it is not finite."""
        place = message.pose.position
        _short(place.x, place.y)
        if not self.lives(now):     # which says itself where the robot goes
            self.goal = message.header.frame_id.strip("/"), place.x, place.y

    def take_plan(self, message: Any, now: float) -> None:
        """Take a nav_msgs/Path. Raises ValueError for a place that is not finite."""
        places = [each.pose.position for each in message.poses]
        self._plan = [_short(place.x, place.y) for place in _some(places, MOST_POINTS)]

    def take_cloud(self, message: Any, now: float) -> None:
        """Take a geometry_msgs/PoseArray: where the robot may be. Raises ValueError for a pose that is not finite."""
        self._cloud = [_short(each.position.x, each.position.y, heading_of(
            each.orientation.x, each.orientation.y, each.orientation.z, each.orientation.w))
            for each in _some(message.poses, MOST_POSES)]

    def take_places(self, message: Any, now: float) -> None:
        """Take a Places. Raises ValueError for a pose that is not finite."""
        named = list(zip(message.names, message.poses))[:MOST_PLACES]
        self._places = [[name[:LONGEST_PLACE], *_pose(pose)] for name, pose in named]


def _pose(pose: Any) -> List[float]:
    """Return a geometry_msgs/Pose2D as a list."""
    return _short(pose.x, pose.y, pose.theta)


def _short(*values: float) -> List[float]:
    if not all(map(math.isfinite, values)):
        raise ValueError("a place is not finite: %r" % (values,))
    return [round(float(value), 2) for value in values[:2]] + [round(float(value), 3) for value in values[2:]]


def _some(values: Iterable[Any], most: int) -> List[Any]:
    """Return at most so many of many values, spread over all, with the last one."""
    values = list(values)
    step = -(-len(values) // most) or 1
    return values[::-1][::step][::-1]
