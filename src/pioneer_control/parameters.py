"""Checks values that a user gives: parameters of nodes, and values in files. This file does not need ROS.

Each kind of value is a class with two members. `legal` describes the legal values to people. `accept` checks a given
value: it returns the value to use, or raises ValueError.

The private parameters of a node are a frozen dataclass, here called a table. Each of its fields is one parameter::

    port: str = parameter("/dev/ttyUSB0", Text(), "serial device, or socket://host:port")

`check` checks all values from the parameter server against this table, and reports all mistakes in one error.
"""

import difflib
import math
import sys
from dataclasses import field, fields
from typing import Any, Iterable, List, Mapping, NamedTuple, Optional, Tuple

from .errors import ParameterError


LARGEST = sys.float_info.max
"""Largest number that a float can hold. There are larger whole numbers."""


class Number(NamedTuple):
    """A finite number (int or float) in [low, high]. A bool or a text is not legal."""

    low: float
    high: float = math.inf

    @property
    def legal(self) -> str:
        """The description of the legal numbers, for people."""
        return "a number" + _range(self.low, self.high)

    def accept(self, value: Any) -> float:
        """Return the value as float. Raises ValueError when it is not legal."""
        is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
        return float(_sure(value, is_number and -LARGEST <= value <= LARGEST and self.low <= value <= self.high))


class Rate(NamedTuple):
    """0, or a number with an absolute value in [least, high]. It may be negative only when ``signed`` is true."""

    least: float
    high: float
    signed: bool = False

    @property
    def low(self) -> float:
        """The lower limit of the legal numbers: -high when ``signed`` is true, 0 when it is false."""
        return -self.high if self.signed else 0.0

    @property
    def legal(self) -> str:
        """The description of the legal numbers, for people."""
        return "0 or a number%s%s" % (_range(self.least, self.high), ", with any sign" if self.signed else "")

    def accept(self, value: Any) -> float:
        """Return the absolute value as float. Raises ValueError when the value is not legal."""
        size = abs(Number(self.low, self.high).accept(value))
        return float(_sure(size, size == 0 or size >= self.least))


class Whole(NamedTuple):
    """A whole number in [low, high]. Without these limits every whole number is legal. A bool is not legal."""

    low: float = -math.inf
    high: float = math.inf

    @property
    def legal(self) -> str:
        """The description of the legal numbers, for people."""
        return "a whole number" + _range(self.low, self.high, "%d")

    def accept(self, value: Any) -> int:
        """Return the value unchanged. Raises ValueError when it is not legal."""
        is_whole = isinstance(value, int) and not isinstance(value, bool)
        return int(_sure(value, is_whole and self.low <= value <= self.high))


def _range(low: float, high: float, form: str = "%g") -> str:
    """Return the limits in words, for example " from 1 to 5" or " from 1 up". Empty when ``low`` is -infinity."""
    up_to = " up" if math.isinf(high) else " to %s" % form % high
    return "" if math.isinf(low) else " from %s" % form % low + up_to


def _sure(value: Any, legal: bool) -> Any:
    """Return the value when ``legal`` is true. Raises ValueError when it is false."""
    if not legal:
        raise ValueError
    return value


class Choice(NamedTuple):
    """A value that must be one of a few given numbers or words."""

    choices: Tuple[Any, ...]

    @property
    def legal(self) -> str:
        """The list of the legal values, for people."""
        return "one of " + ", ".join("an empty text" if each == "" else str(each) for each in self.choices)

    def accept(self, value: Any) -> Any:
        """Return the element of ``choices`` that is equal to the value. Raises ValueError when there is none."""
        return self.choices[self.choices.index(_sure(value, not isinstance(value, bool)))]


class Numbers(NamedTuple):
    """A list of numbers, each in [low, high]. Its length must be ``length``; with None, any length is legal."""

    length: Optional[int]
    low: float
    high: float

    @property
    def legal(self) -> str:
        """The description of the legal lists, for people."""
        how_many = "numbers" if self.length is None else "%d numbers" % self.length
        return "%s%s, as a list" % (how_many, _range(self.low, self.high))

    def accept(self, value: Any) -> Tuple[float, ...]:
        """Return the numbers as floats. Raises ValueError when the list is not legal."""
        numbers = _sure(value, isinstance(value, (list, tuple)) and self.length in (None, len(value)))
        return tuple(map(Number(self.low, self.high).accept, numbers))


