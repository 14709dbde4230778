"""Does a program command the same on the bag as beside the robot? Pure.

Decisions (msg/Decision.msg) are compared exactly, in every field. Of any other program the velocities are compared as
they held at each moment, with some tolerance: a program may be a little faster or slower than it was. Whatever else it
commanded is compared by its order.
"""

from typing import Any, Iterator, List, NamedTuple, Optional, Sequence, Tuple

import numpy as np

from .redrive_schedule import VALID

STEP = 0.05
"""s between two moments that are compared."""
LATE = 0.3
"""s by which a command may come earlier or later."""
TOLERANCE = 0.02, 0.05
"""m/s, rad/s: velocities that differ by less are as good as the same."""
NOT_COMPARED = {"header.seq"}
"""Fields of a decision that count what a publisher sent, not what it decided."""


class Difference(NamedTuple):
    """The first elements of two sequences that are not the same."""

    place: int
    """which, from 0"""
    what: str
    """what is different"""


class Likeness(NamedTuple):
    """How alike two commanded motions are."""

    seconds: float
    """that were compared"""
    share: float
    """of that time, within the tolerance"""
    first: Optional[float]
    """s after the first command: when they differ for the first time; None: never"""
    largest: Tuple[float, float]
    """difference of either number"""


class Verdict(NamedTuple):
    """What a comparison came to."""

    same: bool
    sentences: List[str]


def fields_of(message: Any, prefix: str = "") -> Iterator[Tuple[str, Any]]:
    """Names and values of a message's fields, those in its parts too."""
    for name in message.__slots__:
        value = getattr(message, name)
        if hasattr(value, "__slots__") and hasattr(value, "_type"):
            yield from fields_of(value, "%s%s." % (prefix, name))
        else:
            yield prefix + name, value


def first_difference(live: Sequence[Any], again: Sequence[Any]) -> Optional[Difference]:
    """Where two sequences of messages differ first; None when they are the same, to the last bit, and equally many."""
    for index, (one, other) in enumerate(zip(live, again)):
        for (name, before), (_, now) in zip(fields_of(one), fields_of(other)):
            if before != now and name not in NOT_COMPARED:
                return Difference(index, "%s was %s, and is %s" % (name, before, now))
    if len(live) != len(again):
        return Difference(min(len(live), len(again)), "there were %s, and are %s" % (len(live), len(again)))
    return None


def velocities_of(told: Sequence[Tuple[float, Any]]) -> np.ndarray:
    """Velocities as numbers, (n, 3): when they were commanded (s), and their two numbers.

    Those are m/s forward and rad/s of a Twist, m/s of either side of a WheelVelocities.

    Args:
        told: (s, message).
    """
    return np.array([(time, message.left, message.right) if hasattr(message, "left")
                     else (time, message.linear.x, message.angular.z) for time, message in told]).reshape(-1, 3)


def likeness(live: np.ndarray, again: np.ndarray, tolerance: Tuple[float, float] = TOLERANCE) -> Likeness:
    """How alike are the velocities that hold, from the first command of either to the end of the last one?

    A moment is alike when what was commanded then is met, within the tolerance, at some moment not more than `LATE` s
    away. After `redrive_schedule.VALID` without a command a robot stands.

    Args:
        live: beside the robot, as `velocities_of` has them.
        again: on the bag, likewise.
        tolerance: of either number.
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
    """Which velocity held at each moment (s), (m, 2)."""
    in_order = velocities[np.argsort(velocities[:, 0], kind="stable")]
    ordered = np.concatenate([[(-np.inf, 0.0, 0.0)], in_order])     # before the first command a robot stands
    index = np.searchsorted(ordered[:, 0], moments, side="right") - 1
    is_old = moments - ordered[index, 0] > VALID
    return np.where(is_old[:, np.newaxis], 0.0, ordered[index, 1:])


def _nearest(one: np.ndarray, other: np.ndarray, around: int, tolerance: Tuple[float, float]) -> np.ndarray:
    """How far velocities are from the nearest velocity at a moment near by, (m, 2).

    Args:
        one: velocities (m, 2).
        other: those to look for, (m, 2).
        around: how many steps away a moment may be.
        tolerance: the unit in which either number is compared.
    """
    padded = np.pad(other, ((around, around), (0, 0)))
    shifted = np.stack([np.abs(one - padded[start:start + len(one)]) for start in range(2 * around + 1)])
    best = np.argmin((shifted / np.array(tolerance)).max(axis=2), axis=0)
    return shifted[best, np.arange(len(one))]


def judge_decisions(live: Sequence[Any], again: Sequence[Any]) -> Verdict:
    """Compare the decisions of a `Pioneer`."""
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
    """Compare the velocities of one topic.

    Args:
        topic: last name.
        live: beside the robot, as `velocities_of` has them.
        again: on the bag, likewise.
        enough: share of the time for which they must be alike.
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
    """Compare messages that are not velocities: the same must come in the same order. Repetitions do not count."""
    one, other = _changes(live), _changes(again)
    found = first_difference(one, other)
    if found is None:
        return Verdict(True, ["%s: the same %s in the same order." % (topic, len(one)) if one else "%s: none." % topic])
    return Verdict(False, ["%s: different from the %s. on: %s." % (topic, found.place + 1, found.what)])


def _changes(messages: Sequence[Any]) -> List[Any]:
    """Messages without those that only repeat the one before."""
    return [message for index, message in enumerate(messages) if index == 0
            or first_difference([messages[index - 1]], [message])]
