"""What lies between the page's rooms and robots of any kind: what is shown (Feed), and what is told (Controls).
Besides, what all of these share: how often they tell, and the form of a robot's entry.

================  =============================================================================
file              what it has
================  =============================================================================
``client_robot``  a robot of the client library
``graph``         the robots of a ROS graph
``recorded``      a bag: it has no controls, and the page gets all of it at once
================  =============================================================================
"""

import math
from typing import Any, Dict, List, NamedTuple, Optional, Protocol, Sequence, Tuple

from ..errors import RefusedError
from .frames import LONGEST_RANGE
from .orders import NavigationOrder
from .trail import Trail

TEACHERS = "teachers"
"""As audience of a text: all teachers. It is too short to be a visitor."""
VELOCITY_LIVES = 0.4    # s
REPEAT = 0.15           # s without a frame after which the last one is sent again, with its true age
STATUS_EVERY = 0.5      # s between two statuses of one robot
COUNTS_EVERY = 5.0      # s between two statuses that differ only in what changes all the time
SONAR_LIVES = 2.0       # s: an older range of the sonar counts as not heard
CONE = math.radians(15)
"""Half of the angle of a sonar cone (rad)."""
Pose = Tuple[float, float, float]
"""x and y (m), heading (rad)."""


class Person(NamedTuple):
    """Somebody at a page, at the moment of an order."""

    viewer: int
    """The number of the connection: two tabs of one browser are two viewers."""
    visitor: str
    """The secret text of the browser, the same after a reload. Nobody else may see it."""
    name: str = ""
    """As others see this person; empty until the person says one."""
    teacher: bool = False
    drawn: Optional[int] = None
    """The stamp of the newest frame on this person's screen; None before the first frame."""


class Controls(Protocol):
    """What a person may do with one robot. The seats decide who may; nothing here asks who it is.

    Every method returns at once. It raises a PioneerError that says for people why the robot does not do it.
    """

    def drive(self, linear: float, angular: float) -> None:
        """Drive at m/s and rad/s, and stop VELOCITY_LIVES s later, unless this is called again."""

    def stop(self) -> None:
        """End what drive() began, at once. Raises nothing."""

    def lock(self) -> None:
        """Stop, and let nothing but zero through, whoever commands. Raises nothing."""

    def unlock(self) -> None:
        """Take the lock away."""

    def motors(self, on: bool) -> None:
        """Ask for motors on or off."""

    def gripper(self, command: str) -> None:
        """Give the gripper one of orders.GRIPPER_COMMANDS."""

    def take(self) -> None:
        """Stop what programs do, and lock them out."""

    def release(self) -> None:
        """Let programs command again."""

    def navigate(self, order: NavigationOrder) -> None:
        """Pass an order on to the robot's navigation. Raises RefusedError where there is none."""

    @property
    def locks(self) -> Tuple[str, ...]:
        """Why the robot stands whatever it is told; empty when it may move."""

    @property
    def programs(self) -> str:
        """Whether programs may command: "none", "free", "driving" or "locked out", as in the page's protocol."""


class TextFeed(Protocol):
    """Takes the texts that the page shows. See Feed."""

    def text(self, kind: str, value: Any, robot: Optional[int] = None, seat: str = "", to: str = "") -> None:
        """Take the newest text of a kind.

        Args:
            kind: a kind of the page's protocol: "robots", "world", "status", ...
            value: its value, of what JSON knows.
            robot: the robot that it is about, for a kind that every robot has.
            seat: of the kind "helm": the visitor who has the seat.
            to: for whom it is: a visitor, TEACHERS, or "" for all. A text for fewer goes before one for more of the
                same kind and robot; the value None takes it back.
        """


class Feed(TextFeed, Protocol):
    """Takes what the page shows. `Fleet` is one, and the owner's end of the socket to the server.

    Every method returns at once, may be called by any thread if the feed says so, and raises nothing.
    """

    def frame(self, frame: bytes) -> None:
        """Take the newest frame of a robot, as frames.encode_frame() gives it."""

    def said(self, level: str, text: str, robot: Optional[int] = None,
             viewers: Optional[Sequence[int]] = None) -> None:
        """Tell some viewers, or all (None), a sentence. ``level`` is "info", "warn" or "error"."""


