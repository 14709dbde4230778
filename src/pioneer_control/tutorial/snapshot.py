"""The data that a decision of the wander uses, as immutable values.

Each decision uses one :class:`Snapshot`, so no callback can change a value while the decision is made.

Units are metres, radians and seconds. x is forward, y is left, and headings are counter-clockwise (REP 103).
"""

import math
from typing import Iterable, NamedTuple, Optional, Tuple

from ..errors import NoAnswerError
from ..floor_poses import Pose
from ..robots import HALF_CONE, RobotModel, Transducer
from .clearance import Outline, Point

#: A transducer is a front transducer when the angle between its axis and straight ahead is less than this [rad].
FRONT = math.radians(60)

#: The distance from the body, ahead or behind, at which `RobotShape` checks for gaps between the sonar cones [m].
LOOK = 0.25

#: A gap between two sonar cones that is not wider than this is allowed [m].
BLIND_GAP = 0.05


class Grip(NamedTuple):
    """The reported state of the paddles.

    `state` is a :class:`~pioneer_control.message_values.GripStatus`. `dir` is the direction of a movement: 1 or -1, and
    0 when they do not move or the direction is not known. `inner` and `outer`: an object breaks this light beam. `left`
    and `right`: the contact of this paddle is pressed.
    """

    state: int
    dir: int
    inner: bool
    outer: bool
    left: bool
    right: bool


class Lift(NamedTuple):
    """The reported state of the lift.

    `state` is a :class:`~pioneer_control.message_values.LiftStatus`. `dir` is the direction of a movement: 1 or -1, and
    0 when it does not move or the direction is not known. `position` is 0.0 (down) to 1.0 (up).
    """

    state: int
    dir: int
    position: float


class RobotShape:
    """The properties of a robot that the wander needs: the poses of its sonars and its outline.

    Attributes:
        transducers: the sonar transducers that are fitted.
        outline: the outline of the whole robot.
        sonar_count: the length of a list of ranges whose index is the transducer number.
        axes: the direction of each transducer as (cosine, sine) of its heading, in the order of `transducers`.
        covered: how far each transducer looks over the body, in the order of `transducers`: to the outline [m].
        front: the front transducers from left to right: sonars 1 to 6 of the tutorial on a robot with a full array.
        middle: the numbers of the two front transducers that point most straight ahead (sonars 3 and 4 of the
            tutorial), and of others with the same angle.
        sees_ahead, sees_behind: whether the sonar cones cover the full width of the body at the distance LOOK ahead of
            it or behind it. Gaps up to BLIND_GAP are allowed.
    """

    def __init__(self, transducers: Iterable[Transducer], footprint: Iterable[Point]):
        """Compute the attributes.

        Args:
            transducers: the sonar transducers that are fitted.
            footprint: the corners (x, y) [m] of a polygon around the whole robot, including the paddles of a gripper.
        """
        self.transducers = tuple(Transducer(*each) for each in transducers)
        self.outline = Outline(footprint)
        self.sonar_count = 1 + max((each.number for each in self.transducers), default=-1)
        self.axes = tuple((math.cos(each.heading), math.sin(each.heading)) for each in self.transducers)
        self.covered = tuple(
            self.outline.way_out(each.x, each.y, *axis) for each, axis in zip(self.transducers, self.axes))
        self.front = tuple(sorted(
            (each for each in self.transducers if abs(each.heading) < FRONT), key=lambda each: -each.heading))
        aside = sorted(abs(each.heading) for each in self.front)
        limit = aside[min(1, len(aside) - 1)] + 1e-6 if aside else 0.0
        self.middle = tuple(each.number for each in self.front if abs(each.heading) <= limit)
        self.sees_ahead = self._sees(1, self.outline.front + LOOK)
        self.sees_behind = self._sees(-1, self.outline.rear + LOOK)

    @classmethod
    def of_model(cls, model: RobotModel) -> "RobotShape":
        """Return the shape of a robot model.

        When the model can carry a gripper, the outline includes it, because an outline that is too large is safe.
        """
        return cls(model.sonar, model.outline(model.can_carry_gripper))

    def _sees(self, direction: int, distance: float) -> bool:
        """Return whether the sonar cones cover the full width of the body, on a line across the robot's path.

        The line is `distance` [m] ahead of the origin (`direction` 1) or behind it (-1).
        """
        seen = (_covered(each, direction, distance) for each in self.transducers)
        covered = -self.outline.half_width
        for right, left in sorted(interval for interval in seen if interval):
            if right > covered + BLIND_GAP:
                return False
            covered = max(covered, left)
        return covered >= self.outline.half_width - BLIND_GAP


