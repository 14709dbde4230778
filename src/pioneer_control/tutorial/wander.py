"""The tutorial's wander as a pure function: one snapshot and what was remembered in, one command and what to remember out.

The rule is the tutorial's. Of the six sonars in front the farthest counts: when it is one of the middle two the robot
drives, else it turns towards it, and when none sees OPEN it turns back. What makes it safe and lets it get somewhere:

- A tie goes to the middle: in the open all six see the same, and the robot would turn for ever.
- It drives only as far as its outline fits between the echoes, and starts only where it fits with some to spare.
- Once it drives it goes on until the way gets short; once it turns it keeps to that side.
- When it has turned enough and nothing was open, it takes the best way it saw.
- It remembers near echoes for a while (`echoes`): the cones leave gaps.
- It backs off only where sonars look and see that nothing is there.

Nothing in here knows ROS, threads or clocks; chance comes from the seed in the memory.
"""

import math
import random
from dataclasses import dataclass, replace
from enum import Enum
from typing import List, NamedTuple, Optional, Tuple

from pioneer_control.tutorial.clearance import Point
from pioneer_control.tutorial.echoes import Echo, remember
from pioneer_control.tutorial.snapshot import Command, Pose, Snapshot, Transducer

SPEED = 0.1  #: m/s, the tutorial's
TURN_RATE = 0.4  #: rad/s
STALE = 0.5  #: s; nobody acts on older data

FARTHEST = 5.0  #: m; no sonar sees farther
OPEN = 2.0  #: m; a direction in which a sonar sees this far is open
TIE = 0.3  #: m; what a middle sonar may see less than another and still win
SHORT = 1.0  #: m; the robot drives on until its middle sonars see less

DELAY = 0.5  #: s from an echo to the wheels: a round of the sonars, a packet, the command's way
DECELERATION = 0.3  #: m/s^2, of the robot's own ramp
ANGULAR_DECELERATION = 1.7  #: rad/s^2
IN_FRONT = 0.12  #: m left ahead of the outline when it has stopped
TO_SPARE = 0.30  #: m more than it needs to stop, to start driving
SLOW = 0.30  #: m before the stop from where on it drives slower
SLOWEST = 0.3  #: of the speed

ELBOW_ROOM = 0.12  #: m beyond its turning circle that the robot likes to have on both sides
STEER_AHEAD = 0.35  #: m ahead of that circle to where it looks for them
STEER_GAIN = 0.6  #: rad/s per metre of difference between the sides
STEER_LIMIT = 0.12  #: rad/s
WEAVE_RATE = 0.2  #: rad/s; a robot whose sonars leave a gap straight ahead weaves, so that nothing stays in it
WEAVE_PERIOD = 4.0  #: s

BACK_SPEED = 0.7  #: of the speed
BACK_TIME = 3.0  #: s at most
BACK_CLEAR = 0.20  #: m to see behind before, 0.05 less while backing off

CIRCLE_MARGIN = 0.05  #: m around the turning circle, to drive where the robot can turn round
STEADY = 0.15  #: rad/s; faster is turning
ROLLING = 0.03  #: m/s; faster has not come to rest yet
AT_HEADING = 0.1  #: rad


class Margin(NamedTuple):
    """What the robot leaves between its outline and echoes [m], at its sides and when it turns, and how fast it turns [rad/s]."""

    side: float
    turn: float
    rate: float


WIDE = Margin(side=0.08, turn=0.03, rate=TURN_RATE)
NARROW = Margin(side=0.04, turn=0.01, rate=TURN_RATE / 2)


class Room(Enum):
    """What the robot demands of a way: the next one only when the one before leaves it no way out."""

    TO_TURN_ROUND = 0
    TO_PASS = 1
    TO_SQUEEZE = 2


class Going(Enum):
    """What the robot is about."""

    LOOKING = "looking"
    DRIVING = "driving"
    TURNING = "turning"
    BACKING = "backing off"


class Way(NamedTuple):
    """A direction that was seen while turning: how far it is clear [m], and its heading [rad, odometry]."""

    clear: float
    heading: float


@dataclass(frozen=True)
class Memory:
    """What one decision hands to the next. A new wander begins with ``Memory(seed, speed)``."""

    seed: int = 0
    speed: float = SPEED  #: m/s
    going: Going = Going.LOOKING
    since: float = 0.0  #: s, when backing off began
    short: float = SHORT  #: m, drive on until the middle sees less
    side: int = 1  #: of the turn: 1 left, -1 right
    why: str = "turning {side}: to look round"  #: the reason of the turn, for people
    turned: float = 0.0  #: rad, since the turn began
    enough: float = 2 * math.pi  #: rad, to have looked around
    blocked: int = 0  #: how often this turn was in the way of something
    best: Optional[Way] = None
    goal: Optional[Way] = None  #: the best way, once the robot turns to it
    backed: bool = False  #: has backed off since it drove
    room: Room = Room.TO_TURN_ROUND
    pose: Optional[Pose] = None  #: of the last snapshot
    time: float = 0.0  #: s, of the last snapshot
    echoes: Tuple[Echo, ...] = ()


