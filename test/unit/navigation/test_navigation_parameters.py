"""The parameters of the navigation node: each wrong one is named, with what is legal."""

import pytest

from pioneer_control.errors import ParameterError
from pioneer_control.floor_poses import Pose
from pioneer_control.navigation.node.parameters import check_parameters


def test_without_any_all_have_their_defaults():
    parameters, numbers = check_parameters({"map": "lab.yaml"})
    assert (parameters.map, parameters.start, parameters.initial_pose) == ("lab.yaml", "unknown", None)
    assert numbers.localisation.particles > 0


def test_frames_have_the_prefix_but_not_the_map():
    parameters, _ = check_parameters({"map": "office", "frame_prefix": "robot2/"})
    assert (parameters.odom_frame, parameters.base_frame) == ("robot2/odom", "robot2/base_link")
    assert parameters.global_frame_id == "map"


def test_tuned_numbers_lie_below_their_part():
    _, numbers = check_parameters({"map": "office", "localisation": {"particles": 700}})
    assert numbers.localisation.particles == 700


def test_a_pose_to_begin_at():
    assert check_parameters({"map": "office", "initial_pose": [1, 2.0, 0.5]})[0].initial_pose == Pose(1.0, 2.0, 0.5)
    assert check_parameters({"map": "office", "initial_pose": " "})[0].initial_pose is None


@pytest.mark.parametrize("given, named", [
    ({"max_linear": 9.0}, "max_linear"), ({"start": "here"}, "home"), ({"initial_pose": [1, 2]}, "three numbers"),
    ({"initial_pose": [1, 2, float("nan")]}, "three numbers"), ({"mpa": "lab.yaml"}, "unknown parameter ~mpa"),
    ({"localisation": 3}, "must have numbers below it"),
    ({"localisation": {"particles": -1}}, "^~localisation/particles = -1 is not legal"),
    ({"localisation": {"particels": 9}}, "^~localisation/particels .* did you mean ~localisation/particles"),
    ({"global_frame_id": "odom"}, "are 'odom', 'odom' and 'base_link': they must differ"),
    ({"global_frame_id": "a/base_link", "frame_prefix": "a/"}, "must differ"), ({"base_frame_id": "odom"}, "differ"),
    ({"localisation": {"partikles": 9}}, "partikles"),
    ({"localisation": {"laser_weight": 0.1}}, "laser_weight"),      # it is ~laser/weight
    ({"laser": {"rays": 2}}, "^~laser/rays = 2 is not legal"), ({"use_laser": 2}, "use_laser"),
    ({"map": "lab.yaml", "save_to": "new.yaml"}, "save_to"), ({"save_to": "new.pgm"}, "must end in .yaml"),
    ({"save_to": "lab/.yaml"}, "must end in .yaml"), ({"save_to": "lab.goals.yaml"}, "but not in .goals.yaml"),
    ({"seed": -1}, "~seed = -1 is not legal: give a whole number from 0 up"),
])
def test_what_is_not_legal_is_named(given, named):
    with pytest.raises(ParameterError, match=named):
        check_parameters(given)
