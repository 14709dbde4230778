"""The wander in drawn worlds, through the protocol, as bench/wander.py measures it:
ten worlds, two simulated minutes each.
"""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "bench"))

import wander as bench

MINUTES = 2.0
SETUPS = sorted(bench.SETUPS)


@pytest.mark.parametrize("seed", range(200, 210))
def test_it_touches_nothing_and_gets_somewhere(seed):
    """Row 22: the robots take turns; the worlds are the first ten of the bench."""
    run = bench.drive(SETUPS[seed % len(SETUPS)], "ours", seed, bench.Circumstances(MINUTES))
    assert run.contacts == 0, run.first_contact
    assert run.distance > bench.ENOUGH * MINUTES
    assert run.stuck_minutes == 0


def test_the_original_rule_does_collide():
    """The original rule must collide in these worlds. Otherwise, counting no contact of our rule would prove nothing.
    """
    runs = [bench.drive("p3dx-sh, gripper", "original", seed, bench.Circumstances(MINUTES)) for seed in range(200, 205)]
    assert sum(run.contacts for run in runs) > 0


def test_a_robot_that_stands_is_seen_to_be_stuck():
    """A robot that stands still must be counted as stuck. Otherwise, counting no minutes on one spot would prove
    nothing.
    """
    world = bench.random_world(0)
    x, y, _ = world.starts[0]
    standing = [(x, y, 0.0)] * 601
    leaving = [(x + 0.001 * step, y, 0.0) for step in range(601)]
    assert bench.stuck_minutes(world, standing) == 1
    assert bench.stuck_minutes(world, leaving) == 0


def test_the_same_seed_gives_the_same_run():
    given = bench.Circumstances(0.5)
    assert bench.drive("amigo-sh", "ours", 3, given) == bench.drive("amigo-sh", "ours", 3, given)
