"""A client's session, a simulated robot, and a line between them that can have faults, in one simulated time.

There is no thread, no clock and no ROS: a `Rig` runs as fast as the machine allows, and the same seed gives the same
run. A user gives commands, or stops giving them. A `Judge` checks the wire, the robot and its states in every step, and
lists what was wrong. `Diagnosis` keeps what the driver's diagnostics would say.
soak.py and test/integration/test_faults.py use this file.
"""

import math
import os
import random
import sys
from collections import deque
from typing import Any, Callable, Deque, Dict, Iterator, List, NamedTuple, Optional, Sequence, Set, Tuple

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "src"))

from pioneer_control import p2os
from pioneer_control.client.drive import MotorsRequest
from pioneer_control.client.events import LinkDown, MotionCleared, Ready
from pioneer_control.client.health import Health
from pioneer_control.client.line import BITS_PER_BYTE, LONGEST_QUEUE, SetBaud
from pioneer_control.client.odometry import Odometry
from pioneer_control.client.robot import LinkCounts
from pioneer_control.client.session import Counts, Session
from pioneer_control.client.settings import Settings
from pioneer_control.client.state import RobotState
from pioneer_control.client.threads import BACK_OFF
from pioneer_control.errors import LinkError, LinkLostError, PioneerError, PortError
from pioneer_control.p2os.framing import SMALLEST_COUNT
from pioneer_control.robots import find_model
from pioneer_control.simulator.firmware import Firmware
from pioneer_control.simulator.world import World

STEP = 0.01             # s between two steps of the rig
COMMAND_TIMEOUT = 0.6   # s, of the session
REACTION = 0.1          # s after the time-out, at most, until zero velocity is on the wire
WATCHDOG = 2.0          # s, of the robot
SETTLED = 0.15          # s that a packet and a step of physics may take
LINEAR_FALL = 0.3       # m/s^2 with which the simulated robot comes to rest
ANGULAR_FALL = math.radians(100)
SAME = 0.5              # s within which a repeated fault is counted once
WAITING = 0.3           # s that a whole packet may wait behind bytes that look like a longer one
LONGEST_GAP = 7000      # steps between two states: a minute of silence, and what it takes to connect again
# m that a robot on TCP may move before the next connection: one that was left open and is not heard hears SYNC0 first,
# and to an open robot this is PULSE (docs/driver.md).
STIR = 0.06
JITTER = 0.004          # m or rad by which a reported step may exceed the true one: rounding to the units of the wire

Fault = Callable[[bytes], Sequence[bytes]]
"""From a packet to the pieces of it that arrive, in order; none when it is lost."""


def whole(packet: bytes) -> Sequence[bytes]:
    """The packet as it is."""
    return (packet,)


def lost(packet: bytes) -> Sequence[bytes]:
    """Nothing of the packet."""
    return ()


def packets_in(data: bytes) -> Iterator[bytes]:
    """Split bytes, which must be whole packets, into these."""
    while data:
        length = data[2] + SMALLEST_COUNT
        yield data[:length]
        data = data[length:]