class Wholes(NamedTuple):
    """A list of whole numbers, each in [low, high]. It may be empty."""

    low: int
    high: int

    @property
    def legal(self) -> str:
        """The description of the legal lists, for people."""
        return "whole numbers%s, as a list" % _range(self.low, self.high, "%d")

    def accept(self, value: Any) -> Tuple[int, ...]:
        """Return the numbers. Raises ValueError when the list is not legal."""
        return tuple(map(Whole(self.low, self.high).accept, _sure(value, isinstance(value, (list, tuple)))))


class Signs(NamedTuple):
    """A list of ``length`` signs: each is 1 or -1."""

    length: int

    @property
    def legal(self) -> str:
        """The description of the legal lists, for people."""
        return "%d numbers, each 1 or -1, as a list" % self.length

    def accept(self, value: Any) -> Tuple[int, ...]:
        """Return the signs. Raises ValueError when the list is not legal."""
        return tuple(Choice((1, -1)).accept(sign) for sign in Numbers(self.length, -1, 1).accept(value))


class Switch(NamedTuple):
    """A bool: True or False. Other values that could mean the same (1, "yes") are not legal."""

    legal: str = "true or false"

    def accept(self, value: Any) -> bool:
        """Return the value unchanged. Raises ValueError when it is not a bool."""
        return bool(_sure(value, isinstance(value, bool)))


class AutoSwitch(NamedTuple):
    """True, False, or "auto". With "auto" the robot or its model decides."""

    legal: str = "auto, true or false"

    def accept(self, value: Any) -> Optional[bool]:
        """Return True or False, or None for "auto". Raises ValueError when the value is not legal."""
        spelled = {"auto": None, "true": True, "false": False, True: True, False: False}
        return spelled[_sure(value, isinstance(value, (str, bool)) and value in spelled)]


class Text(NamedTuple):
    """A text. ``empty``: it may be empty. ``slash``: it may begin with a slash (names of tf2 frames may not)."""

    empty: bool = False
    slash: bool = True

    @property
    def legal(self) -> str:
        """The description of the legal texts, for people."""
        return "a text" + ("" if self.empty else ", not empty") + ("" if self.slash else ", not beginning with '/'")

    def accept(self, value: Any) -> str:
        """Return the text unchanged. Raises ValueError when it is not legal."""
        is_text = isinstance(value, str) and bool(self.empty or value.strip()) and (self.slash or value[:1] != "/")
        return str(_sure(value, is_text))


def parameter(default: Any, kind: Any, meaning: str, unit: str = "", live: bool = False) -> Any:
    """Return a dataclass field for one parameter of a node.

    Args:
        default: the value when the user sets none.
        kind: what is legal: an instance of a class of this file, for example ``Number(0, 1)``.
        meaning: for people, in one phrase.
        unit: for example "m/s".
        live: the parameter may change while the node runs.
    """
    return field(default=default, metadata={"kind": kind, "unit": unit, "meaning": meaning, "live": live})


def nearest(name: Any, known: Iterable[str]) -> Optional[str]:
    """Return the known name that is most similar to a misspelt name. None when no known name is similar."""
    return next(iter(difflib.get_close_matches(str(name).lower(), known, n=1, cutoff=0.7)), None)


def check(table: type, given: Mapping[str, Any]) -> Tuple[Any, List[str]]:
    """Check the private parameters of a node.

    Args:
        table: the dataclass with the known parameters (see `parameter`).
        given: names and values from the parameter server.

    Returns:
        An instance of the table with the values to use; and the given names that the table does not know.

    Raises:
        ParameterError: a value is not legal, or an unknown name is similar to a known name. The error message names all
            of these mistakes.
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


def check_old(table: type, given: Mapping[str, Any], without_effect: Mapping[str, str]) -> Tuple[Any, List[str]]:
    """Check the private parameters of a node that takes the place of an older program, so that old launch files start.

    Args:
        table, given: as for `check`.
        without_effect: names of the older program that have no effect here, and why.

    Returns:
        An instance of the table; and a warning for each given name that has no effect.

    Raises:
        ParameterError: as `check` does.
    """
    accepted, unknown = check(table, {name: given[name] for name in given if name not in without_effect})
    why = {name: without_effect[name] for name in sorted(given) if name in without_effect}
    why.update(dict.fromkeys(unknown, "it is not a parameter of this node"))
    return accepted, ["~%s has no effect: %s" % each for each in why.items()]
