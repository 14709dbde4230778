"""The robot's side of P2OS, without I/O: bytes of a client go in, simulated time passes, bytes of the robot come out.

>>> from pioneer_control.robots import find_model
>>> from pioneer_control.simulator.world import load_world
>>> robot = Firmware(find_model("p3dx-sh"), load_world("empty"))
>>> robot.receive(bytes.fromhex("FAFB03000000"))    # SYNC0
>>> robot.advance(0.1).hex()
'fafb03000000'

No thread, clock of the computer or socket is in here: the same bytes at the same simulated times, with the same seed,
give the same answer however the time is split.
"""

from enum import Enum
from typing import Callable, Dict, Iterator, List, Mapping, NamedTuple, Optional, Set, Tuple

from ... import p2os
from ...errors import ParameterError
from ...p2os import SYNC0, SYNC2, Frame, FrameDecoder, ReceivedCommand
from ...robots import RobotModel
from ..clock import NEVER_US, Clock
from ..hardware.gripper import ParallelGripper
from ..hardware.hardware import Hardware
from ..hardware.robot_numbers import RobotNumbers, standard_numbers
from ..world.geometry import Pose
from ..world.world import World
from . import reports
from .commands import HANDLERS, SETTINGS

PARTIAL_TIMEOUT_US = round(p2os.PARTIAL_TIMEOUT * 1e6)


class FirmwareState(Enum):
    """How far a client has come."""

    WAITING = "waits for SYNC0, SYNC1, SYNC2"
    SYNCED = "has told its name, waits for OPEN"
    OPEN = "listens to commands, sends SIPs"


class CommandCounts(NamedTuple):
    """What became of the commands of clients, since power-on."""

    obeyed: int = 0
    unknown: int = 0
    senseless: int = 0


class OpenSession:
    """What is known of a client while its session is open.

    Attributes:
        last_command_us: when its last command came.
        next_sip_us: when the next SIP is due.
        previous: its command before the present one.
        requests: kinds of packets that it asked for; the value says whether they come with every SIP, not with the
            next one only.
    """

    def __init__(self, now_us: int, next_sip_us: int):
        self.last_command_us = now_us
        self.next_sip_us = next_sip_us
        self.previous: Optional[ReceivedCommand] = None
        self.requests: Dict[str, bool] = {}

    def packets(self, hardware: Hardware) -> Iterator[object]:
        """The SIP that is due, and the packets that go out before and behind it."""
        yield from self._requested(reports.BEFORE_SIP, hardware)
        yield reports.sip(hardware)
        yield from self._requested(reports.BEHIND_SIP, hardware)
        for port, aux in enumerate(hardware.aux, 1):
            data = aux.take()
            if data is not None:
                yield p2os.SerialAux(port, data)

    def _requested(self, kinds: Mapping[str, Callable[[Hardware], object]], hardware: Hardware) -> Iterator[object]:
        """Those of some kinds of packets that the client asked for. What it asked for once is forgotten then."""
        for kind in [kind for kind in kinds if kind in self.requests]:
            yield kinds[kind](hardware)
            if not self.requests[kind]:
                del self.requests[kind]


