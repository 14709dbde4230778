"""Driving by packets: limits, watchdog, STOP button, stalls, odometry."""

import math

import pytest

from robot_on_bench import Bench

from pioneer_control import p2os
from pioneer_control.p2os import Flags, StallBits
from pioneer_control.simulator.world import World

WALL_AHEAD = World("wall", walls=[(1.0, -3.0, 1.0, 3.0)])


def test_motors_are_off_until_asked_for_and_commands_are_then_forgotten():
    bench = Bench().open(motors=False).send("VEL", 200).wait(1.0)
    assert bench.robot.true_pose == (0.0, 0.0, 0.0) and not bench.sip.flags & Flags.MOTORS_ENABLED
    bench.send("ENABLE", 1).wait(1.0)
    assert bench.robot.true_pose == (0.0, 0.0, 0.0) and bench.sip.flags & Flags.MOTORS_ENABLED
    assert bench.sip.type_id == p2os.STOPPED


def test_velocity_follows_the_trapezoid():
    bench = Bench().open().send("VEL", 300).wait(2.0)
    # One second of ramp at 300 mm/s^2, then one second at 300 mm/s.
    assert bench.robot.true_pose[0] == pytest.approx(0.3 * 0.5 + 0.3 * 1.0)
    assert bench.sip.type_id == p2os.MOVING and bench.sip.left_velocity_units == 300
    bench.send("STOP").wait(1.5)
    assert bench.robot.true_pose[0] == pytest.approx(0.45 + 0.15) and bench.robot.motors_enabled


def test_enable_zero_stops_and_forgets():
    bench = Bench().open().send("VEL", 300).wait(1.5).send("ENABLE", 0).wait(1.0).send("ENABLE", 1).wait(1.0)
    assert bench.robot.velocity == (0.0, 0.0)


def test_turning_and_arcs():
    bench = Bench().open().send("RVEL", 50).send("VEL", 100).wait(5.0, alive=True)
    assert bench.robot.velocity == (0.1, math.radians(50))
    assert bench.sip.rotation_velocity_ddeg_s == 500


def test_limits_are_clipped_to_the_tops_and_act_on_later_commands():
    bench = Bench().open().send("VEL", 1000).wait(4.0, alive=True)
    assert bench.robot.velocity[0] == 0.75
    bench.send("SETV", 9999).send("SETA", 9999).wait(1.0, alive=True)
    assert bench.robot.velocity[0] == 0.75
    bench.send("VEL", 9999).wait(1.0)
    assert bench.robot.velocity[0] == 1.5
    bench.send("CONFIG").wait(0.1)
    config = bench.of(p2os.Config)[0]
    assert (config.translation_velocity_max_mm_s, config.translation_acceleration_mm_s2) == (1500, 2000)


def test_the_model_limits_the_top():
    config = Bench("p2at").open().send("CONFIG").wait(0.1).of(p2os.Config)[0]
    assert (config.translation_velocity_top_mm_s, config.rotation_velocity_top_deg_s) == (1200, 300)


@pytest.mark.parametrize("raw, linear, turning", [
    ("FAFB06203B0A0A2A45", 0.2, 0),
    ("FAFB06203BF60A1645", 0.0, -1),
    ("FAFB06203B0AF62B31", 0.0, 1),
    ("FAFB06201BF6091624", 0.0, 1),
])
def test_vel2_is_left_in_the_high_byte(raw, linear, turning):
    # Worked packets of protocol 3.1. High byte is the left wheel: 0xF60A turns counter-clockwise, 0x0AF6 clockwise.
    bench = Bench().open()
    bench.robot.receive(bytes.fromhex(raw))
    bench.wait(1.9)
    speed, rotation = bench.robot.velocity
    assert speed == pytest.approx(linear)
    assert rotation == pytest.approx(turning * 200 * 0.0056)


def test_vel_after_vel2_cancels_both_wheels():
    bench = Bench().open().send("VEL2", 5, 10).wait(1.0).send("VEL", 100).wait(1.9)
    assert bench.robot.velocity == (0.1, 0.0)


def test_head_turns_the_shortest_way_and_dhead_as_far_as_it_says():
    bench = Bench().open().send("DHEAD", 170).wait(4.0, alive=True)
    assert bench.robot.true_pose[2] == pytest.approx(math.radians(170), abs=1e-9)
    bench.send("HEAD", 200).wait(3.0, alive=True)
    assert bench.robot.true_pose[2] == pytest.approx(math.radians(200), abs=1e-9)
    assert bench.sip.heading_units == round(-160 / 360 * 4096) == bench.sip.control_units
    bench.send("DHEAD", -400).wait(8.0, alive=True)
    assert bench.robot.true_pose[2] == pytest.approx(math.radians(-200), abs=1e-9)


