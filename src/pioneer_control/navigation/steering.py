"""Chooses the next velocity: the move that brings the robot nearest to its goal, among those it can still stop on.

Each candidate is an arc or a turn on the spot at one speed. It is allowed if some transducer looks along it, and if the
way until the robot's outline touches something is longer than reaction and brakes need; longer still towards an echo
that is young, because somebody may come. Near what may walk it is so slow that it stands before that can be there. The
same holds near what is on no map and has stood still, for it may set off; but at the speed `passing` the robot may go
by. Among the allowed ones, the cost to go from where each leads decides.
"""

import math
from typing import Any, Iterable, NamedTuple, Optional, Tuple

import numpy as np

from ..floor_poses import Pose, compose, wrapped
from .chassis import Chassis, Moves, after
from .frames import into, wrapped_angles
from .planning import RoutePlan, Slowness
from .swept_outlines import SweptOutlines
from .tuned import SteeringNumbers
from .values import STOP, Twist

Array = Any     # of numpy

_SHARES = (0.15, 0.35, 0.6, 0.8, 1.0)   # of the greatest speed forward
_SHARES_BACK = (0.4, 1.0)
_SHARES_TURN = (0.11, 0.3, 0.75, 1.0)   # of the greatest turn rate
_STEP = 0.1     # s
_ROLLS = 0.1            # m/s: a faster robot needs some way until it stands
_BARE = 0.01                            # m: distance that slow moves keep where there is no other way
_SLOW = 0.1, 0.5                        # m/s, rad/s: the fastest of them
_STANDS = 0.03, 0.05    # m/s, rad/s: a slower robot stands
_HALF = 0.05            # s: half the time from one packet to the next
_AHEAD = (0.08, 0.16, 0.24)             # m, rad: poses of a move that are compared with where the robot was
_SAME = 0.03, 0.06                      # m, rad: so near to such a pose it was there
NOWHERE = np.zeros((0, 3))
NOBODY = np.array([math.inf])
"""The distances of all candidates to places that there are not."""


class Around(NamedTuple):
    """What is around the robot (m, robot's frame).

    Attributes:
        standing_x, standing_y: all that is there: each echo that is remembered, and the walls of the map.
        walking_x, walking_y: of these, echoes of the last moments that no wall of the map explains: it may walk.
        apart: distances to the nearest place on no map that has not yet proved to stand still, see `Steering.apart`.
        beside: the same to the nearest place on no map that was heard in the last moments, also one that stands still.
        lost: the same to the nearest place on no map that had not proved to stand still when it was last heard, some
            seconds ago: who was there may be where no transducer looks, at the side and behind.
        late: how much later than usual the robot may react (s).
    """

    standing_x: Array
    standing_y: Array
    walking_x: Array
    walking_y: Array
    apart: Array = NOBODY
    beside: Array = NOBODY
    lost: Array = NOBODY
    late: float = 0.0


class SteeringChoice(NamedTuple):
    """A velocity, and why, for people. `blocked`: the robot stands, for no move was allowed or worth its cost."""

    twist: Twist
    reason: str
    blocked: bool = False


def slowness(tuned: SteeringNumbers, max_linear: float) -> Slowness:
    """Return how slow a robot of this greatest speed (m/s) is beside what has stood still: that may begin to walk.

    It is so slow that it stands before that could reach it; but at `passing` or less it goes by in any case.
    """
    slowest = min(tuned.passing, max_linear)
    near, far = (tuned.walking * (tuned.reaction + speed / tuned.braking) for speed in (slowest, max_linear))
    return Slowness(near, far, max_linear / slowest - 1.0)