class View(NamedTuple):
    """A snapshot as the rule sees it."""

    snapshot: Snapshot
    points: List[Point]  #: all echoes known, in the robot's frame
    farthest: Transducer  #: of the front
    sees: float  #: m, how far
    middle: float  #: m, the farther of the middle two
    ahead: float  #: m the outline can go straight on
    circle: float  #: m it can go and still turn on the spot there
    way: float  #: m with the room that is demanded
    rolling: bool


def wander(snapshot: Snapshot, memory: Memory) -> Tuple[Command, Memory]:
    """Decide once: the command to give now, and what to hand to the next decision."""
    if snapshot.age > STALE:
        return no_news(snapshot.age), memory
    if not snapshot.robot.front:
        return Command(0.0, 0.0, "stopped: this robot has no sonar that looks ahead"), memory
    view, memory = _look(snapshot, memory)
    if memory.going is Going.BACKING:
        return _back_off(view, memory)
    if _open(view, memory):
        return _drive(view, replace(memory, short=SHORT))
    if memory.going is Going.DRIVING and _goes_on(view, memory):
        return _drive(view, memory)
    if memory.going is not Going.TURNING:
        memory = _begin_turn(view, memory)
    return _turn(view, memory)


def no_news(age: float) -> Command:
    """To stand, for what is known is `age` [s] old."""
    return Command(0.0, 0.0, "stopped: no news from the robot for %.1f s" % age)


def _look(snapshot: Snapshot, memory: Memory) -> Tuple[View, Memory]:
    robot, outline, ranges = snapshot.robot, snapshot.robot.outline, snapshot.ranges
    pose, before = snapshot.pose, memory.pose or snapshot.pose
    passed = max(snapshot.time - memory.time, 1e-3)
    turned = abs(_difference(pose.heading, before.heading))
    echoes, points = remember(memory.echoes, snapshot, turned > STEADY * passed)
    farthest = max(robot.front, key=lambda each: ranges[each.number] + TIE * (each.number in robot.middle))
    margin = NARROW if memory.room is Room.TO_SQUEEZE else WIDE
    ahead = outline.straight(points, margin.side, FARTHEST)
    circle = outline.circle_straight(points, CIRCLE_MARGIN, FARTHEST)
    way = min(ahead, circle) if memory.room is Room.TO_TURN_ROUND else ahead
    view = View(
        snapshot, points, farthest, ranges[farthest.number], max(ranges[number] for number in robot.middle), ahead, circle, way,
        rolling=math.hypot(pose.x - before.x, pose.y - before.y) > ROLLING * passed,
    )
    return view, replace(memory, pose=pose, time=snapshot.time, echoes=echoes, turned=memory.turned + turned)


def _open(view: View, memory: Memory) -> bool:
    """The tutorial's forward rule: the farthest sonar is a middle one and sees OPEN, and the robot fits."""
    in_the_middle = view.farthest.number in view.snapshot.robot.middle
    return in_the_middle and view.sees >= OPEN and view.way >= _stop_distance(memory.speed) + TO_SPARE


def _goes_on(view: View, memory: Memory) -> bool:
    return view.middle >= memory.short and view.ahead > _stop_distance(memory.speed) and view.way > _braking(memory.speed)


def _drive(view: View, memory: Memory) -> Tuple[Command, Memory]:
    """Forward, slower where the way gets short, and a little away from what is near at one side."""
    left_over = (view.ahead - _stop_distance(memory.speed)) / SLOW
    linear = memory.speed * min(1.0, max(SLOWEST, left_over))
    room = Room.TO_TURN_ROUND if view.circle > _braking(memory.speed) else memory.room
    memory = replace(memory, going=Going.DRIVING, best=None, goal=None, backed=False, room=room)
    return Command(linear, _steer(view, memory), "driving: %.1f m clear ahead" % view.ahead), memory


def _steer(view: View, memory: Memory) -> float:
    reach = view.snapshot.robot.outline.reach
    left = right = reach + ELBOW_ROOM
    for x, y in view.points:
        if -0.1 < x < reach + STEER_AHEAD:
            if y > 0:
                left = min(left, y)
            else:
                right = min(right, -y)
    angular = max(-STEER_LIMIT, min(STEER_LIMIT, STEER_GAIN * (left - right)))
    if not view.snapshot.robot.sees_ahead:
        angular += WEAVE_RATE * math.cos(2 * math.pi * view.snapshot.time / WEAVE_PERIOD)
    return angular if _can_turn(view, WIDE, 1 if angular > 0 else -1) else 0.0


