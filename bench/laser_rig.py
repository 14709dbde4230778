"""The line of a laser in simulated time: what the node runs on a port, the port, the line with its faults, and a
simulated laser. No thread, no clock and no port of this computer.

A script says what happens: a generator that gets the rig, and yields seconds to let them pass::

    def script(rig):
        yield from rig.until(Measuring)
        rig.cable = False
        yield 60.0

    rig = LaserRig(baud=500000)
    rig.play(script)        # returns when the script is over and the laser was told to stop

The `LaserJudge` looks at each scan that is published: it must be one that the laser has measured, of the time that its
stamp says. The `LaserDiagnosis` keeps what the diagnostics say. test/integration/test_laser.py and test_laser_faults.py
use this file, and bench/laser.py.
"""

import math
import random
from typing import Any, Callable, Generator, List, NamedTuple, Optional, Set, Tuple

from pioneer_control import lms2xx
from pioneer_control.client.fault_flags import Level
from pioneer_control.client.transport import READ_SIZE, Transport
from pioneer_control.errors import LinkLostError, PortError
from pioneer_control.laser.conversion import numbers_of
from pioneer_control.laser.health import LaserHealth
from pioneer_control.laser.line import LaserLine
from pioneer_control.laser.session import ScanHeard
from pioneer_control.laser.settings import LaserSettings
from pioneer_control.simulator.clock import NEVER_US
from pioneer_control.simulator.hardware import LaserNumbers
from pioneer_control.simulator.line.uart import as_heard
from pioneer_control.simulator.lms200 import PERFECT, FirmwareNumbers, LaserFirmware, Optics, moving
from pioneer_control.simulator.world import World, load_world

LIMIT = 1000.0      # s of simulated time that nothing takes
INSTANT = 2e-5      # s that a read takes which waits for nothing
HERE = (1.0, 1.0, 0.3)
"""Pose (m, rad) of the laser in the tutorial's world at the begin."""
TURN = 0.2          # rad/s: it turns all the time, so no scan is like another
QUICK = FirmwareNumbers(boot=0.0)
Script = Generator[float, None, None]


class Measured(NamedTuple):
    """A scan that the laser has measured: when its first ray was fired (s), and what it was."""

    first_ray: float
    scan: lms2xx.RawScan
    variant: lms2xx.Variant
    configuration: lms2xx.Configuration


