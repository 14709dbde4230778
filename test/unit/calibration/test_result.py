"""The numbers of a models file and of the robot itself."""

import math
from dataclasses import replace

import pytest
import yaml

from made_runs import RAD_PER_METRE, WRONG, run_of
from pioneer_control.calibration.estimate import Estimate, estimate
from pioneer_control.calibration.plan import line, plan_of, turns
from pioneer_control.calibration.result import (OwnNumbers, after_telling, check_new_file, numbers_to_tell, of_counts,
                                                of_driver, values_of_file, write_models_file)
from pioneer_control.calibration.tracks import Factors
from pioneer_control.errors import ParameterError, UsageError
from pioneer_control.robots import find_model

MODEL = find_model("p3dx")        # 0.485 mm a unit
OWN = OwnNumbers(128, 16570, 0)
FOUND = Estimate(WRONG, Factors(0, 0, 0), 1.0, 0.95, 0.001)


def test_the_file_of_a_robot_without_a_calibration():
    """It drives 2 % and turns 3 % farther, and bends 0.02 rad in a metre."""
    counted = of_counts(WRONG, MODEL)
    values = values_of_file(counted, counted, MODEL, FOUND)
    assert values == pytest.approx({
        "dist_mm_per_unit": 0.485 * 1.02, "vel_mm_s_per_unit": 1.02, "diff_rad_per_mm": 0.0056 / 1.02,
        "turn_factor": 1.03, "curve_deg_per_m": math.degrees(0.02), "gyro_factor": 0.95}, rel=1e-4)


def test_a_calibration_on_top_of_another():
    """The driver corrects already: what it says is off by the rest, and both together are the whole."""
    before = replace(MODEL, dist_mm_per_unit=0.485 * 1.01, turn_factor=1.02, curve_rad_per_m=0.01)
    track = run_of(line(5.0), WRONG).track
    whole = of_counts(WRONG, before)
    assert whole.distance == pytest.approx(0.485 * 1.01 * 1.02) and whole.turn == pytest.approx(1.02 * 1.03)
    turned = run_of(turns(3), WRONG).track
    for raw in (track, turned):
        by_old_file = type(raw)(raw.ahead * 1.01, raw.turned * 1.02 + raw.ahead * 1.01 * 0.01)
        new = Factors(whole.distance / 0.485, whole.turn, whole.curve)
        assert raw.end(new) == pytest.approx(by_old_file.end(WRONG), abs=1e-9)
    assert of_driver(whole, before) == pytest.approx(WRONG)


def test_the_robots_own_numbers_and_the_rest():
    """128 / 1.02 = 125.49 ticks are 125, which leaves 1.02 * 125 / 128; 16570 / 1.03 = 16087.4."""
    counted = of_counts(WRONG, MODEL)
    new = numbers_to_tell(counted, MODEL, OWN)
    assert new == {"ticks_mm": 125, "rev_count": 16087}
    rest = after_telling(counted, OWN, new)
    assert rest.distance == pytest.approx(0.485 * 1.02 * 125 / 128)
    assert rest.turn == pytest.approx(1.03 * 16087 / 16570) and rest.curve == 0.02
    values = values_of_file(counted, rest, MODEL, FOUND)
    assert values["turn_factor"] == pytest.approx(1.0, abs=1e-4)
    assert values["diff_rad_per_mm"] == pytest.approx(0.0056 * 1.03 / 1.02, rel=1e-4)


def test_the_drift_factor_only_by_a_unit_that_somebody_knows():
    counted = of_counts(WRONG, MODEL)
    assert "drift_factor" not in numbers_to_tell(counted, MODEL, OWN)
    new = numbers_to_tell(counted, MODEL, OWN._replace(drift_factor=7), 0.003)
    assert new["drift_factor"] == 7 - 7         # 0.02 / 0.003 = 6.67
    assert after_telling(counted, OWN._replace(drift_factor=7), new, 0.003).curve == pytest.approx(0.02 - 0.021)


def test_a_robot_that_reports_nothing_is_told_nothing():
    counted = of_counts(WRONG, MODEL)
    assert numbers_to_tell(counted, MODEL, OwnNumbers()) == {}
    assert after_telling(counted, OwnNumbers(), {}) == counted


def test_a_number_that_no_robot_can_have_is_refused():
    with pytest.raises(ParameterError, match="rev_count is 82850; legal: a whole number from 1 to 65535"):
        numbers_to_tell(Factors(0.485, 0.2, 0.0), MODEL, OWN)


def test_the_file_is_read_by_the_driver_and_keeps_what_was_there(tmp_path):
    before, path = tmp_path / "before.yaml", tmp_path / "new.yaml"
    before.write_text("models:\n  p3dx: {width_mm: 430, turn_factor: 0.9}\n  mine: {like: p3dx}\n", encoding="utf-8")
    write_models_file(str(path), "p3dx", {"turn_factor": 1.03, "curve_deg_per_m": 1.1}, str(before), "two\n\nlines")
    found = find_model("p3dx", str(path))
    assert (found.turn_factor, found.width, found.curve_rad_per_m) == pytest.approx((1.03, 0.43, math.radians(1.1)))
    assert find_model("mine", str(path)).turn_factor == 1.03
    assert path.read_text(encoding="utf-8").startswith("# two\n#\n# lines\n")
    assert list(yaml.safe_load(path.read_text(encoding="utf-8"))) == ["models"]


def test_what_is_there_is_never_overwritten(tmp_path):
    there = tmp_path / "there.yaml"
    there.write_text("models: {}\n", encoding="utf-8")
    for path, reason in ((there, "is there already"), (tmp_path / "no" / "x.yaml", "No such file or directory")):
        with pytest.raises(UsageError, match=reason):
            write_models_file(str(path), "p3dx", {"turn_factor": 1.0})
    with pytest.raises(UsageError, match="is there already"):
        check_new_file(str(there))


@pytest.mark.parametrize("path", ["", "/proc/x.yaml", "x" * 300])
def test_a_name_that_cannot_be_written_is_refused_before_anything_is_driven(path):
    """Root has the right to write anywhere, and cannot all the same."""
    with pytest.raises(UsageError, match="'%s' cannot be written" % path):
        check_new_file(path)


def test_a_disk_that_is_full_is_told(tmp_path, monkeypatch):
    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(yaml, "safe_dump", lambda *_, **__: full())
    with pytest.raises(UsageError, match="new.yaml cannot be written: No space left on device"):
        write_models_file(str(tmp_path / "new.yaml"), "p3dx", {"turn_factor": 1.0})
    assert list(tmp_path.iterdir()) == []


def test_values_that_no_driver_reads_are_not_written(tmp_path):
    path = tmp_path / "new.yaml"
    with pytest.raises(UsageError, match="turn_factor is 3.0, but must be a number from 0.5 to 2"):
        write_models_file(str(path), "p3dx", {"turn_factor": 3.0})
    assert list(tmp_path.iterdir()) == []


def test_from_runs_to_a_file():
    """A robot that is 2 % and 3 % off, from its runs: the file has what makes odometry true."""
    found = estimate([run_of(each, WRONG) for each in plan_of().runs], RAD_PER_METRE)
    counted = of_counts(found.factors, MODEL)
    assert values_of_file(counted, counted, MODEL, found)["turn_factor"] == pytest.approx(1.03, abs=3e-4)
