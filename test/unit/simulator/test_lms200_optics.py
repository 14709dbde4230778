"""What a simulated laser measures: exact in a world without errors, and with the errors that its numbers say."""

import math
from dataclasses import replace

import numpy as np
import pytest

from laser_on_bench import ROOM, to_wall
from pioneer_control.lms2xx import RAY_S, TURN_S, VARIANTS, Variant
from pioneer_control.robots import find_model
from pioneer_control.simulator.lms200 import PERFECT, TYPICAL, Optics, moving, standing
from pioneer_control.simulator.lms200.ray_plans import RayPlan, complete_scan, partial_scan, quarter_of_turn
from pioneer_control.simulator.simulation import Simulation
from pioneer_control.simulator.world import World

ORIGIN = standing((0.0, 0.0, 0.0))
ONE_DEGREE = complete_scan(Variant(180, 100))
WALL = World("wall", walls=[(4.0, -50.0, 4.0, 50.0)])
STILL = replace(TYPICAL, bias=0.0, noise=0.0)
"""The spot and the reflectivity of a real laser, and no other errors."""


def measured(optics, plan=ONE_DEGREE, pose_at=ORIGIN, begin=0.0):
    return optics.measure(plan, begin, pose_at).distances


def many(world, numbers=STILL, count=300, seed=0):
    """Return the distances straight ahead of many scans that have this ray alone."""
    optics = Optics(world, numbers, seed)
    return np.array([measured(optics, RayPlan((0.0,), (0.0,), 1))[0] for _ in range(count)])


# -- which rays, and when

def test_a_degree_of_the_mirror_takes_37_us():
    assert RAY_S * 1e6 == pytest.approx(37.0, abs=0.05)
    assert 180 * RAY_S * 1e3 == pytest.approx(6.67, abs=0.005)


@pytest.mark.parametrize("variant", VARIANTS)
def test_rays_of_a_complete_scan(variant):
    plan = complete_scan(variant)
    assert len(plan.angles) == len(plan.after) == variant.values and plan.turns == variant.turns
    assert math.degrees(plan.angles[0]) == pytest.approx(-variant.angle_deg / 2)
    assert math.degrees(plan.angles[-1]) == pytest.approx(variant.angle_deg / 2)
    assert np.degrees(np.diff(plan.angles)) == pytest.approx(variant.step_hundredths / 100)
    for turn in range(variant.turns):
        after = np.array(plan.after[turn::variant.turns]) - turn * TURN_S
        assert after == pytest.approx(np.arange(len(after)) * RAY_S)


def test_neighbours_of_a_fine_scan_were_measured_a_turn_apart():
    after = complete_scan(Variant(180, 50)).after
    assert (after[1] - after[0]) * 1e3 == pytest.approx(13.3, abs=0.05)
    assert len(set(after)) == 361


@pytest.mark.parametrize("quarter, count, first", [
    (0, 181, -90.0), (1, 180, -89.75), (2, 180, -89.5), (3, 180, -89.25)])
def test_rays_of_a_partial_scan(quarter, count, first):
    plan = partial_scan(quarter)
    assert len(plan.angles) == len(plan.after) == count and math.degrees(plan.angles[0]) == pytest.approx(first)
    assert max(plan.after) <= 180 * RAY_S


def test_the_partial_scans_of_a_scan_are_the_scan():
    variant = Variant(180, 50)
    plan = complete_scan(variant)
    for turn in range(2):
        part = partial_scan(quarter_of_turn(variant, turn))
        assert part.angles == pytest.approx(plan.angles[turn::2])
        assert np.array(part.after) + turn * TURN_S == pytest.approx(plan.after[turn::2])
    assert [quarter_of_turn(Variant(100, 25), turn) for turn in range(4)] == [0, 1, 2, 3]


# -- no errors

@pytest.mark.parametrize("variant", VARIANTS)
def test_a_room_by_paper_and_pencil(variant):
    plan = complete_scan(variant)
    assert measured(Optics(ROOM, PERFECT), plan) == pytest.approx([to_wall(angle) for angle in plan.angles], abs=1e-9)


def test_the_pose_counts():
    found = measured(Optics(ROOM, PERFECT), pose_at=standing((1.0, 2.0, math.pi / 2)))
    assert found[[0, 90, 180]] == pytest.approx([3.0, 3.0, 3.0])
    found = measured(Optics(ROOM, PERFECT), pose_at=standing((1.0, 2.0, math.pi)))
    assert found[[0, 90, 180]] == pytest.approx([3.0, 3.0, 5.0])


def test_upside_down_the_first_ray_is_the_leftmost():
    assert measured(Optics(ROOM, PERFECT, upside_down=True)) == pytest.approx(measured(Optics(ROOM, PERFECT))[::-1])
    assert measured(Optics(ROOM, PERFECT))[[0, 180]] == pytest.approx([3.0, 5.0])


