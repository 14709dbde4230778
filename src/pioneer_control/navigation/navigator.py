"""One robot's way to a goal: when it drives, when it waits and why, when it is there, and when it gives up.

The navigator is told what the robot senses, where it is and whether it may move, once for each standard packet. Its
answer is a velocity. The robot stands whenever one of these is not well, and drives on when all are well again.
"""

import enum
import math
import re
from collections import deque
from typing import Any, Deque, Iterable, List, NamedTuple, Optional, Protocol, Sequence, Tuple

import numpy as np

from ..floor_poses import Pose, compose, distance_between, relative, wrapped
from ..maps.grid_map import GridMap
from .aside import Aside
from .chassis import Chassis, distance_outside
from .frames import into, out_of
from .lateness import Lateness
from .obstacles import Obstacles, cells_near, edge_cells
from .planning import NOT_SLOW, DrivableFloor, RoutePlan, length_of
from .steering import NOBODY, NOWHERE, Around, SteeringChoice, Steering, slowness
from .suspected_walls import SuspectedWalls
from .tuned import NavigationNumbers, NavigatorNumbers
from .values import STOP, Point, Sensing, Twist

Array = Any     # of numpy
_NEAR = 1.8     # m: farther faces of walls cannot end a move
_GAP_AHEAD = 10     # squares: what does not let the robot through is not farther ahead on its way
_TRAIL, _TRAIL_STEP = 40, 0.015     # poses; m, rad
_STANDS = 0.05      # m/s: a slower robot stands, and may look around
_LOOKS_ASIDE = 0.5      # rad: so far it looks around to both sides of its way
_LOOKS_AHEAD = 5.0      # s: so long it does, then all round
SLOW_LINE = 0.06
"""Time (s) that a packet needs on a serial line of 9600 baud."""
_GIVING_WAY = "giving way: something that is on no map is near, and may walk"
_LOST = "the robot does not know where it is"
_GOING_ROUND = "going round what is on no map"


class Whereabouts(Protocol):
    """Where the robot is: its pose (map frame), whether that is sure, and if not, why."""

    @property
    def pose(self) -> Pose:
        """The most likely pose (m, rad; map frame)."""

    @property
    def sure(self) -> bool:
        """Whether the robot is there for certain."""

    @property
    def reason(self) -> str:
        """Why it is not sure, for people."""

    @property
    def line(self) -> Sequence[Pose]:
        """Poses along a line on which the robot is for certain, when only where on it is not sure; else empty."""


class Readiness(NamedTuple):
    """What lets the robot move, and how soon it reacts.

    Attributes:
        stalled: a wheel is driven but does not turn.
        may_command: nobody else has the helm.
        motors: motor power is on.
        late: how much later (s) than the quickest of the last seconds the newest packet came.
        on_the_way: how long (s) a packet is on the way from the robot to here; `SLOW_LINE`, if nobody knows.
    """

    stalled: bool = False
    may_command: bool = True
    motors: bool = True
    late: float = 0.0
    on_the_way: float = SLOW_LINE


class State(enum.Enum):
    """What the navigator does."""

    IDLE = "idle"
    DRIVING = "driving"
    WAITING = "waiting"
    REACHED = "reached"
    FAILED = "failed"

    @property
    def has_goal(self) -> bool:
        """Whether there is a goal that the robot is on the way to, or waits to go to."""
        return self in (State.DRIVING, State.WAITING)


class Decision(NamedTuple):
    """What the robot does now: a velocity, the state, and the reason for people."""

    twist: Twist
    state: State
    reason: str


def kind_of(reason: str) -> str:
    """Return a reason up to its first number: it stays the same while the robot does the same."""
    return re.split("[0-9]", reason, maxsplit=1)[0]


class Accelerations(NamedTuple):
    """Accelerations that the robot must have while it navigates: m/s^2 to drive and to brake, rad/s^2 to turn."""

    linear: float
    braking: float
    angular: float


