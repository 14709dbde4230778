"""Who is who in a class: which student has which robot. Pure.

>>> classroom = Classroom([1, 2])
>>> classroom.join("a" * 16, "Ada").robot, classroom.join("b" * 16, "Ada").name
(1, 'Ada 2')

A student is a browser (a visitor): after a reload, or when the laptop has slept, it has the same robot again. A second
browser is another student, also if it says the same name. Only the teacher takes a robot away.
"""

import itertools
import unicodedata
from typing import Dict, List, NamedTuple, Optional, Sequence

from ..errors import RefusedError
from .orders import LONGEST_NAME, visible


class Student(NamedTuple):
    """Somebody who has a robot."""

    visitor: str
    """The secret text of the browser. Nobody else may see it."""
    name: str
    """As others see it; no two students of a class have the same."""
    robot: int


class Classroom:
    """The robots of a class, and the students who have them.

    Args:
        robots: the numbers of all robots, in the order in which they are given away.
    """

    def __init__(self, robots: Sequence[int]) -> None:
        self._robots = list(robots)
        self._students: Dict[str, Student] = {}     # by their visitors

    @property
    def students(self) -> List[Student]:
        """All students, in the order of their robots."""
        return sorted(list(self._students.values()), key=lambda student: student.robot)

    def student(self, visitor: str) -> Optional[Student]:
        """Return the student at a browser; None if it has no robot."""
        return self._students.get(visitor)

    def at(self, robot: int) -> Optional[Student]:
        """Return the student who has a robot; None if it is free. Any thread may call this."""
        return next((each for each in list(self._students.values()) if each.robot == robot), None)

    def join(self, visitor: str, name: str) -> Student:
        """Give a browser a robot: the one that it has, or one that is free.

        Args:
            visitor: the browser.
            name: 1 to LONGEST_NAME printable characters. If another student has it, a number is added.

        Raises:
            RefusedError: all robots are taken.
        """
        before = self._students.get(visitor)
        taken = {student.robot for student in self._students.values()}
        free = [robot for robot in self._robots if robot not in taken]
        if before is None and not free:
            raise RefusedError("all %d robots are taken: ask the teacher to free one" % len(self._robots))
        student = Student(visitor, self._unique(visitor, name), before.robot if before is not None else free[0])
        self._students[visitor] = student
        return student

    def free(self, robot: int) -> Student:
        """Take a robot from its student, and return the student. Raises RefusedError if nobody has it."""
        student = self.at(robot)
        if student is None:
            raise RefusedError("nobody has robot %d" % robot)
        return self._students.pop(student.visitor)

    def _unique(self, visitor: str, name: str) -> str:
        shown = visible(unicodedata.normalize("NFC", name))
        plain = shown[:LONGEST_NAME]
        others = {_look(student.name) for student in self._students.values() if student.visitor != visitor}
        for number in itertools.count(2):
            if _look(plain) not in others:
                break
            end = " %d" % number
            plain = "%s%s" % (shown[:LONGEST_NAME - len(end)].rstrip(), end)
        return plain


def _look(name: str) -> str:
    """Return what names have in common that look nearly the same: letters of any case and any width."""
    return unicodedata.normalize("NFKC", unicodedata.normalize("NFKC", name).casefold())
