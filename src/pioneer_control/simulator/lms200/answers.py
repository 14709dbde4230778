"""What each request does to a simulated laser, and which reply it gets, as a table (laser sheet 1.2 to 1.4).

A function gets the device, its operation, and the request. It acts, and returns an `AnswerOfLaser`. Time is not its
business: the row says how long the laser takes before it acts.
"""

from typing import Any, Callable, Dict, NamedTuple, Optional

from ...lms2xx import (MEASURING_MODES, SPEEDS, VARIANTS, AskConfiguration, AskErrors, AskScan, AskStatus, AskType,
                       AskValues, Configuration, ConfigurationReply, ConfigurationWritten, ErrorsReply, KeepSpeed, Mode,
                       ModeSet, NotPossible, PartReply, ResetLaser, Resetting, ScanPart, ScanReply, SetMode, SetVariant,
                       SpeedKept, TypeReply, Unit, Variant, VariantSet, WriteConfiguration)
from .device import LaserDevice, Operation

DONE, WRONG_PASSWORD = 0, 1
"""Results of `ModeSet`."""
MOST_SENSITIVITY = 3
"""Largest `Configuration.sensitivity` (laser sheet 1.5)."""


class AnswerOfLaser(NamedTuple):
    """What a request leads to.

    Attributes:
        reply: the message that the laser sends.
        new_baud: speed of its line (baud) after the reply has left. None if it stays.
        resets: whether the laser resets itself after the reply has left.
    """

    reply: Any
    new_baud: Optional[int] = None
    resets: bool = False


REFUSED = AnswerOfLaser(NotPossible())


class AnswerRow(NamedTuple):
    """A row of `ANSWERS`.

    Attributes:
        act: function that answers a request.
        takes: name of the number in `FirmwareNumbers` that says how long the laser takes.
    """

    act: Callable[[LaserDevice, Operation, Any], AnswerOfLaser]
    takes: str = "other"


def reset(device: LaserDevice, operation: Operation, request: ResetLaser) -> AnswerOfLaser:
    """10: the laser says so, and begins anew."""
    return AnswerOfLaser(Resetting(), resets=True)


# -- modes

def set_mode(device: LaserDevice, operation: Operation, request: SetMode) -> AnswerOfLaser:
    """20: as `MODES` says. A mode that is not in there is not possible."""
    act = MODES.get(request.mode)
    return act(device, operation, request) if act else REFUSED


def enter(device: LaserDevice, operation: Operation, request: SetMode) -> AnswerOfLaser:
    """Change to a mode that needs nothing else."""
    operation.mode, operation.part, operation.since_us = request.mode, slice(None), device.clock.now_us
    return AnswerOfLaser(ModeSet(DONE))


def install(device: LaserDevice, operation: Operation, request: SetMode) -> AnswerOfLaser:
    """Change to the installation mode, if the password is right."""
    tested = check_password(device, operation, request)
    return enter(device, operation, request) if tested.reply == ModeSet(DONE) else tested


def check_password(device: LaserDevice, operation: Operation, request: SetMode) -> AnswerOfLaser:
    """Say whether the password is right. The mode stays."""
    return AnswerOfLaser(ModeSet(DONE if request.parameters == device.numbers.password else WRONG_PASSWORD))


def enter_with_part(device: LaserDevice, operation: Operation, request: SetMode) -> AnswerOfLaser:
    """Stream the values between two numbers, if a scan has them."""
    if len(request.parameters) != 4:
        return REFUSED
    first, last = (int.from_bytes(request.parameters[at:at + 2], "little") for at in (0, 2))
    if not 1 <= first <= last <= operation.variant.values:
        return REFUSED
    entered = enter(device, operation, request)
    operation.part = slice(first - 1, last)
    return entered


def change_speed(device: LaserDevice, operation: Operation, request: SetMode) -> AnswerOfLaser:
    """Change the speed. The reply still has the old one. The mode stays."""
    return AnswerOfLaser(ModeSet(DONE), new_baud=BAUDS[request.mode])


BAUDS: Dict[int, int] = {speed.mode: baud for baud, speed in SPEEDS.items()}
MODES: Dict[int, Callable[[LaserDevice, Operation, SetMode], AnswerOfLaser]] = {
    Mode.INSTALLATION: install,
    Mode.TEST_PASSWORD: check_password,
    Mode.DIAGNOSIS: enter,
    Mode.STREAM: enter,
    Mode.ON_REQUEST: enter,
    Mode.STREAM_OF_PARTIAL_SCANS: enter,
    Mode.STREAM_OF_A_PART: enter_with_part,
    **{mode: change_speed for mode in BAUDS},
}
"""What the modes of command 20 do. The sheet's other ones are not possible here."""


# -- scans

def send_scan(device: LaserDevice, operation: Operation, request: AskScan) -> AnswerOfLaser:
    """30: the newest scan, in mode ON_REQUEST only."""
    turn = operation.turns_ended(device.clock.now_us)
    if operation.mode != Mode.ON_REQUEST:
        return REFUSED
    if request.part == ScanPart.PARTIAL:
        return AnswerOfLaser(ScanReply(device.partial_scan(operation, turn)))
    values = SCAN_PARTS.get(request.part)
    return AnswerOfLaser(ScanReply(device.scan(operation, turn, values))) if values else REFUSED


