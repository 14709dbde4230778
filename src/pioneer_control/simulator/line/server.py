"""Runs simulated robots in real time and connects them to clients.

>>> with Server(firmware, tcp=0) as server:
...     print(server.url)
socket://127.0.0.1:41873

All sockets, terminals and clocks of the computer are here and in `lines`.
"""

import functools
import selectors
import threading
import time
from dataclasses import dataclass, field
from typing import Any, Callable, Dict, List, Optional, Sequence, Set, Union

from ...errors import LinkError, ParameterError
from ...p2os.recording import Entry
from ..firmware import Firmware, FirmwareState, RobotOnLine
from .faults import Fault
from .line_recorder import LineRecorder
from .line_simulation import Arrival, LineSimulation
from .lines import ServedLine, PtyLine, TcpLine, host_and_port
from .robot_link import RobotsInTime

STANDARD_PORT = 8101
"""The TCP port on which a Pioneer's clients expect a simulator (protocol 2.1)."""
LONGEST_LAG = 0.25
"""Simulated time (s) that is made up for after a hold-up; what is beyond it never happens in the simulation."""
PATIENCE = 2.0
"""Real silence (s) after which a client on one line gives way to a client on the other."""
LONGEST_BACKLOG = 0.5
"""When the line is busy for so long (s) with what the client wrote to its terminal, the rest waits there, as in the
computer's own buffer.
"""
SPEEDS = (0.01, 100.0)
"""Legal real-time factors."""


@dataclass(eq=False)
class Berth:
    """Where the clients of one robot connect.

    Attributes:
        number: of the robot (from 0).
        robot: the robot.
        pty_link: path of the link to its pseudo-terminal, None without one.
        url: of its TCP port, None without one.
        lines: those two, as far as they are there.
        line: that of the present client, None before the first one.
        heard: when that client was last heard (real s).
    """

    number: int
    robot: RobotOnLine
    pty_link: Optional[str]
    url: Optional[str] = None
    lines: List[ServedLine] = field(default_factory=list)
    line: Optional[ServedLine] = None
    heard: float = 0.0

    def busy_elsewhere(self, line: ServedLine, now: float) -> bool:
        """Whether a client on another line is in the middle of a session."""
        in_session = self.robot.session is not FirmwareState.WAITING
        return self.line not in (None, line) and in_session and now - self.heard < PATIENCE