def test_dchead_adds_to_the_set_point():
    bench = Bench().open().send("DHEAD", 40).wait(0.3).send("DCHEAD", 30).wait(4.0, alive=True)
    assert bench.robot.true_pose[2] == pytest.approx(math.radians(70), abs=1e-9)


@pytest.mark.parametrize("distance", [500, -300, 40])
def test_move_goes_that_far(distance):
    bench = Bench().open().send("MOVE", distance).wait(6.0, alive=True)
    assert bench.robot.true_pose[0] == pytest.approx(distance / 1000, abs=1e-9) and bench.robot.velocity[0] == 0.0


# -- watchdog

def test_the_watchdog_stops_it_and_any_packet_revives_it():
    bench = Bench().open().send("VEL", 300).wait(2.0)
    assert bench.robot.velocity[0] == 0.3 and not bench.robot.watchdog_expired
    bench.wait(1.1)
    assert bench.robot.velocity[0] == pytest.approx(0.0, abs=1e-9) and bench.robot.watchdog_expired
    sips = len(bench.sips)
    bench.wait(5.0)
    assert bench.robot.velocity[0] == 0.0 and len(bench.sips) == sips + 50 and bench.robot.motors_enabled
    bench.send("PULSE").wait(1.1)
    assert bench.robot.velocity[0] == 0.3


def test_pulses_keep_it_going():
    assert Bench().open().send("VEL", 300).wait(6.0, alive=True).robot.velocity[0] == 0.3


def test_noise_does_not_feed_the_watchdog():
    bench = Bench().open().send("VEL", 300)
    for _ in range(40):
        bench.robot.receive(b"\x55" * 20)
        bench.wait(0.1)
    assert bench.robot.velocity[0] == 0.0


# -- stops

def test_e_stop_is_quick_and_lasts_until_the_next_motion_command():
    bench = Bench().open().send("VEL", 600).send("RVEL", 50).wait(2.0).send("E_STOP").wait(0.35)
    assert bench.robot.velocity == (0.0, 0.0)
    bench.wait(1.0, alive=True)
    assert bench.robot.velocity == (0.0, 0.0)
    bench.send("VEL", 100).wait(1.0)
    assert bench.robot.velocity == (0.1, 0.0)


def test_the_stop_button_takes_the_motors_and_does_not_give_them_back():
    bench = Bench().open().send("VEL", 300).wait(1.5)
    bench.robot.press_stop_button(True)
    bench.wait(0.5)
    assert bench.sip.flags & (Flags.STOP_BUTTON | Flags.E_STALL) == Flags.STOP_BUTTON | Flags.E_STALL
    assert bench.sip.left_stall_bits & StallBits.STALLED and bench.sip.right_stall_bits & StallBits.STALLED
    assert not bench.robot.motors_enabled and bench.robot.velocity == (0.0, 0.0)
    bench.send("ENABLE", 1).send("VEL", 300).wait(0.5)
    assert not bench.robot.motors_enabled
    bench.robot.press_stop_button(False)
    bench.send("PULSE").wait(1.0)
    assert not bench.robot.motors_enabled and bench.sip.flags & (Flags.STOP_BUTTON | Flags.E_STALL) == 0
    assert not bench.sip.left_stall_bits
    bench.send("ENABLE", 1).wait(0.5)
    assert bench.robot.motors_enabled and bench.robot.velocity == (0.0, 0.0)


def test_e_stall_zero_switches_the_reaction_off():
    bench = Bench().open().send("E_STALL", 0).send("VEL", 300)
    bench.robot.press_stop_button(True)
    bench.wait(1.5)
    assert bench.sip.flags & Flags.STOP_BUTTON and not bench.sip.flags & Flags.E_STALL
    assert bench.robot.velocity[0] == 0.3
    bench.send("E_STALL", 1).wait(0.5)
    assert not bench.robot.motors_enabled


# -- collisions

def test_a_wall_stops_it_and_the_wheels_stall_after_half_a_second():
    bench = Bench(world=WALL_AHEAD).open().send("VEL", 300).wait(4.0, alive=True)
    assert bench.robot.contacts == 1
    assert bench.robot.true_pose[0] == pytest.approx(1.0 - 0.35, abs=0.007)    # the paddles touch first
    seen = [bool(sip.left_stall_bits & StallBits.STALLED) for sip in bench.sips]
    assert not any(seen[:22]) and any(seen[22:])
    assert all(sip.left_velocity_units == 0 for sip in bench.sips[-10:])
    bench.send("VEL", -200).wait(2.0, alive=True)
    assert bench.robot.true_pose[0] < 0.55 and not bench.sip.left_stall_bits and bench.robot.contacts == 1


