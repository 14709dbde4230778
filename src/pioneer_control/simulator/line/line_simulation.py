"""Robots and their lines in one simulated time. Bytes are delayed by their transmission time, and faults begin and end.

>>> from pioneer_control.robots import find_model
>>> from pioneer_control.simulator.line.faults import fault_of
>>> from pioneer_control.simulator.firmware.firmware import Firmware
>>> from pioneer_control.simulator.world.world_loader import load_world
>>> robot = Firmware(find_model("p3dx-sh"), load_world("empty"))
>>> lines = LineSimulation(robot, faults=[fault_of("silence from 1 to 2")])
>>> lines.send(0, bytes.fromhex("FAFB03000000"), baud=9600)    # SYNC0, six bytes: 6.25 ms there, 6.25 ms back
>>> [(arrival.time_us, arrival.data.hex()) for arrival in lines.advance(0.1)]
[(12500, 'fafb03000000')]

This file uses no threads, no sockets and no real time. The same bytes at the same simulated times, with the same seed,
always give the same answers and the same errors of the line. `Server` runs a `LineSimulation` in real time.
"""

import functools
import heapq
from typing import Callable, List, NamedTuple, Optional, Sequence, Tuple

from ...errors import ParameterError
from ...p2os.framing import SMALLEST_COUNT
from ..carrier import Carrier
from ..clock import NEVER_US
from ..firmware import FirmwareState
from ..simulation import Simulation
from .faults import Fault, Faults
from .one_way import BITS_PER_BYTE
from .robot_link import FROM_ROBOT, TO_ROBOT, RobotLink, RobotsInTime

ID_AT, SCAN_IDS = 3, frozenset((0x60, 0x61))
"""Where a packet has its id, and the ids of packets with scans."""
LONGEST_REST_US = 100000
"""Longest time (microseconds) for which `LineSimulation.news_us` lets the steps of a silent robot be delayed."""
LONGEST_WAIT_US = 100000
"""Longest time (microseconds) that a packet of the robot waits for its busy serial line.

A packet that would have to wait longer is dropped, because the next SIP is due by then.
"""


class Arrival(NamedTuple):
    """Bytes that arrive at a client: number of the robot (from 0), simulated time, baud rate (None for TCP), bytes."""

    robot: int
    time_us: int
    baud: Optional[int]
    data: bytes


