"""Settings of the robot itself (ramps, PID, calibration, sonar): a table of their commands and CONFIGpac fields.

The robot forgets these settings at CLOSE (protocol 2.5). So the client sends them again after each OPEN: see `tuner`.
"""

import math
from dataclasses import dataclass, field, fields
from typing import Any, Dict, NamedTuple, Optional, Tuple, Union

from .. import p2os
from ..errors import ParameterError
from ..robots import ARRAY_SIZE, RobotModel

MM = 0.001                      # m, or m/s^2
DEGREE = math.radians(1)        # rad, or rad/s^2
INT, UINT = 0x7FFF, 0xFFFF      # the largest signed and unsigned numbers that a command can carry
SONARS = 32                     # numbers of transducers in the protocol
LONGEST_SEQUENCE = 16           # firings of one array (protocol 3.1, POLLING)

Value = Union[float, Tuple[int, ...]]
"""The value of a setting: a number, or a sequence of transducer numbers."""


class TuningRow(NamedTuple):
    """One setting: the command that sets it, and the field of CONFIGpac that shows it.

    ``command`` carries a whole number between ``low`` and ``high``, multiplied by ``sign``. ``config`` is the name of
    the field in CONFIGpac; None when no field shows the setting. ``scale`` is the size of one step of that number in
    ``unit``; None for a setting that is a whole number itself.
    """

    command: str
    config: Optional[str]
    low: int
    high: int
    scale: Optional[float] = None
    unit: str = ""
    sign: int = 1

    def number(self, value: Any) -> int:
        """Return a value (in the setting's ``unit``) as the whole number that CONFIGpac has for it."""
        number: int = int(value) if self.scale is None else round(value / self.scale)
        return number

    def packet(self, value: Any) -> bytes:
        """Return the packet that sets this value (in the setting's ``unit``) in the robot."""
        return p2os.encode_command(self.command, self.sign * self.number(value))

    def shown(self, config: Optional[p2os.Config]) -> Optional[float]:
        """Return the value in CONFIGpac (in the setting's ``unit``); None without CONFIGpac or without such a field."""
        number: Optional[int] = None if config is None or self.config is None else getattr(config, self.config)
        return number if number is None or self.scale is None else number * self.scale

    def why_not(self, model: RobotModel, value: Value) -> str:
        """Return why a robot of this model cannot have a value; empty if it can."""
        family = model.firmware_family
        return "" if p2os.knows(family, self.command) else "%s firmware does not know %s" % (family, self.command)

    def check(self, name: str, value: Any) -> None:
        """Check a value (in the setting's ``unit``). Raises ParameterError with ``name``, value and what is legal."""
        kinds = (int,) if self.scale is None else (int, float)
        sane = isinstance(value, kinds) and not isinstance(value, bool) and abs(value) < 1e9     # NaN is not
        if not sane or not self.low <= self.number(value) <= self.high:
            legal = ("a whole number from %d to %d" % (self.low, self.high) if self.scale is None else
                     "%.4g to %.6g %s" % (self.low * self.scale, self.high * self.scale, self.unit))
            raise ParameterError("%s is %r; legal: %s, or None to leave it as the robot has it" % (name, value, legal))