def test_without_gripper_the_body_itself_touches():
    bench = Bench(world=WALL_AHEAD, gripper=False).open().send("VEL", 300).wait(4.0, alive=True)
    assert bench.robot.true_pose[0] == pytest.approx(1.0 - 0.21, abs=0.007)


def test_a_bumper_stalls_at_once_and_tells_which_segment():
    world = World("post", posts=[(1.0, 0.2, 0.05)])
    bench = Bench("peoplebot-sh", world).open().send("VEL", 300)
    bench.wait(5.0, alive=True)
    pressed = {int(sip.right_stall_bits) >> 1 for sip in bench.sips} - {0}
    assert pressed and all(segments & 0b00011 and not segments & 0b11000 for segments in pressed)
    assert not any(int(sip.left_stall_bits) >> 1 for sip in bench.sips)


# -- odometry

def test_seto_makes_the_pose_exactly_zero_and_leaves_the_robot_where_it_is():
    bench = Bench(pose=(2.0, 1.0, 0.5)).open().send("VEL", 400).send("RVEL", 30).wait(3.0, alive=True)
    bench.send("STOP").wait(3.0, alive=True)
    where = bench.robot.true_pose
    bench.send("SETO").wait(0.1)
    assert (bench.sip.x_counts, bench.sip.y_counts, bench.sip.heading_units) == (0, 0, 0)
    assert bench.robot.true_pose == where == bench.robot.hardware.odometry.origin
    assert bench.robot.internal_counts == (0, 0)


def test_seto_as_p2os_sends_it():
    bench = Bench().open().send("VEL", 200).wait(1.5)
    bench.robot.receive(bytes.fromhex("FAFB04073B073B"))
    bench.wait(0.02)
    assert abs(bench.robot.internal_counts[0]) < 10


@pytest.mark.parametrize("model", ["p3dx-sh", "p3dx", "p2at"])
def test_counts_wrap_at_15_bits_both_ways(model):
    bench = Bench(model, pose=(0.0, 0.0, math.radians(40)))
    per_count = bench.model.dist_mm_per_unit / 1000
    bench.open().send("SETV", 1500).send("SETA", 2000).send("RVEL", 0)
    wraps = 0
    for speed in (1000, -1000):
        bench.send("VEL", speed)
        for _ in range(500):
            before = bench.sips[-1:]
            bench.send("PULSE").wait(0.1)
            x, y = bench.robot.internal_counts
            assert (bench.sip.x_counts, bench.sip.y_counts) == (x & 0x7FFF, y & 0x7FFF)
            wraps += bool(before) and abs(bench.sip.x_counts - before[0].x_counts) > 0x4000
        assert x == pytest.approx(bench.robot.hardware.odometry.pose[0] / per_count, abs=0.51)
    assert wraps >= 2


def test_encoder_ticks_follow_the_wheels():
    bench = Bench().open().send("MOVE", 1000).send("ENCODER", 1).wait(5.0, alive=True).send("ENCODER", 1).wait(0.2)
    assert len(bench.of(p2os.Encoder)) == 2
    assert bench.of(p2os.Encoder)[-1] == p2os.Encoder(128000, 128000)
    bench.send("DHEAD", 90).wait(4.0, alive=True).send("ENCODER", 1).wait(0.2)
    ticks = round(math.pi / 2 / 0.0056 * 128)
    assert bench.of(p2os.Encoder)[-1] == p2os.Encoder(128000 - ticks, 128000 + ticks)


# -- battery

def test_the_battery_falls_faster_while_driving():
    bench = Bench().open()
    bench.robot.advance(600.0)
    assert bench.robot.hardware.battery.voltage == pytest.approx(12.9)
    bench.send("RVEL", 20)
    for _ in range(60):
        bench.send("PULSE").robot.advance(1.0)
    assert bench.robot.hardware.battery.voltage == pytest.approx(12.88, abs=0.001)


def test_a_24_volt_robot_reports_both_scales():
    sip = Bench("patrolbot-sh").open().wait(0.1).sip
    assert (sip.battery_dv, sip.battery_x10_dv) == (130, 260)


def test_low_and_empty():
    bench = Bench().open().send("BATTEST", 114).wait(0.2)
    assert bench.sip.battery_dv == 114 and bench.sip.fault_flags & p2os.FaultFlags.UNDERVOLTAGE
    assert bench.robot.motors_enabled
    bench.send("BATTEST", 109).wait(0.2)
    assert not bench.robot.motors_enabled
    bench.send("ENABLE", 1).wait(0.2)
    assert not bench.robot.motors_enabled
    bench.send("BATTEST", 0).send("ENABLE", 1).wait(0.2)
    assert bench.sip.battery_dv == 130 and bench.robot.motors_enabled
