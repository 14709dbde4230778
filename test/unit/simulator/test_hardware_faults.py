"""Faults of the robot itself: each attribute of its hardware that a fault sets, and its effect on the wire."""

import pytest

from robot_on_bench import Bench

from pioneer_control import p2os
from pioneer_control.p2os import ChargeState, Flags, GripperCommand, GripState, StallBits
from pioneer_control.simulator.firmware import FirmwareState
from pioneer_control.simulator.world import World


def test_a_power_cycle_forgets_all_but_where_things_are():
    bench = Bench(pose=(1.0, 2.0, 0.0)).open().send("DIGOUT", 0xFF, 0x05).send("SETV", 300).send("ENCODER", 2)
    bench.send("VEL", 200).wait(1.5)
    bench.robot.hardware.battery.voltage = 12.0
    bench.robot.power_cycle()
    where, said = bench.robot.true_pose, len(bench.raw)
    bench.wait(0.5).sync(0).wait(0.4)
    assert len(bench.raw) == said
    assert bench.robot.session is FirmwareState.WAITING    # deaf while it boots: that SYNC0 is lost
    assert bench.robot.true_pose == where and where[0] > 1.1 and bench.robot.velocity == (0.0, 0.0)
    bench.wait(0.2).open(motors=False).send("ENCODER", 1).send("CONFIG").wait(0.2)
    assert not bench.sip.flags & Flags.MOTORS_ENABLED and bench.sip.digital_out == 0 and bench.sip.x_counts == 0
    assert bench.of(p2os.Encoder)[-1] == p2os.Encoder(0, 0)
    assert bench.of(p2os.Config)[-1].translation_velocity_max_mm_s == 750
    assert bench.sip.battery_x10_dv == 120


def test_held_wheels_stall_and_count_nothing():
    bench = Bench().open().send("VEL", 300).wait(1.9)
    bench.robot.hardware.stall.held = True
    x = bench.robot.true_pose[0]
    bench.send("PULSE").wait(1.0)
    assert bench.robot.true_pose[0] == x and bench.robot.contacts == 0
    assert any(sip.left_stall_bits & sip.right_stall_bits & StallBits.STALLED for sip in bench.sips[-6:])
    bench.robot.hardware.stall.held = False
    bench.send("PULSE").wait(1.9)
    assert bench.robot.true_pose[0] > x + 0.2 and not bench.sip.left_stall_bits & StallBits.STALLED


def test_a_dead_transducer_reads_no_echo():
    bench = Bench(world=World("wall", walls=[(1.0, -9.0, 1.0, 9.0)])).open()
    bench.robot.hardware.sonar.dead = {3}
    bench.wait(0.9)
    ranges = {reading.number: reading.range_units for sip in bench.sips for reading in sip.sonar}
    assert ranges[3] == 5000 and ranges[4] < 1000
    bench.robot.hardware.sonar.dead.clear()
    bench.wait(0.9)
    assert {reading.number: reading.range_units for sip in bench.sips for reading in sip.sonar}[3] == ranges[4]


def test_a_stuck_gripper_gives_up_and_shows_errors_until_it_is_told_again():
    bench = Bench().open()
    bench.robot.hardware.jam_gripper(True)
    bench.send("GRIPPER", int(GripperCommand.CLOSE)).send("GRIPPER", int(GripperCommand.LIFT_DOWN)).wait(1.0)
    assert bench.sip.grip_state & (GripState.MOVING | GripState.LIFT_MOVING) == GripState.MOVING | GripState.LIFT_MOVING
    bench.wait(4.0, alive=True)
    assert bench.sip.grip_state == GripState.OPEN | GripState.ERROR | GripState.LIFT_UP | GripState.LIFT_ERROR
    bench.robot.hardware.jam_gripper(False)
    bench.send("GRIPPER", int(GripperCommand.CLOSE)).send("GRIPPER", int(GripperCommand.LIFT_DOWN))
    bench.wait(5.0, alive=True)
    assert bench.sip.grip_state == GripState.CLOSED | GripState.LIFT_DOWN


def test_without_gripper_nothing_sticks():
    bench = Bench(gripper=False)
    bench.robot.hardware.jam_gripper(True)
    assert bench.robot.hardware.gripper is None and bench.open().wait(0.2).sip.grip_state == 0