class PageRobot(Controls, Protocol):
    """One robot for the owner: what the page shows of it, and its Controls."""

    number: int
    """Its number for the page."""
    trail: Trail
    introduced: bool
    """Whether the page has been told the shape of this robot. Before that, no frame of it makes sense."""
    asked: Optional[int]
    """The viewer who asked for the motors last."""

    def start(self) -> None:
        """Begin to look for the robot."""

    def close(self, wait: bool = True) -> None:
        """Stop what persons drive, and let the robot go. Without ``wait`` only the stop is sure when this returns."""

    @property
    def entry(self) -> Dict[str, Any]:
        """The entry of this robot in the text ``robots``."""

    @property
    def limits(self) -> Tuple[float, float]:
        """The robot's own limits (m/s, rad/s)."""

    def repeat(self, now: float) -> None:
        """Send the last frame again, with its age, if none was sent for a while (monotonic time, s)."""

    def status(self, now: float) -> Optional[Dict[str, Any]]:
        """Return the text ``status`` if it is time to tell a new one; else None."""


class Stage(Protocol):
    """What a robot tells the owner. Any thread may call it, and no method blocks."""

    def changed(self, robot: PageRobot) -> None:
        """Its shape, its limits, or who commands it, is another one now."""

    def tell(self, robot: PageRobot, level: str, text: str, viewers: Optional[Sequence[int]] = None) -> None:
        """Something happened, for the log of the page. ``viewers``: see Feed.said()."""


class Rules(Protocol):
    """Who may drive which robot, and what else pages may order. `Everybody` is the simplest one."""

    def known(self, person: Person) -> Person:
        """Return a person with the name that others see."""

    def may(self, person: Person, robot: int) -> bool:
        """Return whether a robot is there for a person."""

    def who(self, robot: int) -> str:
        """Return the name of the person whose robot it is; "" if it is everybody's. Any thread may call it."""

    def audience(self, robot: int) -> Sequence[str]:
        """Return those who may drive a robot, as Feed.text() takes them in ``to``."""

    def viewers(self, robot: int) -> Optional[List[int]]:
        """Return the viewers who are told what happens to a robot; None for all. Any thread may call it."""

    def entries(self, entries: List[Dict[str, Any]]) -> Dict[str, List[Dict[str, Any]]]:
        """Return the text ``robots`` for each audience, made of the entries of all robots."""

    def emptied(self) -> None:
        """No viewer is there: a new server has begun."""

    def came(self, person: Person) -> None:
        """A viewer has come."""

    def left(self, viewer: int) -> None:
        """A viewer is gone."""

    def obey(self, person: Person, order: Any, now: float) -> None:
        """Do an order that is not about driving (monotonic time, s). Raises a PioneerError that says for people why
        not.
        """


def robot_entry(robot: int, name: str, where: str, simulated: bool, **known: Any) -> Dict[str, Any]:
    """Return the entry of a robot in the text ``robots``. ``known``: more of its fields; without them it has no shape.
    """
    return {
        "robot": robot, "name": name, "model": "", "where": where, "simulated": simulated, "outline": [], "sonar": [],
        "sonar_range": LONGEST_RANGE, "sonar_cone": round(CONE, 3), "gripper": False, "max_linear": 0.0,
        "max_angular": 0.0, "yours": True, **known}


class StatusPace:
    """Says when the text ``status`` of one robot is told again."""

    def __init__(self) -> None:
        self._told: Dict[str, Any] = {}
        self._told_at = -math.inf

    def is_due(self, now: float) -> bool:
        """Return whether another status may be told (monotonic time, s)."""
        return now - self._told_at >= STATUS_EVERY

    def take(self, status: Dict[str, Any], now: float, *slow: str) -> Optional[Dict[str, Any]]:
        """Return a status if it is to be told now; else None. A change of the fields ``slow`` alone waits longer."""
        without = dict.fromkeys(slow)
        if now - self._told_at < COUNTS_EVERY and {**status, **without} == {**self._told, **without}:
            return None
        self._told, self._told_at = status, now
        return status


class Everybody:
    """The Rules without a class: all robots are there for everybody who has a key of the page."""

    def known(self, person: Person) -> Person:
        """Return the person: the name is the one that the person said."""
        return person

    def may(self, person: Person, robot: int) -> bool:
        """Return True."""
        return True

    def who(self, robot: int) -> str:
        """Return "": a robot is everybody's."""
        return ""

    def audience(self, robot: int) -> Sequence[str]:
        """Return all."""
        return ("",)

    def viewers(self, robot: int) -> Optional[List[int]]:
        """Return None: all are told everything."""
        return None

    def entries(self, entries: List[Dict[str, Any]]) -> Dict[str, List[Dict[str, Any]]]:
        """Return the same for all."""
        return {"": entries}

    def emptied(self) -> None:
        """Do nothing."""

    def came(self, person: Person) -> None:
        """Do nothing."""

    def left(self, viewer: int) -> None:
        """Do nothing."""

    def obey(self, person: Person, order: Any, now: float) -> None:
        """Raise RefusedError: such orders are for a class."""
        raise RefusedError("refused: this is no class")
