"""robot.yaml, and a user's file that overrides it."""

import pytest

from pioneer_control.errors import ParameterError
from pioneer_control.simulator.hardware import load_numbers


def test_own_numbers():
    numbers = load_numbers()
    assert (numbers.session.watchdog_ms, numbers.drive.linear_limit_mm_s, numbers.sonar.maximum) == (2000, 750, 5.0)


def test_an_override_changes_what_it_names(tmp_path):
    path = tmp_path / "mine.yaml"
    path.write_text("sonar: {noise: 0, maximum: 3}\nsession: {watchdog_ms: 500}\n")
    numbers = load_numbers(str(path))
    assert (numbers.sonar.noise, numbers.sonar.maximum, numbers.sonar.minimum) == (0, 3, 0.1)
    assert numbers.session.watchdog_ms == 500


@pytest.mark.parametrize("text, message", [
    ("snoar: {noise: 0}", "no section 'snoar'"),
    ("sonar: {nosie: 0}", "no number sonar.nosie"),
    ("sonar: {cycle_ms: fast}", "sonar.cycle_ms is 'fast'"),
    ("sonar: {cycle_ms: true}", "sonar.cycle_ms is True"),
    ("sonar: {minimum: 0}", "sonar.minimum is 0: give a number from 1e-06 up"),
    ("sonar: {maximum: 0}", "sonar.maximum is 0: give a number from 0.2 to 30"),
    ("sonar: {cone_deg: 91}", "sonar.cone_deg is 91: give a whole number from 1 to 90"),
    ("sonar: {specular_deg: 0}", "sonar.specular_deg is 0: give a whole number from 1 to 90"),
    ("sonar: {noise: -0.1}", "sonar.noise is -0.1: give a number from 0 to 1"),
    ("wheels: {larger: -0.6}", "wheels.larger is -0.6: give a number from -0.5 to 0.5"),
    ("wheels: {right_larger: .nan}", "wheels.right_larger is nan: give a number from -0.5 to 0.5"),
    ("wheels: {wider_apart: 0.6}", "wheels.wider_apart is 0.6: give a number from -0.5 to 0.5"),
    ("wheels: {slip: -0.1}", "wheels.slip is -0.1: give a number from 0 to 0.9"),
    ("wheels: {noise: 1}", "wheels.noise is 1: give a number from 0 to 0.1"),
    ("drive: {stall_time: .inf}", "stall_time is inf: give a number from 1e-06 up"),
    ("gripper: {open_at_power_on: 1}", "open_at_power_on is 1"),
    ("session: {host_baud: 4800}", "session.host_baud is 4800: give one of 9600, 19200"),
    ("gripper: {fitted_by_default: p3dx-sh}", "fitted_by_default is 'p3dx-sh': give a list of texts"),
    ("gripper: {fitted_by_default: [3]}", r"fitted_by_default is \[3\]: give a list of texts"),
    ("sonar: 5", "expected sections"),
    ("- 1", "expected sections"),
    ("{", "does not parse"),
])
def test_mistakes(tmp_path, text, message):
    path = tmp_path / "mine.yaml"
    path.write_text(text)
    with pytest.raises(ParameterError, match=message) as refused:
        load_numbers(str(path))
    assert "\n" not in str(refused.value)


def test_a_file_that_is_no_text(tmp_path):
    path = tmp_path / "picture.yaml"
    path.write_bytes(b"\x89PNG\xff")
    with pytest.raises(ParameterError, match="picture.yaml does not parse"):
        load_numbers(str(path))
