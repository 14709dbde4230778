"""Where a robot goes that explores."""

import math

import numpy as np
import pytest

from pioneer_control.floor_poses import Pose
from pioneer_control.maps import FREE, OCCUPIED, UNKNOWN, GridMap
from pioneer_control.navigation import exploring
from pioneer_control.navigation.exploring import Doubt, Explorer, with_driven_floor
from pioneer_control.navigation.tuned import ExploringNumbers

HERE = Pose(1.0, 1.0, 0.0)
RADIUS = 0.25


def chosen(explorer, *asked):
    """Return the next goal. To choose it takes some packets."""
    goal = None
    while goal is None:
        goal = explorer.next(*asked)
    return goal


def next_goal(*asked, **options):
    """Return the goal that is chosen."""
    choosing = exploring.next_goal(*asked, **options)
    with pytest.raises(StopIteration) as end:
        while True:
            next(choosing)
    return end.value.value


def driven(until):
    """The path of a robot that drove up and down the room, as far as this x (m): it never was near to the right wall
    when it is less than 2.7.
    """
    x = np.linspace(1.0, until, 50)
    return np.concatenate((np.stack((x, np.full(50, 0.5)), axis=1), np.stack((x, np.full(50, 1.5)), axis=1)))


NOT_RIGHT = driven(2.7)


def floor(*gaps):
    """A room of 4 m x 2 m with walls round it, in unknown land. Gaps: first and last y (m) of holes in its right wall.
    """
    cells = np.full((60, 120), UNKNOWN, dtype=np.int8)
    cells[0:40, 0:80] = OCCUPIED
    cells[1:39, 1:79] = FREE
    for low, high in gaps:
        cells[round(low / 0.05):round(high / 0.05), 79] = UNKNOWN
    return GridMap(cells, 0.05, (0.0, 0.0))


def test_a_closed_room_leaves_nothing():
    goal = next_goal(floor(), HERE, RADIUS)
    assert goal.pose is None
    assert goal.reason == "all that can be reached is known"


def test_it_goes_to_the_hole_and_looks_through_it():
    goal = next_goal(floor((0.5, 1.5)), HERE, RADIUS)
    assert goal.pose[:2] == pytest.approx((3.9, 1.0), abs=0.15)
    assert abs(goal.pose.heading) < math.radians(50)
    assert goal.length == pytest.approx(2.95, abs=0.15)
    assert "%.1f m away" % goal.length in goal.reason


def test_a_hole_that_is_too_narrow_is_none():
    assert next_goal(floor((0.8, 1.2)), HERE, RADIUS).pose is None
    assert next_goal(floor((0.6, 1.4)), HERE, RADIUS).pose is not None


def test_unknown_cells_along_a_wall_are_no_end_of_the_map():
    found = floor()
    found.cells[1:3, 5:70] = UNKNOWN
    assert next_goal(found, HERE, RADIUS).pose is None


def test_what_cannot_be_reached_does_not_count():
    found = floor((0.5, 1.5))
    found.cells[:, 60] = OCCUPIED
    assert next_goal(found, HERE, RADIUS).pose is None
    assert next_goal(found, Pose(3.5, 1.0, 0.0), RADIUS).pose is not None


def test_the_nearer_of_two_equal_ends_is_chosen():
    found = floor((0.5, 1.5))
    found.cells[10:30, 0] = UNKNOWN
    found = GridMap(np.pad(found.cells, ((0, 0), (60, 0)), constant_values=UNKNOWN), 0.05, (-3.0, 0.0))
    assert next_goal(found, Pose(1.0, 1.0, 0.0), RADIUS).pose.x < 1.0
    assert next_goal(found, Pose(3.2, 1.0, 0.0), RADIUS).pose.x > 3.2


def test_more_to_see_is_worth_a_longer_way():
    found = floor((0.5, 1.5))
    found.cells[10:30, 0] = UNKNOWN
    found = GridMap(np.pad(found.cells, ((0, 0), (8, 0)), constant_values=UNKNOWN), 0.05, (-0.4, 0.0))
    found.cells[:, 0] = OCCUPIED
    assert next_goal(found, Pose(1.8, 1.0, math.pi / 2), RADIUS).pose.x > 3.0


