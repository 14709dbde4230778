"""The rule of the wander, as the pure function `wander`: from a snapshot and a memory it makes a move and a new memory.

The basic rule is that of the ROS wiki tutorial. It looks at the front sonar with the longest range. If this is one of
the two in the middle, the robot drives. If it is another one, the robot turns towards it. If no range is OPEN or
longer, the robot turns back. We have added these rules, so that the robot is safe and does not get stuck:

- When ranges are about equal, a middle sonar wins. Otherwise the robot would turn for ever in an open space.
- The robot drives only as far as its outline fits between the echoes. It starts only where there is some room to spare.
- Once it drives, it goes on until the way gets short. Once it turns, it keeps turning to the same side.
- When it has turned for long enough and found no open direction, it takes the best way that it saw.
- It remembers near echoes for a while (`echoes`), because there are gaps between the sonar cones.
- It drives back only when sonars look behind it and see free space.
- When its wheels stall, it stops until they have been free for a while. Then it backs off and goes another way, because
  the obstacle is where no sonar sees it. When they stall in a turn, it does not turn into the obstacle again.
- It leaves an object that it has put down in the same way: it backs off and goes another way.

This file does not use ROS, threads or clocks. Random choices come from the seed in the memory.
"""

import math
import random
from dataclasses import dataclass, replace
from enum import Enum
from typing import List, NamedTuple, Optional, Tuple

from ..floor_poses import Pose
from ..robots import Transducer
from .clearance import Point
from .echoes import Echo, Motion, remember
from .snapshot import Snapshot

SPEED = 0.1  #: m/s, default speed, as in the tutorial
TURN_RATE = 0.4  #: rad/s, speed of turns on the spot
STALE = 0.5  #: s; with older data the robot stops

FARTHEST = 5.0  #: m, the longest range of a sonar
OPEN = 2.0  #: m; a direction is open when its sonar range is at least this
TIE = 0.3  #: m; a middle sonar wins over another sonar when its range is shorter by at most this
SHORT = 1.0  #: m; the robot drives on until the ranges of its middle sonars are shorter than this

DELAY = 0.5  #: s from an echo to the wheels: one round of the sonars, one packet, and the command
DECELERATION = 0.3  #: m/s^2, used by the robot to stop
ANGULAR_DECELERATION = 1.7  #: rad/s^2, used by the robot to stop a turn
IN_FRONT = 0.12  #: m, free space to keep ahead of the outline when the robot has stopped
TO_SPARE = 0.30  #: m; to start driving, the way must be longer than the stop distance by this
SLOW = 0.30  #: m; the robot drives slower when the way is longer than the stop distance by less than this
SLOWEST = 0.3  #: the lowest speed, as a fraction of the speed

ELBOW_ROOM = 0.12  #: m; the robot steers away from echoes that are nearer to its turning circle than this
STEER_AHEAD = 0.35  #: m; it looks for these echoes this far ahead of the turning circle
STEER_GAIN = 6.0  #: rad per metre of way, per metre of difference between the sides
STEER_LIMIT = 1.2  #: rad per metre of way, the sharpest curve of this steering
WEAVE_RATE = 0.2  #: rad/s; a robot with a gap between its cones straight ahead weaves, so that the cones sweep the gap
WEAVE_PERIOD = 4.0  #: s

BACK_SPEED = 0.7  #: speed of backing off, as a fraction of the speed
BACK_WAY = 0.21  #: m, the longest distance to back off
BACK_CLEAR = 0.20  #: m, free space behind that is needed to start backing off; to go on, 0.05 m less is enough
FREE_FOR = 1.0  #: s; after a stall the wheels must be free for this time before the robot moves again
AVOIDED = 1.2  #: rad; it does not drive in directions that differ from the avoided heading by less than this

