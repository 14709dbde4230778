"""The navigator: it reaches goals, refuses bad ones, stands for each reason and says it, and gives up with a reason."""

import math

import numpy as np
import pytest
from floor_for_tests import chassis_of, room, sensing_at

from pioneer_control.floor_poses import Pose, wrapped
from pioneer_control.maps.grid_map import FREE, OCCUPIED, GridMap
from pioneer_control.navigation import navigator
from pioneer_control.navigation.navigator import NavigationNumbers, Navigator, Readiness, State, kind_of
from pioneer_control.navigation.planning import NOT_SLOW, DrivableFloor, RoutePlan
from pioneer_control.navigation.steering import slowness
from pioneer_control.navigation.suspected_walls import SuspectedWalls
from pioneer_control.navigation.tuned import NavigatorNumbers, ObstacleNumbers, SteeringNumbers
from pioneer_control.navigation.values import STOP, Firing, Sensing, Twist

WELL = Readiness()
SOON = NavigationNumbers(navigator=NavigatorNumbers(wait=6.0, patience=9.0))
START = Pose(1.0, 1.0, 0.0)
WALL = [(3.9, 1.6 + 0.1 * number) for number in range(9)]


class Spot:
    """A place for the navigator."""

    def __init__(self, pose, sure=True, reason="", line=()):
        self.pose, self.sure, self.reason, self.line = pose, sure, reason, line


class Run:
    """A robot that a navigator drives in a room. It speeds up and brakes as it was asked to."""

    def __init__(self, grid_map=None, subtype="p3dx-sh", start=START, posts=()):
        self.chassis, self.walls, self.posts = chassis_of(subtype), grid_map or room(), posts
        self.navigator = Navigator(self.walls, self.chassis, SOON)
        self.pose, self.time, self.decision, self.velocity = start, 100.0, None, STOP

    def sensing(self):
        return sensing_at(self.chassis, self.pose, self.time, self.posts, self.walls)

    def step(self, ready=WELL, where=None, sensing=None):
        self.decision = self.navigator.step(
            sensing or self.sensing(), where or Spot(self.pose), ready, self.time)
        x, y, heading = self.pose
        (linear, angular), self.velocity = self.velocity, STOP if ready.stalled else self.faster()
        middle = heading + 0.05 * angular
        self.pose = Pose(x + 0.1 * linear * math.cos(middle), y + 0.1 * linear * math.sin(middle),
                         wrapped(heading + 0.1 * angular))
        self.time += 0.1
        return self.decision

    def faster(self):
        """Return the velocity that it has 0.1 s after it was told one."""
        wanted, has, most = self.decision.twist, self.velocity, self.navigator.acceleration_wanted
        linear = most.linear if abs(wanted.linear) > abs(has.linear) else most.braking
        return Twist(*(old + min(max(new - old, -0.1 * rate), 0.1 * rate)
                       for new, old, rate in zip(wanted, has, (linear, most.angular))))

    def until(self, *states, seconds=120.0, **how):
        end = self.time + seconds
        while self.time < end and self.step(**how).state not in states:
            pass
        return self.decision

    def driving(self, goal=(4.5, 2.5, None)):
        """Begin to drive, and return the run when it moves."""
        self.step()
        assert self.navigator.go_to(*goal, self.time) == ""
        for _ in range(8):
            self.step()
        assert self.decision.state is State.DRIVING and self.decision.twist != STOP
        return self


@pytest.mark.parametrize("subtype", ["p3dx-sh", "p3at-sh", "amigo-sh"])
def test_it_reaches_a_goal_and_its_heading(subtype, heading=2.0):
    run = Run(subtype=subtype).driving((4.5, 2.5, heading))
    decision = run.until(State.REACHED, State.FAILED, seconds=60.0)
    assert decision == (STOP, State.REACHED, "reached the goal")
    assert math.hypot(run.pose.x - 4.5, run.pose.y - 2.5) < 0.05
    assert abs(wrapped(run.pose.heading - heading)) < 0.06


def test_it_begins_to_turn_to_the_heading_of_the_goal_while_it_brakes():
    run = Run(start=Pose(2.0, 2.0, 0.0)).driving((4.0, 2.0, 2.0))
    while run.step().twist.linear > 0.0:
        pass
    assert run.decision.twist.angular > 0.5 and run.velocity.linear > 0.25
    run.until(State.REACHED)
    assert math.hypot(run.pose.x - 4.0, run.pose.y - 2.0) < 0.05 and abs(run.pose.heading - 2.0) < 0.05


@pytest.mark.parametrize("prompt, slow", [
    (Readiness(on_the_way=0.0), Readiness(on_the_way=0.1)), (Readiness(late=0.0), Readiness(late=0.2))])
def test_the_longer_a_packet_needs_the_earlier_it_begins_to_brake_at_the_goal(prompt, slow):
    """By the way in 0.1 s or more at the 0.1 m/s or more that it has there."""
    ends = []
    for readiness in (prompt, slow):
        run = Run(start=Pose(2.0, 2.0, 0.0)).driving((4.0, 2.0, 2.0))
        while run.step(readiness).twist.linear > 0.0:
            pass
        ends.append(run.pose.x)
    assert ends[0] - ends[1] > 0.01


