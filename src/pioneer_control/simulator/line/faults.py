"""The faults that a simulated robot and its line can have: the table of their kinds, how a fault is written, and how
faults begin and end. This file uses no real time.

A fault is written as text, on the command line and in the services of the ROS node::

    loss 0.1                                 lose a tenth of all packets, in both directions, of all robots, from now on
    loss 0.1 way to-robot from 10 to 20      lose only packets of the client, from 10 to 20 simulated seconds
    transducer 3 robot 2                     sonar transducer 3 of the second robot is dead
    carry 2.5 1.0 90 robot 1 from 30         a person carries the first robot to x 2.5, y 1.0, heading 90 degrees

A file of faults is a YAML list. Its entries are such texts, or mappings with the same words as keys::

    - loss 0.1 from 10 to 20
    - {fault: transducer, value: 3, robot: 2, from: 30}
"""

import difflib
import functools
import itertools
import math
import operator
from typing import Any, Callable, Dict, List, Mapping, NamedTuple, Optional, Sequence, Union

from ...errors import ParameterError
from ...parameters import Number, Numbers, Whole
from ..clock import NEVER_US
from ...maps.yaml_nodes import read_values
from .one_way import LineErrors
from .robot_link import WAYS, RobotLink

KEYS = ("fault", "value", "way", "robot", "from", "to")
"""Keys of a fault. In a fault that is written as text, the first two values have no key before them."""


class Kind(NamedTuple):
    """A kind of fault: a row of the table `KINDS`."""

    name: str
    value: Union[Number, Whole, Numbers, None]
    """Object that checks the value of a fault. None if faults of this kind have no value."""
    unit: str
    meaning: str
    act: Optional[Callable[[RobotLink, List[Any]], None]] = None
    """Function that applies to a robot all active faults of this kind. It gets their values, newest last.

    None if it is a fault of the line; see `LineErrors`.
    """
    lasts: float = math.inf
    """Duration (s) of a fault whose end is not given."""

    @property
    def on_line(self) -> bool:
        """Whether this is a fault of the line, which may act on one direction only."""
        return self.act is None


def _radians_together(degrees: List[float]) -> float:
    """Return the sum of angles in degrees, converted to rad. It does not use `sum`, whose rounding Python 3.12 changed.
    """
    return math.radians(functools.reduce(operator.add, degrees, 0.0))


SHARE = Number(0.0, 1.0)

KINDS: Dict[str, Kind] = {kind.name: kind for kind in (
    Kind("loss", SHARE, "share", "this share of the packets never arrives"),
    Kind("flips", SHARE, "share", "this share of the bytes arrives with one bit wrong"),
    Kind("splits", SHARE, "share", "this share of the packets arrives in two pieces, 50 ms apart"),
    Kind("delay", Number(0.0, 60.0), "s", "all bytes arrive later by this time"),
    Kind("silence", None, "", "nothing arrives, and neither side gets an error"),
    Kind("cable", None, "", "unplugged: the client loses its connection, and finds no port until the fault ends",
         lambda link, values: link.unplug(bool(values))),
    Kind("power", None, "", "the robot is switched off, and on again when the fault ends (after 1 s without `to`)",
         lambda link, values: link.set_power(not values), lasts=1.0),
    Kind("stop_button", None, "", "the STOP button is pressed",
         lambda link, values: link.hardware.motors.press_stop_button(bool(values))),
    Kind("stall", None, "", "something holds the wheels", lambda link, values: link.hardware.stall.hold(bool(values))),
    Kind("battery", Number(0.0, 40.0), "V",
         "another battery with this voltage, which then falls; at the end of the fault the robot gets its own battery"
         " back",
         lambda link, values: link.set_voltage(values[-1] if values else None)),
    Kind("transducer", Whole(0, 31), "number", "this sonar transducer is dead: it detects no echo",
         lambda link, values: link.hardware.sonar.deafen(values)),
    Kind("gyro", Number(-360.0, 360.0), "deg/s", "the gyro drifts, + counter-clockwise",
         lambda link, values: link.hardware.gyro.set_drift(_radians_together(values))),
    Kind("gripper", None, "", "stuck: neither paddles nor lift move",
         lambda link, values: link.hardware.jam_gripper(bool(values))),
    Kind("arm", None, "", "the switch of the arm is off; on again when the fault ends, but the arm needs ARM_INIT then",
         lambda link, values: link.hardware.switch_arm(not values)),
    Kind("laser", None, "", "an LMS200 has no power; when the fault ends, it starts anew",
         lambda link, values: link.supply("laser", not values)),
    Kind("camera", None, "", "the camera has no power; when the fault ends, it starts anew",
         lambda link, values: link.supply("camera", not values)),
    Kind("charger", None, "", "not a fault: a charger is plugged in",
         lambda link, values: link.hardware.charger.plug(bool(values))),
    Kind("carry", Numbers(3, -1e6, 1e6), "m, m, deg",
         "a person carries the robot to this x, y and heading in the map's frame, unless something is in its way there;"
         " its odometry does not notice",
         lambda link, values: link.carry(values[-1]) if values else None, lasts=0.1),
)}