TOUCH_REMEMBERED = 300.0  #: s, the time after which a touch is forgotten
TOUCH_NEAR = 0.3  #: m; a touch is forgotten when the robot is farther than this from where it stood
TOUCH_MARGIN = 0.1  #: rad; it ends a turn this much before the heading at which its body touched
TOUCH_PASSED = 0.6  #: rad; it does not turn on when it is past that heading by up to this much

CIRCLE_MARGIN = 0.05  #: m, free space around the turning circle that a way needs when the robot must be able to turn
STEADY = 0.15  #: rad/s; the robot counts as turning when it turns faster
ROLLING = 0.03  #: m/s; the robot counts as rolling (not at rest yet) when it moves faster
STANDING, STANDING_TURN = 0.01, 0.02  #: m/s, rad/s; the robot counts as standing when it is slower than both
AT_HEADING = 0.1  #: rad; the robot has reached a heading when it differs by less than this


class Move(NamedTuple):
    """A decision: the velocity until the next decision, and the reason."""

    linear: float  #: m/s, forward positive
    angular: float  #: rad/s, left positive
    reason: str  #: a text for people: what the robot does, then a colon, then why


class Margin(NamedTuple):
    """The distance to keep between the outline of the robot and echoes, and the turn rate to use with this distance."""

    side: float  #: m, distance to keep on both sides while driving
    turn: float  #: m, distance to keep while turning
    rate: float  #: rad/s, turn rate


WIDE = Margin(side=0.08, turn=0.03, rate=TURN_RATE)
NARROW = Margin(side=0.04, turn=0.01, rate=TURN_RATE / 2)


Room = Enum("Room", ["TO_TURN_ROUND", "TO_PASS", "TO_SQUEEZE"])
"""How much room a way must have. The robot accepts a way with less room only when it finds no way with more room.

TO_TURN_ROUND: room for a full turn on the spot. TO_PASS: room for the outline with the margin WIDE. TO_SQUEEZE: room
for the outline with the margin NARROW.
"""

Going = Enum("Going", {
    "LOOKING": "looking",
    "DRIVING": "driving",
    "TURNING": "turning",
    "BACKING": "backing off",
    "HELD": "held: the wheels stall",
    "LEAVING": "leaving what it has put down",
})
"""The states of the wander. The value is a text for people."""


class Touch(NamedTuple):
    """A turn on the spot that stalled the wheels: the body touched something beside it that no sonar sees."""

    pose: Pose  #: by odometry, when the wheels stalled
    side: int  #: side of the turn: 1 left, -1 right
    time: float  #: s, when the wheels stalled


class Way(NamedTuple):
    """A direction that the robot saw during a turn: its free distance [m] and its heading [rad, odom frame]."""

    clear: float
    heading: float


@dataclass(frozen=True)
class Memory:
    """The state that one decision passes to the next.

    A new wander begins with ``Memory(seed, speed)``. After an object was put down, it begins with ``Memory(seed, speed,
    going=Going.LEAVING)``, so that the robot backs away from the object.
    """

    seed: int = 0
    speed: float = SPEED  #: m/s
    going: Going = Going.LOOKING
    since: float = 0.0  #: s, when backing off began (state BACKING), or when the wheels last stalled (state HELD)
    short: float = SHORT  #: m; drive on until the ranges of the middle sonars are shorter than this
    side: int = 1  #: side of the turn: 1 left, -1 right
    avoided: Optional[float] = None  #: rad, odom frame: the heading to the object that it leaves, until it drives again
    why: str = "turning {side}: to look round"  #: the reason of the turn, for people
    turned: float = 0.0  #: rad turned since the turn began
    enough: float = 2 * math.pi  #: rad; after this turn the robot stops looking for an open direction
    blocked: int = 0  #: how often an obstacle has blocked this turn
    best: Optional[Way] = None  #: the best way seen during this turn
    goal: Optional[Way] = None  #: the best way, when the robot has decided to turn back to it
    backed: bool = False  #: whether it has backed off since it last drove
    room: Room = Room.TO_TURN_ROUND  #: the room that a way must have now
    pose: Optional[Pose] = None  #: the pose in the last snapshot
    time: float = 0.0  #: s, the time of the last snapshot
    echoes: Tuple[Echo, ...] = ()  #: the remembered echoes
    touches: Tuple[Touch, ...] = ()  #: the remembered touches