def test_it_counts_the_floor_that_it_covers_until_it_stands_from_what_may_walk():
    run = Run(start=Pose(2.0, 2.0, 0.0)).driving((4.5, 2.0, None))
    run.posts = [(run.pose.x + 0.8, run.pose.y + side * 0.4) for side in (-1.0, 1.0)]
    for _ in range(3):
        run.step()
    around = run.navigator._around(run.pose, run.time)
    for distances in (around.apart, around.beside):
        assert distances.min() < distances[-1] - 0.1 < math.inf


def test_it_drives_round_what_is_on_no_map():
    post = (2.75, 1.75)
    run, nearest = Run(posts=[post]).driving(), math.inf
    while run.step().state not in (State.REACHED, State.FAILED) and run.time < 200.0:
        nearest = min(nearest, math.hypot(run.pose.x - post[0], run.pose.y - post[1]))
    assert run.decision.state is State.REACHED and 0.22 < nearest


@pytest.mark.parametrize("away, ends", [(0.08, State.REACHED), (0.15, State.FAILED)])
def test_where_something_stands_at_the_goal_a_place_near_it_is_good_enough(away, ends):
    ring = [(2.75 + 0.55 * math.cos(angle), 2.5 + 0.55 * math.sin(angle)) for angle in np.arange(0.0, 6.2, 0.3)]
    run = Run(start=Pose(2.75, 2.5, 0.0), posts=ring)
    run.step()
    assert run.navigator.go_to(2.75 + away, 2.5, None, run.time) == ""
    assert run.until(State.REACHED, State.FAILED).state is ends


@pytest.mark.parametrize("posts, doing", [
    ((), "on the way, 3."), ([(2.75, 1.75)], "going round what is on no map, 3.")])
def test_it_says_what_it_does_and_how_far_it_has_to_go(posts, doing):
    run = Run(posts=posts).driving()
    said = {run.step().reason for _ in range(15)}
    assert doing in {reason[:len(doing)] for reason in said} and all(reason.endswith(" m to go") for reason in said)
    assert doing[:-2] in {kind_of(reason) for reason in said}


def test_a_reason_is_of_the_same_kind_with_another_number():
    assert kind_of("on the way, 3.2 m to go") == kind_of("on the way, 12.0 m to go")
    assert kind_of("a wheel stalls") != kind_of("the sonar is silent")


def stands(run):
    return run.decision.twist == STOP and run.decision.state is State.WAITING and "giving way" in run.decision.reason


def test_it_stands_while_somebody_walks_beside_it_and_goes_on_after():
    run, told = Run(start=Pose(1.0, 2.0, 0.0)).driving((5.0, 2.0, None)), set()
    for step in range(40):      # past the robot on its left, from behind
        run.posts = [(run.pose.x - 0.3 + 0.03 * step, run.pose.y + 0.4)]
        gives_way = run.step().reason.startswith("giving way")
        told |= {run.navigator._task.last_twist} if gives_way else set()
        assert step < 6 or step > 20 or stands(run)
    assert told == {STOP}, "it brakes already when it goes on"
    run.posts = ()
    assert run.until(State.REACHED, State.FAILED).state is State.REACHED


def test_who_was_beside_it_and_is_not_heard_any_more_may_be_where_it_turns_or_drives_backward():
    run = Run(subtype="amigo-sh", start=Pose(1.0, 2.0, 0.0))
    run.step()
    assert run.navigator.go_to(0.4, 2.0, None, run.time) == ""
    for seconds, post in ((1.5, (1.07, 2.34)), (1.8, (0.88, 2.3))):     # the second is behind its side, unheard
        run.posts, end = [post], run.time + seconds
        while run.time < end:
            run.step()
            assert run.decision.twist == STOP or run.decision.twist.linear > 0.0
    while run.step().twist.linear > 0.0 or run.decision.twist == STOP:
        assert run.time < 106.0


def test_it_goes_on_beside_what_has_proved_to_stand_still():
    run = Run(start=Pose(1.0, 2.0, 0.0)).driving((5.0, 2.0, None))
    run.posts, began = [(run.pose.x + 0.05, run.pose.y + 0.4)], run.time
    assert run.until(State.WAITING, seconds=0.5) and stands(run)
    run.until(State.DRIVING)
    assert 1.8 < run.time - began < 3.0


def test_who_came_while_it_stood_must_stand_longer():
    """5685: who had stood beside an AmigoBot for three seconds walked on when it began to turn."""
    run = Run(start=Pose(1.0, 2.0, 0.0)).driving((5.0, 2.0, None))
    for _ in range(20):
        run.step(Readiness(motors=False))
    run.posts, began = [(run.pose.x + 0.05, run.pose.y + 0.4)], run.time
    run.step()
    assert stands(run)
    run.until(State.DRIVING)
    assert 3.8 < run.time - began < 5.0


