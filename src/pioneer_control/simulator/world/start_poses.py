"""Finds start poses for many robots: first the starts of the world, then free floor around the first start."""

import math
from typing import List

import numpy as np

from ...errors import ParameterError
from ...robots import RobotModel
from .grids import flood
from .poses import Pose, hypot
from .world import World

RESOLUTION = 0.05
"""Side (m) of a cell of the grid that is searched for free places."""
MARGIN = 0.1
"""Width (m) of the free floor that is kept around every robot. With it a robot can turn on the spot."""


def standing_places(world: World, model: RobotModel, count: int) -> List[Pose]:
    """Return start poses (m, rad; map frame) for `count` robots.

    The starts of the world come first. If they are too few, free places follow, sorted by distance from the first
    start.

    Raises:
        ParameterError: the world has no room for `count` robots. The message says for how many it has room.
    """
    starts = world.starts[:count]
    if len(starts) == count:
        return starts
    radius = max(hypot(x, y) for x, y in model.outline(model.can_carry_gripper)) + MARGIN
    cells = math.ceil(2.0 * radius / RESOLUTION)     # distance between two robots, in cells
    x0, y0, heading = starts[0]
    low_x, low_y, high_x, high_y = world.bounds
    beyond = (math.isqrt(count) + 2) * cells         # cells to add on each side: enough for all robots on open floor
    columns, rows = [
        np.arange(math.floor((low - at) / RESOLUTION) - beyond, math.ceil((high - at) / RESOLUTION) + beyond + 1)
        for low, high, at in ((low_x, high_x, x0), (low_y, high_y, y0))
    ]
    grid_x, grid_y = x0 + columns * RESOLUTION, y0 + rows * RESOLUTION
    free = world.clearances(grid_x, grid_y, limit=radius + RESOLUTION) >= radius
    seeds = np.any([(np.abs(grid_x - x) <= radius) & (np.abs(grid_y - y) <= radius)[:, None] for x, y, _ in starts],
                   axis=0)
    reached = flood(seeds & free, free)[np.ix_(rows % cells == 0, columns % cells == 0)]
    places = [(float(x), float(y)) for row, y in zip(reached, grid_y[rows % cells == 0])
              for x in grid_x[columns % cells == 0][row]]
    taken = ([(other_x, other_y, 2.0 * radius) for other_x, other_y, _ in starts]
             + [(can.x, can.y, radius + can.radius) for can in world.cans])
    apart = [(x, y) for x, y in places
             if all(hypot(x - other_x, y - other_y) >= reach for other_x, other_y, reach in taken)]
    nearest_first = sorted(apart, key=lambda place: (hypot(place[0] - x0, place[1] - y0), place))
    poses = starts + [(x, y, heading) for x, y in nearest_first]
    if len(poses) < count:
        raise ParameterError("the world %r has room for %s robots of the model %s, not for %s"
                             % (world.name, len(poses), model.subtype, count))
    return poses[:count]
