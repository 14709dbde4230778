#!/usr/bin/python3
"""How many points the programs in docs/programs get at their tasks, and whether it is the same each time: in lockstep.

    python3 bench/tasks.py                          # all tasks, seeds 1 to 10, three times each; writes bench/tasks.md
    python3 bench/tasks.py goal maze --seeds 3-4 --times 1

Exit status 1 when a run has fewer than 90 points, a contact or a problem, or when runs with one seed differ. Only a
run of everything that is right writes the file.
"""

import argparse
import sys
import time
from pathlib import Path
from typing import List, NamedTuple

from pioneer_control.simulator.tasks import Task, load_tasks
from pioneer_control.simulator.tasks.__main__ import attempt

ROOT = Path(__file__).resolve().parents[1]
WANTED = 90.0  # points
TUNED = range(1, 6)  # seeds with which the programs were written
HEAD = """# What `bench/tasks.py` measured

Each program of [docs/programs](../docs/programs) at its [task](../docs/tasks.md), in lockstep, %d times with each
seed. The programs were written with the seeds 1 to 5; the others came afterwards. Real time: of one run, with the
start of the program.
"""


class Row(NamedTuple):
    """What came of all runs of one program with one seed."""

    task: str
    seed: int
    points: float
    note: str
    same: bool
    good: bool
    seconds: float


def measure(task: Task, seed: int, times: int) -> Row:
    """Run the program of a task some times."""
    begin = time.monotonic()
    runs = [attempt(task, str(ROOT / "docs" / "programs" / (task.name + ".py")), seed) for _ in range(times)]
    for problem in {run.problem for run in runs if run.problem}:
        print("%s, seed %d: %s" % (task.name, seed, problem), file=sys.stderr)
    points, note = min(run.score for run in runs)
    same = len({run.score for run in runs}) == 1
    good = same and points >= WANTED and "contact" not in note and not any(run.problem for run in runs)
    return Row(task.name, seed, points, note, same, good, (time.monotonic() - begin) / times)


def table_of_seeds(rows: List[Row]) -> List[str]:
    """Return the table with a line for each program and seed."""
    lines = ["| task | seed | points | what for | the same each time | real time |", "|---|---|---|---|---|---|"]
    for row in rows:
        lines.append("| %s | %d | %g | %s | %s | %.1f s |" % (
            row.task, row.seed, row.points, row.note, "yes" if row.same else "NO", row.seconds))
    return lines


def table_of_tasks(rows: List[Row]) -> List[str]:
    """Return the table with a line for each program: least and greatest points."""
    lines = ["| task | seeds 1 to 5 | the other seeds |", "|---|---|---|"]
    for task in dict.fromkeys(row.task for row in rows):
        cells = [[row.points for row in rows if row.task == task and (row.seed in TUNED) == tuned]
                 for tuned in (True, False)]
        lines.append("| %s | %s |" % (task, " | ".join(span(cell) for cell in cells)))
    return lines


def span(points: List[float]) -> str:
    """Return the least and the greatest points as a text, one number when they are the same."""
    return " to ".join("%g" % each for each in sorted({min(points), max(points)})) if points else "-"


def seeds(text: str) -> List[int]:
    """Convert ``first-last`` or one number to seeds."""
    first, _, last = text.partition("-")
    return list(range(int(first), int(last or first) + 1))


def main() -> int:
    """Run the programs, and print and write the tables. Returns the exit status."""
    tasks = {task.name: task for task in load_tasks()}
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("tasks", nargs="*", metavar="TASK", help="only these: %s" % ", ".join(tasks))
    parser.add_argument("--seeds", type=seeds, default=seeds("1-10"), metavar="FIRST-LAST")
    parser.add_argument("--times", type=int, default=3)
    options = parser.parse_args()
    rows = [measure(tasks[name], seed, options.times) for name in options.tasks or tasks for seed in options.seeds]
    text = "\n".join([HEAD % options.times, *table_of_tasks(rows), "", *table_of_seeds(rows), ""])
    print(text)
    good = all(row.good for row in rows)
    if good and not options.tasks:
        (ROOT / "bench" / "tasks.md").write_text(text, encoding="utf-8")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
