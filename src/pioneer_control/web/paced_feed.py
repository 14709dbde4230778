"""Keeps long texts that change all the time within the page's budget. Pure.

A viewer of 30 robots may get 15 kB a second, of which their frames take 12.5. The ranking of 30 students has 2 kB, and
so have the places of 90 cans: they go so seldom that each of them takes RATE at most.
"""

import json
import math
from typing import Any, Callable, Dict, Mapping, NamedTuple, Optional

from .backend import TextFeed

RATE = 1000     # bytes a second, for each kind of text


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
        self._waiting: Dict[str, Any] = {}
        self._due: Dict[str, float] = {}        # when the next text of a kind may be sent
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
            if now < self._due.get(kind, -math.inf) and urgent == self._urgent[kind]:
                continue
            del self._waiting[kind]
            length = len(json.dumps(value, separators=(",", ":")))
            self._due[kind], self._urgent[kind] = now + max(PACES[kind].period, length / RATE), urgent
            self._feed.text(kind, value)
