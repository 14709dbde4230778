"""Sends the values of a Tuning to a robot, and checks in CONFIGpac that the robot took them.

A robot acknowledges no command. So a value is sent in up to four rounds, until CONFIGpac shows it.
"""

import math
from typing import Dict, Optional

from .. import p2os
from .events import Tuned
from .identity import CONFIG, RobotIdentity
from .link import Link
from .tuning import ROWS, Change, Value

TRIES = 4               # rounds in which a value is sent
AGAIN = 0.4             # s for the answer to a round: CONFIGpac alone takes 0.14 s at 9600 baud


class Tuner:
    """Sends the settings of one connected robot, and reports the result. ``now`` is monotonic time in s.

    The first values are sent when the robot has shown that it stands, later values at once. Each round ends with a
    request for CONFIGpac. CONFIGpac never shows bump_stall and sonar_polling, so they are sent in every round.

    Args:
        link: the link of the robot. Its ``settings`` have the values, and its ``events`` get the result (Tuned).
        identity: the identity with the newest CONFIGpac.
    """

    def __init__(self, link: Link, identity: RobotIdentity) -> None:
        self._link = link
        self._identity = identity
        self.waits_for_rest = True
        """True until the robot has shown that it stands. Until then nothing is sent."""
        self._told: Dict[str, Value] = {}               # all values that were sent to this robot
        self._before: Dict[str, Optional[float]] = {}   # values that are being sent: what the robot had
        self._own = identity.config
        self._answer: Optional[p2os.Config] = None      # to the present round
        self._tries = 0
        self.due = math.inf
        """Time (monotonic, s) by which tick() must be called; infinity when nothing is due."""

    def tune(self, now: float) -> None:
        """Send those wanted values that differ from the values sent before. Call it after the robot has stood once.

        A setting that is None again is set back to the robot's own value.
        """
        self.waits_for_rest = False
        new = {name: value for name, value in self._wanted().items() if self._told.get(name) != value}
        if new:
            for name in new:
                self._before.setdefault(name, ROWS[name].shown(self._identity.config))
            self._told.update(new)
            self._tries = 0
            # During a round nothing is sent: the next round sends the new values, too. So no queue builds up, however
            # fast values come.
            if self.due == math.inf:
                self._send(now)

    def saw_config(self, identity: RobotIdentity, now: float) -> None:
        """Take an identity with a new CONFIGpac, and compare the CONFIGpac with the values that were sent."""
        self._identity = identity
        if self._before:
            self._answer = identity.config
            self._judge(now)

    def tick(self, now: float) -> None:
        """When a round is over without a result, send the values again, or give up and report it."""
        if now >= self.due:
            self._judge(now)

    def _wanted(self) -> Dict[str, Value]:
        wanted = dict(self._link.settings.tuning.values)
        for name in [name for name in self._told if name not in wanted]:
            own = ROWS[name].shown(self._own)
            if own is not None and ROWS[name].number(own) >= ROWS[name].low:
                wanted[name] = own
            elif not self._unknown(name):
                self._before.pop(name, None)
                told = Change(name, ROWS[name].unit, self._told.pop(name), None, None)
                problem = "what it had itself is not known: it stays %s until the next connect" % told.wanted_text
                change = told._replace(wanted=None, problem=problem)
                self._link.events.append(Tuned((change,), self._identity))
        return wanted

    def _send(self, now: float) -> None:
        self._tries += 1
        self.due = now + AGAIN
        waiting = [name for name in self._before if not self._link.line.full and not self._settled(name)]
        for name in waiting:
            self._link.line.command(now, ROWS[name].packet(self._told[name]))
        if any(ROWS[name].config for name in waiting):
            self._link.line.command(now, CONFIG)

    def _judge(self, now: float) -> None:
        """End a round: begin another round, or append the result (Tuned) to the events."""
        if self._tries < TRIES and not all(map(self._settled, self._before)):
            self._send(now)
        else:
            if self._before:
                self._link.events.append(Tuned(tuple(map(self._change, self._before)), self._identity))
            self._before, self._answer, self.due = {}, None, math.inf

    def _settled(self, name: str) -> bool:
        """Return whether a setting is done: the robot has taken the value, or its firmware has no such setting."""
        return self._unknown(name) or self._taken(name)

    def _unknown(self, name: str) -> bool:
        return bool(self._why_not(name))

    def _why_not(self, name: str) -> str:
        return ROWS[name].why_not(self._identity.model, self._told[name])

    def _taken(self, name: str) -> bool:
        shown, number = ROWS[name].shown(self._answer), ROWS[name].number
        return shown is not None and number(shown) == number(self._told[name])

    def _change(self, name: str) -> Change:
        row = ROWS[name]
        reported = row.shown(self._answer)
        problem = ""
        if self._unknown(name):
            problem = self._why_not(name)
        elif row.config and reported is None:
            problem = "sent, but the robot does not report it"
        elif row.config and not self._taken(name):
            problem = "the robot did not take it"
        return Change(name, row.unit, self._told[name], self._before[name], reported, problem)
