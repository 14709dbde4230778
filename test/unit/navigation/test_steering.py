"""Steering: it leads on, brakes in time, gives way to what may walk, and uses no move that nothing looks along."""

import math

import numpy as np
import pytest
from floor_for_tests import chassis_of, room

from pioneer_control.floor_poses import Pose
from pioneer_control.navigation.steering import Around, Steering, slowness
from pioneer_control.navigation.planning import DrivableFloor
from pioneer_control.navigation.tuned import PlanningNumbers, SteeringNumbers
from pioneer_control.navigation.values import STOP, Twist

ALL = range(16)
ANSWER = 0.08    # s
FLOOR = DrivableFloor(room(), chassis_of().half_width, PlanningNumbers())
STEERING = Steering(chassis_of(), SteeringNumbers())
HERE = Pose(1.5, 2.0, 0.0)


def around(standing=(), walking=()):
    columns = [np.array([point[axis] for point in points], dtype=float)
               for points in (standing, walking) for axis in (0, 1)]
    return Around(*columns)


def wall(x, low=-0.5, high=0.5):
    return [(x, y) for y in np.arange(low, high, 0.05)]


def choose(goal, pose=HERE, velocity=STOP, what=None, live=ALL, steering=STEERING, blocked=0.0):
    return steering.choose(pose, velocity, what or around(), live, FLOOR.to(goal), blocked)


def test_it_is_as_slow_beside_what_has_stood_still_as_plans_are_told():
    near, far, _ = slowness(SteeringNumbers(), 0.4)
    speeds = [choose((4.5, 2.0), velocity=Twist(0.4, 0.0), what=around()._replace(beside=beside)).twist.linear
              for beside in (near - 0.01, (near + far) / 2.0, far - 0.01, far + 0.01)]
    assert 0.0 < speeds[0] <= 0.2 < speeds[1] < speeds[2] < speeds[3] == pytest.approx(0.4)


@pytest.mark.parametrize("max_linear, cost", [(0.4, 1.0), (0.2, 0.0), (0.1, 0.0)])
def test_a_slow_robot_loses_no_time_beside_what_is_on_no_map(max_linear, cost):
    assert slowness(SteeringNumbers(), max_linear).cost == pytest.approx(cost)


def test_it_drives_at_full_speed_to_what_lies_ahead():
    twist, reason, blocked = choose((4.5, 2.0), velocity=Twist(0.4, 0.0))
    assert twist.linear == pytest.approx(0.4) and abs(twist.angular) < 0.15 and not blocked and reason == "on the way"


@pytest.mark.parametrize("heading, sign", [(2.0, -1.0), (-2.0, 1.0)])
def test_it_turns_the_short_way_towards_the_goal(heading, sign):
    assert choose((4.5, 2.0), Pose(1.5, 2.0, heading)).twist.angular * sign > 0.3


def test_every_choice_leaves_room_to_brake():
    numbers = SteeringNumbers()
    for gap in np.arange(0.05, 1.0, 0.05):
        face = around(wall(0.21 + gap, -2.0, 2.0))
        speed = choose((4.5, 2.0), velocity=Twist(0.4, 0.0), what=face).twist.linear
        if speed > 0.0:
            ahead = gap - numbers.margin - 0.4 * numbers.delay
            assert speed * numbers.reaction + speed ** 2 / (2.0 * numbers.braking) <= ahead + 0.05


def test_it_goes_slower_towards_what_may_walk_than_towards_what_stands():
    face = wall(0.85, -2.0, 2.0)
    standing = choose((4.5, 2.0), what=around(face)).twist.linear
    walking = choose((4.5, 2.0), what=around(face, face)).twist.linear
    assert 0.0 <= walking < standing


@pytest.mark.parametrize("apart, moves", [(0.2, False), (0.3, True), (0.4, True), (1.0, True)])
def test_beside_what_may_walk_it_stands_before_that_can_be_there(apart, moves):
    numbers = SteeringNumbers()
    for goal in ((4.5, 2.0), (1.5, 4.0)):       # ahead, and to the side
        twist = choose(goal, velocity=Twist(0.4, 0.0), what=around()._replace(apart=apart)).twist
        stands_after = numbers.reaction + max(abs(twist.linear) / numbers.braking,
                                              (twist.linear == 0.0) * abs(twist.angular) / numbers.turn_acceleration)
        assert (twist == STOP or stands_after * numbers.walking < apart) and (twist != STOP) == moves


