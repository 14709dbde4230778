"""A time that never goes back, of stamps that jump."""

import pytest

from pioneer_control.navigation.steady_time import SteadyTime


@pytest.fixture
def steady():
    steady = SteadyTime()
    assert steady.of(1000.0, 5.0) == 1000.0
    return steady


def test_stamps_that_go_on_stay_as_they_are(steady):
    assert [steady.of(stamp, now) for stamp, now in ((1000.1, 5.1), (1000.05, 5.1), (1008.1, 13.1))] == [
        1000.1, 1000.05, 1008.1]
    assert (steady.jump, steady.offset) == (0.0, 0.0)


@pytest.mark.parametrize("jump", [-999.9, -0.5, 3.0, 1e6])
def test_after_a_jump_time_goes_on_as_the_other_clock_says(steady, jump):
    assert steady.of(1000.1 + jump, 5.1) == pytest.approx(1000.1)
    assert steady.jump == pytest.approx(jump)
    assert steady.of(1000.2 + jump, 5.2) == pytest.approx(1000.2)
    assert steady.jump == 0.0
    assert 1000.2 - steady.offset == pytest.approx(1000.2 + jump), "the stamp of a steady time"


def test_stamps_of_two_epochs_that_come_in_turn_still_go_forward(steady):
    times = [steady.of(stamp, now) for stamp, now in (
        (1000.1, 5.1), (500.1, 5.1), (1000.2, 5.2), (500.2, 5.2), (1000.3, 5.3))]
    assert times == pytest.approx([1000.1, 1000.1, 1000.2, 1000.2, 1000.3])


def test_messages_that_were_held_up_and_come_together_do_not_jump(steady):
    assert [steady.of(1000.0 + 0.1 * count, 8.0) for count in (10, 11, 12)] == pytest.approx([1001.0, 1001.1, 1001.2])
    assert steady.jump == 0.0


def test_time_that_stood_goes_on(steady):
    assert steady.of(1000.0, 60.0) == 1000.0
    assert steady.of(1000.1, 60.1) == 1000.1
    assert (steady.jump, steady.offset) == (0.0, 0.0)
