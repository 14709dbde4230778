"""When a robot is in a dock."""

import math

import pytest
from robot_on_bench import Bench

from pioneer_control.simulator.hardware.battery import stands_in
from pioneer_control.simulator.world import known_worlds, load_world

DOCKS = [(1.0, 2.0, math.pi / 2), (5.0, 2.0, -math.pi)]
DISTANCE, ANGLE = 0.1, math.radians(15)


@pytest.mark.parametrize("pose, dock", [
    ((1.0, 2.0, math.pi / 2), 0),
    ((1.06, 2.079, math.pi / 2), 0),
    ((1.06, 2.081, math.pi / 2), None),
    ((1.0, 2.0, math.radians(104.9)), 0),
    ((1.0, 2.0, math.radians(75.1)), 0),
    ((1.0, 2.0, math.radians(105.1)), None),
    ((1.0, 2.0, math.radians(74.9)), None),
    ((1.0, 2.0, -math.pi / 2), None),
    ((1.0, 2.0, math.pi / 2 + 20 * math.pi), 0),        # after ten turns
    ((5.0, 2.0, math.radians(179.0)), 1),               # the other side of half a turn
    ((5.0, 2.0, math.radians(-170.0)), 1),
    ((5.0, 2.0, math.radians(160.0)), None),
    ((3.0, 2.0, 0.0), None),
])
def test_near_and_facing_the_right_way(pose, dock):
    found = [number for number, each in enumerate(DOCKS) if stands_in(each, pose, DISTANCE, ANGLE)]
    assert found == ([] if dock is None else [dock])


def test_without_docks():
    assert not Bench().open().send("CHARGE", 1).wait(0.5).sip.charge_state


@pytest.mark.parametrize("name", [name for name in known_worlds() if load_world(name).docks])
def test_a_robot_charges_in_each_dock_of_the_gallery_and_not_beside_it(name):
    world = load_world(name)
    for x, y, heading in world.docks:
        beside = x - 0.2 * math.cos(heading), y - 0.2 * math.sin(heading), heading
        in_dock, not_in_dock = (
            Bench(world=world, pose=pose).open().send("CHARGE", 1).wait(0.5).sip.charge_state
            for pose in ((x, y, heading), beside))
        assert in_dock and not not_in_dock
