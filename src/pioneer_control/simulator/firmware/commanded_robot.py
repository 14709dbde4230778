"""The simulated robot that command handlers act on: hardware, session, settings, and the packets that it sends.

The subclass `Firmware` adds the decoding of the client's bytes.
"""

from collections import Counter
from dataclasses import dataclass, field
from typing import Counter as CounterType, Dict, Iterator, Optional, Set, Tuple

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
from .laser_orders import LaserOrders
from .line_laser import LineLaser
from .robot_on_line import FirmwareState, RobotOnLine

SETTINGS = dict(
    rotation_kp=40, rotation_kv=20, rotation_ki=0, translation_kp=40, translation_kv=30, translation_ki=0,
    drift_factor=0,
    gyro_cw=0, gyro_ccw=0, aux1_baud=0, aux2_baud=0, aux3_baud=0, sounds_on=1,
)
"""Power-on values of the numbers that a client may set without any effect on the hardware, by names of CONFIGpac."""


SIMULATOR = "SIM"
"""Serial number by which the vendor's client knows a simulator (laser sheet 3.1), in any case."""
SIMULATORS_NAME = "MobileSim"
"""Name by which it knows one."""


@dataclass
class OpenSession:
    """State of an open session with a client.

    Attributes:
        last_command_us: simulated time of the client's last command (microseconds).
        next_sip_us: simulated time of the next SIP (microseconds).
        previous: the command before the present one.
        requests: kinds of packets that are sent. True: with every SIP. False: only with the next SIP.
        laser: what the client has asked of the laser over this line. None if the robot has no such laser.
    """

    last_command_us: int
    next_sip_us: int
    previous: Optional[ReceivedCommand] = None
    requests: Dict[str, bool] = field(default_factory=lambda: {"sip": True})
    laser: Optional[LaserOrders] = None

    def packets(self, hardware: Hardware) -> Iterator[object]:
        """Yield the SIP that is due, and the other requested packets that are sent before and after it.

        Packets that the client has requested only once are removed from `requests`.
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
    """A simulated robot without the decoding of its client's bytes. For arguments and attributes see `Firmware`."""

    def __init__(
        self, model: RobotModel, world: World, pose: Optional[Pose] = None, *, gripper: Optional[bool] = None,
        arm: bool = False, rear_sonar: bool = True, name: str = "sim_0001", seed: int = 0,
        noise: Optional[float] = None, numbers: Optional[RobotNumbers] = None, clock: Optional[Clock] = None,
        line_laser: bool = False,
    ):
        self.numbers = numbers or standard_numbers()
        super().__init__(name, clock or Clock(), self.numbers.session.host_baud)
        gripper = model.subtype in self.numbers.gripper.fitted_by_default if gripper is None else gripper
        noise = self.numbers.sonar.noise if noise is None else noise
        if noise < 0.0:
            raise ParameterError("noise is %g, wanted metres from 0 up" % noise)
        for what, told, is_known in (
                ("serial number", self.numbers.session.serial, self.numbers.session.serial.upper() == SIMULATOR),
                ("name", name, name == SIMULATORS_NAME)):
            if is_known and not line_laser:
                raise ParameterError("with the %s %s, clients take a laser over the robot's own line: add that laser"
                                     " (laser line), or give another %s" % (what, told, what))
        self.world = world
        self.hardware = Hardware(
            model.with_arrays(front=True, rear=rear_sonar), world, world.starts[0] if pose is None else pose, gripper,
            self.numbers, noise, seed)
        if arm:
            if model.firmware_family == "PSOS":
                raise ParameterError("an arm on a %s (arm): its firmware PSOS has no commands of an arm; take a model"
                                     " with another one, such as p3dx-sh" % model.subtype)
            self.hardware.join_arm(self.numbers.arm)
        self.line_laser = LineLaser(world, self.hardware, self.numbers.laser, seed) if line_laser else None
        self.next_step_us += self.numbers.physics.step_us
        self.decoder = FrameDecoder()
        self.command_counts: CounterType[str] = Counter()
        self.unknown_commands: Set[str] = set()
        self._last_byte_us = self.clock.now_us
        self._booted_us = 0
        self._forget_session()

    # -- what tests, benches and nodes may look at

    @property
    def model(self) -> RobotModel:
        """The model of the robot, without sonar arrays that are not fitted."""
        return self.hardware.model

    @property
    def time(self) -> float:
        """The simulated time (s) since the start of the clock."""
        return self.clock.seconds

    @property
    def true_pose(self) -> Pose:
        """The true pose of the robot (m, rad; map frame). The heading is not wrapped."""
        return self.hardware.body.pose

    @property
    def internal_counts(self) -> Tuple[int, int]:
        """The odometry x and y in the units of the SIP, before they wrap to 15 bits."""
        return reports.counts(self.hardware)

    @property
    def velocity(self) -> Tuple[float, float]:
        """The present speeds of translation (m/s) and rotation (rad/s)."""
        return self.hardware.drives.linear.speed, self.hardware.drives.angular.speed

    @property
    def motors_enabled(self) -> bool:
        """Whether the motors have power."""
        return self.hardware.motors.enabled

    @property
    def contacts(self) -> int:
        """The number of times that the body has run into a wall, a post, another robot or a person."""
        return self.hardware.body.contacts

    @property
    def touched_by_people(self) -> int:
        """The number of times that a person has walked into the robot while it stood. `contacts` has none of them."""
        return self.hardware.body.touched_by_people

    @property
    def gripper(self) -> Optional[ParallelGripper]:
        """The gripper of the robot. None if it has no gripper."""
        return self.hardware.gripper

    @property
    def next_sip_us(self) -> int:
        """The simulated time of the next SIP (microseconds). `NEVER_US` while no session is open."""
        return NEVER_US if self.open_session is None else self.open_session.next_sip_us

    @property
    def watchdog_expired(self) -> bool:
        """Whether the client has sent no command for longer than the watchdog time, so that the drives must stop.

        False while no session is open.
        """
        watchdog_us = self.numbers.session.watchdog_ms * 1000
        return self.open_session is not None and self.clock.now_us - self.open_session.last_command_us > watchdog_us

    def press_stop_button(self, pressed: bool) -> None:
        """Press the STOP button of the robot, or release it."""
        self.hardware.motors.press_stop_button(pressed)

    # -- session

    def _forget_session(self) -> None:
        """Drop the session, set baud rate and settings to their power-on values, and wait for SYNC0."""
        self.session = FirmwareState.WAITING
        self._next_sync = SYNC0
        self.open_session: Optional[OpenSession] = None
        self.baud = self.numbers.session.host_baud
        self.settings = dict(SETTINGS)

    def begin_session(self) -> None:
        """Begin a session: set the odometry to 0, switch the sonar on, and send the first SIP after one cycle."""
        last_step_us = self.next_step_us - self.numbers.physics.step_us
        self.open_session = OpenSession(self.clock.now_us, last_step_us + self.numbers.session.sip_cycle_ms * 1000,
                                        laser=LaserOrders() if self.line_laser is not None else None)
        self.session = FirmwareState.OPEN
        self.hardware.reset_odometry()
        self.hardware.sonar.switch(True, last_step_us)

    def close_session(self) -> None:
        """End the session: switch motors and sonar off, set all parameters to power-on values, and wait for SYNC0."""
        self._forget_session()
        self.closed_sessions += 1
        self.hardware.motors.disable()
        if self.hardware.arm is not None:
            self.hardware.arm.close_session()
        self.hardware.sonar.switch(False, self.clock.now_us)
        self.hardware.reset_parameters()

    def restart(self) -> None:
        """Execute command RESET: end the session, restart the robot's hardware, and send a reset packet (0xFF)."""
        self.close_session()
        self.hardware.restart()
        self.send(p2os.Reset(0xFF, b""))

    def power_cycle(self) -> None:
        """Switch the robot off and on again. It drops its session; while it boots it receives and sends nothing."""
        self.hardware.restart()
        self._forget_session()
        self._sent.clear()
        self.decoder.drop_partial()
        self._booted_us = self.clock.now_us + round(self.numbers.session.boot_time * 1e6)

    # -- what it sends

    def request(self, kind: str, how: int) -> None:
        """Set whether packets of a kind are sent with the SIP. Without a session, do nothing.

        Args:
            kind: kind of packet, a key of `reports.PACKETS`.
            how: 0 or less: no longer; 1: with the next SIP only; 2 or more: with every SIP.
        """
        requests = {} if self.open_session is None else self.open_session.requests
        requests.pop(kind, None)
        if how > 0:
            requests[kind] = how > 1

    def send(self, *packets: object) -> None:
        """Append packets to the bytes that the robot sends."""
        self._sent += [p2os.encode_packet(packet, self.model.grip_state_first) for packet in packets]