def test_beside_what_stands_still_and_is_on_no_map_it_is_slow_for_that_may_begin_to_walk():
    post = (1.3, 2.0 + chassis_of().half_width + 0.14)
    run, speeds = Run(start=Pose(1.0, 2.0, 0.0), posts=[post]), []
    run.step()
    assert run.navigator.go_to(4.5, 2.0, None, run.time) == ""
    while "giving way" not in run.step().reason:
        pass
    while run.step().state is not State.REACHED and run.time < 200.0:
        speeds.append((run.pose.x < post[0], run.decision.twist.linear))
    assert run.decision.state is State.REACHED
    assert 0.1 < max(speed for beside, speed in speeds if beside) <= 0.2 < max(speed for _, speed in speeds)


def test_without_a_goal_it_stands():
    assert Run().step() == (STOP, State.IDLE, "no goal")


def test_after_cancel_it_stands():
    run = Run().driving()
    run.navigator.cancel()
    assert run.step() == (STOP, State.IDLE, "no goal") and run.navigator.plan == []


def test_it_makes_one_plan_a_packet_at_most(monkeypatch):
    """A plan of a large map takes tens of milliseconds."""
    run, goals = Run(posts=[(2.75, 1.75)]), []
    for name, plan in (("to", DrivableFloor.to), ("past", DrivableFloor.past)):
        monkeypatch.setattr(DrivableFloor, name,
                            lambda self, *about, plan=plan: goals.append(about) or plan(self, *about))
    run.step()
    run.navigator.go_to(4.5, 2.5, None, run.time)
    counts = []
    for _ in range(30):
        goals.clear()
        run.step()
        counts.append(len(goals))
    assert max(counts) == 1 and sum(counts) > 3


def test_a_goal_may_be_sent_before_anything_was_heard():
    """Its time is 0 then, and the robot gave up at once: "no way on for 100 s"."""
    run = Run()
    assert run.navigator.go_to(4.5, 2.5, None, 0.0) == ""
    assert run.until(State.REACHED, State.FAILED).state is State.REACHED


def test_a_new_goal_takes_the_place_of_the_old_one():
    run = Run().driving((4.5, 2.5, None))
    assert run.navigator.go_to(1.0, 3.0, None, run.time) == ""
    run.until(State.REACHED, State.FAILED)
    assert math.hypot(run.pose.x - 1.0, run.pose.y - 3.0) < 0.05


@pytest.mark.parametrize("goal, reason", [
    ((math.nan, 1.0, None), "not finite"), ((2.0, math.inf, None), "not finite"),
    ((2.0, 2.0, math.nan), "the heading nan of the goal is not finite"),
    ((9.0, 2.0, None), "outside of the map"), ((0.02, 2.0, None), "in a wall"), ((0.2, 2.0, None), "the robot needs")])
def test_a_goal_is_refused_with_a_reason_and_an_earlier_one_stays(goal, reason):
    run = Run()
    run.step()
    refusal = run.navigator.go_to(*goal, run.time)
    assert reason in refusal
    assert run.step() == (STOP, State.FAILED, refusal)
    run.driving()
    assert run.navigator.go_to(*goal, run.time) == refusal
    assert run.step().state is State.DRIVING
    assert run.until(State.REACHED, State.FAILED).state is State.REACHED


@pytest.mark.parametrize("heading, fits", [(0.0, True), (math.pi, True), (0.5, False), (math.pi / 2, False)])
def test_a_goal_where_the_robot_does_not_fit_with_its_heading_is_refused(heading, fits):
    run = Run(start=Pose(3.0, 2.0, 0.0))
    run.step()
    refusal = run.navigator.go_to(3.0, 0.32, heading, run.time)      # beside a wall
    assert (refusal == "") == fits and fits == ("does not fit" not in refusal)
    assert run.navigator.go_to(3.0, 0.32, None, run.time) == ""


def test_what_can_be_reached_is_judged_from_where_the_robot_is_now():
    cells = room().cells.copy()
    cells[:, 60] = OCCUPIED
    run = Run(GridMap(cells, 0.05, (0.0, 0.0))).driving((2.0, 3.0, None))
    run.until(State.REACHED)
    run.pose = Pose(4.5, 2.0, 0.0)      # it was carried to the other side, and knows it
    run.step()
    assert "cannot be reached" in run.navigator.go_to(2.0, 3.0, None, run.time)
    assert run.navigator.go_to(5.0, 3.0, None, run.time) == ""


def test_each_reason_to_wait_has_its_own_time_also_after_something_stood_in_the_way():
    run = Run().driving()
    for _ in range(10):
        run.step(ready=Readiness(motors=False))
    run.posts = [(run.pose.x + 0.5 * math.cos(angle), run.pose.y + 0.5 * math.sin(angle))
                 for angle in np.arange(0.0, 6.2, 0.3)]
    for _ in range(55):
        assert run.step().state in (State.WAITING, State.DRIVING)
    assert run.step(ready=Readiness(motors=False)) == (STOP, State.WAITING, "motor power is off")


