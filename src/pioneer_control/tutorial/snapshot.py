"""What the robot knows at one moment, as values that never change.

A decision is taken from one :class:`Snapshot`, so that no callback can exchange a range between two looks at it.
Everything is in metres, radians and seconds; x is forward, y left, headings count counter-clockwise (REP 103).
"""

import math
from typing import Iterable, NamedTuple, Optional, Tuple

from ..errors import NoAnswerError
from ..robots import RobotModel, Transducer
from .clearance import Outline, Point

#: Half the opening of a transducer's cone [rad]: an echo comes from anywhere within it.
HALF_CONE = math.radians(12.5)

#: A transducer belongs to the front when it looks less than this to one side [rad].
FRONT = math.radians(60)

#: It matters what the sonars see so far ahead of the body, or behind it [m].
LOOK = 0.25

#: What slips between two cones is thinner than this [m].
BLIND_GAP = 0.05


class Pose(NamedTuple):
    """Where odometry believes the robot is: x, y [m] and heading [rad], in its own fixed frame."""

    x: float
    y: float
    heading: float


class Grip(NamedTuple):
    """The paddles as reported: state is a :class:`~pioneer_control.message_values.GripStatus`, dir is -1, 0 or 1."""

    state: int
    dir: int
    inner: bool
    outer: bool
    left: bool
    right: bool


class Lift(NamedTuple):
    """The lift as reported.

    State is a :class:`~pioneer_control.message_values.LiftStatus`, dir is -1, 0 or 1, position 0.0 (down) to 1.0 (up).
    """

    state: int
    dir: int
    position: float


class RobotShape:
    """What a robot is to its wander: where its sonars look, and how much room its body takes.

    Attributes:
        transducers: the sonars that are fitted.
        outline: of the whole robot.
        sonar_count: how many ranges there must be, so that every transducer's number is the index of one.
        axes: where each transducer looks, as (cosine, sine) of its heading.
        front: the sonars that look ahead, from left to right: the tutorial's 1 to 6 on a robot with a full array.
        middle: numbers of the two front sonars that look most straight ahead (the tutorial's 3 and 4), and of others
            that look as straight ahead.
        sees_ahead, sees_behind: whether sonars look at all of the strip straight ahead of the body or behind it, LOOK
            away, but for gaps of BLIND_GAP.
    """

    def __init__(self, transducers: Iterable[Transducer], footprint: Iterable[Point]):
        """Take the sonars and the footprint.

        Args:
            transducers: the sonars that are fitted.
            footprint: corners (x, y) [m] of a polygon around the whole robot, paddles included.
        """
        self.transducers = tuple(Transducer(*each) for each in transducers)
        self.outline = Outline(footprint)
        self.sonar_count = 1 + max((each.number for each in self.transducers), default=-1)
        self.axes = tuple((math.cos(each.heading), math.sin(each.heading)) for each in self.transducers)
        self.front = tuple(sorted(
            (each for each in self.transducers if abs(each.heading) < FRONT), key=lambda each: -each.heading))
        aside = sorted(abs(each.heading) for each in self.front)
        limit = aside[min(1, len(aside) - 1)] + 1e-6 if aside else 0.0
        self.middle = tuple(each.number for each in self.front if abs(each.heading) <= limit)
        self.sees_ahead = self._sees(1, self.outline.front + LOOK)
        self.sees_behind = self._sees(-1, self.outline.rear + LOOK)

    @classmethod
    def of_model(cls, model: RobotModel) -> "RobotShape":
        """The shape of a model. It includes the gripper that the model can carry: too large an outline hits nothing."""
        return cls(model.sonar, model.outline(model.can_carry_gripper))

    def _sees(self, direction: int, distance: float) -> bool:
        seen = (_seen(each, direction, distance) for each in self.transducers)
        covered = -self.outline.half_width
        for right, left in sorted(interval for interval in seen if interval):
            if right > covered + BLIND_GAP:
                return False
            covered = max(covered, left)
        return covered >= self.outline.half_width - BLIND_GAP


def _seen(transducer: Transducer, direction: int, distance: float) -> Optional[Tuple[float, float]]:
    """What a cone covers of a line across the robot's way, from y to y [m]; None if it does not reach that line.

    The line is `distance` [m] ahead (`direction` 1) or behind (-1).
    """
    depth = distance - direction * transducer.x
    off = math.remainder(transducer.heading - (0.0 if direction > 0 else math.pi), 2 * math.pi)
    if depth <= 0 or abs(off) + HALF_CONE >= math.pi / 2:
        return None
    ends = [transducer.y + direction * depth * math.tan(off + side) for side in (-HALF_CONE, HALF_CONE)]
    return min(ends), max(ends)


class Snapshot(NamedTuple):
    """All that one decision may look at."""

    time: float  #: s, of ROS; of a decision on a sonar message its stamp
    age: float  #: how old the oldest of pose and ranges is [s]
    pose: Pose
    ranges: Tuple[float, ...]  #: [m], index is the sonar's number; 0.0 is "not heard"
    robot: RobotShape
    grip: Optional[Grip] = None  #: None without a gripper
    lift: Optional[Lift] = None
    stalled: bool = False  #: a wheel is driven and does not turn


class Heard(NamedTuple):
    """The newest of everything the robot told, each None before its first. Replaced as a whole: it never changes."""

    pose: Optional[Pose] = None
    pose_time: float = 0.0  #: of arrival [s], monotonic
    ranges: Optional[Tuple[float, ...]] = None
    ranges_time: float = 0.0  #: of arrival [s], monotonic
    grip: Optional[Grip] = None
    lift: Optional[Lift] = None
    motors: Optional[bool] = None
    stop_button: Optional[bool] = None  #: is it pressed? Not every driver tells
    stalled: bool = False
    robot: Optional[RobotShape] = None
    has_gripper: bool = False
    driven: float = 0.0  #: m since the program began, by the wheels
    stalls: int = 0  #: how often the wheels stalled since the program began
    silence: float = 0.0  #: s, the longest between two poses since the motors were on

    def age(self, now: float) -> float:
        """How old the oldest of pose and ranges is at time `now` [s] of the clock of their arrivals."""
        return now - min(self.pose_time, self.ranges_time)

    def snapshot(self, time: float, age: float) -> Snapshot:
        """What is known, as of `time` [s] and `age` [s] old.

        Raises:
            NoAnswerError: the robot has not told its pose, its sonar ranges and its shape yet.
        """
        if self.pose is None or self.ranges is None or self.robot is None:
            raise NoAnswerError(
                "nothing to decide on: the robot has not told its pose, its sonar ranges and its shape yet")
        return Snapshot(
            time, age, self.pose, self.ranges + (0.0,) * (self.robot.sonar_count - len(self.ranges)), self.robot,
            self.grip, self.lift, self.stalled)
