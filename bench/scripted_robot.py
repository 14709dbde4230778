"""A robot that costs next to nothing, for bench/driver.py.

It is a P3-DX-SH with 16 sonar on a pty, in a process of its own, and notes when bytes came and went.

It answers the handshake, CONFIG and ENCODER, switches motors, ramps to the commanded speed, and sends SIPs of 85 bytes.
Each SIP is encoded beforehand, so that nothing but a write happens when it is due. There is no world, no echo and no
watchdog. Bytes travel at once, whatever the line speed.
"""

import math
import multiprocessing
import os
import select
import tty
from time import monotonic
from typing import List, NamedTuple, Tuple

from pioneer_control import p2os

ACCELERATION = 300      # mm/s^2, either way
SONAR = tuple(p2os.SonarReading(number, 1000 + number) for number in range(16))
REPLY = p2os.encode_packet(p2os.SyncReply("bench", "Pioneer", "p3dx-sh"))
CONFIG = p2os.encode_packet(p2os.Config(     # as much of it as older firmware sends
    type="Pioneer", subtype="p3dx-sh", serial="bench", four_motors=0,
    rotation_velocity_top_deg_s=360, translation_velocity_top_mm_s=1500,
    rotation_acceleration_top_deg_s2=300, translation_acceleration_top_mm_s2=2000,
    pwm_max=500, name="bench", sip_cycle_ms=100, host_baud=0, aux1_baud=0, has_gripper=0,
    front_sonar=1, rear_sonar=1, low_battery_dv=115, rev_count=16570, watchdog_ms=2000))
ENCODER = p2os.encode_packet(p2os.Encoder(0, 0))


class Record(NamedTuple):
    """What happened on the line: times are monotonic, s."""

    sent: List[float]
    """when each SIP went out"""
    heard: List[Tuple[float, bytes]]
    """what came, in the pieces it came in"""


class Script:
    """The robot's side of the protocol, as far as starting, driving and ending a driver need it."""

    def __init__(self, is_open: bool) -> None:
        self.is_open = is_open
        self.cycle = 0.1
        self.behind = b""
        """what goes out behind the next SIP"""
        self._synced = self._motors = False
        self._speed, self._wanted, self._way = 0.0, 0, 0.0
        self._decoder = p2os.FrameDecoder()

    def answer(self, data: bytes) -> bytes:
        """Obey packets. Returns the robot's answer."""
        return b"".join(map(self._obey if self.is_open else self._sync, self._decoder.feed(data)))

    def _sync(self, frame: p2os.Frame) -> bytes:
        self.is_open = self._synced and frame.id == p2os.SYNC1
        self._synced = frame.id == p2os.SYNC2
        if self.is_open:
            return b""
        return REPLY if self._synced else p2os.encode_frame(frame.id)

    def _obey(self, frame: p2os.Frame) -> bytes:
        command = p2os.decode_command(frame)
        if command.name == "CLOSE":
            self.is_open = self._motors = False
            self._speed = self._wanted = 0
        elif command.name == "ENABLE":
            self._motors = bool(command.value)
        elif command.name in ("VEL", "STOP"):
            self._wanted = command.value or 0
        elif command.name == "ENCODER":
            self.behind = ENCODER
        return CONFIG if command.name == "CONFIG" else b""

    def sip(self) -> bytes:
        """Return the next SIP."""
        step = ACCELERATION * self.cycle
        self._speed += min(max(self._motors * self._wanted - self._speed, -step), step)
        self._way += self._speed * self.cycle
        speed, way = round(self._speed), round(self._way)
        motors = p2os.Flags.MOTORS_ENABLED if self._motors else p2os.Flags(0)
        return p2os.encode_packet(p2os.Sip(
            type_id=p2os.MOVING if speed else p2os.STOPPED, x_counts=way % 0x8000, y_counts=0, heading_units=0,
            left_velocity_units=speed, right_velocity_units=speed, battery_dv=128,
            left_stall_bits=p2os.StallBits(0), right_stall_bits=p2os.StallBits(0), control_units=0,
            flags=p2os.Flags.SONAR_1 | p2os.Flags.SONAR_2 | motors, compass=0, sonar=SONAR,
            grip_state=p2os.GripState(0), analog_port=0, analog=0,
            digital_in=p2os.DigitalIn(255), digital_out=0, battery_x10_dv=128,
            charge_state=0, rotation_velocity_ddeg_s=0, fault_flags=p2os.FaultFlags(0)))


class ScriptedRobot:
    """The process.

    Args:
        phase: of the cycle (0..1) at which SIPs are sent, counted from monotonic time zero, so that two robots can take
        turns. is_open: it streams from the start, as one that a crashed driver left.
    """

    def __init__(self, phase: float, is_open: bool) -> None:
        line, self._other_side = os.openpty()
        tty.setraw(self._other_side)
        os.set_blocking(line, False)
        self.port = os.ttyname(self._other_side)
        self._control, control = multiprocessing.Pipe()
        self._process = multiprocessing.Process(target=_serve, args=(line, control, phase, is_open), daemon=True)
        self._process.start()
        os.close(line)

    def set_cycle(self, seconds: float) -> None:
        """Send a SIP every ``seconds`` from now on."""
        self._control.send(seconds)

    def record(self) -> Record:
        """Return what happened since the last call."""
        self._control.send(None)
        return self._control.recv()

    def end(self) -> None:
        """Switch it off."""
        self._process.terminate()
        self._process.join()


def _serve(line: int, control, phase: float, is_open: bool) -> None:
    script, record, next_sip = Script(is_open), Record([], []), 0.0
    sip, parent = script.sip(), os.getppid()
    while os.getppid() == parent:       # a robot that a killed bench left would disturb the next measurement
        now = monotonic()
        if now >= next_sip:
            next_sip = (math.floor(now / script.cycle - phase) + 1 + phase) * script.cycle
            if script.is_open:
                try:
                    os.write(line, sip + script.behind)
                    record.sent.append(now)
                except BlockingIOError:     # nobody reads
                    pass
            sip, script.behind = script.sip(), b""
        ready, _, _ = select.select([line, control], [], [], max(0.0, next_sip - monotonic()))
        now = monotonic()
        if line in ready:
            data = os.read(line, 4096)
            record.heard.append((now, data))
            answer = script.answer(data)
            if answer:
                os.write(line, answer)
        if control in ready:
            seconds = control.recv()
            if seconds is None:
                control.send(record)
                record = Record([], [])
            else:
                script.cycle, next_sip = seconds, 0.0
