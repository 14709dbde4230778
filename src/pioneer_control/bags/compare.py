"""How far two tracks lie apart when both begin together, and other figures of a run. Pure.

"Together" is the same place, the same heading, and the same moment: that of the first movement, so that neither a
recorder that started early nor another corner of the room counts.
"""

from typing import List, NamedTuple, Tuple

import numpy as np

from .recorded_run import Run, Track, inverted, placed

MOVED = 0.01, np.radians(1.0)  # m, rad: a robot that is so far from its first pose has begun to move
STILL = 0.02, np.radians(2.0)  # m/s, rad/s: a robot that is slower stands
STOP = 0.5  # s: a robot that stands for longer has stopped
PUSHED = 0.05  # m by which a can has moved when it was pushed
AT_REST = 2.0  # s between two pushes, at least
HELD_WITHIN = 0.12  # m from the middle of the paddles: a can that the gripper holds


class Deviation(NamedTuple):
    """How far one track is from a reference, at the same times since each began to move.

    The robot whose track ends before the other's stands where it ended.
    """

    mean: float  # m, over time
    maximum: float  # m
    at_end: float  # m, from end to end
    turn_at_end: float  # rad, -pi to pi; positive: it ended turned further to the left than the reference


def deviation(reference: Track, other: Track) -> Deviation:
    """How far ``other`` is from ``reference``, however long each track is and wherever its frame lies."""
    time, apart = distance_between(reference, other)
    turn = (other.heading[-1] - other.heading[0]) - (reference.heading[-1] - reference.heading[0])
    summed = np.sum(np.diff(time) * (apart[1:] + apart[:-1]) / 2)   # over the time: straight between two moments
    mean = summed / (time[-1] - time[0]) if time[-1] > time[0] else apart.mean()
    return Deviation(float(mean), float(apart.max()), float(apart[-1]), float(np.angle(np.exp(1j * turn))))


def distance_between(reference: Track, other: Track) -> Tuple[np.ndarray, np.ndarray]:
    """Seconds since both began to move, and how far apart (m) they are then."""
    one, two = from_its_start(reference), from_its_start(other)
    # both go straight between these moments, so they are farthest apart at one of them
    moments: np.ndarray = np.unique(np.concatenate((np.zeros(1), one.time, two.time)))
    moments = moments[moments >= 0.0]
    one, two = one.at(moments), two.at(moments)
    return moments, np.hypot(two.x - one.x, two.y - one.y)


def from_its_start(track: Track) -> Track:
    """A track with its first pose as origin, and its first movement as time zero."""
    laid = track.seen_from(inverted(track.pose(0)))
    return laid._replace(time=laid.time - first_movement(track))


class Driven(NamedTuple):
    """A track in figures."""

    time: float  # s from the first movement to the last
    length: float  # m
    mean_speed: float  # m/s: the length divided by the time
    stops: int  # on the way, each of `STOP` s or longer


def driven(track: Track) -> Driven:
    """What a robot drove, in figures."""
    stands = standing(track)
    begin = stands[0][1] if stands and stands[0][0] <= track.time[0] else track.time[0]
    end = stands[-1][0] if stands and stands[-1][1] >= track.time[-1] else track.time[-1]
    time = max(float(end - begin), 0.0)
    on_the_way = sum(begin < since and until < end for since, until in stands)
    return Driven(time, track.length, track.length / time if time else 0.0, on_the_way)


def standing(track: Track) -> List[Tuple[float, float]]:
    """Spans of time (s) in which a robot stood, without those shorter than `STOP`."""
    passed = np.maximum(np.diff(track.time), 1e-9)
    moved, turned = np.hypot(np.diff(track.x), np.diff(track.y)), np.abs(np.diff(track.heading))
    still = (moved < STILL[0] * passed) & (turned < STILL[1] * passed)
    edges = np.flatnonzero(np.diff(np.concatenate(([False], still, [False]))))
    spans = [(float(track.time[begin]), float(track.time[end])) for begin, end in zip(edges[::2], edges[1::2])]
    return [(begin, end) for begin, end in spans if end - begin >= STOP]


def first_movement(track: Track) -> float:
    """When (s) a robot was `MOVED` from its first pose; the first moment of a robot that stays."""
    moved = np.maximum(np.hypot(track.x - track.x[0], track.y - track.y[0]) / MOVED[0],
                       np.abs(track.heading - track.heading[0]) / MOVED[1])
    if moved.max() < 1.0:
        return float(track.time[0])
    first = int(np.argmax(moved >= 1.0))
    return float(np.interp(1.0, moved[first - 1:first + 1], track.time[first - 1:first + 1]))


class Push(NamedTuple):
    """A can that was moved and not carried: its number (from 1), from when on (s), and how far (m)."""

    can: int
    time: float
    distance: float


def pushes(run: Run) -> Tuple[Push, ...]:
    """The pushes of all cans, in order of time. Only a simulated world tells where its cans are."""
    found = []
    for number, can in enumerate(run.cans, 1):
        moved = (np.hypot(np.diff(can.x), np.diff(can.y)) > 0.0) & (np.maximum(can.height[1:], can.height[:-1]) <= 0.0)
        steps = np.flatnonzero(moved & ~_in_gripper(run, can.time[1:], can.x[1:], can.y[1:]))
        for part in np.split(steps, np.flatnonzero(np.diff(can.time[steps]) > AT_REST) + 1):
            if len(part):
                begin, end = part[0], part[-1] + 1
                distance = float(np.hypot(can.x[end] - can.x[begin], can.y[end] - can.y[begin]))
                found += [Push(number, float(can.time[begin]), distance)] * (distance >= PUSHED)
    return tuple(sorted(found, key=lambda push: push.time))


def _in_gripper(run: Run, time: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Whether a can that is at these places at these times is held."""
    if run.truth is None or not run.gripper:
        return np.zeros(len(time), dtype=bool)
    holding = np.array([False] + [event.what == "picked up" for event in run.gripper])
    robot = run.truth.at(time)
    grip_x, grip_y = placed((robot.x, robot.y, robot.heading), run.grip, 0.0)
    after = np.searchsorted([event.time for event in run.gripper], time, side="right")
    return holding[after] & (np.hypot(x - grip_x, y - grip_y) < HELD_WITHIN)
