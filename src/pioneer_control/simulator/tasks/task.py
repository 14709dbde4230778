"""A task with its arena, and the table from which all tasks are read."""

from pathlib import Path
from typing import Any, Dict, List, Mapping, NamedTuple

from ...errors import ParameterError, WorldError
from ..world import World, load_world
from ...maps.yaml_nodes import read_values
from .scores import RULES, Rates, Rule

HERE = Path(__file__).parent
LARGEST = 6.0
"""Longest side (m) of an arena."""


class Task(NamedTuple):
    """A task.

    Attributes:
        name: its name, for programs.
        title: its name, for people.
        text: what to do, in one or two sentences.
        rates: its duration, and what time and contacts are worth.
        rule: the name of the rule that gives the points, with its numbers by their names.
        arena: its floor.
    """

    name: str
    title: str
    text: str
    rates: Rates
    rule: Mapping[str, Any]
    arena: World

    def begin(self) -> Rule:
        """Return the rule for a robot that begins now.

        Raises:
            WorldError: the arena has not what the rule needs.
        """
        numbers = {name: value for name, value in self.rule.items() if name != "name"}
        return RULES[self.rule["name"]](self.arena, self.rates, **numbers)


def load_tasks(folder: Path = HERE) -> List[Task]:
    """Return all tasks, in the order of the table.

    Args:
        folder: where the table ``tasks.yaml`` is, and ``arenas/NAME.yaml`` for each task.

    Raises:
        ParameterError: the table cannot be read, or a time in it is not legal.
        WorldError: an arena cannot be read, is too large, or has not what the rule of its task needs.
    """
    return [_task(name, folder, **entry) for name, entry in read_values(str(folder / "tasks.yaml")).items()]


def _task(name: str, folder: Path, title: str, text: str, rule: Dict[str, Any], **rates: float) -> Task:
    arena = load_world(folder / "arenas" / ("%s.yaml" % name))
    low_x, low_y, high_x, high_y = arena.bounds
    if max(high_x - low_x, high_y - low_y) > LARGEST or len(arena.starts) != 1:
        raise WorldError("arena %s: it must not be larger than %g by %g m, and have one start" % (
            name, LARGEST, LARGEST))
    task = Task(name, title, text, Rates(**rates), rule, arena)
    if not 0.0 <= task.rates.quick_s < task.rates.limit_s:
        raise ParameterError("task %s: quick_s %g is not legal: give less than limit_s" % (name, task.rates.quick_s))
    task.begin()
    return task
