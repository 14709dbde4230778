"""Settings of the simulated robot, and the effect of calibration.

Settings are kept, shown in CONFIGpac, and forgotten at CLOSE. Old firmware does not know them.
"""

import math

import pytest

from robot_on_bench import Bench

from pioneer_control import p2os
from pioneer_control.p2os import COMMANDS, UNKNOWN_TO
from pioneer_control.robots.table import FAMILIES

# A setting: its packet (the protocol's example where it has one), the field of CONFIGpac that shows it, and the value
# of this field before and after.
SHOWN = [
    ("FA FB 06 05 3B F4 01 F9 3C", "translation_acceleration_mm_s2", 300, 500),
    ("FA FB 06 05 1B F4 01 F9 1C", "translation_deceleration_mm_s2", 300, 500),
    ("FA FB 06 05 3B B8 0B BD 46", "translation_acceleration_mm_s2", 300, 2000),      # 3000: more than its top
    ("FA FB 06 17 3B 32 00 49 3B", "rotation_acceleration_deg_s2", 100, 50),
    ("FA FB 06 17 1B 32 00 49 1B", "rotation_deceleration_deg_s2", 100, 50),
    ("FA FB 06 52 3B 29 00 7B 3B", "rotation_kp", 40, 41),
    ("FA FB 06 53 3B 15 00 68 3B", "rotation_kv", 20, 21),
    ("FA FB 06 54 3B 01 00 55 3B", "rotation_ki", 0, 1),
    ("FA FB 06 55 3B 2A 00 7F 3B", "translation_kp", 40, 42),
    ("FA FB 06 56 3B 1F 00 75 3B", "translation_kv", 30, 31),
    ("FA FB 06 57 3B 02 00 59 3B", "translation_ki", 0, 2),
    ("FA FB 06 58 3B D8 40 30 7B", "rev_count", 16570, 16600),
    ("FA FB 06 58 3B 50 C3 A8 FE", "rev_count", 16570, 50000),                        # unsigned
    ("FA FB 06 59 1B 07 00 60 1B", "drift_factor", 0, -7),
    ("FA FB 06 5D 3B 84 00 E1 3B", "ticks_per_mm", 128, 132),
]


def shown(bench, field):
    return getattr(bench.send("CONFIG").wait(0.1).of(p2os.Config)[-1], field)


@pytest.mark.parametrize("packet, field, before, then", SHOWN)
def test_a_setting_is_kept_shown_and_forgotten_at_close(packet, field, before, then):
    bench = Bench().open()
    assert shown(bench, field) == before
    bench.robot.receive(bytes.fromhex(packet))
    assert shown(bench, field) == then
    assert shown(bench.send("CLOSE").open(), field) == before


@pytest.mark.parametrize("command, field", [("TICKSMM", "ticks_per_mm"), ("REVCOUNT", "rev_count")])
def test_a_calibration_of_zero_is_ignored(command, field):
    bench = Bench().open()
    before = shown(bench, field)
    assert shown(bench.send(command, 0), field) == before


def test_more_ticks_of_a_mm_make_longer_metres():
    bench = Bench().open().send("TICKSMM", 192).send("VEL", 200).wait(4.0, alive=True).send("VEL", 0)
    bench.wait(2.0, alive=True)
    counted = bench.robot.internal_counts[0] / 1000
    assert counted == pytest.approx(0.8, abs=0.01)
    assert bench.robot.true_pose[0] == pytest.approx(1.5 * counted, abs=0.001)
    encoder = bench.send("ENCODER", 1).wait(0.1).of(p2os.Encoder)[0]
    assert encoder.left_ticks == pytest.approx(bench.robot.true_pose[0] * 128000, abs=2)


def test_a_greater_count_of_a_turn_makes_wider_turns():
    bench = Bench().open().send("REVCOUNT", 24855).send("RVEL", 30).wait(2.0, alive=True).send("RVEL", 0)
    bench.wait(2.0, alive=True)
    counted = bench.robot.hardware.odometry.pose[2]
    assert counted == pytest.approx(math.radians(60), abs=0.05)
    assert bench.robot.true_pose[2] == pytest.approx(1.5 * counted, abs=1e-6)


def test_a_robot_as_it_comes_counts_what_it_drives():
    bench = Bench().open().send("VEL", 200).send("RVEL", 20).wait(5.0, alive=True)
    assert bench.robot.hardware.odometry.pose == pytest.approx(bench.robot.true_pose, abs=1e-9)


# Which firmware knows a setting

@pytest.mark.parametrize("subtype, known", [("p3dx-sh", 132), ("amigo-sh", 132), ("p3dx", None), ("p2dx", None)])
def test_ticks_of_a_mm_are_for_arcos(subtype, known):
    bench = Bench(subtype).open().send("TICKSMM", 132)
    assert shown(bench, "ticks_per_mm") == known and bench.robot.command_counts["unknown"] == (known is None)
    assert bench.robot.hardware.wheels.ticks_per_mm == known or known is None


def test_a_pioneer_1_knows_no_ramps():
    bench = Bench("pion1m").open().send("SETA", 500).send("SETRA", 50).send("ROTKP", 1).send("BUMPSTALL", 0)
    assert bench.robot.command_counts["unknown"] == 4 and bench.robot.hardware.drives.linear.limits.rise == 0.3


def test_the_table_of_old_firmware_names_commands_and_families_that_there_are():
    assert set(UNKNOWN_TO) <= set(COMMANDS)
    assert {family for families in UNKNOWN_TO.values() for family in families} <= set(FAMILIES)
