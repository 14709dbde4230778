"""Measure how far two tracks are apart, and other figures of a run. No file is read or written here.

Before two tracks are compared, the first pose of each track is moved to the origin, and the time of its first movement
is set to zero. So it does not matter when the recorder started and where in the room the robot started.
"""

from typing import List, NamedTuple, Tuple

import numpy as np

from .recorded_run import CanPath, Run, Track, inverted, placed

MOVED = 0.01, np.radians(1.0)  # m, rad: a robot this far from its first pose has begun to move
STILL = 0.02, np.radians(2.0)  # m/s, rad/s: a robot that is slower in both is standing
STOP = 0.5  # s: a robot that stands at least this long has stopped
PUSHED = 0.05  # m: a can that moved less was not pushed
AT_REST = 2.0  # s: a can that rests longer between two movements was pushed twice
HELD_WITHIN = 0.12  # m: a can that the gripper holds is nearer to the middle of the paddles


class Deviation(NamedTuple):
    """How far one track is from a reference track, at equal times since the first movement of each.

    A robot whose track ends earlier is taken to stand at its last pose until the other track ends.
    """

    mean: float  # m, mean distance over time
    maximum: float  # m, largest distance
    at_end: float  # m, distance between the two ends
    turn_at_end: float  # rad, -pi to pi; positive: the track turned further to the left than the reference


def deviation(reference: Track, other: Track) -> Deviation:
    """Compare the track `other` with the track `reference`. Their lengths, frames and start times may differ."""
    time, apart = distance_between(reference, other)
    turn = (other.heading[-1] - other.heading[0]) - (reference.heading[-1] - reference.heading[0])
    summed = np.sum(np.diff(time) * (apart[1:] + apart[:-1]) / 2)   # integral over time by the trapezoidal rule
    mean = summed / (time[-1] - time[0]) if time[-1] > time[0] else apart.mean()
    return Deviation(float(mean), float(apart.max()), float(apart[-1]), float(np.angle(np.exp(1j * turn))))


def distance_between(reference: Track, other: Track) -> Tuple[np.ndarray, np.ndarray]:
    """Compare two tracks that are both moved to the same start pose and start time.

    Returns:
        The times (s since the first movement of each track), and the distance (m) between the tracks at these times.
    """
    one, two = from_its_start(reference), from_its_start(other)
    # both robots go straight between these moments, so the largest distance is at one of the moments
    moments: np.ndarray = np.unique(np.concatenate((np.zeros(1), one.time, two.time)))
    moments = moments[moments >= 0.0]
    one, two = one.at(moments), two.at(moments)
    return moments, np.hypot(two.x - one.x, two.y - one.y)


def from_its_start(track: Track) -> Track:
    """Return a track in the frame of its own first pose, with time zero at its first movement."""
    laid = track.seen_from(inverted(track.pose(0)))
    return laid._replace(time=laid.time - first_movement(track))


class Driven(NamedTuple):
    """The duration, length, mean speed and number of stops of a track."""

    time: float  # s from the first movement to the last
    length: float  # m
    mean_speed: float  # m/s: the length divided by the time
    stops: int  # between the first and the last movement, each of `STOP` s or longer


def driven(track: Track) -> Driven:
    """Measure a track: its duration, length, mean speed and number of stops. Standing at both ends does not count."""
    stands = standing(track)
    begin = stands[0][1] if stands and stands[0][0] <= track.time[0] else track.time[0]
    end = stands[-1][0] if stands and stands[-1][1] >= track.time[-1] else track.time[-1]
    time = max(float(end - begin), 0.0)
    on_the_way = sum(begin < since and until < end for since, until in stands)
    return Driven(time, track.length, track.length / time if time else 0.0, on_the_way)


def standing(track: Track) -> List[Tuple[float, float]]:
    """Return the begin and end (s) of each span of time of at least `STOP` seconds in which the robot stood."""
    passed = np.maximum(np.diff(track.time), 1e-9)
    moved, turned = np.hypot(np.diff(track.x), np.diff(track.y)), np.abs(np.diff(track.heading))
    still = (moved < STILL[0] * passed) & (turned < STILL[1] * passed)
    edges = np.flatnonzero(np.diff(np.concatenate(([False], still, [False]))))
    spans = [(float(track.time[begin]), float(track.time[end])) for begin, end in zip(edges[::2], edges[1::2])]
    return [(begin, end) for begin, end in spans if end - begin >= STOP]


def first_movement(track: Track) -> float:
    """Return the time (s) at which a robot had moved away from its first pose by `MOVED`.

    Returns the first time of the track if the robot never moved that far.
    """
    moved = np.maximum(np.hypot(track.x - track.x[0], track.y - track.y[0]) / MOVED[0],
                       np.abs(track.heading - track.heading[0]) / MOVED[1])
    if moved.max() < 1.0:
        return float(track.time[0])
    first = int(np.argmax(moved >= 1.0))
    return float(np.interp(1.0, moved[first - 1:first + 1], track.time[first - 1:first + 1]))


class Push(NamedTuple):
    """A push of a can that the gripper did not hold: number of the can (from 1), begin (s), and distance (m)."""

    can: int
    time: float
    distance: float


def pushes(run: Run) -> Tuple[Push, ...]:
    """Return the pushes of all cans, in order of time. Empty for a real robot: only a simulator publishes its cans."""
    found = []
    for number, can in enumerate(run.cans, 1):
        moved = (np.hypot(np.diff(can.x), np.diff(can.y)) > 0.0) & (np.maximum(can.height[1:], can.height[:-1]) <= 0.0)
        steps = np.flatnonzero(moved & ~_held(run, can))
        for part in np.split(steps, np.flatnonzero(np.diff(can.time[steps]) > AT_REST) + 1):
            if len(part):
                begin, end = part[0], part[-1] + 1
                distance = float(np.hypot(can.x[end] - can.x[begin], can.y[end] - can.y[begin]))
                found += [Push(number, float(can.time[begin]), distance)] * (distance >= PUSHED)
    return tuple(sorted(found, key=lambda push: push.time))


def _held(run: Run, can: CanPath) -> np.ndarray:
    """Return whether the gripper holds a can in each step of its path: an array of bool, one shorter than the path.

    A can is held that is lifted before the paddles do something else. One that stands on the floor before them while
    they hold another is pushed. All are False if the run has no true track or no gripper events.
    """
    held = np.zeros(len(can.time) - 1, dtype=bool)
    if run.truth is None:
        return held
    robot = run.truth.at(can.time[1:])
    grip_x, grip_y = placed((robot.x, robot.y, robot.heading), run.grip, 0.0)
    near = np.hypot(can.x[1:] - grip_x, can.y[1:] - grip_y) < HELD_WITHIN
    ends = [event.time for event in run.gripper[1:]] + [np.inf]
    for event, end in zip(run.gripper, ends):
        during = (can.time[1:] >= event.time) & (can.time[1:] < end)
        if event.what == "picked up" and (can.height[1:][during] > 0.0).any():
            held |= during & near
    return held
