"""Programs in docs/programs solve their tasks in lockstep. The two shortest runs; bench/tasks.py runs all."""

import pathlib

import pytest

from pioneer_control.simulator.tasks import load_tasks
from pioneer_control.simulator.tasks.__main__ import attempt

PROGRAMS = pathlib.Path(__file__).resolve().parents[2] / "docs" / "programs"
TASKS = {task.name: task for task in load_tasks()}


def is_solved(run):
    """Return whether a run got nearly all points, touched nothing, and had no problem."""
    return not run.problem and run.score.points >= 90 and "contact" not in run.score.note


@pytest.mark.parametrize("name", ["square", "goal"])
def test_a_program_solves_its_task(name):
    run = attempt(TASKS[name], str(PROGRAMS / (name + ".py")), seed=11)
    assert is_solved(run), run


def test_a_program_for_another_task_does_not():
    run = attempt(TASKS["goal"], str(PROGRAMS / "square.py"), seed=11)
    assert not is_solved(run), run
