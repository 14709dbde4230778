"""A simulation and the lines to its robots, in one simulated time: bytes take as long as the line needs, and faults come and go.

>>> from pioneer_control.robots import find_model
>>> from pioneer_control.simulator.line.faults import fault_of
>>> from pioneer_control.simulator.firmware.firmware import Firmware
>>> from pioneer_control.simulator.world.world_loader import load_world
>>> lines = LineSimulation(Firmware(find_model("p3dx-sh"), load_world("empty")), faults=[fault_of("silence from 1 to 2")])
>>> lines.send(0, bytes.fromhex("FAFB03000000"), baud=9600)    # SYNC0, six bytes: 6.25 ms there, 6.25 ms back
>>> [(arrival.time_us, arrival.data.hex()) for arrival in lines.advance(0.1)]
[(12500, 'fafb03000000')]

No thread, clock or socket is in here: the same bytes at the same simulated times, with the same seed, have the same answers
and the same luck. `Server` runs one in real time.
"""

import heapq
import math
from typing import Callable, List, NamedTuple, Optional, Sequence, Tuple, Union

from ...errors import ParameterError
from ...p2os.framing import SMALLEST_COUNT
from .faults import FROM_ROBOT, TO_ROBOT, Fault, Faults, Plant
from ..firmware.firmware import Firmware, FirmwareState
from ..simulation import Simulation

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

    :param simulation: them (`Simulation`, to which no robot is added from now on), or one that is alone in its world (`Firmware`).
    :param seed: of the luck on the lines.
    :param faults: which come; more may be added to `faults` at any time.
    :param say: told of each fault when it begins and ends: simulated seconds, and a sentence.
    :raises ParameterError: a fault of a robot that is not there, or no robot at all.
    """

    def __init__(
        self, simulation: Union[Simulation, Firmware], seed: int = 0, faults: Sequence[Fault] = (),
        say: Callable[[float, str], None] = lambda time, sentence: None,
    ):
        self._simulation = simulation
        self.robots: List[Firmware] = simulation.robots if isinstance(simulation, Simulation) else [simulation]
        if not self.robots:
            raise ParameterError("there is no robot in the simulation: add one first")
        self.plants = [Plant(robot, "%s %s" % (seed, number)) for number, robot in enumerate(self.robots)]
        self.faults = Faults(self.plants, say)
        self.time_us = simulation.time_us
        self.ended: List[int] = []
        """Robots whose session has been ended by CLOSE; whoever cares takes them out."""
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
        return self.time_us / 1e6

    @property
    def next_us(self) -> float:
        """When something happens next that needs no client."""
        return min(self._step_us, self._due[0][0] if self._due else math.inf, self.faults.next_us)

    @property
    def news_us(self) -> float:
        """When a client may next be told something, if none says anything: until then nobody sees whether steps are taken in time or at once."""
        return min(self._news_us, self._due[0][0] if self._due else math.inf, self.faults.next_us)

    def send(self, robot: int, data: bytes, baud: Optional[int] = None) -> None:
        """What a client of a robot (from 0) writes now, at this line speed; None: over TCP, which takes no time.

        The robot's answers go back the same way. What arrives comes out of `advance`.
        """
        self._serial[robot] = baud is not None and self.robots[robot].line_takes_time
        self._put(robot, TO_ROBOT, data, baud)

    def advance(self, seconds: float) -> List[Arrival]:
        """Let simulated time pass. Returns what came to clients meanwhile, oldest first."""
        return self.run_to(self.time_us + round(seconds * 1e6))

    def run_to(self, end_us: int) -> List[Arrival]:
        """Let simulated time pass until `end_us`, as `advance` does."""
        while self.next_us <= end_us:
            self.time_us = max(self.time_us, self.next_us)
            self.faults.step(self.time_us)
            if self._step_us <= self.time_us:
                self._step()
            while self._due and self._due[0][0] <= self.time_us:
                _, robot, way = heapq.heappop(self._due)
                self._take(robot, way)
        self.time_us = max(self.time_us, end_us)
        arrived, self._out = self._out, []
        return arrived

    def backlog(self, robot: int) -> float:
        """How long (s) the line to a robot is busy with what it has been sent."""
        return self.plants[robot].wires[TO_ROBOT].backlog_us(self.time_us) * 1e-6

    def _next_news(self) -> float:
        return min([robot.next_sip_us for robot in self.robots] + [self.time_us + LONGEST_REST_US])

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
        """Bytes begin their way over a wire that is there."""
        plant = self.plants[robot]
        if plant.unplugged or not plant.powered:
            return
        wire = plant.wires[way]
        waited = wire.next_us is not None
        wire.send(data, self.time_us, baud)
        if not waited:
            self._take(robot, way)

    def _take(self, robot: int, way: str) -> None:
        """Hand over what has come out of a wire, and look at it again when more will."""
        wire = self.plants[robot].wires[way]
        for piece in wire.arrived(self.time_us):
            if way == TO_ROBOT:
                self._hear(robot, piece.data)
            else:
                self._out.append(Arrival(robot, self.time_us, piece.baud, piece.data))
        if wire.next_us is not None:
            heapq.heappush(self._due, (wire.next_us, robot, way))

    def _hear(self, robot: int, data: bytes) -> None:
        """Bytes come to the robot, between two steps of its physics."""
        firmware = self.robots[robot]
        firmware.run_to(self.time_us)
        closed = firmware.closed_sessions
        firmware.receive(data)
        if firmware.closed_sessions != closed and firmware.session is FirmwareState.WAITING:
            self.ended.append(robot)
        data = firmware.take_sent()
        if data:
            self._reply(robot, data)
        self._news_us = min(self._news_us, firmware.next_sip_us)

    def _reply(self, robot: int, data: bytes) -> None:
        """Packets of a robot begin their way to its client, as far as a slow line has time for them."""
        if not self._serial[robot]:
            self._put(robot, FROM_ROBOT, data, None)
            return
        wire, baud = self.plants[robot].wires[FROM_ROBOT], self.robots[robot].baud
        while data:
            length = data[2] + SMALLEST_COUNT
            if wire.backlog_us(self.time_us) < LONGEST_WAIT_US:
                self._put(robot, FROM_ROBOT, data[:length], baud)
            data = data[length:]