def test_what_was_given_up_is_left_alone_and_told():
    found = floor((0.5, 1.5))
    first = next_goal(found, HERE, RADIUS)
    second = next_goal(found, HERE, RADIUS, [first.end])
    assert second.pose is None or second.end != first.end
    third = next_goal(found, HERE, RADIUS, [first.end, (3.98, 0.6), (3.98, 1.4)])
    assert third.pose is None
    assert "3 places that were given up" in third.reason


def test_before_anything_is_known_it_looks_round_where_it_stands():
    nothing = GridMap(np.full((1, 1), UNKNOWN, dtype=np.int8), 0.05, (0.0, 0.0))
    goal = next_goal(nothing, Pose(5.0, 5.0, 0.0), RADIUS)
    assert math.hypot(goal.pose.x - 5.0, goal.pose.y - 5.0) < 0.6


def test_a_robot_in_a_wall_gets_no_goal():
    found = floor()
    found.cells[:] = OCCUPIED
    assert "no known floor" in next_goal(found, HERE, RADIUS).reason


def wide_open():
    """Known floor, 4 m x 2 m, with nothing round it but unknown floor: one end of the map leads all round."""
    cells = np.full((80, 120), UNKNOWN, dtype=np.int8)
    cells[20:60, 20:100] = FREE
    return GridMap(cells, 0.05, (-1.0, -1.0))


def test_a_long_end_of_the_map_is_taken_in_pieces():
    """One place at it that was given up does not end the exploring."""
    given_up = []
    for _ in range(6):
        goal = next_goal(wide_open(), HERE, RADIUS, given_up)
        assert goal.pose is not None
        assert all(math.hypot(goal.end[0] - x, goal.end[1] - y) >= 0.5 for x, y in given_up)
        given_up.append(goal.end)


def test_it_looks_from_where_it_has_room_and_sees_the_end():
    found = floor((1.05, 1.95))
    found.cells[:, 80:] = UNKNOWN
    ample = next_goal(found, HERE, RADIUS)
    assert ample.pose.y < 1.95 - RADIUS - 0.05 - 0.1
    assert 0.0 < math.hypot(ample.end[0] - ample.pose.x, ample.end[1] - ample.pose.y) < 0.8
    assert math.atan2(ample.end[1] - ample.pose.y, ample.end[0] - ample.pose.x) == pytest.approx(ample.pose.heading)


def on_its_way():
    """An explorer with a goal at the hole in the wall, and that goal. It is 10 s on the clock, and at HERE."""
    explorer = Explorer(Pose(2.0, 1.0, 0.5), RADIUS)
    for _ in range(3):
        chosen(explorer, floor((0.5, 1.5)), HERE, 10.0)
    return explorer, chosen(explorer, floor((0.5, 1.5)), HERE, 10.0)


def test_a_goal_is_over_when_the_end_is_known():
    explorer, goal = on_its_way()
    assert not explorer.is_over(HERE, 11.0, floor((0.5, 1.5)))
    known = floor()
    known.cells[8:32, 70:100] = FREE
    assert explorer.is_over(HERE, 11.0, known)
    assert not explorer.is_over(HERE, 11.0)


def test_a_goal_is_over_when_the_robot_does_not_get_on():
    explorer, goal = on_its_way()
    assert not explorer.is_over(HERE, 17.0)
    assert explorer.is_over(Pose(1.1, 1.0, 1.0), 19.0)


def test_a_goal_is_over_when_it_takes_too_long():
    explorer, goal = on_its_way()
    over = [time for time in np.arange(10.0, 200.0) if explorer.is_over(Pose(1.0 + time % 2.0, 1.0, 0.0), time)]
    assert over[0] == pytest.approx(10.0 + 20.0 + 6.0 * goal.length, abs=2.0)


def test_time_in_which_it_must_not_move_does_not_count():
    explorer, _ = on_its_way()
    explorer.held_up(100.0)
    assert not explorer.is_over(HERE, 101.0)


def test_looking_round_and_going_home_take_the_time_that_they_take():
    explorer = Explorer(Pose(2.0, 1.0, 0.5), RADIUS)
    chosen(explorer, floor(), HERE, 0.0)
    assert not explorer.is_over(HERE, 1000.0, floor())


