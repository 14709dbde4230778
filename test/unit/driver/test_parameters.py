"""The driver's parameters: legal values pass, and the error for any other value names what is legal."""

import dataclasses
import math

import pytest

from pioneer_control.driver.parameters import WITHOUT_EFFECT, DriverParameters, check_parameters
from pioneer_control.errors import ParameterError
from pioneer_control.ptz.view import Place3

GAINS = ["%s_%s" % (motion, gain) for motion in ("rot", "trans") for gain in ("kp", "kv", "ki")]
VARIANCES = ["%s_covariance_%s" % (what, how) for what in ("pose", "twist") for how in ("moving", "still")]

LEGAL = [
    ("port", "socket://localhost:8101", "socket://localhost:8101"), ("baud", 115200, 115200),
    ("model", "p3at-sh", "p3at-sh"), ("models_file", "", ""),
    ("gripper", "auto", None), ("gripper", "true", True), ("gripper", False, False),
    ("pulse", 1, 1.0), ("pulse", -1, -1.0), ("pulse", 1.5, 1.5),
    ("use_sonar", False, False), ("laser_power", True, True), ("link_check", False, False),
    ("max_xspeed", 1, 1.0), ("max_yawspeed", 0.5, 0.5), ("cmd_vel_timeout", 0.1, 0.1), ("cmd_vel_timeout", 2, 2.0),
    ("teleop_timeout", 0.1, 0.1), ("teleop_timeout", 2, 2.0),
    ("accept_replay", True, True), ("odom_frame_id", "o", "o"), ("base_link_frame_id", "b", "b"),
    ("frame_prefix", "two/", "two/"), ("publish_tf", False, False),
    ("host_baud", 38400, 38400), ("host_baud", 0, 0), ("beam_polarity", 0, 0), ("enable_motors_on_start", True, True),
    ("max_xaccel", 0.3, 0.3), ("max_xaccel", 0, 0.0), ("max_xdecel", -0.3, 0.3), ("max_xdecel", 10, 10.0),
    ("max_yawaccel", 2, 2.0), ("max_yawdecel", -20.0, 20.0), ("max_yawdecel", 0.2, 0.2),
    ("bumpstall", 3, 3), ("bumpstall", -1, -1), ("ticks_mm", 128, 128), ("rev_count", 16570, 16570),
    ("drift_factor", -40, -40), ("drift_factor", -32768, -32768), ("drift_factor", 32767, 32767),
    ("sonar_cycle", 0.002, 0.002), ("sonar_cycle", 0, 0.0), ("sonar_polling", [0, 0, 31], (0, 0, 31)),
    ("sonar_no_echo", "max", "max"), ("publish_wire", True, True),
    ("ptz", "vcc50i", "vcc50i"), ("ptz_port", "/dev/ttyS1", "/dev/ttyS1"), ("ptz_cabling", "one_way", "one_way"),
    ("ptz_pan_speed", 0.5, 0.5), ("ptz_tilt_speed", 1, 1.0), ("ptz_place", " ", None), ("ptz_inverted", True, True),
    ("ptz_power_off_at_end", True, True), ("ptz_fov_wide", 48, 48.0), ("ptz_fov_tele", 1.97, 1.97),
    *[("ptz_place", place, Place3(0.1, 0.0, 0.4)) for place in ([0.1, 0, 0.4], "[0.1, 0, 0.4]", "0.1,0,0.4")],
    ("use_arm", True, True), ("arm_layout", "M", "M"), ("arm_signs", [1, -1, 1, 1, -1.0], (1, -1, 1, 1, -1)),
    ("arm_offsets", [0, -0.1, 0, 3.2, 0], (0.0, -0.1, 0.0, 3.2, 0.0)),
    ("arm_lower", [-1] * 5, (-1.0,) * 5), ("arm_upper", [1] * 5, (1.0,) * 5),
    ("arm_max_speeds", [0.12] * 5, (0.12,) * 5), ("arm_gripper_speed", 0.2, 0.2), ("arm_max_step", 6.3, 6.3),
    ("arm_autopark", 60, 60), ("arm_grippark", 65535, 65535),
] + [(gain, value, value) for gain in GAINS for value in (-1, 0, 65535)] + [
    (variances, [0, 0.1, 0, 0, 0, 1e6], (0.0, 0.1, 0.0, 0.0, 0.0, 1e6)) for variances in VARIANCES
]

