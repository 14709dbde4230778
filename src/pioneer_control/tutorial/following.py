"""Follows a wander: decides on each sonar message, drives by the newest decision, and says what the robot does and why.
"""

import time
from typing import Callable

import rospy

from .reports import Reports, Stopwatch
from .sights import Sight
from .wander import STALE, Move, no_news
from .wandering import Wandering

SILENCE = 2.0  #: s without sensor data before this is logged; with slow simulated time all messages come late
TELL_AGAIN = 15.0  #: s after which a message of the same kind is logged again, with new numbers
LOOK_AGAIN = 0.25  #: s between two checks for new sensor data


def follow(
        wandering: Wandering, duration: float, reports: Reports, drive: Callable[[float, float], None],
        stop: Callable[[], None], tell: Callable[[Sight, Move], None]) -> None:
    """Decide and drive until the wander ends, or until `duration` seconds have passed and no sensor data come.

    Args:
        wandering: the wander.
        duration: how long it lasts [s].
        reports: what is heard of the robot.
        drive: a function that publishes a velocity [m/s, rad/s].
        stop: a function that stops the robot.
        tell: a function that publishes a decision.
    """
    narrator, passed, news = Narrator(), Stopwatch(), time.monotonic()
    sights = reports.sights
    while wandering.end is None:
        move, newest = None, wandering.newest
        if reports.wait(lambda: sights, LOOK_AGAIN):
            seen_at, sight = sights.popleft()
            move = wandering.decide(sight, reports.heard)
            if wandering.newest != newest:
                news = seen_at
        age = time.monotonic() - news
        if age > STALE:  # also when stamps do not advance: the robot must not drive on while ROS time is paused
            stop()
            if age > SILENCE and not sights:    # there is no silence while sights still wait for a decision
                narrator.tell(no_news(age).reason)
            if passed() >= duration and not wandering.waits:
                return
        elif move and not sights:
            drive(move.linear, move.angular)
            narrator.tell(move.reason)
        if move:
            tell(sight, move)


class Narrator:
    """Logs what the robot does and why: once when this changes, and again every TELL_AGAIN seconds."""

    def __init__(self) -> None:
        self._headline, self._told_at = "", 0.0

    def tell(self, reason: str) -> None:
        """Log a reason, unless a reason with the same text before the colon was just logged."""
        headline, now = reason.partition(":")[0], time.monotonic()
        if headline != self._headline or now - self._told_at > TELL_AGAIN:
            rospy.loginfo("%s", reason)
            self._headline, self._told_at = headline, now