@pytest.mark.parametrize("model, voltage, byte, real", [("p3dx-sh", 11.2, 112, 112), ("patrolbot-sh", 23.0, 115, 230)])
def test_a_battery_can_be_drained(model, voltage, byte, real):
    bench = Bench(model).open()
    bench.robot.hardware.battery.voltage = voltage
    sip = bench.wait(0.1).sip
    assert (sip.battery_dv, sip.battery_x10_dv) == (byte, real)


def test_a_charger_that_is_plugged_in():
    bench = Bench().open()
    bench.robot.hardware.battery.voltage = 12.75
    assert bench.wait(0.1).sip.charge_state == ChargeState.NOT_CHARGING
    bench.robot.hardware.charger.plugged_in = True
    sip = bench.wait(0.1).sip
    assert sip.charge_state == ChargeState.BULK and sip.flags & Flags.CHARGER_POWER
    assert bench.wait(120.0).sip.charge_state == ChargeState.OVERCHARGE
    assert bench.wait(240.0).sip.charge_state == ChargeState.FLOAT and bench.sip.battery_x10_dv == 130
    bench.robot.hardware.charger.plugged_in = False
    assert not bench.wait(0.1).sip.flags & Flags.CHARGER_POWER


def test_a_pressed_stop_button_keeps_the_motors_off():
    bench = Bench().open(motors=False)
    bench.robot.hardware.motors.enable()
    assert bench.wait(0.1).sip.flags & Flags.MOTORS_ENABLED
    bench.robot.hardware.motors.disable()
    assert not bench.wait(0.1).sip.flags & Flags.MOTORS_ENABLED
    bench.robot.hardware.motors.press_stop_button(True)
    bench.robot.hardware.motors.enable()
    assert not bench.wait(0.1).sip.flags & Flags.MOTORS_ENABLED


@pytest.mark.parametrize("model, motors", [("p2dx", True), ("p3dx", False), ("p3dx-sh", False)])
def test_the_stop_button_of_old_firmware_takes_no_motors_until_told_to(model, motors):
    bench = Bench(model).open().wait(0.1)
    bench.robot.hardware.motors.press_stop_button(True)
    bench.wait(0.1)
    assert bool(bench.sip.flags & Flags.MOTORS_ENABLED) == motors and bench.sip.flags & Flags.STOP_BUTTON
    assert bool(bench.sip.flags & Flags.E_STALL) != motors
    assert not bench.send("E_STALL", 1).wait(0.1).sip.flags & Flags.MOTORS_ENABLED


@pytest.mark.parametrize("model", ["p2dx", "p3dx"])
def test_wheels_that_hit_a_wall_one_by_one_stall_and_drive_on_when_told(model):
    bench = Bench(model, World("wall", walls=[(0.6, -9.0, 0.6, 9.0)])).open().send("VEL2", 15, 15).wait(3.0, alive=True)
    assert bench.robot.contacts == 1 and any(sip.left_stall_bits & StallBits.STALLED for sip in bench.sips)
    bench.send("VEL", -200).wait(2.0, alive=True)
    assert bench.robot.velocity == (pytest.approx(-0.2), 0.0) and not bench.sip.left_stall_bits & StallBits.STALLED
    bench.send("VEL2", -10, -10).send("STOP").wait(2.0, alive=True)
    assert bench.robot.velocity == (0.0, 0.0)


def test_what_a_device_says_that_nobody_fetches_does_not_pile_up():
    bench = Bench().open()
    for count in range(1000):
        bench.robot.hardware.aux[0].put(b"%04d" % count * 5)
    bench.send("GETAUX", 4).wait(0.2)
    first, = bench.of(p2os.SerialAux)
    assert 700 < int(first.data) < 999 and len(bench.robot.hardware.aux[0]._waiting) <= 4096


def test_time_passes_for_a_device_at_an_auxiliary_port_and_a_power_cycle_restarts_it():
    class Clockwork:
        times, restarts = [], 0

        def step(self, now_us):
            self.times.append(now_us)

        def restart(self):
            self.restarts += 1

    bench = Bench()
    device = bench.robot.hardware.aux[1].joined = Clockwork()
    bench.wait(0.05)
    step_us = bench.robot.numbers.physics.step_us
    assert device.times == list(range(step_us, 50001, step_us)) and not device.restarts
    bench.robot.power_cycle()
    assert device.restarts == 1