@pytest.mark.parametrize("beside, slowest, fastest", [
    (0.1, 0.1, 0.2), (0.4, 0.2, 0.25), (0.45, 0.3, 0.35), (0.6, 0.4, 0.4)])
def test_it_passes_slowly_by_what_is_on_no_map_though_it_stood_still(beside, slowest, fastest):
    """It has stood still, but may begin to walk: then the robot stands before it is there."""
    around_it = around()._replace(beside=beside)
    assert slowest <= choose((4.5, 2.0), velocity=Twist(0.2, 0.0), what=around_it).twist.linear <= fastest


@pytest.mark.parametrize("walking", [False, True])
def test_the_later_it_reacts_the_slower_it_comes_near(walking):
    face = wall(1.1, -2.0, 2.0)
    what = around(face, face if walking else ())
    speeds = [choose((4.5, 2.0), velocity=Twist(0.2, 0.0), what=what._replace(late=late)).twist.linear
              for late in (0.0, 1.5, 3.0)]
    assert speeds[0] > 0.3 and max(speeds[1:]) < 0.8 * speeds[0] and speeds[-1] < 0.1
    beside = around()._replace(apart=0.35, late=0.3)
    assert choose((4.5, 2.0), velocity=Twist(0.2, 0.0), what=beside).twist == STOP


def test_it_stands_when_every_way_is_blocked():
    ring = [(0.37 * math.cos(a), 0.37 * math.sin(a)) for a in np.arange(0.0, 6.3, 0.05)]
    assert choose((4.5, 2.0), what=around(ring)) == (STOP, "the way is blocked", True)


def test_slow_moves_that_lead_nowhere_give_way_to_faster_ones():
    """Nearly at the goal every fast move costs more, as beside the edge of a door where all that leads on is dear."""
    here, goal = Pose(1.55, 2.05, 0.0), (1.65, 2.05)
    assert choose(goal, here, blocked=7.9).twist == Twist(0.06, 0.0)
    faster = choose(goal, here, blocked=12.0).twist
    assert abs(faster.linear) > 0.1 or abs(faster.angular) > 0.4


@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("makes_map", [True, False])
def test_with_no_way_on_for_long_while_it_makes_its_map_it_turns_on_to_one_side(makes_map, side):
    """In a corner behind a post (4933) it turned to and fro by 10 degrees, to where its way should lead on. On a map
    that is given, it may: with 6397 it reached its goals so.
    """
    told, plan = Twist(0.0, 0.3 * side), FLOOR.to((4.5, 2.0))
    steering = Steering(chassis_of(), SteeringNumbers(), makes_map)

    def turn(blocked):
        return steering.choose(Pose(1.5, 2.0, side), STOP, around(), (), plan, blocked, told).twist.angular
    assert turn(0.0) * side < 0.0
    assert turn(7.9) * side < 0.0
    assert (turn(8.1) * side > 0.0) == makes_map


def test_pushed_against_a_wall_it_drives_away_from_it():
    back_to_the_wall = around(wall(-0.305))
    assert choose((4.5, 2.0), what=back_to_the_wall).twist.linear > 0.1
    nose_to_the_wall = around(wall(0.22))
    choice = choose((0.6, 2.0), Pose(1.5, 2.0, 0.3), what=nose_to_the_wall, blocked=3.0)
    assert choice.twist.linear < 0.0


def test_at_last_it_keeps_next_to_no_distance_and_is_slow():
    alley = around([(x, side * 0.235) for side in (-1, 1) for x in np.arange(-1.0, 1.0, 0.02)])
    fast, slow = choose((4.5, 2.0), what=alley), choose((4.5, 2.0), what=alley, blocked=30.0)
    assert 0.0 < slow.twist.linear <= 0.1
    assert fast.blocked


