"""What can be fitted to a robot beside drives, sonar and gripper: gyro, compass, joystick, user inputs and outputs,
serial ports.

Knows no packets; numbers are raw readings where the wire carries raw readings.
"""

import collections
import math
from dataclasses import dataclass
from typing import Callable, Deque, List, Optional, Tuple

from .drives import Drives
from .robot_numbers import CompassNumbers, GyroNumbers, JoystickNumbers

GYRO_PERIOD_US = 25000
"""Time of one reading of the gyro.

Source: protocol sheet 5.6.
"""
GYRO_KEPT = 40
"""Readings kept for a client, one second of them."""
GYRO_GREATEST = 1023
NO_GYRO, GYRO_OF_CLIENT, GYRO_OF_ROBOT = 0, 1, 2
"""Kinds of gyro, as CONFIGpac has them: none, read by the client, read by the robot itself."""
ENCODERS_ONLY, FUSED, GYRO_ONLY = 0, 1, 2
"""What the heading of a robot that reads its gyro itself is made of.

Source: protocol sheet 3.2, GYRO.
"""
AUX_MOST = 197
"""Bytes of one SERAUXpac."""
AUX_KEPT = 4096
"""Bytes of a device that wait to be asked for; older ones are lost."""


class RateGyro:
    """The gyro of a robot, if it has one.

    A gyro that the client reads gives the client a raw reading every 25 ms. The reading is smaller than the centre
    while the robot turns counter-clockwise. What rounding leaves over goes into the next reading, so that the sum of
    the readings is the angle turned.

    Attributes:
        kind: `NO_GYRO`, `GYRO_OF_CLIENT` or `GYRO_OF_ROBOT`.
        mode: `ENCODERS_ONLY`, `FUSED` or `GYRO_ONLY`, for a gyro of the robot.
        drift: how much faster (rad/s, + counter-clockwise) it turns than the robot does.
    """

    def __init__(self, numbers: GyroNumbers):
        self._numbers = numbers
        self.kind = numbers.kind
        self.drift = 0.0
        self._unit = math.radians(5.0 / 1023.0 * 300.0 / 2.5 * numbers.scaler)
        self._readings: Deque[int] = collections.deque(maxlen=GYRO_KEPT)
        self._angle = self._told = self._left_over = 0.0
        self._next_us = 0
        self.reset()

    def reset(self) -> None:
        """Take the mode of power-on."""
        self.mode = FUSED

    def set_drift(self, drift: float) -> None:
        """Let it drift (rad/s, + counter-clockwise)."""
        self.drift = drift

    def heading_change(self, by_wheels: float, really: float, dt: float) -> float:
        """The turn (rad) of a step of `dt` seconds as the robot adds it up: by its wheels, or by a gyro that it reads
        itself.
        """
        by_gyro = self.kind == GYRO_OF_ROBOT and self.mode != ENCODERS_ONLY
        return really + self.drift * dt if by_gyro else by_wheels

    @property
    def turns_alone(self) -> bool:
        """Whether the drift of this gyro turns the heading of a robot that stands."""
        return self.drift != 0.0 and self.kind == GYRO_OF_ROBOT and self.mode == GYRO_ONLY

    def step(self, now_us: int, step_us: int, turned: float) -> None:
        """A step that ended at `now_us`, in which the robot turned by `turned` (rad), for a gyro of the client."""
        turned += self.drift * (step_us * 1e-6)
        before, self._angle = self._angle, self._angle + turned
        if self._next_us <= now_us - step_us:
            self._next_us = now_us - step_us + GYRO_PERIOD_US
            self._told = before
        while self._next_us <= now_us:
            angle = before + turned * ((self._next_us - now_us + step_us) / step_us)
            self._read((angle - self._told) / (GYRO_PERIOD_US * 1e-6))
            self._told = angle
            self._next_us += GYRO_PERIOD_US

    def _read(self, rate: float) -> None:
        exact = self._numbers.centre - rate / self._unit + self._left_over
        reading = max(0, min(GYRO_GREATEST, round(exact)))
        self._left_over = max(-0.5, min(0.5, exact - reading))
        self._readings.append(reading)

    def take_readings(self) -> Tuple[Tuple[int, int], ...]:
        """Readings and temperatures since the last call, oldest first."""
        readings = tuple((reading, self._numbers.temperature) for reading in self._readings)
        self._readings.clear()
        return readings


