"""Options of the sonar: cone, specular loss, noise and range. Each has the right effect, and none when it is off."""

import dataclasses
import math

import pytest
from robot_on_bench import Bench

from pioneer_control.simulator.hardware import standard_numbers
from pioneer_control.simulator.world import World


def numbers(**options):
    return dataclasses.replace(standard_numbers(), sonar=dataclasses.replace(standard_numbers().sonar, **options))


def heard(world, seconds=1.0, seed=0, **options):
    """Return the ranges (mm) of transducer 0 of a p3dx-sh, which looks to the left."""
    noise = options.get("noise", 0.0)
    bench = Bench(world=world, numbers=numbers(**options), gripper=False, noise=noise, seed=seed).open()
    sips = bench.wait(seconds, alive=True).sips
    return [reading.range_units for sip in sips for reading in sip.sonar if reading.number == 0]


def wall_to_the_left(slant_deg, distance=2.0):
    """Return a wall whose nearest point to transducer 0 is `slant_deg` off its axis."""
    _, x, y, heading = Bench().model.sonar[0]
    angle = heading + math.radians(slant_deg)
    x, y = x + distance * math.cos(angle), y + distance * math.sin(angle)
    along_x, along_y = -9.0 * math.sin(angle), 9.0 * math.cos(angle)
    return World("slanted", walls=[(x - along_x, y - along_y, x + along_x, y + along_y)])


@pytest.mark.parametrize("slant_deg, options, expected", [
    (10, {}, 2.0),                                                              # its nearest point is in the cone
    (10, {"cone_deg": 10}, 2.0 / math.cos(math.radians(5))),                    # now at the edge of the cone
    (20, {}, 2.0 / math.cos(math.radians(7.5))),
    (20, {"cone_deg": 40}, 2.0),
    (20, {"specular_deg": 8}, 2.0 / math.cos(math.radians(7.5))),               # met at 7.5 degrees
    (20, {"specular_deg": 7}, 5.0),
    (20, {"specular_deg": 7, "cone_deg": 40}, 2.0),                             # a wider cone meets it squarely
    (10, {"specular_deg": 1}, 2.0),
    (50, {}, 2.0 / math.cos(math.radians(37.5))),
    (50, {"specular_deg": 30}, 5.0),
    (50, {"specular_deg": 40}, 2.0 / math.cos(math.radians(37.5))),
    (80, {"cone_deg": 90, "specular_deg": 90}, 2.0 / math.cos(math.radians(35))),
])
def test_cone_and_specular_loss(slant_deg, options, expected):
    assert [*set(heard(wall_to_the_left(slant_deg), **options))] == [pytest.approx(expected * 1000, abs=1)]


def test_what_stands_behind_a_wall_that_is_not_heard_is_not_heard():
    wall = wall_to_the_left(50).walls.tolist()
    _, x, y, _ = Bench().model.sonar[0]
    world = World("post behind", walls=wall, posts=[(x, y + 4.0, 0.5)])
    assert [*set(heard(world))] == [pytest.approx(2000 / math.cos(math.radians(37.5)), abs=1)]
    assert [*set(heard(World("post", posts=world.posts.tolist()), specular_deg=30))] == [pytest.approx(3500, abs=1)]
    assert [*set(heard(world, specular_deg=30))] == [5000]


@pytest.mark.parametrize("distance, options, expected", [
    (4.9, {}, 4900),
    (6.5, {}, 5000),
    (6.5, {"maximum": 8.0}, 6500),
    (9.0, {"maximum": 8.0}, 8000),
    (4.9, {"maximum": 3.0}, 3000),
])
def test_range(distance, options, expected):
    assert [*set(heard(wall_to_the_left(0, distance), **options))] == [pytest.approx(expected, abs=1)]


def test_noise():
    quiet, noisy = (heard(wall_to_the_left(0), 30.0, noise=noise) for noise in (0.0, 0.05))
    assert set(quiet) == {2000} and 1949 <= min(noisy) < 1960 and 2040 < max(noisy) <= 2051
    assert sum(noisy) / len(noisy) == pytest.approx(2000, abs=12)
    assert noisy == heard(wall_to_the_left(0), 30.0, noise=0.05) != heard(wall_to_the_left(0), 30.0, noise=0.05, seed=1)


def test_nothing_changes_when_off():
    assert standard_numbers() == numbers(specular_deg=90, cone_deg=25, maximum=5.0, noise=0.003)