class LineSimulation:
    """Robots and their lines, in one simulated time.

    Args:
        simulation: a `Simulation`, to which no robots may be added from now on, or a single robot.
        seed: seed of the random errors of the lines.
        faults: faults of robots and lines. More faults can be added to `LineSimulation.faults` at any time.
        say: function that is called when a fault begins or ends, with the simulated time (s) and a sentence.

    Attributes:
        robots: all robots, in the order of their numbers.
        clock: clock of the simulated time.
        links: all robots with their lines.
        faults: present and future faults of robots and lines.
        ended: numbers (from 0) of robots whose session a CLOSE has ended. The reader of this list empties it.

    Raises:
        ParameterError: a fault is for a robot that does not exist, or there is no robot.
    """

    def __init__(
        self, simulation: RobotsInTime, seed: int = 0, faults: Sequence[Fault] = (),
        say: Callable[[float, str], None] = lambda time, sentence: None,
    ):
        self._simulation = simulation
        self.robots = simulation.robots
        if not self.robots:
            raise ParameterError("there is no robot in the simulation: add one first")
        self.clock, self._say = simulation.clock, say
        self.links = [RobotLink(robot, "%s %s" % (seed, number)) for number, robot in enumerate(self.robots)]
        if isinstance(simulation, Simulation):
            carrier = Carrier(simulation)
            for number, link in enumerate(self.links, 1):
                link.put = functools.partial(carrier.put, number)
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
        """The simulated time (s)."""
        return self.clock.seconds

    @property
    def next_us(self) -> int:
        """The simulated time (microseconds) of the next event: a step, the arrival of bytes, or a change of faults."""
        return min(self._step_us, self._due[0][0] if self._due else NEVER_US, self.faults.next_us)

    @property
    def news_us(self) -> int:
        """A simulated time (microseconds) before which no client can receive bytes, unless a client sends bytes.

        Steps of the simulation may be delayed until then.
        """
        return min(self._news_us, self._due[0][0] if self._due else NEVER_US, self.faults.next_us)

    def send(self, robot: int, data: bytes, baud: Optional[int] = None) -> None:
        """Send bytes from a client to a robot, now. The robot answers over the same line; see `advance`.

        Args:
            robot: number of the robot (from 0).
            data: the bytes.
            baud: baud rate of the serial line, or None for TCP, which takes no time.
        """
        self._serial[robot] = baud is not None and self.robots[robot].line_takes_time
        self._put(robot, TO_ROBOT, data, baud)

    def advance(self, seconds: float) -> List[Arrival]:
        """Let simulated time pass for `seconds`. Return the bytes that arrived at clients, oldest first."""
        return self.run_to(self.clock.after(seconds))

    def run_to(self, end_us: int) -> List[Arrival]:
        """Let simulated time pass until `end_us` (microseconds). Return what arrived at clients, oldest first."""
        clock = self.clock
        while self.next_us <= end_us:
            clock.now_us = max(clock.now_us, self.next_us)
            self.faults.step(clock.now_us)
            if self._step_us <= clock.now_us:
                self._step()
            while self._due and self._due[0][0] <= clock.now_us:
                _, robot, way = heapq.heappop(self._due)
                self._deliver(robot, way)
        clock.now_us = max(clock.now_us, end_us)
        arrived, self._out = self._out, []
        return arrived

    def backlog(self, robot: int) -> float:
        """Return how long (s) the line to a robot (number from 0) is still busy with bytes of its client."""
        return self.links[robot].wires[TO_ROBOT].backlog_us(self.clock.now_us) * 1e-6

    def _next_news(self) -> int:
        return min([robot.next_sip_us for robot in self.robots] + [self.clock.now_us + LONGEST_REST_US])

    def _step(self) -> None:
        """Run the simulation until the next step of its robots, and put the bytes that they send on their lines."""
        self._simulation.run_to(self._step_us)
        for number, robot in enumerate(self.robots):
            data = robot.take_sent()
            if data:
                self._reply(number, data)
        self._step_us = self._simulation.next_step_us
        self._news_us = self._next_news()

    def _put(self, robot: int, way: str, data: bytes, baud: Optional[int]) -> None:
        """Send bytes over one direction of a line. They are lost if its cable is unplugged or the robot is off.

        Args:
            robot: number of the robot (from 0).
            way: direction, one of `WAYS`.
            data: the bytes.
            baud: baud rate of the serial line, or None for TCP.
        """
        link = self.links[robot]
        if link.unplugged or not link.powered:
            return
        wire = link.wires[way]
        waited = wire.next_us != NEVER_US
        wire.send(data, self.clock.now_us, baud)
        if not waited:
            self._deliver(robot, way)

    def _deliver(self, robot: int, way: str) -> None:
        """Deliver the bytes that have arrived over one direction of a line, and schedule its next delivery."""
        wire = self.links[robot].wires[way]
        for burst in wire.arrived(self.clock.now_us):
            if way == TO_ROBOT:
                self._receive(robot, burst.data)
            else:
                self._out.append(Arrival(robot, self.clock.now_us, burst.baud, burst.data))
        if wire.next_us != NEVER_US:
            heapq.heappush(self._due, (wire.next_us, robot, way))

    def _receive(self, robot: int, data: bytes) -> None:
        """Let a robot (number from 0) receive bytes now, and put its answer on its line."""
        self._simulation.run_to(self.clock.now_us)
        firmware = self.robots[robot]
        closed = firmware.closed_sessions
        firmware.receive(data)
        if firmware.closed_sessions != closed and firmware.session is FirmwareState.WAITING:
            self.ended.append(robot)
            self.links[robot].scan.clear()
        data = firmware.take_sent()
        if data:
            self._reply(robot, data)
        self._news_us = min(self._news_us, firmware.next_sip_us)

    def _reply(self, robot: int, data: bytes) -> None:
        """Send packets of a robot (number from 0) to its client. Drop packets that its slow line cannot send in time.

        A scan of a laser is sent whole or not at all, and never instead of a SIP: its packets wait, and go when the
        line has time for one before the next SIP. Until the last one has gone, all later scans are left out.
        """
        if not self._serial[robot]:
            self._put(robot, FROM_ROBOT, data, None)
            return
        link, baud = self.links[robot], self.robots[robot].baud
        scan = []
        while data:
            packet, data = data[:data[2] + SMALLEST_COUNT], data[data[2] + SMALLEST_COUNT:]
            if packet[ID_AT] in SCAN_IDS:
                scan.append(packet)
            elif link.wires[FROM_ROBOT].backlog_us(self.clock.now_us) < LONGEST_WAIT_US:
                self._put(robot, FROM_ROBOT, packet, baud)
        if not link.scan and scan:
            if self._has_time(robot, scan[0]):
                link.scan.extend(scan)
            elif not link.too_slow:
                link.too_slow = True
                self._say(self.time, "robot %d: at %d baud there is no time for scans of its laser beside the SIPs:"
                          " %d bytes in one packet" % (robot + 1, baud, len(scan[0])))
        while link.scan and self._has_time(robot, link.scan[0]):
            self._put(robot, FROM_ROBOT, link.scan.popleft(), baud)

    def _has_time(self, robot: int, packet: bytes) -> bool:
        """Return whether the serial line of a robot (number from 0) can send a packet before the next SIP."""
        now_us, firmware = self.clock.now_us, self.robots[robot]
        busy_us = self.links[robot].wires[FROM_ROBOT].backlog_us(now_us)
        return now_us + busy_us + len(packet) * BITS_PER_BYTE * 1000000 // firmware.baud <= firmware.next_sip_us
