"""A simple robot for tests of the session. It has no body and no world, but every bad habit that a test wants.

Its clock moves only when the test moves it.
"""

import math
from dataclasses import replace
from typing import Callable, Dict, List, NamedTuple, Optional, Sequence

from pioneer_control import p2os
from pioneer_control.client.line import SetBaud
from pioneer_control.client.session import Session
from pioneer_control.client.settings import Settings
from pioneer_control.client.state import RobotState

STEP = 0.005
SIP_CYCLE = 0.1
WAITING, SYNCED, OPEN = "waiting", "synced", "open"


class Heard(NamedTuple):
    time: float
    name: str
    value: object


def config(**fields) -> p2os.Config:
    """Return a CONFIGpac up to the firmware version, as in the protocol sheet."""
    values = dict(
        type="Pioneer", subtype="p3dx-sh", serial="P3DX0001", four_motors=0, rotation_velocity_top_deg_s=360,
        translation_velocity_top_mm_s=1500, rotation_acceleration_top_deg_s2=300,
        translation_acceleration_top_mm_s2=2000, pwm_max=500, name="fake", sip_cycle_ms=100, host_baud=0, aux1_baud=0,
        has_gripper=0, front_sonar=1, rear_sonar=1, low_battery_dv=115, rev_count=16570, watchdog_ms=2000,
        alternative_sips=0, stall_value=200, stall_count=100, joystick_velocity_mm_s=750, joystick_rotation_deg_s=50,
        rotation_velocity_max_deg_s=100, translation_velocity_max_mm_s=750, rotation_acceleration_deg_s2=100,
        rotation_deceleration_deg_s2=100, rotation_kp=40, rotation_kv=20, rotation_ki=0,
        translation_acceleration_mm_s2=300, translation_deceleration_mm_s2=300, translation_kp=40, translation_kv=30,
        translation_ki=0, front_bumpers=0, rear_bumpers=0, charger=0, sonar_cycle_ms=40, autobaud=2, has_gyro=0,
        drift_factor=0, aux2_baud=0, aux3_baud=0, ticks_per_mm=128, shutdown_dv=110, firmware_version="2.9",
    )
    values.update(fields)
    return p2os.Config(**values)


def sip(**fields) -> p2os.Sip:
    """Return a SIP of ARCOS length from a robot at rest."""
    values = dict(
        type_id=p2os.STOPPED, x_counts=0, y_counts=0, heading_units=0, left_velocity_units=0, right_velocity_units=0,
        battery_dv=128, left_stall_bits=p2os.StallBits(0), right_stall_bits=p2os.StallBits(0), control_units=0,
        flags=p2os.Flags(0), compass=0, sonar=(), grip_state=p2os.GripState(0), analog_port=0, analog=0,
        digital_in=p2os.DigitalIn(255), digital_out=0, battery_x10_dv=128, charge_state=0, rotation_velocity_ddeg_s=0,
        fault_flags=p2os.FaultFlags(0),
    )
    values.update(fields)
    return p2os.Sip(**values)


