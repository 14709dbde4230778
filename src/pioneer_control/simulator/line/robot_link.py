"""One robot with its line: what faults act on."""

from typing import Callable, Optional, Union

from ..firmware import Firmware, RobotOnLine
from ..hardware import Hardware
from ..simulation import Simulation
from .one_way import OneWay

TO_ROBOT, FROM_ROBOT = WAYS = ("to-robot", "from-robot")


RobotsInTime = Union[Simulation, RobotOnLine]
"""Robots that share a simulated time, or one robot alone."""


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
        """Put in a battery of this voltage (V), or with None the robot's own battery again."""
        battery = self.hardware.battery
        if self._own_voltage is None:
            self._own_voltage = battery.voltage
        battery.voltage = self._own_voltage if voltage is None else voltage
        if voltage is None:
            self._own_voltage = None

    def _clear(self) -> None:
        for wire in self.wires.values():
            wire.clear()
