"""Optional devices of a robot: gyro, compass, joystick, loudspeaker, user inputs and outputs, auxiliary serial ports.

This file does not depend on packets. Values are raw readings where packets carry raw readings.
"""

import collections
import math
from dataclasses import dataclass
from typing import Callable, Deque, List, Optional, Protocol, Tuple

from ...errors import ParameterError
from .drives import Drives
from .robot_numbers import CompassNumbers, GyroNumbers, JoystickNumbers

GYRO_PERIOD_US = 25000
"""Time between two readings of the gyro (microseconds).

Source: protocol sheet 5.6.
"""
GYRO_KEPT = 40
"""Number of gyro readings that are kept for the client: those of the last second."""
GYRO_GREATEST = 1023
NO_GYRO, GYRO_OF_CLIENT, GYRO_OF_ROBOT = 0, 1, 2
"""Kinds of gyro, with the values of CONFIGpac: no gyro, read by the client, read by the robot itself."""
ENCODERS_ONLY, FUSED, GYRO_ONLY = 0, 1, 2
"""Sources of the heading of a robot that reads its gyro itself: encoders only, encoders and gyro, gyro only.

Source: protocol sheet 3.2, GYRO.
"""
NOTE_UNIT = 0.02
"""Unit of the length of a note (s)."""
NOTES_KEPT = 100
AUX_MOST = 197
"""Largest number of bytes in one SERAUXpac."""
AUX_KEPT = 4096
"""Size of the buffer (bytes) for data from a serial device. When the buffer is full, the oldest bytes are lost."""


class RateGyro:
    """The gyro of a robot. It may be missing, read by the client, or read by the robot.

    A gyro that the client reads gives a raw reading every 25 ms. A reading is below the centre value while the robot
    turns counter-clockwise. The rounding error of a reading is added to the next reading, so that the sum of the
    readings gives the angle turned.

    Attributes:
        kind: `NO_GYRO`, `GYRO_OF_CLIENT` or `GYRO_OF_ROBOT`.
        mode: `ENCODERS_ONLY`, `FUSED` or `GYRO_ONLY`. It is used only for `GYRO_OF_ROBOT`.
        drift: error (rad/s, counter-clockwise positive) of the measured rate.
    """

    def __init__(self, numbers: GyroNumbers):
        self._numbers = numbers
        self.kind = numbers.kind
        self.drift = 0.0
        self._unit = math.radians(5.0 / 1023.0 * 300.0 / 2.5 * numbers.scaler) / (1.0 + numbers.larger)
        self._readings: Deque[int] = collections.deque(maxlen=GYRO_KEPT)
        self._angle = self._angle_read = self._left_over = 0.0
        self._next_us = 0
        self.reset()

    def reset(self) -> None:
        """Set the mode to its power-on value."""
        self.mode = FUSED

    def set_drift(self, drift: float) -> None:
        """Set the drift of the gyro (rad/s, counter-clockwise positive)."""
        self.drift = drift

    def heading_change(self, by_wheels: float, really: float, dt: float) -> float:
        """Return the turn (rad) of one step as the odometry adds it, measured by the wheels or by the robot's gyro.

        Args:
            by_wheels: turn (rad) measured by the wheels.
            really: real turn of the body (rad).
            dt: duration of the step (s).
        """
        by_gyro = self.kind == GYRO_OF_ROBOT and self.mode != ENCODERS_ONLY
        return really + self.drift * dt if by_gyro else by_wheels

    @property
    def turns_alone(self) -> bool:
        """Whether the drift of this gyro changes the odometry heading of a robot that stands still."""
        return self.drift != 0.0 and self.kind == GYRO_OF_ROBOT and self.mode == GYRO_ONLY

    def step(self, now_us: int, step_us: int, turned: float) -> None:
        """Take the readings of one step, for a gyro that the client reads.

        Args:
            now_us: simulated time at the end of the step (microseconds).
            step_us: duration of the step (microseconds).
            turned: real turn of the robot in the step (rad, counter-clockwise positive).
        """
        turned += self.drift * (step_us * 1e-6)
        before, self._angle = self._angle, self._angle + turned
        if self._next_us <= now_us - step_us:
            self._next_us = now_us - step_us + GYRO_PERIOD_US
            self._angle_read = before
        while self._next_us <= now_us:
            angle = before + turned * ((self._next_us - now_us + step_us) / step_us)
            self._read((angle - self._angle_read) / (GYRO_PERIOD_US * 1e-6))
            self._angle_read = angle
            self._next_us += GYRO_PERIOD_US

    def _read(self, rate: float) -> None:
        exact = self._numbers.centre - rate / self._unit + self._left_over
        reading = max(0, min(GYRO_GREATEST, round(exact)))
        self._left_over = max(-0.5, min(0.5, exact - reading))
        self._readings.append(reading)

    def take_readings(self) -> Tuple[Tuple[int, int], ...]:
        """Return raw reading and raw temperature of every reading since the last call, oldest first."""
        readings = tuple((reading, self._numbers.temperature) for reading in self._readings)
        self._readings.clear()
        return readings


class Compass:
    """The compass of a robot, in an undisturbed magnetic field. The robot has a compass only if `numbers.fitted`.

    Attributes:
        numbers: parameters of the compass.
        on: whether the compass is switched on.
    """

    def __init__(self, numbers: CompassNumbers):
        self.numbers = numbers
        self.reset()

    def reset(self) -> None:
        """Switch the compass on, as at power-on."""
        self.on = True

    @staticmethod
    def degrees(heading: float) -> float:
        """Convert a heading (rad, map frame) to degrees clockwise from north, above 0 and at most 360.

        North is the direction of the map's y axis.
        """
        return (90.0 - math.degrees(heading)) % 360.0 or 360.0


