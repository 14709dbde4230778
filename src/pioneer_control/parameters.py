"""How a node's private parameters are checked: by a table, once, all mistakes told at once. No ROS in here.

The table is a frozen dataclass, and each of its fields is a row::

    port: str = parameter("/dev/ttyUSB0", Text(), "serial device, or socket://host:port")

A kind of value has `legal`, which says to people what may be given, and `accept`, which turns what was given into the
field's value or raises ValueError.
"""

import difflib
import math
from dataclasses import field, fields
from typing import Any, List, Mapping, NamedTuple, Optional, Tuple

from .errors import ParameterError


class Number(NamedTuple):
    """A finite number in [low, high]; a whole number will do, a bool or a text will not."""

    low: float
    high: float

    @property
    def legal(self) -> str:
        return f"a number from {self.low:g} to {self.high:g}"

    def accept(self, value: Any) -> float:
        """The value as float. Raises ValueError when it is not legal."""
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise ValueError
        if not (math.isfinite(value) and self.low <= value <= self.high):
            raise ValueError
        return float(value)


class Whole(NamedTuple):
    """A whole number, any."""

    legal: str = "a whole number"

    def accept(self, value: Any) -> int:
        """The value itself. Raises ValueError when it is not legal."""
        if isinstance(value, bool) or not isinstance(value, int):
            raise ValueError
        return value


class Choice(NamedTuple):
    """One of a few numbers."""

    choices: Tuple[int, ...]

    @property
    def legal(self) -> str:
        return "one of " + ", ".join(map(str, self.choices))

    def accept(self, value: Any) -> int:
        """The number chosen. Raises ValueError when it is not legal."""
        if isinstance(value, bool) or value not in self.choices:
            raise ValueError
        return int(value)


class Switch(NamedTuple):
    """True or false, and nothing that merely looks like it (1, "yes")."""

    legal: str = "true or false"

    def accept(self, value: Any) -> bool:
        """The value itself. Raises ValueError when it is not legal."""
        if not isinstance(value, bool):
            raise ValueError
        return value


class AutoSwitch(NamedTuple):
    """True, false, or "auto" (None): as the robot or its model has it."""

    legal: str = "auto, true or false"

    def accept(self, value: Any) -> Optional[bool]:
        """True, False or None. Raises ValueError when it is not legal."""
        spelled = {"auto": None, "true": True, "false": False, True: True, False: False}
        if not isinstance(value, (str, bool)) or value not in spelled:
            raise ValueError
        return spelled[value]


class Text(NamedTuple):
    """A text; may it be empty, and may it begin with a slash (frames of tf2 may not)?"""

    empty: bool = False
    slash: bool = True

    @property
    def legal(self) -> str:
        return "a text" + ("" if self.empty else ", not empty") + ("" if self.slash else ", not beginning with '/'")

    def accept(self, value: Any) -> str:
        """The value itself. Raises ValueError when it is not legal."""
        if not isinstance(value, str) or not (value.strip() or self.empty) or (value[:1] == "/" and not self.slash):
            raise ValueError
        return value


def parameter(default: Any, kind: Any, meaning: str, unit: str = "") -> Any:
    """A row of a table: a field whose metadata say what is legal."""
    return field(default=default, metadata={"kind": kind, "unit": unit, "meaning": meaning})


def check(table: type, given: Mapping[str, Any]) -> Tuple[Any, List[str]]:
    """What the parameter server holds -> (an instance of the table, names that it does not know and that are near none of its own).

    Raises ParameterError naming every illegal parameter, its value and what is legal, and every unknown name that
    looks like a misspelt known one.
    """
    known = {entry.name: entry.metadata for entry in fields(table)}
    accepted, unknown, problems = {}, [], []
    for name, row in known.items():
        if name in given:
            try:
                accepted[name] = row["kind"].accept(given[name])
            except ValueError:
                unit = f" ({row['unit']})" if row["unit"] else ""
                problems.append(f"~{name} = {given[name]!r} is not legal: give {row['kind'].legal}{unit}")
    for name in sorted(set(given) - set(known)):
        near = difflib.get_close_matches(name, known, n=1, cutoff=0.7)
        if near:
            problems.append(f"~{name} is not a parameter of this node: did you mean ~{near[0]}?")
        else:
            unknown.append(name)
    if problems:
        raise ParameterError("; ".join(problems))
    return table(**accepted), unknown