class Server:
    """Simulated robots that clients can connect to, by TCP, by a pseudo-terminal, or by either.

    One thread serves all robots, each one client at a time. A client that ends its session with CLOSE makes room for
    the next one at once. A client that vanishes leaves the robot open, as a pulled cable would. On a terminal the next
    client finds it so. Over TCP it finds a robot that waits for SYNC0: the vendor's client cannot connect to an open
    one. A terminal takes the time that a serial line takes.

    Args:
        robots: a `Simulation`, or one robot that is alone in its world. While the server runs, touch them only under
            `lock`.
        tcp: port of this machine (0: any free one), or ``"host:port"``, for the first robot, the ports after it for
            the others; `STANDARD_PORT` if `pty` is not given either.
        pty: path of a link to be made to a pseudo-terminal; with several robots each one's number (from 1) is put
            behind it.
        speed: how many simulated seconds pass in a real one.
        seed: of the luck on the lines.
        faults: which come, times in simulated seconds from the start.
        record: file to which everything is written that goes over the lines.
        say: told of each fault when it begins and ends.

    Raises:
        PortError: a line cannot be opened.
        ParameterError: a speed or a fault is not legal, or the record cannot be written.
    """

    def __init__(
        self, robots: RobotsInTime, tcp: Union[int, str, None] = None, pty: Optional[str] = None, *, speed: float = 1.0,
        seed: int = 0, faults: Sequence[Fault] = (), record: Optional[str] = None,
        say: Callable[[str], None] = lambda sentence: None,
    ):
        if not SPEEDS[0] <= speed <= SPEEDS[1]:
            raise ParameterError("speed %r is not legal: give a number from %g to %g" % (speed, *SPEEDS))
        if tcp is None and pty is None:
            tcp = STANDARD_PORT
        self.lock = threading.RLock()
        self.speed = speed
        self.watched = False
        """Whether somebody looks at the robots also between what they send: then no step of theirs is put off, at some
        cost.
        """
        self._say = say
        self._recording = LineRecorder(None)
        self.simulation = LineSimulation(robots, seed, faults, self._tell)
        """The robots, their lines and faults."""
        self.berths: List[Berth] = []
        self._selector = selectors.DefaultSelector()
        self._watched: Dict[ServedLine, Set[Any]] = {}      # the files of each line that are waited for
        self._held_up: Dict[ServedLine, Berth] = {}         # not read until they have carried what was read
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._run, name="simulated robots", daemon=True)
        try:
            self._open_berths(tcp, pty)
            self._recording = LineRecorder(record)
        except (LinkError, ParameterError):
            self._close()
            raise
        for berth, link in zip(self.berths, self.simulation.links):
            link.on_cable = functools.partial(self._plug, berth)
            for line in berth.lines:
                self._watch(berth, line)

    @property
    def firmware(self) -> Firmware:
        """The first robot, where it is a simulated one."""
        firmware = self.simulation.links[0].firmware
        assert firmware is not None, "the robot of a record has no firmware"
        return firmware

    @property
    def url(self) -> Optional[str]:
        """Of the first robot's TCP port, None without one."""
        return self.berths[0].url

    @property
    def pty_link(self) -> Optional[str]:
        """Path of the link to the first robot's pseudo-terminal, None without one."""
        return self.berths[0].pty_link

    @property
    def open_to_others(self) -> bool:
        """Whether other machines may connect."""
        return any(isinstance(line, TcpLine) and not line.host.startswith("127.") for line in self._lines)

    def start(self) -> "Server":
        """Let time pass, in a thread."""
        self._thread.start()
        return self

    def stop(self, timeout: float = 2.0) -> None:
        """Switch the robots off, close their lines and wait, at most `timeout` seconds, until that is done."""
        self._stopping.set()
        if self._thread.is_alive():
            self._thread.join(timeout)
        else:
            self._close()

    @property
    def running(self) -> bool:
        """Whether time passes for the robots."""
        return self._thread.is_alive()

    def __enter__(self) -> "Server":
        return self.start()

    def __exit__(self, *_: object) -> None:
        self.stop()

    @property
    def _lines(self) -> List[ServedLine]:
        return [line for berth in self.berths for line in berth.lines]

    def _open_berths(self, tcp: Union[int, str, None], pty: Optional[str]) -> None:
        """Open the lines of all robots."""
        host, port = host_and_port(tcp) if tcp is not None else ("", 0)
        for number, robot in enumerate(self.simulation.robots):
            link = "%s%d" % (pty, number + 1) if pty is not None and len(self.simulation.robots) > 1 else pty
            berth = Berth(number, robot, link)
            self.berths.append(berth)
            if tcp is not None:
                line = TcpLine("%s:%d" % (host, port + number if port else 0))
                berth.url = line.url
                berth.lines.append(line)
            if link is not None:
                berth.lines.append(PtyLine(link, robot.baud))

    # -- its thread

    def _run(self) -> None:
        last = time.monotonic()
        target_us = float(self.simulation.clock.now_us)
        try:
            while not self._stopping.is_set():
                until_us = self.simulation.next_us if self.watched else self.simulation.news_us
                ready = self._selector.select(max(0.0, (until_us - target_us) * 1e-6 / self.speed))
                with self.lock:
                    now = time.monotonic()
                    target_us += min((now - last) * self.speed, LONGEST_LAG) * 1e6
                    last = now
                    self._deliver(self.simulation.run_to(int(target_us)))
                    for key, _ in ready:
                        berth, line = key.data
                        self._serve(berth, line, now)
                    self._let_go()
        finally:
            self._close()

    def _serve(self, berth: Berth, line: ServedLine, now: float) -> None:
        """Read from a line that has something, and let its robot answer."""
        line.baud = berth.robot.baud
        clients = line.clients
        data = line.read(berth.busy_elsewhere(line, now))
        if line.clients > clients and berth.robot.session is not FirmwareState.WAITING:
            berth.robot.close_session()
        if data:
            berth.line, berth.heard = line, now
            self._recording.put(Entry(self.simulation.time, berth.number + 1, True, data))
            self.simulation.send(berth.number, data, line.client_baud)
            # Before another client takes the place of this one:
            self._deliver(self.simulation.run_to(self.simulation.clock.now_us))
            if line.client_baud and self.simulation.backlog(berth.number) > LONGEST_BACKLOG:
                self._held_up[line] = berth
        self._watch(berth, line)

    def _let_go(self) -> None:
        """Read again from the lines that have carried what was read from them."""
        for line, berth in list(self._held_up.items()):
            if self.simulation.backlog(berth.number) <= LONGEST_BACKLOG:
                del self._held_up[line]
                self._watch(berth, line)

    def _deliver(self, arrivals: Sequence[Arrival]) -> None:
        for arrival in arrivals:
            berth = self.berths[arrival.robot]
            if berth.line is not None:
                berth.line.baud = arrival.baud or berth.robot.baud
                self._recording.put(Entry(arrival.time_us * 1e-6, arrival.robot + 1, False, arrival.data))
                berth.line.write(arrival.data)
                self._watch(berth, berth.line)
        while self.simulation.ended:
            line = self.berths[self.simulation.ended.pop()].line
            if line is not None:
                line.finished = True

    # -- what is waited for

    def _watch(self, berth: Berth, line: ServedLine) -> None:
        """Wait from now on for the files that a line has now; for none of a line that is held up."""
        before = self._watched.get(line, set())
        now = self._watched[line] = set() if line in self._held_up else set(line.files())
        for file in before - now:
            self._selector.unregister(file)     # it may be closed already
        for file in now - before:
            self._selector.register(file, selectors.EVENT_READ, (berth, line))

    def _plug(self, berth: Berth, unplugged: bool) -> None:
        try:
            for line in berth.lines:
                line.plug(not unplugged)
                self._held_up.pop(line, None)
                self._watch(berth, line)
        except LinkError as error:
            self._tell(self.simulation.time, str(error))

    def _tell(self, time: float, sentence: str) -> None:
        self._recording.put(Entry(time, 0, False, b"", sentence))
        self._say("%.3f s: %s" % (time, sentence))

    def _close(self) -> None:
        for line in self._lines:
            line.close()
        self._selector.close()
        self._recording.close()