class View(NamedTuple):
    """A snapshot with the values that the rule computes from it."""

    snapshot: Snapshot
    points: List[Point]  #: m, robot's frame: all known obstacle points
    farthest: Transducer  #: the front transducer with the longest range (TIE favours the middle)
    sees: float  #: m, the range of `farthest`
    middle: float  #: m, the longest range of the middle transducers
    ahead: float  #: m, how far the outline can move straight ahead
    circle: float  #: m, how far the robot can move straight ahead and still turn on the spot there
    way: float  #: m, how far it can move with the room that `Memory.room` demands
    rolling: bool  #: whether it still moves (see ROLLING)
    touches: Tuple[Touch, ...]  #: where turns ended at something that no sonar sees


def wander(snapshot: Snapshot, memory: Memory) -> Tuple[Move, Memory]:
    """Make one decision of the wander.

    Args:
        snapshot: the sensor data to decide on.
        memory: the memory that the decision before returned.

    Returns:
        The move to make now, and the memory for the next decision.
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
    """Return whether the sonars look behind the robot and show enough space to back away from an object put down."""
    _, points = remember((), snapshot, Motion.STANDS, 0.0)
    return snapshot.robot.sees_behind and _clear_behind(snapshot, points) > BACK_CLEAR + BACK_WAY


def no_news(age: float) -> Move:
    """Return the move for data that are too old, `age` [s]: the robot stops."""
    return Move(0.0, 0.0, "stopped: no news from the robot for %.1f s" % age)


def _look(snapshot: Snapshot, memory: Memory) -> Tuple[View, Memory]:
    """Compute the view of a snapshot, and update the pose, time, echoes and turned angle in the memory."""
    robot, outline, ranges = snapshot.robot, snapshot.robot.outline, snapshot.ranges
    pose, before = snapshot.pose, memory.pose or snapshot.pose
    passed = max(snapshot.time - memory.time, 1e-3)
    turned = abs(_difference(pose.heading, before.heading))
    moved = _distance(pose, before)
    stands = moved < STANDING * passed and turned < STANDING_TURN * passed
    motion = Motion.STANDS if stands else Motion.TURNS if turned > STEADY * passed else Motion.DRIVES
    echoes, points = remember(memory.echoes, snapshot, motion, passed)
    farthest = max(robot.front, key=lambda each: ranges[each.number] + TIE * (each.number in robot.middle))
    touches = tuple(each for each in memory.touches if _is_remembered(each, snapshot))
    ahead = outline.straight(points, (NARROW if memory.room is Room.TO_SQUEEZE else WIDE).side, FARTHEST)
    circle = outline.circle_straight(points, CIRCLE_MARGIN, FARTHEST)
    view = View(
        snapshot, points, farthest, sees=ranges[farthest.number], middle=max(ranges[number] for number in robot.middle),
        ahead=ahead, circle=circle, way=min(ahead, circle) if memory.room is Room.TO_TURN_ROUND else ahead,
        rolling=moved > ROLLING * passed, touches=touches)
    return view, replace(
        memory, pose=pose, time=snapshot.time, echoes=echoes, touches=touches, turned=memory.turned + turned)


def _is_remembered(touch: Touch, snapshot: Snapshot) -> bool:
    """Return whether a touch is neither too long ago nor too far away."""
    return snapshot.time - touch.time < TOUCH_REMEMBERED and _distance(touch.pose, snapshot.pose) < TOUCH_NEAR


def _open(view: View, memory: Memory) -> bool:
    """Return whether the way ahead is open, so that the robot starts to drive.

    As in the tutorial, the front sonar with the longest range must be a middle one, and the range at least OPEN. In
    addition, there must be enough room for the robot, and the direction must not be avoided.
    """
    return (
        view.farthest.number in view.snapshot.robot.middle and view.sees >= OPEN
        and view.way >= _stop_distance(memory.speed) + TO_SPARE and not _is_avoided(view, memory))


def _goes_on(view: View, memory: Memory) -> bool:
    """Return whether a driving robot drives on: it still fits, and the ranges of the middle sonars are long enough."""
    return (
        view.ahead > _stop_distance(memory.speed) and view.way > _braking(memory.speed)
        and view.middle >= memory.short)


def _drive(view: View, memory: Memory) -> Tuple[Move, Memory]:
    """Drive forward. Return the move and the new memory.

    The robot drives slower when the way gets short, and steers away from near echoes on one side.
    """
    linear = memory.speed * min(1.0, max(SLOWEST, (view.ahead - _stop_distance(memory.speed)) / SLOW))
    memory = replace(
        memory, going=Going.DRIVING, best=None, goal=None, backed=False, avoided=None,
        room=Room.TO_TURN_ROUND if view.circle > _braking(memory.speed) else memory.room)
    reason = "driving: %.1f m clear ahead" % min(view.ahead, view.middle)
    return Move(linear, _steer(view, memory.speed), reason), memory


def _steer(view: View, speed: float) -> float:
    """Return the turn rate while driving [rad/s, left positive], towards the side with more room.

    The turn rate is 0 when there is no room to turn. A robot whose sonars leave a gap straight ahead also weaves.
    """
    reach = view.snapshot.robot.outline.reach
    beside = [y for x, y in view.points if -0.1 < x < reach + STEER_AHEAD]
    left = min([reach + ELBOW_ROOM, *(y for y in beside if y > 0)])
    right = min([reach + ELBOW_ROOM, *(-y for y in beside if y <= 0)])
    angular = speed * max(-STEER_LIMIT, min(STEER_LIMIT, STEER_GAIN * (left - right)))
    if not view.snapshot.robot.sees_ahead:
        angular += WEAVE_RATE * math.cos(2 * math.pi * view.snapshot.time / WEAVE_PERIOD)
    return angular if _can_turn(view, WIDE, 1 if angular > 0 else -1) else 0.0


def _begin_turn(view: View, memory: Memory) -> Memory:
    """Begin a turn towards the front sonar with the longest range. Return the memory of the turn.

    The side is random if no range is OPEN or longer, if the way ahead is too narrow, or if it is to be avoided.
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
    """Continue a turn to the same side. Return the move and the new memory.

    After a turn of `memory.enough`, or when obstacles block both sides, the robot takes the best way that it saw.
    """
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
    """End a turn that found no open direction: drive, back off, or accept less room. Return move and new memory.

    The robot now points along the best way that it saw, or it cannot turn any more.
    """
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
    """Return how far the robot can drive back [m], at most 1. Valid only when sonars look behind it."""
    return snapshot.robot.outline.straight(points, WIDE.side, 1.0, -1)


