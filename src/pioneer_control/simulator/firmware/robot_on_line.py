"""A robot as its line sees it: simulated (`Firmware`), or played from a record (`PlayedRobot`)."""

from abc import ABC, abstractmethod
from enum import Enum
from typing import List

from ..clock import Clock


class FirmwareState(Enum):
    """How far a client has come."""

    WAITING = "waits for SYNC0, SYNC1, SYNC2"
    SYNCED = "has told its name, waits for OPEN"
    OPEN = "listens to commands, sends SIPs"


class RobotOnLine(ABC):
    """A robot with one serial line. Bytes of a client go in, time passes, bytes of the robot come out.

    Args:
        name: which it tells at SYNC2.
        clock: its time, which it may share with others.
        baud: speed of its serial line.

    Attributes:
        name, clock: as the arguments.
        baud: present speed of its serial line.
        session: how far a client has come.
        closed_sessions: how many sessions have ended.
        next_step_us: when it takes its next step.
    """

    line_takes_time = True
    """Whether its packets take the time that a line takes, on a serial line."""

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
        """When the robot next sends by itself; `NEVER_US` if it does not."""

    @abstractmethod
    def receive(self, data: bytes) -> None:
        """Take bytes from the client, in any pieces, at the present simulated time. Answers come out of `advance`."""

    @abstractmethod
    def run_to(self, end_us: int) -> None:
        """Let simulated time pass until `end_us`; what the robot sends meanwhile is kept for `take_sent`."""

    @abstractmethod
    def close_session(self) -> None:
        """End the session of the client."""

    @property
    def robots(self) -> List["RobotOnLine"]:
        """Itself: a robot that is alone in its world is a simulation of one."""
        return [self]

    def advance(self, seconds: float) -> bytes:
        """Let simulated time pass, for a robot that is alone.

        Args:
            seconds: from 0 up; microseconds count, fractions of them are carried over to the next call.

        Returns:
            Everything the robot sent meanwhile, answers to what it received before included.
        """
        self.run_to(self.clock.after(seconds))
        return self.take_sent()

    def take_sent(self) -> bytes:
        """Give everything that the robot sent since the last call."""
        sent = b"".join(self._sent)
        self._sent.clear()
        return sent
