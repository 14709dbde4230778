"""Every packet that a robot sends, as a frozen dataclass, and its frame ids (protocol sheet 2 and 5).

The two large packets, `Sip` and `Config`, have their own files.
"""

from dataclasses import dataclass
from typing import Any, Dict, List, NamedTuple, Tuple

from ..errors import EncodingError
from ..wire_fields import (BYTE, INT16, INT32, REST, STRING, UINT16, UINT32, Many, Record, Table, TextField, TooShort,
                           made, read_fields, rows, wire, write_fields)
from .config import Config
from .flags import GripperSwitches, GripState
from .framing import Frame, encode_frame
from .sip import Sip


@dataclass(frozen=True)
class SyncEcho:
    """The robot's answer to SYNC0 or SYNC1: the same packet, with the same number (0 or 1)."""

    number: int


@dataclass(frozen=True)
class SyncReply:
    """The robot's answer to SYNC2: its name, class and model."""

    name: str = wire(STRING, "", "name of this robot, set by its user")
    type: str = wire(STRING, "", "robot class: `Pioneer` (Pioneer LX: `MTX`)")
    subtype: str = wire(STRING, "", "model, such as `p3dx-sh`; compare without regard to case")


@dataclass(frozen=True)
class Encoder:
    """ENCODERpac: accumulated raw ticks of the wheel encoders."""

    left_ticks: int = wire(INT32, "ticks", "left wheel")
    right_ticks: int = wire(INT32, "ticks", "right wheel")


@dataclass(frozen=True)
class SerialAux:
    """SERAUXpac, SERAUX2pac, SERAUX3pac: bytes from a device on auxiliary port 1, 2 or 3."""

    port: int
    data: bytes = wire(REST, "", "raw bytes")


@dataclass(frozen=True)
class Gripper:
    """GRIPPERpac: kind and state of the gripper.

    `state` has the bits of `GripState`. PSOS, P2OS and AmigOS send the bits of `GripperSwitches` instead.
    """

    has_gripper: int = wire(BYTE, "", "0 is none; other numbers depend on the firmware")
    state: int = wire(BYTE.of(GripState), "", "as in the SIP")
    grasp_time_units: int = wire(BYTE, "20 ms", "how long the paddles go on closing")


@dataclass(frozen=True)
class IO:
    """IOpac: inputs and outputs. Digital bits are electrical levels (bumpers and infrared: 0 means triggered)."""

    digital_in: Tuple[int, ...] = wire(Many(BYTE), "", "user inputs, front bumpers, rear bumpers, infrared")
    digital_out: Tuple[int, ...] = wire(Many(BYTE), "", "user outputs")
    analog: Tuple[int, ...] = wire(Many(UINT16), "", "AROS: 5 values of 12 bits; ARCOS: 9 of 10 bits, 1023 is 5 V")


class GyroReading(NamedTuple):
    """One reading of the gyro, over 25 ms."""

    rate: int = wire(UINT16, "", "0..1023, about 512 at rest, below it counter-clockwise; full scale 300 deg/s")
    temperature: int = wire(BYTE, "", "0..255")


@dataclass(frozen=True)
class Gyro:
    """GYROpac: readings of a gyro that the client has to read (has_gyro 1 in CONFIGpac)."""

    readings: Tuple[GyroReading, ...] = wire(Many(Record(GyroReading)), "", "one per 25 ms")


@dataclass(frozen=True)
class Arm:
    """ARMpac: state of the Pioneer Arm, in the layout of the manual.

    The vendor's client reads byte 1 as motion, and byte 2 as status (bit 0 good, 1 initialised, 2 power, 3 homing).
    Some robots send this other layout.
    """

    status_bits: int = wire(BYTE, "", "bit 0 servo power, bit 1 connected")
    motion_bits: int = wire(BYTE, "", "bit 0 joint 1 moves, ...")
    positions: Tuple[int, ...] = wire(Many(BYTE, count=6), "ticks", "servos 1..6")


