"""A wander uses the stamps of its messages: for its begin, its end, and what it remembers."""

import math
import random

import pytest

from pioneer_control.floor_poses import Pose
from pioneer_control.message_values import GripStatus
from pioneer_control.tutorial.sights import Sight
from pioneer_control.tutorial.snapshot import Grip, Heard
from pioneer_control.tutorial.wander import STALE, Memory
from pioneer_control.tutorial.wandering import WanderEnd, Wandering
from robots_and_snapshots import shape

SECOND = 10 ** 9
FIRST = 1_700_000_000 * SECOND
HEARD = Heard(robot=shape())
OPEN_AIR = (5.0,) * 16
AT_CAN = HEARD._replace(grip=Grip(GripStatus.OPEN, 0, False, True, False, False))
HOLDING = HEARD._replace(grip=Grip(GripStatus.CLOSED, 0, True, True, True, True))


def sight(tenth, ranges=OPEN_AIR, pose_age=0.0):
    """Return what is seen some tenths of a second after FIRST."""
    return Sight(FIRST + round(tenth * SECOND / 10), pose_age, Pose(0.0, 0.0, 0.0), ranges)


def wandering(duration=2.0, **more):
    return Wandering(3, 0.1, duration, **more)


def decisions(wander, tenths, heard=HEARD):
    """Return the tenths of a second with a decision, and how the wander ended."""
    return [tenth for tenth in tenths if wander.decide(sight(tenth), heard)], wander.end


def test_it_lasts_from_the_first_message_on_by_the_stamps():
    assert decisions(wandering(), range(50, 70)) == (list(range(50, 70)), None)
    assert decisions(wandering(), range(50, 71)) == (list(range(50, 70)), WanderEnd.TIME_UP)
    assert decisions(wandering(), [50, 99]) == ([50], WanderEnd.TIME_UP)


def test_what_stands_between_the_paddles_ends_it_unless_it_is_held_or_nobody_minds():
    assert decisions(wandering(), [0, 1], AT_CAN) == ([], WanderEnd.AT_CAN)
    assert decisions(wandering(), [0, 1], HOLDING) == ([0, 1], None)
    assert decisions(wandering(stop_at_can=False), [0, 1], AT_CAN) == ([0, 1], None)


def test_it_first_leaves_what_was_put_down():
    """The thing stands between the paddles until the robot has backed away."""
    wander = wandering(9.0, leaving=True)
    moves = [wander.decide(sight(tenth), AT_CAN) for tenth in range(30)]
    assert {move.linear for move in moves} == {-0.7 * 0.1} and wander.end is None
    assert decisions(wander, range(30, 40)) == (list(range(30, 40)), None)
    assert wander.decide(sight(41), AT_CAN) is None and wander.end is WanderEnd.AT_CAN


def test_a_re_run_decides_from_the_first_to_the_last_message_that_it_is_told():
    begin, end = sight(3).time, sight(6).time
    wander = wandering(begin_at=begin + 4e-5, end_at=end - 4e-5)
    assert wander.waits and not wandering().waits
    assert decisions(wander, range(7), AT_CAN) == ([3, 4, 5, 6], None)
    assert not wander.waits
    assert decisions(wander, [7]) == ([], WanderEnd.AT_CAN)
    assert decisions(wandering(begin_at=begin, end_at=end), [2, 3, 23]) == ([3], WanderEnd.TIME_UP)


def test_a_jump_back_begins_afresh():
    wander, generator = wandering(), random.Random(1)
    ranges = [tuple(generator.uniform(0.3, 3.0) for _ in range(16)) for _ in range(15)]
    first = [wander.decide(sight(tenth, each), HEARD) for tenth, each in enumerate(ranges)]
    assert wander.memory != Memory(3, 0.1)
    again = [wander.decide(sight(tenth - 100, each), HEARD) for tenth, each in enumerate(ranges)]
    assert [each[:2] for each in again] == [each[:2] for each in first]
    assert wander.end is None       # a second and a half of its two


def test_a_step_back_within_a_second_is_no_jump():
    wander = wandering()
    assert decisions(wander, [10, 1, 2]) == ([10, 1, 2], None)
    assert wander.newest == sight(10).stamp
    assert decisions(wander, [30]) == ([], WanderEnd.TIME_UP)


def test_stamps_that_tremble_do_not_move_on():
    """ROS time is paused. The stamps of a fast robot do advance, but not with each message."""
    wander = wandering()
    for tenth in (0, 0.4, -0.3, 0.49):
        assert wander.decide(sight(tenth), HEARD) and wander.newest == FIRST
    assert wander.decide(sight(0.5), HEARD) and wander.newest == sight(0.5).stamp
    assert wander.decide(sight(0.75), HEARD) and wander.decide(sight(1), HEARD) and wander.newest == sight(1).stamp


def test_a_pose_that_is_too_old_is_not_driven_by_nor_remembered():
    wander = wandering()
    before = wander.memory
    command = wander.decide(sight(0, pose_age=STALE + 0.1), HEARD)
    assert command[:2] == (0.0, 0.0) and command.reason == "stopped: no news from the robot for 0.6 s"
    assert wander.memory == before
    assert wander.decide(sight(1, pose_age=STALE), HEARD).linear > 0


def test_what_is_decided_depends_on_the_seed():
    def turns(seed):
        return math.copysign(1, Wandering(seed, 0.1, 2.0).decide(sight(0, (1.0,) * 16), HEARD).angular)

    assert {turns(seed) for seed in range(8)} == {-1, 1}
    assert [turns(7) for _ in range(3)] == [turns(7)] * 3


def test_a_stall_is_decided_on():
    assert wandering().decide(sight(0)._replace(stalled=True), HEARD).reason.startswith("stopped: the wheels stall")


@pytest.mark.parametrize("speed", [0.05, 0.1])
def test_speed_and_seed_are_those_it_was_given_and_the_next_wander_goes_on_with_the_chance(speed):
    wander = Wandering(5, speed, 2.0)
    assert wander.decide(sight(0), HEARD).linear == speed
    assert wander.decide(sight(1, (0.9,) * 16), HEARD).linear == 0
    assert (wander.seed, wander.speed) == (5, speed) and wander.memory.seed != 5
