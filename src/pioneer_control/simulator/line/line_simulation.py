"""A simulation and the lines to its robots, in one simulated time: bytes take as long as the line needs, and faults
come and go.

>>> from pioneer_control.robots import find_model
>>> from pioneer_control.simulator.line.faults import fault_of
>>> from pioneer_control.simulator.firmware.firmware import Firmware
>>> from pioneer_control.simulator.world.world_loader import load_world
>>> lines = LineSimulation(Firmware(find_model("p3dx-sh"), load_world("empty")), faults=[fault_of("silence from 1 to
2")])
>>> lines.send(0, bytes.fromhex("FAFB03000000"), baud=9600)    # SYNC0, six bytes: 6.25 ms there, 6.25 ms back
>>> [(arrival.time_us, arrival.data.hex()) for arrival in lines.advance(0.1)]
[(12500, 'fafb03000000')]

No thread, clock or socket is in here: the same bytes at the same simulated times, with the same seed, have the same
answers and the same luck. `Server` runs one in real time.
"""

import heapq
from typing import Callable, List, NamedTuple, Optional, Sequence, Tuple

from ...errors import ParameterError
from ...p2os.framing import SMALLEST_COUNT
from ..clock import NEVER_US
from ..firmware import FirmwareState
from .faults import Fault, Faults
from .robot_link import FROM_ROBOT, TO_ROBOT, RobotLink, RobotsInTime

LONGEST_REST_US = 100000
"""So long a robot that tells its client nothing is left alone."""
LONGEST_WAIT_US = 100000
"""A packet that the robot's serial line could begin with only so much later is skipped: the next SIP is due by then."""


class Arrival(NamedTuple):
    """Bytes that come to a client: of which robot (from 0), when, and sent at what line speed (None: TCP)."""

    robot: int
    time_us: int
    baud: Optional[int]
    data: bytes


