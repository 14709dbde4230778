"""Units and axes of where a camera looks, and the frustum of its view."""

import math

import pytest

from pioneer_control.errors import ParameterError
from pioneer_control.ptz import CameraSettings, aux_port_of
from pioneer_control.ptz.view import counts_of_joints, frustum, joints, orientation, whole_degrees
from pioneer_control.vcc4 import field_of_view


def turned(quaternion, vector):
    """Return a vector that is turned by a quaternion."""
    x, y, z, w = quaternion
    cross = [y * vector[2] - z * vector[1], z * vector[0] - x * vector[2], x * vector[1] - y * vector[0]]
    again = [y * cross[2] - z * cross[1], z * cross[0] - x * cross[2], x * cross[1] - y * cross[0]]
    return [value + 2.0 * (w * first + second) for value, first, second in zip(vector, cross, again)]


def test_to_the_right_and_upwards_are_negative_angles_of_the_joints_and_back():
    assert joints(800, 400) == pytest.approx((-math.pi / 2.0, -math.pi / 4.0))
    for pan, tilt in ((0, 0), (871, -267), (-871, 782)):
        assert counts_of_joints(*joints(pan, tilt)) == (pan, tilt)
    assert [whole_degrees(count) for count in (-871, 178, 4, 5)] == [-98, 20, 0, 1]


@pytest.mark.parametrize("pan, tilt, ahead", [
    (math.pi / 2.0, 0.0, (0.0, 1.0, 0.0)), (0.0, math.pi / 2.0, (0.0, 0.0, -1.0)),
    (math.pi / 2.0, -math.pi / 4.0, (0.0, math.sqrt(0.5), math.sqrt(0.5))),
])
def test_the_orientation_turns_by_pan_first_then_tilt(pan, tilt, ahead):
    assert turned(orientation(pan, tilt), (1.0, 0.0, 0.0)) == pytest.approx(ahead)
    left = turned(orientation(pan, tilt), (0.0, 1.0, 0.0))
    assert left[2] == pytest.approx(0.0)        # the picture stays level


def test_the_view_narrows_with_the_zoom_by_equal_factors():
    wide, middle, tele = (math.degrees(field_of_view(zoom)) for zoom in (0, 980, 1960))
    assert (wide, tele) == pytest.approx((45.0, 3.0)) and middle == pytest.approx(math.sqrt(45.0 * 3.0))
    assert math.degrees(field_of_view(1960, 60.0, 2.0)) == pytest.approx(2.0)


def test_the_frustum():
    apex, *corners = frustum(math.radians(90.0))
    assert apex == (0.0, 0.0, 0.0)
    assert [tuple(map(round, (x, y, z * 4))) for x, y, z in corners] == [(1, 1, 3), (1, -1, 3), (1, -1, -3), (1, 1, -3)]


@pytest.mark.parametrize("options, text", [
    (dict(model="sony"), "legal is one of vcc4, vcc50i"), (dict(pan_speed=7), "pan_speed 7: legal is 8 to 800"),
    (dict(tilt_speed=623), "tilt_speed 623: legal is 8 to 622"),
])
def test_settings_that_no_camera_can_have(options, text):
    with pytest.raises(ParameterError, match=text):
        CameraSettings(**options)


def test_auxiliary_ports_by_their_names():
    assert [aux_port_of(port) for port in ("aux1", "aux2", "aux3", "aux4", "/dev/ttyS0", "")] == [1, 2, 3] + [None] * 3
