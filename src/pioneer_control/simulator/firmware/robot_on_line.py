"""The interface between a line and a robot. The robot is simulated (`Firmware`), or played from a recording
(`PlayedRobot`).
"""

from abc import ABC, abstractmethod
from enum import Enum
from typing import List

from ..clock import Clock


class FirmwareState(Enum):
    """State of the connection between a client and the robot: during the handshake, or in an open session."""

    WAITING = "waits for SYNC0, SYNC1, SYNC2"
    SYNCED = "has told its name, waits for OPEN"
    OPEN = "listens to commands, sends SIPs"


class RobotOnLine(ABC):
    """A robot with one serial line. It receives bytes from a client, lets simulated time pass, and sends bytes.

    Args:
        name: name of the robot, which it sends in its answer to SYNC2.
        clock: clock of the simulated time. Several robots may share one clock.
        baud: baud rate of the serial line.

    Attributes:
        name: as the argument.
        clock: as the argument.
        baud: present baud rate of the serial line.
        session: state of the connection with the client.
        closed_sessions: number of sessions that have ended.
        next_step_us: simulated time of the robot's next step (microseconds).
    """

    line_takes_time = True
    """Whether the robot's packets on a serial line are delayed by their transmission time."""

    def __init__(self, name: str, clock: Clock, baud: int):
        self.name = name
        self.clock = clock
        self.baud = baud
        self.session = FirmwareState.WAITING
        self.closed_sessions = 0
        self.next_step_us = clock.now_us
        self._sent: List[bytes] = []

    @property
    @abstractmethod
    def next_sip_us(self) -> int:
        """The time at which the robot next sends without a request (microseconds). `NEVER_US` if it will not send."""

    @abstractmethod
    def receive(self, data: bytes) -> None:
        """Receive bytes from the client, at the present simulated time. `take_sent` and `advance` return the answers.

        A packet may be split over several calls.
        """

    @abstractmethod
    def run_to(self, end_us: int) -> None:
        """Let simulated time pass until `end_us` (microseconds). `take_sent` then returns the bytes that were sent."""

    @abstractmethod
    def close_session(self) -> None:
        """End the session of the client."""

    @property
    def robots(self) -> List["RobotOnLine"]:
        """A list that holds only this robot, so that it can be used like a `Simulation` with one robot."""
        return [self]

    def advance(self, seconds: float) -> bytes:
        """Let simulated time pass, for a robot that is not in a `Simulation`.

        Args:
            seconds: duration, at least 0. A fraction of a microsecond is kept, and added in the next call.

        Returns:
            All bytes that the robot has sent since the last call, with the answers to received commands.
        """
        self.run_to(self.clock.after(seconds))
        return self.take_sent()

    def take_sent(self) -> bytes:
        """Return all bytes that the robot has sent since the last call, and empty the buffer."""
        sent = b"".join(self._sent)
        self._sent.clear()
        return sent