ILLEGAL = [
    ("ptz", "sony", "legal: give one of none, vcc4, vcc50i"), ("ptz_cabling", "both", "one of auto, two_way, one_way"),
    ("ptz_pan_speed", 2.0, "a number from 0.016 to 1.571 (rad/s)"), ("ptz_place", [0.1, 0.4], "three numbers"),
    ("ptz_port", "", "a text, not empty"), ("ptz_inverted", 1, "true or false"),
    ("ptz_power_off_at_end", "yes", "true or false"), ("ptz_tilt_speed", 0.0, "a number from 0.016 to 1.221 (rad/s)"),
    ("ptz_fov_wide", 0, "a number from 1 to 120 (deg)"), ("ptz_fov_tele", 180, "a number from 0.1 to 120 (deg)"),
    ("ptz_place", "here", "three numbers"), ("ptz_place", [0.1, 0, float("nan")], "three numbers"),
    ("port", "", "not empty"), ("port", 8101, "a text"), ("baud", 9601, "9600, 19200"), ("baud", "9600", "9600"),
    ("baud", True, "9600"), ("model", 3, "a text"), ("models_file", None, "a text"),
    ("gripper", "yes", "auto, true or false"), ("gripper", 1, "auto"), ("gripper", [], "auto"),
    ("pulse", "1.0", "-1 to 1.5"), ("pulse", 2.0, "-1 to 1.5"),
    ("pulse", math.nan, "-1 to 1.5"), ("pulse", True, "number"),
    ("laser_power", "auto", "true or false"),
    ("use_sonar", 1, "true or false"), ("link_check", "no", "true or false"), ("use_sonar", "true", "true or false"),
    ("max_xspeed", 0, "0.01 to 3"), ("max_xspeed", -0.5, "0.01 to 3"), ("max_xspeed", math.inf, "0.01 to 3"),
    ("max_yawspeed", 0.0, "rad/s"), ("max_yawspeed", 0.015, "0.02 to 6.3"),
    ("cmd_vel_timeout", 0, "0.1 to 2"), ("cmd_vel_timeout", -1, "0.1 to 2"), ("cmd_vel_timeout", 60, "0.1 to 2"),
    ("teleop_timeout", 0.05, "0.1 to 2"), ("teleop_timeout", "slow", "0.1 to 2"),
    ("accept_replay", "no", "true or false"),
    ("odom_frame_id", "", "not empty"), ("odom_frame_id", "/odom", "not beginning with '/'"),
    ("base_link_frame_id", "/base_link", "not beginning"), ("frame_prefix", "/two", "not beginning"),
    ("publish_tf", 0, "true or false"), ("publish_wire", "yes", "true or false"),
    ("host_baud", 9601, "0, 9600, 19200"), ("beam_polarity", 2, "0, 1"), ("beam_polarity", True, "0, 1"),
    ("enable_motors_on_start", "yes", "true or false"),
    ("max_xaccel", -0.3, "0 or a number from 0.01 to 10"), ("max_xaccel", 0.001, "0.01 to 10 (m/s^2)"),
    ("max_xdecel", -0.05, "0.1 to 10, with any sign"),
    ("max_xdecel", -10.5, "0.1 to 10"), ("max_xdecel", math.nan, "0.1 to 10"), ("max_yawaccel", "fast", "0.1 to 20"),
    ("max_yawdecel", 20.5, "with any sign (rad/s^2)"),
    ("bumpstall", 4, "-1 to 3"), ("bumpstall", 1.0, "a whole number"),
    ("ticks_mm", -1, "0 to 65535"), ("rev_count", 65536, "0 to 65535"), ("drift_factor", 32768, "-32768 to 32767"),
    ("sonar_cycle", 0.001, "0 or a number from 0.002 to 0.12 (s)"), ("sonar_cycle", -0.1, "0.002 to 0.12"),
    ("sonar_polling", 3, "as a list"), ("sonar_polling", [32], "whole numbers from 0 to 31, as a list"),
    ("sonar_polling", [0.5], "whole numbers"), ("sonar_polling", [True], "whole numbers"),
    ("sonar_polling", "0", "list"),
    ("sonar_no_echo", "5", "inf, max"), ("sonar_no_echo", math.inf, "inf, max"),
    ("use_arm", 1, "true or false"), ("arm_layout", "B", "auto, A, M"),
    ("arm_signs", [1] * 4, "5 numbers, each 1 or -1"), ("arm_signs", [1, 1, 1, 1, 0], "each 1 or -1"),
    ("arm_signs", [1, 1, 1, 1, 0.5], "each 1 or -1"), ("arm_signs", "1", "each 1 or -1"),
    ("arm_signs", [1, 1, 1, 1, True], "each 1 or -1"), ("arm_offsets", [0.0] * 6, "5 numbers from -3.2 to 3.2"),
    ("arm_lower", [math.nan] * 5, "5 numbers"), ("arm_upper", [9.0] * 5, "5 numbers"),
    ("arm_max_speeds", [0.0] * 5, "0.12 to 2"), ("arm_gripper_speed", 1.0, "0.004 to 0.2"),
    ("arm_max_step", 0.0, "0.05 to 6.3"), ("arm_autopark", 0, "60 to 65535"), ("arm_grippark", 70000, "60 to 65535"),
] + [(gain, value, "-1 to 65535") for gain in GAINS for value in (-2, 65536, 0.5, True)] + [
    (variances, value, "6 numbers from 0 to 1e+09")
    for variances in VARIANCES for value in ([0] * 5, [0, 0, 0, 0, 0, -1], 0.1, [math.nan] * 6)
]


