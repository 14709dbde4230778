"""The simulated Pioneer Arm: what each command does, how servos step, and what moves by itself (arm sheet 14, 17)."""

import dataclasses
import random
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[3] / "bench"))

import fuzz_arm
from by_the_sheet import command
from robot_on_bench import Bench

from pioneer_control import p2os
from pioneer_control.errors import ParameterError
from pioneer_control.simulator.firmware import Firmware
from pioneer_control.simulator.hardware import standard_numbers
from pioneer_control.simulator.hardware.arm import PioneerArm
from pioneer_control.robots import find_model
from pioneer_control.simulator.line.cameras import CameraPorts, fit_camera
from pioneer_control.simulator.line.robot_link import RobotLink
from pioneer_control.simulator.line.faults import KINDS
from pioneer_control.simulator.world import World

HOME = (130, 37, 235, 130, 183, 180)
NUMBERS = standard_numbers()


def numbers(**changes):
    return dataclasses.replace(NUMBERS, arm=dataclasses.replace(NUMBERS.arm, **changes))


class ArmBench(Bench):
    """A robot with an arm in an open session, with a status packet in every SIP cycle."""

    def __init__(self, **changes):
        super().__init__(arm=True, numbers=numbers(**changes))
        self.open(motors=False).send("ARM_STATUS", 2).wait(0.2)

    @property
    def arm(self):
        return self.robot.hardware.arm

    @property
    def said(self):
        """The newest status packet."""
        return self.of(p2os.Arm)[-1]

    @property
    def info(self):
        return self.of(p2os.ArmInfo)[-1]

    @property
    def positions(self):
        return tuple(servo.position for servo in self.arm.servos)

    def powered(self):
        return self.send("ARM_POWER", 1).wait(0.2)


def golden(text):
    return bytes.fromhex(text.replace(" ", ""))


INFO = golden("FA FB 2C A1 31 2E 37 00 06 14 82 19 82 EB 69 19 25 19 82 EB 69 19 EB 19 82 EB 69 0F 82 19 82 EB 69 0F B7"
              " 19 82 EB 69 0F B4 46 80 C8 80 6D 84")


@pytest.mark.parametrize("layout, at_rest, on_its_way", [
    ("M", "FA FB 0B A0 02 00 82 25 EB 82 B7 B4 49 92", "FA FB 0B A0 03 02 82 64 EB 82 B7 B4 8A 93"),
    ("A", "FA FB 0B A0 00 03 82 25 EB 82 B7 B4 4C 90", "FA FB 0B A0 02 07 82 64 EB 82 B7 B4 8F 92"),
])
def test_what_it_says_is_what_the_sheet_prints_byte_for_byte(layout, at_rest, on_its_way):
    bench = ArmBench(layout=layout).send("ARM_INFO").wait(0.1)
    assert INFO in bench.raw and golden(at_rest) in bench.raw
    bench.powered().send("ARM_POS", 2, 130)
    while bench.positions[1] < 100:
        bench.wait(0.02)
    bench.send("ARM_SPEED", 2, 127)     # so that a status comes before the next tick
    assert golden(on_its_way) in bench.wait(0.1).raw


def test_without_an_arm_nothing_is_different():
    bench = Bench().open(motors=False).send("ARM_INFO")
    for name, value in (("ARM_POWER", (1,)), ("ARM_POS", (1, 99)), ("ARM_PARK", ()), ("ARM_INIT", ())):
        bench.send(name, *value)
    bench.send("ARM_STATUS", 2).wait(0.0)
    assert bench.of(p2os.ArmInfo) == [p2os.ArmInfo("No arm", ())]      # at once
    bench.wait(1.0)
    assert set(bench.of(p2os.Arm)) == {p2os.Arm(0, 0, (0,) * 6)}
    assert bench.robot.hardware.arm is None


