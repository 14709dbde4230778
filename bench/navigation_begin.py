"""How long it takes until a robot can localise and plan on a large map, and how much memory that needs.

The map is square: drawn offices beside each other, as many as it takes. Each of the runs is a process of its own.
"""

import argparse
import resource
import statistics
import time
from multiprocessing import get_context
from typing import NamedTuple

import numpy as np
from navigation_cases import MODELS
from navigation_wanders import MAP_RESOLUTION, map_of

from pioneer_control.maps import GridMap
from pioneer_control.navigation.localisation import Localisation
from pioneer_control.navigation.planning import DrivableFloor
from pioneer_control.navigation.tuned import PlanningNumbers
from pioneer_control.robots import find_model
from pioneer_control.simulator.world.generated import random_world


class Begin(NamedTuple):
    """What one run took: processor time (s), and memory (MB) of the whole process at its peak."""

    localise: float  #: until it can localise
    localise_memory: float
    plan: float  #: then, until it has the first plan, too
    plan_memory: float


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of this part."""
    parser.add_argument("--side", type=float, default=50.0, help="of the map, m (default: %(default)s)")
    parser.add_argument("--seed", type=int, default=1000, help="of the offices (default: %(default)s)")
    parser.add_argument("--runs", type=int, default=5)


def main(options: argparse.Namespace) -> int:
    """Run what the command line says, and print it."""
    runs = []
    for _ in range(options.runs):
        with get_context("spawn").Pool(1) as pool:
            runs.append(pool.apply(begun, (options.side, options.seed)))
    for name in Begin._fields:
        values = [getattr(run, name) for run in runs]
        print("%-16s median %.2f %s, %.2f at most of %d" % (
            name, statistics.median(values), "MB" if "memory" in name else "s", max(values), len(values)))
    return 0


def begun(side: float, seed: int) -> Begin:
    """Begin on a map with this side (m)."""
    tile = map_of(random_world(seed, "offices")).cells
    cells = round(side / MAP_RESOLUTION)
    rows, columns = (-(-cells // size) for size in tile.shape)
    grid_map = GridMap(np.ascontiguousarray(np.tile(tile, (rows, columns))[:cells, :cells]), MAP_RESOLUTION, (0.0, 0.0))
    model = find_model(MODELS[0])
    begin = time.process_time()
    Localisation(grid_map, model.sonar)
    localised, localise_memory = time.process_time(), peak()
    floor = DrivableFloor(grid_map, model.width / 2.0, PlanningNumbers())
    floor.to(floor.places([0])[0])
    return Begin(localised - begin, localise_memory, time.process_time() - localised, peak())


def peak() -> float:
    """Return the most memory (MB) that this process had until now."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
