"""Every rule of the wander, one snapshot at a time. test/integration/test_wander.py tests the whole robot."""

import math
from dataclasses import replace

import pytest

from pioneer_control.floor_poses import Pose
from pioneer_control.tutorial.echoes import REMEMBERED, Echo, Motion
from pioneer_control.tutorial.wander import (
    AVOIDED, OPEN, SHORT, STALE, TIE, TOUCH_NEAR, TOUCH_REMEMBERED, TURN_RATE, Going, Memory, Room, Touch, Way,
    can_leave, wander)
from robots_and_snapshots import beside, shape, snapshot

FULL = shape("p3dx-sh", gripper=True)
NO_REAR = shape("p3dx-sh", gripper=True, rear_sonar=False)
SMALL = shape("amigo-sh")

DRIVING = Memory(going=Going.DRIVING)
NEAR_AHEAD = {number: 0.5 for number in (1, 2, 3, 4, 5, 6)}


def decide(ranges, memory=Memory(), robot=FULL, **more):
    """Make one decision on a snapshot."""
    return wander(snapshot(ranges, robot, **more), memory)


# The tutorial's rule

@pytest.mark.parametrize("farthest", [3, 4])
def test_forward_when_a_middle_sonar_is_the_farthest(farthest):
    command, _ = decide({farthest: 4.0}, everything_else=2.5)
    assert command.linear == pytest.approx(0.1) and command.angular == 0.0
    assert command.reason.startswith("driving: ")


@pytest.mark.parametrize("farthest, turn", [(1, 1), (2, 1), (5, -1), (6, -1)])
def test_otherwise_turn_on_the_spot_towards_the_farthest(farthest, turn):
    command, _ = decide({farthest: 4.1}, everything_else=2.5)
    assert command.linear == 0.0 and command.angular == pytest.approx(turn * TURN_RATE)
    assert command.reason == "turning %s: sonar %d sees 4.1 m" % ("left" if turn > 0 else "right", farthest)


@pytest.mark.parametrize("not_in_front", [0, 7, 8, 12, 15])
def test_only_the_front_sonars_are_compared(not_in_front):
    """Row 19: the original looked for the farthest range among all sixteen."""
    command, _ = decide({not_in_front: 4.9, 5: 4.0}, everything_else=2.5)
    assert command.angular < 0


def test_a_range_that_a_rear_sonar_has_too_is_still_the_front_ones():
    """Row 19 again: 4.0 is at index 0 first."""
    command, _ = decide({0: 4.0, 5: 4.0}, everything_else=2.5)
    assert command.angular < 0


def test_turn_back_when_nothing_ahead_is_open():
    """Row 20: the original kept its last command, and drove into the wall."""
    command, memory = decide({number: 0.9 for number in range(1, 7)}, DRIVING)
    assert command.linear == 0.0 and abs(command.angular) == pytest.approx(TURN_RATE)
    assert command.reason.startswith("turning back") and command.reason.endswith("no sonar ahead sees 2 m")
    assert memory.going is Going.TURNING


def test_what_it_calls_clear_is_not_more_than_its_sonars_see():
    """An earlier version of the wander said "no sonar ahead sees 2 m", and right after that "5.0 m clear", because it
    did not count what stands beside the way.
    """
    assert decide({3: 2.1, 4: 2.1}, everything_else=1.0)[0].reason == "driving: 2.1 m clear ahead"
    assert decide({3: 0.8, 4: 2.1}, DRIVING, everything_else=1.0)[0].reason < "driving: 1.0"


def test_no_turning_back_while_something_is_open():
    command, _ = decide({1: OPEN + 0.1}, everything_else=1.5)
    assert not command.reason.startswith("turning back")


def test_chance_chooses_the_side_and_the_seed_chooses_the_chance():
    """Row 21: the original gave two arguments to random.choice."""
    blocked = {number: 0.9 for number in range(1, 7)}
    sides = [decide(blocked, Memory(seed=seed))[0].angular for seed in range(40)]
    assert sides == [decide(blocked, Memory(seed=seed))[0].angular for seed in range(40)]
    assert set(sides) == {TURN_RATE, -TURN_RATE}


# What makes it get somewhere

def test_ties_go_to_the_middle():
    assert decide({})[0].linear > 0
    assert decide({1: 3.0 + TIE - 0.01}, everything_else=3.0)[0].linear > 0
    assert decide({1: 3.0 + TIE + 0.01}, everything_else=3.0)[0].angular > 0


