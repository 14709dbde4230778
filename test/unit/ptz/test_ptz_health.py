"""How a camera is: each level names what is wrong, and nothing is when all is well."""

import pytest

from pioneer_control.client.fault_flags import Level
from pioneer_control.ptz import Cabling, CameraPhase, CameraReport
from pioneer_control.ptz.health import LEVELS, OLD_ANSWER, find_camera

WELL = CameraReport(CameraPhase.READY, Cabling.TWO_WAY, -400, 178, 1000, 100.0, has_power=True, answered_at=100.0,
                    answers=7, repeated=1, stray_bytes=2)


def test_all_is_well():
    found = find_camera(WELL, "aux1", 101.5)
    assert (found.level, found.message) == (Level.OK, "ready, says where it looks")
    assert found.values == {
        "Port": "aux1", "Cabling": "two-way: it answers", "Power": "on", "Pan (deg, to the right)": "-45.0",
        "Tilt (deg, upwards)": "20.0", "Zoom (0 to 1960)": "1000", "Age of the last answer (s)": "1.5", "Answers": "7",
        "Commands that were sent again": "1", "Stray bytes": "2", "Last error": "none"}


@pytest.mark.parametrize("change, level, text", [
    (dict(cabling=Cabling.ONE_WAY), Level.WARN, "no answers: it is wired without the line for them, or"),
    (dict(answered_at=101.5 - OLD_ANSWER - 1.0), Level.WARN, "it has not answered for 11 s"),
    (dict(phase=CameraPhase.FAILED, problem="GO_TO 0 0: it does not answer"), Level.ERROR, "it does not answer"),
    (dict(phase=CameraPhase.NO_LINE, problem="no such port"), Level.ERROR, "no such port"),
    (dict(phase=CameraPhase.STARTING, problem="it is starting"), Level.OK, "it is starting"),
    (dict(phase=CameraPhase.OFF, problem="it is switched off"), Level.OK, "it is switched off"),
])
def test_what_is_not_well_is_said(change, level, text):
    found = find_camera(WELL._replace(**change), "aux1", 101.5)
    assert found.level is level and text in found.message


def test_what_is_not_known_is_said_so_and_each_phase_has_its_level():
    values = find_camera(CameraReport(), "aux1", 5.0).values
    assert values["Power"] == values["Zoom (0 to 1960)"] == "not known"
    assert values["Age of the last answer (s)"] == "there was none"
    assert set(LEVELS) == set(CameraPhase)
