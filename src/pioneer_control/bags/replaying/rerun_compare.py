"""Compare the commands of a program in a re-run with the recorded ones. Pure functions.

Decisions (msg/Decision.msg) must be equal in every field. Velocities are compared over time, with a tolerance, because
a program may be a little faster or slower than in the recorded run. Of other commands, the order is compared.
"""

from typing import Any, Iterator, List, NamedTuple, Optional, Sequence, Tuple

import numpy as np

from .redrive_schedule import VALID

STEP = 0.05
"""The time between two moments at which velocities are compared (s)."""
LATE = 0.3
"""By how much a command may come earlier or later than in the recording (s)."""
TOLERANCE = 0.02, 0.05
"""Velocities (m/s forward, rad/s) are alike when they differ by no more than this."""
NOT_COMPARED = {"header.seq"}
"""Fields of a Decision that are not compared, because they do not depend on what was decided."""


class Difference(NamedTuple):
    """The first difference between two sequences of messages."""

    place: int
    """The index of the first message that differs, counted from 0."""
    what: str
    """What differs, in words."""


class Likeness(NamedTuple):
    """How alike two series of velocity commands are."""

    seconds: float
    """The length of the compared time (s)."""
    share: float
    """The share of the compared time in which the velocities are alike (0 to 1)."""
    first: Optional[float]
    """The time of the first difference, in s after the first command. None if the velocities are always alike."""
    largest: Tuple[float, float]
    """The largest difference of each of the two velocities: m/s and rad/s for a Twist, m/s for wheels."""


class Verdict(NamedTuple):
    """The result of a comparison: whether the commands are the same, and sentences that report it."""

    same: bool
    sentences: List[str]


def fields_of(message: Any, prefix: str = "") -> Iterator[Tuple[str, Any]]:
    """Yield the name and the value of each field of a message. A field of an inner message is named ``header.seq``."""
    for name in message.__slots__:
        value = getattr(message, name)
        if hasattr(value, "__slots__") and hasattr(value, "_type"):
            yield from fields_of(value, "%s%s." % (prefix, name))
        else:
            yield prefix + name, value


def first_difference(live: Sequence[Any], again: Sequence[Any]) -> Optional[Difference]:
    """Return the first difference between two sequences of messages. None if they are equal.

    Values must be exactly equal, except in the fields in `NOT_COMPARED`.
    """
    for index, (one, other) in enumerate(zip(live, again)):
        for (name, before), (_, now) in zip(fields_of(one), fields_of(other)):
            if before != now and name not in NOT_COMPARED:
                return Difference(index, "%s was %s, and is %s" % (name, before, now))
    if len(live) != len(again):
        return Difference(min(len(live), len(again)), "there were %s, and are %s" % (len(live), len(again)))
    return None


def velocities_of(told: Sequence[Tuple[float, Any]]) -> np.ndarray:
    """Return velocity commands as an array (n, 3): time (s) and two velocities.

    The velocities are forward (m/s) and turn (rad/s, counter-clockwise) of a Twist, or left and right (m/s) of a
    WheelVelocities.

    Args:
        told: (time in s, message) of each command.
    """
    return np.array([(time, message.left, message.right) if hasattr(message, "left")
                     else (time, message.linear.x, message.angular.z) for time, message in told]).reshape(-1, 3)


def likeness(live: np.ndarray, again: np.ndarray, tolerance: Tuple[float, float] = TOLERANCE) -> Likeness:
    """Return how alike two series of velocity commands are.

    The time from the first command to the end of the last one is compared in steps of `STEP` s. A moment counts as
    alike when each series has a velocity, at most `LATE` s earlier or later, that the other series has at this moment,
    within the tolerance. A velocity is valid until the next command, but at most for `redrive_schedule.VALID` s. Then
    it is 0.

    Args:
        live: the recorded commands, an array from `velocities_of`.
        again: the commands in the re-run, an array from `velocities_of`.
        tolerance: for each of the two velocities (m/s and rad/s, or m/s and m/s).
    """
    times = np.concatenate([live[:, 0], again[:, 0]])
    if not len(times):
        return Likeness(0.0, 1.0, None, (0.0, 0.0))
    moments = np.arange(-LATE, np.ptp(times) + VALID + LATE, STEP)
    one, other = _held(live, times.min() + moments), _held(again, times.min() + moments)
    around = round(LATE / STEP)
    apart = np.maximum(_nearest(one, other, around, tolerance), _nearest(other, one, around, tolerance))
    alike = np.all(apart <= np.array(tolerance) + 1e-9, axis=1)
    first = None if alike.all() else max(0.0, float(moments[np.argmin(alike)]))
    return Likeness(float(np.ptp(moments)), float(alike.mean()), first,
                    (float(apart[:, 0].max()), float(apart[:, 1].max())))


