"""The pictures of fault effects show every fault and every option, and their runs have the stated effects."""

import importlib.util
import pathlib

import pytest

from pioneer_control.simulator.line.faults import KINDS
from pioneer_control.simulator.hardware.robot_numbers import LEGAL, standard_numbers

BENCH = pathlib.Path(__file__).resolve().parents[3] / "bench" / "fault_effects.py"
_spec = importlib.util.spec_from_file_location("fault_effects", str(BENCH))
fault_effects = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(fault_effects)


def test_every_fault_and_every_option_has_its_picture():
    assert sorted(fault.split()[0] for fault in fault_effects.FAULTS) == sorted(set(KINDS) - fault_effects.NOT_DRIVEN)
    shown = {"%s.%s" % (section, name) for section, values in fault_effects.OPTIONS for name in values}
    assert shown == {name for name in LEGAL if name.startswith(("wheels.", "sonar."))}


@pytest.fixture(scope="module")
def undisturbed():
    return fault_effects.run(None, standard_numbers(), 1, False)


@pytest.mark.parametrize("fault, later", [
    ("charger from 2", 0.0),
    ("silence from 8 to 14", 9.0),
    ("stop_button from 8 to 13", 6.0),
    ("power from 8 to 10", 6.0),
])
def test_a_run_with_a_fault(undisturbed, fault, later):
    run = fault_effects.run(fault, standard_numbers(), 1, False)
    assert undisturbed.arrived == pytest.approx(33.0, abs=2.0)
    assert run.arrived - undisturbed.arrived == pytest.approx(later, abs=1.0 if later else 0.01)
    effect = fault_effects.effect(fault_effects.Panel(fault, undisturbed, run))
    assert (effect == "no effect on the path") == (not later)


def test_the_same_seed_gives_the_same_run():
    runs = [fault_effects.run("loss 0.4 from 2", standard_numbers(), seed, False) for seed in (3, 3, 4)]
    assert (runs[0].track.tolist() == runs[1].track.tolist()) and runs[0].track.tolist() != runs[2].track.tolist()
