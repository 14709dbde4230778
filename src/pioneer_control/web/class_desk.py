"""The teacher's desk: the Rules of a class. It does what students and teachers order, and tells their pages who is who.

=====================  ================================================================================================
text                   who gets it
=====================  ================================================================================================
class                  teachers: address, QR code, students, tasks, whether time stands
join                   true for everybody who has no robot and is no teacher; else false
mine                   each student: robot and name of this student; others: no robot
program                each student: the key of this student's robot; teachers: the keys of all robots
robots                 all; ``yours`` is true for teachers only
=====================  ================================================================================================
"""

import functools
from typing import Any, Callable, Dict, List, Mapping, Optional, Protocol, Sequence

from ..errors import RefusedError
from .backend import TEACHERS, Person
from .classroom import Classroom, Student
from .exchange import Outbox
from .guard import Allowance
from .orders import FreeOrder, JoinOrder
from .programs import Programs
from .simulator_orders import CARRYING, simulator_order

MOST_JOINS = 3          # of a page in a second: each one is told to teachers
Entry = Dict[str, Any]


class Simulator(Protocol):
    """Takes orders for the simulator: see truth.TruthLine."""

    def order(self, name: str, robot: Optional[int], values: Mapping[str, Any],
              answer: Callable[[bool, str], None]) -> None:
        """Send an order; ``answer`` is called with whether it was done, and a sentence. Raises RefusedError."""


class ClassDesk:
    """The Rules of a class. One thread may use it, but for who() and viewers().

    Args:
        robots: the numbers of all robots.
        told: what the text ``class`` says and what never changes: address, QR code, worlds.
        outbox, programs: those of the owner.
        vacate: called with the number of a robot that a student loses: stops it, and frees its seat.
        halt: called with the number of a robot (None: all) that is carried: stops what persons and programs drive.

    Attributes:
        simulator: takes the teacher's orders; set it before the first one.
    """

    def __init__(self, robots: Sequence[int], told: Mapping[str, Any], outbox: Outbox, programs: Programs,
                 vacate: Callable[[int], None], halt: Callable[[Optional[int]], None]) -> None:
        self.simulator: Optional[Simulator] = None
        self._classroom = Classroom(robots)
        self._told = dict(told, tasks=[])
        self._outbox, self._programs, self._vacate, self._halt = outbox, programs, vacate, halt
        self._viewers: Dict[int, Person] = {}
        self._joins: Dict[int, Allowance] = {}      # how often each viewer may still join
        self._time: Entry = {"paused": False, "speed": 1.0}
        outbox.text("join", True)
        outbox.text("join", False, to=TEACHERS)
        outbox.text("mine", {"robot": None, "name": ""})
        self._tell()

    # Rules

    def known(self, person: Person) -> Person:
        """Return a student with the name in the class."""
        student = self._classroom.student(person.visitor)
        return person if student is None else person._replace(name=student.name)

    def may(self, person: Person, robot: int) -> bool:
        """Return whether it is the student's own robot. Teachers may drive all."""
        student = self._classroom.student(person.visitor)
        return person.teacher or student is not None and student.robot == robot

    def who(self, robot: int) -> str:
        """Return the name of the student who has a robot."""
        student = self._classroom.at(robot)
        return "" if student is None else student.name

    def audience(self, robot: int) -> Sequence[str]:
        """Return the student who has a robot, and the teachers."""
        student = self._classroom.at(robot)
        return (TEACHERS,) if student is None else (student.visitor, TEACHERS)

    def viewers(self, robot: int) -> Optional[List[int]]:
        """Return the viewers of the student who has a robot, and of teachers. While time stands nobody: all robots are
        silent then.
        """
        if self._time["paused"]:
            return []
        student = self._classroom.at(robot)
        return [number for number, person in list(self._viewers.items())
                if person.teacher or student is not None and person.visitor == student.visitor]

    def entries(self, entries: List[Entry]) -> Dict[str, List[Entry]]:
        """Return the text ``robots`` for each audience."""
        return {"": [dict(entry, yours=False) for entry in entries], TEACHERS: entries}

    def emptied(self) -> None:
        """No viewer is there: a new server has begun."""
        self._viewers.clear()
        self._joins.clear()
        self._tell()

    def came(self, person: Person) -> None:
        """A viewer has come."""
        self._viewers[person.viewer] = person
        self._tell()

    def left(self, viewer: int) -> None:
        """A viewer is gone."""
        self._joins.pop(viewer, None)
        if self._viewers.pop(viewer, None) is not None:
            self._tell()

    def obey(self, person: Person, order: Any, now: float) -> None:
        """Do an order that is not about driving. Raises RefusedError for what this person may not do."""
        if isinstance(order, JoinOrder):
            if not self._joins.setdefault(person.viewer, Allowance(MOST_JOINS, now)).spends(1, now):
                raise RefusedError("refused: you have just joined")
            if person.teacher:
                raise RefusedError("the teacher needs no robot: all of them obey")
            self._join(person, order.name)
            return
        if not person.teacher:
            raise RefusedError("refused: only the teacher may do this")
        if isinstance(order, FreeOrder):
            self._free(order.robot)
        else:
            if self.simulator is None:
                raise RefusedError("refused: these robots are not simulated")
            name, robot, values = simulator_order(order)
            if isinstance(order, CARRYING):     # nothing moves at the new place because a key is still held
                self._halt(robot)
            self.simulator.order(name, robot, values, functools.partial(self._answer, person.viewer))

    # What the simulator tells: the Feed of the truth

    def text(self, kind: str, value: Any, robot: Optional[int] = None, seat: str = "", to: str = "") -> None:
        """Pass a text of the simulator on. The list of tasks is part of the text ``class``. See Feed.text()."""
        if kind == "time":
            self._time = value
            self._tell()
        if kind == "tasks":
            self._told = dict(self._told, tasks=value)
            self._tell()
            return
        self._outbox.text(kind, value, robot, seat, TEACHERS if kind == "faults" else to)

    # Students

    def _join(self, person: Person, name: str) -> None:
        student = self._classroom.join(person.visitor, name)
        self._tell_student(student)
        self._programs.tell_key(student.robot, self)
        self._tell()

    def _free(self, robot: int) -> None:
        student = self._classroom.free(robot)
        self._vacate(robot)
        for kind, number in (("mine", None), ("join", None), ("program", robot)):
            self._outbox.text(kind, None, number, to=student.visitor)
        self._programs.change_key(robot)
        self._programs.tell_key(robot, self)
        self._outbox.said("warn", "the teacher freed your robot", None, [
            number for number, person in self._viewers.items() if person.visitor == student.visitor])
        self._tell()

    def _tell_student(self, student: Student) -> None:
        self._outbox.text("join", False, to=student.visitor)
        self._outbox.text("mine", {"robot": student.robot, "name": student.name}, to=student.visitor)

    def _tell(self) -> None:
        here = {person.visitor for person in self._viewers.values()}
        students = [[student.robot, student.name, "here" if student.visitor in here else "away"]
                    for student in self._classroom.students]
        self._outbox.text("class", dict(self._told, students=students, **self._time), to=TEACHERS)

    def _answer(self, viewer: int, done: bool, sentence: str) -> None:
        self._outbox.said("info" if done else "error", sentence, None, [viewer])
