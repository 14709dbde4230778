"""One SIP becomes one state in SI units. The bytes are those of the protocol sheet (4.5)."""

import dataclasses
import math

import pytest

from pioneer_control import p2os
from pioneer_control.client.corrected_odometry import odometry_of
from pioneer_control.client.gripper import read_gripper, read_pioneer_1_gripper
from pioneer_control.client.identity import identify
from pioneer_control.client.odometry import Odometry
from pioneer_control.client.state import SonarRange, StateReader
from pioneer_control.robots import find_model

from fake_robot import config, sip

DRIVING = "FAFB2833D204C8FF0002BE00D20080000200020700000203DC0504980821 0500F000800000200000002 60D".replace(" ", "")
OLD = "FAFB1B3200000000000000000000820000000000000000 000000FFFF337E".replace(" ", "")
STALLED = "FAFB2532F87F0A0000F8000000007E010100F820000001008813 6201FFCF05FD0001000008 00AF70".replace(" ", "")


class Reader(StateReader):
    """A reader of packets. A packet takes no time on the line, unless the test says so."""

    def read(self, sip, time, transfer_time=0.0):
        return super().read(sip, time, time - transfer_time)


def reader(subtype="p3dx-sh", has_gripper=True, **fields):
    model = find_model(subtype)
    identity = identify(p2os.SyncReply("fake", "Pioneer", subtype), model, config(**fields), has_gripper=has_gripper)
    return Reader(identity, Odometry(model.dist_mm_per_unit, model.angle_units_per_rev))


def packet(text):
    frame, = p2os.FrameDecoder().feed(bytes.fromhex(text))
    return p2os.decode_packet(frame)


def test_a_driving_robot():
    state = reader(front_bumpers=5, rear_bumpers=5).read(packet(DRIVING), 12.5)
    assert state.time == 12.5
    assert (state.linear, state.angular) == (pytest.approx(0.2), pytest.approx(math.radians(3.2)))
    assert state.motors_enabled and not state.stop_button and state.sonar_enabled
    assert not state.left_stall and not state.right_stall
    assert state.front_bumpers == (True, False, False, False, False) and state.rear_bumpers == (False,) * 5
    assert state.battery_voltage == pytest.approx(12.8)
    assert state.sonar[3] == SonarRange(1.5, 12.5) and state.sonar[4] == SonarRange(2.2, 12.5)
    assert [number for number, heard in enumerate(state.sonar) if heard] == [3, 4] and len(state.sonar) == 16
    assert (state.analog_port, state.analog_voltage) == (5, 0.0)
    assert (state.digital_in, state.digital_out, state.charge_state) == (0xF0, 0, 0)
    assert state.gripper.paddles_open and state.gripper.lift_down and not state.gripper.lift_up
    assert state.fault_flags == 0 and state.temperature is None and state.state_of_charge is None


def test_an_old_robot_says_less():
    state = reader("p2dx", has_gripper=False).read(packet(OLD), 0.0)
    assert state.battery_voltage == pytest.approx(13.0)
    assert (state.digital_in, state.digital_out) == (255, 255)
    assert (state.fault_flags, state.charge_state, state.temperature, state.gripper) == (None, None, None, None)
    assert not state.motors_enabled and not state.sonar_enabled


def test_a_robot_in_trouble():
    state = reader("powerbot-sh").read(packet(STALLED), 0.0)
    assert state.left_stall and state.right_stall and state.stop_button and not state.motors_enabled
    assert state.battery_voltage == pytest.approx(25.3) and state.charge_state == 1
    assert state.fault_flags == p2os.FaultFlags.UNDERVOLTAGE
    assert state.sonar[0].range == pytest.approx(5.0) and state.analog_voltage == pytest.approx(5.0)
    gripper = state.gripper
    assert gripper.paddles_closed and gripper.lift_moving and gripper.lift_down
    assert gripper.inner_beam and gripper.outer_beam and gripper.left_contact and gripper.right_contact


def test_without_rotvel_the_wheels_say_how_fast_it_turns():
    state = reader().read(sip(left_velocity_units=190, right_velocity_units=210, rotation_velocity_ddeg_s=None), 0.0)
    assert state.angular == pytest.approx(10 * find_model("p3dx-sh").diff_rad_per_mm)


def test_a_calibration_corrects_the_turn_rate_that_is_reported():
    """5 deg/s by its count, 2 % more, and 0.02 rad in each of 0.2 m/s."""
    identity = reader().identity
    model = dataclasses.replace(identity.model, turn_factor=1.02, curve_rad_per_m=0.02)
    corrected = StateReader(dataclasses.replace(identity, model=model), odometry_of(model))
    state = corrected.read(
        sip(left_velocity_units=190, right_velocity_units=210, rotation_velocity_ddeg_s=50), 0.0, 0.0)
    assert state.angular == pytest.approx(math.radians(5.1) + 0.004) and state.linear == pytest.approx(0.2)