class _Task:
    """A goal, and how far the robot has come with it."""

    def __init__(self, goal: Pose, with_heading: bool, now: float, numbers: NavigatorNumbers):
        self.goal, self.with_heading = goal, with_heading
        self.at_goal = False
        self.plan: Optional[RoutePlan] = None
        self.way: List[Point] = []              # m, map frame: from the robot to the goal by this plan
        self.map_plan: Optional[RoutePlan] = None       # the plan if nothing stood there that is on no map
        self.obstacle_on_way = False            # something does stand there
        self.plan_taken_at = -math.inf          # s
        self.planned_at = -math.inf             # s, when a plan was made last, taken or not
        self.least_to_go = math.inf             # m, least cost to go so far
        self.progress_at = now                  # s, when it last fell while the robot got on
        self.progress_odometry: Optional[Pose] = None   # odometry then
        self.waiting_since: Optional[float] = None      # s
        self.waiting_kind = ""                  # of its reasons
        self.last_twist = STOP                  # what the robot was told last
        self.stall_count = 0
        self.blocked_since: Optional[float] = None      # s; None: it is not blocked
        self.blocked_at: Optional[Pose] = None          # pose (map frame) then
        self.aside = Aside(numbers)
        self.closed: List[Point] = []           # m, map frame: where it did not get through

    def waited(self, kind: str, now: float) -> float:
        """Return for how long (s) it has waited for a reason of this kind."""
        return 0.0 if self.waiting_since is None or self.waiting_kind != kind else now - self.waiting_since

    def wait(self, kind: str, now: float) -> None:
        """Wait for a reason of this kind."""
        if self.waiting_since is None or self.waiting_kind != kind:
            self.go_on(now)
            self.waiting_since, self.waiting_kind = now, kind

    def go_on(self, now: float) -> None:
        """End to wait, if it did. The time of waiting is no time without progress."""
        if self.waiting_since is not None:
            self.progress_at += now - self.waiting_since
            self.waiting_since = None