class LineSimulation:
    """Robots with their lines.

    Args:
        simulation: the robots: a `Simulation`, to which no robot is added from now on, or one robot that is alone in
            its world.
        seed: of the luck on the lines.
        faults: which come; more may be added to `faults` at any time.
        say: told of each fault when it begins and ends: simulated seconds, and a sentence.

    Attributes:
        robots: all robots, in the order of their numbers.
        clock: their time.
        links: each robot with its line.
        faults: of the robots and their lines.
        ended: numbers (from 0) of robots whose session a CLOSE has ended; the reader of this list empties it.

    Raises:
        ParameterError: a fault of a robot that is not there, or no robot at all.
    """

    def __init__(
        self, simulation: RobotsInTime, seed: int = 0, faults: Sequence[Fault] = (),
        say: Callable[[float, str], None] = lambda time, sentence: None,
    ):
        self._simulation = simulation
        self.robots = simulation.robots
        if not self.robots:
            raise ParameterError("there is no robot in the simulation: add one first")
        self.clock = simulation.clock
        self.links = [RobotLink(robot, "%s %s" % (seed, number)) for number, robot in enumerate(self.robots)]
        self.faults = Faults(self.links, say)
        self.ended: List[int] = []
        self._serial = [False] * len(self.robots)
        self._due: List[Tuple[int, int, str]] = []
        self._out: List[Arrival] = []
        self._step_us = simulation.next_step_us
        self._news_us = self._next_news()
        for fault in faults:
            self.faults.add(fault)

    @property
    def time(self) -> float:
        """Simulated seconds."""
        return self.clock.seconds

    @property
    def next_us(self) -> int:
        """The time of the next event that no client causes: a step, bytes that arrive, or a fault."""
        return min(self._step_us, self._due[0][0] if self._due else NEVER_US, self.faults.next_us)

    @property
    def news_us(self) -> int:
        """Until this time no client can get anything, unless one sends something: steps may be put off until then."""
        return min(self._news_us, self._due[0][0] if self._due else NEVER_US, self.faults.next_us)

    def send(self, robot: int, data: bytes, baud: Optional[int] = None) -> None:
        """Send a robot what its client writes now.

        The robot's answers go back the same way. What arrives at the client comes out of `advance`.

        Args:
            robot: its number (from 0).
            data: the bytes.
            baud: speed of the line; None: over TCP, which takes no time.
        """
        self._serial[robot] = baud is not None and self.robots[robot].line_takes_time
        self._put(robot, TO_ROBOT, data, baud)

    def advance(self, seconds: float) -> List[Arrival]:
        """Let simulated time pass. Returns what came to clients meanwhile, oldest first."""
        return self.run_to(self.clock.after(seconds))

    def run_to(self, end_us: int) -> List[Arrival]:
        """Let simulated time pass until `end_us`, as `advance` does."""
        clock = self.clock
        while self.next_us <= end_us:
            clock.now_us = max(clock.now_us, self.next_us)
            self.faults.step(clock.now_us)
            if self._step_us <= clock.now_us:
                self._step()
            while self._due and self._due[0][0] <= clock.now_us:
                _, robot, way = heapq.heappop(self._due)
                self._take(robot, way)
        clock.now_us = max(clock.now_us, end_us)
        arrived, self._out = self._out, []
        return arrived

    def backlog(self, robot: int) -> float:
        """How long (s) the line to a robot is busy with what it has been sent."""
        return self.links[robot].wires[TO_ROBOT].backlog_us(self.clock.now_us) * 1e-6

    def _next_news(self) -> int:
        return min([robot.next_sip_us for robot in self.robots] + [self.clock.now_us + LONGEST_REST_US])

    def _step(self) -> None:
        """One step of the physics of all robots, and what they sent at its end."""
        self._simulation.run_to(self._step_us)
        for number, robot in enumerate(self.robots):
            data = robot.take_sent()
            if data:
                self._reply(number, data)
        self._step_us = self._simulation.next_step_us
        self._news_us = self._next_news()

    def _put(self, robot: int, way: str, data: bytes, baud: Optional[int]) -> None:
        """Let bytes begin their way over a line, if its cable is plugged in and the robot switched on."""
        link = self.links[robot]
        if link.unplugged or not link.powered:
            return
        wire = link.wires[way]
        waited = wire.next_us != NEVER_US
        wire.send(data, self.clock.now_us, baud)
        if not waited:
            self._take(robot, way)

    def _take(self, robot: int, way: str) -> None:
        """Hand over what has come out of one direction of a line, and note when more will come out."""
        wire = self.links[robot].wires[way]
        for burst in wire.arrived(self.clock.now_us):
            if way == TO_ROBOT:
                self._hear(robot, burst.data)
            else:
                self._out.append(Arrival(robot, self.clock.now_us, burst.baud, burst.data))
        if wire.next_us != NEVER_US:
            heapq.heappush(self._due, (wire.next_us, robot, way))

    def _hear(self, robot: int, data: bytes) -> None:
        """Give bytes to a robot, between two steps of its physics."""
        self._simulation.run_to(self.clock.now_us)
        firmware = self.robots[robot]
        closed = firmware.closed_sessions
        firmware.receive(data)
        if firmware.closed_sessions != closed and firmware.session is FirmwareState.WAITING:
            self.ended.append(robot)
        data = firmware.take_sent()
        if data:
            self._reply(robot, data)
        self._news_us = min(self._news_us, firmware.next_sip_us)

    def _reply(self, robot: int, data: bytes) -> None:
        """Let packets of a robot begin their way to its client. Those that a slow line has no time for are skipped."""
        if not self._serial[robot]:
            self._put(robot, FROM_ROBOT, data, None)
            return
        wire, baud = self.links[robot].wires[FROM_ROBOT], self.robots[robot].baud
        while data:
            length = data[2] + SMALLEST_COUNT
            if wire.backlog_us(self.clock.now_us) < LONGEST_WAIT_US:
                self._put(robot, FROM_ROBOT, data[:length], baud)
            data = data[length:]
