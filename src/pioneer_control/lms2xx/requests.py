"""Every request to a laser, as a frozen dataclass that is also its table (laser sheet 1.3, 1.4)."""

import enum
from dataclasses import dataclass
from typing import Dict, NamedTuple

from ..wire_fields import BYTE, REST, UINT16, wire
from .configuration import Configuration, ConfigurationField

PASSWORD = b"SICK_LMS"
"""The password of a laser that nobody gave another. Some types want ``SICK_`` and the first letters of their type."""


class Mode(enum.IntEnum):
    """What `SetMode` asks for."""

    INSTALLATION = 0x00
    """A password follows. Only in this mode may the configuration be written. Nothing is sent by itself."""
    DIAGNOSIS = 0x10
    MINIMUM_PER_TURN = 0x20
    MINIMUM_PER_TURN_ON_REQUEST = 0x21
    MINIMUM_ALWAYS = 0x22
    MINIMUM_ALWAYS_ON_REQUEST = 0x23
    STREAM = 0x24
    """Complete scans, one after the other."""
    ON_REQUEST = 0x25
    """Nothing by itself. A laser that was just switched on is in this mode."""
    STREAM_OF_MEANS = 0x26
    STREAM_OF_A_PART = 0x27
    STREAM_OF_MEANS_OF_A_PART = 0x28
    STREAM_WITH_FIELDS = 0x29
    STREAM_OF_PARTIAL_SCANS = 0x2A
    """The rays of each turn as soon as they are measured."""
    STREAM_OF_PARTIAL_SCANS_WITH_STRENGTH = 0x2B
    SEGMENT_MINIMA = 0x2C
    NAVIGATION = 0x2E
    TEST_PASSWORD = 0x30
    BAUD_38400 = 0x40
    BAUD_19200 = 0x41
    BAUD_9600 = 0x42
    BAUD_500000 = 0x48
    RANGE_AND_STRENGTH = 0x50


class Speed(NamedTuple):
    """What a speed of the line is called: the mode that asks for it, and its word in the reply B1."""

    mode: Mode
    word: int


SPEEDS: Dict[int, Speed] = {
    9600: Speed(Mode.BAUD_9600, 0x8067),
    19200: Speed(Mode.BAUD_19200, 0x8033),
    38400: Speed(Mode.BAUD_38400, 0x8019),
    500000: Speed(Mode.BAUD_500000, 0x8001),
}
"""All speeds (baud) of the line. 500000 needs RS-422."""


class ScanPart(enum.IntEnum):
    """What `AskScan` asks for."""

    ALL = 0x01
    EVERY_SECOND = 0x06
    EVERY_TWENTIETH = 0x07
    PARTIAL = 0x08
    """The rays of the turn that was just measured."""


@dataclass(frozen=True)
class ResetLaser:
    """10: begin anew. The laser answers, and is away until it sends `PowerOn`."""


@dataclass(frozen=True)
class SetMode:
    """20: change the mode, or the speed of the line."""

    mode: int = wire(BYTE.of(Mode), "", "a `Mode`")
    parameters: bytes = wire(REST, "", "password, or numbers of values")


@dataclass(frozen=True)
class AskScan:
    """30: one scan, please. Legal in mode `ON_REQUEST`."""

    part: int = wire(BYTE.of(ScanPart), "", "a `ScanPart`")


@dataclass(frozen=True)
class AskStatus:
    """31: all that the laser says of itself."""


@dataclass(frozen=True)
class AskErrors:
    """32: which errors are there, and were there?"""


@dataclass(frozen=True)
class AskMean:
    """36: the mean of some scans."""

    scans: int = wire(BYTE, "", "2..250")


@dataclass(frozen=True)
class AskValues:
    """37: the values of some rays."""

    first: int = wire(UINT16, "", "number of the first value, from 1 on")
    last: int = wire(UINT16, "", "number of the last value")


@dataclass(frozen=True)
class AskType:
    """3A: which laser is it?"""


@dataclass(frozen=True)
class SetVariant:
    """3B: how wide it looks, and how fine. It forgets this when it is switched off."""

    angle_deg: int = wire(UINT16, "deg", "100 or 180")
    step_hundredths: int = wire(UINT16, "0.01 deg", "100, 50 or 25, which goes with 100 deg alone; one client sends 0")


@dataclass(frozen=True)
class KeepSpeed:
    """66: which speed it has after it is switched on. This writes to its EEPROM."""

    keep: int = wire(BYTE, "", "0: 9600 baud, 1: the present one")


@dataclass(frozen=True)
class AskConfiguration:
    """74: the `Configuration`, please."""


@dataclass(frozen=True)
class WriteConfiguration:
    """77: write the configuration. The EEPROM lasts for a few thousand writes: use `AskConfiguration` first."""

    configuration: Configuration = wire(ConfigurationField(), "", "34 bytes or fewer")
