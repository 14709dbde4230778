"""Lockstep with a simulated robot: the same program does exactly the same, however fast the computer is.

The simulated time stands after each SIP, until the program asks for the next state (Robot.wait_for_state). Then the
client sends the **mark** behind all commands of this turn, and simulated time goes on until the next SIP. The mark is
PULSE, which every robot understands. So it does no harm where nobody waits for it.

::

    robot:   SIP ......................... SIP .....        no simulated time passes in between
    client:      VEL, RVEL, GRIPPER, mark      VEL, ...

Time-outs of the real time would differ from run to run. So the session of a connected robot has a time of its own. It
begins at 0 with the first state, and each SIP sets it forward by one cycle of the robot. All that acts on the robot
counts in this time: the dead man, repeated commands, the requests for the motors. There are no signs of life by the
clock. Only a simulator that hangs is noticed by real time.

The connection ends at once: STOP, motors off and CLOSE are sent in one piece. The simulated time stands meanwhile.
"""

import math
from typing import Any, Callable, Dict, List, Optional, Tuple, Type

from .. import p2os
from .link import Failed, Learned, Left, Link, Outcome, Phase, Recognised
from .phases import PULSE, TRANSITIONS, Closing, Connected, Finished, Opening, Synced

MARK = PULSE
LONGEST_CYCLE = 10.0    # s of real time: a simulator that takes longer for one cycle hangs
DIGITS = 6              # behind the point of the time (s): sums of cycles stay round numbers


class OpeningInLockstep(Opening):
    """Opening, which sends a mark behind its commands, and after each SIP that is not the last one."""

    _marked = -1        # number of SIPs at the newest mark

    def _resume(self, packet: Any) -> Optional[Outcome]:
        outcome, link = super()._resume(packet), self._link
        if outcome is None and self._marked != link.sips:
            self._marked = link.sips
            link.line.command(link.now, MARK)
        return outcome


class ConnectedInLockstep(Connected):
    """Connected, whose time goes on by one cycle with each SIP.

    All other packets are taken with the next SIP, so that nothing changes in the midst of the program's turn.
    """

    _marked = -1        # number of SIPs at the newest mark
    _pulse_at = math.inf

    def __init__(self, link: Link, before: OpeningInLockstep, learned: Learned) -> None:
        link.now = link.last_sip = 0.0
        link.has_own_time = True
        link.line.begin_clock(link.now)
        self._held: List[Any] = []
        super().__init__(link, before, learned._replace(time=link.now, sent_time=link.now))

    def take(self, packet: Any, sent_time: float) -> Optional[Outcome]:
        if isinstance(packet, p2os.Reset):
            return super().take(packet, sent_time)
        self._held.append(packet)
        if isinstance(packet, p2os.Sip):
            link, packets, self._held = self._link, self._held, []
            link.now = link.last_sip = round(link.now + self.identity.sip_cycle, DIGITS)
            for each in packets:
                super().take(each, link.now)
        return None

    def end_turn(self) -> None:
        """Send all that waits, and the mark behind it. There is one mark for each SIP at most."""
        link = self._link
        if self._marked != link.sips:
            self._marked = link.sips
            link.line.flush(link.now, MARK)


LOCKSTEP_TRANSITIONS: Dict[Tuple[Type[Phase], type], Callable[[Link, Any, Any], Phase]] = {
    **TRANSITIONS,
    (Synced, Recognised): OpeningInLockstep,
    (OpeningInLockstep, Learned): ConnectedInLockstep,
    (OpeningInLockstep, Left): Closing,
    (OpeningInLockstep, Failed): Finished,
    (ConnectedInLockstep, Left): Finished,
    (ConnectedInLockstep, Failed): Finished,
}
"""The next phase in lockstep, as phases.TRANSITIONS without."""
