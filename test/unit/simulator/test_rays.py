"""Where rays of light end, compared with paper and pencil, and with the sonar's cone when it has no width."""

import math
import random

import numpy as np
import pytest

from pioneer_control.simulator.simulation import Simulation
from pioneer_control.simulator.world import Can, World, load_world
from pioneer_control.simulator.world.echoes import echo
from pioneer_control.simulator.world.materials import Material
from pioneer_control.simulator.world.poses import unit
from pioneer_control.simulator.world.rays import LightRays, RayCaster
from pioneer_control.simulator.world.world import Walk
from pioneer_control.robots import find_model


def cast(world, angles, x=0.0, y=0.0, maximum=80.0, carrier=None):
    """Return the ends of rays from one place."""
    to_x, to_y = np.array([unit(angle) for angle in angles]).T
    return RayCaster(world, maximum).cast(
        LightRays(np.full(len(angles), x), np.full(len(angles), y), to_x, to_y), carrier)


def one(world, angle=0.0, **options):
    """Return the distance of one ray, the cosine of its slant, and the material that it meets."""
    distance, normal_x, normal_y, material = (each[0] for each in cast(world, [angle], **options))
    return distance, abs(normal_x * math.cos(angle) + normal_y * math.sin(angle)), material


@pytest.mark.parametrize("angle", [0.0, 0.3, -1.2, 1.5, -1.5])
def test_a_wall(angle):
    distance, cosine, material = one(World("wall", walls=[(2.0, -100.0, 2.0, 100.0)]), angle)
    assert distance == pytest.approx(2.0 / math.cos(angle)) and cosine == pytest.approx(math.cos(angle))
    assert material == Material.PLAIN


def test_no_wall():
    assert one(World("nothing")) == (math.inf, 0.0, Material.PLAIN)
    assert one(World("behind", walls=[(-2.0, -1.0, -2.0, 1.0)])) == (math.inf, 0.0, Material.PLAIN)
    assert one(World("beside", walls=[(2.0, 0.1, 2.0, 1.0)])) == (math.inf, 0.0, Material.PLAIN)
    assert one(World("along", walls=[(2.0, 0.0, 4.0, 0.0)]))[0] == math.inf


def test_farther_than_the_longest_ray():
    world = World("wall", walls=[(5.0, -1.0, 5.0, 1.0)])
    assert one(world, maximum=5.01)[0] == 5.0
    assert one(world, maximum=4.99) == (math.inf, 0.0, Material.PLAIN)


def test_a_post():
    world = World("post", posts=[(3.0, 0.4, 0.5)])
    distance, cosine, _ = one(world)
    assert distance == pytest.approx(3.0 - 0.3) and cosine == pytest.approx(0.6)
    assert one(World("post", posts=[(3.0, 0.6, 0.5)]))[0] == math.inf
    assert one(World("post", posts=[(-3.0, 0.0, 0.5)]))[0] == math.inf
    assert one(World("inside", posts=[(0.1, 0.0, 0.5)]))[0] == 0.0


def test_no_ray_slips_through_a_corner():
    world = World("corner", walls=[(2.0, -1.0, 2.0, 2.0), (2.0, 2.0, -1.0, 2.0)])
    assert one(world, math.pi / 4)[0] == pytest.approx(2.0 * math.sqrt(2.0))


def test_no_ray_slips_through_one_of_many_corners():
    chance = random.Random(3)
    for _ in range(200):
        x, y = chance.uniform(1.0, 9.0), chance.uniform(-3.0, 3.0)
        ends = [(x + chance.uniform(-1.0, 1.0), y + side * chance.uniform(0.5, 1.0)) for side in (1, -1)]
        for walls in ([(x, y, *end) for end in ends], [(*end, x, y) for end in ends]):
            found = one(World("corner", walls=walls), math.atan2(y, x))[0]
            assert found == pytest.approx(math.hypot(x, y), abs=1e-6)


def test_the_nearest_of_two():
    world = World("two", walls=[(4.0, -1.0, 4.0, 1.0), (2.0, -1.0, 2.0, 1.0)], posts=[(3.0, 0.0, 0.5)])
    assert one(world)[0] == 2.0


def test_cans_are_too_low():
    assert one(World("can", cans=[Can(1.0, 0.0)]))[0] == math.inf


@pytest.mark.parametrize("name", ["office", "classroom", "maze"])
def test_a_cone_of_no_width_is_a_ray(name):
    world, chance = load_world(name), random.Random(name)
    low_x, low_y, high_x, high_y = world.bounds
    solids = world.solids
    posts = [(0.0, x, y, radius, 0.0, -1.0) for x, y, radius in solids.posts.tolist()]
    candidates = [(0.0, *frame) for frame in solids.frames.T.tolist()] + posts
    hits = 0
    for _ in range(20):
        x, y = chance.uniform(low_x, high_x), chance.uniform(low_y, high_y)
        angles = sorted(chance.uniform(-math.pi, math.pi) for _ in range(30))
        for angle, found in zip(angles, cast(world, angles, x, y).distance.tolist()):
            wanted = echo(candidates, x, y, unit(angle), unit(angle), 80.0)
            assert found == pytest.approx(wanted, abs=1e-9) or (found == math.inf and wanted == 80.0)
            hits += found < math.inf
    assert hits > 300


def test_rays_from_several_squares_of_floor():
    """A carried robot may jump: each ray begins where it begins."""
    world, xs = load_world("office"), np.array([1.9, 2.1, 2.2, 8.5, 1.9])
    ys, ones = np.full(5, 2.0), np.ones(5)
    together = RayCaster(world, 80.0).cast(LightRays(xs, ys, ones, 0.0 * ones)).distance.tolist()
    assert together == [one(world, x=x, y=2.0)[0] for x in xs.tolist()]


def test_robots_and_people_are_seen_and_the_carrier_is_not():
    simulation = Simulation(World("floor", starts=[(0, 0, 0), (3, 0, 0)], walls=[(9, -1, 9, 1)],
                                  walks=[Walk(path=((0.0, 5.0), (0.0, 6.0)))]))
    first, second = (simulation.add(find_model("p3dx-sh")) for _ in range(2))
    world, body = simulation.world, first.hardware.body
    distance, cosine, material = one(world, carrier=body)
    assert material == Material.ROBOT and 2.6 < distance < 3.0 and cosine == pytest.approx(1.0)
    to_person = pytest.approx(5.0 - simulation.people[0].reach)
    assert one(world, math.pi / 2, carrier=body)[::2] == (to_person, Material.PERSON)
    assert one(world, carrier=body, x=4.0)[::2] == (5.0, Material.PLAIN)
    assert one(world)[0] < 0.4, "another one would see the carrier"
    assert second.hardware.body is not body


def test_a_body_behind_a_wall_is_hidden():
    simulation = Simulation(World("floor", starts=[(0, 0, 0), (3, 0, 0)], walls=[(1, -1, 1, 1)]))
    first, _ = (simulation.add(find_model("p3dx-sh")) for _ in range(2))
    assert one(simulation.world, carrier=first.hardware.body)[::2] == (1.0, Material.PLAIN)