class LaserRig:
    """A laser, its line, and what the node runs on it.

    Args:
        numbers: how the laser behaves.
        optics: how it measures.
        world: where it stands: a World, or the name of one.
        pose: of the laser at the begin (m, rad).
        turn_rate: of the laser (rad/s).
        seed: of all random numbers.
        step: time (s) between two reads of the port while bytes come.
        url: of the port: a socket has no speed.
        settings: what is asked of the laser.

    Attributes:
        now: the time (s).
        cable: whether bytes get through, in each direction: to the laser, from it.
        plugged: whether the port is there. Without it, it breaks.
        taken: whether another program has the port.
        busy: whether this computer does other things, and reads nothing.
        lost, junk, flips: shares of the bytes, in both directions, that get lost, that have noise behind them, and
            that get one bit wrong.
        events: what the node was told, each with its time.
    """

    def __init__(self, numbers: FirmwareNumbers = QUICK, optics: LaserNumbers = PERFECT, world: Any = "tutorial",
                 pose: Tuple[float, float, float] = HERE, turn_rate: float = TURN, seed: int = 1, step: float = 0.001,
                 url: str = "/dev/lms200", **settings: Any) -> None:
        self.now, self.step = 0.0, step
        self.laser = LaserFirmware(
            Optics(world if isinstance(world, World) else load_world(world), optics, seed),
            moving(pose, 0.0, turn_rate), numbers, seed=seed, fixed_baud=None if url.startswith("/") else 500000)
        self.cable, self.plugged, self.taken, self.busy = [True, True], True, False, False
        self.lost = self.junk = self.flips = 0.0
        self.chance = random.Random(seed)
        self.port: Optional[RigPort] = None
        self.events: List[Tuple[float, Any]] = []
        self.line = LaserLine(url, LaserSettings(**settings), self._hear, self._open, lambda: self.now)
        self.line._ending.wait = self.pass_time     # type: ignore[assignment, method-assign]
        self.judge, self.diagnosis = LaserJudge(self), LaserDiagnosis(self)
        self._script: Optional[Script] = None
        self._resume_at = 0.0
        self._under_way: List[Tuple[int, int, bytes]] = []      # to the laser: time (us), speed (baud), a byte

    def play(self, script: Callable[["LaserRig"], Script]) -> "LaserRig":
        """Run all as the node does, until a script is over."""
        self._script, self._resume_at = script(self), self.now
        self.line.run()
        return self

    # For scripts

    def told(self, kind: type, since: float = 0.0) -> List[Any]:
        """Return the events of a kind, oldest first."""
        return [event for at, event in self.events if isinstance(event, kind) and at >= since]

    def until(self, condition: Any, limit: float = LIMIT) -> Script:
        """Let time pass until a condition holds, or until an event of a kind is told."""
        begin, told = self.now, len(self.events)
        while not (any(isinstance(event, condition) for _, event in self.events[told:])
                   if isinstance(condition, type) else condition()):
            assert self.now - begin < limit, "not within %g s: %s; %s" % (limit, condition, self.events[-3:])
            yield 0.01

    # What the line does

    @property
    def pause(self) -> float:
        """The time (s) that may pass at once: a step, or more while no byte is under way and nothing happens."""
        laser = self.laser
        if self._under_way or laser.sent_at_us < NEVER_US:
            return self.step
        quiet = min(laser.next_event_us * 1e-6, self._resume_at if self._script is not None else math.inf)
        return max(self.step, quiet - self.now)

    def pass_time(self, seconds: float) -> None:
        """Let time pass."""
        self.now += seconds
        now_us = round(self.now * 1e6)
        while self._under_way and self._under_way[0][0] <= now_us:
            at_us, baud, byte = self._under_way.pop(0)
            self.laser.run_to(max(at_us, self.laser.clock.now_us))
            self.laser.receive(byte, baud)
        self.laser.run_to(now_us)
        for sent in self.laser.take_sent_with_speeds():
            if self.port is not None and self.cable[1]:
                self.port.waiting += self.spoilt(as_heard(sent.data, sent.baud, self.port.baud or sent.baud))
        self.diagnosis.look()
        if self._script is not None and self.now >= self._resume_at - self.step / 2.0:
            wait = next(self._script, None)
            self._resume_at = self.now + (wait or 0.0)
            if wait is None:
                self._script = None
                self.line.end()

    def carry(self, data: bytes, baud: Optional[int]) -> None:
        """Carry bytes to the laser, at the speed of the port (baud)."""
        speed = baud or self.laser.baud
        at_us = max(round(self.now * 1e6), self._under_way[-1][0] if self._under_way else 0)
        if self.cable[0]:
            for number, byte in enumerate(self.spoilt(data), 1):
                self._under_way.append((at_us + round(number * 1e7 / speed), speed, bytes((byte,))))

    def spoilt(self, data: bytes) -> bytes:
        """Return bytes with the present faults of the line."""
        if not (self.lost or self.junk or self.flips):
            return data
        spoilt = bytearray()
        for byte in data:
            if self.chance.random() >= self.lost:
                spoilt.append(byte ^ 1 << self.chance.randrange(8) if self.chance.random() < self.flips else byte)
            if self.chance.random() < self.junk:
                spoilt.append(self.chance.getrandbits(8))
        return bytes(spoilt)

    def _open(self, url: str, baud: int) -> "RigPort":
        if not self.plugged or self.taken:
            raise PortError("%s: %s" % (url, "in use by another program" if self.plugged else "no such port"))
        self.port = RigPort(self, url, baud if url.startswith("/") else None)
        return self.port

    def _hear(self, event: Any) -> None:
        self.events.append((self.now, event))
        self.judge.event(event)
        self.diagnosis.event(event)


