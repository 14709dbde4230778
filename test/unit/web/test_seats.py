"""Who may tell a robot what: seats, leases, locks, limits, and how old a picture may be."""

import pytest

from pioneer_control.errors import LinkLostError
from pioneer_control.web.backend import VELOCITY_LIVES, Person
from pioneer_control.web.frames import stamp_of
from pioneer_control.web.orders import (
    CancelOrder, DriveOrder, ForgetPlaceOrder, GoOrder, GripperOrder, HereOrder, LimitOrder, MotorsOrder, ReleaseOrder,
    SavePlaceOrder, StopOrder, TakeOrder, UnlockOrder)
from pioneer_control.web.seats import FRESH, LEASE, MOST_HANDS, PICTURE, SLOW, Seats


class Machine:
    """The Controls of a robot that writes down what it is told."""

    def __init__(self):
        self.told, self.locks, self.programs, self.broken = [], (), "free", False

    def drive(self, linear, angular):
        if self.broken:
            raise LinkLostError("no link to the robot")
        self.told.append((round(linear, 6), round(angular, 6)))

    def stop(self):
        self.told.append("stop")

    def lock(self):
        self.locks = ("stop",)
        self.told.append("lock")

    def unlock(self):
        self.locks = ()
        self.told.append("unlock")

    def motors(self, on):
        self.told.append("motors %s" % on)

    def gripper(self, command):
        self.told.append("gripper " + command)

    def take(self):
        self.programs = "locked out"

    def release(self):
        self.programs = "free"

    def navigate(self, order):
        self.told.append(order)


class Room:
    """Two robots, a clock, and persons."""

    def __init__(self, **options):
        self.seats, self.now = Seats(**options), 1000.0
        self.one, self.two = Machine(), Machine()
        self.seats.add(1, self.one, 0.5, 2.0)
        self.seats.add(2, self.two, 0.5, 2.0)

    def does(self, who, order):
        """Give an order. Returns the reasons of refusals."""
        return [reason for _, reason in self.seats.obey(who, order, self.now)]

    def drives(self, who, robot=1, forward=1.0, turn=0.0, age=0.0):
        return self.does(who, DriveOrder(robot, forward, turn, stamp_of(self.now - age)))

    def told(self, robot=1):
        return self.seats.told(robot, self.now)


ADA, BOB = Person(1, "ada" * 6, "Ada"), Person(2, "bob" * 6)
TEACHER, OTHER_TEACHER = Person(3, "tea" * 6, "T", True), Person(4, "oth" * 6, "O", True)


@pytest.fixture
def room():
    return Room()


def test_slow_at_first_with_turns_in_proportion(room):
    assert room.drives(ADA, forward=1.0, turn=-0.5) == []
    assert room.one.told == [(SLOW, -0.5 * 2.0 * SLOW / 0.5)] and room.two.told == []
    assert room.told().value["limit"] == [0.2, 0.8]


def test_raising_the_limit(room):
    assert room.does(ADA, LimitOrder(1, 0.5)) == []
    room.drives(ADA, turn=1.0)
    assert room.one.told == [(0.5, 2.0)]
    reason, = room.does(ADA, LimitOrder(1, 0.51))
    assert "0.51" in reason and "0.5 m/s" in reason
    assert room.told(2).value["limit"][0] == SLOW


@pytest.mark.parametrize("most, limit", [((0.1, 1.0), [0.1, 1.0]), ((0.0, 0.0), [0.0, 0.0]), ((0.2, 3.0), [0.2, 3.0])])
def test_the_first_limit_is_never_beyond_the_robots(most, limit):
    seats = Seats()
    seats.add(1, Machine(), *most)
    assert seats.told(1, 0.0).value["limit"] == limit


def test_limits_of_a_robot_that_came_back_with_others(room):
    room.does(ADA, LimitOrder(1, 0.5))
    room.seats.add(1, room.one, 0.3, 1.0)
    assert room.told().value["limit"] == [0.3, 1.0]


@pytest.mark.parametrize("age, passes", [(0.0, True), (FRESH - 0.01, True), (FRESH + 0.01, False), (5.0, False),
                                         (-0.1, False), (3600.0, False)])
def test_an_old_picture_drives_nothing(room, age, passes):
    answer = room.drives(ADA, age=age)
    assert (answer == [] and len(room.one.told) == 1) if passes else ("0.4 s" in answer[0] and room.one.told == [])
    assert (room.told().seat == ADA.visitor) == passes      # what was refused takes no seat


def test_stamps_that_went_round(room):
    room.now = 2 ** 32 / 1000 + 0.1
    assert room.drives(ADA, age=0.2) == [] and len(room.one.told) == 1