def _can_back_off(view: View, memory: Memory) -> bool:
    """Return whether sonars show free space behind the robot, and it has not backed off since it last drove."""
    return (
        view.snapshot.robot.sees_behind and not memory.backed
        and _clear_behind(view.snapshot, view.points) > BACK_CLEAR)


def _begin_to_back_off(view: View, memory: Memory) -> Tuple[Move, Memory]:
    """Begin to drive back (state BACKING). Return the first move and the new memory."""
    return _back_off(view, replace(memory, going=Going.BACKING, since=view.snapshot.time, backed=True))


def _back_off(view: View, memory: Memory) -> Tuple[Move, Memory]:
    """Drive straight back. Return the move and the new memory.

    This ends when the robot has driven the distance BACK_WAY, or when there is too little free space behind it.
    """
    speed, behind = BACK_SPEED * memory.speed, _clear_behind(view.snapshot, view.points)
    if behind > BACK_CLEAR - 0.05 and view.snapshot.time - memory.since < BACK_WAY / speed:
        return Move(-speed, 0.0, "backing off: %.1f m clear behind" % behind), memory
    return Move(0.0, 0.0, "halting: to look again"), replace(memory, going=Going.LOOKING)


def _stand_while_held(view: View, memory: Memory) -> Tuple[Move, Memory]:
    """Wait until stalled wheels have been free for FREE_FOR seconds, then back off. Return move and new memory.

    The robot then avoids this direction, because no sonar sees the obstacle that held its wheels. When it was turning,
    the obstacle is beside it: it may drive in this direction, but does not turn farther.
    """
    now = view.snapshot.time
    if memory.going is Going.TURNING:
        memory = replace(memory, touches=memory.touches + (Touch(view.snapshot.pose, memory.side, now),))
    elif memory.going is not Going.HELD:
        memory = replace(memory, avoided=view.snapshot.pose.heading)
    if view.snapshot.stalled or memory.going is not Going.HELD:
        memory = replace(
            memory, going=Going.HELD, since=now, backed=memory.backed or memory.going is Going.BACKING)
    if now - memory.since < FREE_FOR:
        return Move(0.0, 0.0, "stopped: the wheels stall, something holds the robot"), memory
    if _can_back_off(view, memory):
        return _begin_to_back_off(view, memory)
    return Move(0.0, 0.0, "halting: to look for another way"), replace(memory, going=Going.LOOKING)


