"""Sonar, gripper, inputs and outputs, as the packets show them."""

import pytest

from robot_on_bench import Bench

from pioneer_control import p2os
from pioneer_control.p2os import DigitalIn, Flags, GripperCommand, GripperSwitches, GripState
from pioneer_control.robots import find_model
from pioneer_control.simulator.world import Can, World

PALM = 0.21 + find_model("p3dx-sh").gripper.paddle_start


def fired(bench):
    """Return the numbers of the readings of each SIP."""
    return [[reading.number for reading in sip.sonar] for sip in bench.sips]


def test_arrays_fire_in_step_one_transducer_each_40_ms():
    bench = Bench().open().wait(0.4)
    assert fired(bench) == [[0, 8, 1, 9], [2, 10, 3, 11, 4, 12], [5, 13, 6, 14], [7, 15, 0, 8, 1, 9]]


def test_only_fitted_transducers_fire():
    assert fired(Bench(rear_sonar=False).open().wait(0.3)) == [[0, 1], [2, 3, 4], [5, 6]]
    assert {number for numbers in fired(Bench("amigo-sh").open().wait(1.0)) for number in numbers} == set(range(8))


def test_ranges_square_on_and_at_their_ends():
    walls = [(1.166, -9.0, 1.166, 9.0)]
    bench = Bench(world=World("wall", walls=walls)).open().wait(1.0)
    ranges = {reading.number: reading.range_units for sip in bench.sips for reading in sip.sonar}
    assert ranges[3] == ranges[4] == 1000   # at x = 0.166, looking 10 degrees aside: the perpendicular is in the cone
    assert ranges[0] == ranges[11] == 5000  # sideways and behind: nothing
    near = Bench(world=World("wall", walls=[(0.26, -9.0, 0.26, 9.0)]), gripper=False).open().wait(1.0)
    ranges = {reading.number: reading.range_units for sip in near.sips for reading in sip.sonar}
    assert ranges[3] == 100


def test_a_firing_hears_the_world_from_where_the_robot_was():
    bench = Bench(world=World("wall", walls=[(3.0, -9.0, 3.0, 9.0)]), gripper=False).open().send("VEL", 500).wait(1.9)
    before = len(bench.sips)
    bench.send("PULSE").wait(1.0)
    heard = [reading.range_units for sip in bench.sips[before:] for reading in sip.sonar if reading.number == 3]
    speed_mm_s = (heard[0] - heard[-1]) / (0.32 * (len(heard) - 1))
    assert speed_mm_s == pytest.approx(500, abs=3)


def test_range_units_of_the_model():
    bench = Bench("p2at", World("wall", walls=[(1.245, -9.0, 1.245, 9.0)])).open().wait(1.0)
    ranges = {reading.number: reading.range_units for sip in bench.sips for reading in sip.sonar}
    assert (ranges[3], ranges[0]) == (round(1000 / 0.268), round(5000 / 0.268))


def test_noise_stays_within_its_bound_and_leaves_silence_alone():
    bench = Bench(world=World("wall", walls=[(1.166, -9.0, 1.166, 9.0)]), noise=0.01, seed=5).open().wait(20.0)
    heard = {reading.range_units for sip in bench.sips for reading in sip.sonar if reading.number == 3}
    assert min(heard) >= 990 and max(heard) <= 1010 and len(heard) > 10
    assert {reading.range_units for sip in bench.sips for reading in sip.sonar if reading.number == 0} == {5000}


def test_sonar_off_and_on():
    bench = Bench().open().wait(0.5).send("SONAR", 0).wait(0.5)
    assert bench.sip.sonar == () and not bench.sip.flags & (Flags.SONAR_1 | Flags.SONAR_2)
    bench.send("SONAR", 1).wait(0.2)
    assert bench.sip.sonar and bench.sip.flags & Flags.SONAR_1 and bench.sip.flags & Flags.SONAR_2


def test_polling_changes_the_sequence_of_the_arrays_it_names():
    bench = Bench().open().send("POLLING", bytes([1, 2, 1, 2])).wait(0.2)
    assert fired(bench) == [[0, 8, 1, 9], [0, 10, 1, 11, 0, 12]]
    bench.send("POLLING", b"").wait(0.2)
    assert bench.sip.sonar == () and not bench.sip.flags & Flags.SONAR_1
    bench.send("SONAR", 1).wait(0.1)
    assert [number for number in fired(bench)[-1] if number < 8] == [0, 1]


def test_polling_of_what_is_not_there():
    bench = Bench(rear_sonar=False).open().send("POLLING", bytes([9, 10, 33, 200, 0])).wait(0.5)
    assert fired(bench)[:2] == [[0, 1], [2, 3, 4]]


