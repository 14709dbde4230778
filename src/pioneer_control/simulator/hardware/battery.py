"""The battery: it falls with time, faster while the robot drives, and rises while a charger feeds it."""

from ...p2os import ChargeState
from .robot_numbers import BatteryNumbers

US_PER_MINUTE = 6e7


class BatteryPack:
    """A battery of the 12 V or the 24 V class.

    Args:
        numbers: voltages of the 12 V class and how fast they fall and rise.
        nominal: 12 or 24.

    Attributes:
        scale: by how much its voltage is more than that of a 12 V battery.
        charging: a charger feeds it.
    """

    def __init__(self, numbers: BatteryNumbers, nominal: int):
        self._numbers = numbers
        self.scale = nominal / 12.0
        self._level = numbers.full
        self._pretended = 0.0
        self.charging = False

    @property
    def voltage_12v(self) -> float:
        """Voltage (V) on the scale of a 12 V battery."""
        return self._pretended / self.scale if self._pretended else self._level

    @property
    def voltage(self) -> float:
        """Real voltage (V). Setting it drains or fills the battery to there, as a fault or a fresh battery would."""
        return self.voltage_12v * self.scale

    @voltage.setter
    def voltage(self, voltage: float) -> None:
        self._level = max(0.0, voltage / self.scale)

    @property
    def charge(self) -> float:
        """Share of the way from the shutdown voltage to full, 0 to 1."""
        span = self._numbers.full - self._numbers.shutdown
        return max(0.0, min(1.0, (self.voltage_12v - self._numbers.shutdown) / span))

    @property
    def charge_state(self) -> int:
        """What the charger does, one of `ChargeState`."""
        if not self.charging:
            return int(ChargeState.NOT_CHARGING)
        reached = (self._level >= self._numbers.overcharge) + (self._level >= self._numbers.full)
        return int((ChargeState.BULK, ChargeState.OVERCHARGE, ChargeState.FLOAT)[reached])

    @property
    def is_low(self) -> bool:
        """Whether the alarm sounds."""
        return self.voltage_12v < self._numbers.alarm

    @property
    def is_empty(self) -> bool:
        """Whether the robot can no longer drive."""
        return self.voltage_12v < self._numbers.shutdown

    def pretend(self, voltage: float) -> None:
        """Report this real voltage (V) whatever the battery has; 0 ends the pretence."""
        self._pretended = voltage

    def step(self, duration_us: int, driving: bool) -> None:
        """Use the battery for some microseconds, or charge it."""
        numbers, level = self._numbers, self._level
        if self.charging:
            rise = numbers.charging_rise_per_min / US_PER_MINUTE * duration_us
            self._level = max(level, min(numbers.full, level + rise))
        else:
            fall_per_min = numbers.driving_fall_per_min if driving else numbers.standing_fall_per_min
            self._level = max(0.0, level - fall_per_min / US_PER_MINUTE * duration_us)
