"""Commands to the robot: one table (protocol sheet 3), and functions that encode and decode commands by it.

The argument of a command is one of these byte sequences (protocol sheet 1.3)::

    (nothing)              no argument at all
    3B low high            an integer that is not negative
    1B low high            a negative integer; the bytes give its magnitude
    2B length bytes...     a string: as many bytes as its length byte says
"""

from enum import Enum
from typing import Any, Dict, NamedTuple, Tuple, Union

from ..errors import EncodingError
from ..wire_fields import checked_bytes, checked_integer
from .framing import Frame, encode_frame

SYNC0, SYNC1, SYNC2 = 0, 1, 2
"""Command numbers of the handshake. In a session the same numbers mean PULSE, OPEN, CLOSE."""

POSITIVE, NEGATIVE, TEXT = 0x3B, 0x1B, 0x2B


Argument = Enum("Argument", {
    "NONE": "no argument",
    "INT": "signed integer",
    "UINT": "unsigned integer",
    "TWO_BYTES": "two bytes in one integer",
    "STRING": "string",
})
"""The kinds of argument that a command can have."""

NONE, INT, UINT, TWO_BYTES, STRING = tuple(Argument)


class Command(NamedTuple):
    """One row of the table of commands.

    `low` and `high` are the limits of the argument. For a STRING they limit its length in bytes. For TWO_BYTES each is
    a pair: first for the byte in bits 8..15, then for the byte in bits 0..7. They are None for a command without an
    argument. An `optional` argument may be left out. `effect` says what the command does, in which unit.
    """

    number: int
    name: str
    argument: Argument
    low: Any
    high: Any
    effect: str
    optional: bool = False


INT_MAX, UINT_MAX, STRING_MAX = 0x7FFF, 0xFFFF, 195

BAUD_RATES = (9600, 19200, 38400, 57600, 115200)
"""Line speeds in the order of their codes 0 to 4, which HOSTBAUD, AUX1BAUD to AUX3BAUD and CONFIGpac use."""