def test_the_cycle_can_be_set_and_a_sip_never_grows_too_long():
    bench = Bench().open().send("SONARCYCLE", 2).wait(1.0)
    assert 40 <= len(bench.sip.sonar) <= 55
    bench.send("SONARCYCLE", 100).wait(1.0)
    assert len(bench.sip.sonar) == 2


# -- gripper

def grip(bench, *commands, seconds=5.0):
    for command in commands:
        bench.send("GRIPPER", int(command))
    return bench.wait(seconds, alive=True)


def test_gripper_at_power_on():
    sip = Bench().open().wait(0.1).sip
    assert sip.grip_state == GripState.OPEN | GripState.LIFT_UP
    free = DigitalIn.LEFT_CONTACT_FREE | DigitalIn.RIGHT_CONTACT_FREE
    assert sip.digital_in == free | DigitalIn.INPUT_6 | DigitalIn.INPUT_7


def test_no_gripper():
    bench = Bench(gripper=False).open().send("GRIPPER", 2).send("GRIPREQUEST", 1).wait(1.0)
    assert (bench.sip.grip_state, bench.sip.digital_in) == (0, 0xFF)
    assert bench.of(p2os.Gripper)[0].has_gripper == 0


def test_moving_bits_carry_the_direction():
    bench = grip(Bench().open(), GripperCommand.LIFT_DOWN, GripperCommand.CLOSE, seconds=1.0)
    assert bench.sip.grip_state == GripState.CLOSED | GripState.MOVING | GripState.LIFT_DOWN | GripState.LIFT_MOVING
    assert bench.sip.digital_in & DigitalIn.PADDLES_NOT_OPEN and bench.sip.digital_in & DigitalIn.LIFT_BETWEEN
    grip(bench, GripperCommand.HALT, seconds=0.2)
    assert bench.sip.grip_state == 0
    grip(bench, GripperCommand.STORE)
    assert bench.sip.grip_state == GripState.CLOSED | GripState.LIFT_UP
    grip(bench, GripperCommand.DEPLOY)
    assert bench.sip.grip_state == GripState.OPEN | GripState.LIFT_DOWN


def test_a_pick_as_packets_show_it():
    world = World("can", cans=[Can(PALM + 0.05, 0.04)])
    bench = grip(Bench(world=world).open(), GripperCommand.LIFT_DOWN)
    assert bench.sip.digital_in & DigitalIn.INNER_BEAM_BROKEN and bench.sip.digital_in & DigitalIn.OUTER_BEAM_BROKEN
    grip(bench, GripperCommand.CLOSE)
    assert bench.sip.grip_state == GripState.CLOSED | GripState.LIFT_DOWN
    assert not bench.sip.digital_in & (DigitalIn.LEFT_CONTACT_FREE | DigitalIn.RIGHT_CONTACT_FREE)
    grip(bench, GripperCommand.LIFT_UP)
    assert bench.robot.gripper.held_can is world.cans[0]
    assert bench.sip.digital_in & DigitalIn.INNER_BEAM_BROKEN
    bench.send("ENABLE", 1).send("MOVE", -300).wait(4.0, alive=True)
    assert world.cans[0].x == pytest.approx(PALM + 0.05 - 0.3, abs=1e-6)


def test_a_pick_of_nothing_ends_with_paddles_that_press_on_each_other_and_no_beam_broken():
    """Protocol sheet 6.4: clients wait for both contacts as the sign of closed paddles."""
    bench = grip(grip(Bench().open(), GripperCommand.LIFT_DOWN), GripperCommand.CLOSE)
    assert bench.sip.grip_state == GripState.CLOSED | GripState.LIFT_DOWN
    assert bench.sip.digital_in == DigitalIn.PADDLES_NOT_OPEN | DigitalIn.INPUT_6 | DigitalIn.INPUT_7
    free = DigitalIn.LEFT_CONTACT_FREE | DigitalIn.RIGHT_CONTACT_FREE
    assert grip(bench, GripperCommand.OPEN, seconds=0.2).sip.digital_in & free == free


def test_a_robot_without_gripper_pushes_cans_with_its_body():
    world = World("can", cans=[Can(0.5, 0.0)])
    Bench(world=world, gripper=False).open().send("MOVE", 500).wait(4.0, alive=True)
    assert world.cans[0].x == pytest.approx(0.5 + 0.21 + 0.033, abs=1e-4)


