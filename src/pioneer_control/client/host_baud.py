"""Another speed of the line for one session: HOSTBAUD (protocol 2.6), for a robot that is open and stands.

Nothing acknowledges HOSTBAUD. The proof is an answer to a question and a SIP at the new speed: that takes both directions of the line.

::

    HOSTBAUD new, change ──> CONFIG? ──CONFIGpac and SIP──> new speed
      ^                        └─ none in 0.9 s ──> HOSTBAUD old, change back ──> CONFIG? ──CONFIGpac and SIP──> once more, then old speed
      └──────────────────────────────────────────────────────────────────────────────────┘   └─ none in 0.9 s ──> no speed works

The robot returns to its own speed at CLOSE and at a reset.
"""

from typing import Any, Generator, Optional

from .. import p2os
from .identity import CONFIG
from .line import GAP, Line
from .script import Clock, Script, pause

CAN_CHANGE = (1, 2)     # autobaud in CONFIGpac: HOSTBAUD is obeyed; autobaud besides
TRIES = 2               # a HOSTBAUD may be lost like anything else
BACK_TRIES = 3          # times that a robot which cannot be understood is told to go back
SETTLE = 0.05           # s for HOSTBAUD to arrive and be obeyed (10 ms), and for what was under way to be gone
BEFORE_SPEAKING = 0.01  # s after our own change
ANSWER = 0.9            # s for the answer
ASK_AGAIN = 0.2         # s; CONFIGpac alone takes 0.14 s at 9600 baud


def change_baud(line: Line, baud: int, clock: Clock) -> Generator[float, Any, Optional[int]]:
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