@dataclass
class JoystickState:
    """The state of a joystick that is plugged into the robot.

    Axes have values from 0 to 1023, 512 in the middle. x increases to the right, y forward.
    """

    button_1: bool = False
    button_2: bool = False
    x: int = 512
    y: int = 512
    throttle: int = 512


class JoystickDrive:
    """Drives the robot by joystick while button 1 is pressed. When the button is released, the robot stops.

    Attributes:
        allowed: whether the client allows the joystick to drive the robot.
        drove: whether the joystick drove the robot in the last step.
    """

    def __init__(self, numbers: JoystickNumbers, drives: Drives):
        self._numbers, self._drives = numbers, drives
        self.reset()

    def reset(self) -> None:
        """Forbid the joystick to drive the robot, as at power-on."""
        self.allowed = self.drove = False

    def step(self, joystick: Optional[JoystickState], motors_enabled: bool) -> None:
        """Set the speeds of the drives from the state of the joystick, or stop them if it no longer drives the robot.

        `joystick` is None when no joystick is plugged in.
        """
        if joystick is not None and joystick.button_1 and self.allowed and motors_enabled:
            self._drives.set_speeds(
                (joystick.y - 512) / 512.0 * self._numbers.linear_mm_s / 1000.0,
                (512 - joystick.x) / 512.0 * math.radians(self._numbers.angular_deg_s))
            self.drove = True
        elif self.drove:
            self._drives.set_speeds(0.0, 0.0)
            self.drove = False


class Loudspeaker:
    """The loudspeaker of a robot. It makes no sound here, but keeps what it was to play last.

    Attributes:
        played: length (s) and tone (the number on the wire) of each note, oldest first.
    """

    def __init__(self) -> None:
        self.played: Deque[Tuple[float, int]] = collections.deque(maxlen=NOTES_KEPT)

    def play(self, notes: bytes) -> None:
        """Play pairs of bytes: length (units of 20 ms) and tone. A last byte without a partner is ignored."""
        self.played.extend((length * NOTE_UNIT, tone) for length, tone in zip(notes[::2], notes[1::2]))


class UserPorts:
    """Analog inputs and digital outputs for devices of the user, and the loudspeaker.

    Attributes:
        analog_volts: voltage at each of the eight analog inputs (V).
        analog_port: number (from 0) of the analog input whose voltage the SIP contains.
        digital_out: states of the digital outputs, one bit for each output.
        speaker: the loudspeaker, which keeps what it was to play.
    """

    def __init__(self) -> None:
        self.analog_volts: List[float] = [0.0] * 8
        self.digital_out = 0
        self.speaker = Loudspeaker()
        self.reset()

    def reset(self) -> None:
        """Set `analog_port` to its power-on value."""
        self.analog_port = 5

    def volts(self, port: int) -> float:
        """Return the voltage (V) that analog input `port` (from 0) measures, clipped to 0 to 5 V."""
        return max(0.0, min(5.0, self.analog_volts[port]))


class JoinedDevice(Protocol):
    """A device at an auxiliary port that moves by itself: a camera, an arm."""

    device_name: str
    """What it is, with its article, for people."""

    def step(self, now_us: int) -> None:
        """Let time pass until ``now_us`` (simulated time, microseconds)."""

    def restart(self) -> None:
        """Take that the robot restarts, as at power-on."""


class AuxPort:
    """An auxiliary serial port of the robot, to which a simulated device can be connected.

    Attributes:
        device: function that gets the bytes of each TTY command and returns the answer. None if no device is connected.
            A device can send bytes at any other time with `put`.
        joined: the same device, if it moves by itself, so that time passes for it. One port has one device.
    """

    def __init__(self) -> None:
        self.device: Optional[Callable[[bytes], bytes]] = None
        self.joined: Optional[JoinedDevice] = None
        self.reset()

    def join(self, device: JoinedDevice, number: int) -> None:
        """Connect a device that moves by itself to this port, which is AUX`number`.

        Raises:
            ParameterError: there is a device already.
        """
        if self.joined is not None:
            raise ParameterError("AUX%d has %s already: %s needs another auxiliary port"
                                 " (camera_aux; arm.aux in robot.yaml)"
                                 % (number, self.joined.device_name, device.device_name))
        self.joined = device

    def reset(self) -> None:
        """Drop all bytes in the buffer and the client's request for bytes, as at power-on."""
        self._waiting = b""
        self._wanted = 0

    def write(self, data: bytes) -> None:
        """Send bytes from the client to the device, and put the answer of the device into the buffer."""
        if self.device is not None:
            self.put(self.device(data))

    def put(self, data: bytes) -> None:
        """Receive bytes from the device, and put them into the buffer for the client."""
        self._waiting = (self._waiting + data)[-AUX_KEPT:]

    def want(self, count: int) -> None:
        """Store the request of the client for `count` bytes in one packet. 0 drops the bytes in the buffer instead."""
        if count >= 0:
            self._wanted = min(count, AUX_MOST)
        if count == 0:
            self._waiting = b""

    def take(self) -> Optional[bytes]:
        """Remove from the buffer the bytes that the client has requested, and return them.

        None if the client has requested no bytes, or if the buffer does not hold all of them yet.
        """
        if not self._wanted or len(self._waiting) < self._wanted:
            return None
        taken, self._waiting = self._waiting[:self._wanted], self._waiting[self._wanted:]
        self._wanted = 0
        return taken