def test_the_time_on_the_line_is_taken_off():
    assert reader().read(packet(DRIVING), 12.5).sent_time == 12.5
    assert reader().read(packet(DRIVING), 12.5, 0.045).sent_time == pytest.approx(12.455)


def test_each_wheel_has_its_speed_and_its_angle():
    model = find_model("p3dx-sh")
    read = reader().read
    state = read(sip(left_velocity_units=190, right_velocity_units=210), 0.0)
    assert state.wheel_velocities == pytest.approx((0.19, 0.21))
    assert read(sip(x_counts=200), 0.1).wheel_angles == pytest.approx((0.2 / 0.0975, 0.2 / 0.0975))
    assert read(sip(x_counts=100), 0.2).wheel_angles == pytest.approx((0.1 / 0.0975, 0.1 / 0.0975)), "backwards"
    turned = math.pi / 2 / model.diff_rad_per_mm / 1000 / 0.0975
    state = read(sip(x_counts=100, heading_units=1024), 0.5)
    assert state.wheel_angles == pytest.approx((0.1 / 0.0975 - turned, 0.1 / 0.0975 + turned))
    state = reader("powerbot").read(sip(left_velocity_units=100), 0.0)
    assert state.wheel_angles is None and state.wheel_velocities == (0.1, 0.0)


@pytest.mark.parametrize("byte, degrees", [(0, None), (1, 2), (90, 180), (180, 360), (181, None), (255, None)])
def test_the_compass(byte, degrees):
    compass = reader().read(sip(compass=byte), 0.0).compass
    assert compass is None if degrees is None else compass == pytest.approx(math.radians(degrees))


def test_units_of_older_models():
    model = find_model("p3dx")
    read = reader("p3dx").read
    read(sip(), 0.0)
    echo = p2os.SonarReading(0, 1000)
    state = read(sip(x_counts=1000, left_velocity_units=100, right_velocity_units=100, sonar=(echo,)), 0.1)
    assert state.x == pytest.approx(model.dist_mm_per_unit)
    assert state.linear == pytest.approx(0.1 * model.vel_mm_s_per_unit)
    assert state.sonar[0].range == pytest.approx(model.range_mm_per_unit)


def test_a_24_volt_robot_that_only_has_the_scaled_byte():
    assert reader("powerbot").read(sip(battery_dv=126, battery_x10_dv=None), 0.0).battery_voltage == pytest.approx(25.2)


def test_sonar_is_remembered_with_its_own_time_and_the_last_of_a_packet_wins():
    read = reader().read
    read(sip(sonar=(p2os.SonarReading(2, 900), p2os.SonarReading(2, 800))), 1.0)
    state = read(sip(sonar=(p2os.SonarReading(5, 700),)), 2.0)
    assert state.sonar[2] == SonarRange(0.8, 1.0) and state.sonar[5] == SonarRange(0.7, 2.0) and state.sonar[0] is None


def test_sonar_numbers_that_the_model_does_not_have_are_ignored_and_counted():
    states = reader(rear_sonar=0)
    state = states.read(sip(sonar=tuple(p2os.SonarReading(number, 1000) for number in (0, 8, 15, 16, 255))), 0.0)
    assert len(state.sonar) == 8 and state.sonar[0] is not None and states.unknown_sonar == 4


def test_a_robot_that_reports_more_sonar_than_before_has_a_reading_for_each():
    read = reader(front_sonar=1, rear_sonar=0)
    assert len(read.read(sip(), 1.0).sonar) == 8
    read.follow(reader(front_sonar=1, rear_sonar=1).identity)
    assert len(read.read(sip(), 1.1).sonar) == 16
    read.follow(reader(front_sonar=1, rear_sonar=0).identity)
    assert len(read.read(sip(), 1.2).sonar) == 16     # whoever still has the old model in mind looks for all of them


def test_numbers_below_those_that_are_fitted_are_no_less_unknown():
    states = reader(front_sonar=0)
    state = states.read(sip(sonar=(p2os.SonarReading(3, 1000), p2os.SonarReading(9, 1000))), 0.0)
    assert state.sonar[3] is None and state.sonar[9] is not None and states.unknown_sonar == 1