def test_a_goal_behind_a_wall_is_refused_also_when_it_was_given_before_the_robot_knew_where_it_is():
    cells = room().cells.copy()
    cells[:, 60] = OCCUPIED
    run = Run(GridMap(cells, 0.05, (0.0, 0.0)))
    assert run.navigator.go_to(4.5, 2.0, None, run.time) == ""
    assert run.step().state is State.FAILED and "cannot be reached" in run.decision.reason
    assert "cannot be reached" in run.navigator.go_to(4.5, 2.0, None, run.time)


@pytest.mark.parametrize("ready, reason", [
    (Readiness(stalled=True), "a wheel stalls"),
    (Readiness(may_command=False), "somebody else has the helm"),
    (Readiness(motors=False), "motor power is off"),
])
def test_it_stands_at_once_says_why_goes_on_when_it_may_and_gives_up_at_last(ready, reason):
    run = Run().driving()
    assert run.step(ready=ready) == (STOP, State.WAITING, reason)
    run.until(State.DRIVING, seconds=3.0)
    assert run.decision.state is State.DRIVING
    pose = run.pose
    decision = run.until(State.FAILED, seconds=10.0, ready=ready)
    assert decision.state is State.FAILED and reason in decision.reason and "gave up after 6 s" in decision.reason
    assert math.hypot(run.pose.x - pose.x, run.pose.y - pose.y) < 0.4 ** 2 / (2 * 0.8) + 0.02


def test_waiting_for_long_is_no_reason_to_give_up_after_it():
    run = Run().driving()
    for _ in range(55):
        run.step(ready=Readiness(may_command=False))
    assert run.until(State.REACHED, State.FAILED).state is State.REACHED


def test_short_waits_do_not_lengthen_its_patience():
    """Each packet of a wait added the whole wait to it, so it never gave up."""
    run = Run().driving()
    there, driven = run.pose, 0
    while run.decision.state is not State.FAILED and run.time < 200.0:     # something holds it: no sonar hears what
        run.step(Readiness(motors=not 2.0 < run.time % 4.0 < 3.0, may_command=run.time % 4.0 < 3.0))
        driven += run.decision.state is State.DRIVING
        run.pose, run.velocity = there, STOP
    assert "no way on" in run.decision.reason and 80 < driven < 110


def test_it_stands_when_what_it_senses_is_old_or_stops():
    run = Run().driving()
    old = run.sensing()
    run.time += 0.7
    decision = run.step(sensing=old)
    assert decision.twist == STOP and decision.reason == "what the robot sensed is 0.7 s old"
    run.time += 150.0
    assert run.step(sensing=old).twist == STOP


@pytest.mark.parametrize("late, gap, speed", [(0.0, 0.1, 0.4), (0.4, 0.1, 0.24), (0.0, 0.5, 0.32)])
def test_it_is_slow_towards_a_wall_while_packets_come_late_or_not_at_all(late, gap, speed):
    run = Run(start=Pose(5.3, 2.0, 0.0))
    run.step()
    assert run.navigator.go_to(5.65, 2.0, None, run.time) == ""
    for _ in range(10):
        run.time += gap
        decision = run.navigator.step(run.sensing(), Spot(run.pose), WELL, run.time + late)
    assert decision.twist.linear == pytest.approx(speed)


def test_it_stands_when_the_clock_jumps_back():
    run = Run().driving()
    ahead = run.sensing()
    run.time -= 50.0
    assert run.step(sensing=ahead).twist == STOP
    run.until(State.DRIVING, seconds=3.0)
    assert run.decision.state is State.DRIVING


def test_it_stands_when_the_sonar_is_silent():
    run = Run().driving()
    for _ in range(15):
        run.step(sensing=Sensing(run.time, run.pose, ()))
    assert run.decision == (STOP, State.WAITING, "the sonar is silent")


def test_it_does_not_drive_ahead_when_only_the_sonar_behind_fires():
    run = Run().driving()
    for _ in range(40):
        whole = run.sensing()
        run.step(sensing=whole._replace(firings=tuple(each for each in whole.firings if each.number >= 8)))
        if run.time > 103.0:
            assert run.decision.twist.linear <= 0.0


@pytest.mark.parametrize("sensing", [
    None, Sensing(math.nan, START, ()), Sensing(101.0, Pose(math.nan, 0.0, 0.0), ()),
    Sensing(101.0, Pose(0.0, 0.0, math.inf), ())])
def test_nothing_moves_on_what_makes_no_sense(sensing):
    run = Run().driving()
    decision = run.navigator.step(sensing, Spot(run.pose), WELL, run.time)
    assert decision.twist == STOP and decision.state is State.WAITING
    assert decision.reason == "the robot has sensed nothing that makes sense"