class SequenceRow(TuningRow):
    """The setting whose value is a sequence of transducer numbers, from 0. The command has them from 1, as bytes."""

    def number(self, value: Any) -> Any:
        """Return the value itself: no field of CONFIGpac shows it."""
        return value

    def packet(self, value: Any) -> bytes:
        """Return the packet that sets this sequence in the robot."""
        return p2os.encode_command(self.command, bytes(number + 1 for number in value))

    def why_not(self, model: RobotModel, value: Any) -> str:
        """Return why a robot of this model cannot have a value: it lacks a transducer; empty if it can."""
        lacking = sorted(set(value) - {transducer.number for transducer in model.sonar})
        return "this robot has no sonar %s" % ", ".join(map(str, lacking)) if lacking else super().why_not(model, value)

    def check(self, name: str, value: Any) -> None:
        """Check a sequence. Raises ParameterError with ``name``, value and what is legal."""
        numbers = isinstance(value, tuple) and all(type(each) is int and 0 <= each < SONARS for each in value)
        if not numbers or not value or any(
                sum(each // ARRAY_SIZE == array for each in value) > LONGEST_SEQUENCE for array in range(4)):
            raise ParameterError(
                "%s is %r; legal: a tuple of sonar numbers from 0 to %d, at most %d of each array of %d, or None to"
                " leave it as the robot has it" % (name, value, SONARS - 1, LONGEST_SEQUENCE, ARRAY_SIZE))


def _row(*row: Any, **more: Any) -> Any:
    return field(default=None, metadata={"row": TuningRow(*row, **more)})


@dataclass(frozen=True)
class Tuning:
    """Settings of the robot itself, valid while it is connected. A setting that is None stays as the robot has it.

    Accelerations (m/s^2, rad/s^2) and decelerations are positive. The robot clips them to its own limits. The robot's
    manual explains the numbers of the PID and of the calibration. Raises ParameterError with the value and its legal
    range.
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
    """Which bumpers stop the wheels: 0 none, 1 front, 2 rear, 3 front and rear."""
    ticks_mm: Optional[int] = _row("TICKSMM", "ticks_per_mm", 1, UINT)
    """Encoder ticks per mm."""
    drift_factor: Optional[int] = _row("DRIFTFACTOR", "drift_factor", -INT, INT)
    """Straight-line correction."""
    rev_count: Optional[int] = _row("REVCOUNT", "rev_count", 1, UINT)
    """Differential encoder count of a full turn."""
    sonar_cycle: Optional[float] = _row("SONARCYCLE", "sonar_cycle_ms", 2, 120, MM, "s")
    """Time (s) between two firings of each sonar array."""
    sonar_polling: Optional[Tuple[int, ...]] = field(default=None, metadata={"row": SequenceRow("POLLING", None, 0, 0)})
    """The order in which sonars fire, by number. Arrays of eight (0 to 7, 8 to 15, ...) fire at the same time, each
    the numbers of its own in turn. A sonar may be there several times. One that is left out does not fire, if its array
    has another one here; other arrays keep their order. No packet shows it, so it is sent a few times.
    """

    def __post_init__(self) -> None:
        for name, value in self.values.items():
            ROWS[name].check(name, value)

    @property
    def values(self) -> Dict[str, Value]:
        """The settings that are not None, by name, in the order in which they are sent."""
        return {name: getattr(self, name) for name in ROWS if getattr(self, name) is not None}


ROWS: Dict[str, TuningRow] = {entry.name: entry.metadata["row"] for entry in fields(Tuning)}
"""The table of settings, by the names of the fields of Tuning."""


class Change(NamedTuple):
    """The result for one setting of a Tuning. All values are in ``unit``."""

    name: str
    unit: str
    wanted: Optional[Value]
    """The value that was sent; None when the robot was to have its own value back, and nobody knows this value."""
    old: Optional[float]
    """The value that CONFIGpac showed before; None when CONFIGpac did not show it."""
    new: Optional[float]
    """The value that CONFIGpac shows now; None when CONFIGpac does not show it."""
    problem: str = ""
    """Why the robot does not have the wanted value, or does not report it; empty when there is no problem."""

    def __str__(self) -> str:
        old, new, wanted = self._text(self.old), self._text(self.new), self.wanted_text
        if self.problem:
            return "%s %s -> %s, wanted %s: %s" % (self.name, old, new, wanted, self.problem)
        return "%s set to %s" % (self.name, wanted) if self.new is None else "%s %s -> %s" % (self.name, old, new)

    @property
    def wanted_text(self) -> str:
        """The wanted value with its unit, for people."""
        return self._text(self.wanted)

    def _text(self, value: Optional[Value]) -> str:
        if value is None:
            return "?"
        if isinstance(value, tuple):
            return ", ".join(map(str, value))
        return "%.4g %s" % (value, self.unit) if self.unit else "%d" % value