class ArmJoint(NamedTuple):
    """Speed and positions of one joint of the arm. Positions are in servo ticks."""

    speed_ms: int = wire(BYTE, "ms", "time of one tick")
    home: int = wire(BYTE, "ticks", "")
    minimum: int = wire(BYTE, "ticks", "")
    centre: int = wire(BYTE, "ticks", "")
    maximum: int = wire(BYTE, "ticks", "")
    ticks_per_90_deg: int = wire(BYTE, "ticks", "joint 6, the gripper, has no angle")


@dataclass(frozen=True)
class ArmInfo:
    """ARMINFOpac: version and joints of the Pioneer Arm."""

    version: str = wire(STRING, "", "of the arm's server; `No arm` without one")
    joints: Tuple[ArmJoint, ...] = wire(Many(Record(ArmJoint)), "", "")


@dataclass(frozen=True)
class Joystick:
    """JOYSTICKpac: buttons and axes of a joystick. An axis has 0..1023, with 512 in the middle."""

    button_1: int = wire(BYTE, "", "1 pressed")
    button_2: int = wire(BYTE, "", "1 pressed")
    x: int = wire(UINT16, "", "")
    y: int = wire(UINT16, "", "")
    throttle: int = wire(UINT16, "", "")


@dataclass(frozen=True)
class TCM2:
    """TCM2pac: readings of a TCM2 compass module."""

    heading_ddeg: int = wire(INT16, "0.1 deg", "")
    pitch_ddeg: int = wire(INT16, "0.1 deg", "")
    roll_ddeg: int = wire(INT16, "0.1 deg", "")
    magnetic_x_hundredths: int = wire(INT16, "0.01", "")
    magnetic_y_hundredths: int = wire(INT16, "0.01", "")
    magnetic_z_hundredths: int = wire(INT16, "0.01", "")
    temperature_dc: int = wire(INT16, "0.1 deg C", "")
    error_bits: int = wire(INT16, "", "")
    calibration_h: int = wire(BYTE, "", "")
    calibration_v: int = wire(BYTE, "", "")
    calibration_m_hundredths: int = wire(INT16, "0.01", "")


@dataclass(frozen=True)
class Playlist:
    """PLAYLIST: one stored sound of an AmigoBot.

    P2OS robots answer with 25 zero bytes. This is one byte too few, and gives a `MalformedPacket`.
    """

    sound: int = wire(BYTE, "", "its number; in the first of all, how many there are")
    enabled: int = wire(BYTE, "", "1 if sounds are on")
    name: str = wire(TextField(16), "", "a leading ~ marks a group")
    offset: int = wire(UINT32, "", "")
    length: int = wire(UINT32, "", "")


class Battery(NamedTuple):
    """State of one battery that measures its own charge."""

    flags1: int = wire(BYTE, "", "")
    flags2: int = wire(BYTE, "", "")
    flags3: int = wire(BYTE, "", "")
    relative_charge_percent: int = wire(BYTE, "%", "")
    absolute_charge_percent: int = wire(BYTE, "%", "")


@dataclass(frozen=True)
class BatteryInfo:
    """Answer to BATTERYINFO: the state of each battery."""

    batteries: Tuple[Battery, ...] = wire(Many(Record(Battery), sized=True), "", "")


@dataclass(frozen=True)
class Reset:
    """The controller has restarted (id 0xFF). With id 0xFE the packet has data about the restart."""

    id: int
    data: bytes = wire(REST, "", "")


@dataclass(frozen=True)
class SimulatedLaser:
    """Part of a scan of a simulated laser: the pose of the robot, and ranges."""

    x: int = wire(INT16, "mm", "robot")
    y: int = wire(INT16, "mm", "robot")
    heading: int = wire(INT16, "deg", "robot")
    total: int = wire(UINT16, "", "readings of the whole scan")
    first: int = wire(UINT16, "", "index of the first one here")
    ranges_mm: Tuple[int, ...] = wire(Many(UINT16), "mm", "")