@pytest.mark.parametrize("firing", [Firing(3, math.nan, 100.0), Firing(-4, 1.0, 100.0), Firing(3, 1.0, math.nan)])
def test_a_firing_that_makes_no_sense_does_not_end_it(firing):
    run = Run().driving()
    whole = run.sensing()
    run.step(sensing=whole._replace(firings=whole.firings + (firing,)))
    assert run.until(State.REACHED, State.FAILED).state is State.REACHED


def lost(reason="nothing fits"):
    return Spot(Pose(3.0, 3.0, 0.0), False, reason)


@pytest.mark.parametrize("where", [lost(), Spot(Pose(math.nan, 0.0, 0.0))])
def test_it_stops_when_it_does_not_know_where_it_is(where):
    run = Run().driving()
    decision = run.step(where=where)
    assert decision.twist == STOP and decision.state is State.WAITING
    assert decision.reason == where.reason or decision.reason == "the robot does not know where it is"


def test_it_looks_around_where_there_is_room_and_never_drives_while_unsure():
    run = Run(start=Pose(3.0, 2.0, 0.0)).driving((1.0, 1.0, None))
    turned, places = 0.0, []
    for _ in range(55):
        run.step(where=lost())
        assert run.decision.twist.linear == 0.0
        turned += abs(run.decision.twist.angular) * 0.1
        places.append(run.pose)
    assert turned > 1.0 and "nothing fits" in run.decision.reason
    assert math.hypot(run.pose.x - places[10].x, run.pose.y - places[10].y) < 0.01
    assert run.until(State.REACHED, State.FAILED).state is State.REACHED


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_it_looks_around_at_once_to_where_its_way_begins_and_at_last_all_round(side):
    run, headings = Run(start=Pose(3.0, 2.0, 0.0)), []
    run.navigator = Navigator(run.walls, run.chassis)
    run.step()
    run.navigator.go_to(3.0 + 1.5 * math.cos(0.5), 2.0 + side * 1.5 * math.sin(0.5), None, run.time)
    for _ in range(250):
        run.step(where=Spot(run.pose, False, "nothing fits"))
        headings.append(run.pose.heading * side)
    assert headings[5] > 0.05 and max(headings[:50]) < 0.5 + 0.7
    assert min(headings) < -2.5 and max(headings) > 2.5


@pytest.mark.parametrize("posts, seconds, turns", [
    ([(3.07, 2.34)], 4.0, False), ([(3.07, 2.34)], 14.0, True), ([(3.07, 2.5)], 4.0, True), ([], 4.0, True)])
def test_it_does_not_look_around_beside_who_has_just_come_and_may_go_on(posts, seconds, turns):
    run = Run(subtype="amigo-sh", start=Pose(3.0, 2.0, 0.0))
    run.navigator = Navigator(run.walls, run.chassis)
    run.driving((5.0, 2.0, None))
    run.pose, run.velocity, run.posts = Pose(3.0, 2.0, 0.0), STOP, posts
    run.step()
    turned = [run.step(where=lost()).twist.angular != 0.0 for _ in range(round(10.0 * seconds))]
    assert any(turned) == turns


def test_it_looks_around_beside_what_may_always_have_been_there():
    """A robot that was carried hears all that is beside it for the first time. It stood ten seconds at each of it."""
    run = Run(subtype="amigo-sh", start=Pose(3.0, 2.0, 0.0))
    run.navigator = Navigator(run.walls, run.chassis)
    run.driving((5.0, 2.0, None))
    run.navigator._obstacles.forget()
    run.pose, run.velocity, run.posts = Pose(3.0, 2.0, 0.0), STOP, [(3.07, 2.34)]
    run.step()
    turned = [run.step(where=lost()).twist.angular != 0.0 for _ in range(40)]
    assert not any(turned[:10]) and any(turned), "whatever is so near may walk until it was heard for some time"


def test_it_looks_around_also_in_a_corridor():
    cells = room().cells.copy()
    cells[52:, :] = cells[:28, :] = OCCUPIED
    run = Run(GridMap(cells, 0.05, (0.0, 0.0)), "p3at-sh", Pose(3.0, 2.0, 0.0)).driving((5.0, 2.0, None))
    assert any(run.step(where=lost()).twist.angular for _ in range(50))


def corridor():
    """Return the map of a corridor of 6 x 1.2 m along x."""
    cells = room().cells.copy()
    cells[52:, :] = cells[:28, :] = OCCUPIED
    return GridMap(cells, 0.05, (0.0, 0.0))


def somewhere_along(run, back=0.8, ahead=0.8):
    """Return where a robot is that knows all but how far along a corridor it is."""
    x, y, heading = run.pose
    return Spot(run.pose, False, "I may be 0.4 m off", [
        Pose(x + off, y, heading) for off in np.linspace(-back, ahead, 9)])


