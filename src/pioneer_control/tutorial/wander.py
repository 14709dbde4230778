"""The tutorial's wander as a pure function: a snapshot and a memory go in, a move and a memory come out.

The rule is the tutorial's. Of the six sonars in front the farthest counts. If it is one of the middle two, the robot
drives. If it is another, the robot turns towards it. If none sees OPEN, it turns back. These rules make it safe and let
it get somewhere:

- When several see equally far, the middle wins: in the open all six see the same, and the robot would turn for ever.
- It drives only as far as its outline fits between the echoes, and starts only where there is more room than it needs.
- Once it drives, it goes on until the way gets short. Once it turns, it keeps to that side.
- When it has turned enough and nothing was open, it takes the best way that it saw.
- It remembers near echoes for a while (`echoes`): the cones leave gaps.
- It backs off only where sonars look and see that nothing is there.
- When its wheels stall, it stops until they have been free for a while. Then it backs off and goes another way: what
  held it stands where no sonar sees it.
- In the same way it leaves what it has put down.

This file knows nothing of ROS, threads or clocks; chance comes from the seed in the memory.
"""

import math
import random
from dataclasses import dataclass, replace
from enum import Enum
from typing import List, NamedTuple, Optional, Tuple

from ..robots import Transducer
from .clearance import Point
from .echoes import Echo, remember
from .snapshot import Pose, Snapshot

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
WEAVE_RATE = 0.2  #: rad/s; a robot whose sonars leave a gap straight ahead weaves, so that nothing stays in the gap
WEAVE_PERIOD = 4.0  #: s

BACK_SPEED = 0.7  #: of the speed
BACK_WAY = 0.21  #: m at most
BACK_CLEAR = 0.20  #: m to see behind before, 0.05 less while backing off
FREE_FOR = 1.0  #: s that the wheels must have been free before a robot that stalled moves again
AVOIDED = 1.2  #: rad to each side of what it leaves: it does not drive there

CIRCLE_MARGIN = 0.05  #: m around the turning circle, to drive where the robot can turn round
STEADY = 0.15  #: rad/s; faster is turning
ROLLING = 0.03  #: m/s; faster has not come to rest yet
AT_HEADING = 0.1  #: rad


class Move(NamedTuple):
    """What the robot shall do until the next decision, and why, for people."""

    linear: float  #: m/s, forward positive
    angular: float  #: rad/s, left positive
    reason: str  #: what it does, then a colon, then why


class Margin(NamedTuple):
    """How much room the robot leaves between its outline and echoes, and how fast it turns with so much room."""

    side: float  #: m, beside it while it drives
    turn: float  #: m, while it turns
    rate: float  #: rad/s


WIDE = Margin(side=0.08, turn=0.03, rate=TURN_RATE)
NARROW = Margin(side=0.04, turn=0.01, rate=TURN_RATE / 2)


Room = Enum("Room", ["TO_TURN_ROUND", "TO_PASS", "TO_SQUEEZE"])
"""How much room a way must have. The robot demands less only when it finds no way out with so much."""

Going = Enum("Going", {
    "LOOKING": "looking",
    "DRIVING": "driving",
    "TURNING": "turning",
    "BACKING": "backing off",
    "HELD": "held: the wheels stall",
    "LEAVING": "leaving what it has put down",
})
"""What the robot is about."""


class Way(NamedTuple):
    """A direction that was seen while turning: how far it is clear [m], and its heading [rad, odometry]."""

    clear: float
    heading: float


@dataclass(frozen=True)
class Memory:
    """What one decision hands to the next. A new wander begins with ``Memory(seed, speed)``.

    To leave what was put down it begins with ``Memory(seed, speed, going=Going.LEAVING)``.
    """

    seed: int = 0
    speed: float = SPEED  #: m/s
    going: Going = Going.LOOKING
    since: float = 0.0  #: s, when backing off began; the last time that the wheels stalled
    short: float = SHORT  #: m, drive on until the middle sees less
    side: int = 1  #: of the turn: 1 left, -1 right
    avoided: Optional[float] = None  #: rad, the heading to what it leaves, until it drives elsewhere
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


def wander(snapshot: Snapshot, memory: Memory) -> Tuple[Move, Memory]:
    """Decide once.

    Returns:
        What to do now, and what to hand to the next decision.
    """
    if snapshot.age > STALE:
        return no_news(snapshot.age), memory
    if not snapshot.robot.front:
        return Move(0.0, 0.0, "stopped: this robot has no sonar that looks ahead"), memory
    view, memory = _look(snapshot, memory)
    if snapshot.stalled or memory.going is Going.HELD:
        return _stand_while_held(view, memory)
    if memory.going is Going.LEAVING:
        return _leave(view, memory)
    if memory.going is Going.BACKING:
        return _back_off(view, memory)
    if _open(view, memory):
        return _drive(view, replace(memory, short=SHORT))
    if memory.going is Going.DRIVING and _goes_on(view, memory):
        return _drive(view, memory)
    return _turn(view, memory if memory.going is Going.TURNING else _begin_turn(view, memory))