class LaserReading(NamedTuple):
    """One reading of a simulated laser, with reflectance."""

    range_mm: int = wire(UINT16, "mm", "")
    reflectance: int = wire(BYTE, "", "")
    reserved: int = wire(UINT16, "", "")


@dataclass(frozen=True)
class SimulatedLaserExtended:
    """Part of a scan of a simulated laser, with reflectance."""

    total: int = wire(UINT16, "", "readings of the whole scan")
    first: int = wire(UINT16, "", "index of the first one here")
    readings: Tuple[LaserReading, ...] = wire(Many(Record(LaserReading)), "", "")
    laser: int = wire(BYTE, "", "which laser")
    flags: int = wire(BYTE, "", "bit 0: the robot was moved")


@dataclass(frozen=True)
class SimulatorStatus:
    """SIMSTAT: state of a simulated robot, with its true pose and its odometry error."""

    text_1: str = wire(STRING, "", "empty")
    text_2: str = wire(STRING, "", "empty")
    flags: int = wire(UINT32, "", "")
    times: Tuple[int, ...] = wire(Many(UINT16, count=3), "", "")
    x_mm: int = wire(INT32, "mm", "true pose")
    y_mm: int = wire(INT32, "mm", "true pose")
    z_mm: int = wire(INT32, "mm", "true pose")
    heading_deg: int = wire(INT32, "deg", "true pose")
    latitude: int = wire(INT32, "1/10000000 deg", "")
    longitude: int = wire(INT32, "1/10000000 deg", "")
    altitude: int = wire(INT32, "0.01 m", "")
    dilution_of_precision: int = wire(INT32, "0.01", "")
    error_x: int = wire(INT32, "", "odometry error")
    error_y: int = wire(INT32, "", "odometry error")
    error_heading: int = wire(INT32, "", "odometry error")


class SimulatedDevice(NamedTuple):
    """One device of a simulated robot."""

    name: str = wire(STRING, "", "")
    type: str = wire(STRING, "", "")
    number: int = wire(BYTE, "", "")
    status: int = wire(UINT32, "", "")


@dataclass(frozen=True)
class SimulatorInfo:
    """SIMINFO: the simulator program, and the devices of the simulated robot."""

    application: str = wire(STRING, "", "")
    version: str = wire(STRING, "", "")
    features: int = wire(UINT32, "", "")
    devices: Tuple[SimulatedDevice, ...] = wire(Many(Record(SimulatedDevice), count=UINT32), "", "")


@dataclass(frozen=True)
class MapChanged:
    """A simulator has loaded another map."""

    by_user: int = wire(BYTE, "", "")
    status: int = wire(BYTE, "", "")
    map_name: str = wire(STRING, "", "")


@dataclass(frozen=True)
class UnknownPacket:
    """A whole frame with an id that is in no table. Programs should ignore it."""

    id: int
    data: bytes


@dataclass(frozen=True)
class MalformedPacket:
    """A whole frame whose data are too short for its id. `reason` names the field that is incomplete."""

    id: int
    data: bytes
    reason: str


PACKETS: Dict[int, Tuple[Any, Dict[str, int]]] = {
    0x00: (SyncEcho, {"number": 0}),
    0x01: (SyncEcho, {"number": 1}),
    0x02: (SyncReply, {}),
    0x20: (Config, {}),
    0x30: (Sip, {"type_id": 0x30}),
    0x31: (Sip, {"type_id": 0x31}),
    0x32: (Sip, {"type_id": 0x32}),
    0x33: (Sip, {"type_id": 0x33}),
    0x34: (Sip, {"type_id": 0x34}),
    0x60: (SimulatedLaser, {}),
    0x61: (SimulatedLaserExtended, {}),
    0x62: (SimulatorStatus, {}),
    0x63: (SimulatorInfo, {}),
    0x66: (MapChanged, {}),
    0x90: (Encoder, {}),
    0x98: (Gyro, {}),
    0xA0: (Arm, {}),
    0xA1: (ArmInfo, {}),
    0xB0: (SerialAux, {"port": 1}),
    0xB8: (SerialAux, {"port": 2}),
    0xC8: (SerialAux, {"port": 3}),
    0xC0: (TCM2, {}),
    0xD0: (Playlist, {}),
    0xE0: (Gripper, {}),
    0xF0: (IO, {}),
    0xF8: (Joystick, {}),
    0xFA: (BatteryInfo, {}),
    0xFE: (Reset, {"id": 0xFE}),
    0xFF: (Reset, {"id": 0xFF}),
}
"""By frame id: the class of the packet, and the fields whose values come from the id."""