@pytest.mark.parametrize("heading", [0.3, 2.8])
def test_unsure_only_of_where_along_a_corridor_it_looks_from_elsewhere_slowly_and_not_for_too_long(heading):
    run = Run(corridor(), "amigo-sh", Pose(3.0, 2.0, heading))
    run.navigator = Navigator(run.walls, run.chassis, NavigationNumbers(navigator=NavigatorNumbers(unsure_drive=14.0)))
    run.driving((5.0, 2.0, None))
    start, speeds, places = run.pose.x, [], []
    for _ in range(400):
        speeds.append(run.step(where=somewhere_along(run)).twist.linear)
        places.append(abs(run.pose.x - start))
        assert run.decision.state is State.WAITING and abs(run.pose.y - 2.0) < 0.2
    assert not any(speeds[:50]) and 0.1 < max(np.abs(speeds)) <= 0.15 and not any(speeds[145:])
    assert 0.8 < max(places) < 1.5


@pytest.mark.parametrize("speed, turns", [(0.15, 1.0), (0.0, -1.0)])
def test_it_turns_along_a_corridor_as_slowly_as_it_looks_around_and_not_at_all_if_it_may_not_drive_there(speed, turns):
    """The nearer way along it is to the left; to look around it turned right, to its goal."""
    there = Pose(3.0, 2.0, 2.0)
    run = Run(corridor(), "amigo-sh", there)
    run.navigator = Navigator(run.walls, run.chassis, NavigationNumbers(navigator=NavigatorNumbers(unsure_speed=speed)))
    run.driving((5.0, 2.0, None))
    for _ in range(70):
        run.pose, run.velocity = there, STOP
        run.step(where=somewhere_along(run))
    assert run.decision.twist == (0.0, pytest.approx(0.4 * turns))


@pytest.mark.parametrize("posts, ahead, least, most", [((), 0.8, 0.9, 2.0), (WALL, 0.8, 0.3, 0.6),
                                                       ((), 2.5, 0.1, 0.3)])
def test_along_a_corridor_it_stops_before_what_it_hears_and_where_a_wall_may_be(posts, ahead, least, most):
    run = Run(corridor(), "amigo-sh", Pose(3.0, 2.0, 0.0), posts)
    run.navigator = Navigator(run.walls, run.chassis)
    run.step()
    run.navigator.go_to(5.0, 2.0, None, run.time)
    places = []
    for _ in range(150):
        run.step(where=somewhere_along(run, 0.8, ahead))
        places.append(run.pose.x - 3.0)
    assert least < max(places) < most


def test_it_does_not_turn_into_a_wall_that_gave_no_echo():
    run = Run(start=Pose(3.0, 2.0, 0.0)).driving((1.0, 1.0, None))
    run.step(where=Spot(Pose(2.0, 0.27, 0.0)))      # where it was sure last: beside a wall
    for _ in range(50):
        assert run.step(where=lost(), sensing=Sensing(run.time, run.pose, (Firing(3, 4.0, run.time),))).twist == STOP


def test_another_doubt_is_the_same_wait():
    run = Run(start=Pose(3.0, 2.0, 0.0)).driving((1.0, 1.0, None))
    turned, doubts = 0.0, ["nothing fits", "other places look like this one"]
    while run.decision.state is not State.FAILED and run.time < 120.0:
        doubts.reverse()
        turned += abs(run.step(where=lost(doubts[0])).twist.angular) * 0.1
    assert turned > 1.0 and "gave up after 6 s" in run.decision.reason


def test_it_gives_up_when_it_never_knows_where_it_is():
    run = Run().driving()
    decision = run.until(State.FAILED, seconds=10.0, where=lost())
    assert "gave up after 6 s: nothing fits" in decision.reason


def test_it_gives_up_when_the_only_way_stays_blocked():
    cells = room().cells.copy()
    cells[:, 60] = OCCUPIED
    cells[30:48, 60] = 0
    run = Run(GridMap(cells, 0.05, (0.0, 0.0)), posts=[(3.0, 1.5 + 0.1 * k) for k in range(1, 9)]).driving()
    decision = run.until(State.REACHED, State.FAILED, seconds=60.0)
    assert decision.state is State.FAILED and "gave up: no way on for 9 s" in decision.reason
    assert run.pose.x < 2.85


def test_it_goes_aside_for_who_waits_until_it_is_gone_and_gives_up_at_last_for_what_stays():
    numbers = NavigationNumbers(navigator=NavigatorNumbers(aside_after=5.0, most_asides=2))
    for leaves in (True, False):
        run = Run(corridor(), start=Pose(1.5, 2.0, 0.0), posts=[(3.0, 1.8), (3.0, 2.2)])
        run.navigator = Navigator(run.walls, run.chassis, numbers)
        run.step()
        assert run.navigator.go_to(4.5, 2.0, None, run.time) == ""
        nearest = 0.0
        while run.step().state not in (State.REACHED, State.FAILED) and run.time < 300.0:
            nearest = max(nearest, run.pose.x)
            if leaves and run.pose.x < nearest - 0.4:
                run.posts = ()
        assert run.decision.state is (State.REACHED if leaves else State.FAILED)
    assert "no way on" in run.decision.reason and run.time < 160.0


