"""The messages of the page: checked, and made into orders. Pure.

The table ORDERS has every message with its fields. docs/page-protocol.md says what each does.

>>> order_of(read_message('{"do": "motors", "robot": 7, "on": true}'))
MotorsOrder(robot=7, on=True)
"""

import json
import math
import re
from typing import Any, Callable, Dict, List, Mapping, NamedTuple, NoReturn, Optional, Tuple, Union

from ..errors import UsageError
from .frames import STAMPS

LONGEST_MESSAGE = 4096      # bytes
LONGEST_NAME = 24
LONGEST_SENTENCE = 500
LONGEST_FAULT = 100
LONGEST_TASK = 24
LONGEST_PLACE = 40
SPEEDS = 0.2, 4.0
"""The slowest and the fastest time of a class. Slower, links to robots are taken for lost."""
ALL = "all"
GRIPPER_COMMANDS = ("open", "close", "up", "down", "stop", "deploy", "store")
INVISIBLE = re.compile(
    "[\u034f\u115f\u1160\u17b4\u17b5\u180b-\u180d\u2800\u3164\ufe00-\ufe0f\uffa0\U000e0100-\U000e01ef]")
"""Characters that count as printable, and show nothing."""
SHOWN = 60                  # characters of a wrong value that an error shows

RobotOrAll = Union[int, str]
"""The number of a robot, or ALL."""


class DrawnOrder(NamedTuple):
    """The newest frame on the screen has this stamp."""

    stamp: int


class PingOrder(NamedTuple):
    """To be answered with the same number."""

    at: float


class DriveOrder(NamedTuple):
    """Drive at these shares (-1 to 1) of the limit. The newest drawn frame of the robot has this stamp."""

    robot: int
    forward: float
    turn: float
    stamp: int


class StopOrder(NamedTuple):
    """Lock the robot, or all robots."""

    robot: RobotOrAll


class UnlockOrder(NamedTuple):
    """Take the lock of the robot, or of all robots, away."""

    robot: RobotOrAll


class MotorsOrder(NamedTuple):
    """Switch the motors on or off."""

    robot: int
    on: bool


class GripperOrder(NamedTuple):
    """Give the gripper a command: one of GRIPPER_COMMANDS."""

    robot: int
    command: str


class LimitOrder(NamedTuple):
    """A person drives the robot at most so fast (m/s)."""

    robot: int
    linear: float


class TakeOrder(NamedTuple):
    """Take the helm from programs."""

    robot: int


class ReleaseOrder(NamedTuple):
    """Give the helm back to programs."""

    robot: int


class GoOrder(NamedTuple):
    """Drive to this pose in the map (m, rad), by the robot's navigation."""

    robot: int
    x: float
    y: float
    heading: float


class HereOrder(NamedTuple):
    """The robot is at this pose in the map (m, rad), as somebody sees it."""

    robot: int
    x: float
    y: float
    heading: float


class CancelOrder(NamedTuple):
    """Drive to the goal no more."""

    robot: int


class SavePlaceOrder(NamedTuple):
    """The place where the robot stands gets this name."""

    robot: int
    name: str


class ForgetPlaceOrder(NamedTuple):
    """The place of this name has no name any more."""

    robot: int
    name: str


class NameOrder(NamedTuple):
    """Others see this viewer under this name."""

    name: str


class SayOrder(NamedTuple):
    """Tell all viewers this."""

    text: str


class JoinOrder(NamedTuple):
    """A student of this name wants a robot."""

    name: str


class FreeOrder(NamedTuple):
    """Take the robot from its student."""

    robot: int


class PauseOrder(NamedTuple):
    """Simulated time is to stand, or to pass again."""

    on: bool


class SpeedOrder(NamedTuple):
    """So many simulated seconds are to pass in a real one."""

    speed: float


class ResetOrder(NamedTuple):
    """Carry the simulated robot back to where it began; all robots and cans."""

    robot: RobotOrAll


class FaultOrder(NamedTuple):
    """A fault in the simulator's words, for a robot or all."""

    robot: RobotOrAll
    words: str


class ClearFaultsOrder(NamedTuple):
    """All faults end."""


class TaskOrder(NamedTuple):
    """Choose the task of this name; "" for none."""

    name: str


class BeginTaskOrder(NamedTuple):
    """The chosen task begins."""


class EndTaskOrder(NamedTuple):
    """The task ends."""


NavigationOrder = Union[GoOrder, HereOrder, CancelOrder, SavePlaceOrder, ForgetPlaceOrder]
"""An order for the navigation of a robot."""
NAVIGATION_ORDERS = (GoOrder, HereOrder, CancelOrder, SavePlaceOrder, ForgetPlaceOrder)
HelmOrder = Union[DriveOrder, StopOrder, UnlockOrder, MotorsOrder, GripperOrder, LimitOrder, TakeOrder, ReleaseOrder,
                  NavigationOrder]