class Navigator:
    """Drives one robot to goals on one map."""

    def __init__(self, grid_map: GridMap, chassis: Chassis, numbers: NavigationNumbers = NavigationNumbers(),
                 makes_map: bool = False):
        """Prepare the map.

        Args:
            grid_map: the map, which all poses and goals are on.
            chassis: the robot.
            numbers: the tuned numbers.
            makes_map: the robot makes this map. A way may lead over unknown floor (the robot drives only where
                its sonar looks, as always), and it does not give way: everything is new to it.
        """
        self._map, self._chassis, self._numbers = grid_map, chassis, numbers
        self._makes_map = makes_map
        self._floor = self._floor_of(grid_map)
        self._edges = edge_cells(self._floor.clearance)
        self._obstacles = Obstacles(chassis, grid_map, self._floor.clearance, numbers.obstacles, makes_map)
        self._steering = Steering(chassis, numbers.steering, makes_map)
        self._task: Optional[_Task] = None
        self._ended = Decision(STOP, State.IDLE, "no goal")
        self._last: Optional[Sensing] = None
        self._velocity = STOP
        self._lateness = Lateness()
        self._answer = 0.0              # s, from the newest packet to the effect of its answer
        self._here: Optional[Point] = None              # m, map frame; None while it is not sure
        self._place: Optional[Pose] = None              # where it was sure to be last on its way
        self._place_odometry = Pose(0.0, 0.0, 0.0)      # its odometry there
        self._stalled = -math.inf       # s, when a wheel last stalled
        self._suspected = SuspectedWalls(chassis.half_width, numbers.suspected_walls)
        self._trail: Deque[Pose] = deque(maxlen=_TRAIL)     # odometry where it was lately

    def use_map(self, grid_map: GridMap) -> None:
        """Go on with a newer map. The goal stays, and what was heard lately; the way is planned anew."""
        self._map = grid_map
        self._floor = self._floor_of(grid_map)
        self._edges = edge_cells(self._floor.clearance)
        self._obstacles.use_map(grid_map, self._floor.clearance)
        if self._task is not None:
            self._task.planned_at, self._task.map_plan = -math.inf, None

    def _floor_of(self, grid_map: GridMap) -> DrivableFloor:
        """Return the floor of a map.

        A robot that makes its map is not slow beside what is on no map: at first all is.
        """
        chassis, numbers = self._chassis, self._numbers
        slow = NOT_SLOW if self._makes_map else slowness(numbers.steering, chassis.max_linear)
        return DrivableFloor(grid_map, chassis.half_width, numbers.planning, self._makes_map, slow)

    @property
    def acceleration_wanted(self) -> Accelerations:
        """The accelerations that the driver is to be asked for while a goal is driven to."""
        steering = self._numbers.steering
        return Accelerations(steering.acceleration, steering.braking, steering.turn_acceleration)

    @property
    def late(self) -> float:
        """How much later (s) than usual the robot reacts now: its packets come late, or are not answered."""
        return self._lateness.late

    @property
    def plan(self) -> List[Point]:
        """The way from the robot to its goal as points (m, map frame). Empty without a goal or a pose."""
        return self._task.way if self._task is not None else []

    def way(self, start: Point, goal: Point) -> Tuple[List[Point], str]:
        """Return the way between two places (m, map frame) as points, without driving; or no points and a refusal."""
        refusal = self._floor.refusal(start, goal)
        return ([], refusal) if refusal else (self._floor.to(goal).points_from(start), "")

    def shortest(self, start: Point, goal: Point) -> float:
        """Return the length (m) of the shortest way between two places, infinite without one."""
        return self._floor.shortest(start, goal)

    def go_to(self, x: float, y: float, heading: Optional[float], now: float) -> str:
        """Begin to drive to a goal (m, rad; map frame), instead of an earlier one.

        Args:
            heading: the heading to have there; None when any will do.
            now: the time (s).

        Returns:
            Why the goal is refused, for people; then an earlier goal stays. Empty when it is accepted.
        """
        refusal = self._refusal(x, y, heading)
        if not refusal:
            self._task = _Task(Pose(x, y, heading or 0.0), heading is not None, now,
                               self._numbers.navigator)
        elif self._task is None:
            self._ended = Decision(STOP, State.FAILED, refusal)
        return refusal

    def _refusal(self, x: float, y: float, heading: Optional[float]) -> str:
        """Return why a goal (m, rad; map frame) is refused, for people. Empty when it is not."""
        if heading is not None and not math.isfinite(heading):
            return "the heading %g of the goal is not finite: give a number in radians" % heading
        refusal = self._floor.refusal(self._here or (x, y), (x, y))
        if refusal or heading is None or self._makes_map:
            return refusal
        walls = self._walls_near(Pose(x, y, heading))
        least = distance_outside(self._chassis.outline, *walls).min(initial=math.inf)
        return "" if least > self._numbers.steering.margin else (
            "at the goal (%.2f, %.2f) a wall is in the way of a heading of %.2f rad: the robot does not fit" % (
                x, y, heading))

    def cancel(self) -> None:
        """Drop the goal. The robot stops."""
        self.end(State.IDLE, "no goal")

    def end(self, state: State, reason: str) -> Decision:
        """End the way to the goal, if there is one. Return the decision, which stays until the next goal: to stand."""
        self._task = None
        self._ended = Decision(STOP, state, reason)
        return self._ended

    def forget_obstacles(self) -> None:
        """Forget what was heard that is on no map."""
        self._obstacles.forget()

    def step(self, sensing: Optional[Sensing], where: Optional[Whereabouts], readiness: Readiness,
             now: float) -> Decision:
        """Return what to do now.

        Args:
            sensing: the newest that the robot sensed; None before the first.
            where: where it is then; None when nobody knows.
            readiness: what lets it move.
            now: the time (s) on the clock of `sensing`. The later the answers are, the slower the robot is near
                anything.
        """
        sure = where is not None and where.sure and all(map(math.isfinite, where.pose))
        self._here = where.pose[:2] if where is not None and sure else None
        self._sense(sensing, where.pose if where is not None and sure else None, now)
        self._answer = readiness.on_the_way + readiness.late + self._numbers.steering.answered
        if readiness.stalled:
            self._feel_stall(now)
        task = self._task
        if task is None:
            return self._ended
        if task.stall_count >= self._numbers.navigator.most_stalls:
            return self.end(State.FAILED, "gave up: the wheels stalled %d times, by something that sonar does not hear"
                            % task.stall_count)
        hindrance = self._hindrance(sensing, readiness, now)
        if hindrance:
            return self._wait(task, kind_of(hindrance), Decision(STOP, State.WAITING, hindrance), now)
        if not sure:
            return self._look_around(task, where, now)
        assert where is not None and sensing is not None
        self._place, self._place_odometry = where.pose, sensing.odometry
        task.go_on(now)
        if task.plan is None:
            refusal = self._floor.refusal(where.pose[:2], task.goal[:2])
            if refusal:
                return self.end(State.FAILED, refusal)
            task.progress_at = now      # the goal may be older than the first packet
        return self._drive(task, where.pose, now)

    def _sense(self, sensing: Optional[Sensing], pose: Optional[Pose], now: float) -> None:
        if sensing is None or sensing is self._last or not all(map(math.isfinite, (sensing.time, *sensing.odometry))):
            return
        last = self._last
        if last is not None and sensing.time <= last.time:
            self._obstacles.forget()
            self._suspected.forget()
            self._trail.clear()
            self._velocity = STOP
        elif last is not None:
            along, _ = into(last.odometry, np.array(sensing.odometry.x), np.array(sensing.odometry.y))
            time = sensing.time - last.time
            turned = wrapped(sensing.odometry.heading - last.odometry.heading)
            self._velocity = Twist(float(along) / time, turned / time)
        self._obstacles.hear(sensing, pose)
        self._last = sensing
        self._lateness.note(sensing.time, now)
        self._suspected.drive(sensing.odometry)
        if not self._trail or distance_between(sensing.odometry, self._trail[-1]) > _TRAIL_STEP or abs(
                wrapped(sensing.odometry.heading - self._trail[-1].heading)) > _TRAIL_STEP:
            self._trail.append(sensing.odometry)

    def _feel_stall(self, now: float) -> None:
        """Remember what stalled the wheels: something that sonar does not hear, where the robot was going."""
        if self._last is not None and now - self._stalled > self._numbers.navigator.rest:
            way = (self._task.last_twist.linear if self._task else 0.0) or self._velocity.linear or 1.0
            points = [(x, y) for x, y in _rim(self._chassis.outline) if x * way > 0.0 and abs(x) > 0.1]
            x, y = (np.array(each) for each in zip(*points))
            scale = 1.0 + 0.03 / np.hypot(x, y)
            self._obstacles.add(*out_of(self._last.odometry, x * scale, y * scale), now)
            if self._task is not None:
                self._task.stall_count += 1
        self._stalled = now

    def _hindrance(self, sensing: Optional[Sensing], readiness: Readiness, now: float) -> str:
        """Return why the robot must not move, for people. Empty when it may."""
        numbers = self._numbers.navigator
        if sensing is None or sensing is not self._last:
            return "the robot has sensed nothing that makes sense"
        if not abs(now - sensing.time) <= numbers.stale:
            return "what the robot sensed is %.1f s old" % (now - sensing.time)
        if not readiness.motors:
            return "motor power is off"
        if not readiness.may_command:
            return "somebody else has the helm"
        if readiness.stalled or now - self._stalled < numbers.rest:
            return "a wheel stalls"
        if not self._obstacles.live(now - numbers.silent):
            return "the sonar is silent"
        return ""

    def _wait(self, task: _Task, kind: str, decision: Decision, now: float) -> Decision:
        """Return the decision to wait; or give up, when the robot has waited for reasons of this kind for too long."""
        task.last_twist = decision.twist
        task.wait(kind, now)
        waited = task.waited(kind, now)
        if waited > self._numbers.navigator.wait:
            return self.end(State.FAILED, "gave up after %.0f s: %s" % (waited, decision.reason))
        return decision

    def _look_around(self, task: _Task, where: Optional[Whereabouts], now: float) -> Decision:
        """Wait until the robot knows where it is. It may turn on the spot where it touches nothing.

        Turning does not tell it how far along a corridor it is. If nothing else is in doubt, it looks from elsewhere.
        """
        numbers = self._numbers.navigator
        task.planned_at, task.at_goal = -math.inf, False
        reason = _LOST if where is None or not where.reason else where.reason
        twist, reckoned = STOP, self._reckoned()
        around = self._around(reckoned, now)._replace(lost=NOBODY)    # the map explains no wall while it is not sure
        if around.apart[-1] >= numbers.give_way and not self._somebody_beside(reckoned, now):
            if where is not None and where.line and numbers.unsure_speed > 0.0 and (
                    _LOOKS_AHEAD < task.waited(_LOST, now) < numbers.unsure_drive):
                twist = self._along(where, now)
            if twist == STOP and abs(self._velocity.linear) < _STANDS and numbers.unsure_turn > 0.0:
                rate = math.copysign(min(numbers.unsure_turn, self._chassis.max_angular), self._side(task, where, now))
                turns = [each for each in (rate, -rate) if self._steering.may_turn(each, self._velocity, around)]
                twist = Twist(0.0, turns[0]) if turns else STOP
        return self._wait(task, _LOST, Decision(twist, State.WAITING, reason), now)

    def _along(self, where: Whereabouts, now: float) -> Twist:
        """Return the velocity with which the robot goes slowly on along the line on which it is, or a stop.

        As always, it drives only where a transducer looks, and stops before what it hears. It also keeps off the walls
        of the map as they are around each pose on the line.
        """
        numbers = self._numbers.navigator
        (x, y, _), (end_x, end_y, _), pose = where.line[0], where.line[-1], where.pose
        direction = math.atan2(end_y - y, end_x - x)
        if abs(wrapped(direction - pose.heading)) > math.pi / 2.0:
            direction += math.pi
        ahead = Pose(pose.x + math.cos(direction), pose.y + math.sin(direction), direction)
        around = self._around(None, now)._replace(lost=NOBODY)
        walls = [self._walls_near(each) for each in where.line]
        around = around._replace(standing_x=np.concatenate([around.standing_x, *(x for x, _ in walls)]),
                                 standing_y=np.concatenate([around.standing_y, *(y for _, y in walls)]))
        live = self._obstacles.live(now - numbers.silent)
        twist = self._steering.finish(pose, self._velocity, around, live, ahead, False, self._answer).twist
        if not twist.linear:
            return Twist(0.0, float(np.clip(twist.angular, -numbers.unsure_turn, numbers.unsure_turn)))
        slower = min(1.0, numbers.unsure_speed / abs(twist.linear))
        return Twist(twist.linear * slower, twist.angular * slower)

    def _somebody_beside(self, pose: Optional[Pose], now: float) -> bool:
        """Return whether something is beside the robot that came lately, and is no wall if the robot is at a pose.

        Somebody who waits until it is gone may stand still for some seconds, and walk when it begins to turn.
        """
        if pose is None:
            return False
        numbers, places = self._numbers, self._obstacles.heard()
        assert self._last is not None
        places = places.chosen(~places.mapped & places.came & (now - places.time < numbers.obstacles.young)
                               & (now - places.since < numbers.navigator.unsure_beside))
        x, y = into(self._last.odometry, places.x, places.y)
        walls = self._obstacles.explained(*out_of(pose, x, y), np.hypot(x, y))
        return bool((distance_outside(self._chassis.outline, x, y)[~walls] < numbers.navigator.give_way).any())

    def _side(self, task: _Task, where: Optional[Whereabouts], now: float) -> float:
        """Return a positive number to look around to the left, a negative one to the right.

        First it turns to where its way probably begins, and there to and fro: so it can drive off as soon as it is
        sure. If that does not tell it where it is, it turns round and round.
        """
        turned = task.last_twist.angular
        if turned and task.waited(_LOST, now) > _LOOKS_AHEAD or where is None or not all(
                map(math.isfinite, where.pose)):
            return turned
        if task.map_plan is None:
            task.map_plan = self._floor.to(task.goal[:2])
        x, y, heading = where.pose
        off = wrapped(float(task.map_plan.heading(np.array(x), np.array(y))) - heading)
        return off if abs(off) > _LOOKS_ASIDE or not turned else turned

    def _drive(self, task: _Task, pose: Pose, now: float) -> Decision:
        numbers = self._numbers
        if now - task.planned_at >= numbers.navigator.replan or task.plan is None:
            self._plan_anew(task, pose, now)
        if now - task.progress_at > numbers.navigator.patience or task.aside.count > numbers.navigator.most_asides:
            aside = ", also after it went aside" if task.aside.count > 1 else ""
            return self.end(State.FAILED, "gave up: no way on for %.0f s%s, %.2f m from the goal" % (
                now - task.progress_at, aside, distance_between(task.goal, pose)))
        around, live = self._around(pose, now), self._obstacles.live(now - numbers.navigator.silent)
        if around.apart[-1] < numbers.navigator.give_way:
            task.last_twist = STOP
            return Decision(STOP, State.WAITING, _GIVING_WAY)
        assert task.plan is not None
        task.way = task.plan.points_from(pose[:2])
        choice = self._choose(task, pose, around, live, now)
        if choice is None:
            return self.end(State.REACHED, "reached the goal")
        self._note_progress(task, pose, choice.blocked, now)
        if task.blocked_at is not None and distance_between(pose, task.blocked_at) > 0.15:
            task.blocked_since = task.blocked_at = None
        task.last_twist = choice.twist
        if not choice.blocked:
            return Decision(choice.twist, State.DRIVING, _doing(task, choice.reason))
        if task.blocked_since is None:
            task.blocked_since, task.blocked_at = now, pose
        return Decision(STOP, State.WAITING, choice.reason)

    def _note_progress(self, task: _Task, pose: Pose, blocked: bool, now: float) -> None:
        """Note whether the robot gets on: the cost to go falls, and its wheels have moved.

        A map that is being made changes, and with it the cost: only who drives gets on.
        """
        numbers = self._numbers.navigator
        assert task.plan is not None and self._last is not None
        to_go, odometry = float(task.plan.cost(np.array(pose.x), np.array(pose.y))), self._last.odometry
        if to_go < task.least_to_go - numbers.progress or task.at_goal and not blocked:
            task.least_to_go = to_go
            before = task.progress_odometry
            if task.at_goal or before is None or distance_between(odometry, before) > numbers.got_on:
                task.progress_at, task.progress_odometry = now, odometry
        elif to_go > task.least_to_go + 2.0:
            task.least_to_go = to_go    # a new plan leads round: measure its progress anew, on the same patience

    def _plan_anew(self, task: _Task, pose: Pose, now: float) -> None:
        """Plan. Keep the plan that there is while its way is not much worse, so that the robot does not turn to and fro
        between two ways past an obstacle. The first plan is of the map alone, and the next packet's has the obstacles:
        two plans of a large map take too long for one packet.
        """
        numbers = self._numbers
        if task.map_plan is None:
            task.map_plan = self._floor.to(task.goal[:2])
            task.plan = task.plan or task.map_plan        # after a change of the map it goes on by the old one
            return
        unmapped = self._obstacles.unmapped(pose)
        there = [unmapped, *task.closed]
        if not self._makes_map:       # a robot that makes its map draws there what stands
            there.append(self._obstacles.note_standing(pose, now))
        plan = self._floor.past(task.map_plan, np.vstack(there), pose[:2])
        task.planned_at = now
        task.obstacle_on_way = _stands_on(unmapped, task.map_plan.points_from(pose[:2]),
                                          self._chassis.half_width + numbers.planning.keep)
        if task.plan is not None and now - task.plan_taken_at < numbers.navigator.plan_kept:
            kept = plan.cost_of_way(task.plan.points_from(pose[:2]))
            if float(plan.cost(np.array(pose.x), np.array(pose.y))) > numbers.navigator.better * kept:
                return
        task.plan, task.plan_taken_at = plan, now

    def _choose(self, task: _Task, pose: Pose, around: Around, live: List[int], now: float) -> Optional[SteeringChoice]:
        """Return the next velocity, or None when the robot stands at the goal. Note in the task whether it is there."""
        numbers, goal, plan = self._numbers.steering, task.goal, task.plan
        assert plan is not None
        distance = distance_between(goal, pose)
        stands_at = self._steering.stands_at(pose, self._velocity, task.last_twist, self._answer)
        near = numbers.arrived_at_last if now - task.progress_at > self._numbers.navigator.slow else numbers.arrived
        task.at_goal = distance_between(goal, stands_at) < (2.5 * numbers.arrived + 0.03 if task.at_goal else near)
        if task.at_goal:
            off = abs(wrapped(goal.heading - stands_at.heading)) if task.with_heading else 0.0
            if off < numbers.arrived_heading:
                stands = self._steering.stands(self._velocity, task.last_twist)
                return None if stands else SteeringChoice(STOP, "at the goal, stopping")
            return self._steering.finish(pose, self._velocity, around, live, goal, True, self._answer)
        if task.aside.is_due(task.progress_at, now) and task.planned_at < now:     # one plan a packet
            task.aside.begin(self._floor, pose, self._obstacles.unmapped(pose), now)
            task.closed.append(_tightest(self._floor, task.way))
        aside = task.aside.plan(pose, task.progress_at, now)
        if aside is None and distance < numbers.final and self._floor.straight(pose[:2], goal[:2]):
            choice = self._steering.finish(pose, self._velocity, around, live, goal, False, self._answer)
            if not choice.blocked:
                return choice
        return self._on(task, aside or plan, pose, around, live, now)

    def _on(self, task: _Task, plan: RoutePlan, pose: Pose, around: Around, live: List[int],
            now: float) -> SteeringChoice:
        """Return the velocity that leads on along a plan."""
        assert self._last is not None
        blocked = max(0.0 if task.blocked_since is None else now - task.blocked_since,
                      now - task.progress_at - self._numbers.navigator.slow)
        trail = _seen_from(self._last.odometry, self._trail) if blocked > 0.0 else NOWHERE
        return self._steering.choose(pose, self._velocity, around, live, plan, blocked, task.last_twist, trail)

    def _reckoned(self) -> Optional[Pose]:
        """Return where the robot should be by the wheels since it was sure; None if it never was."""
        assert self._last is not None
        if self._place is None:
            return None
        return compose(self._place, relative(self._place_odometry, self._last.odometry))

    def _walls_near(self, pose: Pose) -> Tuple[Array, Array]:
        """Return the walls of the map near a pose (map frame), as points (m, robot's frame).

        On a map that is given a wall may be anywhere in its cell. A map that is being made draws walls too thick, so
        there the middle of the cell counts.
        """
        half = 0.0 if self._makes_map else self._map.resolution / 2.0
        return cells_near(self._map, self._edges, pose, _NEAR, half)

    def _around(self, pose: Optional[Pose], now: float) -> Around:
        """Return what is around the robot: what was heard, and the walls of the map if there is a pose on it.

        A robot that makes its map has everything on no map yet: it is beside nothing that may walk.
        """
        tuned, places = self._numbers.obstacles, self._obstacles.heard()
        assert self._last is not None
        x, y = into(self._last.odometry, places.x, places.y)
        walking = ~places.mapped & (now - places.time < tuned.young)
        still = np.where(places.came_up, tuned.proves_still_came, tuned.proves_still)
        unproven = ~places.mapped & (now - places.since < still)
        lost = ~places.mapped & (places.time - places.since < tuned.proves_still) & (now - places.time < tuned.lost)
        apart, beside, left = (self._steering.apart(x, y, which & (not self._makes_map))
                               for which in (unproven, walking, lost))
        wall_x, wall_y = (np.zeros(0),) * 2 if pose is None else self._walls_near(pose)
        all_x, all_y = np.append(x, wall_x), np.append(y, wall_y)
        if self._makes_map:
            more_x, more_y = self._suspected.places(all_x, all_y, self._obstacles.looks(), self._last.odometry)
            all_x, all_y = np.append(all_x, more_x), np.append(all_y, more_y)
        return Around(all_x, all_y, x[walking], y[walking], apart, beside, left, self.late)