def test_temperature_and_charge_where_reported():
    state = reader().read(sip(lateral_velocity_mm_s=0, temperature_c=21, state_of_charge_percent=80), 0.0)
    assert (state.temperature, state.state_of_charge) == (21.0, 0.8)
    state = reader().read(sip(lateral_velocity_mm_s=0, temperature_c=-128, state_of_charge_percent=0), 0.0)
    assert (state.temperature, state.state_of_charge) == (None, None)


@pytest.mark.parametrize("grip_state, names", [
    (0x21, "paddles_open lift_down"), (0x12, "paddles_closed lift_up"), (0x06, "paddles_closed paddles_moving"),
    (0x50, "lift_up lift_moving"), (0x88, "paddles_error lift_error"), (0x00, ""), (0x03, ""), (0x30, ""),
])
def test_the_gripper_state_bits(grip_state, names):
    reading = read_gripper(grip_state, 0xF0)
    assert {name for name, value in dataclasses.asdict(reading).items() if value} == set(names.split())


@pytest.mark.parametrize("digital_in, names", [
    (0xF8, "inner_beam"),
    (0xF4, "outer_beam"),
    (0xE0, "left_contact"),
    (0xD0, "right_contact"),
    (0xFF, "inner_beam outer_beam"),
])
def test_the_gripper_switches(digital_in, names):
    reading = read_gripper(0, digital_in)
    assert {name for name, value in dataclasses.asdict(reading).items() if value} == set(names.split())


# Identity

def identity(model="p3dx-sh", limits=(None, None), has_gripper=None, **fields):
    return identify(p2os.SyncReply("fake", "Pioneer", model), find_model(model), config(**fields), *limits, has_gripper)


def test_what_the_robot_reports_wins_over_the_table():
    known = identity(
        has_gripper=None, translation_velocity_max_mm_s=1200, rotation_velocity_max_deg_s=50, rear_sonar=0,
        watchdog_ms=1500)
    assert known.max_linear == pytest.approx(1.2) and known.max_angular == pytest.approx(math.radians(50))
    assert {transducer.number for transducer in known.model.sonar} == set(range(8)) and known.watchdog == 1.5
    assert (known.firmware, known.serial) == ("2.9", "P3DX0001")


def test_of_a_working_and_a_hard_limit_that_contradict_each_other_the_lower_holds():
    known = identity(
        translation_velocity_max_mm_s=65535, translation_velocity_top_mm_s=1500,
        rotation_velocity_max_deg_s=100, rotation_velocity_top_deg_s=90)
    assert (known.max_linear, known.max_angular) == (1.5, math.radians(90))


def test_what_the_robot_leaves_empty_comes_from_the_table():
    model = find_model("p3dx-sh")
    known = identity(
        translation_velocity_max_mm_s=0, translation_velocity_top_mm_s=0,
        rotation_velocity_max_deg_s=None, rotation_velocity_top_deg_s=None,
        watchdog_ms=0, front_sonar=0, rear_sonar=0, firmware_version="")
    assert (known.max_linear, known.max_angular) == (model.max_linear, model.max_angular)
    assert known.watchdog == 2.0 and known.model == model and known.firmware is None


def test_bumpers_are_the_robots_own_unless_it_does_not_say():
    model = find_model("peoplebot-sh")
    assert (model.front_bumpers, model.rear_bumpers) != (3, 2)
    known = identity("peoplebot-sh", front_bumpers=3, rear_bumpers=2)
    assert (known.model.front_bumpers, known.model.rear_bumpers) == (3, 2)
    old = {name: None for name in ("front_bumpers", "rear_bumpers")}
    assert identity("peoplebot-sh", **old).model.front_bumpers == model.front_bumpers
    state = reader(front_bumpers=9, rear_bumpers=0).read(sip(right_stall_bits=p2os.StallBits(0x80)), 0.0)
    assert state.front_bumpers == (False,) * 6 + (True,)


@pytest.mark.parametrize("reported, wanted, fitted", [
    (0, None, False), (1, None, True), (2, None, True), (0, True, True), (1, False, False)])
def test_a_gripper_is_there_if_the_robot_or_the_user_says_so(reported, wanted, fitted):
    reply, model = p2os.SyncReply("fake", "Pioneer", "p3dx-sh"), find_model("p3dx-sh")
    assert identify(reply, model, config(has_gripper=reported), None, None, wanted).has_gripper is fitted


def test_a_pioneer_1_tells_its_gripper_by_its_inputs_alone():
    old, new = ([read(sip(digital_in=inputs, grip_state=0), 0.0).gripper for inputs in range(256)]
                for read in (reader("pion1m").read, reader("p3dx-sh").read))
    assert old == [read_pioneer_1_gripper(inputs) for inputs in range(256)]
    assert new == [read_gripper(0, inputs) for inputs in range(256)] != old
