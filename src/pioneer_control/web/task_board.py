"""The ranking of a task: students' names, and what the teacher's terminal says of it. Pure."""

from typing import Any, Callable, Dict, List, Mapping, Optional

from .backend import TextFeed

Task = Optional[Mapping[str, Any]]
"""The text ``task``; None: no task is chosen."""
NAMED_AT_THE_END = 3        # of the ranking, in the sentence at the end of a task


class TaskBoard:
    """Passes texts of the simulator on, and puts names into the text ``task``: a TextFeed.

    Only robots of students are ranked. All robots are ranked while nobody has joined.

    Args:
        feed: takes the texts.
        who: returns the name of the student who has a robot, and "" for none.
        say: called with a sentence for the teacher's terminal when a task begins, and when it ends.

    Attributes:
        tasks: name and title of each task that the simulator has.
    """

    def __init__(self, feed: TextFeed, who: Callable[[int], str], say: Callable[[str], None]) -> None:
        self.tasks: List[List[str]] = []
        self._feed, self._who, self._say = feed, who, say
        self._task: Task = None         # as the simulator told it last
        self._shown: Task = None
        feed.text("task", None)

    def text(self, kind: str, value: Any, robot: Optional[int] = None, seat: str = "", to: str = "") -> None:
        """Take a text of the simulator. See Feed.text()."""
        if kind == "task":
            before, self._task = self._task, value
            self._tell_changes(before, value)
            self.turn()
            return
        if kind == "tasks":
            self.tasks = value
        self._feed.text(kind, value, robot, seat, to)

    def turn(self) -> None:
        """Tell the task again if students have come or gone, or have other names."""
        shown = None if self._task is None else {**self._task, "ranking": self._ranking(self._task)}
        if shown != self._shown:
            self._shown = shown
            self._feed.text("task", shown)

    def _ranking(self, task: Mapping[str, Any]) -> List[Dict[str, Any]]:
        named = [dict(entry, who=self._who(entry["robot"])) for entry in task["ranking"]]
        return [entry for entry in named if entry["who"]] or named

    def _tell_changes(self, before: Task, now: Task) -> None:
        """Say that a task has begun or ended."""
        was, runs = _running(before), _running(now)
        if before is not None and was and runs != was:
            same = now is not None and now["name"] == was
            self._say("the task %s has ended: %s" % (was, self._first(now if now is not None and same else before)))
        if now is not None and runs and runs != was:
            self._say("the task %s begins, for %g s: %s" % (runs, now["limit"], now["title"]))

    def _first(self, task: Mapping[str, Any]) -> str:
        """Return the best of a ranking in words."""
        return ", ".join("%d. %s (%.1f)" % (place, entry["who"] or "robot %d" % entry["robot"], entry["points"])
                         for place, entry in enumerate(self._ranking(task)[:NAMED_AT_THE_END], 1))


def _running(task: Task) -> str:
    """Return the name of a task that runs; "" if none does."""
    return str(task["name"]) if task is not None and task["state"] == "running" else ""
