"""Runs simulated robots in real time, and connects them to clients by TCP or pseudo-terminals.

>>> with Server(firmware, tcp=0) as server:
...     print(server.url)
socket://127.0.0.1:41873

Only this file and `lines` use sockets, terminals and real time.
"""

import contextlib
import functools
import selectors
import socket
import threading
import time
from dataclasses import dataclass, field
from typing import Any, Callable, Dict, List, Optional, Sequence, Set, Union

from ...errors import LinkError, ParameterError
from ...p2os.recording import Entry
from ..firmware import Firmware, FirmwareState, RobotOnLine
from ..simulation import Simulation
from .faults import Fault
from .cameras import CameraBerth, CameraPorts, fit_camera
from .lasers import LASER_UNREAD_LIMIT, LaserBerth, LaserPorts
from .line_recorder import LineRecorder
from .line_simulation import Arrival, LineSimulation
from .lines import CHUNK, PTY_UNREAD_LIMIT, STANDARD_PORT, PtyLine, ServedLine, TcpLine, host_and_port
from .lockstep import Lockstep
from .pace import Pace
from .robot_link import RobotsInTime

PATIENCE = 2.0
"""Real time (s) without bytes from the present client after which a client on the robot's other line may take over."""
LONGEST_BACKLOG = 0.5
"""Longest time (s) for which a serial line may be busy with bytes of the client before reading pauses.

Then further bytes of the client wait in the terminal, like in the buffer of a real serial port.
"""


@dataclass(eq=False)
class Berth:
    """The lines to which the clients of one robot connect.

    Attributes:
        number: number of the robot (from 0).
        robot: the robot.
        pty_link: path of the link to the robot's pseudo-terminal. None without a pseudo-terminal.
        url: URL of the robot's TCP port. None without a TCP port.
        lines: the TCP port and the pseudo-terminal, as far as the robot has them.
        line: line of the present client. None before the first client has sent bytes.
        heard: real time at which the present client last sent bytes (s).
    """

    number: int
    robot: RobotOnLine
    pty_link: Optional[str]
    url: Optional[str] = None
    lines: List[ServedLine] = field(default_factory=list)
    line: Optional[ServedLine] = None
    heard: float = 0.0

    def busy_elsewhere(self, line: ServedLine, now: float) -> bool:
        """Return whether a client on another line than `line` has an active session at the real time `now` (s)."""
        in_session = self.robot.session is not FirmwareState.WAITING
        return self.line not in (None, line) and in_session and now - self.heard < PATIENCE


