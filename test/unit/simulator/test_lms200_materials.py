"""What a simulated laser sees of dark walls, glass, mirrors, reflectors, and other lasers."""

import math
from dataclasses import replace

import numpy as np
import pytest

from laser_on_bench import LaserBench
from pioneer_control import lms2xx
from pioneer_control.robots import find_model
from pioneer_control.simulator.lms200 import PERFECT, TYPICAL, Optics, moving, standing
from pioneer_control.simulator.lms200.ray_plans import RayPlan, complete_scan
from pioneer_control.simulator.simulation import Simulation
from pioneer_control.simulator.world import World
from pioneer_control.simulator.world.geometry import joined
from pioneer_control.simulator.world.materials import Material
from pioneer_control.simulator.world.world import Furniture

STILL = replace(TYPICAL, bias=0.0, noise=0.0)
ONE_DEGREE = complete_scan(lms2xx.Variant(180, 100))


def wall(x, material, aside=9.0):
    """Return a wall across x, and its material."""
    return (x, -aside, x, aside), material


def world_of(*walls, **options):
    return World("hall", walls=[each for each, _ in walls], materials=[material for _, material in walls], **options)


def looked(world, angle=0.0, numbers=STILL, pose=(0.0, 0.0, 0.0), count=1):
    """Return what one ray measures, in so many scans, as arrays (count, 1)."""
    optics = Optics(world, numbers)
    found = [optics.measure(RayPlan((angle,), (0.0,), 1), 0.0, standing(pose)) for _ in range(count)]
    return [np.array(each)[:, 0] for each in zip(*found)]


def distance(world, angle=0.0, **options):
    return looked(world, angle, **options)[0][0]


# -- materials

@pytest.mark.parametrize("far, seen", [(5.0, True), (6.5, False)])
def test_a_dark_wall_is_seen_only_when_it_is_near(far, seen):
    assert math.isfinite(distance(world_of(wall(far, Material.DARK)))) == seen
    assert math.isfinite(distance(world_of(wall(far, Material.PLAIN))))
    assert math.isfinite(distance(world_of(wall(far, Material.DARK)), numbers=PERFECT))


@pytest.mark.parametrize("angle_deg, seen", [(0, 2.0), (9, 2.0), (11, 3.0), (60, 3.0)])
def test_glass_is_seen_squarely_and_else_what_is_behind_it(angle_deg, seen):
    angle = math.radians(angle_deg)
    world = world_of(wall(2.0, Material.GLASS), wall(3.0, Material.PLAIN))
    assert distance(world, angle) == pytest.approx(seen / math.cos(angle), abs=1e-3)


def test_glass_that_returns_too_little_light_for_its_distance_is_not_seen():
    """5 % is enough up to 7.2 m."""
    for far, seen in ((7.0, 7.0), (7.5, 9.0)):
        assert distance(world_of(wall(far, Material.GLASS), wall(9.0, Material.PLAIN))) == pytest.approx(seen, abs=1e-4)


def test_behind_glass_there_may_be_nothing_or_more_glass():
    slanted = math.radians(30)
    assert distance(world_of(wall(2.0, Material.GLASS)), slanted) == math.inf
    panes = [wall(1.0 + 0.1 * number, Material.GLASS) for number in range(4)]
    assert distance(world_of(*panes, wall(3.0, Material.PLAIN)), slanted) == pytest.approx(
        3.0 / math.cos(slanted), abs=1e-3)


def test_a_robot_behind_glass_is_seen():
    simulation = Simulation(world_of(wall(1.0, Material.GLASS), starts=[(0, 0, 0), (3, 0, 0)]))
    first, _ = (simulation.add(find_model("p3dx-sh")) for _ in range(2))
    optics = Optics(simulation.world, replace(STILL, glass_angle_deg=0.0), carrier=first.hardware.body)
    assert optics.measure(ONE_DEGREE, 0.0, standing((0.0, 0.0, 0.0))).distances[89] == pytest.approx(2.7, abs=0.02)


def test_a_mirror_shows_what_is_before_it():
    """A mirror at 45 degrees 2 m ahead shows the wall that is 3 m to the left."""
    world = World("hall", walls=[(1.0, -1.0, 3.0, 1.0), (-9.0, 3.0, 9.0, 3.0)], materials=[Material.MIRROR, 0])
    assert distance(world, numbers=PERFECT) == pytest.approx(2.0 + 3.0, abs=1e-5)
    assert distance(world, pose=(0.0, 0.0, math.pi), numbers=PERFECT) == math.inf


def test_in_a_mirror_ahead_a_robot_sees_itself():
    simulation = Simulation(world_of(wall(2.0, Material.MIRROR), starts=[(0, 0, 0)]))
    robot = simulation.add(find_model("p3dx-sh"))
    optics = Optics(simulation.world, STILL, carrier=robot.hardware.body)
    found = optics.measure(ONE_DEGREE, 0.0, standing((0.0, 0.0, 0.0))).distances[90]
    assert found == pytest.approx(4.0 - 0.2, abs=0.1), "there and back to its own front"


