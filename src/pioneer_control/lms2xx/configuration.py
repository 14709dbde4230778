"""What a laser keeps in its EEPROM: the configuration of commands 74 and 77, and what its measuring modes mean
(laser sheet 1.5, 1.7).
"""

import enum
from dataclasses import dataclass, replace
from typing import Any, Dict, NamedTuple, Optional, Tuple

from ..errors import EncodingError
from ..wire_fields import BYTE, UINT16, Many, later, read_fields, rows, wire, write_fields


class Availability(enum.IntFlag):
    """Bits of `Configuration.availability`."""

    HIGHEST = 0x01
    """The laser measures again by itself after it was dazzled."""
    INDICES = 0x02
    """Each scan ends with its two indices."""
    DAZZLE_WITHOUT_EFFECT = 0x04


class Unit(enum.IntEnum):
    """The unit of a value."""

    CENTIMETRES = 0
    MILLIMETRES = 1
    TEN_CENTIMETRES = 2
    """Reserved in the manual. Two programs send it for values of 10 cm."""


CONTOUR = Many(BYTE, count=5)


@dataclass(frozen=True)
class Configuration:
    """The data of commands 77 (write) and of reply F4 (read). Older programs and firmware end earlier: what they do not
    send is None.
    """

    blanking_cm: int = wire(UINT16, "cm", "size of what the area guard ignores")
    stop_threshold_mv: int = wire(BYTE, "mV", "LMS200 and 220; others ignore it")
    sensitivity: int = wire(BYTE, "", "LMS200, 220: peak threshold 0..3; others: 0 standard, 1 medium, 2 low, 3 high")
    availability: int = wire(BYTE.of(Availability), "", "bits of `Availability`")
    measuring_mode: int = wire(BYTE, "", "a key of `MEASURING_MODES`")
    unit: int = wire(BYTE.of(Unit), "", "a `Unit`")
    temporary_field: Optional[int] = later(BYTE, "", "area guard; so are the following")
    subtractive_fields: Optional[int] = later(BYTE, "", "")
    evaluations: Optional[int] = later(BYTE, "", "")
    restart: Optional[int] = later(BYTE, "", "")
    restart_time: Optional[int] = later(BYTE, "", "")
    second_evaluation: Optional[int] = later(BYTE, "", "")
    contour_a: Optional[Tuple[int, ...]] = later(CONTOUR, "", "")
    contour_b: Optional[Tuple[int, ...]] = later(CONTOUR, "", "")
    contour_c: Optional[Tuple[int, ...]] = later(CONTOUR, "", "")
    pixel_evaluation: Optional[int] = later(BYTE, "", "")
    single_value: Optional[int] = later(BYTE, "", "")
    restart_times: Optional[int] = later(UINT16, "", "")
    dazzle_evaluations: Optional[int] = later(UINT16, "", "missing in firmware that has 32 bytes")

    def changed(self, **fields: Any) -> "Configuration":
        """Return this configuration with some fields changed."""
        return replace(self, **fields)

    def over(self, older: "Configuration") -> "Configuration":
        """Return this configuration with what it leaves out taken from an older one."""
        missing = {row.name: getattr(older, row.name) for row in rows(Configuration) if getattr(self, row.name) is None}
        return replace(self, **missing)


class ConfigurationField:
    """The type of a field that is a configuration, at the end of the data."""

    def read(self, data: bytes, at: int) -> Tuple[Configuration, int]:
        """The configuration from index `at` on, and the index of the end of the data. Raises TooShort when the data end
        before the unit.
        """
        values, _ = read_fields(rows(Configuration), data, at)
        return Configuration(**values), len(data)

    def write(self, value: Any, what: str) -> bytes:
        """The bytes of a configuration, up to its last field that is not None. Raises EncodingError, which names
        `what`, for anything else, or when a number does not fit.
        """
        if not isinstance(value, Configuration):
            raise EncodingError("%s: %r is not a Configuration" % (what, value))
        return write_fields(rows(Configuration), value)


_CONTOUR = (0, 10, 10, 80, 100)
FACTORY = Configuration(0, 70, 0, 0, 0, Unit.MILLIMETRES, 0, 0, 2, 2, 2, 0, _CONTOUR, _CONTOUR, _CONTOUR, 0, 0, 0, 2)
"""The configuration of an LMS200 as it is delivered. The outdoor types have `Unit.CENTIMETRES`."""


class MeasuringMode(NamedTuple):
    """What the bits of a value are.

    Attributes:
        distance_bits: how many of the lowest bits are the distance.
        reflector_bits: how many of the highest bits are the level of a reflector; 0: none. All others tell of fields.
        is_strength: the value is the strength of the echo, not a distance.
        meaning: in words.
    """

    distance_bits: int
    reflector_bits: int
    is_strength: bool
    meaning: str


MEASURING_MODES: Dict[int, MeasuringMode] = {
    0x00: MeasuringMode(13, 0, False, "8 (80) m; field A, field B, dazzle"),
    0x01: MeasuringMode(13, 3, False, "8 (80) m; level of a reflector 0..7"),
    0x02: MeasuringMode(13, 0, False, "8 (80) m; fields A, B, C"),
    0x03: MeasuringMode(14, 2, False, "16 (160) m; level of a reflector 0..3"),
    0x04: MeasuringMode(14, 0, False, "16 (160) m; fields A, B"),
    0x05: MeasuringMode(15, 1, False, "32 (320) m; a reflector or none"),
    0x06: MeasuringMode(15, 0, False, "32 (320) m; field A"),
    0x0F: MeasuringMode(16, 0, False, "distance alone"),
    0x3F: MeasuringMode(16, 0, True, "strength of the echo instead of a distance"),
}
"""All measuring modes that the sheet explains, by `Configuration.measuring_mode`. In brackets: in centimetres."""
