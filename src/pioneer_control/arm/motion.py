"""Checks a motion through several positions, and turns it into ticks and speeds of servos (arm sheet 15, 19).

A motion is as a trajectory_msgs/JointTrajectory has it: names of joints, and points, each with a position of every
named joint and the time at which it is to be reached. Joints that are not named stay where they are.
"""

import math
from typing import Dict, List, Mapping, NamedTuple, Sequence, Tuple

from ..errors import UsageError
from .joints import SLOWEST_MS, TICK_LINE_MS, Joint

MOST_POINTS = 1000
"""Largest number of points of a motion."""


class Point(NamedTuple):
    """One point of a motion."""

    positions: Sequence[float]
    """Value of each named joint (rad; m of the gripper)."""
    time: float
    """When it is to be reached (s since the motion began)."""


class Segment(NamedTuple):
    """What is sent to the servos for one point."""

    ends: float
    """Time (s since the motion began) at which the segment ends, if the servos are fast enough."""
    lasts: float
    """How long (s) the servos need for it."""
    speeds: Mapping[int, int]
    """Speed (ms per tick) of each servo that moves, by its number."""
    goals: Mapping[int, int]
    """Position (ticks) of each named servo, by its number."""


def plan(joints: Mapping[str, Joint], ticks: Sequence[int], names: Sequence[str], points: Sequence[Point],
         largest_step: float) -> Tuple[Segment, ...]:
    """Return the segments of a motion.

    A joint that cannot be as fast as the times want is as fast as its limit lets it, and arrives later.

    Args:
        joints: the joints of the arm, by name.
        ticks: the present position of each servo.
        names: names of the joints that move.
        points: the points, at least one.
        largest_step: farthest that a joint may move from one point to the next (rad). The gripper has no such limit.

    Raises:
        UsageError: a name is unknown or there twice, a number is missing, not finite or beyond a limit, or the times do
            not rise. The message names it.
    """
    moved = _named(joints, names)
    if not 1 <= len(points) <= MOST_POINTS:
        raise UsageError("%d points are given, and a motion has 1 to %d" % (len(points), MOST_POINTS))
    segments: List[Segment] = []
    before, now = {joint.number: ticks[joint.number - 1] for joint in moved}, 0.0
    for index, point in enumerate(points):
        _check_times(index, point.time, now)
        _check_positions(index, moved, point.positions)
        goals = {joint.number: joint.tick(value) for joint, value in zip(moved, point.positions)}
        for joint in moved:
            step = abs(goals[joint.number] - before[joint.number]) * abs(joint.unit)
            if not joint.is_gripper and step > largest_step:
                raise UsageError(
                    "point %d moves %s by %.2f rad, and one step is at most %.2f rad (parameter arm_max_step): give"
                    " points between" % (index, joint.name, step, largest_step))
        segments.append(_segment(moved, before, goals, now, point.time))
        before, now = goals, point.time
    return tuple(segments)


def _named(joints: Mapping[str, Joint], names: Sequence[str]) -> List[Joint]:
    for index, name in enumerate(names):
        if name not in joints:
            raise UsageError("there is no joint %r; there are %s" % (name, ", ".join(joints)))
        if name in names[:index]:
            raise UsageError("%s is there twice" % name)
    if not names:
        raise UsageError("no joint is named; there are %s" % ", ".join(joints))
    return [joints[name] for name in names]


def _check_times(index: int, time: float, before: float) -> None:
    if not math.isfinite(time) or time < 0.0:
        raise UsageError("time_from_start of point %d is %s s: give a time from 0 up" % (index, time))
    if index and time <= before:
        raise UsageError("time_from_start of point %d is %g s, not after that of the point before" % (index, time))


def _check_positions(index: int, moved: Sequence[Joint], positions: Sequence[float]) -> None:
    if len(positions) != len(moved):
        raise UsageError("point %d has %d positions for %d joints" % (index, len(positions), len(moved)))
    for joint, value in zip(moved, positions):
        if not math.isfinite(value):
            raise UsageError("%s of point %d is %s, and a position must be finite" % (joint.name, index, value))
        if not joint.allows(value):
            raise UsageError("%s of point %d is %.3f, and may be %.3f to %.3f %s"
                             % (joint.name, index, value, joint.lower, joint.upper, joint.unit_name))


def _segment(moved: Sequence[Joint], before: Mapping[int, int], goals: Mapping[int, int], begins: float,
             ends: float) -> Segment:
    steps: Dict[Joint, int] = {joint: abs(goals[joint.number] - before[joint.number]) for joint in moved}
    moving = {joint: step for joint, step in steps.items() if step}
    speeds = {}
    for joint, step in moving.items():
        fastest = max(joint.fastest_ms, TICK_LINE_MS * len(moving))
        speeds[joint.number] = max(fastest, min(SLOWEST_MS, int(1000.0 * (ends - begins) / step)))
    lasts = max((step * speeds[joint.number] / 1000.0 for joint, step in moving.items()), default=0.0)
    return Segment(ends, lasts, speeds, goals)
