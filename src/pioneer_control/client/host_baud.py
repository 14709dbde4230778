"""Another speed of the line for one session: HOSTBAUD (protocol 2.6), for a robot that is open and stands.

Nothing acknowledges HOSTBAUD. The proof is an answer to a question and a SIP at the new speed: that takes both
directions of the line.

::

    HOSTBAUD new, change ──> CONFIG? ──CONFIGpac and SIP──> new speed
                               └─ none in 0.9 s ──> HOSTBAUD old, change back ──> CONFIG? ─┐
                                                                                           │
              once more from the beginning, then the old speed <──CONFIGpac and SIP────────┤
                                                no speed works <──none in 0.9 s────────────┘

The robot returns to its own speed at CLOSE and at a reset.
"""

from typing import Any, Generator, List, Optional

from .. import p2os
from ..errors import LinkLostError
from .events import LineSpeed
from .identity import CONFIG
from .line import GAP, Line
from .procedure import Clock, Procedure, pause

CAN_CHANGE = (1, 2)     # autobaud in CONFIGpac: HOSTBAUD is obeyed; autobaud besides
COME_TO_REST = 1.0      # s that a robot gets which still rolls when it is found
MOST_BREAKS = 2         # times in a row that the link may break over it: once may be chance
TRIES = 2               # a HOSTBAUD may be lost like anything else
BACK_TRIES = 3          # times that a robot which cannot be understood is told to go back
SETTLE = 0.05           # s for HOSTBAUD to arrive and be obeyed (10 ms), and for what was under way to be gone
BEFORE_SPEAKING = 0.01  # s after our own change
ANSWER = 0.9            # s for the answer
ASK_AGAIN = 0.2         # s; CONFIGpac alone takes 0.14 s at 9600 baud


class HostBaud:
    """Changes to another line speed, if it is wanted and the robot can.

    One object serves all connections of a client, so that what does not work is not tried again.

    Attributes:
        wanted: the other speed (baud); None: the robot's own will do.
    """

    def __init__(self, wanted: Optional[int]) -> None:
        self.wanted = wanted
        self._breaks = 0    # times in a row that it was begun, and the link broke over it

    def procedure(self, line: Line, url: str, clock: Clock, config: Optional[p2os.Config],
                  sip: p2os.Sip) -> Generator[float, Any, List[LineSpeed]]:
        """Take a serial line there, if the robot stands. Returns what there is to say; LinkLostError when the robot was
        lost over it.

        Args:
            line: to the robot, at its own speed.
            url: for the error message.
            clock: tells monotonic time (s).
            config: what the robot says that it is.
            sip: its newest.
        """
        own, wanted = line.baud, self.wanted
        if own is None or wanted is None or wanted == own:
            return []
        if self._breaks == MOST_BREAKS:
            self.wanted = None
            return [LineSpeed(own, "the link broke %d times when its line was to change to %d baud; not tried again"
                              % (MOST_BREAKS, wanted))]
        problem = yield from _hindrance(own, clock, config, sip)
        if problem:
            self._breaks = 0
            return [LineSpeed(own, problem)]
        self._breaks += 1
        works = yield from _change_baud(line, wanted, clock)
        self._breaks = 0
        if works == wanted:
            return [LineSpeed(wanted, "")]
        self.wanted = None
        # It may be at the other speed now, out of reach until it is switched off and on: that is risked only once.
        if works is None:
            raise LinkLostError("%s: lost the robot when its line was to change from %d to %d baud; not tried again"
                                % (url, own, wanted))
        return [LineSpeed(works, "no answer at %d baud; not tried again" % wanted)]


def _hindrance(own: int, clock: Clock, config: Optional[p2os.Config], sip: p2os.Sip) -> Generator[float, Any, str]:
    """Why it cannot be done; empty when the robot can change its speed and has come to rest."""
    if own not in p2os.BAUD_RATES:
        return "there would be no way back to it"
    if config is None or config.autobaud not in CAN_CHANGE:
        return "the robot's firmware cannot change it"
    deadline = clock() + COME_TO_REST
    while not stands(sip) and clock() < deadline:
        packet = yield deadline
        sip = packet if isinstance(packet, p2os.Sip) else sip
    return "" if stands(sip) else "the robot does not stand still"


def stands(sip: p2os.Sip) -> bool:
    """Whether neither wheel turns."""
    return not sip.left_velocity_units and not sip.right_velocity_units


def _change_baud(line: Line, baud: int, clock: Clock) -> Generator[float, Any, Optional[int]]:
    """Take robot and line to ``baud``.

    Returns the speed at which they understand each other then; None if at neither.
    """
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


def _change(line: Line, baud: int, clock: Clock, times: int) -> Procedure:
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
    while missing and clock() < deadline:
        line.command(clock(), CONFIG)
        again = min(clock() + ASK_AGAIN, deadline)
        while missing and clock() < again:
            packet = yield again
            missing.discard(type(packet))
    return not missing