def test_nothing_and_the_farthest():
    assert np.isinf(measured(Optics(World("nothing"), PERFECT))).all()
    for distance, seen in ((79.9, True), (80.1, False)):
        world = World("far", walls=[(distance, -9.0, distance, 9.0)])
        assert math.isfinite(measured(Optics(world, PERFECT))[90]) == seen


# -- motion

def test_while_it_turns_the_scan_is_skewed():
    """Sheet part 5: at 100 deg/s one sweep of 180 degrees turns 0.67 degree."""
    turning = moving((0.0, 0.0, 0.0), 0.0, math.radians(100.0))
    found = measured(Optics(ROOM, PERFECT), pose_at=turning)
    wanted = [to_wall(angle + math.radians(100.0) * after) for angle, after in zip(ONE_DEGREE.angles, ONE_DEGREE.after)]
    assert found == pytest.approx(wanted, abs=1e-9)
    assert math.degrees(turning(ONE_DEGREE.after[-1])[2]) == pytest.approx(0.667, abs=0.001)
    assert np.abs(found - measured(Optics(ROOM, PERFECT))).max() > 0.02


def test_while_it_turns_neighbours_of_a_fine_scan_are_apart():
    """Sheet part 5: 1.33 degrees and 116 mm at 5 m between the two turns of a 0.5-degree scan."""
    turning = moving((0.0, 0.0, 0.0), 0.0, math.radians(100.0))
    plan = complete_scan(Variant(180, 50))
    world = World("wall", walls=[(-9.0, 5.0, 9.0, 5.0)])
    found = measured(Optics(world, PERFECT), plan, turning)
    for index in range(100, 360, 37):
        angle = plan.angles[index] + math.radians(100.0) * plan.after[index]
        if math.sin(angle) > 0.6:
            assert found[index] == pytest.approx(5.0 / math.sin(angle))
    apart = math.radians(100.0) * (plan.after[1] - plan.after[0])
    assert math.degrees(apart) == pytest.approx(1.33, abs=0.01) and 5.0 * apart == pytest.approx(0.116, abs=0.001)


def test_while_it_drives_each_ray_begins_where_it_was_fired():
    """Sheet part 5: at 1 m/s one sweep moves 6.7 mm."""
    found = measured(Optics(WALL, PERFECT), pose_at=moving((0.0, 0.0, 0.0), 1.0, 0.0))
    for index in range(20, 161):
        assert found[index] * math.cos(ONE_DEGREE.angles[index]) == pytest.approx(4.0 - ONE_DEGREE.after[index])
    assert ONE_DEGREE.after[-1] * 1e3 == pytest.approx(6.7, abs=0.05)


def test_the_time_of_the_scan_counts():
    driving = moving((0.0, 0.0, 0.0), 1.0, 0.0)
    early, late = (measured(Optics(WALL, PERFECT), pose_at=driving, begin=begin)[90] for begin in (0.0, 1.0))
    assert early - late == pytest.approx(1.0)


# -- errors

def test_noise_has_the_size_that_its_number_says():
    found = many(WALL, replace(STILL, noise=0.005), 2000)
    assert found.mean() == pytest.approx(4.0, abs=0.0005)
    assert found.std() == pytest.approx(0.005, rel=0.05)
    assert abs(np.corrcoef(found[1:], found[:-1])[0, 1]) < 0.06, "each error is a new one"


def test_neighbours_have_their_own_noise():
    scan = measured(Optics(WALL, replace(STILL, noise=0.005))) * np.cos(ONE_DEGREE.angles)
    assert np.std(scan[60:121]) > 0.002
    assert len(set(scan[60:121].tolist())) == 61


def test_the_bias_is_one_for_each_run_and_within_15_mm():
    biases = [Optics(WALL, TYPICAL, seed).bias for seed in range(300)]
    assert max(map(abs, biases)) <= 0.015 and max(biases) > 0.014 and min(biases) < -0.014
    assert np.std(biases) == pytest.approx(0.015 / math.sqrt(3.0), rel=0.1)
    optics = Optics(WALL, replace(TYPICAL, noise=0.0), 7)
    assert [measured(optics)[90] - 4.0 for _ in range(3)] == pytest.approx([optics.bias] * 3, abs=1e-5)


def test_the_same_seed_gives_the_same_values():
    first, second, other = (Optics(ROOM, TYPICAL, seed) for seed in (3, 3, 4))
    for _ in range(3):
        scans = [measured(each).tolist() for each in (first, second, other)]
        assert scans[0] == scans[1] != scans[2]


def test_an_error_does_not_depend_on_what_stands_elsewhere():
    other_room = ROOM.changed(posts=[(0.0, 2.0, 0.3)])
    first, second = (measured(Optics(world, TYPICAL, 3)) for world in (ROOM, other_room))
    assert first[:100].tolist() == second[:100].tolist() and first[180] != second[180]


def test_no_error_makes_a_distance_negative():
    world = World("touching", walls=[(0.001, -1.0, 0.001, 1.0)])
    assert all(many(world, TYPICAL, 50, seed).min() >= 0.0 for seed in range(10))


# -- reflectivity