COMMANDS: Dict[str, Command] = {command.name: command for command in (
    # Session
    Command(0, "PULSE", NONE, None, None, "reset the watchdog, nothing else (SYNC0 before a session)"),
    Command(1, "OPEN", UINT, 1, 1, "start servers and SIPs (SYNC1 before a session)", optional=True),
    Command(2, "CLOSE", UINT, 1, 1, "end the session: motors off, SIPs stop (SYNC2 before a session)", optional=True),
    # Motion
    Command(4, "ENABLE", INT, 0, 1, "motor power: 1 on, 0 off"),
    Command(5, "SETA", INT, -INT_MAX, INT_MAX, "mm/s^2: + acceleration, - deceleration"),
    Command(6, "SETV", UINT, 0, UINT_MAX, "mm/s: greatest translation speed"),
    Command(7, "SETO", NONE, None, None, "the robot's own pose becomes 0, 0, 0"),
    Command(8, "MOVE", INT, -5000, 5000, "mm: translate that far at SETV"),
    Command(9, "ROTATE", INT, -INT_MAX, INT_MAX, "deg/s, + counter-clockwise: sources disagree, use RVEL"),
    Command(10, "SETRV", UINT, 0, UINT_MAX, "deg/s: greatest rotation speed"),
    Command(11, "VEL", INT, -INT_MAX, INT_MAX, "mm/s, + forward: translation speed"),
    Command(12, "HEAD", INT, -360, 360, "deg, absolute: turn to that heading, the shortest way"),
    Command(13, "DHEAD", INT, -INT_MAX, INT_MAX, "deg, + counter-clockwise: turn relative to the heading"),
    Command(14, "SETRVDIR_ARCOS", INT, -INT_MAX, INT_MAX, "deg/s: + counter-clockwise, - clockwise limit (ARCOS 2.8)"),
    Command(20, "SETRVDIR", INT, -INT_MAX, INT_MAX, "deg/s: the same limit, as another manual numbers it"),
    Command(21, "RVEL", INT, -INT_MAX, INT_MAX, "deg/s, + counter-clockwise: rotation speed"),
    Command(22, "DCHEAD", INT, -INT_MAX, INT_MAX, "deg: turn relative to the heading set point"),
    Command(23, "SETRA", INT, -INT_MAX, INT_MAX, "deg/s^2: + acceleration, - deceleration"),
    Command(29, "STOP", NONE, None, None, "stop with normal deceleration, motors stay enabled"),
    Command(32, "VEL2", TWO_BYTES, (-127, -127), (127, 127), "left, right wheel in 20 mm/s (Pioneer 1: 4)"),
    Command(55, "E_STOP", INT, -INT_MAX, INT_MAX, "stop at once, until a new velocity or heading", optional=True),
    Command(57, "QSTOP", NONE, None, None, "Pioneer LX: stop at once"),
    Command(110, "LATVEL", INT, -INT_MAX, INT_MAX, "mm/s, + left: lateral speed (Seekur)"),
    Command(113, "LATACCEL", INT, -INT_MAX, INT_MAX, "mm/s^2: + acceleration, - deceleration (Seekur)"),
    Command(120, "RECENTERWHEELS", NONE, None, None, "Seekur"),
    Command(150, "ROTVEL_CLOSEDLOOP_ENABLE", INT, 0, 1, "Pioneer LX"),
    # Data requests
    Command(17, "JOYREQUEST", UINT, 0, 2, "JOYSTICKpac: 0 stop, 1 once, 2 continuous"),
    Command(18, "CONFIG", INT, -INT_MAX, INT_MAX, "CONFIGpac once", optional=True),
    Command(19, "ENCODER", UINT, 0, UINT_MAX, "ENCODERpac: 0 stop, 1 once, 2 and more continuous"),
    Command(26, "IMUREQUEST", UINT, 0, 2, "IMU packet: 0 stop, 1 once, 2 continuous"),
    Command(37, "GRIPREQUEST", UINT, 0, UINT_MAX, "GRIPPERpac: 0 stop, 1 once, 2 and more continuous"),
    Command(40, "IOREQUEST", UINT, 0, UINT_MAX, "IOpac: 0 stop, 1 once, 2 and more continuous"),
    Command(58, "GYRO", UINT, 0, 2, "GYROpac: 0 stop, 1 start; gyro in the robot: 0 encoders, 1 fused, 2 gyro only"),
    Command(62, "BATTERYINFO", UINT, 0, 2, "battery information: 0 stop, 1 once, 2 continuous"),
    Command(91, "PLAYLIST", UINT, 0, UINT_MAX, "PLAYLIST: 0 all sounds, n one"),
    Command(123, "ACCELINFO", UINT, 0, 2, "0 stop, 1 once, 2 continuous (Pioneer LX, Seekur)"),
    Command(124, "TORQUEINFO", UINT, 0, 2, "0 stop, 1 once, 2 continuous (Pioneer LX, Seekur)"),
    Command(149, "HEADINGINFO", UINT, 0, 2, "0 stop, 1 once, 2 continuous (Pioneer LX, Seekur)"),
    Command(214, "SAFETY_STATE_INFO", INT, -INT_MAX, INT_MAX, "Pioneer LX"),
    Command(218, "WHEELINFO_REQUEST", INT, -INT_MAX, INT_MAX, "Pioneer LX"),
    # Sensors, inputs and outputs, accessories
    Command(3, "POLLING", STRING, 0, 64, "firing sequence: sonar numbers from 1, as bytes; empty: sonar off"),
    Command(15, "SAY", STRING, 0, 40, "pairs of duration (20 ms) and tone"),
    Command(28, "SONAR", INT, 0, INT_MAX, "1 on, 0 off"),
    Command(30, "DIGOUT", TWO_BYTES, (0, 0), (255, 255), "mask of the outputs to change, their new states"),
    Command(31, "TIMER", TWO_BYTES, (0, 0), (255, 255), "SETPBIOPORT: port, 1 on or 0 off (power board)"),
    Command(35, "ADSEL", UINT, 0, 7, "analog port shown in the SIP (P2OS 1..5)"),
    Command(38, "GYROCALCW", UINT, 0, UINT_MAX, "gyro calibration, clockwise"),
    Command(39, "GYROCALCCW", UINT, 0, UINT_MAX, "gyro calibration, counter-clockwise"),
    Command(41, "PTUPOS", TWO_BYTES, (1, 0), (4, 255), "servo port, pulse width (10 us; PSOS 100 us; 0 off)"),
    Command(45, "TCM2", INT, 0, 7, "compass: 0 off, 1 in the SIP, 2 once, 3 continuous, 4..6 calibrate, 7 reset"),
    Command(46, "DOCK", INT, 0, 2, "0 off, 1 signals, 2 signals and stop when power is sensed"),
    Command(47, "JOYDRIVE", INT, 0, 1, "1 lets a joystick on the robot drive"),
    Command(48, "SONARCYCLE", UINT, 2, 120, "ms: time of a ping in each array"),
    Command(49, "MOVINGBLINK", INT, 0, 1, "PatrolBot"),
    Command(59, "LCDWRITE", STRING, 0, 24, "three control bytes, text of up to 20 characters, NUL"),
    Command(65, "CALCOMP", INT, -INT_MAX, INT_MAX, "compass calibration"),
    Command(68, "CHARGE", INT, 0, 1, "autocharger: 1 deploy, 0 release"),
    Command(90, "SOUND", UINT, 0, UINT_MAX, "play a stored sound (AmigoBot)"),
    Command(92, "SOUNDTOG", INT, 0, 1, "buzzer and sounds: 1 on, 0 mute"),
    Command(95, "POWER_PC", INT, 0, 1, "supply on or off"),
    Command(96, "POWER_LRF", INT, 0, 1, "supply on or off"),
    Command(97, "POWER_5V", INT, 0, 1, "supply on or off"),
    Command(98, "POWER_12V", INT, 0, 1, "supply on or off (also listed as 24 V)"),
    Command(116, "POWER_DEVICE", TWO_BYTES, (0, 0), (255, 255), "port, 1 on or 0 off (Seekur)"),
    Command(125, "POWER_AUX_PC", INT, 0, 1, "supply on or off"),
    Command(126, "POWER_TOUCHSCREEN", INT, 0, 1, "supply on or off"),
    Command(127, "POWER_PTZ", INT, 0, 1, "supply on or off"),
    Command(128, "POWER_AUDIO", INT, 0, 1, "supply on or off"),
    Command(129, "POWER_LRF2", INT, 0, 1, "supply on or off"),
    # Gripper
    Command(33, "GRIPPER", INT, 1, 17, "a GripperCommand: 1 open, 2 close, 3 stop, 4 lift up, 5 lift down, ..."),
    Command(36, "GRIPPERVAL", INT, -255, 255, "20 ms: value for a GRIPPER PRESSURE or CARRY right before it"),
    # Serial pass-through
    Command(42, "TTY2", STRING, 0, STRING_MAX, "bytes for AUX1"),
    Command(43, "GETAUX", UINT, 0, 253, "collect n bytes of AUX1, answer SERAUXpac; 0 flushes"),
    Command(50, "HOSTBAUD", UINT, 0, 4, "baud code: 0..4 are 9600, 19200, 38400, 57600, 115200"),
    Command(51, "AUX1BAUD", UINT, 0, 4, "baud code"),
    Command(52, "AUX2BAUD", UINT, 0, 4, "baud code"),
    Command(53, "AUX3BAUD", UINT, 0, 4, "baud code"),
    Command(60, "TTY4", STRING, 0, STRING_MAX, "bytes for AUX3"),
    Command(61, "GETAUX3", UINT, 0, 253, "collect n bytes of AUX3, answer SERAUX3pac; 0 flushes"),
    Command(66, "TTY3", STRING, 0, STRING_MAX, "bytes for AUX2"),
    Command(67, "GETAUX2", UINT, 0, 253, "collect n bytes of AUX2, answer SERAUX2pac; 0 flushes"),
    # Safety and tuning
    Command(44, "BUMPSTALL", INT, 0, 3, "bumpers that stall the wheels: 0 none, 1 front, 2 rear, 3 both"),
    Command(56, "E_STALL", INT, 0, 1, "whether the STOP button stalls the wheels"),
    Command(82, "ROTKP", UINT, 0, UINT_MAX, "rotation PID"),
    Command(83, "ROTKV", UINT, 0, UINT_MAX, "rotation PID"),
    Command(84, "ROTKI", UINT, 0, UINT_MAX, "rotation PID"),
    Command(85, "TRANSKP", UINT, 0, UINT_MAX, "translation PID"),
    Command(86, "TRANSKV", UINT, 0, UINT_MAX, "translation PID"),
    Command(87, "TRANSKI", UINT, 0, UINT_MAX, "translation PID"),
    Command(88, "REVCOUNT", UINT, 0, UINT_MAX, "differential encoder count of a turn"),
    Command(89, "DRIFTFACTOR", INT, -INT_MAX, INT_MAX, "straight-line correction"),
    Command(93, "TICKSMM", UINT, 0, UINT_MAX, "encoder ticks of a mm"),
    Command(250, "BATTEST", UINT, 0, UINT_MAX, "0.1 V: pretend this voltage, 0 real (AROS 1.6: 2 shuts the PC down)"),
    Command(253, "RESET", NONE, None, None, "restart the controller"),
    Command(255, "MAINTENANCE", NONE, None, None, "leave normal operation: never send by accident"),
    # Pioneer Arm
    Command(70, "ARM_INFO", NONE, None, None, "one ARMINFOpac"),
    Command(71, "ARM_STATUS", UINT, 0, 2, "ARMpac: 0 stop, 1 once, 2 continuous"),
    Command(72, "ARM_INIT", NONE, None, None, "warm reset of the arm"),
    Command(73, "ARM_CHECK", NONE, None, None, "test that the arm answers; result in ARMpac"),
    Command(74, "ARM_POWER", INT, 0, 1, "servo power"),
    Command(75, "ARM_HOME", UINT, 1, 255, "joint 1..6, 255 all"),
    Command(76, "ARM_PARK", NONE, None, None, "home, then power off"),
    Command(77, "ARM_POS", TWO_BYTES, (1, 0), (6, 255), "joint, position in ticks"),
    Command(78, "ARM_SPEED", TWO_BYTES, (1, 1), (6, 127), "joint, ms per tick (more is slower)"),
    Command(79, "ARM_STOP", UINT, 1, 255, "joint 1..6, 255 all"),
    Command(80, "ARM_AUTOPARK", UINT, 0, UINT_MAX, "s without arm command until it parks, 0 never"),
    Command(81, "ARM_GRIPPARK", UINT, 0, UINT_MAX, "s the arm's gripper stays closed, 0 ever"),
)}
"""Every command a Pioneer knows, by name."""

