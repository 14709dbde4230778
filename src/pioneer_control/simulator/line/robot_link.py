"""One robot with its line, on which faults act."""

import math
from collections import deque
from typing import Callable, Deque, Optional, Set, Union

from ...errors import ParameterError
from ..firmware import Firmware, RobotOnLine
from ..hardware import Hardware
from ..simulation import Simulation
from ..world.poses import Pose
from .one_way import OneWay

TO_ROBOT, FROM_ROBOT = WAYS = ("to-robot", "from-robot")


RobotsInTime = Union[Simulation, RobotOnLine]
"""All robots of a `Simulation`, or a single robot."""


def _nobody_is_there(pose: Pose) -> None:
    raise ParameterError("nobody is there to carry a robot that is in no Simulation")


class RobotLink:
    """One robot with its line, on which faults act.

    Args:
        robot: the robot, simulated or played from a recording.
        seed: seed of the random errors of the line.

    Attributes:
        firmware: the robot, if it is simulated. None for a robot that is played from a recording.
        wires: both directions of the line, by their names in `WAYS`.
        powered: whether the robot is switched on.
        unplugged: whether the cable is unplugged.
        put: function that puts the robot at a pose (m, rad; map frame), or raises a ParameterError.
        scan: packets of a scan of a `LineLaser` that wait for a serial line, oldest first.
        too_slow: whether a scan found no time on the line. It is said once.
        on_cable: function that is called with True when the cable is unplugged, with False when it is plugged in.
    """

    def __init__(self, robot: RobotOnLine, seed: str):
        self.firmware = robot if isinstance(robot, Firmware) else None
        self.wires = {way: OneWay("%s %s" % (seed, way)) for way in WAYS}
        self.powered = True
        self.unplugged = False
        self.scan: Deque[bytes] = deque()
        self.too_slow = False
        self.on_cable: Callable[[bool], None] = lambda unplugged: None
        self.put: Callable[[Pose], None] = _nobody_is_there
        self._own_voltage: Optional[float] = None
        self._unsupplied: Set[str] = set()      # devices whose supply has failed

    @property
    def hardware(self) -> Hardware:
        """The devices of the robot, which must be a simulated robot."""
        assert self.firmware is not None, "`Faults.add` refuses faults that a played robot cannot have"
        return self.firmware.hardware

    def unplug(self, unplugged: bool) -> None:
        """Unplug the cable or plug it in. If this is a change, drop all bytes on the line and call `on_cable`."""
        if unplugged != self.unplugged:
            self.unplugged = unplugged
            self._clear()
            self.on_cable(unplugged)

    def set_power(self, on: bool) -> None:
        """Switch the robot on or off. If this is a change, the robot restarts, and all bytes on the line are lost."""
        if on != self.powered and self.firmware is not None:
            self.powered = on
            self.firmware.power_cycle()
            self._clear()

    def supplies(self, device: str) -> bool:
        """Return whether a device on the robot has power: "laser" or "camera", each with a line of its own."""
        return self.powered and device not in self._unsupplied

    def supply(self, device: str, on: bool) -> None:
        """Let the supply of a device fail, "laser" or "camera", or give it power again."""
        (self._unsupplied.discard if on else self._unsupplied.add)(device)
        if device == "camera":
            self.hardware.supply_camera(on)

    def carry(self, place: Pose) -> None:
        """Carry the robot to x, y (m) and heading (degrees) in the map frame.

        Raises:
            ParameterError: something is in its way there. The robot stays where it is.
        """
        self.put((place[0], place[1], math.radians(place[2])))

    def set_voltage(self, voltage: Optional[float]) -> None:
        """Replace the battery by one with this voltage (V). None puts back the robot's own battery."""
        battery = self.hardware.battery
        if self._own_voltage is None:
            self._own_voltage = battery.voltage
        battery.voltage = self._own_voltage if voltage is None else voltage
        if voltage is None:
            self._own_voltage = None

    def _clear(self) -> None:
        self.scan.clear()
        for wire in self.wires.values():
            wire.clear()
