"""All of one robot's navigation in one object: it knows where the robot is, on a map or on one that it makes, drives to
goals, and explores. The node and the benches use it alike.
"""

from typing import Any, List, NamedTuple, Optional, Union

import numpy as np

from ..errors import RefusedError
from ..floor_poses import Pose, relative
from ..maps import FloorMap, GridMap
from .chassis import Chassis
from .exploring import Explorer, NextGoal, with_driven_floor
from .localisation import Localisation, Where
from .mapping import Mapper
from .navigator import Accelerations, Decision, Navigator, Readiness, State
from .stretch import MOST_TURN
from .tuned import NavigationNumbers
from .values import STOP, Point, Sensing, Twist

Array = Any     # of numpy

_OWN_MAP = "a map is being made: the robot is where this map says"
NEW_MAP_EVERY = 1.0
"""Time (s) between two maps that the navigator gets while one is being made."""
LISTENS = 2.0
"""Time (s) in which the robot listens before it explores."""
MOST_REFUSALS = 20
"""How many goals of the explorer the navigator may refuse, one after the other."""
HOME_TRIES = 3
"""How often it tries to come home."""


class PilotStep(NamedTuple):
    """What comes out of one packet of the robot.

    Attributes:
        time: of the packet (s).
        odometry: pose by the wheels at that time, as they tell it.
        jumped: whether it has jumped since the packet before.
        where: pose on the map; None before the first packet.
        state: what navigation does.
        reason: why, for people.
        twist: what the robot is told.
        goal: where it is sent, if anywhere.
        late: how much later (s) than usual the robot reacts.
        plan: the way there as points (m, map frame); empty without a goal.
    """

    time: float
    odometry: Pose
    jumped: bool
    where: Optional[Where]
    state: State
    reason: str
    twist: Twist
    goal: Optional[Pose]
    late: float
    plan: List[Point]


NOTHING_YET = PilotStep(0.0, Pose(0.0, 0.0, 0.0), False, None, State.IDLE, "nothing heard of the robot yet", STOP,
                        None, 0.0, [])


class KnownMap:
    """Knows where the robot is on a map that is given.

    Args:
        floor: the map.
        chassis: the robot.
        numbers: the tuned numbers.
        seed: of what chance decides.
    """

    def __init__(self, floor: FloorMap, chassis: Chassis, numbers: NavigationNumbers, seed: int):
        self.grid, self.drivable, self.path = floor.grid, floor.drivable(), None
        self._localisation = Localisation(floor.grid, chassis.transducers, numbers.localisation, seed,
                                          numbers.laser)

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

    def sense(self, sensing: Sensing, rests: bool = False) -> Where:
        """Return where the robot is."""
        return self._localisation.update(sensing)

    def told(self, velocity: Twist) -> None:
        """The robot is told this velocity."""
        self._localisation.unseen.told = velocity


class OwnMap:
    """Makes a map while the robot drives, and knows where the robot is on it.

    Args:
        chassis: the robot.
        numbers: the tuned numbers.
        start: where it begins (map frame).
    """

    def __init__(self, chassis: Chassis, numbers: NavigationNumbers, start: Pose):
        self._mapper = Mapper(chassis.transducers, numbers.sonar_grid, numbers.scan_match, numbers.wall_directions,
                              numbers.mapper, start)
        self._wide = chassis.half_width + numbers.planning.keep
        self._covariance = np.diag((0.1, 0.1, 0.05)) ** 2      # within a stretch of path

    @property
    def grid(self) -> GridMap:
        """The map as it is now."""
        return self._mapper.grid_map()

    @property
    def drivable(self) -> GridMap:
        """The same, and free wherever the robot has driven. Walls that are drawn there belong elsewhere."""
        return with_driven_floor(self.grid, self.path, self._wide)

    @property
    def path(self) -> Array:
        """Where the robot has been: x, y (m), an array (n, 2)."""
        return self._mapper.path()[:, :2]

    @property
    def particles(self) -> Array:
        """The pose on the map, as an array (1, 3) of x, y (m) and heading (rad)."""
        return np.array([self._mapper.pose], dtype=float)

    def start_at(self, pose: Pose, position: float, heading: float) -> None:
        """Refuse: a map that is being made begins where the robot began."""
        raise RefusedError(_OWN_MAP)

    def start_anywhere(self) -> None:
        """Refuse, as `start_at`."""
        raise RefusedError(_OWN_MAP)

    def sense(self, sensing: Sensing, rests: bool = False) -> Where:
        """Add what was sensed to the map, and return where the robot is on it.

        Args:
            sensing: the packet.
            rests: whether the map is corrected later, as there is other work in this packet.
        """
        return Where(sensing.time, self._mapper.update(sensing, rests), True, self._covariance, "")

    def told(self, velocity: Twist) -> None:
        """The robot is told this velocity. The map is made from what it senses alone."""

    def finish(self) -> None:
        """Draw the whole map anew with all that is known now."""
        self._mapper.finish()


