"""Devices that are joined to the robot and reached over its line: a camera on an auxiliary port, the arm.

What such a device says and wants is sans-I/O: it is a LineDevice. LineDevices joins it with a Robot: it passes on the
packets and the time, and sends what the device wants to send. It never holds up the robot's line: commands of a device
wait behind a stop, and take turns with velocities.
"""

import contextlib
import math
import threading
from time import monotonic
from typing import Any, Callable, Iterator, Protocol, Sequence

from ..errors import PioneerError
from .events import LinkDown, PacketReceived, Ready
from .identity import RobotIdentity
from .robot import Robot


class LineDevice(Protocol):
    """What LineDevices needs of a device. ``now`` is monotonic time in s. No method blocks or raises."""

    @property
    def due(self) -> float:
        """Time (s) by which `tick` must be called; infinity when nothing is due."""

    @property
    def ended(self) -> bool:
        """Whether the device needs the line no more, after `end`."""

    @property
    def stops(self) -> Sequence[bytes]:
        """Its packets that stop what moves: they are sent though the line is too slow for more commands."""

    def connected(self, identity: RobotIdentity, now: float) -> None:
        """Begin: the robot is connected, for the first time or once more."""

    def disconnected(self, now: float) -> None:
        """Forget what waits for an answer: the link is gone. What the device did last is not known any more."""

    def packet(self, packet: Any, now: float) -> None:
        """Take a packet of the robot that is not a SIP. Most are not meant for this device."""

    def tick(self, now: float) -> None:
        """Do what time makes due."""

    def end(self, now: float) -> None:
        """Bring the device to rest, because the connection ends soon. `ended` tells when it rests."""

    def take_commands(self) -> Sequence[bytes]:
        """Return the P2OS packets to send now, and forget them."""


class LineDevices:
    """Joins devices with a robot. Create it before `Robot.start`, then call `start`.

    Args:
        robot: the robot whose line the devices use.
        devices: the devices.
        changed: called after each call of a method of a device, with its state settled; it must return soon.
    """

    def __init__(self, robot: Robot, devices: Sequence[LineDevice], changed: Callable[[], None]) -> None:
        self._robot = robot
        self._devices = devices
        self._changed = changed
        self._turn = threading.Condition()
        self._closed = False
        self._thread = threading.Thread(target=self._run, name="line devices", daemon=True)
        if devices:
            robot.listen(None, self._event)

    def start(self) -> None:
        """Start the thread that keeps the time of the devices. Without devices, do nothing."""
        if self._devices:
            self._thread.start()

    @contextlib.contextmanager
    def using(self) -> Iterator[float]:
        """Let the caller command devices in a ``with`` block, and send what they want then. It gets the time (s)."""
        with self._turn:
            yield monotonic()
            self._send()
            self._turn.notify_all()

    def wait_until(self, holds: Callable[[], bool], timeout: float) -> bool:
        """Wait until something holds of a device, for ``timeout`` (s) at most. Return whether it does."""
        with self._turn:
            return self._turn.wait_for(holds, timeout)

    def end(self, timeout: float) -> bool:
        """Bring all devices to rest. Return whether they are, within ``timeout`` (s). The wheels stand already."""
        with self.using() as now:
            for device in self._devices:
                device.end(now)
        return self.wait_until(lambda: all(device.ended for device in self._devices), timeout)

    def close(self) -> None:
        """End the thread."""
        with self._turn:
            self._closed = True
            self._turn.notify_all()

    def _event(self, event: Any) -> None:
        if isinstance(event, (PacketReceived, Ready, LinkDown)):
            with self.using() as now:
                for device in self._devices:
                    if isinstance(event, PacketReceived):
                        device.packet(event.packet, now)
                    elif isinstance(event, Ready):
                        device.connected(event.identity, now)
                    else:
                        device.disconnected(now)

    def _run(self) -> None:
        with self._turn:
            while not self._closed:
                due = min(device.due for device in self._devices)
                self._turn.wait(None if due == math.inf else max(0.0, due - monotonic()))
                now = monotonic()
                for device in self._devices:
                    if now >= device.due:
                        device.tick(now)
                self._send()
                self._turn.notify_all()

    def _send(self) -> None:
        for device in self._devices:
            for command in device.take_commands():
                # no link: LinkDown follows, or came already; or too many commands wait: then it is lost, as any may be
                with contextlib.suppress(PioneerError):
                    self._robot.send(command, stops=command in device.stops)
        self._changed()