SCAN_PARTS: Dict[int, slice] = {
    ScanPart.ALL: slice(None),
    ScanPart.EVERY_SECOND: slice(None, None, 2),
    ScanPart.EVERY_TWENTIETH: slice(None, None, 20),
}


def send_values(device: LaserDevice, operation: Operation, request: AskValues) -> AnswerOfLaser:
    """37: some values of the newest scan, in mode ON_REQUEST only."""
    if operation.mode != Mode.ON_REQUEST or not 1 <= request.first <= request.last <= operation.variant.values:
        return REFUSED
    scan = device.scan(operation, operation.turns_ended(device.clock.now_us), slice(request.first - 1, request.last))
    return AnswerOfLaser(PartReply(request.first, request.last, scan))


# -- what it is, how it is

def send_status(device: LaserDevice, operation: Operation, request: AskStatus) -> AnswerOfLaser:
    """31: all that the laser says of itself."""
    return AnswerOfLaser(device.status_reply(operation))


def send_errors(device: LaserDevice, operation: Operation, request: AskErrors) -> AnswerOfLaser:
    """32: two bytes for each error."""
    return AnswerOfLaser(ErrorsReply(b"".join(
        bytes((error.severity | (0x80 if error.is_old else 0), error.number)) for error in device.errors)))


def send_type(device: LaserDevice, operation: Operation, request: AskType) -> AnswerOfLaser:
    """3A: type and version."""
    return AnswerOfLaser(TypeReply(device.numbers.identity.encode("ascii")))


# -- what it keeps, and for how long

def set_variant(device: LaserDevice, operation: Operation, request: SetVariant) -> AnswerOfLaser:
    """3B: one of `VARIANTS`. A step of 0 means the present step, as one client needs it (laser sheet 1.9)."""
    wanted = Variant(request.angle_deg, request.step_hundredths or operation.variant.step_hundredths)
    accepted = wanted in VARIANTS
    if accepted and wanted != operation.variant:
        operation.variant, operation.since_us = wanted, device.clock.now_us
        if operation.part.stop is not None and operation.part.stop > wanted.values:     # the part is no more
            operation.mode, operation.part = Mode.ON_REQUEST, slice(None)
    return AnswerOfLaser(VariantSet(int(accepted), *operation.variant))


def keep_speed(device: LaserDevice, operation: Operation, request: KeepSpeed) -> AnswerOfLaser:
    """66: which speed the laser has after power-on. Each request writes to the EEPROM."""
    if request.keep not in (0, 1):
        return REFUSED
    device.eeprom.keeps_speed, device.eeprom.kept_baud = bool(request.keep), device.baud
    device.eeprom.writes += 1
    return AnswerOfLaser(SpeedKept(1, request.keep))


def send_configuration(device: LaserDevice, operation: Operation, request: AskConfiguration) -> AnswerOfLaser:
    """74: the configuration, 34 bytes."""
    return AnswerOfLaser(ConfigurationReply(device.eeprom.configuration))


def write_configuration(device: LaserDevice, operation: Operation, request: WriteConfiguration) -> AnswerOfLaser:
    """77: write what the request has, and keep the rest, in mode INSTALLATION only."""
    if operation.mode != Mode.INSTALLATION:
        return REFUSED
    wanted = request.configuration.over(device.eeprom.configuration)
    accepted = is_legal(wanted)
    if accepted:
        device.eeprom.configuration = wanted
        device.eeprom.writes += 1
    return AnswerOfLaser(ConfigurationWritten(int(accepted), device.eeprom.configuration))


def is_legal(configuration: Configuration) -> bool:
    """Return whether the laser can measure with a configuration. It does not measure the strength of an echo."""
    mode = MEASURING_MODES.get(configuration.measuring_mode)
    return (mode is not None and not mode.is_strength and configuration.sensitivity <= MOST_SENSITIVITY
            and configuration.unit in list(Unit))


ANSWERS: Dict[Any, AnswerRow] = {
    ResetLaser: AnswerRow(reset),
    SetMode: AnswerRow(set_mode, "mode_change"),
    AskScan: AnswerRow(send_scan),
    AskStatus: AnswerRow(send_status),
    AskErrors: AnswerRow(send_errors),
    AskValues: AnswerRow(send_values),
    AskType: AnswerRow(send_type),
    SetVariant: AnswerRow(set_variant, "variant_change"),
    KeepSpeed: AnswerRow(keep_speed, "eeprom_write"),
    AskConfiguration: AnswerRow(send_configuration),
    WriteConfiguration: AnswerRow(write_configuration, "eeprom_write"),
}
"""All requests that the laser knows. Reply 92 answers all others, and those whose data are too short."""
NOT_KNOWN = AnswerRow(lambda device, operation, request: REFUSED)


def row_of(request: Any) -> AnswerRow:
    """Return the row of a request."""
    return ANSWERS.get(type(request), NOT_KNOWN)
