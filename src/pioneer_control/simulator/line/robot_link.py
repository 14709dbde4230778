"""One robot with its line: what faults act on.

And what a line needs to know of a robot, whether simulated or played from a record.
"""

from typing import Callable, Optional, Protocol, Sequence

from ..clock import Clock
from ..firmware.firmware import Firmware, FirmwareState
from ..hardware.hardware import Hardware
from .one_way import OneWay

TO_ROBOT, FROM_ROBOT = WAYS = ("to-robot", "from-robot")


class RobotOnLine(Protocol):
    """A robot, as its line sees it. `Firmware` says what each of these is."""

    name: str
    baud: int
    closed_sessions: int
    line_takes_time: bool

    @property
    def session(self) -> FirmwareState:
        """How far a client has come."""

    @property
    def next_sip_us(self) -> int:
        """When it next sends by itself."""

    def receive(self, data: bytes) -> None:
        """Take bytes from the client."""

    def take_sent(self) -> bytes:
        """Give all that it sent since the last call."""

    def close_session(self) -> None:
        """End the session."""


class RobotsInTime(Protocol):
    """Robots that share a simulated time: a `Simulation`, or one robot alone."""

    clock: Clock

    @property
    def robots(self) -> Sequence[RobotOnLine]:
        """All of them."""

    @property
    def next_step_us(self) -> int:
        """When one of them takes its next step."""

    def run_to(self, end_us: int) -> None:
        """Let simulated time pass for all."""


class RobotLink:
    """One robot with its line.

    Args:
        robot: the robot.
        seed: of the luck on its line.

    Attributes:
        firmware: of a simulated robot, None of a played one.
        wires: both directions of the line, by `WAYS`.
        powered: the robot is switched on.
        unplugged: the cable is pulled out.
        on_cable: told when the cable is pulled out (True) or put back.
    """

    def __init__(self, robot: RobotOnLine, seed: str):
        self.firmware = robot if isinstance(robot, Firmware) else None
        self.wires = {way: OneWay("%s %s" % (seed, way)) for way in WAYS}
        self.powered = True
        self.unplugged = False
        self.on_cable: Callable[[bool], None] = lambda unplugged: None
        self._own_voltage: Optional[float] = None

    @property
    def hardware(self) -> Hardware:
        """The devices of a simulated robot."""
        assert self.firmware is not None, "`Faults.add` refuses faults that a played robot cannot have"
        return self.firmware.hardware

    def unplug(self, unplugged: bool) -> None:
        """Pull the cable out, or put it back."""
        if unplugged != self.unplugged:
            self.unplugged = unplugged
            self._clear()
            self.on_cable(unplugged)

    def set_power(self, on: bool) -> None:
        """Switch the robot on or off."""
        if on != self.powered and self.firmware is not None:
            self.powered = on
            self.firmware.power_cycle()
            self._clear()

    def set_voltage(self, voltage: Optional[float]) -> None:
        """Put a battery of this voltage in; None: the robot's own again."""
        battery = self.hardware.battery
        if self._own_voltage is None:
            self._own_voltage = battery.voltage
        battery.voltage = self._own_voltage if voltage is None else voltage
        if voltage is None:
            self._own_voltage = None

    def _clear(self) -> None:
        for wire in self.wires.values():
            wire.clear()
