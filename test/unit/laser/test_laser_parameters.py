"""The parameters of the laser's node: each has an effect, and each mistake is named."""

import dataclasses
import math

import numpy as np
import pytest

from pioneer_control.errors import ParameterError, UnknownModelError, UsageError
from pioneer_control.laser.parameters import LaserParameters, check_laser_parameters
from pioneer_control.laser.settings import LaserSettings


def parameters(**given):
    return check_laser_parameters(given)[0]


def test_nothing_given_is_all_defaults_and_asks_nothing_of_the_laser():
    assert check_laser_parameters({}) == (LaserParameters(), [])
    assert LaserParameters().settings == LaserSettings()
    assert LaserParameters().mounted == (None, False, False)


def test_every_default_is_legal():
    for entry in dataclasses.fields(LaserParameters):
        given = {"inverted": "auto", "place": ""}.get(entry.name, entry.default)
        assert entry.metadata["kind"].accept(given) == entry.default


@pytest.mark.parametrize("given, asked", [
    (dict(baud=500000), dict(baud=500000)), (dict(angle=100), dict(angle_deg=100)),
    (dict(resolution=0.5), dict(step_hundredths=50)), (dict(resolution=1), dict(step_hundredths=100)),
    (dict(angle=100, resolution=0.25), dict(angle_deg=100, step_hundredths=25)),
    (dict(units="cm"), dict(unit=0)), (dict(units="mm"), dict(unit=1)),
    (dict(measuring_mode=5), dict(measuring_mode=5)), (dict(measuring_mode=0), dict(measuring_mode=0)),
    (dict(write=True), dict(writes=True)), (dict(password="SECRET__"), dict(password=b"SECRET__")),
    (dict(power_on=10), dict(power_on=10.0)),
])
def test_what_is_asked_of_the_laser(given, asked):
    assert parameters(**given).settings == LaserSettings(**asked)


@pytest.mark.parametrize("given, message", [
    (dict(baud=57600), "~baud = 57600 .*9600, 19200, 38400, 500000"), (dict(angle=270), "~angle = 270"),
    (dict(resolution=0.3), "~resolution = 0.3 .*0.25, 0.5, 1.0"), (dict(units="inch"), "an empty text, cm, mm"),
    (dict(measuring_mode=63), "~measuring_mode = 63"), (dict(write="yes"), "true or false"),
    (dict(angle=180, resolution=0.25), "0.25 degrees"), (dict(password="short"), "eight characters"),
    (dict(power_on=-1), "~power_on"), (dict(time_offset=11), "~time_offset"), (dict(no_echo="nan"), "inf, max"),
    (dict(place=[1, 2]), "four numbers"), (dict(place="[1, 2, 3, north]"), "four numbers"), (dict(place=7), "a model"),
    (dict(place="amigo-sh"), "~place = 'amigo-sh': where the laser of this model sits is not known"),
    (dict(frame_id="/laser"), "not beginning"), (dict(prot="/dev/x"), "did you mean ~port"),
    (dict(inverted="maybe"), "auto, true or false"),
])
def test_mistakes(given, message):
    with pytest.raises(ParameterError, match=message):
        check_laser_parameters(given)


def test_a_model_that_nobody_knows():
    with pytest.raises(UnknownModelError, match="p3dx-sh"):
        check_laser_parameters({"place": "p3dz-sh"})


@pytest.mark.parametrize("given, mounted", [
    (dict(place="p3dx-sh"), ((0.021, 0.0, 0.0, 0.0), False, True)),
    (dict(place="powerbot-sh"), ((0.251, 0.0, 0.0, 0.0), True, True)),
    (dict(place="pioneer-lx"), ((0.267, 0.0, 0.19, 0.0), True, False)),
    (dict(place="powerbot-sh", inverted=False), ((0.251, 0.0, 0.0, 0.0), False, True)),
    (dict(place=[0.1, 0, 0.3, 3.1], inverted=True), ((0.1, 0.0, 0.3, 3.1), True, False)),
    (dict(place="[0.1, 0, 0.3, 0]"), ((0.1, 0.0, 0.3, 0.0), False, False)),
    (dict(place=" ", inverted=True), (None, True, False)),
])
def test_where_the_laser_sits(given, mounted):
    assert parameters(**given).mounted == mounted


@pytest.mark.parametrize("given, turns_values, seen", [
    (dict(), False, (1.0, 2.0)),
    (dict(inverted=True), True, None),                                  # the user's own tf, upright
    (dict(place=[0, 0, 0, 0]), False, (1.0, 2.0)),
    (dict(place=[0, 0, 0, 0], inverted=True), False, (1.0, -2.0)),      # what it has on its left is right of the robot
    (dict(place=[0, 0, 0, math.pi / 2], inverted=True), False, (2.0, 1.0)),
    (dict(place=[0, 0, 0, math.pi / 2]), False, (-2.0, 1.0)),
    (dict(place="powerbot-sh"), False, (1.0, -2.0)),
])
def test_upside_down_is_told_by_the_frame_or_by_the_order_of_the_values(given, turns_values, seen):
    mounted = parameters(**given).mounted
    assert mounted.turns_values is turns_values
    if seen is not None:        # a point 1 m ahead of the laser and 2 m to its left, in base_link
        assert turned(mounted.rotation, (1.0, 2.0, 0.0)) == pytest.approx((*seen, 0.0))


def turned(quaternion, point):
    """Return a point turned by a quaternion x, y, z, w."""
    axis, w = np.array(quaternion[:3]), quaternion[3]
    return tuple(point + 2.0 * np.cross(axis, np.cross(axis, point) + w * np.array(point)))


def test_a_model_of_the_users_own(tmp_path):
    mine = tmp_path / "mine.yaml"
    mine.write_text("models: {mine: {like: p3dx-sh, laser: {x_mm: 50, y_mm: 0, z_mm: 300, upside_down: false}}}")
    assert parameters(place="mine", models_file=str(mine)).mounted == ((0.05, 0.0, 0.3, 0.0), False, False)
    with pytest.raises(UsageError, match="cannot be read"):
        parameters(place="mine", models_file=str(tmp_path / "none.yaml"))


def test_frames_have_the_prefix():
    both = parameters(frame_prefix="robot2/", frame_id="front", base_link_frame_id="base")
    assert (both.laser_frame, both.base_frame) == ("robot2/front", "robot2/base")


def test_parameters_of_sicktoolbox_wrapper_that_have_no_effect_are_told():
    given = dict(port="/dev/ttyUSB0", baud=38400, connect_delay=35, inverted=False, angle=180, resolution=0.5,
                 units="mm", frame_id="laser", time_offset=0.0, desired_frequency=75, min_frequency=60,
                 max_frequency=80, frequency_tolerance=0.3, window_size=30, min_acceptable_delay=0.0,
                 max_acceptable_delay=0.2, hardware_id="x", colour="blue")
    accepted, warnings = check_laser_parameters(given)
    assert accepted.port == "/dev/ttyUSB0" and accepted.inverted is False
    assert len(warnings) == 10 and "~colour has no effect: it is not a parameter of this node" in warnings
