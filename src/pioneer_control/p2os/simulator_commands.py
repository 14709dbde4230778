"""Commands that only simulated robots know, in a table of their own (laser sheet 3.2, protocol sheet 3.8).

Four of them have numbers that other commands of `COMMANDS` have, too: 35 to 38. On a Pioneer those others count; who
takes these instead must know that they are meant (see ``simulator.firmware.laser_orders``).
"""

from enum import Enum
from typing import Any, Dict, NamedTuple, Optional, Tuple

from ..errors import EncodingError
from ..wire_fields import checked_bytes, checked_integer
from .commands import INT_MAX, NEGATIVE, POSITIVE, STRING_MAX, TEXT
from .framing import Frame, encode_frame


class OrderArgument(Enum):
    """The kinds of argument that these commands have."""

    NONE = "no argument"
    INT = "signed integer, as of other commands"
    INT_AND_LASER = "signed integer, and one byte: the number of the laser. A robot works without the byte, too"
    INT_AND_NAME = "signed integer, two bytes with a length, and a name so long. Both may be left out"
    STRING = "string, as of other commands"
    POSE = "type byte, and three integers of 32 bits"


NONE, INT, INT_AND_LASER, INT_AND_NAME, STRING, POSE = tuple(OrderArgument)


class SimulatorCommand(NamedTuple):
    """One row of the table. `effect` says what the command does, in which unit."""

    number: int
    name: str
    argument: OrderArgument
    effect: str


SIMULATOR_COMMANDS: Dict[str, SimulatorCommand] = {command.name: command for command in (
    # As older simulators have them, and as the vendor's client sends them
    SimulatorCommand(35, "OLD_LASER_ENABLE", INT, "laser: 0 off, 1 packets 0x60, 2 packets 0x61"),
    SimulatorCommand(36, "OLD_LASER_FIRST", INT, "deg, + left: angle of the first ray"),
    SimulatorCommand(37, "OLD_LASER_LAST", INT, "deg, + left: angle of the last ray"),
    SimulatorCommand(38, "OLD_LASER_STEP", INT, "0.01 deg: angle between two rays. From here on the angles count"),
    # As the vendor's present simulator has them
    SimulatorCommand(224, "SIM_SET_POSE", POSE, "mm, mm, deg: true pose of the robot"),
    SimulatorCommand(225, "SIM_RESET", NONE, "begin anew"),
    SimulatorCommand(230, "SIM_LRF_ENABLE", INT_AND_LASER, "laser: 0 off, 1 packets 0x60, 2 packets 0x61"),
    SimulatorCommand(231, "SIM_LRF_SET_FOV_START", INT_AND_LASER, "deg, + left: angle of the first ray"),
    SimulatorCommand(232, "SIM_LRF_SET_FOV_END", INT_AND_LASER, "deg, + left: angle of the last ray"),
    SimulatorCommand(233, "SIM_LRF_SET_RES", INT_AND_LASER,
                     "0.01 deg: angle between two rays. From here on the angles count"),
    SimulatorCommand(236, "SIM_CTRL", INT_AND_NAME,
                     "1 load map, 2 master, 3 clear it, 4 rotate logs, 5 log state, 6 send SIMINFO, 7 ghost"),
    SimulatorCommand(237, "SIM_STAT", INT, "SIMSTAT: 0 stop, 1 once, 2 continuous"),
    SimulatorCommand(238, "SIM_MESSAGE", STRING, "a message to show"),
    SimulatorCommand(239, "SIM_EXIT", INT, "end the simulator"),
)}
"""The commands, by name."""

_NUMBERS: Dict[int, SimulatorCommand] = {command.number: command for command in SIMULATOR_COMMANDS.values()}
_FEWEST_AND_MOST: Dict[OrderArgument, Tuple[int, int]] = {
    NONE: (0, 0), INT: (1, 1), INT_AND_LASER: (1, 2), INT_AND_NAME: (1, 2), STRING: (1, 1), POSE: (3, 3)}


class SimulatorOrder(NamedTuple):
    """A command as a simulated robot receives it. `values` is empty without an argument, or with a broken one."""

    number: int
    name: str
    values: Tuple[Any, ...]


def encode_simulator_command(name: str, *values: Any) -> bytes:
    """The bytes of a command, ready to be sent with one write, as ``("SIM_LRF_SET_FOV_START", -90, 0)``.

    Raises:
        EncodingError: no command has this name, the number of values is wrong, or a value is out of range.
    """
    command = SIMULATOR_COMMANDS.get(name)
    if command is None:
        raise EncodingError("no command of simulators is called %r" % name)
    fewest, most = _FEWEST_AND_MOST[command.argument]
    if not fewest <= len(values) <= most:
        wanted = " or ".join(sorted({str(fewest), str(most)}))
        raise EncodingError("%s takes %s values, not %d (%s)" % (name, wanted, len(values), command.effect))
    return encode_frame(command.number, _argument(command, values) if values else b"")


def _argument(command: SimulatorCommand, values: Tuple[Any, ...]) -> bytes:
    kind, name = command.argument, command.name
    if kind is STRING:
        text = checked_bytes(values[0], name)
        checked_integer(len(text), 0, STRING_MAX, "%s, length of the string" % name)
        return bytes((TEXT, len(text))) + text
    if kind is POSE:
        return bytes((POSITIVE,)) + b"".join(
            checked_integer(value, -2 ** 31, 2 ** 31 - 1, name).to_bytes(4, "little", signed=True) for value in values)
    value = checked_integer(values[0], -INT_MAX, INT_MAX, name)
    made = bytes((NEGATIVE if value < 0 else POSITIVE,)) + abs(value).to_bytes(2, "little")
    if len(values) == 2 and kind is INT_AND_LASER:
        return made + bytes((checked_integer(values[1], 0, 255, "%s, number of the laser" % name),))
    if len(values) == 2:
        text = checked_bytes(values[1], name)
        checked_integer(len(text), 0, STRING_MAX, "%s, length of the name" % name)
        return made + len(text).to_bytes(2, "little") + text
    return made


def decode_simulator_command(frame: Frame) -> Optional[SimulatorOrder]:
    """The command that a frame to a simulated robot contains; None if its number is none of these. Never raises.

    Bytes behind the argument are ignored.
    """
    command = _NUMBERS.get(frame.id)
    return None if command is None else SimulatorOrder(frame.id, command.name, _values(command.argument, frame.data))


def _values(kind: OrderArgument, data: bytes) -> Tuple[Any, ...]:
    if kind is NONE:
        return ()
    if kind is STRING:
        return (data[2:2 + data[1]],) if data[:1] == bytes((TEXT,)) and len(data) > 1 else ()
    if data[:1] not in (bytes((POSITIVE,)), bytes((NEGATIVE,))) or len(data) < (13 if kind is POSE else 3):
        return ()
    if kind is POSE:
        return tuple(int.from_bytes(data[at:at + 4], "little", signed=True) for at in (1, 5, 9))
    magnitude = int.from_bytes(data[1:3], "little")
    value = -magnitude if data[0] == NEGATIVE else magnitude if magnitude <= INT_MAX else magnitude - 0x10000
    if kind is INT_AND_LASER and len(data) > 3:
        return value, data[3]
    if kind is INT_AND_NAME and len(data) > 4:
        return value, data[5:5 + int.from_bytes(data[3:5], "little")]
    return (value,)