class Pilot:
    """The navigation of one robot.

    Args:
        floor: the map. None: the robot makes one.
        chassis: the robot.
        numbers: the tuned numbers.
        seed: of what chance decides.
        start: where the robot begins on a map that it makes (map frame).
    """

    def __init__(self, floor: Optional[FloorMap], chassis: Chassis, numbers: NavigationNumbers = NavigationNumbers(),
                 seed: int = 0, start: Pose = Pose(0.0, 0.0, 0.0)):
        if floor is None:
            chassis = chassis._replace(max_angular=min(chassis.max_angular, MOST_TURN))
        self._chassis, self._numbers = chassis, numbers
        self._knows: Union[KnownMap, OwnMap] = (
            OwnMap(chassis, numbers, start) if floor is None else KnownMap(floor, chassis, numbers, seed))
        self._origin: Optional[Pose] = None     # of the odometry
        self._explorer: Optional[Explorer] = None
        self._explore_from = 0.0
        self._home_tries = 0
        self._mapped = -NEW_MAP_EVERY
        # Each costly work has packets of its own, so that none takes long: the navigator gets a new map, it plans (so
        # many packets more), the next goal is chosen in steps, the robot is sent. The map is corrected in all others.
        self._is_new, self._plans = False, 0
        self._chooses, self._refusals = False, 0
        self._chosen: Optional[NextGoal] = None
        self._drivable = self._knows.drivable
        self._navigator = Navigator(self._drivable, chassis, numbers, self.makes_map)
        self._goal: Optional[Pose] = None
        self.step = NOTHING_YET
        """The result of the last packet."""

    @property
    def makes_map(self) -> bool:
        """Whether the map is being made."""
        return isinstance(self._knows, OwnMap)

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
        """Send the robot to a goal. Return why it does not go, for people: then all stays as it was; empty: it goes."""
        refusal = self._send(goal)
        if not refusal:
            self._explorer, self._chooses = None, False
        return refusal

    def cancel(self) -> None:
        """The goal counts no more; the robot stands."""
        self._explorer, self._chooses, self._goal = None, False, None
        self._navigator.cancel()

    def explore(self, on: bool) -> str:
        """Begin to explore, or end. Return why not, for people: then all stays as it was; empty: it does."""
        if not on:
            if self._explorer is not None:
                self.cancel()
            return ""
        if not self.makes_map:
            return "there is a map: exploring makes one, so start explore.launch, or navigation without a map"
        if self.step.where is None:
            return self.step.reason
        if self._explorer is not None:
            return ""       # home stays where it began
        self.cancel()
        side, planning = self._chassis.half_width, self._numbers.planning
        self._explorer = Explorer(self.step.where.pose, side + planning.keep, self._numbers.exploring,
                                  side + planning.squeeze)
        self._explore_from, self._home_tries = self.step.time + LISTENS, 0
        return ""

    @property
    def goal(self) -> Optional[Pose]:
        """Where it sends the robot now, if anywhere (map frame)."""
        return self._goal

    @property
    def explores(self) -> bool:
        """Whether it explores."""
        return self._explorer is not None

    def finish(self) -> None:
        """Make the best of a map that was made, before it is saved. This takes some seconds."""
        if isinstance(self._knows, OwnMap):
            self._knows.finish()

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
            return self.step._replace(twist=STOP)
        reason = "neither sonar nor pose of the robot for %.1f s" % seconds
        self.step = self.step._replace(state=State.WAITING, reason=reason, twist=STOP)
        return self.step

    def sense(self, sensing: Sensing, readiness: Readiness) -> PilotStep:
        """Take what the robot sensed in one packet, and return what to do."""
        jumped, self._origin = self._origin not in (None, sensing.origin), sensing.origin
        where = self._knows.sense(sensing, self._is_new or self._plans > 0 or self._chooses)
        decision = self._navigator.step(sensing, where, readiness, sensing.time + readiness.late)
        explorer = self._explorer
        if explorer is not None and not (readiness.may_command and readiness.motors):
            explorer.held_up(sensing.time)
        ended = not decision.state.has_goal
        if self._is_new:
            self._is_new, self._plans = False, 0 if ended else 2
            self._navigator.use_map(self._drivable)
        elif explorer is not None and (ended or self._chooses):
            decision = self._explore_on(explorer, where, decision)
        elif self._plans > 0:
            self._plans -= 1
        elif self.makes_map and not 0.0 <= sensing.time - self._mapped < NEW_MAP_EVERY:
            self._mapped, self._drivable, self._is_new = sensing.time, self._knows.drivable, True
        elif explorer is not None and explorer.is_over(where.pose, where.time, self._drivable):
            decision = self._explore_on(explorer, where, decision)
        if self._explorer is not None and not decision.state.has_goal:
            decision = Decision(STOP, State.WAITING, "choosing where to go next")
        if ended and explorer is None:
            self._goal = None
        self.step = PilotStep(sensing.time, relative(sensing.origin, sensing.odometry), jumped, where, decision.state,
                              decision.reason, decision.twist, self._goal, self._navigator.late, self._navigator.plan)
        self._knows.told(decision.twist)
        return self.step

    def _explore_on(self, explorer: Explorer, where: Where, decision: Decision) -> Decision:
        """Go on after the way to the goal before has ended: choose the next one, and in the packet after that go."""
        if where.time < self._explore_from:
            return Decision(STOP, State.WAITING, "listening before it explores")
        if not self._chooses:
            return self._end_way(explorer, decision)
        chosen = self._chosen
        if chosen is None:
            self._chosen = explorer.next(self._drivable, where.pose, where.time, self._knows.path)
            return decision
        assert chosen.pose is not None
        self._chosen = None
        refusal = self._send(chosen.pose, chosen.with_heading)
        if not refusal:
            self._chooses = False
            return Decision(STOP, State.DRIVING, "exploring: %s" % chosen.reason)
        self._navigator.cancel()
        self._goal = None
        self._refusals += 1
        if explorer.homeward or self._refusals == MOST_REFUSALS:
            self._explorer, self._chooses = None, False
            return self._navigator.end(State.FAILED, "explored, not home: %s" % refusal)
        explorer.refused()
        return Decision(STOP, State.WAITING, refusal)

    def _end_way(self, explorer: Explorer, ended: Decision) -> Decision:
        """End the way to a goal. If it was the last one, exploring ends; else the next packet chooses another."""
        if self._goal is not None and explorer.homeward:
            self._home_tries += 1
            if ended.state is State.REACHED or self._home_tries >= HOME_TRIES:
                self._explorer = self._goal = None
                if ended.state is State.REACHED:
                    return self._navigator.end(State.REACHED, "explored, home again")
                late = "the time for the way is over, " if ended.state.has_goal else ""
                return self._navigator.end(State.FAILED, "explored, not home: %s%s" % (late, ended.reason))
        self._chooses, self._chosen, self._refusals = True, None, 0
        return ended

    def _send(self, goal: Pose, with_heading: bool = True) -> str:
        refusal = self._navigator.go_to(goal.x, goal.y, goal.heading if with_heading else None, self.step.time)
        if not refusal:
            self._goal, self._plans = goal, 2
        return refusal