def _held(velocities: np.ndarray, moments: np.ndarray) -> np.ndarray:
    """Return the commanded velocities at each moment as an array (m, 2).

    They are 0 before the first command, and when the last command is older than `VALID`.

    Args:
        velocities: the commands, an array from `velocities_of`.
        moments: times, on the same clock (s).
    """
    in_order = velocities[np.argsort(velocities[:, 0], kind="stable")]
    ordered = np.concatenate([[(-np.inf, 0.0, 0.0)], in_order])     # before the first command a robot stands
    index = np.searchsorted(ordered[:, 0], moments, side="right") - 1
    is_old = moments - ordered[index, 0] > VALID
    return np.where(is_old[:, np.newaxis], 0.0, ordered[index, 1:])


def _nearest(one: np.ndarray, other: np.ndarray, around: int, tolerance: Tuple[float, float]) -> np.ndarray:
    """For each velocity in `one`, return its difference from the most similar velocity near it in `other`, as (m, 2).

    Args:
        one: velocities (m, 2), a row for each moment.
        other: velocities (m, 2) at the same moments.
        around: how many rows earlier or later a velocity in `other` may be.
        tolerance: weighs the two columns against each other, to find the most similar velocity.
    """
    padded = np.pad(other, ((around, around), (0, 0)))
    shifted = np.stack([np.abs(one - padded[start:start + len(one)]) for start in range(2 * around + 1)])
    best = np.argmin((shifted / np.array(tolerance)).max(axis=2), axis=0)
    return shifted[best, np.arange(len(one))]


def judge_decisions(live: Sequence[Any], again: Sequence[Any]) -> Verdict:
    """Compare the decisions of a `Pioneer` in a re-run with the recorded ones. They must be equal.

    Args:
        live: the recorded Decision messages.
        again: the Decision messages of the re-run.
    """
    found = first_difference(live, again)
    counts = "%s decisions live, %s in the re-run" % (len(live), len(again))
    if found is None:
        return Verdict(True, [counts + ": every one is the same."])
    if found.place >= min(len(live), len(again)):
        return Verdict(False, ["%s: the first %s are the same." % (counts, found.place)])
    stamp = live[found.place].header.stamp.to_sec() - live[0].header.stamp.to_sec()
    return Verdict(False, ["%s. They differ from number %s on, %.1f s after the first: %s."
                           % (counts, found.place + 1, stamp, found.what)])


def judge_velocities(topic: str, live: np.ndarray, again: np.ndarray, enough: float) -> Verdict:
    """Compare the velocities that were commanded on one topic.

    Args:
        topic: the last name of the topic.
        live: the recorded commands, an array from `velocities_of`.
        again: the commands in the re-run, an array from `velocities_of`.
        enough: the share of the time for which the velocities must be alike (0 to 1).
    """
    units = ("m/s", "rad/s") if topic == "cmd_vel" else ("m/s left", "m/s right")
    tolerance = TOLERANCE if topic == "cmd_vel" else (TOLERANCE[0], TOLERANCE[0])
    alike = likeness(live, again, tolerance)
    sentence = "%s: %s live, %s in the re-run; alike for %.1f %% of %.1f s (within %g %s and %g %s)" % (
        topic, len(live), len(again), 100 * alike.share, alike.seconds, tolerance[0], units[0], tolerance[1], units[1])
    if alike.first is not None:
        sentence += "; different first after %.1f s, by at most %.2f %s and %.2f %s" % (
            alike.first, alike.largest[0], units[0], alike.largest[1], units[1])
    return Verdict(alike.share >= enough, [sentence + "."])


def judge_others(topic: str, live: Sequence[Any], again: Sequence[Any]) -> Verdict:
    """Compare commands that are not velocities. They must come in the same order. A repeated command counts once.

    Args:
        topic: the last name of the topic.
        live: the recorded messages.
        again: the messages of the re-run.
    """
    one, other = _changes(live), _changes(again)
    found = first_difference(one, other)
    if found is None:
        return Verdict(True, ["%s: the same %s in the same order." % (topic, len(one)) if one else "%s: none." % topic])
    return Verdict(False, ["%s: different from the %s. on: %s." % (topic, found.place + 1, found.what)])


def _changes(messages: Sequence[Any]) -> List[Any]:
    """Return the messages that differ from the message before them."""
    return [message for index, message in enumerate(messages) if index == 0
            or first_difference([messages[index - 1]], [message])]
