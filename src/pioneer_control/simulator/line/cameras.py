"""The simulated cameras of robots: at an auxiliary port of each robot, or on a line of their own.

A camera at an auxiliary port is reached through the robot's own packets. What the robot says of itself does not change.
"""

from typing import Callable, NamedTuple, Optional, Union

from ...errors import ParameterError
from ..firmware import Firmware
from ..firmware.commands import HANDLERS
from ..hardware.camera import CAMERA_CABLINGS, KINDS_OF_CAMERAS, SimulatedCamera
from .lines import PtyLine, ServedLine, TcpLine, host_and_port

AUX_OF_CAMERAS = 1
"""The auxiliary port at which robots have their cameras (camera sheet 1)."""
CAMERA_BAUD = 9600
SENDS = {1: "TTY2", 2: "TTY3", 3: "TTY4"}
"""The command that sends bytes to an auxiliary port, by its number."""


class CameraPorts(NamedTuple):
    """Which cameras robots have, and where.

    Attributes:
        kind: one of `KINDS_OF_CAMERAS`.
        cabling: one of `CAMERA_CABLINGS`.
        aux: number of the auxiliary port, 1 to 3, unless they have lines of their own.
        tcp: TCP port of the first robot's camera (0 for any free port), or ``"host:port"``; the other cameras have the
            next ports. None: none.
        pty: path of the link to a pseudo-terminal. Those of several robots have their numbers at its end. None: none.
    """

    kind: str
    cabling: str = CAMERA_CABLINGS[0]
    aux: int = AUX_OF_CAMERAS
    tcp: Union[int, str, None] = None
    pty: Optional[str] = None

    @property
    def has_lines(self) -> bool:
        """Whether the cameras have lines of their own."""
        return self.tcp is not None or self.pty is not None

    def camera(self) -> SimulatedCamera:
        """Return a camera of this kind."""
        return SimulatedCamera(self.kind, self.cabling == "two_way")

    def line_of(self, number: int, robots: int) -> ServedLine:
        """Open the line of the camera of robot `number` (from 0) of `robots`. Raises PortError if it does not open."""
        if self.pty is not None:
            return PtyLine(self.pty if robots == 1 else "%s%d" % (self.pty, number + 1), CAMERA_BAUD)
        host, port = host_and_port(0 if self.tcp is None else self.tcp)
        return TcpLine("%s:%d" % (host, port + number if port else 0))


class CameraBerth:
    """The camera of one robot on a line of its own.

    Args:
        camera: the camera.
        line: the line. The berth closes it.
        has_power: function that returns whether the robot is switched on.

    Attributes:
        camera, line: as the arguments.
    """

    def __init__(self, camera: SimulatedCamera, line: ServedLine, has_power: Callable[[], bool]):
        self.camera, self.line, self._has_power = camera, line, has_power
        camera.put = line.write

    @property
    def place(self) -> str:
        """Where a client connects: the URL of a TCP port, or the path of a link."""
        return self.line.url if isinstance(self.line, TcpLine) else self.line.link

    @property
    def next_us(self) -> int:
        """The simulated time (microseconds) at which the camera says something."""
        return self.camera.next_us

    def run_to(self, now_us: int) -> None:
        """Let time pass until `now_us` (simulated microseconds)."""
        self.camera.supply(self._has_power())
        self.camera.step(now_us)

    def hear(self) -> None:
        """Read what the client has sent, and let the camera hear it."""
        self.camera.device(self.line.read(False))


def fit_camera(robot: Firmware, ports: CameraPorts) -> None:
    """Put a camera at the auxiliary port of a robot. Raises ParameterError when there is a device already, or when
    clients of its firmware cannot reach this port.
    """
    family = robot.model.firmware_family
    reached = ["%d" % port for port, command in SENDS.items() if HANDLERS[command].known_to(family)]
    if str(ports.aux) not in reached:
        raise ParameterError("a camera at AUX%d (camera_aux): clients of a %s, whose firmware is %s, reach %s; or give"
                             " it a line of its own (camera_port, camera_pty)" % (
                                 ports.aux, robot.model.subtype, family,
                                 "the auxiliary ports %s" % " and ".join(reached) if reached else "no auxiliary port"))
    ports.camera().join(robot.hardware.aux[ports.aux - 1], ports.aux)


def camera_ports(kind: str, cabling: str, aux: int, tcp: Union[int, str, None],
                 pty: Optional[str]) -> Optional[CameraPorts]:
    """Return what the command line and the ROS node say about cameras. None: robots have no cameras.

    Args:
        kind: "none", or one of `KINDS_OF_CAMERAS`.
        cabling, aux: see `CameraPorts`.
        tcp, pty: see `CameraPorts`. None if it is not given.

    Raises:
        ParameterError: there is a port without a camera, or a port and a pseudo-terminal.
    """
    if kind == "none":
        if tcp is not None or pty is not None:
            raise ParameterError("%s is given as the port of a camera, but no camera: give camera vcc4, too"
                                 % (pty if tcp is None else tcp))
        return None
    if tcp is not None and pty is not None:
        raise ParameterError("a camera has one line: give its TCP port (%s) or its pseudo-terminal (%s), not both"
                             % (tcp, pty))
    return CameraPorts(kind, cabling, aux, tcp, pty)


__all__ = ["CAMERA_CABLINGS", "KINDS_OF_CAMERAS", "CameraBerth", "CameraPorts", "camera_ports", "fit_camera"]
