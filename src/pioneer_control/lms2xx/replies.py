"""Every reply of a laser, as a frozen dataclass that is also its table (laser sheet 1.3, 1.6)."""

from dataclasses import dataclass
from typing import List, NamedTuple, Tuple

from ..wire_fields import BYTE, REST, UINT16, Many, TextField, wire
from .configuration import Configuration, ConfigurationField
from .scans import RawScan, ScanField


@dataclass(frozen=True)
class PowerOn:
    """90: the laser is ready. It comes unasked after power came, and after a reset."""

    text: bytes = wire(REST, "", "type and version, such as ``LMS200;301063;V02.10 ``")


@dataclass(frozen=True)
class Resetting:
    """91: the laser will reset itself."""


@dataclass(frozen=True)
class NotPossible:
    """92: the request arrived whole, but is not legal now, or never."""


@dataclass(frozen=True)
class ModeSet:
    """A0: the answer to `SetMode`."""

    result: int = wire(BYTE, "", "0 is done, 1 a wrong password, all others a fault")


@dataclass(frozen=True)
class ScanReply:
    """B0: a scan."""

    scan: RawScan = wire(ScanField(), "", "")


@dataclass(frozen=True)
class StatusReply:
    """B1: all that a laser says of itself. What the sheet does not explain is called reserved."""

    version: str = wire(TextField(7), "", "of its firmware")
    mode: int = wire(BYTE, "", "a `Mode`")
    defect: int = wire(BYTE, "", "0: none")
    reserved_10: Tuple[int, ...] = wire(Many(BYTE, count=8), "", "")
    variant: int = wire(BYTE, "", "")
    reserved_19: Tuple[int, ...] = wire(Many(BYTE, count=48), "", "")
    turn_us_90ths: int = wire(UINT16, "us", "time of 1/90 of a turn of the mirror")
    reserved_69: Tuple[int, ...] = wire(Many(BYTE, count=33), "", "")
    measuring_mode: int = wire(BYTE, "", "a key of `MEASURING_MODES`")
    reserved_103: Tuple[int, ...] = wire(Many(BYTE, count=4), "", "")
    angle_deg: int = wire(UINT16, "deg", "how wide it looks")
    step_hundredths: int = wire(UINT16, "0.01 deg", "between two rays")
    restart: int = wire(BYTE, "", "")
    reserved_112: Tuple[int, ...] = wire(Many(BYTE, count=4), "", "")
    speed_word: int = wire(UINT16, "", "a `Speed.word`")
    reserved_118: int = wire(BYTE, "", "2 in the manual's example")
    keeps_speed: int = wire(BYTE, "", "1: also after it is switched off")
    address: int = wire(BYTE, "", "")
    reserved_121: int = wire(BYTE, "", "")
    unit: int = wire(BYTE, "", "a `Unit`")
    laser: int = wire(BYTE, "", "1 is on")
    prom_version: str = wire(TextField(7), "", "")
    reserved_131: Tuple[int, ...] = wire(Many(BYTE, count=22), "", "")


class DeviceError(NamedTuple):
    """One error of a laser: a `Severity`, its number, and whether it is over."""

    severity: int
    number: int
    is_old: bool


@dataclass(frozen=True)
class ErrorsReply:
    """B2: the errors of a laser."""

    pairs: bytes = wire(REST, "", "two bytes for each error")

    @property
    def errors(self) -> List[DeviceError]:
        """The errors. A byte without a second is none."""
        return [DeviceError(kind & 0x7F, number, bool(kind & 0x80))
                for kind, number in zip(self.pairs[::2], self.pairs[1::2])]


@dataclass(frozen=True)
class PartReply:
    """B7: the values of some rays of a scan."""

    first: int = wire(UINT16, "", "number of the first value, from 1 on")
    last: int = wire(UINT16, "", "number of the last value")
    scan: RawScan = wire(ScanField(), "", "")


@dataclass(frozen=True)
class TypeReply:
    """BA: which laser it is."""

    text: bytes = wire(REST, "", "as in `PowerOn`")


@dataclass(frozen=True)
class VariantSet:
    """BB: the answer to `SetVariant`."""

    accepted: int = wire(BYTE, "", "1: done, 0: refused")
    angle_deg: int = wire(UINT16, "deg", "how wide it looks now")
    step_hundredths: int = wire(UINT16, "0.01 deg", "between two rays now")


@dataclass(frozen=True)
class SpeedKept:
    """E6: the answer to `KeepSpeed`."""

    accepted: int = wire(BYTE, "", "1: done")
    keep: int = wire(BYTE, "", "as it was asked for")


@dataclass(frozen=True)
class ConfigurationReply:
    """F4: the configuration, 34 bytes; 32 of older firmware."""

    configuration: Configuration = wire(ConfigurationField(), "", "")


@dataclass(frozen=True)
class ConfigurationWritten:
    """F7: the answer to `WriteConfiguration`."""

    accepted: int = wire(BYTE, "", "1: written, 0: refused. Read the configuration again: sources disagree")
    configuration: Configuration = wire(ConfigurationField(), "", "that holds now")