class Steering:
    """Chooses velocities for one robot."""

    def __init__(self, chassis: Chassis, tuned: SteeringNumbers, makes_map: bool = False):
        """Make the tables.

        Args:
            chassis: the robot.
            tuned: the tuned numbers.
            makes_map: the robot makes its map, which is wrong by some centimetres, and knows only what it has heard.
                So it does not turn on the spot with next to no distance from what stands there, though it may have no
                other way; and where it has little room on a side it is slow, for a leg of a table may be heard late.
                And with no way on for long it turns on to one side.
        """
        self._chassis, self._tuned, self._makes_map = chassis, tuned, makes_map
        self.moves = Moves(chassis, tuned.margin)
        self._bare, self._wide = Moves(chassis, _BARE), Moves(chassis, tuned.margin_walking)
        narrower = 1.0 - tuned.retrace_narrower / chassis.half_width
        self._narrow = Moves(chassis._replace(outline=tuple((x, y * narrower) for x, y in chassis.outline)), _BARE)
        self._poses = np.array([[after(move, way) for way in _AHEAD] for move in self.moves.each])
        self._number, self._linear, self._angular = self._candidates()
        self._floors, self._floor = self._covered_floors()

    def choose(self, pose: Pose, velocity: Twist, around: Around, live: Iterable[int], plan: RoutePlan,
               blocked: float = 0.0, told: Twist = STOP, trail: Array = NOWHERE) -> SteeringChoice:
        """Return the velocity that leads on along a plan.

        Args:
            pose: where the robot is (map frame).
            velocity: its present velocity.
            around: what is around it.
            live: numbers of the transducers that work.
            plan: the plan to its goal.
            blocked: for how long (s) no way has led on, or the robot has made no progress. The longer, the more it
                prefers any move to standing; at last it keeps next to no distance from what stands beside it, and is
                slow.
            told: the velocity that it was told last, so that it does not turn to and fro.
            trail: where it was lately (robot's frame), array (n, 3). When nothing else is left, it goes back there.
        """
        allowed = self._allowed(velocity, around, live)
        if blocked > self._tuned.squeeze_after:
            bare = self._allowed(velocity, around, live, (self._bare, self._wide))
            allowed |= bare & ((self._linear != 0.0) | (not self._makes_map))
            if not allowed[:-1].any():
                allowed = self._retraced(velocity, around, live, trail)
        cost = self._costs(pose, velocity, plan)
        # In a corner that is on no map yet it may turn to either side, and has no way on: then it turns on to one side,
        # until it sees one.
        often = self._tuned.turns_on if self._makes_map and blocked > self._tuned.dawdle_after else 1.0
        cost += often * self._tuned.reversal_weight * ((self._linear == 0.0) & (self._angular * told.angular < 0.0))
        cost[-1] += self._tuned.impatience * max(0.0, blocked - 1.0)
        # Slow moves to and fro lead nowhere; a faster one that costs more at first may.
        cost += min(self._tuned.most_dawdling, self._tuned.impatience * max(0.0, blocked - self._tuned.dawdle_after)
                    ) * np.maximum(0.0, 1.0 - np.abs(self._linear) / 0.2 - np.abs(self._angular) / 0.4)
        cost[~allowed] = np.inf
        best = int(np.argmin(cost))
        twist = Twist(float(self._linear[best]), float(self._angular[best]))
        if twist == STOP:
            return SteeringChoice(STOP, "the way is blocked", True)
        return SteeringChoice(twist, "on the way")

    def finish(self, pose: Pose, velocity: Twist, around: Around, live: Iterable[int], goal: Pose,
               turn_only: bool, answer: float) -> SteeringChoice:
        """Return the velocity that ends a way: straight to a goal near by, then to its heading.

        Args:
            pose, velocity, around, live: as for `choose`.
            goal: the goal (map frame).
            turn_only: the robot is at the goal, and only its heading is to change.
            answer: time (s) until it does what it is told now.
        """
        tuned = self._tuned
        along, aside = (float(each) for each in into(pose, np.array(goal.x), np.array(goal.y)))
        distance = math.hypot(along, aside)
        doing = "at the goal, turning to its heading" if turn_only else "finishing, straight to the goal"
        if turn_only:
            wanted = self._turn_by(wrapped(goal.heading - pose.heading), velocity, answer)
        else:
            back = along < 0.0 and distance < 0.25
            off = math.atan2(-aside, -along) if back else math.atan2(aside, along)
            if abs(off) > 0.5:
                wanted = self._turn_by(off, velocity, answer)
            else:
                top = tuned.backward if back else self._chassis.max_linear
                speed = min(top, math.sqrt(2.0 * 0.6 * tuned.braking * distance),
                            max(0.04, tuned.final_gain * distance))
                speed *= max(0.2, math.cos(2.0 * off))
                bend = 2.0 * math.sin(off) / max(distance, 0.1)
                wanted = Twist(-speed if back else speed, float(_within(speed * bend, self._chassis.max_angular)))
        return self._held_back(wanted, velocity, around, live, doing)

    def apart(self, x: Array, y: Array, which: Array) -> Array:
        """Return for each candidate the distance (m) to the nearest of some places, infinite without one.

        A candidate that goes forward counts it from all the floor that the robot covers until it stands, for somebody
        may walk to there. All others count it from the outline; the last of them stands.

        Args:
            x, y: the places (m, robot's frame).
            which: which of them count (bool).
        """
        return self._floors.nearest(x[which], y[which])[self._floor]

    def may_turn(self, rate: float, velocity: Twist, around: Around) -> bool:
        """Return whether the slowest turn on the spot is allowed that is at least as fast as a rate (rad/s).

        For the arguments see `choose`.
        """
        allowed = self._allowed(velocity, around, ())
        turns = (self._linear == 0.0) & (self._angular * rate > 0.0) & (np.abs(self._angular) >= abs(rate) - 1e-6)
        return bool(allowed[turns & (np.abs(self._angular) == np.abs(self._angular[turns]).min(initial=9.0))].any())

    def stands_at(self, pose: Pose, velocity: Twist, told: Twist, answer: float) -> Pose:
        """Return where the robot stands (map frame) if it is told to stop now.

        Args:
            pose: where it is (map frame).
            velocity: its mean velocity since the packet before.
            told: what it was told at that packet. It is nearer to it by now.
            answer: time (s) until it does what it is told now.
        """
        tuned = self._tuned
        linear = velocity.linear + float(_within(told.linear - velocity.linear, tuned.braking * _HALF))
        angular = velocity.angular + float(_within(told.angular - velocity.angular, tuned.turn_acceleration * _HALF))
        return compose(pose, Pose(linear * answer + linear * abs(linear) / (2.0 * tuned.braking), 0.0,
                                  angular * answer + angular * abs(angular) / (2.0 * tuned.turn_acceleration)))

    def stands(self, velocity: Twist, told: Twist) -> bool:
        """Return whether the robot stands by now. It has braked since it was `told` to stop; see `stands_at`."""
        braked = Twist(self._tuned.braking * _HALF, self._tuned.turn_acceleration * _HALF) if told == STOP else STOP
        return (abs(velocity.linear) < _STANDS[0] + braked.linear
                and abs(velocity.angular) < _STANDS[1] + braked.angular)

    def _turn_by(self, angle: float, velocity: Twist, answer: float) -> Twist:
        """Return the turn by an angle (rad) that brakes in time. For the other arguments see `stands_at`."""
        tuned = self._tuned
        left = angle - velocity.angular * answer
        rate = min(self._chassis.max_angular, max(tuned.final_turn_slowest, min(
            tuned.final_turn_gain * abs(left),
            math.sqrt(2.0 * tuned.final_turn_braking * tuned.turn_acceleration * abs(left)))))
        return Twist(0.0, math.copysign(rate, left))

    def _held_back(self, wanted: Twist, velocity: Twist, around: Around, live: Iterable[int],
                   doing: str) -> SteeringChoice:
        """Return a wanted velocity if a candidate much like it is allowed; if not, the one most like it, or a stop."""
        allowed = self._allowed(velocity, around, live)
        if wanted.linear == 0.0 and velocity.linear > _ROLLS:   # it turns where it comes to stand, too
            way = velocity.linear * (1.0 + velocity.linear / (2.0 * self._tuned.braking * self._tuned.delay))
            allowed &= self._allowed(Twist(way, velocity.angular), around, live)
        unlike = np.abs(self._linear - wanted.linear) * 3.0 + np.abs(self._angular - wanted.angular)
        unlike[~allowed] = np.inf
        same = (np.sign(self._linear) == np.sign(wanted.linear)) & (
            (wanted.linear != 0.0) | (np.sign(self._angular) == np.sign(wanted.angular)))
        unlike[~same] = np.inf
        best = int(np.argmin(unlike))
        if not np.isfinite(unlike[best]):
            if velocity.linear > _ROLLS:
                return SteeringChoice(STOP, doing)
            return SteeringChoice(STOP, "something is in the way at the goal", True)
        # As wanted where a candidate is at least as fast, so that the end is driven smoothly.
        if wanted.linear == 0.0:
            as_wanted = (np.abs(self._angular[np.isfinite(unlike)]) >= abs(wanted.angular)).any()
        else:
            as_wanted = (abs(self._linear[best]) >= abs(wanted.linear) - 0.05
                         and abs(self._angular[best] - wanted.angular) < 0.3)
        if as_wanted:
            return SteeringChoice(wanted, doing)
        return SteeringChoice(Twist(float(self._linear[best]), float(self._angular[best])), doing)

    def _candidates(self) -> Tuple[Array, Array, Array]:
        """Return the move, the speed and the turn rate of each candidate. The last one stands (move -1)."""
        chassis, tuned, rows = self._chassis, self._tuned, []
        # With `passing` itself among them: else it would pass what stands more slowly than it may.
        forward = [*(share * chassis.max_linear for share in _SHARES), min(tuned.passing, chassis.max_linear)]
        backward = [share * min(tuned.backward, chassis.max_linear) for share in _SHARES_BACK]
        for number, move in enumerate(self.moves.each):
            if move.direction == 0:
                rows += [(number, 0.0, move.bend * share * chassis.max_angular) for share in _SHARES_TURN]
                continue
            fastest = math.inf if move.bend == 0.0 else chassis.max_angular / abs(move.bend)
            speeds = {round(min(speed, fastest), 4) for speed in (forward if move.direction > 0 else backward)}
            rows += [(number, move.direction * speed, move.bend * speed) for speed in sorted(speeds)]
        rows.append((-1, 0.0, 0.0))
        number, linear, angular = (np.array(column) for column in zip(*rows))
        return number, linear, angular

    def _covered_floors(self) -> Tuple[SweptOutlines, Array]:
        """Return the floors that candidates cover until the robot stands, and for each candidate the number of its own.

        The first floor is the outline: of the candidates that do not go forward.
        """
        tuned, moves = self._tuned, self.moves.each
        ways, number = [(moves[0], 0.0)], np.zeros(len(self._linear), dtype=int)
        for candidate in np.flatnonzero(self._linear > 0.0).tolist():
            speed = float(self._linear[candidate])
            number[candidate] = len(ways)
            ways.append((moves[self._number[candidate]], speed * tuned.reaction + speed ** 2 / (2.0 * tuned.braking)))
        return SweptOutlines(self._chassis.outline, ways), number

    def _retraced(self, velocity: Twist, around: Around, live: Iterable[int], trail: Array) -> Array:
        """Return which slow candidates lead over floor that the robot has just driven over; standing only if none does.

        Echoes scatter by some centimetres, so those of a wall that it nearly touches seem to be in its way. It did not
        touch it when it came. What is well inside of its way has come meanwhile, and ends it.
        """
        off = self._poses[:, :, np.newaxis] - trail
        turned = np.abs(wrapped_angles(off[..., 2]))
        was_there = (np.hypot(off[..., 0], off[..., 1]) < _SAME[0]) & (turned < _SAME[1])
        on_trail = was_there.any(axis=2).all(axis=1)[self._number]
        allowed = self._allowed(velocity, around, live, (self._narrow, self._narrow)) & on_trail
        allowed[-1] = not allowed[:-1].any()
        return allowed

    def _allowed(self, velocity: Twist, around: Around, live: Iterable[int],
                 slow: Optional[Tuple[Moves, Moves]] = None) -> Array:
        """Return which candidates are allowed. `slow`: only those up to `_SLOW`, by these tables of moves instead: one
        for what stands, one for what may walk.
        """
        tuned = self._tuned
        by_standing, by_walking = slow or (self.moves, self._wide)
        ahead = _moved_by(velocity, tuned.delay)
        standing = by_standing.ways(*into(ahead, around.standing_x, around.standing_y))
        walking = by_walking.ways(*into(ahead, around.walking_x, around.walking_y))
        turn = self.moves.direction[self._number] == 0
        speed = np.where(turn, np.abs(self._angular), np.abs(self._linear))
        braking = np.where(turn, tuned.turn_acceleration, tuned.braking)
        reaction = tuned.reaction + around.late
        needed = speed * reaction + speed ** 2 / (2.0 * braking) + tuned.spare
        coming = tuned.walking * (reaction + speed / braking)      # how far somebody walks until it stands
        meets = coming + np.maximum(self._linear, 0.0) * around.late    # the robot, too, comes farther when it is late
        allowed = ((standing[self._number] > needed) & (walking[self._number] > needed + np.where(turn, 0.0, coming))
                   & (meets < np.where(self._linear > 0.0, around.apart, np.minimum(around.apart, around.lost)))
                   & self.moves.covered(live)[self._number])
        # What has stood still may be somebody, who begins to walk.
        allowed &= (np.abs(self._linear) <= tuned.passing) | (meets < around.beside)
        if self._makes_map:
            room = self._wide.ways(*into(ahead, around.standing_x, around.standing_y))
            allowed &= (np.abs(self._linear) <= tuned.tight) | (room[self._number] > needed)
        if slow:
            allowed &= (np.abs(self._linear) <= _SLOW[0]) & (np.abs(self._angular) <= _SLOW[1])
        allowed[-1] = True
        return allowed

    def _costs(self, pose: Pose, velocity: Twist, plan: RoutePlan) -> Array:
        """Return what each candidate costs: the cost to go from where it leads, and what it passes."""
        tuned = self._tuned
        x, y, heading, passed = self._rolled_out(pose, velocity, plan)
        cost = plan.cost(x, y) + tuned.near_weight * passed
        off = np.abs(wrapped_angles(plan.heading(x, y) - heading))
        cost += tuned.heading_weight * off
        cost += tuned.change_weight * np.abs(self._angular - velocity.angular)
        cost[-1] += 0.02
        return cost

    def _rolled_out(self, pose: Pose, velocity: Twist, plan: RoutePlan) -> Tuple[Array, Array, Array, Array]:
        """Return where each candidate leads within the horizon: x, y, heading (map frame), and the cost of its floor
        above that of open floor.
        """
        tuned = self._tuned
        count = round(tuned.horizon / _STEP)
        # One row for each step: the velocity goes to the told one as fast as it can, once the command has an effect.
        time = np.maximum(0.0, _STEP * (np.arange(count) + 1 - round(tuned.delay / _STEP)))[:, np.newaxis]
        slower = np.abs(self._linear) < abs(velocity.linear)
        most = np.where(slower, tuned.braking, tuned.acceleration) * time
        linear = velocity.linear + _within(self._linear - velocity.linear, most)
        angular = velocity.angular + _within(self._angular - velocity.angular, tuned.turn_acceleration * time)
        heading = pose.heading + np.cumsum(angular, axis=0) * _STEP
        middle = heading - angular * (_STEP / 2.0)
        x = pose.x + np.cumsum(linear * np.cos(middle), axis=0) * _STEP
        y = pose.y + np.cumsum(linear * np.sin(middle), axis=0) * _STEP
        floor_cost = plan.floor.cost_of_a_metre(x[2::3], y[2::3]) - 1.0
        passed = (floor_cost * np.abs(linear[2::3])).sum(axis=0) * (3.0 * _STEP)
        return x[-1], y[-1], heading[-1], passed


def _within(values: Array, most: Array) -> Array:
    """Return values, cut off at `most` to both sides. (`np.clip` takes longer than the rest of a decision.)"""
    return np.minimum(np.maximum(values, -most), most)


def _moved_by(velocity: Twist, time: float) -> Pose:
    """Return where a robot is after some time (s) at a velocity, in its frame of now."""
    turn, way = velocity.angular * time, velocity.linear * time
    return Pose(way * math.cos(turn / 2.0), way * math.sin(turn / 2.0), turn)