class Server:
    """Runs simulated robots in real time. Clients connect by TCP or by pseudo-terminals.

    One thread serves all robots. Each robot has one client at a time. When a client ends its session with CLOSE, the
    next client can connect at once. When a client disconnects without CLOSE, the session stays open, as if the cable
    were unplugged. The next client on a pseudo-terminal finds the open session. For the next client over TCP, the
    session is closed and the robot waits for SYNC0, because the vendor's client cannot connect to an open session.
    Bytes on a pseudo-terminal are delayed as on a serial line.

    Args:
        robots: a `Simulation`, or a single robot. While the server runs, use the robots only under `Server.lock`.
        tcp: TCP port on this machine (0 for any free port), or ``"host:port"``, for the first robot. The other robots
            have the next ports. If neither `tcp` nor `pty` is given, `STANDARD_PORT`.
        pty: path of the link to the robot's pseudo-terminal. If there are several robots, the number of the robot (from
            1) is appended.
        speed: simulated seconds per real second, at first.
        seed: seed of the random errors of the lines.
        faults: faults of robots and lines, with times in simulated seconds from the start.
        record: path of a file to which all bytes on the lines are recorded. None for no recording.
        say: function that is called with a sentence when a fault begins or ends, or a client answers too late.
        lockstep: simulated time waits for the client of the only robot, at each SIP, this real time (s) at most; see
            `lockstep`. None: simulated time follows real time.
        lasers: where the clients of the robots' lasers connect. None: robots have no lasers.
        cameras: which cameras the robots have, and where. None: robots have no cameras.

    Raises:
        PortError: a line cannot be opened.
        ParameterError: the speed, a fault or the lockstep is not legal, or the recording cannot be written.
    """

    def __init__(
        self, robots: RobotsInTime, tcp: Union[int, str, None] = None, pty: Optional[str] = None, *, speed: float = 1.0,
        seed: int = 0, faults: Sequence[Fault] = (), record: Optional[str] = None,
        say: Callable[[str], None] = lambda sentence: None, lockstep: Optional[float] = None,
        lasers: Optional[LaserPorts] = None, cameras: Optional[CameraPorts] = None,
    ):
        now_us = robots.clock.now_us
        pace = Pace(speed, now_us) if lockstep is None else Lockstep(lockstep, speed, now_us)
        alone = len(robots.robots) == 1 and isinstance(robots.robots[0], Firmware) and pty is None
        if lockstep is not None and (not alone or lasers is not None or cameras is not None and cameras.has_lines):
            raise ParameterError("lockstep is for one simulated robot on a TCP port: leave out other robots, records,"
                                 " pseudo-terminals, lasers, and cameras with a line of their own")
        if tcp is None and pty is None:
            tcp = STANDARD_PORT
        self.lock = threading.RLock()
        self.pace = pace
        """The speed of the simulated time, and whether it is paused. Change it under `lock`, then call `wake`."""
        self.watched = False
        """Whether other code reads the state of the robots while the server runs.

        If True, no step of the simulation is delayed, which takes more CPU time.
        """
        self._say = say
        self._recording = LineRecorder(None)
        self.simulation = LineSimulation(robots, seed, faults, self._report)
        """The robots with their lines and faults."""
        self.berths: List[Berth] = []
        self.lasers: List[LaserBerth] = []
        """The lasers of the robots, in their order. Empty if they have none."""
        self.cameras: List[CameraBerth] = []
        """The cameras of the robots that have a line of their own, in the order of the robots."""
        self._selector = selectors.DefaultSelector()
        self._watched: Dict[ServedLine, Set[Any]] = {}      # the files of each line that the selector watches
        self._paused: Dict[ServedLine, Berth] = {}          # lines that are not read while they are busy
        self._stopping = threading.Event()
        self._wakers = socket.socketpair()      # a byte into the first one ends the thread's wait at the second one
        self._thread = threading.Thread(target=self._run, name="simulated robots", daemon=True)
        try:
            self._open_berths(tcp, pty)
            if lasers is not None:
                self._open_lasers(robots, lasers, tcp, seed)
            if cameras is not None:
                self._open_cameras(robots, cameras)
            self._recording = LineRecorder(record)
        except (LinkError, ParameterError):
            self._close()
            raise
        for waker in self._wakers:
            waker.setblocking(False)
        self._selector.register(self._wakers[1], selectors.EVENT_READ)
        for berth, link in zip(self.berths, self.simulation.links):
            link.on_cable = functools.partial(self._plug, berth)
            for line in berth.lines:
                self._watch(berth, line)
        for device in self._devices:
            self._watch(device, device.line)

    @property
    def firmware(self) -> Firmware:
        """The first robot, which must be a simulated robot."""
        firmware = self.simulation.links[0].firmware
        assert firmware is not None, "the robot of a record has no firmware"
        return firmware

    @property
    def url(self) -> Optional[str]:
        """The URL of the first robot's TCP port. None if it has no TCP port."""
        return self.berths[0].url

    @property
    def pty_link(self) -> Optional[str]:
        """The path of the link to the first robot's pseudo-terminal. None if it has no pseudo-terminal."""
        return self.berths[0].pty_link

    @property
    def open_to_others(self) -> bool:
        """Whether clients on other machines can connect to a TCP port of this server."""
        return any(isinstance(line, TcpLine) and not line.host.startswith("127.") for line in self._lines)

    def start(self) -> "Server":
        """Start the thread that runs the robots, and return this server."""
        self._thread.start()
        return self

    def stop(self, timeout: float = 2.0) -> None:
        """Stop the thread that runs the robots, and close their lines. Wait at most `timeout` seconds for its end."""
        self._stopping.set()
        if self._thread.is_alive():
            self.wake()
            self._thread.join(timeout)
        else:
            self._close()

    @property
    def running(self) -> bool:
        """Whether the thread that runs the robots is alive."""
        return self._thread.is_alive()

    def wake(self) -> None:
        """Let the thread that runs the robots look at once at what other code has changed: pace, faults or robots."""
        with contextlib.suppress(OSError):      # it has a byte already, or the server is closed
            self._wakers[0].send(b"!")

    def __enter__(self) -> "Server":
        return self.start()

    def __exit__(self, *_: object) -> None:
        self.stop()

    @property
    def _lines(self) -> List[ServedLine]:
        return [line for berth in self.berths for line in berth.lines] + [device.line for device in self._devices]

    @property
    def _devices(self) -> List[Union[LaserBerth, CameraBerth]]:
        """All devices with a line of their own."""
        return [*self.lasers, *self.cameras]

    def _open_berths(self, tcp: Union[int, str, None], pty: Optional[str]) -> None:
        """Open the lines of all robots. For the arguments see `Server`."""
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
                has_laser = isinstance(robot, Firmware) and robot.line_laser is not None
                limit = LASER_UNREAD_LIMIT if has_laser else PTY_UNREAD_LIMIT
                berth.lines.append(PtyLine(link, robot.baud, limit))

    def _open_lasers(self, robots: RobotsInTime, ports: LaserPorts, tcp: Union[int, str, None], seed: int) -> None:
        """Put a laser on each robot, and open its line. For the arguments see `Server`.

        Raises:
            PortError: a line cannot be opened.
            ParameterError: the robots are not simulated.
        """
        if not isinstance(robots, Simulation):
            raise ParameterError("lasers are for simulated robots: a record has nothing of what one would see")
        for number, (robot, link) in enumerate(zip(robots.robots, self.simulation.links)):
            line = ports.line_of(number, len(robots.robots), tcp)
            laser = LaserBerth(robot, robots.world, line, ports, "%s %s" % (seed, number), robots.clock.now_us,
                               functools.partial(link.supplies, "laser"))
            self.lasers.append(laser)
            robots.on_step.append(laser.history.note)

    def _open_cameras(self, robots: RobotsInTime, ports: CameraPorts) -> None:
        """Put a camera on each robot, and open its line, if it has one.

        Raises:
            PortError: a line cannot be opened.
            ParameterError: the robots are not simulated.
        """
        if not isinstance(robots, Simulation):
            raise ParameterError("cameras are for simulated robots: a record has what its own camera said")
        for number, (robot, link) in enumerate(zip(robots.robots, self.simulation.links)):
            if ports.has_lines:
                self.cameras.append(CameraBerth(ports.camera(), ports.line_of(number, len(robots.robots)),
                                                functools.partial(link.supplies, "camera")))
            else:
                fit_camera(robot, ports)

    # -- its thread

    def _run(self) -> None:
        now = time.monotonic()
        self.pace.due_us(now)
        try:
            while not self._stopping.is_set():
                until_us = self.simulation.next_us if self.watched else self.simulation.news_us
                until_us = min([until_us] + [device.next_us for device in self._devices])
                rest = self.pace.rest(until_us)     # from the time at which the last round began
                ready = self._selector.select(rest and max(0.0, now + rest - time.monotonic()))
                with self.lock:
                    now = time.monotonic()
                    self._deliver(self.simulation.run_to(self._due_us(now)), now)
                    for device in self._devices:
                        device.run_to(self.simulation.clock.now_us)
                    for key, _ in ready:
                        if key.fileobj is self._wakers[1]:
                            self._wakers[1].recv(CHUNK)
                        else:
                            berth, line = key.data
                            if isinstance(berth, (LaserBerth, CameraBerth)):
                                berth.hear()
                                self._watch(berth, line)
                            else:
                                self._serve(berth, line, now)
                    self._resume()
        finally:
            self._close()

    def _due_us(self, now: float) -> int:
        """Return the simulated time (microseconds) that is due at the real time `now` (s). Report a late answer."""
        late = self.pace.late_answers
        due_us = self.pace.due_us(now, self.simulation.news_us)
        if self.pace.late_answers != late:
            self._report(self.simulation.time, "the client does not answer in time: simulated time goes on without it")
        return due_us

    def _serve(self, berth: Berth, line: ServedLine, now: float) -> None:
        """Read the bytes that are ready on a line, and let its robot answer. `now` is the real time (s)."""
        line.baud = berth.robot.baud
        clients = line.clients
        data = line.read(berth.busy_elsewhere(line, now))
        if line.clients > clients and berth.robot.session is not FirmwareState.WAITING:
            berth.robot.close_session()
        if data:
            berth.line, berth.heard = line, now
            self._recording.put(Entry(self.simulation.time, berth.number + 1, True, data))
            self.simulation.send(berth.number, data, line.client_baud)
            self.pace.client_sent(data, berth.robot.session is FirmwareState.OPEN, now)
            # Before another client takes the place of this one:
            self._deliver(self.simulation.run_to(self.simulation.clock.now_us), now)
            if line.client_baud and self.simulation.backlog(berth.number) > LONGEST_BACKLOG:
                self._paused[line] = berth
        self._watch(berth, line)

    def _resume(self) -> None:
        """Resume reading from each line on which reading was paused and which is no longer too busy."""
        for line, berth in list(self._paused.items()):
            if self.simulation.backlog(berth.number) <= LONGEST_BACKLOG:
                del self._paused[line]
                self._watch(berth, line)

    def _deliver(self, arrivals: Sequence[Arrival], now: float) -> None:
        """Send to the clients what has arrived at them at the real time `now` (s)."""
        for arrival in arrivals:
            berth = self.berths[arrival.robot]
            if berth.line is not None:
                berth.line.baud = arrival.baud or berth.robot.baud
                self._recording.put(Entry(arrival.time_us * 1e-6, arrival.robot + 1, False, arrival.data))
                berth.line.write(arrival.data)
                self.pace.client_got(arrival.data, now)
                self._watch(berth, berth.line)
        while self.simulation.ended:
            self.pace.session_ended()
            line = self.berths[self.simulation.ended.pop()].line
            if line is not None:
                line.finished = True

    # -- the files that the selector watches

    def _watch(self, berth: Union[Berth, LaserBerth, CameraBerth], line: ServedLine) -> None:
        """Update the files of a line that the selector watches. Watch no files of a line whose reading is paused."""
        before = self._watched.get(line, set())
        now = self._watched[line] = set() if line in self._paused else set(line.files())
        for file in before - now:
            self._selector.unregister(file)     # the file may be closed already
        for file in now - before:
            self._selector.register(file, selectors.EVENT_READ, (berth, line))

    def _plug(self, berth: Berth, unplugged: bool) -> None:
        try:
            for line in berth.lines:
                line.plug(not unplugged)
                self._paused.pop(line, None)
                self._watch(berth, line)
        except LinkError as error:
            self._report(self.simulation.time, str(error))

    def _report(self, time: float, sentence: str) -> None:
        self._recording.put(Entry(time, 0, False, b"", sentence))
        self._say("%.3f s: %s" % (time, sentence))

    def _close(self) -> None:
        for line in self._lines:
            line.close()
        self._selector.close()
        for waker in self._wakers:
            waker.close()
        self._recording.close()
