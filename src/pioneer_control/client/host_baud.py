"""Changes the serial line speed for one session by HOSTBAUD (protocol 2.6), while the robot is open and stands.

The robot does not acknowledge HOSTBAUD. So the client asks for CONFIGpac at the new speed, and waits for CONFIGpac and
a SIP. They prove that the robot obeyed: an answer needs both directions of the line.

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
from .line import GAP
from .link import Link

CAN_CHANGE = (1, 2)     # values of autobaud in CONFIGpac: 1 the robot obeys HOSTBAUD, 2 it has autobaud, too
COME_TO_REST = 1.0      # s for a robot that still rolls to come to rest
MOST_BREAKS = 2         # how often in a row the link may break during the change: one break may be chance
TRIES = 2               # HOSTBAUD may get lost like any packet
BACK_TRIES = 3          # how often HOSTBAUD is sent to change back, when the client cannot understand the robot
SETTLE = 0.05           # s for HOSTBAUD to arrive and be obeyed (10 ms), and for older bytes to arrive
BEFORE_SPEAKING = 0.01  # s between our own change and our next packet
ANSWER = 0.9            # s for CONFIGpac and a SIP to come
ASK_AGAIN = 0.2         # s; CONFIGpac alone takes 0.14 s at 9600 baud


def use_host_baud(link: Link, config: Optional[p2os.Config],
                  sip: p2os.Sip) -> Generator[float, Any, List[LineSpeed]]:
    """Change a serial line to the speed ``link.host_baud.wanted``, if the robot can change it and stands.

    Args:
        link: the link to a robot at its own speed. Its ``host_baud`` keeps the result for later connections.
        config: the robot's CONFIGpac; None when none came.
        sip: the newest SIP.

    Returns:
        Events for the listeners; empty when no other speed is wanted.

    Raises:
        LinkLostError: the robot answers neither at the new speed nor at its own speed.
    """
    own, wanted = link.line.baud, link.host_baud.wanted
    if own is None or wanted is None or wanted == own:
        return []
    if link.host_baud.breaks == MOST_BREAKS:
        link.host_baud.wanted = None
        return [LineSpeed(own, "the link broke %d times when its line was to change to %d baud; not tried again"
                          % (MOST_BREAKS, wanted))]
    problem = yield from _hindrance(link, own, config, sip)
    if problem:
        link.host_baud.breaks = 0
        return [LineSpeed(own, problem)]
    link.host_baud.breaks += 1
    for _ in range(TRIES):
        if (yield from _works_at(link, wanted, 1)):
            link.host_baud.breaks = 0
            return [LineSpeed(wanted, "")]
        if not (yield from _works_at(link, own, BACK_TRIES)):
            # It may be at the other speed now, out of reach until it is switched off and on: that is risked only once.
            link.host_baud.wanted = None
            raise LinkLostError("%s: lost the robot when its line was to change from %d to %d baud; not tried again"
                                % (link.url, own, wanted))
    link.host_baud.wanted = None
    return [LineSpeed(own, "no answer at %d baud; not tried again" % wanted)]


def _hindrance(link: Link, own: int, config: Optional[p2os.Config], sip: p2os.Sip) -> Generator[float, Any, str]:
    """Return why the speed cannot be changed; empty when it can. Waits up to COME_TO_REST s for the robot to stand.

    ``own`` is the robot's own line speed (baud).
    """
    if own not in p2os.BAUD_RATES:
        return "there would be no way back to it"
    if config is None or config.autobaud not in CAN_CHANGE:
        return "the robot's firmware cannot change it"
    deadline = link.now + COME_TO_REST
    while not stands(sip) and link.now < deadline:
        packet = yield deadline
        sip = packet if isinstance(packet, p2os.Sip) else sip
    return "" if stands(sip) else "the robot does not stand still"


def stands(sip: p2os.Sip) -> bool:
    """Return whether both wheels stand still in this SIP."""
    return not sip.left_velocity_units and not sip.right_velocity_units


def _works_at(link: Link, baud: int, times: int) -> Generator[float, Any, bool]:
    """Send HOSTBAUD for ``baud`` so many ``times``, and change our side of the line to this speed.

    Returns whether the robot then sends CONFIGpac and a SIP.
    """
    for _ in range(times):
        link.line.command(link.now, p2os.encode_command("HOSTBAUD", p2os.BAUD_RATES.index(baud)))
    while link.line.waiting or link.line.busy(link.now):
        yield max(link.line.free_at, link.now + GAP)
    yield from link.pause(SETTLE)
    link.line.set_baud(baud)
    yield from link.pause(BEFORE_SPEAKING)
    missing, deadline = {p2os.Sip, p2os.Config}, link.now + ANSWER
    while missing and link.now < deadline:
        link.line.command(link.now, CONFIG)
        again = min(link.now + ASK_AGAIN, deadline)
        while missing and link.now < again:
            packet = yield again
            missing.discard(type(packet))
    return not missing
