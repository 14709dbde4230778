"""What can be fitted to a robot beside drives, sonar and gripper: gyro, compass, joystick, and devices on its auxiliary serial ports.

Knows no packets; numbers are raw readings where the wire carries raw readings.
"""

import collections
import math
from dataclasses import dataclass
from typing import Callable, Deque, List, Optional, Tuple

GYRO_PERIOD_US = 25000
"""Time of one reading of the gyro (protocol 5.6)."""
GYRO_KEPT = 40
"""Readings kept for a client, one second of them."""
GYRO_GREATEST = 1023
AUX_MOST = 197
"""Bytes of one SERAUXpac."""
AUX_KEPT = 4096
"""Bytes of a device that wait to be asked for; older ones are lost."""


class RateGyro:
    """A gyro whose raw readings the client gets: one for every 25 ms, smaller than the centre while the robot turns counter-clockwise.

    What rounding leaves over goes into the next reading, so that their sum is the angle turned.

    :param numbers: of ``robot.yaml`` (`GyroNumbers`).
    """

    def __init__(self, numbers):
        self._numbers = numbers
        self._unit = math.radians(5.0 / 1023.0 * 300.0 / 2.5 * numbers.scaler)
        self._readings: Deque[int] = collections.deque(maxlen=GYRO_KEPT)
        self._angle = self._told = self._left_over = 0.0
        self._next_us = 0

    def step(self, now_us: int, step_us: int, turned: float) -> None:
        """A step that ended at `now_us`, in which the robot turned by `turned` (rad)."""
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


@dataclass
class JoystickState:
    """A joystick plugged into the robot: what its hands do with it. Axes 0 to 1023, 512 in the middle; x grows to the right, y forward."""

    button_1: bool = False
    button_2: bool = False
    x: int = 512
    y: int = 512
    throttle: int = 512

    @property
    def forward(self) -> float:
        """How far it is pushed forward, -1 to 1."""
        return (self.y - 512) / 512.0

    @property
    def leftward(self) -> float:
        """How far it is pushed to the left, -1 to 1."""
        return (512 - self.x) / 512.0


class AuxPort:
    """An auxiliary serial port. `device` is what hangs there: it gets the bytes of each TTY command and returns what it answers at once;
    with `put` it speaks unasked. Nothing hangs there at first.
    """

    def __init__(self) -> None:
        self.device: Optional[Callable[[bytes], bytes]] = None
        self._waiting = b""
        self._wanted = 0

    def write(self, data: bytes) -> None:
        """Bytes from the client to the device."""
        if self.device is not None:
            self.put(self.device(data))

    def put(self, data: bytes) -> None:
        """Bytes from the device."""
        self._waiting = (self._waiting + data)[-AUX_KEPT:]

    def want(self, count: int) -> None:
        """The client wants so many bytes in one packet, once they are there; 0 throws away what waits."""
        self._wanted = min(count, AUX_MOST)
        if not count:
            self._waiting = b""

    def take(self) -> Optional[bytes]:
        """The bytes that the client wants, if they are all there; then it wants no more."""
        if not self._wanted or len(self._waiting) < self._wanted:
            return None
        taken, self._waiting = self._waiting[:self._wanted], self._waiting[self._wanted:]
        self._wanted = 0
        return taken

    def reset(self) -> None:
        """As at power-on."""
        self._waiting, self._wanted = b"", 0


def compass_degrees(heading: float) -> float:
    """Degrees clockwise from north, above 0 up to 360, of a heading (rad, map frame): north is where y grows."""
    degrees = (90.0 - math.degrees(heading)) % 360.0
    return degrees or 360.0


SOUNDS: List[Tuple[str, int]] = [("~greetings", 0), ("hello", 8000), ("goodbye", 6400)]
"""Stored sounds of an AmigoBot: name and length in bytes; a leading ~ marks a group."""