@pytest.mark.parametrize("reflectivity, farthest", [(0.1, 10.0), (0.2, 14.0), (0.5, 21.0), (0.8, 27.0), (1.0, 30.0)])
def test_how_far_a_surface_is_seen(reflectivity, farthest):
    """The sheet's table, which was read off a graph (part 5)."""
    for share, seen in ((0.92, True), (1.08, False)):
        world = World("wall", walls=[(farthest * share, -9.0, farthest * share, 9.0)])
        assert math.isfinite(measured(Optics(world, replace(STILL, wall_reflectivity=reflectivity)))[90]) == seen


@pytest.mark.parametrize("reflectivity, seen", [(0.019, True), (0.017, False)])
def test_how_dark_a_near_surface_may_be(reflectivity, seen):
    world = World("wall", walls=[(2.0, -9.0, 2.0, 9.0)])
    assert math.isfinite(measured(Optics(world, replace(STILL, wall_reflectivity=reflectivity)))[90]) == seen


def test_at_a_slant_less_light_comes_back():
    """A long wall 4 m ahead: the ray 80 degrees aside would go 23 m and has cos 80 = 0.17 of the light."""
    found = measured(Optics(WALL, STILL))
    assert math.isfinite(found[90 + 60]) and math.isinf(found[90 + 80])
    assert math.isfinite(measured(Optics(WALL, PERFECT))[90 + 80])


def test_robots_are_darker_than_walls():
    simulation = Simulation(World("floor", starts=[(0, 0, 0), (15, 0, 0)]))
    first, _ = (simulation.add(find_model("p3dx-sh")) for _ in range(2))
    pose = standing((0.0, 0.0, 0.0))
    for body, seen in ((0.15, False), (0.5, True)):
        optics = Optics(simulation.world, replace(STILL, body_reflectivity=body), carrier=first.hardware.body)
        assert math.isfinite(measured(optics, pose_at=pose)[90]) == seen


# -- mixed pixels

def edge(depth):
    """Return a world whose ray straight ahead hits the edge of a wall at 4 m with half its spot, and a wall behind."""
    return World("edge", walls=[(4.0, 0.001, 4.0, 9.0), (4.0 + depth, -9.0, 4.0 + depth, 9.0)])


def test_a_spot_on_two_near_surfaces_gives_anything_between():
    found = many(edge(0.5), count=2000)
    between = (found >= 4.0) & (found <= 4.5)
    assert between.mean() == pytest.approx(0.95, abs=0.015)
    assert found.min() >= 3.9 and found.max() <= 4.6 and found.min() < 3.91 and found.max() > 4.59
    quarters = np.histogram(found[between], 4, (4.0, 4.5))[0] / between.sum()
    assert quarters == pytest.approx([0.25] * 4, abs=0.03)


def test_a_spot_on_two_surfaces_less_than_10_cm_apart_gives_their_mean():
    found = many(edge(0.06))
    assert found == pytest.approx(4.0 + 2 / 3 * 0.06, abs=1e-5)


def test_a_spot_on_two_far_surfaces_gives_the_front():
    assert many(edge(1.5)) == pytest.approx(4.0, abs=1e-4)


def test_a_dark_front_gives_the_back():
    """One third of the spot on a surface that needs all of its light."""
    assert many(edge(1.5), replace(STILL, wall_reflectivity=0.045)) == pytest.approx(5.5, abs=1e-4)
    assert np.isinf(many(edge(1.5), replace(STILL, wall_reflectivity=0.02))).all()


def test_the_edge_of_a_thing_in_the_open():
    world = World("edge", walls=[(4.0, 0.001, 4.0, 9.0)])
    assert many(world) == pytest.approx(4.0, abs=1e-4)
    assert np.isinf(many(world, replace(STILL, wall_reflectivity=0.045))).all()


def test_the_size_of_the_spot():
    """Sheet part 5: 34 mm at 5 m, 56 mm at 10 m."""
    for distance, diameter in ((5.0, 0.034), (10.0, 0.056)):
        for beside, hit in ((0.47, True), (0.53, False)):
            world = World("edge", walls=[(distance, beside * diameter, distance, 9.0)])
            assert math.isfinite(many(world, replace(STILL, wall_reflectivity=1.0), 1)[0]) == hit


def test_more_rays_across_the_spot_lie_at_equal_distances():
    """Of five rays, that on the left and that between it and the middle hit the front: two fifths."""
    radius = (0.012 + 0.0044 * 4.0) / 2.0
    for beside, share in ((0.6, 1 / 5), (0.4, 2 / 5), (-0.1, 3 / 5)):
        world = World("edge", walls=[(4.0, beside * radius, 4.0, 9.0), (4.05, -9.0, 4.05, 9.0)])
        assert many(world, replace(STILL, rays=5), 1)[0] == pytest.approx(4.05 - 0.05 * share, abs=1e-5)


def test_a_perfect_laser_has_no_spot():
    found = many(edge(0.5), PERFECT)
    assert set(found.tolist()) == {4.5}