def test_the_way_home_does_not_take_for_ever():
    explorer = Explorer(Pose(2.0, 1.0, 0.5), RADIUS)
    for _ in range(4):
        chosen(explorer, floor(), HERE, 0.0)
    assert explorer.homeward and not explorer.is_over(HERE, 170.0)
    explorer.held_up(100.0)
    assert not explorer.is_over(HERE, 270.0) and explorer.is_over(HERE, 290.0)


def test_what_it_did_not_get_to_from_where_it_was_jammed_is_tried_again_once_it_got_away():
    """4972: jammed at one place it gave up six ends of the map there, knew half of the floor, and drove home."""
    explorer, goal = on_its_way()
    assert chosen(explorer, floor((0.5, 1.5)), HERE, 20.0).end == goal.end, "the narrower ways"
    assert chosen(explorer, floor((0.5, 1.5)), HERE, 30.0).end is None and explorer.homeward
    assert not explorer.is_over(Pose(1.9, 1.0, 0.0), 40.0)
    assert explorer.is_over(Pose(2.1, 1.0, 0.0), 40.0) and not explorer.homeward
    assert chosen(explorer, floor((0.5, 1.5)), Pose(2.1, 1.0, 0.0), 41.0).end == goal.end


def test_it_also_tries_again_once_it_got_away_to_another_end():
    two = floor((0.05, 0.95), (1.05, 1.95))
    explorer = Explorer(Pose(2.0, 1.0, 0.5), RADIUS)
    for _ in range(3):
        chosen(explorer, two, HERE, 10.0)
    jammed = chosen(explorer, two, HERE, 10.0).end
    other = chosen(explorer, two, HERE, 20.0).end
    assert other != jammed
    assert chosen(explorer, two, Pose(2.4, other[1], 0.0), 30.0).end == pytest.approx(jammed)


@pytest.mark.parametrize("places", [(2.5, 1.2), (3.2, 3.2, 3.2, 3.2)])
def test_what_it_did_not_get_to_though_it_came_a_way_or_near_is_given_up_for_good(places):
    """It has two chances, and from near it also turns to look."""
    explorer, goal = on_its_way()
    for time, x in enumerate(places, 20):
        assert goal.end is not None
        goal = chosen(explorer, floor((0.5, 1.5)), Pose(x, 1.0, 0.0), time)
    assert goal.end is None and explorer.homeward
    assert not explorer.is_over(HERE, 50.0)
    assert not explorer.is_over(Pose(3.5, 1.0, 0.0), 50.0)


def test_before_it_gives_up_it_turns_to_look():
    explorer, goal = on_its_way()
    there = Pose(3.8, 0.95, 2.0)
    look = chosen(explorer, floor((0.5, 1.5)), there, 30.0)
    assert look.with_heading and look.pose[:2] == there[:2] and look.end == goal.end
    assert abs(look.pose.heading) < 0.5
    again = chosen(explorer, floor((0.5, 1.5)), there, 40.0)
    assert not again.with_heading and not explorer.homeward, "a second chance begins anew"


def test_an_end_that_it_cannot_come_near_gets_a_second_chance_when_nothing_else_is_left_and_no_third():
    explorer, goal = on_its_way()
    assert chosen(explorer, floor((0.5, 1.5)), HERE, 30.0).end == goal.end
    last = chosen(explorer, floor((0.5, 1.5)), HERE, 60.0)
    assert explorer.homeward and "given up" in last.reason and last.reason.endswith(": home")


def test_an_end_that_is_known_and_unknown_in_turn_is_left_alone_at_last():
    explorer, _ = on_its_way()
    known, goals = floor(), 1
    known.cells[8:32, 70:100] = FREE
    while not explorer.homeward and goals < 60:
        chosen(explorer, known, HERE, 20.0)
        chosen(explorer, floor((0.5, 1.5)), HERE, 30.0)
        goals += 1
    assert explorer.homeward and 3 <= goals < 20


def test_a_gap_that_is_rather_narrow_is_tried_when_nothing_else_is_left():
    explorer = Explorer(Pose(2.0, 1.0, 0.5), 0.32, narrow=0.28)
    gap = floor((0.6, 1.4))
    for _ in range(3):
        chosen(explorer, gap, HERE, 10.0)
    assert next_goal(gap, HERE, 0.32).pose is None
    assert chosen(explorer, gap, HERE, 10.0).end is not None and not explorer.homeward
    wide = Explorer(Pose(2.0, 1.0, 0.5), 0.32)
    for _ in range(4):
        chosen(wide, gap, HERE, 10.0)
    assert wide.homeward


