"""What can go wrong with a simulated robot and its line: one table, how a fault is written, and when each begins and ends. No I/O, no clock.

A fault in words, as on the command line and in the services of the ROS node::

    loss 0.1                                 a tenth of all packets, both ways, of every robot, from now on
    loss 0.1 way to-robot from 10 to 20      only what the client sends, between 10 and 20 simulated seconds
    transducer 3 robot 2                     of the second robot

A file of them, a timeline, is a YAML list of such words, or of mappings with the same words as keys::

    - loss 0.1 from 10 to 20
    - {fault: transducer, value: 3, robot: 2, from: 30}
"""

import difflib
import functools
import math
import operator
from typing import Any, Callable, Dict, List, Mapping, NamedTuple, Optional, Sequence, Tuple, Union

from ...errors import ParameterError
from ...parameters import Number, Whole
from .one_way import OneWay
from ..world.yaml_nodes import read_values

TO_ROBOT, FROM_ROBOT = WAYS = ("to-robot", "from-robot")
KEYS = ("fault", "value", "way", "robot", "from", "to")
"""Words of a fault; the first two stand without a word of their own where it is written as text."""


class Plant:
    """What faults act on: one robot with its line.

    :param firmware: the robot (`Firmware`).
    :param seed: of the luck on its line.
    """

    def __init__(self, firmware, seed: str):
        self.firmware = firmware
        self.wires = {way: OneWay("%s %s" % (seed, way)) for way in WAYS}
        self.powered = True
        """Whether the robot is switched on."""
        self.on_cable: Callable[[bool], None] = lambda unplugged: None
        """Told when the cable is pulled out (True) or put back."""
        self._unplugged = False
        self._voltage: Optional[float] = None

    @property
    def unplugged(self) -> bool:
        """Whether the cable is pulled out."""
        return self._unplugged

    @unplugged.setter
    def unplugged(self, unplugged: bool) -> None:
        if unplugged != self._unplugged:
            self._unplugged = unplugged
            self._clear()
            self.on_cable(unplugged)

    def set_power(self, on: bool) -> None:
        """Switch the robot on or off."""
        if on != self.powered:
            self.powered = on
            self.firmware.hardware.power_cycle()
            self._clear()

    def set_voltage(self, voltage: Optional[float]) -> None:
        """Put a battery of this voltage in, or its own back."""
        battery = self.firmware.hardware.battery
        if self._voltage is None:
            self._voltage = battery.voltage
        battery.voltage = self._voltage if voltage is None else voltage
        if voltage is None:
            self._voltage = None

    def _clear(self) -> None:
        for wire in self.wires.values():
            wire.clear()


class Kind(NamedTuple):
    """A kind of fault: `act` is given what it acts on and the values of all faults of this kind that are on, newest last."""

    name: str
    value: Any
    """What it takes, a kind of value of `parameters`; None when it takes none."""
    unit: str
    meaning: str
    act: Callable[[Any, List[Any]], None]
    on_line: bool = False
    """Whether it acts on a `OneWay`, and so may be on one way only."""
    lasts: float = math.inf
    """Seconds until it ends when that is not said."""


def _newest(name: str, rest: Any) -> Callable[[Any, List[Any]], None]:
    """Sets an attribute of a wire or of a `Plant` to the newest value, or to `rest` when none is on."""
    return lambda target, values: setattr(target, name, values[-1] if values else rest)


def _hardware(name: str, of: Callable[[List[Any]], Any]) -> Callable[[Plant, List[Any]], None]:
    """Sets an attribute of the robot's hardware to what a function makes of the values."""
    return lambda plant, values: setattr(plant.firmware.hardware, name, of(values))


def _radians_together(degrees: List[float]) -> float:
    """The sum in rad; not by `sum`, which rounds otherwise from Python 3.12 on."""
    return math.radians(functools.reduce(operator.add, degrees, 0.0))


SHARE = Number(0.0, 1.0)

