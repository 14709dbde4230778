"""Another speed of the line for one session: HOSTBAUD (protocol 2.6), for a robot that is open and stands.

Nothing acknowledges HOSTBAUD. The proof is an answer to a question and a SIP at the new speed: that takes both directions of the line.

::

    HOSTBAUD new, change ──> CONFIG? ──CONFIGpac and SIP──> new speed
      ^                        └─ none in 0.9 s ──> HOSTBAUD old, change back ──> CONFIG? ──CONFIGpac and SIP──> once more, then old speed
      └──────────────────────────────────────────────────────────────────────────────────┘   └─ none in 0.9 s ──> no speed works

The robot returns to its own speed at CLOSE and at a reset.
"""

from typing import Any, Generator, List, Optional

from .. import p2os
from ..errors import LinkLostError
from .events import LineSpeed
from .identity import CONFIG
from .line import GAP, Line
from .script import Clock, Script, pause

CAN_CHANGE = (1, 2)     # autobaud in CONFIGpac: HOSTBAUD is obeyed; autobaud besides
COME_TO_REST = 1.0      # s that a robot gets which still rolls when it is found
TRIES = 2               # a HOSTBAUD may be lost like anything else
BACK_TRIES = 3          # times that a robot which cannot be understood is told to go back
SETTLE = 0.05           # s for HOSTBAUD to arrive and be obeyed (10 ms), and for what was under way to be gone
BEFORE_SPEAKING = 0.01  # s after our own change
ANSWER = 0.9            # s for the answer
ASK_AGAIN = 0.2         # s; CONFIGpac alone takes 0.14 s at 9600 baud


class HostBaud:
    """Another speed, where it is wanted and the robot can.

    Args:
        line: to the robot; at its own speed when the script begins.
        url: for the error message.
        wanted: the other speed; None: its own will do.
        clock: tells monotonic time (s).
    """

    def __init__(self, line: Line, url: str, wanted: Optional[int], clock: Clock) -> None:
        self.failed = False
        """Whether it was tried and does not work."""
        self.under_way = False
        """Whether it was begun and did not end well or badly: of a session that is over, that the link broke over it."""
        self._line = line
        self._url = url
        self._wanted = wanted
        self._clock = clock

    def script(self, config: Optional[p2os.Config], sip: p2os.Sip) -> Generator[float, Any, List[LineSpeed]]:
        """Take a serial line there, if the robot stands. Returns what there is to say; LinkLostError when the robot was lost over it.

        Args:
            config: what the robot says that it is.
            sip: its newest.
        """
        own, wanted = self._line.baud, self._wanted
        if own is None or wanted is None or wanted == own:
            return []
        problem = yield from self._hindrance(own, config, sip)
        if problem:
            return [LineSpeed(own, problem)]
        self.under_way = True
        works = yield from _change_baud(self._line, wanted, self._clock)
        self.under_way, self.failed = False, works != wanted
        if works is None:       # it may be at the other speed now, out of reach until it is switched off and on: that is risked only once
            raise LinkLostError("%s: lost the robot when its line was to change from %d to %d baud; not tried again" % (self._url, own, wanted))
        return [LineSpeed(works, "no answer at %d baud; not tried again" % wanted if self.failed else "")]

    def _hindrance(self, own: int, config: Optional[p2os.Config], sip: p2os.Sip) -> Generator[float, Any, str]:
        """Why it cannot be done; empty when the robot can change its speed and has come to rest."""
        if own not in p2os.BAUD_RATES:
            return "there would be no way back to it"
        if config is None or config.autobaud not in CAN_CHANGE:
            return "the robot's firmware cannot change it"
        deadline = self._clock() + COME_TO_REST
        while not stands(sip) and self._clock() < deadline:
            packet = yield deadline
            sip = packet if isinstance(packet, p2os.Sip) else sip
        return "" if stands(sip) else "the robot does not stand still"


def stands(sip: p2os.Sip) -> bool:
    """Whether neither wheel turns."""
    return not sip.left_velocity_units and not sip.right_velocity_units


def _change_baud(line: Line, baud: int, clock: Clock) -> Generator[float, Any, Optional[int]]:
    """Take robot and line to ``baud``. Returns the speed at which they understand each other then; None if at neither."""
    old = line.baud
    assert old is not None
    for _ in range(TRIES):
        yield from _change(line, baud, clock, 1)
        if (yield from _answers(line, clock)):
            return baud
        yield from _change(line, old, clock, BACK_TRIES)
        if not (yield from _answers(line, clock)):
            return None
    return old


def _change(line: Line, baud: int, clock: Clock, times: int) -> Script:
    for _ in range(times):
        line.command(clock(), p2os.encode_command("HOSTBAUD", p2os.BAUD_RATES.index(baud)))
    while line.waiting or line.busy(clock()):
        yield max(line.free_at, clock() + GAP)
    yield from pause(SETTLE, clock)
    line.set_baud(baud)
    yield from pause(BEFORE_SPEAKING, clock)


def _answers(line: Line, clock: Clock) -> Generator[float, Any, bool]:
    """Whether the robot answers, and goes on sending SIPs."""
    missing, deadline = {p2os.Sip, p2os.Config}, clock() + ANSWER
    while clock() < deadline:
        line.command(clock(), CONFIG)
        again = min(clock() + ASK_AGAIN, deadline)
        while clock() < again:
            packet = yield again
            missing.discard(type(packet))
            if not missing:
                return True
    return False