class Way:
    """One direction of the line.

    Args:
        chance: draws the noise.
    """

    def __init__(self, chance: random.Random) -> None:
        self.fault: Fault = whole
        self.delay = 0.0                    # s, on top of the time of transfer
        self.baud: Optional[int] = None     # of the side that sends; None: no line speed
        self._chance = chance
        self._free_at = 0.0
        self._under_way: Deque[Tuple[float, int, bytes]] = deque()

    def send(self, data: bytes, now: float) -> None:
        """Begin to carry whole packets."""
        for packet in packets_in(data):
            if self.baud is not None:
                self._free_at = max(now, self._free_at) + len(packet) * BITS_PER_BYTE / self.baud
            for piece in self.fault(packet):
                self._under_way.append((max(now, self._free_at) + self.delay, self.baud, piece))

    def arrived(self, now: float, baud: Optional[int]) -> List[bytes]:
        """The pieces that have arrived, as a receiver at ``baud`` hears them."""
        pieces = []
        while self._under_way and self._under_way[0][0] <= now:
            _, sent_at, piece = self._under_way.popleft()
            pieces.append(piece if sent_at == baud else self._garbled(piece, sent_at, baud))
        return pieces

    def backlog(self, now: float) -> float:
        """Seconds until everything sent so far has left the sender."""
        return max(0.0, self._free_at - now)

    def clear(self) -> None:
        """Drop what is under way."""
        self._under_way.clear()
        self._free_at = 0.0

    def _garbled(self, piece: bytes, sent_at: int, baud: int) -> bytes:
        """What a receiver at another line speed hears: noise, as many bytes as its own speed gives."""
        return bytes(self._chance.randrange(256) for _ in range(max(1, len(piece) * baud // sent_at)))


class Velocity(NamedTuple):
    """m/s forward, rad/s counter-clockwise."""

    linear: float
    angular: float


class Rig:
    """A user, a client, a line and a robot.

    Args:
        firmware: the robot; a p3dx-sh on an endless floor if None.
        baud: line speeds of the client's port and of the robot; None for TCP.
        seed: of all random numbers.
        settings: of the session.
    """

    def __init__(self, firmware: Optional[Firmware] = None, baud: Optional[Tuple[int, int]] = None, seed: int = 0,
                 **settings: Any) -> None:
        self.chance = random.Random(seed)
        self.firmware = firmware or Firmware(find_model("p3dx-sh"), World("floor"), (0.0, 0.0, 0.0), seed=seed)
        self.to_robot, self.to_client = Way(self.chance), Way(self.chance)
        self.to_robot.baud, self.to_client.baud = baud or (None, None)
        self.now = 0.0
        self.plugged = True
        self.commanding: Optional[Velocity] = None
        self.commands_per_step = 0.1        # 10 Hz
        self.state: Optional[RobotState] = None
        self.states = 0
        self.events: Deque[Any] = deque(maxlen=100)
        self.session: Optional[Session] = None
        self.judge = Judge(self)
        self.diagnosis = Diagnosis(self)
        self._settings = Settings(command_timeout=COMMAND_TIMEOUT, **settings)
        self._commands_due = 0.0
        self._odometry: Optional[Odometry] = None
        self._past = Counts()
        self._connect_at = 0.0
        self._connect()

    @property
    def ready(self) -> bool:
        """Whether commands are accepted."""
        return self.session is not None and self.session.connected is not None

    @property
    def counts(self) -> Counts:
        """The counts of all sessions so far, added up."""
        present = self.session.counts if self.session is not None else Counts()
        return Counts(*(past + more for past, more in zip(self._past, present)))

    def heard(self, kind: type) -> List[Any]:
        """The recent events of a kind."""
        return [event for event in self.events if isinstance(event, kind)]

    # What the user does

    def command(self, velocity: Velocity) -> None:
        """Command one velocity. Without a link nothing happens, as in Robot."""
        if self.ready:
            self.session.connected.drive.set_velocity(*velocity, self.now)
            self.judge.commanded(velocity)
            self._act()

    def request_motors(self, on: bool) -> Optional[MotorsRequest]:
        """Ask for motors on or off once; None without a link."""
        if not self.ready:
            return None
        request = self.session.connected.drive.request_motors(on, self.now, 2.0)
        self.judge.asked_for_motors(on, request)
        self._act()
        return request

    def switch_motors_on(self, limit: float = 10.0) -> None:
        """Ask until the motors are on."""
        end = self.now + limit
        request = None
        while not (request is not None and request.done and request.error is None):
            if self.now > end:
                raise AssertionError("motors did not come on within %g s: %s" % (limit, request and request.error))
            if request is None or request.done:
                request = self.request_motors(True)
            self.step()

    # Faults

    def mend(self) -> None:
        """Repair the line."""
        self.plugged = True
        for way in (self.to_robot, self.to_client):
            way.fault, way.delay = whole, 0.0

    def pull(self) -> None:
        """Pull the cable; the computer notices."""
        self.plugged = False
        self.to_robot.clear()
        self.to_client.clear()
        self.session.fail(LinkLostError("rig: the line broke: Input/output error"))

    def kill(self, down_for: float = 0.0) -> None:
        """Kill the client without any farewell, and start it again after so many seconds."""
        self.judge.killed()
        self._past, self._odometry, self.session = self.counts, None, None
        self.diagnosis = Diagnosis(self)
        self._connect_at = self.now + down_for

    # Time

    def run(self, seconds: float) -> None:
        """Let time pass."""
        end = self.now + seconds - STEP / 2
        while self.now < end:
            self.step()

    def run_until(self, condition: Callable[[], bool], limit: float = 20.0) -> float:
        """Seconds until the condition holds; AssertionError when it takes longer than ``limit`` s."""
        start = self.now
        while not condition():
            if self.now - start >= limit:
                phase = self.session and type(self.session.phase).__name__
                last = list(self.events)[-5:]
                raise AssertionError("not within %g s; session is %s, events %s" % (limit, phase, last))
            self.step()
        return self.now - start

    def step(self) -> None:
        """Advance everything by STEP seconds."""
        self._give_commands()
        for piece in self.to_robot.arrived(self.now, self.to_client.baud):
            self.firmware.receive(piece)
            self.judge.arrived(piece)
        sent = self.firmware.advance(STEP)
        self.now += STEP
        if self.plugged:
            self.to_client.send(sent, self.now)
        if self.session is None:
            if self.now >= self._connect_at:
                self._connect()
        else:
            self._serve()
        self.judge.look()
        self.diagnosis.look()

    def _give_commands(self) -> None:
        self._commands_due += self.commands_per_step
        while self._commands_due >= 1.0:
            self._commands_due -= 1.0
            if self.commanding is not None:
                self.command(self.commanding)

    def _serve(self) -> None:
        """Do what Robot's I/O thread does: receive, tick, send, tell; connect again after a pause."""
        session = self.session
        for piece in self.to_client.arrived(self.now, session.line.baud):
            session.receive(piece, self.now)
        session.tick(self.now)
        if session.wake_at <= self.now:
            self.judge.wrong("a thread would spin")
        self._act()
        for event in session.events():
            self._tell(event)
        if session.finished:
            self._past, self._odometry, self.session = self.counts, session.phase.odometry, None
            if session.error is not None:
                self._try_again_after(session.error)

    def _tell(self, event: Any) -> None:
        if isinstance(event, RobotState):
            self.judge.reported(event)
            self.state = event
            self.states += 1
        else:
            self.judge.happened(event)
            self.events.append(event)
        self.diagnosis.heard(event)

    def _act(self) -> None:
        for action in self.session.data_to_send():
            if isinstance(action, SetBaud):
                self.to_robot.baud = action.baud
                continue
            self.judge.wrote(action)
            if self.plugged:
                self.to_robot.send(action, self.now)

    def _connect(self) -> None:
        if not self.plugged:
            self._try_again_after(PortError("rig: no such port"))
            return
        given = self.to_robot.baud
        others = tuple(rate for rate in (9600, 38400, 19200, 115200, 57600) if rate != given)
        rates = () if given is None else (given,) + others
        self.session = Session("rig", rates, self._settings, self.now, self._odometry)
        self.to_client.clear()

    def _try_again_after(self, error: PioneerError) -> None:
        pause = BACK_OFF if isinstance(error, LinkError) else math.inf
        self._connect_at = self.now + pause
        self._tell(LinkDown(error, pause))


class Said(NamedTuple):
    """What one diagnostics task says; its values as text."""

    task: str
    level: int
    message: str
    values: str


class Diagnosis:
    """What the driver's diagnostics say, once a second and when a level changes, as driver.diagnostics does.

    Attributes:
        now: what all tasks said last.
        said: everything that any task said; clear it to begin anew.
    """

    PERIOD = 1.0

    def __init__(self, rig: Rig) -> None:
        self.now: List[Said] = []
        self.said: Set[Said] = set()
        self._rig = rig
        self._health = Health("rig", rig.to_robot.baud, "rosservice call set_motors true")
        self._due = 0.0
        self._links = 0
        self._last_error: Optional[str] = None

    def heard(self, event: Any) -> None:
        """Take in a state or an event of the client."""
        if isinstance(event, RobotState):
            changed = self._health.state(event)
        else:
            self._links += isinstance(event, Ready)
            self._last_error = str(event.error) if isinstance(event, LinkDown) else self._last_error
            changed = self._health.event(event)
        if changed:
            self._due = 0.0

    def look(self) -> None:
        """At the end of every step."""
        now = self._rig.now
        if now < self._due:
            return
        self._due = now + self.PERIOD
        counts = LinkCounts(*self._rig.counts, reconnects=max(0, self._links - 1), last_error=self._last_error)
        self.now = [Said(task, finding.level, finding.message, "; ".join(map(": ".join, finding.values.items())))
                    for task, finding in self._health.report(now, counts).items()]
        self.said.update(self.now)


class Judge:
    """Checks every step, and lists what must not happen.

    Attributes:
        lossy: whether stops may get lost. Then only the robot's watchdog limits how long it drives on.
        late: seconds by which a packet may be late, besides the time that the decoder waits for the rest of one.
        wrongs: the first hundred things that were wrong, each with its time.
    """

    def __init__(self, rig: Rig) -> None:
        self.lossy = False
        self.late = 0.0
        self.wrongs: List[str] = []
        self._last: Dict[str, float] = {}
        self.bytes_written = 0
        self.distance = 0.0                         # m that the body has really moved
        self.turned = 0.0                           # rad that it has really turned
        self._rig = rig
        self._commanded_at = -math.inf
        self._void_at = -math.inf                   # older set points are void
        self._stand_by = 0.0                        # when the robot must stand at the latest
        self._heard_at = 0.0                        # when the robot last heard something
        self._on_wire = {"VEL": 0, "RVEL": 0}
        self._fastest = {"VEL": 0, "RVEL": 0}       # since it stood
        self._stirred = 0.0                         # m that it moved against all rules since the last connection
        self._request: Optional[MotorsRequest] = None
        self._may_be_on = False
        self._were_on = False
        self._true_pose = rig.firmware.true_pose
        # in the last steps
        self._covered: Deque[Tuple[float, float]] = deque([(0.0, 0.0)] * LONGEST_GAP, maxlen=LONGEST_GAP)
        self._pose: Optional[Tuple[float, float, float]] = None
        self._pose_at = 0.0

    def wrong(self, what: str, how: str = "") -> None:
        """List something that is wrong, unless the same was wrong a moment ago."""
        now = self._rig.now
        if now > self._last.get(what, -math.inf) + SAME and len(self.wrongs) < 100:
            self.wrongs.append("%.2f s: %s %s" % (now, what, how))
        self._last[what] = now

    # What the rig tells the judge

    def commanded(self, velocity: Velocity) -> None:
        """The session accepted a velocity."""
        self._commanded_at = self._rig.now
        self._stand_by = self._rig.now + COMMAND_TIMEOUT + REACTION

    def asked_for_motors(self, on: bool, request: MotorsRequest) -> None:
        """The user asked for motors on or off."""
        self._request, self._may_be_on = (request, True) if on else (None, False)

    def killed(self) -> None:
        """The client is dead and writes nothing more. The robot drives on until its watchdog stops it."""
        self._on_wire = {"VEL": 0, "RVEL": 0}
        self._stand_by = self._rig.now + WATCHDOG
        self._void_at, self._request, self._pose = self._rig.now, None, None

    def happened(self, event: Any) -> None:
        """The robot lost its motors, or the link broke: older commands are void."""
        if isinstance(event, (MotionCleared, LinkDown)):
            self._void_at = self._rig.now
        if isinstance(event, LinkDown):
            self._request = None
        if isinstance(event, Ready):
            self._stirred = 0.0

    def wrote(self, data: bytes) -> None:
        """The session sent these bytes."""
        now = self._rig.now
        self.bytes_written += len(data)
        for packet in packets_in(data):
            command = p2os.decode_command(p2os.Frame(packet[3], packet[4:-2]))
            if command.name in self._on_wire:
                self._on_wire[command.name] = command.value
                self._fastest[command.name] = max(abs(command.value), self._fastest[command.name])
                is_old = now > self._commanded_at + COMMAND_TIMEOUT + REACTION
                if command.value and (is_old or self._commanded_at < self._void_at):
                    self.wrong("a velocity that nobody wants any more", "%s %s" % (command.name, command.value))
            elif command.name == "STOP":
                self._on_wire = {"VEL": 0, "RVEL": 0}
            elif command.name == "ENABLE" and command.value and (self._request is None or self._request.done):
                self.wrong("motors switched on by itself")

    def arrived(self, data: bytes) -> None:
        """Bytes reached the robot."""
        self._heard_at = self._rig.now

    def reported(self, state: RobotState) -> None:
        """The client reported a state: check that the pose moved no farther than the body."""
        self._follow_the_body()
        now, pose = self._rig.now, (state.x, state.y, state.heading)
        if self._pose is not None:
            step = math.hypot(pose[0] - self._pose[0], pose[1] - self._pose[1])
            turn = abs(math.remainder(pose[2] - self._pose[2], 2 * math.pi))
            steps_ago = (now - self._pose_at + self.late + WAITING) / STEP
            distance, turned = self._covered[-min(len(self._covered), math.ceil(steps_ago) + 2)]
            if step > self.distance - distance + JITTER or turn > self.turned - turned + JITTER:
                self.wrong("the pose jumps", "from %s to %s" % (self._pose, pose))
        self._pose, self._pose_at = pose, now

    def look(self) -> None:
        """At the end of every step."""
        rig, now = self._rig, self._rig.now
        self._follow_the_body()
        self._covered.append((self.distance, self.turned))
        if any(self._on_wire.values()) and now > self._commanded_at + COMMAND_TIMEOUT + REACTION + STEP:
            self.wrong("no zero velocity on the wire", "the last command is %.2f s old" % (now - self._commanded_at))
        moving = rig.firmware.velocity != (0.0, 0.0)
        if not moving and not any(self._on_wire.values()):
            self._fastest = {"VEL": 0, "RVEL": 0}
        to_stand = min(self._stand_by + WATCHDOG * self.lossy, self._heard_at + WATCHDOG)
        if moving and now > to_stand + self._rest_time() + SETTLED:
            self._stirred += self.distance - self._covered[-2][0]
            is_excused = rig.to_robot.baud is None and (rig.session is None or rig.session.connected is None)
            if not is_excused or self._stirred > STIR:
                self.wrong("it moves", str(rig.firmware.velocity))
        on = rig.firmware.motors_enabled
        if on and not self._were_on and not self._may_be_on:
            self.wrong("motors are on, and nobody asked")
        if self._were_on and not on:
            self._may_be_on = False
        self._were_on = on
        if rig.session is not None:
            if rig.session.line.waiting > LONGEST_QUEUE:
                self.wrong("commands wait", str(rig.session.line.waiting))
            if rig.to_robot.backlog(now) > REACTION:
                self.wrong("bytes wait in the line", "%.2f s" % rig.to_robot.backlog(now))

    def _follow_the_body(self) -> None:
        before, pose = self._true_pose, self._rig.firmware.true_pose
        self.distance += math.hypot(pose[0] - before[0], pose[1] - before[1])
        self.turned += abs(pose[2] - before[2])
        self._true_pose = pose

    def _rest_time(self) -> float:
        """Seconds that the robot needs to stop from the highest velocity that it was told since it last stood."""
        return self._fastest["VEL"] / 1000 / LINEAR_FALL + math.radians(self._fastest["RVEL"]) / ANGULAR_FALL