def test_once_driving_it_goes_on_until_the_way_gets_short():
    side_is_farther = {1: 4.0, 2: 3.0, 3: SHORT + 0.1, 4: SHORT + 0.1}
    assert decide(side_is_farther)[0].linear == 0.0
    assert decide(side_is_farther, DRIVING)[0].linear > 0
    assert decide({**side_is_farther, 3: SHORT - 0.1, 4: SHORT - 0.1}, DRIVING)[0].linear == 0.0


def test_once_turning_it_keeps_to_its_side():
    _, memory = decide({1: 4.0}, everything_else=2.5)
    for number in (6, 5, 1, 6):
        command, memory = decide({number: 4.0}, memory, everything_else=2.5)
        assert command.angular == pytest.approx(TURN_RATE)


def test_after_enough_turning_it_takes_the_best_way_it_saw():
    """Nothing is open anywhere. At 90 degrees it sees farther than in other directions."""
    memory, heading, seen = Memory(seed=1), 0.0, []
    for step in range(800):
        ahead = 1.5 if abs(math.remainder(heading - math.pi / 2, 2 * math.pi)) < 0.1 else 1.2
        command, memory = decide({}, memory, everything_else=ahead, pose=(0.0, 0.0, heading), time=100 + step / 10)
        seen.append(command)
        if command.linear > 0:
            break
        heading += command.angular / 10
    assert abs(math.remainder(heading - math.pi / 2, 2 * math.pi)) < 0.2
    turned = sum(abs(each.angular) for each in seen) / 10
    assert 2 * math.pi < turned < 3 * math.pi + 2 * math.pi


def test_a_best_way_that_is_short_is_driven_all_the_same():
    memory = replace(DRIVING, short=0.4)
    assert decide({3: 0.9, 4: 0.9}, memory, everything_else=1.5)[0].linear > 0


BESIDE_AHEAD = {1: 0.23}  # it can pass that, but it could not turn round there


def test_where_it_cannot_turn_round_it_does_not_go_on_its_own_account():
    assert decide(BESIDE_AHEAD)[0].linear == 0.0
    assert decide(BESIDE_AHEAD, DRIVING)[0].linear == 0.0


def test_but_the_best_way_it_knows_it_goes_all_the_same_and_on_until_it_has_room_again():
    ranges = {**BESIDE_AHEAD, 3: 1.2, 4: 1.2}
    arrived = Memory(going=Going.TURNING, goal=Way(1.0, 0.0), best=Way(1.0, 0.0))
    command, memory = decide(ranges, arrived, everything_else=1.5)
    assert command.linear > 0
    command, memory = decide(ranges, memory, everything_else=1.5)
    assert command.linear > 0 and memory.room is Room.TO_PASS
    command, memory = decide({3: 1.2, 4: 1.2}, memory, everything_else=1.5)
    assert command.linear > 0 and memory.room is Room.TO_TURN_ROUND


def test_it_makes_itself_thin_only_when_there_is_no_other_way():
    assert decide({})[1].room is Room.TO_TURN_ROUND
    assert decide({}, robot=NO_REAR, everything_else=0.19)[1].room is Room.TO_SQUEEZE


# Safety

@pytest.mark.parametrize("robot", [FULL, NO_REAR, SMALL, shape("p3at-sh")])
def test_it_stops_before_what_stands_ahead(robot):
    middle = robot.middle[0]
    command, memory = decide({middle: 0.3, robot.middle[1]: 0.3}, DRIVING, robot)
    assert command.linear <= 0.0
    assert memory.going is not Going.DRIVING


def test_it_stops_for_what_only_one_side_sonar_sees_in_the_way():
    """Row 22: the original hit corners, because it used only the farthest sonar."""
    command, _ = decide({2: 0.27}, DRIVING)
    assert command.linear == 0.0


def test_it_slows_before_it_stops():
    ranges = {number: 0.95 for number in (3, 4)}
    assert decide(ranges, replace(DRIVING, short=0.3))[0].linear == pytest.approx(0.1)
    ranges = {number: 0.55 for number in (3, 4)}
    assert 0 < decide(ranges, replace(DRIVING, short=0.3))[0].linear < 0.1


def test_a_faster_robot_stops_farther_away():
    ranges = {number: 0.7 for number in (3, 4)}
    assert decide(ranges, replace(DRIVING, short=0.3, speed=0.1))[0].linear > 0
    assert decide(ranges, replace(DRIVING, short=0.3, speed=0.4))[0].linear == 0


