"""A simulated robot as the handlers of commands see it: hardware, session, settings, and the packets that it sends.

`Firmware` adds how the robot understands its client.
"""

from dataclasses import dataclass, field
from typing import Dict, Iterator, NamedTuple, Optional, Set, Tuple

from ... import p2os
from ...errors import ParameterError
from ...p2os import SYNC0, FrameDecoder, ReceivedCommand
from ...robots import RobotModel
from ..clock import NEVER_US, Clock
from ..hardware import Hardware, RobotNumbers, standard_numbers
from ..hardware.gripper import ParallelGripper
from ..world import World
from ..world.poses import Pose
from . import reports
from .robot_on_line import FirmwareState, RobotOnLine

SETTINGS = dict(
    rotation_kp=40, rotation_kv=20, rotation_ki=0, translation_kp=40, translation_kv=30, translation_ki=0,
    drift_factor=0,
    gyro_cw=0, gyro_ccw=0, aux1_baud=0, aux2_baud=0, aux3_baud=0, sounds_on=1,
)
"""What a client may set and the hardware does not obey, as at power-on, by its name in CONFIGpac."""


class CommandCounts(NamedTuple):
    """What became of the commands of clients, since power-on."""

    obeyed: int = 0
    unknown: int = 0
    senseless: int = 0


@dataclass
class OpenSession:
    """What is known of a client while its session is open.

    Attributes:
        last_command_us: when its last command came.
        next_sip_us: when the next SIP is due.
        previous: its command before the present one.
        requests: kinds of packets that it gets; the value says whether they come with every SIP, not with the next one
            only.
    """

    last_command_us: int
    next_sip_us: int
    previous: Optional[ReceivedCommand] = None
    requests: Dict[str, bool] = field(default_factory=lambda: {"sip": True})

    def packets(self, hardware: Hardware) -> Iterator[object]:
        """The SIP that is due, and the packets that go out before and behind it.

        The session forgets then what the client asked for once.
        """
        for kind, make in reports.PACKETS.items():
            if kind in self.requests:
                yield make(hardware)
                if not self.requests[kind]:
                    del self.requests[kind]
        for port, aux in enumerate(hardware.aux, 1):
            data = aux.take()
            if data is not None:
                yield p2os.SerialAux(port, data)


class CommandedRobot(RobotOnLine):
    """All of a simulated robot but how it understands its client. `Firmware` explains the arguments and attributes."""

    def __init__(
        self, model: RobotModel, world: World, pose: Optional[Pose] = None, *, gripper: Optional[bool] = None,
        rear_sonar: bool = True, name: str = "sim_0001", seed: int = 0, noise: Optional[float] = None,
        numbers: Optional[RobotNumbers] = None, clock: Optional[Clock] = None,
    ):
        self.numbers = numbers or standard_numbers()
        super().__init__(name, clock or Clock(), self.numbers.session.host_baud)
        gripper = model.subtype in self.numbers.gripper.fitted_by_default if gripper is None else gripper
        noise = self.numbers.sonar.noise if noise is None else noise
        if noise < 0.0:
            raise ParameterError("noise is %g, wanted metres from 0 up" % noise)
        self.model = model.with_arrays(front=True, rear=rear_sonar)
        self.world = world
        self.hardware = Hardware(
            self.model, world, world.starts[0] if pose is None else pose, gripper, self.numbers, noise, seed)
        self.next_step_us += self.numbers.physics.step_us
        self.decoder = FrameDecoder()
        self.command_counts = CommandCounts()
        self.unknown_commands: Set[str] = set()
        self._last_byte_us = self.clock.now_us
        self._booted_us = 0
        self._forget_session()

    # -- what tests, benches and nodes may look at

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
    def next_sip_us(self) -> int:
        """When it next sends by itself; never without a session."""
        return NEVER_US if self.open_session is None else self.open_session.next_sip_us

    @property
    def watchdog_expired(self) -> bool:
        """Whether an open session has been silent for so long that the drives stand until the next command."""
        watchdog_us = self.numbers.session.watchdog_ms * 1000
        return self.open_session is not None and self.clock.now_us - self.open_session.last_command_us > watchdog_us

    def press_stop_button(self, pressed: bool) -> None:
        """Press the STOP button on the robot, or let it go."""
        self.hardware.motors.press_stop_button(pressed)

    # -- session

    def _forget_session(self) -> None:
        """Wait for SYNC0, with the line and the settings of power-on."""
        self.session = FirmwareState.WAITING
        self._next_sync = SYNC0
        self.open_session: Optional[OpenSession] = None
        self.baud = self.numbers.session.host_baud
        self.settings = dict(SETTINGS)

    def begin_session(self) -> None:
        """Begin a session: pose 0, sonar on, the first SIP in one cycle."""
        last_step_us = self.next_step_us - self.numbers.physics.step_us
        self.open_session = OpenSession(self.clock.now_us, last_step_us + self.numbers.session.sip_cycle_ms * 1000)
        self.session = FirmwareState.OPEN
        self.hardware.reset_odometry()
        self.hardware.sonar.switch(True, last_step_us)

    def close_session(self) -> None:
        """End the session: motors and sonar off, parameters as at power-on, waiting for SYNC0."""
        self._forget_session()
        self.closed_sessions += 1
        self.hardware.motors.disable()
        self.hardware.sonar.switch(False, self.clock.now_us)
        self.hardware.reset_parameters()

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

    # -- what it sends

    def request(self, kind: str, how: int) -> None:
        """Send packets of a kind with the SIP: 0 no more of them, 1 with the next one, more with every one."""
        requests = {} if self.open_session is None else self.open_session.requests
        requests.pop(kind, None)
        if how > 0:
            requests[kind] = how > 1

    def send(self, *packets: object) -> None:
        """Send packets, behind all others."""
        self._sent += [p2os.encode_packet(packet, self.model.grip_state_first) for packet in packets]
