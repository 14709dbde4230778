"""Who may tell which robot what. Pure: time (monotonic, s) is an argument, and robots are behind `Controls`.

=====================================  ================================================================================
order                                  who may, and when
=====================================  ================================================================================
drive                                  the holder of the seat, or anybody if it is free; not while locked; its own
                                       stamp is not older than FRESH s. Zero from the holder is always obeyed
motors, gripper                        the holder of the seat, or anybody if it is free. While locked, the gripper only
                                       stops, and motors only go off (the helm sees to that)
limit, take, release                   everybody, but not while somebody else has the seat
go                                     everybody, but not while somebody else has the seat, not while locked, and not
                                       while programs are locked out: navigation is one
here, save_place, forget_place         everybody, but not while somebody else has the seat
stop, cancel                           everybody, always, however old
unlock                                 everybody; only a teacher what a teacher has stopped
=====================================  ================================================================================

"Everybody" is everybody whose robot it is. A person has the seat of a robot from the first drive, motors or gripper
until LEASE s after the last. A teacher takes it from a visitor. All orders but stop, cancel, drive and motors off count
with the newest frame on the person's screen: when this is older than PICTURE s, they are refused, because nobody knows
how long they were under way.

A hand must go on without a gap. When a velocity ran out or was refused (a lock, a page that hung, a network that was
dark), the same visitor must let go first, with a zero, before the next one counts: nothing moves by itself because a
key is still held when the trouble ends. A page that died without a zero is such a hand, too.
"""

import contextlib
from typing import Any, Callable, Dict, List, Mapping, NamedTuple, Optional, Tuple

from ..errors import PioneerError, RefusedError
from .backend import VELOCITY_LIVES, Controls, Person
from .frames import stamp_age
from .orders import (ALL, NAVIGATION_ORDERS, CancelOrder, DriveOrder, GoOrder, GripperOrder, HelmOrder, LimitOrder,
                     MotorsOrder, ReleaseOrder, StopOrder, TakeOrder, UnlockOrder)

LEASE = 2.0             # s after the last order that needs the seat
FRESH = 0.4             # s: the oldest stamp with which a person may drive
PICTURE = 2.0           # s: the oldest picture with which a person may give other orders
SLOW = 0.2              # m/s: the first limit of each robot
MOST_HANDS = 200        # visitors of whom one seat remembers that they have not let go

Answer = Tuple[int, str]
"""The number of a robot that did not obey, and why."""


class HelmTold(NamedTuple):
    """The text "helm" of one robot, and the visitor who has its seat ("": nobody)."""

    value: Mapping[str, Any]
    seat: str


class Seat:
    """One robot: its controls, who has the seat until when, and how fast a person may drive it."""

    def __init__(self, controls: Controls, max_linear: float, max_angular: float) -> None:
        self.controls = controls
        self.most = (max_linear, max_angular)
        """Limits of the robot (m/s, rad/s)."""
        self.limit = min(SLOW, max_linear)      # m/s
        self.person: Optional[Person] = None
        self.until = 0.0
        self.moved_until = 0.0
        """Time until which a velocity of the person lives."""
        self.hands: Dict[str, None] = {}
        """Visitors whose last word was a velocity, not a zero: their hand is on a key. The oldest come first."""
        self.teacher_locks = False
        """Whether a teacher has locked it, so that only a teacher unlocks it."""

    @property
    def limits(self) -> Tuple[float, float]:
        """How fast a person drives at most (m/s, rad/s)."""
        most_linear, most_angular = self.most
        return self.limit, most_angular * self.limit / most_linear if most_linear else 0.0

    def holder(self, now: float) -> Optional[Person]:
        """Return who has the seat; None when it is free."""
        return self.person if now < self.until else None