@pytest.mark.parametrize("number", [1, 2, 3, 4, 5, 6])
def test_a_sonar_that_was_not_heard_is_an_obstacle(number):
    command, _ = decide({number: 0.0}, DRIVING)
    assert command.linear == 0.0


def test_nothing_heard_at_all_means_standing_still():
    """Row 17: the original drove on sixteen zeros."""
    command, _ = decide({}, DRIVING, everything_else=0.0)
    assert (command.linear, command.angular) == (0.0, 0.0)
    assert command.reason == "waiting: sonar 0 is not heard"


def test_a_stale_snapshot_means_standing_still():
    command, memory = decide({}, DRIVING, age=STALE + 0.01)
    assert (command.linear, command.angular) == (0.0, 0.0) and command.reason.startswith("stopped")
    assert memory == DRIVING
    assert decide({}, DRIVING, age=STALE - 0.01)[0].linear > 0


def test_a_robot_without_front_sonars_stands_still():
    blind = shape("p3dx-sh")
    corners = [(-0.3, -0.2), (0.2, -0.2), (0.2, 0.2), (-0.3, 0.2)]
    blind = type(blind)([each for each in blind.transducers if each.number > 7], corners)
    command, _ = decide({}, DRIVING, blind)
    assert (command.linear, command.angular) == (0.0, 0.0)


def test_a_turn_that_would_sweep_something_goes_the_other_way():
    """Something stands at the left of the rear, where the body moves when the robot turns right."""
    turning_right = Memory(going=Going.TURNING, side=-1)
    ranges = {**NEAR_AHEAD, 15: beside(FULL, 15) - 0.03, 14: beside(FULL, 14) - 0.03}
    command, _ = decide(ranges, turning_right, everything_else=1.0)
    assert command.angular > 0
    assert decide(NEAR_AHEAD, turning_right, everything_else=1.0)[0].angular < 0


def test_it_comes_to_rest_before_it_turns():
    _, memory = decide({}, DRIVING, pose=(0.0, 0.0, 0.0), time=100.0)
    command, memory = decide(NEAR_AHEAD, memory, pose=(0.01, 0.0, 0.0), time=100.1)
    assert (command.linear, command.angular) == (0.0, 0.0)
    command, _ = decide(NEAR_AHEAD, memory, pose=(0.01, 0.0, 0.0), time=100.2)
    assert command.angular != 0.0


# Backing off

ENCLOSED = {number: 0.21 for number in (0, 1, 2, 3, 4, 5, 6, 7)}


def until_it_backs_off(robot, ranges, decisions=200):
    """Return all commands until it reverses. Walls surround its front."""
    memory, commands = Memory(), []
    for step in range(decisions):
        command, memory = decide(ranges, memory, robot, time=100 + step / 10)
        commands.append(command)
        if command.linear < 0:
            break
    return commands, memory


def test_it_backs_off_when_it_is_enclosed_and_sees_behind():
    commands, memory = until_it_backs_off(FULL, {**ENCLOSED, 8: 0.2, 15: 0.2})
    assert commands[-1].linear < 0 and commands[-1].reason.startswith("backing off")
    assert memory.going is Going.BACKING


def test_it_does_not_back_off_into_what_it_sees():
    commands, _ = until_it_backs_off(FULL, {**ENCLOSED, 8: 0.2, 15: 0.2, 11: 0.2, 12: 0.2})
    assert all(command.linear >= 0 for command in commands)


@pytest.mark.parametrize("robot", [NO_REAR, SMALL])
def test_it_never_reverses_where_no_sonar_looks(robot):
    ranges = {number: 0.15 for number in range(6 if robot is SMALL else 8)}
    commands, _ = until_it_backs_off(robot, ranges)
    assert all(command.linear >= 0 for command in commands)


@pytest.mark.parametrize("speed, duration", [(0.1, 3.0), (0.3, 1.0)])
def test_backing_off_ends_after_the_same_way_at_any_speed(speed, duration):
    backing = Memory(going=Going.BACKING, since=100.0, speed=speed)
    assert decide(NEAR_AHEAD, backing, time=100 + duration - 0.1)[0].linear == pytest.approx(-0.7 * speed)
    assert decide(NEAR_AHEAD, backing, time=100 + duration + 0.1)[0].linear == 0


# Held by something that no sonar sees

HELD_REASON = "stopped: the wheels stall, something holds the robot"