def test_what_the_robot_drove_over_is_free():
    """A wall that is drawn across its path belongs elsewhere."""
    found = floor()
    found.cells[:, 40] = OCCUPIED
    path = np.stack((np.linspace(1.0, 3.0, 41), np.full(41, 1.0)), axis=1)
    driven = with_driven_floor(found, path, RADIUS)
    x, y = np.full(21, 2.02), np.linspace(0.5, 1.5, 21)
    assert (driven.at(x, y)[np.abs(y - 1.0) < RADIUS - 0.05] == FREE).all()
    assert (driven.at(x, y)[np.abs(y - 1.0) > RADIUS + 0.05] == OCCUPIED).all()
    assert found.at(2.02, 1.0) == OCCUPIED, "the map itself stays"
    assert next_goal(driven, HERE, RADIUS - 0.06).pose is None
    assert (with_driven_floor(found, path + 50.0, RADIUS).cells == found.cells).all()


def test_first_it_looks_round():
    explorer = Explorer(Pose(2.0, 1.0, 0.5), RADIUS)
    pose, turned = HERE, 0.0
    for _ in range(3):
        goal = chosen(explorer, floor((0.5, 1.5)), pose, 0.0)
        assert goal.with_heading and goal.pose[:2] == HERE[:2]
        turned += math.remainder(goal.pose.heading - pose.heading, 2.0 * math.pi)
        pose = goal.pose
    assert turned == pytest.approx(2.0 * math.pi)
    assert not chosen(explorer, floor((0.5, 1.5)), HERE, 0.0).with_heading


def that_has_looked_round():
    explorer = Explorer(Pose(2.0, 1.0, 0.5), RADIUS)
    for _ in range(3):
        chosen(explorer, floor(), HERE, 0.0)
    return explorer


@pytest.mark.parametrize("found, path, steps", [
    (floor((0.5, 1.5)), None, ["the room", "the ways", "the ends of the map"]),
    (floor(), NOT_RIGHT, ["the room", "the ways", "the ends of the map", "the walls that are doubted"]),
    (floor(), None, ["the room", "the ways", "the ends of the map"] * 2),
])
def test_each_costly_step_of_a_choice_has_a_packet_of_its_own(found, path, steps):
    explorer = that_has_looked_round()
    packets = 1
    while explorer.next(found, HERE, 10.0, path) is None:
        packets += 1
    assert packets == len(steps)


def test_a_choice_is_made_on_the_map_with_which_it_began():
    explorer = that_has_looked_round()
    assert explorer.next(floor((0.9, 1.9)), HERE, 10.0) is None
    assert chosen(explorer, floor((0.1, 1.1)), HERE, 10.1).end[1] > 1.1


def test_after_all_it_goes_home():
    explorer, _ = on_its_way()
    assert not explorer.homeward
    for time in (20.0, 30.0):
        explorer.refused()
        last = chosen(explorer, floor((0.5, 1.5)), HERE, time)
    assert explorer.homeward
    assert last.pose == Pose(2.0, 1.0, 0.5)
    assert last.reason.endswith(": home")


def test_a_wall_that_was_heard_from_afar_is_looked_at_from_near_when_no_end_is_left():
    goal = next_goal(floor(), HERE, RADIUS, doubt=Doubt(NOT_RIGHT, ()))
    assert goal.doubts and goal.with_heading and goal.reason == "to look from near at a wall that was heard from afar"
    assert goal.end[0] > 3.2 and math.hypot(goal.end[0] - goal.pose.x, goal.end[1] - goal.pose.y) < 0.8
    assert math.atan2(goal.end[1] - goal.pose.y, goal.end[0] - goal.pose.x) == pytest.approx(goal.pose.heading)
    assert not next_goal(floor((0.5, 1.5)), HERE, RADIUS, doubt=Doubt(NOT_RIGHT, ())).doubts, "ends come first"