def can_leave(snapshot: Snapshot) -> bool:
    """Is there room behind the robot to leave what it puts down, and do its sonars look there?"""
    _, points = remember((), snapshot, turning=False)
    return snapshot.robot.sees_behind and _clear_behind(snapshot, points) > BACK_CLEAR + BACK_WAY


def no_news(age: float) -> Move:
    """To stand, because what is known is `age` [s] old."""
    return Move(0.0, 0.0, "stopped: no news from the robot for %.1f s" % age)


def _look(snapshot: Snapshot, memory: Memory) -> Tuple[View, Memory]:
    robot, outline, ranges = snapshot.robot, snapshot.robot.outline, snapshot.ranges
    pose, before = snapshot.pose, memory.pose or snapshot.pose
    passed = max(snapshot.time - memory.time, 1e-3)
    turned = abs(_difference(pose.heading, before.heading))
    echoes, points = remember(memory.echoes, snapshot, turned > STEADY * passed)
    farthest = max(robot.front, key=lambda each: ranges[each.number] + TIE * (each.number in robot.middle))
    ahead = outline.straight(points, (NARROW if memory.room is Room.TO_SQUEEZE else WIDE).side, FARTHEST)
    circle = outline.circle_straight(points, CIRCLE_MARGIN, FARTHEST)
    view = View(
        snapshot, points, farthest, sees=ranges[farthest.number], middle=max(ranges[number] for number in robot.middle),
        ahead=ahead, circle=circle, way=min(ahead, circle) if memory.room is Room.TO_TURN_ROUND else ahead,
        rolling=math.hypot(pose.x - before.x, pose.y - before.y) > ROLLING * passed)
    return view, replace(memory, pose=pose, time=snapshot.time, echoes=echoes, turned=memory.turned + turned)


def _open(view: View, memory: Memory) -> bool:
    """The tutorial's forward rule: the farthest sonar is a middle one and sees OPEN, and the robot fits."""
    return (
        view.farthest.number in view.snapshot.robot.middle and view.sees >= OPEN
        and view.way >= _stop_distance(memory.speed) + TO_SPARE and not _is_avoided(view, memory))


def _goes_on(view: View, memory: Memory) -> bool:
    """The robot still fits, and its middle sonars do not see the end of the way yet."""
    return (
        view.ahead > _stop_distance(memory.speed) and view.way > _braking(memory.speed)
        and view.middle >= memory.short)


def _drive(view: View, memory: Memory) -> Tuple[Move, Memory]:
    """Forward, slower where the way gets short, and a little away from what is near at one side."""
    linear = memory.speed * min(1.0, max(SLOWEST, (view.ahead - _stop_distance(memory.speed)) / SLOW))
    memory = replace(
        memory, going=Going.DRIVING, best=None, goal=None, backed=False, avoided=None,
        room=Room.TO_TURN_ROUND if view.circle > _braking(memory.speed) else memory.room)
    return Move(linear, _steer(view), "driving: %.1f m clear ahead" % min(view.ahead, view.middle)), memory


def _steer(view: View) -> float:
    """How fast to turn while driving [rad/s]: towards the side on which there is more room."""
    reach = view.snapshot.robot.outline.reach
    beside = [y for x, y in view.points if -0.1 < x < reach + STEER_AHEAD]
    left = min([reach + ELBOW_ROOM, *(y for y in beside if y > 0)])
    right = min([reach + ELBOW_ROOM, *(-y for y in beside if y <= 0)])
    angular = max(-STEER_LIMIT, min(STEER_LIMIT, STEER_GAIN * (left - right)))
    if not view.snapshot.robot.sees_ahead:
        angular += WEAVE_RATE * math.cos(2 * math.pi * view.snapshot.time / WEAVE_PERIOD)
    return angular if _can_turn(view, WIDE, 1 if angular > 0 else -1) else 0.0


def _begin_turn(view: View, memory: Memory) -> Memory:
    """Turn towards the sonar that sees farthest.

    Chance chooses the side if no sonar sees OPEN, or if the way ahead is too narrow.
    """
    chance = random.Random(memory.seed)
    side = chance.choice((1, -1))
    if _is_avoided(view, memory):
        why = "turning {side}: away from what stands ahead"
    elif view.sees < OPEN:
        why = "turning back, {side}: no sonar ahead sees %g m" % OPEN
    elif view.farthest.number in view.snapshot.robot.middle:
        why = "turning {side}: the way ahead is too narrow"
    else:
        side = 1 if view.farthest.heading > 0 else -1
        why = "turning {side}: sonar %d sees %.1f m" % (view.farthest.number, view.sees)
    return replace(
        memory, going=Going.TURNING, side=side, why=why, turned=0.0, enough=2 * math.pi * chance.uniform(1.0, 1.5),
        blocked=0, best=None, goal=None, seed=chance.getrandbits(32))