@pytest.mark.parametrize("makes_map", [True, False])
def test_while_it_makes_its_map_it_squeezes_through_but_turns_nowhere_without_the_usual_distance(makes_map):
    """Its own map is right to some centimetres. A corner of the body touched a wall in a turn 1 cm beside it."""
    steering = Steering(chassis_of(), SteeringNumbers(), makes_map)
    alley = around([(x, side * 0.235) for side in (-1, 1) for x in np.arange(-1.0, 1.0, 0.02)])
    assert 0.0 < choose((4.5, 2.0), what=alley, steering=steering, blocked=30.0).twist.linear <= 0.1
    reach = chassis_of().reach + 0.02
    ring = around([(reach * math.cos(angle), reach * math.sin(angle)) for angle in np.arange(0.0, 6.28, 0.05)])
    turn = choose((0.5, 2.0), what=ring, live=(), steering=steering, blocked=5.0).twist.angular
    assert (turn != 0.0) != makes_map
    assert choose((0.5, 2.0), what=ring, live=(), steering=steering, blocked=3.0).twist == STOP


def jammed(*more):
    """Echoes that scatter by some centimetres all round the outline of a p3at-sh: no move is left."""
    sides = [(x, side * 0.24) for side in (-1, 1) for x in np.arange(-0.32, 0.33, 0.04)]
    ends = [(side * 0.3, y) for side in (-1, 1) for y in (-0.24, -0.22, 0.22, 0.24)]
    return around(sides + ends + wall(0.34, -0.2, 0.2) + list(more))


@pytest.mark.parametrize("more, live, backs", [
    ((), ALL, True), ([(-0.36, 0.0)], ALL, False), ((), range(8), False)])
def test_with_nothing_else_left_it_goes_back_where_it_came_from(more, live, backs):
    """Unless something is there now, or no transducer looks there."""
    steering = Steering(chassis_of("p3at-sh"), SteeringNumbers())
    came = np.column_stack((np.arange(-0.5, 0.01, 0.03), np.zeros((17, 2))))

    def chosen(blocked, trail):
        return steering.choose(HERE, STOP, jammed(*more), live, FLOOR.to((4.5, 2.0)), blocked, STOP, trail).twist
    assert chosen(3.0, came) == STOP
    assert (-0.1 <= chosen(5.0, came).linear < 0.0) == backs
    assert chosen(5.0, came[-2:]) == STOP, "it was not there"


def test_without_live_transducers_it_only_turns():
    assert choose((4.5, 2.0), live=[]).twist.linear == 0.0
    assert choose((4.5, 2.0), live=range(8, 16)).twist.linear <= 0.0


def test_without_sonar_behind_it_never_drives_back():
    steering = Steering(chassis_of(rear=False), SteeringNumbers())
    nose_to_the_wall = around(wall(0.22))
    for blocked in (0.0, 3.0, 30.0):
        assert choose((0.6, 2.0), steering=steering, what=nose_to_the_wall, live=range(8),
                      blocked=blocked).twist.linear >= 0.0


def finish(goal, pose=HERE, what=None, turn_only=False, live=ALL):
    return STEERING.finish(pose, STOP, what or around(), live, goal, turn_only, ANSWER)


def test_it_slows_down_towards_the_goal_and_not_before_it_must():
    far, middle, near = (finish(Pose(1.5 + d, 2.0, 0.0)).twist.linear for d in (0.55, 0.2, 0.1))
    assert 0.0 < near < 0.25 < 0.3 < middle <= far <= 0.4


def test_a_goal_just_behind_is_reached_backward_and_one_aside_after_a_turn():
    assert finish(Pose(1.35, 2.0, 0.0)).twist.linear < 0.0
    twist = finish(Pose(1.5, 2.4, 0.0)).twist
    assert twist.linear == 0.0 and twist.angular > 0.3


@pytest.mark.parametrize("heading", [1.0, -1.0, 0.1])
def test_at_the_goal_it_turns_to_its_heading(heading):
    twist = finish(Pose(1.5, 2.0, heading), turn_only=True).twist
    assert twist.linear == 0.0 and twist.angular * heading > 0.0


@pytest.mark.parametrize("turn", [0.5, -1.5, 3.0])
def test_the_turn_to_a_heading_takes_not_much_longer_than_it_must_and_ends_in_it(turn):
    """By a robot that does what it is told 0.1 s late."""
    pose, velocity, told, time = Pose(1.5, 2.0, 0.0), STOP, STOP, 0.0
    faster = 0.1 * SteeringNumbers().turn_acceleration
    while True:
        off = turn - STEERING.stands_at(pose, velocity, told, ANSWER).heading
        if abs(off) < 0.03 and abs(velocity.angular) < 0.05:
            break
        told = STOP if abs(off) < 0.03 else STEERING.finish(
            pose, velocity, around(), ALL, Pose(1.5, 2.0, turn), True, ANSWER).twist
        rate = velocity.angular + min(max(told.angular - velocity.angular, -faster), faster)
        pose = pose._replace(heading=pose.heading + 0.1 * velocity.angular)
        velocity, time = Twist(0.0, rate), time + 0.1
    assert abs(pose.heading - turn) < 0.05 and time < abs(turn) / 1.6 + 0.16 / faster + 0.6


