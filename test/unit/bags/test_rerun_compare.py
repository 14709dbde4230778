"""Whether a program gives the same commands again. Pure, with made-up messages."""

import math

import numpy as np
import pytest

from pioneer_control.bags.replaying.rerun_compare import (LATE, first_difference, judge_decisions,
                                                          judge_others, judge_velocities, likeness)


class Part:
    """The part of a message that a comparison uses."""

    _type = "any/Message"

    def __init__(self, **fields):
        self.__slots__ = list(fields)
        self.__dict__.update(fields)


class Stamp:
    """A time. It is a value, not a message."""

    def __init__(self, seconds):
        self.seconds = seconds

    def __eq__(self, other):
        return self.seconds == other.seconds

    def __repr__(self):
        return str(self.seconds)

    def to_sec(self):
        return self.seconds


def decision(stamp, angular=0.0, sent=1):
    return Part(header=Part(seq=sent, stamp=Stamp(stamp), frame_id=""), wander=1, seed=7, speed=0.1, linear=0.1,
                angular=angular, reason="driving")


class TestDecisions:
    live = [decision(10.0 + 0.1 * number) for number in range(20)]

    def test_the_same(self):
        again = [decision(10.0 + 0.1 * number, sent=number) for number in range(20)]
        verdict = judge_decisions(self.live, again)
        assert verdict.same and verdict.sentences == ["20 decisions live, 20 in the re-run: every one is the same."]

    @pytest.mark.parametrize("name, value", [
        ("wander", 2), ("seed", 8), ("speed", 0.2), ("linear", 0.1000000001), ("angular", 0.3),
        ("reason", "turning left")])
    def test_any_field_that_differs_is_told(self, name, value):
        again = [decision(10.0 + 0.1 * number) for number in range(20)]
        setattr(again[12], name, value)
        verdict = judge_decisions(self.live, again)
        assert not verdict.same
        assert "differ from number 13 on, 1.2 s after the first" in verdict.sentences[0]
        assert "%s was" % name in verdict.sentences[0]

    def test_a_stamp_that_differs(self):
        found = first_difference(self.live, [*self.live[:3], decision(99.0), *self.live[4:]])
        assert found.place == 3 and "header.stamp was 10.3, and is 99.0" in found.what

    @pytest.mark.parametrize("again", [live[:19], [], [*live, decision(12.0)]])
    def test_fewer_or_more(self, again):
        verdict = judge_decisions(self.live, again)
        assert not verdict.same and "the first %s are the same" % min(20, len(again)) in verdict.sentences[0]


def driven(wave=0.0, late=0.0, count=100, faster=0.0):
    """Return ten velocities a second: 2 s straight on, 2 s turning, and so on."""
    return np.array([(5.0 + 0.1 * n + late, 0.1 + faster, 0.5 * (n // 20 % 2) + wave * math.sin(n))
                     for n in range(count)])


STRAIGHT = 1.0, 1.0, 0.0
"""Of a velocity what is left without a turn."""
NOTHING = np.empty((0, 3))


class TestVelocities:
    def test_the_same(self):
        found = likeness(driven(), driven())
        assert (found.share, found.first, found.largest) == (1.0, None, (0.0, 0.0))

    @pytest.mark.parametrize("late", [0.0, 0.1, LATE - 0.1, -0.2])
    def test_a_little_late_or_early_is_alike(self, late):
        assert likeness(driven(), driven(late=late)).share == 1.0

    def test_a_little_faster_is_alike(self):
        assert likeness(driven(), driven(faster=0.015)).share == 1.0

    def test_much_faster_is_not(self):
        found = likeness(driven(), driven(faster=0.1))
        assert found.share < 0.1 and found.first < 0.1 and found.largest[0] == pytest.approx(0.1)

    def test_a_turn_that_was_not_made(self):
        found = likeness(driven(), driven() * STRAIGHT)
        assert found.first == pytest.approx(2.0, abs=LATE + 0.1)
        assert found.largest[1] == pytest.approx(0.5) and 0.5 < found.share < 0.75

    def test_a_turn_too_many(self):
        assert likeness(driven() * STRAIGHT, driven()).largest[1] == pytest.approx(0.5)

    def test_one_that_comes_far_too_late(self):
        assert likeness(driven(), driven(late=1.5)).share < 0.95

    def test_silence_is_standing(self):
        found = likeness(driven(count=100), driven(count=50))
        assert found.first == pytest.approx(5.0 + 0.6 - LATE, abs=0.5)

    def test_nothing_at_all(self):
        assert likeness(driven(), NOTHING).share < 0.2
        assert likeness(NOTHING, NOTHING).share == 1.0

    def test_what_is_told(self):
        same = judge_velocities("cmd_vel", driven(), driven(), 0.95)
        other = judge_velocities("cmd_vel", driven(), driven(faster=0.1), 0.95)
        assert same.same and "alike for 100.0 %" in same.sentences[0] and "different" not in same.sentences[0]
        assert not other.same and "by at most 0.10 m/s" in other.sentences[0]

    def test_either_wheel_is_compared_with_the_tolerance_that_is_told(self):
        for faster in ((0.0, 0.03, 0.0), (0.0, 0.0, 0.03)):
            verdict = judge_velocities("cmd_wheels", driven(), driven() + faster, 0.95)
            assert not verdict.same and "within 0.02 m/s left and 0.02 m/s right" in verdict.sentences[0]

    def test_wheels_are_told_in_their_units(self):
        assert "m/s left" in judge_velocities("cmd_wheels", driven(), driven(faster=0.1), 0.95).sentences[0]


class TestOthers:
    def test_repeating_does_not_count(self):
        once, again = [Part(state=1), Part(state=2)], [Part(state=1), Part(state=1), Part(state=2)]
        assert judge_others("gripper_control", once, again).same

    @pytest.mark.parametrize("again", [[2, 1], [1], [1, 2, 3], [1, 3], []])
    def test_another_order(self, again):
        verdict = judge_others("gripper_control", [Part(state=1), Part(state=2)],
                               [Part(state=state) for state in again])
        assert not verdict.same and "gripper_control: different from" in verdict.sentences[0]