KINDS: Dict[str, Kind] = {kind.name: kind for kind in (
    Kind("loss", SHARE, "share", "so many of the packets never arrive", _newest("loss", 0.0), on_line=True),
    Kind("flips", SHARE, "share", "so many of the bytes arrive with one bit wrong", _newest("flips", 0.0), on_line=True),
    Kind("splits", SHARE, "share", "so many of the packets arrive in two pieces, 50 ms apart", _newest("splits", 0.0), on_line=True),
    Kind("delay", Number(0.0, 60.0), "s", "everything arrives that much later", _newest("delay", 0.0), on_line=True),
    Kind("silence", None, "", "nothing arrives, and nobody is told", _newest("silence", False), on_line=True),
    Kind("cable", None, "", "pulled out: the client is hung up on, and finds no port, until it is put back", _newest("unplugged", False)),
    Kind("power", None, "", "off, and on again at the end; after 1 s if that is not said",
         lambda plant, values: plant.set_power(not values), lasts=1.0),
    Kind("stop_button", None, "", "the STOP button is pressed", _hardware("stop_button", bool)),
    Kind("stall", None, "", "something holds the wheels", _hardware("held", bool)),
    Kind("battery", Number(0.0, 40.0), "V", "another battery, of this voltage, which falls from there; its own is back at the end",
         lambda plant, values: plant.set_voltage(values[-1] if values else None)),
    Kind("transducer", Whole(0, 31), "number", "this sonar transducer is dead: it hears nothing", _hardware("dead_transducers", set)),
    Kind("gyro", Number(-360.0, 360.0), "deg/s", "the gyro drifts, + counter-clockwise", _hardware("gyro_drift", _radians_together)),
    Kind("gripper", None, "", "stuck: neither paddles nor lift move", _hardware("gripper_stuck", bool)),
    Kind("charger", None, "", "no fault: somebody plugs a charger in", _hardware("charger", bool)),
)}


class Fault(NamedTuple):
    """One fault. Times are simulated seconds; `robot` counts from 1, None: every robot; `way`: one of `WAYS`, None: both."""

    kind: str
    value: Any = None
    way: Optional[str] = None
    robot: Optional[int] = None
    start: float = 0.0
    end: float = math.inf

    def __str__(self) -> str:
        """Its words, without the times."""
        words = [self.kind] + ([] if self.value is None else ["%g" % self.value])
        return " ".join(words + ["way %s" % self.way] * bool(self.way) + ["robot %s" % self.robot] * bool(self.robot))


def fault_of(words: Union[str, Mapping[str, Any]]) -> Fault:
    """The fault that a text or a mapping describes.

    :raises ParameterError: names what makes no sense in it, and what is legal.
    """
    def fail(problem: str) -> ParameterError:
        return ParameterError("fault %r: %s" % (str(words), problem))

    given = _split(words, fail) if isinstance(words, str) else words
    if not isinstance(given, Mapping) or not given:
        raise fail("write a kind, perhaps its value, and 'way', 'robot', 'from' and 'to' with theirs: loss 0.1 from 10 to 20")
    unknown = [key for key in given if key not in KEYS]
    if unknown:
        raise fail("it has no %r; there are %s" % (unknown[0], ", ".join(KEYS)))
    kind = KINDS.get(str(given.get("fault")))
    if kind is None:
        near = difflib.get_close_matches(str(given.get("fault")).lower(), KINDS, n=1)
        meant = "did you mean %r? " % near[0] if near else ""
        raise fail("no kind %r; %sthere are %s" % (given.get("fault"), meant, ", ".join(KINDS)))
    checks = {"robot": Whole(1, 100000), "from": Number(0.0, 1e9), "to": Number(0.0, 1e9)}
    if kind.value is not None:
        checks["value"] = kind.value
    elif "value" in given:
        raise fail("%s takes no value, and %r is one" % (kind.name, given["value"]))
    accepted = {}
    for key, check in checks.items():
        if key in given:
            try:
                accepted[key] = check.accept(given[key])
            except ValueError:
                unit = " (%s)" % kind.unit if key == "value" else ""
                raise fail("%s %r is not legal: give %s%s" % (key, given[key], check.legal, unit)) from None
    if kind.value is not None and "value" not in given:
        raise fail("%s needs a value: %s (%s)" % (kind.name, kind.value.legal, kind.unit))
    way = given.get("way")
    if way is not None and (way not in WAYS or not kind.on_line):
        raise fail("way %r is not legal: " % way + ("give %s" % " or ".join(WAYS) if kind.on_line else "%s has no way" % kind.name))
    start = accepted.get("from", 0.0)
    end = accepted.get("to", start + kind.lasts)
    if end <= start:
        raise fail("to %g is not after from %g" % (end, start))
    return Fault(kind.name, accepted.get("value"), way, accepted.get("robot"), start, end)