def test_light_between_two_mirrors_is_lost():
    world = World("hall", walls=[(2.0, -9.0, 2.0, 9.0), (-2.0, -9.0, -2.0, 9.0)], materials=[Material.MIRROR] * 2)
    assert distance(world) == distance(world, numbers=PERFECT) == math.inf
    panes = world_of(*(wall(1.0 + 0.1 * number, Material.GLASS) for number in range(8)), wall(3.0, Material.PLAIN))
    assert distance(panes, math.radians(30)) == math.inf, "more panes than a ray goes through"


def test_posts_may_be_mirrors_too():
    world = World("hall", posts=[(2.0, 0.25, 0.25 * math.sqrt(2.0))], walls=[(-9.0, -3.0, 9.0, -3.0)],
                  materials=[0, Material.MIRROR])
    # The ray meets the post where its normal is turned by 45 degrees, and goes on to the right.
    assert distance(world, numbers=PERFECT) == pytest.approx(2.0 - 0.25 + 3.0, abs=1e-5)


def test_a_reflector_is_bright_and_its_values_are_marked():
    world = world_of(wall(60.0, Material.REFLECTOR))
    distances, reflectors, dazzled = looked(world)
    assert distances == pytest.approx([60.0], abs=1e-3) and reflectors.all() and not dazzled.any()
    assert not looked(world_of(wall(4.0, Material.PLAIN)))[1].any()
    hidden = looked(world_of(wall(4.0, Material.PLAIN), wall(5.0, Material.REFLECTOR)))
    assert not hidden[1].any()


@pytest.mark.parametrize("mode, bits", [(0, 0), (1, 0xE000), (3, 0xC000), (5, 0x8000), (15, 0)])
def test_a_telegram_has_the_highest_level_of_its_mode(mode, bits):
    bench = LaserBench(world=world_of(wall(4.0, Material.REFLECTOR)))
    bench.variant(180, 100).configure(measuring_mode=mode)
    assert bench.scan().values[90] == 4000 | bits


# -- other lasers

def facing(far, on=True):
    """Return what a laser measures of a robot with a laser so far ahead, in many scans."""
    simulation = Simulation(World("hall", starts=[(0, 0, 0), (far, 0, 0)]))
    first, second = (simulation.add(find_model("p3dx-sh")) for _ in range(2))
    if on:
        second.hardware.body.material = Material.LASER
    optics = Optics(simulation.world, replace(STILL, dazzle_share=0.3), carrier=first.hardware.body)
    return np.array([optics.measure(RayPlan((0.0,), (0.0,), 1), 0.0, standing((0.0, 0.0, 0.0))).dazzled[0]
                     for _ in range(1000)])


def test_another_laser_dazzles_some_values():
    assert facing(5.0).mean() == pytest.approx(0.3, abs=0.05)
    assert not facing(7.0).any() and not facing(5.0, on=False).any()


def test_a_dazzled_value_is_its_code():
    simulation = Simulation(World("hall", starts=[(4, 0, 0)]))
    simulation.add(find_model("p3dx-sh")).hardware.body.material = Material.LASER
    bench = LaserBench(world=simulation.world, optics=replace(PERFECT, dazzle_share=1.0))
    bench.variant(180, 100)
    values = bench.scan().values
    assert values[90] == 8190 and values[0] == 8191
    assert math.isnan(lms2xx.ranges_m(bench.scan(), lms2xx.MEASURING_MODES[0])[90])


# -- skew

def test_without_skew_all_rays_are_of_one_moment():
    world = World("wall", walls=[(4.0, -50.0, 4.0, 50.0)])
    turning = moving((0.0, 0.0, 0.0), 0.5, math.radians(100.0))
    still, skewed = (Optics(world, replace(PERFECT, skew=skew)).measure(ONE_DEGREE, 0.0, turning).distances
                     for skew in (False, True))
    at_the_end = Optics(world, PERFECT).measure(ONE_DEGREE, 0.0, standing(turning(ONE_DEGREE.after[-1]))).distances
    assert still.tolist() == at_the_end.tolist() != skewed.tolist()


# -- the world

def test_materials_go_where_walls_go():
    world = world_of(wall(2.0, Material.GLASS), posts=[]).changed(
        unmapped=[Furniture(posts=((1.0, 5.0, 0.2),), material=Material.DARK)])
    assert world.solids.materials.tolist() == [Material.GLASS, Material.DARK] and world.materials == [Material.GLASS]
    assert world.with_start((0.0, 0.0, 0.0)).materials == [Material.GLASS]
    assert world.changed(walls=[(5.0, 0.0, 6.0, 0.0)]).materials == [Material.PLAIN], "other walls"
    assert joined([world.solids, world.solids]).materials.tolist() == [2, 2, 1, 1]
    assert world.solids.within(2.0, 0.0, 1.0).materials.tolist() == [Material.GLASS]
    assert world.solids.within(1.0, 5.0, 0.5).materials.tolist() == [Material.DARK]