def _begin_turn(view: View, memory: Memory) -> Memory:
    """Towards the farthest sonar; to a side that chance chooses when none is open, or the middle is but does not let the robot through."""
    chance = random.Random(memory.seed)
    side = chance.choice((1, -1))
    if view.sees < OPEN:
        why = "turning back, {side}: nothing ahead is open"
    elif view.farthest.number in view.snapshot.robot.middle:
        why = "turning {side}: the way ahead is too narrow"
    else:
        side = 1 if view.farthest.heading > 0 else -1
        why = "turning {side}: sonar %d sees %.1f m" % (view.farthest.number, view.sees)
    return replace(
        memory, going=Going.TURNING, side=side, why=why, turned=0.0, enough=2 * math.pi * chance.uniform(1.0, 1.5), blocked=0,
        best=None, goal=None, seed=chance.getrandbits(32),
    )


def _turn(view: View, memory: Memory) -> Tuple[Command, Memory]:
    """Keep to the side of the turn; after enough of it, or when both sides are blocked, go the best way that was seen."""
    if view.rolling:
        return Command(0.0, 0.0, "halting: to turn"), memory
    clear = min(view.way, view.middle)
    if memory.best is None or clear > memory.best.clear:
        memory = replace(memory, best=Way(clear, view.snapshot.pose.heading))
    if memory.goal is None and (memory.turned > memory.enough or memory.blocked > 1):
        why = "turning {side}: back to the best way seen, %.1f m" % memory.best.clear
        memory = replace(memory, goal=memory.best, why=why, blocked=0)
    if memory.goal is not None:
        off = _difference(memory.goal.heading, view.snapshot.pose.heading)
        if abs(off) < AT_HEADING:
            return _take_best_way(view, memory)
        if not memory.blocked:
            memory = replace(memory, side=1 if off > 0 else -1)
    for _ in range(2):
        for margin in (WIDE, NARROW) if memory.room is Room.TO_SQUEEZE else (WIDE,):
            if _can_turn(view, margin, memory.side):
                why = memory.why.format(side="left" if memory.side > 0 else "right")
                return Command(0.0, memory.side * margin.rate, why), memory
        memory = replace(memory, side=-memory.side, blocked=memory.blocked + 1)
    return _take_best_way(view, memory)


def _take_best_way(view: View, memory: Memory) -> Tuple[Command, Memory]:
    """The robot looks along the best way it knows, or cannot turn to it: go, make room, or make itself thin."""
    if view.ahead > _stop_distance(memory.speed) + 0.05:
        room = Room.TO_PASS if memory.room is Room.TO_TURN_ROUND else memory.room
        return _drive(view, replace(memory, short=min(SHORT, view.middle / 2), room=room))
    snapshot, robot = view.snapshot, view.snapshot.robot
    if not memory.backed and robot.sees_behind and robot.outline.straight(view.points, WIDE.side, 1.0, -1) > BACK_CLEAR:
        return _back_off(view, replace(memory, going=Going.BACKING, since=snapshot.time, backed=True))
    memory = replace(memory, going=Going.LOOKING, backed=False)
    not_heard = [each.number for each in robot.transducers if not snapshot.ranges[each.number]]
    if not_heard:
        return Command(0.0, 0.0, "waiting: sonar %d is not heard" % not_heard[0]), memory
    room = Room.TO_TURN_ROUND if memory.room is Room.TO_SQUEEZE else Room.TO_SQUEEZE
    return Command(0.0, 0.0, "waiting: no way out seen yet"), replace(memory, room=room)


def _back_off(view: View, memory: Memory) -> Tuple[Command, Memory]:
    """Straight back, while sonars look there and see that it is clear."""
    behind = view.snapshot.robot.outline.straight(view.points, WIDE.side, 1.0, -1)
    if behind > BACK_CLEAR - 0.05 and view.snapshot.time - memory.since < BACK_TIME:
        return Command(-BACK_SPEED * memory.speed, 0.0, "backing off: no room to turn, %.1f m clear behind" % behind), memory
    return Command(0.0, 0.0, "halting: to look again"), replace(memory, going=Going.LOOKING)


def _can_turn(view: View, margin: Margin, side: int) -> bool:
    """Is the turn free as far as it would go before it could be stopped?"""
    needed = margin.rate * DELAY + margin.rate ** 2 / (2 * ANGULAR_DECELERATION)
    return view.snapshot.robot.outline.turn(view.points, side, margin.turn, needed) >= needed


def _braking(speed: float) -> float:
    """How far it goes [m] from the moment there is a reason to stop."""
    return speed * DELAY + speed ** 2 / (2 * DECELERATION)


def _stop_distance(speed: float) -> float:
    """What the robot needs ahead [m] to come to rest IN_FRONT of something."""
    return IN_FRONT + _braking(speed)


def _difference(heading: float, other: float) -> float:
    """From one heading to another [rad], -pi to pi: left is positive."""
    return math.remainder(heading - other, 2 * math.pi)
