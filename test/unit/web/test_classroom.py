"""Who is who in a class: students keep their robots, names differ, and nobody has another's robot."""

import urllib.parse
import xml.etree.ElementTree

import pytest
from hypothesis import given
from hypothesis import strategies as some

from pioneer_control.errors import PioneerError, RefusedError
from pioneer_control.web.backend import TEACHERS, Person
from pioneer_control.web.class_desk import MOST_JOINS, ClassDesk
from pioneer_control.web.classroom import Classroom
from pioneer_control.web.orders import (
    LONGEST_NAME, ClearFaultsOrder, EndTaskOrder, FaultOrder, FreeOrder, JoinOrder, PauseOrder, ResetOrder, SpeedOrder,
    BeginTaskOrder, TaskOrder)
from pioneer_control.web.qr import qr_image, qr_lines, qr_rows

ADA, BOB, EVE = "a" * 16, "b" * 16, "e" * 16
TEACHER = Person(9, "t" * 16, "", True)


def test_the_first_free_robot_and_the_same_again():
    room = Classroom([3, 7])
    assert room.join(ADA, "Ada") == (ADA, "Ada", 3)
    assert room.join(BOB, "Bob").robot == 7
    assert room.join(ADA, "Ada Lovelace") == (ADA, "Ada Lovelace", 3)      # also when all are taken
    with pytest.raises(RefusedError, match="all 2 robots are taken: ask the teacher"):
        room.join(EVE, "Eve")
    assert room.free(3).name == "Ada Lovelace" and room.at(3) is None
    assert room.join(EVE, "Eve").robot == 3
    assert [student.name for student in room.students] == ["Eve", "Bob"]
    with pytest.raises(RefusedError, match="nobody has robot 5"):
        room.free(5)


@pytest.mark.parametrize("name, shown", [
    ("Ada", "Ada 2"), ("ADA", "ADA 2"), (" Ada ", "Ada 2"), ("A\u0301da", "\u00c1da"),
    ("<b>x</b>", "<b>x</b>"), ("\u674e", "\u674e"), ("Ada\ufe0f", "Ada 2"), ("A\u034fda", "Ada 2"),
    ("\uff21da", "\uff21da 2")])
def test_names_differ(name, shown):
    room = Classroom(range(5))
    room.join(ADA, "Ada")
    assert room.join(BOB, name).name == shown
    assert room.join(BOB, name).name == shown       # itself is no other


@given(some.lists(some.tuples(some.integers(0, 8), some.sampled_from(["Ada", "ada", "Ada 2", "x" * 24, "X" * 24])),
                  max_size=30))
def test_no_two_students_have_one_robot_or_one_name(joins):
    room = Classroom(range(6))
    for visitor, name in joins:
        before = room.student("visitor%d" % visitor)
        try:
            student = room.join("visitor%d" % visitor, name)
        except RefusedError:
            assert len(room.students) == 6 and before is None
            continue
        assert before is None or before.robot == student.robot
        assert 1 <= len(student.name) <= LONGEST_NAME
    assert len({student.robot for student in room.students}) == len(room.students)
    assert len({student.name.casefold() for student in room.students}) == len(room.students)


class Told:
    """Outbox, programs and simulator of a desk: keeps what it is told."""

    def __init__(self):
        self.texts, self.sentences, self.keys, self.changed = {}, [], [], []
        self.orders, self.vacated, self.halted = [], [], []
        self.desk = ClassDesk([1, 2], {"address": "http://x/#k", "qr": "", "worlds": ["w"]}, self, self,
                              self.vacated.append, self.halted.append)
        self.desk.simulator = self

    def text(self, kind, value, robot=None, seat="", to=""):
        self.texts[kind, robot, to] = value

    def said(self, level, text, robot=None, viewers=None):
        self.sentences.append((level, text, viewers))

    def tell_key(self, robot, rules):
        self.keys.append((robot, tuple(rules.audience(robot))))

    def change_key(self, robot):
        self.changed.append(robot)

    def order(self, name, robot, values, answer):
        self.orders.append((name, robot, dict(values)))
        answer(name != "speed", "answer")


@pytest.fixture
def told():
    return Told()


def student(viewer, visitor, name="", drawn=None):
    return Person(viewer, visitor, name, False, drawn)


def test_a_student_joins_and_only_teacher_and_student_are_told(told):
    desk = told.desk
    assert told.texts["join", None, ""] is True and told.texts["join", None, TEACHERS] is False
    desk.came(TEACHER)
    desk.came(student(1, ADA))
    desk.obey(student(1, ADA), JoinOrder("Ada"), 5.0)
    assert told.texts["mine", None, ADA] == {"robot": 1, "name": "Ada"} and told.texts["join", None, ADA] is False
    assert told.keys == [(1, (ADA, TEACHERS))]
    assert told.texts["class", None, TEACHERS] == {
        "address": "http://x/#k", "qr": "", "worlds": ["w"], "students": [[1, "Ada", "here"]], "paused": False,
        "speed": 1.0, "tasks": []}
    assert {key for key in told.texts if key[0] == "class"} == {("class", None, TEACHERS)}
    desk.left(1)
    assert told.texts["class", None, TEACHERS]["students"] == [[1, "Ada", "away"]]
    desk.came(student(5, ADA))
    assert desk.viewers(1) == [9, 5] and desk.viewers(2) == [9]
    assert desk.known(student(5, ADA, "liar")).name == "Ada" and desk.who(1) == "Ada" and desk.who(2) == ""
    desk.emptied()
    assert desk.viewers(1) == [] and desk.who(1) == "Ada"