def _leave(view: View, memory: Memory) -> Tuple[Move, Memory]:
    """Back away from the object that was put down. Return the move and the new memory.

    The robot does not turn first, because the object is between its paddles and would move with them.
    """
    if not _can_back_off(view, memory):
        return Move(0.0, 0.0, "waiting: for room behind, to leave what was put down"), memory
    return _begin_to_back_off(view, replace(memory, avoided=view.snapshot.pose.heading))


def _is_avoided(view: View, memory: Memory) -> bool:
    """Return whether the robot points in the avoided direction: to an object put down, or to what held its wheels."""
    return memory.avoided is not None and abs(_difference(view.snapshot.pose.heading, memory.avoided)) < AVOIDED


def _can_turn(view: View, margin: Margin, side: int) -> bool:
    """Return whether the robot can turn to a side (1 left, -1 right) with a margin, and still stop in time."""
    needed = margin.rate * DELAY + margin.rate ** 2 / (2 * ANGULAR_DECELERATION)
    if any(touch.side == side and _would_touch(view.snapshot, touch, needed) for touch in view.touches):
        return False
    return view.snapshot.robot.outline.turn(view.points, side, margin.turn, needed) >= needed


def _would_touch(snapshot: Snapshot, touch: Touch, turn: float) -> bool:
    """Return whether a turn of `turn` [rad] to the side of a touch may touch the same thing again."""
    left = touch.side * _difference(touch.pose.heading, snapshot.pose.heading)
    # The farthest corner meets the thing earlier by this angle when the robot stands as far as this from the old place.
    earlier = _distance(touch.pose, snapshot.pose) / snapshot.robot.outline.reach
    return -TOUCH_PASSED < left < turn + TOUCH_MARGIN + earlier


def _distance(pose: Pose, other: Pose) -> float:
    """Return the distance between the positions of two poses [m]."""
    return math.hypot(pose.x - other.x, pose.y - other.y)


def _braking(speed: float) -> float:
    """Return the distance [m] that the robot needs to stop from `speed` [m/s], including the reaction time DELAY."""
    return speed * DELAY + speed ** 2 / (2 * DECELERATION)


def _stop_distance(speed: float) -> float:
    """Return the free distance ahead [m] that the robot needs at `speed` [m/s] to stop IN_FRONT before an obstacle."""
    return IN_FRONT + _braking(speed)


def _difference(heading: float, other: float) -> float:
    """Return the turn from `other` to `heading` [rad, -pi to pi], left positive."""
    return math.remainder(heading - other, 2 * math.pi)