def test_a_cost_that_changes_with_the_map_is_no_progress(monkeypatch):
    """A robot that stood before a changing map of its own thought for 18 minutes that it got on."""
    run = Run(posts=[(1.0 + 0.4 * math.cos(a), 1.0 + 0.4 * math.sin(a)) for a in np.arange(0.0, 6.2, 0.2)])
    run.step()
    assert run.navigator.go_to(4.5, 2.5, None, run.time) == ""
    cost = RoutePlan.cost
    monkeypatch.setattr(RoutePlan, "cost", lambda self, x, y: cost(self, x, y) + 5.0 * math.sin(run.time))
    assert run.until(State.FAILED, seconds=60.0).state is State.FAILED
    assert "no way on" in run.decision.reason


def test_after_a_stall_it_goes_round_what_sonar_does_not_hear():
    run = Run().driving()
    where = run.pose
    for _ in range(5):
        run.step(ready=Readiness(stalled=True))
    assert run.until(State.REACHED, State.FAILED).state is State.REACHED
    assert math.hypot(run.pose.x - where.x, run.pose.y - where.y) > 1.0


def test_it_gives_up_when_its_wheels_stall_again_and_again():
    run = Run().driving()
    for stall in range(3):
        assert run.decision.state is not State.FAILED, "%d stalls are not too many" % stall
        for _ in range(3):
            run.step(ready=Readiness(stalled=True))
        for _ in range(15):
            run.step()
    assert run.decision.state is State.FAILED and "the wheels stalled 3 times" in run.decision.reason
    assert run.decision.twist == STOP


def test_the_plan_leads_from_the_robot_to_the_goal():
    run = Run().driving((4.5, 2.5, None))
    plan = run.navigator.plan
    assert math.hypot(plan[0][0] - run.pose.x, plan[0][1] - run.pose.y) < 0.1 and plan[-1] == (4.5, 2.5)
    assert run.navigator.way((1.0, 1.0), (4.0, 1.0))[0][-1] == (4.0, 1.0)
    assert run.navigator.way((1.0, 1.0), (40.0, 1.0))[1] != ""
    assert run.navigator.shortest((1.0, 1.0), (4.0, 1.0)) == pytest.approx(3.0, abs=0.15)


def test_the_accelerations_that_it_needs():
    linear, braking, angular = Run().navigator.acceleration_wanted
    assert braking >= 0.8 and 0.7 <= linear <= braking and angular >= 4.0


def test_the_same_run_twice_is_the_same():
    def path():
        run = Run(posts=[(2.75, 1.75)]).driving()
        return [run.step() and run.pose for _ in range(80)]
    assert path() == path()


def test_forgotten_obstacles_are_gone():
    run = Run(posts=[(2.0, 1.3)]).driving()
    run.posts = ()
    run.navigator.forget_obstacles()
    assert np.isfinite(run.step().twist).all()


@pytest.mark.parametrize("makes_map", [True, False])
def test_only_while_it_makes_its_map_it_keeps_off_walls_that_are_suspected(makes_map, monkeypatch):
    """Here one is suspected right ahead. On a map that is given, all walls are known."""
    ahead = np.full(9, 0.4), np.linspace(-0.2, 0.2, 9)
    monkeypatch.setattr(SuspectedWalls, "places", lambda *_: ahead)
    run = Run()
    run.navigator = Navigator(run.walls, run.chassis, SOON, makes_map=makes_map)
    run.step()
    assert run.navigator.go_to(4.5, 1.0, None, run.time) == ""
    twists = [run.step().twist for _ in range(8)]
    assert any(twist.linear > 0.3 and twist.angular == 0.0 for twist in twists) is not makes_map


@pytest.mark.parametrize("makes_map", [True, False])
def test_while_it_makes_its_map_nothing_that_it_hears_is_somebody_who_may_walk(makes_map):
    """Everything is new to it."""
    run = Run(posts=[(2.0, 1.3)])
    run.navigator = Navigator(run.walls, run.chassis, SOON, makes_map=makes_map)
    for _ in range(3):
        run.step()
    around = run.navigator._around(run.pose, run.time)
    assert all((distances.min() == math.inf) == makes_map for distances in (around.apart, around.beside, around.lost))


@pytest.mark.parametrize("makes_map", [True, False])
def test_the_steering_is_told_whether_the_robot_makes_its_map(makes_map, monkeypatch):
    """test_steering tests what that does."""
    told = []
    monkeypatch.setattr(navigator, "Steering", lambda *rest: told.append(rest[-1]))
    Navigator(room(), chassis_of(), makes_map=makes_map)
    assert told == [makes_map]


@pytest.mark.parametrize("makes_map", [True, False])
def test_a_robot_that_makes_its_map_is_not_slow_beside_what_is_on_no_map(makes_map, monkeypatch):
    told = []
    monkeypatch.setattr(navigator, "DrivableFloor", lambda *rest: told.append(rest[-1]) or DrivableFloor(*rest))
    driver = Navigator(room(), chassis_of(), makes_map=makes_map)
    driver.use_map(room())
    assert told == 2 * [NOT_SLOW if makes_map else slowness(SteeringNumbers(), 0.4)]