UNKNOWN_TO: Dict[str, Tuple[str, ...]] = {
    **dict.fromkeys(("SETA", "SETRA", "BUMPSTALL", "E_STALL", "REVCOUNT", "ENCODER"), ("PSOS",)),
    **dict.fromkeys(("ROTKP", "ROTKV", "ROTKI", "TRANSKP", "TRANSKV", "TRANSKI"), ("PSOS",)),
    **dict.fromkeys(("DRIFTFACTOR", "TICKSMM", "BATTEST"), ("PSOS", "P2OS", "AROS", "AmigOS")),
    **dict.fromkeys(("SONARCYCLE", "JOYREQUEST", "CHARGE"), ("PSOS", "P2OS", "AmigOS")),
    "JOYDRIVE": ("PSOS", "AmigOS"),
    "SAY": ("AmigOS",),
    "STOP": ("PSOS", "AmigOS", "uARCS", "MARCOS"),
    "IOREQUEST": ("PSOS", "AmigOS"),
}
"""By command: the families of firmware that do not know the command.

Early versions of other families may not know a setting, either. Then CONFIGpac shows that the robot did not take it.
"""

COMMAND_NUMBERS: Dict[int, Command] = {command.number: command for command in COMMANDS.values()}


def knows(family: str, command: str) -> bool:
    """Whether firmware of a family knows a command. It does, unless `UNKNOWN_TO` has the command with this family."""
    return family not in UNKNOWN_TO.get(command, ())


