"""Where many robots can stand in a world: apart from each other, from cans and from walls, and always at the same places."""

import math

import pytest

from pioneer_control.errors import ParameterError
from pioneer_control.robots import find_model
from pioneer_control.simulator.loading import known_worlds, load_world
from pioneer_control.simulator.places import standing_places
from pioneer_control.simulator.simulation import Simulation

MODEL = find_model("p3dx-sh")
REACH = max(math.hypot(x, y) for x, y in MODEL.outline(True))


@pytest.mark.parametrize("name", known_worlds())
def test_eight_robots_stand_in_every_world_of_the_gallery(name):
    world = load_world(name)
    places = standing_places(world, MODEL, 8)
    assert places == standing_places(world, MODEL, 8) and places[: len(world.starts)] == world.starts
    for number, (x, y, _) in enumerate(places):
        assert world.clearance(x, y) >= REACH or number < len(world.starts)
        assert all(math.hypot(x - other[0], y - other[1]) >= 2 * REACH for other in places[:number])
        assert all(math.hypot(x - can.x, y - can.y) >= REACH + can.radius for can in world.cans) or number < len(world.starts)
    simulation = Simulation(world)
    assert len([simulation.add(MODEL, pose) for pose in places]) == 8


def test_no_room_is_told():
    with pytest.raises(ParameterError, match=r"the world 'table' has room for \d+ robots of the model p3dx-sh, not for 100"):
        standing_places(load_world("table"), MODEL, 100)
