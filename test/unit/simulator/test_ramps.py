"""Ramps, compared with the closed forms of a trapezoid."""

import pytest

from pioneer_control.simulator.hardware.ramps import Channel, Limits, approach, ramp

DT = 0.02


def channel(limit=0.75, top=1.5, rise=0.3, fall=0.3, rate_top=2.0):
    return Channel(Limits(limit, top, rise, fall, rate_top), 0.0005)


def drive(wheel, seconds, held=False):
    return sum(wheel.step(DT, held) for _ in range(round(seconds / DT)))


def test_ramp_reaches_the_target_and_covers_the_triangle():
    speed, travelled = ramp(0.0, 0.6, rise=0.3, fall=0.5, dt=2.0)
    assert speed == 0.6
    assert travelled == pytest.approx(0.6 * 2.0 / 2.0)


def test_ramp_goes_on_at_the_target():
    assert ramp(0.0, 0.6, 0.3, 0.5, 5.0)[1] == pytest.approx(0.6 + 3.0 * 0.6)


def test_ramp_through_zero_falls_first_and_rises_then():
    speed, travelled = ramp(0.5, -0.3, rise=0.1, fall=0.25, dt=2.0 + 3.0)
    assert speed == pytest.approx(-0.3)
    assert travelled == pytest.approx(0.5 * 2.0 / 2.0 - 0.3 * 3.0 / 2.0)


def test_ramp_to_a_lower_speed_falls():
    assert ramp(-1.0, -0.4, rise=9.0, fall=0.2, dt=3.0) == (pytest.approx(-0.4), pytest.approx(-2.1))


@pytest.mark.parametrize("speed, target", [(0.0, 0.5), (0.7, -0.7), (-0.2, 0.0), (0.4, 0.4)])
def test_one_long_step_equals_many_short_ones(speed, target):
    long_speed, long_way = ramp(speed, target, 0.31, 0.17, 3.0)
    way = 0.0
    for _ in range(300):
        speed, part = ramp(speed, target, 0.31, 0.17, 0.01)
        way += part
    assert (speed, way) == (pytest.approx(long_speed), pytest.approx(long_way))


def test_a_speed_is_clipped_to_the_limit_of_its_moment():
    wheel = channel()
    wheel.set_speed(5.0)
    wheel.limits.set_limit(0.2)
    drive(wheel, 5.0)
    assert wheel.speed == 0.75
    wheel.set_speed(-5.0)
    drive(wheel, 9.0)
    assert wheel.speed == -0.2


def test_limits_are_clipped_to_their_tops():
    limits = channel().limits
    limits.set_limit(9.0)
    limits.set_rate(9.0)
    limits.set_rate(-9.0)
    assert (limits.limit, limits.rise, limits.fall) == (1.5, 2.0, 2.0)
    limits.set_rate(0.0)
    assert limits.rise == 2.0


@pytest.mark.parametrize("distance", [2.0, -2.0, 0.1, -0.03, 0.001])
def test_a_distance_is_covered_exactly_and_never_overrun(distance):
    wheel = channel()
    wheel.set_distance(distance)
    covered, most = 0.0, 0.0
    for _ in range(1000):
        covered += wheel.step(DT, held=False)
        most = max(most, abs(covered))
    assert covered == pytest.approx(distance, abs=1e-12)
    assert most <= abs(distance) + 1e-12
    assert wheel.speed == 0.0 and not wheel.driven and wheel.remaining is None


def test_a_short_distance_is_a_triangle():
    wheel = channel()
    wheel.set_distance(0.3)
    fastest, steps = 0.0, 0
    while wheel.driven:
        wheel.step(DT, held=False)
        fastest = max(fastest, wheel.speed)
        steps += 1
    assert fastest == pytest.approx(0.3, rel=0.03)     # v = sqrt(a * d)
    assert steps * DT == pytest.approx(2.0, rel=0.1)   # t = 2 * sqrt(d / a)


def test_a_distance_behind_a_moving_drive_turns_it_round():
    wheel = channel()
    wheel.set_speed(0.5)
    drive(wheel, 3.0)
    wheel.set_distance(-0.2)
    assert drive(wheel, 12.0) == pytest.approx(-0.2, abs=1e-12)


def test_approach_slows_down_no_faster_than_it_can():
    speed, _ = approach(1.0, 0.01, limit=2.0, rise=0.3, fall=0.3, dt=DT)
    assert speed == pytest.approx(1.0 - 0.3 * DT)


def test_held_stops_and_resumes_what_was_set():
    wheel = channel()
    wheel.set_speed(0.3)
    drive(wheel, 2.0)
    stopping = drive(wheel, 3.0, held=True)
    assert wheel.speed == 0.0 and stopping == pytest.approx(0.3 ** 2 / 2 / 0.3)
    drive(wheel, 2.0)
    assert wheel.speed == 0.3


def test_held_on_the_way_to_a_distance_still_arrives():
    wheel = channel()
    wheel.set_distance(1.0)
    way = drive(wheel, 1.0) + drive(wheel, 4.0, held=True) + drive(wheel, 9.0)
    assert way == pytest.approx(1.0, abs=1e-12)


def test_an_emergency_stop_is_as_fast_as_the_top_allows_and_lasts():
    wheel = channel()
    wheel.set_speed(0.6)
    drive(wheel, 3.0)
    wheel.emergency_stop()
    assert drive(wheel, 1.0) == pytest.approx(0.6 ** 2 / 2 / 2.0)
    assert drive(wheel, 1.0) == 0.0
    wheel.set_speed(0.1)
    assert drive(wheel, 1.0) > 0.0


def test_what_did_not_happen_is_still_to_do():
    wheel = channel()
    wheel.set_distance(0.5)
    wheel.blocked(wheel.step(DT, held=False))
    assert wheel.speed == 0.0
    assert wheel.remaining == pytest.approx(0.5)
