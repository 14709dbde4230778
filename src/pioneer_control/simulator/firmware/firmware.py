"""The robot's side of P2OS, without I/O: bytes of a client go in, simulated time passes, bytes of the robot come out.

>>> from pioneer_control.robots import find_model
>>> from pioneer_control.simulator.world.world_loader import load_world
>>> robot = Firmware(find_model("p3dx-sh"), load_world("empty"))
>>> robot.receive(bytes.fromhex("FAFB03000000"))    # SYNC0
>>> robot.advance(0.1).hex()
'fafb03000000'

No thread, clock or socket is in here: the same bytes at the same simulated times, with the same seed, give the same
answer however the time is split.
"""

import math
from enum import Enum
from typing import Dict, List, NamedTuple, Optional, Set, Tuple

from ... import p2os
from ...errors import ParameterError
from ...p2os import SYNC0, SYNC2, Frame, FrameDecoder, ReceivedCommand
from ...robots import RobotModel
from . import reports
from ..world.geometry import Pose
from ..hardware.gripper import ParallelGripper
from .commands import HANDLERS
from ..hardware.hardware import Hardware
from ..hardware.robot_numbers import RobotNumbers, standard_numbers
from ..world.world import World

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


class Firmware:
    """A simulated robot, as its serial line shows it.

    :param model: which robot (`RobotModel`).
    :param world: the `World` it stands in.
    :param pose: where it stands (x, y, heading; map frame); the first start of the world if None.
    :param gripper: whether it has one; None: if ``robot.yaml`` fits one to this model.
    :param rear_sonar: whether the rear array is fitted.
    :param name: which it tells at SYNC2.
    :param seed: of the noise.
    :param noise: every sonar range is off by up to this much (m); None: as ``robot.yaml`` says.
    :param numbers: other numbers than those of ``robot.yaml``.
    :param time_us: simulated time at which it is switched on, for a robot among others (see `Simulation`).
    :raises ParameterError: a gripper on a model that cannot carry one, a place in a wall, or a negative noise.
    """

    line_takes_time = True
    """On a serial line its packets take the time that a line takes."""

    def __init__(
        self, model: RobotModel, world: World, pose: Optional[Pose] = None, *, gripper: Optional[bool] = None,
        rear_sonar: bool = True, name: str = "sim_0001", seed: int = 0, noise: Optional[float] = None,
        numbers: Optional[RobotNumbers] = None, time_us: int = 0,
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
        self.hardware.on_power_up = self._boot
        self.session = FirmwareState.WAITING
        self.time_us = time_us
        self.previous: Optional[ReceivedCommand] = None
        self.wheel_mode = False
        self.closed_sessions = 0
        self.baud = self.numbers.session.host_baud
        """Present speed of its serial line."""
        self._booted_us = 0
        self._remainder_us = 0.0
        self.next_step_us = time_us + self.numbers.physics.step_us
        self._next_sip_us = time_us
        self._next_sync = SYNC0
        self._decoder = FrameDecoder()
        self._last_byte_us = time_us
        self._last_command_us = time_us
        self._requests: Dict[str, bool] = {}
        self._counts = [0, 0, 0]
        self.unknown_commands: Set[str] = set()
        """Names of commands that came and that its firmware does not know."""
        self._sent: List[bytes] = []

    # -- the line and the clock

    def receive(self, data: bytes) -> None:
        """Take bytes from the client, in any pieces, at the present simulated time. Answers come out of `advance`."""
        if self.time_us < self._booted_us:
            return
        self._last_byte_us = self.time_us
        for frame in self._decoder.feed(data):
            self._take(frame)

    def advance(self, dt: float) -> bytes:
        """Let `dt` seconds of simulated time pass.

        :param dt: seconds, from 0 up; microseconds count, fractions of them are carried over to the next call.
        :returns: everything the robot sent meanwhile, answers to what it received before included.
        """
        exact_us = dt * 1e6 + self._remainder_us
        whole_us = round(exact_us)
        self._remainder_us = exact_us - whole_us
        self.run_to(self.time_us + whole_us)
        return self.take_sent()

    def run_to(self, end_us: int) -> None:
        """Let simulated time pass until `end_us`; what the robot sends meanwhile is kept for `take_sent`."""
        while self.next_step_us <= end_us:
            self.time_us = self.next_step_us
            self.next_step_us += self.numbers.physics.step_us
            self._step()
        self.time_us = end_us

    @property
    def next_sip_us(self) -> float:
        """When it next sends by itself; never without a session."""
        return self._next_sip_us if self.session is FirmwareState.OPEN else math.inf

    def take_sent(self) -> bytes:
        """Everything the robot sent since the last call."""
        if not self._sent:
            return b""
        sent, self._sent = b"".join(self._sent), []
        return sent

    def _step(self) -> None:
        if self.time_us - self._last_byte_us >= PARTIAL_TIMEOUT_US and self._decoder.waiting:
            for frame in self._decoder.drop_partial():
                self._take(frame)
        self.hardware.step(self.time_us, self.watchdog_expired)
        if self.time_us >= self._next_sip_us and self.session is FirmwareState.OPEN:
            self._next_sip_us += self.numbers.session.sip_cycle_ms * 1000
            self._send_sips()

    # -- what tests, benches and nodes may look at

    @property
    def time(self) -> float:
        """Simulated seconds: of the `Simulation` it is in, else since power-on."""
        return self.time_us * 1e-6

    @property
    def true_pose(self) -> Pose:
        """Where the robot stands (x, y, heading; map frame; the heading is not wrapped)."""
        return self.hardware.body.pose

    @property
    def odometry_origin(self) -> Pose:
        """The true pose (map frame) at which the robot's own pose was 0, 0, 0: OPEN and SETO make it the present one."""
        return self.hardware.origin

    @property
    def internal_counts(self) -> Tuple[int, int]:
        """The robot's own x and y in counts of the wire, before they wrap to 15 bits."""
        return reports.counts(self.hardware)

    @property
    def velocity(self) -> Tuple[float, float]:
        """Present translation (m/s) and rotation (rad/s)."""
        return self.hardware.linear.speed, self.hardware.angular.speed

    @property
    def motors_enabled(self) -> bool:
        """Whether the motors have power."""
        return self.hardware.motors_enabled

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
        return CommandCounts(*self._counts)

    @property
    def line_counts(self) -> p2os.DecoderCounts:
        """What the line brought since power-on."""
        return self._decoder.counts

    @property
    def watchdog_expired(self) -> bool:
        """Whether an open session has been silent for so long that the drives stand until the next command."""
        silence_us = self.time_us - self._last_command_us
        return silence_us > self.numbers.session.watchdog_ms * 1000 and self.session is FirmwareState.OPEN

    def press_stop_button(self, pressed: bool) -> None:
        """Press the STOP button on the robot, or let it go."""
        self.hardware.stop_button = pressed

    # -- session

    def _take(self, frame: Frame) -> None:
        command = p2os.decode_command(frame)
        if self.session is FirmwareState.WAITING:
            self._synchronise(frame)
        elif self.session is FirmwareState.SYNCED:
            if command.name == "OPEN":
                self._open_session()
            elif command.name == "CLOSE":
                self.close_session()
        else:
            self._last_command_us = self.time_us
            self._obey(command)
            self.previous = command

    def _synchronise(self, frame: Frame) -> None:
        """One step of the SYNC sequence; anything out of order starts it again."""
        if frame.id != self._next_sync:
            self._next_sync = SYNC0
        if frame.id != self._next_sync:
            return
        if frame.id == SYNC2:
            self._next_sync = SYNC0
            self.session = FirmwareState.SYNCED
            self._send(p2os.SyncReply(self.name, "Pioneer", self.model.subtype))
        else:
            self._next_sync += 1
            self._send(p2os.SyncEcho(frame.id))

    def _open_session(self) -> None:
        self.session = FirmwareState.OPEN
        self._last_command_us = self.time_us
        last_step_us = self.next_step_us - self.numbers.physics.step_us
        self._next_sip_us = last_step_us + self.numbers.session.sip_cycle_ms * 1000
        self.hardware.reset_odometry()
        self.hardware.sonar.switch(True, last_step_us)

    def close_session(self) -> None:
        """End the session: motors and sonar off, parameters as at power-on, waiting for SYNC0."""
        self._forget_session()
        self.closed_sessions += 1
        self.hardware.disable_motors()
        self.hardware.sonar.switch(False, self.time_us)
        self.hardware.reset_parameters()

    def _forget_session(self) -> None:
        self.session = FirmwareState.WAITING
        self.previous = None
        self.wheel_mode = False
        self.baud = self.numbers.session.host_baud
        self._requests.clear()

    def _boot(self) -> None:
        """The power came back: nothing of the session is left, and for a moment it hears and says nothing."""
        self._forget_session()
        self._next_sync = SYNC0
        self._sent.clear()
        self._decoder.drop_partial()
        self._booted_us = self.time_us + round(self.numbers.session.boot_time * 1e6)

    def restart(self) -> None:
        """What the RESET command does: end the session as a fresh start of the controller would, and say so."""
        self.close_session()
        self.hardware.restart()
        self._send(p2os.Reset(0xFF, b""))

    # -- commands

    def _obey(self, command: ReceivedCommand) -> None:
        handler = HANDLERS.get(command.name)
        if handler is None or not handler.known_to(self.model.firmware_family):
            self._counts[1] += 1
            self.unknown_commands.add(command.name)
        elif handler.value is not None and not isinstance(command.value, handler.value):
            self._counts[2] += 1
        else:
            self._counts[0] += 1
            handler.act(self, command.value)

    def change_baud(self, baud: int) -> None:
        """The serial line has another speed from now on, until the session ends."""
        self.baud = baud

    def can_drive(self) -> bool:
        """Whether a motion command is obeyed now; with the motors off it is forgotten."""
        return self.hardware.motors_enabled

    def leave_wheel_mode(self) -> None:
        """A motion command after VEL2 cancels both of its speeds."""
        if self.wheel_mode:
            self.wheel_mode = False
            self.hardware.leave_wheels()
            self.hardware.linear.set_speed(0.0)
            self.hardware.angular.set_speed(0.0)

    def request(self, kind: str, how: int) -> None:
        """Send packets of a kind behind the SIP: 0 no more of them, 1 with the next one, more with every one."""
        if how <= 0:
            self._requests.pop(kind, None)
        else:
            self._requests[kind] = how > 1

    def request_gyro(self, on: bool) -> None:
        """Send what the gyro reads from now on before every SIP, or no more."""
        self.request("gyro", 2 if on else 0)
        self.hardware.gyro.take_readings()

    def send_playlist(self, number: int) -> None:
        """Answer with the stored sounds, at once."""
        for packet in reports.playlist(self.hardware, number):
            self._send(packet)

    def send_arm_info(self) -> None:
        """Answer with ARMINFOpac, at once."""
        self._send(reports.NO_ARM_INFO)

    def send_config(self) -> None:
        """Answer with CONFIGpac, at once."""
        self._send(reports.config(self.hardware, self.name, self.numbers))

    # -- what it sends

    def _send_sips(self) -> None:
        if not self._requests:
            self._send(reports.sip(self.hardware))
        else:
            self._send_requested(BEFORE_SIP)
            self._send(reports.sip(self.hardware))
            self._send_requested(BEHIND_SIP)
        for port, aux in enumerate(self.hardware.aux, 1):
            data = aux.take()
            if data is not None:
                self._send(p2os.SerialAux(port, data))

    def _send_requested(self, packets) -> None:
        for kind in [kind for kind in packets if kind in self._requests]:
            self._send(packets[kind](self))
            if not self._requests[kind]:
                del self._requests[kind]

    def _send(self, packet) -> None:
        self._sent.append(p2os.encode_packet(packet, self.model.grip_state_first))


BEFORE_SIP = {
    "gyro": lambda robot: reports.gyro(robot.hardware),
    "joystick": lambda robot: reports.joystick(robot.hardware),
}
BEHIND_SIP = {
    "encoder": lambda robot: reports.encoder(robot.hardware),
    "gripper": lambda robot: reports.gripper(robot.hardware),
    "io": lambda robot: reports.io(robot.hardware),
    "battery": lambda robot: reports.battery_info(robot.hardware),
    "compass": lambda robot: reports.tcm2(robot.hardware, robot.numbers),
    "arm": lambda robot: reports.NO_ARM,
}
"""The packets that a client can ask for, in the order in which they go out with a SIP."""