def test_who_may_what(told):
    desk = told.desk
    desk.obey(student(1, ADA), JoinOrder("Ada"), 5.0)
    assert desk.may(student(2, ADA), 1) and not desk.may(student(1, ADA), 2) and not desk.may(student(3, EVE), 1)
    assert desk.may(TEACHER, 1) and desk.may(TEACHER, 2)
    for order in (FreeOrder(1), PauseOrder(True), SpeedOrder(2.0), ResetOrder("all"), FaultOrder(1, "loss 0.5"),
                  ClearFaultsOrder(), TaskOrder("square"), TaskOrder(""), BeginTaskOrder(), EndTaskOrder()):
        with pytest.raises(PioneerError, match="only the teacher"):
            desk.obey(student(1, ADA), order, 5.0)
    assert told.orders == [] and told.vacated == []
    with pytest.raises(PioneerError, match="no robot"):
        desk.obey(TEACHER, JoinOrder("T"), 5.0)


def test_the_teacher_frees_a_robot(told):
    desk = told.desk
    desk.came(student(1, ADA))
    desk.obey(student(1, ADA), JoinOrder("Ada"), 5.0)
    desk.obey(TEACHER, FreeOrder(1), 5.0)
    assert told.vacated == [1] and told.changed == [1] and told.keys[-1] == (1, (TEACHERS,))
    for kind, robot in (("mine", None), ("join", None), ("program", 1)):
        assert told.texts[kind, robot, ADA] is None
    assert told.sentences[-1][2] == [1] and not desk.may(student(1, ADA), 1)


def test_orders_for_the_simulator(told):
    for order in (PauseOrder(True), PauseOrder(False), SpeedOrder(2.0), ResetOrder("all"), ResetOrder(2),
                  FaultOrder(2, "loss 0.5"), FaultOrder("all", "stall"), ClearFaultsOrder(), TaskOrder("square"),
                  BeginTaskOrder(), EndTaskOrder()):
        told.desk.obey(TEACHER, order, 5.0)
    assert told.orders == [
        ("pause", None, {}), ("go_on", None, {}), ("speed", None, {"speed": 2.0}), ("reset", None, {}),
        ("reset", 2, {}), ("add_fault", 2, {"fault": "loss 0.5"}), ("add_fault", None, {"fault": "stall"}),
        ("clear_faults", None, {}), ("task", None, {"name": "square"}), ("begin_task", None, {}),
        ("end_task", None, {})]
    assert told.sentences[0] == ("info", "answer", [9]) and told.sentences[2][0] == "error"


def test_what_drives_a_robot_ends_before_it_is_carried(told):
    told.order = lambda name, robot, values, answer: told.halted.append(name)
    for order in (ResetOrder(2), ResetOrder("all"), TaskOrder("square"), BeginTaskOrder(), EndTaskOrder()):
        told.desk.obey(TEACHER, order, 5.0)
    assert told.halted == [2, "reset", None, "reset", None, "task", None, "begin_task", "end_task"]
    with pytest.raises(PioneerError):
        told.desk.obey(student(1, ADA), ResetOrder(2), 5.0)
    assert len(told.halted) == 9


def test_while_time_stands_nobody_hears_of_lost_links(told):
    told.desk.came(TEACHER)
    told.desk.text("time", {"paused": True, "speed": 1.0})
    assert told.desk.viewers(1) == [] and told.texts["class", None, TEACHERS]["paused"] is True
    assert told.texts["time", None, ""] == {"paused": True, "speed": 1.0}
    told.desk.text("faults", ["x"])
    assert told.texts["faults", None, TEACHERS] == ["x"]


def test_teachers_are_told_which_tasks_there_are(told):
    told.desk.text("tasks", [["square", "Drive a square"]])
    assert told.texts["class", None, TEACHERS]["tasks"] == [["square", "Drive a square"]]
    assert not [key for key in told.texts if key[0] == "tasks"]


def test_robots_of_others_are_not_yours(told):
    entries = told.desk.entries([{"robot": 1, "yours": True}])
    assert entries == {"": [{"robot": 1, "yours": False}], TEACHERS: [{"robot": 1, "yours": True}]}


def test_a_qr_code():
    rows = qr_rows("http://192.168.1.20:8080/#abcdefghijklmnopqrstuv")
    assert len(rows) == len(rows[0]) >= 25 and set("".join(rows)) == {"0", "1"}
    assert rows[0].startswith("1111111") and rows[6].startswith("1111111") and rows[1].startswith("1000001")
    lines = qr_lines(rows)
    assert len({len(line) for line in lines}) == 1 and 2 * len(lines) >= len(rows) + 4
    assert qr_lines([]) == []


def test_a_qr_code_as_a_picture():
    start, _, svg = qr_image(["11", "01"]).partition(",")
    root = xml.etree.ElementTree.fromstring(urllib.parse.unquote(svg))
    assert start == "data:image/svg+xml" and root.get("viewBox") == "-4 -4 10 10"
    assert [path.get("d") for path in root] == ["M-4,-4h10v10h-10z", "M0,0h2v1h-2zM1,1h1v1h-1z"]
    assert qr_image([]) == ""


def test_who_joins_again_and_again_is_refused(told):
    for number in range(MOST_JOINS):
        told.desk.obey(student(1, ADA), JoinOrder("Ada %d" % number), 5.0)
    with pytest.raises(RefusedError, match="just joined"):
        told.desk.obey(student(1, ADA), JoinOrder("Ada"), 5.0)
    told.desk.obey(student(2, BOB), JoinOrder("Bob"), 5.0)
    told.desk.obey(student(1, ADA), JoinOrder("Ada"), 6.0)