class Compass:
    """A compass, if `numbers.fitted`, in an undisturbed field.

    Attributes:
        on: it is switched on.
    """

    def __init__(self, numbers: CompassNumbers):
        self.numbers = numbers
        self.reset()

    def reset(self) -> None:
        """Switch it on, as at power-on."""
        self.on = True

    @staticmethod
    def degrees(heading: float) -> float:
        """Degrees clockwise from north, above 0 up to 360, of a heading (rad, map frame). North is where y grows."""
        return (90.0 - math.degrees(heading)) % 360.0 or 360.0


@dataclass
class JoystickState:
    """A joystick that is plugged into the robot.

    Axes go from 0 to 1023, 512 in the middle; x grows to the right, y forward.
    """

    button_1: bool = False
    button_2: bool = False
    x: int = 512
    y: int = 512
    throttle: int = 512


class JoystickDrive:
    """Drives the robot by joystick while the joystick's first button is pressed. When the button is let go, the robot
    stops.

    Attributes:
        allowed: the client allows it.
        drove: it drove in the last step.
    """

    def __init__(self, numbers: JoystickNumbers, drives: Drives):
        self._numbers, self._drives = numbers, drives
        self.reset()

    def reset(self) -> None:
        """Allow nothing, as at power-on."""
        self.allowed = self.drove = False

    def step(self, joystick: Optional[JoystickState], motors_enabled: bool) -> None:
        """Tell the drives what the joystick says now."""
        if joystick is not None and joystick.button_1 and self.allowed and motors_enabled:
            self._drives.set_speeds(
                (joystick.y - 512) / 512.0 * self._numbers.linear_mm_s / 1000.0,
                (512 - joystick.x) / 512.0 * math.radians(self._numbers.angular_deg_s))
            self.drove = True
        elif self.drove:
            self._drives.set_speeds(0.0, 0.0)
            self.drove = False


class UserPorts:
    """Analog inputs and digital outputs for devices of the user.

    Attributes:
        analog_volts: what is on the analog inputs, 0 to 5 V each.
        analog_port: which of them the SIP shows.
        digital_out: states of the outputs, bit by bit.
    """

    def __init__(self) -> None:
        self.analog_volts: List[float] = [0.0] * 8
        self.digital_out = 0
        self.reset()

    def reset(self) -> None:
        """Show the port of power-on."""
        self.analog_port = 5

    def volts(self, port: int) -> float:
        """What an analog input reads (V)."""
        return max(0.0, min(5.0, self.analog_volts[port]))


class AuxPort:
    """An auxiliary serial port.

    Attributes:
        device: what is connected, None at first. It gets the bytes of each TTY command, and returns what it answers at
            once. With `put` it speaks unasked.
    """

    def __init__(self) -> None:
        self.device: Optional[Callable[[bytes], bytes]] = None
        self.reset()

    def reset(self) -> None:
        """Forget all bytes, as at power-on."""
        self._waiting = b""
        self._wanted = 0

    def write(self, data: bytes) -> None:
        """Give bytes of the client to the device."""
        if self.device is not None:
            self.put(self.device(data))

    def put(self, data: bytes) -> None:
        """Take bytes of the device."""
        self._waiting = (self._waiting + data)[-AUX_KEPT:]

    def want(self, count: int) -> None:
        """Note that the client wants `count` bytes in one packet, once they are there; 0 throws away what waits."""
        if count >= 0:
            self._wanted = min(count, AUX_MOST)
        if count == 0:
            self._waiting = b""

    def take(self) -> Optional[bytes]:
        """Take the bytes that the client wants, if they are all there."""
        if not self._wanted or len(self._waiting) < self._wanted:
            return None
        taken, self._waiting = self._waiting[:self._wanted], self._waiting[self._wanted:]
        self._wanted = 0
        return taken