def moves(memory, until, robot=FULL, stalled=lambda time: False, ranges=None, **more):
    """Return its moves from 100 s on, ten times a second. It turns as commanded."""
    heading, made = 0.0, []
    for tenth in range(round((until - 100) * 10)):
        time = 100 + tenth / 10
        now = {"time": time, "pose": (0.0, 0.0, heading), "stalled": stalled(time), **more}
        move, memory = decide(ranges or {}, memory, robot, **now)
        made.append((time, heading, move))
        heading += move.angular / 10
    return made, memory


def test_a_stall_stops_the_robot_at_once_and_is_said():
    move, memory = decide({}, DRIVING, stalled=True)
    assert move == (0.0, 0.0, HELD_REASON)
    assert memory.going is Going.HELD


def test_it_stands_until_the_wheels_have_been_free_for_a_while():
    made, _ = moves(DRIVING, 109, stalled=lambda time: 101 <= time < 107)
    assert {move for time, _, move in made if 101 <= time < 107.8} == {(0.0, 0.0, HELD_REASON)}
    assert made[0][2].linear > 0 and made[-1][2].linear < 0


def test_then_it_backs_off_and_drives_another_way():
    made, memory = moves(DRIVING, 125, stalled=lambda time: time < 101)
    kinds = [move.reason.partition(":")[0].split()[0] for _, _, move in made]
    assert [kind for number, kind in enumerate(kinds) if kinds[number - 1] != kind] == [
        "stopped", "backing", "halting", "turning", "driving"]
    first_heading = next(heading for _, heading, move in made if move.linear > 0)
    assert abs(first_heading) > AVOIDED
    assert memory.avoided is None, "once it drives elsewhere it may go anywhere"


@pytest.mark.parametrize("robot, ranges", [(NO_REAR, {}), (FULL, {11: 0.2, 12: 0.2})])
def test_it_backs_off_only_where_it_sees_that_nothing_is_there(robot, ranges):
    made, _ = moves(DRIVING, 125, robot, stalled=lambda time: time < 101, ranges=ranges)
    assert all(move.linear >= 0 for _, _, move in made)
    assert all(abs(heading) > AVOIDED for _, heading, move in made if move.linear > 0)
    assert made[-1][2].linear > 0, "it finds another way all the same"


def test_what_holds_it_while_it_backs_off_is_not_pushed_again():
    made, _ = moves(DRIVING, 125, stalled=lambda time: time < 101 or 103 < time < 104)
    assert any(move.linear < 0 for time, _, move in made if time < 103)
    assert all(move.linear >= 0 for time, _, move in made if time > 103)


def test_held_while_it_turns_it_stops_too():
    turning = Memory(going=Going.TURNING, side=1)
    assert decide(NEAR_AHEAD, turning)[0].angular > 0
    assert decide(NEAR_AHEAD, turning, stalled=True)[0] == (0.0, 0.0, HELD_REASON)


def test_a_turn_that_stalls_is_remembered_and_leaves_the_way_ahead_free():
    _, memory = decide(NEAR_AHEAD, Memory(going=Going.TURNING, side=-1), stalled=True, pose=(1.0, 2.0, 3.0))
    assert memory.touches == (Touch(Pose(1.0, 2.0, 3.0), -1, 100.0),) and memory.avoided is None
    assert decide(NEAR_AHEAD, memory, stalled=True, time=100.1, pose=(1.0, 2.0, 3.0))[1].touches == memory.touches


@pytest.mark.parametrize("touch, turn", [
    (Touch(Pose(0.0, 0.0, 0.2), 1, 99.0), -1),
    (Touch(Pose(0.0, 0.0, -0.2), 1, 99.0), -1),
    (Touch(Pose(0.0, 0.0, 1.0), 1, 99.0), 1),
    (Touch(Pose(0.1, 0.0, 0.7), 1, 99.0), -1),
    (Touch(Pose(0.0, 0.0, -0.2), -1, 99.0), 1),
    (Touch(Pose(TOUCH_NEAR + 0.01, 0.0, 0.2), 1, 99.0), 1),
    (Touch(Pose(0.0, 0.0, 0.2), 1, 99.0 - TOUCH_REMEMBERED), 1)])
def test_it_does_not_turn_into_what_it_touched(touch, turn):
    """It keeps to its side unless it would touch again: near the same place, before or just past the same heading."""
    side = touch.side
    move, _ = decide(NEAR_AHEAD, Memory(going=Going.TURNING, side=side, touches=(touch,)), SMALL, everything_else=1.5)
    assert move.angular == pytest.approx(turn * TURN_RATE)


