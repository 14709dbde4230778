"""Keeps long texts that change all the time within the page's budget. Pure.

A viewer of 30 robots may get 15 kB a second, of which frames and status take 13.7. The ranking of 30 students has 3 kB,
and the places of 90 cans 1.4: they go in turn, and so seldom that all of them together take RATE.
"""

import json
import math
from typing import Any, Callable, Dict, Mapping, NamedTuple, Optional

from .backend import TextFeed

RATE = 1100     # bytes a second


class TextPace(NamedTuple):
    """How often texts of a kind are sent."""

    period: float = 0.0
    """The least time between two texts (s), however short they are."""
    urgent: Callable[[Any], Any] = lambda value: None
    """Returns the part of a text of which each change is sent at once."""


PACES: Mapping[str, TextPace] = {
    "task": TextPace(1.0, lambda task: task and (task["name"], task["state"])),
    "cans": TextPace(),
}
"""The kinds of texts that wait. All of them are for all viewers."""


class PacedFeed:
    """A TextFeed that passes texts on. Of kinds that wait it passes on the newest, and only in turn().

    Args:
        feed: takes the texts.
    """

    def __init__(self, feed: TextFeed) -> None:
        self._feed = feed
        self._waiting: Dict[str, Any] = {}      # the kind that waits longest comes first
        self._due = -math.inf                   # when the next text may be sent, of any kind
        self._due_again: Dict[str, float] = {}  # when the next text of the same kind may be sent
        self._urgent: Dict[str, Any] = {}       # of the texts that were sent last

    def text(self, kind: str, value: Any, robot: Optional[int] = None, seat: str = "", to: str = "") -> None:
        """Take a text. See Feed.text()."""
        if kind in PACES:
            self._waiting[kind] = value
        else:
            self._feed.text(kind, value, robot, seat, to)

    def turn(self, now: float) -> None:
        """Pass on what is due (monotonic time, s)."""
        for kind, value in list(self._waiting.items()):
            urgent = PACES[kind].urgent(value)
            if now >= max(self._due, self._due_again.get(kind, -math.inf)) or urgent != self._urgent.get(kind):
                del self._waiting[kind]
                self._urgent[kind] = urgent
                self._due_again[kind] = now + PACES[kind].period
                self._due = now + len(json.dumps(value, separators=(",", ":"))) / RATE
                self._feed.text(kind, value)