def load_faults(path: str) -> List[Fault]:
    """The faults of a timeline file.

    :raises ParameterError: names the file and what makes no sense in it.
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


class _Timed(NamedTuple):
    """A fault, and when it begins and ends (simulated microseconds)."""

    fault: Fault
    start_us: int
    end_us: float


class Faults:
    """The faults of some robots, and which of them are on.

    :param plants: what they act on.
    :param say: told when one begins and ends: simulated seconds, and a sentence.
    """

    def __init__(self, plants: Sequence[Plant], say: Callable[[float, str], None] = lambda time, sentence: None):
        self._plants = plants
        self._say = say
        self._waiting: List[_Timed] = []
        self._on: List[_Timed] = []

    @property
    def on(self) -> List[Fault]:
        """Those that have begun and not ended, oldest first."""
        return [timed.fault for timed in self._on]

    def told(self, now_us: int) -> List[str]:
        """In words, those that are on, and behind them those that are to come, and when."""
        to_come = [(str(timed.fault), (timed.start_us - now_us) / 1e6) for timed in self._waiting]
        return [str(fault) for fault in self.on] + ["%s, in %.1f s" % (words, wait) if wait > 0.0 else words for words, wait in to_come]

    def add(self, fault: Fault, now_us: int = 0) -> None:
        """One more; its times count from `now_us`.

        :raises ParameterError: there is no such robot.
        """
        if fault.robot is not None and fault.robot > len(self._plants):
            raise ParameterError("fault '%s': there is no robot %s; there are 1 to %s" % (fault, fault.robot, len(self._plants)))
        end_us = math.inf if math.isinf(fault.end) else now_us + round(fault.end * 1e6)
        self._waiting.append(_Timed(fault, now_us + round(fault.start * 1e6), end_us))
        self._waiting.sort(key=lambda timed: timed.start_us)

    def clear(self, now_us: int, kind: Optional[str] = None) -> int:
        """End all of a kind (None: of every kind), also those that have not begun. Returns how many that were."""
        before = len(self._waiting) + len(self._on)
        self._waiting = [timed for timed in self._waiting if kind not in (None, timed.fault.kind)]
        self._end([timed for timed in self._on if kind in (None, timed.fault.kind)], now_us)
        return before - len(self._waiting) - len(self._on)

    @property
    def next_us(self) -> float:
        """When the next one begins or ends; infinity when none will."""
        if not (self._waiting or self._on):
            return math.inf
        return min([timed.start_us for timed in self._waiting[:1]] + [timed.end_us for timed in self._on])

    def step(self, now_us: int) -> None:
        """Begin and end what is due."""
        while self._waiting and self._waiting[0].start_us <= now_us:
            timed = self._waiting.pop(0)
            self._on.append(timed)
            self._say(now_us / 1e6, "fault begins: %s" % str(timed.fault))
            self._act(timed.fault)
        self._end([timed for timed in self._on if timed.end_us <= now_us], now_us)

    def _end(self, ended: List[_Timed], now_us: int) -> None:
        for timed in ended:
            self._on.remove(timed)
            self._say(now_us / 1e6, "fault ends: %s" % str(timed.fault))
            self._act(timed.fault)

    def _act(self, fault: Fault) -> None:
        """Let everything be as those that are on of this kind will have it, where this one acted."""
        kind = KINDS[fault.kind]
        for number, plant in enumerate(self._plants, 1):
            if fault.robot not in (None, number):
                continue
            same = [each for each in self.on if each.kind == fault.kind and each.robot in (None, number)]
            for way in WAYS if kind.on_line else (None,):
                if fault.way in (None, way):
                    values = [True if each.value is None else each.value for each in same if each.way in (None, way)]
                    kind.act(plant.wires[way] if kind.on_line else plant, values)


def _split(text: str, fail: Callable[[str], ParameterError]) -> Dict[str, Any]:
    """The words of a fault by key; numbers as numbers."""
    words = text.split()
    given: Dict[str, Any] = {"fault": words.pop(0)} if words else {}
    if words and words[0] not in KEYS:
        given["value"] = _number(words.pop(0))
    while words:
        key = words.pop(0)
        if key in given or key in KEYS and not words:
            raise fail("%r is there twice" % key if key in given else "%r needs a value behind it" % key)
        given[key] = _number(words.pop(0)) if words else None
    return given


def _number(word: str) -> Union[int, float, str]:
    for kind in (int, float):
        try:
            return kind(word)
        except ValueError:
            continue
    return word


def rows() -> List[Tuple[str, str, str, str]]:
    """The table for people: name, legal values, unit, meaning."""
    return [(kind.name, "" if kind.value is None else kind.value.legal, kind.unit, kind.meaning) for kind in KINDS.values()]