def _seen_from(odometry: Pose, trail: Iterable[Pose]) -> Array:
    """Return where the robot was lately (robot's frame), as an array (number, 3); odometry: where it is now."""
    x, y, heading = np.array(trail).T
    return np.column_stack((*into(odometry, x, y), heading - odometry.heading))


def _stands_on(places: Array, way: List[Point], near: float) -> bool:
    """Return whether one of some places (m, map frame) is nearer than `near` (m) to the next two metres of a way."""
    if not len(places) or not way:
        return False
    points = np.array(way)
    steps = np.hypot(*np.diff(points, axis=0).T)
    points = points[np.append(0.0, np.cumsum(steps)) < 2.0]
    apart = np.hypot(*(places[:, np.newaxis] - points).transpose(2, 0, 1))
    return bool(apart.min() < near)


def _tightest(floor: DrivableFloor, way: List[Point]) -> Point:
    """Return the place (m, map frame) with least room on the next part of a way, which begins where the robot is."""
    return min(way[1:1 + _GAP_AHEAD], key=lambda point: floor.room(*point))


def _doing(task: _Task, reason: str) -> str:
    """Return what the robot does, for people; on its way, with the length (m) of what is left of it."""
    if reason != "on the way":
        return reason
    return "%s, %.1f m to go" % (_GOING_ROUND if task.obstacle_on_way else reason, length_of(task.way))


def _rim(outline: Tuple[Point, ...]) -> List[Point]:
    """Return points along an outline, about 4 cm apart."""
    points = []
    for (x1, y1), (x2, y2) in zip(outline, outline[1:] + outline[:1]):
        count = max(1, math.ceil(math.hypot(x2 - x1, y2 - y1) / 0.04))
        points += [(x1 + (x2 - x1) * k / count, y1 + (y2 - y1) * k / count) for k in range(count)]
    return points