class RigPort(Transport):
    """The computer's port. Time passes while it is read."""

    def __init__(self, rig: LaserRig, url: str, baud: Optional[int]) -> None:
        super().__init__(url, baud)
        self.waiting = b""
        self._rig, self._woken, self._broken = rig, False, False

    def read(self, timeout: float) -> bytes:
        rig, until = self._rig, self._rig.now + timeout
        first = True
        while first or rig.busy or not (self.waiting or self._woken) and rig.now < until - 1e-9:
            rig.pass_time(max(INSTANT, min(rig.pause, until - rig.now)) if not rig.busy else rig.step)
            first = False
            self._check()
        self._woken = False
        data, self.waiting = self.waiting[:READ_SIZE], self.waiting[READ_SIZE:]
        return data

    def write(self, data: bytes) -> None:
        self._check()
        self._rig.carry(data, self.baud)

    def set_baud(self, baud: int) -> None:
        self._check()
        if self.baud is not None:
            self.baud, self.waiting = baud, b""

    def wake(self) -> None:
        self._woken = True

    def close(self) -> None:
        self._rig.port = None

    def _check(self) -> None:
        self._broken = self._broken or not self._rig.plugged
        if self._broken:
            raise LinkLostError("%s: the line broke: Input/output error" % self.url)


class LaserJudge:
    """Checks each scan that is published.

    Attributes:
        wrongs: what was wrong with a scan, in words.
        late: time (s) by which a stamp may be off, besides the step of the rig and the time of a byte.
        worst: the largest such error so far (s): of the stamp, without sign.
        measured: all scans that the laser has measured.
    """

    def __init__(self, rig: LaserRig) -> None:
        self.wrongs: List[str] = []
        self.late = self.worst = 0.0
        self.measured: List[Measured] = []
        self._rig, self._last = rig, -math.inf
        device = rig.laser.device
        measure = device.scan

        def scan(operation: Any, last_turn: int, values: slice = slice(None)) -> lms2xx.RawScan:
            result = measure(operation, last_turn, values)
            first_us = operation.turn_end_us(last_turn - operation.variant.turns)
            self.measured.append(Measured(first_us * 1e-6, result, operation.variant, device.eeprom.configuration))
            return result

        device.scan = scan      # type: ignore[assignment, method-assign]

    def event(self, event: Any) -> None:
        """Take an event of the line."""
        if not isinstance(event, ScanHeard):
            return
        numbers = numbers_of(event)
        true = next((each for each in reversed(self.measured) if each.scan == event.scan), None)
        if true is None:
            return self._wrong("a scan that the laser has not measured")
        error = numbers.first_ray - true.first_ray
        self.worst = max(self.worst, abs(error))
        if abs(error) > self._rig.step + self.late + lms2xx.time_on_line(1, event.info.baud):
            self._wrong("a stamp that is off by %.4f s" % error)
        if (event.info.variant, event.info.configuration) != (true.variant, true.configuration):
            self._wrong("another setting than the laser has: %s, not %s" % (event.info.variant, true.variant))
        if numbers.first_ray <= self._last:
            self._wrong("a scan that is not newer than the last one")
        self._last = numbers.first_ray
        if len(numbers.ranges) != round((numbers.angle_max - numbers.angle_min) / numbers.angle_increment) + 1:
            self._wrong("%d ranges" % len(numbers.ranges))

    def _wrong(self, what: str) -> None:
        self.wrongs.append("%.3f s: %s" % (self._rig.now, what))


class LaserSaid(NamedTuple):
    """What the diagnostics say; the values as text."""

    level: Level
    message: str
    values: str


class LaserDiagnosis:
    """What the node's diagnostics say, once a second and when something changes.

    Attributes:
        now: what they said last.
        said: all that they said; clear it to begin anew.
    """

    PERIOD = 1.0

    def __init__(self, rig: LaserRig) -> None:
        self.now = LaserSaid(Level.STALE, "", "")
        self.said: Set[LaserSaid] = set()
        self._rig, self._due = rig, 0.0
        self._health = LaserHealth(rig.line.url)

    def event(self, event: Any) -> None:
        """Take an event of the line."""
        if self._health.event(event):
            self._due = self._rig.now

    def look(self) -> None:
        """Report if it is time."""
        if self._rig.now >= self._due:
            self._due = self._rig.now + self.PERIOD
            finding = self._health.report(self._rig.now, self._rig.line.session.counts)
            self.now = LaserSaid(finding.level, finding.message, "; ".join(map(": ".join, finding.values.items())))
            self.said.add(self.now)
