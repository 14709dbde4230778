"""The places where many robots stand at the start."""

import math

import pytest

from pioneer_control.errors import ParameterError
from pioneer_control.robots import find_model
from pioneer_control.simulator.world import World, known_worlds, load_world, standing_places
from pioneer_control.simulator.simulation import Simulation


@pytest.mark.parametrize("name", known_worlds())
@pytest.mark.parametrize("subtype", ["p3dx-sh", "amigo-sh"])
def test_five_robots_stand_in_every_world_of_the_gallery_and_can_turn(name, subtype):
    simulation, model = Simulation(load_world(name)), find_model(subtype)
    for pose in standing_places(simulation.world, model, 5):
        simulation.add(model, pose)
    for pose in standing_places(simulation.world, model, 5)[len(simulation.world.starts):]:
        reach = max(math.hypot(x, y) for x, y in model.outline(model.can_carry_gripper))
        assert simulation.world.clearance(*pose[:2]) >= reach


def test_the_starts_of_the_world_come_first_as_they_are():
    world = load_world("office")
    for count in (1, 3, 5):
        assert standing_places(world, find_model("p3dx-sh"), count)[:3] == world.starts[:count][:3]


def test_five_hundred_on_an_open_floor_none_near_another():
    places = standing_places(World("hall", starts=[(1.0, 2.0, 0.5)]), find_model("p3dx-sh"), 500)
    assert len(places) == 500 and {heading for _, _, heading in places} == {0.5}
    assert min(math.hypot(x - a, y - b) for at, (x, y, _) in enumerate(places) for a, b, _ in places[:at]) > 0.8
    assert max(math.hypot(x - 1.0, y - 2.0) for x, y, _ in places) < 20.0


def test_nobody_stands_beyond_a_wall():
    walls = [(-2, -2, 2, -2), (2, -2, 2, 2), (2, 2, -2, 2), (-2, 2, -2, -2)]
    with pytest.raises(ParameterError, match="the world 'cell' has room for 9 robots of the model p3dx-sh, not for 10"):
        standing_places(World("cell", walls), find_model("p3dx-sh"), 10)
    assert all(abs(x) < 2 and abs(y) < 2 for x, y, _ in standing_places(World("cell", walls), find_model("p3dx-sh"), 9))