def test_a_robot_that_still_rolls_does_not_turn_where_it_would_touch_as_it_stands():
    steering = Steering(chassis_of("p3at-sh"), SteeringNumbers())
    beside, goal = around([(-0.12, 0.31)]), Pose(1.6, 2.0, -1.5)    # beside the tail, where it comes to stand
    rolling = steering.finish(HERE, Twist(0.3, 0.0), beside, ALL, goal, True, ANSWER)
    assert rolling.twist == STOP and not rolling.blocked
    assert steering.finish(HERE, Twist(0.3, 0.0), around(), ALL, goal, True, ANSWER).twist.angular < -0.5


def test_it_tells_where_it_comes_to_stand():
    assert STEERING.stands_at(HERE, STOP, STOP, 0.08) == HERE
    x, _, heading = STEERING.stands_at(HERE, Twist(0.4, 1.2), Twist(0.4, 1.2), 0.08)
    assert 0.1 < x - HERE.x < 0.2 and 0.24 < heading < 0.5
    assert STEERING.stands_at(HERE, Twist(0.4, 0.0), STOP, 0.08).x < x, "it brakes already"
    assert STEERING.stands_at(HERE, Twist(0.4, 1.2), Twist(0.4, 1.2), 0.02).x == pytest.approx(x - 0.06 * 0.4, abs=2e-3)


@pytest.mark.parametrize("velocity, told, stands", [
    (Twist(0.02, 0.04), Twist(0.0, 0.12), True), (Twist(0.05, 0.0), Twist(0.05, 0.0), False),
    (Twist(0.0, 0.2), Twist(0.0, 0.12), False), (Twist(0.05, 0.2), STOP, True), (Twist(-0.1, 0.0), STOP, False),
    (Twist(0.0, -0.3), STOP, False)])
def test_a_robot_that_was_told_to_stop_stands_as_soon_as_its_brakes_have_ended(velocity, told, stands):
    assert STEERING.stands(velocity, told) == stands


def test_at_the_goal_it_does_not_turn_into_what_is_near():
    beside = around([(-0.1, -0.25), (-0.2, -0.25)])
    choice = finish(Pose(1.5, 2.0, 1.5), what=beside, turn_only=True)
    assert choice.twist.angular <= 0.0


def test_it_does_not_drive_to_a_goal_through_what_stands_before_it():
    assert finish(Pose(2.0, 2.0, 0.0), what=around(wall(0.26))).blocked


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_it_may_turn_on_the_spot_only_where_it_touches_nothing(side):
    """A corner of the robot sweeps over what is beside it, if it turns to this side."""
    steering = Steering(chassis_of("p3at-sh"), SteeringNumbers())
    beside = around([(0.26, side * 0.31)])
    assert not steering.may_turn(side * 0.4, STOP, beside) and steering.may_turn(-side * 0.4, STOP, beside)
    assert steering.may_turn(side * 0.4, STOP, around())


@pytest.mark.parametrize("max_linear, speed", [(0.4, 0.2), (0.15, 0.15)])
def test_it_goes_by_what_has_stood_still_as_fast_as_it_may(max_linear, speed):
    """One candidate is just that speed. Without it, the robot went at 0.14 m/s."""
    steering = Steering(chassis_of()._replace(max_linear=max_linear), SteeringNumbers())
    beside = around()._replace(beside=0.1)
    assert choose((4.5, 2.0), velocity=Twist(speed, 0.0), what=beside, steering=steering).twist.linear == speed


@pytest.mark.parametrize("rate", [1.0, 1.6, 2.0])
def test_the_turn_to_a_heading_is_told_as_it_brakes_and_not_by_leaps(rate):
    """Between two candidates it told the faster one: 1.2 rad/s where 0.85 brakes in time."""
    steering = Steering(chassis_of()._replace(max_angular=rate), SteeringNumbers())
    rates = [steering.finish(HERE, STOP, around(), ALL, HERE._replace(heading=left), True, ANSWER).twist.angular
             for left in np.arange(0.02, 0.8, 0.01)]
    assert rates == sorted(rates) and rates[-1] == rate
    assert np.diff(rates).max() < 0.1 and np.unique(rates).size > 10


