"""What a user asks of a laser. Checked once; each number then has its meaning."""

from dataclasses import dataclass
from typing import Optional

from ..errors import ParameterError
from ..lms2xx import MEASURING_MODES, PASSWORD, SPEEDS, Unit

_LEGAL = (
    ("baud", tuple(SPEEDS)),
    ("angle_deg", (None, 100, 180)),
    ("step_hundredths", (None, 100, 50, 25)),
    ("unit", (None, Unit.CENTIMETRES, Unit.MILLIMETRES)),
    ("measuring_mode", (None, *MEASURING_MODES)),
    ("writes", (False, True)),
)


@dataclass(frozen=True)
class LaserSettings:
    """How the laser shall measure and send. None and 0 keep what the laser has.

    Attributes:
        baud: the speed of the line while it measures (baud).
        angle_deg: how wide it looks: 100 or 180 (degrees).
        step_hundredths: between two rays: 100, 50 or 25 (hundredths of a degree).
        unit: a `Unit`: centimetres (to 80 m) or millimetres (to 8 m).
        measuring_mode: a key of `MEASURING_MODES`.
        writes: whether `unit` and `measuring_mode` may be written to the laser's EEPROM, if they differ from what is
            there. It lasts for a few thousand writes.
        password: of the laser, for this.
        power_on: time (s) that a laser may take until it is ready, when power comes with the opening of the port.

    Raises:
        ParameterError: no laser can have this. The message names the value, and what is legal.
    """

    baud: int = 38400
    angle_deg: Optional[int] = None
    step_hundredths: Optional[int] = None
    unit: Optional[int] = None
    measuring_mode: Optional[int] = None
    writes: bool = False
    password: bytes = PASSWORD
    power_on: float = 65.0

    def __post_init__(self) -> None:
        for name, legal in _LEGAL:
            if getattr(self, name) not in legal:
                raise ParameterError("laser, %s %r: legal is one of %s" % (
                    name, getattr(self, name), ", ".join(str(each) for each in legal if each is not None)))
        if self.step_hundredths == 25 and self.angle_deg == 180:
            raise ParameterError("laser, step of 0.25 degrees: legal with an angle of 100 degrees alone, not of 180")
        if len(self.password) != 8:
            raise ParameterError("laser, password %r: legal are eight characters" % (self.password,))
        if not 0.0 <= self.power_on <= 600.0:
            raise ParameterError("laser, power_on %r: legal is 0 to 600 s" % (self.power_on,))
