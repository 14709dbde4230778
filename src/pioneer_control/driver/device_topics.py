"""Which devices on the robot have topics and services, and what the driver needs of each: see `DeviceTopics`.

A new kind of device is a class with these methods, in a file of its own, and two lines in `device_topics`.
"""

from typing import Callable, Dict, Protocol, Sequence, Tuple

from ..client import RobotState
from ..client.health import Finding
from ..client.line_devices import LineDevice, LineDevices
from .parameters import DriverParameters
from .requests import Requests


class DeviceTopics(Protocol):
    """The topics, services and diagnostics of a device on the robot."""

    @property
    def line_devices(self) -> Sequence[LineDevice]:
        """The device, if it uses the robot's line. Nothing, if it has a line of its own."""

    @property
    def acts_at_end(self) -> bool:
        """Whether the device has something to do at the end, which takes time."""

    def start(self, devices: LineDevices, requests: Requests) -> None:
        """Begin, before the robot is connected.

        Args:
            devices: the devices on the robot's line.
            requests: it gets the topics and services.
        """

    def changed(self) -> None:
        """Take note that the device may have changed, and tell people what happened. It must return soon."""

    def state(self, state: RobotState) -> None:
        """Take a state of the robot."""

    def finding(self) -> Finding:
        """Return the finding of the device for the diagnostics."""

    def end(self, timeout: float) -> None:
        """Bring a device on a line of its own to rest, within ``timeout`` s, and close its line."""


def device_topics(parameters: DriverParameters, locks: Callable[[], Tuple[str, ...]]) -> Dict[str, DeviceTopics]:
    """Return the topics of each device that the parameters name, by its name in the diagnostics.

    Args:
        parameters: the parameters of the driver.
        locks: function that returns the names of the locks that are set. Then no device moves.
    """
    # A driver without such a device does not load what it needs, which takes a fifth of a start.
    devices: Dict[str, DeviceTopics] = {}
    if parameters.camera is not None:
        from .ptz_topics import PtzTopics
        devices["Camera"] = PtzTopics(parameters, parameters.camera, locks)
    if parameters.arm is not None:
        from .arm_topics import ArmTopics
        devices["Arm"] = ArmTopics(parameters.arm, locks)
    return devices