OTHER_MEANINGS: Tuple[Tuple[int, str, str], ...] = (
    (57, "simulators", "stop at once, like E_STOP"),
    (61, "old simulators", "load parameters"),
    (62, "old simulators", "exit"),
    (63, "old simulators", "load world"),
    (64, "old simulators", "single step"),
    (66, "old simulators", "set true x"),
    (67, "old simulators", "set true y"),
    (68, "old simulators", "set true heading"),
    (69, "old simulators", "reset"),
    (90, "PeopleBot manual", "PLAYLIST (everywhere else 91)"),
    (94, "the vendor's laser logger", "log to a file of that name"),
    (210, "Pioneer LX", "SRECORD"),
    (211, "Pioneer LX", "MARCDEBUG"),
    (212, "Pioneer LX", "WHEEL_LIGHT"),
    (213, "Pioneer LX", "ABSOLUTE_MAXES"),
    (215, "Pioneer LX", "SAFETY_SET_STATE"),
    (216, "Pioneer LX", "SAFETY_DISABLE_POWER_OFF_TIMER"),
    (217, "Pioneer LX", "SAFETY_ZONE_ACTIVE"),
    (219, "Pioneer LX", "MARC_CONFIG_SET"),
    (220, "Pioneer LX", "MARC_CONFIG_GET"),
    (226, "simulators", "SIM_MODEL_CONFIG: string"),
    (250, "AROS 1.6", "SHUTDOWN: 0 cancel, 1 simulate low power, 2 shut the PC down"),
    (251, "simulators", "over-temperature flag"),
    (252, "simulators", "temperature, deg C (-128 off)"),
)
"""Command numbers with another meaning for other robots or programs: the number, the robot or program, the meaning.
`SIMULATOR_COMMANDS` has those of the simulators that somebody still uses.

A Pioneer that knows the command in `COMMANDS` takes the number for this command.
"""