@pytest.mark.parametrize("makes_map", [True, False])
def test_on_a_map_that_is_given_a_wall_may_be_anywhere_in_its_cell(makes_map):
    """A p3at touched the tip of a wall whose cell lay 4 cm from it (1647)."""
    driver = Navigator(room(), chassis_of(), makes_map=makes_map)
    x, _ = driver._walls_near(Pose(1.0, 2.0, math.pi))
    assert x == pytest.approx(np.full(len(x), 0.975 if makes_map else 0.95))


def test_after_a_jump_of_time_it_does_not_know_where_it_drove(monkeypatch):
    """Odometry may begin anew then, and its old places are elsewhere."""
    forgotten = []
    monkeypatch.setattr(SuspectedWalls, "forget", lambda _: forgotten.append(True))
    run = Run()
    run.step()
    assert forgotten == []
    run.time -= 50.0
    run.step()
    assert forgotten == [True]


def two_doors():
    """Return a room with a wall across at x 3.0 m. It has a door in the way, at y 2.0 m, and one farther away."""
    walls = room()
    cells = walls.cells.copy()
    cells[:, 60] = OCCUPIED
    cells[28:52, 60] = cells[58:76, 60] = FREE
    return GridMap(cells, walls.resolution, walls.origin)


class BlockedDoor(Run):
    """A robot before a door in which posts stand. There is another door."""

    def __init__(self, seconds=5, **how):
        super().__init__(two_doors(), posts=[(3.0, 1.5 + 0.1 * number) for number in range(11)])
        self.navigator = Navigator(self.walls, self.chassis, **how)
        self.look(Pose(1.7, 2.0, 0.0), seconds)

    def look(self, pose, seconds):
        for number in range(10 * seconds):
            self.pose, self.velocity = pose._replace(heading=pose.heading + 0.4 * math.sin(number / 5.0)), STOP
            self.step()

    def door(self):
        """Return the y (m) of the door on its way."""
        assert self.navigator.go_to(4.5, 2.0, None, self.time) == ""
        self.look(self.pose, 3)
        return min(self.navigator.plan, key=lambda point: abs(point[0] - 3.0))[1]

    def go_away(self, x=1.0, y=3.4):
        """Take the posts away, and stand elsewhere for longer than echoes are kept. Here it hears nothing of it."""
        self.navigator.cancel()
        self.posts = ()
        self.look(Pose(x, y, math.pi), 30)


@pytest.mark.parametrize("remembered, door", [(120.0, 3.35), (10.0, 2.0)])
def test_what_stood_in_a_way_is_remembered_longer_than_its_echoes(remembered, door):
    """A robot with two ways, and a thing in each, forgot each on its way to the other, and went to and fro (1647)."""
    run = BlockedDoor(numbers=NavigationNumbers(obstacles=ObstacleNumbers(kept_standing=remembered)))
    assert run.door() == pytest.approx(3.35, abs=0.3)
    run.go_away()
    assert run.door() == pytest.approx(door, abs=0.3)


@pytest.mark.parametrize("then", [
    lambda run: run.step(where=Spot(run.pose, sure=False)),     # it may have been elsewhere
    lambda run: run.navigator.forget_obstacles(),
    lambda run: run.navigator.use_map(run.walls),
    lambda run: (run.go_away(1.0, 2.0), run.door())])       # from there it hears that the door is free
def test_what_stood_in_a_way_is_forgotten(then):
    run = BlockedDoor()
    assert run.door() == pytest.approx(3.35, abs=0.3)
    then(run)
    run.go_away()
    assert run.door() == pytest.approx(2.0, abs=0.3)


@pytest.mark.parametrize("seconds, makes_map, remembered", [(5, False, True), (0, False, False), (5, True, False)])
def test_only_what_stood_still_is_remembered_so_and_only_on_a_map_that_is_given(seconds, makes_map, remembered):
    run = BlockedDoor(seconds, makes_map=makes_map)
    assert run.navigator.go_to(4.5, 2.0, None, run.time) == ""
    run.look(run.pose, 1)
    assert (len(run.navigator._obstacles._standing.places) > 0) is remembered


def test_where_it_did_not_get_through_it_tries_another_way():
    """A gap was wide enough on the map, and the robot tried it until it gave up, though another way led round."""
    run = Run(two_doors(), start=Pose(2.0, 2.0, 0.0))
    run.navigator = Navigator(run.walls, run.chassis, NavigationNumbers())

    def door():
        return min(run.navigator.plan, key=lambda point: abs(point[0] - 3.0))[1]

    run.driving((4.5, 2.0, None))
    assert door() == pytest.approx(2.0, abs=0.2)
    there = run.pose
    for _ in range(400):       # something holds it: no sonar hears what
        run.step()
        run.pose, run.velocity = there, STOP
    assert door() > 2.8
