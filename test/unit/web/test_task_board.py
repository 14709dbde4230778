"""A task on the pages of a class: who is ranked under which name, and how often it is told."""

import json

import pytest

from pioneer_control.web.orders import LONGEST_NAME
from pioneer_control.web.paced_feed import RATE, PacedFeed
from pioneer_control.web.task_board import TaskBoard


def task(state, *points, name="square", clock=0.0, note=""):
    """Return the text ``task`` as it comes from the simulator: the robots 1 and up have these points."""
    ranking = [{"robot": robot, "who": "", "points": each, "note": note} for robot, each in enumerate(points, 1)]
    return {"name": name, "title": "Do it", "text": "Do.", "state": state, "clock": clock, "limit": 120.0,
            "ranking": sorted(ranking, key=lambda entry: (-entry["points"], entry["robot"]))}


class Pages:
    """A board whose students, by robot, a test changes. Keeps what the pages and the terminal are told."""

    def __init__(self):
        self.students, self.texts, self.sentences = {}, [], []
        self.board = TaskBoard(self, lambda robot: self.students.get(robot, ""), self.sentences.append)

    def text(self, kind, value, robot=None, seat="", to=""):
        self.texts.append((kind, value))

    def ranking(self):
        kind, value = self.texts[-1]
        assert kind == "task"
        return [(entry["robot"], entry["who"], entry["points"]) for entry in value["ranking"]]


@pytest.fixture
def pages():
    return Pages()


def test_only_students_are_ranked_and_all_robots_while_there_is_none(pages):
    assert pages.texts == [("task", None)]
    pages.board.text("task", task("running", 10.0, 30.0, 20.0))
    assert pages.ranking() == [(2, "", 30.0), (3, "", 20.0), (1, "", 10.0)]
    pages.students.update({1: "Ada", 3: "Bob"})
    pages.board.turn()
    assert pages.ranking() == [(3, "Bob", 20.0), (1, "Ada", 10.0)]
    pages.students = {1: "Ada Lovelace"}
    pages.board.turn()
    assert pages.ranking() == [(1, "Ada Lovelace", 10.0)]
    pages.board.turn()
    assert len(pages.texts) == 4       # nothing new
    pages.board.text("task", None)
    assert pages.texts[-1] == ("task", None)


def test_other_texts_pass(pages):
    pages.board.text("tasks", [["square", "Drive a square"]])
    pages.board.text("faults", ["x"])
    assert pages.texts[1:] == [("tasks", [["square", "Drive a square"]]), ("faults", ["x"])]
    assert pages.board.tasks == [["square", "Drive a square"]]


def test_the_terminal_says_when_a_task_begins_and_who_was_best(pages):
    pages.students = {1: "Ada", 2: "Bob", 4: "Cleo", 5: "Dan"}
    for state, points in (("ready", (0, 0, 0, 0, 0)), ("running", (0, 0, 0, 0, 0)), ("running", (5, 80.25, 99, 7, 6)),
                          ("over", (5, 80.25, 99, 7, 6.5)), ("over", (5, 80.25, 99, 7, 6.5))):
        pages.board.text("task", task(state, *points))
    assert pages.sentences == ["the task square begins, for 120 s: Do it",
                               "the task square has ended: 1. Bob (80.2), 2. Cleo (7.0), 3. Dan (6.5)"]


@pytest.mark.parametrize("then", [None, task("ready", 0.0, name="maze")])
def test_a_task_that_is_taken_away_has_ended(pages, then):
    pages.board.text("task", task("running", 3.0))
    pages.board.text("task", then)
    assert pages.sentences[1:] == ["the task square has ended: 1. robot 1 (3.0)"]
    pages.board.text("task", task("running", 0.0, name="maze"))
    assert pages.sentences[2:] == ["the task maze begins, for 120 s: Do it"]


# How often

class Clocked:
    """A paced feed. Keeps what it passes on, with the times."""

    def __init__(self):
        self.came, self.now = [], 0.0
        self.feed = PacedFeed(self)

    def text(self, kind, value, robot=None, seat="", to=""):
        self.came.append((self.now, kind, value))

    def at(self, now, *texts):
        self.now = now
        for kind, value in texts:
            self.feed.text(kind, value)
        self.feed.turn(now)

    def times(self, kind):
        return [at for at, name, _ in self.came if name == kind]


@pytest.fixture
def clocked():
    return Clocked()


def test_a_task_is_told_once_a_second_and_the_newest_is_never_lost(clocked):
    for tenth in range(25):
        clocked.at(tenth / 10, ("task", task("running", 1.0, clock=tenth / 10)))
    for tenth in range(25, 50):
        clocked.at(tenth / 10)
    assert clocked.times("task") == [0.0, 1.0, 2.0, 3.0] and clocked.came[-1][2]["clock"] == 2.4


def test_another_state_is_told_at_once(clocked):
    clocked.at(0.0, ("task", None))
    clocked.at(0.1, ("task", task("ready", 1.0)))
    clocked.at(0.2, ("task", task("running", 1.0)))
    clocked.at(0.3, ("task", task("running", 2.0)))
    clocked.at(0.4, ("task", task("over", 2.0)))
    clocked.at(0.5, ("task", task("over", 2.0, name="maze")))
    clocked.at(0.6, ("task", None))
    assert clocked.times("task") == [0.0, 0.1, 0.2, 0.4, 0.5, 0.6]


def test_other_texts_do_not_wait(clocked):
    clocked.feed.text("time", {"paused": True})
    assert clocked.came == [(0.0, "time", {"paused": True})]


def test_three_cans_are_told_ten_times_a_second(clocked):
    for tenth in range(10):
        clocked.at(tenth / 10, ("cans", [[1.23, 5.68, tenth]] * 3))
    assert len(clocked.times("cans")) == 10


TASK = "task", lambda count: task("running", *[count / 7] * 30, note="3 of 4 corners, touched 2 things")
LONG_NAMES = "task", lambda count: dict(task("running"), ranking=[
    {"robot": 1, "who": "\u674e" * LONGEST_NAME, "points": count, "note": ""}] * 30)
CANS = "cans", lambda count: [[12.35, 23.46, 0.1 * count]] * 90


@pytest.mark.parametrize("kinds", [[TASK], [LONG_NAMES], [CANS], [TASK, CANS], [CANS, LONG_NAMES]])
def test_long_texts_stay_within_their_rate_and_none_waits_for_ever(clocked, kinds):
    for twentieth in range(30 * 20):
        clocked.at(twentieth / 20, *((kind, make(twentieth)) for kind, make in kinds))
    lengths = [len(json.dumps(value, separators=(",", ":"))) for _, _, value in clocked.came]
    assert 0.8 * 30 * RATE < sum(lengths) < 30 * RATE + 2 * max(lengths)
    assert all(len(clocked.times(kind)) >= 3 for kind, _ in kinds)