class Firmware:
    """A simulated robot, as its serial line shows it.

    Args:
        model: which robot.
        world: the world it stands in.
        pose: where it stands (x, y, heading: m, rad; map frame); the first start of the world if None.
        gripper: whether it has one; None: if ``robot.yaml`` fits one to this model.
        rear_sonar: whether the rear array is fitted.
        name: which it tells at SYNC2.
        seed: of the noise.
        noise: every sonar range is off by up to this much (m); None: as ``robot.yaml`` says.
        numbers: other numbers than those of ``robot.yaml``.
        clock: the time of the simulation it is in, for a robot among others (see `Simulation`).

    Attributes:
        hardware: its devices.
        settings: what a client may set and CONFIGpac shows.
        baud: present speed of its serial line.
        closed_sessions: how many sessions have ended.
        next_step_us: when it takes its next step.
        decoder: of what the line brings; it has the counts since power-on.
        unknown_commands: names of commands that came and that its firmware does not know.

    Raises:
        ParameterError: a gripper on a model that cannot carry one, a place in a wall, or a negative noise.
    """

    line_takes_time = True
    """On a serial line its packets take the time that a line takes."""

    def __init__(
        self, model: RobotModel, world: World, pose: Optional[Pose] = None, *, gripper: Optional[bool] = None,
        rear_sonar: bool = True, name: str = "sim_0001", seed: int = 0, noise: Optional[float] = None,
        numbers: Optional[RobotNumbers] = None, clock: Optional[Clock] = None,
    ):
        self.numbers = numbers or standard_numbers()
        if gripper is None:
            gripper = model.subtype in self.numbers.gripper.fitted_by_default
        if noise is None:
            noise = self.numbers.sonar.noise
        if noise < 0.0:
            raise ParameterError("noise is %g, wanted metres from 0 up" % noise)
        self.model = model.with_arrays(front=True, rear=rear_sonar)
        self.world = world
        self.name = name
        start = world.starts[0] if pose is None else pose
        self.hardware = Hardware(self.model, world, start, gripper, self.numbers, noise, seed)
        self.clock = clock or Clock()
        self.settings = dict(SETTINGS)
        self.baud = self.numbers.session.host_baud
        self.closed_sessions = 0
        self.next_step_us = self.clock.now_us + self.numbers.physics.step_us
        self.unknown_commands: Set[str] = set()
        self._booted_us = 0
        self._next_sync: Optional[int] = SYNC0      # None: it waits for OPEN
        self._open: Optional[OpenSession] = None
        self.decoder = FrameDecoder()
        self._last_byte_us = self.clock.now_us
        self._counts = CommandCounts()
        self._sent: List[bytes] = []

    # -- the line and the clock

    def receive(self, data: bytes) -> None:
        """Take bytes from the client, in any pieces, at the present simulated time. Answers come out of `advance`."""
        if self.clock.now_us < self._booted_us:
            return
        self._last_byte_us = self.clock.now_us
        for frame in self.decoder.feed(data):
            self._take(frame)

    def advance(self, dt: float) -> bytes:
        """Let `dt` seconds of simulated time pass, for a robot that is alone.

        Args:
            dt: seconds, from 0 up; microseconds count, fractions of them are carried over to the next call.

        Returns:
            Everything the robot sent meanwhile, answers to what it received before included.
        """
        self.run_to(self.clock.after(dt))
        return self.take_sent()

    @property
    def robots(self) -> List["Firmware"]:
        """Itself: a robot that is alone in its world is a simulation of one."""
        return [self]

    def run_to(self, end_us: int) -> None:
        """Let simulated time pass until `end_us`; what the robot sends meanwhile is kept for `take_sent`."""
        while self.next_step_us <= end_us:
            self.clock.now_us = self.next_step_us
            self.step()
        self.clock.now_us = end_us

    def step(self) -> None:
        """Take the step that is due now."""
        now_us = self.clock.now_us
        self.next_step_us += self.numbers.physics.step_us
        if now_us - self._last_byte_us >= PARTIAL_TIMEOUT_US and self.decoder.waiting:
            for frame in self.decoder.drop_partial():
                self._take(frame)
        self.hardware.step(now_us, self.watchdog_expired)
        session = self._open
        if session is not None and now_us >= session.next_sip_us:
            session.next_sip_us += self.numbers.session.sip_cycle_ms * 1000
            for packet in session.packets(self.hardware):
                self.send(packet)

    @property
    def next_sip_us(self) -> int:
        """When it next sends by itself; never without a session."""
        return NEVER_US if self._open is None else self._open.next_sip_us

    def take_sent(self) -> bytes:
        """Give everything that the robot sent since the last call."""
        if not self._sent:
            return b""
        sent, self._sent = b"".join(self._sent), []
        return sent

    # -- what tests, benches and nodes may look at

    @property
    def session(self) -> FirmwareState:
        """How far a client has come."""
        if self._open is not None:
            return FirmwareState.OPEN
        return FirmwareState.SYNCED if self._next_sync is None else FirmwareState.WAITING

    @property
    def time(self) -> float:
        """Simulated seconds: of the `Simulation` it is in, else since power-on."""
        return self.clock.seconds

    @property
    def true_pose(self) -> Pose:
        """Where the robot stands (x, y, heading; map frame; the heading is not wrapped)."""
        return self.hardware.body.pose

    @property
    def internal_counts(self) -> Tuple[int, int]:
        """The robot's own x and y in counts of the wire, before they wrap to 15 bits."""
        return reports.counts(self.hardware)

    @property
    def velocity(self) -> Tuple[float, float]:
        """Present translation (m/s) and rotation (rad/s)."""
        return self.hardware.drives.linear.speed, self.hardware.drives.angular.speed

    @property
    def motors_enabled(self) -> bool:
        """Whether the motors have power."""
        return self.hardware.motors.enabled

    @property
    def contacts(self) -> int:
        """How often the body has run into a wall or a post."""
        return self.hardware.body.contacts

    @property
    def gripper(self) -> Optional[ParallelGripper]:
        """The gripper, None without one."""
        return self.hardware.gripper

    @property
    def command_counts(self) -> CommandCounts:
        """Commands since power-on: obeyed, unknown, without a value that makes sense."""
        return self._counts

    @property
    def previous(self) -> Optional[ReceivedCommand]:
        """The command before the present one, in this session."""
        return None if self._open is None else self._open.previous

    @property
    def watchdog_expired(self) -> bool:
        """Whether an open session has been silent for so long that the drives stand until the next command."""
        if self._open is None:
            return False
        return self.clock.now_us - self._open.last_command_us > self.numbers.session.watchdog_ms * 1000

    def press_stop_button(self, pressed: bool) -> None:
        """Press the STOP button on the robot, or let it go."""
        self.hardware.motors.press_stop_button(pressed)

    # -- session

    def _take(self, frame: Frame) -> None:
        command = p2os.decode_command(frame)
        if self._open is not None:
            self._open.last_command_us = self.clock.now_us
            self._obey(command)
            if self._open is not None:
                self._open.previous = command
        elif self._next_sync is not None:
            self._synchronise(frame.id, self._next_sync)
        elif command.name == "OPEN":
            self._begin_session()
        elif command.name == "CLOSE":
            self.close_session()

    def _synchronise(self, number: int, expected: int) -> None:
        """Take a step of the SYNC sequence. What is out of order starts it again."""
        if number != expected:
            self._next_sync = expected = SYNC0
        if number != expected:
            return
        if number == SYNC2:
            self._next_sync = None
            self.send(p2os.SyncReply(self.name, "Pioneer", self.model.subtype))
        else:
            self._next_sync = number + 1
            self.send(p2os.SyncEcho(number))

    def _begin_session(self) -> None:
        last_step_us = self.next_step_us - self.numbers.physics.step_us
        self._open = OpenSession(self.clock.now_us, last_step_us + self.numbers.session.sip_cycle_ms * 1000)
        self.hardware.reset_odometry()
        self.hardware.sonar.switch(True, last_step_us)

    def close_session(self) -> None:
        """End the session: motors and sonar off, parameters as at power-on, waiting for SYNC0."""
        self._forget_session()
        self.closed_sessions += 1
        self.hardware.motors.disable()
        self.hardware.sonar.switch(False, self.clock.now_us)
        self.hardware.reset_parameters()

    def _forget_session(self) -> None:
        self._open = None
        self._next_sync = SYNC0
        self.baud = self.numbers.session.host_baud
        self.settings = dict(SETTINGS)

    def restart(self) -> None:
        """Obey RESET: end the session as a fresh start of the controller would, and say so."""
        self.close_session()
        self.hardware.restart()
        self.send(p2os.Reset(0xFF, b""))

    def power_cycle(self) -> None:
        """Switch the robot off and on again: it forgets its session, and while it boots it hears and says nothing."""
        self.hardware.restart()
        self._forget_session()
        self._sent.clear()
        self.decoder.drop_partial()
        self._booted_us = self.clock.now_us + round(self.numbers.session.boot_time * 1e6)

    # -- commands

    def _obey(self, command: ReceivedCommand) -> None:
        handler = HANDLERS.get(command.name)
        obeyed, unknown, senseless = self._counts
        if handler is None or not handler.known_to(self.model.firmware_family):
            unknown += 1
            self.unknown_commands.add(command.name)
        elif handler.value is not None and not isinstance(command.value, handler.value):
            senseless += 1
        else:
            obeyed += 1
            handler.act(self, command.value)
        self._counts = CommandCounts(obeyed, unknown, senseless)

    def request(self, kind: str, how: int) -> None:
        """Send packets of a kind with the SIP: 0 no more of them, 1 with the next one, more with every one."""
        if self._open is None:
            return
        if how <= 0:
            self._open.requests.pop(kind, None)
        else:
            self._open.requests[kind] = how > 1

    # -- what it sends

    def send(self, packet: object) -> None:
        """Send a packet, behind all others."""
        self._sent.append(p2os.encode_packet(packet, self.model.grip_state_first))
