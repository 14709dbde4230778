#!/usr/bin/env python3
"""What one look of the sonar, one contact test and one clearance cost in small and large worlds:
`python3 bench/world.py`.

A look is five transducers of one robot, as a SIP brings. Large worlds are as dense as an office, one wall of 1 to 2 m
for each square metre. Robots stand at random places; each first looks once, which finds its neighbourhood,
and that is listed apart.

Measured on two cores that others were using too (Python 3.11, numpy 1.24), in microseconds:

world             walls  posts   first look    look   contact   clearance
tutorial             25      2          123      12       5.5        12.0
office              160     15          186      14       6.8        13.0
10 walls             10      0           73       9       3.0        11.7
1000 walls         1000      0          211      13       4.6        16.0
100000 walls     100000      0         1846      15       5.1       940.7
"""

import math
import pathlib
import random
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "src"))

from pioneer_control.robots import find_model
from pioneer_control.simulator.world import World, load_world
from pioneer_control.simulator.world.poses import unit

HALF_WIDTH, MAXIMUM = math.radians(12.5), 5.0
PLACES, ROUNDS = 50, 20


def plain(count, rng):
    """A square floor with one wall a square metre."""
    side, walls = math.sqrt(count), []
    for _ in range(count):
        x, y = rng.uniform(0, side), rng.uniform(0, side)
        angle, length = rng.uniform(-math.pi, math.pi), rng.uniform(1.0, 2.0)
        walls.append((x, y, x + length * math.cos(angle), y + length * math.sin(angle)))
    return World("%s walls" % count, walls)


def microseconds(function, arguments):
    """The median over all arguments of the least time that a call took."""
    least = []
    for argument in arguments:
        times = []
        for _ in range(ROUNDS):
            begin = time.perf_counter()
            function(*argument)
            times.append(time.perf_counter() - begin)
        least.append(min(times))
    return sorted(least)[len(least) // 2] * 1e6


def look_from(ear, sensors):
    """What some transducers at places and headings hear."""
    return [ear.echo(x, y, to, unit(to - HALF_WIDTH), unit(to + HALF_WIDTH)) for x, y, to in sensors]


def measure(world, model, rng):
    """One row of the table."""
    low_x, low_y, high_x, high_y = world.bounds
    places = [(rng.uniform(low_x, high_x), rng.uniform(low_y, high_y), rng.uniform(-3.0, 3.0)) for _ in range(PLACES)]
    looks, outlines = [], []
    for x, y, heading in places:
        cosine, sine = math.cos(heading), math.sin(heading)
        sensors = [(x + s.x * cosine - s.y * sine, y + s.x * sine + s.y * cosine, heading + s.heading)
                   for s in model.sonar[1:6]]
        looks.append((world.ear(HALF_WIDTH, MAXIMUM), sensors))
        outlines.append(([(x + px * cosine - py * sine, y + px * sine + py * cosine)
                          for px, py in model.outline(gripper=True)],))
    begin = time.perf_counter()
    for look in looks:
        look_from(*look)
    first = (time.perf_counter() - begin) / PLACES * 1e6
    return (first, microseconds(look_from, looks), microseconds(world.touches, outlines),
            microseconds(world.clearance, [place[:2] for place in places]))


def main():
    rng, model = random.Random(1), find_model("p3dx-sh")
    worlds = [load_world("tutorial"), load_world("office")] + [plain(count, rng) for count in (10, 1000, 100000)]
    print("%-15s%8s%7s%13s%8s%10s%12s" % ("world", "walls", "posts", "first look", "look", "contact", "clearance"))
    for world in worlds:
        row = "{:13.0f}{:8.0f}{:10.1f}{:12.1f}".format(*measure(world, model, rng))
        print("%-15s%8d%7d%s" % (world.name, len(world.walls), len(world.posts), row))


if __name__ == "__main__":
    main()
