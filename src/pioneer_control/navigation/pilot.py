"""All of one robot's navigation in one object: it knows where the robot is, on a map or on one that it makes, drives to
goals, and explores. The node and the benches use it alike.
"""

from typing import Any, List, NamedTuple, Optional

from ..errors import RefusedError
from ..floor_poses import Pose
from ..maps import FloorMap, GridMap
from .chassis import Chassis
from .localisation import Localisation, Where
from .navigator import Accelerations, Navigator, Readiness, State
from .planning import Point
from .tuned import NavigationNumbers
from .values import Sensing, Twist

Array = Any     # of numpy

STAND = Twist(0.0, 0.0)


class PilotStep(NamedTuple):
    """What comes out of one packet of the robot.

    Attributes:
        time: of the packet (s).
        odometry: pose by the wheels at that time.
        where: pose on the map; None before the first packet.
        state: what navigation does.
        reason: why, for people.
        twist: what the robot is told.
        goal: where it is sent, if anywhere.
        plan: the way there as points (m, map frame); empty without a goal.
    """

    time: float
    odometry: Pose
    where: Optional[Where]
    state: State
    reason: str
    twist: Twist
    goal: Optional[Pose]
    plan: List[Point]


NOTHING_YET = PilotStep(0.0, Pose(0.0, 0.0, 0.0), None, State.IDLE, "nothing heard of the robot yet", STAND, None, [])


class KnownMap:
    """Knows where the robot is on a map that is given.

    Args:
        floor: the map.
        chassis: the robot.
        numbers: the tuned numbers.
        seed: of what chance decides.
    """

    def __init__(self, floor: FloorMap, chassis: Chassis, numbers: NavigationNumbers, seed: int):
        self.grid, self.drivable = floor.grid, floor.drivable()
        self._localisation = Localisation(floor.grid, chassis.transducers, numbers.localisation, seed)

    @property
    def particles(self) -> Array:
        """Poses where the robot may be: an array (n, 3) of x, y (m) and heading (rad)."""
        return self._localisation.particles

    def start_at(self, pose: Pose, position: float, heading: float) -> None:
        """Somebody says where the robot is, with standard deviations of place (m) and heading (rad)."""
        self._localisation.known_start(pose, position, heading)

    def start_anywhere(self) -> None:
        """The robot may be anywhere."""
        self._localisation.unknown_start()

    def sense(self, sensing: Sensing) -> Where:
        """Return where the robot is."""
        return self._localisation.update(sensing)


class Pilot:
    """The navigation of one robot.

    Args:
        floor: the map.
        chassis: the robot.
        numbers: the tuned numbers.
        seed: of what chance decides.
    """

    def __init__(self, floor: FloorMap, chassis: Chassis, numbers: NavigationNumbers = NavigationNumbers(),
                 seed: int = 0):
        self._chassis, self._numbers = chassis, numbers
        self._knows = KnownMap(floor, chassis, numbers, seed)
        self._navigator = Navigator(self._knows.drivable, chassis, numbers)
        self._goal: Optional[Pose] = None
        self.step = NOTHING_YET
        """The result of the last packet."""

    @property
    def makes_map(self) -> bool:
        """Whether the map is being made."""
        return False

    @property
    def grid(self) -> GridMap:
        """The map."""
        return self._knows.grid

    @property
    def particles(self) -> Array:
        """Poses where the robot may be: an array (n, 3) of x, y (m) and heading (rad)."""
        return self._knows.particles

    @property
    def accelerations(self) -> Accelerations:
        """The accelerations that the robot must have while it drives to a goal."""
        return self._navigator.acceleration_wanted

    def start_at(self, pose: Pose, position: float = 0.5, heading: float = 0.26) -> None:
        """Somebody says where the robot is, with standard deviations of place (m) and heading (rad).

        Raises:
            RefusedError: a map is being made.
        """
        self._knows.start_at(pose, position, heading)

    def start_anywhere(self) -> None:
        """The robot may be anywhere. Raises RefusedError when a map is being made."""
        self._knows.start_anywhere()

    def go_to(self, goal: Pose) -> str:
        """Send the robot to a goal. Return why it does not go, for people; empty: it goes."""
        return self._send(goal)

    def cancel(self) -> None:
        """The goal counts no more; the robot stands."""
        self._goal = None
        self._navigator.cancel(self.step.time)

    def way(self, start: Pose, goal: Pose) -> List[Point]:
        """Return the way between two poses as points, without driving. Raises RefusedError with the reason if none."""
        points, refusal = self._navigator.way(start[:2], goal[:2])
        if refusal:
            raise RefusedError(refusal)
        return points

    def forget_obstacles(self) -> None:
        """Forget what was heard that is on no map."""
        self._navigator.forget_obstacles()

    def silent(self, seconds: float) -> PilotStep:
        """Return what to do after so long without news of the robot: stand."""
        if self._goal is None:
            return self.step._replace(twist=STAND)
        reason = "neither sonar nor pose of the robot for %.1f s" % seconds
        self.step = self.step._replace(state=State.WAITING, reason=reason, twist=STAND)
        return self.step

    def sense(self, sensing: Sensing, readiness: Readiness) -> PilotStep:
        """Take what the robot sensed in one packet, and return what to do."""
        where = self._knows.sense(sensing)
        decision = self._navigator.step(sensing, where, readiness, sensing.time)
        if decision.state not in (State.DRIVING, State.WAITING):
            self._goal = None
        self.step = PilotStep(sensing.time, sensing.odometry, where, decision.state, decision.reason, decision.twist,
                              self._goal, self._navigator.plan)
        return self.step

    def _send(self, goal: Pose) -> str:
        refusal = self._navigator.go_to(goal.x, goal.y, goal.heading, self.step.time)
        self._goal = None if refusal else goal
        return refusal