def test_nothing_leads_back_to_what_held_it():
    """It is in a dead end. The only open way leads to what held it."""
    dead_end = {number: 0.22 for number in (0, 1, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15)}
    made, _ = moves(DRIVING, 140, stalled=lambda time: time < 101, ranges=dead_end)
    assert all(abs(math.remainder(heading, 2 * math.pi)) > AVOIDED for _, heading, move in made if move.linear > 0)


# Leaving what was put down

LEAVING = Memory(going=Going.LEAVING)


def test_it_backs_away_from_what_it_put_down_and_goes_another_way():
    made, _ = moves(LEAVING, 125)
    assert all(move.linear < 0 and move.angular == 0 for time, _, move in made if time < 102.9)
    assert abs(next(heading for _, heading, move in made if move.linear > 0)) > AVOIDED


@pytest.mark.parametrize("robot, ranges", [(NO_REAR, {}), (FULL, {11: 0.2, 12: 0.2})])
def test_it_takes_nothing_along_where_it_cannot_back_away(robot, ranges):
    made, _ = moves(LEAVING, 110, robot, ranges=ranges)
    assert {move for _, _, move in made} == {(0.0, 0.0, "waiting: for room behind, to leave what was put down")}


def test_whether_it_could_leave_is_known_before():
    assert can_leave(snapshot({}, FULL))
    assert not can_leave(snapshot({}, NO_REAR))
    assert not can_leave(snapshot({11: 0.4, 12: 0.4}, FULL))


# Memory

# Where the body turns when it turns right, and a robot without rear sonar sees nothing.
BEHIND_ON_THE_LEFT = (-0.255, 0.255)


@pytest.mark.parametrize("age, turn", [(0.1, 1), (1.1, -1)])
def test_it_remembers_for_a_while_what_it_does_not_see(age, turn):
    memory = Memory(going=Going.TURNING, side=-1, time=99.9, echoes=(Echo(*BEHIND_ON_THE_LEFT, age),))
    command, _ = decide(NEAR_AHEAD, memory, NO_REAR, everything_else=1.5)
    assert command.angular == pytest.approx(turn * TURN_RATE)


@pytest.mark.parametrize("before, motion", [
    ((0.0, 0.0, 0.0), Motion.STANDS), ((0.0, 0.0, -1.0), Motion.TURNS), ((-0.2, 0.0, 0.0), Motion.DRIVES),
    ((-0.008, 0.0, -0.018), Motion.STANDS), ((-0.012, 0.0, 0.0), Motion.DRIVES), ((0.0, 0.0, -0.022), Motion.DRIVES)])
def test_for_how_long_depends_on_whether_it_stands_turns_or_drives(before, motion):
    """The pose is that of a second ago."""
    memory = Memory(going=Going.TURNING, time=99.0, pose=Pose(*before), echoes=(Echo(*BEHIND_ON_THE_LEFT),))
    _, after = decide(NEAR_AHEAD, memory, NO_REAR, everything_else=1.5)
    (age,) = [echo.age for echo in after.echoes if (echo.x, echo.y) == BEHIND_ON_THE_LEFT]
    assert age == pytest.approx(1.0 / REMEMBERED[motion])


def test_a_memory_is_not_changed_by_a_decision():
    memory = Memory(seed=5)
    before = replace(memory)
    decide(NEAR_AHEAD, memory)
    assert memory == before


# Other robots

def test_an_eight_sonar_robot_wanders_by_the_same_rule():
    """Row 17: the original ignored every message that did not have sixteen ranges."""
    assert decide({}, robot=SMALL)[0].linear > 0
    assert decide({1: 4.0}, robot=SMALL, everything_else=2.5)[0].angular == pytest.approx(TURN_RATE)
    assert decide({4: 4.0}, robot=SMALL, everything_else=2.5)[0].angular == pytest.approx(-TURN_RATE)


def test_a_robot_with_a_gap_straight_ahead_weaves():
    turns = [decide({}, robot=SMALL, time=100 + step / 2)[0].angular for step in range(8)]
    assert min(turns) < -0.1 and max(turns) > 0.1
    assert {decide({}, time=100 + step / 2)[0].angular for step in range(8)} == {0.0}


def test_it_keeps_away_from_the_nearer_side():
    assert decide({0: 0.3}, DRIVING)[0].angular < 0
    assert decide({7: 0.3}, DRIVING)[0].angular > 0


def test_the_curve_away_from_the_nearer_side_is_as_sharp_at_any_speed():
    slow, fast = (decide({0: 0.3}, replace(DRIVING, speed=speed))[0] for speed in (0.1, 0.25))
    assert fast.angular / 0.25 == pytest.approx(slow.angular / 0.1)
