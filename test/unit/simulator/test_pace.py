"""How simulated time follows real time."""

import pytest

from pioneer_control.errors import ParameterError
from pioneer_control.simulator.line.pace import LONGEST_LAG, Pace


def paced(speed=1.0, now_us=0, looked=100.0):
    """Return a pace that was looked at once."""
    pace = Pace(speed, now_us)
    assert pace.due_us(looked) == now_us
    return pace


@pytest.mark.parametrize("speed", [0.01, 0.5, 1.0, 2.0])
def test_time_passes_at_its_speed(speed):
    pace = paced(speed, now_us=7000000)
    assert [pace.due_us(100.0 + 0.1 * step) for step in (1, 2, 3)] == pytest.approx(
        [7000000 + speed * 100000 * step for step in (1, 2, 3)], abs=1)


def test_small_steps_add_up():
    pace = paced(0.01)
    for step in range(1, 10001):
        last = pace.due_us(100.0 + step * 1e-5)
    assert last == pytest.approx(1000, abs=1)


def test_a_long_delay_of_the_process_is_left_out():
    assert paced().due_us(200.0) == round(LONGEST_LAG * 1e6)
    assert paced(speed=50.0).due_us(100.1) == round(LONGEST_LAG * 1e6)


def test_while_it_is_paused_time_stands_and_none_of_it_is_made_up_for():
    pace = paced()
    pace.paused = True
    assert pace.paused and [pace.due_us(now) for now in (100.1, 101.0, 200.0)] == [0, 0, 0]
    pace.paused = False
    assert [pace.due_us(now) for now in (200.2, 200.3)] == [0, pytest.approx(100000, abs=1)]
    pace.paused = False     # no change
    assert pace.due_us(200.4) == pytest.approx(200000, abs=1)


def test_another_speed_counts_from_the_last_look():
    pace = paced()
    pace.due_us(100.1)
    pace.speed = 2.0
    assert pace.due_us(100.2) == pytest.approx(300000, abs=1)


def test_the_wait_for_a_simulated_time():
    pace = paced(speed=0.5, now_us=1000000)
    assert pace.rest(1020000) == pytest.approx(0.04) and pace.rest(900000) == 0.0
    pace.paused = True
    assert pace.rest(1020000) is None


@pytest.mark.parametrize("speed", [0.0, -1.0, 0.0099, 100.1, float("nan"), float("inf")])
def test_a_senseless_speed_changes_nothing(speed):
    with pytest.raises(ParameterError, match="speed .* is not legal: give a number from 0.01 to 100"):
        Pace(speed, 0)
    pace = Pace(3.0, 0)
    with pytest.raises(ParameterError):
        pace.speed = speed
    assert pace.speed == 3.0
