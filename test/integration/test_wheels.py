"""Wheel velocities, from the command to the wheels of the simulated robot."""

import math

import pytest

from pioneer_control.client import CommandTimedOut

from simulated_time import Rig


def wheels(rig):
    """Return the speeds of the left and right wheels (m/s)."""
    return rig.firmware.hardware.drives.wheel_speeds


@pytest.mark.parametrize("subtype", ["p3dx-sh", "p3at-sh", "amigo-sh", "pion1m"])
@pytest.mark.parametrize("left, right", [(0.2, 0.2), (0.1, 0.16), (-0.16, -0.1), (0.1, -0.1), (0.0, 0.12)])
def test_the_wheels_end_at_their_speeds(subtype, left, right):
    rig = Rig(subtype)
    rig.run(4.0, rig.wheels(left, right))
    assert wheels(rig) == pytest.approx((left, right), abs=0.001)
    assert rig.state.linear == pytest.approx((left + right) / 2, abs=0.005)
    assert rig.state.angular == pytest.approx((right - left) / 2 * 1000 * rig.firmware.model.diff_rad_per_mm, abs=0.02)


def test_a_speed_between_two_steps_is_right_on_average():
    rig = Rig()
    rig.run(4.0, rig.wheels(0.05, 0.05))
    start, before = rig.firmware.true_pose[0], rig.now
    rig.run(30.0, rig.wheels(0.05, 0.05))
    assert (rig.firmware.true_pose[0] - start) / (rig.now - before) == pytest.approx(0.05, abs=0.001)


def test_beyond_the_limits_the_curve_stays():
    rig = Rig(max_linear=0.4)
    rig.run(5.0, rig.wheels(3.0, 2.7))
    left, right = wheels(rig)
    assert right / left == pytest.approx(0.9, abs=0.06) and 0.37 < (left + right) / 2 <= 0.4 + 1e-9


def test_a_stop_overtakes():
    rig = Rig()
    rig.run(2.0, rig.wheels(0.3, 0.2))
    for _ in range(20):
        rig.drive.set_wheel_velocities(0.3, 0.2, rig.now)
    rig.drive.stop(rig.now)
    assert rig.until(lambda: wheels(rig) == (0.0, 0.0)) <= 0.25 / 0.3 + 0.1
    rig.run(2.0)
    assert wheels(rig) == (0.0, 0.0) and rig.drive.at_rest


def test_the_dead_man_stops_them():
    rig = Rig()
    rig.run(2.0, rig.wheels(0.3, 0.2))
    assert rig.until(lambda: wheels(rig) == (0.0, 0.0)) <= 0.6 + 0.25 / 0.3 + 0.15
    assert len(rig.of(CommandTimedOut)) == 1


def test_a_silent_client_is_stopped_by_the_robot():
    rig = Rig()
    rig.run(2.0, rig.wheels(0.3, 0.2))
    for _ in range(50 * 4):
        rig.firmware.advance(0.02)
    assert wheels(rig) == (0.0, 0.0) and rig.firmware.watchdog_expired


def test_body_after_wheels_and_wheels_after_body():
    rig = Rig()
    rig.run(3.0, rig.wheels(0.2, 0.1))
    rig.run(3.0, rig.velocity(0.1, 0.0))
    assert wheels(rig) == pytest.approx((0.1, 0.1), abs=0.001)
    rig.run(3.0, rig.wheels(-0.1, 0.1))
    assert rig.firmware.velocity == pytest.approx((0.0, 0.56), abs=0.01)
    rig.run(3.0, rig.velocity(0.0, math.radians(20)))
    assert rig.firmware.velocity == pytest.approx((0.0, math.radians(20)), abs=0.001)


def test_without_motors_nothing_turns():
    rig = Rig(motors=False)
    rig.run(2.0, rig.wheels(0.2, 0.2))
    assert wheels(rig) == (0.0, 0.0) and not rig.firmware.motors_enabled
