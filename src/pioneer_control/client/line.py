"""When bytes may be sent. Robots lose commands that come too fast, and a full serial line delays a stop.

Bytes are given to the operating system only when the line can carry them. So no queue builds up that a stop cannot
overtake. There are two exceptions. A busy computer delivers velocities in a bunch: on a fast line one of them may be
sent a little early, so that none of 100 velocities a second is lost. And a stop is sent at once.
"""

import math
from collections import deque
from typing import Callable, Deque, List, NamedTuple, Optional, Sequence, Tuple, Union

GAP = 0.004             # s per command: firmware may drop what comes faster than one in 3 to 5 ms (ARCOS manual)
# s by which a velocity may be early: so two are sent at once. A STOP behind them is still among six commands in a row,
# as ARIA sends them.
AHEAD_OF_ROBOT = 3 * GAP
# s within which the line must carry an early velocity: two velocities at 57600 baud, one at a lower speed.
AHEAD_OF_LINE = 0.007
BITS_PER_BYTE = 10      # start, eight data, stop
LONGEST_QUEUE = 32      # commands


class SetBaud(NamedTuple):
    """Change the speed of the line."""

    baud: int


Action = Union[bytes, SetBaud]
"""What the owner of the line has to do: write these bytes in one piece, or change the speed."""
Companion = Callable[[float], Sequence[bytes]]
"""Gives the packets that are sent in one piece with a velocity, at this time (s)."""


def alone(now: float) -> Sequence[bytes]:
    """No companion."""
    return ()


class _Velocity(NamedTuple):
    """A velocity that waits for the line, or a stop in a flood of stops. From ``until`` (s) on it is too old."""

    packets: Tuple[bytes, ...]
    until: float
    companion: Companion


class Line:
    """The outgoing half of a connection. What is due now is in ``to_send`` after each call.

    Order: a stop at once; then commands, first come first served, and the newest velocity, in turn. ``now`` is
    monotonic time in s everywhere.

    Args:
        baud: of a serial line; None when only the robot's pace counts.
        revival: packets that are sent first after a silence of ``watchdog`` s: any packet makes a robot that its
            watchdog has stopped obey its old set points again.

    Source: protocol sheet 2.4.
    """

    def __init__(self, baud: Optional[int], revival: Sequence[bytes]) -> None:
        self.baud = baud
        self.byte_time = BITS_PER_BYTE / baud if baud else 0.0
        """How long (s) a byte is under way, in either direction; 0 where there is no line speed (TCP)."""
        self.watchdog = math.inf
        self.last_sent = -math.inf
        self.free_at = -math.inf
        """When the line has carried all that was written, and the robot is ready for more (one command in GAP s)."""
        self._carried_at = -math.inf    # when all that was written is carried
        self.to_send: List[Action] = []
        """What is to be done on the line now, in order. The session takes it."""
        self._revival = revival
        self._stopped = False           # no velocity was written since the last stop
        self._commands: Deque[Sequence[bytes]] = deque()
        self._velocity: Optional[_Velocity] = None
        # a flood of commands must not keep the robot at an old speed, nor velocities hold up commands.
        self._velocity_next = False

    @property
    def due(self) -> float:
        """When tick() has something to write; infinity when nothing waits."""
        if self._velocity and self._velocity_has_its_turn:
            ahead = max(0.0, AHEAD_OF_LINE - self.transfer_time(sum(map(len, self._velocity.packets))))
            return max(self._carried_at - ahead, self.free_at - AHEAD_OF_ROBOT)
        return self.free_at if self._commands else math.inf

    @property
    def waiting(self) -> int:
        """How many commands wait."""
        return len(self._commands)

    @property
    def full(self) -> bool:
        """Whether so many commands wait that one more would come too late."""
        return len(self._commands) >= LONGEST_QUEUE

    def transfer_time(self, count: int) -> float:
        """How long (s) so many bytes are under way, in either direction."""
        return count * self.byte_time

    def set_baud(self, baud: int) -> None:
        """Go on at another line speed."""
        self.baud, self.byte_time = baud, BITS_PER_BYTE / baud
        self.to_send.append(SetBaud(baud))

    def say(self, data: bytes) -> None:
        """Send this at once, behind what is on its way, whatever the line carries: for a link that has no time left."""
        self.to_send.append(data)

    def drop(self) -> None:
        """Forget all that waits."""
        self._commands.clear()
        self._velocity = None

    def withdraw(self, *packets: bytes) -> None:
        """Forget a command wherever it waits."""
        self._commands = deque(each for each in self._commands if each != packets)

    def busy(self, now: float) -> bool:
        """Whether what was written is still on its way, or has come as fast as the robot can take it."""
        return now < self.free_at

    def command(self, now: float, *packets: bytes) -> None:
        """Send packets that belong together, in turn."""
        self._commands.append(packets)
        self.tick(now)

    def velocity(self, now: float, *packets: bytes, until: float = math.inf, companion: Companion = alone) -> None:
        """Send a velocity now, or as soon as the line allows it. It replaces one that still waits.

        Args:
            until: when it is too old to be sent (s).
            companion: is asked when the velocity is written, for packets to send with it.
        """
        self._velocity = _Velocity(packets, until, companion)
        self.tick(now)

    def stop(self, now: float, *packets: bytes) -> None:
        """Send at once, ahead of all that waits; a velocity that waits is forgotten.

        A flood of stops is sent at the pace of the line.
        """
        self._velocity = None
        if self._stopped and self.busy(now):
            self._velocity = _Velocity(packets, math.inf, alone)
        else:
            self._put(now, packets)
            self._stopped = True

    def tick(self, now: float) -> None:
        """Write what the line can carry now."""
        if self._velocity and now >= self._velocity.until:      # only after a hold-up of the whole process
            self._velocity = None
        while now >= self.due:
            if self._velocity and self._velocity_has_its_turn:
                velocity, self._velocity = self._velocity, None
                self._put(now, (*velocity.packets, *velocity.companion(now)))
                self._stopped = self._velocity_next = False
            else:
                self._put(now, self._commands.popleft())
                self._velocity_next = True

    @property
    def _velocity_has_its_turn(self) -> bool:
        return self._velocity_next or not self._commands

    def _put(self, now: float, packets: Sequence[bytes]) -> None:
        if now - self.last_sent > self.watchdog:
            packets = (*self._revival, *packets)
        data = b"".join(packets)
        seconds = self.transfer_time(len(data))
        self._carried_at = max(now, self._carried_at) + seconds
        self.free_at = max(now, self.free_at) + max(seconds, len(packets) * GAP)
        self.last_sent = now
        self.to_send.append(data)
