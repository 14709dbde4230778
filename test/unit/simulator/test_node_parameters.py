"""Parameters of the simulator's node."""

import dataclasses

import pytest

from pioneer_control.errors import ParameterError
from pioneer_control.simulator.world import known_worlds, load_world
from pioneer_control.simulator.parameters import SimulatorParameters, check_parameters


def test_nothing_given_is_all_defaults():
    assert check_parameters({}) == SimulatorParameters()


def test_every_default_is_legal():
    written = {"tcp": "", "laser_port": "", "camera_port": "", "gripper": "auto", "start": ""}
    for entry in dataclasses.fields(SimulatorParameters):
        given = written.get(entry.name, entry.default)
        assert entry.metadata["kind"].accept(given) == entry.default


@pytest.mark.parametrize("given, tcp", [(0, 0), (8101, 8101), ("0.0.0.0:81", "0.0.0.0:81"), ("", None)])
def test_tcp(given, tcp):
    assert check_parameters({"tcp": given}).tcp == tcp


@pytest.mark.parametrize("given, start", [
    ([1, 2.5, -3], (1.0, 2.5, -3.0)), ("", None), (" ", None), ("random", "random"),
    ("[1, 2.5, -3]", (1.0, 2.5, -3.0)), ("1,2,3", (1.0, 2.0, 3.0)),
])
def test_start(given, start):
    assert check_parameters({"start": given}).start == start


@pytest.mark.parametrize("given", [[1, 2], "1 2 3", [1, 2, "north"], 7, True, [1, 2, float("nan")]])
def test_a_start_that_is_none(given):
    with pytest.raises(ParameterError, match="~start = .*three numbers"):
        check_parameters({"start": given})


@pytest.mark.parametrize("given, message", [
    ({"wrold": "x"}, "did you mean ~world"), ({"laser": "hokuyo"}, "one of none, lms200"),
    ({"qqqq": 1}, "unknown parameter ~qqqq: there are ~model, ~world"),
    ({"seed": 1.5}, "~seed = 1.5 .*a whole number"),
    ({"seed": True}, "~seed = True"),
    ({"world": 3}, "~world = 3 .*a text"),
    ({"gripper": "maybe"}, "auto, true or false"), ({"map_frame": "/map"}, "not beginning with '/'"),
    ({"odom_frame_id": ""}, "not empty"), ({"tcp": True}, "~tcp = True .*host:port"), ({"tcp": 1.5}, "~tcp = 1.5"),
])
def test_mistakes(given, message):
    with pytest.raises(ParameterError, match=message):
        check_parameters(given)


@pytest.mark.parametrize("name", known_worlds())
def test_a_world_with_another_start_is_the_same_world(name):
    """The start may also be outside of everything that is in the world."""
    own = load_world(name)
    moved = load_world(name).with_start((-30.0, 20.0, 1.0))
    assert moved.starts == [(-30.0, 20.0, 1.0), *own.starts]
    assert moved.bounds[0] == -30.0 and moved.bounds[2:] == (own.bounds[2], 20.0)
    assert (moved.walls == own.walls).all() and (moved.posts == own.posts).all() and len(moved.cans) == len(own.cans)
    moved.occupancy(0.5)