def test_status_comes_once_or_in_every_cycle_or_not_at_all():
    bench = Bench(arm=True).open(motors=False).wait(0.5)
    assert bench.of(p2os.Arm) == []
    assert len(bench.send("ARM_STATUS", 1).wait(0.5).of(p2os.Arm)) == 1
    assert len(bench.send("ARM_STATUS", 2).wait(1.0).of(p2os.Arm)) == 11
    assert len(bench.send("ARM_STATUS", 0).wait(1.0).of(p2os.Arm)) == 11


def test_nothing_moves_before_the_power_is_on():
    bench = ArmBench()
    for name, value in (("ARM_POS", (1, 99)), ("ARM_HOME", (255,)), ("ARM_HOME", (3,)), ("ARM_PARK", ())):
        bench.send(name, *value).wait(1.0)
    assert bench.positions == HOME and not bench.arm.powered and not any(bench.arm.moving)


@pytest.mark.parametrize("speed_ms, expected", [(20, 50), (40, 25), (127, 7), (1, 105)])
def test_a_servo_takes_its_time_for_each_tick_and_no_less_than_the_line_needs(speed_ms, expected):
    bench = ArmBench().powered().send("ARM_SPEED", 1, speed_ms).send("ARM_POS", 1, 235).wait(1.0)
    assert bench.positions[0] - 130 == pytest.approx(min(expected, 105), abs=1)
    assert bench.said.status_bits == (0b000001 if expected < 105 else 0)       # layout A: which joints move


def test_several_servos_share_the_line():
    bench = ArmBench().powered()
    for joint in range(1, 6):
        bench.send("ARM_SPEED", joint, 1).send("ARM_POS", joint, 130)
    bench.send("ARM_POS", 1, 235).send("ARM_POS", 4, 25).wait(0.4)
    moved = [abs(now - before) for now, before in zip(bench.positions, HOME)]
    assert moved[:5] == pytest.approx([40, 40, 40, 40, 40], abs=2)     # 5 at once: 10 ms a tick


def test_a_position_is_clipped_and_a_new_one_replaces_it():
    bench = ArmBench().powered().send("ARM_POS", 6, 255).send("ARM_POS", 1, 0).wait(1.0)
    bench.send("ARM_POS", 1, 255).wait(10.0)
    assert bench.positions[0] == 235 and bench.positions[5] == 200
    assert bench.send("ARM_POS", 6, 0).wait(5.0).positions[5] == 70


def test_joints_that_are_not_there_are_ignored():
    bench = ArmBench().powered()
    for joint in (0, 7, 200, 255):
        for name in ("ARM_POS", "ARM_SPEED"):
            bench.robot.receive(command(p2os.COMMANDS[name].number, joint << 8 | 99))
    bench.robot.receive(command(75, 0))
    bench.robot.receive(command(79, 0))
    bench.robot.receive(command(77, -0x0163))
    bench.wait(1.0)
    assert bench.positions == HOME


def test_speeds_are_clipped_shown_and_kept_while_the_power_goes():
    bench = ArmBench().send("ARM_INFO").wait(0.2)
    assert [joint.speed_ms for joint in bench.info.joints] == list(NUMBERS.arm.speed_ms)
    for joint, speed in ((1, 255), (2, 0), (3, 30)):
        bench.robot.receive(command(78, joint << 8 | speed))
    bench.powered().send("ARM_PARK").wait(1.0).send("ARM_INFO").wait(0.2)
    assert [joint.speed_ms for joint in bench.info.joints] == [127, 1, 30, 15, 15, 15]
    bench.send("ARM_INIT").wait(1.0).send("ARM_INFO").wait(0.2)
    assert [joint.speed_ms for joint in bench.info.joints] == list(NUMBERS.arm.speed_ms)


def away(bench, seconds=3.0):
    for joint in range(1, 6):
        bench.send("ARM_POS", joint, 130)
    return bench.wait(seconds)