def test_nothing_given_is_all_defaults():
    """An empty parameter server is legal, and the time-out is on."""
    parameters, warnings = check_parameters({})
    assert parameters == DriverParameters() and not warnings
    assert parameters.cmd_vel_timeout == 0.6 and not parameters.accept_replay


def test_every_default_is_legal():
    """Every default is a value that the user may give, too."""
    for entry in dataclasses.fields(DriverParameters):
        given = {"gripper": "auto", "ptz_place": ""}.get(entry.name, entry.default)
        assert entry.metadata["kind"].accept(given) == entry.default


@pytest.mark.parametrize("name, given, expected", LEGAL)
def test_legal_value(name, given, expected):
    """A legal value arrives with its own type."""
    value = getattr(check_parameters({name: given})[0], name)
    assert value == expected and type(value) is type(expected)


@pytest.mark.parametrize("name, given, says", ILLEGAL)
def test_illegal_value(name, given, says):
    """The error for an illegal value has the name, the value, and what is legal."""
    with pytest.raises(ParameterError) as caught:
        check_parameters({name: given})
    message = str(caught.value)
    assert message.startswith("~%s = %r" % (name, given)) and says in message


def test_the_cases_cover_every_parameter():
    """A new parameter needs a legal and an illegal case here."""
    names = {entry.name for entry in dataclasses.fields(DriverParameters)}
    assert {name for name, _, _ in LEGAL} == names == {name for name, _, _ in ILLEGAL}


def test_all_problems_are_told_at_once():
    """Three mistakes give one message of one line."""
    with pytest.raises(ParameterError) as caught:
        check_parameters({"pulse": "x", "baud": 1, "use_sonr": True})
    message = str(caught.value)
    assert "~pulse" in message and "~baud" in message and "did you mean ~use_sonar?" in message
    assert "\n" not in message


@pytest.mark.parametrize("slip, meant", [
    ("prot", "port"), ("use_sonars", "use_sonar"), ("cmd_vel_timeot", "cmd_vel_timeout"), ("max_speed", "max_xspeed"),
    ("odom_frame", "odom_frame_id"), ("pulses", "pulse"), ("accept_replays", "accept_replay"),
    ("TicksMM", "ticks_mm"), ("DriftFactor", "drift_factor"), ("RevCount", "rev_count")])
def test_misspelt_name_is_refused(slip, meant):
    """A name that is similar to one of ours is an error. Otherwise the value would be ignored without a word."""
    with pytest.raises(ParameterError, match="~%s .*did you mean ~%s\\?" % (slip, meant)):
        check_parameters({slip: 1})


@pytest.mark.parametrize("name", sorted(WITHOUT_EFFECT) + ["lab_room"])
def test_foreign_name_is_a_warning(name):
    """Old launch files still start. A warning names what has no effect."""
    parameters, warnings = check_parameters({name: 1})
    assert parameters == DriverParameters()
    assert len(warnings) == 1 and "~" + name in warnings[0] and "no effect" in warnings[0]


def test_prefix_goes_before_every_frame():
    """One prefix sets all frames."""
    parameters, _ = check_parameters({"frame_prefix": "two/", "odom_frame_id": "o"})
    assert (parameters.odom_frame, parameters.base_link_frame) == ("two/o", "two/base_link")


def test_frozen():
    """Nobody changes a parameter behind the driver's back."""
    with pytest.raises(dataclasses.FrozenInstanceError):
        check_parameters({})[0].pulse = 0.0


@pytest.mark.parametrize("programs, person, good_for", [(0.6, 0.5, 0.5), (0.3, 0.5, 0.3), (0.6, 2.0, 0.6)])
def test_a_persons_velocity_is_never_good_for_longer_than_one_of_a_program(programs, person, good_for):
    inputs = check_parameters({"cmd_vel_timeout": programs, "teleop_timeout": person})[0].inputs
    assert {name: (each.timeout, each.keeps_helm) for name, each in inputs.items()} == {
        "cmd_vel": (programs, False), "cmd_wheels": (programs, False), "teleop/cmd_vel": (good_for, True)}
    assert inputs["teleop/cmd_vel"].priority > inputs["cmd_vel"].priority == inputs["cmd_wheels"].priority
