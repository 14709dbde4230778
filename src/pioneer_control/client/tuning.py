"""What a user may set in the robot itself: ramps, PID, bumpers, calibration. A table of commands and CONFIGpac fields.

The robot forgets all of it at CLOSE (protocol 2.5), so it is told again after each OPEN. See tuner for how it is told.
"""

import math
from dataclasses import dataclass, field, fields
from typing import Any, Dict, NamedTuple, Optional

from .. import p2os
from ..errors import ParameterError

MM = 0.001                      # m, or m/s^2
DEGREE = math.radians(1)        # rad, or rad/s^2
INT, UINT = 0x7FFF, 0xFFFF      # largest numbers of the wire


class TuningRow(NamedTuple):
    """How a setting travels to the robot and back.

    ``command`` sets it, with a number between ``low`` and ``high`` times ``sign``. ``config`` names the field of
    CONFIGpac that shows it; None when no field does. ``scale`` is one unit of the wire in the setting's own ``unit``;
    None for a whole number that travels as it is.
    """

    command: str
    config: Optional[str]
    low: int
    high: int
    scale: Optional[float] = None
    unit: str = ""
    sign: int = 1

    def number(self, value: float) -> int:
        """A value in the setting's own unit, as CONFIGpac counts it."""
        return int(value) if self.scale is None else round(value / self.scale)

    def packet(self, value: float) -> bytes:
        """The command that sets the robot to a value."""
        return p2os.encode_command(self.command, self.sign * self.number(value))

    def shown(self, config: Optional[p2os.Config]) -> Optional[float]:
        """The value that the robot reports, in the setting's own unit; None when it reports none."""
        number: Optional[int] = None if config is None or self.config is None else getattr(config, self.config)
        return number if number is None or self.scale is None else number * self.scale

    def check(self, name: str, value: Any) -> None:
        """Raises ParameterError that names the value and what is legal."""
        kinds = (int,) if self.scale is None else (int, float)
        sane = isinstance(value, kinds) and not isinstance(value, bool) and abs(value) < 1e9     # NaN is not
        if not sane or not self.low <= self.number(value) <= self.high:
            legal = ("a whole number from %d to %d" % (self.low, self.high) if self.scale is None else
                     "%.4g to %.6g %s" % (self.low * self.scale, self.high * self.scale, self.unit))
            raise ParameterError("%s is %r; legal: %s, or None to leave it as the robot has it" % (name, value, legal))


def _row(*row: Any, **more: Any) -> Any:
    return field(default=None, metadata={"row": TuningRow(*row, **more)})


@dataclass(frozen=True)
class Tuning:
    """Settings of the robot, valid while it is connected; None leaves each as the robot has it.

    Raises ParameterError that names the value and its legal range. Accelerations and decelerations are magnitudes; the
    robot clips them to limits of its own. What the numbers of the PID and of the calibration mean, the robot's manual
    says.
    """

    max_linear_acceleration: Optional[float] = _row("SETA", "translation_acceleration_mm_s2", 1, INT, MM, "m/s^2")
    max_linear_deceleration: Optional[float] = _row("SETA", "translation_deceleration_mm_s2", 1, INT, MM, "m/s^2",
                                                    sign=-1)
    max_angular_acceleration: Optional[float] = _row("SETRA", "rotation_acceleration_deg_s2", 1, INT, DEGREE, "rad/s^2")
    max_angular_deceleration: Optional[float] = _row("SETRA", "rotation_deceleration_deg_s2", 1, INT, DEGREE, "rad/s^2",
                                                     sign=-1)
    rotation_kp: Optional[int] = _row("ROTKP", "rotation_kp", 0, UINT)
    rotation_kv: Optional[int] = _row("ROTKV", "rotation_kv", 0, UINT)
    rotation_ki: Optional[int] = _row("ROTKI", "rotation_ki", 0, UINT)
    translation_kp: Optional[int] = _row("TRANSKP", "translation_kp", 0, UINT)
    translation_kv: Optional[int] = _row("TRANSKV", "translation_kv", 0, UINT)
    translation_ki: Optional[int] = _row("TRANSKI", "translation_ki", 0, UINT)
    bump_stall: Optional[int] = _row("BUMPSTALL", None, 0, 3)
    """which bumpers stop the wheels: 0 none, 1 front, 2 rear, 3 both"""
    ticks_mm: Optional[int] = _row("TICKSMM", "ticks_per_mm", 1, UINT)
    """encoder ticks of a mm"""
    drift_factor: Optional[int] = _row("DRIFTFACTOR", "drift_factor", -INT, INT)
    """straight-line correction"""
    rev_count: Optional[int] = _row("REVCOUNT", "rev_count", 1, UINT)
    """differential encoder count of a turn"""

    def __post_init__(self) -> None:
        for name, value in self.values.items():
            ROWS[name].check(name, value)

    @property
    def values(self) -> Dict[str, float]:
        """What is to be set, by name, in the order in which it is sent."""
        return {name: getattr(self, name) for name in ROWS if getattr(self, name) is not None}


ROWS: Dict[str, TuningRow] = {entry.name: entry.metadata["row"] for entry in fields(Tuning)}
"""The table, by the names of the fields."""


class Change(NamedTuple):
    """What became of one value of a Tuning, in its own unit."""

    name: str
    unit: str
    wanted: Optional[float]
    """None for what the robot had before it was ever told"""
    old: Optional[float]
    """as CONFIGpac showed it before; None when it did not"""
    new: Optional[float]
    """as CONFIGpac shows it now; None when it does not"""
    problem: str = ""
    """why it is not as wanted, or not known to be; empty when all is well"""

    def __str__(self) -> str:
        old, new, wanted = ("?" if value is None else "%.4g %s" % (value, self.unit) if self.unit else "%d" % value
                            for value in (self.old, self.new, self.wanted))
        if self.problem:
            return "%s %s -> %s, wanted %s: %s" % (self.name, old, new, wanted, self.problem)
        return "%s set to %s" % (self.name, wanted) if self.new is None else "%s %s -> %s" % (self.name, old, new)