def test_home_of_one_joint_goes_at_its_own_speed_and_of_all_at_a_safe_one():
    bench = away(ArmBench().powered())
    assert bench.positions[:5] == (130,) * 5
    bench.send("ARM_HOME", 5).wait(0.6)
    assert bench.positions == (130, 130, 130, 130, 170, 180) and bench.said.motion_bits == 0b0111
    bench.wait(1.0).send("ARM_HOME", 255).wait(0.6)
    assert bench.positions[1] == 130 - 20 and bench.said.motion_bits == 0b1111      # 30 ms a tick, and it says homing
    bench.wait(5.0)
    assert bench.positions == HOME and bench.arm.powered and bench.said.motion_bits == 0b0111


def test_all_joints_are_any_number_above_6():
    bench = away(ArmBench().powered()).send("ARM_HOME", 7).wait(5.0)
    assert bench.positions == HOME


def test_park_goes_home_first_and_never_drops_the_arm():
    bench = away(ArmBench().powered()).send("ARM_PARK").wait(1.0)
    assert bench.arm.powered and bench.said.motion_bits == 0b1111
    bench.wait(5.0)
    assert not bench.arm.powered and bench.positions == HOME and bench.arm.drops == 0 and bench.said.motion_bits == 0b11


def test_power_off_drops_an_arm_that_is_not_at_home_and_power_on_makes_it_jump():
    bench = away(ArmBench().powered()).send("ARM_POWER", 0).wait(0.2)
    assert (bench.arm.drops, bench.arm.jumps, bench.positions) == (1, 0, HOME)      # it believes that it is at home
    assert bench.powered().arm.jumps == 1
    assert bench.send("ARM_POWER", 0).powered().arm.drops == 1


def test_stop_holds_the_position_of_one_or_of_all_and_ends_parking():
    bench = ArmBench().powered().send("ARM_POS", 1, 235).send("ARM_POS", 2, 235).wait(0.5).send("ARM_STOP", 1).wait(1.0)
    first = bench.positions
    assert first[0] < 170 and bench.arm.moving[1]
    bench.send("ARM_STOP", 255).wait(0.1)
    stopped = bench.positions
    assert bench.wait(1.0).positions == stopped and bench.arm.powered and not any(bench.arm.moving)
    bench.send("ARM_PARK").wait(0.2).send("ARM_STOP", 255).wait(8.0)
    assert bench.arm.powered and bench.positions != HOME
    bench.send("ARM_PARK").wait(0.2).send("ARM_POS", 1, 130).wait(8.0)
    assert bench.arm.powered


def test_a_reset_takes_its_time_and_obeys_nothing_meanwhile():
    bench = ArmBench().send("ARM_INIT").wait(0.3)
    assert bench.said == p2os.Arm(0, 0, HOME)       # it says that it is not there
    bench.send("ARM_POWER", 1).send("ARM_INFO").wait(0.3)
    assert bench.info.joints and not bench.arm.powered
    assert bench.wait(0.3).said.motion_bits == 0b0011
    assert bench.powered().arm.powered


def test_a_check_takes_less_and_a_stop_gets_through():
    bench = ArmBench().powered().send("ARM_POS", 1, 235).wait(0.2).send("ARM_CHECK").send("ARM_POS", 2, 99)
    bench.send("ARM_STOP", 255).wait(0.1)
    assert bench.positions[1] == 37 and not any(bench.arm.moving)
    bench.wait(0.2).send("ARM_POS", 2, 99).wait(0.2)
    assert bench.arm.moving[1]


def test_an_arm_whose_switch_was_turned_needs_a_reset():
    bench = away(ArmBench(layout="M").powered())
    bench.arm.switch(False)
    assert bench.wait(0.2).said.status_bits == 0 and bench.arm.drops == 1
    assert bench.powered().said.status_bits == 0
    bench.arm.switch(True)
    assert bench.powered().said.status_bits == 0
    assert bench.send("ARM_INIT").wait(1.0).said.status_bits == 0b10
    assert bench.powered().said.status_bits == 0b11


