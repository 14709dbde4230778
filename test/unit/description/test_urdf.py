"""The URDF of every model: a parser takes it, and outline, wheels, sonar and parts are where the model has them."""

import math
import re
import subprocess
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest

from pioneer_control.arm.joints import JOINT_NAMES as ARM_JOINTS
from pioneer_control.description import Parts, describe
from pioneer_control.description.__main__ import main
from pioneer_control.description.picture import draw, solids
from pioneer_control.errors import UsageError
from pioneer_control.robots import SONAR_HEIGHT, find_model, load_table

MODELS = load_table().models
BODY = re.compile("base_link|(left|right)_(rear_)?wheel")
P3DX = MODELS["p3dx-sh"]


def all_parts(model):
    return Parts(model.can_carry_gripper, model.laser is not None, True, True)


def corners(shapes, links):
    """Return the corners (m, base_link) of all shapes of the links whose names match."""
    return np.vstack([shape.corners for shape in shapes if re.fullmatch(links, shape.link)])


def joints(urdf):
    return {joint.get("name"): joint for joint in ElementTree.fromstring(urdf).findall("joint")}


def judged(urdf, tmp_path):
    """Return what check_urdf says of a URDF, and whether it takes it."""
    path = tmp_path / "robot.urdf"
    path.write_text(urdf)
    done = subprocess.run(["check_urdf", str(path)], stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    return done.stdout.decode(), done.returncode == 0


@pytest.mark.parametrize("model", MODELS.values(), ids=list(MODELS))
class TestEveryModel:
    def test_a_parser_takes_it_with_everything_on_it(self, model, tmp_path):
        said, taken = judged(describe(model, all_parts(model)), tmp_path)
        assert taken and "root Link: base_link" in said and "camera" in said and "arm_finger" in said, said

    def test_its_outline_is_the_models(self, model):
        shapes = solids(describe(model))
        body = corners(shapes, BODY)
        assert body.min(axis=0) == pytest.approx((-model.length_rear, -model.width / 2, 0.0), abs=1e-3)
        tall = model.shape.tower or max(model.shape.height, 2 * (model.wheel_radius or model.shape.wheel_radius))
        assert body.max(axis=0) == pytest.approx((model.length_front, model.width / 2, tall), abs=1e-3)

    def test_what_is_hit_is_the_outline(self, model):
        box = ElementTree.fromstring(describe(model)).find("link[@name='base_link']/collision")
        middle, size = (np.array(list(map(float, text.split()))) for text in (
            box.find("origin").get("xyz"), box.find("geometry/box").get("size")))
        assert (middle - size / 2)[:2] == pytest.approx(model.outline()[0], abs=1e-3)
        assert (middle + size / 2)[:2] == pytest.approx(model.outline()[2], abs=1e-3)

    def test_wheels_turn_where_joint_states_say_so(self, model):
        kinds = {name: joint.get("type") for name, joint in joints(describe(model)).items() if "wheel" in name}
        assert {"left_wheel_joint", "right_wheel_joint"} <= set(kinds)
        assert set(kinds.values()) == {"continuous" if model.wheel_radius else "fixed"}

    def test_each_transducer_has_the_drivers_frame(self, model):
        found = {name: joint for name, joint in joints(describe(model)).items() if name.startswith("sonar")}
        assert len(found) == len(model.sonar)
        for transducer in model.sonar:
            origin = found["sonar_%d_joint" % transducer.number].find("origin")
            place = list(map(float, origin.get("xyz").split() + origin.get("rpy").split()))
            wanted = [transducer.x, transducer.y, SONAR_HEIGHT, 0, 0, transducer.heading]
            assert place == pytest.approx(wanted, abs=1e-3)

    def test_with_open_paddles_it_has_that_outline(self, model):
        if model.can_carry_gripper:
            tips = corners(solids(describe(model, Parts(gripper=True))), "gripper")
            assert tips.max(axis=0)[:2] == pytest.approx(model.outline(True)[4], abs=1e-3)
        else:
            with pytest.raises(UsageError, match="%s cannot carry a gripper" % re.escape(model.subtype)):
                describe(model, Parts(gripper=True))

    def test_a_laser_is_where_the_model_has_it(self, model):
        if model.laser is not None:
            origin = joints(describe(model, Parts(laser=True)))["laser_joint"].find("origin")
            wanted = model.laser.x, model.laser.y, model.laser.z or 0.0
            assert list(map(float, origin.get("xyz").split())) == pytest.approx(wanted, abs=1e-3)
        else:
            with pytest.raises(UsageError, match="where the laser of the model %s sits" % re.escape(model.subtype)):
                describe(model, Parts(laser=True))


def test_a_parser_refuses_what_does_not_hang_together(tmp_path):
    assert not judged(describe(P3DX).replace('<parent link="base_link"', '<parent link="nothing"', 1), tmp_path)[1]


def test_rear_wheels_turn_with_the_front_wheels():
    found = joints(describe(MODELS["p3at-sh"]))
    assert {name: joint.find("mimic").get("joint") for name, joint in found.items() if joint.find("mimic") is not None
            } == {"left_rear_wheel_joint": "left_wheel_joint", "right_rear_wheel_joint": "right_wheel_joint"}


def test_wheels_are_as_large_as_the_models_and_stand_on_the_floor():
    wheel = corners(solids(describe(P3DX)), "left_wheel")
    assert (wheel[:, 2].min(), wheel[:, 2].max()) == pytest.approx((0.0, 2 * P3DX.wheel_radius), abs=1e-3)
    assert wheel[:, 1].min() > 0


def test_a_camera_looks_ahead_turns_left_and_tilts_down():
    found = joints(describe(P3DX, Parts(ptz=True)))
    pan, tilt = found["ptz_pan_joint"], found["ptz_tilt_joint"]
    assert [each.find("axis").get("xyz") for each in (pan, tilt)] == ["0.0000 0.0000 1.0000", "0.0000 1.0000 0.0000"]
    limits = [math.degrees(float(tilt.find("limit").get(end))) for end in ("lower", "upper")]
    assert limits == pytest.approx([-88, 30], abs=0.01)
    assert tilt.find("child").get("link") == "camera" and "ptz_base_link" == pan.find("parent").get("link")


def test_an_arm_at_rest_reaches_straight_ahead_as_far_as_its_lengths():
    """Arm sheet 16: 0.47971 m from the base axis, at shoulder height, which is 0.3185 m on a Pioneer 2."""
    urdf = describe(P3DX, Parts(arm=True))
    assert [name for name in joints(urdf) if name.startswith("arm") and name != "arm_mount_joint"] == list(ARM_JOINTS)
    tip = corners(solids(urdf), "arm_hand").max(axis=0)
    assert tip[0] == pytest.approx(0.105 + 0.47971, abs=1e-3)
    base = joints(urdf)["arm_mount_joint"].find("origin").get("xyz")
    assert list(map(float, base.split())) == pytest.approx([0.105, 0.0, 0.3185], abs=1e-4)


def test_the_prefix_is_before_links_and_not_before_joints():
    plain, prefixed = describe(P3DX, all_parts(P3DX)), describe(P3DX, all_parts(P3DX), "robot2/")
    assert re.sub(r'(link(?: name)?=")', r'\1robot2/', plain) == prefixed != plain
    assert list(joints(plain)) == list(joints(prefixed))


def test_the_command_prints_it_of_a_users_model_too(tmp_path, capsys):
    mine = tmp_path / "mine.yaml"
    mine.write_text("models: {my-robot: {like: p3at-sh, width_mm: 700, shape: amigobot}}")
    assert main(["my-robot", "--laser", "--models-file", str(mine)]) == 0
    assert capsys.readouterr().out == describe(find_model("my-robot", str(mine)), Parts(laser=True))


@pytest.mark.parametrize("words, message", [
    ([], "which robot"), (["p3dz"], "unknown robot model 'p3dz'"), (["p3at-sh", "--gripper"], "cannot carry a gripper"),
    (["--picture", "/nowhere/models.png"], "there is no directory /nowhere"),
])
def test_what_makes_no_sense_is_told(words, message, capsys):
    with pytest.raises(SystemExit):
        main(words)
    assert message in capsys.readouterr().err


def test_models_are_drawn_on_one_sheet(tmp_path):
    picture = tmp_path / "models.svg"
    draw([P3DX, MODELS["seekur"]], str(picture))
    assert re.findall("<!-- (.*?) -->", picture.read_text()) == ["p3dx-sh", "p3dx-sh, camera, arm", "seekur"]


def turned(axis, angle):
    """Return the rotation by an angle (rad) about an axis (Rodrigues)."""
    x, y, z = axis
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + math.sin(angle) * cross + (1.0 - math.cos(angle)) * cross @ cross


@pytest.mark.parametrize("degrees, place, approach", [      # arm sheet 16
    ((0, 0, 0, 0, 0), (0.4797, 0, 0), (1, 0, 0)),
    ((0, 90, 0, 0, 0), (0.0688, 0, 0.4110), (0, 0, 1)),
    ((0, 90, -90, 0, 0), (0.3197, 0, 0.1600), (1, 0, 0)),
    ((90, 0, 0, 0, 0), (0, 0.4797, 0), (0, 1, 0)),
    ((30, 45, -60, 0, -30), (0.3421, 0.1975, -0.0026), (0.6124, 0.3536, -0.7071)),
    ((30, 45, -60, 40, -30), (0.3269, 0.2307, 0.0102), (0.4779, 0.6470, -0.5941)),
    ((0, 80, -90, 0, 0), (0.3437, 0, 0.1140), (0.9848, 0, -0.1736)),
])
def test_an_arm_reaches_where_its_kinematics_say(degrees, place, approach):
    found = joints(describe(P3DX, Parts(arm=True)))
    rotation, at = np.eye(3), np.zeros(3)
    for name, angle in zip(ARM_JOINTS, degrees):
        origin, axis = (list(map(float, found[name].find(tag).get("xyz").split())) for tag in ("origin", "axis"))
        at = at + rotation @ np.array(origin)
        rotation = rotation @ turned(axis, math.radians(angle))
    assert at + rotation @ np.array([0.11321, 0.0, 0.0]) == pytest.approx(np.array(place), abs=1e-3)
    assert rotation[:, 0] == pytest.approx(np.array(approach), abs=1e-3)