def _covered(transducer: Transducer, direction: int, distance: float) -> Optional[Tuple[float, float]]:
    """Return which part of a line across the robot's path a sonar cone covers: its least and greatest y [m].

    The line is `distance` [m] ahead of the origin (`direction` 1) or behind it (-1). None when the cone does not cover
    a limited part of the line.
    """
    depth = distance - direction * transducer.x
    off = math.remainder(transducer.heading - (0.0 if direction > 0 else math.pi), 2 * math.pi)
    if depth <= 0 or abs(off) + HALF_CONE >= math.pi / 2:
        return None
    ends = [transducer.y + direction * depth * math.tan(off + side) for side in (-HALF_CONE, HALF_CONE)]
    return min(ends), max(ends)


class Snapshot(NamedTuple):
    """All data that one decision of the wander uses."""

    time: float  #: s, ROS time; in a wander it is the stamp of the sonar message
    age: float  #: s, the age of pose or ranges, whichever is older
    pose: Pose  #: by odometry, in the odom frame
    ranges: Tuple[float, ...]  #: m, the index is the transducer number; 0.0 means no recent reading
    robot: RobotShape
    grip: Optional[Grip] = None  #: None without a gripper
    lift: Optional[Lift] = None  #: None without a gripper
    stalled: bool = False  #: whether a wheel is driven but does not turn


class Heard(NamedTuple):
    """The newest data from each topic of the robot. A field is None before the first message.

    The object is immutable. Each message makes a new object, so other threads never see a half-changed one.
    """

    pose: Optional[Pose] = None
    pose_time: float = 0.0  #: s, monotonic; arrival time of the pose
    ranges: Optional[Tuple[float, ...]] = None
    ranges_time: float = 0.0  #: s, monotonic; arrival time of the ranges
    grip: Optional[Grip] = None
    lift: Optional[Lift] = None
    motors: Optional[bool] = None
    stop_button: Optional[bool] = None  #: whether it is pressed; not every driver publishes this
    stalled: bool = False
    robot: Optional[RobotShape] = None
    has_gripper: bool = False
    driven: float = 0.0  #: m, distance driven since the program started, by odometry
    stalls: int = 0  #: how often a wheel began to stall since the program started
    silence: float = 0.0  #: s, the longest time between two poses since the motors were last on

    def age(self, now: float) -> float:
        """Return the age [s] of the pose or the ranges, whichever is older. `now` is monotonic time [s]."""
        return now - min(self.pose_time, self.ranges_time)

    def snapshot(self, time: float, age: float) -> Snapshot:
        """Return these data as a Snapshot, the form that a decision uses.
        Args:
            time: the time of the snapshot [s].
            age: the age of its oldest value [s].

        Raises:
            NoAnswerError: the pose, the sonar ranges or the shape of the robot have not arrived yet.
        """
        if self.pose is None or self.ranges is None or self.robot is None:
            raise NoAnswerError(
                "nothing to decide on: the robot has not told its pose, its sonar ranges and its shape yet")
        return Snapshot(
            time, age, self.pose, self.ranges + (0.0,) * (self.robot.sonar_count - len(self.ranges)), self.robot,
            self.grip, self.lift, self.stalled)
