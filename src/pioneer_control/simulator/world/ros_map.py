"""Makes worlds of the maps of ROS's map_server (see `maps.ros_map`).

The borders of the occupied cells become few long walls (see `grids.borders`); unknown cells hold no walls. These maps
have no start. The robot starts at the origin of the map frame if there is room, else at the most spacious free place.
"""

import numpy as np
import yaml

from ...maps.ros_map import RosMapReader
from .grids import borders, roomiest
from .poses import placed, relative
from .world import START_CLEARANCE, World, begin_at


def world_of_map(reader: RosMapReader, root: yaml.Node) -> World:
    """Return the world of a map. `root` is the root node of its YAML file.

    Raises:
        WorldError: the file or its image is not legal, or no cell is free.
    """
    read = reader.read(root)
    side, origin = read.resolution, read.origin
    wanted_x, wanted_y, _ = relative(origin, (0.0, 0.0, 0.0))
    start = roomiest(read.occupancy < read.free_below, (wanted_x / side, wanted_y / side), START_CLEARANCE / side)
    if start is None:
        reader.fail(root, "no cell of the map is free: a robot has to stand somewhere")
    walls = np.array(borders(read.occupancy > read.occupied_above)).reshape(-1, 2) * side
    (x, y), *ends = placed([(start[0] * side, start[1] * side), *walls.tolist()], origin)
    beginning = x, y, 0.0
    return World(
        name=reader.path.stem,
        walls=[first + second for first, second in zip(ends[::2], ends[1::2])],
        starts=[beginning],
        skipped=[*read.skipped, "no start in a map of this kind: %s" % begin_at(beginning)],
    )
