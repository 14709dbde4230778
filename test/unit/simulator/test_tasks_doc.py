"""docs/tasks.md is true, and its programs are what it says: short, and made of the client and the standard library."""

import ast
import pathlib
import re

import pytest

from pioneer_control.simulator.tasks import load_tasks

DOCS = pathlib.Path(__file__).resolve().parents[3] / "docs"
TEXT = (DOCS / "tasks.md").read_text(encoding="utf-8")
PROGRAMS = DOCS / "programs"
TASKS = load_tasks()
MAY_USE = {"math", "sys", "pioneer_control.client"}
MOST_LINES = 80


def imported(text):
    """Return the modules that a program imports."""
    nodes = list(ast.walk(ast.parse(text)))
    return ({alias.name for node in nodes if isinstance(node, ast.Import) for alias in node.names}
            | {node.module for node in nodes if isinstance(node, ast.ImportFrom)})


def constant(program, name):
    """Return a value that a program gives a name at its begin."""
    body = ast.parse((PROGRAMS / (program + ".py")).read_text(encoding="utf-8")).body
    return next(ast.literal_eval(node.value) for node in body
                if isinstance(node, ast.Assign) and node.targets[0].id == name)


def numbers(text):
    """Return the numbers in a text."""
    return [float(number) for number in re.findall(r"-?\d+(?:\.\d+)?", text)]


def row_of(task):
    """Return the cells of a task in the table: what to do, limit, points for it, points for the time, contact."""
    return re.search(r"^\| `%s` \| (.*) \|$" % task.name, TEXT, re.MULTILINE).group(1).split(" | ")


def test_each_task_is_shown_and_has_a_program():
    shown = re.findall(r"`(\w+)` !\[\w+\]\(images/task-(\w+)\.png\)", TEXT)
    names = [task.name for task in TASKS]
    assert shown == [(name, name) for name in names]
    assert sorted(path.name for path in PROGRAMS.iterdir() if path.is_file()) == sorted(name + ".py" for name in names)
    assert all("(programs/%s.py)" % name in TEXT for name in names)


@pytest.mark.parametrize("task", TASKS, ids=lambda task: task.name)
def test_the_table_of_points(task):
    rates, (_, limit, points, for_time, contact) = task.rates, row_of(task)
    assert numbers(limit) == [rates.limit_s]
    assert (numbers(for_time), numbers(contact)) == ([rates.time_points], [rates.contact_points])
    assert numbers(points)[0] == 100 - rates.time_points


def test_the_times_for_all_points():
    told = re.search(r"hard to reach \((.*?)\)", TEXT).group(1)
    assert numbers(told) == [task.rates.quick_s for task in TASKS]


def test_the_points_are_those_that_were_measured():
    measured = (DOCS.parent / "bench" / "tasks.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| (\w+) \| [0-9.to ]+ \| [0-9.to ]+ \|$", measured, re.MULTILINE)
    assert rows == [task.name for task in TASKS]
    assert measured.split("\n\n")[2] in TEXT


def test_programs_know_where_things_are():
    arenas = {task.name: task.arena for task in TASKS}
    places = {name: [(place.x, place.y) for place in arena.places] for name, arena in arenas.items()}
    assert [arena.starts for arena in arenas.values()] == [[(0, 0, 0)]] * len(TASKS)
    assert places["square"] == constant("square", "CORNERS")
    assert (places["goal"], places["maze"]) == ([constant("goal", "GOAL")], [constant("maze", "EXIT")])
    assert sorted((can.x, can.y) for can in arenas["cans"].cans) == sorted(can for can, _ in constant("cans", "TRIPS"))


@pytest.mark.parametrize("path", sorted(PROGRAMS.glob("*.py")), ids=lambda path: path.name)
def test_a_program_is_short_and_needs_nothing_else(path):
    text = path.read_text(encoding="utf-8")
    assert imported(text) <= MAY_USE and len(text.splitlines()) <= MOST_LINES


def test_what_a_program_may_not_use_is_seen():
    assert imported("import time, math\nfrom pioneer_control.p2os import Sip") - MAY_USE == {
        "time", "pioneer_control.p2os"}