def test_a_switch_that_is_off_is_not_mended_by_a_reset():
    bench = ArmBench()
    KINDS["arm"].act(link := RobotLink(bench.robot, "seed"), [None])
    assert bench.send("ARM_INIT").wait(1.0).powered().said.motion_bits == 0
    KINDS["arm"].act(link, [])
    assert bench.send("ARM_INIT").wait(1.0).powered().said.motion_bits == 0b0111
    KINDS["arm"].act(RobotLink(Bench().robot, "seed"), [None])        # a robot without an arm


def test_an_arm_may_be_unlinked_from_the_start():
    bench = ArmBench(linked_at_power_on=False)
    assert bench.powered().said.motion_bits == 0
    assert bench.send("ARM_INIT").wait(1.0).said.motion_bits == 0b0011


def test_it_parks_by_itself_when_nobody_commands_it():
    bench = away(ArmBench().powered().send("ARM_AUTOPARK", 10), 9.0)
    away(bench, 9.5)
    bench.send("ARM_INFO").send("ARM_STATUS", 2)        # these two do not count
    assert not bench.arm.parking
    bench.wait(1.0)
    assert bench.arm.parking and not bench.wait(8.0).arm.powered and bench.arm.drops == 0


def test_it_never_parks_by_itself_with_autopark_0():
    assert away(ArmBench(autopark_s=5).powered().send("ARM_AUTOPARK", 0), 30.0).arm.powered
    assert not away(ArmBench(autopark_s=5).powered(), 30.0).arm.powered


def test_a_gripper_that_was_closed_for_long_opens():
    bench = ArmBench().powered().send("ARM_GRIPPARK", 20).send("ARM_POS", 6, 70).wait(19.0)
    assert bench.positions[5] == 70
    assert bench.wait(8.0).positions[5] == 180
    assert ArmBench().powered().send("ARM_GRIPPARK", 0).send("ARM_POS", 6, 70).wait(400.0).positions[5] == 70


def test_the_end_of_the_session_parks_it():
    bench = away(ArmBench().powered()).send("CLOSE").wait(1.0)
    assert bench.arm.powered
    assert not bench.wait(6.0).arm.powered and bench.arm.drops == 0


def test_a_reset_or_a_power_cycle_of_the_robot_drops_it():
    for end in (Firmware.restart, Firmware.power_cycle):
        bench = away(ArmBench().powered().send("ARM_SPEED", 1, 99))
        end(bench.robot)
        assert (bench.arm.powered, bench.arm.drops, bench.positions) == (False, 1, HOME), end
        assert bench.arm.servos[0].speed_ms == 20


def test_the_port_of_the_arm_has_no_room_for_another_device():
    robot = Firmware(find_model("p3dx-sh"), World("hall"), (0.0, 0.0, 0.0), arm=True)
    assert robot.hardware.aux[0].joined is robot.hardware.arm
    with pytest.raises(ParameterError, match="AUX1 has an arm already: a camera needs another auxiliary"):
        fit_camera(robot, CameraPorts("vcc4"))
    fit_camera(robot, CameraPorts("vcc4", aux=2))
    with pytest.raises(ParameterError, match="AUX1 has an arm already: an arm needs another auxiliary"):
        robot.hardware.join_arm(NUMBERS.arm)
    robot.hardware.aux[2].join(PioneerArm(NUMBERS.arm), 3)


def test_an_arm_that_no_client_can_command_is_refused():
    with pytest.raises(ParameterError, match="an arm on a pion1m .*: its firmware PSOS has no commands of an arm"):
        Firmware(find_model("pion1m"), World("hall"), (0.0, 0.0, 0.0), arm=True)


def test_random_commands_never_leave_its_ranges_or_upset_it():
    """bench/fuzz_arm.py does the same a million times."""
    counts = fuzz_arm.fuzz_simulated_arm(random.Random(5), 5000)
    assert counts["with power"] > 500 and counts["moving"] > 100


def test_an_arm_that_moves_without_power_is_seen(monkeypatch):
    monkeypatch.setattr(PioneerArm, "cut_power", lambda arm: setattr(arm, "powered", False))
    with pytest.raises(AssertionError):
        fuzz_arm.fuzz_simulated_arm(random.Random(5), 5000)
