"""The battery: it falls with time, faster while the robot drives."""


class Battery:
    """A battery of the 12 V or the 24 V class.

    :param numbers: voltages of the 12 V class and how fast they fall (`BatteryNumbers`).
    :param nominal: 12 or 24.
    """

    def __init__(self, numbers, nominal: int):
        self._numbers = numbers
        self.scale = nominal / 12.0
        self._standing_us = 0
        self._driving_us = 0
        self._pretended = 0.0

    @property
    def voltage_12v(self) -> float:
        """Voltage (V) on the scale of a 12 V battery."""
        if self._pretended:
            return self._pretended / self.scale
        minutes = 6e7
        fallen = self._standing_us / minutes * self._numbers.standing_fall_per_min
        fallen += self._driving_us / minutes * self._numbers.driving_fall_per_min
        return max(0.0, self._numbers.full - fallen)

    @property
    def voltage(self) -> float:
        """Real voltage (V)."""
        return self.voltage_12v * self.scale

    @property
    def charge(self) -> float:
        """Share of the way from the shutdown voltage to full, 0 to 1."""
        span = self._numbers.full - self._numbers.shutdown
        return max(0.0, min(1.0, (self.voltage_12v - self._numbers.shutdown) / span))

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
        """Use the battery for some microseconds."""
        if driving:
            self._driving_us += duration_us
        else:
            self._standing_us += duration_us
