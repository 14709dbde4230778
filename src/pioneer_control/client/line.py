"""Decides when bytes are sent. Robots lose commands that come too fast, and a full serial line delays a stop.

Bytes are given to the operating system only when the line can carry them. So there is never a long queue in front of a
stop. There are two exceptions. First, a busy computer delivers velocities in bunches. So on a fast line a velocity may
be sent a little early, and none of 100 velocities a second is lost. Second, a stop is sent at once.
"""

import math
from collections import deque
from typing import Callable, Deque, List, NamedTuple, Optional, Sequence, Tuple, Union

GAP = 0.004             # s per command: firmware may drop what comes faster than one in 3 to 5 ms (ARCOS manual)
# s by which a velocity may be sent early, so that two velocities go out at once. A STOP behind them is still among six
# commands in a row, and ARIA sends six, too.
AHEAD_OF_ROBOT = 3 * GAP
# s within which the line must carry an early velocity: two velocities at 57600 baud, one at a lower speed.
AHEAD_OF_LINE = 0.007
BITS_PER_BYTE = 10      # start, eight data, stop
LONGEST_QUEUE = 32      # commands that may wait


class SetBaud(NamedTuple):
    """An action: change the speed of the line to ``baud``."""

    baud: int


Action = Union[bytes, SetBaud]
"""What the owner of the line has to do: write these bytes in one piece, or change the line speed."""
Companion = Callable[[float], Sequence[bytes]]
"""A function that returns packets to send in one piece with a velocity. Its argument is the time (monotonic, s)."""


def alone(now: float) -> Sequence[bytes]:
    """Return no packets: the companion of a velocity that is sent alone."""
    return ()


class _Velocity(NamedTuple):
    """A velocity, or a stop after many stops, that waits for the line. From time ``until`` (s) on it is too old."""

    packets: Tuple[bytes, ...]
    until: float
    companion: Companion