class FakeRobot:
    """Obeys at once: it has a new velocity with the next SIP. Set its attributes to make it misbehave."""

    def __init__(self) -> None:
        self.phase = WAITING
        self.subtype = "p3dx-sh"
        self.config: Optional[p2os.Config] = config()
        self.motors = False
        self.stop_button = False
        self.stalled = False
        self.set_point = {"VEL": 0, "RVEL": 0}
        self.watchdog_expired = False
        self.heard: List[Heard] = []
        self.deaf: Callable[[Heard], bool] = lambda heard: False
        self.mute: Callable[[object], bool] = lambda packet: False
        self.coasts = False                     # wheels go on turning whatever it is told
        self.revived = False                    # an old set point came back to life
        self.baud: Optional[int] = None
        self.own_baud: Optional[int] = None     # to which it returns from another that HOSTBAUD set
        self.streams_encoders = False           # for ever, when it is asked once, as early P2OS
        self.noisy: Sequence[int] = ()          # line speeds that the line does not carry
        self._decoder = p2os.FrameDecoder()
        self._next_sync = 0
        self._out = b""
        self._next_sip = 0.0
        self._encoder = 0                       # of its last ENCODER
        self._last_command = 0.0

    def receive(self, data: bytes, now: float) -> None:
        for frame in self._decoder.feed(data):
            command = p2os.decode_command(frame)
            heard = Heard(now, command.name, command.value)
            self.heard.append(heard)
            if not self.deaf(heard):
                self._take(heard, frame.id, now)

    def advance(self, now: float) -> bytes:
        if self.phase == OPEN and now - self._last_command > 2.0:
            self.watchdog_expired = True
        while self.phase == OPEN and now >= self._next_sip - 1e-9:
            self._next_sip += SIP_CYCLE
            self.send(self._sip())
            if self._encoder:
                self.send(p2os.Encoder(0, 0))
                self._encoder = 2 if self._encoder == 2 or self.streams_encoders else 0
        out, self._out = self._out, b""
        return out

    def send(self, packet) -> None:
        if not self.mute(packet):
            self._out += p2os.encode_packet(packet)

    def open(self, now: float = 0.0) -> None:
        self.phase, self._next_sip, self._last_command = OPEN, now, now

    @property
    def moving(self) -> bool:
        return self.coasts or self.motors and not self.watchdog_expired and any(self.set_point.values())

    def names(self) -> List[str]:
        return [heard.name for heard in self.heard]

    def _take(self, heard: Heard, number: int, now: float) -> None:
        if self.phase == OPEN:
            self._obey(heard, now)
        elif self.phase == SYNCED:
            if number == 1:
                self.open(now)
            elif number == 2:
                self.phase, self._next_sync = WAITING, 0
        elif number == self._next_sync:
            self._next_sync += 1
            if number < 2:
                self.send(p2os.SyncEcho(number))
            else:
                self.phase = SYNCED
                self.send(p2os.SyncReply("fake", "Pioneer", self.subtype))
        else:
            self._next_sync = 0

    def _obey(self, heard: Heard, now: float) -> None:
        if heard.name == "CLOSE":
            self.baud = self.own_baud or self.baud
            self.__dict__.update(
                phase=WAITING, motors=False, watchdog_expired=False, set_point={"VEL": 0, "RVEL": 0}, _next_sync=0)
            return
        if heard.name in ("STOP", "VEL", "RVEL"):
            self.set_point.update({"VEL": 0, "RVEL": 0} if heard.name == "STOP" else {heard.name: heard.value})
        elif heard.name == "VEL2":
            left, right = (units * 20 for units in p2os.two_bytes(heard.value))
            self.set_point = {"VEL": (left + right) // 2, "RVEL": round(math.degrees((right - left) / 2 * 0.0056))}
        if self.watchdog_expired and self.motors and any(self.set_point.values()):
            self.revived = True
        self.watchdog_expired, self._last_command = False, now
        if heard.name == "HOSTBAUD":
            self.own_baud = self.own_baud or self.baud
            self.baud = p2os.BAUD_RATES[heard.value]
        elif heard.name == "ENABLE":
            self.motors = bool(heard.value) and not self.stop_button
        elif heard.name == "ENCODER":
            self._encoder = heard.value
        elif heard.name == "CONFIG" and self.config is not None:
            self.send(self.config)

    def _sip(self) -> p2os.Sip:
        flags = p2os.Flags.SONAR_1
        flags |= p2os.Flags.MOTORS_ENABLED if self.motors else p2os.Flags(0)
        flags |= p2os.Flags.STOP_BUTTON if self.stop_button else p2os.Flags(0)
        speed = 100 if self.coasts else self.set_point["VEL"] if self.moving else 0
        turn = self.set_point["RVEL"] * 10 if self.moving else 0
        stall = p2os.StallBits(self.stalled)
        return sip(
            flags=flags, left_stall_bits=stall, left_velocity_units=speed, right_velocity_units=speed,
            rotation_velocity_ddeg_s=turn)

    def press_stop_button(self, pressed: bool) -> None:
        self.stop_button = pressed
        if pressed:
            self.motors = False


class Bench:
    """A session and a fake robot on a line, and their clock."""

    def __init__(
            self, robot: Optional[FakeRobot] = None, rates=(), to_client: Callable[[bytes], bytes] = bytes, **settings
    ) -> None:
        self.robot = robot or FakeRobot()
        self.now = 0.0
        self.session = Session("fake", tuple(rates), Settings(**settings), self.now)
        self.baud = rates[0] if rates else None
        self.states: List[RobotState] = []
        self.events: List[object] = []
        self.writes: Dict[float, List[bytes]] = {}
        self._to_client = to_client
        self.act()

    def step(self) -> None:
        self.act()
        self.now += STEP
        sent = self.robot.advance(self.now)
        if sent:
            heard = sent if self.line_speed_fits else bytes(byte ^ 0x5A for byte in sent)
            self.session.receive(self._to_client(heard), self.now)
        self.session.tick(self.now)
        assert self.session.wake_at > self.now, "a thread would spin"
        self.act()

    @property
    def line_speed_fits(self) -> bool:
        return self.robot.baud is None or self.robot.baud == self.baud and self.baud not in self.robot.noisy

    def run(self, seconds: float) -> None:
        end = self.now + seconds
        while self.now < end - STEP / 2:
            self.step()

    def run_until(self, condition: Callable[[], bool], limit: float = 10.0) -> float:
        """Return the seconds until the condition holds."""
        start = self.now
        while not condition():
            assert self.now - start < limit, "not within %g s; heard: %s" % (limit, self.robot.names())
            self.step()
        return self.now - start

    def until_ready(self) -> "Bench":
        self.run_until(lambda: self.session.connected)
        return self

    def until_driving(self, linear: float = 0.2, angular: float = 0.0) -> "Bench":
        """Wait until the robot is ready, has its motors on, and moves. The list of what it heard begins with the
        velocity.
        """
        self.until_ready()
        request = self.session.connected.drive.request_motors(True, self.now, 2.0)
        self.run_until(lambda: request.done)
        assert request.error is None
        self.run(0.5)
        self.robot.heard.clear()
        self.drive(linear, angular)
        self.run(0.15)
        assert self.robot.moving
        return self

    def drive(self, linear: float, angular: float) -> None:
        self.session.connected.drive.set_velocity(linear, angular, self.now)
        self.act()

    def use(self, **settings) -> None:
        """Use these settings from now on."""
        self.session.use(replace(self.session._link.settings, **settings), self.now)

    def want(self, kind: str, on: bool) -> None:
        """Request packets of this kind, or cancel the request."""
        kinds = self.session._link.settings.data
        self.use(data=kinds | {kind} if on else kinds - {kind})

    def close(self) -> None:
        self.session.close(self.now)
        self.act()

    @property
    def finished(self) -> bool:
        return self.session.finished

    def event(self, kind: type):
        """Return the only event of this type."""
        found, = (event for event in self.events if isinstance(event, kind))
        return found

    def act(self) -> None:
        """Carry out the actions of the session."""
        for action in self.session.data_to_send():
            if isinstance(action, SetBaud):
                self.baud = action.baud
                continue
            self.writes.setdefault(self.now, []).append(action)
            self.robot.receive(action if self.line_speed_fits else bytes(byte ^ 0x5A for byte in action), self.now)
        for event in self.session.events():
            (self.states if isinstance(event, RobotState) else self.events).append(event)
