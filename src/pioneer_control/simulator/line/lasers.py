"""The simulated lasers of robots, in the time of their robots: where each is, and the line to its client.

A laser sits where the robot's model says, with the robot's true pose, and sees walls, people and other robots. It has a
line of its own, as on a real robot: what the robot says of itself does not change.
"""

from bisect import bisect_right
from typing import Callable, List, NamedTuple, Optional, Union

from ...errors import ParameterError
from ..clock import Clock
from ..firmware import Firmware
from ..firmware.line_laser import laser_place
from ..hardware import LaserNumbers
from ..lms200 import FirmwareNumbers, LaserFirmware, Optics
from ..world import World
from ..world.materials import Material
from ..world.poses import Pose, along_arc, compose
from .lines import PtyLine, ServedLine, TcpLine, host_and_port

OWN_LINE, ROBOTS_LINE = KINDS_OF_LASERS = ("lms200", "line")
"""Lasers of robots: an LMS200 on a line of its own, or scans over the robot's line (`LineLaser`)."""
STANDARD_LASER_PORT = 8102
"""TCP port on which the vendor's client expects the laser of a simulated robot (laser sheet 1.9)."""
NETWORK_BAUD = 500000
"""Speed (baud) of a laser behind a TCP port: such as one at the far end of a bridge from its line to the network. It
stays, whatever a client asks for."""
LASER_UNREAD_LIMIT = 2500
"""Number of unread bytes in the pseudo-terminal of a laser above which all are dropped: three of the longest scans."""
NUMBERS = FirmwareNumbers(boot=1.0)
"""How a served laser behaves. A real one takes 30 s until it is ready, for which nobody wants to wait [inv]."""
KEPT_US = 1000000
"""How long (microseconds) past poses are kept. A scan asks for those of 0.06 s; more after a delay of this process."""


class LaserPorts(NamedTuple):
    """Where the clients of lasers connect: each robot has one laser, and each laser one line.

    Attributes:
        tcp: TCP port of the first robot's laser (0 for any free port), or ``"host:port"``; the other lasers have the
            next ports. None: the first port after those of the robots, or `STANDARD_LASER_PORT` if they have none.
        pty: path of the link to a pseudo-terminal, instead of TCP. Those of several robots have their numbers at its
            end.
        optics: how the lasers measure. None: as the numbers of each robot say (section ``laser`` of ``robot.yaml``).
        numbers: how they behave.
    """

    tcp: Union[int, str, None] = None
    pty: Optional[str] = None
    optics: Optional[LaserNumbers] = None
    numbers: FirmwareNumbers = NUMBERS

    def line_of(self, number: int, robots: int, robots_tcp: Union[int, str, None]) -> ServedLine:
        """Open the line of a laser.

        Args:
            number: number of its robot (from 0).
            robots: number of all robots.
            robots_tcp: TCP port or ``"host:port"`` of the first robot. None if robots have no TCP ports.

        Raises:
            PortError: it cannot be opened.
        """
        if self.pty is not None:
            link = self.pty if robots == 1 else "%s%d" % (self.pty, number + 1)
            return PtyLine(link, unread_limit=LASER_UNREAD_LIMIT)
        if self.tcp is not None:
            host, port = host_and_port(self.tcp)
        elif robots_tcp is not None:
            host, port = host_and_port(robots_tcp)
            port = port and port + robots
        else:
            host, port = host_and_port(STANDARD_LASER_PORT)
        return TcpLine("%s:%d" % (host, port + number if port else 0))