class ReceivedCommand(NamedTuple):
    """A command as a robot receives it. `value` is the string or the signed integer; None without an argument."""

    number: int
    name: str
    value: Union[None, int, bytes]


def encode_command(name: str, *values: Any) -> bytes:
    """The bytes of a command, ready to be sent with one write.

    Examples of arguments: ``("PULSE")``, ``("VEL", -200)``, ``("DIGOUT", mask, states)``, ``("TTY2", b"hi")``.

    Raises:
        EncodingError: no command has this name, the number of values is wrong, or a value is out of range. Values are
            never clamped.
    """
    command = COMMANDS.get(name)
    if command is None:
        raise EncodingError("no command is called %r" % name)
    needed = 0 if command.argument is NONE else 2 if command.argument is TWO_BYTES else 1
    if len(values) != needed and not (command.optional and not values):
        raise EncodingError("%s takes %d value%s, not %d (%s)" % (
            name, needed, "" if needed == 1 else "s", len(values), command.effect))
    return encode_frame(command.number, _encode_argument(command, values) if values else b"")


def _encode_argument(command: Command, values: Tuple[Any, ...]) -> bytes:
    if command.argument is STRING:
        text = checked_bytes(values[0], command.name)
        checked_integer(len(text), command.low, command.high, "%s, length of the string" % command.name)
        return bytes((TEXT, len(text))) + text
    if command.argument is TWO_BYTES:
        first, second = (checked_integer(value, low, high, "%s, %s value" % (command.name, which))
                         for value, low, high, which in zip(values, command.low, command.high, ("first", "second")))
        return bytes((POSITIVE, second & 0xFF, first & 0xFF))
    value = checked_integer(values[0], command.low, command.high, command.name)
    return bytes((NEGATIVE if value < 0 else POSITIVE,)) + abs(value).to_bytes(2, "little")


def decode_command(frame: Frame) -> ReceivedCommand:
    """The command that a frame to the robot contains. Never raises.

    A missing or incomplete argument gives the value None. An unknown number gives the name ``COMMAND_n``. Bytes behind
    the argument are ignored. A positive integer with bit 15 set becomes negative, as in a 16-bit variable of the robot,
    unless the argument of the command is unsigned or two bytes.
    """
    command = COMMAND_NUMBERS.get(frame.id)
    unsigned = command is not None and command.argument in (UINT, TWO_BYTES)
    return ReceivedCommand(
        frame.id, command.name if command else "COMMAND_%d" % frame.id, _decode_argument(frame.data, unsigned))


def _decode_argument(data: bytes, unsigned: bool) -> Union[None, int, bytes]:
    if data[:1] == bytes((TEXT,)) and len(data) > 1:
        return data[2:2 + data[1]]
    if len(data) < 3 or data[0] not in (POSITIVE, NEGATIVE):
        return None
    number = int.from_bytes(data[1:3], "little")
    wraps = data[0] == POSITIVE and number > INT_MAX and not unsigned
    return -number if data[0] == NEGATIVE else number - 0x10000 if wraps else number


def two_bytes(value: int) -> Tuple[int, int]:
    """The high and the low byte of a TWO_BYTES value, both signed (-128..127). For an unsigned byte mask with 0xFF.

    The sign of the whole value is applied first. So ``0xF60A`` and ``-0x09F6`` give the same bytes.
    """
    high, low = value >> 8 & 0xFF, value & 0xFF
    return high - 0x100 if high > 127 else high, low - 0x100 if low > 127 else low