def test_a_can_jammed_against_a_wall_holds_the_robot_without_a_contact():
    world = World("can", walls=[(1.0, -3.0, 1.0, 3.0)], cans=[Can(0.8, 0.0)])
    bench = Bench(world=world, gripper=False).open().send("VEL", 200).wait(5.0, alive=True)
    assert bench.robot.true_pose[0] == pytest.approx(1.0 - 0.066 - 0.21, abs=0.005)
    assert bench.robot.contacts == 0 and any(sip.left_stall_bits for sip in bench.sips)


def test_pressure_and_carry_need_their_value_right_behind():
    bench = grip(Bench().open(), GripperCommand.LIFT_DOWN)
    bench.send("GRIPPER", 17).send("GRIPPERVAL", 50).wait(2.0, alive=True)
    assert bench.robot.gripper.height == pytest.approx(0.02)
    bench.send("GRIPPER", 17).send("PULSE").send("GRIPPERVAL", 50).wait(2.0, alive=True)
    assert bench.robot.gripper.height == pytest.approx(0.02)
    bench.send("GRIPPER", 17).send("GRIPPERVAL", -25).wait(2.0, alive=True)
    assert bench.robot.gripper.height == pytest.approx(0.01)
    bench.send("GRIPPER", 16).send("GRIPPERVAL", 40).send("GRIPREQUEST", 1).wait(0.2)
    assert bench.of(p2os.Gripper)[-1].grasp_time_units == 40


def test_gripperpac_once_continuous_and_off():
    bench = Bench().open().send("GRIPREQUEST", 0).wait(0.5)
    assert bench.of(p2os.Gripper) == []
    bench.send("GRIPREQUEST", 1).wait(0.5)
    assert bench.of(p2os.Gripper) == [p2os.Gripper(1, GripState.OPEN | GripState.LIFT_UP, 10)]
    bench.send("GRIPREQUEST", 2).wait(0.5)
    assert len(bench.of(p2os.Gripper)) == 6
    bench.send("GRIPREQUEST", 0).wait(0.5)
    assert len(bench.of(p2os.Gripper)) == 6


def test_gripperpac_of_p2os_shows_switches():
    bench = Bench("p2dx", gripper=True).open().send("GRIPPER", 2).send("GRIPREQUEST", 1).wait(0.1)
    state = GripperSwitches(int(bench.of(p2os.Gripper)[0].state))
    free = GripperSwitches.LEFT_CONTACT_FREE | GripperSwitches.RIGHT_CONTACT_FREE
    assert state == GripperSwitches.PADDLES_NOT_OPEN | GripperSwitches.PADDLES_MOVING | free


# -- inputs and outputs

def test_digout_changes_only_what_the_mask_says():
    bench = Bench().open().send("DIGOUT", 0xFF, 0x05).wait(0.1)
    assert bench.sip.digital_out == 0x05
    bench.robot.receive(bytes.fromhex("FAFB061E3B01051F40"))   # protocol 3.3: sets bit 0, clears bit 2
    bench.wait(0.1)
    assert bench.sip.digital_out == 0x01


def test_adsel_and_its_revert_at_close():
    bench = Bench().open().send("ADSEL", 2).wait(0.1)
    assert bench.sip.analog_port == 2
    assert bench.send("CLOSE").wait(0.1).open().wait(0.1).sip.analog_port == 5


@pytest.mark.parametrize("model, analog, battery", [("p3dx-sh", 8, (665,)), ("p3dx", 5, ())])
def test_iopac(model, analog, battery):
    bench = Bench(model, gripper=False).open().send("IOREQUEST", 2).wait(0.3)
    assert bench.of(p2os.IO) == [p2os.IO((0xFF, 0xFF, 0xFF, 0xFF), (0,), (0,) * analog + battery)] * 3
    assert [type(packet) for packet in bench.packets[-2:]] == [p2os.Sip, p2os.IO]


def test_batteryinfo():
    bench = Bench().open().send("BATTERYINFO", 1).wait(0.3)
    assert bench.of(p2os.BatteryInfo) == [p2os.BatteryInfo((p2os.Battery(0, 0, 0, 100, 100),))]


def test_what_it_is_to_say_is_kept():
    """Pairs of length (20 ms) and tone; 20 notes of one SAY, and the newest hundred of all."""
    bench = Bench().open().send("SAY", bytes([25, 69, 10, 0, 5])).wait(0.1)
    played = bench.robot.hardware.ports.speaker.played
    assert list(played) == [(pytest.approx(0.5), 69), (pytest.approx(0.2), 0)]
    bench.send("SAY", bytes(2 * [1, 60]) + bytes([2, 61] * 18)).send("SAY", b"").wait(0.1)
    assert len(played) == 22 and played[-1] == (pytest.approx(0.04), 61)
    for _ in range(6):
        bench.send("SAY", bytes([1, 60] * 20)).wait(0.1)
    assert len(played) == 100