def _turn(view: View, memory: Memory) -> Tuple[Move, Memory]:
    """Keep to the side of the turn. After enough of it, or with both sides blocked, go the best way that was seen."""
    if view.rolling:
        return Move(0.0, 0.0, "halting: to turn"), memory
    clear, best = 0.0 if _is_avoided(view, memory) else min(view.way, view.middle), memory.best
    if best is None or clear > best.clear:
        best = Way(clear, view.snapshot.pose.heading)
    memory = replace(memory, best=best)
    if memory.goal is None and (memory.turned > memory.enough or memory.blocked > 1):
        memory = replace(
            memory, goal=best, why="turning {side}: back to the best way seen, %.1f m" % best.clear, blocked=0)
    if memory.goal is not None:
        off = _difference(memory.goal.heading, view.snapshot.pose.heading)
        if abs(off) < AT_HEADING:
            return _take_best_way(view, memory)
        if not memory.blocked:
            memory = replace(memory, side=1 if off > 0 else -1)
    for _ in range(2):
        for margin in (WIDE, NARROW) if memory.room is Room.TO_SQUEEZE else (WIDE,):
            if _can_turn(view, margin, memory.side):
                reason = memory.why.format(side="left" if memory.side > 0 else "right")
                return Move(0.0, memory.side * margin.rate, reason), memory
        memory = replace(memory, side=-memory.side, blocked=memory.blocked + 1)
    return _take_best_way(view, memory)


def _take_best_way(view: View, memory: Memory) -> Tuple[Move, Memory]:
    """Drive, back off, or demand less room: the robot looks along the best way that it knows, or cannot turn to it."""
    if view.ahead > _stop_distance(memory.speed) + 0.05 and not _is_avoided(view, memory):
        return _drive(view, replace(
            memory, short=min(SHORT, view.middle / 2),
            room=Room.TO_PASS if memory.room is Room.TO_TURN_ROUND else memory.room))
    if _can_back_off(view, memory):
        return _begin_to_back_off(view, memory)
    memory = replace(memory, going=Going.LOOKING, backed=False)
    not_heard = [each.number for each in view.snapshot.robot.transducers if not view.snapshot.ranges[each.number]]
    if not_heard:
        return Move(0.0, 0.0, "waiting: sonar %d is not heard" % not_heard[0]), memory
    memory = replace(memory, room=Room.TO_TURN_ROUND if memory.room is Room.TO_SQUEEZE else Room.TO_SQUEEZE)
    return Move(0.0, 0.0, "waiting: no way out seen yet"), memory


def _clear_behind(snapshot: Snapshot, points: List[Point]) -> float:
    """How far the way behind is clear [m], at most 1, if sonars look there."""
    return snapshot.robot.outline.straight(points, WIDE.side, 1.0, -1)


def _can_back_off(view: View, memory: Memory) -> bool:
    return (
        view.snapshot.robot.sees_behind and not memory.backed
        and _clear_behind(view.snapshot, view.points) > BACK_CLEAR)


def _begin_to_back_off(view: View, memory: Memory) -> Tuple[Move, Memory]:
    return _back_off(view, replace(memory, going=Going.BACKING, since=view.snapshot.time, backed=True))


def _back_off(view: View, memory: Memory) -> Tuple[Move, Memory]:
    """Straight back, while sonars look there and see that it is clear."""
    speed, behind = BACK_SPEED * memory.speed, _clear_behind(view.snapshot, view.points)
    if behind > BACK_CLEAR - 0.05 and view.snapshot.time - memory.since < BACK_WAY / speed:
        return Move(-speed, 0.0, "backing off: %.1f m clear behind" % behind), memory
    return Move(0.0, 0.0, "halting: to look again"), replace(memory, going=Going.LOOKING)


def _stand_while_held(view: View, memory: Memory) -> Tuple[Move, Memory]:
    """Stand until the wheels have been free for a while, then leave what held them: no sonar sees it."""
    now = view.snapshot.time
    if view.snapshot.stalled or memory.going is not Going.HELD:
        memory = replace(
            memory, going=Going.HELD, since=now, backed=memory.backed or memory.going is Going.BACKING)
    if now - memory.since < FREE_FOR:
        return Move(0.0, 0.0, "stopped: the wheels stall, something holds the robot"), memory
    memory = replace(memory, avoided=view.snapshot.pose.heading)
    if _can_back_off(view, memory):
        return _begin_to_back_off(view, memory)
    return Move(0.0, 0.0, "halting: to look for another way"), replace(memory, going=Going.LOOKING)


def _leave(view: View, memory: Memory) -> Tuple[Move, Memory]:
    """Back away from what stands between the paddles. A robot that turned at once would take it along."""
    if not _can_back_off(view, memory):
        return Move(0.0, 0.0, "waiting: for room behind, to leave what was put down"), memory
    return _begin_to_back_off(view, replace(memory, avoided=view.snapshot.pose.heading))


def _is_avoided(view: View, memory: Memory) -> bool:
    """Does the robot look towards what it leaves?"""
    return memory.avoided is not None and abs(_difference(view.snapshot.pose.heading, memory.avoided)) < AVOIDED


def _can_turn(view: View, margin: Margin, side: int) -> bool:
    """Is the turn free, as far as the robot turns before it could stop?"""
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