class Fault(NamedTuple):
    """One fault of a robot or its line.

    `start` and `end` are simulated seconds. `robot` counts from 1; None means all robots. `way` is one of `WAYS`; None
    means both directions.
    """

    kind: str
    value: Any = None
    way: Optional[str] = None
    robot: Optional[int] = None
    start: float = 0.0
    end: float = math.inf

    def __str__(self) -> str:
        """Return the fault as text, without its times."""
        values = self.value if isinstance(self.value, tuple) else [self.value] * (self.value is not None)
        words = [self.kind, *("%g" % value for value in values)]
        return " ".join(words + ["way %s" % self.way] * bool(self.way) + ["robot %s" % self.robot] * bool(self.robot))

    @property
    def announcement(self) -> str:
        """The fault as text with its times, counted from the time at which it is added."""
        begins = "in %g s" % self.start if self.start else "now"
        ends = "until it is cleared" if math.isinf(self.end) else "for %g s" % (self.end - self.start)
        return "%s: %s, %s" % (self, begins, ends)


def fault_of(words: Union[str, Mapping[str, Any]]) -> Fault:
    """Parse a fault that is written as text or as a mapping.

    Raises:
        ParameterError: the fault is not legal. The message names the error and the legal values.
    """
    def fail(problem: str) -> ParameterError:
        return ParameterError("fault %r: %s" % (str(words), problem))

    given = _split(words, fail) if isinstance(words, str) else words
    if not isinstance(given, Mapping) or not given:
        raise fail("write a kind, perhaps its value, and 'way', 'robot', 'from' and 'to' with theirs: loss 0.1 from 10"
                   " to 20")
    unknown = [key for key in given if key not in KEYS]
    if unknown:
        raise fail("it has no %r; there are %s" % (unknown[0], ", ".join(KEYS)))
    kind = KINDS.get(str(given.get("fault")))
    if kind is None:
        near = difflib.get_close_matches(str(given.get("fault")).lower(), KINDS, n=1)
        raise fail("no kind %r; %sthere are %s" % (
            given.get("fault"), "did you mean %r? " % near[0] if near else "", ", ".join(KINDS)))
    checks: Dict[str, Union[Number, Whole, Numbers, None]] = {
        "robot": Whole(1, 100000), "from": Number(0.0, 1e9), "to": Number(0.0, 1e9), "value": kind.value}
    if kind.value is None and "value" in given:
        raise fail("%s takes no value, and %r is one" % (kind.name, given["value"]))
    accepted: Dict[str, Any] = {}
    for key, check in checks.items():
        if check is not None and key in given:
            try:
                accepted[key] = check.accept(given[key])
            except ValueError:
                raise fail("%s %r is not legal: give %s%s" % (
                    key, given[key], check.legal, " (%s)" % kind.unit if key == "value" else "")) from None
    if kind.value is not None and "value" not in given:
        raise fail("%s needs a value: %s (%s)" % (kind.name, kind.value.legal, kind.unit))
    way = given.get("way")
    if way is not None and (way not in WAYS or not kind.on_line):
        raise fail("way %r is not legal: " % way
                   + ("give %s" % " or ".join(WAYS) if kind.on_line else "%s has no way" % kind.name))
    start = accepted.get("from", 0.0)
    end = accepted.get("to", start + kind.lasts)
    if end <= start:
        raise fail("to %g is not after from %g" % (end, start))
    return Fault(kind.name, accepted.get("value"), way, accepted.get("robot"), start, end)


def load_faults(path: str) -> List[Fault]:
    """Read a YAML file of faults.

    Raises:
        ParameterError: the file cannot be read, or a fault is not legal. The message names the file and the error.
    """
    listed = read_values(path)
    if not isinstance(listed, list):
        raise ParameterError("%s: expected a list of faults, such as '- loss 0.1 from 10 to 20'" % path)
    faults = []
    for number, words in enumerate(listed, 1):
        try:
            faults.append(fault_of(words))
        except ParameterError as error:
            raise ParameterError("%s, entry %s: %s" % (path, number, error)) from error
    return faults