"""An order about robots."""
HELM_ORDERS = (DriveOrder, StopOrder, UnlockOrder, MotorsOrder, GripperOrder, LimitOrder, TakeOrder, ReleaseOrder,
               *NAVIGATION_ORDERS)
SimulatorOrder = Union[PauseOrder, SpeedOrder, ResetOrder, FaultOrder, ClearFaultsOrder, TaskOrder, BeginTaskOrder,
                       EndTaskOrder]
"""An order for the simulator."""
ClassOrder = Union[JoinOrder, FreeOrder, SimulatorOrder]
"""An order in a class: all but the first are for the teacher."""
PageOrder = Union[HelmOrder, DrawnOrder, PingOrder, NameOrder, SayOrder, ClassOrder]


class FirstWords(NamedTuple):
    """The first message of a page."""

    key: str
    visitor: str


class Check(NamedTuple):
    """A type of a field: what is legal, in words, and a function that says whether a value is."""

    legal: str
    is_legal: Callable[[Any], bool]


def visible(text: str) -> str:
    """Return a text without characters that show nothing, and with single spaces between words."""
    return " ".join(INVISIBLE.sub("", text).split())


def _whole(low: int, high: int, what: str) -> Check:
    # type(), because True is an int too.
    return Check(what, lambda value: type(value) is int and low <= value <= high)


def _number(low: float, high: float, what: str) -> Check:
    return Check(what, lambda value: type(value) in (int, float) and low <= value <= high)      # NaN is not


def _text(longest: int, what: str) -> Check:
    return Check(what, lambda value: type(value) is str and 1 <= len(value) <= longest and value.isprintable() and
                 visible(value) != "")


ROBOT = _whole(0, 65535, "the number of a robot, 0 to 65535")
ROBOT_OR_ALL = Check(ROBOT.legal + ', or "all"', lambda value: ROBOT.is_legal(value) or value == ALL)
STAMP = _whole(0, STAMPS - 1, "a whole number from 0 to %d" % (STAMPS - 1))
SWITCH = Check("true or false", lambda value: type(value) is bool)
NAME = _text(LONGEST_NAME, "1 to %d printable characters" % LONGEST_NAME)
SHARE = _number(-1, 1, "a number from -1 to 1")
METRES = _number(-10000, 10000, "a number from -10000 to 10000 (m)")
ON_MAP = {"robot": ROBOT, "x": METRES, "y": METRES, "heading": _number(-7, 7, "a number from -7 to 7 (rad)")}
PLACE = _text(LONGEST_PLACE, "1 to %d printable characters" % LONGEST_PLACE)
ORDERS: Mapping[str, Tuple[Callable[..., PageOrder], Mapping[str, Check]]] = {
    "drawn": (DrawnOrder, {"stamp": STAMP}),
    "ping": (PingOrder, {"at": _number(-1e15, 1e15, "a number from -1e15 to 1e15")}),
    "drive": (DriveOrder, {"robot": ROBOT, "forward": SHARE, "turn": SHARE, "stamp": STAMP}),
    "stop": (StopOrder, {"robot": ROBOT_OR_ALL}),
    "unlock": (UnlockOrder, {"robot": ROBOT_OR_ALL}),
    "motors": (MotorsOrder, {"robot": ROBOT, "on": SWITCH}),
    "gripper": (GripperOrder, {"robot": ROBOT, "command": Check(
        ", ".join(GRIPPER_COMMANDS), lambda value: type(value) is str and value in GRIPPER_COMMANDS)}),
    "limit": (LimitOrder, {"robot": ROBOT, "linear": _number(0.01, 100, "a number from 0.01 to 100 (m/s)")}),
    "take": (TakeOrder, {"robot": ROBOT}),
    "release": (ReleaseOrder, {"robot": ROBOT}),
    "go": (GoOrder, ON_MAP),
    "here": (HereOrder, ON_MAP),
    "cancel": (CancelOrder, {"robot": ROBOT}),
    "save_place": (SavePlaceOrder, {"robot": ROBOT, "name": PLACE}),
    "forget_place": (ForgetPlaceOrder, {"robot": ROBOT, "name": PLACE}),
    "name": (NameOrder, {"name": NAME}),
    "say": (SayOrder, {"text": _text(LONGEST_SENTENCE, "1 to %d printable characters" % LONGEST_SENTENCE)}),
    "join": (JoinOrder, {"name": NAME}),
    "free": (FreeOrder, {"robot": ROBOT}),
    "pause": (PauseOrder, {"on": SWITCH}),
    "speed": (SpeedOrder, {"speed": _number(*SPEEDS, "a number from %g to %g" % SPEEDS)}),
    "reset": (ResetOrder, {"robot": ROBOT_OR_ALL}),
    "fault": (FaultOrder, {"robot": ROBOT_OR_ALL, "words": _text(
        LONGEST_FAULT, "1 to %d printable characters" % LONGEST_FAULT)}),
    "clear_faults": (ClearFaultsOrder, {}),
    "task": (TaskOrder, {"name": Check(
        "a text of at most %d printable characters" % LONGEST_TASK,
        lambda value: type(value) is str and len(value) <= LONGEST_TASK and value.isprintable())}),
    "begin_task": (BeginTaskOrder, {}),
    "end_task": (EndTaskOrder, {}),
}
"""For each value of ``do``: the order, and its fields."""
VISITOR = Check("16 to 64 letters and digits", lambda value: (
    type(value) is str and 16 <= len(value) <= 64 and value.isascii() and value.isalnum()))