_IDS: Dict[Any, List[Tuple[int, Dict[str, int]]]] = {
    packet_class: [(id, said) for id, (known, said) in PACKETS.items() if known is packet_class]
    for packet_class, _ in PACKETS.values()}

NAMES_ONLY = {
    0x7B: "acceleration",
    0x7C: "torque",
    0x95: "heading",
    0x9A: "IMU",
    0xD3: "MARC debug text",
    0xD5: "absolute maxima",
    0xDA: "wheel information",
}
"""Names of packets whose data no readable source describes (Seekur, Pioneer LX). They become an `UnknownPacket`."""


def _port_first(table: Table) -> Table:
    """The table of a `Sip` of PSOS, P2OS and AmigOS, made from `table`: the analog port is before the gripper state."""
    at = [row.name for row in table].index("grip_state")
    return Table(table[:at] + (table[at + 1], table[at]) + table[at + 2:])


_TABLES = {True: {packet_class: rows(packet_class) for packet_class in _IDS}}
_TABLES[False] = {
    **_TABLES[True],
    Sip: _port_first(rows(Sip)),
    Gripper: Table(row._replace(type=BYTE.of(GripperSwitches)) if row.name == "state" else row
                   for row in rows(Gripper)),
}
"""The tables of all packets, first by `grip_state_first` (see `decode_packet`), then by packet class."""


def packet_rows(packet_class: Any, grip_state_first: bool = True) -> Table:
    """The table of a packet class, for the kind of firmware that `grip_state_first` gives (see `decode_packet`)."""
    return _TABLES[grip_state_first].get(packet_class, Table())


def decode_packet(frame: Frame, grip_state_first: bool = True) -> Any:
    """The packet in a frame from the robot: an object of one of the packet classes.

    Never raises. A frame with an id that is in no table becomes an `UnknownPacket`. A frame whose data end too soon
    becomes a `MalformedPacket`. Bytes behind the last field are ignored.

    Args:
        frame: from a `FrameDecoder`.
        grip_state_first: the kind of firmware, which the bytes do not show. True for AROS, ARCOS and AmigoSH: their SIP
            has the gripper state before the analog port, and their GRIPPERpac has the same gripper state. False for
            PSOS, P2OS and AmigOS: their SIP has the analog port first, and their GRIPPERpac has switches.
    """
    number, data = frame
    if number not in PACKETS:
        return UnknownPacket(number, data)
    packet_class, said_by_id = PACKETS[number]
    try:
        values, _ = read_fields(_TABLES[grip_state_first][packet_class], data)
    except TooShort as short:
        malformed = MalformedPacket(number, data, "%s.%s" % (packet_class.__name__, short))
        return SyncEcho(2) if number == 2 and not data else malformed
    values.update(said_by_id)
    return made(packet_class, values)


def encode_packet(packet: Any, grip_state_first: bool = True) -> bytes:
    """The bytes of `packet`, as a robot sends them; `grip_state_first` as in `decode_packet`.

    Raises:
        EncodingError: `packet` is not a packet that robots send, or one of its values does not fit its field.
    """
    if isinstance(packet, (UnknownPacket, MalformedPacket)):
        return encode_frame(packet.id, packet.data)
    for id, said_by_id in _IDS.get(type(packet), ()):
        if said_by_id.items() <= vars(packet).items():
            return encode_frame(id, write_fields(packet_rows(type(packet), grip_state_first), packet))
    if packet == SyncEcho(2):
        return encode_frame(2)
    raise EncodingError("no robot sends %r" % (packet,))