class PoseHistory:
    """The poses of one robot in the last second, one for each step of the simulation.

    Args:
        robot: the robot.
        now_us: the present simulated time (microseconds).
    """

    def __init__(self, robot: Firmware, now_us: int):
        self._robot = robot
        self._times: List[int] = []
        self._poses: List[Pose] = []
        self.note(now_us)

    def note(self, now_us: int) -> None:
        """Keep the present pose. Call this after each step of the robot."""
        self._times.append(now_us)
        self._poses.append(self._robot.true_pose)
        old = bisect_right(self._times, now_us - KEPT_US) - 1
        if old > 0:
            del self._times[:old], self._poses[:old]

    def pose_at(self, seconds: float) -> Pose:
        """Return the pose (m, rad; map frame) at a simulated time (s), also a little after the last step."""
        time_us = seconds * 1e6
        after = bisect_right(self._times, time_us)
        if after == 0:
            return self._poses[0]
        before_us, before = self._times[after - 1], self._poses[after - 1]
        if after == len(self._times):
            speed, turn_rate = self._robot.velocity
            passed = (time_us - before_us) * 1e-6
            return along_arc(before, speed * passed, turn_rate * passed)
        share = (time_us - before_us) / (self._times[after] - before_us)
        x, y, heading = (start + share * (end - start) for start, end in zip(before, self._poses[after]))
        return x, y, heading


class LaserBerth:
    """The laser of one robot, and the line to its client.

    Args:
        robot: the robot.
        world: the world in which it stands.
        line: the line. The berth closes it.
        ports: how lasers measure and behave.
        seed: seed of the laser's errors.
        now_us: the present simulated time (microseconds), at which the laser is switched on.
        has_power: function that returns whether the robot is switched on.

    Attributes:
        line: the line.
        laser: the laser.
        history: the poses of the robot.
    """

    def __init__(self, robot: Firmware, world: World, line: ServedLine, ports: LaserPorts, seed: str, now_us: int,
                 has_power: Callable[[], bool]):
        place = laser_place(robot.model)
        self.line, self._has_power, self._body = line, has_power, robot.hardware.body
        self.history = PoseHistory(robot, now_us)
        mirror = place.x, place.y, 0.0
        optics = Optics(world, ports.optics or robot.numbers.laser, seed, robot.hardware.body, place.upside_down)
        clock = Clock()
        clock.now_us = now_us
        self.laser = LaserFirmware(
            optics, lambda seconds: compose(self.history.pose_at(seconds), mirror), ports.numbers, clock, seed=seed,
            fixed_baud=NETWORK_BAUD if isinstance(line, TcpLine) else None)

    @property
    def place(self) -> str:
        """Where a client connects: the URL of a TCP port, or the path of a link."""
        return self.line.url if isinstance(self.line, TcpLine) else self.line.link

    @property
    def next_us(self) -> int:
        """The simulated time (microseconds) at which `run_to` has something to do, unless a client sends bytes."""
        return min(self.laser.next_event_us, self.laser.sent_at_us)

    def run_to(self, now_us: int) -> None:
        """Let time pass until `now_us` (simulated microseconds), for which the robot's poses are known. Send the client
        what has left the laser.
        """
        if self._has_power():
            self.laser.power_on()       # does nothing to a laser that is on
        else:
            self.laser.power_off()
        self.laser.run_to(now_us)
        self._body.material = Material.LASER if self.laser.is_ready else Material.ROBOT
        for sent in self.laser.take_sent_with_speeds():
            self.line.baud = sent.baud
            self.line.write(sent.data)

    def hear(self) -> None:
        """Read what the client has sent, and let the laser hear it."""
        self.line.baud = self.laser.baud
        data = self.line.read(False)
        if data:
            baud = self.line.client_baud
            self.laser.receive(data, None if baud == self.laser.baud else baud)


def laser_ports(kind: str, tcp: Union[int, str, None], pty: Optional[str]) -> Optional[LaserPorts]:
    """Return what the command line and the ROS node say about lasers. None: no robot has one on a line of its own.

    Args:
        kind: "none", or one of `KINDS_OF_LASERS`.
        tcp: see `LaserPorts`. None if it is not given.
        pty: see `LaserPorts`. None if it is not given.

    Raises:
        ParameterError: there is a port without a laser, or a port and a pseudo-terminal.
    """
    if kind != OWN_LINE:
        if tcp is not None or pty is not None:
            raise ParameterError("%s is given as the port of a laser, but no laser: give laser %s, too, which has a"
                                 " line of its own" % (pty if tcp is None else tcp, OWN_LINE))
        return None
    if tcp is not None and pty is not None:
        raise ParameterError("a laser has one line: give its TCP port (%s) or its pseudo-terminal (%s), not both"
                             % (tcp, pty))
    return LaserPorts(tcp, pty)
