"""Picks through the protocol, as bench/picking.py measures them: a few seeds of each case."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "bench"))

import picking as bench

SEEDS = range(3)


@pytest.mark.parametrize("case", sorted(bench.CASES))
def test_held_is_said_exactly_when_a_can_is_held_and_what_is_between_the_paddles_is(case):
    for seed in SEEDS:
        picked = bench.run(bench.CASES[case], seed)
        assert picked.said == picked.held
        assert picked.held or not picked.between
        assert not picked.timed_out


@pytest.mark.parametrize("case, held", [
    ("between the paddles", True),
    ("driven up to", True),
    ("no can", False),
    ("out of reach", False),
])
def test_the_cases_are_what_they_are_called(case, held):
    assert [bench.run(bench.CASES[case], seed).held for seed in SEEDS] == [held] * len(SEEDS)