def test_one_seat_and_its_lease(room):
    room.drives(ADA)
    reason, = room.drives(BOB)
    assert reason == "Ada drives this robot now; you may stop it"
    for order in (MotorsOrder(1, True), GripperOrder(1, "open"), LimitOrder(1, 0.5), TakeOrder(1), ReleaseOrder(1)):
        assert "Ada" in room.does(BOB, order)[0]
    assert room.drives(BOB, robot=2) == [] and len(room.one.told) == 1
    assert room.told() == ({"robot": 1, "commander": "person", "who": "Ada", "you": False, "programs": "free",
                            "locks": [], "teacher": False, "limit": [0.2, 0.8]}, ADA.visitor)
    room.now += LEASE - 0.01
    assert room.drives(BOB) != []
    room.now += 0.02
    assert room.told().value["commander"] == "" and room.told().seat == ""
    room.drives(BOB, forward=0.0)
    assert room.drives(BOB) == [] and room.told().seat == BOB.visitor


def test_the_same_visitor_in_another_tab_has_the_seat(room):
    room.drives(ADA)
    assert room.drives(ADA._replace(viewer=9)) == []


@pytest.mark.parametrize("order, needs", [
    (MotorsOrder(1, True), True), (MotorsOrder(1, False), True), (GripperOrder(1, "close"), True),
    (LimitOrder(1, 0.3), False), (TakeOrder(1), False), (ReleaseOrder(1), False), (UnlockOrder(1), False),
    (StopOrder(1), False)])
def test_which_orders_take_the_seat(room, order, needs):
    assert room.does(ADA, order) == []
    assert (room.told().seat == ADA.visitor) == needs


def test_a_teacher_takes_it_from_a_visitor_but_not_from_a_teacher(room):
    room.drives(ADA)
    assert room.drives(TEACHER) == [] and room.told().seat == TEACHER.visitor
    assert "T drives" in room.drives(ADA)[0] and "T drives" in room.drives(OTHER_TEACHER)[0]


def test_anybody_may_stop_however_old(room):
    room.drives(ADA)
    assert room.does(BOB._replace(drawn=stamp_of(room.now - 3600)), StopOrder(1)) == []
    assert room.one.told[-1] == "lock" and room.told().value["locks"] == ["stop"]
    assert "locked" in room.drives(ADA)[0] and "locked" in room.drives(TEACHER)[0]


def test_stop_all_and_unlock_all(room):
    assert room.does(BOB, StopOrder("all")) == []
    assert room.one.locks == room.two.locks == ("stop",)
    assert room.does(ADA, UnlockOrder("all")) == []
    assert room.one.locks == room.two.locks == ()


def test_while_locked_the_gripper_only_stops_and_zero_passes(room):
    room.does(BOB, StopOrder(1))
    assert "locked" in room.does(ADA, GripperOrder(1, "close"))[0]
    assert room.does(ADA, GripperOrder(1, "stop")) == [] and room.drives(ADA, forward=0.0) == []
    assert room.one.told == ["lock", "gripper stop"]


def test_who_holds_the_key_through_an_unlock_must_let_go(room):
    """An unlock alone moves nothing, although velocities go on to come."""
    room.drives(ADA)
    room.does(BOB, StopOrder(1))
    room.does(BOB, UnlockOrder(1))
    before = len(room.one.told)
    for _ in range(50):
        room.now += 0.05
        assert "let go" in room.drives(ADA)[0]
    assert len(room.one.told) == before
    assert room.drives(ADA, forward=0.0) == []
    assert room.drives(ADA) == [] and len(room.one.told) == before + 1


@pytest.mark.parametrize("pause", [0.0, 1.0, 3600.0])
def test_who_pressed_it_only_while_locked_must_let_go_too_and_a_pause_is_not_letting_go(room, pause):
    room.does(BOB, StopOrder(1))
    room.drives(ADA)
    room.does(BOB, UnlockOrder(1))
    room.now += pause
    assert "let go" in room.drives(ADA)[0]
    room.drives(ADA, forward=0.0)
    assert room.drives(ADA) == []


def test_a_hand_that_was_silent_too_long_must_let_go(room):
    """A page that hung, a network that was dark, a computer that slept: its key is still held."""
    room.drives(ADA)
    room.now += VELOCITY_LIVES + 0.01
    told = len(room.one.told)
    assert "let go" in room.drives(ADA)[0] and len(room.one.told) == told
    again = ADA._replace(viewer=99)     # the page connected anew
    assert "let go" in room.drives(again)[0]
    room.drives(again, forward=0.0)
    assert room.drives(again) == []