class Line:
    """The outgoing half of a connection. After each call ``to_send`` has what is to be sent now.

    A stop is sent at once. Then commands (first in, first out) and the newest velocity are sent in turn. ``now`` is
    monotonic time in s everywhere.

    Args:
        baud: speed of a serial line; None on TCP, where only the robot limits the pace.
        revival: packets that are sent first after a silence of ``watchdog`` s. They are needed because any packet makes
            a robot that its watchdog has stopped obey its old set points again.

    Source: protocol sheet 2.4.
    """

    def __init__(self, baud: Optional[int], revival: Sequence[bytes]) -> None:
        self.baud = baud
        self.byte_time = BITS_PER_BYTE / baud if baud else 0.0
        """Time (s) that the line takes to carry one byte, in either direction; 0 on TCP."""
        self.watchdog = math.inf
        self.last_sent = -math.inf
        self.free_at = -math.inf
        """Time (s) at which all written bytes are carried and the robot can take more (one command in GAP s)."""
        self._carried_at = -math.inf    # when all that was written is carried
        self.to_send: List[Action] = []
        """Actions that are to be carried out now, in order. The session takes them out."""
        self._revival = revival
        self._stopped = False           # no velocity was written since the last stop
        self._commands: Deque[Sequence[bytes]] = deque()
        self._velocity: Optional[_Velocity] = None
        # Velocities and commands take turns: many commands must not delay a velocity, and velocities no commands.
        self._velocity_next = False

    @property
    def due(self) -> float:
        """Time (monotonic, s) at which tick() has something to send; infinity when nothing waits."""
        if self._velocity and self._velocity_has_its_turn:
            ahead = max(0.0, AHEAD_OF_LINE - self.transfer_time(sum(map(len, self._velocity.packets))))
            return max(self._carried_at - ahead, self.free_at - AHEAD_OF_ROBOT)
        return self.free_at if self._commands else math.inf

    @property
    def waiting(self) -> int:
        """Number of commands that wait to be sent. Velocities do not count."""
        return len(self._commands)

    @property
    def full(self) -> bool:
        """Whether LONGEST_QUEUE commands wait, so that another command would come too late."""
        return len(self._commands) >= LONGEST_QUEUE

    def transfer_time(self, count: int) -> float:
        """Return the time (s) that the line takes to carry ``count`` bytes, in either direction; 0 on TCP."""
        return count * self.byte_time

    def begin_clock(self, now: float) -> None:
        """Let another clock begin, at ``now``. The line is idle."""
        self.last_sent = self.free_at = self._carried_at = now

    def set_baud(self, baud: int) -> None:
        """Change the speed of the line (baud), after the actions that are in ``to_send`` already."""
        self.baud, self.byte_time = baud, BITS_PER_BYTE / baud
        self.to_send.append(SetBaud(baud))

    def say(self, data: bytes) -> None:
        """Send these bytes at once, without waiting for the line: for a link that has no time left."""
        self.to_send.append(data)

    def drop(self) -> None:
        """Discard all commands and velocities that wait."""
        self._commands.clear()
        self._velocity = None

    def withdraw(self, *packets: bytes) -> None:
        """Discard a command that waits. ``packets`` are those that were given to command()."""
        self._commands = deque(each for each in self._commands if each != packets)

    def busy(self, now: float) -> bool:
        """Return whether the line still carries written bytes, or the robot still needs its pause (GAP)."""
        return now < self.free_at

    def command(self, now: float, *packets: bytes) -> None:
        """Send packets that belong together in one piece, when it is their turn."""
        self._commands.append(packets)
        self.tick(now)

    def velocity(self, now: float, *packets: bytes, until: float = math.inf, companion: Companion = alone) -> None:
        """Send a velocity now, or as soon as the line allows it. It replaces one that still waits.

        Args:
            until: time (s) from which on the velocity is too old to be sent.
            companion: called when the velocity is written; it returns packets to send with the velocity.
        """
        self._velocity = _Velocity(packets, until, companion)
        self.tick(now)

    def stop(self, now: float, *packets: bytes) -> None:
        """Send these stop packets at once, ahead of all that waits. A velocity that waits is discarded.

        When many stops follow each other, they are sent at the pace of the line.
        """
        self._velocity = None
        if self._stopped and self.busy(now):
            self._velocity = _Velocity(packets, math.inf, alone)
        else:
            self._put(now, packets)
            self._stopped = True

    def tick(self, now: float) -> None:
        """Put what the line can carry now into ``to_send``."""
        if self._velocity and now >= self._velocity.until:      # only after a hold-up of the whole process
            self._velocity = None
        while now >= self.due:
            self._put_next(now)

    def flush(self, now: float, *packets: bytes) -> None:
        """Send all that waits, and these packets behind it, at once: for a robot that waits for nothing else."""
        self.tick(now)
        while self.due < math.inf:
            self._put_next(now)
        self._put(now, packets)

    @property
    def _velocity_has_its_turn(self) -> bool:
        return self._velocity_next or not self._commands

    def _put_next(self, now: float) -> None:
        """Send the velocity or the command whose turn it is. One of them waits."""
        if self._velocity and self._velocity_has_its_turn:
            velocity, self._velocity = self._velocity, None
            self._put(now, (*velocity.packets, *velocity.companion(now)))
            self._stopped = self._velocity_next = False
        else:
            self._put(now, self._commands.popleft())
            self._velocity_next = True

    def _put(self, now: float, packets: Sequence[bytes]) -> None:
        if now - self.last_sent > self.watchdog:
            packets = (*self._revival, *packets)
        data = b"".join(packets)
        seconds = self.transfer_time(len(data))
        self._carried_at = max(now, self._carried_at) + seconds
        self.free_at = max(now, self.free_at) + max(seconds, len(packets) * GAP)
        self.last_sent = now
        self.to_send.append(data)
