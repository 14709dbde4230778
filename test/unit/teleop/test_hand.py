"""What the hand on keys wants, for how long, and how fast it may drive."""

import pytest

from pioneer_control.teleop.hand import FIRST_PRESS, REPEATED, SLOW, STAND, KeyHand, Limit, Wish

AHEAD, LEFT = Wish(1, 0), Wish(0, 1)


def test_one_press_lives_for_a_short_time_and_never_more_than_allowed():
    hand = KeyHand()
    assert hand.wish(0.0) == STAND
    hand.press(AHEAD, 1.0)
    assert hand.wish(1.0 + FIRST_PRESS - 0.01) == AHEAD
    assert hand.wish(1.0 + FIRST_PRESS) == STAND
    assert FIRST_PRESS <= 0.6


def test_a_held_key_drives_without_a_gap_and_stands_soon_after_it_is_let_go():
    """A terminal repeats after half a second, then every 33 ms."""
    hand = KeyHand()
    hand.press(AHEAD, 0.0)
    presses = [0.5 + 0.033 * number for number in range(30)]
    for time in presses:
        assert hand.wish(time) == AHEAD
        hand.press(AHEAD, time)
    assert hand.wish(presses[-1] + REPEATED) == STAND
    assert REPEATED < FIRST_PRESS


def test_another_key_replaces_it_at_once():
    hand = KeyHand()
    hand.press(AHEAD, 0.0)
    hand.press(LEFT, 0.1)
    assert hand.wish(0.1) == LEFT
    assert hand.wish(0.1 + FIRST_PRESS - 0.01) == LEFT      # a first press again
    hand.let_go()
    assert hand.wish(0.1) == STAND


def test_the_limit_is_slow_until_somebody_raises_it_and_never_beyond_the_robots_own():
    limit = Limit()
    assert limit.velocity(AHEAD) == (SLOW, 0.0)
    limit.robot = (0.45, 1.5)
    for _ in range(9):
        limit.change(1)
    assert limit.velocity(AHEAD) == (0.45, 0.0) and limit.velocity(LEFT) == (0.0, 1.5)
    for _ in range(9):
        limit.change(-1)
    assert limit.linear == 0.1 and limit.angular == pytest.approx(1.5 * 0.1 / 0.45)


def test_a_limit_beyond_what_the_robot_may_is_the_robots_own():
    limit = Limit(2.0)
    assert limit.velocity(Wish(-1, 1)) == (-0.5, 1.745)