def test_a_hand_that_waited_for_the_seat_must_let_go(room):
    room.drives(ADA)
    assert "Ada" in room.drives(BOB)[0]
    room.drives(ADA, forward=0.0)
    room.now += LEASE + 0.1
    assert "let go" in room.drives(BOB)[0]


def test_hands_of_very_many_visitors_take_no_memory(room):
    for number in range(3 * MOST_HANDS):
        room.drives(ADA._replace(visitor="v%015d" % number))
    assert len(room.seats._seats[1].hands) <= MOST_HANDS


def test_who_did_not_drive_may_begin_after_an_unlock(room):
    room.drives(ADA)
    room.drives(ADA, forward=0.0)
    room.now += LEASE + 0.1
    room.does(BOB, StopOrder(1))
    room.does(BOB, UnlockOrder(1))
    assert room.drives(ADA) == []


def test_the_hand_gone_stops_at_once_with_any_stamp_and_only_once(room):
    room.drives(ADA)
    assert room.drives(ADA, forward=0.0, age=60.0) == [] and room.drives(ADA, forward=0.0) == []
    assert room.one.told[1:] == ["stop"] and room.told().seat == ADA.visitor


def test_zero_of_somebody_else_changes_nothing(room):
    room.drives(ADA)
    assert "Ada" in room.drives(BOB, forward=0.0)[0]
    room.drives(BOB, robot=2, forward=0.0)
    assert len(room.one.told) == 1 and room.two.told == [] and room.told(2).seat == ""


def test_who_leaves_stops_what_this_connection_drove(room):
    room.drives(ADA)
    room.drives(BOB, robot=2)
    room.seats.left(ADA.viewer, room.now + 0.1)
    room.seats.left(ADA.viewer, room.now + 0.1)
    assert room.one.told[1:] == ["stop"] and len(room.two.told) == 1


def test_who_leaves_later_stops_nobody(room):
    room.drives(ADA)
    room.now += LEASE + 1
    room.drives(BOB)
    room.seats.left(ADA.viewer, room.now)
    room.now += VELOCITY_LIVES + 0.1
    room.seats.left(BOB.viewer, room.now)      # the velocity has ended by itself
    assert "stop" not in room.one.told


def test_a_lost_server_stops_what_persons_drive_and_nothing_else(room):
    room.drives(ADA)
    room.seats.lost(room.now + 0.2)
    room.seats.lost(room.now + 0.3)
    assert room.one.told[1:] == ["stop"] and room.two.told == []


def test_who_drives_a_robot_that_is_carried_must_let_go(room):
    room.drives(ADA)
    room.seats.lost(room.now, 2)
    assert len(room.one.told) == 1
    room.seats.lost(room.now, 1)
    assert room.one.told[1:] == ["stop"] and "let go" in room.drives(ADA)[0]


@pytest.mark.parametrize("order", [
    UnlockOrder(1), MotorsOrder(1, True), GripperOrder(1, "open"), LimitOrder(1, 0.5), TakeOrder(1), ReleaseOrder(1)])
def test_other_orders_count_with_the_picture_too(room, order):
    old = ADA._replace(drawn=stamp_of(room.now - PICTURE - 0.1))
    assert "picture" in room.does(old, order)[0] and room.one.told == []
    assert room.does(ADA._replace(drawn=stamp_of(room.now - 1.0)), order) == []


def test_motors_go_off_with_any_picture(room):
    assert room.does(ADA._replace(drawn=stamp_of(room.now - 60)), MotorsOrder(1, False)) == []
    assert room.one.told == ["motors False"]


def test_taking_and_releasing_the_helm(room):
    room.does(ADA, TakeOrder(1))
    assert room.told().value["programs"] == "locked out"
    room.does(BOB, ReleaseOrder(1))
    assert room.told().value["programs"] == "free"
    room.one.programs = "driving"
    assert room.told().value["commander"] == "program"


@pytest.mark.parametrize("number", [-1, 0, 3, 65535])
def test_robots_that_are_not_there(room, number):
    assert "there are: 1, 2" in room.drives(ADA, robot=number)[0]
    assert "no robot" in room.does(ADA, StopOrder(number))[0]
    assert room.one.told == room.two.told == []


def test_a_robot_that_went(room):
    room.seats.remove(1)
    room.seats.remove(1)
    assert "no robot 1" in room.drives(ADA)[0] and room.seats.robots == [2]


def test_a_robot_without_a_link_says_so_and_takes_no_seat(room):
    room.one.broken = True
    assert room.drives(ADA) == ["no link to the robot"] and room.told().seat == ""