@pytest.mark.parametrize("goal, turn_only", [(HERE._replace(heading=0.3), True), (Pose(1.76, 2.15, 0.0), False)])
def test_the_later_its_answer_has_an_effect_the_earlier_it_brakes_a_turn(goal, turn_only):
    slower, faster = (STEERING.finish(HERE, Twist(0.0, 1.0), around(), ALL, goal, turn_only, answer).twist.angular
                      for answer in (0.15, 0.02))
    assert 0.0 < slower < faster - 0.1


def test_it_turns_no_faster_than_it_may_as_it_finishes():
    steering = Steering(chassis_of()._replace(max_angular=0.3), SteeringNumbers())
    aside = steering.finish(HERE, Twist(0.2, 0.0), around(), ALL, Pose(1.65, 2.018, 0.0), False, ANSWER).twist
    assert 0.25 < aside.angular <= 0.3 and aside.linear > 0.0


def test_it_is_slower_before_somebody_ahead_and_aside_than_before_somebody_abeam():
    """In run 1507 the robot touched somebody 0.43 m away: that would have been enough for a robot that stands."""
    told = []
    for x, y, late in ((0.0, 0.7, 0.0), (0.7, 0.52, 0.0), (0.0, 0.7, 0.3)):     # as far from the outline
        distances = STEERING.apart(np.array([x]), np.array([y]), np.array([True]))
        assert distances[-1] == pytest.approx(0.49, abs=0.005)
        for somebody in ({"apart": distances}, {"beside": distances}):
            what = around()._replace(late=late, **somebody)
            told.append(choose((4.5, 2.0), velocity=Twist(0.4, 0.0), what=what).twist.linear)
    assert told[:2] == [0.4, 0.4]
    assert 0.0 < told[2] < 0.3 and 0.0 < told[4] < 0.1, "who has just come"
    assert 0.2 <= told[3] < 0.3 and told[5] == 0.2, "who has stood still"


@pytest.mark.parametrize("which", ["apart", "beside"])
def test_it_counts_the_way_that_it_drives_itself_while_its_answer_is_late(which):
    """At 0.4 m/s somebody comes 0.625 m near until it stands, and it drives 0.12 m farther than in time."""
    speeds = [choose((4.5, 2.0), velocity=Twist(0.4, 0.0), what=around()._replace(
        late=0.3, **{which: np.array([far])})).twist.linear for far in (0.68, 0.76)]
    assert 0.2 < speeds[0] < speeds[1] == 0.4


def test_somebody_ahead_does_not_keep_it_from_going_back_or_turning():
    distances = STEERING.apart(np.array([0.9, 9.0]), np.zeros(2), np.array([True, False]))
    forward = STEERING._linear > 0.0
    assert (distances[~forward] == distances[-1]).all() and (distances[forward] < distances[-1]).all()
    assert STEERING.apart(np.array([0.9]), np.zeros(1), np.array([False])).min() == math.inf


def test_what_it_keeps_from_is_the_floor_of_the_curve():
    """Straight ahead it passes somebody to its left at a distance that is too small for a turn to the left."""
    distances = STEERING.apart(np.array([0.15]), np.array([0.7]), np.array([True]))
    fast = STEERING._linear > 0.3
    left, straight = (distances[fast & which].min() for which in (STEERING._angular > 1.0, STEERING._angular == 0.0))
    assert left < straight - 0.1


def test_while_it_makes_its_map_it_is_slow_where_it_has_little_room_on_a_side():
    """Run 1131: a leg of a table was heard 4 cm away, between others that were nearly as near."""
    steering = Steering(chassis_of(), SteeringNumbers(), makes_map=True)
    half = chassis_of().half_width

    def speed(room, steering=steering):
        beside = around([(x, side * (half + room)) for x in np.arange(0.0, 2.0, 0.05) for side in (1.0, -1.0)])
        return choose((4.5, 2.0), velocity=Twist(0.2, 0.0), what=beside, steering=steering).twist.linear

    assert 0.1 < speed(0.08) <= SteeringNumbers().tight < 0.3 < speed(0.15)
    assert speed(0.08, STEERING) > 0.3, "on a map that is given"