def test_a_doubted_wall_is_looked_at_also_where_there_is_no_ample_room():
    found = floor()
    found.cells[1:14], found.cells[26:] = OCCUPIED, OCCUPIED
    doubt = Doubt(np.stack((np.linspace(0.5, 2.5, 41), np.full(41, 1.0)), axis=1), ())
    goal = next_goal(found, HERE, RADIUS, doubt=doubt)
    assert goal.doubts and goal.pose[:2] == pytest.approx((3.65, 1.0), abs=0.1)


def test_the_nearer_of_two_doubted_walls_is_chosen():
    found = GridMap(np.pad(floor().cells, ((0, 0), (40, 0)), constant_values=UNKNOWN), 0.05, (-2.0, 0.0))
    doubt = Doubt(driven(2.7)[driven(2.7)[:, 0] > 1.3], ())
    assert next_goal(found, Pose(1.0, 1.0, 0.0), RADIUS, doubt=doubt).end[0] < 0.1
    assert next_goal(found, Pose(3.0, 1.0, math.pi), RADIUS, doubt=doubt).end[0] > 3.9


def test_a_wall_that_the_robot_was_near_to_is_not_doubted():
    goal = next_goal(floor(), HERE, RADIUS, doubt=Doubt(driven(3.2), ()))
    assert goal.pose is None and goal.reason == "all that can be reached is known"


def test_a_wall_is_not_doubted_where_no_way_leads_beside_it():
    found = floor()
    found.cells[:, 70] = OCCUPIED
    found.cells[:, 77:79] = OCCUPIED
    assert next_goal(found, HERE, RADIUS, doubt=Doubt(NOT_RIGHT, ())).pose is None


def looking_at_the_right_wall():
    """An explorer on its way to a wall that it doubts, and that goal."""
    explorer = Explorer(Pose(2.0, 1.0, 0.5), RADIUS)
    for _ in range(3):
        chosen(explorer, floor(), HERE, 10.0, NOT_RIGHT)
    return explorer, chosen(explorer, floor(), HERE, 10.0, NOT_RIGHT)


def test_a_wall_that_was_looked_at_from_near_is_not_looked_at_again():
    explorer, goal = looking_at_the_right_wall()
    assert goal.doubts and not explorer.homeward
    last = chosen(explorer, floor(), goal.pose, 20.0, driven(3.2))
    assert explorer.homeward and last.reason == "all that can be reached is known: home"


def test_when_the_wall_is_gone_the_end_of_the_map_behind_it_is_next():
    explorer, goal = looking_at_the_right_wall()
    there = goal.pose
    beyond = chosen(explorer, floor((0.5, 1.5)), there, 20.0, NOT_RIGHT)
    assert not beyond.doubts and beyond.end is not None and "end of the map" in beyond.reason


@pytest.mark.parametrize("refused", (False, True))
def test_a_wall_that_it_cannot_come_near_is_looked_at_once(refused):
    explorer, goal = looking_at_the_right_wall()
    ends = []
    while goal.end is not None and len(ends) < 20:
        assert all(math.hypot(goal.end[0] - x, goal.end[1] - y) >= 0.5 for x, y in ends)
        ends.append(goal.end)
        if refused:
            explorer.refused()
        else:
            assert explorer.is_over(HERE, 10.0 + 100.0 * len(ends), floor())
        goal = chosen(explorer, floor(), HERE, 10.0 + 100.0 * len(ends), NOT_RIGHT)
    assert explorer.homeward and 1 <= len(ends) <= 5


def test_it_looks_at_no_more_walls_than_it_may():
    explorer = Explorer(Pose(2.0, 1.0, 0.5), RADIUS, ExploringNumbers(most_doubts=1))
    goals = [chosen(explorer, floor(), HERE, 10.0, driven(1.5)) for _ in range(5)]
    assert [goal.doubts for goal in goals] == [False, False, False, True, False] and explorer.homeward


def test_where_nothing_is_drawn_no_wall_is_doubted():
    assert not next_goal(wide_open(), HERE, RADIUS, doubt=Doubt(NOT_RIGHT, ())).doubts
    nothing = GridMap(np.full((1, 1), UNKNOWN, dtype=np.int8), 0.05, (0.0, 0.0))
    assert not next_goal(nothing, HERE, 2.0, doubt=Doubt(NOT_RIGHT, ())).doubts