def test_robots_that_are_not_there_for_somebody():
    room = Room(may=lambda person, robot: person.teacher or robot == 2)
    assert room.drives(ADA) == ["this robot is not yours"] == room.does(ADA, StopOrder(1))
    assert room.does(ADA, StopOrder("all")) == [] and room.one.told == [] and room.two.told == ["lock"]
    assert room.drives(TEACHER) == []


def test_a_new_name_is_seen(room):
    room.drives(BOB)
    assert "somebody else" in room.drives(ADA)[0]
    room.seats.rename(BOB._replace(name="Bob"))
    assert room.told().value["who"] == "Bob"


def test_a_robot_that_is_taken_from_its_person(room):
    room.does(ADA, LimitOrder(1, 0.5))
    room.does(ADA, TakeOrder(1))
    room.drives(ADA)
    room.seats.vacate(1, room.now)
    assert room.one.told[-2:] == ["stop", "motors False"] and room.told().seat == ""
    assert room.told().value["programs"] == "free" and room.told().value["limit"][0] == SLOW
    room.seats.vacate(77, room.now)


def test_what_a_teacher_stops_only_a_teacher_unlocks(room):
    room.does(ADA, StopOrder(1))
    assert room.does(ADA, UnlockOrder(1)) == []
    assert not room.told().value["teacher"]
    room.does(TEACHER, StopOrder("all"))
    assert room.told().value["teacher"]
    room.does(ADA, StopOrder(1))
    assert "only the teacher unlocks it" in room.does(ADA, UnlockOrder(1))[0] and room.one.locks == ("stop",)
    assert room.does(OTHER_TEACHER, UnlockOrder("all")) == [] and room.one.locks == ()
    assert not room.told().value["teacher"]
    room.does(ADA, StopOrder(1))
    assert room.does(ADA, UnlockOrder(1)) == []


def test_the_person_to_whom_a_program_belongs():
    room = Room(who=lambda robot: "Ada")
    assert room.told().value["who"] == ""
    room.one.programs = "driving"
    assert room.told().value["who"] == "Ada"


GO, HERE = GoOrder(1, 3.0, 1.5, 0.0), HereOrder(1, 3.0, 1.5, 0.0)
NAVIGATES = [GO, HERE, SavePlaceOrder(1, "kitchen"), ForgetPlaceOrder(1, "kitchen")]


@pytest.mark.parametrize("order", [*NAVIGATES, CancelOrder(1)])
def test_navigation_is_told_and_takes_no_seat(room, order):
    assert room.does(ADA, order) == [] and room.one.told == [order] and room.two.told == []
    assert room.told().value["commander"] == "" and room.drives(BOB) == []


@pytest.mark.parametrize("order", NAVIGATES)
def test_only_who_may_drive_tells_navigation_something(room, order):
    room.drives(ADA)
    assert room.does(BOB, order) == ["Ada drives this robot now; you may stop it"]
    assert order not in room.one.told
    assert room.does(TEACHER, order) == []
    others = Room(may=lambda person, robot: robot == 2)
    assert others.does(ADA, order) == ["this robot is not yours"] and others.one.told == []


@pytest.mark.parametrize("order", NAVIGATES)
def test_navigation_is_told_nothing_by_an_old_picture(room, order):
    reason, = room.does(ADA._replace(drawn=stamp_of(room.now - PICTURE - 0.1)), order)
    assert "picture" in reason and room.one.told == []


def test_nothing_is_sent_while_it_is_locked_or_a_person_has_the_helm(room):
    room.does(ADA, StopOrder(1))
    assert room.does(ADA, GO) == ["locked (stop): unlock it first"]
    assert room.does(ADA, HERE) == [], "where it is may be told at any time"
    room.does(ADA, UnlockOrder(1))
    room.does(ADA, TakeOrder(1))
    reason, = room.does(ADA, GO)
    assert "let programs drive first" in reason and GoOrder not in map(type, room.one.told)
    room.does(ADA, ReleaseOrder(1))
    assert room.does(ADA, GO) == []


def test_anybody_whose_robot_it_is_calls_it_back_however_old_the_picture(room):
    room.drives(ADA)
    room.does(ADA, StopOrder(1))
    assert room.does(BOB._replace(drawn=stamp_of(room.now - 60.0)), CancelOrder(1)) == []
    assert room.one.told[-1] == CancelOrder(1)
    others = Room(may=lambda person, robot: robot == 2)
    assert others.does(ADA, CancelOrder(1)) == ["this robot is not yours"] and others.one.told == []