class Seats:
    """The seats of all robots. One thread may use it.

    Args:
        may: says whether a robot is there for a person. Everybody may do everything without it.
        who: returns the name of the person whose robot it is, for programs; "" if it is everybody's.
    """

    def __init__(self, may: Callable[[Person, int], bool] = lambda person, robot: True,
                 who: Callable[[int], str] = lambda robot: "") -> None:
        self._seats: Dict[int, Seat] = {}
        self._may, self._who = may, who

    def add(self, robot: int, controls: Controls, max_linear: float, max_angular: float) -> None:
        """Add a robot, with its own limits (m/s, rad/s). If it is there already, only its limits change."""
        seat = self._seats.setdefault(robot, Seat(controls, max_linear, max_angular))
        seat.most = (max_linear, max_angular)
        seat.limit = min(seat.limit, max_linear) or min(SLOW, max_linear)

    def remove(self, robot: int) -> None:
        """Forget a robot. An unknown number is no error."""
        self._seats.pop(robot, None)

    @property
    def robots(self) -> List[int]:
        """The numbers of all robots, in the order in which they came."""
        return list(self._seats)

    def obey(self, person: Person, order: HelmOrder, now: float) -> List[Answer]:
        """Do what a person orders, as far as this person may.

        Returns the robots that did not do it, and for each the reason for people. Empty when all is done.
        """
        robots = [order.robot] if isinstance(order.robot, int) else list(self._seats)
        answers = []
        for robot in robots:
            try:
                if robot not in self._seats:
                    raise RefusedError("there is no robot %d; there are: %s" % (
                        robot, ", ".join(map(str, self._seats)) or "none"))
                if self._may(person, robot):
                    self._obey(person, self._seats[robot], order, now)
                elif order.robot != ALL:
                    raise RefusedError("this robot is not yours")
            except PioneerError as error:
                answers.append((robot, str(error)))
        return answers

    def left(self, viewer: int, now: float) -> None:
        """Stop the robots that this viewer drives: its connection is gone. The seats stay until their time is up."""
        for seat in self._seats.values():
            if seat.person is not None and seat.person.viewer == viewer and now < seat.moved_until:
                seat.moved_until = now
                seat.controls.stop()

    def lost(self, now: float, robot: Optional[int] = None) -> None:
        """Stop a robot, or all robots (None), as far as persons drive them: nobody hears the viewers any more, or the
        robots are carried. Who drove must let go first.
        """
        for number, seat in self._seats.items():
            if now < seat.moved_until and robot in (None, number):
                seat.moved_until = now
                seat.controls.stop()

    def vacate(self, robot: int, now: float) -> None:
        """Stop a robot, switch its motors off, and free seat and helm. An unknown number is no error."""
        seat = self._seats.get(robot)
        if seat is not None:
            seat.person, seat.until, seat.moved_until = None, now, now
            seat.limit = min(SLOW, seat.most[0])
            seat.hands.clear()
            seat.controls.stop()
            with contextlib.suppress(PioneerError):     # no link: each one begins with motors off
                seat.controls.release()
                seat.controls.motors(False)

    def rename(self, person: Person) -> None:
        """Take a new name of a person who may have seats."""
        for seat in self._seats.values():
            if seat.person is not None and seat.person.visitor == person.visitor:
                seat.person = seat.person._replace(name=person.name)

    def told(self, robot: int, now: float) -> HelmTold:
        """Return the text "helm" of a robot. Raises KeyError for an unknown robot."""
        seat = self._seats[robot]
        holder, programs = seat.holder(now), seat.controls.programs
        return HelmTold({
            "robot": robot,
            "commander": "person" if holder else "program" if programs == "driving" else "",
            "who": holder.name if holder else self._who(robot) if programs == "driving" else "",
            "you": False,
            "programs": programs,
            "locks": list(seat.controls.locks),
            "teacher": bool(seat.teacher_locks and seat.controls.locks),
            "limit": [round(value, 3) for value in seat.limits],
        }, holder.visitor if holder else "")

    # One robot

    def _obey(self, person: Person, seat: Seat, order: HelmOrder, now: float) -> None:
        if isinstance(order, StopOrder):
            seat.moved_until = now
            seat.teacher_locks |= person.teacher
            seat.controls.lock()
        elif isinstance(order, DriveOrder):
            self._drive(person, seat, order, now)
        elif isinstance(order, CancelOrder):
            seat.controls.navigate(order)
        else:
            is_safe = isinstance(order, MotorsOrder) and not order.on
            if person.drawn is not None and stamp_age(person.drawn, now) > PICTURE and not is_safe:
                raise RefusedError("refused: the picture was more than %g s old: look, and do it again" % PICTURE)
            self._do(person, seat, order, now)

    def _drive(self, person: Person, seat: Seat, order: DriveOrder, now: float) -> None:
        if not order.forward and not order.turn:
            seat.hands.pop(person.visitor, None)
            self._check_seat(person, seat, now)
            if now < seat.moved_until:
                seat.moved_until = now
                self._sit(person, seat, now)
                seat.controls.stop()
            return
        was_on = person.visitor in seat.hands
        seat.hands[person.visitor] = None
        if len(seat.hands) > MOST_HANDS:
            del seat.hands[next(iter(seat.hands))]
        self._check_seat(person, seat, now)
        if seat.controls.locks:
            raise RefusedError("locked (%s): unlock it first" % ", ".join(seat.controls.locks))
        goes_on = now < seat.moved_until and seat.person is not None and seat.person.visitor == person.visitor
        if was_on and not goes_on:
            raise RefusedError("the robot was stopped meanwhile: let go, then drive again")
        if stamp_age(order.stamp, now) > FRESH:
            raise RefusedError("refused: the picture was more than %g s old" % FRESH)
        linear, angular = seat.limits
        seat.controls.drive(order.forward * linear, order.turn * angular)
        seat.moved_until = now + VELOCITY_LIVES
        self._sit(person, seat, now)

    def _do(self, person: Person, seat: Seat, order: HelmOrder, now: float) -> None:
        controls = seat.controls
        if isinstance(order, UnlockOrder):
            if seat.teacher_locks and not person.teacher:
                raise RefusedError("the teacher stopped this robot: only the teacher unlocks it")
            seat.teacher_locks = False
            controls.unlock()
            return
        self._check_seat(person, seat, now)
        if isinstance(order, MotorsOrder):
            controls.motors(order.on)
            self._sit(person, seat, now)
        elif isinstance(order, GripperOrder):
            if controls.locks and order.command != "stop":
                raise RefusedError("locked (%s): unlock it first" % ", ".join(controls.locks))
            controls.gripper(order.command)
            self._sit(person, seat, now)
        elif isinstance(order, LimitOrder):
            if order.linear > seat.most[0]:
                raise RefusedError("the limit %g m/s is more than this robot drives: %g m/s at most" % (
                    order.linear, seat.most[0]))
            seat.limit = order.linear
        elif isinstance(order, TakeOrder):
            controls.take()
        elif isinstance(order, ReleaseOrder):
            controls.release()
        elif isinstance(order, NAVIGATION_ORDERS):
            if isinstance(order, GoOrder):
                self._check_free(controls)
            controls.navigate(order)

    @staticmethod
    def _check_free(controls: Controls) -> None:
        """Raise RefusedError if programs do not drive the robot now, whatever they are told."""
        if controls.locks:
            raise RefusedError("locked (%s): unlock it first" % ", ".join(controls.locks))
        if controls.programs == "locked out":
            raise RefusedError("a person has the helm: let programs drive first, then send it")

    @staticmethod
    def _sit(person: Person, seat: Seat, now: float) -> None:
        seat.person, seat.until = person, now + LEASE

    @staticmethod
    def _check_seat(person: Person, seat: Seat, now: float) -> None:
        """Raise RefusedError if somebody else has the seat, from whom this person cannot take it."""
        holder = seat.holder(now)
        if holder is None or holder.visitor == person.visitor or person.teacher and not holder.teacher:
            return
        raise RefusedError("%s drives this robot now; you may stop it" % (holder.name or "somebody else"))