class Faults:
    """The present and future faults of all robots in a simulation. Begins and ends the faults at their times.

    Args:
        links: all robots with their lines.
        say: function that is called when a fault begins or ends, with the simulated time (s) and a sentence.

    Attributes:
        on: the faults that have begun and have not ended, oldest first. Their times are simulated seconds.
    """

    def __init__(self, links: Sequence[RobotLink], say: Callable[[float, str], None] = lambda time, sentence: None):
        self._links = links
        self._say = say
        self._waiting: List[Fault] = []     # the first to begin is the first
        self.on: List[Fault] = []

    def told(self, now_us: int) -> List[str]:
        """Return texts of the active faults, then of the future faults with the time until they begin."""
        waits = [(fault, fault.start - now_us / 1e6) for fault in self._waiting]
        to_come = ["%s, in %.1f s" % (fault, wait) if wait > 0.0 else str(fault) for fault, wait in waits]
        return [str(fault) for fault in self.on] + to_come

    def add(self, fault: Fault, now_us: int = 0) -> None:
        """Add a fault. Its times are relative to `now_us` (simulated microseconds).

        Raises:
            ParameterError: the fault's robot does not exist, or a robot is played from a recording and cannot have it.
        """
        if fault.robot is not None and fault.robot > len(self._links):
            raise ParameterError("fault '%s': there is no robot %d; there are 1 to %d"
                                 % (fault, fault.robot, len(self._links)))
        of_robot = not KINDS[fault.kind].on_line and fault.kind != "cable"
        if of_robot and any(link.firmware is None for link in self._links):
            raise ParameterError("fault '%s': a played robot only says what the record has; its line can have faults"
                                 % str(fault))
        now = now_us / 1e6
        self._waiting.append(fault._replace(start=now + fault.start, end=now + fault.end))
        self._waiting.sort(key=lambda waiting: waiting.start)

    def clear(self, now_us: int) -> int:
        """End all active faults at `now_us` (simulated microseconds), and drop all future faults.

        Returns:
            The number of ended and dropped faults.
        """
        count = len(self._waiting) + len(self.on)
        self._waiting.clear()
        self._end(self.on[:], now_us)
        return count

    @property
    def next_us(self) -> int:
        """The simulated time at which the next fault begins or ends (microseconds). `NEVER_US` if there is none."""
        return min([_microseconds(fault.start) for fault in self._waiting[:1]]
                   + [_microseconds(fault.end) for fault in self.on], default=NEVER_US)

    def step(self, now_us: int) -> None:
        """Begin and end all faults that are due at `now_us` (simulated microseconds)."""
        while self._waiting and _microseconds(self._waiting[0].start) <= now_us:
            fault = self._waiting.pop(0)
            self.on.append(fault)
            self._say(now_us / 1e6, "fault begins: %s" % str(fault))
            self._act(fault)
        self._end([fault for fault in self.on if _microseconds(fault.end) <= now_us], now_us)

    def _end(self, ended: List[Fault], now_us: int) -> None:
        for fault in ended:
            self.on.remove(fault)
            self._say(now_us / 1e6, "fault ends: %s" % str(fault))
            self._act(fault)

    def _act(self, fault: Fault) -> None:
        """Apply all active faults of the same kind as `fault` to the robots or lines that `fault` concerns.

        Called whenever a fault has begun or ended.
        """
        act = KINDS[fault.kind].act
        for number, link in enumerate(self._links, 1):
            if fault.robot not in (None, number):
                continue
            same = [each for each in self.on if each.kind == fault.kind and each.robot in (None, number)]
            if act is not None:
                try:
                    act(link, [True if each.value is None else each.value for each in same])
                except ParameterError as error:
                    self._say(fault.start, "fault %s: %s" % (fault, error))
                continue
            for way in [way for way in WAYS if fault.way in (None, way)]:
                values = [True if each.value is None else each.value for each in same if each.way in (None, way)]
                newest = values[-1] if values else getattr(LineErrors(), fault.kind)
                link.wires[way].errors = link.wires[way].errors._replace(**{fault.kind: newest})


def _microseconds(seconds: float) -> int:
    return round(min(seconds * 1e6, NEVER_US))


def _split(text: str, fail: Callable[[str], ParameterError]) -> Dict[str, Any]:
    """Split a fault that is written as text. Return its values by key, numbers as int or float.

    `fail` makes the error from the description of a problem.

    Raises:
        ParameterError: a key is given twice, or its value is missing.
    """
    words = text.split()
    given: Dict[str, Any] = {"fault": words.pop(0)} if words else {}
    values = list(itertools.takewhile(lambda word: word not in KEYS, words))
    if values:
        count = getattr(getattr(KINDS.get(str(given.get("fault"))), "value", None), "length", 1)
        numbers = [_number(word) for word in values[:count]]
        given["value"] = numbers if count > 1 else numbers[0]
        del words[:len(numbers)]
    while words:
        key = words.pop(0)
        if key in given or key in KEYS and not words:
            raise fail("%r is there twice" % key if key in given else "%r needs a value behind it" % key)
        given[key] = _number(words.pop(0)) if words else None
    return given


def _number(word: str) -> Union[int, float, str]:
    try:
        return float(word) if set(word) & set(".eEnN") else int(word)
    except ValueError:
        return word