KEY = Check("a text", lambda value: type(value) is str)


def read_message(text: Union[str, bytes]) -> Dict[str, Any]:
    """Return a message of the page as a dictionary.

    Raises:
        UsageError: it is longer than 4 kB, binary, not JSON, not an object, has a field twice, or a number that is not
            finite. Whoever sends this does not speak this protocol.
    """
    if isinstance(text, bytes):
        raise UsageError("a message of %d bytes is binary; legal: text, a JSON object" % len(text))
    if len(text.encode("utf-8", "surrogatepass")) > LONGEST_MESSAGE:
        raise UsageError("a message is longer than %d bytes" % LONGEST_MESSAGE)
    try:
        message = json.loads(text, object_pairs_hook=_object, parse_constant=_constant, parse_float=_float)
    except RecursionError:
        raise UsageError("a message is nested too deeply") from None
    except UsageError:
        raise
    except ValueError as error:     # also a whole number with thousands of digits
        raise UsageError("a message is not JSON: %s" % error) from None
    if not isinstance(message, dict):
        raise UsageError("a message is %s; legal: a JSON object" % _shown(message))
    return message


def order_of(message: Mapping[str, Any]) -> PageOrder:
    """Return the order in a message, as read_message() gives it.

    Raises:
        UsageError: ``do`` is unknown, a field is missing, unknown, or has an illegal value. The error names the field,
            the value and what is legal.
    """
    name = message.get("do")
    if type(name) is not str or name not in ORDERS:
        raise UsageError("do is %s; legal: %s" % (_shown(name), ", ".join(ORDERS)))
    make, fields = ORDERS[name]
    return make(**_fields(name, {key: value for key, value in message.items() if key != "do"}, fields))


def first_words(message: Mapping[str, Any]) -> FirstWords:
    """Return the first words of a page, as read_message() gives them. Raises UsageError that names the wrong field.

    The error never has the key.
    """
    return FirstWords(**_first_fields(message, {"key": KEY, "visitor": VISITOR}))


def program_key(message: Mapping[str, Any]) -> str:
    """Return the key in the first words of a program, as read_message() gives them. Raises UsageError without one.

    The error never has the key.
    """
    return str(_first_fields(message, {"key": KEY})["key"])


def _first_fields(message: Mapping[str, Any], checks: Mapping[str, Check]) -> Dict[str, Any]:
    """Return the fields of a first message. The error for a wrong key does not show it, unlike that of _fields()."""
    if not KEY.is_legal(message.get("key")):
        raise UsageError("the first message needs the field key: a text")
    return _fields("the first message", message, checks)


def _fields(what: str, values: Mapping[str, Any], checks: Mapping[str, Check]) -> Dict[str, Any]:
    for name in values:
        if name not in checks:
            raise UsageError("%s has no field %s; legal: %s" % (what, _shown(name), ", ".join(checks)))
    for name, check in checks.items():
        if name not in values:
            raise UsageError("%s lacks the field %s: %s" % (what, name, check.legal))
        if not check.is_legal(values[name]):
            raise UsageError("%s: %s is %s; legal: %s" % (what, name, _shown(values[name]), check.legal))
    return dict(values)


def _object(pairs: List[Tuple[str, Any]]) -> Dict[str, Any]:
    result = dict(pairs)
    if len(result) != len(pairs):
        raise UsageError("a message has the same field twice")
    return result


def _constant(name: str) -> NoReturn:
    raise UsageError("a message has the number %s; legal: finite numbers" % name)


def _float(digits: str) -> float:
    value = float(digits)
    if not math.isfinite(value):
        _constant(digits[:SHOWN])
    return value


def _shown(value: Optional[object]) -> str:
    try:
        text = json.dumps(value)
    except RecursionError:
        return "something nested deeply"
    return text if len(text) <= SHOWN else text[:SHOWN] + "..."
