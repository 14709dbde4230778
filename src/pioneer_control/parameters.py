"""How values that a user gives are checked: parameters of nodes, and values in files. This file does not need ROS.

A kind of value has `legal`, which says to people what may be given, and `accept`, which turns what was given into the
value that is used, or raises ValueError.

The private parameters of a node are a table, a frozen dataclass. Each of its fields is a row::

    port: str = parameter("/dev/ttyUSB0", Text(), "serial device, or socket://host:port")

`check` compares what the parameter server holds with the table, once, and tells all mistakes at once.
"""

import difflib
import math
from dataclasses import field, fields
from typing import Any, Iterable, List, Mapping, NamedTuple, Optional, Tuple

from .errors import ParameterError


class Number(NamedTuple):
    """A finite number in [low, high]; a whole number will do, a bool or a text will not."""

    low: float
    high: float = math.inf

    @property
    def legal(self) -> str:
        """Which numbers, for people."""
        return "a number" + _range(self.low, self.high)

    def accept(self, value: Any) -> float:
        """The value as float. Raises ValueError when it is not legal."""
        is_number = isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)
        return float(_sure(value, is_number and self.low <= value <= self.high))


class Rate(NamedTuple):
    """0, or a number whose size, without its sign, is in [least, high]. A ``signed`` number may be negative."""

    least: float
    high: float
    signed: bool = False

    @property
    def low(self) -> float:
        """The least number."""
        return -self.high if self.signed else 0.0

    @property
    def legal(self) -> str:
        """Which numbers, for people."""
        return "0 or a number%s%s" % (_range(self.least, self.high), ", with any sign" if self.signed else "")

    def accept(self, value: Any) -> float:
        """The size as float. Raises ValueError when it is not legal."""
        size = abs(Number(self.low, self.high).accept(value))
        return float(_sure(size, size == 0 or size >= self.least))


class Whole(NamedTuple):
    """A whole number in [low, high]; without limits, any."""

    low: float = -math.inf
    high: float = math.inf

    @property
    def legal(self) -> str:
        """Which numbers, for people."""
        return "a whole number" + _range(self.low, self.high, "%d")

    def accept(self, value: Any) -> int:
        """The value itself. Raises ValueError when it is not legal."""
        is_whole = isinstance(value, int) and not isinstance(value, bool)
        return int(_sure(value, is_whole and self.low <= value <= self.high))


def _range(low: float, high: float, form: str = "%g") -> str:
    """The limits in words, as far as there are any."""
    up_to = " up" if math.isinf(high) else " to %s" % form % high
    return "" if math.isinf(low) else " from %s" % form % low + up_to


def _sure(value: Any, legal: bool) -> Any:
    """The value. Raises ValueError when it is not legal."""
    if not legal:
        raise ValueError
    return value


class Choice(NamedTuple):
    """One of a few numbers or words."""

    choices: Tuple[Any, ...]

    @property
    def legal(self) -> str:
        """Which ones, for people."""
        return "one of " + ", ".join(map(str, self.choices))

    def accept(self, value: Any) -> Any:
        """The one chosen, as the table has it. Raises ValueError when it is not legal."""
        return self.choices[self.choices.index(_sure(value, not isinstance(value, bool)))]


class Numbers(NamedTuple):
    """A list of ``length`` numbers (None: of any length), each in [low, high]."""

    length: Optional[int]
    low: float
    high: float

    @property
    def legal(self) -> str:
        """Which numbers, for people."""
        how_many = "numbers" if self.length is None else "%d numbers" % self.length
        return "%s%s, as a list" % (how_many, _range(self.low, self.high))

    def accept(self, value: Any) -> Tuple[float, ...]:
        """The numbers as floats. Raises ValueError when it is not legal."""
        numbers = _sure(value, isinstance(value, (list, tuple)) and self.length in (None, len(value)))
        return tuple(map(Number(self.low, self.high).accept, numbers))


class Switch(NamedTuple):
    """True or false. What only looks like it (1, "yes") is not legal."""

    legal: str = "true or false"

    def accept(self, value: Any) -> bool:
        """The value itself. Raises ValueError when it is not legal."""
        return bool(_sure(value, isinstance(value, bool)))


class AutoSwitch(NamedTuple):
    """True, false, or "auto" (None): as the robot or its model has it."""

    legal: str = "auto, true or false"

    def accept(self, value: Any) -> Optional[bool]:
        """True, False or None. Raises ValueError when it is not legal."""
        spelled = {"auto": None, "true": True, "false": False, True: True, False: False}
        return spelled[_sure(value, isinstance(value, (str, bool)) and value in spelled)]


class Text(NamedTuple):
    """A text. ``empty``: it may be empty. ``slash``: it may begin with a slash (frames of tf2 may not)."""

    empty: bool = False
    slash: bool = True

    @property
    def legal(self) -> str:
        """Which texts, for people."""
        return "a text" + ("" if self.empty else ", not empty") + ("" if self.slash else ", not beginning with '/'")

    def accept(self, value: Any) -> str:
        """The value itself. Raises ValueError when it is not legal."""
        is_text = isinstance(value, str) and bool(self.empty or value.strip()) and (self.slash or value[:1] != "/")
        return str(_sure(value, is_text))


def parameter(default: Any, kind: Any, meaning: str, unit: str = "", live: bool = False) -> Any:
    """A row of a table: a field whose metadata say what is legal. A ``live`` one may change while the node runs."""
    return field(default=default, metadata={"kind": kind, "unit": unit, "meaning": meaning, "live": live})


def nearest(name: Any, known: Iterable[str]) -> Optional[str]:
    """The known name that is most like a misspelt name; None when no known name is like it."""
    return next(iter(difflib.get_close_matches(str(name).lower(), known, n=1, cutoff=0.7)), None)


def check(table: type, given: Mapping[str, Any]) -> Tuple[Any, List[str]]:
    """Compare what the parameter server holds with a table.

    Returns:
        An instance of the table; and the unknown names, but for those that look like misspelt known names.

    Raises:
        ParameterError: names every illegal parameter, its value and what is legal, and every misspelt name.
    """
    known = {entry.name: entry.metadata for entry in fields(table)}
    accepted, problems = {}, []
    for name, row in known.items():
        if name in given:
            try:
                accepted[name] = row["kind"].accept(given[name])
            except ValueError:
                unit = " (%s)" % row["unit"] if row["unit"] else ""
                problems.append("~%s = %r is not legal: give %s%s" % (name, given[name], row["kind"].legal, unit))
    foreign = {name: nearest(name, known) for name in sorted(set(given) - set(known))}
    problems += ["~%s is not a parameter of this node: did you mean ~%s?" % (name, near)
                 for name, near in foreign.items() if near is not None]
    if problems:
        raise ParameterError("; ".join(problems))
    return table(**accepted), [name for name, near in foreign.items() if near is None]
